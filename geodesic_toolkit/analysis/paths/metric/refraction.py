"""Shortest polylines through strips of faces, each with a metric of its own: refraction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solveh_banded

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray

__all__ = ["Polylines", "refracted"]

FIRST_SHARE = 0.5
"""Share at which all free points begin."""

BARRIERS = tuple(10.0**-power for power in range(1, 11))
"""Weights of the barrier, one after the other, in mean lengths of segments. With the last one a
polyline of P points is at most 2e-10 P mean segments longer than the shortest, and points that
press against a vertex are within some 1e-9 of it, in edges."""

STEPS_PER_BARRIER = 12
"""Newton steps at most for one weight; two or three are the rule."""

SETTLED = 0.01
"""Decrement of a Newton step for each point, in weights of the barrier, at which the next weight
follows. With 1e-5 there are twice as many steps, and lengths differ by less than 1e-12."""

NEAREST_TO_BOUND = 0.99
"""Share of the way to a bound that a step goes at most."""

SUFFICIENT_DECREASE = 1e-4
"""Share of the linear decrease that a step must reach (Armijo)."""

MAX_HALVINGS = 40
"""Halvings of a step, after which the rest is rounding."""

SNAPPED = (1e-3, 1e-5, 1e-7)
"""Shares within which a point is moved to the vertex, of which the one of the shortest polyline is
taken: points that press against a vertex are within 1e-8, and those of a line that just passes
through it within the square root of the barrier."""

POLISHING_STEPS = 12
"""Newton steps without barrier at most; convergence is quadratic."""

REGULARIZATION = 1e-12
"""Share of the second derivatives that is added to them: where a line runs along an edge, its point
on this edge is arbitrary."""


@dataclass(frozen=True, eq=False)
class Polylines:
    """Polylines through faces, one after the other, of P points together.

    Attributes
    ----------
    frames : ndarray of shape (P - 1, 3, 2), float64
        Corners, in its plane, of the face that leads from each point to the next; zeros where a
        polyline ends.
    tails, heads : ndarray of shape (P - 1, 2), int64
        The corners of that face between which the point and the next one lie; twice the same at a
        vertex.
    free : ndarray of shape (P,), bool
        False at points that stay.
    shares : ndarray of shape (P,), float64
        Share of the second of these corners in each point.
    """

    frames: FloatArray
    tails: IntArray
    heads: IntArray
    free: BoolArray
    shares: FloatArray

    @cached_property
    def _sides(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The step between the first corners, and both edges, (P - 1, 2)."""
        rows = np.arange(len(self.frames))[:, None]
        tail, head = self.frames[rows, self.tails], self.frames[rows, self.heads]
        return head[:, 0] - tail[:, 0], tail[:, 1] - tail[:, 0], head[:, 1] - head[:, 0]

    def steps(self, shares: FloatArray) -> FloatArray:
        """Return the segments as vectors, (P - 1, 2)."""
        base, tail, head = self._sides
        return base + head * shares[1:, None] - tail * shares[:-1, None]

    @property
    def lengths(self) -> FloatArray:
        """Lengths of the segments, (P - 1,)."""
        steps = self.steps(self.shares)
        return np.sqrt(_dot(steps, steps))

    def derivatives(
        self, shares: FloatArray, smoothing: float
    ) -> tuple[float, FloatArray, FloatArray, FloatArray]:
        """Return length, gradient (P,), and the Hessian's diagonal (P,) and (P - 1,) beside it."""
        _, tail, head = self._sides
        steps = self.steps(shares)
        lengths = np.sqrt(_dot(steps, steps) + smoothing**2)
        inverse = np.divide(1.0, lengths, out=np.zeros(len(lengths)), where=lengths > 0)
        gradient, diagonal = np.zeros(len(shares)), np.zeros(len(shares))
        gradient[:-1] -= _dot(steps, tail) * inverse
        gradient[1:] += _dot(steps, head) * inverse
        # a.b - (a.u)(b.u) of a unit vector u is (a x u)(b x u), without cancellation
        off_tail, off_head, cube = _cross(steps, tail), _cross(steps, head), inverse**3
        diagonal[:-1] += (off_tail**2 + smoothing**2 * _dot(tail, tail)) * cube
        diagonal[1:] += (off_head**2 + smoothing**2 * _dot(head, head)) * cube
        beside = -(off_tail * off_head + smoothing**2 * _dot(tail, head)) * cube
        return float(lengths.sum()), gradient, diagonal, beside


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1])


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def refracted(lines: Polylines, *, exact: bool = True) -> Polylines:
    """Return the shortest polylines through the same faces.

    The length is a convex function of the shares, a sum of norms, and its Hessian is tridiagonal.
    Newton's method minimises it with a logarithmic barrier at the ends of the edges, whose weight
    falls. At a positive weight no segment has length zero, which would not be smooth.

    Parameters
    ----------
    lines : Polylines
    exact : bool
        Move points that press against vertices there, and minimise over all others to rounding.

    Returns
    -------
    Polylines
    """
    if not lines.free.any():
        return lines
    shares = np.where(lines.free, FIRST_SHARE, lines.shares)
    unit = float(replace(lines, shares=shares).lengths.mean())
    if not unit > 0:
        return lines
    scaled = replace(lines, frames=lines.frames / unit)
    for weight in BARRIERS:
        shares = _centred(scaled, shares, weight)
    if not exact:
        return replace(lines, shares=shares)
    found = [_polished(replace(scaled, shares=shares), near) for near in SNAPPED]
    best = min(found, key=lambda one: float(one.lengths.sum()))
    return replace(lines, shares=best.shares)


