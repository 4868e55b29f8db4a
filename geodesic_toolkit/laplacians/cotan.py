"""The cotangent Laplacian of triangle meshes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, cast, final

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.positivity import obtuse_excess
from geodesic_toolkit.discretization.triangle_sums import TriangleSums
from geodesic_toolkit.domains import (
    Domain,
    IntrinsicMesh,
    MeasuredFaces,
    MetricMesh,
    TriangleMesh,
)
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.components import connected_by_faces, connected_vertices
from geodesic_toolkit.geometry.frames import ComplexArray, Fans, Frames, fans_of
from geodesic_toolkit.geometry.intrinsic import delaunay_triangles, voronoi_areas
from geodesic_toolkit.geometry.parts import lengths_of_pattern, mean_edges_of_parts, part_scales
from geodesic_toolkit.geometry.rims import (
    Trapezoids,
    mirrored_at_rims,
    rim_cotangents,
    rim_edges,
)
from geodesic_toolkit.geometry.triangles import (
    lengths_from_inverse,
    mean_edge_length,
    mean_squared_edges,
    measured_by_lengths,
    measured_triangles,
    mollified_lengths,
    proper_faces,
)
from geodesic_toolkit.laplacians.base import LaplaceOperator

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["CotanLaplacian"]

MAX_OBTUSE_EXCESS = 0.13
"""Value of `obtuse_excess` above which ``intrinsic_delaunay="auto"`` flips edges.

Measured: sheared grids (0.13 and more) have errors of 7-60 % without flips; scans and models below
(bunny 0.09, armadillo 0.11, horse 0.13) lose at most 0.3 points; of those above, camelhead (0.15)
has half the error with flips, and a CAD model (0.15) has 3 % instead of 15 %.
"""

MIN_WIDTH_OF_MESH = 1e-75
"""Minimum width of a mesh, so that fourth powers of lengths do not underflow."""

MIN_OBTUSE_EXCESS = 1e-9
"""Value of `obtuse_excess` below which it is rounding."""

MIN_COTANGENT_OF_SLIVERS = 1.0
"""Negative cotangent of an angle opposite a boundary edge above which ``intrinsic_delaunay="auto"``
flips edges: 135 degrees. Such angles leave `obtuse_excess` small, because their triangles are
small, but heat spreads too far along the rim.

