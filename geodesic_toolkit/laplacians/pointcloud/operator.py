"""The Laplacian of point clouds: local Delaunay stars, assembled like a triangle mesh."""

import warnings
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Literal, final

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.positivity import positive_part
from geodesic_toolkit.domains import Domain, PointCloud
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError, NormalsWarning
from geodesic_toolkit.geometry.components import connected_by_edges, connected_by_faces
from geodesic_toolkit.geometry.triangles import face_areas, hat_gradients, inverse_frames
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.laplacians.pointcloud.blades import (
    CURVED,
    NOISY_NEIGHBOURS,
    NORMAL_NEIGHBOURS,
    SAMPLE,
    roughness_and_growth,
    where_blades,
)
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives, representatives, restored
from geodesic_toolkit.laplacians.pointcloud.curves import curve_links, largest_chain, lie_on_lines
from geodesic_toolkit.laplacians.pointcloud.neighbours import (
    along_curve,
    distinct_points,
    nearest_among,
    normalised,
)
from geodesic_toolkit.laplacians.pointcloud.normals import open3d_normals, pca_normals
from geodesic_toolkit.laplacians.pointcloud.parts import (
    CloudParts,
    warn_of_fragments,
    warn_of_lines,
)
from geodesic_toolkit.laplacians.pointcloud.poles import pole_normals
from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars, tie_breakers
from geodesic_toolkit.laplacians.pointcloud.tears import bridges

__all__ = ["PointCloudLaplacian"]

DEFAULT_K = 20
"""Neighbours that a star begins with: a ball of 2.5 spacings, which holds nearly every star."""

POLE_NEIGHBOURS = 30
"""Neighbours among which the emptiest side of a point is sought, where its normal is in doubt."""

FAR_NEIGHBOURS = (120, 400)
"""Neighbours that a star may look among where points were crowded and it is open, the more where
the fewer leave it open. Measured on sweeps of 32 beams on a street: refined distances are 1.6 % off
with 160, 1.4 % with 400."""

FARTHEST_NEIGHBOURS = 1200
"""The same of scans, where the last rings are hundreds of their points apart and walls are nearer.
Measured, refined, on a street between houses, with :data:`FARTHEST` of 8: with 16 beams at 0.1 and
0.2 degrees 0.17 and 0.23 % of error among 800, 0.07 and 0.23 % among 1200."""

SCANS = 0.5
"""Share of crowded points from which on a cloud is a scan. Measured: 16 beams have 0.7 to 0.9 and
need so many, other sweeps 0.2 to 0.4; vertices of meshes 0 to 0.3, where so many are a limb:
camelhead's distances err by 1.13 % with them, and by 0.94 % without."""

AT_ONCE = 5_000
"""Stars that look among so many at once: their neighbours are not kept."""

FARTHEST = 6.0
"""Widest circle about a triangle of such a star, in reaches of the crowd. Scan lines get as much as
3 times farther apart from one to the next, and a crowd between walls reaches no farther than these;
the blind disc about a spinning scanner is 10 times as wide as its next ring, and more. Measured on
that street: 4, 6, 8 and 12 leave 1.9, 0.09, 0.07 and 0.07 % of error with 16 beams at 0.1 degrees,
and 2.2, 0.05, 0.05 and 0.05 % at 0.05 degrees (4 with 400 neighbours)."""

CLOSED = 0.1
"""Share of closed stars below which a thinned part of a cloud is taken for curves. Measured: two
lines have 0, scan lines of surfaces 0.5 to 0.9."""

CLOSED_LINES = 0.4
"""The same of parts most of whose points lie on lines, whether they were thinned or not: three
lines side by side have a third."""

ON_LINES = 0.8
"""Share of the points of a part that lie on lines from which on it may be curves. Measured: wires
have 0.95 and more, a band of random points as wide as their spacing 0.6."""

BYTES, FIRST_BYTES, FIRST = 2900.0, 1000.0, 100_000
"""Memory that each point takes while stars are made, at the most, and what the first of them take
beside that: twice 40 neighbours, 20 triangles with frames and gradients, and room to query. On
50,000, 200,000, 500,000 and a million random points of a sphere the sum is 0.95, 0.91, 1.02 and
1.00 of the peak."""

LARGE = 100_000
"""Points from which on they are taken in an order in which near ones are together: those of a cloud
drawn at random are all over the memory otherwise."""

