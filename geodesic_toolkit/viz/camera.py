"""The camera: suitable viewing directions for a shape of unknown orientation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.viz.scene import Scene

__all__ = ["View", "choose_views", "fit"]

AXES = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
    "-x": (-1, 0, 0),
    "-y": (0, -1, 0),
    "-z": (0, 0, -1),
}
TURN, RAISE = np.radians(24.0), np.radians(16.0)
FLAT = 0.02
MOST_VIEWS = 12


@dataclass(frozen=True)
class View:
    """A viewing direction, with the directions up and right on the picture: unit vectors."""

    name: str
    toward: FloatArray
    up: FloatArray

    @property
    def right(self) -> FloatArray:
        """The direction to the right on the picture."""
        return np.cross(self.up, self.toward)


def choose_views(scene: Scene, views: Sequence[str | ArrayLike]) -> list[View]:
    """Return the requested views.

    "front" looks along the thinnest extent of the shape, slightly from the side and from above,
    where the most sources are visible; "back" is half a turn about the vertical from there.
    """
    if isinstance(views, str) or len(views) == 0:
        raise InvalidOptionError(f"views is a sequence such as ('front', 'back'), not {views!r}")
    if len(views) > MOST_VIEWS:
        raise InvalidOptionError(f"a picture has at most {MOST_VIEWS} views, not {len(views)}")
    front: View | None = None
    chosen = []
    for view in views:
        if isinstance(view, str) and view in ("front", "back"):
            front = front or _front(scene)
            chosen.append(front if view == "front" else _half_turn(front))
        elif isinstance(view, str) and view in AXES:
            chosen.append(_looking_from(view, np.array(AXES[view], dtype=np.float64)))
        else:
            chosen.append(_looking_from("", _direction(view)))
    return chosen


def fit(scene: Scene, views: Sequence[View]) -> FloatArray:
    """Return the centre and half extents of the shape on the picture of each view, (V, 4)."""
    shown = scene.points[scene.present]
    ball = scene.ball if scene.faces is None else 0.0
    frames = []
    for view in views:
        flat = shown @ np.column_stack([view.right, view.up])
        low, high = flat.min(axis=0), flat.max(axis=0)
        frames.append([*((low + high) / 2), *((high - low) / 2 + ball)])
    return np.array(frames)


def _direction(view: object) -> FloatArray:
    try:
        vector = np.asarray(view, dtype=np.float64)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        raise InvalidOptionError(
            f"a view is 'front', 'back', {', '.join(map(repr, AXES))} or a direction to look from, "
            f"not {view!r}"
        )
    return vector / np.linalg.norm(vector)


def _looking_from(name: str, toward: FloatArray) -> View:
    """Return the view from a direction, with y up (z if the view is along y)."""
    vertical = np.array([0.0, 0.0, 1.0] if abs(toward[1]) > 0.9 else [0.0, 1.0, 0.0])
    up = vertical - toward * (vertical @ toward)
    return View(name, toward, up / np.linalg.norm(up))


def _half_turn(front: View) -> View:
    """Return the view from the other side, after half a turn about the vertical."""
    vertical = np.array([0.0, 0.0, 1.0] if abs(front.up[2]) > abs(front.up[1]) else [0.0, 1.0, 0.0])

    def turned(vector: FloatArray) -> FloatArray:
        turn: FloatArray = 2 * vertical * (vertical @ vector) - vector
        return turn

    return View("back", turned(front.toward), turned(front.up))


def _front(scene: Scene) -> View:
    axis, flat = _thin_axis(scene.points[scene.present])
    plain = _looking_from("front", axis)
    turns = [0.0] if flat else [TURN, -TURN]
    raises = [0.0] if flat else [RAISE]
    candidates = [
        _tilted(_looking_from("front", side * plain.toward), turn, lift)
        for side in (1.0, -1.0)
        for turn in turns
        for lift in raises
    ]
    # The first of the best: sums of what each source contributes, so ties keep the order above.
    return max(candidates, key=lambda view: _sees(scene, view))


def _tilted(view: View, turn: float, lift: float) -> View:
    """Return the view moved sideways by `turn` and upwards by `lift` radians."""
    toward = (
        np.cos(lift) * (np.cos(turn) * view.toward + np.sin(turn) * view.right)
        + np.sin(lift) * view.up
    )
    up = view.up - toward * (view.up @ toward)
    return View(view.name, toward, up / np.linalg.norm(up))


def _thin_axis(points: FloatArray) -> tuple[FloatArray, bool]:
    """Return the direction in which a shape is thinnest, and whether it is flat.

    It is a coordinate axis, as most shapes are aligned with them (z before x before y if they are
    alike), or the least principal axis if the shape is much thinner along it: a slanting sheet.
    """
    spread = points - points.mean(axis=0)
    deviation = spread.std(axis=0)
    order = [2, 0, 1]
    best = next(axis for axis in order if deviation[axis] <= 1.1 * deviation.min())
    _, sizes, axes = np.linalg.svd(spread.T @ spread / len(spread), hermitian=True)
    least = float(np.sqrt(max(sizes[2], 0.0)))
    if least < 0.5 * deviation[best]:
        return axes[2] * np.sign(axes[2][np.abs(axes[2]).argmax()]), least < FLAT
    return np.eye(3)[best], bool(deviation[best] < FLAT)


def _sees(scene: Scene, view: View) -> float:
    """Return the number of sources that are not hidden behind the shape in a view."""
    if len(scene.sources) == 0:
        return 0.0
    frame = np.column_stack([view.right, view.up, view.toward])
    positions = scene.points @ frame
    seen = 0.0
    for source in scene.sources[:20] @ frame:  # twenty are enough to choose a side
        if scene.faces is not None:
            hidden = _behind_faces(source, positions, scene)
        else:
            offset = positions[scene.present] - source
            near = np.hypot(offset[:, 0], offset[:, 1]) < 0.03
            hidden = bool((near & (offset[:, 2] > 0.1)).any())
        seen += 0.0 if hidden else 1.0
    return seen


def _behind_faces(source: FloatArray, positions: FloatArray, scene: Scene) -> bool:
    """Return whether a face lies between the camera and the source."""
    assert scene.faces is not None
    a, b, c = (positions[scene.faces[:, corner]] - source for corner in range(3))
    areas = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)])  # barycentric, up to a factor
    total = areas.sum(axis=0)
    over = (np.abs(total) > 1e-15) & ((areas >= 0).all(axis=0) | (areas <= 0).all(axis=0))
    depths = np.stack([a[over, 2], b[over, 2], c[over, 2]])
    depth = (areas[:, over] * depths).sum(axis=0) / total[over]
    return bool((depth > 0.02).any())  # closer faces are those at the source itself


def _cross(p: FloatArray, q: FloatArray) -> FloatArray:
    product: FloatArray = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    return product
