"""Objects of other packages that hold several shapes: scenes, blocks, pairs of hemispheres."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.interop.refusals import several

__all__ = ["Member", "hemispheres", "only_member"]


class Member(NamedTuple):
    """The only shape that an object holds, and the transform (4, 4) that places it, or None."""

    shape: Any
    placement: FloatArray | None = None


def only_member(obj: Any) -> Member | None:
    """Return the only shape of a scene of trimesh, blocks of PyVista or hemispheres of nilearn.

    Parameters
    ----------
    obj : object

    Returns
    -------
    Member or None
        None for objects that are not collections.

    Raises
    ------
    UnsupportedDomainError
        The object holds several shapes or no shape; the message has the code for one of them.
    """
    if _has(obj, "geometry", "graph", "dump") and isinstance(obj.geometry, Mapping):
        nodes = list(obj.graph.nodes_geometry)
        if len(nodes) == 1:
            placement, name = obj.graph[nodes[0]]
            return Member(obj.geometry[name], placement)
        raise several(
            obj,
            len(nodes),
            "scene.geometry[name]",
            list(obj.geometry),
            "trimesh.util.concatenate(scene.dump())",
        )
    if _has(obj, "n_blocks", "combine", "keys"):
        blocks = [block for block in obj if block is not None]
        if len(blocks) == 1:
            return Member(blocks[0])
        raise several(obj, len(blocks), "blocks[name]", obj.keys(), "blocks.combine()")
    parts = hemispheres(obj)
    if parts is None:
        return None
    if len(parts) == 1:
        return Member(next(iter(parts.values())))
    raise several(obj, len(parts), "mesh.parts[name]", list(parts))


def hemispheres(obj: Any) -> Mapping[str, Any] | None:
    """Return the meshes of a PolyMesh or SurfaceImage of nilearn by name; None for others."""
    parts = getattr(getattr(obj, "mesh", obj), "parts", None)  # a SurfaceImage has a PolyMesh
    return parts if isinstance(parts, Mapping) else None


def _has(obj: Any, *names: str) -> bool:
    return all(hasattr(obj, name) for name in names)
