"""Elements of the gradient and measures for the stars and links of a cloud."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.geometry.triangles import face_areas, hat_gradients, inverse_frames
from geodesic_toolkit.laplacians.pointcloud.soup import Soup

__all__ = ["TIE_LENGTH", "areas_of", "frames_on_surface", "with_segments"]

MIN_SQUARED_RELATIVE_HEIGHT = 1e-16
"""Squared height of a triangle relative to its edge below which the height is rounding."""

TIE_LENGTH = 1e-9
"""Distance of duplicates from their representative, in spacings."""

TIE_WEIGHT = 1e6
"""Stiffness between them, relative to the stiffness that holds the representative."""


def with_segments(
    triangles: IntArray,
    frames: FloatArray,
    shares: FloatArray,
    *,
    links: tuple[IntArray, FloatArray, FloatArray],
    ties: IntArray,
    tie_length: float,
    n_vertices: int,
) -> ElementGradient:
    """Return the gradient on triangles, a third of each, on links of given widths, and on ties.

    A segment (i, j) is the element (i, j, j) on which the gradient has one component, along it.
    Ties are stiff relative to the elements at their first end. Outliers are held by a thousandth of
    a millionth, and with ties equally stiff everywhere that would be lost to rounding in a factor.
    """
    elements, coefficients = [triangles], [hat_gradients(frames)]
    measures = [shares * face_areas(frames) / 3]
    ends, lengths, widths = links
    held = np.bincount(ends.ravel(), np.repeat(widths / lengths, 2), minlength=n_vertices)
    each = measures[0][:, None] * np.einsum("edc,edc->ec", coefficients[0], coefficients[0])
    held = held + np.bincount(triangles.ravel(), each.ravel(), minlength=n_vertices)
    stiff = TIE_WEIGHT * np.where(held > 0, held, 1.0)[ties[:, 0]]
    lengths_of_ties = np.full(len(ties), tie_length)
    for pairs, long, wide in (links, (ties, lengths_of_ties, stiff * tie_length)):
        slope = np.zeros((len(pairs), 2, 3))
        slope[:, 0, 0], slope[:, 0, 1] = -1 / long, 1 / long
        elements.append(pairs[:, [0, 1, 1]])
        coefficients.append(slope)
        measures.append(long * wide)
    return ElementGradient(
        np.concatenate(elements),
        np.concatenate(coefficients),
        np.concatenate(measures),
        n_vertices,
        stars=True,
        copy=False,
    )


def areas_of(soup: Soup, count: int) -> FloatArray:
    """Return the measure at every position: a ninth of its triangles and half of its links."""
    corner_areas = np.repeat(soup.shares * face_areas(soup.frames) / 9, 3)
    halves = np.repeat(soup.link_lengths * soup.link_widths / 2, 2)
    area = np.bincount(soup.triangles.ravel(), corner_areas, minlength=count)
    return np.asarray(area + np.bincount(soup.links.ravel(), halves, minlength=count))


def frames_on_surface(
    points: FloatArray, soup: Soup, gradient: ElementGradient, in_space: FloatArray, scale: float
) -> FloatArray:
    """Return the inverse frames of all elements, with triangles measured in space by `in_space`.

    For shares between 0 and 1, the inner products of the two edges from the centre are averaged;
    the result is that of a triangle.
    """
    if not in_space.any():
        return np.zeros((0, 3))
    share = in_space[soup.triangles[:, 0]]
    frames, (centre, second, third) = soup.frames, soup.triangles.T
    p, q = points[second] - points[centre], points[third] - points[centre]
    flat = (frames[:, 0] ** 2, frames[:, 0] * frames[:, 1], frames[:, 1] ** 2 + frames[:, 2] ** 2)
    solid = (np.einsum("ed,ed->e", *pair) for pair in ((p, p), (p, q), (q, q)))
    pp, pq, qq = (s * share + f * (1 - share) for s, f in zip(solid, flat, strict=True))
    length = np.sqrt(pp)
    height = np.sqrt(np.maximum(qq - (pq / length) ** 2, MIN_SQUARED_RELATIVE_HEIGHT * qq))
    inverse = gradient.inverse_frames.copy()
    triangles = np.column_stack([length, pq / length, height])
    inverse[: len(frames)] = inverse_frames(triangles * scale)
    return inverse
