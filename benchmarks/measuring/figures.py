"""Figures beside their bounds and those of potpourri3d: on the screen, as JSON and as tables."""

import argparse
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from measuring.machine import machine, sentence
from measuring.tables import load, markdown, save

HEADINGS = ["", "figure", "bound", "potpourri3d"]


class Row(NamedTuple):
    """A figure, the bound that it is to keep if it has one, and the figure of potpourri3d."""

    name: str
    figure: float
    bound: float | None = None
    at_least: bool = False
    peer: float | str = ""

    @property
    def is_kept(self) -> bool:
        """Whether the figure keeps its bound."""
        if self.bound is None:
            return True
        return self.figure >= self.bound if self.at_least else self.figure <= self.bound

    def cells(self) -> list[str]:
        """Return the name, the figure, its bound and that of potpourri3d as text."""
        sign = ">=" if self.at_least else "<="
        bound = "" if self.bound is None else f"{sign} {self.bound:g}"
        peer = self.peer if isinstance(self.peer, str) else f"{self.peer:.3g}"
        return [self.name, f"{self.figure:.3g}", bound, peer]

    def __str__(self) -> str:
        name, figure, bound, peer = self.cells()
        verdict = "" if self.is_kept else "  MISSED"
        return f"{name:66s} {figure:>10s} {bound:>10s} {peer:>10s}{verdict}"


Parts = Mapping[str, Callable[[], Iterator[Row]]]
"""The rows of a script by the parts that can be asked for."""


def parser(doc: str) -> argparse.ArgumentParser:
    """Return a parser with the options that all scripts of figures have."""
    found = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawTextHelpFormatter)
    found.add_argument("--parts", help="some of the parts, with commas between them")
    found.add_argument(
        "--json",
        type=Path,
        metavar="FILE",
        help="write the rows there, and a table beside it; other parts in the file stay",
    )
    return found


def report(parts: Parts, options: argparse.Namespace) -> None:
    """Print the rows of the parts that are asked for, and write them if a file is given."""
    asked = options.parts.split(",") if options.parts else list(parts)
    known = load(options.json).get("parts", {}) if options.json else {}
    for part in asked:
        rows = []
        for row in parts[part]():
            print(row, flush=True)
            rows.append(row)
        known[part] = [row._asdict() for row in rows]
        if options.json:
            found = {"parts": {p: known[p] for p in parts if p in known}, "machine": machine()}
            save(options.json, found, {options.json.stem: table(found)})


def table(found: dict) -> str:
    """Return the rows of a file as Markdown; figures that miss their bound are bold."""
    rows = [Row(**row) for part in found["parts"].values() for row in part]
    cells = [row.cells() for row in rows]
    for row, own in zip(rows, cells, strict=True):
        if not row.is_kept:
            own[1] = f"**{own[1]}**"
    return markdown(HEADINGS, cells, sentence(found["machine"]).strip())