BYSTANDER = 1e-4
"""Weight of the stars of points that others stand for. They hear of the others, and the others
hardly of them: forty to one are less than a hundredth."""

SMOOTH = (0.95, 1.15)
"""Growth of the roughness (:func:`_roughness_and_growth`) up to which fronts are measured in the
tangent planes, and from which on in space; in between in part. Of points with hardly any noise the
distance in space is the better one, and their angles tell the curvature. Measured, refined, in the
plane and in space: bunny.off (growth 1.25) 0.57 and 0.31 %; 4,000 random points of a sphere (1.56)
0.34 and 0.04 %, with noise of a 60th of the spacing (1.39) 0.32 and 0.09 %, of a 30th (1.15) 0.30
and 0.18 %, of a 20th (0.97) 0.27 and 0.27 %, of a 6th (0.70) 0.47 and 0.84 %."""

FLATTEST = 1e-16
"""Squared height of a triangle to its edge below which it is taken for rounding."""

TIE_LENGTH = 1e-9
"""Distance of duplicates from their representative, in spacings."""

STIFFEST = 100.0
"""Largest width of a link in shares of its length, which is its stiffness. Points a millionth of
the spacing apart are as good as one, and factors that have to tell them apart come to nothing."""

TIE_WEIGHT = 1e6
"""Stiffness between them, in shares of what holds the representative."""


