"""The contract of a writer: distances on certain kinds of domain, in files of one suffix."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain

__all__ = ["Writer"]


@dataclass(frozen=True)
class Writer:
    """The files of one suffix in which a plugin writes distances on its kinds of domain.

    :func:`write` and the command line call it. It is registered in ``gt.writers`` under the suffix
    without the dot, by an entry point of the group ``geodesic_toolkit.writers``.

    Parameters
    ----------
    write : callable
        ``write(path, domain, distances)`` fills an existing, empty file, which then replaces the
        output. `distances` are float64, of shape (N,), and may be ``inf``.
    domains : tuple of types
        Kinds of domain that it takes, other than those of the core in formats of the core.
    packages : tuple of str, optional
        Modules that it imports, which are not dependencies of its distribution. A missing one is
        found before the work.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> def write_column(path, graph, distances):
    ...     np.savetxt(path, distances, "%g", header=f"{len(graph.edges)} edges")
    >>> gt.writers.register("column", gt.Writer(write_column, (gt.Graph,)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "distance.column")
    ...     gt.write(file, gt.Graph(2, [[0, 1]]), [0, 1])
    ...     print(file.read_text(), end="")
    # 1 edges
    0
    1
    >>> gt.writers.unregister("column")
    """

    write: Callable[[Path, Any, FloatArray], object]
    domains: tuple[type[Domain], ...]
    packages: tuple[str, ...] = ()

    @property
    def kinds(self) -> str:
        """The names of the kinds of domain that it takes."""
        return " or ".join(kind.__name__ for kind in self.domains)