Measured on 15 meshes with rims: any limit from 0.25 to 4 gives the same mean errors, except a
difference of 0.02 points on one scan (Stanford bunny, whose worst is 0.75). Without a limit
scattered points are 2 to 53 % off instead of 1 to 4, and a scan with slivers (Laurana) 1.5 instead
of 0.7.
"""

_TRIANGULATION = {
    (False, False): "given",
    (True, False): "partly intrinsic Delaunay",
    (True, True): "intrinsic Delaunay",
}

MAX_FACES_OF_SMALL_COMPONENTS = 500
"""Faces of a component up to which ``intrinsic_delaunay="auto"`` flips edges wherever possible,
because it is cheap there. Measured on 24 components of a truck, of 10 to 152 vertices: mean error
18.2 % without, 9.1 % with flips; of the worst component 64 and 7 %.
"""


_Parts: TypeAlias = list[tuple[IntArray, FloatArray]]


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
        Assemble on the intrinsic Delaunay triangulation of the same surface, glued to its mirror
        image at the boundary: the vertices are the same, but all weights have the right sign, so
        that heat is positive. It is worth its cost (that of the rest of the assembly) on meshes
        with many obtuse angles, or a few at the boundary. "auto" decides by the share of the
        stiffness that has the wrong sign, and by the slivers at the boundary. Refined distances are
        measured on flipped triangles with any value.

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

    domains: ClassVar[tuple[type[Domain], ...]] = (TriangleMesh, MetricMesh, IntrinsicMesh)
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
        domain : TriangleMesh, MetricMesh or IntrinsicMesh
            Faces with a repeated vertex, and repeated faces, are dropped; faces of zero area are
            mollified.

        Returns
        -------
        Discretization
            If the boundary was mirrored, the gradient has elements (i, j, j), on which functions
            change along the boundary alone, instead of obtuse triangles; ``surface`` keeps these
            triangles. The notes hold ``dropped_faces``, ``mollified_by`` (a length),
            ``obtuse_excess`` and ``triangulation`` ("given", "intrinsic Delaunay", or "partly
            intrinsic Delaunay").

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, a mesh without a face of three different positions, or one so
            large or small that its measures overflow or underflow.
        """
        measured = self._measured(domain)
        gradient, sums, flip, surface = measured.gradient, measured.sums, measured.flip, None
        if flip.any():
            agree = measured.edges_agree
            faces, lengths, twin = _flipped(
                gradient.elements, measured.lengths, flip, sums.sides, edges_agree=agree
            )
            gradient = ElementGradient.of_triangles(
                faces, *measured_by_lengths(lengths), gradient.n_vertices, copy=False
            )
            # An edge whose faces disagree is not a boundary: heat flows across it.
            kept, trapezoids = mirrored_at_rims(faces, lengths, twin) if agree else (None, None)
            if kept is not None and trapezoids is not None and not kept.all():
                surface, gradient = gradient, _mirrored(gradient, kept, trapezoids)
            sums = gradient.sums()
        triangulation = _TRIANGULATION[bool(flip.any()), bool(flip.all())]
        notes: dict[str, Any] = {
            "dropped_faces": measured.dropped,
            "mollified_by": measured.added,
            "obtuse_excess": float(measured.excess.max()),
            "triangulation": triangulation,
        }
        return Discretization(
            mass=self._mass(gradient, sums.lumped_mass),
            stiffness=cast("csr_array", sums.stiffness()),  # the class of the result
            gradient=gradient,
            spacing=measured.spacing,
            boundary=measured.sums.boundary,
            scales=measured.scales[measured.parts],
            surface=surface,
            unflipped=measured.gradient if flip.any() else None,
            triangulation=triangulation,
            edges_agree=measured.edges_agree,
            known_components=measured.parts,  # flips do not change components
            notes=notes,
            copy=False,
        )

    def frames(self, domain: Domain, metric: Discretization) -> Frames:
        """Return tangent frames by the angles around each vertex, and the turns into the triangles.

        Directions of edges are updated by flips, so that turns are those of the surface, whatever
        triangulation the metric has.
        """
        self.check_domain(domain)
        if not isinstance(domain, TriangleMesh):
            raise UnsupportedDomainError(
                f"tangent vectors are those of a surface in space, not of {a_kind_of(domain)}"
            )
        given, flipped = self._triangles_of(domain, metric)
        normals, axes, fans = fans_of(domain.vertices, [*given, *flipped])
        if flipped:
            fans[-1] = fans[-1].delaunay()
        turns, mirrored = (
            np.concatenate(parts) for parts in zip(*map(Fans.turns, fans), strict=True)
        )
        if metric.surface is None:
            return Frames(normals, axes, turns, mirrored)
        last = fans[-1]  # the others are not mirrored at rims, and come first
        kept, trapezoids = mirrored_at_rims(last.elements, last.lengths, last.twin)
        kept = np.append(np.ones(len(turns) - len(kept), dtype=np.bool_), kept)
        own = np.concatenate([turns[kept], _turns_of_trapezoids(last, trapezoids)])
        none = np.zeros(len(trapezoids.widths), dtype=np.bool_)
        return Frames(normals, axes, own, np.append(mirrored[kept], none), turns, mirrored)

    def _triangles_of(self, mesh: TriangleMesh, metric: Discretization) -> tuple[_Parts, _Parts]:
        """Return the triangles that a metric keeps, and those that it flips, as lists.

        Each list is empty, or has one entry: faces with their edge lengths.
        """
        gradient = metric.gradient
        if metric.triangulation == "given" and isinstance(gradient, ElementGradient):
            return [(gradient.elements, lengths_from_inverse(gradient.inverse_frames))], []
        measured = self._measured(mesh)
        faces, lengths, flip = measured.gradient.elements, measured.lengths, measured.flip
        given = [] if flip.all() else [(faces[~flip], lengths[~flip])]
        return given, [(faces[flip], lengths[flip])]

    def _measured(self, domain: Domain) -> "_Measured":
        """Return the measured triangles of a mesh, and a mask of those to be flipped."""
        self.check_domain(domain)
        assert isinstance(domain, TriangleMesh | MeasuredFaces)  # for the type checker
        if isinstance(domain, MeasuredFaces):
            faces, inverse, areas, added = _triangles_by_length(domain)
        else:
            faces, inverse, areas, added = _triangles(domain)
        if not len(faces):
            raise UnsupportedDomainError(
                "all corners of every face are at one position; the mesh has zero area"
            )
        gradient = ElementGradient.of_triangles(
            faces, inverse, areas, domain.n_vertices, copy=False
        )
        sums, lengths = gradient.sums(), lengths_from_inverse(inverse)
        parts = connected_vertices(sums.edges)
        spacing, means = _mean_edges(domain, sums, parts)
        scales = part_scales(
            parts,
            means,
            first_vertices=faces[:, 0],
            squares=mean_squared_edges(lengths),
            areas=areas,
        )
        excess = obtuse_excess(sums.edges, sums.lumped_mass)
        rims = rim_edges(faces, sums.boundary)
        slivers = rims[_are_too_obtuse(lengths, rims)]
        return _Measured(
            gradient=gradient,
            sums=sums,
            lengths=lengths,
            parts=parts,
            spacing=spacing,
            scales=scales,
            excess=excess,
            flip=self._to_be_flipped(faces, parts, excess, slivers),
            added=added,
            dropped=domain.n_faces - len(faces),
            edges_agree=not isinstance(domain, MeasuredFaces) or domain.edges_agree,
        )

    def _to_be_flipped(
        self, faces: IntArray, labels: IntArray, excess: FloatArray, slivers: IntArray
    ) -> BoolArray:
        """Return the faces of the components that are to be made intrinsically Delaunay.

        `slivers` are half-edges of rims; a component that has one is flipped.
        """
        if self.intrinsic_delaunay != "auto":
            return np.full(len(faces), bool(self.intrinsic_delaunay))
        if not labels.any():  # one component, as in most meshes
            limit = (
                MIN_OBTUSE_EXCESS
                if len(faces) <= MAX_FACES_OF_SMALL_COMPONENTS
                else MAX_OBTUSE_EXCESS
            )
            return np.full(len(faces), len(slivers) > 0 or excess.max() > limit)
        worst = np.zeros(labels.max() + 1)
        np.maximum.at(worst, labels, excess)
        worst[labels[faces[slivers // 3, 0]]] = np.inf
        component = labels[faces[:, 0]]
        small = np.bincount(component, minlength=len(worst)) <= MAX_FACES_OF_SMALL_COMPONENTS
        chosen = worst > np.where(small, MIN_OBTUSE_EXCESS, MAX_OBTUSE_EXCESS)
        return np.asarray(chosen[component])

    def _mass(self, gradient: ElementGradient, lumped_mass: FloatArray) -> FloatArray:
        faces, count = gradient.elements, gradient.n_vertices
        if self.mass == "voronoi":
            return voronoi_areas(faces, lengths_from_inverse(gradient.inverse_frames), count)
        if self.mass == "identity":
            return (np.bincount(faces.ravel(), minlength=count) > 0).astype(np.float64)
        return lumped_mass


@dataclass(frozen=True)
class _Measured:
    """The given triangles of a mesh, and a mask of those to be flipped."""

    gradient: ElementGradient
    sums: TriangleSums
    lengths: FloatArray
    parts: IntArray
    spacing: float
    scales: FloatArray
    excess: FloatArray
    flip: BoolArray
    added: float
    dropped: int
    edges_agree: bool


def _triangles(mesh: TriangleMesh) -> tuple[IntArray, FloatArray, FloatArray, float]:
    """Return the proper faces of a mesh, as :func:`measured_triangles` does."""
    _check_extent(mesh)
    return measured_triangles(mesh.vertices, mesh.faces)


def _triangles_by_length(
    surface: MeasuredFaces,
) -> tuple[IntArray, FloatArray, FloatArray, float]:
    """Return the same of faces with lengths."""
    proper = proper_faces(surface.faces)
    faces, lengths = surface.faces[proper], surface.lengths[proper]
    longest = float(lengths.max(initial=0.0))
    if longest == 0:
        return faces[:0], np.zeros((0, 3)), np.zeros(0), 0.0
    _check_width(longest)
    part = connected_by_faces(faces, surface.n_vertices)[faces[:, 0]]
    longer, added = mollified_lengths(lengths, part)
    return faces, *measured_by_lengths(longer), float(added.max())


def _mean_edges(domain: Domain, sums: TriangleSums, parts: IntArray) -> tuple[float, FloatArray]:
    """Return the mean edge length of a shape, and of each of its components."""
    if isinstance(domain, MeasuredFaces):
        graph = domain.as_graph()
        return float(graph.lengths.mean()), mean_edges_of_parts(
            graph.lengths, graph.edges[:, 0], parts
        )
    assert isinstance(domain, TriangleMesh)  # for the type checker; check_domain has raised
    spacing = mean_edge_length(domain.vertices, sums.edges)
    if not parts.any():
        return spacing, np.full(1, spacing)
    tails, lengths = lengths_of_pattern(domain.vertices, sums.edges)
    return spacing, mean_edges_of_parts(lengths, tails, parts, spacing)


def _check_extent(mesh: TriangleMesh) -> None:
    """Raise if squares of the lengths in a mesh overflow or underflow."""
    extent = _widest(mesh.vertices)
    if not extent <= 1 / MIN_WIDTH_OF_MESH:  # also for NaN: unused vertices may have any value
        extent = _widest(mesh.vertices[mesh.used])
    _check_width(extent)


def _check_width(extent: float) -> None:
    if extent and not MIN_WIDTH_OF_MESH <= extent <= 1 / MIN_WIDTH_OF_MESH:
        raise UnsupportedDomainError(
            f"the mesh is {extent:.3g} wide: squares of such lengths are out of the range of "
            "double precision; use another unit of length"
        )


def _widest(points: FloatArray) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        # NumPy takes twenty times as long for all columns at once.
        return max(float(np.ptp(column)) for column in points.T)


def _are_too_obtuse(lengths: FloatArray, rims: IntArray) -> BoolArray:
    """Return a mask of the half-edges of rims whose opposite angles are too obtuse."""
    return np.asarray(rim_cotangents(lengths, rims) < -MIN_COTANGENT_OF_SLIVERS)


def _flipped(
    faces: IntArray,
    lengths: FloatArray,
    flip: BoolArray,
    sides: _native.HalfEdges,
    *,
    edges_agree: bool,
) -> tuple[IntArray, FloatArray, IntArray]:
    """Make the chosen triangles intrinsically Delaunay; return all triangles and their twins.

    Triangles that are not chosen come first, and are their own twins.
    """
    if flip.all():
        return delaunay_triangles(faces, lengths, sides, edges_agree=edges_agree)
    rest = 3 * np.count_nonzero(~flip)
    delaunay, delaunay_lengths, twin = delaunay_triangles(
        faces[flip], lengths[flip], edges_agree=edges_agree
    )
    return (
        np.concatenate([faces[~flip], delaunay]),
        np.concatenate([lengths[~flip], delaunay_lengths]),
        np.concatenate([np.arange(rest), np.where(twin < 0, twin, twin + rest)]),
    )


def _mirrored(surface: ElementGradient, kept: BoolArray, beside: Trapezoids) -> ElementGradient:
    """Return the gradient on triangles and on trapezoids between them and a mirror.

    On trapezoids a function changes along the mirror alone, as on a right triangle (i, j, j) with
    one leg along the mirror and two corners of one value. Its area is that of the trapezoid if the
    other leg is as long as both parallel sides together.
    """
    legs = beside.tail_sides + beside.head_sides
    first = np.where(beside.tail_sides <= beside.head_sides, beside.tails, beside.heads)
    second = beside.tails + beside.heads - first  # it has the larger area
    inverse = np.column_stack([1 / beside.widths, -1 / legs, 1 / legs])
    return ElementGradient.of_triangles(
        np.concatenate([surface.elements[kept], np.column_stack([first, second, second])]),
        np.concatenate([surface.inverse_frames[kept], inverse]),
        np.concatenate([surface.measure[kept], beside.widths * legs / 2]),
        surface.n_vertices,
        copy=False,
    )


def _turns_of_trapezoids(fans: Fans, beside: Trapezoids) -> ComplexArray:
    """Return the turns (T, 3) into the elements that :func:`_mirrored` makes from trapezoids.

    The first axis of an element is along the mirror, from the vertex that is nearer to it.
    """
    into = beside.within  # from head to tail, along a removed triangle
    at_tail = into - into % 3 + (into + 1) % 3  # leaves the tail
    corner = into - into % 3 + (into + 2) % 3  # of that triangle, at the tail
    bisectors = _native.bisectors(fans.lengths, fans.angles, fans.scales).ravel()
    to_head = 2 * bisectors[corner] - fans.angles[at_tail]  # the other side of that corner
    slope = np.arctan2(beside.head_sides - beside.tail_sides, beside.widths)
    tail = to_head - fans.scales[at_tail] * slope
    head = fans.angles[into] - fans.scales[into] * slope - np.pi
    first, second = np.exp(-1j * tail), np.exp(-1j * head)
    ahead = beside.tail_sides <= beside.head_sides
    turns = np.where(ahead, [first, second, second], [-second, -first, -first])
    return np.ascontiguousarray(turns.T)