@final
@dataclass(frozen=True, kw_only=True)
class PointCloudLaplacian(LaplaceOperator):
    """Laplacian of a point cloud: the triangles of local Delaunay stars, a third each.

    Every point is surrounded by triangles in its tangent plane: the star of the Delaunay
    triangulation of its neighbours there. A triangle belongs to the stars of its three corners, so
    each counts a third, in stiffness, gradient and mass; from there on it is the mesh's
    ``L = Gᵀ W G``, positive semidefinite (L = -Δ). Noise along the normals does not lengthen
    distances, because triangles are measured along the tangent planes. Refinement measures them in
    space where there is hardly any.

    Neighbours at more than 45° from the tangent plane, and those whose given normal faces the
    other way, lie on another sheet and do not count; those that stand off it less count for
    farther than they are.

    Parameters
    ----------
    k : int, optional
        Neighbours that a star begins with; up to twice as many are taken where these do not settle
        it. By default 20, or all where the cloud has fewer.
    normals : {"auto", "open3d", "pca"}
        Who estimates the normals of a cloud that comes without: Open3D, our own principal
        components, or Open3D where it can be imported. Where their planes are in doubt, on thin
        limbs and sheets, they are turned to the emptiest side. Given normals are used as they are.

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
        if self.normals not in ("auto", "open3d", "pca"):
            raise InvalidOptionError(
                f'normals must be "auto", "open3d" or "pca", not {self.normals!r}'
            )

    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a point cloud.

        Parameters
        ----------
        domain : PointCloud
            Missing points get no mass, and with that the distance ``inf``. Points at the same
            place share its mass and are tied together. A point that no triangle reaches, as on a
            curve, is linked to its neighbours on either side.

        Returns
        -------
        Discretization
            Elements whose three vertices differ are triangles, the centre of the star first; the
            others, of the form (i, j, j), are links and ties. The spacing is the mean length of
            the spokes of all stars, in the tangent plane. The boundary is where a star is open.
            Where there is hardly any noise, the frames in space are given. The notes hold
            ``normals`` ("given", "open3d", "pca", or "none" for a cloud of less than three places),
            ``k``, and the numbers ``missing``, ``duplicates`` and ``links``.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain.
        InvalidOptionError
            An explicit k that the cloud has not as many neighbours for.
        MissingDependencyError
            ``normals="open3d"``, and Open3D cannot be imported.

        Warns
        -----
        NormalsWarning
            ``normals="auto"``, and Open3D cannot be imported.
        """
        self.check_domain(domain)
        assert isinstance(domain, PointCloud)  # for the type checker; check_domain has raised
        everywhere = np.flatnonzero(domain.present)
        points, scale = normalised(domain.points, domain.present)
        first, place = distinct_points(points)
        count = len(first)
        k = self._neighbours_of(count)
        points = points[first]
        if count > LARGE:
            order = along_curve(points)
            first, points, place = first[order], points[order], np.argsort(order)[place]
        wanted = max(2 * k, POLE_NEIGHBOURS, NOISY_NEIGHBOURS)
        thin = representatives(points, wanted)
        stars = partial(self._stars, points, domain=domain, representative=everywhere[first], k=k)
        soup, whose, in_space = stars(thin)
        on_lines = np.zeros(count, dtype=np.bool_)
        on_lines[thin.kept] = lie_on_lines(points[thin.kept], thin.own)
        curved = _on_curves(soup, thin, on_lines)
        if curved.any():
            thin = restored(points, thin, curved)
            soup, whose, in_space = stars(thin, curved=curved)
        share = _share_of_longest_line(points, thin, on_lines & ~curved)
        spacing = soup.spacing * scale if soup.spacing > 0 else 1.0  # one place: there is no length

        representative = everywhere[first]
        duplicates = np.flatnonzero(first[place] != np.arange(len(place)))
        ties = np.column_stack([everywhere[first[place[duplicates]]], everywhere[duplicates]])
        gradient = _with_segments(
            representative[soup.triangles],
            soup.frames * scale,
            soup.shares,
            (representative[soup.links], soup.link_lengths * scale, soup.link_widths * scale),
            ties,
            TIE_LENGTH * spacing,
            domain.n_vertices,
        )
        area = _areas(soup, count) * scale**2
        if count == 1:
            area[:] = spacing**2 if len(duplicates) else 0.0
        mass = np.zeros(domain.n_vertices)
        boundary = np.zeros(domain.n_vertices, dtype=np.bool_)
        mass[everywhere] = (area / np.bincount(place))[place]
        boundary[everywhere] = soup.boundary[place]
        notes: dict[str, Any] = {
            "normals": whose,
            "k": k,
            "missing": domain.n_vertices - len(everywhere),
            "duplicates": len(duplicates),
            "links": len(soup.links),
            "representatives": len(thin.kept),
            "open_stars": int(soup.boundary.sum()),
        }
        connected = connected_by_faces(gradient.elements, domain.n_vertices)
        parts = soup.parts(np.unique(connected[representative], return_inverse=True)[1])
        unit = spacing / scale
        scale_of_part = parts.scales(unit) * scale
        scales = np.full(domain.n_vertices, spacing)
        scales[everywhere] = scale_of_part[parts.parts][place]
        notes |= parts.notes(thin.neighbours, unit)
        notes["longest_line"] = share
        notes["assembly_bytes"] = BYTES * count + FIRST_BYTES * min(count, FIRST)
        warn_of_fragments(notes, count)
        warn_of_lines(notes)
        return Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=spacing,
            boundary=boundary,
            scales=scales,
            surface_frames=_surface_frames(points, soup, gradient, in_space, scale),
            notes=notes,
            copy=False,
        )

    def diffusion(self, metric: Discretization) -> Discretization:
        """Return the positive part of `metric`: stars that disagree have edges of the wrong sign.

        Without it 2 % of a room scan and a tenth of the vertices of a CAD model get heat that is
        not positive; with it, none.
        """
        return positive_part(metric)

    def _neighbours_of(self, count: int) -> int:
        if self.k is None:
            return min(DEFAULT_K, count - 1)
        if self.k > count - 1:
            raise InvalidOptionError(
                f"k={self.k} needs {self.k + 1} points at different places; the cloud has {count} "
                "(leave k out to have it chosen)"
            )
        return int(self.k)

    def _stars(
        self,
        points: FloatArray,
        thin: Representatives,
        *,
        domain: PointCloud,
        representative: IntArray,
        k: int,
        curved: BoolArray | None = None,
    ) -> tuple["_Soup", str, FloatArray]:
        """Return the stars, whose normals they were made with, and how far space measures them.

        Points of curves, if it is known which they are, have none.
        """
        rough, growth, blades = _roughness_and_growth(points, thin)
        noisy = blades | (rough > 0.15 and growth < 0.85)
        normals, whose = self._normals(points, thin, domain, representative, noisy)
        flat = float(np.clip((growth - SMOOTH[0]) / (SMOOTH[1] - SMOOTH[0]), 0, 1))
        in_space = np.where(blades, 0.0, flat)
        if curved is None:
            curved = np.zeros(len(points), dtype=np.bool_)
        given = whose == "given"
        soup = _soup(points, normals, thin, k, curved, in_space == 1, oriented=given)
        return soup, whose, in_space

    def _normals(
        self,
        points: FloatArray,
        thin: Representatives,
        domain: PointCloud,
        representative: IntArray,
        noisy: BoolArray,
    ) -> tuple[FloatArray, str]:
        """Return a unit normal for every distinct point, and whose they are."""
        if domain.normals is not None:
            return domain.normals[representative], "given"
        count = len(points)
        if count < 3:
            return np.tile([0.0, 0.0, 1.0], (count, 1)), "none"
        kept, near = points[thin.kept], thin.own
        noisy = noisy[thin.kept]
        normals, whose = self._estimate(
            kept, near[:, : NOISY_NEIGHBOURS if noisy.all() else NORMAL_NEIGHBOURS]
        )
        more = np.flatnonzero((noisy | (thin.reaches[thin.kept] > 0)) & ~noisy.all())
        normals[more] = pca_normals(kept, near[more], more)
        if not noisy.all():  # from noise, too, neighbours are steep
            poles = pole_normals(kept, near[:, :POLE_NEIGHBOURS], normals)
            normals = np.where(noisy[:, None], normals, poles)
        return normals[thin.nearest], whose

    def _estimate(self, points: FloatArray, near: IntArray) -> tuple[FloatArray, str]:
        """Return normals from the neighbours that count, and whose they are."""
        # Open3D guesses from fewer than four points; three have one plane, whoever finds it.
        if self.normals != "pca" and len(points) > 3:
            try:
                normals = open3d_normals(points, near)
            except MissingDependencyError as error:
                if self.normals == "open3d":
                    raise
                warnings.warn(
                    f"{error}; until then normals come from principal components, which "
                    'PointCloudLaplacian(normals="pca") chooses without this warning',
                    NormalsWarning,
                    stacklevel=5,
                )
            else:
                return normals, "open3d"
        return pca_normals(points, near), "pca"


