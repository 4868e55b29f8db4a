"""The graph Laplacian."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar, Literal, final

import numpy as np

from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.domains import Domain, Graph, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.across_edges import AcrossEdges
from geodesic_toolkit.geometry.along_edges import AlongEdges, shortest_parallel_edges
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.geometry.lines import MAX_SHARE_OF_MESHES, share_of_meshes
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.laplacians.base import LaplaceOperator

__all__ = ["UniformLaplacian"]

MAX_RATIO_OF_LENGTHS = 1e6
"""Maximum ratio of two edge lengths in a component for which factors with weights ``1/ℓ²`` are
accurate. Measured on paths, trees and random graphs with edges of two lengths: the error does not
depend on the ratio up to 1e6, reaches 800 % at 1e7, and from 1e8 on factors are noise or singular.
"""

MAX_LENGTH = 1e100
"""Maximum length whose square, and its inverse, are well within double precision."""


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
        Dimension of the space that the graph samples: 1 for a path, 2 for a surface, 3 for a solid.
        "auto" takes 2 on a mesh. On a graph it takes the scale from the neighbourhood of each
        vertex, such that potentials around it rise by the length of the path along edges in some
        direction.
    mass : {"metric", "identity"}
        "metric" as above; "identity" is ``w = 1`` and ``m = 1``, for use as the *diffusion* of
        another discretization: it ignores lengths.

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
    known_failures: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"error_decreases_under_refinement": "the scale of a graph is known only to a few per cent"}
    )

    def __post_init__(self) -> None:
        whole = isinstance(self.dim, int) and not isinstance(self.dim, bool) and self.dim >= 1
        if not (whole or is_one_of(self.dim, ("auto",))):
            raise InvalidOptionError(f'dim must be a positive integer or "auto", not {self.dim!r}')
        if not is_one_of(self.mass, ("metric", "identity")):
            raise InvalidOptionError(f'mass must be "metric" or "identity", not {self.mass!r}')

    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a graph.

        Parameters
        ----------
        domain : Graph or TriangleMesh

        Returns
        -------
        Discretization
            The notes hold ``dim``, which is "local" if the scale is local. Vertices at one
            position, connected by edges of less than a millionth of the usual length, have one
            representative.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain; lengths beyond 1e100 or below its inverse; on a mesh, an edge
            more than a million times as long as another one of its component.
        """
        self.check_domain(domain)
        edges, lengths, boundary = _metric_graph(domain)
        count = domain.n_vertices
        if self.mass == "identity":
            part = connected_by_edges(edges, count)
            gradient = EdgeGradient(edges, np.ones(len(edges)), np.ones(count), copy=False)
            return _discretization(gradient, lengths, part, boundary)
        paths = AlongEdges(count, edges, lengths) if isinstance(domain, Graph) else None
        edges, lengths, representatives = _contracted(edges, lengths, count)
        _check_lengths(lengths)
        part = connected_by_edges(edges, count)
        fault = _instead_of_heat(edges, lengths, part[edges[:, 0]])
        if fault and paths is None:
            raise UnsupportedDomainError(f"{fault}; merge vertices that are almost at one position")
        dim = self._dimension(domain, edges)
        measure = np.bincount(edges.ravel(), minlength=count) / (2.0 * dim)
        local = self.dim == "auto" and isinstance(domain, Graph)
        return _discretization(
            EdgeGradient(edges, 1 / lengths**2, measure, copy=False),
            lengths,
            part,
            boundary,
            along_edges=None if paths is None else replace(paths, instead_of_heat=fault),
            across_edges=(
                None if paths is None else AcrossEdges(count, edges, lengths, representatives)
            ),
            representatives=representatives,
            local_scale=local,
            notes={"dim": "local" if local else dim},
        )

    def _dimension(self, domain: Domain, edges: IntArray) -> int:
        if self.dim != "auto":
            return self.dim
        if isinstance(domain, TriangleMesh):
            return 2
        # An initial value, which the local scale corrects.
        return 1 if share_of_meshes(domain.n_vertices, edges) <= MAX_SHARE_OF_MESHES else 2


