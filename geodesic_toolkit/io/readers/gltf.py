"""glTF scenes (glb, gltf), through trimesh."""

import json
from pathlib import Path

import numpy as np

from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import warn

__all__ = ["read_gltf"]


def read_gltf(path: Path) -> Domain:
    """Read all meshes of a glTF scene, instances as in the scene, one after the other.

    The format repeats a vertex for each of its normals, texture coordinates and materials, which
    cuts the surface there; a warning reports it.
    """
    import trimesh  # heavy

    if path.suffix.lower() == ".gltf":
        _check_json(path)  # otherwise trimesh would read a model.gltf beside it

    scene = trimesh.load(path, force="scene", process=False)
    vertices, faces, points = [], [], []
    offset = 0
    order = {name: number for number, name in enumerate(scene.geometry)}  # the order of the file
    instances = [scene.graph[node] for node in reversed(scene.graph.nodes_geometry)]
    for placement, name in sorted(instances, key=lambda pair: order[pair[1]]):
        shape = scene.geometry[name]
        positions = shape.vertices @ placement[:3, :3].T + placement[:3, 3]
        if isinstance(shape, trimesh.Trimesh) and len(shape.faces):
            vertices.append(positions)
            faces.append(shape.faces + offset)
            offset += len(positions)
        elif isinstance(shape, trimesh.PointCloud):
            points.append(positions)
    if not faces:
        if points:
            return PointCloud(np.concatenate(points))
        raise ReadError("the scene has no triangles and no points")
    mesh = TriangleMesh(np.concatenate(vertices), np.concatenate(faces))
    repeated = mesh.n_vertices - len(np.unique(mesh.vertices, axis=0))
    if repeated:
        warn(
            path,
            f"{repeated} of {mesh.n_vertices} vertices repeat another's position, as glTF does "
            "along seams of texture, normals and material: the surface is cut there",
        )
    return mesh


def _check_json(path: Path) -> None:
    try:
        tree = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise ReadError(f"not a glTF file, or a damaged one: {error}") from error
    if not isinstance(tree, dict):
        raise ReadError("not a glTF file: its text is not a JSON object")
