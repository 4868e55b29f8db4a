"""Do masks, points, queries, paths, files and pictures work on polygons?"""

import pickle

import numpy as np
import pytest
from typer.testing import CliRunner

import geodesic_toolkit as gt
from geodesic_toolkit.cli import app
from geodesic_toolkit.errors import InvalidDomainError, ReadError, UnsupportedDomainError
from geodesic_toolkit_polygon import PolygonLaplacian, PolygonMesh
from geodesic_toolkit_polygon.samples import hexagons, l_shapes, quad_sphere, quads

PLANE = quads(20)
SOLVER = gt.GeodesicSolver(PLANE)

SWEPT = 2e-3
"""Error of fronts on the plane, in its side; measured: 1e-3 from the middle of a face."""


def test_auto_takes_the_operator_and_refines():
    assert SOLVER.operator == PolygonLaplacian()
    assert SOLVER.method.refine
    assert repr(PLANE) == "PolygonMesh(441 vertices, 400 faces of 4 corners)"
    assert "vertices inside polygons" in repr(SOLVER.method.metric.gradient)


@pytest.mark.parametrize("place", [[0.525, 0.525, 0.0], [0.512, 0.543, 0.0], [0.5, 0.52, 0.0]])
def test_sources_lie_anywhere_in_faces(place):
    exact = np.linalg.norm(PLANE.positions - place, axis=1)
    assert np.abs(SOLVER.distance(place) - exact).max() < SWEPT


@pytest.mark.parametrize("place", [[0.3, 0.21, 0.0], [1 / 3, 1 / 3, 0.0]])
def test_small_meshes_are_exact_from_places_in_faces(place):
    mesh = l_shapes(1)
    exact = np.linalg.norm(mesh.positions - place, axis=1)
    assert gt.geodesic_distance(mesh, place) == pytest.approx(exact, abs=1e-9)


def test_sources_at_vertices_and_between_them_mix():
    places = [[0.0, 0.0, 0.0], [0.525, 0.525, 0.0]]
    both = np.minimum(*(np.linalg.norm(PLANE.positions - place, axis=1) for place in places))
    assert np.abs(SOLVER.distance(places) - both).max() < SWEPT
    late = gt.OffsetSources(places, [0.1, 0.0])
    first, second = (np.linalg.norm(PLANE.positions - place, axis=1) for place in places)
    assert np.abs(SOLVER.distance(late) - np.minimum(first + 0.1, second)).max() < 2 * SWEPT


def test_a_curve_is_a_source():
    line = gt.Curve([[0.0, 0.32, 0.0], [1.0, 0.32, 0.0]])
    assert np.abs(SOLVER.distance(line) - np.abs(PLANE.positions[:, 1] - 0.32)).max() < SWEPT


def test_sheets_at_one_place_are_distinguished():
    low = quads(4)
    both = PolygonMesh.of_corners(
        np.concatenate([low.positions, low.positions]),
        np.tile(low.sizes, 2),
        np.concatenate([low.corners, low.corners + low.n_vertices]),
    )
    middle = gt.SurfacePoint(len(low.triangles), (0.2, 0.3, 0.5))
    distance = gt.geodesic_distance(both, middle)
    assert np.isinf(distance[: low.n_vertices]).all()
    assert np.isfinite(distance[low.n_vertices :]).all()


def test_queries_are_answered_inside_faces():
    points = np.random.default_rng(3).uniform(0.1, 0.9, size=(50, 3)) * [1, 1, 0]
    assert np.abs(SOLVER.query(points, 0) - np.linalg.norm(points, axis=1)).max() < SWEPT


def test_no_path_crosses_masked_vertices():
    wall = np.isclose(PLANE.positions[:, 0], 0.5) & (PLANE.positions[:, 1] < 0.75)
    solver = gt.GeodesicSolver(PLANE, mask=wall)
    distance = solver.distance(0)
    assert np.isinf(distance[wall]).all()
    right = int(np.abs(PLANE.positions - [1, 0, 0]).sum(axis=1).argmin())
    assert distance[right] > 1.6
    assert gt.geodesic_path(solver, 0, right).length == pytest.approx(distance[right], rel=0.01)


