"""The format of an output of distances: by its suffix, and by the kind of domain."""

import os
from pathlib import Path

from geodesic_toolkit.core.atomic import as_path, check_output
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, Graph, MeasuredFaces, PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.io.common import optional_package
from geodesic_toolkit.io.readers.las import require_las
from geodesic_toolkit.io.readers.vtk_library import require_vtk
from geodesic_toolkit.registry.catalog import writers
from geodesic_toolkit.registry.writer import Writer

__all__ = ["check_distance_output", "check_domain_of_output"]

WITH_SHAPE = (".ply", ".pcd", ".las", ".laz", ".vtp", ".vtk", ".vtu")
"""Formats of a shape with numbers at its vertices."""

ALONE = (".npy", ".csv", ".txt")
"""Formats of numbers that need no shape."""

OF_THE_CORE = (*WITH_SHAPE, ".gii", *ALONE)

SHAPE_ALONE = (".obj", ".off", ".stl", ".xyz", ".mesh")
"""Common formats of shapes that cannot hold a field."""

OTHER_GIFTI = (".surf.gii", ".label.gii")
"""Names of GIFTI files whose suffix promises something else than a field."""


def check_distance_output(path: str | os.PathLike[str]) -> Path:
    """Raise if distances cannot be written to `path`; call it before any work.

    Raises
    ------
    InvalidOptionError
        A suffix of an unknown format, or of one that cannot hold numbers at vertices.
    WriteError
        A directory, a device, a directory that does not exist, or no permission.
    MissingDependencyError
        The format needs a package that is not installed.
    """
    file = as_path(path)
    suffix = file.suffix.lower()
    if suffix not in OF_THE_CORE and _names(file):  # of a plugin
        return check_output(file, (suffix,))
    can = ", ".join(OF_THE_CORE)
    if suffix in SHAPE_ALONE:
        raise InvalidOptionError(
            f"{file}: {suffix} files hold a shape, but cannot hold distances; can be written: {can}"
        )
    if file.name.lower().endswith(OTHER_GIFTI):
        raise InvalidOptionError(
            f"{file}: distances are numbers, not a surface and not labels; call it .shape.gii or "
            f".func.gii; can be written: {can}"
        )
    check_output(file, OF_THE_CORE if suffix in OF_THE_CORE else (*OF_THE_CORE, *_of_plugins()))
    if suffix in {".vtp", ".vtk", ".vtu"}:
        require_vtk(file)
    elif suffix == ".gii":
        optional_package("nibabel.gifti", "gii", "writing")
    elif suffix in {".las", ".laz"}:
        require_las(file)
    return file


def check_domain_of_output(file: Path, domain: Domain) -> Writer | None:
    """Return the writer of a plugin that writes distances on `domain` to `file`; None for the core.

    Parameters
    ----------
    file : Path
        Checked by `check_distance_output`.
    domain : Domain

    Raises
    ------
    InvalidOptionError
        The format is not one of this kind of domain.
    MissingDependencyError
        The writer needs a package that is not installed.
    PluginLoadError
        The writer does not load.
    """
    suffix = file.suffix.lower()
    if suffix not in OF_THE_CORE or not _of_the_core(domain):
        found = [writers[name] for name in _names(file)]
        for writer in found:
            if isinstance(domain, writer.domains):
                for package in writer.packages:
                    optional_package(package, suffix[1:], "writing")
                return writer
        if suffix not in OF_THE_CORE:
            others = " or ".join(writer.kinds for writer in found)
            raise InvalidOptionError(
                f"{file}: this format is for {others}, not for {a_kind_of(domain)}; can be "
                f"written: {', '.join(_of_kind(domain))}"
            )
    if suffix in WITH_SHAPE and not domain.has("positions"):
        raise InvalidOptionError(
            f"{file}: {a_kind_of(domain)} has no positions to write to a {suffix} file; can be "
            f"written: {', '.join(_of_kind(domain))}"
        )
    return None


def _of_the_core(domain: Domain) -> bool:
    """Return True for kinds of the core, whose formats do not need a search for plugins."""
    return isinstance(domain, TriangleMesh | MeasuredFaces | PointCloud | Graph)


def _names(file: Path) -> list[str]:
    """Return the names of the writers of a file; a suffix such as nii.gz has two parts."""
    return [name for name in writers if file.name.lower().endswith(_suffix(name))]


def _suffix(name: str) -> str:
    return "." + name.rpartition(":")[2]


def _of_plugins() -> list[str]:
    return sorted({_suffix(name) for name in writers} - set(OF_THE_CORE))


def _of_kind(domain: Domain) -> list[str]:
    """Return the suffixes of the formats that hold distances on a kind of domain."""
    own = {_suffix(name) for name in writers if isinstance(domain, writers[name].domains)}
    core = OF_THE_CORE if domain.has("positions") else (".gii", *ALONE)
    return [*sorted(own - set(core)), *core]
