"""Group marching: all vertices within a narrow band of distances are accepted at once.

Fast marching accepts one vertex at a time, which is slow in NumPy. Vertices whose distances differ
by less than the width of an element depend little on each other, and are accepted together; a
vertex that improves later is accepted again.

S. Kim, *An O(N) Level Set Method for Eikonal Equations*, SIAM Journal on Scientific Computing 22,
2001, https://doi.org/10.1137/S1064827500367130
"""

from abc import abstractmethod
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt

__all__ = ["Marching", "Wave"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MIN_IMPROVEMENT_OF_ACCEPTED = 1e-3
"""Improvement, as a share of the width of the band, below which an accepted vertex is not accepted
again. It bounds the error by a thousandth of the band for each vertex along a path."""


MAX_ACCEPTANCES_PER_VERTEX = 20
"""Mean number of times that vertices may be accepted, after which accepted vertices do not change;
1.5 to 3 were measured. It bounds the work where candidate distances contradict each other."""


class Wave:
    """The state of one march.

    Attributes
    ----------
    values : ndarray of shape (N,), float64
        The least distance of every vertex that is known; ``inf`` where the front has not arrived.
    began : ndarray of shape (N,), float64
        The offset of the source of the front at each vertex.
    accepted : ndarray of shape (N,), bool
        The vertices whose distances update those of others.
    left : int
        The number of acceptances until accepted vertices do not change.
    """

    def __init__(self, n_vertices: int) -> None:
        self.values = np.full(n_vertices, np.inf)
        self.began = np.zeros(n_vertices)
        self.accepted = np.zeros(n_vertices, dtype=np.bool_)
        self.left = MAX_ACCEPTANCES_PER_VERTEX * n_vertices


class Marching(gt.Fronts):
    """Distances by group marching, for any kind of element that can update its vertices."""

    @property
    @abstractmethod
    def n_vertices(self) -> int:
        """Number N of vertices."""

    @property
    @abstractmethod
    def width(self) -> float:
        """Width of the band of distances whose vertices are accepted at once."""

    @abstractmethod
    def updates(self, now: Integers, wave: Wave) -> Iterator[tuple[Integers, Floats, Floats]]:
        """Yield candidate distances of the neighbours of newly accepted vertices.

        Parameters
        ----------
        now : ndarray of shape (V,), int64
        wave : Wave
            Its distances are lowered after each candidate array.

        Yields
        ------
        vertices, distances, began : ndarrays of shape (P,)
            A vertex may come several times.
        """

    def distances(
        self, begins: Integers, vertices: Integers, known: Floats, starts: Floats
    ) -> Floats:
        """Return the distance from each of K sets of sources, (K, N); see `gt.Fronts`."""
        found = np.empty((len(begins) - 1, self.n_vertices))
        for k, (first, last) in enumerate(pairwise(begins)):
            own, wave = slice(first, last), Wave(self.n_vertices)
            self._march(wave, vertices[own], known[own], starts[own])
            found[k] = wave.values
        return found

    def _march(self, wave: Wave, vertices: Integers, known: Floats, starts: Floats) -> None:
        """Lower the distances of a wave from `inf` to those from one set of sources."""
        order = np.lexsort((known, vertices))
        vertices, first = np.unique(vertices[order], return_index=True)
        wave.values[vertices], wave.began[vertices] = known[order][first], starts[order][first]
        waiting, queued = vertices, np.zeros(len(wave.values), dtype=np.bool_)
        while len(waiting):
            values = wave.values[waiting]
            near = values <= values.min() + self.width
            now, waiting = waiting[near], waiting[~near]
            queued[now], wave.accepted[now] = False, True
            wave.left -= len(now)
            improved = [self._lowered(wave, *update) for update in self.updates(now, wave)]
            again = np.concatenate(improved) if improved else now[:0]
            again = np.unique(again[~queued[again]])
            queued[again] = True
            waiting = np.concatenate([waiting, again])

    def _lowered(self, wave: Wave, vertices: Integers, values: Floats, began: Floats) -> Integers:
        """Lower distances to candidate values, and return the vertices that improve."""
        worth = MIN_IMPROVEMENT_OF_ACCEPTED * self.width if wave.left > 0 else np.inf
        least = np.where(wave.accepted[vertices], worth, 0.0)
        better = values < wave.values[vertices] - least
        vertices, values, began = vertices[better], values[better], began[better]
        np.minimum.at(wave.values, vertices, values)
        best = values == wave.values[vertices]
        wave.began[vertices[best]] = began[best]
        return vertices
