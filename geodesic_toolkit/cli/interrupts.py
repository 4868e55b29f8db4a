"""Ctrl-C that works while compiled code computes."""

import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from geodesic_toolkit.cli.exits import INTERRUPTED

__all__ = ["last_words", "leave_soon", "prompt_interrupts"]

GRACE_PERIOD = 1.0
"""Seconds for Python's own KeyboardInterrupt to come through and clean up."""

_last_words: list[str] = []


@contextmanager
def last_words(text: str) -> Iterator[None]:
    """Have `text` said where the process is ended within the block, with no time for more."""
    _last_words.append(text)
    try:
        yield
    finally:
        _last_words.remove(text)


@contextmanager
def prompt_interrupts() -> Iterator[None]:
    """End the process soon after Ctrl-C, whatever it is doing.

    Python raises KeyboardInterrupt between two of its own instructions, and a factorisation is
    one instruction that may take minutes. The signal also reaches a thread here, which ends the
    process where the exception does not come through.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ours, theirs = socket.socketpair()
    theirs.setblocking(False)
    left = threading.Event()

    def watch() -> None:
        while signals := ours.recv(16):
            if signal.SIGINT in signals and not left.wait(GRACE_PERIOD):
                _leave()

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    previous = signal.set_wakeup_fd(theirs.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        left.set()
        signal.set_wakeup_fd(previous)
        theirs.close()
        watcher.join()
        ours.close()


def leave_soon() -> None:
    """See to it that the interpreter ends, which waits for the threads of a pool of processes.

    A process that was ended in the middle of a result leaves such a thread waiting for the rest.
    """

    def leave() -> None:
        time.sleep(GRACE_PERIOD)
        os._exit(INTERRUPTED)

    threading.Thread(target=leave, daemon=True).start()


def _leave() -> None:
    # No cleaning up is possible with the main thread held; only the terminal's cursor comes back.
    restore = "\r\x1b[2K\x1b[?25h" if sys.stderr.isatty() else ""
    lines = [*_last_words, "interrupted"]
    os.write(2, (restore + "\n".join(lines) + "\n").encode(errors="backslashreplace"))
    os._exit(INTERRUPTED)
