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
"""Seconds for Python's own KeyboardInterrupt to arrive and clean up."""

_last_words: list[str] = []


@contextmanager
def last_words(text: str) -> Iterator[None]:
    """Print `text` if the process is ended within the block without cleaning up."""
    _last_words.append(text)
    try:
        yield
    finally:
        _last_words.remove(text)


@contextmanager
def prompt_interrupts() -> Iterator[None]:
    """End the process soon after Ctrl-C, even during a compiled computation.

    Python raises KeyboardInterrupt between two of its own instructions, and a factorisation is
    one instruction that may take minutes. The signal also reaches a thread here, which ends the
    process if the exception does not arrive in time.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    finished = threading.Event()

    def watch() -> None:
        while signals := receiver.recv(16):
            if signal.SIGINT in signals and not finished.wait(GRACE_PERIOD):
                _end_process()

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    previous = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        finished.set()
        signal.set_wakeup_fd(previous)
        sender.close()
        watcher.join()
        receiver.close()


def leave_soon() -> None:
    """End the interpreter after a grace period, even if the threads of a process pool still wait.

    If a process is ended in the middle of a result, such a thread waits for the rest of it.
    """

    def leave() -> None:
        time.sleep(GRACE_PERIOD)
        os._exit(INTERRUPTED)

    threading.Thread(target=leave, daemon=True).start()


def _end_process() -> None:
    # The main thread is blocked, so cleaning up is not possible; only the cursor is restored.
    restore = "\r\x1b[2K\x1b[?25h" if sys.stderr.isatty() else ""
    lines = [*_last_words, "interrupted"]
    os.write(2, (restore + "\n".join(lines) + "\n").encode(errors="backslashreplace"))
    os._exit(INTERRUPTED)
