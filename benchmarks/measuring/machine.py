"""The machine of the measurements."""

import mmap
import os
import platform
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from measuring.clocks import timed

PACKAGES = ("geodesic-toolkit", "numpy", "scipy", "potpourri3d", "libigl")


def machine() -> dict[str, Any]:
    """Return the processor, its cores, the memory, the date and the versions."""
    versions = {"Python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return {
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "memory": os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"),
        "date": datetime.now(UTC).date().isoformat(),
        "versions": versions,
    }


def sentence(found: dict[str, Any]) -> str:
    """Return the same as a line of text."""
    versions = ", ".join(f"{name} {version}" for name, version in found["versions"].items())
    return (
        f"Measured on {found['date']}: {found['processor']}, {found['cores']} cores, "
        f"{found['memory'] / 2**30:.0f} GiB of memory; {versions}.\n"
    )


def processor() -> str:
    """Return the model of the processor, as the system calls it."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def reading(long: np.ndarray) -> float:
    """Return the bytes a second of CPU time at which one core reads an array."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        spent, _ = timed(lambda: long @ long)
    return long.nbytes / spent["cpu"]


def touch(size: int) -> None:
    """Write to `size` bytes of fresh memory, and free them.

    The host of a virtual machine takes away memory that has been free for some seconds. The
    next process that uses it waits twenty times as long for each page (measured: 2.4 ms a megabyte
    instead of 0.1), which is not a property of a library.
    """
    np.empty(size, dtype=np.uint8)[:: mmap.PAGESIZE] = 1
