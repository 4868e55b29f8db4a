"""The compiled kernels, built for the best level of x86-64 that this processor has.

The kernels are functions on arrays, in ``native/``; ``__init__.pyi`` has their names and types.
"""

import importlib
import os
from types import ModuleType

_CHOICE = "GEODESIC_TOOLKIT_LEVEL"
_LEVELS = (2, 3, 4)


def _processor_level() -> int:
    try:
        processor = importlib.import_module(f"{__name__}._processor")
    except ModuleNotFoundError:  # not x86-64: one module, named after the lowest level
        return _LEVELS[0]
    return int(processor.LEVEL)


def _levels() -> list[int]:
    """Return the levels to try, best first: the level in the environment, or all."""
    best = _processor_level()
    possible = [level for level in reversed(_LEVELS) if level <= best]
    chosen = os.environ.get(_CHOICE)
    if not chosen:
        return possible
    if chosen not in map(str, possible):  # its instructions would crash the process
        raise ImportError(
            f"{_CHOICE} is {chosen!r}, but this processor has the levels "
            f"{', '.join(map(str, reversed(possible)))}: name one of them, or unset it"
        )
    return [int(chosen)]


def _load() -> tuple[ModuleType, int]:
    levels = _levels()
    for level in levels:
        name = f"{__name__}._level{level}"
        try:
            return importlib.import_module(name), level
        except (
            ModuleNotFoundError
        ) as error:  # errors inside an existing module are raised unchanged
            if error.name != name:
                raise
    wanted = " or ".join(map(str, levels))
    raise ImportError(
        f"{__path__[0]} has no compiled kernels for level {wanted} of x86-64. If this is "
        "a checkout, `pip install --editable .` builds them (it needs a C++ compiler), and "
        f"Python in another folder finds an installed package; unset {_CHOICE} if it is set"
    )


_kernels, LEVEL = _load()
"""The level of the kernels; the environment can choose a lower one for tests."""

globals().update({name: value for name, value in vars(_kernels).items() if name[0] != "_"})
