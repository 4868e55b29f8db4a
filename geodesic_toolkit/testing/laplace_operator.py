"""The contract of a Laplace operator as executable laws."""

import copy
import pickle
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import GeodesicError, InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.heat import HeatMethod
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.linear.superlu import SuperLU
from geodesic_toolkit.testing.conformance import (
    Check,
    ConformanceReport,
    Measured,
    as_checks,
    run_checks,
)
from geodesic_toolkit.testing.recipe_laws import RECIPE_LAWS, faults
from geodesic_toolkit.testing.samples import DomainSamples, Sample, samples_of

__all__ = ["OPERATOR_LAWS", "check_laplace_operator", "laplace_operator_checks"]

ROUNDING = 1e-12
"""For identities that assembly keeps to the last bits."""

ALGEBRA = 1e-9
"""For identities between products of sparse matrices."""

COVARIANCE = 1e-6
"""For the same shape seen otherwise: rounding, after square roots and eigenvectors."""

FIELD = 0.1
"""For totals and slopes of smooth functions on samples of some 20 edges across."""

SMALL = 200
"""Largest number of vertices whose eigenvalues are computed."""

SHRINK = 0.9
"""Part of the error that may be left when the edges are half as long; first order leaves 0.5."""


def laplace_operator_checks(
    operator: LaplaceOperator,
    *,
    samples: Sequence[DomainSamples] | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> list[Check]:
    """Return the contract of a Laplace operator as a list of checks, one a law.

    Parameters
    ----------
    operator : LaplaceOperator
        An instance; its options are part of what is checked.
    samples : sequence of DomainSamples, optional
        What to measure it on; by default the core's samples of every kind in ``operator.domains``.
    expected_failures : mapping of str to str, optional
        Laws that are known to fail, with the reason; added to ``operator.known_failures``. One
        that holds after all is reported too.

    Returns
    -------
    list of Check
        Call one to have it raise where its law is broken; ``check.run()`` returns the figures.

    Raises
    ------
    InvalidOptionError
        Something else than an instance, a kind of domain without samples, a failure declared of
        a law that there is not.

    Notes
    -----
    As tests, in five lines::

        import geodesic_toolkit as gt, pytest
        from my_package import MyLaplacian

        @pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(MyLaplacian()), ids=str)
        def test_my_laplacian_keeps_the_contract(law): law()

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> checks = gt.testing.laplace_operator_checks(gt.CotanLaplacian())
    >>> outcome = {check.law: check for check in checks}["stiffness_is_symmetric"].run()
    >>> outcome.ok, outcome.figure
    (True, 0.0)
    """
    if not isinstance(operator, LaplaceOperator):
        raise InvalidOptionError(f"expected an instance of a LaplaceOperator, not {operator!r}")
    chosen = samples_of(operator.domains) if samples is None else list(samples)
    expected = {**operator.known_failures, **(expected_failures or {})}
    return as_checks(OPERATOR_LAWS, OperatorSubject(operator, chosen), expected)


def check_laplace_operator(
    operator: LaplaceOperator,
    *,
    samples: Sequence[DomainSamples] | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> ConformanceReport:
    """Check a Laplace operator against the whole contract.

    Parameters and errors are those of :func:`laplace_operator_checks`.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound.

    Raises
    ------
    ConformanceError
        Laws are broken, or hold that were declared to fail: all of them, each with its figure and
        its bound.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> print(gt.testing.check_laplace_operator(gt.UniformLaplacian()))
    UniformLaplacian(dim='auto', mass='metric'): 32 of 32 laws as they should be
    """
    checks = laplace_operator_checks(operator, samples=samples, expected_failures=expected_failures)
    return run_checks(operator, checks).or_raise()


class OperatorSubject:
    """An operator with the samples that it is measured on; each is assembled once."""

    def __init__(self, operator: LaplaceOperator, samples: Sequence[DomainSamples]) -> None:
        self.recipe = operator
        self.samples = samples
        self._methods: dict[int, HeatMethod] = {}
        self._assembled: dict[int, Discretization] = {}

    def assemble(self, domain: Domain) -> Discretization:
        """Return the operator's discretization of a domain that the samples keep alive."""
        key = id(domain)
        if key not in self._assembled:
            self._assembled[key] = self.recipe.assemble(domain)
        return self._assembled[key]

    def method(self, sample: Sample) -> HeatMethod:
        """Return the heat method of a sample."""
        key = id(sample)
        if key not in self._methods:
            self._methods[key] = heat_method(self.assemble(sample.domain))
        return self._methods[key]

    def cases(self) -> Iterator[tuple[Sample, Discretization]]:
        """Iterate over all samples, assembled."""
        for kind in self.samples:
            for family in kind.families:
                for sample in family:
                    yield sample, self.assemble(sample.domain)

    def error(self, sample: Sample) -> float:
        """Return the mean relative error of the distance from the sample's source."""
        distance = self.method(sample).distance(sample.source)
        away = sample.distance > 0
        return float(np.mean(np.abs(distance[away] / sample.distance[away] - 1)))


def heat_method(discretization: Discretization) -> HeatMethod:
    """Return the plain heat method on a discretization."""
    return HeatMethod(discretization, heat_solver=SuperLU(), poisson_solver=SuperLU())


# -- the recipe ------------------------------------------------------------------------------------


def domains_are_kinds_of_domain(subject: OperatorSubject) -> Iterable[Measured]:
    """``domains`` is a tuple of subclasses of Domain, at least one."""
    kinds = subject.recipe.domains
    good = isinstance(kinds, tuple) and all(
        isinstance(kind, type) and issubclass(kind, Domain) for kind in kinds
    )
    yield faults([] if good and kinds else [f"domains is {kinds!r}"])


# -- data ------------------------------------------------------------------------------------------


def shapes_fit(subject: OperatorSubject) -> Iterable[Measured]:
    """Mass (N,), L (N, N), G (R, N), weights (R,); unit of (N,) or (N, K) has R rows, adjoint N."""
    for sample, discretization in subject.cases():
        count, gradient = sample.domain.n_vertices, discretization.gradient
        matrix, found = gradient.matrix, list[str]()
        rows = matrix.shape[0]

        def expect(name: str, got: tuple[int, ...], *wanted: int, found: list[str] = found) -> None:
            if tuple(got) != wanted:
                found.append(f"{name} has shape {tuple(got)}, not {wanted}")

        expect("mass", discretization.mass.shape, count)
        expect("stiffness", discretization.stiffness.shape, count, count)
        expect("boundary", discretization.boundary.shape, count)
        expect("gradient.matrix", matrix.shape, rows, count)
        expect("gradient.weights", gradient.weights.shape, rows)
        for columns in ((), (1,), (3,)):
            field = gradient.unit(np.zeros((count, *columns)))
            # The leading axes enumerate the rows: their product is R, with K behind them.
            leading = field.shape[: field.ndim - len(columns)]
            got = (int(np.prod(leading)), *field.shape[len(leading) :])
            expect(f"unit of {(count, *columns)}, rows flattened,", got, rows, *columns)
            expect(f"adjoint of {field.shape}", gradient.adjoint(field).shape, count, *columns)
        yield Measured(float(len(found)), 0.0, f"{sample.name}: {'; '.join(found)}")


def dtypes_are_the_agreed_ones(subject: OperatorSubject) -> Iterable[Measured]:
    """Everything is float64 but the boundary, which is bool; L and G are csr_array."""
    for sample, discretization in subject.cases():
        gradient = discretization.gradient
        field = gradient.unit(np.zeros((sample.domain.n_vertices, 1)))
        parts: dict[str, tuple[Any, Any]] = {
            "mass": (discretization.mass, np.float64),
            "boundary": (discretization.boundary, np.bool_),
            "stiffness": (discretization.stiffness, np.float64),
            "gradient.matrix": (gradient.matrix, np.float64),
            "gradient.weights": (gradient.weights, np.float64),
            "unit": (field, np.float64),
            "adjoint": (gradient.adjoint(field), np.float64),
        }
        found = [
            f"{name} is {part.dtype}"
            for name, (part, dtype) in parts.items()
            if part.dtype != dtype
        ]
        found += [
            f"{name} is a {type(parts[name][0]).__name__}, not a csr_array"
            for name in ("stiffness", "gradient.matrix")
            if not isinstance(parts[name][0], csr_array)
        ]
        if not isinstance(discretization, Discretization):
            found.append(f"assemble returned a {type(discretization).__name__}")
        yield Measured(float(len(found)), 0.0, f"{sample.name}: {'; '.join(found)}")


def arrays_are_read_only(subject: OperatorSubject) -> Iterable[Measured]:
    """The arrays of a discretization cannot be written to, nor those of a pickled copy of it."""
    for sample, discretization in subject.cases():
        found = []
        copied = pickle.loads(pickle.dumps(discretization))  # noqa: S301 - made here
        for way, data in (("", discretization), ("pickled ", copied)):
            stiffness = data.stiffness
            arrays = {
                "mass": data.mass,
                "boundary": data.boundary,
                "stiffness.data": stiffness.data,
                "stiffness.indices": stiffness.indices,
                "stiffness.indptr": stiffness.indptr,
            }
            found += [
                f"{way}{name} is writeable" for name, a in arrays.items() if a.flags.writeable
            ]
        yield Measured(float(len(found)), 0.0, f"{sample.name}: {'; '.join(found)}")


def pickled_data_is_the_same(subject: OperatorSubject) -> Iterable[Measured]:
    """A discretization comes back from pickle and from deepcopy with the same numbers."""
    for sample, discretization in subject.cases():
        for arrived in (pickle.loads(pickle.dumps(discretization)), copy.deepcopy(discretization)):  # noqa: S301
            yield Measured(_distance_of_data(discretization, arrived), 0.0, sample.name)


def assembly_is_deterministic(subject: OperatorSubject) -> Iterable[Measured]:
    """Assembling twice gives the same numbers to the bit."""
    for sample, discretization in subject.cases():
        again = subject.recipe.assemble(sample.domain)
        yield Measured(_distance_of_data(discretization, again), 0.0, sample.name)


# -- mass and stiffness ----------------------------------------------------------------------------


def mass_is_positive(subject: OperatorSubject) -> Iterable[Measured]:
    """Every vertex of a connected domain has positive mass (the figure counts those without)."""
    for sample, discretization in subject.cases():
        yield Measured(float((discretization.mass <= 0).sum()), 0.0, sample.name)


def mass_adds_up_to_the_measure(subject: OperatorSubject) -> Iterable[Measured]:
    """On elements, the mass adds up to the length, area or volume (the figure is relative)."""
    for sample, discretization in subject.cases():
        # Elsewhere only M⁻¹L has a scale: a graph knows no area.
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
        yield Measured(
            _largest(stiffness - stiffness.T) / _largest(stiffness), ROUNDING, sample.name
        )


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
        yield Measured(drift / _largest(matrix), ROUNDING, sample.name)


def stiffness_is_that_of_the_gradient(subject: OperatorSubject) -> Iterable[Measured]:
    """``Gᵀ W G = L`` (largest difference, relative to the largest entry)."""
    for sample, discretization in subject.cases():
        gradient, stiffness = discretization.gradient, discretization.stiffness
        matrix = csr_array(gradient.matrix)
        weighted = csr_array(matrix.multiply(np.asarray(gradient.weights)[:, None]))
        difference = _largest(csr_array(matrix.T @ weighted) - stiffness)
        yield Measured(difference / _largest(stiffness), ALGEBRA, sample.name)


def adjoint_is_that_of_the_gradient(subject: OperatorSubject) -> Iterable[Measured]:
    """``adjoint(x) = Gᵀ W x`` for a random field x (relative)."""
    for sample, discretization in subject.cases():
        gradient = discretization.gradient
        rng = np.random.default_rng(1)
        field = rng.normal(size=gradient.unit(np.zeros((sample.domain.n_vertices, 2))).shape)
        expected = gradient.matrix.T @ (gradient.weights[:, None] * field.reshape(-1, 2))
        yield Measured(_relative(gradient.adjoint(field), expected), ALGEBRA, sample.name)


def unit_has_the_slope_of_the_plane(subject: OperatorSubject) -> Iterable[Measured]:
    """Where it is flat, ``unit(c x·a) = G (x·a)`` for directions |a| = 1 (relative, in energy)."""
    for sample, discretization in subject.cases():
        if sample.inner is None:
            continue
        gradient = discretization.gradient
        matrix = csr_array(gradient.matrix)
        outside = abs(matrix) @ (~sample.inner).astype(np.float64)
        weights = np.where(outside == 0, gradient.weights, 0.0)
        height = sample.positions @ _directions(sample.dim)
        slope = matrix @ height
        # So slow a decay that the exponential is all but linear within an element.
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
        yield Measured(_relative(shifted, unit), ALGEBRA, sample.name)
        without = np.where(sample.distance[:, None] > np.median(sample.distance), -np.inf, log_heat)
        spoilt = int((~np.isfinite(gradient.unit(without))).sum())
        yield Measured(float(spoilt), 0.0, f"{sample.name}: no heat in the far half")


def blocks_equal_their_columns(subject: OperatorSubject) -> Iterable[Measured]:
    """Distances of several source sets at once, and unit and adjoint, equal those one by one."""
    for sample, discretization in subject.cases():
        count, gradient = sample.domain.n_vertices, discretization.gradient
        scale = sample.distance.max()
        rng = np.random.default_rng(2)
        log_heat = np.stack([-3 * sample.distance, -rng.random(count), np.zeros(count)], axis=1)
        log_heat /= sample.spacing
        field = gradient.unit(log_heat)
        adjoint = gradient.adjoint(field)
        for k in range(3):
            alone = gradient.unit(log_heat[:, k : k + 1])
            yield Measured(_relative(field[..., k : k + 1], alone), ALGEBRA, f"unit, {sample.name}")
            pull = gradient.adjoint(alone)
            apart = _relative(adjoint[:, k : k + 1], pull, floor=np.abs(adjoint).max())
            yield Measured(apart, ALGEBRA, f"adjoint, {sample.name}")
        method = subject.method(sample)
        sets = [[sample.source], [0, count - 1], [count // 2]]
        together = method.distances(sets)
        for row, sources in zip(together, sets, strict=True):
            difference = np.abs(row - method.distance(sources)).max() / scale
            yield Measured(float(difference), ALGEBRA, f"distances, {sample.name}")


# -- heat and distance -----------------------------------------------------------------------------


def spacing_is_the_edge_length(subject: OperatorSubject) -> Iterable[Measured]:
    """``spacing`` is the mean edge length, up to a factor of 2 (the figure is the log ratio)."""
    for sample, discretization in subject.cases():
        ratio = abs(np.log(discretization.spacing / sample.spacing))
        yield Measured(float(ratio), float(np.log(2)), sample.name)


def heat_is_positive(subject: OperatorSubject) -> Iterable[Measured]:
    """``(M + h² L) u = δ`` has u > 0 at every vertex (the figure counts the others)."""
    for sample, _ in subject.cases():
        report = subject.method(sample).heat_report(sample.source)
        yield Measured(float(report.non_positive), 0.0, sample.name)


def distance_is_accurate(subject: OperatorSubject) -> Iterable[Measured]:
    """On the finest sample of each family the distance is right (mean relative error)."""
    for kind in subject.samples:
        for family in kind.families:
            yield Measured(subject.error(family[-1]), family[-1].error, family[-1].name)


def error_decreases_under_refinement(subject: OperatorSubject) -> Iterable[Measured]:
    """The mean error falls from the coarse sample of a family to the fine one (their ratio)."""
    for kind in subject.samples:
        for family in kind.families:
            for coarse, fine in pairwise(family):
                ratio = subject.error(fine) / subject.error(coarse)
                yield Measured(ratio, SHRINK, f"{coarse.name} -> {fine.name}")


def disconnected_parts_are_infinitely_far(subject: OperatorSubject) -> Iterable[Measured]:
    """What no source connects to is inf, all else finite (the figure counts the wrong ones)."""
    for kind in subject.samples:
        part = kind.families[0][0].domain
        count, name = part.n_vertices, f"{kind.kind.__name__} of two parts"
        method = heat_method(subject.recipe.assemble(kind.united(part, part)))
        first, both = method.distance(0), method.distance([0, count])
        wrong = (~np.isfinite(first[:count])).sum() + np.isfinite(first[count:]).sum()
        yield Measured(float(wrong), 0.0, f"{name}, a source in one")
        yield Measured(float((~np.isfinite(both)).sum()), 0.0, f"{name}, a source in each")
        method = heat_method(subject.recipe.assemble(kind.isolated(part)))
        distance = method.distance(0)
        wrong = (~np.isfinite(distance[:-1])).sum() + np.isfinite(distance[-1])
        yield Measured(float(wrong), 0.0, f"{kind.kind.__name__} with an isolated vertex")


# -- the same shape seen otherwise -----------------------------------------------------------------


def permuting_the_vertices_permutes_the_result(subject: OperatorSubject) -> Iterable[Measured]:
    """Renumbered vertices renumber M and L and change nothing else (relative)."""
    for kind in subject.samples:
        order = np.random.default_rng(3).permutation(kind.generic.n_vertices)
        permuted = subject.recipe.assemble(kind.permuted(kind.generic, order))
        yield _same(subject.assemble(kind.generic), permuted, kind, order=order)


def moving_the_shape_changes_nothing(subject: OperatorSubject) -> Iterable[Measured]:
    """A rigid motion leaves M, L and the spacing as they are (relative)."""
    for kind in subject.samples:
        if kind.moved is not None:
            rotation = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
            moved = kind.moved(kind.generic, rotation, np.array([1.0, -2.0, 0.5]))
            yield _same(subject.assemble(kind.generic), subject.recipe.assemble(moved), kind)


def scaling_the_shape_scales_the_result(subject: OperatorSubject) -> Iterable[Measured]:
    """Lengths s times as large scale the spacing by s and ``M⁻¹L`` by 1/s² (relative)."""
    for kind in subject.samples:
        if kind.scaled is not None:
            for factor in (1e-3, 1e3):
                scaled = subject.recipe.assemble(kind.scaled(kind.generic, factor))
                yield _same(subject.assemble(kind.generic), scaled, kind, factor=factor)


def _same(
    given: Discretization,
    seen: Discretization,
    kind: DomainSamples,
    *,
    order: Any = None,
    factor: float | None = None,
) -> Measured:
    """Return how far two discretizations of one shape differ, in mass, L and spacing.

    Under scaling only ``M⁻¹L`` is compared: M may be an area, or a number of neighbours.
    """
    probe = np.cos(1.0 + np.arange(given.n_vertices) ** 1.5)[:, None]
    order = np.arange(given.n_vertices) if order is None else order
    if factor is None:
        mass = _relative(seen.mass, given.mass[order])
        pull = _relative(seen.stiffness @ probe[order], (given.stiffness @ probe)[order])
        spacing = abs(seen.spacing / given.spacing - 1)
    else:
        mass, heavy = 0.0, (given.mass > 0) & (seen.mass > 0)
        expected = (given.stiffness @ probe)[heavy] / given.mass[heavy, None]
        scaled = (seen.stiffness @ probe)[heavy] / seen.mass[heavy, None]
        pull = _relative(scaled * factor**2, expected)
        spacing = abs(seen.spacing / (factor * given.spacing) - 1)
    figures = {"mass": mass, "stiffness": pull, "spacing": spacing}
    name = max(figures, key=lambda key: figures[key])
    scale = "" if factor is None else f" scaled by {factor:g}"
    return Measured(figures[name], COVARIANCE, f"{name}, {kind.kind.__name__}{scale}")


# -- what is no domain of its own ------------------------------------------------------------------


class ForeignDomain(Domain):
    """A kind of domain that no operator has heard of."""

    @property
    def n_vertices(self) -> int:
        """One vertex."""
        return 1


def other_domains_are_refused_by_name(subject: OperatorSubject) -> Iterable[Measured]:
    """Another kind of domain, or none, is an UnsupportedDomainError (counts what is not)."""
    found = []
    for other in (ForeignDomain(), None, np.zeros((4, 3))):
        raised = _raised(subject.recipe, other)
        if not isinstance(raised, UnsupportedDomainError):
            found.append(f"a {type(other).__name__} gave {_text(raised)}")
    yield faults(found)


def degenerate_domains_are_assembled_or_refused(subject: OperatorSubject) -> Iterable[Measured]:
    """One vertex, coincident points, no edges: a Discretization or a typed error, nothing else."""
    for kind in subject.samples:
        for domain in kind.degenerate:
            raised = _raised(subject.recipe, domain)
            good = raised is None or isinstance(raised, GeodesicError)
            yield Measured(
                0.0 if good else 1.0, 0.0, "" if good else f"{domain!r} gave {_text(raised)}"
            )


def _raised(operator: LaplaceOperator, domain: Any) -> Exception | None:
    try:
        operator.assemble(domain)
    except Exception as error:  # noqa: BLE001 - which error it is is the question
        return error
    return None


def _text(error: Exception | None) -> str:
    return "no error" if error is None else f"{type(error).__name__}: {error}"


# -- figures ---------------------------------------------------------------------------------------


def _largest(matrix: csr_array) -> float:
    return float(np.abs(matrix.data).max(initial=0.0))


def _relative(got: FloatArray, expected: FloatArray, floor: float = 0.0) -> float:
    """Return the largest difference, relative to the largest expected value or `floor`."""
    scale = max(float(np.abs(expected).max(initial=0.0)), floor)
    difference = float(np.abs(got - expected).max(initial=0.0))
    return difference / scale if scale else difference


def _directions(dim: int) -> FloatArray:
    """Return unit vectors of a space as columns: its axes and some between them."""
    between = np.random.default_rng(4).normal(size=(dim, 3))
    return np.concatenate([np.eye(dim), between / np.linalg.norm(between, axis=0)], axis=1)


def _distance_of_data(first: Discretization, second: Discretization) -> float:
    """Return the largest difference of the numbers of two discretizations; inf for other shapes."""
    if (
        first.stiffness.shape != second.stiffness.shape
        or first.boundary.tolist() != second.boundary.tolist()
    ):
        return np.inf
    return max(
        float(np.abs(first.mass - second.mass).max()),
        _largest(csr_array(first.stiffness - second.stiffness)),
        _largest(csr_array(first.gradient.matrix - second.gradient.matrix))
        if first.gradient.matrix.shape == second.gradient.matrix.shape
        else np.inf,
        abs(first.spacing - second.spacing),
    )


OPERATOR_LAWS = (
    *RECIPE_LAWS,
    domains_are_kinds_of_domain,
    shapes_fit,
    dtypes_are_the_agreed_ones,
    arrays_are_read_only,
    pickled_data_is_the_same,
    assembly_is_deterministic,
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
    blocks_equal_their_columns,
    spacing_is_the_edge_length,
    heat_is_positive,
    distance_is_accurate,
    error_decreases_under_refinement,
    disconnected_parts_are_infinitely_far,
    permuting_the_vertices_permutes_the_result,
    moving_the_shape_changes_nothing,
    scaling_the_shape_scales_the_result,
    other_domains_are_refused_by_name,
    degenerate_domains_are_assembled_or_refused,
)
"""The contract of :class:`~geodesic_toolkit.LaplaceOperator`: functions of a subject, in order."""
