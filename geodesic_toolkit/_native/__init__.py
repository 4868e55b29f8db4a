"""The compiled kernels, built for the best level of x86-64 that this processor has.

Each is a function on arrays, in ``native/``; the names and types are those of ``__init__.pyi``.
"""

import importlib
import os
from types import ModuleType

_CHOICE = "GEODESIC_TOOLKIT_LEVEL"
_LEVELS = (2, 3, 4)


def _processor_level() -> int:
    try:
        processor = importlib.import_module(f"{__name__}._processor")
    except ModuleNotFoundError:  # not an x86-64 processor: there is one module, called the lowest
        return _LEVELS[0]
    return int(processor.LEVEL)


def _levels() -> list[int]:
    """Return the levels to try, the best first: the one that the environment names, or all."""
    best = _processor_level()
    possible = [level for level in reversed(_LEVELS) if level <= best]
    chosen = os.environ.get(_CHOICE)
    if not chosen:
        return possible
    if chosen not in map(str, possible):  # its instructions would end the process
        raise ImportError(
            f"{_CHOICE} is {chosen!r}, and this processor has the levels "
            f"{', '.join(map(str, reversed(possible)))}: name one of them, or unset it"
        )
    return [int(chosen)]


def _load() -> tuple[ModuleType, int]:
    levels = _levels()
    for level in levels:
        name = f"{__name__}._level{level}"
        try:
            return importlib.import_module(name), level
        except ModuleNotFoundError as error:  # one that is there and broken is told as it is
            if error.name != name:
                raise
    wanted = " or ".join(map(str, levels))
    raise ImportError(
        f"{__path__[0]} has no compiled kernels for level {wanted} of x86-64. If that is "
        "in a checkout, `pip install --editable .` builds them (it needs a C++ compiler), and "
        f"Python in another folder finds an installed package; unset {_CHOICE} if it is set"
    )


_kernels, LEVEL = _load()
"""The level is chosen in the environment to test a lower one."""

globals().update({name: value for name, value in vars(_kernels).items() if name[0] != "_"})
