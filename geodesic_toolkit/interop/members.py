"""Objects of other packages that hold several shapes: scenes, blocks, pairs of hemispheres."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.interop.refusals import several

__all__ = ["Member", "hemispheres", "only_member"]


BLOCKS = ("n_blocks", "combine", "keys")
"""Attributes of PyVista's blocks that its shapes lack."""


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
        placed = [
            f"scene.dump()[{position}] ({obj.graph[node][1]!r})"
            for position, node in enumerate(nodes)
        ]
        raise several(obj, placed, _whole_scene(obj))
    if _has(obj, *BLOCKS):
        blocks = list(_blocks(obj, "blocks"))
        if len(blocks) == 1:
            return Member(blocks[0][1])
        raise several(obj, [code for code, _ in blocks], "blocks.combine()")
    parts = hemispheres(obj)
    if parts is None:
        return None
    if len(parts) == 1:
        return Member(*parts.values())
    raise several(obj, [f"mesh.parts[{name!r}]" for name in parts])


def _whole_scene(scene: Any) -> str | None:
    """Return the code that joins the shapes of a scene as they are placed, if they are of a kind.

    Trimesh leaves out clouds where it joins meshes.
    """
    surfaces = [hasattr(shape, "faces") for shape in scene.geometry.values()]
    if all(surfaces):
        joined = "scene.to_geometry()"  # younger than the oldest version that is supported
        return joined if hasattr(scene, "to_geometry") else "trimesh.util.concatenate(scene.dump())"
    if any(surfaces):
        return None
    return "numpy.concatenate([cloud.vertices for cloud in scene.dump()])"


def _blocks(obj: Any, code: str) -> Iterator[tuple[str, Any]]:
    """Yield the code and the shape of each block of PyVista, of blocks within blocks, too."""
    names = list(obj.keys())
    for position, name in enumerate(names):
        key = name if names.count(name) == 1 else position
        block, inner = obj[position], f"{code}[{key!r}]"
        if block is not None and _has(block, *BLOCKS):
            yield from _blocks(block, inner)
        elif block is not None:
            yield inner, block


def hemispheres(obj: Any) -> Mapping[str, Any] | None:
    """Return the meshes of a PolyMesh or SurfaceImage of nilearn by name; None for others."""
    parts = getattr(getattr(obj, "mesh", obj), "parts", None)  # a SurfaceImage has a PolyMesh
    return parts if isinstance(parts, Mapping) else None


def _has(obj: Any, *names: str) -> bool:
    return all(hasattr(obj, name) for name in names)
