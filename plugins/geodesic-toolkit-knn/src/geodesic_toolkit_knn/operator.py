"""The Laplacian of samples: curves by their order, surfaces by stars, others by a graph."""

import warnings
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, final

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    GeodesicWarning,
    InvalidDiscretizationError,
    InvalidOptionError,
    UnsupportedDomainError,
)
from geodesic_toolkit_knn.domain import KNNGraph, Neighbourhoods
from geodesic_toolkit_knn.planes import charts, growth_of_roughness
from geodesic_toolkit_knn.tables import FloatArray, IntArray

__all__ = ["HighDimensionWarning", "KNNLaplacian"]

SMOOTH = (0.95, 1.15)
"""Growth of the roughness up to which distances are measured along the principal directions, and
from which on in space; in between in part. Those of ``PointCloudLaplacian`` in space."""

MIN_PLACES = 4
"""Places that a chart needs."""

MIN_CANDIDATES = 24
"""Neighbours that a star may take where the graph has less than half as many. Errors are alike with
20 and 24; 16 leave gaps, and 30 reach the next sheet of a roll of 400 samples: 5 % for 0.5 %."""


MAX_DIMENSION_OF_GRAPHS = 3
"""Dimension up to which distances across a graph of neighbours are within 5 %. In cubes they are
2 to 3 % off in 3 dimensions, 9 % in 4, 16 to 18 % in 5 and 28 to 45 % in 10."""


class HighDimensionWarning(GeodesicWarning):
    """Samples have too many dimensions for their neighbours to show distances within 5 %."""


