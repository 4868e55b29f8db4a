"""Matrices of distances: right, the same on every way, and resumable to the last bit."""

import importlib.util
import json
import multiprocessing
import os
import shutil
import subprocess
import sys
import textwrap
import warnings
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, load_npz

import geodesic_toolkit as gt
from geodesic_toolkit import errors
from geodesic_toolkit.analysis.matrix import fingerprints, stores, symmetry, workers
from geodesic_toolkit.analysis.matrix.tasks import rows_of_task
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.linear import memory
from geodesic_toolkit.testing import shapes

HOWS = ("mean", "min", "max", None)

UFUNCS = {"mean": lambda a, b: (a + b) / 2, "min": np.minimum, "max": np.maximum}


@pytest.fixture(scope="module")
def solver():
    return gt.GeodesicSolver(shapes.icosphere(2))


@pytest.fixture(scope="module")
def rows(solver):
    """Every vertex to every vertex, as they come."""
    return solver.distances(range(162))


def symmetric(rows, how):
    return rows if how is None else UFUNCS[how](rows, rows.T)


def stop_after(rows):
    """A progress callback that interrupts once so many rows are done."""

    def progress(done, total):
        if done >= rows:
            raise KeyboardInterrupt

    return progress


def contents(path):
    """Every byte of a file, or of all files of a store."""
    if path.is_file():
        return path.read_bytes()
    files = sorted(file for file in path.rglob("*") if file.is_file())
    return {str(file.relative_to(path)): file.read_bytes() for file in files}


# -- what is in it ---------------------------------------------------------------------------------


