"""The option ``--weld``: compute on merged vertices, report those of the file."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.cli.arguments import MarkedVertices
    from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
    from geodesic_toolkit.domains import Domain

__all__ = ["Welded", "read_welded", "welded"]


@dataclass(frozen=True)
class Welded:
    """A shape as read, and the shape with merged vertices.

    Attributes
    ----------
    file : Domain
        The shape as read.
    domain : Domain
        The same, or with merged vertices.
    new : ndarray of shape (N,), int64, optional
        The vertex of `domain` for each vertex of the file, if they differ.
    """

    file: "Domain"
    domain: "Domain"
    new: "IntArray | None" = None

    def sources(
        self, sources: list[int] | list[list[float]], masked: "BoolArray | None" = None
    ) -> "list[list[float]] | IntArray | list[int]":
        """Return sources of the file as sources on the domain, whose vertices differ."""
        if self.new is None or not isinstance(sources[0], int):
            return sources
        return self.vertices(sources, masked)

    def vertices(
        self,
        vertices: "IntArray | list[int] | list[list[float]]",
        masked: "BoolArray | None" = None,
    ) -> "IntArray":
        """Return vertices of the file, (K,), as vertices of the domain.

        Raises
        ------
        InvalidSourceError
            A vertex that is not in the file, or that is `masked`, (N,), in the domain: the message
            has the index in the file.
        """
        from geodesic_toolkit.sources.points import as_vertices

        known = as_vertices(vertices, self.file.n_vertices)
        if self.new is None:
            return known
        new = self.new[known]
        if masked is not None and masked[new].any():
            raise InvalidSourceError(
                f"vertex {known[masked[new]][0]} is masked, or a vertex merged with it is, so that "
                "no path starts there"
            )
        return new

    def firsts(self, vertices: "IntArray") -> "IntArray":
        """Return the first vertex of the file merged into each vertex of the domain, (K,)."""
        import numpy as np

        if self.new is None:
            return vertices
        return np.asarray(np.unique(self.new, return_index=True)[1][vertices], dtype=np.int64)

    def mask(self, mask: "BoolArray | None") -> "BoolArray | None":
        """Return a mask of the file's vertices on the domain: masked if any merged vertex is."""
        import numpy as np

        if mask is None or self.new is None:
            return mask
        own = np.zeros(self.domain.n_vertices, dtype=np.bool_)
        own[self.new[mask]] = True
        return own

    def values(self, values: "FloatArray") -> "FloatArray":
        """Return values at the vertices of the domain as values at those of the file, (N,)."""
        return values if self.new is None else values[self.new]

    def with_cost(self, cost: Path | None) -> "Welded":
        """Return the shape with the costs of a file on its faces or vertices, if there is one.

        Raises
        ------
        InvalidOptionError
            The shape is not a mesh.
        ReadError, InvalidDomainError
            The file has no numbers, or they are not costs of its faces or vertices.
        """
        if cost is None:
            return self
        import numpy as np

        from geodesic_toolkit.domains import MetricMesh, TriangleMesh
        from geodesic_toolkit.io import read_values

        if not isinstance(self.domain, TriangleMesh):
            raise InvalidOptionError(
                f"--cost is for faces or vertices of a mesh; the input is {a_kind_of(self.domain)}"
            )
        values = read_values(cost, "cost")
        if self.new is not None and len(values) == self.file.n_vertices:
            values = values[self.firsts(np.arange(self.domain.n_vertices))]
        return replace(self, domain=MetricMesh(self.domain, cost=values))

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Rows of names and values for a table."""
        shape = ("shape", repr(self.file))
        if self.new is None:
            return [shape]
        welded = f"{self.file.n_vertices} vertices to {self.domain.n_vertices}"
        return [shape, ("welded", welded)]


def welded(domain: "Domain", weld: float | None, run: Run) -> Welded:
    """Return a shape with vertices merged that are no farther apart than `weld`, if it is given.

    The run notes the number of merged vertices, and warns if there are none.

    Raises
    ------
    InvalidOptionError
        The shape to weld is not a mesh, or the tolerance is more than its size.
    """
    if weld is None:
        return Welded(domain, domain)
    from geodesic_toolkit.domains import TriangleMesh
    from geodesic_toolkit.interop.merging import merge_vertices

    if not isinstance(domain, TriangleMesh):
        raise InvalidOptionError(
            f"--weld merges vertices of a mesh; the input is {a_kind_of(domain)}"
        )
    shape = Welded(domain, *merge_vertices(domain, tolerance=weld))
    merged = domain.n_vertices - shape.domain.n_vertices
    if merged:
        run.note(f"--weld {weld:g} merged {merged} of {domain.n_vertices} vertices into others")
    else:
        run.warn(
            f"--weld {weld:g} merged none of the {domain.n_vertices} vertices: no two of different "
            "features are so close"
        )
    return shape


def read_welded(
    path: Path,
    weld: float | None,
    run: Run,
    *,
    mask: "MarkedVertices | None" = None,
    kinds: "tuple[type[Domain], ...]" = (),
) -> "tuple[Welded, BoolArray | None]":
    """Return the shape of a file, see :func:`welded`, and the mask of its vertices, if any.

    Raises
    ------
    ReadError
        A file cannot be read.
    InvalidOptionError
        See :func:`welded`.
    """
    from geodesic_toolkit.io import read

    shape = welded(read(path, kinds=kinds), weld, run)
    return shape, shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
