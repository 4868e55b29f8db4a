"""`GeodesicIsomap`: an embedding in which straight lines are as long as geodesics."""

from typing import Any, Self

import numpy as np
from scipy.linalg import eigh
from sklearn.base import ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.neighbors import NearestNeighbors

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.domains import Graph
from geodesic_toolkit.errors import FragmentedCloudWarning, UnreachableError
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.sklearn.landmarks import Landmarks, landmark_distances
from geodesic_toolkit.sklearn.samples import OnSamples, check_count

__all__ = ["GeodesicIsomap"]

MIN_SHARE_OF_VARIANCE = 1e-12
"""Share of the largest eigenvalue up to which another one is rounding, and its coordinates 0."""


class GeodesicIsomap(ClassNamePrefixFeaturesOutMixin, TransformerMixin, OnSamples):
    """Isomap by distances across the graph of neighbours, from landmarks.

    Scikit-learn's Isomap measures the shortest path along the edges of the graph between all pairs
    of samples. Here fronts cross the graph, so that distances do not follow its edges, and they are
    measured from landmarks only, whose classical scaling places all samples.

    Parameters
    ----------
    n_neighbors : int, optional
        Neighbours of a sample in the graph; 12 by default, or all others where there are fewer.
    n_components : int
        Coordinates of the embedding.
    landmarks : int, "auto", "all" or array-like of int
        As for :class:`GeodesicDistances`: 100 by default. Their number barely affects the error.
    metric, operator, refine
        As for :class:`GeodesicDistances`.

    Attributes
    ----------
    embedding_ : ndarray of shape (N, n_components), float64
        Centred, in the unit of the samples.
    eigenvalues_ : ndarray of shape (n_components,), float64
        Of the doubly centred squared distances between landmarks.
    landmarks_ : ndarray of shape (L,), int64
    distances_ : ndarray of shape (L, N), float64
    solver_ : GeodesicSolver
    domain_ : Domain
    nearest_ : NearestNeighbors
    n_features_in_ : int

    References
    ----------
    J. B. Tenenbaum, V. de Silva, J. C. Langford, *A global geometric framework for nonlinear
    dimensionality reduction*, Science 290, 2000, https://doi.org/10.1126/science.290.5500.2319

    V. de Silva, J. B. Tenenbaum, *Sparse multidimensional scaling using landmark points*, Stanford
    University, 2004

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.sklearn import GeodesicIsomap
    >>> angle = np.linspace(0, 1.5 * np.pi, 301)
    >>> arc = np.column_stack([np.cos(angle), np.sin(angle)])
    >>> line = GeodesicIsomap(n_components=1).fit_transform(arc)
    >>> round(float(np.ptp(line)), 2)  # 1.5 π, the length of the arc
    4.71
    """

    def __init__(
        self,
        *,
        n_neighbors: int | None = None,
        n_components: int = 2,
        landmarks: Landmarks = "auto",
        metric: str = "euclidean",
        operator: Any = "auto",
        refine: Any = "auto",
    ) -> None:
        super().__init__(n_neighbors=n_neighbors, metric=metric, operator=operator, refine=refine)
        self.n_components = n_components
        self.landmarks = landmarks

    def fit(self, X: Any, y: object = None) -> Self:  # noqa: ARG002, N803 - scikit-learn's names
        """Compute the embedding.

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
        UnreachableError
            Nothing connects some vertices of the domain, or of an operator's kind of domain.

        Warns
        -----
        FragmentedCloudWarning
            The graph of neighbours has several components; the shortest possible edges connect
            them.
        """
        check_count(self.n_components, "n_components")
        self._fit_samples(X)
        self.landmarks_, self.distances_ = landmark_distances(self.solver_, self.landmarks, "mean")
        unreachable = np.flatnonzero(~np.isfinite(self.distances_).all(axis=0))
        if len(unreachable):
            raise UnreachableError(
                f"no path connects sample {unreachable[0]}, one of {len(unreachable)}, with all "
                "landmarks, and an embedding has no infinite distance: embed each connected part, "
                "or take more neighbors"
            )
        self._scale()
        self.embedding_ = self._placed(self.distances_.T)
        self._n_features_out = self.embedding_.shape[1]
        return self

    def fit_transform(self, X: Any, y: object = None) -> FloatArray:  # noqa: N803
        """Fit, and return the embedding; parameters are those of `fit`."""
        embedding: FloatArray = self.fit(X, y).embedding_
        return embedding

    def transform(self, X: Any) -> FloatArray:  # noqa: N803
        """Return the places of samples in the embedding.

        Parameters
        ----------
        X : array-like of shape (M, D), or the Domain of `fit`

        Returns
        -------
        ndarray of shape (M, n_components), float64
        """
        if self._is_fitted_on(X):
            embedding: FloatArray = self.embedding_
            return embedding
        return self._placed(self._continued(self.distances_, X))

    def _scale(self) -> None:
        """Scale the landmarks classically: set the map from squared distances to places."""
        squared = self.distances_[:, self.landmarks_] ** 2
        squared = (squared + squared.T) / 2
        count = check_count(
            self.n_components, "n_components", len(squared), f"there are {len(squared)} landmarks"
        )
        mean = squared.mean(axis=0)
        products = (mean[:, None] + mean[None, :] - squared - mean.mean()) / 2
        last = len(products) - 1
        values, vectors = eigh(products, subset_by_index=[last - count + 1, last])
        values, vectors = values[::-1], vectors[:, ::-1]
        # Signs of eigenvectors are arbitrary: the largest entry of each is positive.
        vectors = vectors * np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(count)])
        used = values > max(MIN_SHARE_OF_VARIANCE * values[0], 0.0)
        inverse = np.divide(1, np.sqrt(np.maximum(values, 0)), out=np.zeros(count), where=used)
        self.eigenvalues_ = values
        self._mean, self._map = mean, vectors * inverse
        self._middle = np.zeros(count)
        self._middle = self._placed(self.distances_.T).mean(axis=0)

    def _placed(self, distances: FloatArray) -> FloatArray:
        """Return places (M, n_components) by the distances (M, L) from landmarks."""
        return np.asarray((self._mean - distances**2) @ self._map / 2 - self._middle)

    def _graph_of(self, table: FloatArray) -> Graph:
        graph = super()._graph_of(table)
        labels = connected_by_edges(graph.edges, graph.n_vertices)
        if not labels.any():
            return graph
        links, lengths = _links(table, labels, self.metric)
        warn(
            f"the graph of neighbors has {labels.max() + 1} components; {len(links)} edges between "
            "their nearest samples connect them, and distances over these follow no samples. Take "
            "more neighbors, or embed each part",
            FragmentedCloudWarning,
        )
        return Graph(
            graph.n_vertices,
            np.concatenate([graph.edges, links]),
            np.concatenate([graph.lengths, lengths]),
        )


def _links(table: FloatArray, labels: IntArray, metric: str) -> tuple[IntArray, FloatArray]:
    """Return the shortest edges (E, 2) that connect all components, and their lengths.

    As in Borůvka's algorithm, each component gets its shortest edge to the others, until there is
    one component.
    """
    links: list[tuple[int, int]] = []
    lengths: list[float] = []
    while labels.any():
        for label in range(labels.max() + 1):
            own, others = np.flatnonzero(labels == label), np.flatnonzero(labels != label)
            search = NearestNeighbors(n_neighbors=1, metric=metric).fit(table[others])
            far, near = search.kneighbors(table[own])
            best = int(far[:, 0].argmin())
            links.append((int(own[best]), int(others[near[best, 0]])))
            lengths.append(float(far[best, 0]))
        labels = connected_by_edges(labels[np.array(links)], int(labels.max()) + 1)[labels]
    ends, first = np.unique(np.sort(links, axis=1), axis=0, return_index=True)
    return ends, np.array(lengths)[first]
