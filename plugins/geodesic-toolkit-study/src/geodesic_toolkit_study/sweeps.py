"""Errors and costs over a range: of the time step, and of the size of the mesh."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.geometry.triangles import edges_and_lengths, edges_of_faces, proper_faces
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit_study.subject import Subject, error_of

__all__ = ["Times", "study_sizes", "study_times", "subdivided"]

FACTORS = tuple(2.0**power for power in range(-4, 9))
"""Time steps in units of h²."""

LARGEST_SIZE = 60_000
"""Vertices up to which the mesh is subdivided."""

MOST_LEVELS = 3

LARGEST_SPHERE = 20_000

QUICK = 20_000
"""Vertices up to which a factorisation is timed several times."""

RUNS = 3
"""Runs of each measurement; the quickest counts, as others share the machine."""

OCTAHEDRON = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]

OCTAHEDRON_FACES = [
    face for i, j in ((0, 1), (1, 2), (2, 3), (3, 0)) for face in ((i, j, 4), (j, i, 5))
]


@dataclass
class Times:
    """Error by time factor, and what rules that need no true distance would choose.

    Attributes
    ----------
    rows : list of dict
        One for each factor and source.
    rules : list of dict
        One for each rule.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    rules: list[dict[str, Any]] = field(default_factory=list)


def study_times(subject: Subject) -> Times:
    """Sweep the time step, and let rules choose one."""
    refined = subject.heat_method(refine=True)
    targets = {source: refined.distance(source) for source in subject.sources}
    found = Times()
    for factor in FACTORS:
        found.rows += _at_factor(subject, factor, targets)
    mean = {
        key: np.array([_mean(found.rows, factor, key) for factor in FACTORS])
        for key in ("mean_error", "slope_error", "from_refined")
    }
    _, longest = _edge_lengths(subject.mesh)
    longest_factor = (longest / subject.h) ** 2
    at_longest = _at_factor(subject, longest_factor, targets)
    best = int(mean["mean_error"].argmin())
    choices = [
        ("mean edge length squared", 1.0, mean["mean_error"][FACTORS.index(1.0)]),
        ("longest edge squared", longest_factor, np.mean([r["mean_error"] for r in at_longest])),
        *(
            (name, FACTORS[int(mean[key].argmin())], mean["mean_error"][int(mean[key].argmin())])
            for name, key in (
                ("slope nearest to 1", "slope_error"),
                ("nearest to the refined distance", "from_refined"),
            )
        ),
        ("best of the sweep, knowing the truth", FACTORS[best], mean["mean_error"][best]),
    ]
    found.rules = [
        {"rule": rule, "factor": float(factor), "mean_error": float(error)}
        for rule, factor, error in choices
    ]
    return found


def study_sizes(subject: Subject) -> list[dict[str, Any]]:
    """Measure errors and costs on finer and finer meshes of two surfaces.

    One is the surface of the subject itself: subdividing at midpoints leaves it, and the true
    distances at its vertices, as they are. The other is the unit sphere, whose meshes have the
    angle between two vertices for their true distance.
    """
    source, mesh, level = subject.sources[0], subject.mesh, 0
    true = subject.true(source)
    rows: list[dict[str, Any]] = []
    while level == 0 or (mesh.n_vertices <= LARGEST_SIZE and level <= MOST_LEVELS):
        rows += _at_size(subject.name, mesh, source, true)
        mesh, level = subdivided(mesh), level + 1
    sphere = TriangleMesh(OCTAHEDRON, OCTAHEDRON_FACES)
    while sphere.n_vertices <= LARGEST_SPHERE:
        if sphere.n_vertices > 50:
            rows += _at_size("sphere", sphere, 0, np.arccos(np.clip(sphere.vertices[:, 0], -1, 1)))
        finer = subdivided(sphere)
        radii = np.linalg.norm(finer.vertices, axis=1, keepdims=True)
        sphere = TriangleMesh(finer.vertices / radii, finer.faces)
    return rows


def subdivided(mesh: TriangleMesh) -> TriangleMesh:
    """Return each triangle split in four at the midpoints of its edges: the same surface.

    The vertices of `mesh` come first, in their order.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> subdivided(gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    TriangleMesh(6 vertices, 4 faces)
    """
    faces = mesh.faces[proper_faces(mesh.faces)]
    edges, _ = edges_of_faces(faces, mesh.n_vertices)
    keys = edges[:, 0] * mesh.n_vertices + edges[:, 1]
    order = np.argsort(keys)
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1), axis=-1)
    wanted = sides[..., 0] * mesh.n_vertices + sides[..., 1]
    middle = mesh.n_vertices + order[np.searchsorted(keys[order], wanted)]
    (a, b, c), (ab, bc, ca) = faces.T, middle.T
    split = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=-1).reshape(-1, 3)
    return TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices[edges].mean(axis=1)]), split)


def _at_factor(
    subject: Subject, factor: float, targets: dict[int, FloatArray]
) -> list[dict[str, Any]]:
    method = subject.heat_method(time_factor=factor)
    rows = []
    for source in subject.sources:
        directions = -subject.metric.gradient.unit(method.log_heat(source))
        potential = subject.method.integrate(directions)  # one Poisson factor serves all times
        distance = np.where(subject.reached(source), potential - potential[source], np.inf)
        error = subject.error(distance, source)
        rows.append(
            {
                "factor": factor,
                "source": source,
                "mean_error": error["mean"],
                "largest_error": error["largest"],
                "slope_error": _slope_error(subject, distance),
                "from_refined": error_of(distance, targets[source])["mean"],
            }
        )
    return rows


def _at_size(
    surface: str, mesh: TriangleMesh, source: int, true: FloatArray
) -> list[dict[str, Any]]:
    rows = []
    runs = RUNS if mesh.n_vertices <= QUICK else 1
    for refine in (False, True):
        prepared, solved = [], []
        for _ in range(runs):
            start = time.perf_counter()
            solver = GeodesicSolver(mesh, refine=refine)
            prepared.append(1e3 * (time.perf_counter() - start))
        for _ in range(RUNS):
            start = time.perf_counter()
            distance = solver.distance(source)
            solved.append(1e3 * (time.perf_counter() - start))
        rows.append(
            {
                "surface": surface,
                "vertices": mesh.n_vertices,
                "refined": refine,
                "mean_error": error_of(distance[: len(true)], true)["mean"],
                "prepare_ms": round(min(prepared), 3),
                "solve_ms": round(min(solved), 3),
            }
        )
    return rows


def _mean(rows: list[dict[str, Any]], factor: float, key: str) -> float:
    return float(np.mean([row[key] for row in rows if row["factor"] == factor]))


def _slope_error(subject: Subject, distance: FloatArray) -> float:
    """Return how far |∇φ| is from 1, in per cent, averaged over the area that is reached."""
    gradient = subject.metric.gradient
    assert isinstance(gradient, ElementGradient)  # that of a mesh
    inside = np.isfinite(distance[gradient.elements]).all(axis=1) & (gradient.measure > 0)
    if not inside.any():
        return 0.0
    corners = distance[gradient.elements[inside]]
    slope = np.einsum("edm,em->ed", gradient.coefficients[inside], corners)
    off = np.abs(np.linalg.norm(slope, axis=1) - 1)
    return round(100 * float(np.average(off, weights=gradient.measure[inside])), 6)


def _edge_lengths(mesh: TriangleMesh) -> tuple[float, float]:
    """Return the mean and the greatest edge length."""
    _, lengths = edges_and_lengths(mesh.vertices, mesh.faces)
    return float(lengths.mean()), float(lengths.max())
