"""PETSc as a linear solver of geodesic-toolkit, on one process or many."""

from geodesic_toolkit_petsc.processes import peak_memory
from geodesic_toolkit_petsc.solvers import MUMPS, PETSc

__all__ = ["MUMPS", "PETSc", "peak_memory"]
