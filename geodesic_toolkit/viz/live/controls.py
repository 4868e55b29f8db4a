"""The page: the shape, its marks and its panel, joined to a session."""

import io
import math
import re
import threading
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import collected_warnings
from geodesic_toolkit.errors import (
    GeodesicError,
    GeodesicWarning,
    InvalidOptionError,
    InvalidSourceError,
    WriteError,
)
from geodesic_toolkit.viz.camera import choose_views
from geodesic_toolkit.viz.colours import (
    CURVE,
    MARKER,
    choose_style,
    colour_table,
    isoline_levels,
    point_colours,
)
from geodesic_toolkit.viz.live.coding import N_COLOURS, coded, style_rows
from geodesic_toolkit.viz.live.marks import balls, tube
from geodesic_toolkit.viz.live.readout import MEASURED, legend, warnings_as_html
from geodesic_toolkit.viz.live.session import MOST_PARTS, Mode, Place, Session

__all__ = ["Controls", "check_look"]

FIELD_OF_VIEW = 30.0
RADIUS_OF_MARKS = 0.018
RADIUS_OF_PATH = 0.008
MOST_LINES = 60
"""Number of isolines at the end of the slider."""

MOST_MARKS = 200
"""Number of sources that are marked; a label may have thousands."""

COLOUR_MAPS = ("viridis", "plasma", "cividis", "magma", "turbo", "twilight", "brg", "gray")
SECONDS_OF_NOTICE = 15.0
SECONDS_OF_PICTURE = 30.0
"""Seconds after which a page that is not on the screen is not waited for."""

Colour = tuple[float, float, float]

MODES = {
    "sets the source": Mode.SOURCE,
    "draws a path": Mode.PATH,
    "reads the distance": Mode.MEASURE,
}


def check_look(cmap: str, isolines: int) -> None:
    """Raise an `InvalidOptionError` for a colour map or a number of isolines that is not one."""
    if not isinstance(cmap, str):
        raise InvalidOptionError(f"cmap must be the name of a colour map, not {cmap!r}")
    colour_table(cmap, N_COLOURS)
    if (
        isinstance(isolines, bool)
        or not isinstance(isolines, int)
        or not 0 <= isolines <= MOST_LINES
    ):
        raise InvalidOptionError(
            f"isolines must be an integer from 0 to {MOST_LINES}, not {isolines!r}"
        )


