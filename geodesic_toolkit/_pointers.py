"""Plain pointers into arrays, for inner loops.

Handing an array to a compiled function counts a reference up and down again, an atomic operation
each, and an index that might be negative is looked at before it is used. On supernodes of a few
columns both cost as much as the arithmetic. A pointer has neither; its array must outlive it, and
one of a kernel's own making is dropped where it is named last.
"""

from typing import Any, TypeAlias

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["Pointer", "keep", "pointer", "prefetch", "shifted"]

Pointer: TypeAlias = Any
"""To type checkers, what `pointer` returns."""


@intrinsic  # type: ignore[untyped-decorator]
def pointer(_context: Any, array: Any) -> Any:
    """Return where the first element of a contiguous array is; ``p[k]`` is the one k further."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        structure = context.make_array(signature.args[0])(context, builder, arguments[0])
        return structure.data

    return types.CPointer(array.dtype)(array), code


@intrinsic  # type: ignore[untyped-decorator]
def shifted(_context: Any, place: Any, _count: Any) -> Any:
    """Return a pointer moved by a count of numbers."""

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.gep(arguments[0], [arguments[1]])

    return place(place, types.int64), code


@intrinsic  # type: ignore[untyped-decorator]
def keep(_context: Any, arrays: Any) -> Any:
    """Let a tuple of arrays live until here, so that pointers into them are good until here."""

    def code(context: Any, _builder: Any, _signature: Any, _arguments: Any) -> Any:
        return context.get_dummy_value()

    return types.void(arrays), code


@intrinsic  # type: ignore[untyped-decorator]
def prefetch(_context: Any, place: Any) -> Any:
    """Ask for the memory around a pointer, which is to be read soon, without waiting for it."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        number = ir.IntType(32)
        where = builder.bitcast(arguments[0], ir.IntType(8).as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [where.type, number, number, number])
        ask = builder.module.declare_intrinsic("llvm.prefetch", [where.type], kind)
        reading, often, data = number(0), number(3), number(1)
        builder.call(ask, [where, reading, often, data])
        return context.get_dummy_value()

    return types.void(place), code
