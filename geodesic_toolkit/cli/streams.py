"""Standard input and output in place of files.

The INPUT ``-`` is standard input, whose format its first bytes say; the output ``-.csv`` is
standard output, in the format of .csv files.
"""

import codecs
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from geodesic_toolkit.cli.output import quiet, renamed, to_stdout
from geodesic_toolkit.errors import InvalidOptionError, ReadError, WriteError

__all__ = ["is_stream", "streams"]

INPUTS = ("path", "paths")
OUTPUTS = ("output", "picture", "html", "parts")
"""Parameters of commands that are files; each may be one path or several."""

STREAM = re.compile(r"-(\.\w+)*")

BEGINNINGS: tuple[tuple[bytes, str], ...] = (
    (rb"ply\s", ".ply"),
    (rb"\s*(ST)?(C)?(N)?(4)?(n)?OFF\b", ".off"),
    (rb"\xff\xff\xfe", ".pial"),
    (rb"(#[^\n]*\n)?\s*(VERSION|# \.PCD)|# \.PCD", ".pcd"),
    (rb"LASF", ".las"),
    (rb"# vtk DataFile", ".vtk"),
    (rb"<\?xml[^>]*>\s*<!DOCTYPE GIFTI|(<\?xml[^>]*>\s*)?<GIFTI", ".gii"),
    (rb'(<\?xml[^>]*>\s*)?<VTKFile[^>]*type="PolyData"', ".vtp"),
    (rb'(<\?xml[^>]*>\s*)?<VTKFile[^>]*type="UnstructuredGrid"', ".vtu"),
    (rb"\$MeshFormat", ".msh"),
    (rb"glTF", ".glb"),
    (rb"%%MatrixMarket", ".mtx"),
    (rb"\x93NUMPY", ".npy"),
    (rb"\s*solid\b[^\n]*\n\s*(facet|endsolid)", ".stl"),
    (rb"(\s*(#|o |g |mtllib|s |usemtl)[^\n]*\n|\s*\n)*\s*v +[-+.\d]", ".obj"),
)
"""Patterns of the first bytes of a file, and the suffix of its format."""

LENGTH_OF_BEGINNING = 65536

FOLDERS = (".zarr",)
"""Formats of which an output is a folder, which no stream can carry."""


def is_stream(path: Path) -> bool:
    """Return True if a path as typed stands for standard input or output."""
    return STREAM.fullmatch(str(path)) is not None


@contextmanager
def streams(options: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Replace streams among the files of a command by files, read before and written after it.

    Results are not printed if a file goes to standard output.

    Parameters
    ----------
    options : mapping
        Arguments of a command by name.

    Raises
    ------
    InvalidOptionError
        A stream without a format or of a format that needs a folder; several streams of one
        direction, or one that is closed; a JSON object and a file on standard output; a shape from
        a terminal.
    """
    read, written = _streams_of(options, INPUTS), _streams_of(options, OUTPUTS)
    if not read and not written:
        yield dict(options)
        return
    if written and options.get("json"):
        raise InvalidOptionError("--json and an output cannot both go to standard output")
    for paths, stream, name in ((read, sys.stdin, "input"), (written, sys.stdout, "output")):
        if paths and stream is None:
            raise InvalidOptionError(f"{paths[0]} is standard {name}, which is closed")
    if read and sys.stdin.isatty():
        raise InvalidOptionError("- reads standard input, which is a terminal; pipe a file into it")
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        files = {path: Path(folder, f"stdout{_format(path)}") for path in written}
        files |= {path: _received(Path(folder)) for path in read}
        stack.enter_context(renamed({str(file): str(path) for path, file in files.items()}))
        stack.enter_context(quiet(results=bool(written)))
        yield {
            name: _replaced(value, files) if name in (*INPUTS, *OUTPUTS) else value
            for name, value in options.items()
        }
        sys.stdout.flush()
        for path in written:
            _send(files[path])


def _streams_of(options: Mapping[str, Any], names: tuple[str, ...]) -> list[Path]:
    """Return the streams among the files of some parameters: one at most."""
    found = [path for name in names for path in _paths(options.get(name)) if is_stream(path)]
    if len(found) > 1:
        raise InvalidOptionError(
            f"{' and '.join(map(str, found))} are the same stream; give one, and files otherwise"
        )
    return found


def _paths(value: Any) -> list[Path]:
    values = value if isinstance(value, list | tuple) else [value]
    return [one for one in values if isinstance(one, Path)]


def _received(folder: Path) -> Path:
    """Return a file with the content of standard input, whose suffix is that of its format.

    Raises
    ------
    ReadError
        The format is not known.
    WriteError
        The folder of temporary files is full.
    """
    beginning = sys.stdin.buffer.read(LENGTH_OF_BEGINNING)
    text = beginning.removeprefix(codecs.BOM_UTF8)
    suffixes = (suffix for pattern, suffix in BEGINNINGS if re.match(pattern, text))
    suffix = next(suffixes, None)
    if suffix is None:
        raise ReadError(
            "the format of standard input was not recognised from its first bytes; write it to a "
            "file with the suffix of its format, and give that"
        )
    path = folder / f"stdin{suffix}"
    try:
        with path.open("wb") as file:
            file.write(beginning)
            shutil.copyfileobj(sys.stdin.buffer, file)
    except OSError as error:
        raise WriteError(
            f"standard input cannot be stored in {folder.parent}: {error.strerror}; free space "
            "there, or set TMPDIR to another folder"
        ) from error
    return path


def _format(path: Path) -> str:
    suffix = str(path)[1:]
    if not suffix:
        raise InvalidOptionError("the output - needs a format: -.csv, for example")
    if suffix.lower() in FOLDERS:
        raise InvalidOptionError(f"{path}: a {suffix} output is a folder, not a stream")
    return suffix


def _replaced(value: Any, files: Mapping[Path, Path]) -> Any:
    if isinstance(value, list | tuple):
        return [_replaced(one, files) for one in value]
    return files.get(value, value) if isinstance(value, Path) else value


def _send(file: Path) -> None:
    """Copy a file to standard output."""
    with file.open("rb") as content, to_stdout():
        shutil.copyfileobj(content, sys.stdout.buffer)
        sys.stdout.buffer.flush()