def test_rows_are_what_the_solver_says(solver, rows):
    found = gt.distance_matrix(solver, [5, 100, 5])
    assert found.shape == (3, 162)
    np.testing.assert_allclose(found, rows[[5, 100, 5]], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("how", HOWS)
def test_all_vertices_make_a_square_matrix_that_is_symmetrised(solver, rows, how):
    matrix = gt.distance_matrix(solver, symmetrize=how)
    np.testing.assert_array_equal(matrix, symmetric(rows, how))
    assert np.array_equal(matrix, matrix.T) == (how is not None)


def test_the_default_is_the_mean(solver):
    np.testing.assert_array_equal(
        gt.distance_matrix(solver), gt.distance_matrix(solver, symmetrize="mean")
    )


def test_sources_as_targets_make_a_square_matrix_between_them(solver, rows):
    some = np.array([7, 3, 150])
    between = gt.distance_matrix(solver, some, targets=some)
    expected = symmetric(rows[np.ix_(some, some)], "mean")
    np.testing.assert_allclose(between, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(between, between.T)


@pytest.mark.parametrize(
    ("sources", "targets"),
    [([1, 2], None), ([1, 2], [2, 1]), ([1, 1], [1, 1]), ([[1], [2]], [1, 2])],
)
def test_only_rows_and_columns_of_the_same_vertices_are_symmetrised(solver, sources, targets):
    matrix = gt.distance_matrix(solver, sources, targets=targets)
    rows = solver.distances(sources)
    np.testing.assert_array_equal(matrix, rows if targets is None else rows[:, targets])


def test_sources_are_of_every_kind(solver):
    sets = [
        3,
        [1, 2],
        [0.0, 0.0, 1.0],
        gt.SurfacePoint(4, (0.2, 0.3, 0.5)),
        gt.OffsetSources([8], [0.5]),
    ]
    np.testing.assert_array_equal(gt.distance_matrix(solver, sets), solver.distances(sets))


def test_float32_is_the_nearest_to_float64(solver):
    exact = gt.distance_matrix(solver, [0, 1])
    rounded = gt.distance_matrix(solver, [0, 1], dtype=np.float32)
    assert rounded.dtype == np.float32
    np.testing.assert_array_equal(rounded, exact.astype(np.float32))


def test_what_does_not_connect_is_infinitely_far_in_both_directions():
    two = shapes.disjoint_union(shapes.icosphere(1), shapes.icosphere(2))
    matrix = gt.distance_matrix(gt.GeodesicSolver(two, refine=True))
    assert np.isinf(matrix[:42, 42:]).all()
    assert np.isinf(matrix[42:, :42]).all()
    assert np.isfinite(matrix[:42, :42]).all()
    assert np.isfinite(matrix[42:, 42:]).all()


def test_vertices_that_cannot_be_sources_have_rows_of_infinity():
    mesh = shapes.grid(9)
    mask = np.isclose(mesh.vertices[:, 0], 0.5)
    solver = gt.GeodesicSolver(mesh, mask=mask, refine=True)
    matrix = gt.distance_matrix(solver)
    assert np.isinf(matrix[mask]).all()
    assert np.isinf(matrix[:, mask]).all()
    assert (np.diag(matrix)[~mask] == 0).all()
    cloud = np.vstack([shapes.icosphere(2).vertices, [[np.nan] * 3]])
    matrix = gt.distance_matrix(gt.GeodesicSolver(gt.PointCloud(cloud, cloud)))
    assert np.isinf(matrix[162]).all()
    assert np.isfinite(matrix[:162, :162]).all()


def test_a_graph_has_a_matrix_too():
    path = gt.GeodesicSolver(gt.Graph(20, [[i, i + 1] for i in range(19)]))
    places = np.arange(20)
    matrix = gt.distance_matrix(path)
    np.testing.assert_allclose(
        matrix, np.abs(places[:, None] - places), atol=0.3
    )  # an end is 0.15 off


# -- sparse ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", HOWS)
@pytest.mark.parametrize("limit", [0.0, 0.4, 1.5, 9.0])
def test_a_thinned_matrix_holds_the_entries_of_the_dense_one_that_are_not_above(solver, how, limit):
    dense = gt.distance_matrix(solver, symmetrize=how)
    sparse = gt.distance_matrix(solver, symmetrize=how, max_distance=limit)
    assert isinstance(sparse, csr_array)
    assert sparse.nnz == (dense <= limit).sum()
    assert sparse.has_canonical_format
    np.testing.assert_array_equal(sparse.toarray(), np.where(dense <= limit, dense, 0.0))


def test_zeros_of_the_diagonal_are_entries(solver):
    sparse = gt.distance_matrix(solver, max_distance=0.0)
    np.testing.assert_array_equal(sparse.indices, np.arange(162))
    np.testing.assert_array_equal(sparse.data, np.zeros(162))


def test_a_thinned_float32_matrix_is_cut_where_the_dense_one_is(solver):
    dense = gt.distance_matrix(solver, dtype="float32")
    limit = float(dense[0, 7]) - 1e-12  # in float32 the limit would be the entry itself
    sparse = gt.distance_matrix(solver, dtype="float32", max_distance=limit)
    assert sparse.dtype == np.float32
    assert sparse.nnz == (dense.astype(np.float64) <= limit).sum()


def test_a_thinned_matrix_of_some_rows_has_the_shape_of_the_dense_one(solver, rows):
    sparse = gt.distance_matrix(solver, [9, 3], targets=[1, 2, 3], max_distance=0.1)
    assert sparse.shape == (2, 3)
    assert sparse.nnz == 1
    assert sparse[1, 2] == 0


@given(
    st.integers(1, 8).flatmap(
        lambda n: st.lists(
            st.lists(st.integers(0, 12), min_size=n, max_size=n), min_size=n, max_size=n
        )
    ),
    st.sampled_from(["mean", "min", "max"]),
    st.integers(0, 12),
)
def test_symmetry_of_sparse_entries_is_that_of_dense_ones(entries, how, limit):
    dense = np.array(entries, dtype=np.float64)
    kept = dense <= symmetry.widened(limit, how)
    starts = np.concatenate([[0], np.cumsum(kept.sum(axis=1))])
    thinned = csr_array((dense[kept], np.nonzero(kept)[1], starts), shape=dense.shape)
    rows, farther = symmetry.unknown_rows(thinned, how, limit)
    assert len(rows) == 0 or how == "mean"
    kept[rows] = dense[rows] <= farther
    starts = np.concatenate([[0], np.cumsum(kept.sum(axis=1))])
    thinned = csr_array((dense[kept], np.nonzero(kept)[1], starts), shape=dense.shape)
    found = symmetry.symmetrized_entries(thinned, how, limit)
    expected = UFUNCS[how](dense, dense.T)
    np.testing.assert_array_equal(found.nnz, (expected <= limit).sum())
    np.testing.assert_array_equal(found.toarray(), np.where(expected <= limit, expected, 0))


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_mirrored_distances_that_differ_much_are_measured_again(tmp_path, dtype):
    line = np.arange(12.0)
    one_way = np.where(line > line[:, None], 1.0, 1.8) * np.abs(line - line[:, None])

    class Slow(gt.GeodesicSolver):
        def near(self, source_sets, limits):
            vertices = [sources.vertices[0] for sources in self.locate_sets(source_sets)]
            rows = one_way[vertices]
            return NearRows.of_table(rows, np.full(len(rows), limits))

    graph = gt.Graph(12, np.column_stack([np.arange(11), np.arange(1, 12)]))
    expected = (one_way + one_way.T) / 2
    for limit in (0.0, 1.4, 2.8, 5.0, 100.0):
        found = gt.distance_matrix(Slow(graph), max_distance=limit, dtype=dtype)
        assert found.nnz == (expected.astype(dtype) <= limit).sum()
        kept = np.where(expected <= limit, expected, 0)
        np.testing.assert_allclose(found.toarray(), kept, rtol=1e-6)
    saved = gt.distance_matrix(Slow(graph), max_distance=2.8, out=tmp_path / "D.npz")
    memory_of_it = gt.distance_matrix(Slow(graph), max_distance=2.8)
    np.testing.assert_array_equal(saved.toarray(), memory_of_it.toarray())


# -- the same on every way -------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("how", ["mean", None])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_memory_file_and_store_hold_the_same(solver, tmp_path, how, dtype):
    pytest.importorskip("zarr")
    options = {"symmetrize": how, "dtype": dtype}
    matrix = gt.distance_matrix(solver, **options)
    file = gt.distance_matrix(solver, out=tmp_path / "D.npy", **options)
    store = gt.distance_matrix(solver, out=tmp_path / "D.zarr", **options)
    np.testing.assert_array_equal(file, matrix)
    np.testing.assert_array_equal(store[:], matrix)
    assert isinstance(file, np.memmap)
    assert file.dtype == store.dtype == dtype
    assert store.chunks == (rows_of_task(162, 162), 162)
    assert {path.name for path in tmp_path.iterdir()} == {"D.npy", "D.zarr"}
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), matrix)


