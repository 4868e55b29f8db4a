"""``geodesic-toolkit doctor``: examine the installation, or a shape."""

import platform
import re
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit import __version__, _native
from geodesic_toolkit.cli.arguments import Json, Weld, all_existing
from geodesic_toolkit.cli.output import aligned, one_line, show, show_json, versions
from geodesic_toolkit.cli.plugins import plugin_rows
from geodesic_toolkit.cli.probes import probe_all
from geodesic_toolkit.cli.run import Run, running
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import read_welded

if TYPE_CHECKING:
    from geodesic_toolkit.solver.diagnosis import Diagnosis
    from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["doctor"]

SHARP_ANGLE = 1.0
"""Angle in degrees below which a face is a sliver."""

HARMFUL_SHARE = 0.01
"""Share of vertices with non-positive heat above which distances suffer."""


def doctor(
    paths: Annotated[
        list[Path] | None,
        typer.Argument(
            callback=all_existing,
            metavar="INPUT",
            help="Meshes, point clouds or graphs; - reads standard input; if omitted, the "
            "installation is examined.",
            show_default=False,
        ),
    ] = None,
    weld: Weld = None,
    json: Json = False,
) -> None:
    """Examine the installation, or what the shape INPUT is like."""
    if not paths:
        _examine_installation(json)
    else:
        answer_each(partial(_examine_shape, weld=weld), paths, Targets(), json=json)


# -- a shape -----------------------------------------------------------------------------------


def _examine_shape(run: Run, path: Path, _: Targets, *, weld: float | None) -> Answer:
    from geodesic_toolkit.solver.solver import GeodesicSolver

    with run.step("reading"):
        shape, _mask = read_welded(path, weld, run)
    with run.step("factorising"):
        solver = GeodesicSolver(shape.domain)
    with run.step("examining"):
        diagnosis = solver.diagnosis
    advice = _of_seams(solver) + _advice(diagnosis)
    content = {"diagnosis": diagnosis.as_dict(), "recommendations": advice}
    findings = [f"- {line}" for line in advice or ["Nothing stands out: use it as it is."]]
    return Answer(shape, content, lines=[str(diagnosis), "", *findings])


def _of_seams(solver: "GeodesicSolver") -> list[str]:
    seams = solver.seams
    if seams is None:
        return []
    return [f"{seams.finding}: {seams.cure}."]


def _advice(diagnosis: "Diagnosis") -> list[str]:
    """Return the meaning of the findings for distances, and the remedies."""
    cure = _cure_of_negative_weights(diagnosis)
    advice = []
    if diagnosis.components > 1:
        advice.append(
            f"The shape has {diagnosis.components} components: distances are inf in those without "
            "a source. Join them, or give each a source."
        )
    if diagnosis.isolated_vertices:
        advice.append(
            f"{diagnosis.isolated_vertices} vertices are isolated: their distance is "
            "inf, which does no other harm."
        )
    if diagnosis.non_manifold_edges:
        advice.append(
            f"{diagnosis.non_manifold_edges} edges have more than two faces: heat flows into all "
            "of them. Exact distances refuse such a mesh."
        )
    if diagnosis.minimum_angle is not None and diagnosis.minimum_angle < SHARP_ANGLE:
        advice.append(
            f"The sharpest angle is {diagnosis.minimum_angle:.2g} degrees; if there are many "
            f"slivers, {cure}."
        )
    if diagnosis.non_positive > HARMFUL_SHARE * diagnosis.reached:
        advice.append(
            f"Heat is not positive at {diagnosis.non_positive} of {diagnosis.reached} vertices, "
            f"where distances are unreliable: {cure}."
        )
    if diagnosis.boundary_vertices:
        advice.append(
            f"{diagnosis.boundary_vertices} vertices are on a boundary; if plain heat "
            "(--no-refine) bends near it, try --boundary average."
        )
    return advice


