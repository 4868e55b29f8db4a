"""The order of elimination, and the shape that the factor of the built-in solver takes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from matrices import (
    LAPLACIANS,
    SOLVER,
    analyze,
    complete,
    elimination_of,
    graph_laplacian,
    graphs,
    path,
    plus,
    star,
)
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu


def ordered(matrix):
    return elimination_of(matrix).order


def filled(matrix, order):
    """The pattern of the factor, by elimination of a dense matrix of truth values."""
    pattern = np.eye(len(order), dtype=bool) | (matrix.toarray() != 0)[np.ix_(order, order)]
    for k in range(len(order)):
        below = np.flatnonzero(pattern[k + 1 :, k]) + k + 1
        pattern[np.ix_(below, below)] = True
    return np.tril(pattern)


def fill(matrix, order):
    """The entries of the factor, those of the matrix among them."""
    places = matrix.tocoo()
    permuted = csr_array(
        (np.ones(matrix.nnz), (np.argsort(order)[places.row], np.argsort(order)[places.col])),
        matrix.shape,
    )
    system = plus(permuted, 1.0 + 2.0 * abs(permuted).sum(axis=1).max())
    lu = splu(
        system.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return lu.L.nnz


# -- the order of elimination ----------------------------------------------------------------------


@given(graphs())
def test_an_order_has_every_vertex_once(matrix):
    np.testing.assert_array_equal(np.sort(ordered(matrix)), np.arange(matrix.shape[0]))


@pytest.mark.parametrize("n", [1, 2, 17, 500])
@pytest.mark.parametrize("kind", [path, star, complete, lambda n: csr_array((n, n))])
def test_special_graphs_are_ordered(kind, n):
    np.testing.assert_array_equal(np.sort(ordered(kind(n))), np.arange(n))


def test_the_order_is_the_same_every_time(laplacian):
    np.testing.assert_array_equal(ordered(laplacian), ordered(laplacian.copy()))


def test_an_order_of_a_graph_whose_fill_outgrows_the_first_lists_has_every_vertex_once():
    n = 1500
    edges = np.random.default_rng(0).integers(
        0, n, size=(5 * n, 2)
    )  # almost all vertices are far apart
    matrix = graph_laplacian(n, edges[edges[:, 0] != edges[:, 1]])
    order = ordered(matrix)
    np.testing.assert_array_equal(np.sort(order), np.arange(n))
    theirs = np.argsort(splu(plus(matrix, 1.0).tocsc(), permc_spec="MMD_AT_PLUS_A").perm_c)
    assert fill(matrix, order) <= 1.1 * fill(matrix, theirs)


@pytest.mark.parametrize("kind", [path, star])
def test_a_tree_has_no_fill(kind):
    assert fill(kind(300), ordered(kind(300))) == 300 + 299


def test_a_full_row_goes_last():
    n, hub = 4000, 1234  # set aside from 10 √N neighbours on
    edges = np.r_[np.stack([np.full(n, hub), np.arange(n)], axis=1), list(pairwise(range(n)))]
    order = ordered(graph_laplacian(n, edges[edges[:, 0] != edges[:, 1]]))
    assert order[-1] == hub
    np.testing.assert_array_equal(np.sort(order), np.arange(n))


@pytest.mark.parametrize(
    "name",
    ["icosphere", "torus", "tube", "grid of squares", "several parts", "neighbours in space"],
)
def test_fill_is_about_that_of_the_minimum_degree_order_of_superlu(name):
    system = plus(LAPLACIANS[name](), 1.0)
    theirs = np.argsort(splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A").perm_c)
    own, other = (fill(system, order) for order in (ordered(system), theirs))
    assert own <= 1.1 * other


# -- what the factor looks like --------------------------------------------------------------------


def groups_of(found):
    return [np.arange(a, b) for a, b in pairwise(found.starts)]


@given(graphs())
def test_heights_are_those_of_dense_elimination_and_parents_take_over_all_rows(matrix):
    found = elimination_of(matrix)
    pattern = filled(matrix, found.order)
    groups = groups_of(found)
    assert found.n_full == 0
    for group, height, parent in zip(groups, found.heights, found.parents, strict=True):
        np.testing.assert_array_equal(pattern[:, group].sum(axis=0), height - np.arange(len(group)))
        rows = set(np.flatnonzero(pattern[:, group[-1]])) - set(group)
        if parent < 0:
            assert not rows
        else:
            assert groups[parent][0] > group[-1]
            assert rows <= set(np.flatnonzero(pattern[:, groups[parent][0]]))


@pytest.mark.parametrize("hubs", [1, 3])
def test_full_rows_are_in_every_supernode_that_they_reach(hubs):
    """They are set aside before the order is made, and the tree does not know of them."""
    n = 2500
    edges = [(i, i + 1) for i in range(n - 1)]
    edges += [(n + h, i) for h in range(hubs) for i in range(h, n, 2 + h)]
    matrix = plus(graph_laplacian(n + hubs, edges), 0.1)
    assert elimination_of(matrix).n_full == hubs
    its = analyze(matrix)
    assert len(its.rows) == its.row_starts[-1]
    assert set(its.order[-hubs:]) == set(range(n, n + hubs))
    load = np.random.default_rng(0).normal(size=n + hubs)
    np.testing.assert_allclose(matrix @ SOLVER.factorize(matrix).solve(load), load, atol=1e-10)


ZEROS = (0.6, 0.3, 0.12, 0.05)
"""Share of zeros that a supernode may store, by its number of columns."""


@given(graphs())
def test_the_rows_of_supernodes_hold_the_factor_and_few_zeros_more(matrix):
    its = analyze(matrix)
    pattern = filled(matrix, its.order)
    assert its.first[0] == 0
    assert its.first[-1] == matrix.shape[0]
    for s in range(len(its.parents)):
        columns = np.arange(its.first[s], its.first[s + 1])
        rows = its.rows[its.row_starts[s] : its.row_starts[s + 1]]
        assert (np.diff(rows) > 0).all()
        np.testing.assert_array_equal(rows[: len(columns)], columns)
        true = pattern[:, columns]
        assert set(np.flatnonzero(true.any(axis=1))) <= set(rows)
        stored = sum(len(rows) - k for k in range(len(columns)))
        limit = ZEROS[int(np.searchsorted([4, 16, 48], len(columns)))]
        assert stored - true.sum() <= limit * stored
        parent = its.parents[s]
        if parent < 0:
            assert len(rows) == len(columns)
        else:
            theirs = its.rows[its.row_starts[parent] : its.row_starts[parent + 1]]
            assert parent > s
            assert set(rows[len(columns) :]) <= set(theirs)


@given(graphs())
def test_the_permuted_triangle_has_every_entry_once_and_knows_its_place(matrix):
    matrix.data[:] = np.arange(matrix.nnz)
    its = analyze(matrix)
    columns = np.repeat(np.arange(matrix.shape[0]), np.diff(its.starts))
    assert (its.lower_rows >= columns).all()
    values = matrix.data[its.places]
    dense = matrix.toarray()
    np.testing.assert_array_equal(values, dense[its.order[columns], its.order[its.lower_rows]])
    assert len(values) == np.tril(filled_places(matrix)).sum()


def filled_places(matrix):
    """Return the pattern of a matrix, explicit zeros included."""
    return csr_array((np.ones(matrix.nnz), matrix.indices, matrix.indptr), matrix.shape).toarray()
