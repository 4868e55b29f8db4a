"""Crowds of points: heaps, and lines whose points are closer together than the lines are.

Sensors do not sample evenly. A spinning scanner writes lines that are tens of spacings apart, and
one that passes several times writes heaps. All nearest neighbours of a point then lie in one
direction, or without a clear direction, and a single number of neighbours is not right everywhere.
So crowds are thinned, and the remaining points are about as dense across lines as along them.

The kernels are ``native/clouds/crowds.cpp``, with the measurements behind their constants.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.threads import threads_for
from geodesic_toolkit.laplacians.pointcloud.blades import N_SAMPLES, where_blades
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_among, nearest_neighbours

__all__ = ["Representatives", "representatives", "restored"]

RELATIVE_SPACING_OF_KEPT = 0.25
"""Minimum distance between kept points of a crowd, relative to its reach: the next line, or the
next heap, is about one reach away."""

POINTS_PER_NEIGHBOUR = 32
"""Points of a cloud for each neighbour that is inspected: in a cloud of some hundreds, 40
neighbours are a limb. The error on a fox of 313 points is 6.2 % with this limit, and 9.1 % with all
neighbours."""

MAX_ROUNDS = 12
"""Maximum number of rounds of thinning. Lines take one round for every factor of 5 between their
distance and that of their points, heaps one or two."""

MAX_SHARE_OF_CROWDED_IN_LAST_ROUND = 0.05
"""Share of the crowded points up to which a round that removes them is the last one."""

MAX_SHARE_OF_ALL_IN_LAST_ROUND = 0.001
"""The same share of all points: on clouds without crowds a few points look crowded by chance."""

MAX_CROWDED_SHARE_BY_CHANCE = 0.01
"""Share of the points up to which crowded ones occur by chance, and are not thinned: it is 0 to
0.9 % on clouds that sample surfaces evenly or at random."""

SAMPLING_STEP_OF_HEAPS = 8
"""Sampling step in the search for heaps of more points than there are neighbours."""

N_PROBES = 500
"""Points at which these heaps are searched first."""

NUMBERS_OF_HEAPS, RATIO_OF_FARTHER_NEIGHBOURS = (2, 4, 10), 4
"""Numbers of neighbours of which a heap may consist, and the factor of that number at which the
next heaps are."""

MIN_RATIO_OF_HEAPS = 6.0
"""Minimum ratio of the distances to the neighbours number 4 r and r in the sample at which they do
not lie on one surface around a point: larger than in the kernel, because a random sample has heaps
of its own."""

MIN_RATIO_OF_CERTAIN_HEAPS = 25.0
"""Minimum of the same ratio in a heap even if the next heaps lie in one direction."""

MAX_VARIANCE_ACROSS_BANDS = 0.1
"""Variance across a neighbourhood, relative to the variance along it, up to which it is a band: a
band of a fifth of the length of the neighbourhood has 0.04, a quarter of a circle 0.03, a surface
0.5 or more."""

MIN_SHARE_OF_LONE_POINTS = 0.25
"""Minimum share of isolated points among the crowded ones at which the cloud is not crowded at all;
among heaps a tenth is isolated by chance."""

NEIGHBOURS_TO_NEXT_LINE = 16
"""Neighbours of a remaining point of a line among which the next line must be."""

MIN_SHARE_OF_PROBES = 0.05
"""Minimum share of probes with a heap at which all points are searched."""

SAMPLING_STEPS_OF_BLADES = (2, 4, 8, 16)
"""Sampling steps in the search for blades that hold all neighbours of their points. Measured on
sweeps of 32 beams over slopes of 0.15 and 0.3 with noise of 2 and 3 cm, refined: errors of 3 to 34
% become 0.003 to 0.016 % with these, 0.002 to 0.01 % with 3 and 9, and 0.006 to 3.2 % with 4 and
16."""

N_VOTING_POINTS = 9
"""Points around a point, itself included, most of which have to agree."""


@dataclass(frozen=True)
class Representatives:
    """The points of a cloud that represent all of it.

    Attributes
    ----------
    kept : ndarray of shape (P,), int64
        Indices of the representatives, ascending.
    reaches : ndarray of shape (N,), float64
        Reach of the widest crowd that contained each point; 0 outside crowds.
    neighbours : ndarray of shape (N, k), int64
        The nearest representatives of all points, the points themselves excluded.
    """

    kept: IntArray
    reaches: FloatArray
    neighbours: IntArray

    @cached_property
    def is_kept(self) -> BoolArray:
        """A mask of the points that represent themselves, of shape (N,)."""
        mask = np.zeros(len(self.reaches), dtype=np.bool_)
        mask[self.kept] = True
        return mask

    @cached_property
    def nearest(self) -> IntArray:
        """The index of the nearest representative of each point, of shape (N,)."""
        if len(self.kept) == len(self.reaches):
            return self.kept
        number = np.zeros(len(self.reaches), dtype=np.int64)
        number[self.kept] = np.arange(len(self.kept))
        own = np.arange(len(self.reaches))
        return np.asarray(number[np.where(self.is_kept, own, self.neighbours[:, 0])])

    @cached_property
    def own(self) -> IntArray:
        """The neighbours of the representatives, in their order, of shape (P, k)."""
        if len(self.kept) == len(self.reaches):
            return self.neighbours
        return self.nearest[self.neighbours[self.kept]]


def representatives(points: FloatArray, k: int) -> Representatives:
    """Return the points that remain when crowds are thinned, and the neighbours among them.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    k : int
        Number of neighbours; one less than the number of representatives if these are fewer.
    """
    kept = np.arange(len(points))
    reaches = np.zeros(len(points))
    if len(points) < 2:
        return Representatives(kept, reaches, np.empty((len(points), 0), dtype=np.int64))
    everywhere = near = nearest_neighbours(points, min(k, len(points) - 1))
    for _ in range(MAX_ROUNDS):
        some = points[kept]
        local = np.ascontiguousarray(near[:, : len(some) // POINTS_PER_NEIGHBOUR])
        found = _native.crowd_reaches(some, local, n_threads=threads_for(len(some)))
        found = np.maximum(found, _reaches_of_large_heaps(some, near))
        found = np.maximum(found, _reaches_of_blades(some, k))
        if np.count_nonzero(found) <= MAX_CROWDED_SHARE_BY_CHANCE * len(some):
            break
        reaches[kept] = np.maximum(reaches[kept], found)
        stays = _native.thinned(some, near, RELATIVE_SPACING_OF_KEPT * found)
        near = _remaining_neighbours(some, near, stays, k)
        kept = kept[stays]
        few = max(
            MAX_SHARE_OF_CROWDED_IN_LAST_ROUND * np.count_nonzero(found),
            MAX_SHARE_OF_ALL_IN_LAST_ROUND * len(points),
        )
        if np.count_nonzero(~stays) <= few:
            break
    if len(kept) < len(points):
        everywhere = nearest_among(points, kept, np.arange(len(points)), near.shape[1])
        # The representative of a crowd may lie outside all crowds. The points thinned last have the
        # best estimate of the distance to the next line.
        others = np.flatnonzero(reaches)
        np.maximum.at(reaches, everywhere[others, 0], reaches[others])
        gone = np.ones(len(points), dtype=np.bool_)
        gone[kept] = False
        reaches[gone] = np.maximum(reaches[gone], reaches[everywhere[gone, 0]])
    thin = Representatives(kept, reaches, everywhere)
    if not reaches.any():
        return thin
    alone = _have_one_direction(points[kept], near)[thin.nearest]
    return restored(points, thin, reaches > 0) if _are_many(alone, thin) else thin


def _have_one_direction(points: FloatArray, near: IntArray) -> BoolArray:
    """Return a mask (P,) of the remaining points with neighbours in one direction only.

    A line of a scan has another beside it, and the remaining points of both cover a surface. A
    narrow band that is sampled evenly looks like a line, too, but does not have another beside it,
    and must not be thinned: on a band of 3,000 points, three spacings wide, distances were off by
    twice their length on average.
    """
    if near.shape[1] < NEIGHBOURS_TO_NEXT_LINE:
        return np.ones(len(points), dtype=np.bool_)  # too few remain for a decision
    nearer, farther = (
        np.linalg.norm(points[near[:, r - 1]] - points, axis=1)
        for r in (NEIGHBOURS_TO_NEXT_LINE // 4, NEIGHBOURS_TO_NEXT_LINE)
    )
    found = ~_in_several_directions(points[near[:, :NEIGHBOURS_TO_NEXT_LINE]]) & (
        farther < MIN_RATIO_OF_HEAPS * nearer
    )  # not a heap
    found |= found[near[:, : N_VOTING_POINTS - 1]].any(axis=1)  # everything around a gap
    return np.asarray(found)


def _are_many(chosen: BoolArray, thin: Representatives) -> bool:
    crowded = thin.reaches > 0
    return bool(
        np.count_nonzero(chosen & crowded) > MIN_SHARE_OF_LONE_POINTS * np.count_nonzero(crowded)
    )


def restored(points: FloatArray, thin: Representatives, again: BoolArray) -> Representatives:
    """Return the representatives to which the points of a mask, (N,), are added again.

    If they are many of the crowded points, these were not crowds, and all are added: a band of
    which half is thinned is worse than one that is thinned entirely.
    """
    if _are_many(again, thin):
        again = again | (thin.reaches > 0)
    kept = np.flatnonzero(thin.is_kept | again)
    all_points = np.arange(len(points))
    near = nearest_among(points, kept, all_points, thin.neighbours.shape[1])
    return Representatives(kept, np.where(again, 0.0, thin.reaches), near)


def _remaining_neighbours(points: FloatArray, near: IntArray, stays: BoolArray, k: int) -> IntArray:
    """Return the neighbours of the points that stay; most have kept all of theirs."""
    left = np.flatnonzero(stays)
    k = min(k, len(left) - 1)
    number = np.full(len(points), -1)
    number[left] = np.arange(len(left))
    result = number[near[left, :k]]
    changed = np.flatnonzero((result < 0).any(axis=1))
    result[changed] = number[nearest_among(points, left, left[changed], k)]
    return np.ascontiguousarray(result)


def _reaches_of_large_heaps(points: FloatArray, near: IntArray) -> FloatArray:
    """Return the reach of heaps that hold all neighbours of their points, 0 outside them.

    Among an eighth of the points, the same number of neighbours covers eight times as many points.
    """
    count = len(near)
    k = max(near.shape[1], RATIO_OF_FARTHER_NEIGHBOURS * max(NUMBERS_OF_HEAPS))
    none = np.zeros(count)
    if count // SAMPLING_STEP_OF_HEAPS <= k:
        return none
    part = np.sort(np.random.default_rng(0).permutation(count)[: count // SAMPLING_STEP_OF_HEAPS])
    probes = np.linspace(0, count - 1, min(N_PROBES, count)).astype(np.int64)
    around = np.column_stack([np.arange(count), near[:, : N_VOTING_POINTS - 1]])
    queried = np.unique(around[probes])
    near = nearest_among(points, part, queried, k)
    seen = _reaches_of_queried_heaps(points, near, queried, around[probes]) > 0
    if seen.mean() < MIN_SHARE_OF_PROBES:
        return none
    all_points = np.arange(count)
    near = nearest_among(points, part, all_points, k)
    return _reaches_of_queried_heaps(points, near, all_points, around)


def _reaches_of_blades(points: FloatArray, k: int) -> FloatArray:
    """Return the reach of blades that hold all neighbours of their points, 0 outside them.

    Blades wider than the neighbourhoods are found in a sample of the points. It is not enough to
    estimate normals from more neighbours, because stars, too, have to reach the next blade.
    """
    reaches = np.zeros(len(points))
    shuffled = np.random.default_rng(0).permutation(len(points))  # steps alias with the scanner's
    for every in SAMPLING_STEPS_OF_BLADES:
        if len(points) < every * N_SAMPLES or len(points) // every <= k:
            break
        part = np.sort(shuffled[: len(points) // every])
        chosen = part[np.linspace(0, len(part) - 1, N_SAMPLES).astype(np.int64)]
        near = nearest_among(points, part, chosen, k)
        blades = where_blades(points, chosen, near)
        if blades.any():
            farthest = np.linalg.norm(points[near[:, -1]] - points[chosen], axis=1)
            queried = np.flatnonzero(blades)
            nearest = np.searchsorted(chosen, nearest_among(points, chosen, queried, 1)[:, 0])
            reaches[queried] = np.maximum(reaches[queried], farthest[nearest])
    return reaches


def _in_several_directions(groups: FloatArray) -> BoolArray:
    """Return a mask (K,) of the groups of points, (K, n, 3), that extend in two directions.

    The next heaps of a surface do. A narrow band of random points looks as uneven as heaps from a
    distance, but extends in one direction.
    """
    offsets = groups - groups.mean(axis=1, keepdims=True)
    spread = np.linalg.eigvalsh(np.einsum("kni,knj->kij", offsets, offsets))
    return np.asarray(spread[:, 1] > MAX_VARIANCE_ACROSS_BANDS * spread[:, 2])


def _reaches_of_queried_heaps(
    points: FloatArray, near: IntArray, queried: IntArray, around: IntArray
) -> FloatArray:
    """Return the reaches at the first of each row of `around`, whose points are all `queried`."""
    row = np.zeros(len(points), dtype=np.int64)
    row[queried] = np.arange(len(queried))
    reaches = np.zeros(len(around))
    for number in NUMBERS_OF_HEAPS:
        nearer, farther = (
            np.linalg.norm(points[near[:, r - 1]] - points[queried], axis=1)
            for r in (number, RATIO_OF_FARTHER_NEIGHBOURS * number)
        )
        signs = np.asarray(farther > MIN_RATIO_OF_HEAPS * nearer)
        certain = farther[signs] > MIN_RATIO_OF_CERTAIN_HEAPS * nearer[signs]
        signs[signs] = certain | _in_several_directions(points[near[signs]])
        found = np.asarray(2 * np.count_nonzero(signs[row[around]], axis=1) > N_VOTING_POINTS)
        reaches[found] = farther[row[around[found, 0]]]
    return reaches