@pytest.mark.parametrize("how", ["mean", "min", "max"])
def test_bands_of_any_size_give_the_same_symmetric_matrix(monkeypatch, how):
    rng = np.random.default_rng(0)
    matrix = rng.random((37, 37)).astype(np.float32)
    expected = symmetric(matrix, how)
    for size in (1.0, 1e3, 1e9):
        monkeypatch.setattr(symmetry, "BAND_BYTES", size)
        bands = list(symmetry.symmetric_bands(matrix, how, 4))
        assert all(start % 4 == 0 for start, _ in bands)
        np.testing.assert_array_equal(np.concatenate([band for _, band in bands]), expected)
        in_place = matrix.copy()
        symmetry.symmetrize_in_place(in_place, how)
        np.testing.assert_array_equal(in_place, expected)


def test_a_sparse_file_holds_what_is_returned(solver, tmp_path):
    found = gt.distance_matrix(solver, max_distance=0.5, out=tmp_path / "D.npz")
    expected = gt.distance_matrix(solver, max_distance=0.5)
    for matrix in (found, load_npz(tmp_path / "D.npz")):
        assert matrix.nnz == expected.nnz  # the zeros too
        np.testing.assert_array_equal(matrix.toarray(), expected.toarray())


def test_a_second_matrix_takes_the_place_of_the_first(solver, tmp_path):
    pytest.importorskip("zarr")
    for name in ("D.npy", "D.zarr"):
        gt.distance_matrix(solver, out=tmp_path / name)
        again = gt.distance_matrix(solver, [1, 2], out=tmp_path / name)
        assert again.shape == (2, 162)
    assert {path.name for path in tmp_path.iterdir()} == {"D.npy", "D.zarr"}


def test_tasks_are_fixed_by_the_shape_alone():
    assert rows_of_task(10_242, 10_242) == 160
    assert rows_of_task(1, 5_000_000) == 16
    assert rows_of_task(10_000_000, 100) == 1024
    assert all(rows_of_task(k, 700) % 16 == 0 for k in range(1, 3000, 37))


def test_progress_counts_rows_from_none_to_all(solver):
    seen = []
    gt.distance_matrix(solver, progress=lambda done, total: seen.append((done, total)))
    assert [done for done, _ in seen] == [*range(0, 162, 16), 162]
    assert {total for _, total in seen} == {162}


