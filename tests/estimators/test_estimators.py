"""Estimators: distances, neighbours and embeddings that are right, also of new samples."""

import pickle
import re

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.datasets import make_swiss_roll
from sklearn.exceptions import NotFittedError
from sklearn.manifold import Isomap
from sklearn.neighbors import KNeighborsTransformer, RadiusNeighborsTransformer

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    FragmentedCloudWarning,
    InvalidDomainError,
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.sklearn import GeodesicDistances, GeodesicIsomap, GeodesicNeighbors
from geodesic_toolkit.testing import shapes

NEAR_EXACT = 0.01
"""Mean error over the mean distance on a roll of 1,200 samples: 0.004 was measured, also of new
samples; along the edges of the same graph it is 0.03."""

SIDE = np.arange(12.0)
GRID = np.stack(np.meshgrid(SIDE, SIDE, indexing="ij"), axis=-1).reshape(-1, 2)
GRID = GRID + 0.2 * np.random.default_rng(0).uniform(-1, 1, GRID.shape)
"""Samples of a square, where geodesics are straight lines."""

PARTS = np.concatenate([GRID, GRID + 100.0])


def roll(count, seed):
    """Samples of a roll, and their places in the rectangle that was rolled up."""
    samples, angle = make_swiss_roll(count, random_state=seed)
    along = (angle * np.sqrt(1 + angle**2) + np.arcsinh(angle)) / 2
    return samples, np.column_stack([along, samples[:, 1]])


@pytest.fixture(scope="module")
def rolls():
    return roll(1200, 0), roll(200, 1)


def straight(places, others):
    return np.linalg.norm(places[:, None] - others, axis=2)


def error(found, truth):
    return np.abs(found - truth).sum() / truth.sum()


def error_of_embedding(found, flat):
    one, other = found - found.mean(axis=0), flat - flat.mean(axis=0)
    left, _, right = np.linalg.svd(one.T @ other)
    return np.linalg.norm(one @ left @ right - other) / np.linalg.norm(other)


# -- distances to landmarks ------------------------------------------------------------------------


@pytest.mark.slow
def test_distances_on_a_roll_are_those_of_the_rectangle(rolls):
    (samples, flat), (new, new_flat) = rolls
    model = GeodesicDistances(landmarks=30)
    found = model.fit_transform(samples)
    assert found.shape == (1200, 30)
    assert error(found, straight(flat, flat[model.landmarks_])) < NEAR_EXACT
    assert error(model.transform(new), straight(new_flat, flat[model.landmarks_])) < NEAR_EXACT


