"""LLVM vectors of numbers, which all vector instructions that are spelled out here share."""

from typing import Any

from llvmlite import ir

__all__ = ["minus_product", "number", "place", "spread", "vector_of", "zeros"]

number = ir.DoubleType()


def vector_of(lanes: int, element: Any = number) -> Any:
    """Return the type of so many numbers side by side."""
    return ir.VectorType(element, lanes)


def zeros(vector: Any) -> Any:
    """Return a vector of zeros."""
    return ir.Constant(vector, [0] * vector.count)


def place(builder: Any, numbers: Any, offset: Any, vector: Any) -> Any:
    """Return the address of the vector that begins `offset` numbers after a pointer."""
    if isinstance(offset, int):
        offset = ir.Constant(ir.IntType(64), offset)
    return builder.bitcast(builder.gep(numbers, [offset]), vector.as_pointer())


def spread(builder: Any, value: Any, vector: Any) -> Any:
    """Return a vector of equal numbers."""
    undefined, first = ir.Constant(vector, ir.Undefined), ir.Constant(ir.IntType(32), 0)
    all_first = zeros(vector_of(vector.count, ir.IntType(32)))
    return builder.shuffle_vector(
        builder.insert_element(undefined, value, first), undefined, all_first
    )


def minus_product(builder: Any, vector: Any, factor: Any, other: Any) -> Any:
    """Return ``vector - factor * other``, rounded once where the machine can."""
    product = builder.fmul(factor, other, ("contract",))
    return builder.fsub(vector, product, ("contract",))
