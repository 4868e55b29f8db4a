"""What an interrupted run leaves beside its output, so that the next one goes on from there.

A folder ``NAME.partial`` holds the rows so far, a record of the request, and which tasks are done.
"""

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray
from geodesic_toolkit.errors import InvalidOptionError, WriteError

__all__ = ["Unfinished", "writing"]

SUFFIX = ".partial"

RECORD = "request.json"

NEW_RECORD = RECORD + ".new"

DONE = "done"
"""A file of one byte a task: 1 where its rows are on disk."""

LOCK = "lock"

LONGEST = 100
"""Characters of a value shown where requests differ."""


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the system says of a full disk or a missing permission into a `WriteError`."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        raise WriteError(f"{path} cannot be written: {error.strerror or error}") from error


def _folder(output: Path) -> Path:
    return output.with_name(output.name + SUFFIX)


class Unfinished:
    """The folder of an unfinished matrix, new or found.

    Parameters
    ----------
    output : Path
        Where the result will be; the folder lies beside it.
    request : mapping of str to str
        Everything that the rows depend on, by names that a message can use.
    n_tasks : int
    resume : bool
        Whether to go on with what is there; else it is thrown away.

    Attributes
    ----------
    folder : Path
    done : ndarray of shape (n_tasks,), bool
        Whose rows are on disk.

    Raises
    ------
    InvalidOptionError
        What is there was begun for another request; the message says what differs.
    WriteError
        Another run is at work on it, it is a folder of another kind, or cannot be written.
    """

    def __init__(
        self, output: Path, request: Mapping[str, str], n_tasks: int, *, resume: bool
    ) -> None:
        self.output = output
        self.folder = _folder(output)
        self.done: BoolArray = np.zeros(n_tasks, dtype=bool)
        with writing(self.folder):
            found = self._is_there()
            self.folder.mkdir(exist_ok=True)
            self._lock = _locked(self.folder)
            try:
                if found and resume:
                    self._go_on(request)
                else:
                    self._begin(request)
                self._marks = (self.folder / DONE).open("r+b")
            except BaseException:  # Ctrl-C too must not leave the lock; it goes on at once
                self._lock.close()
                raise

    def mark(self, task: int) -> None:
        """Note that the rows of a task are on disk."""
        with writing(self.folder):
            self._marks.seek(task)
            self._marks.write(b"\1")
            self._marks.flush()
        self.done[task] = True

    def deliver(self, item: Path) -> None:
        """Put an item of the folder in the place of the output, and remove the folder."""
        with writing(self.output):
            aside = self.folder / "replaced"
            if self.output.is_dir():  # a store of zarr, which cannot be replaced in one step
                self.output.replace(aside)
            try:
                item.replace(self.output)
            except BaseException:  # Ctrl-C too must leave the old output whole; it goes on at once
                if aside.exists():
                    aside.replace(self.output)
                raise
            self._remove_rest()

    def _remove_rest(self) -> None:
        self.close()
        self._empty()
        for name in (RECORD, LOCK):  # the record last of all that matters: with it goes the claim
            (self.folder / name).unlink()
        self.folder.rmdir()

    def _empty(self) -> None:
        for item in self.folder.iterdir():
            if item.name in (RECORD, LOCK):
                continue
            if item.is_dir():
                shutil.rmtree(item)
            else:
                item.unlink()

    def close(self) -> None:
        """Let go of the folder, and leave it for the next run."""
        self._marks.close()
        self._lock.close()

    def _is_there(self) -> bool:
        """Whether there is something to go on with; raises where it is not ours."""
        if not self.folder.exists():
            return False
        if not self.folder.is_dir():
            raise WriteError(f"{self.folder} is in the way: it is not a folder; remove it")
        if (self.folder / RECORD).exists():
            return True
        if any(item.name not in (DONE, LOCK, NEW_RECORD) for item in self.folder.iterdir()):
            raise WriteError(
                f"{self.folder} is in the way: it is not an unfinished matrix; move it elsewhere"
            )
        return False

    def _begin(self, request: Mapping[str, str]) -> None:
        (self.folder / RECORD).unlink(missing_ok=True)
        self._empty()
        (self.folder / DONE).write_bytes(bytes(len(self.done)))
        # Last, and in one step: where it is, all else is there.
        temporary = self.folder / NEW_RECORD
        temporary.write_text(json.dumps(dict(request), indent=2), encoding="utf-8")
        temporary.replace(self.folder / RECORD)

    def _go_on(self, request: Mapping[str, str]) -> None:
        then = self._record()
        names = [name for name in {**then, **request} if then.get(name) != request.get(name)]
        if names:
            differences = "; ".join(
                f"{name} was {_short(then.get(name))}, now {_short(request.get(name))}"
                for name in names
            )
            raise InvalidOptionError(
                f"{self.folder} holds an unfinished matrix of another request: {differences}. "
                "Finish that one with the same request, or begin anew with resume=False (--restart)"
            )
        marks = np.frombuffer((self.folder / DONE).read_bytes(), dtype=np.uint8)
        if len(marks) != len(self.done):
            raise self._broken(f"{len(marks)} tasks, not {len(self.done)}")
        self.done = marks == 1

    def _record(self) -> dict[str, Any]:
        try:
            record = json.loads((self.folder / RECORD).read_text(encoding="utf-8"))
        except ValueError as error:
            raise self._broken(f"its {RECORD} cannot be read") from error
        if not isinstance(record, dict):
            raise self._broken(f"its {RECORD} holds no record")
        return record

    def _broken(self, what: str) -> WriteError:
        return WriteError(
            f"{self.folder} is a damaged unfinished matrix ({what}); begin anew with resume=False "
            "(--restart)"
        )


def _locked(folder: Path) -> IO[bytes]:
    """Return a file whose lock says that the folder is in use; a process that dies lets it go."""
    handle = (folder / LOCK).open("wb")
    if os.name == "posix":  # elsewhere two runs at once are not noticed
        import fcntl

        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            handle.close()
            raise WriteError(f"{folder} is being written by another run; wait for it") from error
        except OSError:
            return handle  # a file system without locks
    return handle


def _short(value: object) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 14]}…{text[-13:]}"