@final
@dataclass(frozen=True, kw_only=True)
class KNNLaplacian(gt.LaplaceOperator):
    """Laplacian of samples in any dimension; L is -Δ, positive semidefinite.

    The dimension of the domain decides how it is made:

    - 1, a curve: each sample is connected to the next on either side, along its tangent, and
      distances go along these edges.
    - 2, a surface: the star of the Delaunay triangulation in the plane about each sample, as on
      point clouds, and fronts that cross its triangles.
    - 3 and more, neighbours without points, or another metric than the Euclidean: the graph of
      the neighbours, as :class:`~geodesic_toolkit.UniformLaplacian` has it.

    Parameters
    ----------
    way : {"auto", "charts", "graph"}
        "auto" as above; "charts" insists on the first two; "graph" takes the last for all.

    Raises
    ------
    InvalidOptionError
        A value outside the ones above.

    References
    ----------
    N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, Computer Graphics Forum 39,
    2020, section 5.7, https://doi.org/10.1111/cgf.14069

    J. B. Tenenbaum, V. de Silva, J. C. Langford, *A Global Geometric Framework for Nonlinear
    Dimensionality Reduction*, Science 290, 2000, https://doi.org/10.1126/science.290.5500.2319

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_knn import KNNGraph
    >>> u, v = np.random.default_rng(0).random((2, 1000)) * 2 * np.pi
    >>> u[:2], v[:2] = [0, 1], [0, 1]
    >>> torus = KNNGraph(np.column_stack([np.cos(u), np.sin(u), np.cos(v), np.sin(v)]))
    >>> round(float(gt.geodesic_distance(torus, 0)[1]), 2)  # sqrt(2)
    1.41
    """

    way: Literal["auto", "charts", "graph"] = "auto"

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (KNNGraph,)
    references: ClassVar[tuple[str, ...]] = ("10.1111/cgf.14069", "10.1126/science.290.5500.2319")

    def __post_init__(self) -> None:
        if self.way not in ("auto", "charts", "graph"):
            raise InvalidOptionError(f'way must be "auto", "charts" or "graph", not {self.way!r}')

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on samples.

        Parameters
        ----------
        domain : KNNGraph

        Returns
        -------
        Discretization
            Its notes hold ``way`` ("curve", "surface" or "graph"), ``why`` where it is the last,
            ``dimension``, ``dimension_estimate``, ``k``, and for the first two ``growth``, of the
            roughness, and ``links``, connections of the graph that had to be added.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain; ``way="charts"`` where there cannot be any.

        Warns
        -----
        HighDimensionWarning
            The dimension is 4 or more: distances are more than 5 % too long.
        """
        self.check_domain(domain)
        assert isinstance(domain, KNNGraph)  # for the type checker; check_domain has raised
        notes: dict[str, Any] = {
            "dimension": domain.dimension,
            "dimension_estimate": domain.dimension_estimate,
            "k": domain.k,
        }
        why = "asked for" if self.way == "graph" else _why_no_charts(domain)
        if why and self.way == "charts":
            raise UnsupportedDomainError(f'way="charts": {why}')
        found = domain.neighbourhoods
        if domain.dimension > MAX_DIMENSION_OF_GRAPHS:
            warnings.warn(
                f"samples of dimension {domain.dimension}: distances across the graph of their "
                "neighbours are 9 to 45 % too long, and the more so the higher the dimension; "
                "give dimension= if the estimate "
                f"({domain.dimension_estimate:.1f}) is that of noise",
                HighDimensionWarning,
                stacklevel=2,
            )
        if why or found is None:
            metric = gt.UniformLaplacian().assemble(domain.as_graph())
            notes = {**metric.notes, **notes, "way": "graph", "why": why}
            return replace(metric, notes=notes, copy=False)
        if domain.dimension == 1:
            return _curve(domain, found, notes)
        return _surface(domain, found, notes)

    def diffusion(self, metric: gt.Discretization) -> gt.Discretization:
        """Return the positive part of `metric`, as stars may disagree on the sign of an edge."""
        return gt.positive_part(metric) if metric.notes.get("way") == "surface" else metric


def _why_no_charts(domain: KNNGraph) -> str:
    """Return why there are no charts of a domain, "" where there are."""
    found = domain.neighbourhoods
    if found is None:
        return "neighbours were given, and no points"
    if domain.metric != "euclidean":
        return f"charts need Euclidean distances, and the metric is {domain.metric!r}"
    if len(found.centres) < MIN_PLACES:
        return f"there are {len(found.centres)} samples at different places"
    if domain.dimension > 2:
        return f"the dimension is {domain.dimension}, and charts are for curves and surfaces"
    return ""


def _laid_out(domain: KNNGraph, found: Neighbourhoods) -> tuple[FloatArray, float, float]:
    """Return charts in the unit of the data, how far they are those in space, and the growth."""
    used = max(2 * domain.k, MIN_CANDIDATES)
    growth = growth_of_roughness(found.places, found.near, domain.dimension)
    in_space = float(np.clip((growth - SMOOTH[0]) / (SMOOTH[1] - SMOOTH[0]), 0, 1))
    coordinates = charts(
        found.places,
        found.near,
        domain.dimension,
        k=domain.k,
        in_space=in_space,
        noisy=in_space < 1,
    )
    return coordinates[:, :used] * found.scale, in_space, growth


def _surface(domain: KNNGraph, found: Neighbourhoods, notes: dict[str, Any]) -> gt.Discretization:
    coordinates, in_space, growth = _laid_out(domain, found)
    notes = {**notes, "way": "surface", "growth": growth}
    positions = None
    if in_space == 1:
        assert domain.points is not None  # for the type checker
        positions = np.zeros((domain.n_vertices, found.places.shape[1]))
        positions[found.centres] = found.places * found.scale
    options: dict[str, Any] = {
        "n_vertices": domain.n_vertices,
        "centres": found.centres,
        "k": max(domain.k, MIN_PLACES),
        "positions": positions,
        "representatives": _representatives(domain, found),
    }
    charts_of = (found.centres[found.near[:, : coordinates.shape[1]]], coordinates)
    try:
        metric = gt.discretization_of_charts(*charts_of, **options, notes=notes)
    except InvalidDiscretizationError as error:
        raise UnsupportedDomainError(
            f"{error}: all samples lie on one line; give KNNGraph dimension=1"
        ) from error
    edges, lengths = _edges(domain, found)
    parts = metric.components[edges]
    links = _between(parts, lengths)
    if not len(links):
        return metric
    return gt.discretization_of_charts(
        *charts_of, **options, notes=notes, links=edges[links], link_lengths=lengths[links]
    )


def _curve(domain: KNNGraph, found: Neighbourhoods, notes: dict[str, Any]) -> gt.Discretization:
    coordinates, _, growth = _laid_out(domain, found)
    along = coordinates[:, :, 0]
    ends, far = [], []
    for side in (along, -along):
        ahead = np.where(side > 0, side, np.inf)  # neither those behind nor NaN
        column = ahead.argmin(axis=1)
        rows = np.flatnonzero(np.isfinite(ahead[np.arange(len(ahead)), column]))
        ends.append(np.column_stack([rows, found.near[rows, column[rows]]]))
        far.append(ahead[rows, column[rows]])
    own = found.centres[np.concatenate(ends)]
    edges, lengths = _edges(domain, found)
    pairs = coo_array((np.ones(len(own)), tuple(own.T)), shape=(domain.n_vertices,) * 2)
    parts = connected_components(pairs, directed=False)[1].astype(np.int64)
    links = _between(parts[edges], lengths)
    again = np.flatnonzero(domain.as_graph().lengths == 0)
    graph = gt.Graph(
        domain.n_vertices,
        np.concatenate([own, edges[links], domain.as_graph().edges[again]]),
        np.concatenate([*far, lengths[links], np.zeros(len(again))]),
    )
    metric = gt.UniformLaplacian(dim=1).assemble(graph)
    assert metric.along_edges is not None  # for the type checker: graphs have them
    paths = replace(metric.along_edges, instead_of_heat="the samples lie on a curve")
    notes = {**notes, "way": "curve", "growth": growth, "links": len(links)}
    return replace(metric, along_edges=paths, notes=notes, copy=False)


def _edges(domain: KNNGraph, found: Neighbourhoods) -> tuple[IntArray, FloatArray]:
    """Return the edges (E, 2) of the graph between places, and their lengths."""
    ends = np.repeat(found.centres, domain.k)
    near = found.centres[found.near[:, : domain.k]].ravel()
    return np.column_stack([ends, near]), found.far[:, : domain.k].ravel()


def _between(parts: IntArray, lengths: FloatArray) -> IntArray:
    """Return which edges connect all parts that edges connect, the shortest of them.

    `parts` are those of both ends of each edge, (E, 2).
    """
    between = np.flatnonzero(parts[:, 0] != parts[:, 1])
    if not len(between):
        return between
    pairs, rank = np.unique(np.sort(parts[between], axis=1), axis=0, return_inverse=True)
    order = np.lexsort((lengths[between], rank.ravel()))
    _, first = np.unique(rank.ravel()[order], return_index=True)
    shortest = between[order[first]]
    count = int(parts.max()) + 1
    weights = coo_array((lengths[shortest], tuple(pairs.T)), shape=(count, count))
    tree = minimum_spanning_tree(weights.tocsr()).tocoo()
    number = coo_array((np.arange(1, len(pairs) + 1), tuple(pairs.T)), shape=(count, count))
    chosen = np.asarray(number.tocsr()[tree.row, tree.col]).ravel().astype(np.int64) - 1
    return np.sort(shortest[chosen])


def _representatives(domain: KNNGraph, found: Neighbourhoods) -> IntArray | None:
    """Return the first sample at the place of each, or None where all places differ."""
    graph = domain.as_graph()
    again = graph.edges[graph.lengths == 0]
    if not len(again):
        return None
    representatives = np.arange(domain.n_vertices)
    first = np.zeros(domain.n_vertices, dtype=np.bool_)
    first[found.centres] = True
    other = np.where(first[again[:, 0]], again[:, 1], again[:, 0])
    representatives[other] = again.sum(axis=1) - other
    return representatives
