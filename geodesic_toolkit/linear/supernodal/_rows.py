"""Arithmetic on rows of a block of right-hand sides, each row as one vector of the machine.

Compilers vectorise such short loops only where they can prove that a row does not overlap what it
is changed by, and they cannot. So the vector instructions are spelled out; LLVM splits a row into
as many registers as it takes. Rows are given by a pointer and an offset.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["BLOCK", "four_minus", "minus_four", "minus_one"]

BLOCK = 16
"""Right-hand sides solved at once: a row of them is two cache lines."""

_row = ir.VectorType(ir.DoubleType(), BLOCK)
_pointer = types.CPointer(types.float64)


def _place(builder: Any, pointer: Any, offset: Any) -> Any:
    """Return the address of the row that begins `offset` numbers after a pointer."""
    if isinstance(offset, int):
        offset = ir.Constant(ir.IntType(64), offset)
    return builder.bitcast(builder.gep(pointer, [offset]), _row.as_pointer())


def _minus_product(builder: Any, row: Any, factor: Any, other: Any) -> Any:
    """Return ``row - factor * other``."""
    undefined, lane = ir.Constant(_row, ir.Undefined), ir.Constant(ir.IntType(32), 0)
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), BLOCK), [0] * BLOCK)
    first = builder.insert_element(undefined, factor, lane)
    product = builder.fmul(builder.shuffle_vector(first, undefined, lanes), other, ("contract",))
    return builder.fsub(row, product, ("contract",))


@intrinsic  # type: ignore[untyped-decorator]
def minus_one(_context: Any, _target: Any, _at: Any, _other: Any, _begin: Any, _factor: Any) -> Any:
    """Subtract a multiple of the row ``other[begin:]`` from the row ``target[at:]``."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, at, other, begin, factor = arguments
        place = _place(builder, target, at)
        row = builder.load(place, align=8)
        multiple = builder.load(_place(builder, other, begin), align=8)
        builder.store(_minus_product(builder, row, factor, multiple), place, align=8)
        return context.get_dummy_value()

    return types.void(_pointer, types.int64, _pointer, types.int64, types.float64), code


@intrinsic  # type: ignore[untyped-decorator]
def minus_four(
    _context: Any, _target: Any, _at: Any, _head: Any, _l0: Any, _l1: Any, _l2: Any, _l3: Any
) -> Any:
    """Subtract multiples of the four rows at `head` from the row ``target[at:]``."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, at, head, *factors = arguments
        place = _place(builder, target, at)
        row = builder.load(place, align=8)
        for k, factor in enumerate(factors):
            other = builder.load(_place(builder, head, k * BLOCK), align=8)
            row = _minus_product(builder, row, factor, other)
        builder.store(row, place, align=8)
        return context.get_dummy_value()

    return types.void(_pointer, types.int64, _pointer, *(types.float64,) * 4), code


@intrinsic  # type: ignore[untyped-decorator]
def four_minus(
    _context: Any, _head: Any, _other: Any, _at: Any, _l0: Any, _l1: Any, _l2: Any, _l3: Any
) -> Any:
    """Subtract multiples of the row ``other[at:]`` from the four rows at `head`."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        head, other, at, *factors = arguments
        multiple = builder.load(_place(builder, other, at), align=8)
        for k, factor in enumerate(factors):
            place = _place(builder, head, k * BLOCK)
            row = builder.load(place, align=8)
            builder.store(_minus_product(builder, row, factor, multiple), place, align=8)
        return context.get_dummy_value()

    return types.void(_pointer, _pointer, types.int64, *(types.float64,) * 4), code
