"""The graph Laplacian."""

from dataclasses import dataclass
from typing import ClassVar, Literal, final

import numpy as np

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import Domain, Graph, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.geometry.dimension import graph_dimension
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.gradient import EdgeGradient
from geodesic_toolkit.laplacians.base import LaplaceOperator

__all__ = ["UniformLaplacian"]

FARTHEST = 1e6
"""Ratio of two edge lengths in a connected part up to which weights ``1/ℓ²`` leave the factors
digits. Measured on paths, trees and random graphs with edges of two lengths: the error does not
depend on the ratio up to 1e6, reaches 800 % at 1e7, and from 1e8 on factors are noise or singular.
"""

LARGEST = 1e100
"""Length whose square, and its inverse, are well within double precision."""


@final
@dataclass(frozen=True, kw_only=True)
class UniformLaplacian(LaplaceOperator):
    """Graph Laplacian of a graph, or of the edges of a mesh.

    ``L = D - W``, positive semidefinite (L = -Δ). A graph that samples a space of dimension dim
    gets the scale of that space: ``w = 1/ℓ²`` on an edge of length ℓ, and
    ``m_i = Σ_j w_ij ℓ_ij² / (2 dim)`` at a vertex, so that ``M⁻¹ L ≈ -Δ`` and ``|∇u|`` is a slope.

    Parameters
    ----------
    dim : int or "auto"
        Dimension of what the graph samples: 1 for a path, 2 for a surface, 3 for a solid. "auto"
        takes 2 on a mesh and the growth of balls on a graph.
    mass : {"metric", "identity"}
        "metric" as above; "identity" is ``w = 1`` and ``m = 1``, for use as the *diffusion* of
        another discretization: it knows nothing of lengths.

    Raises
    ------
    InvalidOptionError
        A value outside the ones above.

    References
    ----------
    D. Bakry, I. Gentil, M. Ledoux, *Analysis and Geometry of Markov Diffusion Operators*, 2014,
    https://doi.org/10.1007/978-3-319-00227-9 (the carré du champ)

    F. R. K. Chung, *Spectral Graph Theory*, 1997, https://doi.org/10.1090/cbms/092

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> path = gt.Graph(3, [[0, 1], [1, 2]], lengths=[0.5, 0.5])
    >>> gt.UniformLaplacian(dim=1).assemble(path).mass
    array([0.5, 1. , 0.5])
    """

    dim: int | Literal["auto"] = "auto"
    mass: Literal["metric", "identity"] = "metric"

    domains: ClassVar[tuple[type[Domain], ...]] = (Graph, TriangleMesh)
    references: ClassVar[tuple[str, ...]] = ("10.1007/978-3-319-00227-9", "10.1090/cbms/092")

    def __post_init__(self) -> None:
        whole = isinstance(self.dim, int) and not isinstance(self.dim, bool) and self.dim >= 1
        if not (whole or self.dim == "auto"):
            raise InvalidOptionError(f'dim must be a positive integer or "auto", not {self.dim!r}')
        if self.mass not in ("metric", "identity"):
            raise InvalidOptionError(f'mass must be "metric" or "identity", not {self.mass!r}')

    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a graph.

        Parameters
        ----------
        domain : Graph or TriangleMesh

        Returns
        -------
        Discretization
            Its notes hold ``dim``.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain; an edge more than a million times as long as another that it is
            connected to; lengths beyond 1e100 or below its inverse.
        """
        self.check_domain(domain)
        edges, lengths, boundary = _metric_graph(domain)
        count = domain.n_vertices
        part = connected_by_edges(edges, count)
        if self.mass == "identity":
            weights, measure, dim = np.ones(len(edges)), np.ones(count), None
        else:
            _check_lengths(edges, lengths, part[edges[:, 0]])
            dim = self._dimension(domain, edges)
            weights = 1 / lengths**2
            measure = np.bincount(edges.ravel(), minlength=count) / (2.0 * dim)
        gradient = EdgeGradient(edges, weights, measure)
        spacing = float(lengths.mean()) if len(lengths) else 1.0
        return Discretization(
            mass=gradient.measure,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=spacing,
            scales=_scales(edges, lengths, part, spacing),
            boundary=boundary,
            notes={} if dim is None else {"dim": dim},
        )

    def _dimension(self, domain: Domain, edges: IntArray) -> int:
        if self.dim != "auto":
            return self.dim
        return 2 if isinstance(domain, TriangleMesh) else graph_dimension(domain.n_vertices, edges)


def _scales(edges: IntArray, lengths: FloatArray, part: IntArray, spacing: float) -> FloatArray:
    """Return the mean edge length of the part of each vertex, of shape (N,).

    A part has the distances that it has alone. Where there is but one the mean is that of all.
    """
    number = np.bincount(part[edges[:, 0]])
    if np.count_nonzero(number) <= 1:
        return np.full(len(part), spacing)
    number = np.bincount(part[edges[:, 0]], minlength=part.max() + 1)
    total = np.bincount(part[edges[:, 0]], lengths, minlength=part.max() + 1)
    mean = np.divide(total, number, out=np.full(len(total), spacing), where=number > 0)
    return np.asarray(mean[part])


def _check_lengths(edges: IntArray, lengths: FloatArray, part: IntArray) -> None:
    """Raise where lengths are so large, so small or so far apart that distances would be noise.

    `part` is the connected part of each edge.
    """
    if not len(edges):
        return
    for length in (lengths.min(), lengths.max()):
        if not 1 / LARGEST <= length <= LARGEST:
            raise UnsupportedDomainError(
                f"an edge is {length:.4g} long, and its square leaves double precision; take "
                "another unit of length"
            )
    if lengths.max() <= FARTHEST * lengths.min():
        return
    order = np.lexsort((lengths, part))  # part by part, from the shortest to the longest
    first = np.flatnonzero(np.concatenate([[True], part[order][1:] != part[order][:-1]]))
    last = np.append(first[1:], len(order)) - 1
    ratios = lengths[order[last]] / lengths[order[first]]
    worst = int(ratios.argmax())
    if ratios[worst] > FARTHEST:
        short, long = order[first[worst]], order[last[worst]]
        raise UnsupportedDomainError(
            f"the edge from vertex {edges[short, 0]} to {edges[short, 1]} is {lengths[short]:.4g} "
            f"long, and that from {edges[long, 0]} to {edges[long, 1]}, connected to it, "
            f"{lengths[long]:.4g}: more than {FARTHEST:.0e} times as long, too far apart for "
            "double precision; merge vertices that are as good as at one place, or cut such long "
            "edges"
        )


def _metric_graph(domain: Domain) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return different edges with their lengths, and the boundary vertices."""
    boundary = np.zeros(domain.n_vertices, dtype=np.bool_)
    if isinstance(domain, TriangleMesh):
        faces = domain.faces[proper_faces(domain.faces)]
        edges, face_counts = edges_of_faces(faces, domain.n_vertices)
        boundary[edges[face_counts == 1]] = True
        steps = domain.vertices[edges[:, 0]] - domain.vertices[edges[:, 1]]
        lengths = np.sqrt(np.einsum("ed,ed->e", steps, steps))
        apart = lengths > 0
        return edges[apart], lengths[apart], boundary
    assert isinstance(domain, Graph)  # for the type checker; check_domain has raised
    edges, lengths = _shortest_parallel_edges(domain)
    return edges, lengths, boundary


def _shortest_parallel_edges(graph: Graph) -> tuple[IntArray, FloatArray]:
    """Return the edges without loops, smaller vertex first, each once with its least length."""
    ends = np.sort(graph.edges, axis=1)
    order = np.lexsort((graph.lengths, ends[:, 1], ends[:, 0]))
    ends, lengths = ends[order], graph.lengths[order]
    keep = ends[:, 0] != ends[:, 1]
    keep[1:] &= (ends[1:] != ends[:-1]).any(axis=1)
    return ends[keep], lengths[keep]
