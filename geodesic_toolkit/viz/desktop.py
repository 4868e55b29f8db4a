"""The desktop viewer: polyscope, in a separate window."""

from typing import Any

from numpy.typing import ArrayLike

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import MissingDependencyError
from geodesic_toolkit.viz.camera import choose_views
from geodesic_toolkit.viz.colours import MARKER, UNREACHED
from geodesic_toolkit.viz.scene import Scene, compacted, make_scene

__all__ = ["polyscope"]

NAMES = ("shape", "not reached", "sources")


def polyscope(
    domain: Domain,
    distance: ArrayLike,
    *,
    sources: Any = None,
    label: str = "distance",
    positions: ArrayLike | None = None,
    block: bool = True,
) -> Any:
    """Show a distance on its shape in a polyscope window, with isolines; needs a display.

    Parameters
    ----------
    domain, distance, sources, label, positions
        As for :func:`plot`.
    block : bool
        True opens the window and returns when it is closed; False only sets up the scene, which can
        be extended before calling ``polyscope.show()``.

    Returns
    -------
    polyscope.SurfaceMesh, polyscope.PointCloud or polyscope.CurveNetwork
        The reached part; the rest is another structure, "not reached", in grey. None if no vertex
        is reached.

    Raises
    ------
    UnsupportedDomainError, InvalidOptionError, InvalidSourceError
        As for :func:`plot`.
    MissingDependencyError
        polyscope is not installed (it comes with ``pip install "geodesic-toolkit[gui]"``), or
        there is no display.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> gt.viz.polyscope(sphere, gt.geodesic_distance(sphere, 0))  # doctest: +SKIP
    """
    scene = make_scene(domain, distance, sources=sources, positions=positions)
    viewer = require("polyscope", "gui", "Desktop windows need")
    try:
        viewer.init()
    except RuntimeError as error:  # polyscope raises nothing more specific
        raise MissingDependencyError(
            f"polyscope cannot open a window without a display: {error}; "
            "gt.viz.plot and gt.viz.save_html do not need one"
        ) from error
    _forget(viewer)
    viewer.set_ground_plane_mode("none")
    shape, where = _register(viewer, scene, NAMES[0], reached=True)
    if shape is not None:
        shape.add_scalar_quantity(
            label,
            scene.values[where],
            cmap="viridis",
            vminmax=scene.limits,
            isolines_enabled=True,
            enabled=True,
        )
    rest, _ = _register(viewer, scene, NAMES[1], reached=False)
    if rest is not None:
        rest.set_color(UNREACHED)
    if len(scene.sources):
        marks = viewer.register_point_cloud(NAMES[2], scene.sources * scene.radius + scene.centre)
        marks.set_color(MARKER)
        marks.set_radius(0.012)
    front = choose_views(scene, ["front"])[0]
    viewer.look_at_dir(scene.centre + 2.4 * scene.radius * front.toward, scene.centre, front.up)
    if block:
        viewer.show()
    return shape


def _forget(viewer: Any) -> None:
    """Remove the structures of an earlier call, but not those that the user registered."""
    for name in NAMES:
        viewer.remove_surface_mesh(name, error_if_absent=False)
        viewer.remove_point_cloud(name, error_if_absent=False)
        viewer.remove_curve_network(name, error_if_absent=False)


def _register(viewer: Any, scene: Scene, name: str, *, reached: bool) -> tuple[Any, Any]:
    """Register the reached part, or the rest; return it with its vertices."""
    points = scene.points * scene.radius + scene.centre
    rows = scene.faces if scene.faces is not None else scene.edges
    if rows is None:
        chosen = scene.present & (scene.reached == reached)
        shape = viewer.register_point_cloud(name, points[chosen]) if chosen.any() else None
        return shape, chosen
    rows = rows[scene.reached[rows].all(axis=1) == reached]
    if len(rows) == 0:
        return None, rows
    used, own = compacted(rows)
    if scene.faces is not None:
        return viewer.register_surface_mesh(name, points[used], own, smooth_shade=True), used
    return viewer.register_curve_network(name, points[used], own), used
