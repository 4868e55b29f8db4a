"""Are refined distances those of triangles with further vertices, and files those of polygons?"""

import pickle

import numpy as np
import pytest
from command_line import fails, run
from scipy.sparse import csr_array
from squares import Squares, SquaresLaplacian

import geodesic_toolkit as gt
from geodesic_toolkit.domains import polygons_of
from geodesic_toolkit.errors import (
    InvalidDiscretizationError,
    ReadError,
    UnsupportedDomainError,
)

LARGE, SMALL = Squares(20), Squares(5)

SWEPT = 2e-3
"""Error of fronts from places in faces, in the side of the square."""

MEETING = 0.02
"""The same where two fronts meet within triangles: on the diagonals alone it is 0.024."""


@pytest.fixture(autouse=True)
def plugins(register):
    register(gt.operators, "squares", SquaresLaplacian)


@pytest.fixture
def solver():
    return gt.GeodesicSolver(LARGE)


def test_fronts_cross_the_triangles_of_the_subdivision(solver):
    mesh = SquaresLaplacian().fans(LARGE).mesh
    assert solver.method.refine
    exact = gt.exact_distance(mesh, 5)[: LARGE.n_vertices]
    assert solver.distance(5) == pytest.approx(exact, abs=SWEPT)
    assert solver.distances([5, 7]).shape == (2, LARGE.n_vertices)


def test_small_parts_are_exact_on_the_subdivision():
    place = [0.33, 0.41, 0.0]
    exact = np.linalg.norm(SMALL.positions - place, axis=1)
    solver = gt.GeodesicSolver(SMALL)
    assert solver.distance(place) == pytest.approx(exact, abs=1e-12)
    assert "up to 1000 faces" in solver.diagnosis.reason


def test_sources_between_vertices_are_in_triangles_of_the_subdivision(solver):
    place = [0.33, 0.41, 0.0]
    exact = np.linalg.norm(LARGE.positions - place, axis=1)
    assert np.abs(solver.distance(place) - exact).max() < SWEPT
    both = gt.OffsetSources([place, [0.0, 0.0, 0.0]], [0.2, 0.0])
    first = np.minimum(exact + 0.2, np.linalg.norm(LARGE.positions, axis=1))
    assert np.abs(solver.distance(both) - first).max() < MEETING
    assert solver.distance(both)[0] == 0


def test_a_curve_keeps_its_front(solver):
    line = gt.Curve([[0.0, 0.32, 0.0], [1.0, 0.32, 0.0]])
    assert np.abs(solver.distance(line) - np.abs(LARGE.positions[:, 1] - 0.32)).max() < SWEPT


def test_paths_cross_the_triangles_of_the_subdivision(solver):
    path = gt.geodesic_path(solver, [0.33, 0.41, 0.0], 440)
    assert path.length == pytest.approx(np.hypot(0.67, 0.59), rel=1e-9)
    late = gt.geodesic_path(solver, gt.OffsetSources([0, 20], [3.0, 0.0]), 440)
    assert late.length == pytest.approx(1.0, rel=1e-9)


def test_a_solver_with_a_subdivision_comes_back_from_pickle(solver):
    assert np.array_equal(pickle.loads(pickle.dumps(solver)).distance(3), solver.distance(3))


def test_what_is_not_a_subdivision_is_refused():
    fans = SquaresLaplacian().fans(SMALL)
    other = SquaresLaplacian().fans(LARGE)
    with pytest.raises(InvalidDiscretizationError, match="as many vertices"):
        gt.Subdivision(fans.mesh, other.metric, fans.weights)
    with pytest.raises(InvalidDiscretizationError, match="further vertex 0 have the sum 2"):
        gt.Subdivision(fans.mesh, fans.metric, 2 * fans.weights)
    skew = fans.weights.toarray()
    skew[3, np.flatnonzero(skew[3])] = [0.5, 0.5, 0.5, -0.5]
    with pytest.raises(InvalidDiscretizationError, match="further vertex 3 must be positive"):
        gt.Subdivision(fans.mesh, fans.metric, csr_array(skew))
    flat = SquaresLaplacian().assemble(SMALL)
    with pytest.raises(InvalidDiscretizationError, match="subdivision is of 441 vertices, not of"):
        gt.Discretization(
            mass=flat.mass,
            stiffness=flat.stiffness,
            gradient=flat.gradient,
            spacing=flat.spacing,
            boundary=flat.boundary,
            subdivision=other,
        )


# -- files -----------------------------------------------------------------------------------------


def test_files_keep_polygons(tmp_path):
    path = tmp_path / "squares.ply"
    gt.write(path, SMALL, np.zeros(SMALL.n_vertices))
    vertices, sizes, corners = gt.read_polygons(path)
    assert np.array_equal(vertices, SMALL.positions)
    assert np.array_equal(corners.reshape(-1, 4), SMALL.corners)
    assert set(sizes.tolist()) == {4}


@pytest.mark.parametrize(
    ("polygons", "message"),
    [
        ((np.array([4]), np.array([0, 1, 2])), "as many corners"),
        ((np.array([4.0]), np.array([0, 1, 2, 3])), "two rows of int64"),
        ((np.array([0, 3]), np.array([0, 1, 2])), "positive sizes"),
        ((np.array([3]), np.array([0, 1, 99])), "corner 2 of .* is vertex 99; there are 36"),
    ],
)
def test_polygons_that_do_not_fit_are_refused(monkeypatch, polygons, message):
    monkeypatch.setattr(Squares, "polygons", polygons)
    with pytest.raises(UnsupportedDomainError, match=message):
        polygons_of(SMALL)


def test_a_kind_reads_files_that_another_reader_has(tmp_path):
    path = tmp_path / "squares.txt"
    path.write_text("3")
    assert isinstance(gt.read(path, kinds=SquaresLaplacian.domains), Squares)
    output = tmp_path / "distance.ply"
    run("distance", path, "--source", "0", "--operator", "squares", "--output", output)
    assert len(gt.read_polygons(output)[1]) == 9
    fails(run("distance", path, "--source", "0"), 3, "squares.txt")
    with pytest.raises(UnsupportedDomainError, match="not read from files"):
        gt.TriangleMesh.from_file(path)


FORMS = {
    "square.off": "OFF 4 1 0   0 0 0   1 0 0   1 1 0   0 1 0   4 0 1 2 3",
    "square.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    "square.ply": "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
}


@pytest.mark.parametrize("name", FORMS)
def test_polygons_are_read_unsplit(tmp_path, name):
    path = tmp_path / name
    path.write_text(FORMS[name])
    vertices, sizes, corners = gt.read_polygons(path)
    assert vertices.shape == (4, 3)
    assert (sizes.tolist(), corners.tolist()) == ([4], [0, 1, 2, 3])


def test_points_have_no_polygons_and_other_formats_are_named(tmp_path):
    points = tmp_path / "points.ply"
    gt.write(points, gt.PointCloud(np.eye(3)), np.zeros(3))
    assert len(gt.read_polygons(points)[1]) == 0
    other = tmp_path / "mesh.stl"
    other.write_text("solid")
    with pytest.raises(ReadError, match=r"polygons can be read from \.obj, \.off, \.ply files"):
        gt.read_polygons(other)
