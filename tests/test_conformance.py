"""Does every built-in keep the contract, and does a wrong one break the very law that it should?"""

import json
import subprocess
import sys
import threading
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array, diags_array, vstack

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ConformanceError, GeodesicError, InvalidOptionError
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.testing.conformance import Measured, worst
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


@pytest.mark.parametrize("name", sorted(gt.solvers))
def test_every_registered_solver_keeps_the_contract_by_its_name(name):
    assert gt.testing.check_linear_solver(gt.solvers[name]()).ok


def test_a_solver_that_does_not_claim_small_entries_is_not_measured_on_them():
    outcome = one(gt.testing.linear_solver_checks(gt.CG()), "tiny_entries_are_resolved").run()
    assert outcome.ok
    assert outcome.figure is None


# -- wrong operators, one a law --------------------------------------------------------------------


class Tampered(gt.Gradient):
    """A gradient of a third kind: another one with a fault, and perhaps with one more row."""

    def __init__(self, base: gt.Gradient, fault: str, row=None, weight: float = 0.0) -> None:
        self.base = base
        self.fault = fault
        self.row = row
        self.weight = weight

    @property
    def n_vertices(self) -> int:
        return self.base.n_vertices

    def unit(self, log_heat):
        if self.fault == "heat of a narrow range":
            with np.errstate(divide="ignore"):
                log_heat = np.log(np.exp(log_heat))
        unit = self.base.unit(log_heat)
        if self.fault == "no slope in slow heat" and np.ptp(log_heat) < 1.0:
            return np.zeros_like(unit)
        if self.fault == "slope of the first column for all" and log_heat.ndim == 2:
            return np.repeat(unit[..., :1], log_heat.shape[1], axis=-1)
        if self.fault == "too short":
            return unit * (0.95 if self.n_vertices > 300 else 0.91)
        if self.fault == "shorter on fine meshes":
            return unit * (0.975 if self.n_vertices > 300 else 1.0)
        if self.row is not None:
            rows = unit.reshape(-1, *log_heat.shape[1:])
            return np.concatenate([rows, np.zeros((1, *log_heat.shape[1:]))])
        return unit

    def adjoint(self, x):
        if self.row is not None:
            weights = self.weights.reshape(-1, *(1,) * (x.ndim - 1))
            return self.matrix.T @ (weights * x)
        pull = self.base.adjoint(x)
        if self.fault == "a column where there is none" and pull.ndim == 1:
            return pull[:, None]
        return pull * (1 + 1e-6) if self.fault == "adjoint of something else" else pull

    @property
    def matrix(self):
        if self.fault == "by columns":
            return self.base.matrix.tocsc()
        if self.row is None:
            return self.base.matrix
        return csr_array(vstack([self.base.matrix, csr_array(self.row[None, :])]))

    @property
    def weights(self):
        if self.row is None:
            return self.base.weights
        return np.append(self.base.weights, self.weight)

    def stiffness(self):
        weighted = csr_array(self.matrix.multiply(self.weights[:, None]))
        return csr_array(self.matrix.T @ weighted)


def with_gradient(fault):
    return lambda given, domain: replace(given, gradient=Tampered(given.gradient, fault))


def with_mass(change):
    return lambda given, domain: replace(given, mass=change(given.mass.copy(), domain))


def with_stiffness(change):
    return lambda given, domain: replace(given, stiffness=csr_array(change(given.stiffness)))


def with_measure(factor, mass_factor):
    def tamper(given, domain):
        was = given.gradient
        measure = factor * was.measure
        gradient = ElementGradient(was.elements, was.coefficients, measure, was.n_vertices)
        return replace(
            given, gradient=gradient, stiffness=gradient.stiffness(), mass=mass_factor * given.mass
        )

    return tamper


def one_entry(stiffness, row, column, value):
    entry = coo_array(([value], ([row], [column])), shape=stiffness.shape)
    return stiffness + entry


