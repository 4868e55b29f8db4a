"""The compiled kernels, built for the best level of x86-64 that this processor has.

Each is a function on arrays, in ``native/``; the names and types are those of ``__init__.pyi``.
"""

import importlib
import os
from types import ModuleType

LEVEL = int(os.environ.get("GEODESIC_TOOLKIT_LEVEL", "0"))
"""The level of the module that is loaded; chosen in the environment to test the lower ones."""


def _levels() -> list[int]:
    """Return the levels that this processor has, the best first."""
    if LEVEL:
        return [LEVEL]
    try:
        processor = importlib.import_module("geodesic_toolkit._native._processor")
    except ImportError:  # not an x86-64 processor: there is one module
        return [2]
    return list(range(processor.LEVEL, 1, -1))


def _load() -> tuple[ModuleType, int]:
    failed: list[str] = []
    for level in _levels():
        name = f"{__name__}._level{level}"
        try:
            return importlib.import_module(name), level
        except ImportError as error:
            failed.append(f"level {level}: {error}")
    raise ImportError(
        "the compiled kernels of geodesic-toolkit could not be loaded ("
        + "; ".join(failed)
        + "). A checkout is built by: pip install . (it needs a C++ compiler)"
    )


_kernels, LEVEL = _load()
globals().update({name: value for name, value in vars(_kernels).items() if name[0] != "_"})