def test_a_sample_of_fit_gets_its_own_distances_again(rolls):
    (samples, _), _ = rolls
    model = GeodesicDistances(landmarks=5)
    np.testing.assert_allclose(model.fit_transform(samples), model.transform(samples), rtol=1e-9)
    wide = np.random.default_rng(0).normal(size=(60, 40))  # neighbours by matrix products
    np.testing.assert_allclose(model.fit_transform(wide), model.transform(wide), atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("operator", ["uniform", "pointcloud", gt.PointCloudLaplacian()])
def test_an_operator_makes_the_kind_of_domain_that_it_takes(operator):
    sheet = np.column_stack([GRID, np.zeros(len(GRID))])
    model = GeodesicDistances([0, 5], operator=operator).fit(sheet)
    kind = gt.Graph if operator == "uniform" else gt.PointCloud
    assert type(model.domain_) is kind
    assert error(model.distances_, straight(GRID[[0, 5]], GRID)) < 0.02


def test_operators_of_shapes_that_samples_alone_do_not_make_are_refused():
    with pytest.raises(
        UnsupportedDomainError, match="a TriangleMesh, which operator='cotan' takes"
    ):
        GeodesicDistances(operator="cotan").fit(GRID)
    with pytest.raises(InvalidOptionError, match="metric='manhattan' is that of the graph"):
        GeodesicDistances(operator="pointcloud", metric="manhattan").fit(PARTS)


def test_landmarks_are_all_samples_up_to_a_number_and_then_the_farthest():
    square = GeodesicDistances(landmarks="all").fit(GRID)
    np.testing.assert_array_equal(square.landmarks_, np.arange(144))
    assert len(GeodesicDistances().fit(GRID[:60]).landmarks_) == 60
    some = GeodesicDistances().fit(GRID)
    expected = gt.farthest_point_sampling(some.solver_, 100)
    np.testing.assert_array_equal(some.landmarks_, expected)
    np.testing.assert_array_equal(some.distances_, some.solver_.distances(expected))


@pytest.mark.parametrize("refine", [False, "across", True])
def test_the_matrix_of_all_samples_is_symmetric_unless_that_is_declined(refine):
    square = GeodesicDistances(landmarks="all", refine=refine).fit_transform(GRID)
    np.testing.assert_array_equal(square, square.T)
    raw = GeodesicDistances(landmarks="all", refine=refine, symmetrize=None).fit(GRID)
    np.testing.assert_array_equal(raw.distances_, raw.solver_.distances(np.arange(144)))


@pytest.mark.slow
def test_samples_that_nothing_connects_are_infinitely_far_unless_a_fill_is_given():
    model = GeodesicDistances([0]).fit(PARTS)
    other = np.arange(288) >= 144
    np.testing.assert_array_equal(np.isinf(model.transform(PARTS)[:, 0]), other)
    filled = GeodesicDistances([0], fill=-1).fit_transform(PARTS)
    np.testing.assert_array_equal(filled[:, 0] == -1, other)
    between = np.array([[50.0, 50.0]])  # neighbours of both parts
    near = GeodesicDistances([0], n_neighbors=200).fit(PARTS).transform(between)
    assert np.isfinite(near).all()


def test_a_new_sample_between_two_components_keeps_to_the_nearer():
    pair = np.concatenate([GRID[:4], GRID[:4] + np.array([30.0, 0.0])])
    model = GeodesicDistances([0, 4], n_neighbors=3).fit(pair)
    found = model.transform([[14.0, 1.0]])
    assert np.isfinite(found[0, 0])
    assert np.isinf(found[0, 1])


def test_other_metrics_and_identical_samples(rolls):
    twice = np.repeat(GRID, 2, axis=0)
    model = GeodesicDistances([0], n_neighbors=16).fit(twice)
    np.testing.assert_array_equal(model.distances_[0, ::2], model.distances_[0, 1::2])
    manhattan = GeodesicDistances([0], metric="manhattan", refine=True).fit(GRID)
    apart = np.abs(GRID - GRID[0]).sum(axis=1)
    assert error(manhattan.distances_[0], apart) < 0.05
    new = manhattan.transform(GRID[[3]] + 0.1)[0, 0]
    assert new == pytest.approx(apart[3] + 0.2, abs=0.3)


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"landmarks": 0}, InvalidOptionError, "landmarks must be 1 or more, not 0"),
        (
            {"landmarks": 145},
            InvalidOptionError,
            "landmarks must be 144 or less, not 145: there are 144 samples",
        ),
        ({"landmarks": 2.5}, InvalidOptionError, "landmarks must be an integer, not 2.5"),
        ({"landmarks": True}, InvalidOptionError, "landmarks must be an integer, not True"),
        ({"landmarks": "some"}, InvalidOptionError, 'must be "auto", "all", .* not \'some\''),
        ({"landmarks": [144]}, InvalidSourceError, "landmarks: vertex 144 does not exist"),
        ({"fill": "inf"}, InvalidOptionError, "fill must be a number or None, not 'inf'"),
        ({"symmetrize": "median"}, InvalidOptionError, "median"),
        ({"n_neighbors": 144}, InvalidOptionError, "n_neighbors must be 143 or less, not 144"),
        ({"n_neighbors": "5"}, InvalidOptionError, "n_neighbors must be an integer, not '5'"),
        ({"metric": "no"}, ValueError, "metric"),
    ],
)
def test_an_option_outside_its_values_is_refused(options, kind, message):
    with pytest.raises(kind, match=message):
        GeodesicDistances(**options).fit(GRID)


