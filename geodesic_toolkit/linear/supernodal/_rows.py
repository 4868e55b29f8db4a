"""Arithmetic on rows of a block of right-hand sides, each row as one vector of the machine.

Compilers vectorise such short loops only where they can prove that a row does not overlap what it
is changed by, and they cannot. So the vector instructions are spelled out; LLVM splits a row into
as many registers as it takes. Rows are given by a pointer and an offset, or by a list: the row
``rows[i]`` of x begins at ``x[rows[i] * BLOCK]``.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from geodesic_toolkit.linear.supernodal._vectors import (
    minus_product,
    number,
    place,
    spread,
    vector_of,
)

__all__ = ["BLOCK", "copy_row", "four_minus_rows", "minus_one", "rows_minus_four"]

BLOCK = 16
"""Right-hand sides solved at once: a row of them is two cache lines."""

_row = vector_of(BLOCK)
_index = ir.IntType(64)
_pointer = types.CPointer(types.float64)
_four_places = (types.int64,) * 4


def _row_at(builder: Any, pointer: Any, offset: Any) -> Any:
    """Return the address of the row that begins `offset` numbers after a pointer."""
    return place(builder, pointer, offset, _row)


def _four_rows(builder: Any, head: Any) -> list[Any]:
    """Return the addresses of the four rows at `head`."""
    return [_row_at(builder, head, k * BLOCK) for k in range(4)]


def _listed(builder: Any, x: Any, rows: Any, i: Any) -> Any:
    """Return the address of the row of x that stands at place i of a list."""
    row = builder.sext(builder.load(builder.gep(rows, [i])), _index)
    return _row_at(builder, x, builder.mul(row, ir.Constant(_index, BLOCK)))


def _spread_from(builder: Any, factor: Any, offset: Any) -> Any:
    """Return a row of one number of a factor, or of the number of which an upper half is left."""
    value = builder.load(builder.gep(factor, [offset]))
    if value.type == number:
        return spread(builder, value, _row)
    twice = vector_of(2 * BLOCK, value.type)
    uppers = ir.Constant(twice, [0, -1] * BLOCK)
    return builder.bitcast(builder.and_(spread(builder, value, twice), uppers), _row)


@intrinsic  # type: ignore[untyped-decorator]
def copy_row(_context: Any, _target: Any, _at: Any, _other: Any, _begin: Any) -> Any:
    """Write the row ``other[begin:]`` to the row ``target[at:]``."""

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, at, other, begin = arguments
        row = builder.load(_row_at(builder, other, begin), align=8)
        builder.store(row, _row_at(builder, target, at), align=8)
        return context.get_dummy_value()

    return types.void(_pointer, types.int64, _pointer, types.int64), code


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
def rows_minus_four(
    _context: Any,
    x: Any,
    rows: Any,
    _count: Any,
    head: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
) -> Any:
    """Subtract multiples of the four rows at `head` from the rows of x that a list says.

    The multiples begin at the places p, q, r, s of the factor.
    """

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        x, rows, count, head, factor, *columns = arguments
        known = [builder.load(where, align=8) for where in _four_rows(builder, head)]
        with cgutils.for_range(builder, count) as loop:
            where = _listed(builder, x, rows, loop.index)
            row = builder.load(where, align=8)
            for column, other in zip(columns, known, strict=True):
                multiple = _spread_from(builder, factor, builder.add(column, loop.index))
                row = minus_product(builder, row, multiple, other)
            builder.store(row, where, align=8)
        return context.get_dummy_value()

    return types.void(x, rows, types.int64, head, factor, *_four_places), code


@intrinsic  # type: ignore[untyped-decorator]
def four_minus_rows(
    _context: Any,
    head: Any,
    x: Any,
    rows: Any,
    _count: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
) -> Any:
    """Subtract multiples of the rows of x that a list says from the four rows at `head`.

    The multiples begin at the places p, q, r, s of the factor. Until the end of the list the four
    rows are in registers.
    """

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        head, x, rows, count, factor, *columns = arguments
        places = _four_rows(builder, head)
        sums = [cgutils.alloca_once(builder, _row) for _ in places]
        for where, total in zip(places, sums, strict=True):
            builder.store(builder.load(where, align=8), total)
        with cgutils.for_range(builder, count) as loop:
            row = builder.load(_listed(builder, x, rows, loop.index), align=8)
            for column, total in zip(columns, sums, strict=True):
                multiple = _spread_from(builder, factor, builder.add(column, loop.index))
                builder.store(minus_product(builder, builder.load(total), multiple, row), total)
        for where, total in zip(places, sums, strict=True):
            builder.store(builder.load(total), where, align=8)
        return context.get_dummy_value()

    return types.void(head, x, rows, types.int64, factor, *_four_places), code
