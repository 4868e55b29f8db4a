"""Linear solvers with one fault each, by the law of the contract that it breaks."""

import threading
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt


class Tricked(gt.Factor):
    """The factor of SuperLU with a fault."""

    def __init__(self, base, matrix, fault):
        self.base = base
        self.matrix = matrix
        self.fault = fault
        self.solves = 0

    def solve(self, b):
        self.solves += 1
        solution = self.base.solve(b)
        if self.fault == "inaccurate":
            return solution * (1 + 1e-5)
        if self.fault == "first column counts" and b.ndim == 2:
            return solution * (1 + 1e-9 * np.arange(b.shape[1]))
        if self.fault == "single precision":
            return solution.astype(np.longdouble)
        if self.fault == "memory order" and not b.flags.c_contiguous:
            return solution * (1 + 1e-9)
        if self.fault == "wears out":
            return solution * (1 + 1e-11 * self.solves)
        if self.fault == "threads" and threading.current_thread() is not threading.main_thread():
            return solution * (1 + 1e-9)
        if self.fault == "coarse":
            return solution + 1e-14 * np.abs(solution).max(initial=0.0)
        return solution

    @property
    def nnz(self):
        return self.base.nnz

    @property
    def nbytes(self):
        return 0 if self.fault == "weightless" else self.base.nbytes


@dataclass(frozen=True, kw_only=True)
class WrongSolver(gt.LinearSolver):
    """SuperLU with one fault."""

    fault: str = "none"

    componentwise: ClassVar = True

    def factorize(self, matrix):
        if self.fault == "regularised":
            hollow = np.where(abs(matrix).sum(axis=1) > 0, 0.0, 1.0)
            matrix = csr_array(matrix + diags_array(hollow))
        return Tricked(gt.SuperLU().factorize(matrix), matrix, self.fault)


@dataclass(frozen=True, kw_only=True)
class Hesitant(WrongSolver):
    componentwise: ClassVar = "perhaps"


class Rigid(gt.Analysis):
    """The analysis of a matrix that remembers its values, and knows no others."""

    def __init__(self, factor):
        self.factor = factor

    def factorize(self, matrix):
        return self.factor


@dataclass(frozen=True, kw_only=True)
class RigidSolver(WrongSolver):
    def analyse(self, pattern):
        return Rigid(self.factorize(pattern))


@dataclass(frozen=True, kw_only=True)
class DemandingSolver(WrongSolver):
    mandatory: int


@dataclass(frozen=True, kw_only=True)
class NeverEqualSolver(WrongSolver):
    __eq__ = object.__eq__
    __hash__ = object.__hash__


@dataclass(frozen=True, kw_only=True)
class SecretiveSolver(WrongSolver):
    def __repr__(self):
        return "a solver"


@dataclass(frozen=True, kw_only=True)
class HomesickSolver(WrongSolver):
    distance_travelled: int = 0

    def __reduce__(self):
        return travelled_solver, (self.distance_travelled,)


def travelled_solver(distance):
    return HomesickSolver(distance_travelled=distance + 1)


@dataclass(frozen=True, kw_only=True)
class Modest(WrongSolver):
    known_failures: ClassVar = {"factor_tells_its_size": "it is a view"}


WRONG_SOLVERS = {
    "recipe_is_frozen_data": DemandingSolver(mandatory=1),
    "equal_recipes_are_equal": NeverEqualSolver(),
    "recipe_survives_pickling": HomesickSolver(),
    "repr_says_what_it_is": SecretiveSolver(),
    "componentwise_is_declared": Hesitant(),
    "solution_solves_the_system": WrongSolver(fault="inaccurate"),
    "analysis_serves_any_matrix": RigidSolver(),
    "blocks_equal_their_columns": WrongSolver(fault="first column counts"),
    "result_is_a_fresh_float64_array": WrongSolver(fault="single precision"),
    "memory_order_does_not_matter": WrongSolver(fault="memory order"),
    "factor_can_be_used_again": WrongSolver(fault="wears out"),
    "factor_is_safe_from_threads": WrongSolver(fault="threads"),
    "factor_tells_its_size": WrongSolver(fault="weightless"),
    "tiny_entries_are_resolved": WrongSolver(fault="coarse"),
    "singular_matrices_are_refused": WrongSolver(fault="regularised"),
}

IMPLIED_BY_SOLVERS = {
    "solution_solves_the_system": {"analysis_serves_any_matrix", "tiny_entries_are_resolved"},
    # A change from one solve to the next is a change between a block and its columns, too.
    "factor_can_be_used_again": {
        "blocks_equal_their_columns",
        "memory_order_does_not_matter",
        "factor_is_safe_from_threads",
    },
    # Every second column of a block is at another place in the narrower block.
    "blocks_equal_their_columns": {"memory_order_does_not_matter", "factor_can_be_used_again"},
    # A column taken out of a block is not contiguous.
    "memory_order_does_not_matter": {"blocks_equal_their_columns", "factor_can_be_used_again"},
}
