"""The length of curves, and the area that a level encloses."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.analysis.curves.cuts import (
    areas_of,
    as_field,
    as_level,
    as_mesh,
    cut_triangles,
    finite_faces,
)
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.sources.curves import polyline_length
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.locate import corners_of_curve

__all__ = ["area_above", "curve_length"]


def curve_length(domain: Any, curve: Curve) -> float:
    """Return the length of a curve as a polyline in space, in the unit of the domain.

    Parameters
    ----------
    domain : Domain or object
        The shape of the curve, or an object that :func:`as_domain` converts.
    curve : Curve

    Returns
    -------
    float

    Raises
    ------
    InvalidSourceError
        Not a curve, or one with points in faces that the domain does not have.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(5)
    >>> gt.curve_length(square, gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]]))
    2.0
    """
    shape = as_domain(domain)
    if not isinstance(curve, Curve):
        raise InvalidSourceError(f"a Curve has a length, {a_kind_of(curve)} has not")
    return polyline_length(corners_of_curve(shape, curve, "curve"), closed=curve.closed)


def area_above(domain: Any, values: ArrayLike, level: float) -> float:
    """Return the area of a mesh on which a field has a value or more: left of its isolines.

    Within a face the field is linear. The area where it has less is that of the negative field
    above the negative level, except for faces on which the field is the level throughout.

    Parameters
    ----------
    domain : TriangleMesh or object
    values : array-like of shape (N,)
        Faces are left out where one is not finite.
    level : float

    Returns
    -------
    float
        In squared units of length.

    Raises
    ------
    UnsupportedDomainError
        Not a mesh.
    InvalidOptionError
        Values that are not one number a vertex, a level that is not finite.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(8)
    >>> round(gt.area_above(square, square.vertices[:, 0], 0.3), 12)
    0.7
    """
    mesh = as_mesh(domain, "areas")
    field, bound = as_field(values, mesh.n_vertices), as_level(level)
    triangles = mesh.faces[finite_faces(mesh, field)]
    areas = areas_of(mesh.vertices, triangles)
    whole = areas[(field[triangles] >= bound).all(axis=1)].sum()
    cuts = cut_triangles(triangles, field, bound)
    tip = cuts.from_alone.prod(axis=1)
    part = areas[cuts.triangles] @ np.where(cuts.above, tip, 1 - tip)
    return float(whole + part)