def writeable(given, domain):
    data = replace(given, mass=given.mass.copy())
    data.mass.setflags(write=True)
    return data


def without_least_mass(mass, domain):
    mass[mass.argmin()] = 0.0
    return mass


def steep_constants(given, domain):
    """Add a row that does not send constants to zero, and that weighs nothing."""
    row = np.eye(1, given.n_vertices)[0]
    return replace(given, gradient=Tampered(given.gradient, "constants have a slope", row))


def repulsion(weight):
    """Give one long edge of a flat mesh a negative weight: from its middle to a corner."""

    def tamper(given, domain):
        away = np.linalg.norm(domain.vertices - domain.vertices.mean(axis=0), axis=1)
        ends = [away.argmin(), away.argmax()]
        if given.n_vertices < 50 or not given.boundary.any() or np.ptp(given.components[ends]) > 0:
            return given
        row = np.zeros(given.n_vertices)
        row[ends] = [-1.0, 1.0]
        gradient = Tampered(given.gradient, "repulsion", row, -weight)
        return replace(given, gradient=gradient, stiffness=gradient.stiffness())

    return tamper


def joined(given, domain):
    """Connect the first and the last vertex, so weakly that only components notice."""
    ends, count = [0, given.n_vertices - 1], given.n_vertices
    weak = np.array([1.0, 1.0, -1.0, -1.0]) * 1e-14 * given.stiffness.data.max()
    link = coo_array((weak, (ends + ends, ends + ends[::-1])), shape=(count, count))
    return replace(given, stiffness=csr_array(given.stiffness + link))


def noisy(given, domain):
    noise = 1e-13 * np.random.default_rng().random(given.n_vertices)
    return replace(given, mass=given.mass * (1 + noise))


def in_transit(given, domain):
    return replace(given, gradient=Forgetful(given.gradient, "none"))