def _discretization(
    gradient: EdgeGradient,
    lengths: FloatArray,
    part: IntArray,
    boundary: BoolArray,
    **others: Any,
) -> Discretization:
    """Return the discretization of a gradient along edges of these lengths."""
    spacing = float(lengths.mean()) if len(lengths) else 1.0
    return Discretization(
        mass=gradient.measure,
        stiffness=gradient.stiffness(),
        gradient=gradient,
        spacing=spacing,
        scales=_scales(gradient.edges, lengths, part, spacing),
        boundary=boundary,
        copy=False,
        **others,
    )


def _scales(edges: IntArray, lengths: FloatArray, part: IntArray, spacing: float) -> FloatArray:
    """Return the mean edge length of the component of each vertex, of shape (N,).

    So the distances of a component do not depend on other components. With a single component the
    mean is that of all edges.
    """
    number = np.bincount(part[edges[:, 0]])
    if np.count_nonzero(number) <= 1:
        return np.full(len(part), spacing)
    number = np.bincount(part[edges[:, 0]], minlength=part.max() + 1)
    total = np.bincount(part[edges[:, 0]], lengths, minlength=part.max() + 1)
    mean = np.divide(total, number, out=np.full(len(total), spacing), where=number > 0)
    return np.asarray(mean[part])


def _check_lengths(lengths: FloatArray) -> None:
    """Raise if lengths are so large or so small that their squares overflow or underflow."""
    for length in (lengths.min(initial=1.0), lengths.max(initial=1.0)):
        if not 1 / MAX_LENGTH <= length <= MAX_LENGTH:
            raise UnsupportedDomainError(
                f"an edge is {length:.4g} long, and its square is out of the range of double "
                "precision; use another unit of length"
            )


def _instead_of_heat(edges: IntArray, lengths: FloatArray, part: IntArray) -> str:
    """Describe lengths of such different size that plain heat would be noise; "" if there are none.

    `part` is the component of each edge.
    """
    if not len(edges) or lengths.max() <= MAX_RATIO_OF_LENGTHS * lengths.min():
        return ""
    order = np.lexsort((lengths, part))  # by component, the shortest first
    first = np.flatnonzero(np.concatenate([[True], part[order][1:] != part[order][:-1]]))
    last = np.append(first[1:], len(order)) - 1
    ratios = lengths[order[last]] / lengths[order[first]]
    worst = int(ratios.argmax())
    if ratios[worst] <= MAX_RATIO_OF_LENGTHS:
        return ""
    short, long = order[first[worst]], order[last[worst]]
    return (
        f"the edge from vertex {edges[short, 0]} to {edges[short, 1]} is {lengths[short]:.4g} "
        f"long, and the edge from {edges[long, 0]} to {edges[long, 1]} of the same component "
        f"{lengths[long]:.4g}: a ratio of more than {MAX_RATIO_OF_LENGTHS:.0e}, too large for "
        "double precision"
    )


def _contracted(
    edges: IntArray, lengths: FloatArray, n_vertices: int
) -> tuple[IntArray, FloatArray, IntArray]:
    """Merge vertices at one position; return the edges between groups, and the representatives.

    Vertices are at one position if edges connect them that are negligible relative to the other
    edges of the component.
    """
    positive = lengths > 0
    part = connected_by_edges(edges, n_vertices)[edges[:, 0]]
    typical = _medians(lengths[positive], part[positive], n_vertices)
    short = lengths < typical[part] / MAX_RATIO_OF_LENGTHS
    short |= ~positive
    if not short.any():
        return edges, lengths, np.zeros(0, dtype=np.int64)
    group = connected_by_edges(edges[short], n_vertices)
    _, first = np.unique(group, return_index=True)
    representatives = first[group]
    between = representatives[edges[~short]]
    return *shortest_parallel_edges(between, lengths[~short]), representatives


def _medians(lengths: FloatArray, part: IntArray, n_parts: int) -> FloatArray:
    """Return the median length in each component, 0 for components without lengths."""
    order = np.lexsort((lengths, part))
    number = np.bincount(part, minlength=n_parts)
    ends = np.cumsum(number)
    medians = np.zeros(n_parts)
    some = number > 0
    medians[some] = lengths[order[(ends - number // 2 - 1)[some]]]
    return medians


def _metric_graph(domain: Domain) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the distinct edges with their lengths, and the boundary vertices."""
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
    edges, lengths = shortest_parallel_edges(domain.edges, domain.lengths)
    return edges, lengths, boundary
