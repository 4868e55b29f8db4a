"""`attach`: put values of vertices back on the object of another library that has the vertices."""

import numbers
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, positions_of
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.welding import merged_positions, rounding_of
from geodesic_toolkit.interop import names
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.interop.members import hemispheres, only_member
from geodesic_toolkit.interop.names import check_name
from geodesic_toolkit.interop.refusals import described

__all__ = ["attach"]

Values: TypeAlias = np.ndarray[Any, Any]

TAKEN = (
    "a mesh or cloud of trimesh, Open3D, PyVista or meshio, a scene or blocks with one of them, a "
    "PolyMesh or SurfaceImage of nilearn, an AnnData or a networkx graph"
)

OF_OTHER_VERTICES = (
    ". After merged, new = merge_vertices(...) attach distance[new]; for a shape whose vertices "
    "are in another order, as those of its file, give it: attach(obj, distance, domain=shape)"
)
"""Advice for values of other vertices than those of the object."""


class Holder(NamedTuple):
    """An object that holds values of vertices, and how to put them there.

    Attributes
    ----------
    n_vertices : int
    put : callable
        Takes the values; returns a new object that holds them, or None if `obj` does.
    positions : array-like of shape (N, 2) or (N, 3), optional
        Positions of the vertices.
    """

    n_vertices: int
    put: Callable[[Values], Any]
    positions: Any = None


def attach(
    obj: Any,
    distance: ArrayLike | Mapping[str, ArrayLike],
    name: str = "distance",
    *,
    domain: Any = None,
    fill: float | None = None,
) -> Any:
    """Put distances, or other values of vertices, on the object that has the vertices.

    Value i belongs to vertex i of the object, as :func:`as_domain` keeps the order of vertices.
    Values of a shape whose vertices were merged, or whose file was read apart, are in another
    order: give that shape as `domain`, and they follow the positions.

    ========================= ==================================================================
    object                    place of the values
    ========================= ==================================================================
    trimesh                   ``mesh.vertex_attributes[name]``; ``cloud.metadata[name]``
    Open3D, tensor            ``mesh.vertex[name]``, ``cloud.point[name]``, on their device, as a
                              column (N, 1), which Open3D writes to files
    Open3D, legacy            the same, on a tensor geometry that is returned: legacy geometries
                              hold only colours and normals
    PyVista, meshio           ``mesh.point_data[name]``
    nilearn                   a SurfaceImage that is returned, whose data are the values; its
                              data have no name
    AnnData                   ``adata.obs[name]``
    networkx                  ``graph.nodes[node][name]``
    a scene, blocks           the only shape that they hold
    ========================= ==================================================================

    Parameters
    ----------
    obj : object
        One that is listed above.
    distance : array-like of shape (N,)
        One value per vertex: distances, or labels. For hemispheres of nilearn a mapping of "left"
        and "right" to one array each.
    name : str
        Name of the values; values of that name are replaced. Names with a meaning in the library,
        such as that of normals, are refused, and those of data that are not one number per vertex.
    domain : Domain or object, optional
        The shape on which the values were measured, if it is not `obj` itself. Its vertices have
        the positions of those of the object, in any order and number.
    fill : float, optional
        Value that replaces infinite distances. By default they stay ``inf``: exporters and colour
        maps of other libraries may need a finite value, or NaN.

    Returns
    -------
    object
        `obj` itself, which was changed; a new object where the table says so.

    Raises
    ------
    InvalidOptionError
        The number of values is not that of the vertices; the name is one that the library uses
        itself, or that of other data; values that are not real numbers; positions of the object
        that the domain lacks.
    UnsupportedDomainError
        An object that is not listed, or holds several shapes.

    See Also
    --------
    Domain.attach : Values on objects of plugins.

    Examples
    --------
    >>> import meshio
    >>> import geodesic_toolkit as gt
    >>> mesh = meshio.Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [("triangle", [[0, 1, 2]])])
    >>> gt.attach(mesh, gt.geodesic_distance(mesh, 1)).point_data["distance"]
    array([3., 0., 5.])
    """
    if not isinstance(name, str) or not name:
        raise InvalidOptionError(f"name must be the name of the values, not {name!r}")
    if fill is not None and (isinstance(fill, bool) or not isinstance(fill, numbers.Real)):
        raise InvalidOptionError(f"fill must be a number or None, not {fill!r}")
    if isinstance(distance, Mapping):
        return _on_hemispheres(obj, {part: _values(distance[part], fill) for part in distance})
    values = _values(distance, fill)
    member = only_member(obj) if hemispheres(obj) is None else None
    target = obj if member is None else member.shape
    holder = next(filter(None, (find(target, name) for find in HOLDERS)), None)
    measured = None if domain is None else as_domain(domain)
    if measured is not None:
        _check_count(values, measured, measured.n_vertices)
        if holder is None and measured.has("attach"):
            return measured.attach(obj, values, name)
    if holder is None:
        raise UnsupportedDomainError(_refusal(target))
    if measured is not None and holder.positions is not None and measured.has("positions"):
        positions = _placed(holder.positions, None if member is None else member.placement)
        values = _in_order_of(positions, measured, values)
    _check_count(values, target, holder.n_vertices, OF_OTHER_VERTICES)
    changed = holder.put(values)
    return obj if changed is None else changed


