"""Views of a scene, drawn by VTK into arrays, through pyvista."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.viz.camera import View
from geodesic_toolkit.viz.colours import CURVE, INK, MARKER, UNREACHED, Style, point_colours
from geodesic_toolkit.viz.contours import contour_lines, surface
from geodesic_toolkit.viz.opengl import check_opengl, quiet
from geodesic_toolkit.viz.page import Page
from geodesic_toolkit.viz.scene import Scene

__all__ = ["render"]

SUPERSAMPLING = 2
LARGEST_WINDOW = 8192
"""Largest window that OpenGL draws on any machine."""

SHADING: dict[str, Any] = {
    "ambient": 0.46,  # colours must match the bar, also in the shade
    "diffuse": 0.66,
    "specular": 0.1,
    "specular_power": 25,
    "smooth_shading": True,
    "split_sharp_edges": True,
    "feature_angle": 70.0,
}


def render(scene: Scene, style: Style, page: Page) -> list[NDArray[np.uint8]]:
    """Return one picture per view, of the size of the page's cells.

    Raises
    ------
    MissingDependencyError
        pyvista, or the system's OpenGL, is missing.
    """
    pyvista = require("pyvista", "viz", "Pictures need")
    factor = SUPERSAMPLING if SUPERSAMPLING * max(page.cell) <= LARGEST_WINDOW else 1
    size = [factor * side for side in page.cell]
    with quiet():
        check_opengl()
        plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
        try:
            plotter.set_background("white")
            _add_lights(plotter, pyvista)
            stage = _Stage(plotter, pyvista, factor * page.scale, factor * page.em)
            stage.add(scene, style)
            pictures = []
            for view, frame in zip(page.views, page.frames, strict=True):
                stage.look(view, frame, half_height=size[1] / (2 * stage.scale))
                pictures.append(_averaged(plotter.screenshot(return_img=True), factor))
        finally:
            plotter.close()
    return pictures


class _Stage:
    """The objects before the camera, and the shift of each towards it.

    The projection is parallel: views share one scale, lines have the same width everywhere, and an
    object shifted towards the camera does not move on the picture.
    """

    def __init__(self, plotter: Any, pyvista: Any, scale: float, em: float) -> None:
        self.plotter, self.pyvista = plotter, pyvista
        self.scale, self.em = scale, em
        self.raised: list[tuple[Any, float]] = []

    def add(self, scene: Scene, style: Style) -> None:
        """Add the shape and the marks of its sources."""
        if scene.faces is not None:
            self._add_surface(scene, style)
            self._add_isolines(scene, style)
        else:
            self._add_points(scene, style)
        self._add_curves(scene)
        self._add_arrows(scene)
        if len(scene.sources):
            buried = 0.0 if scene.faces is not None else scene.ball  # among the surrounding points
            radius = max(0.55 * self.em / self.scale, 1.1 * buried)
            ball = self.pyvista.Sphere(radius=radius, theta_resolution=32, phi_resolution=32)
            marks = self.pyvista.PolyData(scene.sources)
            marks = marks.glyph(geom=ball, scale=False, orient=False)
            look = {"smooth_shading": True, "ambient": 0.35, "specular": 0.4}
            self.raised.append((self.plotter.add_mesh(marks, color=MARKER, **look), 4 * buried))

    def look(self, view: View, frame: FloatArray, *, half_height: float) -> None:
        """Turn the camera to a view and draw."""
        camera = self.plotter.camera
        camera.focal_point = view.right * frame[0] + view.up * frame[1]
        camera.position = camera.focal_point + 4.0 * view.toward
        camera.up = view.up
        camera.parallel_projection = True
        camera.parallel_scale = half_height
        camera.clipping_range = (1.0, 7.0)
        for actor, height in self.raised:
            actor.position = height * view.toward
        self.plotter.render()

    def _add_surface(self, scene: Scene, style: Style) -> None:
        assert scene.faces is not None
        colors = require("matplotlib.colors", "viz", "Pictures need")
        reached = scene.face_reached
        plain = reached & ~self._add_checkers(scene, style)
        if plain.any():
            mesh, used = surface(scene.points, scene.faces[plain])
            self.plotter.add_mesh(
                mesh,
                scalars=scene.values[used],
                cmap=colors.ListedColormap(style.table),
                clim=scene.limits,
                interpolate_before_map=True,
                show_scalar_bar=False,
                **SHADING,
            )
        if not reached.all():
            mesh, _ = surface(scene.points, scene.faces[~reached])
            self.plotter.add_mesh(mesh, color=UNREACHED, **SHADING)

    def _add_checkers(self, scene: Scene, style: Style) -> BoolArray:
        """Add the faces with a pattern, if there are any, and return a mask of them."""
        assert scene.faces is not None
        if scene.checkers is None:
            return np.zeros(len(scene.faces), dtype=np.bool_)
        patterned = scene.face_reached & scene.checkers.patterned(
            scene.radius * scene.points, scene.faces
        )
        if patterned.any():
            mesh, used = surface(scene.points, scene.faces[patterned])
            mesh.active_texture_coordinates = scene.checkers.texture_coordinates()[used]
            texture = self.pyvista.Texture(scene.checkers.texture(style.table, scene.limits))
            texture.interpolate = True
            self.plotter.add_mesh(mesh, texture=texture, **SHADING)
        return patterned

    def _add_isolines(self, scene: Scene, style: Style) -> None:
        points, segments = contour_lines(scene, style.levels)
        if len(segments) == 0:
            return
        lines = self.pyvista.PolyData(points, lines=np.insert(segments, 0, 2, axis=1).ravel())
        # Tubes: VTK's own lines break up if a segment is shorter than their width.
        tubes = lines.clean().strip().tube(radius=0.055 * self.em / self.scale, n_sides=6)
        self.raised.append((self.plotter.add_mesh(tubes, color=INK, lighting=False), 0.004))

    def _add_curves(self, scene: Scene) -> None:
        buried = 0.0 if scene.faces is not None else scene.ball  # among the points about it
        for line in scene.curves:
            # A point on the one before has no direction, which a tube must have.
            moved = np.append(True, (np.diff(line, axis=0) != 0).any(axis=1))
            if moved.sum() < 2:
                continue
            tube = self.pyvista.lines_from_points(line[moved]).tube(
                radius=0.14 * self.em / self.scale, n_sides=8
            )
            actor = self.plotter.add_mesh(tube, color=CURVE, lighting=False)
            self.raised.append((actor, 0.008 + 4 * buried))

    def _add_arrows(self, scene: Scene) -> None:
        places, vectors = scene.arrows
        if not len(places):
            return
        marks = self.pyvista.PolyData(places)
        marks["vectors"] = vectors
        arrow = self.pyvista.Arrow(tip_length=0.38, tip_radius=0.13, shaft_radius=0.045)
        glyphs = marks.glyph(orient="vectors", scale="vectors", factor=1.0, geom=arrow)
        actor = self.plotter.add_mesh(glyphs, color=CURVE, ambient=0.6, smooth_shading=True)
        self.raised.append((actor, 0.012 + 4 * (0.0 if scene.faces is not None else scene.ball)))

    def _add_points(self, scene: Scene, style: Style) -> None:
        """Add points as balls that form a closed surface; dark outlines show their depth."""
        colours = np.round(255 * point_colours(scene, style)).astype(np.uint8)
        self.plotter.add_mesh(
            self.pyvista.PolyData(scene.points[scene.present]),
            scalars=colours[scene.present],
            rgb=True,
            style="points",
            render_points_as_spheres=True,
            point_size=2 * scene.ball * self.scale,
            ambient=0.55,
            diffuse=0.5,
        )
        if scene.edges is not None and len(scene.edges):
            lines = np.insert(scene.edges, 0, 2, axis=1).ravel()
            network = self.pyvista.PolyData(scene.points, lines=lines)
            self.plotter.add_mesh(network, color="#999999", line_width=2.0, lighting=False)
        self.plotter.enable_eye_dome_lighting()


def _add_lights(plotter: Any, pyvista: Any) -> None:
    """Add lights that move with the camera: the key from the upper left, a fill from the right."""
    for position, intensity in (((-0.8, 1.2, 2.4), 0.74), ((1.6, -0.2, 1.6), 0.3)):
        light = pyvista.Light(position=position, intensity=intensity, light_type="camera light")
        plotter.add_light(light)


def _averaged(image: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """Return the picture reduced by `factor`, with smooth edges and lines."""
    height, width = image.shape[0] // factor, image.shape[1] // factor
    blocks = image[:, :, :3].reshape(height, factor, width, factor, 3)
    averaged: NDArray[np.uint8] = np.round(blocks.mean(axis=(1, 3))).astype(np.uint8)
    return averaged
