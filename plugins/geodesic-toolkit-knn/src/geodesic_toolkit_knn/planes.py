"""The directions in which neighbourhoods extend, and what lies off them."""

import numpy as np

from geodesic_toolkit_knn.tables import FloatArray, IntArray

__all__ = ["NEIGHBOURS_IN_NOISE", "charts", "frames_of", "growth_of_roughness"]

NEIGHBOURS_OF_PLANE, NEIGHBOURS_IN_NOISE = 12, 30
"""Neighbours that a plane is found among, and the same in noise: those of point clouds in space.
Measured on rolls, S-curves and flat tori of 1,000 to 20,000 samples in ten dimensions with noise of
a fifth of the distance to the nearest sample: 0.2 to 1.4 % of error among 30."""

N_PROBES = 2000
"""Samples that show how rough the data are."""

MAX_ROUGHNESS_OF_ROUNDING = 1e-3
"""Roughness up to which there is only rounding."""

GROWTH_ON_SMOOTH_SURFACES = 1.58
"""Growth of the roughness where it is only rounding: the ratio sqrt(30 / 12) of the widths."""

MAX_SQUARED_SINE = (0.5, 0.2)
"""Square of the sine of the elevation up to which a neighbour is on the sheet of a sample: of the
first neighbours, and of those that a star takes when it grows. Those of point clouds in space."""

NOISE_OFF_SHEET = 4.0
"""Squared distance from the sheet that noise may account for, in medians over all samples."""

NUMBERS_AT_ONCE = 20_000_000
"""Numbers in memory at once."""


def frames_of(points: FloatArray, near: IntArray, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Return orthonormal directions of most extent of neighbourhoods, and all their variances.

    Parameters
    ----------
    points : ndarray of shape (M, D)
    near : ndarray of shape (P, k)
    dimension : int

    Returns
    -------
    frames : ndarray of shape (P, dimension, D)
    variances : ndarray of shape (P, min(D, k))
        Sums of squares along the principal directions, the largest first.
    """
    count, k = near.shape
    size = points.shape[1]
    kept = min(size, k)
    frames, variances = np.zeros((count, dimension, size)), np.zeros((count, max(kept, dimension)))
    for some in _batches(count, (k + 1) * (size + k)):
        places = points[near[some]]
        places -= places.mean(axis=1, keepdims=True)
        turned = places.transpose(0, 2, 1)
        wide = size > k
        values, vectors = np.linalg.eigh(places @ turned if wide else turned @ places)
        values, vectors = np.maximum(values[:, ::-1], 0.0), vectors[:, :, ::-1][:, :, :dimension]
        found = vectors.transpose(0, 2, 1)
        if wide:
            found = found @ places
            lengths = np.sqrt(values[:, : found.shape[1], None])
            found = np.divide(found, lengths, out=np.zeros_like(found), where=lengths > 0)
        frames[some, : found.shape[1]] = found
        variances[some, :kept] = values[:, :kept]
    return frames, variances


def growth_of_roughness(points: FloatArray, near: IntArray, dimension: int) -> float:
    """Return how much rougher a wider neighbourhood is: above 1 with curvature, below in noise.

    The roughness is how far samples stand off the principal directions of their neighbourhood, in
    shares of its least width along them.
    """
    if near.shape[1] < NEIGHBOURS_IN_NOISE:
        return GROWTH_ON_SMOOTH_SURFACES
    chosen = np.linspace(0, len(near) - 1, min(N_PROBES, len(near))).astype(np.int64)
    roughness = []
    for k in (NEIGHBOURS_OF_PLANE, NEIGHBOURS_IN_NOISE):
        variances = frames_of(points, near[chosen, :k], dimension)[1]
        off, width = variances[:, dimension:].sum(axis=1), variances[:, dimension - 1]
        share = np.divide(off, width, out=np.zeros_like(off), where=width > 0)
        roughness.append(np.sqrt(share))
    few, more = roughness
    growth = np.full(len(few), GROWTH_ON_SMOOTH_SURFACES)
    np.divide(more, few, out=growth, where=few > MAX_ROUGHNESS_OF_ROUNDING)
    return float(np.median(growth))


def charts(
    points: FloatArray, near: IntArray, dimension: int, *, k: int, in_space: float, noisy: bool
) -> FloatArray:
    """Return where the neighbours of each sample lie along its principal directions.

    A neighbour keeps its direction there. Its distance is that in space where there is almost no
    noise, and otherwise that across the principal directions of both, which noise off them does not
    lengthen.

    Parameters
    ----------
    points : ndarray of shape (M, D)
    near : ndarray of shape (M, m)
        Nearest first.
    dimension : int
    k : int
        Neighbours for which the looser of the bounds on the elevation holds.
    in_space : float
        How far distances are those in space, from 0 to 1.
    noisy : bool
        Whether directions are taken from more neighbours.

    Returns
    -------
    ndarray of shape (M, m, dimension)
        NaN for neighbours on another sheet.
    """
    among = NEIGHBOURS_IN_NOISE if noisy else NEIGHBOURS_OF_PLANE
    frames, variances = frames_of(points, near[:, :among], dimension)
    used = min(among, near.shape[1])
    noise = NOISE_OFF_SHEET * float(np.median(variances[:, dimension:].sum(axis=1) / used))
    sines = np.where(np.arange(near.shape[1]) < k, *MAX_SQUARED_SINE)
    coordinates = np.empty((*near.shape, dimension))
    size = near.shape[1] * points.shape[1] * (dimension + 2)
    for some in _batches(len(near), size):
        steps = points[near[some]] - points[some][:, None]
        own = np.einsum("nkd,npd->nkp", steps, frames[some])
        theirs = np.einsum("nkd,nkpd->nkp", steps, frames[near[some]])
        squared = np.einsum("nkd,nkd->nk", steps, steps)
        along, across = (np.einsum("nkp,nkp->nk", c, c) for c in (own, theirs))
        most = sines * squared + noise
        on_sheet = (squared - along <= most) & (squared - across <= most) & (along > 0)
        wanted = in_space * squared + (1 - in_space) * (along + across) / 2
        ratio = np.sqrt(np.divide(wanted, along, out=np.full_like(along, np.nan), where=on_sheet))
        coordinates[some] = own * ratio[:, :, None]
    return coordinates


def _batches(count: int, size: int) -> list[slice]:
    """Return slices of rows of so many numbers each, of which a few million are in memory."""
    step = max(1, NUMBERS_AT_ONCE // max(1, size))
    return [slice(begin, begin + step) for begin in range(0, count, step)]
