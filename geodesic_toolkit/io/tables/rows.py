"""Tables of numbers as text: their separators, and the meaning of commas.

A comma may separate columns, be a decimal comma, or group thousands. An ambiguous file is refused,
because one reading would give wrong numbers.
"""

import io
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import text_of

__all__ = ["Table", "number_table", "read_table"]

COMMENT = re.compile(r"(#|//|%)[^\n]*")
TRUTH = {"true", "false"}

DECIMAL = re.compile(r"[+-]?(\d+,\d*|,\d+)(e[+-]?\d+)?", re.IGNORECASE)
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
POINT = re.compile(r"\d\.|\.\d")
THOUSANDS = re.compile(r"(?<![\d.])\d{1,3}(,\d{3})+\.\d")
SPACED = re.compile(r",[ \t]|[ \t],")
GLUED = re.compile(r"[^\s,],[^\s,]")
QUOTED = re.compile(r"(?<![^\s,;])(\"[^\"\n]*\"|'[^'\n]*')(?![^\s,;])")
"""Pattern of a field in quotes."""

SPLIT_DECIMAL = re.compile(r"(^|,)([+-]?0\d|-0(,|$))", re.MULTILINE)
"""Pattern of digits that are not a whole number: those of decimals, or a negative zero."""

ADVICE = "write decimal points, or separate the columns by semicolons"


@dataclass(frozen=True)
class Table:
    """Rows of text with decimal points.

    Attributes
    ----------
    names : list of str
        Names of the columns in lower case, without quotes and units; [] if there is no such line.
    lines : list of str
        The rows; at least one.
    separator : str or None
        Separator of the columns: ``","``, ``";"``, or None for blanks.
    """

    names: list[str]
    lines: list[str]
    separator: str | None

    def fields(self, row: int) -> list[str]:
        """Return the fields of a row."""
        return [field.strip() for field in self.lines[row].split(self.separator)]

    def numbers(self, columns: Sequence[int] | None = None) -> FloatArray:
        """Return the numbers of all columns, or of some.

        Raises
        ------
        ReadError
            The rows are not a table of numbers.
        """
        return number_table(self.lines, self.separator, columns)

    def values(self, name: str) -> list[bytes]:
        """Return all fields of the rows, which may have different lengths.

        If columns are named, only the column `name` is read.

        Raises
        ------
        ReadError
            Several columns are named, but not one of them `name`; or rows such as ``5,0`` may be
            two numbers each, or one with a decimal comma.
        """
        rows = [line.replace(self.separator or " ", " ").split() for line in self.lines]
        if len(self.names) > 1:
            if name not in self.names:
                raise ReadError(f"no column is {name!r}; there are {', '.join(self.names)[:80]}")
            column = self.names.index(name)
            return [self.fields(row)[column].encode() for row in range(len(rows))]
        if (
            self.separator == ","
            and len(rows) > 1
            and all(len(row) == 2 and not row[1].strip("0") for row in rows)
        ):
            raise ReadError(f"{self.lines[0]!r} may be one number or two; {ADVICE}")
        return [word.encode() for row in rows for word in row]


def read_table(path: Path) -> Table:
    """Return the table in a text file, without comments, which begin with ``#``, ``//`` or ``%``.

    Raises
    ------
    ReadError
        The file is empty or binary, or its commas are ambiguous.
    """
    whole = text_of(path).decode("latin-1")
    text = COMMENT.sub("", whole)
    lines = [line for line in map(str.strip, text.splitlines()) if line]
    if not lines:
        raise ReadError("there are no numbers in the file")
    names = _names(lines[0])
    body, separator = _separated(_unquoted("\n".join(lines[1:] if names else lines)))
    if not body:
        raise ReadError(f"there are no numbers in the file, only {lines[0][:40]!r}")
    table = Table(names, body.split("\n"), separator)
    if not names:
        names = _commented_names(whole)
        return replace(table, names=names) if len(names) == len(table.fields(0)) else table
    if len(names) != len(table.fields(0)):
        raise ReadError(
            f"the first line, {lines[0][:40]!r}, names {len(names)} columns, but there are "
            f"{len(table.fields(0))}; if their commas are decimal ones, {ADVICE}"
        )
    return table


