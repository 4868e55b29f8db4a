"""Reports of checks of a back end: figures, declared failures, errors that name the fault."""

import subprocess
import sys
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from wrong_operators import MESH_SAMPLES
from wrong_solvers import Modest, WrongSolver

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ConformanceError, GeodesicError, InvalidOptionError
from geodesic_toolkit.testing.conformance import Measured, worst


def one(checks, law):
    (found,) = [check for check in checks if check.law == law]
    return found


def test_the_error_lists_every_broken_law_with_its_figure_and_bound():
    identity = gt.CotanLaplacian(mass="identity")
    with pytest.raises(ConformanceError) as caught:
        gt.testing.check_laplace_operator(identity)
    message = str(caught.value)
    assert "32 of 37 laws" in message
    for law in (
        "mass_adds_up_to_the_measure",
        "energy_of_the_positions_is_the_mass",
        "distance_is_accurate",
        "error_decreases_under_refinement",
        "scaling_the_shape_scales_the_result",
    ):
        assert f"{law} is broken" in message
    assert "440 (at most 0.1)" in message
    assert isinstance(caught.value, GeodesicError)
    assert isinstance(caught.value, AssertionError)


def test_a_check_called_as_a_test_raises_with_the_figure():
    checks = gt.testing.laplace_operator_checks(gt.CotanLaplacian(mass="identity"))
    with pytest.raises(
        ConformanceError, match=r"distance_is_accurate is broken: 0.12 \(at most 0.05"
    ):
        one(checks, "distance_is_accurate")()


def test_the_report_names_the_law_that_a_solver_breaks():
    with pytest.raises(ConformanceError, match="factor_tells_its_size is broken"):
        gt.testing.check_linear_solver(WrongSolver(fault="weightless"))


def test_an_expected_failure_passes_and_keeps_its_reason():
    checks = gt.testing.linear_solver_checks(
        WrongSolver(fault="weightless"), expected_failures={"factor_tells_its_size": "it is a view"}
    )
    outcome = one(checks, "factor_tells_its_size").run()
    assert outcome.ok
    assert not outcome.held
    assert "fails as declared (it is a view)" in str(outcome)


def test_an_expected_failure_that_passes_is_reported():
    with pytest.raises(ConformanceError, match="holds, but is declared to fail"):
        gt.testing.check_linear_solver(
            gt.SuperLU(), expected_failures={"factor_tells_its_size": "once it did not"}
        )


@pytest.mark.slow
def test_an_expected_failure_of_a_law_that_does_not_apply_is_reported():
    with pytest.raises(ConformanceError, match="tiny_entries_are_resolved"):
        gt.testing.check_linear_solver(
            gt.CG(), expected_failures={"tiny_entries_are_resolved": "conjugate gradients"}
        )


def test_an_operator_may_declare_its_known_failures_itself():
    report = gt.testing.check_linear_solver(Modest(fault="weightless"))
    assert [row.expected_failure for row in report.outcomes if not row.held] == ["it is a view"]


def test_declaring_the_failure_of_an_unknown_law_is_an_error():
    with pytest.raises(InvalidOptionError, match="stiffness_is_blue"):
        gt.testing.laplace_operator_checks(
            gt.CotanLaplacian(), expected_failures={"stiffness_is_blue": "it is red"}
        )


@pytest.mark.parametrize("other", [gt.CotanLaplacian, "cotan", None])
def test_only_an_instance_of_an_operator_can_be_checked(other):
    with pytest.raises(InvalidOptionError, match="instance of a LaplaceOperator"):
        gt.testing.laplace_operator_checks(other)


@pytest.mark.parametrize("other", [gt.SuperLU, "superlu", None])
def test_only_an_instance_of_a_solver_can_be_checked(other):
    with pytest.raises(InvalidOptionError, match="instance of a LinearSolver"):
        gt.testing.linear_solver_checks(other)


class Cube(gt.Domain):
    """A kind of domain that the core does not know."""

    @property
    def n_vertices(self):
        return 8


@dataclass(frozen=True, kw_only=True)
class CubeLaplacian(gt.LaplaceOperator):
    domains: ClassVar = (Cube,)

    def assemble(self, domain):
        raise AssertionError("it is not reached")


def test_a_new_kind_of_domain_needs_samples_of_its_own():
    with pytest.raises(InvalidOptionError, match=r"no samples of Cube: pass samples="):
        gt.testing.laplace_operator_checks(CubeLaplacian())


def test_an_operator_that_raises_breaks_its_laws_and_the_report_says_what_it_raised():
    report = gt.testing.run_checks(
        CubeLaplacian(), gt.testing.laplace_operator_checks(CubeLaplacian(), samples=MESH_SAMPLES)
    )
    broken = {row.law: row for row in report.broken}
    assert broken["stiffness_is_symmetric"].where == "AssertionError: it is not reached"
    assert "recipe_is_frozen_data" not in broken


def test_a_report_is_plain_data_for_json():
    checks = [
        gt.testing.Check("a", "A.", lambda: Measured(np.inf, 1.0, "here")),
        gt.testing.Check("b", "B.", lambda: Measured(0.5, 1.0, "there")),
        gt.testing.Check("c", "C.", lambda: None),
    ]
    report = gt.testing.run_checks("subject", checks)
    plain = report.as_dict()
    assert not plain["ok"]
    assert [row["figure"] for row in plain["laws"]] == [None, 0.5, None]
    assert [row["ok"] for row in plain["laws"]] == [False, True, True]
    assert [row.applies for row in report.outcomes] == [True, True, False]


def test_nan_is_worse_than_any_figure_and_breaks_the_law():
    measured = worst([Measured(3.0, 1.0, "a"), Measured(np.nan, 1.0, "b"), Measured(0.0, 0.0, "c")])
    assert measured.where == "b"
    assert not measured.holds


def test_of_nothing_there_is_no_worst():
    assert worst([]) is None


def test_an_outcome_says_the_law_the_figure_and_the_bound():
    text = str(
        one(gt.testing.linear_solver_checks(gt.SuperLU()), "singular_matrices_are_refused").run()
    )
    assert text.startswith("singular_matrices_are_refused holds: 0 (at most 0)")


@pytest.mark.slow
def test_the_kit_does_not_need_a_test_framework():
    code = "import sys, geodesic_toolkit.testing; sys.exit('pytest' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_solver_that_does_not_claim_small_entries_is_not_measured_on_them():
    outcome = one(gt.testing.linear_solver_checks(gt.CG()), "tiny_entries_are_resolved").run()
    assert outcome.ok
    assert outcome.figure is None