# -- interrupted and resumed -----------------------------------------------------------------------


OUTPUTS = [
    pytest.param("D.npy", {}, id="npy"),
    pytest.param("D.npy", {"symmetrize": None, "dtype": "float32"}, id="npy, not symmetric"),
    pytest.param("D.zarr", {"dtype": "float32"}, id="zarr"),
    pytest.param("D.zarr", {"symmetrize": None}, id="zarr, not symmetric"),
    pytest.param("D.npz", {"max_distance": 0.7}, id="npz"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), OUTPUTS)
def test_a_resumed_run_ends_in_the_same_bytes(solver, tmp_path, name, options):
    if name.endswith(".zarr"):
        pytest.importorskip("zarr")
    (tmp_path / "whole").mkdir()
    gt.distance_matrix(solver, out=tmp_path / "whole" / name, **options)
    for rows in (40, 100):  # twice, to resume what was resumed
        with pytest.raises(KeyboardInterrupt):
            gt.distance_matrix(solver, out=tmp_path / name, progress=stop_after(rows), **options)
        assert not (tmp_path / name).exists()
        assert (tmp_path / f"{name}.partial").is_dir()
    seen = []
    gt.distance_matrix(
        gt.GeodesicSolver(shapes.icosphere(2)),  # as another process would make it
        out=tmp_path / name,
        progress=lambda done, total: seen.append(done),
        **options,
    )
    assert seen[0] == 112  # the first multiple of the task's 16 rows that is not below 100
    assert contents(tmp_path / name) == contents(tmp_path / "whole" / name)
    assert not (tmp_path / f"{name}.partial").exists()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["D.npy", "D.zarr"])
def test_a_run_interrupted_while_it_symmetrises_ends_in_the_same_bytes(
    solver, tmp_path, monkeypatch, name
):
    if name.endswith(".zarr"):
        pytest.importorskip("zarr")
    (tmp_path / "whole").mkdir()
    gt.distance_matrix(solver, out=tmp_path / "whole" / name)
    usual = symmetry.symmetric_bands

    def interrupted(*arguments):
        yield next(usual(*arguments))
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(symmetry, "BAND_BYTES", 1.0)
        patch.setattr(stores, "symmetric_bands", interrupted)
        with pytest.raises(KeyboardInterrupt):
            gt.distance_matrix(solver, out=tmp_path / name)
    seen = []
    gt.distance_matrix(solver, out=tmp_path / name, progress=lambda done, _: seen.append(done))
    assert seen == [162]  # nothing was computed again
    assert contents(tmp_path / name) == contents(tmp_path / "whole" / name)


@pytest.mark.slow
def test_rows_that_were_lost_are_computed_again(solver, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    (tmp_path / "D.npy.partial" / "rows.npy").unlink()
    found = gt.distance_matrix(solver, out=tmp_path / "D.npy")
    np.testing.assert_array_equal(found, gt.distance_matrix(solver))
    thinned = {"max_distance": 0.5, "out": tmp_path / "D.npz"}
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, **thinned, progress=stop_after(100))
    (tmp_path / "D.npz.partial" / "rows-000002.npz").unlink()
    seen = []
    sparse = gt.distance_matrix(solver, **thinned, progress=lambda done, _: seen.append(done))
    assert seen[0] == 112 - 16
    assert sparse.nnz == gt.distance_matrix(solver, max_distance=0.5).nnz