class Controls:
    """A session on a page; made for a server, on which it puts everything.

    Callbacks come from several threads of viser, and one at a time changes the session.

    Parameters
    ----------
    server : viser.ViserServer
    session : Session
    cmap : str
        Colour map of matplotlib to begin with.
    isolines : int
        Number of isolines to begin with.
    unit : str
        Unit of the distances.

    Attributes
    ----------
    warnings : dict of str to (str, str)
        Kind and text of the warnings on the page. Those that differ in their numbers alone are one
        warning, with the text of the last: many depend on the sources.
    """

    def __init__(
        self, server: Any, session: Session, *, cmap: str, isolines: int, unit: str
    ) -> None:
        self._server, self._session, self._unit = server, session, unit
        self._lock = threading.RLock()
        self._meshes: dict[str, Any] = {}
        self.warnings: dict[str, tuple[str, str]] = {}
        self._list: Any = None
        names = dict.fromkeys([cmap, *COLOUR_MAPS])
        self._maps = {name: colour_table(name, N_COLOURS) for name in names}
        self._solid = session.scene.faces is not None
        self._set_scene()
        self._add_panel(cmap, isolines)
        self._show_all()
        for modifier in (None, "shift"):
            server.scene.on_click(modifier=modifier)(self._clicked)

    # -- the shape ---------------------------------------------------------------------------------

    def _set_scene(self) -> None:
        server, session = self._server, self._session
        scene = session.scene
        server.gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            control_width="medium",
            brand_color=(40, 90, 150),
        )
        server.gui.main_panel.dock_right()
        marked = replace(scene, sources=session.positions_of(session.sources[:MOST_MARKS]))
        front = choose_views(marked, ["front"])[0]
        reach = float(np.linalg.norm(scene.points[scene.present], axis=1).max())
        away = 1.1 * max(reach, 0.1) / np.sin(np.radians(FIELD_OF_VIEW / 2))
        server.scene.set_up_direction(tuple(front.up))
        camera = server.initial_camera
        camera.position, camera.look_at = tuple(away * front.toward), (0.0, 0.0, 0.0)
        camera.up, camera.fov = tuple(front.up), float(np.radians(FIELD_OF_VIEW))
        camera.near, camera.far = 0.01, 100.0
        server.on_client_connect(self._widen)
        if self._solid:
            self._add_surface()
        else:
            self._add_points()

    def _widen(self, client: Any) -> None:
        """Show all of the shape on a page that is higher than wide: angles of view are vertical."""
        half = np.tan(np.radians(FIELD_OF_VIEW / 2)) / min(client.camera.aspect, 1.0)
        client.camera.fov = float(2 * np.arctan(half))

    def _add_surface(self) -> None:
        """Add the mesh once, and the hidden clouds from which surface.js takes its values."""
        scene, add = self._session.scene, self._server.scene
        shadows = {"cast_shadow": False, "receive_shadow": False}
        add.add_mesh_simple(
            "/shape", scene.points, scene.faces, color=(255, 255, 255), side="double", **shadows
        )
        count = len(scene.points)
        self._values = add.add_point_cloud(
            "/values",
            np.zeros((count, 3)),
            np.zeros((count, 3), dtype=np.uint8),
            precision="float16",
            visible=False,
        )
        rows = style_rows(self._maps["viridis"], (0.0, 1.0), 0.0)
        self._style = add.add_point_cloud(
            "/style", rows, np.zeros_like(rows, dtype=np.uint8), precision="float32", visible=False
        )

    def _add_points(self) -> None:
        """Add the points that are shown, and the edges between them."""
        session, add = self._session, self._server.scene
        shown = session.shown
        self._values = add.add_point_cloud(
            "/shape",
            session.scene.points[shown],
            np.zeros((int(shown.sum()), 3), dtype=np.uint8),
            point_size=session.scene.ball,
            point_shape="circle",
            precision="float32",
        )
        if session.scene.edges is not None:
            edges = session.scene.edges
            ends = session.scene.points[edges[shown[edges].all(axis=1)]]
            add.remove_by_name("/edges")
            if len(ends):
                grey, look = (160, 160, 160), {"thickness": 1.0, "thickness_units": "screen"}
                add.add_line_segments("/edges", ends, grey, **look)

    # -- the panel ---------------------------------------------------------------------------------

    def _add_panel(self, cmap: str, isolines: int) -> None:
        gui = self._server.gui
        self._readout = gui.add_html("")
        self._mode = gui.add_dropdown("A click", tuple(MODES))
        self._lines = gui.add_slider("Isolines", 0, MOST_LINES, 1, isolines)
        self._map = gui.add_dropdown("Colours", tuple(self._maps), initial_value=cmap)
        with gui.add_folder("Method"):
            self._refine = gui.add_checkbox("Refined", self._session.refined)
            power = math.log10(self._session.time_factor)
            self._time = gui.add_slider(
                "log10 of time factor",
                min(-1.0, math.floor(power)),
                max(2.0, math.ceil(power)),
                0.1,
                power,
                hint="the time step is 10 to this power, in squared mean edge lengths",
            )
        self._parts = self._add_parts()
        with gui.add_folder("Save"):
            buttons = gui.add_button_group("As", ("PNG", "PLY", "JSON"))
        self._mode.on_update(self._guarded(self._mode_changed))
        for widget in (self._lines, self._map):
            widget.on_update(self._guarded(self._look_changed))
        self._refine.on_update(self._guarded(self._refine_changed))
        self._time.on_update(self._guarded(self._time_changed))
        for box in self._parts:
            box.on_update(self._guarded(self._parts_changed))
        buttons.on_click(self._guarded(self._save))

    def _add_parts(self) -> list[Any]:
        sizes, gui = self._session.sizes, self._server.gui
        if len(sizes) < 2:
            return []
        names = [f"Part {part}: {size} vertices" for part, size in enumerate(sizes)]
        if len(sizes) > MOST_PARTS:
            names[MOST_PARTS] = f"The rest: {sizes[MOST_PARTS]} vertices"
        with gui.add_folder("Parts"):
            return [gui.add_checkbox(name, True) for name in names]

    # -- events ------------------------------------------------------------------------------------

    def _guarded(self, act: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return a callback that runs alone, and shows typed errors and warnings on the page."""

        def callback(event: Any) -> None:
            with self._lock:
                with collected_warnings(GeodesicWarning) as collected:
                    try:
                        act(event)
                    except GeodesicError as error:
                        self._report(event, error)
                self.warn((text, category.__name__) for text, category in collected)
                self._server.flush()

        return callback

    def _report(self, event: Any, error: GeodesicError) -> None:
        clients = self._server.get_clients().values() if event.client is None else [event.client]
        color = "yellow" if isinstance(error, InvalidSourceError) else "red"  # click elsewhere
        for client in clients:
            _notify(client, type(error).__name__, str(error), color)

    def warn(self, warnings: Iterable[tuple[str, str]]) -> None:
        """List warnings, texts and kinds, in the panel; notify open pages of those that are new."""
        with self._lock:
            before = dict(self.warnings)
            for text, kind in warnings:
                key = f"{kind}: {re.sub(r'[0-9.]+', '#', text)}"
                if key not in self.warnings:
                    for client in self._server.get_clients().values():
                        _notify(client, kind, text, "yellow")
                self.warnings[key] = kind, text
            if self.warnings != before:
                self._list_warnings()

    def _list_warnings(self) -> None:
        if self._list is None:
            with self._server.gui.add_folder("Warnings"):
                self._list = self._server.gui.add_html("")
        self._list.content = warnings_as_html(self.warnings.values())

    def _clicked(self, event: Any) -> None:
        self._guarded(self._click)(event)

    def _click(self, event: Any) -> None:
        place = self._session.pick(event.ray_origin, event.ray_direction)
        if place is None:
            return
        self._session.click(place, add=event.modifier == "shift")
        self._show_all()

    def _mode_changed(self, _: Any) -> None:
        self._session.set_mode(MODES[self._mode.value])
        self._show_readout()

    def _look_changed(self, _: Any) -> None:
        self._show_look()
        self._show_readout()

    def _refine_changed(self, _: Any) -> None:
        self._set_method(self._refine.value, self._session.time_factor)

    def _time_changed(self, _: Any) -> None:
        self._set_method(self._session.refined, float(f"{10.0**self._time.value:.4g}"))

    def _set_method(self, refine: bool, factor: float) -> None:
        session = self._session
        if (refine, factor) == (session.refined, session.time_factor):
            return  # a slider that moved on while the distances were computed
        try:
            session.set_method(refine=refine, time_factor=factor)
        finally:
            self._refine.value = session.refined
        self._show_all()

    def _parts_changed(self, _: Any) -> None:
        hidden = frozenset(part for part, box in enumerate(self._parts) if not box.value)
        if len(hidden) == len(self._parts):  # an empty page has nothing to click
            hidden -= {0}
            self._parts[0].value = True
        self._session.hide(hidden)
        if not self._solid:
            self._add_points()
        self._show_all()

    # -- what is shown -----------------------------------------------------------------------------

    def _show_all(self) -> None:
        session = self._session
        with self._server.atomic():
            if self._solid:
                covered = session.covered if session.hidden else None
                self._values.colors = coded(session.distances, session.limits, covered)
            self._show_look()
            self._show_marks()
            self._show_readout()

    def _show_look(self) -> None:
        """Show colours and isolines; on a mesh the page draws them from the values it has."""
        session, table = self._session, self._maps[self._map.value]
        if self._solid:
            levels = isoline_levels(self._lines.value, session.limits)
            step = float(levels[0]) if len(levels) else 0.0
            self._style.points = style_rows(table, session.limits, step)
        else:
            values = np.where(np.isfinite(session.distances), session.distances, np.nan)
            scene = replace(session.scene, values=values, limits=session.limits)
            style = choose_style(scene, self._map.value, self._lines.value)
            colours = point_colours(scene, style)[session.shown]
            self._values.colors = np.rint(255 * colours).astype(np.uint8)

    def _show_marks(self) -> None:
        session = self._session
        measured = () if session.measured is None else (session.measured[0],)
        line = session.line()
        for name, colour, (points, faces) in (
            ("/sources", MARKER, self._balls(session.sources[:MOST_MARKS])),
            ("/measured", MEASURED, self._balls(measured)),
            ("/path", CURVE, tube(np.zeros((0, 3)) if line is None else line, RADIUS_OF_PATH)),
        ):
            self._show_mesh(name, points, faces, colour)

    def _balls(self, places: tuple[Place, ...]) -> tuple[FloatArray, IntArray]:
        session = self._session
        radius = max(RADIUS_OF_MARKS, 0.0 if self._solid else 1.3 * session.scene.ball)
        return balls(session.positions_of(places), radius)

    def _show_mesh(self, name: str, points: FloatArray, faces: IntArray, colour: Colour) -> None:
        """Show a mesh of one colour, or none; the one that is there is changed in place."""
        handle = self._meshes.get(name)
        if len(faces) == 0:
            if handle is not None:
                handle.visible = False
            return
        if handle is None:
            rgb = tuple(round(255 * part) for part in colour)
            self._meshes[name] = self._server.scene.add_mesh_simple(
                name, points, faces, color=rgb, cast_shadow=False, receive_shadow=False
            )
            return
        handle.vertices, handle.faces = points, faces.astype(np.uint32)
        handle.visible = True

    def _show_readout(self) -> None:
        table = self._maps[self._map.value]
        self._readout.content = legend(self._session, table, unit=self._unit)

    # -- files -------------------------------------------------------------------------------------

    def _save(self, event: Any) -> None:
        session = self._session
        match event.target.value:
            case "PNG":
                name, content = f"{session.name}.png", _picture(event.client)
            case "PLY":
                name, content = session.table()
            case _:
                name, content = f"{session.name}.sources.json", session.as_json().encode()
        event.client.send_file_download(name, content, save_immediately=True)


def _notify(client: Any, title: str, text: str, color: str) -> None:
    client.add_notification(title, text, color=color, auto_close_seconds=SECONDS_OF_NOTICE)


def _picture(client: Any) -> bytes:
    """Return what a client sees as a PNG, on white."""
    image = require("PIL.Image", "view", "Pictures need")
    size = {"height": client.camera.image_height, "width": client.camera.image_width}
    try:
        seen = client.get_render(**size, transport_format="png", timeout=SECONDS_OF_PICTURE)
    except (RuntimeError, TimeoutError) as error:
        raise WriteError(f"the page did not send its picture: {error}") from error
    opaque = seen[..., 3:] / 255.0
    flat = np.rint(seen[..., :3] * opaque + 255.0 * (1.0 - opaque)).astype(np.uint8)
    file = io.BytesIO()
    image.fromarray(flat).save(file, format="PNG")
    return file.getvalue()
