"""The Laplacian of point clouds: local Delaunay stars, assembled like a triangle mesh."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, final

import numpy as np

from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.positivity import positive_part
from geodesic_toolkit.domains import Domain, PointCloud
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.geometry.components import connected_by_faces
from geodesic_toolkit.geometry.frames import Frames
from geodesic_toolkit.geometry.widths import check_width, widest
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.laplacians.pointcloud.blades import NOISY_NEIGHBOURS
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives, representatives, restored
from geodesic_toolkit.laplacians.pointcloud.curves import lie_on_lines
from geodesic_toolkit.laplacians.pointcloud.elements import (
    TIE_LENGTH,
    areas_of,
    frames_on_surface,
    with_segments,
)
from geodesic_toolkit.laplacians.pointcloud.lines import on_curves, share_of_longest_line
from geodesic_toolkit.laplacians.pointcloud.parts import warn_of_fragments, warn_of_lines
from geodesic_toolkit.laplacians.pointcloud.places import Places
from geodesic_toolkit.laplacians.pointcloud.planes import (
    POLE_NEIGHBOURS,
    is_noisy,
    normals_of,
    roughness_of_cloud,
    roughness_of_sheets,
    warn_of_noise,
)
from geodesic_toolkit.laplacians.pointcloud.soup import Soup, soup_of
from geodesic_toolkit.laplacians.tangents import frames_of_stars

__all__ = ["PointCloudLaplacian"]

DEFAULT_K = 20
"""Initial number of neighbours of a star: a ball of 2.5 spacings, which holds nearly every star."""

BYTES_PER_POINT, EXTRA_BYTES_OF_FIRST_POINTS, N_FIRST_POINTS = 2900.0, 1000.0, 100_000
"""Peak memory per point while stars are made, and the additional memory of the first points: twice
40 neighbours, 20 triangles with frames and gradients, and workspace to query. On 50,000, 200,000,
500,000 and a million random points of a sphere the sum is 0.95, 0.91, 1.02 and 1.00 of the peak."""

GROWTH_OF_NOISY_AND_SMOOTH_CLOUDS = (0.95, 1.15)
"""Growth of the roughness (:func:`roughness_of_cloud`) up to which fronts are measured in the
tangent planes, and from which on in space; values in between blend both. For points almost without
noise the distance in space is more accurate, and their angles show the curvature. Errors measured,
refined, in the plane and in space: bunny.off (growth 1.25) 0.57 and 0.31 %; 4,000 random points of
a sphere (1.56) 0.34 and 0.04 %, with noise of a 60th of the spacing (1.39) 0.32 and 0.09 %, of a
30th (1.15) 0.30 and 0.18 %, of a 20th (0.97) 0.27 and 0.27 %, of a 6th (0.70) 0.47 and 0.84 %."""


@dataclass(frozen=True)
class _Stars:
    """The stars of a cloud, and the data that they were made from.

    Attributes
    ----------
    soup : Soup
    normals : ndarray of shape (P, 3), float64
        Normals of the planes of the stars.
    thin : Representatives
        The positions that represent crowds.
    origin : str
        Origin of the normals that they were made with.
    in_space : ndarray of shape (P,), float64
        Share, from 0 to 1, to which triangles are measured in space instead of in tangent planes.
    rough : float
        Roughness of the cloud; 0 if most of it is curves.
    noisy : bool
        True if points deviate from the surface by noise.
    """

    soup: Soup
    normals: FloatArray
    thin: Representatives
    origin: str
    in_space: FloatArray
    rough: float
    noisy: bool


@final
@dataclass(frozen=True, kw_only=True)
class PointCloudLaplacian(LaplaceOperator):
    """Laplacian of a point cloud, from the triangles of local Delaunay stars.

    Every point is surrounded by triangles in its tangent plane: the star of the Delaunay
    triangulation of its neighbours there. A triangle belongs to the stars of its three corners, so
    each counts a third, in stiffness, gradient and mass; from there on it is the mesh's
    ``L = Gᵀ W G``, positive semidefinite (L = -Δ). Noise along the normals does not lengthen
    distances, because triangles are measured along the tangent planes. Refinement measures them in
    space if there is almost no noise.

    Neighbours at more than 45° from the tangent plane, and those whose given normal faces the
    opposite side, lie on another sheet and are ignored; neighbours that are off the plane by less
    are treated as if they were farther away.

    Parameters
    ----------
    k : int, optional
        Initial number of neighbours of a star; up to twice as many are used if the star needs them.
        By default 20, or all if the cloud has fewer.
    normals : {"auto", "open3d", "pca"}
        Estimator of the normals of a cloud without normals: Open3D, our own principal components,
        or Open3D if it can be imported. Normals whose planes are uncertain, on thin limbs and
        sheets, are turned to the emptiest side. Given normals are used as they are.

    Raises
    ------
    InvalidOptionError
        A value outside the ones above, or a k below 3.

    References
    ----------
    N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, Computer Graphics Forum 39,
    2020, section 5.7, https://doi.org/10.1111/cgf.14069

    K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat*, 2013, section 3.2.3,
    https://doi.org/10.1145/2516971.2516977

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> cloud = gt.PointCloud(gt.testing.shapes.icosphere(3).vertices)
    >>> sphere = gt.PointCloudLaplacian(normals="pca").assemble(cloud)
    >>> round(float(sphere.mass.sum()), 1)  # 4π
    12.5
    >>> sphere.notes["normals"], sphere.notes["k"]
    ('pca', 20)
    """

    k: int | None = None
    normals: Literal["auto", "open3d", "pca"] = "auto"

    domains: ClassVar[tuple[type[Domain], ...]] = (PointCloud,)
    references: ClassVar[tuple[str, ...]] = ("10.1111/cgf.14069", "10.1145/2516971.2516977")

    def __post_init__(self) -> None:
        whole = isinstance(self.k, int | np.integer) and not isinstance(self.k, bool)
        if self.k is not None and (not whole or self.k < 3):
            raise InvalidOptionError(
                f"k must be a whole number of 3 or more, or None, not {self.k!r}"
            )
        if not is_one_of(self.normals, ("auto", "open3d", "pca")):
            raise InvalidOptionError(
                f'normals must be "auto", "open3d" or "pca", not {self.normals!r}'
            )

    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a point cloud.

        Parameters
        ----------
        domain : PointCloud
            Missing points have zero mass, and so the distance ``inf``. Points at the same position
            share its mass and are tied together. A point without a triangle, as on a curve, is
            linked to its neighbours on either side.

        Returns
        -------
        Discretization
            Elements whose three vertices differ are triangles, the centre of the star first; the
            others, of the form (i, j, j), are links and ties. The spacing is the mean length of the
            spokes of all stars, in the tangent plane. The boundary consists of points whose star is
            open. If there is almost no noise, the frames in space are given. The notes hold
            ``normals`` ("given", "open3d", "pca", or "none" for a cloud of less than three
            positions), ``k``, the numbers ``missing``, ``duplicates`` and ``links``, the
            ``roughness`` of the cloud, and True as ``noisy`` if it has noise.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, or a width whose powers are out of the range of floats.
        InvalidOptionError
            An explicit k larger than the number of neighbours in the cloud.
        MissingDependencyError
            ``normals="open3d"``, and Open3D cannot be imported.

        Warns
        -----
        NormalsWarning
            ``normals="auto"``, and Open3D cannot be imported.
        NoisyCloudWarning
            Points deviate so far from the planes of their neighbours that distances are unreliable.
        """
        self.check_domain(domain)
        assert isinstance(domain, PointCloud)  # for the type checker; check_domain has raised
        check_width(widest(domain.points[domain.present]), "cloud")
        places = Places.of(domain)
        k = self._neighbours_of(places.count)
        stars, longest_line = self._stars_and_curves(places, domain, k)
        soup, scale = stars.soup, places.scale
        spacing = soup.spacing * scale if soup.spacing > 0 else 1.0  # a single one has none
        gradient = _gradient(places, soup, spacing)
        area = areas_of(soup, places.count) * scale**2
        if places.count == 1:
            area[:] = spacing**2 if len(places.ties) else 0.0
        scales, of_parts = _of_parts(places, stars, gradient, spacing)
        notes: dict[str, Any] = {
            "normals": stars.origin,
            "k": k,
            "missing": domain.n_vertices - len(places.present),
            "duplicates": len(places.ties),
            "links": len(soup.links),
            "representatives": len(stars.thin.kept),
            "open_stars": int(soup.boundary.sum()),
            "roughness": stars.rough,
            "noisy": stars.noisy,
            **of_parts,
            "longest_line": longest_line,
            "assembly_bytes": BYTES_PER_POINT * places.count
            + EXTRA_BYTES_OF_FIRST_POINTS * min(places.count, N_FIRST_POINTS),
        }
        warn_of_fragments(notes, places.count)
        warn_of_lines(notes)
        warn_of_noise(stars.rough)
        return Discretization(
            mass=places.shared(area),
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=spacing,
            boundary=places.at_points(soup.boundary, False),
            scales=scales,
            surface_frames=frames_on_surface(places.points, soup, gradient, stars.in_space, scale),
            normals=np.column_stack(
                [places.at_points(stars.normals[:, axis], axis == 2) for axis in range(3)]
            ),
            notes=notes,
            copy=False,
        )

    def diffusion(self, metric: Discretization) -> Discretization:
        """Return the positive part of `metric`: stars that disagree have edges of the wrong sign.

        Without it 2 % of an indoor scan and a tenth of the vertices of a CAD model have heat that
        is not positive; with it, all heat is positive.
        """
        return positive_part(metric)

    def frames(self, domain: Domain, metric: Discretization) -> Frames:
        """Return the frames of the tangent planes of the stars.

        Normals without a sign take one along a minimum spanning tree; those of closed surfaces
        point outwards.
        """
        self.check_domain(domain)
        return frames_of_stars(domain, metric)

    def _neighbours_of(self, count: int) -> int:
        if self.k is None:
            return min(DEFAULT_K, count - 1)
        if self.k > count - 1:
            raise InvalidOptionError(
                f"k={self.k} needs {self.k + 1} points at different places; the cloud has {count} "
                "(leave k out to have it chosen)"
            )
        return int(self.k)

    def _stars_and_curves(self, places: Places, cloud: PointCloud, k: int) -> tuple[_Stars, float]:
        """Return the stars, and the share of all points on the longest line of a surface.

        If there are points of curves, the stars are made again without them.
        """
        points = places.points
        thin = representatives(points, max(2 * k, POLE_NEIGHBOURS, NOISY_NEIGHBOURS))
        curved = np.zeros(places.count, dtype=np.bool_)
        stars = self._stars(places, thin, cloud, k, curved)
        on_lines = np.zeros(places.count, dtype=np.bool_)
        on_lines[thin.kept] = lie_on_lines(points[thin.kept], thin.own)
        curved = on_curves(stars.soup, thin, on_lines)
        if curved.any():
            thin = restored(points, thin, curved)
            stars = self._stars(places, thin, cloud, k, curved)
        return stars, share_of_longest_line(points, thin, on_lines & ~curved)

    def _stars(
        self, places: Places, thin: Representatives, cloud: PointCloud, k: int, curved: BoolArray
    ) -> _Stars:
        """Return the stars of points that are not on curves."""
        points = places.points
        rough, growth, blades = roughness_of_cloud(points, thin)
        noisy = is_noisy(rough, growth)
        given = None if cloud.normals is None else cloud.normals[places.representatives]
        normals, origin = normals_of(
            points, thin, blades | noisy, given=given, estimator=self.normals
        )
        low, high = GROWTH_OF_NOISY_AND_SMOOTH_CLOUDS
        flat = float(np.clip((growth - low) / (high - low), 0, 1))
        in_space = np.where(blades, 0.0, flat)
        soup = soup_of(
            points,
            normals,
            thin,
            k,
            curved=curved,
            smooth=in_space == 1,
            oriented=given is not None,
        )
        if given is not None and rough > 0:
            rough = roughness_of_sheets(points, thin, given)
        on_surface = 2 * np.count_nonzero(curved) <= places.count
        return _Stars(soup, normals, thin, origin, in_space, rough if on_surface else 0.0, noisy)


def _gradient(places: Places, soup: Soup, spacing: float) -> ElementGradient:
    """Return the gradient on triangles, links, and ties between points at one position."""
    own, scale = places.representatives, places.scale
    return with_segments(
        own[soup.triangles],
        soup.frames * scale,
        soup.shares,
        links=(own[soup.links], soup.link_lengths * scale, soup.link_widths * scale),
        ties=places.ties,
        tie_length=TIE_LENGTH * spacing,
        n_vertices=places.n_vertices,
    )


def _of_parts(
    places: Places, stars: _Stars, gradient: ElementGradient, spacing: float
) -> tuple[FloatArray, dict[str, Any]]:
    """Return the square root of the time step, (N,), by component, and notes on components."""
    connected = connected_by_faces(gradient.elements, places.n_vertices)
    own = connected[places.representatives]
    parts = stars.soup.parts(np.unique(own, return_inverse=True)[1])
    unit = spacing / places.scale
    scale_of_part = parts.scales(unit) * places.scale
    scales = places.at_points(scale_of_part[parts.parts], spacing)
    return scales, parts.notes(stars.thin.neighbours, unit)
