"""A document of headings, text, tables and figures, as Markdown and as one HTML file."""

import base64
import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

__all__ = ["Block", "Bullets", "Figure", "Heading", "Paragraph", "Table", "as_html", "as_markdown"]


@dataclass(frozen=True)
class Heading:
    """A heading of level 1, 2 or 3."""

    level: int
    text: str


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; `**bold**` and `` `code` `` are all the markup there is."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """A list of points."""

    points: Sequence[str]


@dataclass(frozen=True)
class Table:
    """A table; the first column is text, the others are numbers."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Figure:
    """A PNG file beside the document, and what it shows."""

    file: str
    caption: str


Block: TypeAlias = Heading | Paragraph | Bullets | Table | Figure


def as_markdown(blocks: Sequence[Block]) -> str:
    """Return the document as Markdown; figures are links.

    Examples
    --------
    >>> print(as_markdown([Heading(2, "Errors"), Table(["mesh", "%"], [["bunny", "1.8"]])]))
    ## Errors
    <BLANKLINE>
    | mesh | % |
    |---|---:|
    | bunny | 1.8 |
    <BLANKLINE>
    """
    return "\n\n".join(_markdown(block) for block in blocks) + "\n"


def as_html(title: str, blocks: Sequence[Block], images: Mapping[str, bytes]) -> str:
    """Return the document as one HTML file with the images inside it.

    Parameters
    ----------
    title : str
    blocks : sequence of Block
    images : mapping of str to bytes
        JPEG pictures by the names of the figures' files.
    """
    body = "\n".join(_html(block, images) for block in blocks)
    return PAGE.format(title=html.escape(title), body=body)


def _markdown(block: Block) -> str:
    match block:
        case Heading():
            return f"{'#' * block.level} {block.text}"
        case Paragraph():
            return block.text
        case Bullets():
            return "\n".join(f"- {point}" for point in block.points)
        case Figure():
            return f"![{block.caption}]({block.file})\n\n*{block.caption}*"
        case Table():
            rule = "|---|" + "---:|" * (len(block.header) - 1)
            rows = [_row(block.header), rule, *map(_row, block.rows)]
            return "\n".join(rows)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _html(block: Block, images: Mapping[str, bytes]) -> str:
    match block:
        case Heading():
            return f"<h{block.level}>{_inline(block.text)}</h{block.level}>"
        case Paragraph():
            return f"<p>{_inline(block.text)}</p>"
        case Bullets():
            points = "".join(f"<li>{_inline(point)}</li>" for point in block.points)
            return f"<ul>{points}</ul>"
        case Figure():
            data = base64.b64encode(images[block.file]).decode("ascii")
            picture = (
                f'<img src="data:image/jpeg;base64,{data}" alt="{html.escape(block.caption)}">'
            )
            caption = f"<figcaption>{_inline(block.caption)}</figcaption>"
            return f"<figure>{picture}{caption}</figure>"
        case Table():
            head = "".join(f"<th>{_inline(cell)}</th>" for cell in block.header)
            rows = "".join(
                "<tr>" + "".join(f"<td>{_inline(cell)}</td>" for cell in row) + "</tr>"
                for row in block.rows
            )
            table = f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody>"
            return f'<div class="wide"><table>{table}</table></div>'


def _inline(text: str) -> str:
    escaped = html.escape(text)
    escaped = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", escaped)
    return re.sub(r"`(.+?)`", r"<code>\1</code>", escaped)


PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 17px/1.55 Georgia, "Times New Roman", serif; color: #1a1a1f; background: #fff;
  max-width: 46rem; margin: 3rem auto; padding: 0 1.2rem; }}
h1, h2, h3 {{ font-family: "Helvetica Neue", Arial, sans-serif; line-height: 1.2; }}
h1 {{ font-size: 1.9rem; }} h2 {{ font-size: 1.35rem; margin-top: 2.8rem; }}
figure {{ margin: 1.8rem 0; }}
figure img {{ width: 100%; border: 1px solid #e4e4e8; }}
@media (min-width: 75rem) {{ figure {{ margin: 1.8rem -11rem; }}
  figcaption {{ padding: 0 11rem; }} }}
figcaption {{ font-size: .88rem; color: #55555c; margin-top: .4rem; }}
.wide {{ overflow-x: auto; margin: 1.4rem 0; }}
table {{ border-collapse: collapse; font: .86rem/1.4 "Helvetica Neue", Arial, sans-serif;
  font-variant-numeric: tabular-nums; }}
th, td {{ padding: .28rem .8rem; text-align: right; border-bottom: 1px solid #e4e4e8; }}
th:first-child, td:first-child {{ text-align: left; }}
th {{ vertical-align: bottom; border-bottom: 2px solid #1a1a1f; }}
code {{ font-size: .88em; background: #f3f3f5; padding: .05em .25em; }}
</style>
</head>
<body>
{body}
</body>
</html>
"""