class Forgetful(Tampered):
    """A gradient that loses weight on its way through pickle."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self.fault = "lost"

    @property
    def matrix(self):
        return self.base.matrix * 2 if self.fault == "lost" else self.base.matrix


def numbered(mass, domain):
    return mass * (1 + 1e-5 * np.linspace(0, 1, len(mass)))


def oriented(mass, domain):
    return mass * (1 + 1e-4 * np.tanh(domain.vertices[:, 0] / np.abs(domain.vertices).max()))


MUTANTS = {
    "shapes_fit": with_gradient("a column where there is none"),
    "dtypes_are_the_agreed_ones": with_gradient("by columns"),
    "arrays_are_read_only": writeable,
    "pickled_data_is_the_same": in_transit,
    "assembly_is_deterministic": noisy,
    "mass_is_positive": with_mass(without_least_mass),
    "mass_adds_up_to_the_measure": with_measure(2.0, 2.0),
    "energy_of_the_positions_is_the_mass": with_measure(1.3, 1.0),
    "stiffness_is_symmetric": with_stiffness(
        lambda s: one_entry(one_entry(s, 0, 1, 1e-11), 0, 0, -1e-11)
    ),
    "stiffness_is_positive_semidefinite": repulsion(0.9),
    "stiffness_sends_constants_to_zero": with_stiffness(
        lambda s: s + 1e-10 * diags_array(s.diagonal())
    ),
    "gradient_sends_constants_to_zero": steep_constants,
    "stiffness_is_that_of_the_gradient": with_stiffness(lambda s: s * (1 + 1e-6)),
    "adjoint_is_that_of_the_gradient": with_gradient("adjoint of something else"),
    "unit_has_the_slope_of_the_plane": with_gradient("no slope in slow heat"),
    "unit_depends_on_ratios_only": with_gradient("heat of a narrow range"),
    "blocks_equal_their_columns": with_gradient("slope of the first column for all"),
    "spacing_is_the_edge_length": lambda given, domain: replace(given, spacing=given.spacing / 2.1),
    "heat_is_positive": repulsion(0.02),
    "distance_is_accurate": with_gradient("too short"),
    "error_decreases_under_refinement": with_gradient("shorter on fine meshes"),
    "disconnected_parts_are_infinitely_far": joined,
    "permuting_the_vertices_permutes_the_result": with_mass(numbered),
    "moving_the_shape_changes_nothing": with_mass(oriented),
    "scaling_the_shape_scales_the_result": lambda given, domain: replace(
        given, spacing=given.spacing + 1e-3
    ),
}


@dataclass(frozen=True, kw_only=True)
class Mutant(gt.LaplaceOperator):
    """The cotangent Laplacian with one fault, named after the law that it breaks."""

    breaks: str = "nothing"

    domains: ClassVar = (gt.TriangleMesh,)

    def assemble(self, domain):
        given = gt.CotanLaplacian().assemble(domain)
        return MUTANTS[self.breaks](given, domain) if self.breaks in MUTANTS else given


@dataclass(frozen=True, kw_only=True)
class Demanding(Mutant):
    """An option without a default: ``Demanding()`` does not work."""

    mandatory: int


@dataclass(frozen=True, kw_only=True, eq=False)
class NeverEqual(Mutant):
    __eq__ = object.__eq__
    __hash__ = object.__hash__


@dataclass(frozen=True, kw_only=True)
class Secretive(Mutant):
    def __repr__(self):
        return "an operator"


@dataclass(frozen=True, kw_only=True)
class Homesick(Mutant):
    distance_travelled: int = 0

    def __reduce__(self):
        return travelled, (self.distance_travelled,)


def travelled(distance):
    return Homesick(distance_travelled=distance + 1)


@dataclass(frozen=True, kw_only=True)
class Anywhere(Mutant):
    domains: ClassVar = [gt.TriangleMesh]

    def check_domain(self, domain):
        gt.CotanLaplacian().check_domain(domain)


@dataclass(frozen=True, kw_only=True)
class Rude(Mutant):
    def assemble(self, domain):
        if not isinstance(domain, gt.TriangleMesh):
            raise ValueError("no")  # noqa: TRY004 - that is its fault
        return super().assemble(domain)


@dataclass(frozen=True, kw_only=True)
class Fragile(Mutant):
    def assemble(self, domain):
        if isinstance(domain, gt.TriangleMesh) and domain.n_vertices < 4:
            raise IndexError("index 3 is out of bounds")
        return super().assemble(domain)


RECIPE_MUTANTS = {
    "recipe_is_frozen_data": Demanding(mandatory=1),
    "equal_recipes_are_equal": NeverEqual(),
    "recipe_survives_pickling": Homesick(),
    "repr_says_what_it_is": Secretive(),
    "other_domains_are_refused_by_name": Rude(),
    "degenerate_domains_are_assembled_or_refused": Fragile(),
}

MESH_SAMPLES = gt.testing.samples_of([gt.TriangleMesh])

WRONG_OPERATORS = {
    **{law: Mutant(breaks=law) for law in MUTANTS},
    **RECIPE_MUTANTS,
    "domains_are_kinds_of_domain": Anywhere(),
}

IMPLIED = {
    # Where L has a negative eigenvalue, heat and distance are meaningless.
    "stiffness_is_positive_semidefinite": {
        "heat_is_positive",
        "distance_is_accurate",
        "error_decreases_under_refinement",
        "permuting_the_vertices_permutes_the_result",
        "energy_of_the_positions_is_the_mass",
    },
}


def broken_laws(checks):
    return {check.law for check in checks if not check.run().ok}


def one(checks, law):
    (found,) = [check for check in checks if check.law == law]
    return found


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


# -- wrong solvers, one a law ----------------------------------------------------------------------


class Tricked(gt.Factor):
    """The factor of SuperLU with a fault."""

    def __init__(self, base, matrix, fault):
        self.base = base
        self.matrix = matrix
        self.fault = fault
        self.solves = 0

    def solve(self, b):
        self.solves += 1
        solution = self.base.solve(b)
        if self.fault == "inaccurate":
            return solution * (1 + 1e-5)
        if self.fault == "first column counts" and b.ndim == 2:
            return solution * (1 + 1e-9 * np.arange(b.shape[1]))
        if self.fault == "single precision":
            return solution.astype(np.longdouble)
        if self.fault == "memory order" and not b.flags.c_contiguous:
            return solution * (1 + 1e-9)
        if self.fault == "wears out":
            return solution * (1 + 1e-11 * self.solves)
        if self.fault == "threads" and threading.current_thread() is not threading.main_thread():
            return solution * (1 + 1e-9)
        if self.fault == "coarse":
            return solution + 1e-14 * np.abs(solution).max(initial=0.0)
        return solution

    @property
    def nnz(self):
        return self.base.nnz

    @property
    def nbytes(self):
        return 0 if self.fault == "weightless" else self.base.nbytes


@dataclass(frozen=True, kw_only=True)
class WrongSolver(gt.LinearSolver):
    """SuperLU with one fault."""

    fault: str = "none"

    componentwise: ClassVar = True

    def factorize(self, matrix):
        if self.fault == "regularised":
            hollow = np.where(abs(matrix).sum(axis=1) > 0, 0.0, 1.0)
            matrix = csr_array(matrix + diags_array(hollow))
        return Tricked(gt.SuperLU().factorize(matrix), matrix, self.fault)


@dataclass(frozen=True, kw_only=True)
class Hesitant(WrongSolver):
    componentwise: ClassVar = "perhaps"


@dataclass(frozen=True, kw_only=True)
class DemandingSolver(WrongSolver):
    mandatory: int


@dataclass(frozen=True, kw_only=True)
class NeverEqualSolver(WrongSolver):
    __eq__ = object.__eq__
    __hash__ = object.__hash__


@dataclass(frozen=True, kw_only=True)
class SecretiveSolver(WrongSolver):
    def __repr__(self):
        return "a solver"


@dataclass(frozen=True, kw_only=True)
class HomesickSolver(WrongSolver):
    distance_travelled: int = 0

    def __reduce__(self):
        return travelled_solver, (self.distance_travelled,)


def travelled_solver(distance):
    return HomesickSolver(distance_travelled=distance + 1)


WRONG_SOLVERS = {
    "recipe_is_frozen_data": DemandingSolver(mandatory=1),
    "equal_recipes_are_equal": NeverEqualSolver(),
    "recipe_survives_pickling": HomesickSolver(),
    "repr_says_what_it_is": SecretiveSolver(),
    "componentwise_is_declared": Hesitant(),
    "solution_solves_the_system": WrongSolver(fault="inaccurate"),
    "blocks_equal_their_columns": WrongSolver(fault="first column counts"),
    "result_is_a_fresh_float64_array": WrongSolver(fault="single precision"),
    "memory_order_does_not_matter": WrongSolver(fault="memory order"),
    "factor_can_be_used_again": WrongSolver(fault="wears out"),
    "factor_is_safe_from_threads": WrongSolver(fault="threads"),
    "factor_tells_its_size": WrongSolver(fault="weightless"),
    "tiny_entries_are_resolved": WrongSolver(fault="coarse"),
    "singular_matrices_are_refused": WrongSolver(fault="regularised"),
}

IMPLIED_BY_SOLVERS = {
    "solution_solves_the_system": {"tiny_entries_are_resolved"},
    # What changes from one solve to the next changes between a block and its columns, too.
    "factor_can_be_used_again": {
        "blocks_equal_their_columns",
        "memory_order_does_not_matter",
        "factor_is_safe_from_threads",
    },
    # Every second column of a block is at another place in the narrower block.
    "blocks_equal_their_columns": {"memory_order_does_not_matter", "factor_can_be_used_again"},
    # A column taken out of a block is not contiguous.
    "memory_order_does_not_matter": {"blocks_equal_their_columns", "factor_can_be_used_again"},
}


def test_there_is_a_wrong_solver_for_every_law():
    assert set(WRONG_SOLVERS) == set(names(SOLVER_LAWS))


@pytest.mark.parametrize("law", names(SOLVER_LAWS))
def test_a_wrong_solver_breaks_its_law_and_no_other(law):
    broken = broken_laws(gt.testing.linear_solver_checks(WRONG_SOLVERS[law]))
    assert law in broken
    assert broken <= {law} | IMPLIED_BY_SOLVERS.get(law, set())


def test_a_right_solver_in_the_same_clothes_breaks_no_law():
    assert gt.testing.check_linear_solver(WrongSolver()).ok


# -- checks, outcomes and reports ------------------------------------------------------------------


def test_the_error_lists_every_broken_law_with_its_figure_and_bound():
    identity = gt.CotanLaplacian(mass="identity")
    with pytest.raises(ConformanceError) as caught:
        gt.testing.check_laplace_operator(identity)
    message = str(caught.value)
    assert "27 of 32 laws" in message
    for law in (*NO_SCALE, "mass_adds_up_to_the_measure"):
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


def test_a_solver_that_breaks_a_law_is_told_which():
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


def test_an_expected_failure_of_a_law_that_does_not_apply_is_reported():
    with pytest.raises(ConformanceError, match="tiny_entries_are_resolved"):
        gt.testing.check_linear_solver(
            gt.CG(), expected_failures={"tiny_entries_are_resolved": "conjugate gradients"}
        )


@dataclass(frozen=True, kw_only=True)
class Modest(WrongSolver):
    known_failures: ClassVar = {"factor_tells_its_size": "it is a view"}


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
    """A kind of domain that the core has never heard of."""

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


def test_the_kit_does_not_need_a_test_framework():
    code = "import sys, geodesic_toolkit.testing; sys.exit('pytest' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# -- the command -----------------------------------------------------------------------------------


@pytest.fixture
def command():
    from typer.testing import CliRunner

    from geodesic_toolkit.cli import app

    return lambda *words: CliRunner().invoke(app, ["check", *words])


@pytest.mark.parametrize(
    "name",
    ["cotan", "operator:cotan", "geodesic-toolkit:cotan", "supernodal", "superlu", "solver:cg"],
)
def test_the_command_shows_every_law_and_leaves_with_0(command, name):
    result = command(name)
    assert result.exit_code == 0
    assert "recipe_is_frozen_data" in result.stdout
    assert "laws as they should be" in result.stdout


def test_the_command_prints_one_json_object(command):
    content = json.loads(command("superlu", "--json").stdout)
    assert content["ok"]
    assert content["kind"] == "solver"
    assert [row["law"] for row in content["laws"]] == names(SOLVER_LAWS)


@pytest.fixture
def registered():
    gt.operators.register("twice", Mutant)
    gt.operators.register("rude", Rude)
    gt.solvers.register("twice", WrongSolver)
    gt.solvers.register("modest", Modest)
    yield
    gt.operators.unregister("twice")
    gt.operators.unregister("rude")
    gt.solvers.unregister("twice")
    gt.solvers.unregister("modest")


def test_the_command_leaves_with_1_where_a_law_is_broken(command, registered):
    result = command("rude")
    assert result.exit_code == 1
    assert "other_domains_are_refused_by_name is broken: 3 (at most 0)" in result.stdout


def test_the_command_shows_an_unexpected_success(command, registered):
    result = command("modest")
    assert result.exit_code == 1
    assert "holds unexpectedly" in result.stdout


def test_the_command_asks_which_where_an_operator_and_a_solver_share_a_name(command, registered):
    result = command("twice")
    assert result.exit_code == 2
    assert "operator:twice or solver:twice" in result.stderr


@pytest.mark.parametrize("name", ["nothing", "operator:nothing", "solver:nothing", "nobody:cotan"])
def test_the_command_says_what_there_is_when_the_name_is_unknown(command, name):
    result = command(name)
    assert result.exit_code == 2
    assert "nothing" in result.stderr or "nobody" in result.stderr