@pytest.mark.skipif(sys.platform == "win32", reason="folders are not locked there")
def test_a_file_system_without_locks_is_enough(solver, tmp_path, monkeypatch):
    import fcntl

    def flock(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    assert gt.distance_matrix(solver, [1], out=tmp_path / "D.npy").shape == (1, 162)


def test_a_shape_of_one_vertex_has_a_matrix_of_one_zero(tmp_path):
    alone = gt.GeodesicSolver(gt.Graph(1, np.zeros((0, 2), dtype=np.int64)))
    for out in (None, tmp_path / "D.npy"):
        np.testing.assert_array_equal(gt.distance_matrix(alone, out=out), [[0.0]])
    assert gt.distance_matrix(alone, max_distance=0).nnz == 1


def test_an_old_output_stays_until_the_new_one_is_complete(solver, tmp_path):
    gt.distance_matrix(solver, [0], out=tmp_path / "D.npy")
    before = contents(tmp_path / "D.npy")
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    assert contents(tmp_path / "D.npy") == before


def test_an_old_store_comes_back_where_the_new_one_cannot_take_its_place(
    solver, tmp_path, monkeypatch
):
    zarr = pytest.importorskip("zarr")
    gt.distance_matrix(solver, [0], out=tmp_path / "D.zarr")
    before = contents(tmp_path / "D.zarr")
    usual = Path.replace

    def replace(self, target):
        if self.name == "matrix.zarr":
            raise OSError(5, "Input/output error")
        return usual(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", replace)
        with pytest.raises(errors.WriteError, match="Input/output error"):
            gt.distance_matrix(solver, out=tmp_path / "D.zarr")
    assert contents(tmp_path / "D.zarr") == before
    gt.distance_matrix(solver, out=tmp_path / "D.zarr")
    np.testing.assert_array_equal(
        zarr.open_array(tmp_path / "D.zarr", mode="r")[:], gt.distance_matrix(solver)
    )


def test_without_resume_everything_is_computed_again(solver, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    seen = []
    gt.distance_matrix(
        solver,
        [3, 4],  # another request, which would be refused
        out=tmp_path / "D.npy",
        resume=False,
        progress=lambda done, _: seen.append(done),
    )
    assert seen == [0, 2]


CHANGES = [
    ("shape", {"mesh": shapes.icosphere(2, radius=2.0)}),
    ("time", {"solver": {"time_factor": 2.0}}),
    ("refine", {"solver": {"refine": False}}),
    ("boundary", {"solver": {"boundary": "average"}}),
    ("operator", {"solver": {"operator": gt.CotanLaplacian(mass="voronoi")}}),
    ("operator", {"solver": {"mask": np.arange(162) == 3}}),
    ("Poisson solver", {"solver": {"solver": {"poisson": "cg"}}}),
    ("sources", {"sources": [1, 2, 3]}),
    ("targets", {"targets": [1, 2, 3]}),
    ("dtype", {"dtype": "float32"}),
    ("symmetrize", {"symmetrize": "max"}),
]


@pytest.mark.parametrize(
    ("name", "change"), CHANGES, ids=[f"{name} {index}" for index, (name, _) in enumerate(CHANGES)]
)
def test_another_request_is_refused_and_named(solver, tmp_path, name, change):
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    before = contents(tmp_path)
    change = dict(change)
    mesh = change.pop("mesh", solver.domain)
    other = gt.GeodesicSolver(mesh, **change.pop("solver", {}))
    with pytest.raises(errors.InvalidOptionError, match=f"{name} was .*, now .*resume=False"):
        gt.distance_matrix(other, out=tmp_path / "D.npy", **change)
    assert contents(tmp_path) == before
    assert gt.distance_matrix(solver, out=tmp_path / "D.npy").shape == (162, 162)


def test_another_limit_is_refused(solver, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(
            solver, max_distance=0.5, out=tmp_path / "D.npz", progress=stop_after(100)
        )
    with pytest.raises(errors.InvalidOptionError, match=r"max_distance was 0\.5, now 0\.6"):
        gt.distance_matrix(solver, max_distance=0.6, out=tmp_path / "D.npz")


@pytest.mark.slow
def test_fingerprints_are_the_same_in_another_process(solver):
    program = """
        import json
        import geodesic_toolkit as gt
        from geodesic_toolkit.analysis.matrix.fingerprints import fingerprint_of_solver
        solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(2))
        print(json.dumps(fingerprint_of_solver(solver)))
    """
    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, check=True
    )
    assert json.loads(result.stdout) == fingerprints.fingerprint_of_solver(solver)


@pytest.mark.skipif(sys.platform == "win32", reason="folders are not locked there")
def test_two_runs_do_not_write_the_same_matrix(solver, tmp_path):
    def inside(done, total):
        if done == 160:
            with pytest.raises(errors.WriteError, match="another run"):
                gt.distance_matrix(solver, out=tmp_path / "D.npy")

    first = gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=inside)
    np.testing.assert_array_equal(first, gt.distance_matrix(solver))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda folder: (folder / "request.json").write_text("{"), "cannot be read"),
        (lambda folder: (folder / "request.json").write_text("[]"), "is not a record"),
        (lambda folder: (folder / "done").write_bytes(b"\1"), "1 tasks, not 11"),
        (lambda folder: (folder / "request.json").unlink(), "is not an unfinished matrix"),
        (lambda folder: (shutil.rmtree(folder), folder.write_text("")), "is not a folder"),
    ],
)
def test_a_folder_that_is_not_sound_is_refused(solver, tmp_path, spoil, message):
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    spoil(tmp_path / "D.npy.partial")
    with pytest.raises(errors.WriteError, match=message):
        gt.distance_matrix(solver, out=tmp_path / "D.npy")


