"""The laws of linear solvers, on those of this plugin."""

import pytest

import geodesic_toolkit as gt

pytest.importorskip("petsc4py", reason="petsc4py is not installed: see the README")

from geodesic_toolkit_petsc import MUMPS, PETSc

SOLVERS = [PETSc(), PETSc(preconditioner="gamg"), MUMPS()]


def laws():
    return [
        pytest.param(law, id=f"{number}-{law}")
        for number, solver in enumerate(SOLVERS)
        for law in gt.testing.linear_solver_checks(solver)
    ]


@pytest.mark.parametrize("law", laws())
def test_the_contract_of_linear_solvers_holds(law):
    law()