# -- shapes ----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_vertices_of_a_shape_are_samples():
    sphere = shapes.icosphere(2)
    model = GeodesicDistances(landmarks=[0, 3])
    found = model.fit_transform(sphere)
    np.testing.assert_array_equal(found.T, gt.GeodesicSolver(sphere).distances([0, 3]))
    np.testing.assert_array_equal(model.transform(sphere), found)
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.transform(sphere), found)
    with pytest.raises(InvalidOptionError, match=r"was fitted on a TriangleMesh, .* solver_.query"):
        model.transform(np.zeros((1, 3)))
    graph = GeodesicNeighbors(n_neighbors=5).fit(sphere)
    near = graph.kneighbors(return_distance=False)
    np.testing.assert_array_equal(graph.kneighbors_graph(sphere, 1).indices, np.arange(162))
    edges = {tuple(edge) for edge in sphere.as_graph().edges.tolist()}
    assert all(tuple(sorted((own, int(other)))) in edges for own, other in enumerate(near[:, 0]))
    assert GeodesicIsomap(n_components=3).fit(sphere).transform(sphere).shape == (162, 3)


# -- neighbours ------------------------------------------------------------------------------------


def by_hand(matrix, count):
    order = np.argsort(matrix, axis=1, kind="stable")[:, :count]
    return np.take_along_axis(matrix, order, axis=1), order


@pytest.mark.slow
def test_the_nearest_samples_are_those_of_all_distances():
    model = GeodesicNeighbors(n_neighbors=4).fit(GRID)
    matrix = model.solver_.distances(np.arange(144))
    far, near = model.kneighbors(GRID)
    expected_far, expected = by_hand(matrix, 4)
    np.testing.assert_array_equal(far, expected_far)
    np.testing.assert_array_equal(near, expected)
    np.fill_diagonal(matrix, np.inf)
    far, near = model.kneighbors(n_neighbors=7)
    np.testing.assert_array_equal(far, by_hand(matrix, 7)[0])
    np.testing.assert_array_equal(near, by_hand(matrix, 7)[1])
    np.testing.assert_array_equal(model.kneighbors(n_neighbors=7, return_distance=False), near)
    distances, indices = model.radius_neighbors(radius=1.5)
    for row, some, chosen in zip(matrix, distances, indices, strict=True):
        np.testing.assert_array_equal(chosen, np.flatnonzero(row <= 1.5))
        np.testing.assert_array_equal(some, row[chosen])
    only = model.radius_neighbors(radius=1.5, return_distance=False)
    np.testing.assert_array_equal(only[3], indices[3])


@pytest.mark.parametrize("mode", ["distance", "connectivity"])
def test_graphs_have_the_form_of_those_of_scikit_learn(mode):
    ours = GeodesicNeighbors(n_neighbors=4, mode=mode).fit_transform(GRID)
    theirs = KNeighborsTransformer(n_neighbors=4, mode=mode).fit_transform(GRID)
    assert type(ours) is type(theirs)
    np.testing.assert_array_equal(ours.indptr, theirs.indptr)
    np.testing.assert_array_equal(
        ours.indices, theirs.indices
    )  # in a square geodesics are straight
    np.testing.assert_allclose(ours.data, theirs.data, rtol=1e-6)
    ours = GeodesicNeighbors(radius=1.6, mode=mode).fit_transform(GRID)
    theirs = RadiusNeighborsTransformer(radius=1.6, mode=mode).fit_transform(GRID)
    np.testing.assert_array_equal(ours.indptr, theirs.indptr)
    np.testing.assert_array_equal(ours.sorted_indices().indices, theirs.sorted_indices().indices)
    if mode == "distance":
        assert (np.diff(ours.data)[ours.indptr[1:-1] - 1] <= 0).all()  # each row begins with 0
        np.testing.assert_array_equal(ours.toarray(), ours.toarray().T)


@pytest.mark.slow
def test_new_samples_have_the_neighbours_of_the_rectangle(rolls):
    (samples, flat), (new, new_flat) = rolls
    model = GeodesicNeighbors(n_neighbors=10).fit(samples)
    far, near = model.kneighbors(new[:20])
    truth = straight(new_flat[:20], flat)
    np.testing.assert_allclose(far, np.take_along_axis(truth, near, axis=1), rtol=0.3, atol=0.05)
    graph = model.transform(new[:20])
    assert graph.shape == (20, 1200)
    assert np.diff(graph.indptr).tolist() == [11] * 20
    within = model.radius_neighbors_graph(new[:3], radius=4.0, mode="distance", sort_results=True)
    assert within.data.max() <= 4
    assert (np.diff(within[1].data) >= 0).all()
    assert set(model.kneighbors_graph(new[:3]).data) == {1.0}


