"""The report: tables, figures and conclusions, in an order that one can learn from."""

from collections.abc import Mapping
from typing import Any

from geodesic_toolkit_study import conclusions
from geodesic_toolkit_study.beyond import REFINED
from geodesic_toolkit_study.document import (
    Block,
    Bullets,
    Figure,
    Heading,
    Paragraph,
    Table,
)
from geodesic_toolkit_study.results import TIMES, Results
from geodesic_toolkit_study.time_step import LARGEST_POISSON_BY_CG

__all__ = ["compose"]


def compose(results: Results) -> list[Block]:
    """Return the report as blocks."""
    return [
        *_introduction(results),
        *_time_step(results),
        *_noise(results),
        *_discretizations(results),
        *_beyond(results),
    ]


def _introduction(results: Results) -> list[Block]:
    subject = results.subject
    kinds = {subject.reference(source) for source in subject.sources}
    truth = (
        "Errors are measured against exact distances along the polyhedron"
        if kinds == {"exact"}
        else "This mesh is too large, or not manifold enough, for exact distances: errors are "
        "measured against the refined ones, whose own error is a few times smaller than that of "
        "heat"
    )
    return [
        Heading(1, f"A study of the heat method on {subject.name}"),
        Paragraph(
            f"{subject.mesh.n_vertices:,} vertices, {subject.mesh.n_faces:,} faces, mean edge "
            f"length h = {subject.h:.4g}, bounding box of diagonal {subject.diagonal:.4g}; "
            f"sources {', '.join(map(str, subject.sources))}. {truth}: the mean relative error "
            "over all vertices, and in brackets the largest error as a share of the largest "
            "distance, both in per cent."
        ),
        Paragraph(
            "The heat method finds the distance from a source in three steps: let heat flow from "
            "it for a short time t, `(M + t L) u = δ`; turn its gradient into unit vectors, "
            "`X = -∇u/|∇u|`, which point away from the source; and find the function whose "
            "gradient they are, `L φ = Gᵀ W X`. L = -Δ is the Laplacian, positive semidefinite, "
            "and M the areas of the vertices."
        ),
        Figure("distance.png", "Lines of equal distance, equally far apart on the surface."),
    ]


def _time_step(results: Results) -> list[Block]:
    found = results.time_step
    rows = [
        [
            f"{row['source']}",
            TIMES[row["time"]],
            "CG" if row["solver"] == "cg" else "direct",
            (f"{row['iterations']}" if row["iterations"] else "–")
            + ("" if row["converged"] else " (gave up)"),
            f"{row['zeros']:,}",
            f"{row['non_positive']:,}",
            _errors(row),
        ]
        for row in sorted(found.rows, key=lambda row: row["source"])
    ]
    tolerances = [
        [
            f"{row['source']}",
            f"{row['rtol']:.0e}",
            f"{row['iterations']}" + ("" if row["converged"] else " (gave up)"),
            f"{row['zeros']:,}",
            f"{row['non_positive']:,}",
            _errors(row),
        ]
        for row in sorted(found.tolerances, key=lambda row: (row["source"], -row["rtol"]))
    ]
    return [
        Heading(2, "1. The time step, and the solver"),
        Paragraph(
            "Each system is solved twice: by SciPy's conjugate gradients at a relative tolerance "
            + (
                "of 1e-5, in both steps, "
                if results.subject.mesh.n_vertices <= LARGEST_POISSON_BY_CG
                else "of 1e-5 (the heat alone, as the Poisson equation would take long here) "
            )
            + "and by a direct solver. The gradient is taken of u as it "
            "comes, as one would at first."
        ),
        Table(["source", "t", "solver", "steps", "u = 0", "u ≤ 0", "error [%]"], rows),
        *(
            Figure(
                f"time_step_{source}.png",
                f"Distance from vertex {source}, scaled to [0, 1], in matplotlib's brg. Rows: the "
                "time step. Left: conjugate gradients. Right: the direct solver.",
            )
            for source in results.subject.sources
        ),
        Heading(3, "The cause of the flat part"),
        Paragraph(
            "Conjugate gradients start from 0, and each step multiplies by the matrix once, which "
            "passes information from neighbour to neighbour. After k steps, vertices beyond k - 1 "
            "edges from the source are unchanged: **one ring of neighbours a step**. The iteration "
            "stops when the residual is small relative to its start. But the heat falls by a "
            "factor of about e with every edge, so the residual is small long before the far side "
            "has been reached, and there u still has its initial value: exactly 0. Just "
            "inside that front the values are leftovers of the iteration, of either sign."
        ),
        Bullets(conclusions.on_the_solver(results)),
        Figure(
            "rings.png",
            "Left: entries of the iterate that are not 0 after each step (dots), on the number of "
            "vertices within as many rings (line). Right: the heat at every vertex; the direct "
            "solver resolves all its decades, conjugate gradients depart from them once u is as "
            "small, beside its largest value, as the tolerance.",
        ),
        Figure(
            "heat.png",
            "Above: the rings that the iteration reached. Middle: the heat that it left, grey "
            "where zero or negative. Below: the heat by the direct solver, in the same colours.",
        ),
        Heading(3, "Does a smaller tolerance help?"),
        Paragraph(
            "Conjugate gradients for the heat at t = h², the direct solver for the Poisson "
            "equation, so that the heat alone differs."
        ),
        Table(["source", "tolerance", "steps", "u = 0", "u ≤ 0", "error [%]"], tolerances),
        Figure(
            "tolerances.png",
            "Vertices without heat, and the error of the distance, as the tolerance shrinks.",
        ),
        Bullets(conclusions.on_the_step(results)),
        Paragraph(
            "A sparse Cholesky or LU factor does not know this trouble: on a matrix with "
            "off-diagonal entries that are not positive it adds up numbers of one sign, and every "
            "entry of u is right relative to itself, however small. That is why the library asks "
            "for a direct solver for the heat, and allows conjugate gradients for the Poisson "
            "equation only. Where a direct solver still leaves u ≤ 0, entries of the other sign "
            "are the cause: obtuse angles."
        ),
    ]