def _commented_names(text: str) -> list[str]:
    """Return the names of columns in the last comment before the numbers, if it has x, y and z.

    CloudCompare writes ``//X,Y,Z,R,G,B``, NumPy ``# x y z``.
    """
    names: list[str] = []
    for line in map(str.strip, text.splitlines()):
        if line and not COMMENT.match(line):
            break
        found = _names(line.lstrip("#/% \t"))
        names = found if {"x", "y", "z"} <= set(found) else names
    return names


def _unquoted(body: str) -> str:
    """Return lines without quotes around their fields, and without commas in the fields.

    Raises
    ------
    ReadError
        Commas in quoted numbers may not be decimal commas.
    """
    if not ('"' in body or "'" in body):
        return body
    numbers = [field for field in QUOTED.findall(body) if _is_number(field[1:-1])]
    _decimal_points(";".join(field[1:-1].strip() for field in numbers))
    return QUOTED.sub(_bare, body)


def _bare(field: re.Match[str]) -> str:
    inner = field.group()[1:-1].strip()
    if DECIMAL.fullmatch(inner):
        return inner.replace(",", ".")
    return re.sub(r"[,;\s]+", "_", inner)  # in a word, not a number


def _names(line: str) -> list[str]:
    """Return the names of columns in a line; [] if it has a number or a truth value."""
    line = re.sub(r"\s*[,;]$", "", line)  # as in rows
    separator = next((mark for mark in ";\t," if mark in line), None)
    words = [word.strip().strip("\"'").strip().lower() for word in line.split(separator)]
    if not any(word[:1].isalpha() for word in words):
        return []
    if any(_is_number(part) or part in TRUTH for word in words for part in [word, *word.split()]):
        return []
    return [re.sub(r"\s*[\[(].*", "", word) for word in words]


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True


def _separated(body: str) -> tuple[str, str | None]:
    """Return lines with decimal points only, and the separator of their columns."""
    if ";" in body:
        body = re.sub(r"[ \t]*;$", "", body, flags=re.MULTILINE)
        return _decimal_points(body), ";"
    if "," not in body:
        return body, None
    body = re.sub(r"[ \t]*,$", "", body, flags=re.MULTILINE)
    blanks = re.search(r"\S[ \t]+\S", body)
    spaced, glued, point = (mark.search(body) for mark in (SPACED, GLUED, POINT))
    if blanks and not spaced:
        return _decimal_points(body), None
    if blanks and glued and (not point or (found := THOUSANDS.search(body))):
        what = found.group() if point and found else glued.group()
        raise ReadError(f"the comma of {what!r} may separate columns or be in a number; {ADVICE}")
    if not point and (odd := SPLIT_DECIMAL.search(body)):
        line = body[body.rfind("\n", 0, odd.start() + 1) + 1 :].partition("\n")[0]
        raise ReadError(
            f"commas seem to separate columns and to be decimal ones: {line[:60]!r}; {ADVICE}"
        )
    return body, ","


def _decimal_points(body: str) -> str:
    """Replace commas that can only be decimal by points, in a text, and return it.

    Raises
    ------
    ReadError
        A number with a comma is not decimal, others have points, or all might group thousands.
    """
    words = re.findall(r"[^\s;]*,[^\s;]*", body)
    for word in words:
        if not DECIMAL.fullmatch(word):
            raise ReadError(f"{word[:40]!r} is not a number with a decimal comma; {ADVICE}")
    if words and (other := POINT.search(body)):
        raise ReadError(f"{words[0][:40]!r} has a comma and {other.group()!r} a point; {ADVICE}")
    if words and all(GROUPED.fullmatch(word) for word in words):
        raise ReadError(
            f"the comma of {words[0][:40]!r} may be decimal or group thousands; {ADVICE}"
        )
    return body.replace(",", ".")


def number_table(
    lines: Sequence[str], separator: str | None = None, columns: Sequence[int] | None = None
) -> FloatArray:
    """Return numbers in columns, a row a line.

    Raises
    ------
    ReadError
        They are not a table of numbers.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table: FloatArray = np.loadtxt(
                io.StringIO("\n".join(lines)),
                ndmin=2,
                comments=None,
                delimiter=separator,
                usecols=columns,
            )
    except (ValueError, UserWarning) as error:
        reason = str(error).partition(";")[0]
        raise ReadError(f"the file is not a table of numbers: {reason}") from error
    return table