@pytest.mark.parametrize("refine", [True, False])
def test_paths_run_straight_across_faces(refine):
    path = gt.geodesic_path(gt.GeodesicSolver(PLANE, refine=refine), 0, [0.91, 0.52, 0.0])
    assert path.length == pytest.approx(np.hypot(0.91, 0.52), rel=1e-9)
    late = gt.geodesic_path(SOLVER, gt.OffsetSources([0, 440], [5.0, 0.0]), 20)
    assert late.length == pytest.approx(1.0, rel=1e-9)


def test_matrices_and_samples_are_those_of_the_vertices():
    matrix = gt.distance_matrix(SOLVER, [0, 20, 440])
    assert matrix.shape == (3, 441)
    assert matrix[0, 440] == pytest.approx(np.sqrt(2), abs=SWEPT)
    assert gt.farthest_point_sampling(SOLVER, 4).shape == (4,)


def test_a_solver_comes_back_from_pickle():
    copy = pickle.loads(pickle.dumps(SOLVER))
    assert np.array_equal(copy.distance(5), SOLVER.distance(5))


# -- files ---------------------------------------------------------------------------------------


MIXED = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0], [2, 0, 0], [2, 1, 0], [1.5, 2, 0]]
FACES = [[0, 1, 2, 3], [3, 2, 4], [1, 5, 6, 7, 2]]


def write_obj(path, vertices, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_off(path, vertices, faces):
    lines = [f"OFF\n{len(vertices)} {len(faces)} 0"]
    lines += [f"{x} {y} {z}" for x, y, z in vertices]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_ply(path, vertices, faces):
    mesh = PolygonMesh(vertices, faces)
    gt.write(path, mesh, np.zeros(mesh.n_vertices))


WRITERS = {".obj": write_obj, ".off": write_off, ".ply": write_ply}


@pytest.mark.parametrize("suffix", WRITERS)
def test_polygons_are_read_as_they_are(tmp_path, suffix):
    path = tmp_path / f"mixed{suffix}"
    WRITERS[suffix](path, MIXED, FACES)
    mesh = gt.read(path, kinds=PolygonLaplacian.domains)
    assert [face.tolist() for face in mesh.faces] == FACES
    assert np.array_equal(mesh.positions, MIXED)


def test_what_is_wrong_in_a_file_is_said_with_its_name(tmp_path):
    path = tmp_path / "bad.obj"
    write_obj(path, MIXED, [[0, 2, 1, 3]])
    with pytest.raises(ReadError, match=r"bad\.obj: face 0 crosses itself"):
        gt.read(path, kinds=[PolygonMesh])
    other = tmp_path / "mesh.stl"
    other.write_text("solid")
    with pytest.raises(ReadError, match=r"polygons can be read from \.obj, \.off, \.ply"):
        gt.read(other, kinds=[PolygonMesh])


def test_the_command_line_reads_and_writes_polygons(tmp_path):
    source, output = tmp_path / "mixed.obj", tmp_path / "distance.ply"
    write_obj(source, MIXED, FACES)
    command = ["distance", str(source), "--source", "0", "--operator", "polygon"]
    result = CliRunner().invoke(app, [*command, "--output", str(output)])
    assert result.exit_code == 0, result.output
    assert "PolygonMesh(8 vertices, 3 faces of 3 to 5 corners)" in result.output
    again = gt.read(output, kinds=[PolygonMesh])
    assert [face.tolist() for face in again.faces] == FACES


@pytest.mark.parametrize("suffix", [".vtp", ".vtk", ".vtu"])
def test_files_of_vtk_keep_polygons(tmp_path, suffix):
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / f"mixed{suffix}"
    mesh = PolygonMesh(MIXED, FACES)
    gt.write(path, mesh, gt.geodesic_distance(mesh, 0))
    back = pyvista.read(path)
    assert [back.get_cell(k).n_points for k in range(back.n_cells)] == [4, 3, 5]


def test_large_faces_are_written(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 301)[:-1]
    disc = PolygonMesh(np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), [range(300)])
    path = tmp_path / "disc.ply"
    gt.write(path, disc, gt.geodesic_distance(disc, 0))
    assert gt.read(path, kinds=[PolygonMesh]).sizes.tolist() == [300]


