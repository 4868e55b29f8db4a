"""Time and memory of this process; standard library alone, so that imports can be timed."""

import gc
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

STATUS = Path("/proc/self/status")
CLEAR = Path("/proc/self/clear_refs")


def timed(work: Callable[[], Any]) -> tuple[dict[str, float], Any]:
    """Return the seconds of CPU, of all threads, and of the clock that `work` takes; its result."""
    gc.collect()
    return clocked(work)


def clocked(work: Callable[[], Any]) -> tuple[dict[str, float], Any]:
    """Return the same without looking for garbage before: a part of what is being timed."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return {"cpu": cpu, "wall": wall}, result


def resident() -> int:
    """Return the bytes of memory that this process holds."""
    return _status("VmRSS")


def peak_resident() -> int:
    """Return the most that it has held since `forget_peak`."""
    return _status("VmHWM")


def forget_peak() -> None:
    """Count the peak from now on (Linux)."""
    CLEAR.write_text("5", encoding="ascii")


def trim() -> None:
    """Give back what allocators keep: this package's, and the C library's if it has a way."""
    import ctypes
    import ctypes.util

    name = ctypes.util.find_library("c")
    if name is not None:
        getattr(ctypes.CDLL(name), "malloc_trim", int)(0)
    kernels = sys.modules.get("geodesic_toolkit._native")
    if kernels is not None:
        getattr(kernels, "trim", int)()


def go_first() -> None:
    """Let the system end this process, and not its parent, where memory runs out (Linux)."""
    Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")


def _status(key: str) -> int:
    for line in STATUS.read_text(encoding="ascii").splitlines():
        name, _, value = line.partition(":")
        if name == key:
            return 1024 * int(value.split()[0])
    raise RuntimeError(f"{STATUS} has no {key}: memory is measured on Linux only")
