"""Laplace operators with one fault each, named after the law of the contract that it breaks."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, vstack

import geodesic_toolkit as gt
from geodesic_toolkit.discretization.element_gradient import ElementGradient


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


def with_turns(factor):
    return lambda frames, domain: replace(frames, turns=frames.turns * factor(frames, domain))


def second_corner_by(angle, flat):
    """Turn the second corner of each element of flat meshes, or of the others."""

    def factor(frames, domain):
        turned = np.ones_like(frames.turns)
        if (np.ptp(domain.vertices[:, 2]) == 0) == flat:
            turned[:, 1] = np.exp(1j * angle)
        return turned

    return with_turns(factor)


def by_the_sun(frames, domain):
    """Tilt the normals that look up."""
    tilted = frames.normals + np.array([1e-2, 0.0, 0.0]) * (frames.normals[:, 2:] > 0.5)
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    axes = frames.x_axes - np.einsum("nd,nd->n", frames.x_axes, tilted)[:, None] * tilted
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    flat = np.ptp(domain.vertices[:, 2]) == 0
    return frames if flat else replace(frames, normals=tilted, x_axes=axes)


FRAME_MUTANTS = {
    "frames_are_orthonormal": lambda frames, domain: replace(frames, x_axes=2 * frames.x_axes),
    "turns_have_length_one": with_turns(lambda frames, domain: 1 + 1e-9),
    "in_the_plane_transport_changes_nothing": second_corner_by(1e-6, flat=True),
    "holonomy_is_the_angle_defect": second_corner_by(1e-6, flat=False),
    "moving_the_shape_moves_its_frames": by_the_sun,
}


@dataclass(frozen=True, kw_only=True)
class Mutant(gt.LaplaceOperator):
    """The cotangent Laplacian with one fault, named after the law that it breaks."""

    breaks: str = "nothing"

    domains: ClassVar = (gt.TriangleMesh,)

    def assemble(self, domain):
        given = gt.CotanLaplacian().assemble(domain)
        return MUTANTS[self.breaks](given, domain) if self.breaks in MUTANTS else given

    def frames(self, domain, metric):
        given = super().frames(domain, metric)
        return FRAME_MUTANTS[self.breaks](given, domain) if self.breaks in FRAME_MUTANTS else given


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
    **{law: Mutant(breaks=law) for law in (*MUTANTS, *FRAME_MUTANTS)},
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
