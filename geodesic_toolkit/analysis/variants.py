"""Variants to compare on a shape: operators, time steps, diffusions, boundaries, solvers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import PluginLoadError
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.laplacians.uniform import UniformLaplacian
from geodesic_toolkit.registry import catalog

__all__ = ["DEFAULT", "PLAIN", "Variant", "variants_for"]

DEFAULT = "auto"
"""Name of the variant of a :class:`GeodesicSolver` without options."""

PLAIN = "plain heat"
"""Name of the same with ``refine=False``; all other variants are plain heat too, unless their name
says that they are refined."""


@dataclass(frozen=True)
class Variant:
    """A variant of computing distances, with its name and options.

    Attributes
    ----------
    name : str
        Unique in a comparison.
    group : str
        The option that varies: "default", "operator", "time", "diffusion", "boundary", "solver",
        "refinement" or "domain".
    options : mapping
        Options of :class:`GeodesicSolver`.
    domain : Domain, optional
        The domain of the computation, if not the shape itself; vertices correspond.
    """

    name: str
    group: str
    options: Mapping[str, Any] = field(default_factory=dict)
    domain: Domain | None = None


def variants_for(domain: Any) -> list[Variant]:
    """Return the variants that are worth comparing on a shape, the default first.

    They are: every installed operator that takes the shape, on meshes with its options, other
    diffusions, the cloud of the vertices and the graph of the edges; a quarter and four times the
    default time step; other boundary conditions; conjugate gradients for the Poisson step. All are
    variants of plain heat, which shows the differences; some operators are refined as well.

    Parameters
    ----------
    domain : Domain or object
        A shape, or an object that :func:`as_domain` converts to one.

    Returns
    -------
    list of Variant

    Raises
    ------
    UnsupportedDomainError
        The object is not a shape.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> [variant.name for variant in gt.variants_for(gt.testing.shapes.grid(3))][:2]
    ['auto', 'plain heat']
    """
    domain = as_domain(domain)
    found = [Variant(DEFAULT, "default"), _plain(PLAIN, "refinement")]
    found += _operators(domain)
    found += [_plain(f"time factor {factor:g}", "time", time_factor=factor) for factor in (0.25, 4)]
    mesh = domain if isinstance(domain, TriangleMesh) else None
    if mesh is not None:
        unit = UniformLaplacian(mass="identity")
        found += [
            _plain("uniform diffusion, t = h²", "diffusion", diffusion=unit),
            _plain("uniform diffusion, t = 1", "diffusion", diffusion=unit, time=1.0),
        ]
    if mesh is None or not _is_closed(mesh):
        found += [
            _plain(f"{condition} boundary", "boundary", boundary=condition)
            for condition in ("dirichlet", "average")
        ]
    found.append(_plain("cg for Poisson", "solver", solver={"poisson": "cg"}))
    return found if mesh is None else [*found, *_elsewhere(mesh)]


def _plain(name: str, group: str, **options: Any) -> Variant:
    return Variant(name, group, {"refine": False, **options})


def _is_closed(mesh: TriangleMesh) -> bool:
    _, face_counts = edges_of_faces(mesh.faces[proper_faces(mesh.faces)], mesh.n_vertices)
    return bool((face_counts > 1).all())


def _operators(domain: Domain) -> Iterator[Variant]:
    for name in catalog.operators:
        try:
            operator = catalog.operators[name]
        except PluginLoadError:  # skip a broken plugin; `geodesic-toolkit plugins` shows it
            continue
        if isinstance(domain, operator.domains):
            yield _plain(name, "operator", operator=name)
    if isinstance(domain, TriangleMesh):
        delaunay = CotanLaplacian(intrinsic_delaunay=True)
        yield _plain("cotan, intrinsic Delaunay", "operator", operator=delaunay)
        voronoi = CotanLaplacian(mass="voronoi")
        yield _plain("cotan, Voronoi mass", "operator", operator=voronoi)
        options = {"operator": delaunay}
        yield Variant("cotan, intrinsic Delaunay, refined", "refinement", options)


def _elsewhere(mesh: TriangleMesh) -> Iterator[Variant]:
    """Yield variants without the faces: the vertices as a cloud, the edges as a graph."""
    faces = mesh.faces[proper_faces(mesh.faces)]
    used = np.isin(np.arange(mesh.n_vertices), faces)
    cloud = PointCloud(np.where(used[:, None], mesh.vertices, np.nan))
    yield Variant("cloud of the vertices", "domain", {"refine": False}, cloud)
    yield Variant("cloud of the vertices, refined", "domain", domain=cloud)
    yield Variant("graph of the edges", "domain", domain=mesh.as_graph())
