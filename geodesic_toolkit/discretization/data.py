"""The data that a back end assembles: mass, stiffness, and the gradient."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.checks import check_finite, check_range, coerce
from geodesic_toolkit.core.frozen import FrozenArrays, freeze, freeze_csr
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.fronts import Fronts
from geodesic_toolkit.discretization.gradient import Gradient
from geodesic_toolkit.discretization.subdivision import Subdivision
from geodesic_toolkit.errors import InvalidDiscretizationError
from geodesic_toolkit.geometry.across_edges import AcrossEdges
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.components import connected_vertices

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Discretization"]


@final
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Discretization(FrozenArrays):
    """The discrete Laplacian of a domain, with the gradient that it is made of, as data.

    It is validated once, on construction, at the cost of a few matrix-vector products.

    Parameters
    ----------
    mass : ndarray of shape (N,), float64
        Measure of every vertex: length, area or volume. Positive; 0 for a vertex without elements,
        whose distance is ``inf``.
    stiffness : csr_array or CompressedRows of shape (N, N), float64
        ``L = Gᵀ W G`` with L = -Δ positive semidefinite, symmetric, ``L 1 = 0``; ``M⁻¹ L ≈ -Δ``.
        The attribute is always a csr_array; `rows` has it in the form that kernels take.
    gradient : Gradient
        ∇ with its normalisation and its adjoint.
    spacing : float
        Mean edge length h, in the unit of the domain; the default time step is h².
    boundary : ndarray of shape (N,), bool
        True at the boundary of the domain, for boundary conditions of the heat; all false without a
        boundary.
    scales : ndarray of shape (N,), float64, optional
        The square root of the default time step, one value in each connected component; `spacing`
        in all components unless given.
    surface_frames : ndarray of shape (E, 3), float64, optional
        For elements that are stars in tangent planes: the same triangles measured in space, in the
        form of the gradient's own ``inverse_frames``. Refinement takes lengths and curvature from
        them.
    surface : ElementGradient, optional
        The triangles of the surface, if they are not the elements of the gradient: fronts cross
        these triangles, and distances are measured on them.
    unflipped : ElementGradient, optional
        The triangles of the domain, if the edges of some are flipped: sources inside are in these.
    normals : ndarray of shape (N, 3), float64, optional
        For elements that are stars in tangent planes: the unit normals of these planes.
    subdivision : Subdivision, optional
        Triangles with further vertices, if the elements are not triangles: refinement sweeps over
        these triangles.
    along_edges : AlongEdges, optional
        The shortest paths along the edges of a graph, which bound distances, and which refinement
        uses.
    across_edges : AcrossEdges, optional
        The same graph, for fronts that cross its corners.
    fronts : Fronts, optional
        Fronts for a kind of domain of a plugin. They replace heat.
    representatives : ndarray of shape (N,), int64, optional
        The vertex whose distance each vertex takes. Of several vertices at one position, one
        represents the others and has entries in the stiffness.
    local_scale : bool, optional
        True if the measure of the gradient is correct up to a factor at each vertex, which is
        estimated from potentials (``heat.local_scale``). For edge gradients with `along_edges`.
    triangulation : str, optional
        For triangles: "given", "intrinsic Delaunay" after edge flips, or "partly intrinsic
        Delaunay" after flips in some connected components. Refinement does not flip edges of an
        intrinsic Delaunay triangulation again.
    edges_agree : bool, optional
        False if two triangles may disagree about the length of their edge, as where a cost jumps.
    known_components : ndarray of shape (N,), int64, optional
        The connected component of every vertex, numbered from 0, if the operator knows it already;
        otherwise it is found from the stiffness.
    notes : mapping, optional
        Findings and decisions of the operator, by name, for users: a number of flipped edges, or
        the origin of normals.
    copy : bool
        False transfers the arrays: they become read-only instead of being copied, which saves
        memory if they were made for this.

    Raises
    ------
    InvalidDiscretizationError
        An invariant above does not hold; the message names the invariant and the index.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> mesh = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> discretization = gt.CotanLaplacian().assemble(mesh)
    >>> discretization.gradient
    ElementGradient(1 elements of 3 vertices in 2 dimensions)
    >>> discretization.mass.sum()
    np.float64(0.5)
    """

    mass: FloatArray
    stiffness: csr_array
    gradient: Gradient
    spacing: float
    boundary: BoolArray
    scales: FloatArray = field(default_factory=lambda: np.zeros(0))
    surface_frames: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    surface: ElementGradient | None = None
    unflipped: ElementGradient | None = None
    normals: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    subdivision: Subdivision | None = None
    along_edges: AlongEdges | None = None
    across_edges: AcrossEdges | None = None
    fronts: Fronts | None = None
    representatives: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    local_scale: bool = False
    triangulation: str = ""
    edges_agree: bool = True
    known_components: InitVar[IntArray | None] = None
    notes: Mapping[str, Any] = field(default_factory=dict)
    copy: InitVar[bool] = True

    def __post_init__(self, known_components: IntArray | None, copy: bool) -> None:
        floats = dict.fromkeys(("mass", "surface_frames", "normals"), np.float64)
        coerce(self, copy=copy, boundary=np.bool_, representatives=np.int64, **floats)
        count = len(self.mass)
        if self.mass.ndim != 1 or self.boundary.shape != (count,):
            raise InvalidDiscretizationError(
                f"mass {self.mass.shape} and boundary {self.boundary.shape} must be (N,)"
            )
        if self.gradient.n_vertices != count:
            raise InvalidDiscretizationError(
                f"the gradient has {self.gradient.n_vertices} vertices, the mass {count}"
            )
        check_finite(self.mass, "mass")
        if self.mass.min() < 0:
            bad = int(self.mass.argmin())
            raise InvalidDiscretizationError(f"vertex {bad} has the negative mass {self.mass[bad]}")
        if not (np.isfinite(self.spacing) and self.spacing > 0):
            raise InvalidDiscretizationError(
                f"spacing must be positive and finite, not {self.spacing}"
            )
        for name in ("surface", "unflipped"):
            other = getattr(self, name)
            if other is not None and not (other.of_planes and other.n_vertices == count):
                raise InvalidDiscretizationError(
                    f"{name} must be triangles with the same {count} vertices, not {other!r} "
                    f"with {other.n_vertices}"
                )
        if self.subdivision is not None and self.subdivision.n_vertices != count:
            raise InvalidDiscretizationError(
                f"subdivision is of {self.subdivision.n_vertices} vertices, not of {count}"
            )
        self._set_rows(count, copy)
        self._set_scales(count, copy)
        self._check_frames()
        self._check_graph()
        if known_components is not None:
            if known_components.shape != (count,):
                raise InvalidDiscretizationError(
                    f"known_components {known_components.shape} must be (N,)"
                )
            parts = np.array(known_components) if copy else known_components
            self.__dict__["components"] = freeze(parts)
        self._set(spacing=float(self.spacing), notes=dict(self.notes))

    def _set_rows(self, count: int, copy: bool) -> None:
        """Keep the stiffness in the form of kernels; SciPy's form is made at its first use."""
        given: csr_array | CompressedRows = self.stiffness
        if given.shape != (count, count):
            raise InvalidDiscretizationError(
                f"stiffness must have shape ({count}, {count}), not {given.shape}"
            )
        rows = CompressedRows.of(given, copy=copy)
        _check_stiffness(rows)
        del self.__dict__["stiffness"]
        for array in rows.arrays:
            freeze(array)
        self.__dict__["_rows"] = rows

    @property
    def rows(self) -> CompressedRows:
        """The stiffness in the form that kernels take."""
        rows: CompressedRows = self.__dict__["_rows"]
        return rows

    def __getattr__(self, name: str) -> Any:
        if name == "stiffness" and "_rows" in self.__dict__:
            self.__dict__["stiffness"] = freeze_csr(self.rows.scipy)
            return self.__dict__["stiffness"]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def _set_scales(self, count: int, copy: bool) -> None:
        if not len(self.scales):
            self._set(scales=np.broadcast_to(float(self.spacing), (count,)))
            return
        coerce(self, copy=copy, scales=np.float64)
        if self.scales.shape != (count,):
            raise InvalidDiscretizationError(f"scales {self.scales.shape} must be (N,)")
        sound = np.isfinite(self.scales) & (self.scales > 0)
        if not sound.all():
            bad = int(sound.argmin())
            raise InvalidDiscretizationError(
                f"the scale of vertex {bad} is {self.scales[bad]}; it must be positive and finite"
            )

    def _check_frames(self) -> None:
        if len(self.normals):
            if self.normals.shape != (self.n_vertices, 3):
                raise InvalidDiscretizationError(f"normals {self.normals.shape} must be (N, 3)")
            check_finite(self.normals, "the normal of vertex")
        gradient, frames = self.gradient, self.surface_frames
        if len(frames):
            if not (
                isinstance(gradient, ElementGradient)
                and gradient.stars
                and frames.shape == gradient.elements.shape
            ):
                raise InvalidDiscretizationError(
                    f"surface_frames {frames.shape} must be (E, 3), for the triangles of the stars "
                    f"of {gradient!r}"
                )
            check_finite(frames, "the surface frame of element")

    def _check_graph(self) -> None:
        others = self.representatives
        if len(others):
            if others.shape != self.mass.shape:
                raise InvalidDiscretizationError(f"representatives {others.shape} must be (N,)")
            check_range(others, len(others), "representative")
        if self.local_scale and not (
            isinstance(self.gradient, EdgeGradient) and self.along_edges is not None
        ):
            raise InvalidDiscretizationError(
                f"a local scale is for gradients along edges with lengths, not {self.gradient!r}"
            )

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return len(self.mass)

    @property
    def on_surface(self) -> Gradient:
        """The gradient on the triangles of the surface: `surface`, or `gradient` without one."""
        return self.gradient if self.surface is None else self.surface

    @cached_property
    def components(self) -> IntArray:
        """The connected component of every vertex, of shape (N,), numbered from 0."""
        return freeze(connected_vertices(self.rows))

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without derived attributes."""
        return {
            name: value
            for name, value in self.__dict__.items()
            if name not in {"components", "stiffness"}
        }

    def __repr__(self) -> str:
        return (
            f"Discretization({self.n_vertices} vertices, {self.gradient!r}, "
            f"spacing={self.spacing:.4g})"
        )


def _check_stiffness(rows: CompressedRows) -> None:
    """Check L = Lᵀ and L 1 = 0 in one pass; if that fails, raise an error that names the fault."""
    if _native.is_sound(*rows.arrays):
        return
    stiffness, count = rows.scipy, rows.shape[0]
    check_finite(stiffness.data, "stiffness entry")
    scale = abs(stiffness) @ np.ones(count)
    drift = np.abs(stiffness @ np.ones(count))
    if (drift > 1e-8 * scale).any():
        bad = int(np.argmax(drift - 1e-8 * scale))
        raise InvalidDiscretizationError(
            f"row {bad} of the stiffness sums to {drift[bad]:.3g}, not 0: L 1 = 0 does not hold"
        )
    probe = np.cos(np.arange(count))
    skew = np.abs(stiffness @ probe - stiffness.T @ probe)
    if (skew > 1e-8 * scale).any():
        bad = int(np.argmax(skew - 1e-8 * scale))
        raise InvalidDiscretizationError(
            f"the stiffness is not symmetric: row and column {bad} differ"
        )
    lowest = stiffness.diagonal()
    if (lowest < 0).any():
        bad = int(lowest.argmin())
        raise InvalidDiscretizationError(
            f"stiffness[{bad}, {bad}] is {lowest[bad]:.3g}: L = -Δ must be positive semidefinite"
        )
