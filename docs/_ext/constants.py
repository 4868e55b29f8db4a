"""The directive ``constants``: every tuned constant with its text, of Python and of kernels."""

import ast
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[2]
PACKAGE, NATIVE = ROOT / "geodesic_toolkit", ROOT / "native"
OF_KERNELS = re.compile(
    r"^((?:[ ]*//.*\n)+)[ ]*(?:inline |static )?constexpr (?:double|int|Index|Row|std::size_t)"
    r" k(\w+)\s*=\s*([^;]*\d[^;]*);",
    re.MULTILINE,
)


class Constant(NamedTuple):
    """A number under a name in capitals, and the text below it."""

    name: str
    value: str
    text: str


def constants_of(module: Path) -> Iterator[Constant]:
    """Yield the constants of a module that are numbers, or several numbers, and have a text."""
    body = ast.parse(module.read_text(encoding="utf-8")).body
    for statement, below in pairwise(body):
        if isinstance(statement, ast.Assign):
            target = statement.targets[0]
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            target = statement.target
        else:
            continue
        name, value = (ast.unparse(part).strip("()") for part in (target, statement.value))
        is_text = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        is_number = re.search(r"\b\d", value) and not re.search(r"[({\[]", value)
        if name.isupper() and is_text and is_number and isinstance(below.value.value, str):
            yield Constant(name.lstrip("_"), value, below.value.value.strip())


def constants_of_kernels(source: Path) -> Iterator[Constant]:
    """Yield the constants of a C++ file that are numbers and have a comment above them."""
    for above, name, value in OF_KERNELS.findall(source.read_text(encoding="utf-8")):
        text = " ".join(line.strip().removeprefix("//").strip() for line in above.splitlines())
        yield Constant(f"k{name}", " ".join(value.split()), text)


class Constants(SphinxDirective):
    """Show a section for each module that has constants, in the order of the folders."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        sections = []
        kernels = [path for path in NATIVE.rglob("*.?pp") if path.parent.name != "tests"]
        for module in [*sorted(PACKAGE.rglob("*.py")), *sorted(kernels)]:
            read = constants_of if module.suffix == ".py" else constants_of_kernels
            self.env.note_dependency(str(module))
            if found := list(read(module)):
                sections.append(self._section(module, found))
        return sections

    def _section(self, module: Path, constants: list[Constant]) -> nodes.section:
        place = module.relative_to(PACKAGE if module.suffix == ".py" else ROOT).as_posix()
        section = nodes.section(ids=[f"constants-{nodes.make_id(place)}"], names=[place])
        section += nodes.title(place, place)
        for constant in constants:
            shown = f"{constant.name} = {constant.value}"
            section += nodes.paragraph("", "", nodes.literal(shown, shown))
            quote = nodes.block_quote()
            quote += [nodes.paragraph(text, text) for text in constant.text.split("\n\n")]
            section += quote
        self.state.document.note_explicit_target(section)
        return section


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("constants", Constants)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
