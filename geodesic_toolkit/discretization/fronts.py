"""A kind's own way from sources to distances, in the place of heat."""

import abc

from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Fronts"]


class Fronts(abc.ABC):
    """Fronts that cross the elements of a kind of domain that the core does not know.

    A discretization that has them is measured by them, and heat is left to ``refine=False``.
    Solids, of which a factor takes much memory, and costs of places are what they are for.
    Instances are immutable, and may serve several threads at once.
    """

    @abc.abstractmethod
    def distances(
        self, begins: IntArray, vertices: IntArray, known: FloatArray, starts: FloatArray
    ) -> FloatArray:
        """Return the distance of every vertex from each of K sets of sources.

        Parameters
        ----------
        begins : ndarray of shape (K + 1,), int64
            Where the vertices of each set begin, and P at the end.
        vertices : ndarray of shape (P,), int64
            The vertices of the elements that sources lie in; one may come several times.
        known : ndarray of shape (P,), float64
            The distance that each of them starts with: its offset and how far it is from its
            source; of any sign.
        starts : ndarray of shape (P,), float64
            The offset of that source alone. A front is a sphere about a place where the distance
            is this.

        Returns
        -------
        ndarray of shape (K, N), float64
            ``inf`` where no element leads. A vertex that is given reads what is known of it, or
            less.
        """

    def near(
        self,
        begins: IntArray,
        vertices: IntArray,
        known: FloatArray,
        starts: FloatArray,
        limits: FloatArray,
    ) -> NearRows:
        """Return the distances up to a limit for each of K sets of sources.

        It computes all of them, unless a class has a faster way, whose result has to be the same.

        Parameters
        ----------
        begins, vertices, known, starts
            As for `distances`.
        limits : ndarray of shape (K,), float64

        Returns
        -------
        NearRows
        """
        return NearRows.of_table(self.distances(begins, vertices, known, starts), limits)
