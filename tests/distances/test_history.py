"""Results do not depend on earlier work of the process or of another one."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.testing import shapes


def in_a_new_process(program, *arguments):
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout


def answers(mesh):
    """Return what a mesh is asked in these tests: plain and refined, one source and many."""
    plain, refined = gt.GeodesicSolver(mesh), gt.GeodesicSolver(mesh, refine=True)
    sources = list(range(0, 160, 10))
    return [plain.distance(7), plain.distances(sources), refined.distance(7)]


@pytest.mark.slow
def test_a_mesh_reads_the_same_after_a_large_one():
    mesh = shapes.icosphere(2)
    before = answers(mesh)
    large = gt.GeodesicSolver(shapes.grid(260))
    large.distances(list(range(40)))
    after = answers(gt.TriangleMesh(mesh.vertices, mesh.faces))
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_a_mesh_reads_the_same_in_a_new_process(tmp_path):
    program = """
        import sys
        import numpy as np
        import geodesic_toolkit as gt
        mesh = gt.testing.shapes.icosphere(2)
        plain, refined = gt.GeodesicSolver(mesh), gt.GeodesicSolver(mesh, refine=True)
        sources = list(range(0, 160, 10))
        np.savez(sys.argv[1], plain.distance(7), plain.distances(sources), refined.distance(7))
    """
    in_a_new_process(program, tmp_path / "there.npz")
    there = np.load(tmp_path / "there.npz")
    here = answers(shapes.icosphere(2))
    for name, one in zip(there.files, here, strict=True):
        np.testing.assert_array_equal(one, there[name])


@pytest.mark.slow
def test_auto_is_the_same_solver_whatever_was_done_before():
    expected = gt.Supernodal(compact=True)  # heat gives an order only
    assert gt.GeodesicSolver(shapes.icosphere(1)).method.heat_solver == expected
    program = """
        import geodesic_toolkit as gt
        print(gt.GeodesicSolver(gt.testing.shapes.icosphere(1)).method.heat_solver)
    """
    assert in_a_new_process(program).strip() == repr(expected)


@pytest.mark.slow
@pytest.mark.parametrize("refine", [False, True])
def test_a_matrix_is_resumed_in_a_new_process_after_unrelated_work(tmp_path, refine):
    mesh = shapes.icosphere(2)
    solver = gt.GeodesicSolver(mesh, refine=refine)
    whole = gt.distance_matrix(solver, symmetrize=None)

    def stop(done, total):
        if done >= 64:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gt.distance_matrix(solver, symmetrize=None, out=tmp_path / "D.npy", progress=stop)
    program = """
        import sys
        import geodesic_toolkit as gt
        gt.GeodesicSolver(gt.testing.shapes.grid(160)).distances(range(20))
        mesh, first = gt.testing.shapes.icosphere(2), []
        solver = gt.GeodesicSolver(mesh, refine=bool(int(sys.argv[2])))
        progress = lambda done, total: first.append(done)
        gt.distance_matrix(solver, symmetrize=None, out=sys.argv[1], progress=progress)
        print(first[0])
    """
    first = int(in_a_new_process(program, tmp_path / "D.npy", int(refine)))
    assert first >= 64  # it went on from what was there
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), whole)