def test_a_run_that_ended_before_its_record_was_written_starts_again(solver, tmp_path):
    folder = tmp_path / "D.npy.partial"
    folder.mkdir()
    (folder / "lock").touch()
    (folder / ".request.0123456789ab.json").write_text("{")
    found = gt.distance_matrix(solver, [1, 2], out=tmp_path / "D.npy")
    assert found.shape == (2, 162)
    assert not folder.exists()


# -- workers ---------------------------------------------------------------------------------------


@dataclass
class Watched(Executor):
    """An executor that passes on what it is given, and keeps it."""

    inner: Executor

    def __post_init__(self):
        self.submitted = []

    def submit(self, function, /, *arguments):
        self.submitted.append(arguments)
        return self.inner.submit(function, *arguments)

    @property
    def payloads(self):
        return sum(parcel.content is not None for parcel, _ in self.submitted)


def spawned(count):
    return ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))


@pytest.mark.slow
def test_processes_give_the_same_bits_and_get_the_solver_once(solver, rows, tmp_path):
    with spawned(1) as pool:
        watched = Watched(pool)
        found = gt.distance_matrix(solver, symmetrize=None, executor=watched)
        np.testing.assert_array_equal(found, rows)
        assert 1 <= watched.payloads <= 2
        before = watched.payloads
        gt.distance_matrix(solver, [1, 2, 3], executor=watched)  # the worker still has it
        assert watched.payloads == before
        gt.distance_matrix(solver, out=tmp_path / "D.npy", executor=watched)
    gt.distance_matrix(solver, out=tmp_path / "E.npy")
    assert contents(tmp_path / "D.npy") == contents(tmp_path / "E.npy")


def test_threads_share_the_solver_itself(solver, rows):
    with ThreadPoolExecutor(3) as pool:
        watched = Watched(pool)
        found = gt.distance_matrix(solver, symmetrize=None, executor=watched)
    np.testing.assert_array_equal(found, rows)
    assert watched.payloads == 0


def test_a_run_in_workers_resumes_one_without(solver, tmp_path):
    gt.distance_matrix(solver, out=tmp_path / "whole.npy")
    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, out=tmp_path / "D.npy", progress=stop_after(100))
    with ThreadPoolExecutor(2) as pool:
        gt.distance_matrix(solver, out=tmp_path / "D.npy", executor=pool)
    assert contents(tmp_path / "D.npy") == contents(tmp_path / "whole.npy")


def test_an_interrupted_run_cancels_what_has_not_begun(solver):
    with ThreadPoolExecutor(1) as pool:
        watched = Watched(pool)
        with pytest.raises(KeyboardInterrupt):
            gt.distance_matrix(solver, executor=watched, progress=stop_after(16))
        assert pool.submit(int).result() == 0  # the pool is open and idle


def test_an_unknown_worker_gets_an_error_with_advice(solver):
    assert workers.compute(workers.Parcel("nobody's"), None) is None


def test_a_worker_keeps_one_solver(monkeypatch, solver):
    monkeypatch.setattr(workers, "_kept", None)
    content = workers.pickled(solver)
    first = workers.Parcel("a", content=content).opened()
    assert workers.Parcel("a").opened() is first
    assert workers.Parcel("b", content=content).opened() is not first
    assert workers.Parcel("a").opened() is None


def test_warnings_of_workers_are_passed_on():
    coarse = gt.GeodesicSolver(gt.TriangleMesh(np.eye(3), [[0, 1, 2]]), refine=False)
    with (
        spawned(1) as pool,
        pytest.warns(errors.CoarseMeshWarning, match="has 3 vertices|only 3 vertices") as seen,
    ):
        gt.distance_matrix(coarse, executor=pool)
    assert all(Path(warning.filename).samefile(__file__) for warning in seen)


