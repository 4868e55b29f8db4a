"""Does every built-in keep the contract, and does a wrong one break the very law that it should?"""

import pytest
from wrong_operators import IMPLIED, MESH_SAMPLES, WRONG_OPERATORS, Mutant
from wrong_solvers import IMPLIED_BY_SOLVERS, WRONG_SOLVERS, WrongSolver

import geodesic_toolkit as gt
from geodesic_toolkit.testing.laplace_operator import OPERATOR_LAWS
from geodesic_toolkit.testing.linear_solver import SOLVER_LAWS

IDENTITY = "the identity mass knows nothing of lengths: it is for the diffusion of another metric"
NO_SCALE = dict.fromkeys(
    [
        "energy_of_the_positions_is_the_mass",
        "distance_is_accurate",
        "error_decreases_under_refinement",
        "scaling_the_shape_scales_the_result",
    ],
    IDENTITY,
)

OPERATORS = [
    (gt.CotanLaplacian(), {}),
    (gt.CotanLaplacian(mass="voronoi"), {}),
    (gt.CotanLaplacian(intrinsic_delaunay=True), {}),
    (gt.CotanLaplacian(intrinsic_delaunay="auto"), {}),
    (gt.CotanLaplacian(mass="identity"), {**NO_SCALE, "mass_adds_up_to_the_measure": IDENTITY}),
    (gt.UniformLaplacian(), {}),
    (
        gt.UniformLaplacian(mass="identity"),
        {**NO_SCALE, "unit_has_the_slope_of_the_plane": IDENTITY},
    ),
]

SOLVERS = [
    gt.SuperLU(),
    gt.Supernodal(),
    gt.CG(),
    gt.CG(rtol=1e-10, max_iterations=5000),
    gt.CG(allow_heat=True),
]


def names(laws):
    return [law.__name__ for law in laws]


def broken_laws(checks):
    return {check.law for check in checks if not check.run().ok}


@pytest.mark.parametrize(
    "check",
    [
        pytest.param(check, id=f"{operator}-{check}")
        for operator, expected in OPERATORS
        for check in gt.testing.laplace_operator_checks(operator, expected_failures=expected)
    ],
)
def test_every_operator_of_the_core_keeps_the_contract(check):
    check()


@pytest.mark.parametrize("name", sorted(gt.operators))
def test_every_registered_operator_keeps_the_contract_by_its_name(name):
    assert gt.testing.check_laplace_operator(gt.operators[name]()).ok


@pytest.mark.parametrize(
    "check",
    [
        pytest.param(check, id=f"{solver}-{check}")
        for solver in SOLVERS
        for check in gt.testing.linear_solver_checks(solver)
    ],
)
def test_every_solver_of_the_core_keeps_the_contract(check):
    check()


# Those of plugins have tests of their own: one of them starts MPI in its process, for good.
@pytest.mark.parametrize(
    "name", [each for each in gt.solvers if f"geodesic-toolkit:{each}" in gt.solvers]
)
def test_every_solver_of_the_core_keeps_the_contract_by_its_name(name):
    assert gt.testing.check_linear_solver(gt.solvers[name]()).ok


# -- wrong ones, one a law ------------------------------------------------------------------------


def test_there_is_a_wrong_operator_for_every_law():
    assert set(WRONG_OPERATORS) == set(names(OPERATOR_LAWS))


@pytest.mark.parametrize("law", names(OPERATOR_LAWS))
def test_a_wrong_operator_breaks_its_law_and_no_other(law):
    checks = gt.testing.laplace_operator_checks(WRONG_OPERATORS[law], samples=MESH_SAMPLES)
    broken = broken_laws(checks)
    assert law in broken
    assert broken <= {law} | IMPLIED.get(law, set())


def test_a_right_operator_in_the_same_clothes_breaks_no_law():
    assert gt.testing.check_laplace_operator(Mutant()).ok


def test_there_is_a_wrong_solver_for_every_law():
    assert set(WRONG_SOLVERS) == set(names(SOLVER_LAWS))


@pytest.mark.parametrize("law", names(SOLVER_LAWS))
def test_a_wrong_solver_breaks_its_law_and_no_other(law):
    broken = broken_laws(gt.testing.linear_solver_checks(WRONG_SOLVERS[law]))
    assert law in broken
    assert broken <= {law} | IMPLIED_BY_SOLVERS.get(law, set())


def test_a_right_solver_in_the_same_clothes_breaks_no_law():
    assert gt.testing.check_linear_solver(WrongSolver()).ok
