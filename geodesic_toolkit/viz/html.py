"""Pictures as one HTML file that works offline in any browser, and as a widget in notebooks."""

import base64
import html
import os
import zlib
from collections.abc import Sequence
from importlib import resources
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.atomic import replacing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import MissingDependencyError
from geodesic_toolkit.viz.camera import choose_views
from geodesic_toolkit.viz.colours import (
    CURVE,
    INK,
    MARKER,
    UNREACHED,
    Style,
    choose_style,
    packed,
    point_colours,
)
from geodesic_toolkit.viz.contours import contour_lines
from geodesic_toolkit.viz.legend import legend
from geodesic_toolkit.viz.scene import Scene, compacted, make_scene

__all__ = ["save_html", "show"]

FIELD_OF_VIEW = 25.0
LINE_WIDTH = 0.004
CURVE_WIDTH = 0.012
MARKER_RADIUS = 0.025
VIEWER = "static/standalone.js"  # k3d's viewer, an AMD module without dependencies
ENTRY = "CreateK3DAndLoadBinarySnapshot"  # its function that page.js calls
COMPRESSION = 6


def save_html(
    domain: Domain,
    distance: ArrayLike,
    path: str | os.PathLike[str],
    *,
    sources: Any = None,
    curves: Any = (),
    cmap: Any = "viridis",
    isolines: int | ArrayLike = 20,
    unit: str = "",
    title: str | None = None,
    label: str = "distance",
    limits: Sequence[float] | None = None,
    positions: ArrayLike | None = None,
) -> None:
    """Write one HTML file that shows a distance on its shape, rotatable and without a network.

    Drag the mouse to rotate; on meshes the value under the pointer is shown. The file contains the
    viewer (k3d, 1 MB) and the shape in single precision, compressed. If a browser does not offer
    WebGL 2, the page says so.

    Parameters
    ----------
    domain, distance, sources, curves, cmap, isolines, unit, title, label, limits, positions
        As for :func:`plot`.
    path : str or path-like
        The file to write; it is complete or absent.

    Raises
    ------
    UnsupportedDomainError, InvalidOptionError, InvalidSourceError, WriteError
        As for :func:`plot`.
    MissingDependencyError
        k3d, pyvista or matplotlib is not installed, or this version of k3d lacks the viewer.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> file = pathlib.Path(tempfile.mkdtemp(), "sphere.html")
    >>> gt.viz.save_html(sphere, gt.geodesic_distance(sphere, 0), file, unit="m")
    >>> file.read_text(encoding="utf-8").startswith("<!doctype html>")
    True
    """
    scene = make_scene(
        domain, distance, sources=sources, curves=curves, positions=positions, limits=limits
    )
    style = choose_style(scene, cmap, isolines)
    widget = _widget(scene, style, name=label)
    widget.colorbar_object_id = 0  # the page has its own
    widget.menu_visibility = False
    widget.mode = "callback"  # follow the pointer: page.js shows the value there
    for item in widget.objects:
        if item.type == "Mesh":
            item.hover_callback = _nothing
    page = Template(_text_of("page.html")).substitute(
        title=html.escape(title or label),
        css=_text_of("page.css"),
        legend=legend(scene, style, label=label, unit=unit, title=title),
        viewer=_encoded(zlib.compress(_viewer(), COMPRESSION)),
        scene=_encoded(widget.get_binary_snapshot(COMPRESSION)),
        script=_text_of("page.js"),
    )
    with replacing(path) as temporary:
        temporary.write_text(page, encoding="utf-8")


def show(
    domain: Domain,
    distance: ArrayLike,
    *,
    sources: Any = None,
    curves: Any = (),
    cmap: Any = "viridis",
    isolines: int | ArrayLike = 20,
    label: str = "distance",
    limits: Sequence[float] | None = None,
    positions: ArrayLike | None = None,
    height: int = 512,
) -> Any:
    """Return a rotatable widget of a distance on its shape: the last line of a notebook's cell.

    Parameters
    ----------
    domain, distance, sources, curves, cmap, isolines, label, limits, positions
        As for :func:`plot`.
    height : int
        In pixels.

    Returns
    -------
    k3d.Plot
        Notebooks display it; its objects and camera can be changed.

    Raises
    ------
    UnsupportedDomainError, InvalidOptionError, InvalidSourceError
        As for :func:`plot`.
    MissingDependencyError
        k3d, pyvista or matplotlib is not installed.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> widget = gt.viz.show(sphere, gt.geodesic_distance(sphere, 0))
    >>> [item.name for item in widget.objects]
    ['distance', 'isolines', 'sources']
    """
    scene = make_scene(
        domain, distance, sources=sources, curves=curves, positions=positions, limits=limits
    )
    widget = _widget(scene, choose_style(scene, cmap, isolines), name=label)
    widget.height = height
    return widget


