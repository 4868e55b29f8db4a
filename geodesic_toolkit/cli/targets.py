"""The files that a command writes: checked before the work, written after it."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidOptionError

if TYPE_CHECKING:
    from geodesic_toolkit.core.types import FloatArray
    from geodesic_toolkit.domains import Domain

__all__ = ["Targets"]


@dataclass(frozen=True, kw_only=True)
class Targets:
    """The output files of a command.

    Parameters
    ----------
    tables : tuple of Path
        Files of numbers; the suffix chooses the format.
    check_table : callable, optional
        Raises if such a file could not be written: for distances, unless given.
    picture, html : Path, optional
    parts : Path, optional
        Picture of the components.
    cmap : str, optional
        Colour map of picture and page; None for their defaults.
    """

    tables: tuple[Path, ...] = ()
    check_table: Callable[[Path], object] | None = None
    picture: Path | None = None
    html: Path | None = None
    parts: Path | None = None
    cmap: str | None = None

    @property
    def paths(self) -> list[Path]:
        """All output files, in the order in which they are written."""
        drawn = (self.picture, self.html, self.parts)
        return [*self.tables, *(path for path in drawn if path is not None)]

    @property
    def drawn(self) -> bool:
        """True if there is a picture or page to draw."""
        return len(self.paths) > len(self.tables)

    def of_each(self, inputs: Sequence[Path], *used: Path) -> "dict[Path, Targets]":
        """Return the targets of each input, checked: with its name in place of ``{name}``.

        Parameters
        ----------
        inputs : sequence of Path
        *used : Path
            Other files that no output may overwrite.

        Raises
        ------
        InvalidOptionError
            Several inputs have one output; and see :meth:`check`.
        WriteError, MissingDependencyError
            See :meth:`check`.
        """
        each = {path: self._named(_name_of(path)) for path in inputs}
        if len(each) < len(inputs):
            twice = next(path for path in inputs if inputs.count(path) > 1)
            raise InvalidOptionError(f"{twice} is given several times")
        taken = {path.resolve() for path in (*inputs, *used)}
        seen: dict[Path, Path] = {}
        for path, targets in each.items():
            targets.check(taken)
            for output in targets.paths:
                first = seen.setdefault(output.resolve(), path)
                if first != path:
                    raise InvalidOptionError(
                        f"{output} would be the output of {first} and of {path}; write "
                        "{name} where the names of outputs differ, as in {name}.npy, and run "
                        "inputs of the same name in commands of their own"
                    )
        return each

    def _named(self, name: str) -> "Targets":
        def named(path: Path | None) -> Path | None:
            return None if path is None else Path(str(path).replace("{name}", name))

        return replace(
            self,
            tables=tuple(Path(str(path).replace("{name}", name)) for path in self.tables),
            picture=named(self.picture),
            html=named(self.html),
            parts=named(self.parts),
        )

    def check(self, taken: Collection[Path] = ()) -> None:
        """Raise, before any work, if a file could not be written after it.

        Parameters
        ----------
        taken : collection of Path
            Resolved paths of files that no output may overwrite.

        Raises
        ------
        InvalidOptionError
            A suffix that does not fit, an unknown colour map, two outputs in one file, or an
            output that is `taken`.
        WriteError
            A folder that does not exist or is not writable.
        MissingDependencyError
            A package for colour maps, or for a format, is not installed.
        """
        from geodesic_toolkit.io import check_output
        from geodesic_toolkit.io.writing import check_distance_output

        seen: set[Path] = set()
        for path in self.paths:
            file = path.resolve()
            if file in taken or file in seen:
                other = "the input" if file in taken else "another output"
                raise InvalidOptionError(f"{path} would overwrite {other}")
            seen.add(file)
        for path in self.tables:
            (self.check_table or check_distance_output)(path)
        for picture in (self.picture, self.parts):
            if picture is not None:
                check_output(picture, (".png",))
        if self.html is not None:
            check_output(self.html, (".html",))
        if self.cmap is not None:
            from geodesic_toolkit.viz.colours import colour_table

            colour_table(self.cmap)

    def check_domain(self, domain: "Domain") -> None:
        """Raise an `InvalidOptionError` if a file needs positions and `domain` has none."""
        from geodesic_toolkit.io.writing import WITH_SHAPE

        if not domain.has("positions"):
            for path in self.paths:
                if path.suffix.lower() in (*WITH_SHAPE, ".png", ".html"):
                    raise InvalidOptionError(
                        f"{path}: {a_kind_of(domain)} has no positions to draw or to write; "
                        "use .npy, .csv or .txt"
                    )

    def load_graphics(self) -> None:
        """Import the graphics packages, so that a missing one is found before the work.

        Raises
        ------
        MissingDependencyError
            A package is not installed, or does not import.
        """
        from geodesic_toolkit.core.optional import require

        if self.picture is not None or self.parts is not None:
            require("pyvista", "viz", "Pictures need")
        if self.html is not None:
            require("k3d", "viz", "HTML pages need")

    def write(
        self,
        run: Run,
        domain: "Domain",
        distances: "FloatArray",
        sources: Sequence[int] | Sequence[Sequence[float]],
        /,  # pictures of two sides have `sources` of their own in their look
        *,
        parts: "FloatArray | None" = None,
        asked: "tuple[Domain, FloatArray] | None" = None,
        like: Path | None = None,
        **look: Any,
    ) -> None:
        """Write distances: numbers first, so that they are safe if a picture fails.

        Parameters
        ----------
        run : Run
        domain : Domain
        distances : ndarray of shape (N,)
        sources : sequence
        parts : ndarray of shape (N,), optional
            Result of :func:`geodesic_toolkit.viz.by_part`, if a picture of components is requested.
        asked : tuple, optional
            Points and the distances there, for the tables; pictures still show the `domain`.
        like : Path, optional
            The file of the points of the tables, whose attributes are kept.
        **look
            Further options of picture and page.

        Raises
        ------
        WriteError
            A file could not be written.
        MissingDependencyError
            A package for pictures is not installed.
        """
        if self.tables:
            from geodesic_toolkit.io import write

            with run.step("writing"):
                for path in self.tables:
                    if asked is None:
                        write(path, domain, distances, sources=sources, like=like)
                    else:
                        write(path, *asked, like=like)
        if self.drawn:
            from geodesic_toolkit import viz

            look = {"sources": sources, **look}
            if self.cmap is not None:
                look["cmap"] = self.cmap
            with run.step("rendering"):
                if self.picture is not None:
                    viz.plot(domain, distances, path=self.picture, **look)
                if self.html is not None:
                    viz.save_html(domain, distances, self.html, **look)
                if self.parts is not None and parts is not None:
                    viz.plot(domain, parts, path=self.parts, sources=sources, **viz.OF_PARTS)


def _name_of(path: Path) -> str:
    """Return the name of a file without its suffix, and without the one of a compressed file."""
    return (path.with_suffix("") if path.suffix.lower() == ".gz" else path).stem
