"""A user's program: type checkers read it as a user's editor does, and a test runs it.

``assert_type`` states what a call returns, so that a signature which loses its types is an error.
Where it says ``Any``, a third-party package that publishes no types is behind the result.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, assert_type

import numpy as np
import numpy.typing as npt

import geodesic_toolkit as gt
from geodesic_toolkit.sklearn import GeodesicDistances, GeodesicIsomap, GeodesicNeighbors

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def shapes(folder: Path) -> tuple[gt.TriangleMesh, gt.PointCloud, gt.Graph]:
    mesh = gt.TriangleMesh(np.eye(3), [[0, 1, 2]])
    file = folder / "mesh.ply"
    gt.write(file, mesh, np.zeros(3), sources=0)
    assert_type(gt.read(file), gt.Domain)
    assert_type(gt.as_domain((np.eye(3), [[0, 1, 2]])), gt.Domain)
    assert_type(gt.merge_vertices(mesh, 0.0), tuple[gt.TriangleMesh, Indices])
    assert_type(mesh.vertices, Floats)
    assert_type(mesh.n_vertices, int)
    cloud = gt.PointCloud(gt.testing.shapes.icosphere(2).vertices)
    assert_type(gt.thin(cloud, 0.01), gt.Thinned)
    graph = gt.Graph(3, [[0, 1], [1, 2]], [1.0, 2.0])
    return gt.testing.shapes.icosphere(2), cloud, graph


def distances(solver: gt.GeodesicSolver) -> None:
    """Ask for distances from every kind of source."""
    curve = gt.Curve([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    for source in (0, [0, 5], np.arange(3), [[0.0, 0.0, 1.0]], curve):
        assert_type(solver.distance(source), Floats)
    assert_type(solver.distance(gt.SurfacePoint(7, (0.2, 0.3, 0.5))), Floats)
    assert_type(solver.distance(gt.OffsetSources([0, 5], [0.0, 0.1])), Floats)
    assert_type(solver.distances([0, 5]), Floats)
    assert_type(solver.blocks([0, 5]), Iterator[Floats])
    assert_type(solver.query([[0.0, 0.0, 1.0]], 0), Floats)
    assert_type(solver.nearest_source([[0.0, 0.0, 1.0]], [0, 5]), tuple[Indices, Floats])
    assert_type(solver.diagnosis, gt.Diagnosis)


def analysis(solver: gt.GeodesicSolver, folder: Path) -> None:
    path = gt.geodesic_path(solver, 0, 9)
    assert_type(path, gt.GeodesicPath | gt.CloudPath | gt.EdgePath)
    assert_type(path.points, Floats)
    assert_type(path.length, float)
    assert_type(gt.distance_matrix(solver, [0, 1], out=folder / "D.npy"), Any)
    assert_type(gt.farthest_point_sampling(solver, 3), Indices)
    assert_type(gt.farthest_point_sampling(solver, 3, return_radii=True), tuple[Indices, Floats])
    assert_type(gt.geodesic_voronoi(solver, [0, 9]), Indices)
    assert_type(gt.geodesic_voronoi(solver, [0, 9], return_distances=True), tuple[Indices, Floats])
    assert_type(gt.mean_eikonal_residual(solver, solver.distance(0)), float)


class Cloud:
    """An object of the user's own that holds values of points, as those of PyVista do."""

    def __init__(self) -> None:
        self.points = np.eye(3)
        self.point_data: dict[str, Floats] = {}


def objects(mesh: gt.TriangleMesh) -> None:
    cloud = Cloud()
    distance = gt.geodesic_distance(mesh, 0)[:3]
    assert_type(gt.attach(cloud, distance, "from 0", fill=-1.0), Any)
    assert_type(gt.attach(cloud, distance, domain=gt.PointCloud(np.eye(3))), Any)
    assert set(cloud.point_data) == {"from 0", "distance"}


def estimators(mesh: gt.TriangleMesh) -> None:
    samples = np.random.default_rng(0).random((60, 3))
    distances = GeodesicDistances(landmarks=3, fill=9.0).fit(samples)
    assert_type(distances.transform(samples), Floats)
    assert_type(GeodesicDistances([0, 1]).fit_transform(mesh), Floats)
    isomap = GeodesicIsomap(n_components=2, operator=gt.UniformLaplacian())
    assert_type(isomap.fit_transform(samples), Floats)
    assert_type(GeodesicNeighbors(n_neighbors=3, mode="connectivity").fit_transform(samples), Any)


def pictures(mesh: gt.TriangleMesh, folder: Path) -> None:
    distance = gt.geodesic_distance(mesh, 0)
    picture = gt.viz.plot(mesh, distance, path=folder / "d.png", sources=0, size=(320, 160))
    assert_type(picture, npt.NDArray[np.uint8])
    gt.viz.save_html(mesh, distance, folder / "d.html", unit="m")


def errors(mesh: gt.TriangleMesh) -> None:
    try:
        gt.geodesic_distance(mesh, mesh.n_vertices)
    except gt.errors.InvalidSourceError as error:
        index_error: IndexError = error
        root: gt.errors.GeodesicError = error
        assert str(index_error) == str(root)


@dataclass(frozen=True, kw_only=True)
class Voronoi(gt.LaplaceOperator):
    """An operator of the user's own."""

    domains = (gt.TriangleMesh,)

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        return gt.CotanLaplacian(mass="voronoi").assemble(domain)


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mesh, cloud, graph = shapes(folder)
        solver = gt.GeodesicSolver(mesh, operator=Voronoi(), solver=gt.Supernodal(), refine="auto")
        distances(solver)
        analysis(gt.GeodesicSolver(mesh, boundary="neumann", mask=None), folder)
        for domain in (cloud, graph):
            assert_type(gt.geodesic_distance(domain, 0, operator="auto"), Floats)
        objects(mesh)
        estimators(mesh)
        pictures(mesh, folder)
        errors(mesh)
        assert_type(gt.operators.status(), list[gt.PluginStatus])
        assert len(gt.testing.laplace_operator_checks(Voronoi())) > 0


if __name__ == "__main__":
    main()