def _centred(lines: Polylines, shares: FloatArray, weight: float) -> FloatArray:
    """Return the shares at which length plus barrier are least, by Newton's method."""
    free = lines.free

    def barrier(at: FloatArray) -> float:
        with np.errstate(divide="ignore"):  # rounded to 1: infinite, and not taken
            return -weight * float((np.log(at[free]) + np.log1p(-at[free])).sum())

    def merit(at: FloatArray) -> float:
        steps = lines.steps(at)
        return float(np.sqrt(_dot(steps, steps) + weight**2).sum()) + barrier(at)

    for _ in range(STEPS_PER_BARRIER):
        length, gradient, diagonal, beside = lines.derivatives(shares, weight)
        gradient[free] += weight / (1 - shares[free]) - weight / shares[free]
        diagonal[free] += weight / shares[free] ** 2 + weight / (1 - shares[free]) ** 2
        step = _newton_step(gradient, diagonal, beside, free)
        decrease = -float(gradient @ step)
        if decrease <= SETTLED * weight * np.count_nonzero(free):
            break
        scale = min(1.0, NEAREST_TO_BOUND * _room(shares, step))
        before = length + barrier(shares)
        for _ in range(MAX_HALVINGS):
            if merit(shares + scale * step) <= before - SUFFICIENT_DECREASE * scale * decrease:
                break
            scale /= 2
        else:
            break
        shares = shares + scale * step
    return shares


def _newton_step(
    gradient: FloatArray, diagonal: FloatArray, beside: FloatArray, free: BoolArray
) -> FloatArray:
    """Return the solution of the tridiagonal system, 0 where shares are not free."""
    bands = np.zeros((2, len(gradient)))
    bands[0, 1:] = np.where(free[1:] & free[:-1], beside, 0.0)
    bands[1] = np.where(free, diagonal, 1.0)
    bands[1] += REGULARIZATION * (bands[1] + REGULARIZATION * bands[1].max())
    return np.asarray(solveh_banded(bands, np.where(free, -gradient, 0.0), check_finite=False))


def _room(shares: FloatArray, step: FloatArray) -> float:
    """Return the multiple of a step at which the first share comes to 0 or 1."""
    bound = np.where(step > 0, 1.0 - shares, shares)
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(step != 0, bound / np.abs(step), np.inf)
    return float(most.min())


def _polished(lines: Polylines, near: float) -> Polylines:
    """Return polylines with points near vertices on them, and the shortest for all others."""
    shares = lines.shares.copy()
    shares[lines.free & (shares < near)] = 0.0
    shares[lines.free & (shares > 1 - near)] = 1.0
    best = replace(lines, shares=shares)
    least = float(best.lengths.sum())
    for _ in range(POLISHING_STEPS):
        free = lines.free & (shares > 0) & (shares < 1)
        if not free.any():
            break
        _, gradient, diagonal, beside = lines.derivatives(shares, 0.0)
        step = _newton_step(gradient, diagonal, beside, free)
        shares = np.clip(shares + min(1.0, _room(shares, step)) * step, 0.0, 1.0)
        found = replace(lines, shares=shares)
        length = float(found.lengths.sum())
        if not length < least:
            break
        best, least = found, length
    return best
