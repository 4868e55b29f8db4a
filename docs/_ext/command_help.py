"""The directive ``command-help``: every command, by what it says about itself."""

import typer
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from typer.testing import CliRunner

from geodesic_toolkit.cli.program import app as program


class CommandHelp(SphinxDirective):
    """Show the ``--help`` of the program, and a section with that of each of its commands."""

    def run(self) -> list[nodes.Node]:
        """Return a literal block and the sections."""
        return [self._help(), *map(self._section, typer.main.get_command(program).commands)]

    def _section(self, command: str) -> nodes.section:
        section = nodes.section(ids=[f"command-{command}"], names=[command])
        section += [nodes.title(command, command), self._help(command)]
        self.state.document.note_explicit_target(section)
        return section

    def _help(self, *command: str) -> nodes.literal_block:
        result = CliRunner().invoke(program, [*command, "--help"], env={"COLUMNS": "88"})
        if result.exit_code != 0:
            raise self.error(f"geodesic-toolkit {' '.join(command)} --help: {result.output}")
        text = result.stdout.strip("\n")
        block = nodes.literal_block(text, text, language="text", classes=["help"])
        self.set_source_info(block)
        return block


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