def _viewer() -> bytes:
    """Return the JavaScript viewer from the files of k3d.

    Raises
    ------
    MissingDependencyError
        The installed k3d lacks the viewer.
    """
    try:
        program = resources.files("k3d").joinpath(VIEWER).read_bytes()
    except FileNotFoundError:
        program = b""
    if ENTRY.encode() not in program:
        raise MissingDependencyError(
            f"the installed k3d has no viewer for HTML pages ({VIEWER} with {ENTRY}), as version "
            '3.2 has; install a suitable one: pip install -U "geodesic-toolkit[viz]"'
        )
    return program


def _text_of(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _encoded(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _widget(scene: Scene, style: Style, *, name: str) -> Any:
    """Return a k3d plot of a scene, in the scene's coordinates."""
    k3d = require("k3d", "viz", "HTML pictures and widgets need")
    front = choose_views(scene, ["front"])[0]
    reach = max(0.1, float(np.linalg.norm(scene.points[scene.present], axis=1).max()))
    distance = 1.08 * reach / np.sin(np.radians(FIELD_OF_VIEW / 2))
    widget = k3d.plot(
        grid_visible=False,
        axes_helper=0.0,
        background_color=0xFFFFFF,
        lighting=1.7,
        camera_auto_fit=False,
        camera_fov=FIELD_OF_VIEW,
        snapshot_type="full",
    )
    widget.camera = [*(distance * front.toward).tolist(), 0.0, 0.0, 0.0, *front.up.tolist()]
    items = _points(k3d, scene, style, name) if scene.faces is None else []
    if scene.faces is not None:
        items = [*_faces(k3d, scene, style, name), *_isolines(k3d, scene, style)]
    items += _curves(k3d, scene)
    if len(scene.sources):
        size = 2 * max(MARKER_RADIUS, 0.0 if scene.faces is not None else 1.3 * scene.ball)
        look = {"shader": "mesh", "mesh_detail": 3, "name": "sources"}
        items.append(
            k3d.points(_single(scene.sources), point_size=size, color=packed(MARKER), **look)
        )
    for item in items:
        widget += item
    return widget


def _faces(k3d: Any, scene: Scene, style: Style, name: str) -> list[Any]:
    assert scene.faces is not None
    reached = scene.face_reached
    look = {"flat_shading": False, "side": "double", "roughness": 0.6}
    items = []
    if reached.any():
        used, faces = compacted(scene.faces[reached])
        stops = np.column_stack([np.linspace(0, 1, len(style.table)), style.table])
        items.append(
            k3d.mesh(
                _single(scene.points[used]),
                faces.astype(np.uint32),
                attribute=_single(scene.values[used]),
                color_map=_single(stops).ravel(),
                color_range=list(scene.limits),
                name=name,
                **look,
            )
        )
    if not reached.all():
        used, faces = compacted(scene.faces[~reached])
        points, grey = _single(scene.points[used]), packed(UNREACHED)
        items.append(
            k3d.mesh(points, faces.astype(np.uint32), color=grey, name="not reached", **look)
        )
    return items


def _isolines(k3d: Any, scene: Scene, style: Style) -> list[Any]:
    points, segments = contour_lines(scene, style.levels)
    if len(segments) == 0:
        return []
    look = {"shader": "mesh", "radial_segments": 5, "width": LINE_WIDTH, "name": "isolines"}
    lines = k3d.lines(
        _single(points),
        segments.astype(np.uint32),
        indices_type="segment",
        color=packed(INK),
        **look,
    )
    return [lines]


def _curves(k3d: Any, scene: Scene) -> list[Any]:
    look = {"shader": "mesh", "radial_segments": 8, "width": CURVE_WIDTH, "name": "curve"}
    return [k3d.line(_single(line), color=packed(CURVE), **look) for line in scene.curves]


def _points(k3d: Any, scene: Scene, style: Style, name: str) -> list[Any]:
    colours = np.array([packed(colour) for colour in point_colours(scene, style)[scene.present]])
    items = [
        k3d.points(
            _single(scene.points[scene.present]),
            colors=colours.astype(np.uint32),
            point_size=2 * scene.ball,
            shader="3d",
            name=name,
        )
    ]
    if scene.edges is not None and len(scene.edges):
        look = {"indices_type": "segment", "color": 0x999999, "shader": "simple", "name": "edges"}
        items.append(k3d.lines(_single(scene.points), scene.edges.astype(np.uint32), **look))
    return items


def _nothing(*_: Any) -> None:
    """Do nothing: the viewer follows the pointer only if there is a callback."""


def _single(values: FloatArray) -> Any:
    return np.ascontiguousarray(values, dtype=np.float32)
