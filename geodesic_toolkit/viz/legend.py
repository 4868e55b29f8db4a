"""The legend of an HTML page: title, colour bar, label, and the value under the pointer."""

import html

from geodesic_toolkit.viz.colours import UNREACHED, Style, isoline_levels, packed
from geodesic_toolkit.viz.scene import Scene

__all__ = ["legend"]

NO_WEBGL = """\
<div class="gt" id="gt-no-webgl">This browser does not offer WebGL 2, which draws the shape. Turn on
hardware acceleration in its settings, or open the page in another browser.</div>
<script>
if (document.createElement('canvas').getContext('webgl2')) {
    document.getElementById('gt-no-webgl').remove();
}
</script>"""
"""Shown until the browser has proved that it can draw: k3d does not report if it cannot."""

STOPS = 64
"""Number of colours of the bar's gradient."""

MOST_MARKS = 60
"""Largest number of isolines marked on the bar; more would blacken it."""


def legend(scene: Scene, style: Style, *, label: str, unit: str, title: str | None) -> str:
    """Return the elements of the legend as HTML."""
    parts = [NO_WEBGL]
    if title:
        parts.append(_box("title", html.escape(title)))
    if scene.reached.any():
        parts.append(_bar(scene, style))
        parts.append(_box("label", html.escape(f"{label} [{unit}]" if unit else label)))
    if not scene.reached[scene.present].all():
        parts.append(_box("none", f'<b style="background: {_hex(UNREACHED)}"></b>not reached'))
    parts.append(_box("value", "", f'data-unit="{html.escape(unit)}"'))
    return "\n".join(parts)


def _bar(scene: Scene, style: Style) -> str:
    low, high = scene.limits

    def height(value: float) -> float:
        return 100 * (value - low) / (high - low)

    every = max(1, len(style.table) // STOPS)
    gradient = ", ".join(_hex(colour) for colour in style.table[::every])
    levels = style.levels if len(style.levels) <= MOST_MARKS else ()
    marks = [f'<i style="bottom: {height(level):.3f}%"></i>' for level in levels]
    numbers = [
        f'<span style="top: {100 - height(value):.3f}%">{value:.6g}</span>'
        for value in ([low] if low == 0 else []) + isoline_levels(5, scene.limits).tolist()
    ]
    style_text = f'style="background: linear-gradient(to top, {gradient})"'
    return _box("bar", "".join(marks + numbers), style_text)


def _box(name: str, content: str, attributes: str = "") -> str:
    return f'<div class="gt" id="gt-{name}" {attributes}>{content}</div>'


def _hex(colour: object) -> str:
    return f"#{packed(colour):06x}"