def test_samples_that_nothing_connects_are_not_neighbours():
    pair = np.concatenate([GRID[:4], GRID[:4] + 100])
    model = GeodesicNeighbors(n_neighbors=5, graph_neighbors=3).fit(pair)
    far, near = model.kneighbors()
    assert np.isinf(far[:, 3:]).all()
    assert (near[:, 3:] == 8).all()
    assert np.diff(model.kneighbors_graph().indptr).tolist() == [3] * 8
    assert np.diff(model.transform(pair).indptr).tolist() == [4] * 8


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: GeodesicNeighbors(mode="length").fit(GRID), "mode must be .* not 'length'"),
        (lambda: GeodesicNeighbors(radius=-1).fit(GRID), "finite and not negative, not -1"),
        (lambda: GeodesicNeighbors(radius="1").fit(GRID), "radius must be a distance, not '1'"),
        (lambda: GeodesicNeighbors().fit(GRID).radius_neighbors(), "be a distance, not None"),
        (lambda: GeodesicNeighbors().fit(GRID).kneighbors(n_neighbors=144), "143 or less, not 144"),
        (lambda: GeodesicNeighbors(n_neighbors=0).fit(GRID).transform(GRID), "1 or more, not 0"),
        (lambda: GeodesicNeighbors().fit(GRID).kneighbors_graph(mode="d"), "mode must be"),
    ],
)
def test_a_wrong_question_about_neighbours_is_refused(ask, message):
    with pytest.raises(InvalidOptionError, match=message):
        ask()


# -- embeddings ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_an_embedding_of_a_roll_is_the_rectangle(rolls):
    (samples, flat), (new, new_flat) = rolls
    model = GeodesicIsomap(n_neighbors=12)
    found = error_of_embedding(model.fit_transform(samples), flat)
    along_edges = error_of_embedding(Isomap(n_neighbors=12).fit_transform(samples), flat)
    assert found < 0.5 * along_edges
    both = np.concatenate([model.embedding_, model.transform(new)])
    assert error_of_embedding(both, np.concatenate([flat, new_flat])) < 1.05 * found
    np.testing.assert_allclose(model.embedding_.mean(axis=0), 0, atol=1e-9)
    assert (np.diff(model.eigenvalues_) < 0).all()


def test_components_beyond_the_dimension_of_the_samples_are_zero():
    line = np.linspace(0, 1, 30)[:, None]
    found = GeodesicIsomap(n_components=3, n_neighbors=2).fit(line)
    np.testing.assert_allclose(np.ptp(found.embedding_[:, 0]), 1)
    np.testing.assert_allclose(found.embedding_[:, 1:], 0, atol=1e-6)
    with pytest.raises(
        InvalidOptionError, match="n_components must be 3 or less, not 4: there are 3 landm"
    ):
        GeodesicIsomap(n_components=4, landmarks=3).fit(GRID)


def test_components_of_the_graph_are_connected_by_their_shortest_edges_with_a_warning():
    shifts = np.array([[0.0, 0.0], [50.0, 0.0], [0.0, 40.0]])
    parts = np.concatenate([GRID + shift for shift in shifts])
    with pytest.warns(FragmentedCloudWarning, match="has 3 components; 2 edges between") as caught:
        model = GeodesicIsomap().fit(parts)
    assert caught[0].filename == __file__
    link = model.domain_.lengths[-2:]
    apart = [straight(GRID, GRID + shift).min() for shift in shifts[[2, 1]]]
    np.testing.assert_allclose(np.sort(link), apart)
    truth = straight(parts, parts)
    assert error(straight(model.embedding_, model.embedding_), truth) < 0.2


@pytest.mark.slow
def test_a_domain_of_several_components_has_no_embedding():
    apart = gt.Graph(4, [[0, 1], [2, 3]])
    with pytest.raises(UnreachableError, match="no path connects sample 0, one of 4"):
        GeodesicIsomap().fit(apart)
    sheet = np.column_stack([GRID, np.zeros(144)])
    with pytest.raises(UnreachableError, match="embed each connected part"):
        GeodesicIsomap(operator="pointcloud").fit(np.concatenate([sheet, sheet + 100]))