def _noise(results: Results) -> list[Block]:
    rows = [
        [
            f"{row['source']}",
            f"{100 * row['sigma_of_diagonal']:g}",
            f"{row['sigma_of_edge']:.2f}",
            _number(row["rank_correlation_of_u"], ".4f"),
            f"{row['change_of_distance']:.2f}",
            f"{row['change_of_true']:.2f}",
            f"{row['error_across']:.2f}",
            f"{row['error_on_noisy']:.2f}",
            f"{row['error_of_auto']:.2f}",
            f"{row['non_positive']:,}",
        ]
        for row in sorted(results.noise.rows, key=lambda row: row["source"])
    ]
    return [
        Heading(2, "2. Noise"),
        Paragraph(
            "Every coordinate is moved by Gaussian noise; sigma is a share of the bounding box's "
            "diagonal. Each noisy mesh gets its own h and its own t = h². Columns: Spearman's "
            "correlation of u with and without noise; the change of the distance by "
            "heat; the change of the true distance; the error of the noisy mesh's distance "
            "against the clean truth, against its own truth, and the latter with the operator "
            "that the library chooses; and the vertices at which u ≤ 0. All but the first in %."
        ),
        Table(
            [
                "source",
                "sigma [% of diagonal]",
                "sigma / h",
                "correlation of u",
                "heat, noisy – clean",
                "truth, noisy – clean",
                "error, clean truth",
                "error, own truth",
                "own truth, auto",
                "u ≤ 0",
            ],
            rows,
        ),
        Figure("noise_heat.png", "Heat and distance with more and more noise."),
        Figure("noise.png", "Effects of noise on heat and distance."),
        Bullets(conclusions.on_noise(results)),
    ]


def _discretizations(results: Results) -> list[Block]:
    rows = [
        [
            f"{row['diffusion']}, t = {TIMES[row['time']]}",
            f"{row['source']}",
            f"{row['decades_of_u']:.1f}",
            _number(row["rank_correlation"], ".4f"),
            _errors(row),
        ]
        for row in results.discretizations.rows
    ]
    return [
        Heading(2, "3. Diffusion by other operators"),
        Paragraph(
            "The first step uses one Laplacian or another; gradient and Poisson equation remain "
            "those of the mesh, solved directly. Beside the error: how many decades u spans, and "
            "how well its order agrees with that of the true distance."
        ),
        Table(["diffusion", "source", "decades of u", "rank correlation", "error [%]"], rows),
        Figure(
            "discretizations.png",
            "Left: the heat. Right: the error of its distance, red where it is too long and "
            "blue where it is too short.",
        ),
        Bullets(conclusions.on_the_discretization(results)),
    ]


def _beyond(results: Results) -> list[Block]:
    rows = [
        [
            row["method"],
            f"{row['source']}",
            (
                "the reference"
                if row["method"] == REFINED
                and results.subject.reference(row["source"]) == "refined"
                else _errors(row)
            ),
            f"{row['prepare_ms']:.0f}",
            f"{row['solve_ms']:.1f}",
        ]
        for row in results.beyond.rows
    ]
    rules = [
        [rule["rule"], f"{rule['factor']:.3g}", f"{rule['mean_error']:.2f}"]
        for rule in results.times.rules
    ]
    sizes = [
        [
            row["surface"],
            f"{row['vertices']:,}",
            "refined" if row["refined"] else "heat",
            f"{row['mean_error']:.3g}",
            f"{row['prepare_ms']:.0f}",
            f"{row['solve_ms']:.1f}",
        ]
        for row in results.sizes
    ]
    return [
        Heading(2, "4. More accurate methods"),
        Paragraph(
            "Other operators on the same vertices: the intrinsic Delaunay triangulation of the "
            "same surface; wavefronts swept in the order of the heat (refined); the vertices as a "
            "point cloud, which has to find its surface by itself; the edges as a graph."
        ),
        Table(["method", "source", "error [%]", "prepare [ms]", "solve [ms]"], rows),
        Figure(
            "error_maps.png",
            "Signed errors in one scale, that of plain heat; red is too long, blue too short. "
            "Grey is not reached.",
        ),
        Bullets(conclusions.on_operators(results)),
        Heading(3, "Choosing t"),
        Paragraph(
            "Rules that need no true distance: the paper's h², the square of the longest edge, "
            "the t at which |∇φ| is nearest to 1 on average, as a distance's should be, and the t "
            "at which φ is nearest to the refined distance."
        ),
        Table(["rule", "t / h²", "error [%]"], rules),
        Figure("time_factors.png", "The error as t grows, and what can be known of it."),
        Bullets(conclusions.on_times(results)),
        Heading(3, "Finer meshes"),
        Paragraph(
            f"From vertex {results.subject.sources[0]}: the mesh, its triangles split in four "
            "again and again; and spheres."
        ),
        Table(["surface", "vertices", "method", "error [%]", "prepare [ms]", "solve [ms]"], sizes),
        Figure("sizes.png", "Error and cost against the number of vertices."),
        Bullets(conclusions.on_sizes(results)),
    ]


def _errors(row: Mapping[str, Any]) -> str:
    return f"{row['mean_error']:.2f} ({row['largest_error']:.1f})"


def _number(value: float | None, form: str) -> str:
    return "–" if value is None else format(value, form)
