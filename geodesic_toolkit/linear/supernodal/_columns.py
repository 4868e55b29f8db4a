"""Arithmetic on four neighbouring columns of a panel, several rows at once.

Most panels have a handful of rows, and what compilers make of such short loops is a vector loop
that is passed by and a scalar one that does the work. So the vector instructions are spelled out.
The last of them reaches past the end of a column: what it reads there is a number, of the next
column or panel, and what becomes of it is not used.

The rows of x lie together (`minus_columns`, `dot_columns`) or where a list says (`minus_rows`,
`dot_rows`). The list is read past its end too, and what it says there is replaced by one more row.
"""

from collections.abc import Iterator
from contextlib import contextmanager
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
    zeros,
)
from geodesic_toolkit.linear.supernodal.analysis import LANES

__all__ = ["dot_columns", "dot_rows", "minus_columns", "minus_rows"]

_index = ir.IntType(64)
_vector = vector_of(LANES)
_bits, _uppers = vector_of(LANES, ir.IntType(64)), vector_of(LANES, ir.IntType(32))
_shift = ir.Constant(_bits, [32] * LANES)


def _loaded(builder: Any, factor: Any, offset: Any) -> Any:
    """Return some numbers of a factor, or of the upper halves that are left of them."""
    if factor.type.pointee == number:
        return builder.load(place(builder, factor, offset, _vector), align=8)
    upper = builder.load(place(builder, factor, offset, _uppers), align=4)
    return builder.bitcast(builder.shl(builder.zext(upper, _bits), _shift), _vector)


@contextmanager
def _steps(builder: Any, count: Any) -> Iterator[Any]:
    """Loop over `count` numbers, LANES at a time."""
    zero, step = ir.Constant(_index, 0), ir.Constant(_index, LANES)
    with cgutils.for_range_slice(builder, zero, count, step, inc=True) as (k, _):
        yield k


def _listed(  # noqa: PLR0917 - as its callers have them
    builder: Any, x: Any, rows: Any, k: Any, count: Any, spare: Any
) -> list[Any]:
    """Return the addresses of LANES numbers of x, by a list of `count` rows from its place k on."""
    addresses = []
    for lane in range(LANES):
        at = builder.add(k, ir.Constant(_index, lane))
        row = builder.sext(builder.load(builder.gep(rows, [at])), _index)
        inside = builder.icmp_signed("<", at, count)
        addresses.append(builder.gep(x, [builder.select(inside, row, spare)]))
    return addresses


def _combined(builder: Any, factor: Any, columns: Any, k: Any, multiples: Any) -> Any:
    """Return the sum of multiples of the columns, from their row k on."""
    total = None
    for column, multiple in zip(columns, multiples, strict=True):
        values = _loaded(builder, factor, builder.add(column, k))
        product = builder.fmul(values, multiple, ("contract",))
        total = product if total is None else builder.fadd(total, product, ("contract",))
    return total


def _dots(builder: Any, count: Any, factor: Any, columns: Any, x_from: Any) -> list[Any]:
    """Return the dot products of columns with the vectors that `x_from` gives, row by row."""
    sums = [cgutils.alloca_once_value(builder, zeros(_vector)) for _ in columns]
    for total in sums:  # the line above sets it once, and this may be a loop
        builder.store(zeros(_vector), total)
    with _steps(builder, count) as k:
        rows = x_from(k)
        for column, total in zip(columns, sums, strict=True):
            values = _loaded(builder, factor, builder.add(column, k))
            product = builder.fmul(values, rows, ("contract",))
            builder.store(builder.fadd(builder.load(total), product, ("contract",)), total)
    kind = ir.FunctionType(number, [number, _vector])
    name = f"llvm.vector.reduce.fadd.v{LANES}f64"
    add_up = cgutils.get_or_insert_function(builder.module, kind, name)
    nothing = ir.Constant(number, -0.0)
    return [
        builder.call(add_up, [nothing, builder.load(total)], fastmath=("reassoc",))
        for total in sums
    ]


