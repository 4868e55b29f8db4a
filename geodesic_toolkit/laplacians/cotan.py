"""The cotangent Laplacian of triangle meshes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, cast, final

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit._frozen import freeze
from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.components import connected_vertices
from geodesic_toolkit.geometry.intrinsic import delaunay_triangles, voronoi_areas
from geodesic_toolkit.geometry.parts import part_scales
from geodesic_toolkit.geometry.triangles import (
    lengths_from_inverse,
    mean_edge_length,
    mean_squared_edges,
    measured_by_lengths,
    measured_triangles,
)
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.positivity import obtuse_excess

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["CotanLaplacian"]

DELAUNAY_LIMIT = 0.13
"""The `obtuse_excess` above which ``intrinsic_delaunay="auto"`` flips edges.

Measured: sheared grids (0.13 and more) have errors of 7-60 % without flips; scans and models below
(bunny 0.09, armadillo 0.11, horse 0.13) lose at most 0.3 points; of those above, camelhead (0.15)
halves its error and a CAD model (0.15) goes from 15 % to 3 %.
"""

SMALLEST = 1e-75
"""Width of a mesh from which on the fourth power of a length is a number."""

ROUNDING = 1e-9
"""The `obtuse_excess` below which there is none."""

_TRIANGULATION = {
    (False, False): "given",
    (True, False): "partly intrinsic Delaunay",
    (True, True): "intrinsic Delaunay",
}

SMALL = 500
"""Faces of a component up to which ``intrinsic_delaunay="auto"`` flips edges wherever one can be
flipped: it costs nothing there. Measured on 24 parts of a truck, of 10 to 152 vertices: mean error
18.2 without, 9.1 % with flips; of the worst part 64 and 7 %.
"""


@final
@dataclass(frozen=True, kw_only=True)
class CotanLaplacian(LaplaceOperator):
    """Cotangent Laplacian of a triangle mesh: linear finite elements.

    ``L = Gᵀ W G`` with G the gradients of the hat functions and W the triangle areas, positive
    semidefinite (L = -Δ); its off-diagonal entries are ``-(cot α + cot β) / 2``.

    Parameters
    ----------
    mass : {"barycentric", "voronoi", "identity"}
        A third of the area of the faces around a vertex, its mixed Voronoi area, or 1.
    intrinsic_delaunay : bool or "auto"
        Assemble on the intrinsic Delaunay triangulation of the same surface: same vertices, but
        no weight of the wrong sign away from the boundary, so that heat is positive. Worth its
        cost (that of the rest of the assembly) on meshes with many obtuse angles.
        "auto" decides by how much of the stiffness has the wrong sign. Refined distances are
        measured on flipped triangles whatever is said here.

    Raises
    ------
    InvalidOptionError
        A value outside the ones above.

    References
    ----------
    U. Pinkall, K. Polthier, *Computing Discrete Minimal Surfaces and Their Conjugates*,
    Experimental Mathematics 2, 1993, https://doi.org/10.1080/10586458.1993.10504266

    A. I. Bobenko, B. Springborn, *A Discrete Laplace-Beltrami Operator for Simplicial Surfaces*,
    Discrete & Computational Geometry 38, 2007, https://doi.org/10.1007/s00454-007-9006-1

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> mesh = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> gt.CotanLaplacian().assemble(mesh).stiffness.toarray()
    array([[ 1. , -0.5, -0.5],
           [-0.5,  0.5,  0. ],
           [-0.5,  0. ,  0.5]])
    """

    mass: Literal["barycentric", "voronoi", "identity"] = "barycentric"
    intrinsic_delaunay: bool | Literal["auto"] = False

    domains: ClassVar[tuple[type[Domain], ...]] = (TriangleMesh,)
    references: ClassVar[tuple[str, ...]] = (
        "10.1080/10586458.1993.10504266",
        "10.1007/s00454-007-9006-1",
    )

    def __post_init__(self) -> None:
        if self.mass not in ("barycentric", "voronoi", "identity"):
            raise InvalidOptionError(
                f'mass must be "barycentric", "voronoi" or "identity", not {self.mass!r}'
            )
        if self.intrinsic_delaunay not in (True, False, "auto"):
            raise InvalidOptionError(
                f'intrinsic_delaunay must be True, False or "auto", not {self.intrinsic_delaunay!r}'
            )

    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a triangle mesh.

        Parameters
        ----------
        domain : TriangleMesh
            Faces with a repeated vertex are left out, and those with the three of an earlier one;
            zero-area ones are mollified.

        Returns
        -------
        Discretization
            Its notes hold ``dropped_faces``, ``mollified_by`` (a length), ``obtuse_excess`` and
            ``triangulation`` ("given", "intrinsic Delaunay", or "partly intrinsic Delaunay").

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, a mesh without a single face of three different places, or one
            so large or small that its measures are no numbers.
        """
        self.check_domain(domain)
        assert isinstance(domain, TriangleMesh)  # for the type checker; check_domain has raised
        count = domain.n_vertices
        _check_extent(domain)
        faces, inverse, areas, added = measured_triangles(domain.vertices, domain.faces)
        if not len(faces):
            raise UnsupportedDomainError("every face of the mesh is a single place; it has no area")
        dropped = domain.n_faces - len(faces)
        gradient = ElementGradient.of_triangles(faces, inverse, areas, count)
        sums, lengths = gradient.sums(), lengths_from_inverse(inverse)
        spacing = mean_edge_length(domain.vertices, sums.edges)
        parts = connected_vertices(sums.edges)
        scales = part_scales(
            domain.vertices,
            sums.edges,
            parts,
            spacing=spacing,
            first_vertices=faces[:, 0],
            squares=mean_squared_edges(lengths),
            areas=areas,
        )
        excess, boundary = obtuse_excess(sums.edges, sums.thirds), sums.boundary
        flip = self._to_be_flipped(faces, parts, excess)
        if flip.any():
            faces, lengths = _flipped(faces, lengths, flip, sums.sides)
            gradient = ElementGradient.of_triangles(faces, *measured_by_lengths(lengths), count)
            sums = gradient.sums()
        notes: dict[str, Any] = {
            "dropped_faces": dropped,
            "mollified_by": added,
            "obtuse_excess": float(excess.max()),
            "triangulation": _TRIANGULATION[bool(flip.any()), bool(flip.all())],
        }
        discretization = Discretization(
            mass=self._mass(gradient, sums.thirds),
            stiffness=cast("csr_array", sums.stiffness()),  # what it makes of it
            gradient=gradient,
            spacing=spacing,
            boundary=boundary,
            scales=scales[parts],
            notes=notes,
        )
        vars(discretization)["components"] = freeze(parts)  # flips join and part nothing
        return discretization

    def _to_be_flipped(self, faces: IntArray, labels: IntArray, excess: FloatArray) -> BoolArray:
        """Return the faces of the components that are to be made intrinsically Delaunay."""
        if self.intrinsic_delaunay != "auto":
            return np.full(len(faces), bool(self.intrinsic_delaunay))
        if not labels.any():  # one component, as most meshes are
            limit = ROUNDING if len(faces) <= SMALL else DELAUNAY_LIMIT
            return np.full(len(faces), excess.max() > limit)
        worst = np.zeros(labels.max() + 1)
        np.maximum.at(worst, labels, excess)
        component = labels[faces[:, 0]]
        small = np.bincount(component, minlength=len(worst)) <= SMALL
        wanted = worst > np.where(small, ROUNDING, DELAUNAY_LIMIT)
        return np.asarray(wanted[component])

    def _mass(self, gradient: ElementGradient, thirds: FloatArray) -> FloatArray:
        faces, count = gradient.elements, gradient.n_vertices
        if self.mass == "voronoi":
            return voronoi_areas(faces, lengths_from_inverse(gradient.inverse_frames), count)
        if self.mass == "identity":
            return (np.bincount(faces.ravel(), minlength=count) > 0).astype(np.float64)
        return thirds


def _check_extent(mesh: TriangleMesh) -> None:
    """Raise where squares of the lengths in a mesh are no numbers."""
    extent = _widest(mesh.vertices)
    if not extent <= 1 / SMALLEST:  # NaN too: vertices that no face uses may be anything
        extent = _widest(mesh.vertices[mesh.used])
    if extent and not SMALLEST <= extent <= 1 / SMALLEST:
        raise UnsupportedDomainError(
            f"the mesh is {extent:.3g} wide: squares of such lengths leave double precision; "
            "take another unit of length"
        )


def _widest(points: FloatArray) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        # NumPy takes twenty times as long over all columns at once.
        return max(float(np.ptp(column)) for column in points.T)


def _flipped(
    faces: IntArray, lengths: FloatArray, flip: BoolArray, sides: _native.HalfEdges
) -> tuple[IntArray, FloatArray]:
    """Return the triangles, the chosen ones of them made intrinsically Delaunay."""
    if flip.all():
        return delaunay_triangles(faces, lengths, sides)
    delaunay, delaunay_lengths = delaunay_triangles(faces[flip], lengths[flip])
    return (
        np.concatenate([faces[~flip], delaunay]),
        np.concatenate([lengths[~flip], delaunay_lengths]),
    )
