"""Discs about a source: their area, what they are made of, when they are none."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

SPHERE = gt.GeodesicSolver(shapes.icosphere(4))


def cap(radius):
    return 2 * np.pi * (1 - np.cos(radius))


@pytest.mark.parametrize("source", [0, [0.0, 0.6, 0.8], gt.SurfacePoint(700, (0.3, 0.3, 0.4))])
@pytest.mark.parametrize("radius", [0.4, 1.0, 2.5])
def test_a_disc_on_a_sphere_has_the_area_of_a_cap(source, radius):
    disc = gt.geodesic_disc(SPHERE, source, radius)
    assert disc.area == pytest.approx(cap(radius), rel=0.01)
    assert disc.is_disc
    assert disc.n_boundaries == 1


def test_the_area_of_discs_converges():
    errors = []
    for level in (2, 3, 4):
        disc = gt.geodesic_disc(gt.GeodesicSolver(shapes.icosphere(level)), 0, 1.0)
        errors.append(abs(disc.area / cap(1.0) - 1))
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


def test_the_border_of_a_disc_is_the_isoline_of_the_distance():
    disc = gt.geodesic_disc(SPHERE, 0, 1.0)
    field = SPHERE.distance(0)
    (circle,) = gt.isolines(SPHERE.domain, field, 1.0)
    sides = np.sort(disc.mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    ends = disc.mesh.vertices[edges[counts == 1]]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    assert length == pytest.approx(gt.curve_length(SPHERE.domain, circle), rel=1e-9)
    assert disc.area == pytest.approx(gt.area_above(SPHERE.domain, -field, -1.0), rel=1e-9)
    assert disc.distance.max() == 1.0


def test_a_disc_says_where_its_vertices_and_faces_come_from():
    mesh = SPHERE.domain
    disc = gt.geodesic_disc(SPHERE, gt.SurfacePoint(700, (0.3, 0.3, 0.4)), 0.7)
    np.testing.assert_allclose(disc.carry(mesh.vertices), disc.mesh.vertices, atol=1e-12)
    with pytest.raises(InvalidOptionError, match="of shape"):
        disc.carry(np.zeros(3))
    old = disc.origin >= 0
    np.testing.assert_array_equal(disc.mesh.vertices[old], mesh.vertices[disc.origin[old]])
    np.testing.assert_allclose(disc.distance[~old].max(), 0.7)
    normals = [
        np.cross(
            shape.vertices[f[:, 1]] - shape.vertices[f[:, 0]],
            shape.vertices[f[:, 2]] - shape.vertices[f[:, 0]],
        )
        for shape, f in ((disc.mesh, disc.mesh.faces), (mesh, mesh.faces[disc.faces]))
    ]
    assert (np.einsum("fd,fd->f", *normals) > 0).all()
    assert not disc.distance.flags.writeable


def test_a_disc_that_reaches_around_is_none():
    torus = gt.GeodesicSolver(shapes.torus(60, 30))
    small, band, whole = (gt.geodesic_disc(torus, 0, r) for r in (0.8, 3.0, 100.0))
    assert (small.is_disc, band.is_disc, whole.is_disc) == (True, False, False)
    assert (small.n_boundaries, band.n_boundaries, whole.n_boundaries) == (1, 2, 0)
    two = gt.geodesic_disc(SPHERE, [0, 100], 0.1)
    assert not two.is_disc
    assert repr(two).endswith("2 boundaries)")


def test_a_disc_at_a_boundary_ends_there():
    square = gt.GeodesicSolver(shapes.grid(31))
    disc = gt.geodesic_disc(square, 0, 0.5)
    assert disc.area == pytest.approx(np.pi / 16, rel=0.005)
    assert disc.is_disc


def test_a_cut_next_to_vertices_leaves_no_sliver():
    square = gt.GeodesicSolver(shapes.grid(21))
    disc = gt.geodesic_disc(square, 220, 0.25)  # five edges, and vertices 3 by 4 of them away
    corners = disc.mesh.vertices[disc.mesh.faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert sides.min() > 1e-3
    assert disc.area == pytest.approx(np.pi / 16, rel=0.02)


def test_a_disc_about_a_curve_is_a_band():
    square = gt.GeodesicSolver(shapes.grid(31))
    band = gt.geodesic_disc(square, gt.Curve([[0.5, 0, 0], [0.5, 1, 0]]), 0.2)
    assert band.area == pytest.approx(0.4, rel=0.01)


def test_a_disc_of_less_than_an_edge_is_one():
    place = gt.SurfacePoint(7, (0.2, 0.3, 0.5))
    disc = gt.geodesic_disc(SPHERE, place, 0.005)
    assert disc.is_disc
    assert 0 < disc.area <= np.pi * 0.005**2


@pytest.mark.parametrize("radius", [1e-6, 0.005, 0.012])
@pytest.mark.parametrize(
    ("source", "share"),
    [(60, 1.0), (0, 0.25), (5, 0.5), ([0.52, 0.54, 0.0], 1.0), ([0.55, 0.5, 0.0], 1.0)],
)
def test_a_disc_within_the_faces_about_its_source_is_round(source, share, radius):
    """On a grid of edges of 0.1: in the middle, in a corner, on a side, in a face, on an edge."""
    square = gt.GeodesicSolver(shapes.grid(11))
    disc = gt.geodesic_disc(square, source, radius)
    assert disc.area == pytest.approx(share * np.pi * radius**2, rel=0.002)
    assert disc.is_disc
    np.testing.assert_allclose(disc.carry(square.domain.vertices), disc.mesh.vertices, atol=1e-15)
    centre = square.domain.vertices[source] if isinstance(source, int) else np.array(source)
    apart = np.linalg.norm(disc.mesh.vertices - centre, axis=1)
    np.testing.assert_allclose(disc.distance, apart, atol=1e-9)


@pytest.mark.parametrize("radius", [0.08, 0.1, 0.12])
def test_a_circle_that_leaves_these_faces_loses_little(radius):
    disc = gt.geodesic_disc(gt.GeodesicSolver(shapes.grid(11)), 60, radius)
    assert 0.9 * np.pi * radius**2 < disc.area < np.pi * radius**2
    assert disc.is_disc


def test_round_discs_of_neighbouring_sources_overlap():
    square = gt.GeodesicSolver(shapes.grid(11))
    both = gt.geodesic_disc(square, [60, 61], 0.08)  # 0.1 apart
    half = np.arccos(0.05 / 0.08)
    lens = 2 * 0.08**2 * (half - np.sin(half) * np.cos(half))
    assert both.area == pytest.approx(2 * np.pi * 0.08**2 - lens, rel=0.03)
    assert both.is_disc


def test_faces_about_a_source_are_not_split_for_a_circle_that_is_far():
    disc = gt.geodesic_disc(SPHERE, 0, 1.0)
    inside = disc.origin >= 0
    assert (np.abs(disc.distance[~inside] - 1.0) == 0).all()


@pytest.mark.parametrize("radius", [1e-12, 1e-300])
def test_a_radius_that_edges_do_not_resolve_is_refused(radius):
    with pytest.raises(InvalidOptionError, match="less than 1e-09 of the edges about the source"):
        gt.geodesic_disc(SPHERE, 0, radius)


def test_a_disc_stays_out_of_what_is_not_reached():
    two = shapes.disjoint_union(shapes.icosphere(2), shapes.icosphere(2))
    disc = gt.geodesic_disc(gt.GeodesicSolver(two), 0, 100.0)
    assert disc.mesh.n_faces == two.n_faces // 2


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf, "wide", True, None])
def test_a_radius_is_a_length(radius):
    with pytest.raises(InvalidOptionError, match="radius"):
        gt.geodesic_disc(SPHERE, 0, radius)


def test_a_radius_with_nothing_within_is_refused():
    middle = gt.Curve([gt.SurfacePoint(0, (0.3, 0.3, 0.4)), gt.SurfacePoint(0, (0.3, 0.4, 0.3))])
    with pytest.raises(InvalidOptionError, match="give a larger one"):
        gt.geodesic_disc(SPHERE, middle, 1e-6)


def test_a_disc_needs_a_mesh_and_a_source():
    with pytest.raises(UnsupportedDomainError, match="need a triangle mesh"):
        gt.geodesic_disc(gt.GeodesicSolver(gt.PointCloud(shapes.grid(9).vertices)), 0, 1.0)
    with pytest.raises(InvalidSourceError, match="does not exist"):
        gt.geodesic_disc(SPHERE, 10**6, 1.0)
    with pytest.raises(InvalidOptionError, match="GeodesicSolver"):
        gt.geodesic_disc(SPHERE.domain, 0, 1.0)
