"""Samples as a domain, and the distances of further samples by their neighbours."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, Self

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.neighbors import NearestNeighbors
from sklearn.utils.validation import check_is_fitted, validate_data

from geodesic_toolkit.analysis.matrix.fingerprints import digest
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, Graph
from geodesic_toolkit.errors import (
    GeodesicError,
    InvalidDomainError,
    InvalidOptionError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.widths import check_width
from geodesic_toolkit.interop.conversion import graph_of_lengths
from geodesic_toolkit.registry.catalog import operators
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["OnSamples", "check_count"]

DEFAULT_NEIGHBORS = 12
"""Neighbours of a sample in the graph. Measured on rolls of 1,000 and 5,000 samples, in distances
from 40 of them: the mean error is 2.1 to 2.6 % with 8 neighbours, 0.7 to 1.1 % with 10, 0.3 to
0.5 % with 12 and 0.2 to 0.4 % with 15, which takes twice as long."""

REGULARISATION_OF_WEIGHTS = 1e-3
"""Share of the trace that is added to the products of steps to neighbours, as in locally linear
embedding. Measured as above on 500 further samples: errors are those of the samples from 1e-3 to
1e-2, and a tenth more at 0.1."""

NUMBERS_AT_ONCE = 20_000_000
"""Numbers of a batch: 160 MB."""


class OnSamples(BaseEstimator):
    """The options of all estimators here, and the solver that they make.

    The parameters are documented by each estimator.

    Attributes
    ----------
    option_of_graph : str
        Name of the option that says how many neighbours a sample has in the graph.
    """

    option_of_graph: ClassVar[str] = "n_neighbors"

    def __init__(
        self,
        *,
        n_neighbors: int | None = None,
        metric: str = "euclidean",
        operator: Any = "auto",
        refine: Any = "auto",
    ) -> None:
        self.n_neighbors = n_neighbors
        self.metric = metric
        self.operator = operator
        self.refine = refine

    def _fit_samples(self, X: Any) -> Self:  # noqa: N803 - scikit-learn's name
        """Set `domain_`, `solver_`, `nearest_` and `n_neighbors_` of a table or a domain."""
        if isinstance(X, Domain):
            self.nearest_: Any = None
            self.domain_: Domain = X
        else:
            table = validate_data(self, X, dtype=np.float64, ensure_min_samples=2)
            self.n_neighbors_ = self._checked_neighbors(len(table))
            self._check_table(table)
            with self._named_metric():
                self.nearest_ = NearestNeighbors(n_neighbors=self.n_neighbors_, metric=self.metric)
                self.nearest_.fit(table)
                self._table = table
                self.domain_ = self._domain_of(table)
        self.solver_ = GeodesicSolver(self.domain_, operator=self.operator, refine=self.refine)
        return self

    def _checked_neighbors(self, n_samples: int) -> int:
        given = getattr(self, self.option_of_graph)
        if given is None:
            return min(DEFAULT_NEIGHBORS, n_samples - 1)
        why = f"each of the {n_samples} samples has {n_samples - 1} others"
        return check_count(given, self.option_of_graph, n_samples - 1, why)

    def _check_table(self, table: FloatArray) -> None:
        """Raise unless a table can have the distances of the metric."""
        if self.metric != "precomputed":
            with np.errstate(over="ignore"):
                check_width(float(np.ptp(table, axis=0).max()), "table of samples")
        elif table.shape[0] != table.shape[1]:
            raise InvalidOptionError(
                'metric="precomputed" is for a square table of distances between all samples, not '
                f"one of shape {table.shape}; give samples with another metric, or a graph of "
                "known distances, geodesic_toolkit.as_domain(matrix)"
            )

    @contextmanager
    def _named_metric(self) -> Iterator[None]:
        """Name the option in errors of scikit-learn's about the metric."""
        try:
            yield
        except GeodesicError:
            raise
        except (ValueError, TypeError) as error:
            raise InvalidOptionError(
                f"metric={self.metric!r} does not measure these samples: {error}"
            ) from error

    def _domain_of(self, table: FloatArray) -> Domain:
        """Return the graph of neighbours, or the kind of domain that the operator asks for."""
        kinds = (Graph,) if self.operator == "auto" else operators.resolve(self.operator).domains
        if Graph in kinds:
            return self._graph_of(table)
        kind: Any = kinds[0]
        if self.metric != "euclidean":
            raise InvalidOptionError(
                f"metric={self.metric!r} is that of the graph of neighbours; a {kind.__name__}, "
                f"which operator={self.operator!r} takes, has distances in space"
            )
        try:
            domain: Domain = kind(table)
        except TypeError as error:
            raise UnsupportedDomainError(
                f"a {kind.__name__}, which operator={self.operator!r} takes, is not made of "
                f"samples ({error}); make it, and fit the estimator on it"
            ) from error
        return domain

    def _graph_of(self, table: FloatArray) -> Graph:
        """Return the graph of neighbours, whose edges have lengths.

        Neighbours are those of distinct samples: a repeated one is at a distance of 0 from the
        first of its kind.
        """
        _, first, kind = np.unique(table, axis=0, return_index=True, return_inverse=True)
        if len(first) == len(table) or self.metric == "precomputed":  # rows are not places
            return graph_of_lengths(self.nearest_.kneighbors_graph(mode="distance"))
        if len(first) == 1:
            raise InvalidDomainError("all samples are equal: there is no distance between them")
        distinct = NearestNeighbors(
            n_neighbors=min(self.n_neighbors_, len(first) - 1), metric=self.metric
        ).fit(table[first])
        near = graph_of_lengths(distinct.kneighbors_graph(mode="distance"))
        own = first[kind.ravel()]
        repeats = np.flatnonzero(own != np.arange(len(table)))
        return Graph(
            len(table),
            np.concatenate([first[near.edges], np.column_stack([own[repeats], repeats])]),
            np.append(near.lengths, np.zeros(len(repeats))),
        )

    def _is_fitted_on(self, X: Any) -> bool:  # noqa: N803
        """Return True for the domain of `fit`; raise for another one, and for tables then."""
        check_is_fitted(self)
        if self.nearest_ is not None:
            return False
        if X is not self.domain_ and digest(X) != digest(self.domain_):
            raise InvalidOptionError(
                f"{type(self).__name__} was fitted on {a_kind_of(self.domain_)}, whose "
                "vertices are its samples: give that domain again; points in space are for "
                "solver_.query"
            )
        return True

    def _near(self, X: Any) -> tuple[FloatArray, IntArray, FloatArray]:  # noqa: N803
        """Return new samples as a table, their nearest samples, and the distances of these."""
        if isinstance(X, Domain):
            raise InvalidOptionError(
                f"{type(self).__name__} was fitted on a table of samples: give new ones as a table "
                f"with as many columns, not {a_kind_of(X)}"
            )
        table = validate_data(self, X, dtype=np.float64, reset=False)
        far, near = self.nearest_.kneighbors(table)
        return table, near.astype(np.int64), far

    def _continued(self, known: FloatArray, X: Any) -> FloatArray:  # noqa: N803
        """Return the distances (M, L) of new samples, from those of the samples, (L, N).

        They are linear in the neighbours of a new sample, and keep the triangle inequality with
        each of them.
        """
        table, near, far = self._near(X)
        continued = np.empty((len(table), len(known)))
        step = max(1, NUMBERS_AT_ONCE // (near.shape[1] * max(len(known), table.shape[1])))
        for begin in range(0, len(table), step):
            some = slice(begin, begin + step)
            own, gap = known[:, near[some]], far[some]
            weights = None
            if self.metric == "euclidean":
                weights = _linear_weights(self._table[near[some]] - table[some, None])
            continued[some] = _between_neighbors(own, gap, weights).T
        return continued


def check_count(value: object, name: str, most: int | None = None, why: str = "") -> int:
    """Return a positive number that an option gives.

    Parameters
    ----------
    value : object
    name : str
        The option.
    most : int, optional
        Its largest value.
    why : str
        The reason for the largest value: "there are 40 samples".

    Raises
    ------
    InvalidOptionError
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InvalidOptionError(f"{name} must be an integer, not {value!r}")
    if value < 1:
        raise InvalidOptionError(f"{name} must be 1 or more, not {value}")
    if most is not None and value > most:
        raise InvalidOptionError(f"{name} must be {most} or less, not {value}: {why}")
    return int(value)


def _linear_weights(steps: FloatArray) -> FloatArray:
    """Return weights of neighbours that give linear functions, (M, k), from steps (M, k, D)."""
    scale = np.abs(steps).max(axis=(1, 2), keepdims=True)
    steps = np.divide(steps, scale, out=np.zeros_like(steps), where=scale > 0)
    products = np.einsum("mkd,mjd->mkj", steps, steps)
    traces = np.trace(products, axis1=1, axis2=2)
    added = np.where(traces > 0, REGULARISATION_OF_WEIGHTS * traces, 1.0)
    products += added[:, None, None] * np.eye(products.shape[1])
    weights = np.linalg.solve(products, np.ones((*products.shape[:2], 1)))[:, :, 0]
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _between_neighbors(
    known: FloatArray, far: FloatArray, weights: FloatArray | None
) -> FloatArray:
    """Return distances (L, M) between the bounds of neighbours, with distances (L, M, k)."""
    finite: BoolArray = np.isfinite(known)
    bound = (known + far).min(axis=2)
    if weights is not None:
        lower = np.where(finite, np.abs(known - far), 0.0).max(axis=2)
        linear = (np.where(finite, known, 0.0) * weights).sum(axis=2)
        linear[~finite.all(axis=2)] = np.inf  # some neighbours are on another component
        bound = np.minimum(np.maximum(linear, lower), bound)
    # Bounds of several neighbours may contradict each other, as distances are not exact: those of
    # the nearest one come last, so that a sample of `fit` gets its own distance.
    nearest, gap = known[:, :, 0], far[:, 0]
    first = np.where(np.isfinite(nearest), nearest, bound)
    return np.asarray(np.clip(bound, np.abs(first - gap), first + gap))