def _roughness_and_growth(
    points: FloatArray, thin: Representatives
) -> tuple[float, float, BoolArray]:
    """Return how rough neighbourhoods are, how that grows with their width, and where blades are.

    The roughness is how far points stand off their neighbourhood's plane. A wider neighbourhood of
    a curved surface is rougher relative to its width, one of a noisy surface smoother. Measured, as
    the median ratio of both: spheres, meshes and fused scans 0.86 to 1.5; noise from a sixth of the
    spacing on, a raw object scan and a depth image 0.6 to 0.8. Too few points to tell are taken for
    a surface, and so are planes.

    Both are medians over the cloud; blades are a matter of regions.
    """
    kept, count = thin.kept, len(points)
    blades = np.zeros(count, dtype=np.bool_)
    if len(kept) <= 4 * NOISY_NEIGHBOURS:
        return 0.0, CURVED, blades
    chosen = kept[np.linspace(0, len(kept) - 1, min(SAMPLE, len(kept))).astype(np.int64)]
    near = thin.neighbours[chosen]
    rough, growth = (np.median(each) for each in roughness_and_growth(points, near)[::2])
    return float(rough), float(growth), where_blades(points, chosen, near)


@dataclass(frozen=True)
class _Soup:
    """The triangles of all stars, and links to points of none; indices are those of places."""

    triangles: IntArray
    frames: FloatArray
    shares: FloatArray
    links: IntArray
    link_lengths: FloatArray
    spacing: float
    boundary: BoolArray

    @property
    def link_widths(self) -> FloatArray:
        """How wide links are: as points are apart, but for those that would be too stiff."""
        return np.minimum(self.spacing, STIFFEST * self.link_lengths)

    def parts(self, parts: IntArray) -> CloudParts:
        """Return what is connected, where `parts` are the (N,) parts of places."""
        stars = (self.triangles, self.frames, self.shares)
        return CloudParts(*stars, self.links, self.link_lengths, parts)


