"""`GeodesicNeighbors`: the samples that are nearest by geodesic distance."""

import math
import numbers
from typing import Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from scipy.sparse import csr_matrix
from sklearn.base import ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from geodesic_toolkit.analysis.matrix.matrix import distance_matrix
from geodesic_toolkit.analysis.matrix.symmetry import Symmetrize, check_symmetrize
from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.sklearn.nearest import near_blocks, nearest_blocks
from geodesic_toolkit.sklearn.samples import OnSamples, check_count
from geodesic_toolkit.sources.kinds import OffsetSources

__all__ = ["GeodesicNeighbors"]

Mode: TypeAlias = Literal["distance", "connectivity"]

Objects: TypeAlias = np.ndarray[Any, Any]


class GeodesicNeighbors(ClassNamePrefixFeaturesOutMixin, TransformerMixin, OnSamples):
    """The nearest samples by geodesic distance, as arrays and as sparse graphs.

    Methods and results are those of scikit-learn's ``KNeighborsTransformer`` and
    ``RadiusNeighborsTransformer``: `transform` gives the graph that estimators with
    ``metric="precomputed"`` take. Distances are measured from each sample that is asked for, to the
    samples near it where distances are refined or fronts measure them, and else to all.

    Parameters
    ----------
    n_neighbors : int
        Nearest samples of each.
    radius : float, optional
        `transform` gives the samples up to this distance instead.
    mode : {"distance", "connectivity"}
        Entries of the graph of `transform`: distances, or 1. With distances, each sample has itself
        as an explicit 0, beside its `n_neighbors` others.
    symmetrize : {"mean", "min", "max"} or None
        Makes the graph of `fit_transform` within the radius symmetric; distances by heat are not.
    graph_neighbors : int, optional
        Neighbours of a sample in the graph on which distances are measured; 12 by default, or all
        others where there are fewer.
    metric, operator, refine
        As for :class:`GeodesicDistances`.

    Attributes
    ----------
    solver_ : GeodesicSolver
    domain_ : Domain
    nearest_ : NearestNeighbors
        Finds the neighbours of new samples; None after `fit` on a domain.
    n_samples_fit_ : int
    n_features_in_ : int
        Only after `fit` on a table.

    Notes
    -----
    A new sample is measured by fronts that start at its neighbours, late by the distance to each.
    Samples that nothing connects are not neighbours: graphs leave them out, and arrays of `k`
    neighbours have the distance ``inf`` and the index N in their place.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.sklearn import GeodesicNeighbors
    >>> angle = np.linspace(0, 1.9 * np.pi, 40)  # the ends are near each other in the plane only
    >>> arc = np.column_stack([np.cos(angle), np.sin(angle)])
    >>> model = GeodesicNeighbors(n_neighbors=2, graph_neighbors=2).fit(arc)
    >>> model.kneighbors(return_distance=False)[[0, 39]]
    array([[ 1,  2],
           [38, 37]])
    """

    option_of_graph: ClassVar[str] = "graph_neighbors"

    def __init__(
        self,
        n_neighbors: int = 5,
        *,
        radius: float | None = None,
        mode: Mode = "distance",
        symmetrize: Symmetrize = "mean",
        graph_neighbors: int | None = None,
        metric: str = "euclidean",
        operator: Any = "auto",
        refine: Any = "auto",
    ) -> None:
        super().__init__(n_neighbors=n_neighbors, metric=metric, operator=operator, refine=refine)
        self.radius = radius
        self.mode = mode
        self.symmetrize = symmetrize
        self.graph_neighbors = graph_neighbors

    def fit(self, X: Any, y: object = None) -> Self:  # noqa: ARG002, N803 - scikit-learn's names
        """Make the solver of the samples.

        Parameters
        ----------
        X : array-like of shape (N, D), or Domain
            Samples; or a mesh, cloud or graph, whose vertices are the samples.
        y : object
            Not used.

        Returns
        -------
        self

        Raises
        ------
        InvalidOptionError
            An option outside its values.
        UnsupportedDomainError
            An operator of shapes that are not made of samples alone.
        ValueError
            A table that is not one of finite numbers, or that has one row.
        """
        check_count(self.n_neighbors, "n_neighbors")
        _check_mode(self.mode)
        check_symmetrize(self.symmetrize)
        if self.radius is not None:
            _check_radius(self.radius)
        self._fit_samples(X)
        self.n_samples_fit_ = self._n_features_out = self.domain_.n_vertices
        return self

    def kneighbors(
        self,
        X: Any = None,  # noqa: N803
        n_neighbors: int | None = None,
        return_distance: bool = True,
    ) -> IntArray | tuple[FloatArray, IntArray]:
        """Return the nearest samples of each.

        Parameters
        ----------
        X : array-like of shape (M, D), or the Domain of `fit`, optional
            By default the samples themselves, none of which is its own neighbour.
        n_neighbors : int, optional
            By default the option of that name.
        return_distance : bool

        Returns
        -------
        distances : ndarray of shape (M, n_neighbors), float64
            With `return_distance`; the smallest first.
        indices : ndarray of shape (M, n_neighbors), int64
        """
        check_is_fitted(self)
        sets, own = self._sets(X)
        distances, indices = self._nearest(sets, own, n_neighbors)
        return (distances, indices) if return_distance else indices

    def kneighbors_graph(
        self,
        X: Any = None,  # noqa: N803
        n_neighbors: int | None = None,
        mode: Mode = "connectivity",
    ) -> Any:
        """Return the same as a csr_matrix of shape (M, N).

        Parameters
        ----------
        X, n_neighbors
            As for `kneighbors`.
        mode : {"connectivity", "distance"}
            Entries are 1, or distances.

        Returns
        -------
        csr_matrix of shape (M, N), float64
            Entries of a row are in the order of the distance.
        """
        check_is_fitted(self)
        _check_mode(mode)
        sets, own = self._sets(X)
        return self._graph(*self._nearest(sets, own, n_neighbors), mode)

    def radius_neighbors(
        self,
        X: Any = None,  # noqa: N803
        radius: float | None = None,
        return_distance: bool = True,
        sort_results: bool = False,
    ) -> Objects | tuple[Objects, Objects]:
        """Return the samples up to a distance from each.

        Parameters
        ----------
        X : array-like of shape (M, D), or the Domain of `fit`, optional
            By default the samples themselves, none of which is its own neighbour.
        radius : float, optional
            By default the option of that name.
        return_distance : bool
        sort_results : bool
            Whether the nearest are first; otherwise indices ascend.

        Returns
        -------
        distances : ndarray of shape (M,), of arrays of float64
            With `return_distance`.
        indices : ndarray of shape (M,), of arrays of int64
        """
        check_is_fitted(self)
        sets, own = self._sets(X)
        distances, indices = self._within(sets, own, radius, sort_results)
        return (distances, indices) if return_distance else indices

    def radius_neighbors_graph(
        self,
        X: Any = None,  # noqa: N803
        radius: float | None = None,
        mode: Mode = "connectivity",
        sort_results: bool = False,
    ) -> Any:
        """Return the same as a csr_matrix of shape (M, N).

        Parameters
        ----------
        X, radius, sort_results
            As for `radius_neighbors`.
        mode : {"connectivity", "distance"}
            Entries are 1, or distances.

        Returns
        -------
        csr_matrix of shape (M, N), float64
        """
        check_is_fitted(self)
        _check_mode(mode)
        sets, own = self._sets(X)
        return self._graph(*self._within(sets, own, radius, sort_results), mode)

    def transform(self, X: Any) -> Any:  # noqa: N803
        """Return the graph of the nearest samples, or of those within the radius.

        Parameters
        ----------
        X : array-like of shape (M, D), or the Domain of `fit`

        Returns
        -------
        csr_matrix of shape (M, N), float64
            The nearest are first in each row.
        """
        check_is_fitted(self)
        return self._transformed(self._sets(X)[0])

    def fit_transform(self, X: Any, y: object = None) -> Any:  # noqa: N803
        """Fit, and return the graph of the same samples; parameters are those of `fit`."""
        self.fit(X, y)
        if self.radius is None:
            return self._transformed(np.arange(self.n_samples_fit_))
        graph = csr_matrix(
            distance_matrix(self.solver_, max_distance=self.radius, symmetrize=self.symmetrize)
        )
        order = np.lexsort(
            (graph.data, np.repeat(np.arange(graph.shape[0]), np.diff(graph.indptr)))
        )
        graph.indices, graph.data = graph.indices[order], graph.data[order]
        if self.mode == "connectivity":
            graph.data[:] = 1.0
        return graph

    def _transformed(self, sets: Any) -> Any:
        if self.radius is not None:
            return self._graph(*self._within(sets, False, None, True), self.mode)
        itself = self.mode == "distance"  # beside its neighbours
        count = self._checked_count(self.n_neighbors, itself) + itself
        return self._graph(*self._nearest(sets, False, count), self.mode)

    def _checked_count(self, count: object, others: bool) -> int:
        """Return a number of neighbours, among all samples or all `others`."""
        most = self.n_samples_fit_ - others
        why = f"there are {most} {'other ' if others else ''}samples"
        return check_count(count, "n_neighbors", most, why)

    def _sets(self, X: Any) -> tuple[Any, bool]:  # noqa: N803
        """Return the sources of each sample, and True if a sample is not its own neighbour."""
        if X is None or self._is_fitted_on(X):
            return np.arange(self.n_samples_fit_), X is None
        _, near, far = self._near(X)
        return [
            [int(own[0])] if late[0] == 0 else OffsetSources(own, late)
            for own, late in zip(near, far, strict=True)
        ], False

    def _nearest(
        self, sets: Any, own: bool, n_neighbors: int | None
    ) -> tuple[FloatArray, IntArray]:
        count = self.n_neighbors if n_neighbors is None else n_neighbors
        count = self._checked_count(count, own)
        distances = np.full((len(sets), count), np.inf)
        indices = np.full((len(sets), count), self.n_samples_fit_)
        for rows, near in nearest_blocks(self.solver_, sets, count + own):
            row, vertex, far = _entries(rows, near, own)
            order = np.lexsort((vertex, far, row))
            row, vertex, far = row[order], vertex[order], far[order]
            rank = np.arange(len(row)) - np.searchsorted(row, row)
            chosen = rank < count
            place = row[chosen], rank[chosen]
            distances[place], indices[place] = far[chosen], vertex[chosen]
        return distances, indices

    def _within(
        self, sets: Any, own: bool, radius: float | None, sort_results: bool
    ) -> tuple[Objects, Objects]:
        limit = _check_radius(self.radius if radius is None else radius)
        distances, indices = np.empty((2, len(sets)), dtype=object)
        for rows, near in near_blocks(self.solver_, sets, limit):
            row, vertex, far = _entries(rows, near, own)
            if sort_results:
                order = np.lexsort((vertex, far, row))
                vertex, far = vertex[order], far[order]
            ends = np.searchsorted(row, np.append(rows, rows[-1] + 1))
            for position, begin, end in zip(rows.tolist(), ends[:-1], ends[1:], strict=True):
                distances[position], indices[position] = far[begin:end], vertex[begin:end]
        return distances, indices

    def _graph(self, distances: Objects, indices: Objects, mode: Mode) -> Any:
        """Return the graph of rows of neighbours, without those that nothing connects."""
        rows = [
            (far[np.isfinite(far)], near[np.isfinite(far)])
            for far, near in zip(distances, indices, strict=True)
        ]
        ends = np.cumsum([0, *(len(far) for far, _ in rows)])
        data = np.concatenate([far for far, _ in rows])
        columns = np.concatenate([near for _, near in rows])
        if mode == "connectivity":
            data = np.ones(len(data))
        return csr_matrix((data, columns, ends), shape=(len(rows), self.n_samples_fit_))


def _entries(rows: IntArray, near: NearRows, own: bool) -> tuple[IntArray, IntArray, FloatArray]:
    """Return row, sample and distance of each entry; without that of a sample itself if `own`."""
    row = rows[near.rows]
    if not own:
        return row, near.vertices, near.distances
    others = row != near.vertices
    return row[others], near.vertices[others], near.distances[others]


def _check_mode(mode: object) -> None:
    if not is_one_of(mode, ("distance", "connectivity")):
        raise InvalidOptionError(f'mode must be "distance" or "connectivity", not {mode!r}')


def _check_radius(radius: Any) -> float:
    if isinstance(radius, bool) or not isinstance(radius, numbers.Real):
        raise InvalidOptionError(f"radius must be a distance, not {radius!r}")
    limit = float(radius)
    if not (limit >= 0 and math.isfinite(limit)):
        raise InvalidOptionError(f"radius must be finite and not negative, not {radius}")
    return limit
