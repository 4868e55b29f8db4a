"""Numbers below the smallest normal one, taken for zero while a kernel runs.

Heat falls by a factor of e an edge, and so do entries of its factor: between the ends of a large
shape they leave the range of normal numbers, 2e-308. With those below it x86 processors take a
hundred times as long: half of the time of a factorisation with 557,000 unknowns. They have few
digits left, and whatever they are added to is far larger: nothing above 1e-300 feels whether they
are there.
"""

import platform
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["flush_subnormals", "restore_subnormals"]

ZEROS = 1 << 15 | 1 << 6
"""The bits of the processor's mode by which results, and what is read, count as zeros."""

SLOW = platform.machine().lower() in {"x86_64", "amd64", "i386", "i686"}
"""Whether this is a processor that needs it; others are no slower on such numbers."""

_mode = ir.IntType(32)


def _call(builder: Any, instruction: str, memory: Any) -> None:
    """Store the mode of the processor in memory (stmxcsr), or load it from there (ldmxcsr)."""
    place = builder.bitcast(memory, ir.IntType(8).as_pointer())
    kind = ir.FunctionType(ir.VoidType(), [place.type])
    name = f"llvm.x86.sse.{instruction}"
    builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [place])


@intrinsic  # type: ignore[untyped-decorator]
def flush_subnormals(_context: Any) -> Any:
    """Have this thread take them for zero, and return its mode of before."""

    def code(_context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        memory = cgutils.alloca_once_value(builder, ir.Constant(_mode, 0))
        if not SLOW:
            return builder.load(memory)
        _call(builder, "stmxcsr", memory)
        before = builder.load(memory)
        builder.store(builder.or_(before, ir.Constant(_mode, ZEROS)), memory)
        _call(builder, "ldmxcsr", memory)
        return before

    return types.int32(), code


@intrinsic  # type: ignore[untyped-decorator]
def restore_subnormals(_context: Any, _before: Any) -> Any:
    """Give this thread the mode that it had."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        if SLOW:
            _call(builder, "ldmxcsr", cgutils.alloca_once_value(builder, arguments[0]))
        return context.get_dummy_value()

    return types.void(types.int32), code
