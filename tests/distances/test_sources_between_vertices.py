"""Are distances from a source between vertices as accurate as from a vertex?"""

import dataclasses

import numpy as np
import pytest
from curved_shapes import irregular_plate, irregular_sphere
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDiscretizationError
from geodesic_toolkit.refinement.sight import missing_triangles
from geodesic_toolkit.testing import shapes

PLATE = irregular_plate(40)
SWEPT = 2e-5
"""Error in the unit square. Thin triangles are measured with edges a little longer."""

KINDS = ("mesh", "flipped mesh", "cloud")


@pytest.fixture(scope="module")
def solvers():
    flipped = gt.CotanLaplacian(intrinsic_delaunay=True)
    return {
        "mesh": gt.GeodesicSolver(PLATE, refine=True),
        "flipped mesh": gt.GeodesicSolver(PLATE, operator=flipped, refine=True),
        "cloud": gt.GeodesicSolver(gt.PointCloud(PLATE.vertices), refine=True),
    }


def straight(vertices, place):
    return np.linalg.norm(vertices - place, axis=1)


def weights_of(draw):
    """Weights in the face, near an edge and near a vertex, to less than rounding."""
    small = st.sampled_from([0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.02])
    first, second = draw(st.one_of(small, st.floats(0, 1))), draw(st.one_of(small, st.floats(0, 1)))
    rest = np.array([first * (1 - second), second, (1 - first) * (1 - second)])
    return draw(st.permutations(list(rest / rest.sum())))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_in_the_plane_all_distances_are_straight(solvers, kind, data):
    face = PLATE.faces[data.draw(st.integers(0, PLATE.n_faces - 1))]
    place = np.asarray(weights_of(data.draw)) @ PLATE.vertices[face]
    found = solvers[kind].distance(place)
    np.testing.assert_allclose(found, straight(PLATE.vertices, place), rtol=0, atol=SWEPT)


@pytest.mark.parametrize("shear", [3.0, 10.0])
def test_flips_do_not_hide_a_source_from_the_vertices_around_it(shear):
    mesh = shapes.grid(40, shear=shear)
    solver = gt.GeodesicSolver(mesh, refine=True)
    rng = np.random.default_rng(0)
    for face in rng.choice(mesh.n_faces, 10):
        place = gt.SurfacePoint(int(face), rng.dirichlet([0.5] * 3))
        at = np.asarray(place.barycentric) @ mesh.vertices[mesh.faces[face]]
        exact = straight(mesh.vertices, at)
        np.testing.assert_allclose(solver.distance(place), exact, rtol=0, atol=1e-4)


def test_on_spheres_errors_are_those_of_vertices():
    mesh = irregular_sphere(2000)
    for domain in (mesh, gt.PointCloud(mesh.vertices)):
        solver, rng = gt.GeodesicSolver(domain, refine=True), np.random.default_rng(1)
        errors = {"between": [], "at vertices": []}
        for face in rng.choice(mesh.n_faces, 30):
            place = rng.dirichlet([0.4] * 3) @ mesh.vertices[mesh.faces[face]]
            vertex = int(mesh.faces[face, 0])
            for kind, source, at in (
                ("between", place, place / np.linalg.norm(place)),
                ("at vertices", vertex, mesh.vertices[vertex]),
            ):
                exact = np.arccos(np.clip(mesh.vertices @ at, -1, 1))
                counted = (exact > 0.05) & (exact < 3.0)
                error = np.abs(solver.distance(source) - exact)[counted] / exact[counted]
                errors[kind].append(error.mean())
        assert np.mean(errors["between"]) < 1.1 * np.mean(errors["at vertices"])


def test_a_set_of_places_gives_the_nearest_of_them(solvers):
    solver, rng = solvers["mesh"], np.random.default_rng(2)
    places = np.column_stack([rng.random((6, 2)), np.zeros(6)])
    each = np.array([straight(PLATE.vertices, place) for place in places])
    np.testing.assert_allclose(solver.distance(places), each.min(axis=0), rtol=0, atol=SWEPT)


@pytest.mark.parametrize("between", [False, True])
def test_offsets_do_not_change_the_shape_of_fronts(solvers, between):
    # A front about a source with an offset was a circle of the wrong radius, half an edge off.
    rng = np.random.default_rng(3)
    for _ in range(5):
        vertex = int(rng.integers(len(PLATE.vertices)))
        place = np.array([*rng.uniform(0.1, 0.9, 2), 0.0])
        source, at = ([place], place) if between else ([vertex], PLATE.vertices[vertex])
        late = solvers["mesh"].distance(gt.OffsetSources(source, [0.3]))
        np.testing.assert_allclose(late - 0.3, straight(PLATE.vertices, at), rtol=0, atol=SWEPT)


