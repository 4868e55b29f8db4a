"""Files that are written whole or not at all."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from geodesic_toolkit.errors import WriteError

__all__ = ["replacing"]


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside `path`, and move it there when the block ends without an error.

    Whoever looks at `path` meanwhile sees what was there before; so does everyone after a failure.
    A link is followed: its target is replaced.

    Parameters
    ----------
    path : str or path-like
        The file to write.

    Yields
    ------
    Path
        An empty file in the same directory with the same suffix; write the content there.

    Raises
    ------
    WriteError
        The directory does not exist or cannot be written, `path` is a directory or a device, or
        the block raises an ``OSError``.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with replacing(folder / "answer.txt") as temporary:
    ...     _ = temporary.write_text("42")
    >>> (folder / "answer.txt").read_text()
    '42'
    """
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        raise WriteError(f"{path} is not a regular file: give the name of a file to write")
    if not target.parent.is_dir():
        raise WriteError(f"cannot write {path}: there is no directory {target.parent}")
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem[:40]}-", suffix=target.suffix
        )
    except OSError as error:
        raise WriteError(f"cannot write {path}: {error.strerror or error}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(_mode(target))
        temporary.replace(target)
    except WriteError:
        raise
    except OSError as error:
        raise WriteError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _mode(target: Path) -> int:
    """Return the permissions of the file that is there, or those that a new one would get."""
    if target.exists():
        return target.stat().st_mode & 0o7777
    umask = os.umask(0)  # it can only be read by setting it
    os.umask(umask)
    return 0o666 & ~umask