def test_matrices_of_one_solver_at_the_same_time_do_not_disturb_each_other(solver, rows):
    """The first ends while the second is under way, which must not lose its solver by that."""
    with ThreadPoolExecutor(2) as pool:
        watched = Watched(pool)
        second = []

        def begin_another(done, total):
            if done and not second:
                second.append(None)
                second[0] = gt.distance_matrix(solver, symmetrize=None, executor=watched)

        first = gt.distance_matrix(
            solver, symmetrize=None, executor=watched, progress=begin_another
        )

        def short_one(done, total):
            if done == 16:
                gt.distance_matrix(solver, [1, 2], executor=watched)

        third = gt.distance_matrix(solver, symmetrize=None, executor=watched, progress=short_one)
    for found in (first, second[0], third):
        np.testing.assert_array_equal(found, rows)
    assert watched.payloads == 0


@pytest.mark.slow
def test_matrices_leave_the_warnings_of_a_worker_as_they_are(solver):
    with spawned(1) as pool:
        before = pool.submit(warnings_of_the_process).result()
        gt.distance_matrix(solver, [1, 2], executor=pool)
        assert pool.submit(warnings_of_the_process).result() == before


def warnings_of_the_process():
    return warnings.showwarning.__module__, len(warnings.filters)


def test_a_failure_in_a_worker_is_raised_here(solver, monkeypatch):
    class Dead(Executor):
        def submit(self, function, /, *arguments):
            future = Future()
            future.set_exception(BrokenExecutor("it is gone"))
            return future

    with pytest.raises(errors.SolverError, match="it is gone"):
        gt.distance_matrix(solver, executor=Dead())


def test_a_solver_that_cannot_travel_says_so():
    @dataclass(frozen=True, kw_only=True)
    class Local(gt.LaplaceOperator):
        domains: ClassVar = (gt.TriangleMesh,)

        def assemble(self, domain):
            return gt.CotanLaplacian().assemble(domain)

    solver = gt.GeodesicSolver(shapes.icosphere(2), operator=Local())
    with pytest.raises(errors.InvalidOptionError, match="cannot be sent"), spawned(1) as pool:
        gt.distance_matrix(solver, executor=pool)
    with ThreadPoolExecutor(1) as pool:
        assert gt.distance_matrix(solver, [0], executor=pool).shape == (1, 162)


def test_many_workers_are_served_in_turn(solver, rows):
    """Each task is a worker of its own that has nothing: the worst order there can be."""

    class Forgetful(Executor):
        def __init__(self):
            self.payloads = 0

        def submit(self, function, /, parcel, task):
            self.payloads += parcel.content is not None
            future = Future()
            future.set_result(None if parcel.content is None else (task.compute(solver), []))
            return future

    executor = Forgetful()
    np.testing.assert_array_equal(
        gt.distance_matrix(solver, symmetrize=None, executor=executor), rows
    )
    assert executor.payloads == 11


PROGRAM = """
import numpy as np
import geodesic_toolkit as gt

if __name__ == "__main__":
    {setup}
    solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(2))
    found = gt.distance_matrix(solver, executor=executor)
    assert np.array_equal(found, gt.distance_matrix(solver))
    {end}
    print("the same bits")
"""

CLUSTER = """import distributed
    client = distributed.Client(n_workers=2, dashboard_address=None)
    executor = client.get_executor()"""

