"""Masked vertices, which paths may not cross: the domain without them."""

from typing import Any

import numpy as np

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import BoolArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import Domain, PointCloud
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.welding import same_positions
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["as_mask", "assembled_without", "check_unmasked", "passable_part", "with_duplicates"]


def as_mask(mask: Any, n_vertices: int) -> BoolArray:
    """Return `mask` as a fresh boolean array of shape (N,), checked.

    Raises
    ------
    InvalidOptionError
        Values that are not booleans, or not one for each vertex.
    """
    check_nothing_masked(mask, "mask", InvalidOptionError, "{}.filled(True), or False")
    try:
        array = np.asarray(mask)
    except (ValueError, TypeError) as error:
        raise InvalidOptionError(f"mask cannot be read as an array: {error}") from error
    if array.dtype.kind != "b" or array.shape != (n_vertices,):
        truth = array.shape == (n_vertices,) and array.dtype.kind in "iuf"
        cure = "; of 0 and 1: mask.astype(bool)" if truth and np.isin(array, (0, 1)).all() else ""
        raise InvalidOptionError(
            f"mask must hold one boolean for each of the {n_vertices} vertices, True at those that "
            f"paths may not cross, not {array.dtype} of shape {array.shape}{cure}"
        )
    return np.array(array, dtype=np.bool_)


def with_duplicates(domain: Domain, mask: BoolArray) -> BoolArray:
    """Return the mask with all points of a cloud at one position, if it has one of them."""
    if not isinstance(domain, PointCloud):
        return mask
    first, place = same_positions(domain.points)
    held = np.zeros(len(first), dtype=np.bool_)
    held[place[mask]] = True
    return np.asarray(held[place])


def check_unmasked(places: SourcePoints, mask: BoolArray, name: str = "sources") -> None:
    """Raise an `InvalidSourceError` if one of the sources touches a masked vertex.

    Parameters
    ----------
    places : SourcePoints
    mask : ndarray of shape (N,), bool
    name : str
        Name of the sources in the message.
    """
    used = places.vertices
    if mask[used].any():
        raise InvalidSourceError(
            f"{name}: vertex {used[mask[used]][0]} is masked, so that paths cannot start there"
        )


def passable_part(domain: Domain, mask: BoolArray) -> Domain:
    """Return the domain without its masked vertices, checked.

    Raises
    ------
    InvalidOptionError, UnsupportedDomainError
        As for :meth:`Domain.without`; a kind of domain that renumbers its vertices.
    """
    passable = domain.without(mask)
    if not isinstance(passable, Domain) or passable.n_vertices != domain.n_vertices:
        raise UnsupportedDomainError(
            f"{type(domain).__name__}.without must return a domain of the same "
            f"{domain.n_vertices} vertices, not {passable!r}"
        )
    return passable


def assembled_without(
    operator: LaplaceOperator, domain: Domain, mask: BoolArray
) -> tuple[Discretization, Discretization | None]:
    """Return the discretization of a domain without its masked vertices.

    The stars of a cloud are made with all of its points, and triangles that touch a masked point
    are removed: stars made without these points would close over them, and paths would cross walls
    of up to four rows.

    Parameters
    ----------
    operator : LaplaceOperator
    domain : Domain
    mask : ndarray of shape (N,), bool

    Returns
    -------
    left : Discretization
    whole : Discretization or None
        The discretization of the whole cloud, if `left` is a part of it.

    Raises
    ------
    InvalidOptionError, UnsupportedDomainError
        As for :meth:`Domain.without`, and errors of the operator.
    """
    passable = passable_part(domain, mask)
    operator.check_domain(passable)
    if isinstance(domain, PointCloud):
        whole = operator.assemble(domain)
        stars = whole.gradient
        if isinstance(stars, ElementGradient) and stars.stars and whole.surface is None:
            return _restricted(whole, stars, mask), whole
    return operator.assemble(passable), None


def _restricted(whole: Discretization, stars: ElementGradient, mask: BoolArray) -> Discretization:
    """Return a discretization without the elements that touch a masked vertex."""
    count = whole.n_vertices
    touched = mask[stars.elements].any(axis=1)
    stay = ~touched
    left = ElementGradient(
        stars.elements[stay],
        stars.coefficients[stay],
        stars.measure[stay],
        count,
        stars=True,
        copy=False,
    )
    shares = np.repeat(stars.measure, stars.elements.shape[1])
    corners = stars.elements.ravel()
    had = np.bincount(corners, shares, count)
    has = np.bincount(left.elements.ravel(), shares[np.repeat(stay, 3)], count)
    kept = np.divide(has, had, out=np.where(mask, 0.0, 1.0), where=had > 0)
    boundary = whole.boundary.copy()
    boundary[stars.elements[touched]] = True
    return Discretization(
        mass=whole.mass * kept,
        stiffness=left.stiffness(),
        gradient=left,
        spacing=whole.spacing,
        boundary=boundary & ~mask,
        scales=whole.scales,
        surface_frames=whole.surface_frames[stay]
        if len(whole.surface_frames)
        else np.zeros((0, 3)),
        normals=whole.normals,
        notes={**whole.notes, "masked": int(mask.sum())},
        copy=False,
    )
