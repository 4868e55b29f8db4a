"""Several processes: the program runs once, all help, and none waits for ever."""

import numpy as np
import pytest

import geodesic_toolkit as gt

PRELUDE = """
import sys
import numpy as np
import geodesic_toolkit as gt
from geodesic_toolkit.errors import SolverError
from geodesic_toolkit_petsc import MUMPS, PETSc, peak_memory, processes
from geodesic_toolkit_petsc.processes import processes as job
"""

FAIL = """
def fail(library, parts, *, data, early):
    is_second = library.communicator.Get_rank() == 1
    if early and is_second:
        raise MemoryError("no memory for 7 rows")
    yield
    if is_second:
        raise ValueError("it is wrong")
    library.communicator.Barrier()
"""


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    torus = gt.testing.shapes.bumpy_torus(rng=np.random.default_rng(0))
    path = tmp_path_factory.mktemp("mesh") / "torus.ply"
    gt.write(path, torus, np.zeros(torus.n_vertices))
    return path


def test_the_contract_holds_on_two_processes(run_on):
    ended = run_on(
        2,
        PRELUDE
        + """
for solver in (PETSc(), MUMPS()):
    if solver.leads():
        print(gt.testing.check_linear_solver(solver).ok)
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["True"] * 2


def test_there_may_be_more_processes_than_unknowns(run_on):
    ended = run_on(
        3,
        PRELUDE
        + """
from scipy.sparse import csr_array
for solver in (PETSc(), PETSc(preconditioner="gamg"), MUMPS()):
    if solver.leads():
        factor = solver.factorize(csr_array([[2.0, -1.0], [-1.0, 2.0]]))
        print(*factor.solve(np.array([1.0, 1.0])).round(9))
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["1.0"] * 6


@pytest.mark.parametrize("solver", ["petsc", "petsc-mumps"])
def test_the_command_line_agrees_with_one_process_and_writes_once(
    run_program, mesh, tmp_path, solver
):
    output = tmp_path / "distance.npy"
    arguments = ["--source", 5, "--no-refine", "--output", output]
    ended = run_program(2, "distance", mesh, *arguments, "--solver", solver)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("wrote") == ended.stdout.count("method") == 1
    exact = gt.GeodesicSolver(gt.read(mesh), refine=False, solver=gt.Supernodal(compact=False))
    expected = exact.distance(5)
    assert np.abs(np.load(output) - expected).max() < 1e-6 * expected.max()
    assert [path.name for path in tmp_path.iterdir()] == ["distance.npy"]


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--source", 10**6], 2, "vertex 1000000 does not exist"),
        (["--source", 0, "--output", "nowhere/d.npy"], 2, "there is no directory"),
    ],
)
def test_an_error_of_the_program_is_said_once_and_ends_all(
    run_program, mesh, arguments, status, message
):
    ended = run_program(2, "distance", mesh, *arguments, "--solver", "petsc")
    assert ended.returncode == status
    assert ended.stderr.count(message) == 1
    assert ended.stdout == ""


def test_a_file_that_cannot_be_read_ends_all(run_program, tmp_path):
    broken = tmp_path / "broken.ply"
    broken.write_text("ply\n", encoding="utf-8")
    ended = run_program(2, "distance", broken, "--source", 0, "--solver", "petsc")
    assert ended.returncode == 3
    assert ended.stderr.count("error: ") == 1


def test_helping_processes_end_where_a_script_first_factorises(run_on):
    ended = run_on(
        3,
        PRELUDE
        + """
distance = gt.geodesic_distance(gt.testing.shapes.icosphere(3), 0, solver="petsc", refine=False)
print(distance.argmax(), "of one process")
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("of one process") == 1


def test_no_process_has_most_of_the_matrix_or_the_factor(run_on):
    ended = run_on(
        2,
        PRELUDE
        + """
def shares(library, parts, *, data, system):
    yield
    part = parts[system]
    factor = part.solver.getPC().getFactorMatrix()
    own = part.matrix.getLocalSize()[0], factor.getMumpsInfo(27)
    return library.communicator.gather(own)

if MUMPS().leads():
    ball = gt.CotanLaplacian().assemble(gt.testing.shapes.icosphere(6))
    from scipy.sparse import csr_array, diags_array
    factor = MUMPS().factorize(csr_array(ball.stiffness + diags_array(ball.mass)))
    for rows, entries in job().run(shares, system=factor._system):
        print(rows / ball.n_vertices < 0.6 and 0 < entries < 0.8 * factor.nnz)
    print(sum(entries for _, entries in job().run(shares, system=factor._system)) == factor.nnz)
    print(len(peak_memory()) == 2)
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["True"] * 4


def test_a_failure_on_one_process_before_the_common_part_is_an_error_and_work_goes_on(run_on):
    ended = run_on(
        2,
        PRELUDE
        + FAIL
        + """
if PETSc().leads():
    try:
        job().run(fail, early=True)
    except MemoryError as error:
        print(type(error).__name__, error)
    distance = gt.geodesic_distance(gt.testing.shapes.icosphere(3), 0, solver="petsc")
    print(distance.max().round(2))
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines() == [
        "NotEnoughMemoryError process 1 of 2: no memory for 7 rows",
        "3.12",
    ]


def test_a_failure_on_one_process_for_which_others_wait_ends_the_job(run_on):
    ended = run_on(
        2,
        PRELUDE
        + FAIL
        + """
sys.modules["geodesic_toolkit_petsc.processes"].PATIENCE = 0.5
if PETSc().leads():
    job().run(fail, early=False)
    print("never")
""",
    )
    assert ended.returncode != 0
    assert "error: process 1 of 2: ValueError: it is wrong" in ended.stderr
    assert "never" not in ended.stdout


def test_an_exception_of_process_0_within_an_operation_ends_the_job(run_on):
    ended = run_on(
        2,
        PRELUDE
        + """
def interrupted(library, parts, *, data):
    if library.communicator.Get_rank() == 0:
        raise KeyboardInterrupt
    yield

if PETSc().leads():
    try:
        job().run(interrupted)
    except KeyboardInterrupt:
        pass
    try:
        MUMPS().factorize(gt.CotanLaplacian().assemble(gt.testing.shapes.icosphere(0)).stiffness)
    except SolverError as error:
        print(error, flush=True)
""",
    )
    assert ended.returncode != 0
    assert "the processes of this job are broken by an interrupt" in ended.stdout


def test_a_pool_of_processes_is_refused(run_program, mesh, tmp_path):
    arguments = ["--landmarks", 4, "--workers", 2, "--output", tmp_path / "matrix.npy"]
    ended = run_program(2, "matrix", mesh, *arguments, "--solver", "petsc")
    assert ended.returncode == 4, ended.stderr
    assert "a process of a pool cannot use PETSc" in ended.stderr
