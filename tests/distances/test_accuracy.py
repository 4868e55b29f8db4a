"""Errors against exact polyhedral distances, on real and on generated meshes."""

import numpy as np
import pytest
from closed_forms import mean_relative_error, on_plane
from sample_shapes import hull

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidSourceError, SolverError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

# Mean relative error of plain heat in per cent, as measured (source 500, source 2000), and how
# much worse it may become.
MEASURED = {
    "igltut__bunny.off": (2.56, 1.84),
    "jacobson__spot.obj": (1.99, 1.87),
    "odedstein__koala_low_resolution.obj": (1.36, 1.76),
    "igltut__3holes.off": (2.18, 1.78),
}
SLACK = 1.03


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_plain_heat_is_as_accurate_as_measured(shared_data, name):
    mesh = gt.read(shared_data(name))
    solver = gt.GeodesicSolver(mesh, refine=False)
    for source, measured in zip((500, 2000), MEASURED[name], strict=True):
        error = mean_relative_error(solver.distance(source), gt.exact_distance(mesh, source))
        assert 100 * error < SLACK * measured


IRREGULAR = {0: (0.114, 2.47), 500: (0.084, 2.87), 1300: (0.069, 2.75), 2000: (0.078, 2.61)}
"""Mean relative errors in per cent by source, as measured: refined, and of plain heat."""


@pytest.mark.parametrize("source", IRREGULAR)
def test_an_irregular_closed_surface_is_as_accurate_as_measured_refined_and_not(source):
    mesh = shapes.bumpy_torus(rng=np.random.default_rng(0))
    exact = gt.exact_distance(mesh, source)
    for refine, measured in zip((True, False), IRREGULAR[source], strict=True):
        distance = gt.geodesic_distance(mesh, source, refine=refine)
        assert 100 * mean_relative_error(distance, exact) < SLACK * measured


@pytest.mark.parametrize(("source", "zeros"), [(2000, 1714), (500, 1176)])
def test_conjugate_gradients_leave_zeros_that_a_direct_solver_does_not(shared_data, source, zeros):
    mesh = gt.read(shared_data("igltut__bunny.off"))
    loose = gt.CG(rtol=1e-5, allow_heat=True)
    iterative = gt.GeodesicSolver(mesh, solver={"heat": loose, "poisson": "superlu"})
    assert (iterative.heat(source) == 0).sum() == zeros
    assert (gt.GeodesicSolver(mesh).heat(source) != 0).all()


@pytest.mark.slow
def test_obtuse_scans_profit_from_auto(shared_data):
    mesh = gt.read(shared_data("igltut__camelhead.off"))
    exact = gt.exact_distance(mesh, 5690)
    auto, plain = (
        mean_relative_error(gt.geodesic_distance(mesh, 5690, operator=each, refine=False), exact)
        for each in ("auto", "cotan")
    )
    assert auto < 0.6 * plain


def test_exact_distance_on_a_plane_is_euclidean():
    mesh = shapes.grid(12)
    np.testing.assert_allclose(gt.exact_distance(mesh, 40), on_plane(mesh, 40), atol=1e-12)


