"""Does it hold on the shapes that it is for, and refuse by name what it cannot take?"""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit_robust import RobustLaplacian

LOOSE = 0.05
"""Mean relative error on coarse shapes."""


def fan(pages=5, n=17):
    """Flat pages on one spine, an edge of which has as many faces as there are pages."""
    page = gt.testing.shapes.grid(n)
    spine = np.flatnonzero(page.vertices[:, 0] == 0)
    vertices, faces, count = [page.vertices[spine]], [], len(spine)
    rest = np.setdiff1d(np.arange(page.n_vertices), spine)
    for k in range(pages):
        angle = 2 * np.pi * k / pages
        x, y, _ = page.vertices[rest].T
        vertices.append(np.column_stack([x * np.cos(angle), y, x * np.sin(angle)]))
        number = np.empty(page.n_vertices, dtype=np.int64)
        number[spine], number[rest] = np.arange(len(spine)), count + np.arange(len(rest))
        count += len(rest)
        faces.append(number[page.faces])
    return gt.TriangleMesh(np.concatenate(vertices), np.concatenate(faces))


@pytest.mark.parametrize("options", [{"operator": "robust"}, {"diffusion": "robust"}])
def test_on_a_non_manifold_fan_of_pages_the_heat_is_positive_and_the_distance_right(options):
    mesh = fan()
    middle = int(np.abs(mesh.vertices - [0.5, 0.5, 0.0]).sum(axis=1).argmin())
    solver = gt.GeodesicSolver(mesh, **options)
    assert solver.diagnosis.non_manifold_edges == 16
    assert solver.diagnosis.non_positive == 0
    x, y, z = mesh.vertices.T
    same_page = (z == 0) & (x >= 0)
    across = np.where(same_page, x - 0.5, np.hypot(x, z) + 0.5)  # unfolded about the spine
    exact = np.hypot(across, y - 0.5)
    distance = solver.distance(middle)
    away = exact > 0
    assert np.mean(np.abs(distance[away] / exact[away] - 1)) < LOOSE


def test_heat_is_positive_where_the_cotangent_laplacian_turns_it_negative():
    slivers = gt.testing.shapes.grid(30, shear=6.0)
    plain = gt.GeodesicSolver(slivers, operator="cotan")
    cured = gt.GeodesicSolver(slivers, operator="cotan", diffusion="robust")
    assert plain.diagnosis.non_positive > 100
    assert cured.diagnosis.non_positive == 0


def test_no_weight_is_negative_and_what_was_clipped_is_rounding():
    discretization = RobustLaplacian().assemble(gt.testing.shapes.grid(30, shear=6.0))
    assert discretization.gradient.weights.min() >= 0
    assert 0 <= discretization.notes["clipped_weight"] < 1e-6


def test_the_boundary_is_that_of_the_mesh():
    discretization = RobustLaplacian().assemble(gt.testing.shapes.grid(4))
    assert np.flatnonzero(~discretization.boundary).tolist() == [5, 6, 9, 10]


def test_an_unreferenced_vertex_weighs_nothing_and_is_infinitely_far():
    ball = gt.testing.shapes.icosphere(2)
    mesh = gt.TriangleMesh(np.concatenate([[[9, 9, 9]], ball.vertices]), ball.faces + 1)
    solver = gt.GeodesicSolver(mesh, operator="robust")
    assert solver.method.metric.mass[0] == 0
    distance = solver.distance(1)
    assert distance[0] == np.inf
    np.testing.assert_allclose(
        distance[1:], gt.geodesic_distance(ball, 0, operator="robust"), atol=1e-12
    )


def test_a_missing_point_is_infinitely_far_and_changes_no_other():
    points = gt.testing.shapes.icosphere(2).vertices
    with_hole = gt.PointCloud(np.concatenate([[[np.nan] * 3], points]))
    distance = gt.geodesic_distance(with_hole, 1, operator="robust")
    assert distance[0] == np.inf
    alone = gt.geodesic_distance(gt.PointCloud(points), 0, operator="robust")
    np.testing.assert_allclose(distance[1:], alone, atol=1e-12)


def test_duplicate_points_have_distance_zero():
    points = gt.testing.shapes.icosphere(3).vertices
    twice = gt.PointCloud(np.concatenate([points, points[:100]]))
    distance = gt.geodesic_distance(twice, 0, operator="robust")
    assert np.isfinite(distance).all()
    np.testing.assert_allclose(distance[len(points) :], distance[:100], atol=0.01)


def test_a_cloud_far_from_the_origin_is_the_same_cloud():
    (samples,) = gt.testing.samples_of([gt.PointCloud])
    points = samples.generic.points
    there = gt.geodesic_distance(gt.PointCloud(points + 1000.0), 0, operator="robust")
    here = gt.geodesic_distance(gt.PointCloud(points), 0, operator="robust")
    np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-6)


def test_a_degenerate_face_among_good_ones_does_no_harm():
    ball = gt.testing.shapes.icosphere(2)
    faces = np.concatenate([ball.faces, [[0, 0, 1], [5, 5, 5]]])
    distance = gt.geodesic_distance(gt.TriangleMesh(ball.vertices, faces), 0, operator="robust")
    np.testing.assert_allclose(
        distance, gt.geodesic_distance(ball, 0, operator="robust"), atol=1e-12
    )


@pytest.mark.parametrize(
    "options", [{"mollify_factor": -1}, {"mollify_factor": np.nan}, {"n_neighbors": 2}]
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(InvalidOptionError, match=next(iter(options))):
        RobustLaplacian(**options)


def test_a_mesh_that_is_one_place_is_refused():
    with pytest.raises(UnsupportedDomainError, match="at one position"):
        RobustLaplacian().assemble(gt.TriangleMesh(np.ones((3, 3)), [[0, 1, 2]]))


def test_a_cloud_of_three_points_is_refused():
    with pytest.raises(UnsupportedDomainError, match="has 3 points"):
        RobustLaplacian().assemble(gt.PointCloud(np.eye(3)))


def test_points_on_a_line_are_refused():
    line = gt.PointCloud(np.linspace(0, 1, 40)[:, None] * [1.0, 2.0, 3.0])
    with pytest.raises(UnsupportedDomainError, match="on one line"):
        RobustLaplacian().assemble(line)


def test_triangles_too_thin_for_the_library_are_refused():
    needle = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(UnsupportedDomainError, match="not finite"):
        RobustLaplacian(mollify_factor=0).assemble(needle)


def test_a_graph_is_refused():
    with pytest.raises(UnsupportedDomainError, match="not Graph"):
        RobustLaplacian().assemble(gt.Graph(2, [[0, 1]]))
