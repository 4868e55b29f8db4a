"""Pictures: PNG, a rotatable HTML file, notebook widgets, a page to click, a desktop window.

Nothing is imported until it is used: the packages for it are installed by
``pip install "geodesic-toolkit[viz]"``, ``[view]`` for :func:`view`, ``[gui]`` for
:func:`polyscope`.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geodesic_toolkit.viz.checkers import Checkers
    from geodesic_toolkit.viz.desktop import polyscope
    from geodesic_toolkit.viz.html import save_html, show
    from geodesic_toolkit.viz.live.view import View, view
    from geodesic_toolkit.viz.parts import OF_PARTS, by_part
    from geodesic_toolkit.viz.picture import plot
    from geodesic_toolkit.viz.sides import two_sided

_HOMES = {
    "Checkers": "checkers",
    "View": "live.view",
    "OF_PARTS": "parts",
    "by_part": "parts",
    "plot": "picture",
    "polyscope": "desktop",
    "save_html": "html",
    "show": "html",
    "two_sided": "sides",
    "view": "live.view",
}

__all__ = [
    "OF_PARTS",
    "Checkers",
    "View",
    "by_part",
    "plot",
    "polyscope",
    "save_html",
    "show",
    "two_sided",
    "view",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
