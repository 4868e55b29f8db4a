"""Means and medians of places on surfaces, and cells whose sites are their centres."""

import numpy as np
import pytest
from curved_shapes import irregular_plate, irregular_sphere

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)

shapes = gt.testing.shapes
SPHERE = gt.GeodesicSolver(irregular_sphere(2000))
PLATE = gt.GeodesicSolver(irregular_plate(20))
HEXAGON = 5 / (18 * np.sqrt(3))
"""Second moment of regular hexagons of area 1."""


def mean_on_sphere(points, weights, power, steps=300):
    x = points.mean(axis=0)
    x /= np.linalg.norm(x)
    for _ in range(steps):
        d = np.arccos(np.clip(points @ x, -1, 1))
        away = points - (points @ x)[:, None] * x
        logs = away / np.maximum(np.linalg.norm(away, axis=1), 1e-12)[:, None] * d[:, None]
        pull = weights * (1 if power == 2 else 1 / np.maximum(d, 1e-12))
        move = pull @ logs / pull.sum()
        size = np.linalg.norm(move)
        x = np.cos(size) * x + (np.sin(size) / size * move if size > 0 else 0)
    return x


@pytest.mark.parametrize("power", [1, 2])
def test_means_on_a_sphere_are_those_of_the_sphere(power):
    mesh = SPHERE.domain
    sites = np.flatnonzero(mesh.vertices[:, 2] > 0.6)[::40][:7]
    weights = np.linspace(0.5, 2, len(sites))
    found = gt.geodesic_mean(SPHERE, sites, weights=weights, power=power)
    want = mean_on_sphere(mesh.vertices[sites], weights, power)
    at = found.position / np.linalg.norm(found.position)
    assert np.arccos(min(1.0, at @ want)) < 0.05 * SPHERE.method.metric.spacing
    assert found.energy <= found.vertex_energy.min() * (1 + 1e-6)


def test_medians_are_not_left_where_distances_are_rough():
    # The sum is rough by errors of distances: iterations that stopped at its first increase were
    # up to 0.12 edge lengths off.
    points = SPHERE.domain.vertices
    cap = np.flatnonzero(points[:, 2] > 0.55)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        sites = points[rng.choice(cap, 5 + 7 * (seed % 2), replace=False)]
        want = mean_on_sphere(sites, np.ones(len(sites)), 1, steps=3000)
        found = gt.geodesic_mean(SPHERE, sites, power=1).position
        off = np.linalg.norm(found / np.linalg.norm(found) - want)
        assert off < 0.02 * SPHERE.method.metric.spacing


def test_in_the_plane_the_mean_is_that_of_the_coordinates():
    places = [gt.SurfacePoint(30, (0.2, 0.3, 0.5)), gt.SurfacePoint(400, (0.1, 0.1, 0.8))]
    mesh = PLATE.domain
    corners = [mesh.vertices[mesh.faces[place.face]] for place in places]
    at = [np.array(p.barycentric) @ c for p, c in zip(places, corners, strict=True)]
    found = gt.geodesic_mean(PLATE, places, weights=[3.0, 1.0])
    np.testing.assert_allclose(found.position, 0.75 * at[0] + 0.25 * at[1], atol=1e-4)
    assert found.point.face < mesh.n_faces
    assert "energy" in repr(found)


