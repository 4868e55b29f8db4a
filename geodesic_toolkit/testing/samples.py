"""Domains with known distances, on which operators are measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import (
    Domain,
    Graph,
    IntrinsicMesh,
    MetricMesh,
    PointCloud,
    TriangleMesh,
)
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.testing import shapes

__all__ = ["DomainSamples", "Sample", "samples_of"]

Kind = TypeVar("Kind", bound=Domain)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """A domain with known distances.

    Parameters
    ----------
    name : str
        Name for reports.
    domain : Domain
        Connected, without isolated vertices.
    dim : int
        Its dimension: 1 for a curve, 2 for a surface, 3 for a solid.
    positions : ndarray of shape (N, d)
        Positions of its vertices in the Euclidean space of its lengths.
    source : int
        A vertex.
    distance : ndarray of shape (N,)
        The distance of every vertex from the source, by a closed form.
    spacing : float
        Its mean edge length, or an equivalent length.
    measure : float
        Its length, area or volume.
    error : float
        The largest mean relative error of a distance that the contract allows.
    inner : ndarray of shape (N,), bool, optional
        On a flat sample, the vertices well away from its boundary; None for a curved one.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sample = gt.testing.samples_of([gt.TriangleMesh])[0].families[0][0]
    >>> sample.dim, float(sample.distance[sample.source])
    (2, 0.0)
    """

    name: str
    domain: Domain
    dim: int
    positions: FloatArray
    source: int
    distance: FloatArray
    spacing: float
    measure: float
    error: float
    inner: BoolArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class DomainSamples(Generic[Kind]):
    """The samples of one kind of domain that the checks need.

    The core has them for meshes, clouds and graphs. A plugin's kind of domain returns them from
    its classmethod ``samples()``, or they are passed as ``samples=``.

    Parameters
    ----------
    kind : type
        The kind of domain.
    families : sequence of sequences of Sample
        Each family is one shape, from coarse to fine.
    generic : Domain
        A shape without symmetry and without equal distances.
    permuted : callable, optional
        From a domain and a permutation p to the same domain whose vertex i is the old ``p[i]``;
        None if the order of vertices is part of the kind, as that of voxels is.
    united : callable, optional
        From two domains to their disconnected union: the vertices of the first come first.
    isolated : callable, optional
        From a domain to the same with an additional last vertex that is isolated.
    moved : callable, optional
        From a domain, a rotation matrix (3, 3) and a shift (3,) to the moved domain; None if the
        domain has no positions.
    scaled : callable, optional
        From a domain and a factor to the domain with lengths multiplied by it.
    degenerate : sequence of Domain
        Valid domains that may have no distances to compute.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.samples_of([gt.Graph])[0].kind
    <class 'geodesic_toolkit.domains.graph.Graph'>
    """

    kind: type[Kind]
    families: Sequence[Sequence[Sample]]
    generic: Kind
    permuted: Callable[[Kind, IntArray], Kind] | None = None
    united: Callable[[Kind, Kind], Kind] | None = None
    isolated: Callable[[Kind], Kind] | None = None
    moved: Callable[[Kind, FloatArray, FloatArray], Kind] | None = None
    scaled: Callable[[Kind, float], Kind] | None = None
    degenerate: Sequence[Kind] = ()


def samples_of(kinds: Sequence[type[Domain]]) -> list[DomainSamples[Any]]:
    """Return the samples of `kinds` of domain: the core's own, or those of :meth:`Domain.samples`.

    Parameters
    ----------
    kinds : sequence of types
        Kinds of domain, as in ``operator.domains``.

    Returns
    -------
    list of DomainSamples
        One for each kind.

    Raises
    ------
    InvalidOptionError
        A kind has no samples.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.testing.samples import samples_of
    >>> [len(family) for family in samples_of([gt.TriangleMesh])[0].families]
    [2, 2]
    """
    missing = [k.__name__ for k in kinds if k not in _MAKERS and not k.has("samples")]
    if missing:
        raise InvalidOptionError(
            f"there are no samples of {', '.join(missing)}: pass samples=[DomainSamples(...)], or "
            "implement the classmethod samples() of Domain"
        )
    return [_MAKERS[kind]() if kind in _MAKERS else kind.samples() for kind in kinds]


MEAN_ERROR = 0.05
"""Mean relative error allowed at about 20 edges across: correct operators have 0.5 to 3.5 %."""

SEGMENT_ERROR = 0.01
"""Mean relative error allowed on a segment, where only the ends cause errors."""

PLANE = (11, 21)
"""Number of vertices along the side of the square, coarse and fine."""

SPHERE = (2, 3)
"""Levels of the icosphere: 162 and 642 vertices."""

SEGMENT = (17, 65)
"""Number of vertices of the segment, coarse and fine."""

SEPARATING_SHIFT = np.array([10.0, 0.0, 0.0])
"""Shift that separates one sample from another."""

MISSING_POINT = [np.nan, 0.0, 0.0]
"""Position of a missing point."""


def _plane(n: int, domain: Domain, spacing: float, positions: FloatArray) -> Sample:
    """Return the unit square as a sample, with distances from its centre."""
    source = int(np.abs(positions - 0.5).sum(axis=1).argmin())
    return Sample(
        name=f"plane, {n} x {n} {type(domain).__name__}",
        domain=domain,
        dim=2,
        positions=positions,
        source=source,
        distance=np.linalg.norm(positions - positions[source], axis=1),
        spacing=spacing,
        measure=1.0,
        error=MEAN_ERROR,
        inner=_near_the_middle(positions),
    )


def _near_the_middle(positions: FloatArray) -> BoolArray:
    inside: BoolArray = np.abs(positions - 0.5).max(axis=1) < 0.3
    return inside


def _sphere(domain: Domain, spacing: float, positions: FloatArray) -> Sample:
    """Return the unit sphere as a sample."""
    cosine = np.clip(positions @ positions[0], -1.0, 1.0)
    return Sample(
        name=f"sphere, {len(positions)} vertices, {type(domain).__name__}",
        domain=domain,
        dim=2,
        positions=positions,
        source=0,
        distance=np.arccos(cosine),
        spacing=spacing,
        measure=4 * np.pi,
        error=MEAN_ERROR,
    )


def _segment(n: int) -> Sample:
    """Return the unit interval as a path."""
    positions = np.linspace(0.0, 1.0, n)
    edges = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    return Sample(
        name=f"segment, {n} vertices, Graph",
        domain=Graph(n, edges, np.full(n - 1, 1 / (n - 1))),
        dim=1,
        positions=positions[:, None],
        source=0,
        distance=positions,
        spacing=1 / (n - 1),
        measure=1.0,
        error=SEGMENT_ERROR,
        inner=_near_the_middle(positions[:, None]),
    )


def _spacing(mesh: TriangleMesh) -> float:
    return float(mesh.as_graph().lengths.mean())


def _lumpy(level: int = 2) -> TriangleMesh:
    """Return an ellipsoid with lumps: a closed surface without symmetry."""
    ball = shapes.icosphere(level)
    x, y, z = ball.vertices.T
    radius = 1 + 0.1 * np.sin(3 * x + 1) + 0.07 * np.cos(4 * y + z) + 0.05 * np.sin(2 * z + x)
    return TriangleMesh(ball.vertices * radius[:, None] * [1.0, 0.8, 0.65], ball.faces)


def _mesh_samples() -> DomainSamples[TriangleMesh]:
    squares = [(n, shapes.grid(n)) for n in PLANE]
    balls = [shapes.icosphere(level) for level in SPHERE]
    point, line = np.ones((3, 3)), np.outer([0.0, 1.0, 2.0], [1.0, 0.0, 0.0])
    triangle = np.eye(3)
    return DomainSamples(
        kind=TriangleMesh,
        families=(
            [_plane(n, m, _spacing(m), m.vertices[:, :2]) for n, m in squares],
            [_sphere(m, _spacing(m), m.vertices) for m in balls],
        ),
        generic=_lumpy(),
        permuted=lambda m, order: TriangleMesh(m.vertices[order], np.argsort(order)[m.faces]),
        united=lambda first, second: shapes.disjoint_union(
            first, TriangleMesh(second.vertices + SEPARATING_SHIFT, second.faces)
        ),
        isolated=lambda m: TriangleMesh(np.concatenate([m.vertices, [[0.1, 0.2, 0.3]]]), m.faces),
        moved=lambda m, rotation, shift: TriangleMesh(m.vertices @ rotation.T + shift, m.faces),
        scaled=lambda m, factor: TriangleMesh(m.vertices * factor, m.faces),
        degenerate=(
            TriangleMesh(triangle, [[0, 1, 2]]),
            TriangleMesh(triangle, [[0, 1, 2], [0, 1, 2], [2, 1, 0]]),
            TriangleMesh(triangle, [[0, 0, 1], [0, 1, 2]]),
            TriangleMesh(triangle, [[0, 0, 0]]),
            TriangleMesh(point, [[0, 1, 2]]),
            TriangleMesh(line, [[0, 1, 2]]),
        ),
    )


def _cloud_samples() -> DomainSamples[PointCloud]:
    squares = [(n, shapes.grid(n)) for n in PLANE]
    balls = [shapes.icosphere(level) for level in SPHERE]
    return DomainSamples(
        kind=PointCloud,
        families=(
            [_plane(n, PointCloud(m.vertices), _spacing(m), m.vertices[:, :2]) for n, m in squares],
            [_sphere(PointCloud(m.vertices), _spacing(m), m.vertices) for m in balls],
        ),
        generic=PointCloud(_lumpy().vertices),
        permuted=lambda c, order: PointCloud(c.points[order]),
        united=lambda first, second: PointCloud(
            np.concatenate([first.points, second.points + SEPARATING_SHIFT])
        ),
        isolated=lambda c: PointCloud(np.concatenate([c.points, [MISSING_POINT]])),
        moved=lambda c, rotation, shift: PointCloud(c.points @ rotation.T + shift),
        scaled=lambda c, factor: PointCloud(c.points * factor),
        degenerate=(
            PointCloud([[0, 0, 0]]),
            PointCloud([[0.0, 0.0, 0.0], MISSING_POINT]),
            PointCloud([[0, 0, 0], [1, 0, 0]]),
            PointCloud([[0, 0, 0], [1, 0, 0], [0, 1, 0]]),
            PointCloud(np.zeros((40, 3))),
            PointCloud(np.linspace(0, 1, 40)[:, None] * [1.0, 2.0, 3.0]),
            PointCloud(np.repeat(shapes.grid(5).vertices, 2, axis=0)),
        ),
    )


def _graph_samples() -> DomainSamples[Graph]:
    squares = [(n, *_lattice(n)) for n in PLANE]
    balls = [shapes.icosphere(level) for level in SPHERE]
    return DomainSamples(
        kind=Graph,
        families=(
            [_segment(n) for n in SEGMENT],
            [_plane(n, graph, 1 / (n - 1), positions) for n, graph, positions in squares],
            [_sphere(m.as_graph(), _spacing(m), m.vertices) for m in balls],
        ),
        generic=_lumpy().as_graph(),
        permuted=lambda g, order: Graph(g.n_vertices, np.argsort(order)[g.edges], g.lengths),
        united=lambda first, second: Graph(
            first.n_vertices + second.n_vertices,
            np.concatenate([first.edges, second.edges + first.n_vertices]),
            np.concatenate([first.lengths, second.lengths]),
        ),
        isolated=lambda g: Graph(g.n_vertices + 1, g.edges, g.lengths),
        scaled=lambda g, factor: Graph(g.n_vertices, g.edges, g.lengths * factor),
        degenerate=(
            Graph(1, []),
            Graph(3, []),
            Graph(2, [[0, 0], [1, 1]]),
            Graph(2, [[0, 1]]),
            Graph(3, [[0, 1], [1, 0], [0, 1], [1, 2]], [1.0, 2.0, 3.0, 1.0]),
        ),
    )


def _lattice(n: int) -> tuple[Graph, FloatArray]:
    """Return the square grid of n x n vertices on the unit square, without diagonals."""
    index = np.arange(n * n).reshape(n, n)
    along = np.column_stack([index[:, :-1].ravel(), index[:, 1:].ravel()])
    across = np.column_stack([index[:-1].ravel(), index[1:].ravel()])
    edges = np.concatenate([along, across])
    return Graph(n * n, edges, np.full(len(edges), 1 / (n - 1))), shapes.grid(n).vertices[:, :2]


def _intrinsic(mesh: TriangleMesh) -> IntrinsicMesh:
    """Return a mesh without degenerate faces by its edge lengths."""
    return IntrinsicMesh(mesh.faces, MetricMesh(mesh, cost=1.0).lengths, mesh.n_vertices)


def _remeasured(sample: Sample, domain: Domain) -> Sample:
    name = sample.name.replace(TriangleMesh.__name__, type(domain).__name__)
    return replace(sample, name=name, domain=domain)


def _intrinsic_samples() -> DomainSamples[IntrinsicMesh]:
    meshes = _mesh_samples()
    return DomainSamples(
        kind=IntrinsicMesh,
        families=[
            [_remeasured(one, _intrinsic(_mesh_of(one))) for one in family]
            for family in meshes.families
        ],
        generic=_intrinsic(meshes.generic),
        permuted=lambda m, order: IntrinsicMesh(
            np.argsort(order)[m.faces], m.lengths, m.n_vertices
        ),
        united=lambda first, second: IntrinsicMesh(
            np.concatenate([first.faces, second.faces + first.n_vertices]),
            np.concatenate([first.lengths, second.lengths]),
            first.n_vertices + second.n_vertices,
        ),
        isolated=lambda m: IntrinsicMesh(m.faces, m.lengths, m.n_vertices + 1),
        scaled=lambda m, factor: IntrinsicMesh(m.faces, m.lengths * factor, m.n_vertices),
        degenerate=(
            IntrinsicMesh([[0, 1, 2]], [[1.0, 1.0, 1.0]]),
            IntrinsicMesh([[0, 1, 2]], [[1.0, 1.0, 2.0]]),
            IntrinsicMesh([[0, 0, 1]], [[1.0, 1.0, 1.0]]),
        ),
    )


def _mesh_of(sample: Sample) -> TriangleMesh:
    assert isinstance(sample.domain, TriangleMesh)  # for the type checker
    return sample.domain


COST = 2.0
"""Cost of a sample; distances by closed forms are multiplied by it."""


def _weighted(mesh: TriangleMesh) -> MetricMesh:
    return MetricMesh(mesh, cost=COST)


def _mesh_within(domain: MetricMesh) -> TriangleMesh:
    return TriangleMesh(domain.vertices, domain.faces)


def _metric_samples() -> DomainSamples[MetricMesh]:
    meshes = _mesh_samples()
    assert meshes.permuted
    assert meshes.united
    assert meshes.isolated
    permuted, united, isolated = meshes.permuted, meshes.united, meshes.isolated
    return DomainSamples(
        kind=MetricMesh,
        families=[
            [
                replace(
                    _remeasured(one, _weighted(_mesh_of(one))),
                    positions=COST * one.positions,
                    distance=COST * one.distance,
                    spacing=COST * one.spacing,
                    measure=COST**2 * one.measure,
                )
                for one in family
            ]
            for family in meshes.families
        ],
        generic=_weighted(meshes.generic),
        permuted=lambda m, order: _weighted(permuted(_mesh_within(m), order)),
        united=lambda first, second: _weighted(united(_mesh_within(first), _mesh_within(second))),
        isolated=lambda m: _weighted(isolated(_mesh_within(m))),
        scaled=lambda m, factor: _weighted(TriangleMesh(m.vertices * factor, m.faces)),
        degenerate=tuple(map(_weighted, meshes.degenerate)),
    )


_MAKERS: Mapping[type[Domain], Callable[[], DomainSamples[Any]]] = {
    TriangleMesh: _mesh_samples,
    PointCloud: _cloud_samples,
    Graph: _graph_samples,
    MetricMesh: _metric_samples,
    IntrinsicMesh: _intrinsic_samples,
}
