"""What Numba is told of kernels and of their parts."""

import gc

import numba
import pytest
from numba import types

from geodesic_toolkit._compiled import kernel, part


@pytest.mark.parametrize("inline", [False, True])
def test_a_part_is_called_by_kernels_and_from_python(inline):
    @part(inline=inline)
    def squared(x):
        return x * x

    def fourth(x):
        return squared(squared(x))

    assert numba.njit(fourth)(3) == 81
    assert squared(3) == 9


@pytest.mark.parametrize("collecting", [True, False])
def test_garbage_is_looked_for_after_compilation_if_it_was_before(collecting):
    def unknown(x):
        return x.missing

    try:
        gc.enable() if collecting else gc.disable()
        assert kernel(types.int64(types.int64))(lambda x: x + 1)(1) == 2
        assert gc.isenabled() == collecting
        with pytest.raises(numba.TypingError):
            kernel(types.int64(types.int64))(unknown)
        assert gc.isenabled() == collecting
    finally:
        gc.enable()


def test_a_kernel_without_signatures_is_compiled_when_it_is_called():
    later = kernel()(lambda x: x + 1)
    assert not later.signatures
    assert later(1.5) == 2.5
    assert later.signatures
