"""Output files that are complete or absent: an interrupted run does not change the old file."""

import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from geodesic_toolkit.errors import GeodesicError, InvalidOptionError, WriteError

__all__ = ["as_path", "check_output", "make_folder", "new_folder", "replacing", "sync", "writing"]


def as_path(path: object) -> Path:
    """Return the path that a user gave.

    Raises
    ------
    InvalidOptionError
        Something else than text or a path.
    """
    if isinstance(path, str | os.PathLike):
        return Path(path)
    raise InvalidOptionError(f"the name of a file must be text or a path, not {path!r:.60}")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn the system's errors, such as a full disk or no permission, into a `WriteError`."""
    try:
        yield
    except GeodesicError:
        raise
    except OSError as error:
        raise WriteError(f"{path} cannot be written: {error.strerror or error}") from error


def check_output(path: str | os.PathLike[str], suffixes: Sequence[str]) -> Path:
    """Raise if `path` cannot become an output; call it before any work.

    Parameters
    ----------
    path : str or path-like
    suffixes : sequence of str
        The suffixes that can be written, with their dots: ``(".ply", ".npy")``.

    Returns
    -------
    Path

    Raises
    ------
    InvalidOptionError
        The suffix is not one of them.
    WriteError
        A directory, a device, a directory that does not exist, or no permission.

    Examples
    --------
    >>> from geodesic_toolkit.io import check_output
    >>> check_output("d.txt", (".ply", ".npy"))
    Traceback (most recent call last):
        ...
    geodesic_toolkit.errors.InvalidOptionError: d.txt: cannot write .txt; can be written: .ply, .npy
    """
    file = as_path(path)
    if file.suffix.lower() not in suffixes:
        unknown = f"cannot write {file.suffix}" if file.suffix else "it has no suffix"
        raise InvalidOptionError(f"{file}: {unknown}; can be written: {', '.join(suffixes)}")
    _target(file)
    return file


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Create the folder of outputs, and its parents, unless it exists.

    Raises
    ------
    WriteError
        It cannot be created: no permission, or another kind of file has its name.
    """
    folder = as_path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"{folder} cannot be made: {error.strerror or error}") from error
    return folder


@contextmanager
def new_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary folder to fill, which is renamed to `path` at the end.

    If the block ends with an exception, the folder is removed, and there is no `path`.

    Parameters
    ----------
    path : str or path-like
        A name that does not exist, in a folder that does.

    Yields
    ------
    Path
        An empty folder beside `path`.

    Raises
    ------
    WriteError
        No permission, a full disk, or `path` exists.
    """
    target = as_path(path)
    temporary = target.with_name(f".{target.name[:100]}.{secrets.token_hex(6)}")
    with writing(target):
        temporary.mkdir()
        try:
            yield temporary
            temporary.rename(target)
        except BaseException:  # also Ctrl-C: remove what was begun, then re-raise
            shutil.rmtree(temporary, ignore_errors=True)
            raise


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path to write to, which replaces `path` at the end.

    It is in the same directory and has the same suffix. If the block ends with an exception, the
    temporary file is removed and `path` does not change; otherwise the file is on disk before it
    replaces `path`.

    Parameters
    ----------
    path : str or path-like
        A symbolic link is kept; the file to which it points is replaced.

    Yields
    ------
    Path
        An empty file.

    Raises
    ------
    WriteError
        A directory, a device, a directory that does not exist, no permission, a full disk.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import replacing
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     target = pathlib.Path(folder, "note.txt")
    ...     with replacing(target) as temporary:
    ...         _ = temporary.write_text("whole")
    ...     target.read_text()
    'whole'
    """
    file = as_path(path)
    target = _target(file)
    temporary = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(6)}{target.suffix}")
    with writing(file):
        # Not tempfile's files, which only their owner may read, whatever the umask.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        try:
            yield temporary
            sync(temporary)
            if target.exists():
                shutil.copymode(target, temporary)
            temporary.replace(target)
            if os.name == "posix":  # so that the new name is on disk, too
                sync(target.parent)
        finally:
            temporary.unlink(missing_ok=True)


def _target(file: Path) -> Path:
    """Return the file to replace, links resolved, or raise if it cannot be replaced."""
    try:
        with writing(file):
            target = Path(os.path.realpath(file))
            if target.is_dir():
                raise WriteError(f"{file} is a directory; give the name of a file")
            if target.exists() and not target.is_file():
                raise WriteError(f"{file} is not a regular file")
            if not target.parent.is_dir():
                raise WriteError(f"{file} cannot be written: there is no directory {target.parent}")
            if not os.access(target.parent, os.W_OK):
                raise WriteError(f"{file} cannot be written: no permission in {target.parent}")
            if target.exists() and not os.access(target, os.W_OK):
                raise WriteError(f"{file} cannot be written: it is read-only")
            return target
    except ValueError as error:  # a NUL in the path
        raise WriteError(f"{str(file)!r} is not a path: {error}") from error


def sync(path: Path) -> None:
    """Flush the contents of a file or folder to disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
