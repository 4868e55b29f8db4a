"""PNG pictures without a window or a display: VTK draws the shape, matplotlib the page."""

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.atomic import replacing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.viz.camera import choose_views
from geodesic_toolkit.viz.checkers import Checkers
from geodesic_toolkit.viz.colours import choose_style
from geodesic_toolkit.viz.page import Page
from geodesic_toolkit.viz.render import render
from geodesic_toolkit.viz.scene import make_scene

__all__ = ["plot"]

LARGEST_SIDE = 8000


def plot(
    domain: Domain,
    distance: ArrayLike,
    *,
    path: str | os.PathLike[str] | None = None,
    sources: Any = None,
    curves: Any = (),
    arrows: ArrayLike | None = None,
    checkers: Checkers | None = None,
    cmap: Any = "viridis",
    isolines: int | ArrayLike = 20,
    views: Sequence[str | ArrayLike] = ("front", "back"),
    unit: str = "",
    title: str | None = None,
    label: str = "distance",
    limits: Sequence[float] | None = None,
    size: tuple[int, int] = (1600, 800),
    positions: ArrayLike | None = None,
) -> NDArray[np.uint8]:
    """Draw a distance on its shape, as a PNG and as an array, without a window or a display.

    Parameters
    ----------
    domain : Domain
        A TriangleMesh or a PointCloud; a Graph with `positions`.
    distance : array-like of shape (N,)
        Or any other number per vertex. The shape is grey where it is not finite.
    path : str or path-like, optional
        The PNG file to write; it is complete or absent.
    sources : optional
        Places to mark, as :meth:`GeodesicSolver.distance` takes them. By default those where the
        value is exactly 0, if they are few; an empty list marks none.
    curves : Curve, GeodesicPath, CloudPath, or sequence of them, optional
        Lines to draw.
    arrows : array-like of shape (N, 3), optional
        A vector at each vertex, of which a spread selection is drawn, the longest about a twentieth
        of the size of the shape.
    checkers : Checkers, optional
        A pattern on a mesh, coloured by distance from its origin, or on a point cloud: for the
        distance of a logarithmic map.
    cmap : str or matplotlib Colormap
        Perceptually uniform by default; "brg" or any other name of a colour map of matplotlib.
    isolines : int or array-like of float
        Approximate number of lines, at round values; 0 for none; or the values themselves. On
        clouds and graphs the points nearest to them are darker, if points are dense enough.
    views : sequence of str or of array-like of shape (3,)
        "front" (along the thinnest extent, from where the sources are visible), "back" (the other
        side), "x", "-x", "y", "-y", "z", "-z", or a direction to look from.
    unit : str
        Unit of the values, for the colour bar.
    title : str, optional
        A line above the picture.
    label : str
        Name of the values, for the colour bar.
    limits : pair of float, optional
        Ends of the colour map, to compare pictures; the extremes of the values by default.
    size : (int, int)
        Width and height in pixels.
    positions : array-like of shape (N, 3) or (N, 2), optional
        Positions at which the vertices of a graph are drawn.

    Returns
    -------
    ndarray of shape (height, width, 3), uint8

    Raises
    ------
    UnsupportedDomainError
        The domain has no positions.
    InvalidOptionError
        An unknown colour map, view or size; values, arrows or checkers that do not fit the domain.
    InvalidSourceError
        Sources or curves that name no place.
    MissingDependencyError
        pyvista or matplotlib is not installed, or the system has no OpenGL.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> gt.viz.plot(sphere, sphere.vertices[:, 2], size=(200, 100)).shape
    (100, 200, 3)
    """
    width, height = _checked_size(size)
    scene = make_scene(
        domain,
        distance,
        sources=sources,
        curves=curves,
        positions=positions,
        limits=limits,
        arrows=arrows,
        checkers=checkers,
    )
    style = choose_style(scene, cmap, isolines)
    require("pyvista", "viz", "Pictures need")
    page = Page((width, height), scene, choose_views(scene, views), titled=bool(title))
    for index, picture in enumerate(render(scene, style, page)):
        page.place(index, picture)
    if title:
        page.write_title(title)
    page.write_legend(style, f"{label} [{unit}]" if unit else label)
    image = page.finish()
    if path is not None:
        _save(image, path)
    return image


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"size must be (width, height) in pixels, not {size!r}") from error
    if not (100 <= width <= LARGEST_SIDE and 100 <= height <= LARGEST_SIDE):
        raise InvalidOptionError(
            f"each side of the picture must have 100 to {LARGEST_SIDE} pixels, not {size!r}"
        )
    return width, height


def _save(image: NDArray[np.uint8], path: str | os.PathLike[str]) -> None:
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(image).save(temporary, format="PNG", optimize=True)
