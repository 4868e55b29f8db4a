"""``geodesic-toolkit demo``: the main job on a generated shape."""

from pathlib import Path

from geodesic_toolkit.cli.arguments import Folder, Json
from geodesic_toolkit.cli.output import aligned, one_line, say, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.core.atomic import make_folder
from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["demo"]

SOURCE = 0

KINDS = {
    ".ply": "surface with distances",
    ".csv": "table",
    ".png": "picture: look at it",
    ".html": "page: open it in a browser",
}

DRAWN = " --picture distances.png"


def demo(out: Folder = Path("geodesic-demo"), json: Json = False) -> None:
    """Compute and draw distances on a generated shape.

    Writes tables of numbers, a picture, and a page that shows the shape in a browser.
    """
    from geodesic_toolkit.solver.solver import GeodesicSolver
    from geodesic_toolkit.testing import shapes

    tables = Targets(tables=(out / "knot.ply", out / "knot.csv"))
    looks = (Targets(picture=out / "knot.png"), Targets(html=out / "knot.html"))
    make_folder(out)
    for targets in (tables, *looks):
        targets.check()
    written, missing = list(tables.paths), []
    with running() as run:
        with run.step("factorising"):
            knot = shapes.knot()
            solver = GeodesicSolver(knot)
        with run.step("solving"):
            distances = solver.distance(SOURCE)
        with run.step("checking"):
            error = _error_on_sphere()
        tables.write(run, knot, distances, [SOURCE])
        for targets in looks:
            try:
                targets.write(run, knot, distances, [SOURCE])
            except MissingDependencyError as failure:
                missing.append(one_line(failure))
            else:
                written += targets.paths
    for reason in missing:
        say(f"warning: not everything was drawn: {reason}")
    if json:
        show_json(
            {
                "n_vertices": knot.n_vertices,
                "source": SOURCE,
                "max": distances.max(),
                "mean_error_on_sphere": error,
                "timings": run.timings,
                "warnings": [*run.warnings, *missing],
                "outputs": [str(path) for path in written],
                "versions": versions(),
            }
        )
        return
    rows = [
        ("shape", f"a trefoil knot, {knot!r}"),
        ("result", f"distance along the surface from vertex {SOURCE}: up to {distances.max():.2f}"),
        ("check", f"on a sphere, mean error {error:.2%} against the exact arc length"),
        ("took", run.took),
        *((KINDS[path.suffix], str(path)) for path in written),
    ]
    for line in aligned(rows):
        show(line)
    show("")
    show("The lines on the picture are equally far apart on the surface, however it bends.")
    show("Do the same with your own shape:")
    show(
        f"  geodesic-toolkit distance YOUR_MESH.ply --source {SOURCE} --output distances.ply{DRAWN}"
    )


def _error_on_sphere() -> float:
    """Return the mean relative error on a sphere, whose distances are known."""
    import numpy as np

    from geodesic_toolkit.solver.convenience import geodesic_distance
    from geodesic_toolkit.testing import shapes

    sphere = shapes.icosphere(4)
    exact = np.arccos(np.clip(sphere.vertices @ sphere.vertices[SOURCE], -1.0, 1.0))
    away = exact > 0
    error = np.abs(geodesic_distance(sphere, SOURCE)[away] / exact[away] - 1)
    return float(error.mean())