CLUSTERS = {
    "loky": (
        "import loky; executor = loky.ProcessPoolExecutor(2)",
        "executor.shutdown()",
        [sys.executable],
    ),
    "distributed": (
        CLUSTER,
        "client.shutdown()",
        [sys.executable],
    ),
    "mpi4py": (
        "from mpi4py.futures import MPIPoolExecutor; executor = MPIPoolExecutor()",
        "executor.shutdown()",
        ["mpiexec", "-n", "3", sys.executable, "-m", "mpi4py.futures"],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("package", list(CLUSTERS))
def test_other_executors_give_the_same_bits(package, tmp_path, monkeypatch):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    setup, end, command = CLUSTERS[package]
    program = tmp_path / "program.py"
    program.write_text(PROGRAM.format(setup=setup, end=end))
    # The mpiexec of mpi4py's own MPI: a system may have another one.
    folders = os.pathsep.join([str(Path(sys.executable).parent), os.defpath, os.environ["PATH"]])
    if (started := shutil.which(command[0], path=folders)) is None:
        pytest.skip(f"there is no {command[0]}")
    # Open MPI would not run in a container, nor with more processes than processors.
    monkeypatch.setenv("OMPI_ALLOW_RUN_AS_ROOT", "1")
    monkeypatch.setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    monkeypatch.setenv("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")
    result = subprocess.run(
        [started, *command[1:], str(program)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "the same bits"


# -- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"executor": 3}, errors.InvalidOptionError, "not an int"),
        ({"symmetrize": "average"}, errors.InvalidOptionError, "'average'"),
        ({"dtype": "int32"}, errors.InvalidOptionError, "not int32"),
        ({"dtype": "nonsense"}, errors.InvalidOptionError, "'nonsense'"),
        ({"max_distance": "far"}, errors.InvalidOptionError, "'far'"),
        ({"max_distance": float("nan")}, errors.InvalidOptionError, "not nan"),
        ({"max_distance": float("inf")}, errors.InvalidOptionError, "not inf"),
        ({"max_distance": -0.1}, errors.InvalidOptionError, "not -0.1"),
        ({"out": "D.txt"}, errors.InvalidOptionError, "cannot write .txt"),
        ({"out": 3}, errors.InvalidOptionError, "must be text or a path, not 3"),
        ({"out": "D.npz"}, errors.InvalidOptionError, "give max_distance"),
        ({"out": "D.npy", "max_distance": 1}, errors.InvalidOptionError, "write a .npz"),
        ({"out": "no/such/folder/D.npy"}, errors.WriteError, "no directory"),
        ({"out": "no/such/folder/D.zarr"}, errors.WriteError, "no directory"),
        ({"out": "folder.npy"}, errors.WriteError, "is a directory"),
        ({"out": "folder.zarr"}, errors.WriteError, "is not a zarr store"),
        ({"out": "file.zarr"}, errors.WriteError, "is not a zarr store"),
        ({"sources": []}, errors.InvalidSourceError, "no source sets"),
        ({"sources": [0, 162]}, errors.InvalidSourceError, "set 1: vertex 162"),
        ({"sources": 3}, errors.InvalidSourceError, "must be a sequence"),
        ({"targets": [162]}, errors.InvalidSourceError, "targets: vertex 162"),
        ({"targets": []}, errors.InvalidSourceError, "targets: there are none"),
        ({"targets": [0.5]}, errors.InvalidSourceError, "targets must be"),
    ],
)
def test_a_bad_request_is_refused_before_any_work(
    solver, tmp_path, monkeypatch, options, error, message
):
    monkeypatch.chdir(tmp_path)
    Path("folder.npy").mkdir()
    Path("folder.zarr").mkdir()
    Path("file.zarr").touch()
    monkeypatch.setattr(type(solver), "distances", None)
    with pytest.raises(error, match=message):
        gt.distance_matrix(solver, **options)
    assert not list(tmp_path.glob("*.partial"))


def test_a_masked_source_is_refused(solver):
    masked = gt.GeodesicSolver(shapes.icosphere(2), mask=np.arange(162) == 5)
    with pytest.raises(errors.InvalidSourceError, match="vertex 5 is masked"):
        gt.distance_matrix(masked, [4, 5])


def test_zarr_is_asked_for_by_name(solver, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(errors.MissingDependencyError, match=r"geodesic-toolkit\[zarr\]"):
        gt.distance_matrix(solver, out=tmp_path / "D.zarr")


def test_a_matrix_that_does_not_fit_says_what_would(solver, monkeypatch):
    monkeypatch.setattr(memory, "MIN_BYTES_CHECKED", 0.0)
    monkeypatch.setattr(memory, "available_memory", lambda: 1000.0)
    with pytest.raises(errors.NotEnoughMemoryError, match=r"162 x 162 .*\.zarr.*max_distance"):
        gt.distance_matrix(solver)


def test_a_disk_that_is_too_small_is_noticed_before_the_work(solver, tmp_path, monkeypatch):
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage)
    with pytest.raises(errors.WriteError, match="are free in"):
        gt.distance_matrix(solver, out=tmp_path / "D.npy")


def test_a_disk_that_is_full_later_is_an_error_that_leaves_what_is_done(
    solver, tmp_path, monkeypatch
):
    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(stores.os, "fsync", full)
        with pytest.raises(errors.WriteError, match="No space left"):
            gt.distance_matrix(solver, out=tmp_path / "D.npy")
    assert gt.distance_matrix(solver, out=tmp_path / "D.npy").shape == (162, 162)