def test_exact_distance_takes_several_sources_and_says_inf():
    mesh = shapes.disjoint_union(shapes.grid(5), shapes.grid(4))
    distance = gt.exact_distance(mesh, [0, 24])
    one_by_one = np.minimum(gt.exact_distance(mesh, 0), gt.exact_distance(mesh, 24))
    np.testing.assert_allclose(distance, one_by_one, atol=1e-12)
    assert (distance[25:] == np.inf).all()
    lonely = gt.TriangleMesh(np.vstack([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    alone = gt.exact_distance(lonely, lonely.n_vertices - 1)
    assert alone[-1] == 0
    assert (alone[:-1] == np.inf).all()


def test_exact_distance_starts_anywhere_on_the_surface():
    mesh = shapes.grid(9)
    # In a face; on an edge; by itself on the line to another in the same face; at a vertex.
    places = np.array(
        [[0.31, 0.2, 0], [0.25, 0.3, 0], [0.32, 0.21, 0], [0.33, 0.22, 0], [0.5, 0.5, 0]]
    )
    for sources in (*places, places):
        straight = np.linalg.norm(mesh.vertices - np.reshape(sources, (-1, 1, 3)), axis=2)
        np.testing.assert_allclose(
            gt.exact_distance(mesh, sources), straight.min(axis=0), atol=1e-7
        )


def test_exact_distance_from_a_point_is_that_from_the_vertex_it_becomes():
    mesh = shapes.icosphere(2)
    point = gt.SurfacePoint(5, (0.2, 0.3, 0.5))
    a, b, c = mesh.faces[5]
    place = point.barycentric @ mesh.vertices[mesh.faces[5]]
    faces = np.vstack([np.delete(mesh.faces, 5, axis=0), [[a, b, 162], [b, c, 162], [c, a, 162]]])
    split = gt.TriangleMesh(np.vstack([mesh.vertices, place]), faces)
    expected = gt.exact_distance(split, 162)[:162]
    np.testing.assert_allclose(gt.exact_distance(mesh, point), expected, atol=1e-9)
    both = gt.exact_distance(mesh, [point, gt.SurfacePoint(80, (1.0, 0.0, 0.0))])
    other = gt.exact_distance(mesh, int(mesh.faces[80, 0]))
    np.testing.assert_allclose(both, np.minimum(expected, other), atol=1e-9)


def test_exact_distance_is_a_metric():
    mesh = shapes.torus(20, 8)
    sources = [0, 33, 71]
    rows = np.array([gt.exact_distance(mesh, source) for source in sources])
    between = rows[:, sources]
    np.testing.assert_allclose(between, between.T, atol=1e-9)
    assert (rows[0] <= between[0, 1] + rows[1] + 1e-9).all()


def fan(start, turn, spokes=4):
    """Vertices on an arc of radius 1 about the origin, each at its angle."""
    angles = start + turn * np.linspace(0, 1, spokes)
    return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(spokes)])


def glued(mesh, *pairs):
    """Return the mesh with the second vertex of each pair made the first."""
    numbers = np.arange(mesh.n_vertices)
    for first, second in pairs:
        np.testing.assert_array_equal(mesh.vertices[first], mesh.vertices[second])
        numbers[second] = first
    return gt.TriangleMesh(mesh.vertices, numbers[mesh.faces])


def test_exact_distance_passes_through_the_knot_of_a_bow_tie():
    right, left = fan(-0.6, 1.2), fan(np.pi - 0.6, 1.2)
    faces = [[0, i, i + 1] for i in (1, 2, 3, 5, 6, 7)]
    faces[4] = faces[4][::-1]  # turned over: the knot does not mind
    tie = gt.TriangleMesh(np.vstack([np.zeros((1, 3)), right, left]), faces)
    on_right = np.linalg.norm(tie.vertices - right[1], axis=1)
    expected = np.concatenate([[1.0], on_right[1:5], np.full(4, 2.0)])
    np.testing.assert_allclose(gt.exact_distance(tie, 2), expected, atol=1e-12)
    np.testing.assert_allclose(gt.exact_distance(tie, 0), [0] + 8 * [1.0], atol=1e-12)
    inside = gt.exact_distance(tie, gt.SurfacePoint(0, (0.5, 0.25, 0.25)))
    np.testing.assert_allclose(inside[5:], inside[0] + 1, atol=1e-12)


def test_exact_distance_takes_the_nearer_of_two_knots_and_goes_on_from_it():
    # Two flat squares, one upon the other, joined at two corners; a third hangs on the second's.
    mesh = shapes.disjoint_union(*[shapes.grid(5)] * 3)
    mesh = glued(mesh, (4, 29), (20, 45), (49, 74))
    square, source = shapes.grid(5).vertices, 13
    first, second = (np.linalg.norm(square - square[corner], axis=1) for corner in (4, 20))
    own = np.linalg.norm(square - square[source], axis=1)
    beyond = np.minimum(own[4] + first, own[20] + second)
    last = beyond[24] + np.linalg.norm(square - square[24], axis=1)
    expected = np.concatenate([own, beyond, last])
    found = gt.exact_distance(mesh, source)
    used = np.isin(np.arange(75), mesh.faces)
    np.testing.assert_allclose(found[used], expected[used], atol=1e-9)
    assert (found[~used] == np.inf).all()


def test_exact_distance_between_two_balls_that_touch():
    ball = shapes.icosphere(2)
    moved = ball.vertices - 2 * ball.vertices[7]
    touching = int(np.linalg.norm(moved + ball.vertices[7], axis=1).argmax())  # the antipode
    other = gt.TriangleMesh(moved - (moved[touching] - ball.vertices[7]), ball.faces)
    both = shapes.disjoint_union(ball, other)
    vertices = np.array(both.vertices)
    vertices[162 + touching] = vertices[7]
    both = glued(gt.TriangleMesh(vertices, both.faces), (7, 162 + touching))
    found = gt.exact_distance(both, 100)
    alone = gt.exact_distance(ball, 100)
    np.testing.assert_allclose(found[:162], alone, atol=1e-9)
    beyond = np.delete(alone[7] + gt.exact_distance(ball, touching), touching)
    np.testing.assert_allclose(np.delete(found[162:], touching), beyond, atol=1e-6)


@pytest.mark.parametrize("name", ["jacobson__cow.obj", "meshlab__non_manif_hole.ply"])
def test_exact_distance_on_models_whose_sheets_meet_in_vertices(shared_data, name):
    mesh = gt.read(shared_data(name))
    source, target = mesh.n_vertices // 2, 3
    there, back = gt.exact_distance(mesh, source), gt.exact_distance(mesh, target)
    assert there[target] == pytest.approx(back[source], rel=1e-6)
    delaunay = gt.CotanLaplacian(intrinsic_delaunay=True)
    refined = gt.geodesic_distance(mesh, source, operator=delaunay, refine=True)
    assert mean_relative_error(refined, there) < 0.01


def test_exact_distance_crosses_edges_of_three_faces():
    # Three pages about a spine from (0, 0, 0) to (0, 0, 1): what is on another page is unfolded.
    vertices = [[0, 0, 0], [0, 0, 1], [1, 0, 0.5], [0, 2, 0.5], [-3, 0, 0.5]]
    book = gt.TriangleMesh(vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    edge = np.hypot(1, 0.5)
    np.testing.assert_allclose(gt.exact_distance(book, 2), [edge, edge, 0, 3, 4], atol=1e-12)


def test_exact_distance_is_that_of_libigl_on_hulls_of_random_points():
    igl = pytest.importorskip("igl")
    rng = np.random.default_rng(0)
    nothing = np.zeros(0, dtype=np.int64)
    for count in (4, 5, 9, 30, 200):
        mesh = hull(rng.normal(size=(count, 3)) * [1, 2, 3])
        sources = rng.choice(mesh.n_vertices, 2, replace=False)
        everywhere = np.arange(mesh.n_vertices)
        expected = igl.exact_geodesic(
            mesh.vertices, mesh.faces, sources, nothing, everywhere, nothing
        )
        np.testing.assert_allclose(gt.exact_distance(mesh, sources), expected, atol=1e-12)


def test_exact_distance_begins_with_offsets():
    mesh = shapes.torus(20, 8)
    one, other = gt.exact_distance(mesh, 3), gt.exact_distance(mesh, 70)
    expected = np.minimum(one + 0.5, other)
    found = gt.exact_distance(mesh, gt.OffsetSources([3, 70], [0.5, 0.0]))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_exact_distance_takes_vertices_at_one_place_and_faces_without_area():
    square = shapes.grid(4)
    source, doubled = 5, 10
    vertices = np.vstack([square.vertices, square.vertices[doubled]])
    # A slit along an edge, closed by two faces without area that share its ends.
    across = np.isin(square.faces, [doubled]).any(axis=1)
    right = across & (square.vertices[square.faces].mean(axis=1)[:, 0] > vertices[doubled, 0])
    faces = np.array(square.faces)
    faces[right] = np.where(faces[right] == doubled, 16, faces[right])
    above, below = 6, 14
    assert {above, below} <= set(faces[right].ravel())
    mesh = gt.TriangleMesh(vertices, [*faces, [doubled, 16, above], [16, doubled, below]])
    np.testing.assert_allclose(gt.exact_distance(mesh, source), on_plane(mesh, source), atol=1e-12)


@pytest.mark.parametrize("unit", [1e-100, 1e-9, 1e9, 1e100])
def test_exact_distance_has_any_unit(unit):
    mesh = shapes.torus(12, 6)
    point = gt.SurfacePoint(5, (0.2, 0.3, 0.5))
    scaled = gt.TriangleMesh(unit * mesh.vertices, mesh.faces)
    np.testing.assert_allclose(
        gt.exact_distance(scaled, point), unit * gt.exact_distance(mesh, point), rtol=1e-9
    )


def test_exact_distance_gives_a_search_up_that_does_not_end(monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.exact.MOST_WINDOWS", 1)
    with pytest.raises(SolverError, match="not found with 1280 windows; refine=True"):
        gt.exact_distance(shapes.icosphere(3), 0)


def test_exact_distance_refuses_what_it_cannot_measure():
    with pytest.raises(UnsupportedDomainError, match="not a Graph"):
        gt.exact_distance(gt.Graph(2, [[0, 1]]), 0)
    with pytest.raises(InvalidSourceError):
        gt.exact_distance(shapes.grid(3), 9)
    with pytest.raises(InvalidSourceError, match="lies on face 8; there are 8"):
        gt.exact_distance(shapes.grid(3), gt.SurfacePoint(8, (1.0, 0.0, 0.0)))
    with pytest.raises(InvalidSourceError, match="not from a Curve; give points along it"):
        gt.exact_distance(shapes.grid(3), gt.Curve([[0, 0, 0], [1, 0, 0]]))