def _soup(  # noqa: PLR0917 - what it needs, in the order of its doing
    points: FloatArray,
    normals: FloatArray,
    thin: Representatives,
    k: int,
    curved: BoolArray,
    smooth: BoolArray,
    *,
    oriented: bool,
) -> _Soup:
    count = len(points)
    neighbours = np.ascontiguousarray(thin.neighbours[:, : 2 * k])
    weights = tie_breakers(points, neighbours)
    star = partial(_stars_of, points, normals, smooth, k=k, oriented=oriented, weights=weights)
    triangles, frames, boundary = star(neighbours, np.arange(count))
    is_scan = np.count_nonzero(thin.reaches) > SCANS * count
    for far in (*FAR_NEIGHBOURS, FARTHEST_NEIGHBOURS) if is_scan else FAR_NEIGHBOURS:
        asked = np.flatnonzero(boundary & (thin.reaches > 0))
        for begin in range(0, len(asked), AT_ONCE):
            some = asked[begin : begin + AT_ONCE]
            wide = nearest_among(points, thin.kept, some, min(far, len(thin.kept) - 1))
            reaches = FARTHEST * thin.reaches[some]
            grown, grown_frames, boundary[some] = star(wide, some, reaches=reaches)
            stay = ~np.isin(triangles[:, 0], some)
            triangles = np.concatenate([triangles[stay], grown])
            frames = np.concatenate([frames[stay], grown_frames])
    order = np.argsort(triangles[:, 0], kind="stable")
    if curved.any():
        order = order[~curved[triangles[order]].any(axis=1)]
    triangles, frames = triangles[order], frames[order]
    alone = np.bincount(triangles.ravel(), minlength=count) == 0
    links = curve_links(points, neighbours, np.flatnonzero(alone))
    ends = np.bincount(links.ravel(), minlength=count) == 1
    boundary = np.where(alone, ends, boundary)
    edges = np.concatenate([triangles[:, :2], triangles[:, ::2], links, links[:, ::-1]])
    torn = (boundary | alone) & thin.stands
    across = bridges(
        points, normals, neighbours, edges, torn, oriented=oriented, curved=curved | alone
    )
    links = np.concatenate([links, across])
    steps = points[links[:, 1]] - points[links[:, 0]]
    lengths = np.sqrt(np.einsum("ed,ed->e", steps, steps))
    shares = np.where(thin.stands[triangles[:, 0]], 1.0, BYSTANDER)
    spokes = np.concatenate([frames[:, 0], np.hypot(frames[:, 1], frames[:, 2])])
    measured = spokes if len(spokes) else lengths
    spacing = (
        float(np.average(measured, weights=np.tile(shares, 2) if len(spokes) else None))
        if len(measured)
        else 0.0
    )
    return _Soup(triangles, frames, shares, links, lengths, spacing, boundary)


