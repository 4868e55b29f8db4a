"""Samples and their nearest neighbours as a kind of domain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array, csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError
from geodesic_toolkit_knn.dimension import N_NEIGHBOURS, dimension_from_distances
from geodesic_toolkit_knn.neighbours import ASYMMETRY, Metric, nearest
from geodesic_toolkit_knn.planes import NEIGHBOURS_IN_NOISE
from geodesic_toolkit_knn.tables import FloatArray, IntArray, as_table

__all__ = ["KNNGraph", "Neighbourhoods"]

DEFAULT_K = 20
"""Neighbours of a sample. Fronts across the graphs of rolls, S-curves and tori of 1,000 to 20,000
samples have errors of 0.2 to 0.8 % with 15 and 20, 0.3 to 1.5 % with 12, 2 to 7 % with 8; in a cube
they need 15. Charts are almost as accurate with any number."""

RELATIVE_GRID_WIDTH = 2.0**-36
"""Samples closer than this share of the size of the data are at one place."""


@dataclass(frozen=True, eq=False)
class Neighbourhoods:
    """The nearest neighbours of samples at different places.

    Attributes
    ----------
    centres : ndarray of shape (M,), int64
        The first sample at each place, ascending.
    places : ndarray of shape (M, D), float64
        Where they are, about the middle of all and in a unit in which the largest coordinate is 1.
    scale : float
        That unit.
    near : ndarray of shape (M, m), int64
        Neighbours as indices of `centres`, nearest first: twice as many as the graph has, and 30
        or more, where there are so many others. Charts are made of these.
    far : ndarray of shape (M, m), float64
        How far they are, in the unit of the data.
    """

    centres: IntArray
    places: FloatArray
    scale: float
    near: IntArray
    far: FloatArray


@final
class KNNGraph(gt.Domain):
    """Samples of a space of any dimension, with the nearest neighbours of each.

    Samples at the same place are one place under several indices. A sample whose coordinates are
    all NaN is missing: it has an index, and its distance is ``inf``.

    Parameters
    ----------
    points : array-like of shape (N, D)
        Samples, in any number D of coordinates.
    k : int, optional
        Neighbours of a sample; by default 20, or all others where there are fewer.
    metric : str or callable
        How distances between samples are measured, as in scikit-learn's ``NearestNeighbors``, or a
        function of two samples. It should obey the triangle inequality, which "cosine" and
        "sqeuclidean" do not.
    dimension : int or "auto"
        Dimension of the space that is sampled: 1 for a curve, 2 for a surface. "auto" estimates it.
    search : {"auto", "exact", "approximate"}
        "approximate" is pynndescent, which "auto" takes for more than 20,000 samples of more than
        15 coordinates where it is installed.

    Attributes
    ----------
    points : ndarray of shape (N, D), float64, or None
        None for a domain of :meth:`from_distances`.
    k : int
    metric : str or callable
    dimension : int
    dimension_estimate : float
        The estimate from the neighbours; NaN where there are too few.
    distances : csr_array of shape (N, N)
        Row i holds the distances of the neighbours of sample i. An explicit 0 connects samples at
        one place.

    Raises
    ------
    InvalidDomainError
        Not a table of real numbers, no sample that is not missing, a value that is not finite, or
        samples that extend over less than 1e-60 or more than 1e60.
    InvalidOptionError
        k is not positive, or there are not so many other samples; more dimensions than
        coordinates; an unknown search; a metric that is unknown or not symmetric, or has negative
        values.
    MissingDependencyError
        ``search="approximate"``, and pynndescent is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_knn import KNNGraph
    >>> angle = np.linspace(0, 2 * np.pi, 201)[:-1]
    >>> circle = KNNGraph(np.column_stack([np.cos(angle), np.sin(angle), angle * 0, angle * 0]))
    >>> circle
    KNNGraph(200 samples, 20 neighbours, dimension 1)
    >>> round(float(gt.geodesic_distance(circle, 0)[100]), 2)
    3.14
    """

    vertex_name = "sample"

    points: FloatArray | None
    k: int
    metric: Metric
    dimension: int
    dimension_estimate: float
    distances: csr_array

    def __init__(
        self,
        points: ArrayLike,
        *,
        k: int | None = None,
        metric: Metric = "euclidean",
        dimension: int | Literal["auto"] = "auto",
        search: Literal["auto", "exact", "approximate"] = "auto",
    ) -> None:
        table = as_table(points)
        _check_options(k, dimension)
        if not isinstance(dimension, str) and dimension > table.shape[1]:
            raise InvalidOptionError(
                f"dimension={dimension}: samples have {table.shape[1]} coordinates, and their "
                "space cannot have more dimensions"
            )
        if search not in ("auto", "exact", "approximate"):
            raise InvalidOptionError(
                f'search must be "auto", "exact" or "approximate", not {search!r}'
            )
        present = np.asarray(~np.isnan(table).all(axis=1))
        centres, places, scale, place = _places(table, present, metric)
        others = len(centres) - 1
        if k is not None and k > others:
            raise InvalidOptionError(
                f"k={k}: there are {others} samples at other places; take fewer, or leave k out"
            )
        own = min(DEFAULT_K, others) if k is None else int(k)
        near, far = _neighbourhoods(
            places, min(max(2 * own, NEIGHBOURS_IN_NOISE), others), metric, search
        )
        where = np.flatnonzero(present)
        again = np.flatnonzero(centres[place] != where)
        rows = np.concatenate([np.repeat(centres, own), where[again]])
        columns = np.concatenate([centres[near[:, :own]].ravel(), centres[place[again]]])
        lengths = np.concatenate([far[:, :own].ravel() * scale, np.zeros(len(again))])
        self._set(
            points=table,
            metric=metric,
            search=search,
            _present=present,
            _neighbourhoods=Neighbourhoods(centres, places, scale, near, far * scale),
        )
        self._set_graph(
            _matrix(rows, columns, lengths, len(table)), own, dimension, far[:, :N_NEIGHBOURS]
        )

    @classmethod
    def from_distances(
        cls, distances: Any, *, dimension: int | Literal["auto"] = "auto"
    ) -> KNNGraph:
        """Return the domain of neighbours that are known already.

        Parameters
        ----------
        distances : sparse array or matrix of shape (N, N)
            Row i holds the distances of the neighbours of sample i, as ``kneighbors_graph(...,
            mode="distance")`` of scikit-learn has them, or ``obsp["distances"]`` of AnnData.
        dimension : int or "auto"
            As above.

        Returns
        -------
        KNNGraph
            Without points, so that distances are measured on the graph.

        Raises
        ------
        InvalidDomainError
            Not square, or an entry that is not a length.

        Examples
        --------
        >>> from scipy.sparse import csr_array
        >>> from geodesic_toolkit_knn import KNNGraph
        >>> KNNGraph.from_distances(csr_array([[0.0, 2.0], [2.0, 0.0]]), dimension=1)
        KNNGraph(2 samples, 1 neighbours, dimension 1)
        """
        _check_options(None, dimension)
        if not hasattr(distances, "tocoo"):
            raise InvalidDomainError(
                f"distances are a sparse matrix of SciPy's, not {type(distances).__name__}"
            )
        graph = gt.as_domain(distances)  # which refuses what is not square, or not a length
        entries = coo_array(distances)
        row, column = entries.coords
        if (endless := ~np.isfinite(entries.data)).any():  # where the other direction is finite
            bad = int(endless.argmax())
            raise InvalidDomainError(
                f"the distance from sample {row[bad]} to {column[bad]} is {entries.data[bad]}; "
                "leave out entries that connect nothing"
            )
        off = row != column
        lengths = entries.data[off].astype(np.float64)
        matrix = _matrix(row[off], column[off], lengths, graph.n_vertices)
        domain = cls.__new__(cls)
        domain._set(  # noqa: SLF001 - of this class: it is a constructor
            points=None,
            metric="precomputed",
            search="exact",
            _present=np.ones(graph.n_vertices, dtype=np.bool_),
            _neighbourhoods=None,
        )
        counts = np.diff(matrix.indptr)
        k = int(np.median(counts)) if counts.any() else 0
        far = _full_rows(matrix, k)
        domain._set_graph(matrix, k, dimension, far)  # noqa: SLF001 - as above
        return domain

    @classmethod
    def from_affinities(
        cls, affinities: Any, *, dimension: int | Literal["auto"] = "auto"
    ) -> KNNGraph:
        """Return the domain of samples whose affinities are known.

        Parameters
        ----------
        affinities : sparse array or matrix of shape (N, N)
            Symmetric, of a Gaussian kernel: ``exp(-d²)`` at distance d, in the unit in which the
            kernel has width 1. Entries of 0, like those that are not stored, connect nothing.
        dimension : int or "auto"
            As above.

        Returns
        -------
        KNNGraph
            Without points, with distances ``sqrt(-log a)``.

        Raises
        ------
        InvalidDomainError
            Not square, not symmetric, or an entry outside 0 to 1.

        Examples
        --------
        >>> from scipy.sparse import csr_array
        >>> from geodesic_toolkit_knn import KNNGraph
        >>> near = KNNGraph.from_affinities(csr_array([[1.0, 0.5], [0.5, 1.0]]), dimension=1)
        >>> near.distances.data.round(2)
        array([0.83, 0.83])
        """
        if not hasattr(affinities, "tocoo"):
            raise InvalidDomainError(
                f"affinities are a sparse matrix of SciPy's, not {type(affinities).__name__}"
            )
        matrix = csr_array(affinities)
        if (
            len(matrix.shape) != 2
            or matrix.shape[0] != matrix.shape[1]
            or matrix.dtype.kind not in "iufb"
        ):
            raise InvalidDomainError(
                "affinities are a square matrix of real numbers, not "
                f"{matrix.dtype} of shape {matrix.shape}"
            )
        entries = coo_array(matrix.astype(np.float64))
        row, column = entries.coords
        sound = (entries.data >= 0) & (entries.data <= 1)
        if not sound.all():
            bad = int(sound.argmin())
            raise InvalidDomainError(
                f"the affinity of samples {row[bad]} and {column[bad]} is {entries.data[bad]}; a "
                "Gaussian kernel has values of 0 to 1. Divide by the largest, or give distances to "
                "from_distances"
            )
        apart = coo_array(abs(entries.tocsr() - entries.T.tocsr()))
        if apart.nnz and apart.data.max() > ASYMMETRY:
            worst = int(apart.data.argmax())
            i, j = (int(ends[worst]) for ends in apart.coords)
            raise InvalidDomainError(
                f"affinities are not symmetric: samples {i} and {j} have {matrix[i, j]} and "
                f"{matrix[j, i]}; give (a + a.T) / 2, or a.maximum(a.T)"
            )
        kept = (entries.data > 0) & (row != column)
        if kept.any() and (entries.data[kept] == 1).all():
            raise InvalidDomainError(
                "all affinities are 1, which is a distance of 0 between all neighbours: this is a "
                "matrix of connections; give from_distances a matrix of their distances"
            )
        lengths = np.sqrt(-np.log(entries.data[kept]))
        known = _matrix(row[kept], column[kept], lengths, matrix.shape[0])
        return cls.from_distances(known, dimension=dimension)

    def _set_graph(
        self, matrix: csr_array, k: int, dimension: int | Literal["auto"], far: FloatArray
    ) -> None:
        estimate = dimension_from_distances(far)
        found = max(1, round(estimate)) if np.isfinite(estimate) else 2
        self._set(
            distances=matrix,
            k=k,
            dimension=found if dimension == "auto" else dimension,
            dimension_estimate=estimate,
        )

    @property
    def n_vertices(self) -> int:
        """Number of samples, the missing ones among them."""
        return int(self.distances.shape[0])

    @property
    def present(self) -> NDArray[np.bool_]:
        """True at the samples that are not missing, of shape (N,)."""
        present: NDArray[np.bool_] = self.__dict__["_present"]
        return present

    @property
    def neighbourhoods(self) -> Neighbourhoods | None:
        """The neighbours of different places; None where neighbours were given."""
        found: Neighbourhoods | None = self.__dict__["_neighbourhoods"]
        return found

    @cached_property
    def _graph(self) -> gt.Graph:
        graph = gt.as_domain(self.distances)
        assert isinstance(graph, gt.Graph)  # for the type checker
        return graph

    def as_graph(self) -> gt.Graph:
        """Return the edges between samples of which either is a neighbour of the other."""
        return self._graph

    def affinities(self) -> csr_array:
        """Return ``exp(-d² / σ_i σ_j)`` of each edge, symmetric, of shape (N, N).

        Returns
        -------
        csr_array
            σ_i is the mean distance of the neighbours of sample i; samples at one place have 1.

        References
        ----------
        L. Zelnik-Manor, P. Perona, *Self-Tuning Spectral Clustering*, NIPS 17, 2004

        Examples
        --------
        >>> from scipy.sparse import csr_array
        >>> from geodesic_toolkit_knn import KNNGraph
        >>> KNNGraph.from_distances(csr_array([[0.0, 2.0], [2.0, 0.0]])).affinities().data.round(3)
        array([0.368, 0.368])
        """
        edges, lengths = self._graph.edges, self._graph.lengths
        proper = np.repeat(lengths > 0, 2)
        total = np.bincount(edges.ravel(), np.repeat(lengths, 2), self.n_vertices)
        width = total / np.maximum(np.bincount(edges.ravel()[proper], minlength=self.n_vertices), 1)
        product = width[edges].prod(axis=1)
        share = np.divide(lengths**2, product, out=np.zeros(len(lengths)), where=product > 0)
        both = np.concatenate([edges, edges[:, ::-1]])
        return _matrix(both[:, 0], both[:, 1], np.tile(np.exp(-share), 2), self.n_vertices)

    def without(self, mask: NDArray[np.bool_]) -> KNNGraph:
        """Return the domain with masked samples missing; the others have new neighbours.

        Where neighbours were given, those that are left stay neighbours.

        Raises
        ------
        InvalidOptionError
            The mask leaves no sample, or fewer than there are neighbours.
        """
        left = self.present & ~mask
        if not left.any():
            raise InvalidOptionError("the mask leaves no sample, and so no paths")
        if self.points is not None:
            k = min(self.k, int(left.sum()) - 1)
            return KNNGraph(
                np.where(mask[:, None], np.nan, self.points),
                k=k or None,
                metric=self.metric,
                dimension=self.dimension,
                search=self.__dict__["search"],
            )
        entries = coo_array(self.distances)
        row, column = entries.coords
        kept = left[row] & left[column]
        matrix = _matrix(row[kept], column[kept], entries.data[kept], self.n_vertices)
        domain = KNNGraph.from_distances(matrix, dimension=self.dimension)
        domain._set(_present=left)  # noqa: SLF001 - of this class
        return domain

    @classmethod
    def samples(cls) -> Any:
        """Return shapes about which the truth is known, for the checks of an operator."""
        from geodesic_toolkit_knn.samples import samples_of_neighbours

        return samples_of_neighbours()

    def __repr__(self) -> str:
        return (
            f"KNNGraph({self.n_vertices} samples, {self.k} neighbours, dimension {self.dimension})"
        )


def _check_options(k: int | None, dimension: object) -> None:
    for name, value, other in (("k", k, None), ("dimension", dimension, "auto")):
        if value is None or isinstance(value, str):
            sound = value == other
        else:
            whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
            sound = whole and int(str(value)) >= 1
        if not sound:
            raise InvalidOptionError(f"{name} must be a positive integer, not {value!r}")


def _places(
    table: FloatArray, present: NDArray[np.bool_], metric: Metric
) -> tuple[IntArray, FloatArray, float, IntArray]:
    """Return the first sample at each place, the places, their unit, and the place of each sample.

    Only Euclidean distances do not depend on where the origin and what the unit is.
    """
    chosen, scale = table[present], 1.0
    if metric == "euclidean":
        low, high = chosen.min(axis=0), chosen.max(axis=0)
        scale = float((high / 2 - low / 2).max()) or 1.0
        centred = (chosen - (low / 2 + high / 2)) / scale
        chosen = np.round(centred / RELATIVE_GRID_WIDTH) * RELATIVE_GRID_WIDTH
    _, first, place = np.unique(chosen, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    places = chosen[first[order]]
    return np.flatnonzero(present)[first[order]], places, scale, np.argsort(order)[place.ravel()]


def _neighbourhoods(
    places: FloatArray, m: int, metric: Metric, search: str
) -> tuple[IntArray, FloatArray]:
    """Return m neighbours of each place and how far they are, in the unit of the places."""
    if m == 0:
        return np.zeros((len(places), 0), dtype=np.int64), np.zeros((len(places), 0))
    near, far = nearest(places, m, metric, search)
    if metric == "euclidean":  # whose squares the search expands, and loses digits
        for column in range(m):
            steps = places[near[:, column]] - places
            far[:, column] = np.sqrt(np.einsum("nd,nd->n", steps, steps))
        order = np.argsort(far, axis=1, kind="stable")
        near, far = np.take_along_axis(near, order, 1), np.take_along_axis(far, order, 1)
    return near, far


def _matrix(rows: Any, columns: Any, values: FloatArray, count: int) -> csr_array:
    """Return a sparse matrix that keeps explicit zeros, sorted and read-only."""
    matrix = csr_array(coo_array((values, (rows, columns)), shape=(count, count)))
    matrix.sort_indices()
    for array in (matrix.data, matrix.indices, matrix.indptr):
        array.setflags(write=False)
    return matrix


def _full_rows(matrix: csr_array, k: int) -> FloatArray:
    """Return the k shortest lengths of each row that has so many, nearest first."""
    counts = np.diff(matrix.indptr)
    rows = np.flatnonzero(counts >= k) if k else np.zeros(0, dtype=np.int64)
    row = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((matrix.data, row))
    lengths = np.asarray(matrix.data)[order]
    return np.asarray(lengths[matrix.indptr[:-1][rows][:, None] + np.arange(k)])