def _values(distance: Any, fill: float | None) -> Values:
    """Return a copy of the values, with infinite ones replaced."""
    cure = "{}.filled(numpy.inf)"
    check_nothing_masked(distance, "distance", InvalidOptionError, cure)
    try:
        given = np.asarray(distance)
    except (ValueError, TypeError) as error:  # rows of different lengths
        raise InvalidOptionError(f"distance cannot be read as an array: {error}") from error
    kinds = {"b": np.bool_, "i": np.int64, "u": np.int64, "f": np.float64}
    if given.dtype.kind not in kinds:
        raise InvalidOptionError(f"distance must hold real numbers, not {given.dtype}")
    if given.dtype == np.uint64 and (given > np.uint64(np.iinfo(np.int64).max)).any():
        raise InvalidOptionError("distance holds integers that are too large for int64")
    single = given.dtype == np.float32
    values: Values = np.array(given, np.float32 if single else kinds[given.dtype.kind])
    if values.ndim != 1:
        rows = " (attach one row at a time: distances[0])" if values.ndim == 2 else ""
        raise InvalidOptionError(
            f"distance must have one value per vertex, not the shape {values.shape}{rows}"
        )
    if fill is not None and values.dtype.kind == "f":
        values[np.isinf(values)] = fill
    return values


def _check_count(values: Values, obj: Any, count: int, advice: str = "") -> None:
    if len(values) != count:
        raise InvalidOptionError(
            f"distance has {len(values)} values, and {described(obj)} has {count} vertices{advice}"
        )


def _refusal(obj: Any) -> str:
    if isinstance(obj, Domain):
        return f"{a_kind_of(obj)} is immutable; write(file, shape, distance) saves both"
    if hasattr(obj, "coordinates") and hasattr(obj, "faces"):
        return (
            f"{described(obj)} holds no values; give the hemisphere that it is, "
            "nilearn.surface.PolyMesh(left=mesh)"
        )
    return (
        f"{described(obj)} holds no values of vertices that attach knows; give {TAKEN}. A plugin's "
        "own objects need domain=, of a kind that has attach"
    )


# -- vertices in another order ---------------------------------------------------------------------


def _placed(positions: Any, placement: FloatArray | None) -> FloatArray:
    """Return positions in space, (N, 3), where a scene puts them."""
    points = np.asarray(positions, dtype=np.float64)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return points if placement is None else points @ placement[:3, :3].T + placement[:3, 3]


def _in_order_of(theirs: FloatArray, domain: Domain, values: Values) -> Values:
    """Return the values of a domain in the order of the vertices of an object, by position."""
    ours = positions_of(domain)
    rounding = max(rounding_of(part[np.isfinite(part).all(axis=1)]) for part in (ours, theirs))
    if theirs.shape == ours.shape and np.allclose(
        theirs, ours, rtol=0, atol=rounding, equal_nan=True
    ):
        return values
    together = np.concatenate([ours, theirs])
    owner = merged_positions(together, np.full(len(together), rounding))
    found = owner[len(ours) :]
    missing = np.flatnonzero(found >= len(ours))
    if len(missing):
        raise InvalidOptionError(
            f"{len(missing)} of {len(theirs)} vertices of the object are not vertices of the "
            f"domain, which has {len(ours)}; the first is vertex {missing[0]}, at "
            f"{theirs[missing[0]].tolist()}: nothing was measured there"
        )
    _check_one_value(values, owner[: len(ours)], found)
    return np.asarray(values[found])


def _check_one_value(values: Values, owner: IntArray, asked: IntArray) -> None:
    """Raise if coincident vertices of the domain, one of which is asked for, differ in value."""
    differs = values != values[owner]
    differs &= ~(np.isnan(values) & np.isnan(values[owner]))
    bad = np.flatnonzero(differs & np.isin(owner, asked))
    if len(bad):
        one, other = int(owner[bad[0]]), int(bad[0])
        raise InvalidOptionError(
            f"vertices {one} and {other} of the domain are at one position, and their values are "
            f"{values[one]} and {values[other]}: the surface is cut there; measure on "
            "merge_vertices(...), or attach to the object in the order of the domain"
        )


# -- objects that hold values ----------------------------------------------------------------------


def _has(obj: Any, *names: str) -> bool:
    return all(hasattr(obj, name) for name in names)


def _point_data(obj: Any, name: str) -> Holder | None:
    """Find the point data of PyVista and meshio."""
    if not _has(obj, "points", "point_data"):
        return None
    check_name(name, names.POINT_DATA, obj.point_data)
    return Holder(len(obj.points), _putting(obj.point_data, name), obj.points)


