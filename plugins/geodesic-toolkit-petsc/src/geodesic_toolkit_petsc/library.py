"""PETSc and MPI, by way of petsc4py and mpi4py: the only place that imports them."""

from __future__ import annotations

import importlib
import multiprocessing
import os
from dataclasses import dataclass
from functools import cache
from typing import Any

from geodesic_toolkit.errors import MissingDependencyError, SolverError

__all__ = ["Library", "library"]

ADVICE = (
    "on Debian and Ubuntu: apt-get install libpetsc-real-dev openmpi-bin, then build petsc4py of "
    "the same release, as the README of geodesic-toolkit-petsc says; if they are installed, start "
    "several processes with the mpiexec of PETSc's MPI"
)

SIZES_OF_JOB = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")
"""Environment variables of Open MPI's and MPICH's mpiexec that have the number of processes."""

ARGUMENTS = ["geodesic-toolkit", "-no_signal_handler", "-skip_petscrc"]
"""Arguments of PETSc: signals are Python's, and a file in the home folder changes no result."""


@dataclass(frozen=True)
class Library:
    """The modules of petsc4py and mpi4py, after MPI was started.

    Attributes
    ----------
    petsc, mpi : module
    communicator : mpi4py.MPI.Comm
        All processes that mpiexec started, apart from messages of PETSc and of other code.
    """

    petsc: Any
    mpi: Any
    communicator: Any


@cache
def library() -> Library:
    """Return PETSc and MPI, which the first call starts.

    Raises
    ------
    MissingDependencyError
        petsc4py or mpi4py is not installed, or does not load.
    SolverError
        mpiexec started several processes, but belongs to another MPI than PETSc; or this is a
        process of a pool in one of several processes.
    """
    size = max((int(os.environ.get(name, "1")) for name in SIZES_OF_JOB), default=1)
    if size > 1 and multiprocessing.parent_process() is not None:
        raise SolverError(
            f"a process of a pool cannot use PETSc in a job of {size} processes: use a job without "
            "a pool, or a pool without mpiexec"
        )
    # Open MPI would keep a processor busy while it waits, and others may need it. Where processes
    # outnumber processors, systems of 10,000 unknowns are solved 5 times as fast with this.
    os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")
    try:
        # PETSc first: mpi4py then takes the MPI that PETSc has loaded, and not one of its own.
        importlib.import_module("petsc4py").init(ARGUMENTS)
        petsc = importlib.import_module("petsc4py.PETSc")
        mpi = importlib.import_module("mpi4py.MPI")
    except ImportError as error:
        raise MissingDependencyError(
            f"the solver needs petsc4py and mpi4py ({error}); {ADVICE}"
        ) from error
    world = mpi.COMM_WORLD
    if world.Get_size() == 1 < size:
        name = mpi.Get_library_version().split(",")[0].split("\n")[0]
        raise SolverError(
            f"mpiexec started {size} processes that do not find each other: PETSc uses {name}; "
            "start them with the mpiexec of that MPI"
        )
    return Library(petsc, mpi, world.Dup())
