"""Laws of an operator's input and output: kinds of domain, arrays, typed errors."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import GeodesicError, UnsupportedDomainError
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.figures import largest
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject
from geodesic_toolkit.testing.recipe_laws import faults
from geodesic_toolkit.testing.travel import arrivals

__all__ = ["DATA_LAWS", "REFUSAL_LAWS"]


def domains_are_kinds_of_domain(subject: OperatorSubject) -> Iterable[Measured]:
    """``domains`` is a tuple of subclasses of Domain, at least one."""
    kinds = subject.recipe.domains
    good = isinstance(kinds, tuple) and all(
        isinstance(kind, type) and issubclass(kind, Domain) for kind in kinds
    )
    yield faults([] if good and kinds else [f"domains is {kinds!r}"])


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
    """All arrays are float64 except the boundary, which is bool; L and G are csr_array."""
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
            found.append(f"assemble returned {a_kind_of(discretization)}")
        yield Measured(float(len(found)), 0.0, f"{sample.name}: {'; '.join(found)}")


def arrays_are_read_only(subject: OperatorSubject) -> Iterable[Measured]:
    """The arrays of a discretization are read-only, also in a pickled copy of it."""
    for sample, discretization in subject.cases():
        found = []
        copied = arrivals(discretization)["pickle"]
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
    """Pickle and deepcopy keep all numbers of a discretization."""
    for sample, discretization in subject.cases():
        for arrived in arrivals(discretization).values():
            yield Measured(_distance_of_data(discretization, arrived), 0.0, sample.name)


def assembly_is_deterministic(subject: OperatorSubject) -> Iterable[Measured]:
    """Assembling twice gives the same numbers, bit for bit."""
    for sample, discretization in subject.cases():
        again = subject.recipe.assemble(sample.domain)
        yield Measured(_distance_of_data(discretization, again), 0.0, sample.name)


def _distance_of_data(first: Discretization, second: Discretization) -> float:
    """Return the largest difference between two discretizations; inf if their shapes differ."""
    if (
        first.stiffness.shape != second.stiffness.shape
        or first.boundary.tolist() != second.boundary.tolist()
    ):
        return np.inf
    return max(
        float(np.abs(first.mass - second.mass).max()),
        largest(csr_array(first.stiffness - second.stiffness)),
        largest(csr_array(first.gradient.matrix - second.gradient.matrix))
        if first.gradient.matrix.shape == second.gradient.matrix.shape
        else np.inf,
        abs(first.spacing - second.spacing),
    )


# -- domains that an operator must refuse ---------------------------------------------------------


class ForeignDomain(Domain):
    """A kind of domain that no operator supports."""

    @property
    def n_vertices(self) -> int:
        """A single vertex."""
        return 1


def other_domains_are_refused_by_name(subject: OperatorSubject) -> Iterable[Measured]:
    """Another kind of domain, or no domain, raises an UnsupportedDomainError (counts faults)."""
    found = []
    for other in (ForeignDomain(), None, np.zeros((4, 3))):
        raised = _raised(subject.recipe, other)
        if not isinstance(raised, UnsupportedDomainError):
            found.append(f"{a_kind_of(other)} raised {_text(raised)}")
    yield faults(found)


def degenerate_domains_are_assembled_or_refused(subject: OperatorSubject) -> Iterable[Measured]:
    """Degenerate domains (one vertex, coincident points, no edges) give a result or an error."""
    for kind in subject.samples:
        for domain in kind.degenerate:
            raised = _raised(subject.recipe, domain)
            good = raised is None or isinstance(raised, GeodesicError)
            yield Measured(
                0.0 if good else 1.0, 0.0, "" if good else f"{domain!r} raised {_text(raised)}"
            )


def _raised(operator: LaplaceOperator, domain: Any) -> Exception | None:
    try:
        operator.assemble(domain)
    except Exception as error:  # noqa: BLE001 - the caller examines the error
        return error
    return None


def _text(error: Exception | None) -> str:
    return "no error" if error is None else f"{type(error).__name__}: {error}"


DATA_LAWS = (
    domains_are_kinds_of_domain,
    shapes_fit,
    dtypes_are_the_agreed_ones,
    arrays_are_read_only,
    pickled_data_is_the_same,
    assembly_is_deterministic,
)

REFUSAL_LAWS = (other_domains_are_refused_by_name, degenerate_domains_are_assembled_or_refused)
