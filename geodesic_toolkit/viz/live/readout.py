"""The head of the panel: colour bar, lengths, and what the next click does."""

import html
import math
from collections.abc import Iterable
from itertools import pairwise

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.viz.colours import CURVE, UNREACHED, isoline_levels, packed
from geodesic_toolkit.viz.live.session import Mode, Session

__all__ = ["MEASURED", "in_digits", "legend", "warnings_as_html"]

MEASURED = (0.1, 0.1, 0.9)
"""Blue of the place that was measured."""

N_NUMBERS = 4
CHARACTERS_OF_BAR = 38
"""Number of digits that have a place under the colour bar, in the panel's font."""

HINTS = {
    Mode.SOURCE: "Click the shape to move the source; shift-click adds one.",
    Mode.PATH: "Click where the path begins.",
    Mode.MEASURE: "Click a place to read its distance.",
}


def legend(session: Session, table: FloatArray, *, unit: str) -> str:
    """Return the colour bar and the numbers of a session as HTML."""
    low, high = session.limits
    gradient = ", ".join(f"#{packed(colour):06x}" for colour in table)
    ticks = "".join(
        f'<span style="position:absolute;left:{100 * (value - low) / (high - low):.2f}%;'
        f'transform:translateX(-50%)">{in_digits(value, 4)}</span>'
        for value in _numbers(session.limits)
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


def in_digits(value: float, digits: int) -> str:
    """Return a number with so many significant digits; whole ones up to ten million in full.

    Examples
    --------
    >>> in_digits(0.123456, 4), in_digits(1376512.4, 5), in_digits(2e-7, 4)
    ('0.1235', '1376512', '2e-07')
    """
    return f"{value:.0f}" if 10**digits <= abs(value) < 1e7 else f"{value:.{digits}g}"


def _numbers(limits: tuple[float, float]) -> list[float]:
    """Return the numbers under the colour bar: as many round ones as have a place there."""
    low, high = limits
    for count in range(N_NUMBERS, 0, -1):
        numbers = [low, *isoline_levels(count, limits).tolist()]
        longest = max(len(in_digits(value, 4)) for value in numbers)
        steps = [after - before for before, after in pairwise(numbers)]
        if min(steps, default=0.0) / (high - low) * CHARACTERS_OF_BAR >= longest + 1:
            return numbers
    return [low]


def warnings_as_html(warnings: Iterable[tuple[str, str]]) -> str:
    """Return warnings, each of a kind and a text, as HTML."""
    rows = "".join(
        f'<p style="margin:0 0 0.6em 0"><b>{html.escape(kind)}</b><br>{html.escape(text)}</p>'
        for kind, text in warnings
    )
    return f'<div style="padding:0.2em 1.4em;font-size:0.85em;line-height:1.4">{rows}</div>'


def _rows(session: Session, unit: str) -> list[tuple[str, str]]:
    """Return the numbers of a session: their names, and their values as text."""
    end = f" {html.escape(unit)}" if unit else ""
    rows = [
        ("Sources", f"{len(session.sources)}"),
        ("Largest distance", in_digits(session.largest, 5) + end),
    ]
    if session.path is not None:
        rows.append((f"{_spot(CURVE)} Length of the path", in_digits(session.path.length, 6) + end))
    if session.measured is not None:
        value = session.measured[1]
        text = in_digits(value, 6) + end if math.isfinite(value) else "not reached"
        rows.append((f"{_spot(MEASURED)} Distance there", text))
    for name, count in (("Masked", session.masked.sum()), ("Not reached", session.n_unreached)):
        if count:
            rows.append((f"{_spot(UNREACHED)} {name}", f"{count} vertices"))
    return rows


def _spot(colour: tuple[float, float, float]) -> str:
    return f'<span style="color:#{packed(colour):06x}">●</span>'
