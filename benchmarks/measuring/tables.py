"""Markdown, and where the documentation keeps it."""

import json
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[2] / "docs"
TABLES = DOCS / "_tables"
STATIC = DOCS / "_static"


def markdown(headings: list[str], rows: list[list[str]], note: str, names: int = 1) -> str:
    """Return a table whose first columns are `names`, the others figures, and a note beneath it."""
    rule = ["---"] * names + ["---:"] * (len(headings) - names)
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in [headings, rule, *rows])
    return f"{table}\n\n{note}\n"


def seconds(value: float) -> str:
    """Return a time with three digits and its unit."""
    return f"{value:.3g} s" if value >= 0.9995 else f"{1e3 * value:.3g} ms"


def gigabytes(value: float) -> str:
    """Return a number of bytes with three digits and its unit."""
    return f"{value / 1e9:.3g} GB" if value >= 0.9995e9 else f"{value / 1e6:.3g} MB"


def load(path: Path) -> dict[str, Any]:
    """Return what earlier runs have found."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def save(path: Path, found: dict[str, Any], tables: dict[str, str]) -> None:
    """Write the figures, and each table beside them."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    for name, text in tables.items():
        (path.parent / f"{name}.md").write_text(text, encoding="utf-8")
