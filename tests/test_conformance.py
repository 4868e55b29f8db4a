"""Does every built-in keep the contract, and does a wrong one break the very law that it should?"""

import pickle
import warnings
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array, eye_array, vstack

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ConformanceError, GeodesicError, InvalidOptionError
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

SOLVERS = [gt.SuperLU(), gt.CG(), gt.CG(rtol=1e-10, max_iterations=5000), gt.CG(allow_heat=True)]


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
    """A gradient of a third kind: another one with a fault."""

    def __init__(self, base: gt.Gradient, fault: str) -> None:
        self.base = base
        self.fault = fault

    @property
    def n_vertices(self) -> int:
        return self.base.n_vertices

    @property
    def extra(self) -> csr_array:
        """A further row, for faults that need one: 1 at the first vertex."""
        return csr_array(coo_array(([1.0], ([0], [0])), shape=(1, self.n_vertices)))

    def unit(self, log_heat):
        if self.fault == "heat of a narrow range":
            with np.errstate(divide="ignore"):
                log_heat = np.log(np.exp(log_heat))
        unit = self.base.unit(log_heat)
        columns = log_heat.shape[1:]
        if self.fault == "no slope in slow heat":
            fall = np.ptp(log_heat, axis=0)
            return np.where(fall < 1.0, 0.0, unit)
        if self.fault == "slope of the first column for all" and log_heat.ndim == 2:
            return np.repeat(unit[..., :1], log_heat.shape[1], axis=-1)
        if self.fault == "a row too many":
            return unit.reshape(-1, *columns)[..., None] if log_heat.ndim == 1 else unit
        if self.fault == "a tenth too long":
            return 1.085 * unit
        if self.fault == "longer on fine meshes":
            return unit * (0.975 if self.n_vertices > 300 else 1.0)
        if self.fault == "constants have a slope":
            flat = unit.reshape(-1, *columns)
            return np.concatenate([flat, np.zeros((1, *columns))])
        if self.fault == "repulsion":
            flat = unit.reshape(-1, *columns)
            return np.concatenate([flat, self._further(log_heat)])
        return unit

    def _further(self, log_heat):
        return np.zeros((1, *log_heat.shape[1:]))

    def adjoint(self, x):
        if self.fault in ("constants have a slope", "repulsion"):
            return self._by_matrix(x)
        pull = self.base.adjoint(x[..., 0] if self._unsqueezed(x) else x)
        return pull * (1 + 1e-6) if self.fault == "adjoint of something else" else pull

    def _unsqueezed(self, x):
        return self.fault == "a row too many" and x.ndim == 2 and x.shape[1] == 1

    def _by_matrix(self, x):
        weights = self.weights.reshape(-1, *(1,) * (x.ndim - 1))
        return self.matrix.T @ (weights * x)

    @property
    def matrix(self):
        if self.fault == "single precision":
            return self.base.matrix.tocsc()
        if self.fault == "constants have a slope":
            return csr_array(vstack([self.base.matrix, self.extra]))
        if self.fault == "repulsion":
            far = csr_array(coo_array(([1.0, -1.0], ([0, 0], [0, 5])), shape=(1, self.n_vertices)))
            return csr_array(vstack([self.base.matrix, far]))
        return self.base.matrix

    @property
    def weights(self):
        if self.fault == "constants have a slope":
            return np.append(self.base.weights, 0.0)
        if self.fault == "repulsion":
            return np.append(self.base.weights, -50.0)
        return self.base.weights

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
        gradient = replace(given.gradient, measure=factor * given.gradient.measure)
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


def repelled(given, domain):
    gradient = Tampered(given.gradient, "repulsion")
    return replace(given, gradient=gradient, stiffness=gradient.stiffness())


def joined(given, domain):
    """Connect the first and the last vertex, so weakly that only components notice."""
    ends, count = [0, given.n_vertices - 1], given.n_vertices
    weak = np.array([1.0, 1.0, -1.0, -1.0]) * 1e-14 * given.stiffness.data.max()
    link = coo_array((weak, (ends + ends, ends + ends[::-1])), shape=(count, count))
    return replace(given, stiffness=csr_array(given.stiffness + link))


def cold(given, domain):
    """Give the diffusion some long positive entries, by an intrinsic metric that is still right.

    The edges of the mesh weigh a little less and those of two steps repel a little.
    """
    ring = abs(given.stiffness) > 0
    two = csr_array((ring @ ring).astype(np.float64))
    two.setdiag(0.0)
    two.data[:] = 1.0
    weak = 2e-3 * given.stiffness.data.max()
    degree = np.asarray(two.sum(axis=1))
    repulsion = weak * (two - csr_array(coo_array((degree, (np.arange(len(degree)),) * 2))))
    return replace(given, stiffness=csr_array(given.stiffness + repulsion))


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
    "shapes_fit": with_gradient("a row too many"),
    "dtypes_are_the_agreed_ones": with_gradient("single precision"),
    "arrays_are_read_only": writeable,
    "pickled_data_is_the_same": in_transit,
    "assembly_is_deterministic": noisy,
    "mass_is_positive": with_mass(without_least_mass),
    "mass_adds_up_to_the_measure": with_measure(2.0, 2.0),
    "energy_of_the_positions_is_the_mass": with_measure(1.3, 1.0),
    "stiffness_is_symmetric": with_stiffness(
        lambda s: one_entry(one_entry(s, 0, 1, 1e-11), 0, 0, -1e-11)
    ),
    "stiffness_is_positive_semidefinite": repelled,
    "stiffness_sends_constants_to_zero": with_stiffness(
        lambda s: s + 1e-10 * eye_array(s.shape[0])
    ),
    "gradient_sends_constants_to_zero": with_gradient("constants have a slope"),
    "stiffness_is_that_of_the_gradient": with_stiffness(lambda s: s * (1 + 1e-6)),
    "adjoint_is_that_of_the_gradient": with_gradient("adjoint of something else"),
    "unit_has_the_slope_of_the_plane": with_gradient("no slope in slow heat"),
    "unit_depends_on_ratios_only": with_gradient("heat of a narrow range"),
    "blocks_equal_their_columns": with_gradient("slope of the first column for all"),
    "spacing_is_the_edge_length": lambda given, domain: replace(
        given, spacing=1.55 * given.spacing
    ),
    "heat_is_positive": cold,
    "distance_is_accurate": with_gradient("a tenth too long"),
    "error_decreases_under_refinement": with_gradient("longer on fine meshes"),
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


@dataclass
class Mutable(Mutant):
    """An unfrozen recipe can still be hashed, pickled and compared."""

    breaks: str = "nothing"

    def __hash__(self):
        return hash(self.breaks)


@dataclass(frozen=True, kw_only=True, eq=False)
class NeverEqual(Mutant):
    pass


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
            raise ValueError("no")
        return super().assemble(domain)


@dataclass(frozen=True, kw_only=True)
class Fragile(Mutant):
    def assemble(self, domain):
        if domain is not None and domain.n_vertices < 4 and isinstance(domain, gt.TriangleMesh):
            raise IndexError("index 3 is out of bounds")
        return super().assemble(domain)


RECIPE_MUTANTS = {
    "recipe_is_frozen_data": Mutable(),
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
