"""Experiment 4: other operators on the same vertices, and wavefronts."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Graph, PointCloud
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit_study.subject import Subject

__all__ = ["REFINED", "Beyond", "study_beyond"]

T = TypeVar("T")

Distance = Callable[[int], FloatArray]

REFINED = "heat, refined"

RUNS = 2
"""Measurements of each cost, of which the least counts: a first run imports."""


@dataclass
class Beyond:
    """Results of the experiment.

    Attributes
    ----------
    rows : list of dict
        One for each method and source.
    distances : dict
        From (method, source) to the distance.
    left_out : dict of str to str
        Methods that this mesh does not allow, and why.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    distances: dict[tuple[str, int], FloatArray] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)


def study_beyond(subject: Subject) -> Beyond:
    """Measure every operator of the library on the vertices of the mesh."""
    found = Beyond()
    for name, prepare in _methods(subject).items():
        try:
            prepared, distance_from = _timed(prepare)
        except UnsupportedDomainError as error:
            found.left_out[name] = str(error)
            continue
        for source in subject.sources:
            solved, distance = _timed(partial(distance_from, source))
            error_figures = subject.error(distance, source)
            found.distances[name, source] = distance
            found.rows.append(
                {
                    "method": name,
                    "source": source,
                    "mean_error": error_figures["mean"],
                    "largest_error": error_figures["largest"],
                    "unreached": int((subject.reached(source) & ~np.isfinite(distance)).sum()),
                    "prepare_ms": prepared,
                    "solve_ms": solved,
                }
            )
    return found


def _methods(subject: Subject) -> dict[str, Callable[[], Distance]]:
    """Return what makes each method ready, by its name."""
    mesh = subject.mesh

    def heat(domain: Any, *, refine: bool = False, **options: Any) -> Callable[[], Distance]:
        return lambda: GeodesicSolver(domain, refine=refine, **options).distance

    cotan, flipped = CotanLaplacian(), CotanLaplacian(intrinsic_delaunay=True)
    cloud = PointCloud(mesh.vertices)
    return {
        "heat": heat(mesh, operator=cotan),
        "heat, intrinsic Delaunay": heat(mesh, operator=flipped),
        REFINED: heat(mesh, operator=cotan, refine=True),
        "point cloud": heat(cloud),
        "point cloud, refined": heat(cloud, refine=True),
        "graph of the edges": heat(mesh.as_graph()),
        "shortest path along edges": lambda: _along_edges(mesh.as_graph()),
    }


def _along_edges(graph: Graph) -> Distance:
    """Return Dijkstra's distance along the edges, for comparison."""
    along = AlongEdges(graph.n_vertices, graph.edges, graph.lengths)
    both, zero = np.array([0, 1]), np.zeros(1)
    return lambda source: along.distances(both, np.array([source]), zero)[0]


def _timed(work: Callable[[], T]) -> tuple[float, T]:
    """Return the least time that `work` takes, in milliseconds, and what it returns."""
    spent = []
    for _ in range(RUNS):
        start = time.perf_counter()
        result = work()
        spent.append(1e3 * (time.perf_counter() - start))
    return round(min(spent), 3), result