def test_the_median_stays_at_a_site_that_outweighs_the_others():
    found = gt.geodesic_mean(PLATE, [0, 150, 399], weights=[1.0, 5.0, 1.0], power=1)
    np.testing.assert_allclose(found.position, PLATE.domain.vertices[150], atol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"power": 3}, "power must be 1 or 2"),
        ({"tolerance": 0.0}, "tolerance positive"),
        ({"weights": [1.0]}, "weights must be 2"),
        ({"weights": [-1.0, 1.0]}, "not negative"),
        ({"weights": ["a", "b"]}, "numbers"),
        ({"weights": [0.0, 0.0]}, "not all zero"),
    ],
)
def test_options_of_means_outside_their_values_are_named(options, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.geodesic_mean(PLATE, [0, 1], **options)


def test_means_need_faces_sites_and_a_connection_between_them():
    with pytest.raises(UnsupportedDomainError, match="place on a TriangleMesh"):
        gt.geodesic_mean(gt.GeodesicSolver(gt.Graph(2, [[0, 1]])), [0, 1])
    with pytest.raises(InvalidSourceError, match="not of a curve"):
        gt.geodesic_mean(PLATE, gt.Curve([[0, 0, 0], [1, 0, 0]]))
    both = shapes.disjoint_union(shapes.grid(3), shapes.grid(3))
    with pytest.raises(UnreachableError, match="different parts"):
        gt.geodesic_mean(gt.GeodesicSolver(both), [0, 9])


def test_cells_on_a_sphere_become_nearly_regular():
    cells = gt.centroidal_voronoi(SPHERE, 30, rng=np.random.default_rng(0))
    assert (np.diff(cells.energies) < 0).all()
    assert cells.energies[-1] < 1.08 * HEXAGON * (4 * np.pi) ** 2 / 30
    assert set(cells.labels) == set(range(30))
    assert len(cells.sites) == 30
    nearest = gt.geodesic_voronoi(SPHERE, cells.sites)
    labels = nearest[0] if isinstance(nearest, tuple) else nearest
    assert (labels != cells.labels).mean() < 0.03


def test_cells_are_small_where_the_density_is_large():
    x = PLATE.domain.vertices[:, 0]
    cells = gt.centroidal_voronoi(
        PLATE, 20, density=1 + 50 * (x < 0.3), rng=np.random.default_rng(1)
    )
    at = np.array([p.barycentric for p in cells.sites])
    corners = PLATE.domain.vertices[PLATE.domain.faces[[p.face for p in cells.sites]]]
    places = np.einsum("pc,pcd->pd", at, corners)
    assert (places[:, 0] < 0.4).sum() > 11


def test_one_site_goes_to_the_middle_of_a_plate():
    cells = gt.centroidal_voronoi(PLATE, [0], tolerance=0.0)
    corners = PLATE.domain.vertices[PLATE.domain.faces[cells.sites[0].face]]
    np.testing.assert_allclose(
        np.array(cells.sites[0].barycentric) @ corners, [0.5, 0.5, 0.0], atol=0.02
    )
    assert "1 sites" in repr(cells)


def test_masked_faces_keep_their_numbers():
    square = shapes.grid(9)
    solver = gt.GeodesicSolver(square, mask=square.vertices[:, 0] < 0.2)
    cells = gt.centroidal_voronoi(solver, [40, 60], steps=3)
    for site in cells.sites:
        assert not solver.mask[square.faces[site.face]].any()


EVEN = np.ones(PLATE.domain.n_vertices)


@pytest.mark.parametrize(
    ("sites", "options", "message"),
    [
        ([0, 1], {"steps": -1}, "steps must be an integer that is not negative, not -1"),
        ([0, 1], {"steps": 2.5}, "steps must be an integer that is not negative, not 2.5"),
        ([0, 1], {"tolerance": "a"}, "tolerance must be a number of 0 or more, not 'a'"),
        ([0, 1], {"tolerance": np.nan}, "tolerance must be a number of 0 or more, not nan"),
        ([0, 1], {"density": [1.0]}, "density must hold one real number for each of the"),
        ([0, 1], {"density": ["a"]}, "density must hold real numbers, not <U1"),
        (
            [0, 1],
            {"density": 1j * EVEN},
            "density must hold real numbers, not numbers of complex128",
        ),
        ([0, 1], {"density": 0 * EVEN}, "density is 0 at all vertices that have an area"),
        ([0, 1], {"density": -EVEN}, "density is -1.0 at vertex 0; it must be finite and not neg"),
        ([0, 1], {"density": np.where(EVEN.cumsum() == 4, np.nan, 1)}, "nan at vertex 3; it must"),
        ([0, 1], {"density": 1e300 * EVEN}, r"give density / density.max\(\)"),
        ([0, 1], {"density": 1e-320 * EVEN}, r"give density / density.max\(\)"),
        ([0, 1], {"rng": np.random.default_rng(0)}, "number of sites to draw, as rng is given"),
        (0, {"rng": np.random.default_rng(0)}, "between 1"),
    ],
)
def test_options_of_cells_outside_their_values_are_named(sites, options, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.centroidal_voronoi(PLATE, sites, **options)


def test_cells_need_faces_and_points():
    with pytest.raises(UnsupportedDomainError, match="faces"):
        gt.centroidal_voronoi(gt.GeodesicSolver(gt.Graph(2, [[0, 1]])), [0, 1])
    with pytest.raises(InvalidSourceError, match="points for sites"):
        gt.centroidal_voronoi(PLATE, gt.OffsetSources([0, 1], [0.0, 1.0]))


def test_progress_counts_steps():
    seen = []
    gt.centroidal_voronoi(PLATE, [0, 1, 2], steps=2, progress=lambda *at: seen.append(at))
    assert seen[0] == (1, 2)


def test_a_number_of_sites_needs_a_generator():
    solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(1))
    with pytest.raises(InvalidOptionError, match=r"give places, such as \[3\]"):
        gt.centroidal_voronoi(solver, 3)
