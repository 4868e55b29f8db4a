"""The identities of mass, stiffness and gradient."""

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.figures import ALGEBRA, largest, relative
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject

__all__ = ["ALGEBRA_LAWS"]

ROUNDING = 1e-12
"""Tolerance of identities that assembly keeps to the last bits."""

FIELD = 0.1
"""Tolerance of totals and slopes of smooth functions on samples about 20 edges across."""

SMALL = 200
"""Largest number of vertices for which eigenvalues are computed."""


# -- mass and stiffness ----------------------------------------------------------------------------


def mass_is_positive(subject: OperatorSubject) -> Iterable[Measured]:
    """Every vertex of a connected domain has positive mass (the figure counts the others)."""
    for sample, discretization in subject.cases():
        yield Measured(float((discretization.mass <= 0).sum()), 0.0, sample.name)


def mass_adds_up_to_the_measure(subject: OperatorSubject) -> Iterable[Measured]:
    """On elements, the mass adds up to the length, area or volume (the figure is relative)."""
    for sample, discretization in subject.cases():
        # On other domains only M⁻¹L has a scale: a graph has no area.
        if isinstance(discretization.gradient, ElementGradient):
            excess = abs(discretization.mass.sum() / sample.measure - 1)
            yield Measured(excess, FIELD, sample.name)


def energy_of_the_positions_is_the_mass(subject: OperatorSubject) -> Iterable[Measured]:
    """``Σ_k x_kᵀ L x_k = dim Σ m`` for the positions x: the scale of M⁻¹L ≈ -Δ (relative)."""
    for sample, discretization in subject.cases():
        positions = sample.positions
        energy = float((positions * (discretization.stiffness @ positions)).sum())
        yield Measured(
            abs(energy / (sample.dim * discretization.mass.sum()) - 1), FIELD, sample.name
        )


def stiffness_is_symmetric(subject: OperatorSubject) -> Iterable[Measured]:
    """``L = Lᵀ`` (largest difference, relative to the largest entry)."""
    for sample, discretization in subject.cases():
        stiffness = discretization.stiffness
        yield Measured(largest(stiffness - stiffness.T) / largest(stiffness), ROUNDING, sample.name)


def stiffness_is_positive_semidefinite(subject: OperatorSubject) -> Iterable[Measured]:
    """``L ⪰ 0``: no negative eigenvalue (the lowest, negated, relative to the largest)."""
    for sample, discretization in subject.cases():
        if sample.domain.n_vertices <= SMALL:
            dense = discretization.stiffness.toarray()
            eigenvalues = np.linalg.eigvalsh((dense + dense.T) / 2)
            yield Measured(-eigenvalues[0] / eigenvalues[-1], ALGEBRA, sample.name)


def stiffness_sends_constants_to_zero(subject: OperatorSubject) -> Iterable[Measured]:
    """``L 1 = 0`` (largest entry, relative to the largest absolute row sum)."""
    for sample, discretization in subject.cases():
        stiffness, ones = discretization.stiffness, np.ones(sample.domain.n_vertices)
        drift = np.abs(stiffness @ ones).max() / (abs(stiffness) @ ones).max()
        yield Measured(drift, ROUNDING, sample.name)


# -- the gradient ----------------------------------------------------------------------------------


def gradient_sends_constants_to_zero(subject: OperatorSubject) -> Iterable[Measured]:
    """``G 1 = 0`` (largest entry, relative to the largest of G)."""
    for sample, discretization in subject.cases():
        matrix = discretization.gradient.matrix
        drift = np.abs(matrix @ np.ones(sample.domain.n_vertices)).max()
        yield Measured(drift / largest(matrix), ROUNDING, sample.name)


def stiffness_is_that_of_the_gradient(subject: OperatorSubject) -> Iterable[Measured]:
    """``Gᵀ W G = L`` (largest difference, relative to the largest entry)."""
    for sample, discretization in subject.cases():
        gradient, stiffness = discretization.gradient, discretization.stiffness
        matrix = csr_array(gradient.matrix)
        weighted = csr_array(matrix.multiply(np.asarray(gradient.weights)[:, None]))
        difference = largest(csr_array(matrix.T @ weighted) - stiffness)
        yield Measured(difference / largest(stiffness), ALGEBRA, sample.name)


def adjoint_is_that_of_the_gradient(subject: OperatorSubject) -> Iterable[Measured]:
    """``adjoint(x) = Gᵀ W x`` for a random field x (relative)."""
    for sample, discretization in subject.cases():
        gradient = discretization.gradient
        rng = np.random.default_rng(1)
        field = rng.normal(size=gradient.unit(np.zeros((sample.domain.n_vertices, 2))).shape)
        expected = gradient.matrix.T @ (gradient.weights[:, None] * field.reshape(-1, 2))
        yield Measured(relative(gradient.adjoint(field), expected), ALGEBRA, sample.name)


def unit_has_the_slope_of_the_plane(subject: OperatorSubject) -> Iterable[Measured]:
    """On flat shapes, ``unit(c x·a) = G (x·a)`` for directions |a| = 1 (relative, in energy)."""
    for sample, discretization in subject.cases():
        if sample.inner is None:
            continue
        gradient = discretization.gradient
        matrix = csr_array(gradient.matrix)
        outside = abs(matrix) @ (~sample.inner).astype(np.float64)
        weights = np.where(outside == 0, gradient.weights, 0.0)
        height = sample.positions @ _directions(sample.dim)
        slope = matrix @ height
        # The decay is so slow that the exponential is almost linear within an element.
        log_heat = 0.01 / sample.spacing * height
        columns = [gradient.unit(column[:, None]).reshape(-1) for column in log_heat.T]
        unit = np.stack(columns, axis=1)
        energy = (weights[:, None] * slope**2).sum(axis=0)
        difference = (weights[:, None] * (unit - slope) ** 2).sum(axis=0)
        yield Measured(float(np.sqrt(difference / energy).max()), FIELD, sample.name)


def unit_depends_on_ratios_only(subject: OperatorSubject) -> Iterable[Measured]:
    """``unit(log u - 5000) = unit(log u)``, and it is finite where u = 0 (relative)."""
    for sample, discretization in subject.cases():
        gradient = discretization.gradient
        log_heat = -2.0 * (sample.distance / sample.spacing)[:, None]
        unit = gradient.unit(log_heat)
        shifted = gradient.unit(log_heat - 5000.0)
        yield Measured(relative(shifted, unit), ALGEBRA, sample.name)
        without = np.where(sample.distance[:, None] > np.median(sample.distance), -np.inf, log_heat)
        spoilt = int((~np.isfinite(gradient.unit(without))).sum())
        yield Measured(float(spoilt), 0.0, f"{sample.name}: no heat in the far half")


def _directions(dim: int) -> FloatArray:
    """Return unit vectors of a space as columns: its axes and some directions between them."""
    between = np.random.default_rng(4).normal(size=(dim, 3))
    return np.concatenate([np.eye(dim), between / np.linalg.norm(between, axis=0)], axis=1)


ALGEBRA_LAWS = (
    mass_is_positive,
    mass_adds_up_to_the_measure,
    energy_of_the_positions_is_the_mass,
    stiffness_is_symmetric,
    stiffness_is_positive_semidefinite,
    stiffness_sends_constants_to_zero,
    gradient_sends_constants_to_zero,
    stiffness_is_that_of_the_gradient,
    adjoint_is_that_of_the_gradient,
    unit_has_the_slope_of_the_plane,
    unit_depends_on_ratios_only,
)
