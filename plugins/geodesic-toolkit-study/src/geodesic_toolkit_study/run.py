"""The whole study: experiments, pictures, report."""

import io
import json
import os
import warnings
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, TypeAlias

from geodesic_toolkit.core.atomic import make_folder, replacing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import (
    CoarseMeshWarning,
    NonPositiveHeatWarning,
    UnsupportedDomainError,
)
from geodesic_toolkit.viz.opengl import check_opengl, quiet
from geodesic_toolkit_study.beyond import study_beyond
from geodesic_toolkit_study.charts import draw_charts
from geodesic_toolkit_study.discretizations import study_discretizations
from geodesic_toolkit_study.document import as_html, as_markdown
from geodesic_toolkit_study.noise import study_noise
from geodesic_toolkit_study.pictures import draw_pictures
from geodesic_toolkit_study.report import compose
from geodesic_toolkit_study.results import Results
from geodesic_toolkit_study.subject import Subject, choose_sources
from geodesic_toolkit_study.sweeps import study_sizes, study_times
from geodesic_toolkit_study.time_step import study_time_step

__all__ = ["run_study"]

Step: TypeAlias = Callable[[str], AbstractContextManager[Any]]


def run_study(
    mesh: Domain,
    folder: str | os.PathLike[str],
    *,
    sources: Sequence[int] | None = None,
    name: str = "the mesh",
    seed: int = 0,
    step: Step = nullcontext,
) -> dict[str, Any]:
    """Run every experiment on a mesh, and write figures, tables and conclusions.

    Parameters
    ----------
    mesh : TriangleMesh
    folder : str or path-like
        Where the files go: ``study.json``, ``study.md``, ``study.html`` and PNG figures. Made if
        it is not there; each file is written whole or not at all.
    sources : sequence of int, optional
        Source vertices; by default 500 and 2000 where the mesh has them in its largest part, else
        two far ends of that.
    name : str
        What to call the mesh.
    seed : int
        Of the noise.
    step : callable, optional
        Called with the name of each part of the work; returns a context that it runs in.

    Returns
    -------
    dict
        The content of ``study.json``.

    Raises
    ------
    UnsupportedDomainError
        Not a triangle mesh.
    InvalidSourceError
        A source that is not there.
    MissingDependencyError
        A package for pictures is not installed.
    WriteError
        The folder cannot be made, or a file not written.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_study import run_study
    >>> run_study(gt.PointCloud([[0.0, 0.0, 0.0]]), "out")
    Traceback (most recent call last):
        ...
    geodesic_toolkit.errors.UnsupportedDomainError: the study is about triangle meshes, not ...
    """
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"the study is about triangle meshes, not a {type(mesh).__name__}; "
            "its experiments need faces"
        )
    require("pyvista", "viz", "Pictures need")
    with quiet():
        check_opengl()
    chosen = choose_sources(mesh, sources)
    target = make_folder(folder)
    with warnings.catch_warnings():
        # Bad heat is what is studied here: the tables count it.
        warnings.simplefilter("ignore", NonPositiveHeatWarning)
        warnings.simplefilter("ignore", CoarseMeshWarning)
        results = _experiments(Subject(mesh, name, chosen.tolist(), seed=seed), step)
    with step("drawing"):
        files = [*draw_pictures(results, target), *draw_charts(results, target)]
    with step("writing"):
        blocks = compose(results)
        figures = {**results.figures, "figures": files}
        images = {file: _smaller(target / file) for file in files}
        title = f"A study of the heat method on {name}"
        _write(target / "study.json", json.dumps(figures, indent=1, allow_nan=False) + "\n")
        _write(target / "study.md", as_markdown(blocks))
        _write(target / "study.html", as_html(title, blocks, images))
    return figures


def _experiments(subject: Subject, step: Step) -> Results:
    with step("exact distances"):
        for source in subject.sources:
            subject.true(source)
    with step("time step and solver"):
        time_step = study_time_step(subject)
    with step("noise"):
        noise = study_noise(subject)
    with step("discretizations"):
        discretizations = study_discretizations(subject)
    with step("operators"):
        beyond = study_beyond(subject)
    with step("choice of t"):
        times = study_times(subject)
    with step("finer meshes"):
        sizes = study_sizes(subject)
    return Results(
        subject=subject,
        time_step=time_step,
        noise=noise,
        discretizations=discretizations,
        beyond=beyond,
        times=times,
        sizes=sizes,
    )


def _smaller(path: Path) -> bytes:
    """Return a picture as a JPEG, which the page holds a third as many bytes of."""
    from PIL import Image

    stream = io.BytesIO()
    with Image.open(path) as picture:
        picture.convert("RGB").save(stream, format="JPEG", quality=88, subsampling=0, optimize=True)
    return stream.getvalue()


def _write(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
