"""A user's program for the rest of the public interface: directions, curves, costs, files, parts.

Type checkers read it, and the tests run it.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, assert_type

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def directions(solver: gt.GeodesicSolver) -> None:
    log: gt.LogMap = gt.log_map(solver, 0)
    assert_type(log.angle, Floats)
    frames: gt.TangentFrames = gt.tangent_frames(solver)
    assert_type(frames.x_axes, Floats)
    assert_type(gt.parallel_transport(solver, 0, frames.x_axes[:1]), Floats)
    ends: gt.ExpMap = gt.exp_map(solver, 0, frames.x_axes[:1])
    assert_type(ends.positions, Floats)
    labels: npt.NDArray[Any] = gt.extend(solver, [0, 9], [1, 2])
    assert set(labels.tolist()) == {1, 2}


def centres(solver: gt.GeodesicSolver) -> None:
    mean: gt.GeodesicMean = gt.geodesic_mean(solver, [0, 5, 9], power=1)
    assert_type(mean.position, Floats)
    cells: gt.CentroidalVoronoi = gt.centroidal_voronoi(
        solver, 4, steps=3, rng=np.random.default_rng(0)
    )
    assert_type(cells.labels, Indices)


def curves(solver: gt.GeodesicSolver, mesh: gt.TriangleMesh, folder: Path) -> None:
    distance = solver.distance(0)
    lines = gt.isolines(mesh, distance, [0.5])
    assert_type(lines, list[gt.Curve])
    assert_type(gt.curve_length(mesh, lines[0]), float)
    assert_type(gt.area_above(mesh, distance, 0.5), float)
    disc: gt.GeodesicDisc = gt.geodesic_disc(solver, 0, 0.5)
    assert_type(disc.radius, float)
    assert_type(gt.signed_distance(solver, lines), Floats)
    gt.write_curves(folder / "lines.obj", mesh, lines)
    assert_type(gt.read_curves(folder / "lines.obj", mesh), list[gt.Curve])
    gt.write_log_map(folder / "uv.obj", mesh, gt.log_map(solver, 0))
    torus = gt.testing.shapes.torus(24, 12)
    loop: gt.GeodesicPath = gt.geodesic_loop(gt.GeodesicSolver(torus), [0, 96, 192])
    assert_type(loop.length, float)
    girth: gt.GeodesicPath = gt.shortest_loop(gt.GeodesicSolver(torus), at=0)
    assert_type(girth.closed, bool)
    volume: gt.VolumeDistance = gt.signed_distance_volume(mesh, resolution=12)
    assert_type(volume.values, Floats)


def of_plugins(report: gt.HeatReport, finer: gt.Subdivision, fronts: gt.Fronts) -> None:
    assert_type(report.reached, int)
    assert_type(finer.metric, gt.Discretization)
    assert isinstance(fronts, gt.Fronts)


def costs(mesh: gt.TriangleMesh) -> None:
    for metric in (
        gt.MetricMesh(mesh, cost=2.0),
        gt.IntrinsicMesh(mesh.faces, np.ones((mesh.n_faces, 3))),
    ):
        assert_type(gt.geodesic_distance(metric, gt.SurfacePoint(0, (0.2, 0.3, 0.5))), Floats)


def comparisons(solver: gt.GeodesicSolver, mesh: gt.TriangleMesh) -> None:
    distance = solver.distance(gt.Located([[0, 1]], [[0.5, 0.5]]))
    variants: list[gt.Variant] = gt.variants_for(mesh)
    compared: gt.Comparison = gt.compare(mesh, 0, variants=variants[:2])
    assert_type(compared.reference, Floats)
    assert_type(gt.exact_distance(mesh, 0), Floats)
    assert_type(gt.eikonal_residual(solver, distance), Floats)


def files(folder: Path) -> None:
    (folder / "some.txt").write_text("0\n2\n")
    assert_type(gt.read_vertices(folder / "some.txt"), Indices)
    assert_type(gt.read_mask(folder / "some.txt", 4), npt.NDArray[np.bool_])
    (folder / "points.csv").write_text("0,0,0\n1,0,0\n")
    assert_type(gt.read_points(folder / "points.csv"), gt.PointCloud)
    (folder / "face.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    vertices, corners, sizes = gt.read_polygons(folder / "face.off")
    assert_type(vertices, Floats)
    assert_type(corners, Indices)
    assert_type(sizes, Indices)


def parts(mesh: gt.TriangleMesh) -> None:
    metric: gt.Discretization = gt.CotanLaplacian().assemble(mesh)
    gradient: gt.Gradient = metric.gradient
    assert isinstance(gradient, gt.ElementGradient)
    assert_type(gt.positive_part(metric), gt.Discretization)
    graph = gt.UniformLaplacian().assemble(gt.Graph(2, [[0, 1]]))
    assert isinstance(graph.gradient, gt.EdgeGradient)
    matrix = csr_array(metric.stiffness + diags_array(metric.mass))
    for solver in (gt.SuperLU(), gt.Supernodal(), gt.CG()):
        linear: gt.LinearSolver = solver
        analysis: gt.Analysis = linear.analyse(matrix)
        factor: gt.Factor = analysis.factorize(matrix)
        assert factor is not None
    heat = gt.HeatMethod(metric, heat_solver=gt.Supernodal(), poisson_solver=gt.CG(), refine=False)
    sources: gt.SourcePoints = gt.SourcePoints.at_vertices(np.array([0]), mesh.n_vertices)
    distance = heat.distance(sources)
    assert_type(distance, Floats)
    assert_type(gt.interpolate(mesh, metric, distance, mesh.vertices[:2]), Floats)
    assert_type(heat, gt.HeatMethod)
    assert gt.PointCloudLaplacian(k=8).assemble(gt.PointCloud(mesh.vertices)).mass.min() > 0
    of_charts: Callable[..., gt.Discretization] = gt.discretization_of_charts
    assert callable(of_charts)
    for registry in (gt.operators, gt.solvers, gt.readers):
        known: gt.Registry[Any] = registry
        assert len(list(known)) > 0
    writers: gt.Registry[gt.Writer] = gt.writers
    assert "ply" not in writers  # a format of the core
    assert_type(gt.__version__, str)


def main() -> None:
    mesh = gt.testing.shapes.icosphere(3)
    solver = gt.GeodesicSolver(mesh)
    directions(solver)
    centres(solver)
    costs(mesh)
    comparisons(solver, mesh)
    parts(mesh)
    with tempfile.TemporaryDirectory() as name:
        curves(solver, mesh, Path(name))
        files(Path(name))


if __name__ == "__main__":
    main()