# -- other libraries -----------------------------------------------------------------------------


def test_meshes_of_pyvista_and_meshio_keep_their_polygons():
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    data = pyvista.PolyData(np.array(MIXED), faces=[4, 0, 1, 2, 3, 3, 3, 2, 4, 5, 1, 5, 6, 7, 2])
    assert [face.tolist() for face in PolygonMesh.of(data).faces] == FACES
    cells = [("quad", [FACES[0]]), ("triangle", [FACES[1]]), ("polygon", [FACES[2]])]
    points = np.array(MIXED)
    assert [f.tolist() for f in PolygonMesh.of(meshio.Mesh(points, cells)).faces] == FACES
    flat = PolygonMesh.of(meshio.Mesh(points[:, :2], cells))
    assert np.array_equal(flat.positions, points)
    with pytest.raises(UnsupportedDomainError, match="cells of type tetra"):
        PolygonMesh.of(meshio.Mesh(points, [("tetra", [[0, 1, 2, 4]])]))
    with pytest.raises(InvalidDomainError, match="no triangles, quads or polygons"):
        PolygonMesh.of(meshio.Mesh(points, [("line", [[0, 1]])]))
    with pytest.raises(UnsupportedDomainError, match="triangle strips"):
        PolygonMesh.of(pyvista.PolyData(np.array(MIXED), strips=[4, 0, 1, 3, 2]))


def test_pairs_and_domains_become_polygon_meshes():
    mesh = PolygonMesh(MIXED, FACES)
    for same in (PolygonMesh.of((MIXED, FACES)), PolygonMesh.of(mesh)):
        assert [face.tolist() for face in same.faces] == FACES
    assert PolygonMesh(MIXED, np.array([[0, 1, 2, 3]])).n_faces == 1
    assert PolygonMesh.of(gt.testing.shapes.grid(3)).sizes.tolist() == [3] * 8
    with pytest.raises(UnsupportedDomainError, match="a str is not a polygon mesh"):
        PolygonMesh.of("mesh")
    with pytest.raises(UnsupportedDomainError, match="has no"):
        PolygonMesh.of(gt.Graph(2, [[0, 1]]))


def test_pictures_show_polygon_meshes():
    from geodesic_toolkit.viz.scene import make_scene

    ball = quad_sphere(4)
    scene = make_scene(ball, gt.geodesic_distance(ball, 0))
    assert scene is not None


def test_a_click_on_the_page_is_a_place_inside_a_polygon():
    from geodesic_toolkit.viz.live.session import Session

    session, toward = Session(quad_sphere(16)), np.array([0.3, 0.5, 0.9])
    session.click(session.pick(9 * toward, -toward))
    session.set_mode("measure")
    session.click(session.pick(9 * toward, -toward))
    assert session.measured[1] == pytest.approx(0.0, abs=1e-6)
    session.click(session.pick(-9 * toward, toward))
    assert session.measured[1] == pytest.approx(np.pi, rel=0.02)
    session.set_mode("path")
    for end in (toward, -toward):
        session.click(session.pick(9 * end, -end))
    assert session.path.length == pytest.approx(np.pi, rel=0.01)


def test_plain_heat_of_blocks_is_that_of_single_sources():
    solver = gt.GeodesicSolver(hexagons(6), refine=False)
    both = solver.distances([0, 5])
    assert both[1] == pytest.approx(solver.distance(5), rel=1e-9, abs=1e-12)
