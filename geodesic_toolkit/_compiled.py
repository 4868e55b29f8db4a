"""How kernels are compiled: one place for what Numba is told.

A *kernel* is called from Python, and compiled when its module is imported for the first time on a
machine; a *part* is called by kernels only. Numba wraps a function for callers of three kinds, and
compiling those wrappers takes a fifth as long as compiling the functions. A kernel has the wrapper
for Python, a part has none; to Python it stays the plain function that it is, unless it is inline.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import numba
from numba.extending import register_jitable

__all__ = ["kernel", "part"]

Function = TypeVar("Function", bound=Callable[..., Any])

_options = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}

_FUSED = {"fastmath": {"contract", "nsz"}}
"""A product and a sum may be rounded once. No sum is reordered: it comes out the same wherever it
stands."""


def kernel(*signatures: Any, fused: bool = False) -> Callable[[Function], Function]:
    """Compile a function for some signatures, or load what an earlier process has compiled.

    Without signatures it is compiled when it is called, if ever.
    """
    options = {**_options, **(_FUSED if fused else {})}
    compiled = numba.njit(list(signatures) or None, cache=True, **options)

    def decorate(function: Function) -> Function:
        with _garbage_left_alone():
            result: Function = compiled(function)
        return result

    return decorate


def part(*, fused: bool = False, inline: bool = False) -> Callable[[Function], Function]:
    """Let kernels call a function, or have it `inline` as if it were written out in them.

    What is inline is compiled with the options of the kernel, once for every place that names it.
    What is not is compiled once for kernels, once for parts, and again as a piece of its callers.
    """
    options = {**_options, **(_FUSED if fused else {})}
    decorate: Callable[[Function], Function] = (
        numba.njit(**options, inline="always") if inline else register_jitable(**options)
    )
    return decorate


@contextmanager
def _garbage_left_alone() -> Iterator[None]:
    """Look for no garbage: a tenth of the time of compiling, which makes and keeps many objects."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