def _trimesh(obj: Any, name: str) -> Holder | None:
    """Find the attributes of a mesh, or the metadata of a cloud, of trimesh."""
    if not _has(obj, "vertices", "metadata") or _has(obj, "entities"):  # those are curves
        return None
    if _has(obj, "vertex_attributes"):
        table, fixed = obj.vertex_attributes, names.TRIMESH
    else:
        table, fixed = obj.metadata, names.TRIMESH_CLOUD
    check_name(name, fixed, table)
    return Holder(len(obj.vertices), _putting(table, name), obj.vertices)


def _putting(table: Any, name: str) -> Callable[[Values], None]:
    """Return what puts values into a table of arrays by name."""

    def put(values: Values) -> None:
        table[name] = values

    return put


def _open3d_tensors(obj: Any, name: str) -> Holder | None:
    """Find the attributes of vertices or points whose arrays are tensors, possibly on a GPU."""
    attributes = obj.vertex if _has(obj, "vertex", "triangle") else getattr(obj, "point", None)
    if attributes is None or not hasattr(attributes, "primary_key"):
        return None
    check_name(name, names.OPEN3D, dict(attributes.items()))
    if attributes.primary_key not in attributes:
        raise UnsupportedDomainError(f"{described(obj)} has no vertices")
    positions = attributes[attributes.primary_key]

    def put(values: Values) -> None:  # Open3D writes a column, (N, 1), to files, but not (N,)
        attributes[name] = type(positions)(values[:, None], device=positions.device)

    return Holder(len(positions), put, positions.cpu().numpy())


def _open3d(obj: Any, name: str) -> Holder | None:
    """Find legacy geometries of Open3D, which have no place for values: they become tensors."""
    if _has(obj, "vertices", "triangles", "vertex_colors"):
        points, kind = np.asarray(obj.vertices), "TriangleMesh"
    elif _has(obj, "points", "normals", "has_normals"):
        points, kind = np.asarray(obj.points), "PointCloud"
    else:
        return None

    def put(values: Values) -> Any:
        open3d = require("open3d", "all", "Values on geometries of Open3D need")
        tensors = getattr(open3d.t.geometry, kind).from_legacy(obj, open3d.core.float64)
        return attach(tensors, values, name)

    return Holder(len(points), put, points)


def _anndata(obj: Any, name: str) -> Holder | None:
    """Find the table of observations of AnnData."""
    if not _has(obj, "obs", "obsm", "n_obs"):
        return None
    check_name(name, {**names.TABLE, obj.obs.index.name: "the index"}, obj.obs)
    return Holder(obj.n_obs, _putting(obj.obs, name))


def _network(obj: Any, name: str) -> Holder | None:
    """Find the attributes of the nodes of networkx."""
    if not _has(obj, "nodes", "edges", "is_directed"):
        return None

    check_name(name, {}, _other_attribute(obj, name))

    def put(values: Values) -> None:
        for node, value in zip(obj.nodes, values.tolist(), strict=True):
            obj.nodes[node][name] = value

    return Holder(len(obj.nodes), put)


def _other_attribute(graph: Any, name: str) -> dict[str, Any]:
    """Return the first attribute of that name, of a node of networkx, that is not a number."""
    for _, data in graph.nodes(data=True):
        if name in data and not isinstance(data[name], numbers.Real):
            other = np.empty(1, dtype=object)
            other[0] = data[name]
            return {name: other}
    return {}


def _hemisphere(obj: Any, _: str) -> Holder | None:
    """Find the hemisphere of a PolyMesh or SurfaceImage of nilearn that has one."""
    parts = hemispheres(obj)
    if parts is None:
        return None
    if len(parts) != 1:
        both = ", ".join(f"{part!r}: ..." for part in parts)
        raise UnsupportedDomainError(
            f"{described(obj)} holds {len(parts)} shapes; give the values of each, {{{both}}}"
        )
    [(part, mesh)] = parts.items()
    return Holder(
        len(mesh.coordinates), lambda values: _surface_image(obj, {part: values}), mesh.coordinates
    )


def _on_hemispheres(obj: Any, values: Mapping[str, Values]) -> Any:
    """Return the SurfaceImage of nilearn with the values of each hemisphere."""
    parts = hemispheres(obj)
    if parts is None:
        raise InvalidOptionError(
            f"a mapping of values is for the hemispheres of nilearn, not for {described(obj)}; "
            "give one array"
        )
    if values.keys() != parts.keys():
        raise InvalidOptionError(
            f"values are given for {', '.join(map(repr, values)) or 'nothing'}, and "
            f"{described(obj)} has {', '.join(map(repr, parts))}"
        )
    for part, mesh in parts.items():
        _check_count(values[part], mesh, len(mesh.coordinates))
    return _surface_image(obj, values)


def _surface_image(obj: Any, values: Mapping[str, Values]) -> Any:
    surface = require("nilearn.surface", "all", "Values on hemispheres need")
    return surface.SurfaceImage(getattr(obj, "mesh", obj), dict(values))


HOLDERS: tuple[Callable[[Any, str], Holder | None], ...] = (
    _hemisphere,
    _point_data,
    _trimesh,
    _open3d_tensors,
    _open3d,
    _anndata,
    _network,
)
"""Each finds the values of one kind of object, and returns None for others."""
