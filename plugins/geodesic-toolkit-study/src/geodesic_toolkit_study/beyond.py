"""Experiment 4: other operators on the same vertices, and wavefronts."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Graph, PointCloud
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit_study.subject import Subject

__all__ = ["REFINED", "Beyond", "edge_graph", "study_beyond"]

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


def edge_graph(subject: Subject) -> Graph:
    """Return the graph of the edges of the mesh, with their lengths."""
    mesh = subject.mesh
    edges, _ = edges_of_faces(mesh.faces[proper_faces(mesh.faces)], mesh.n_vertices)
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return Graph(mesh.n_vertices, edges[lengths > 0], lengths[lengths > 0])


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
        "graph of the edges": heat(edge_graph(subject)),
        "shortest path along edges": lambda: _along_edges(edge_graph(subject)),
    }


def _along_edges(graph: Graph) -> Distance:
    """Return Dijkstra's distance along the edges, for comparison."""
    shape = (graph.n_vertices, graph.n_vertices)
    lengths = csr_array(coo_array((graph.lengths, tuple(graph.edges.T)), shape=shape))
    return lambda source: np.asarray(dijkstra(lengths, directed=False, indices=[source])[0])


def _timed(work: Callable[[], T]) -> tuple[float, T]:
    """Return the least time that `work` takes, in milliseconds, and what it returns."""
    spent = []
    for _ in range(RUNS):
        start = time.perf_counter()
        result = work()
        spent.append(1e3 * (time.perf_counter() - start))
    return round(min(spent), 3), result
