"""The diagnosis of a shape: its properties, and their treatment."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.geometry.seams import Seams
from geodesic_toolkit.geometry.triangles import (
    edges_of_faces,
    frames_from_positions,
    proper_faces,
)
from geodesic_toolkit.heat.method import HeatMethod, HeatReport
from geodesic_toolkit.solver.coarseness import coarse_components

__all__ = ["Diagnosis", "diagnose"]


@dataclass(frozen=True)
class Diagnosis:
    """The diagnosis of a shape: its properties, and their treatment.

    Attributes
    ----------
    domain, operator : str
        The discretized shape, and its operator.
    components : int
        Connected components of more than one vertex.
    coarse_components : int
        Components that are so coarse that plain heat is about 5 % off, or more; 0 without faces.
    isolated_vertices : int
        Vertices without connections; their distance is ``inf``.
    boundary_vertices : int
        Vertices on a boundary.
    seam_edges : int
        Edges of the boundary that coincide with others: a mesh is cut there, and paths do not
        cross.
    seam_tolerance : float or None
        Tolerance with which :func:`merge_vertices` joins them; None without seams.
    non_manifold_edges : int or None
        Edges of more than two faces; None without faces.
    minimum_angle : float or None
        Smallest angle of a face, in degrees; None without faces.
    positive_off_diagonals : float
        Share of positive off-diagonal entries in the stiffness of the diffusion; it is 0 for a
        Laplacian with a maximum principle.
    refined : bool
        True if distances are refined. On a graph refined distances are shortest paths along edges.
    across : bool
        True if fronts cross the corners of a graph. If both are False, distances are those of plain
        heat.
    reason : str
        Reason for this choice, if it was left to "auto"; empty if it was given.
    spacing : float
        Mean edge length h.
    time : float
        Time step t.
    probe : int
        The middle vertex of the largest component, from which heat was sent.
    reached, non_positive, stages : int
        Vertices connected to the probe; those with heat that was not positive; solves for the range
        of the heat, 0 without heat.
    notes : mapping
        Findings and decisions of the operator.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> diagnosis = gt.GeodesicSolver(gt.testing.shapes.grid(5)).diagnosis
    >>> diagnosis.components, diagnosis.boundary_vertices, round(diagnosis.minimum_angle)
    (1, 16, 45)
    """

    domain: str
    operator: str
    components: int
    coarse_components: int
    isolated_vertices: int
    boundary_vertices: int
    seam_edges: int
    seam_tolerance: float | None
    non_manifold_edges: int | None
    minimum_angle: float | None
    positive_off_diagonals: float
    refined: bool
    across: bool
    reason: str
    spacing: float
    time: float
    probe: int
    reached: int
    non_positive: int
    stages: int
    notes: Mapping[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain Python objects, for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        rows = {**self.as_dict(), **{f"notes.{key}": value for key, value in self.notes.items()}}
        del rows["notes"]
        width = max(map(len, rows))
        return "\n".join(f"{key.ljust(width)}  {_shown(value)}" for key, value in rows.items())


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def diagnose(
    domain: Domain,
    operator: object,
    method: HeatMethod,
    reason: str = "",
    seams: Seams | None = None,
) -> Diagnosis:
    """Return the diagnosis of `domain` for `method`; `reason` is its reason to refine or not."""
    metric = method.metric
    sizes = np.bincount(metric.components)
    members = np.flatnonzero(metric.components == sizes.argmax())
    probe = int(members[len(members) // 2])
    report = method.heat_report(probe) if method.flows else HeatReport(int(sizes.max()), 0, 0)
    manifold, angle = _face_quality(domain)
    return Diagnosis(
        domain=repr(domain),
        operator=repr(operator),
        components=int((sizes > 1).sum()),
        coarse_components=(
            coarse_components(domain, metric.components) if isinstance(domain, TriangleMesh) else 0
        ),
        isolated_vertices=_isolated(metric),
        boundary_vertices=int(metric.boundary.sum()),
        seam_edges=0 if seams is None else seams.edges,
        seam_tolerance=None if seams is None else seams.tolerance,
        non_manifold_edges=manifold,
        minimum_angle=angle,
        positive_off_diagonals=_positive_share(method.diffusion),
        refined=method.refine,
        across=method.across,
        spacing=metric.spacing,
        time=method.time,
        probe=probe,
        reached=report.reached,
        non_positive=report.non_positive,
        stages=report.stages,
        notes={**metric.notes, **_local_dimensions(method), **_noise(method)},
        reason=reason,
    )


def _noise(method: HeatMethod) -> dict[str, Any]:
    """Return the share of squared edge lengths that fronts subtract as noise, by name."""
    across = method.metric.across_edges
    return {"noise": across.noise} if method.across and across is not None else {}


def _isolated(metric: Discretization) -> int:
    """Return the number of vertices without connections and without duplicates."""
    alone = np.bincount(metric.components)[metric.components] == 1
    others = metric.representatives
    if len(others):
        alone &= np.bincount(others, minlength=len(others))[others] == 1
    return int(alone.sum())


def _local_dimensions(method: HeatMethod) -> dict[str, Any]:
    """Return the 5th, 50th and 95th percentile of the local dimensions of a graph, by name."""
    found = method.local_dimensions
    if found is None or np.isnan(found).all():
        return {}
    low, middle, high = np.nanpercentile(found, [5, 50, 95]).round(2).tolist()
    return {"local_dimensions": (low, middle, high)}


def _positive_share(discretization: Discretization) -> float:
    stiffness = discretization.stiffness
    rows = np.repeat(np.arange(stiffness.shape[0]), np.diff(stiffness.indptr))
    off_diagonal = stiffness.data[(rows != stiffness.indices) & (stiffness.data != 0)]
    rounding = 1e-12 * np.abs(off_diagonal).max(initial=0.0)
    return float((off_diagonal > rounding).mean()) if off_diagonal.size else 0.0


def _face_quality(domain: Domain) -> tuple[int | None, float | None]:
    """Return the number of non-manifold edges and the smallest angle in degrees, of a mesh."""
    if not isinstance(domain, TriangleMesh):
        return None, None
    faces = domain.faces[proper_faces(domain.faces)]
    _, face_counts = edges_of_faces(faces, domain.n_vertices)
    length, along, height = frames_from_positions(domain.vertices, faces).T
    first = np.arctan2(height, along)
    second = np.arctan2(height, length - along)
    smallest = np.minimum(np.minimum(first, second), np.pi - first - second).min()
    angle = float(np.degrees(smallest)) if np.isfinite(smallest) else 0.0
    return int((face_counts > 2).sum()), max(angle, 0.0)
