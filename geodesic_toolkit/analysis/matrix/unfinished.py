"""The files that an interrupted run leaves beside its output, to resume from.

A folder ``NAME.partial`` holds the rows so far, a record of the request, and a mark for each task.
"""

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import IO

import numpy as np

from geodesic_toolkit.core.atomic import replacing, writing
from geodesic_toolkit.core.types import BoolArray
from geodesic_toolkit.errors import InvalidOptionError, WriteError

__all__ = ["Unfinished"]

RECORD = "request.json"

DONE = "done"
"""Name of a file of one byte per task: 1 if its rows are on disk. If it is missing, none are."""

LOCK = "lock"

LONGEST = 100
"""Number of characters of a value that a message shows if requests differ."""


class Unfinished:
    """The folder of an unfinished matrix, new or found.

    Parameters
    ----------
    output : Path
        The path of the result; the folder is beside it.
    request : mapping of str to str
        Everything on which the rows depend, by names that a message can use.
    n_tasks : int
    resume : bool
        Resume from the files found; otherwise discard them.

    Attributes
    ----------
    folder : Path
    done : ndarray of shape (n_tasks,), bool
        The tasks whose rows are on disk.

    Raises
    ------
    InvalidOptionError
        The files belong to another request; the message names the differences.
    WriteError
        Another run is writing it, it is a folder of another kind, or it cannot be written.
    """

    def __init__(
        self, output: Path, request: Mapping[str, str], n_tasks: int, *, resume: bool
    ) -> None:
        self.output = output
        self.folder = output.with_name(f"{output.name}.partial")
        with writing(self.folder):
            found = self._is_there()
            self.folder.mkdir(exist_ok=True)
            self._lock = _locked(self.folder)
            try:
                if found and resume:
                    self._check(request)
                else:
                    self._clear()
                    with replacing(self.folder / RECORD) as record:
                        record.write_text(json.dumps(dict(request), indent=2), encoding="utf-8")
                self.done = self._marks(n_tasks)
            except BaseException:  # also Ctrl-C: remove the lock, then re-raise
                self.close()
                raise

    def mark(self, task: int) -> None:
        """Mark the rows of a task as stored."""
        with (self.folder / DONE).open("r+b") as marks:
            marks.seek(task)
            marks.write(b"\1")
        self.done[task] = True

    def deliver(self, item: Path) -> None:
        """Move an item of the folder to the path of the output, and remove the folder."""
        with writing(self.output):
            aside = self.folder / "replaced"
            if self.output.is_dir():  # a store of zarr, which cannot be replaced in one step
                self.output.replace(aside)
            try:
                item.replace(self.output)
            except BaseException:  # also Ctrl-C: restore the old output
                if aside.exists():
                    aside.replace(self.output)
                raise
            self.close()
            self._clear()
            shutil.rmtree(self.folder)

    def close(self) -> None:
        """Release the folder, and leave it for the next run."""
        self._lock.close()

    def _clear(self) -> None:
        """Remove the marks, then the rows that they mark; the folder stays locked."""
        (self.folder / DONE).unlink(missing_ok=True)
        for item in self.folder.iterdir():
            if item.is_dir():
                shutil.rmtree(item)
            elif item.name not in (RECORD, LOCK):
                item.unlink()

    def _is_there(self) -> bool:
        """Return whether there is a run to resume; raise if the files belong to another request."""
        if not self.folder.exists():
            return False
        if not self.folder.is_dir():
            raise WriteError(f"{self.folder} is not a folder; its name is needed, so remove it")
        if (self.folder / RECORD).exists():
            return True
        # A run that ended before its record was in place leaves the lock and a hidden file.
        if any(item.name != LOCK and item.name[0] != "." for item in self.folder.iterdir()):
            raise WriteError(
                f"{self.folder} is not an unfinished matrix; its name is needed, so move it"
            )
        return False

    def _check(self, request: Mapping[str, str]) -> None:
        try:
            then = json.loads((self.folder / RECORD).read_text(encoding="utf-8"))
        except ValueError as error:
            raise self._broken(f"its {RECORD} cannot be read") from error
        if not isinstance(then, dict):
            raise self._broken(f"its {RECORD} is not a record")
        differences = [
            f"{name} was {_short(then.get(name))}, now {_short(request.get(name))}"
            for name in {**then, **request}
            if then.get(name) != request.get(name)
        ]
        if differences:
            raise InvalidOptionError(
                f"{self.folder} holds an unfinished matrix of another request: "
                f"{'; '.join(differences)}. Finish that one with the same request, or start again "
                "with resume=False (--restart)"
            )

    def _marks(self, n_tasks: int) -> BoolArray:
        path = self.folder / DONE
        if not path.exists():
            with replacing(path) as new:
                new.write_bytes(bytes(n_tasks))
        marks = np.frombuffer(path.read_bytes(), dtype=np.uint8)
        if len(marks) != n_tasks:
            raise self._broken(f"it has {len(marks)} tasks, not {n_tasks}")
        return np.asarray(marks == 1)

    def _broken(self, what: str) -> WriteError:
        return WriteError(
            f"{self.folder} is a damaged unfinished matrix ({what}); start again with resume=False "
            "(--restart)"
        )


def _locked(folder: Path) -> IO[bytes]:
    """Return an open file whose lock marks the folder as in use; a dying process releases it."""
    handle = (folder / LOCK).open("wb")
    if os.name == "posix":  # other systems do not detect two runs at once
        import fcntl

        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            handle.close()
            raise WriteError(f"{folder} is being written by another run; wait for it") from error
        except OSError:
            return handle  # the file system has no locks
    return handle


def _short(value: object) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 14]}…{text[-13:]}"
