"""The head of the panel: colour bar, lengths, and what the next click does."""

import html
import math

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.viz.colours import CURVE, UNREACHED, isoline_levels, packed
from geodesic_toolkit.viz.live.session import Mode, Session

__all__ = ["MEASURED", "legend"]

MEASURED = (0.1, 0.1, 0.9)
"""Blue of the place that was measured."""

N_NUMBERS = 4

HINTS = {
    Mode.SOURCE: "Click the shape to move the source; shift-click adds one.",
    Mode.PATH: "Click where the path begins.",
    Mode.MEASURE: "Click a place to read its distance.",
}


def legend(session: Session, table: FloatArray, *, unit: str) -> str:
    """Return the colour bar and the numbers of a session as HTML."""
    low, high = session.limits
    gradient = ", ".join(f"#{packed(colour):06x}" for colour in table)
    numbers = [low, *isoline_levels(N_NUMBERS, session.limits).tolist()]
    ticks = "".join(
        f'<span style="position:absolute;left:{100 * (value - low) / (high - low):.2f}%;'
        f'transform:translateX(-50%)">{value:.4g}</span>'
        for value in numbers
    )
    rows = "".join(
        f"<tr><td>{name}</td><td><b>{value}</b></td></tr>" for name, value in _rows(session, unit)
    )
    hint = "Click where the path ends." if session.waits_for_target else HINTS[session.mode]
    return (
        '<div style="padding:0.2em 1.4em 0.4em 1.4em;font-size:0.85em;line-height:1.5">'
        '<div style="height:1em;border-radius:2px;'
        f'background:linear-gradient(to right,{gradient})"></div>'
        f'<div style="position:relative;height:1.7em">{ticks}</div>'
        f'<table style="width:100%">{rows}</table>'
        f'<div style="opacity:0.65;padding-top:0.3em">{hint}</div></div>'
    )


def _rows(session: Session, unit: str) -> list[tuple[str, str]]:
    """Return the numbers of a session: their names, and their values as text."""
    end = f" {html.escape(unit)}" if unit else ""
    rows = [
        ("Sources", f"{len(session.sources)}"),
        ("Largest distance", f"{session.largest:.5g}{end}"),
    ]
    if session.path is not None:
        rows.append((f"{_spot(CURVE)} Length of the path", f"{session.path.length:.6g}{end}"))
    if session.measured is not None:
        value = session.measured[1]
        text = f"{value:.6g}{end}" if math.isfinite(value) else "not reached"
        rows.append((f"{_spot(MEASURED)} Distance there", text))
    if session.n_unreached:
        rows.append((f"{_spot(UNREACHED)} Not reached", f"{session.n_unreached} vertices"))
    return rows


def _spot(colour: tuple[float, float, float]) -> str:
    return f'<span style="color:#{packed(colour):06x}">●</span>'