def _cure_of_negative_weights(diagnosis: "Diagnosis") -> str:
    if diagnosis.non_manifold_edges is None:
        return "even sampling and fewer outliers help"
    if diagnosis.non_manifold_edges:
        return "remeshing helps"
    return "CotanLaplacian(intrinsic_delaunay=True) or remeshing helps"


# -- the installation --------------------------------------------------------------------------


def _examine_installation(json: bool) -> None:
    with running() as run:
        packages = _packages()
        with run.step("trying Open3D and pictures in separate processes"):
            probes = probe_all()
        with run.step("loading the plugins"):
            plugins = plugin_rows()
    problems = [f"{row['package']} is not installed" for row in packages if row["problem"]]
    problems += [f"{name}: {probe.detail}" for name, probe in probes.items() if not probe.works]
    problems += [one_line(row.error) for _, row in plugins if not row.usable]
    normals = "open3d" if probes["open3d"].works else "pca"
    if json:
        show_json(
            {
                "python": platform.python_version(),
                "platform": platform.platform(),
                "packages": packages,
                "open3d": vars(probes["open3d"]),
                "pictures": vars(probes["pictures"]),
                "pages": vars(probes["pages"]),
                "plugins": len(plugins),
                "normals": normals,
                "kernels": KERNELS,
                "problems": problems,
                "warnings": run.warnings,
                "versions": versions(),
            }
        )
        return
    show(
        f"geodesic-toolkit {__version__}, Python {platform.python_version()}, {platform.platform()}"
    )
    show("")
    table = [(row["package"], row["version"] or "missing", row["needed_for"]) for row in packages]
    for line in aligned([("PACKAGE", "VERSION", "NEEDED FOR"), *table]):
        show(line)
    show("")
    state = [
        (name, "works" if probe.works else "fails", probe.detail) for name, probe in probes.items()
    ]
    broken = sum(not row.usable for _, row in plugins)
    state.append(
        ("plugins", "fail" if broken else "work", f"{len(plugins)} installed, {broken} broken")
    )
    state.append(("normals", normals, NORMALS[normals]))
    state.append(("kernels", "work", KERNELS))
    for line in aligned(state):
        show(line)
    show("")
    for line in problems or ["Everything works."]:
        show(f"problem: {line}" if problems else line)


def _packages() -> list[dict[str, Any]]:
    """Return the dependencies with their versions, without importing them."""
    found: dict[str, dict[str, Any]] = {}
    for requirement in metadata.requires("geodesic-toolkit") or []:
        specifier, _, marker = requirement.partition(";")
        name = re.match(r"[\w.-]+", specifier)
        extra = re.search(r"extra\s*==\s*['\"]([\w-]+)", marker)
        if name is None or name[0] in found or name[0] == "geodesic-toolkit":
            continue
        if extra is not None and extra[1] not in USEFUL_EXTRAS:
            continue
        version = _version(name[0])
        found[name[0]] = {
            "package": name[0],
            "version": version,
            "needed_for": USEFUL_EXTRAS[extra[1]] if extra else EVERYTHING,
            # A marker other than an extra's excludes systems without wheels.
            "problem": version is None and not marker,
        }
    return sorted(
        found.values(), key=lambda row: (row["needed_for"] != EVERYTHING, row["needed_for"])
    )


KERNELS = f"compiled for level {_native.LEVEL} of x86-64, {_native.LANES} numbers per register"

NORMALS = {
    "open3d": 'of clouds without their own, by Open3D; PointCloudLaplacian(normals="pca") does '
    "not need it",
    "pca": "of clouds without their own, by principal components, as Open3D cannot be imported: "
    "pip install open3d, if there are wheels for this Python and system; or give normals, "
    "PointCloud(points, normals)",
}

EVERYTHING = "everything"

USEFUL_EXTRAS = {
    "viz": "pictures",
    "view": "pages to click",
    "gui": "the desktop viewer",
    "io": "more file formats",
    "zarr": "large matrices",
    "robust": "the robust Laplacian",
    "exact": "another exact reference",
}
"""The extras for users, and their purpose; the others are for development of the package."""


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