@intrinsic  # type: ignore[untyped-decorator]
def minus_columns(
    _context: Any,
    target: Any,
    _begin: Any,
    _count: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
    _x0: Any,
    _x1: Any,
    _x2: Any,
    _x3: Any,
) -> Any:
    """Subtract four columns from ``target[begin:begin + count]``, and spoil up to 3 numbers behind.

    The columns begin at the places p, q, r, s of the factor and are taken x0, x1, x2, x3 times.
    """

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, begin, count, factor, *rest = arguments
        columns, multiples = rest[:4], [spread(builder, x, _vector) for x in rest[4:]]
        with _steps(builder, count) as k:
            where = place(builder, target, builder.add(begin, k), _vector)
            rows = builder.load(where, align=8)
            for column, x in zip(columns, multiples, strict=True):
                values = _loaded(builder, factor, builder.add(column, k))
                rows = minus_product(builder, rows, values, x)
            builder.store(rows, where, align=8)
        return context.get_dummy_value()

    places, values = (types.int64,) * 4, (types.float64,) * 4
    return types.void(target, types.int64, types.int64, factor, *places, *values), code


@intrinsic  # type: ignore[untyped-decorator]
def dot_columns(
    _context: Any,
    x: Any,
    _begin: Any,
    _count: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
) -> Any:
    """Return the dot products of ``x[begin:begin + count]`` with four columns.

    They begin at the places p, q, r, s of the factor. Behind its end x must have 3 zeros.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        x, begin, count, factor, *columns = arguments

        def together(k: Any) -> Any:
            return builder.load(place(builder, x, builder.add(begin, k), _vector), align=8)

        dots = _dots(builder, count, factor, columns, together)
        return context.make_tuple(builder, signature.return_type, dots)

    places = (types.int64,) * 4
    dots = types.UniTuple(types.float64, 4)
    return dots(x, types.int64, types.int64, factor, *places), code


@intrinsic  # type: ignore[untyped-decorator]
def minus_rows(
    _context: Any,
    x: Any,
    rows: Any,
    _count: Any,
    _spare: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
    _x0: Any,
    _x1: Any,
    _x2: Any,
    _x3: Any,
) -> Any:
    """Subtract four columns from ``x[rows[:count]]``, and something from ``x[spare]``.

    The columns begin at the places p, q, r, s of the factor and are taken x0, x1, x2, x3 times.
    """

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        x, rows, count, spare, factor, *rest = arguments
        columns, multiples = rest[:4], [spread(builder, value, _vector) for value in rest[4:]]
        with _steps(builder, count) as k:
            less = _combined(builder, factor, columns, k, multiples)
            for lane, where in enumerate(_listed(builder, x, rows, k, count, spare)):
                own = builder.extract_element(less, ir.Constant(ir.IntType(32), lane))
                builder.store(builder.fsub(builder.load(where), own), where)
        return context.get_dummy_value()

    places, values = (types.int64,) * 4, (types.float64,) * 4
    return types.void(x, rows, types.int64, types.int64, factor, *places, *values), code


@intrinsic  # type: ignore[untyped-decorator]
def dot_rows(
    _context: Any,
    x: Any,
    rows: Any,
    _count: Any,
    _spare: Any,
    factor: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
) -> Any:
    """Return the dot products of ``x[rows[:count]]`` with four columns; ``x[spare]`` must be 0.

    They begin at the places p, q, r, s of the factor.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        x, rows, count, spare, factor, *columns = arguments

        def listed(k: Any) -> Any:
            values = ir.Constant(_vector, ir.Undefined)
            for lane, where in enumerate(_listed(builder, x, rows, k, count, spare)):
                at = ir.Constant(ir.IntType(32), lane)
                values = builder.insert_element(values, builder.load(where), at)
            return values

        dots = _dots(builder, count, factor, columns, listed)
        return context.make_tuple(builder, signature.return_type, dots)

    places = (types.int64,) * 4
    dots = types.UniTuple(types.float64, 4)
    return dots(x, rows, types.int64, types.int64, factor, *places), code