def test_of_sources_with_offsets_the_earliest_front_counts(solvers):
    rng = np.random.default_rng(4)
    places, offsets = np.column_stack([rng.random((5, 2)), np.zeros(5)]), rng.random(5) / 5
    found = solvers["mesh"].distance(gt.OffsetSources(places, offsets))
    each = np.array([straight(PLATE.vertices, place) for place in places])
    exact = (each + offsets[:, None]).min(axis=0)
    assert np.abs(found - exact).mean() < 1e-4
    assert np.abs(found - exact).max() < 0.2 / 40  # beside the lines at which fronts meet


def test_a_face_of_both_sides_and_an_edge_of_three_faces_are_seen_through():
    square = shapes.grid(9)
    both = gt.TriangleMesh(square.vertices, [*square.faces, *square.faces[:, ::-1]])
    flap = np.vstack([square.vertices, [[0.5, 0.5, 1.0]]])
    middle = np.flatnonzero((square.vertices == [0.5, 0.5, 0]).all(axis=1))[0]
    three = gt.TriangleMesh(flap, [*square.faces, [middle, middle + 1, 81]])
    place = [0.51, 0.501, 0.0]
    for mesh in (both, three):
        found = gt.GeodesicSolver(mesh, refine=True).distance([place])[:81]
        np.testing.assert_allclose(found, straight(square.vertices, place), rtol=0, atol=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_distances_from_a_place_are_symmetric(solvers, kind):
    solver = solvers[kind]
    one, other = [0.313, 0.422, 0.0], [0.711, 0.604, 0.0]
    there, back = solver.query(other, [one])[0], solver.query(one, [other])[0]
    assert there == pytest.approx(np.linalg.norm(np.subtract(one, other)), abs=1e-3)
    assert there == pytest.approx(back, abs=1e-3)


# -- clouds ----------------------------------------------------------------------------------------


def test_a_place_on_a_cloud_lies_in_a_triangle_of_its_stars(solvers):
    located = solvers["cloud"].locate([[0.313, 0.422, 0.01]])
    assert located.shares.sum() == pytest.approx(1.0)
    assert len(located.vertices) == 3
    foot = located.shares @ PLATE.vertices[located.vertices]
    np.testing.assert_allclose(foot, [0.313, 0.422, 0.0], atol=1e-12)


def test_a_place_at_a_point_of_a_cloud_is_that_point(solvers):
    located = solvers["cloud"].locate(PLATE.vertices[[7, 805]])
    assert located.are_vertices
    assert located.vertices.tolist() == [7, 805]


def test_a_place_between_two_points_of_a_chain_lies_on_their_link():
    line = np.column_stack([np.arange(12.0), np.zeros((12, 2))])
    solver = gt.GeodesicSolver(gt.PointCloud(line))
    located = solver.locate([[4.25, 0.0, 0.0]])
    assert sorted(located.vertices.tolist()) == [4, 5]
    found = solver.distance([[4.25, 0.0, 0.0]])
    np.testing.assert_allclose(found, np.abs(line[:, 0] - 4.25), rtol=0, atol=1e-6)


def test_a_place_beyond_the_rim_of_a_cloud_goes_to_the_rim(solvers):
    located = solvers["cloud"].locate([[-0.3, 0.4, 0.0]])
    foot = located.shares @ PLATE.vertices[located.vertices]
    np.testing.assert_allclose(foot, [0.0, 0.4, 0.0], atol=1e-9)


def test_masked_points_take_no_part_in_places():
    mask = straight(PLATE.vertices, [0.5, 0.5, 0.0]) < 0.2
    solver = gt.GeodesicSolver(gt.PointCloud(PLATE.vertices), mask=mask)
    located = solver.locate([[0.5, 0.5, 0.0]])
    assert not mask[located.vertices].any()


def test_clouds_of_one_and_two_points_have_places():
    assert gt.geodesic_distance(gt.PointCloud([[1, 2, 3.0]]), [[1, 2, 3.0]]).tolist() == [0]
    two = gt.GeodesicSolver(gt.PointCloud([[0, 0, 0.0], [1, 0, 0]]))
    found = two.distance([[0.25, 0.5, 0.0]])
    np.testing.assert_allclose(found, [0.25, 0.75], atol=1e-9)


# -- parts -----------------------------------------------------------------------------------------


def test_triangles_are_compared_as_sets_of_vertices():
    some = np.array([[0, 1, 2], [2, 1, 3], [5, 4, 3], [0, 1, 2]])
    others = np.array([[1, 2, 0], [6, 7, 8]])
    assert missing_triangles(some, others).tolist() == [[1, 2, 3], [3, 4, 5]]
    assert missing_triangles(some, some).shape == (0, 3)


def test_unflipped_triangles_are_triangles_of_the_same_vertices(solvers):
    metric = solvers["flipped mesh"].method.metric
    assert metric.unflipped.elements.shape == PLATE.faces.shape
    wrong = gt.CotanLaplacian().assemble(shapes.grid(3)).gradient
    with pytest.raises(InvalidDiscretizationError, match="unflipped must be triangles"):
        dataclasses.replace(metric, unflipped=wrong)
