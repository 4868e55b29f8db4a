"""Words and digests of the request for a matrix, which distinguish it from other requests."""

import dataclasses
import hashlib
from importlib import metadata
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.analysis.matrix.tasks import EveryVertex, Sets
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["digest", "fingerprint_of_solver", "fingerprint_of_sources", "fingerprint_of_versions"]


def digest(*values: Any) -> str:
    """Return twelve characters that change if any bit of `values` changes.

    Arrays count by type, shape and contents; other objects by their class and their attributes.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.analysis.matrix.fingerprints import digest
    >>> digest(np.arange(3)) == digest(np.arange(3)), digest(np.arange(3)) == digest([0, 1, 2])
    (True, False)
    """
    state = hashlib.sha256()
    for value in values:
        _feed(state, value)
    return state.hexdigest()[:12]


def _feed(state: Any, value: Any) -> None:
    if isinstance(value, np.ndarray) and value.dtype != object:
        state.update(f"array {value.dtype.str} {value.shape} ".encode())
        state.update(np.ascontiguousarray(value).data)
    elif isinstance(value, csr_array):
        _feed(state, [value.shape, value.data, value.indices, value.indptr])
    elif isinstance(value, list | tuple):
        state.update(f"{type(value).__name__} {len(value)} ".encode())
        for item in value:
            _feed(state, item)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        state.update(f"{type(value).__qualname__} ".encode())
        for item in dataclasses.fields(value):
            _feed(state, getattr(value, item.name))
    elif isinstance(value, Domain):  # a plugin's kind; its repr may omit data
        state.update(f"{type(value).__qualname__} ".encode())
        _feed(state, sorted(vars(value).items()))
    else:
        state.update(f"{value!r} ".encode())


def fingerprint_of_solver(solver: GeodesicSolver) -> dict[str, str]:
    """Return by name everything on which distances depend: the shape, the operator, each option.

    Parameters
    ----------
    solver : GeodesicSolver

    Returns
    -------
    dict of str to str
    """
    method = solver.method
    return {
        "shape": f"{solver.domain!r} {digest(solver.domain)}",
        "operator": f"{solver.operator!r} {_of_discretization(method.metric)}",
        "diffusion": f"{solver.diffusion!r} {_of_discretization(method.diffusion)}",
        "time": repr(method.time),
        "boundary": method.boundary,
        "heat solver": repr(method.heat_solver),
        "Poisson solver": repr(method.poisson_solver),
        "refine": "across" if method.across else repr(method.refine),
    }


def _of_discretization(discretization: Discretization) -> str:
    """Return a digest that includes the mask, and options that a repr does not show."""
    kind = type(discretization.gradient).__qualname__
    return digest(discretization.mass, discretization.stiffness, discretization.boundary, kind)


def fingerprint_of_sources(sets: Sets) -> str:
    """Return the number of source sets and their digest."""
    if isinstance(sets, EveryVertex):
        return f"every vertex {digest(sets.vertices)}"
    kind = "vertices" if isinstance(sets, np.ndarray) else "source sets"
    return f"{len(sets)} {kind} {digest(sets)}"


def fingerprint_of_versions() -> str:
    """Return the versions of packages on which the last bit of a distance may depend."""
    names = ("geodesic-toolkit", "numpy", "scipy")
    return ", ".join(f"{name} {metadata.version(name)}" for name in names)
