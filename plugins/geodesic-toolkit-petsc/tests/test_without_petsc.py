import subprocess
import sys

import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError, SolverError
from geodesic_toolkit_petsc import MUMPS, PETSc, solvers
from geodesic_toolkit_petsc import library as loading


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"preconditioner": "ilu"}, "preconditioner must be one of hypre, gamg"),
        ({"heat": "lu"}, "heat must be one of mumps, cg"),
        ({"rtol": 0.0}, "rtol must lie between 0 and 1"),
        ({"rtol": float("nan")}, "rtol must lie between 0 and 1"),
        ({"max_iterations": 0}, "max_iterations must be positive"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(InvalidOptionError, match=message):
        PETSc(**options)


def test_both_solvers_are_found_by_name_without_importing_petsc():
    asked = (
        "import sys, geodesic_toolkit as gt; gt.solvers['petsc'](); gt.solvers['petsc-mumps'](); "
        "raise SystemExit('petsc4py' in sys.modules or 'mpi4py' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", asked], check=False).returncode == 0


@pytest.fixture
def without_petsc(monkeypatch):
    monkeypatch.setitem(sys.modules, "petsc4py", None)
    loading.library.cache_clear()
    solvers.processes.cache_clear()
    yield
    loading.library.cache_clear()
    solvers.processes.cache_clear()


@pytest.mark.parametrize("solver", [PETSc(), MUMPS()], ids=repr)
def test_where_petsc_is_absent_the_error_says_what_to_install(without_petsc, solver):
    with pytest.raises(MissingDependencyError, match="apt-get install libpetsc-real-dev"):
        gt.geodesic_distance(gt.testing.shapes.icosphere(1), 0, solver=solver)
    with pytest.raises(MissingDependencyError, match="petsc4py"):
        solver.leads()


def test_a_pool_in_a_job_of_several_processes_is_refused(without_petsc, monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    monkeypatch.setattr(loading.multiprocessing, "parent_process", object)
    with pytest.raises(SolverError, match="a process of a pool cannot use PETSc in a job of 2"):
        PETSc().leads()