# -- conventions -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "names"),
    [
        (GeodesicDistances(landmarks=2), ["geodesicdistances0", "geodesicdistances1"]),
        (GeodesicIsomap(n_neighbors=8), ["geodesicisomap0", "geodesicisomap1"]),
        (GeodesicNeighbors(), [f"geodesicneighbors{number}" for number in range(144)]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_models_are_copied_and_pickled_and_name_their_features(model, names):
    copy = clone(model)
    assert copy.get_params() == model.get_params()
    with pytest.raises(NotFittedError):
        copy.transform(GRID)
    found = copy.fit_transform(GRID)
    assert copy.get_feature_names_out().tolist() == names
    again = pickle.loads(pickle.dumps(copy)).transform(GRID)
    np.testing.assert_allclose(found @ np.eye(len(names)), again @ np.eye(len(names)), atol=1e-9)


def test_the_output_may_be_a_table_of_pandas():
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(GRID, columns=["x", "y"], index=np.arange(144) + 7)
    model = GeodesicDistances(landmarks=3).set_output(transform="pandas")
    found = model.fit_transform(table)
    assert found.columns.tolist() == [f"geodesicdistances{number}" for number in range(3)]
    assert found.index.tolist() == table.index.tolist()
    assert model.feature_names_in_.tolist() == ["x", "y"]


# -- what new samples and repeated ones may read ---------------------------------------------------


def test_a_new_sample_is_as_far_as_its_way_to_the_samples():
    samples = make_swiss_roll(300, random_state=0)[0]
    far = GeodesicDistances().fit(samples).transform(samples[:3] + 1e4)
    step = 1e4 * np.sqrt(3)
    assert (far > 0.99 * step).all()
    assert (far < 1.02 * step).all()


def test_repeated_samples_do_not_take_the_place_of_neighbours():
    once = make_swiss_roll(200, random_state=0)[0]
    rows = np.repeat(once, 6, axis=0)
    found = GeodesicDistances(n_neighbors=5, landmarks=[0]).fit_transform(rows)
    expected = GeodesicDistances(n_neighbors=5, landmarks=[0]).fit_transform(once)
    np.testing.assert_allclose(found[::6], expected, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(
        found.reshape(-1, 6), np.repeat(expected, 6, axis=1), rtol=1e-6, atol=1e-9
    )
    assert GeodesicIsomap(n_neighbors=5).fit_transform(rows).shape == (1200, 2)


def test_equal_samples_are_refused():
    with pytest.raises(InvalidDomainError, match="all samples are equal"):
        GeodesicDistances().fit(np.ones((9, 3)))


@pytest.mark.parametrize("fill", [0.0, 0.5])
def test_a_fill_below_a_distance_is_refused(fill):
    apart = np.concatenate([np.linspace(0, 1, 20), np.linspace(50, 51, 20)])[:, None]
    estimator = GeodesicDistances(landmarks=[0], n_neighbors=3, fill=fill)
    with pytest.raises(InvalidOptionError, match="above all distances"):
        estimator.fit_transform(apart)
    assert estimator.set_params(fill=9.0).fit_transform(apart).max() == 9.0


def test_a_shape_is_not_a_new_sample():
    samples = make_swiss_roll(50, random_state=0)[0]
    with pytest.raises(InvalidOptionError, match="fitted on a table"):
        GeodesicDistances().fit(samples).transform(gt.testing.shapes.icosphere(1))


# -- options by their names ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (GeodesicNeighbors(n_neighbors=0), "n_neighbors must be 1 or more, not 0"),
        (GeodesicNeighbors(n_neighbors=2.5), "n_neighbors must be an integer, not 2.5"),
        (GeodesicNeighbors(n_neighbors=None), "n_neighbors must be an integer, not None"),
        (
            GeodesicNeighbors(graph_neighbors=9),
            "graph_neighbors must be 8 or less, not 9: each of the 9 samples has 8 others",
        ),
        (GeodesicDistances(n_neighbors=9), "n_neighbors must be 8 or less, not 9: each of the 9"),
        (GeodesicDistances(landmarks=10), "landmarks must be 9 or less, not 10: there are 9 sam"),
        (GeodesicDistances(landmarks=None), 'landmarks must be "auto", "all", a number or an ar'),
        (GeodesicIsomap(n_components=True), "n_components must be an integer, not True"),
        (GeodesicIsomap(n_components=0), "n_components must be 1 or more, not 0"),
        (GeodesicDistances(metric="kilometres"), "metric='kilometres' does not measure these sam"),
        (GeodesicIsomap(metric="haversine"), "metric='haversine' does not measure these samples"),
        (GeodesicNeighbors(metric="precomputed"), "is for a square table of distances between all"),
    ],
)
def test_fit_names_the_option_that_is_wrong_and_its_bound(estimator, message):
    table = np.random.default_rng(0).random((9, 3))
    with pytest.raises(InvalidOptionError, match=re.escape(message)):
        estimator.fit(table)


def test_neighbours_that_are_too_many_are_named_as_they_were_given():
    model = GeodesicNeighbors(n_neighbors=9).fit(np.random.default_rng(0).random((9, 3)))
    with pytest.raises(InvalidOptionError, match="n_neighbors must be 8 or less, not 9: there are"):
        model.transform(np.zeros((1, 3)))
    with pytest.raises(InvalidOptionError, match="8 or less, not 10: there are 8 other samples"):
        model.kneighbors(n_neighbors=10)


def test_known_distances_are_those_of_their_samples_though_two_rows_are_equal():
    table = np.random.default_rng(0).random((30, 2))
    table[7] = table[3]
    known = np.linalg.norm(table[:, None] - table, axis=2)
    own = GeodesicDistances(n_neighbors=29, refine=True).fit_transform(table)
    given = GeodesicDistances(n_neighbors=29, refine=True, metric="precomputed")
    np.testing.assert_allclose(given.fit_transform(known), own, atol=1e-12)
    np.testing.assert_allclose(given.transform(known[:4]), own[:4], atol=1e-12)


def test_tables_out_of_the_range_of_floats_are_refused():
    table = np.random.default_rng(0).random((30, 2))
    for unit in (1e-200, 1e200, 1e308):
        with pytest.raises(UnsupportedDomainError, match=r"the table of samples is .* wide"):
            GeodesicDistances().fit(unit * table)


# -- nearest samples, as brute force finds them ----------------------------------------------------


def brute_force(model, count):
    """Return the nearest by the whole matrix, ties by number: distances and indices."""
    solver = model.solver_
    rows = solver.distances(np.arange(solver.domain.n_vertices))
    np.fill_diagonal(rows, np.inf)
    order = np.lexsort((np.broadcast_to(np.arange(len(rows)), rows.shape), rows))[:, :count]
    far = np.take_along_axis(rows, order, axis=1)
    return far, np.where(np.isinf(far), len(rows), order)


def lattice_with_parts():
    """A grid, on which many distances are equal, and a part of three samples."""
    side = np.arange(8.0)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    return np.concatenate([grid, [[100.0, 0.0], [101.0, 0.0], [100.5, 0.5]]])


@pytest.mark.parametrize("refine", ["across", True, False])
@pytest.mark.parametrize("count", [1, 4, 30])
def test_the_nearest_are_those_of_the_whole_matrix_with_ties(refine, count):
    model = GeodesicNeighbors(graph_neighbors=2 if refine is False else 4, refine=refine)
    model.fit(GRID if refine is False else lattice_with_parts())
    distances, indices = model.kneighbors(n_neighbors=count)
    expected, nearest = brute_force(model, count)
    np.testing.assert_array_equal(distances, expected)
    np.testing.assert_array_equal(indices, nearest)


@pytest.mark.parametrize(
    "make", [shapes.icosphere, lambda n: gt.PointCloud(shapes.icosphere(n).vertices)]
)
def test_the_nearest_vertices_of_a_surface_are_those_of_the_whole_matrix(make):
    model = GeodesicNeighbors().fit(make(4 if make is shapes.icosphere else 3))
    expected, nearest = brute_force(model, 6)
    distances, indices = model.kneighbors(n_neighbors=6)
    np.testing.assert_array_equal(distances, expected)
    np.testing.assert_array_equal(indices, nearest)


def test_graphs_within_a_radius_are_symmetric():
    graph = GeodesicNeighbors(radius=2.5).fit_transform(GRID).toarray()
    np.testing.assert_array_equal(graph, graph.T)
    model = GeodesicNeighbors(radius=2.5, symmetrize=None).fit(GRID)
    rows = model.solver_.distances(np.arange(len(GRID)))
    np.testing.assert_array_equal(model.transform(GRID).toarray(), np.where(rows <= 2.5, rows, 0))
    along = GeodesicNeighbors(radius=2.5, symmetrize=None, refine=True).fit_transform(GRID)
    np.testing.assert_array_equal(along.toarray(), along.toarray().T)
