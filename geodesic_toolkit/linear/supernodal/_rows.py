"""Arithmetic on rows of a block of right-hand sides, each row as one vector of the machine.

Compilers vectorise such short loops only where they can prove that a row does not overlap what it
is changed by, and they cannot. So the vector instructions are spelled out; LLVM splits a row into
as many registers as it takes. Rows are given by a pointer and an offset.
"""

from typing import Any

from numba import types
from numba.extending import intrinsic

from geodesic_toolkit.linear.supernodal._vectors import minus_product, place, spread, vector_of

__all__ = ["BLOCK", "four_minus", "minus_four", "minus_one"]

BLOCK = 16
"""Right-hand sides solved at once: a row of them is two cache lines."""

_row = vector_of(BLOCK)
_pointer = types.CPointer(types.float64)


def _row_at(builder: Any, pointer: Any, offset: Any) -> Any:
    """Return the address of the row that begins `offset` numbers after a pointer."""
    return place(builder, pointer, offset, _row)


@intrinsic  # type: ignore[untyped-decorator]
def minus_one(_context: Any, _target: Any, _at: Any, _other: Any, _begin: Any, _factor: Any) -> Any:
    """Subtract a multiple of the row ``other[begin:]`` from the row ``target[at:]``."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, at, other, begin, factor = arguments
        where = _row_at(builder, target, at)
        row = builder.load(where, align=8)
        multiple = builder.load(_row_at(builder, other, begin), align=8)
        builder.store(
            minus_product(builder, row, spread(builder, factor, _row), multiple), where, align=8
        )
        return context.get_dummy_value()

    return types.void(_pointer, types.int64, _pointer, types.int64, types.float64), code


@intrinsic  # type: ignore[untyped-decorator]
def minus_four(
    _context: Any, _target: Any, _at: Any, _head: Any, _l0: Any, _l1: Any, _l2: Any, _l3: Any
) -> Any:
    """Subtract multiples of the four rows at `head` from the row ``target[at:]``."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, at, head, *factors = arguments
        where = _row_at(builder, target, at)
        row = builder.load(where, align=8)
        for k, factor in enumerate(factors):
            other = builder.load(_row_at(builder, head, k * BLOCK), align=8)
            row = minus_product(builder, row, spread(builder, factor, _row), other)
        builder.store(row, where, align=8)
        return context.get_dummy_value()

    return types.void(_pointer, types.int64, _pointer, *(types.float64,) * 4), code


@intrinsic  # type: ignore[untyped-decorator]
def four_minus(
    _context: Any, _head: Any, _other: Any, _at: Any, _l0: Any, _l1: Any, _l2: Any, _l3: Any
) -> Any:
    """Subtract multiples of the row ``other[at:]`` from the four rows at `head`."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        head, other, at, *factors = arguments
        multiple = builder.load(_row_at(builder, other, at), align=8)
        for k, factor in enumerate(factors):
            where = _row_at(builder, head, k * BLOCK)
            row = builder.load(where, align=8)
            builder.store(
                minus_product(builder, row, spread(builder, factor, _row), multiple), where, align=8
            )
        return context.get_dummy_value()

    return types.void(_pointer, _pointer, types.int64, *(types.float64,) * 4), code
