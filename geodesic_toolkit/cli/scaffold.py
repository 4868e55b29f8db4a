"""The files of a new plugin, from the templates of its kind."""

import keyword
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path

import typer

from geodesic_toolkit.core.atomic import make_folder, new_folder
from geodesic_toolkit.errors import InvalidOptionError, WriteError

__all__ = ["Names", "PluginKind", "check_names", "files_of", "names_of", "write_plugin"]

TEMPLATES = Path(__file__).with_name("templates")

PREFIX = "geodesic-toolkit-"
"""Beginning of the names of distributions that the name of a plugin omits."""

DISTRIBUTION_NAME = re.compile(r"[A-Z0-9]|[A-Z0-9][A-Z0-9._-]*[A-Z0-9]", re.ASCII | re.IGNORECASE)
"""Valid names of distributions, as the packaging standards define them."""


class PluginKind(StrEnum):
    """Kinds of plugin that have templates."""

    operator = "operator"
    domain = "domain"
    solver = "solver"
    reader = "reader"
    command = "command"


@dataclass(frozen=True)
class _Metadata:
    """The metadata that depend on the kind of plugin."""

    group: str
    target: str
    summary: str
    dependencies: tuple[str, ...]


ARRAYS = ("geodesic-toolkit>=0.1", "numpy>=1.26")
WITH_SCIPY = (*ARRAYS, "scipy>=1.15")

METADATA = {
    PluginKind.operator: _Metadata(
        "operators",
        "KernelLaplacian",
        "An operator for geodesic-toolkit: the Gaussian-kernel Laplacian of a point cloud",
        WITH_SCIPY,
    ),
    PluginKind.domain: _Metadata(
        "operators",
        "WireLaplacian",
        "A kind of domain for geodesic-toolkit: straight wires in space",
        ARRAYS,
    ),
    PluginKind.solver: _Metadata(
        "solvers",
        "PivotedLU",
        "A linear solver for geodesic-toolkit: sparse LU with pivoting",
        WITH_SCIPY,
    ),
    PluginKind.reader: _Metadata(
        "readers",
        "read_triangles",
        "A reader for geodesic-toolkit: triangles in a small text format",
        ARRAYS[:1],
    ),
    PluginKind.command: _Metadata(
        "commands",
        "farthest",
        "A command for geodesic-toolkit: the vertex that is farthest from another one",
        (*ARRAYS, "typer>=0.16"),
    ),
}


@dataclass(frozen=True)
class Names:
    """The names of a new plugin.

    Attributes
    ----------
    distribution : str
        Name of the distribution, and of its folder.
    module : str
        Name of the package that it installs.
    plugin : str
        Name of the plugin: an operator, a solver, the suffix of files, or a command.
    """

    distribution: str
    module: str
    plugin: str


def names_of(distribution: str) -> Names:
    """Return the names that follow from that of a distribution.

    Raises
    ------
    InvalidOptionError
        It is not a valid name of a distribution, or the name of its package would not be one.

    Examples
    --------
    >>> names_of("geodesic-toolkit-hodge")
    Names(distribution='geodesic-toolkit-hodge', module='geodesic_toolkit_hodge', plugin='hodge')
    """
    if not DISTRIBUTION_NAME.fullmatch(distribution):
        raise InvalidOptionError(
            f"{distribution!r} is not the name of a distribution: use letters, digits, and single "
            "dots, hyphens or underscores between them"
        )
    normal = re.sub(r"[-_.]+", "-", distribution).lower()
    module = normal.replace("-", "_")
    if not module.isidentifier() or keyword.iskeyword(module):
        raise InvalidOptionError(
            f"{distribution!r} would be the package {module!r}, which Python cannot import: choose "
            "a name that begins with a letter and is not a keyword"
        )
    return Names(distribution, module, normal.removeprefix(PREFIX))


def check_names(names: Names, kind: PluginKind) -> None:
    """Raise unless the names of a new plugin are free in this environment.

    Raises
    ------
    InvalidOptionError
        Another package or another plugin of the kind has the name.
    """
    found = find_spec(names.module)
    if names.module in sys.stdlib_module_names or (found is not None and found.has_location):
        raise InvalidOptionError(
            f"the package {names.module!r} exists in this environment: choose another name than "
            f"{names.distribution!r}"
        )
    if names.plugin in _taken(kind):
        raise InvalidOptionError(
            f"the {METADATA[kind].group.removesuffix('s')} {names.plugin!r} exists in this "
            f"environment: choose another name than {names.distribution!r}"
        )


def _taken(kind: PluginKind) -> set[str]:
    """Return the names of the installed plugins in the group of a kind."""
    from geodesic_toolkit.cli.extensions import commands
    from geodesic_toolkit.cli.program import app
    from geodesic_toolkit.registry import catalog

    group = METADATA[kind].group
    if group == "commands":
        return {*commands, *typer.main.get_group(app).commands}
    groups: dict[str, Mapping[str, object]] = {
        "operators": catalog.operators,
        "solvers": catalog.solvers,
        "readers": catalog.readers,
    }
    shared = {"gz"} if group == "readers" else set()  # which is unpacked, whatever is in it
    return shared | {name.rpartition(":")[2] for name in groups[group]}


def files_of(kind: PluginKind, names: Names) -> dict[str, str]:
    """Return the files of a new plugin: their paths in its folder, and their texts."""
    metadata = METADATA[kind]
    words = {
        "distribution-name": names.distribution,
        "package_name": names.module,
        "plugin-name": names.plugin,
        "plugin-group": metadata.group,
        "plugin-target": metadata.target,
        "plugin-summary": metadata.summary,
        "plugin-dependencies": '", "'.join(metadata.dependencies),
    }
    pattern = re.compile("|".join(words))

    def filled(text: str) -> str:
        return pattern.sub(lambda found: words[found[0]], text)

    return {
        filled(path.relative_to(folder).as_posix()): filled(path.read_text(encoding="utf-8"))
        for folder in (TEMPLATES / "common", TEMPLATES / kind)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "__pycache__"
    }


def write_plugin(kind: PluginKind, names: Names, parent: Path) -> list[Path]:
    """Write a new plugin into a folder of its own, all files of it or none.

    Parameters
    ----------
    kind : PluginKind
    names : Names
    parent : Path
        The folder of its folder; created if it does not exist.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    WriteError
        The folder of the plugin exists, or cannot be written.
    """
    target = parent / names.distribution
    if target.exists() or target.is_symlink():
        raise WriteError(f"{target} exists already: remove it, or choose another name or folder")
    files = files_of(kind, names)
    make_folder(parent)
    with new_folder(target) as temporary:
        for name, text in files.items():
            file = temporary / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="\n")
    return [target / name for name in files]
