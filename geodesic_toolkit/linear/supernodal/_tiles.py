"""Arithmetic on tiles: four columns of a few vectors of rows, which registers hold.

Products of thin matrices are most of a factorisation, and three quarters of the matrices have fewer
rows than the kernels of a BLAS are made for. These take rows one vector at a time at their ends,
under a mask, and nothing is copied or padded before.
"""

from typing import Any

import llvmlite.binding
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from geodesic_toolkit.linear.supernodal._vectors import (
    minus_product,
    place,
    spread,
    vector_of,
    zeros,
)

__all__ = ["ACROSS", "LANES", "TALL", "divide_four", "edge_tile", "whole_tile"]

LANES = 8 if llvmlite.binding.get_host_cpu_features().get("avx512f") else 4
"""Numbers in a register. A tile keeps eight sums of as many, which hide how long each takes."""

TALL, ACROSS = 2 * LANES, 4
"""Rows and columns of a whole tile."""

_vector = vector_of(LANES)
_index, _alignment = ir.IntType(64), ir.Constant(ir.IntType(32), 8)
_flags = vector_of(LANES, ir.IntType(1))
_pointer = types.CPointer(types.float64)


def _first(builder: Any, count: Any) -> Any:
    """Return the mask of the first `count` lanes."""
    lanes = vector_of(LANES, _index)
    numbered = ir.Constant(lanes, list(range(LANES)))
    return builder.icmp_signed("<", numbered, spread(builder, count, lanes))


def _load(builder: Any, at: Any, mask: Any) -> Any:
    """Return a vector; where there is a mask, of the lanes in it, without touching the others."""
    if mask is None:
        return builder.load(at, align=8)
    kind = ir.FunctionType(_vector, [at.type, ir.IntType(32), _flags, _vector])
    name = f"llvm.masked.load.v{LANES}f64.p0v{LANES}f64"
    load = cgutils.get_or_insert_function(builder.module, kind, name)
    return builder.call(load, [at, _alignment, mask, zeros(_vector)])


def _store(builder: Any, value: Any, at: Any, mask: Any) -> None:
    if mask is None:
        builder.store(value, at, align=8)
        return
    kind = ir.FunctionType(ir.VoidType(), [_vector, at.type, ir.IntType(32), _flags])
    name = f"llvm.masked.store.v{LANES}f64.p0v{LANES}f64"
    store = cgutils.get_or_insert_function(builder.module, kind, name)
    builder.call(store, [value, at, _alignment, mask])


def _tile(n_vectors: int, *, at_an_edge: bool) -> Any:
    @intrinsic  # type: ignore[untyped-decorator]
    def tile(
        _context: Any,
        _target: Any,
        _at: Any,
        _stride: Any,
        _source: Any,
        _row: Any,
        _column: Any,
        _step: Any,
        _depth: Any,
        _width: Any,
        _count: Any,
        _fresh: Any,
    ) -> Any:
        """Subtract products ``A Bᵀ`` from a tile of `width` columns that begins at ``target[at]``.

        ``A[i, c]`` is ``source[row + c * step + i]``, ``B[j, c]`` is
        ``source[column + c * step + j]``, for `depth` columns c. The tile is taken for zero before
        where `fresh`. At an edge it has `count` rows, or all of one vector.
        """

        def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            target, at, stride, source, row, column, step, depth, width, count, fresh = arguments
            mask = _first(builder, count) if at_an_edge else None
            steps = [ir.Constant(_index, LANES * v) for v in range(n_vectors)]
            sums = [[cgutils.alloca_once(builder, _vector) for _ in steps] for _ in range(ACROSS)]
            for total in (total for column_sums in sums for total in column_sums):
                builder.store(zeros(_vector), total)
            with cgutils.for_range(builder, depth) as loop:
                begin = builder.mul(loop.index, step)
                rows = [
                    _load(builder, place(builder, source, builder.add(top, s), _vector), mask)
                    for top in [builder.add(begin, row)]
                    for s in steps
                ]
                for k in range(ACROSS):
                    at_k = builder.add(builder.add(begin, column), ir.Constant(_index, k))
                    factor = spread(builder, builder.load(builder.gep(source, [at_k])), _vector)
                    for total, values in zip(sums[k], rows, strict=True):
                        product = builder.fmul(factor, values, ("contract",))
                        more = builder.fadd(builder.load(total), product, ("contract",))
                        builder.store(more, total)
            for k in range(ACROSS):
                with builder.if_then(builder.icmp_signed(">", width, ir.Constant(_index, k))):
                    begin = builder.add(at, builder.mul(stride, ir.Constant(_index, k)))
                    for total, s in zip(sums[k], steps, strict=True):
                        where = place(builder, target, builder.add(begin, s), _vector)
                        before = _load(builder, where, mask)
                        before = builder.select(fresh, zeros(_vector), before)
                        after = builder.fsub(before, builder.load(total))
                        _store(builder, after, where, mask)
            return context.get_dummy_value()

        index = types.int64
        return types.void(_pointer, index, index, _pointer, *(index,) * 6, types.boolean), code

    return tile


whole_tile = _tile(TALL // LANES, at_an_edge=False)
edge_tile = _tile(1, at_an_edge=True)


@intrinsic  # type: ignore[untyped-decorator]
def divide_four(
    _context: Any,
    _panel: Any,
    _begin: Any,
    _count: Any,
    _p: Any,
    _q: Any,
    _r: Any,
    _s: Any,
    _triangle: Any,
) -> Any:
    """Replace the rows X of four columns by ``X L⁻ᵀ``.

    The columns are those at the places p, q, r, s of `panel`, from row `begin` on. L is given by
    rows, with the inverse of its diagonal. Of columns that are the same the first one counts.
    """

    def code(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        panel, begin, count, *columns, triangle = arguments
        entries = iter(cgutils.unpack_tuple(builder, triangle))
        lower = [[spread(builder, next(entries), _vector) for _ in range(k + 1)] for k in range(4)]
        zero, step = ir.Constant(_index, 0), ir.Constant(_index, LANES)
        with cgutils.for_range_slice(builder, zero, count, step, inc=True) as (k, _):
            mask = _first(builder, builder.sub(count, k))
            row = builder.add(begin, k)
            places = [
                place(builder, panel, builder.add(column, row), _vector) for column in columns
            ]
            solved: list[Any] = []
            for where, (*factors, inverse) in zip(places, lower, strict=True):
                value = _load(builder, where, mask)
                for factor, x in zip(factors, solved, strict=True):
                    value = minus_product(builder, value, factor, x)
                solved.append(builder.fmul(value, inverse))
            for where, value in zip(reversed(places), reversed(solved), strict=True):
                _store(builder, value, where, mask)
        return context.get_dummy_value()

    triangle = types.UniTuple(types.float64, 10)
    return types.void(_pointer, *(types.int64,) * 6, triangle), code
