"""Polygon meshes: errors against exact distances, on polygons and on triangles made of them first.

python benchmarks/polygons.py            potpourri3d's polygon heat method in the same run
python benchmarks/polygons.py --write    also into docs/_tables

The exact distance is that along the fans which `PolygonMesh.surface` consists of, on a sphere the
arc.
"""

import argparse
import warnings
from pathlib import Path

import numpy as np
import potpourri3d as pp3d
from measuring.tables import TABLES, markdown

import geodesic_toolkit as gt
from geodesic_toolkit_polygon import PolygonMesh
from geodesic_toolkit_polygon.samples import hexagons, l_shapes, quad_sphere

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

FILES = {
    "horse": "igltut__horse_quad.obj",
    "inspired mesh": "igltut__inspired_mesh_quads_Smooth.off",
    "bunny of polygons": "potpourri3d__bunny_poly.ply",
    "spot, control mesh": "odedstein__spot_control_mesh.obj",
}
SOURCES = 10
ROUNDING = 1e-9
HEADINGS = [
    "mesh", "faces", "corners", "refined", "triangles first", "turned", "plain heat",
    "triangles first", "potpourri3d",
]  # fmt: skip
NOTE = (
    "Mean errors from {count} sources, in per cent of each distance. *Triangles first*: of the "
    "mesh that `gt.read` makes of the file. *Turned*: how much its refined distances change, at "
    "most and over the largest, where every face begins at another corner; those of polygons "
    "change by rounding."
)


def meshes():
    """Yield names, meshes, and what gives the exact distance of a source; None along the fans."""
    for name, file in FILES.items():
        yield name, PolygonMesh.from_file(DATA / file), None
    ball = quad_sphere(16)
    yield "sphere of quadrangles", ball, ball.positions
    yield "plane of hexagons", hexagons(16), None
    yield "plane of L shapes", l_shapes(5), None


def exact(mesh, sphere, source):
    if sphere is not None:
        return np.arccos(np.clip(sphere @ sphere[source], -1.0, 1.0))
    return gt.exact_distance(mesh.surface, source)[: mesh.n_vertices]


def split(mesh):
    return gt.TriangleMesh(mesh.positions, mesh.triangles)


def row(name, mesh, sphere):
    turned = split(PolygonMesh(mesh.positions, [np.roll(face, 1) for face in mesh.faces]))
    triangles = split(mesh)
    refined = [gt.GeodesicSolver(each) for each in (mesh, triangles)]
    plain = [gt.GeodesicSolver(each, refine=False) for each in (mesh, triangles)]
    other = gt.GeodesicSolver(turned)
    peer = pp3d.PolygonMeshHeatSolver(mesh.positions, [face.tolist() for face in mesh.faces])
    errors, change = [], []
    for source in np.linspace(0, mesh.n_vertices - 1, SOURCES).astype(int).tolist():
        truth = exact(mesh, sphere, source)
        known = np.isfinite(truth) & (truth > 0)
        found = [
            *(solver.distance(source) for solver in (*refined, *plain)),
            peer.compute_distance([source]),
        ]
        errors.append([np.abs(each[known] / truth[known] - 1).mean() for each in found])
        change.append(np.abs(found[1] - other.distance(source))[known].max() / truth[known].max())
    swept, first, heat, heat_first, potpourri = (100 * np.mean(errors, axis=0)).tolist()
    sizes = f"{mesh.sizes.min()} to {mesh.sizes.max()}" if np.ptp(mesh.sizes) else mesh.sizes[0]
    figures = [swept, first, 100 * max(change), heat, heat_first, potpourri]
    return [name, f"{mesh.n_faces:,}", str(sizes), *map(_figure, figures)]


def _figure(value):
    return "0" if value < ROUNDING else f"{value:.3g}"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="also into docs/_tables")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gt.errors.GeodesicWarning)
    rows = [row(*each) for each in meshes()]
    table = markdown(HEADINGS, rows, NOTE.format(count=SOURCES))
    print(table)
    if arguments.write:
        (TABLES / "polygons.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