def _stars_of(  # noqa: PLR0917 - what it needs, in the order of its doing
    points: FloatArray,
    normals: FloatArray,
    smooth: BoolArray,
    neighbours: IntArray,
    centres: IntArray,
    reaches: FloatArray | None = None,
    **options: Any,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the stars of some points, of which the smooth ones are made more strictly."""
    is_open = np.zeros(len(centres), dtype=np.bool_)
    stars = []
    for strict in (True, False):
        rows = np.flatnonzero(smooth[centres] == strict)
        if len(rows) == 0:
            continue
        found = delaunay_stars(
            points,
            normals,
            neighbours if len(rows) == len(centres) else neighbours[rows],
            centres=centres[rows],
            reaches=None if reaches is None else reaches[rows],
            smooth=strict,
            **options,
        )
        stars.append(found[:2])
        is_open[rows] = found[2]
    triangles, frames = (np.concatenate(parts) for parts in zip(*stars, strict=True))
    return triangles, frames, is_open


def _surface_frames(
    points: FloatArray, soup: _Soup, gradient: ElementGradient, in_space: FloatArray, scale: float
) -> FloatArray:
    """Return all elements' inverse frames, the triangles' measured in space as far as told.

    Between both the products of the two edges from the centre are averaged: those of a triangle.
    """
    if not in_space.any():
        return np.zeros((0, 3))
    share = in_space[soup.triangles[:, 0]]
    frames, (centre, second, third) = soup.frames, soup.triangles.T
    p, q = points[second] - points[centre], points[third] - points[centre]
    flat = (frames[:, 0] ** 2, frames[:, 0] * frames[:, 1], frames[:, 1] ** 2 + frames[:, 2] ** 2)
    solid = (np.einsum("ed,ed->e", *pair) for pair in ((p, p), (p, q), (q, q)))
    pp, pq, qq = (s * share + f * (1 - share) for s, f in zip(solid, flat, strict=True))
    length = np.sqrt(pp)
    height = np.sqrt(np.maximum(qq - (pq / length) ** 2, FLATTEST * qq))
    inverse = gradient.inverse_frames.copy()
    triangles = np.column_stack([length, pq / length, height])
    inverse[: len(frames)] = inverse_frames(triangles * scale)
    return inverse


def _share_of_longest_line(points: FloatArray, thin: Representatives, on_lines: BoolArray) -> float:
    """Return the share of all points that the longest line of a surface holds."""
    on_lines = on_lines[thin.kept]
    if not on_lines.any():
        return 0.0
    return largest_chain(points[thin.kept], thin.own, on_lines)


def _on_curves(soup: _Soup, thin: Representatives, on_lines: BoolArray) -> BoolArray:
    """Return which points are of curves and not of surfaces, of shape (N,).

    Lines of a surface have others on either side, so that most of their stars are closed. Where
    hardly any is, what the stars connect is a wire, or a few lines at most.
    """
    count = len(on_lines)
    crowded = thin.reaches > 0
    if not (crowded.any() or on_lines.any()):
        return crowded
    alone = np.bincount(soup.triangles.ravel(), minlength=count) == 0
    # A line goes on where it bends, although the points there have triangles.
    steps = np.concatenate([soup.triangles[:, :2], soup.triangles[:, 1:], soup.links])
    part = connected_by_edges(steps, count)
    whole = ~soup.boundary & ~alone
    open_crowds = _shares(part, whole, crowded) < CLOSED
    few_lines = _shares(part, whole, thin.stands) < CLOSED_LINES
    few_lines &= _shares(part, on_lines, thin.stands) > ON_LINES
    stands_alone = alone[thin.kept][thin.nearest]
    curved = crowded & (alone | stands_alone | open_crowds[part])
    return np.asarray(curved | few_lines[part])


def _shares(part: IntArray, chosen: BoolArray, among: BoolArray) -> FloatArray:
    """Return which share of some points of each part is chosen; 1 where there are none."""
    count = int(part.max()) + 1
    total = np.bincount(part[among], minlength=count)
    found = np.bincount(part[among & chosen], minlength=count)
    return np.divide(found, total, out=np.ones(count), where=total > 0)


def _areas(soup: _Soup, count: int) -> FloatArray:
    """Return the measure of every place: a third of a third of its triangles, half of its links."""
    corner_areas = np.repeat(soup.shares * face_areas(soup.frames) / 9, 3)
    halves = np.repeat(soup.link_lengths * soup.link_widths / 2, 2)
    area = np.bincount(soup.triangles.ravel(), corner_areas, minlength=count)
    return np.asarray(area + np.bincount(soup.links.ravel(), halves, minlength=count))


def _with_segments(  # noqa: PLR0917 - what it needs, in the order of its doing
    triangles: IntArray,
    frames: FloatArray,
    shares: FloatArray,
    links: tuple[IntArray, FloatArray, FloatArray],
    ties: IntArray,
    tie_length: float,
    n_vertices: int,
) -> ElementGradient:
    """Return the gradient on triangles, a third of each, on links of given widths, and on ties.

    A segment (i, j) is the element (i, j, j) on which the gradient has one component, along it.
    Ties are stiff beside what holds their first end: outliers hang by a thousandth of a millionth,
    and a factor could not tell that from nothing beside ties that are equally stiff everywhere.
    """
    elements, coefficients = [triangles], [hat_gradients(frames)]
    measures = [shares * face_areas(frames) / 3]
    ends, lengths, widths = links
    held = np.bincount(ends.ravel(), np.repeat(widths / lengths, 2), minlength=n_vertices)
    each = measures[0][:, None] * np.einsum("edc,edc->ec", coefficients[0], coefficients[0])
    held = held + np.bincount(triangles.ravel(), each.ravel(), minlength=n_vertices)
    stiff = TIE_WEIGHT * np.where(held > 0, held, 1.0)[ties[:, 0]]
    lengths_of_ties = np.full(len(ties), tie_length)
    for pairs, long, wide in (links, (ties, lengths_of_ties, stiff * tie_length)):
        slope = np.zeros((len(pairs), 2, 3))
        slope[:, 0, 0], slope[:, 0, 1] = -1 / long, 1 / long
        elements.append(pairs[:, [0, 1, 1]])
        coefficients.append(slope)
        measures.append(long * wide)
    return ElementGradient(
        np.concatenate(elements),
        np.concatenate(coefficients),
        np.concatenate(measures),
        n_vertices,
        stars=True,
        copy=False,
    )
