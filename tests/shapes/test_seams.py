"""Vertices that share a place: meshes cut along seams, what warns of them, and what joins them."""

import struct
import warnings

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    SeamWarning,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.seams import find_seams
from geodesic_toolkit.geometry.welding import merged_positions
from geodesic_toolkit.testing import shapes

BALL = shapes.icosphere(3)
MIDDLES = BALL.vertices[BALL.faces].mean(axis=1)
ABOVE = MIDDLES[:, 2] > 0
SQUARE = shapes.grid(9)


def compact(vertices, faces):
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def together(*parts, gap=0.0):
    """Return meshes as one, each with vertices of its own, and each moved a little farther."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    vertices = [vertices + gap * k for k, (vertices, _) in enumerate(parts)]
    faces = [faces + start for (_, faces), start in zip(parts, starts[:-1], strict=True)]
    return gt.TriangleMesh(np.concatenate(vertices), np.concatenate(faces))


def moved(mesh, step):
    return gt.TriangleMesh(mesh.vertices + np.array(step), mesh.faces)


def parts_of_ball(*chosen):
    return [compact(BALL.vertices, BALL.faces[faces]) for faces in chosen]


def soup(mesh, noise=0.0):
    rng = np.random.default_rng(0)
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    moved = corners + noise * rng.uniform(-1, 1, corners.shape)
    return gt.TriangleMesh(moved, np.arange(len(corners)).reshape(-1, 3))


def seams_of(mesh):
    return find_seams(mesh.vertices, mesh.faces, gt.CotanLaplacian().assemble(mesh).boundary)


def assert_advice_helps(mesh, n_vertices):
    """The tolerance of the warning joins all that lies together, and makes no face degenerate."""
    seams = seams_of(mesh)
    assert seams is not None
    merged, new = gt.merge_vertices(mesh, tolerance=seams.tolerance)
    assert merged.n_vertices == n_vertices
    assert seams_of(merged) is None
    assert (np.diff(np.sort(merged.faces, axis=1), axis=1) > 0).all()
    assert np.linalg.norm(merged.vertices[new] - mesh.vertices, axis=1).max() <= seams.tolerance
    assert np.isfinite(gt.geodesic_distance(merged, 0, refine=True)).all()


CAP_AND_BAND = parts_of_ball(MIDDLES[:, 2] > 0.8, (MIDDLES[:, 2] <= 0.8) & (MIDDLES[:, 2] > -0.3))


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("parts", [parts_of_ball(ABOVE, ~ABOVE), CAP_AND_BAND])
def test_parts_that_share_a_rim_are_found_and_joined(parts, gap):
    mesh = together(*parts, gap=gap)
    whole = np.unique(np.round(np.concatenate([part[0] for part in parts]), 9), axis=0)
    assert_advice_helps(mesh, len(whole))


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize("mesh", [BALL, SQUARE, shapes.torus(30, 12)])
def test_a_soup_that_nothing_connects_is_found_and_joined(mesh, noise):
    assert_advice_helps(soup(mesh, noise), mesh.n_vertices)


def test_the_tolerance_for_a_soup_is_that_of_its_noise_not_of_its_edges():
    rng = np.random.default_rng(3)
    uneven = gt.TriangleMesh(SQUARE.vertices + 0.1 * rng.uniform(-1, 1, (81, 3)), SQUARE.faces)
    assert seams_of(soup(uneven, 1e-6)).tolerance < 5e-6


@pytest.mark.parametrize("gap", [0.0, 1e-9])
def test_a_side_that_two_sheets_share_is_a_seam(gap):
    beside = (moved(SQUARE, [1.0, 0, 0]).vertices, SQUARE.faces)
    mesh = together((SQUARE.vertices, SQUARE.faces), beside, gap=gap)
    assert_advice_helps(mesh, 153)


def test_front_and_back_with_vertices_of_their_own_are_two_sheets_until_they_are_merged():
    back = (SQUARE.vertices, SQUARE.faces[:, ::-1])
    mesh = together((SQUARE.vertices, SQUARE.faces), back)
    with pytest.warns(SeamWarning, match="reaches 81 of 162 vertices"):
        distance = gt.geodesic_distance(mesh, 0, refine=True)
    assert np.isinf(distance[81:]).all()
    merged, new = gt.merge_vertices(mesh)
    single = gt.geodesic_distance(SQUARE, 0, refine=True)
    np.testing.assert_array_equal(gt.geodesic_distance(merged, 0, refine=True)[new[81:]], single)


@pytest.mark.parametrize(
    "mesh",
    [
        SQUARE,
        gt.TriangleMesh(*parts_of_ball(ABOVE)[0]),
        shapes.disjoint_union(SQUARE, moved(SQUARE, [1.01, 0, 0])),
        shapes.disjoint_union(SQUARE, moved(SQUARE, [0, 0, 1e-3])),
        shapes.disjoint_union(BALL, moved(BALL, [2.0, 0, 0])),
        gt.TriangleMesh(
            np.random.default_rng(0).uniform(size=(90, 3)), np.arange(90).reshape(-1, 3)
        ),
    ],
    ids=["boundary", "half", "beside", "parallel", "touching", "scattered"],
)
def test_surfaces_that_end_or_come_near_are_not_cut(mesh):
    assert seams_of(mesh) is None


def test_meshes_beside_much_larger_ones_are_not_taken_for_noise():
    small = gt.TriangleMesh(1e-9 * SQUARE.vertices, SQUARE.faces)
    assert seams_of(shapes.disjoint_union(SQUARE, small)) is None


def test_coordinates_far_from_the_origin_do_not_widen_the_search():
    far = moved(SQUARE, [5e5, 4.6e6, 0.1])
    assert seams_of(far) is None
    joined, _ = gt.merge_vertices(far, tolerance=1.0)
    assert joined.n_vertices == 81


def test_the_warning_says_how_far_sources_reach_and_what_joins_the_surface():
    mesh = together(*parts_of_ball(ABOVE, ~ABOVE), gap=1e-9)
    solver = gt.GeodesicSolver(mesh, refine=True)
    text = r"reaches 337 of 690 vertices.*merge_vertices\(mesh, tolerance=1.8e-09\)"
    with pytest.warns(SeamWarning, match=text):
        solver.distance(0)
    with pytest.warns(SeamWarning):
        solver.distances([0, 1])
    with pytest.warns(SeamWarning):
        solver.query([0.0, 0.0, 1.0], 0)


def test_a_mask_does_not_cut_along_seams():
    with warnings.catch_warnings():
        warnings.simplefilter("error", SeamWarning)
        gt.geodesic_distance(BALL, 0, refine=True, mask=np.arange(BALL.n_vertices) == 40)


# -- merging -----------------------------------------------------------------------------------


def test_vertices_that_stay_are_the_first_ones_in_their_order():
    vertices = [[5, 0, 0], [0, 0, 0], [0, 1, 0], [5, 0, 1e-9], [0, -0.0, 0], [np.nan, 0, 0]]
    mesh = gt.TriangleMesh(vertices, [[0, 1, 2], [3, 4, 2]])
    merged, new = gt.merge_vertices(mesh)
    assert new.tolist() == [0, 1, 2, 3, 1, 4]
    merged, new = gt.merge_vertices(mesh, tolerance=1e-6)
    assert new.tolist() == [0, 1, 2, 0, 1, 3]
    np.testing.assert_array_equal(merged.vertices, np.array(vertices)[[0, 1, 2, 5]])
    assert merged.faces.tolist() == [[0, 1, 2], [0, 1, 2]]
    assert gt.CotanLaplacian().assemble(merged).notes["dropped_faces"] == 1


@pytest.mark.parametrize("tolerance", [0.02, 1.0, 3.4])
def test_a_wide_tolerance_collapses_no_face(tolerance):
    merged, new = gt.merge_vertices(BALL, tolerance=tolerance)
    assert merged.n_vertices == BALL.n_vertices
    np.testing.assert_array_equal(new, np.arange(BALL.n_vertices))


def test_places_are_merged_as_if_one_after_the_other():
    rng = np.random.default_rng(0)
    points, reach = rng.uniform(size=(400, 3)), rng.uniform(0.02, 0.2, 400)
    stay, expected = [], []
    for k, point in enumerate(points):
        gaps = np.linalg.norm(points[stay] - point, axis=1) if stay else np.zeros(0)
        near = np.flatnonzero(gaps <= np.minimum(reach[stay], reach[k]))
        expected.append(stay[near[0]] if len(near) else k)
        if not len(near):
            stay.append(k)
    np.testing.assert_array_equal(merged_positions(points, reach), expected)
    assert 50 < len(stay) < 350


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, np.inf, "1", True, None])
def test_a_tolerance_that_is_not_a_length_is_refused(tolerance):
    with pytest.raises(InvalidOptionError, match="tolerance must be"):
        gt.merge_vertices(BALL, tolerance=tolerance)


def test_a_tolerance_of_more_than_the_size_of_the_mesh_is_refused():
    with pytest.raises(InvalidOptionError, match=r"100 is more than the size of the mesh, 3\.46"):
        gt.merge_vertices(BALL, tolerance=100)


def test_a_diagnosis_and_a_path_that_fails_name_the_seam_and_its_cure():
    solver = gt.GeodesicSolver(shapes.disjoint_union(SQUARE, moved(SQUARE, [1.0, 0, 0])))
    diagnosis = solver.diagnosis
    assert (diagnosis.seam_edges, diagnosis.seam_tolerance) == (16, 0.0)
    with pytest.raises(UnreachableError, match=r"16 of the 64 edges.*merge_vertices\(mesh"):
        gt.geodesic_path(solver, 0, 100)
    merged, new = gt.merge_vertices(solver.domain, diagnosis.seam_tolerance)
    whole = gt.GeodesicSolver(merged)
    assert gt.geodesic_path(whole, new[0], new[100]).length == pytest.approx(
        np.linalg.norm(solver.domain.vertices[100])
    )
    assert whole.diagnosis.seam_edges == 0
    assert whole.diagnosis.seam_tolerance is None


def test_only_meshes_have_vertices_to_merge():
    with pytest.raises(UnsupportedDomainError, match="not those of a PointCloud"):
        gt.merge_vertices(gt.PointCloud(BALL.vertices))


# -- STL files ---------------------------------------------------------------------------------


def text_stl(corners):
    lines = ["solid part"]
    for facet in corners.reshape(-1, 3, 3):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(f"{x:.9g}" for x in corner) for corner in facet]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""])


def binary_stl(corners):
    facets = corners.reshape(-1, 9).astype("<f4")
    body = b"".join(struct.pack("<3f", 0, 0, 0) + row.tobytes() + b"\0\0" for row in facets)
    return b"\0" * 80 + struct.pack("<I", len(facets)) + body


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1e-3, 1.0, 250.0])
@pytest.mark.parametrize("noise", [0.0, 1e-7, 1e-6, 1e-5])
def test_corners_of_an_stl_that_differ_by_rounding_are_one(tmp_path, noise, scale):
    path = tmp_path / "part.stl"
    path.write_text(text_stl(scale * soup(BALL, noise).vertices))
    mesh = gt.read(path)
    assert (mesh.n_vertices, mesh.n_faces) == (BALL.n_vertices, BALL.n_faces)
    assert not len(gt.CotanLaplacian().assemble(mesh).boundary.nonzero()[0])


def test_single_precision_far_from_the_origin_leaves_an_stl_whole(tmp_path):
    rng = np.random.default_rng(0)
    corners = 1e3 * soup(BALL).vertices + [5e3, 4e4, 0]
    eps = np.spacing(np.abs(corners).max().astype(np.float32))
    path = tmp_path / "part.stl"
    path.write_bytes(binary_stl(corners + eps / 2 * rng.uniform(-1, 1, corners.shape)))
    assert gt.read(path).n_vertices == BALL.n_vertices


def test_closed_bodies_of_an_stl_stay_apart_however_near_they_are(tmp_path):
    corners = [BALL.vertices[BALL.faces], BALL.vertices[BALL.faces] + [0, 0, 1e-6]]
    path = tmp_path / "part.stl"
    path.write_text(text_stl(np.concatenate(corners)))
    assert gt.read(path).n_vertices == 2 * BALL.n_vertices


def test_features_of_an_stl_survive_rounding(tmp_path):
    """A plate with a notch narrower than what is joined elsewhere keeps every corner."""
    vertices = np.array(SQUARE.vertices)
    vertices[40] = vertices[31] + [1e-6, 0, 0]  # an edge of the surface as short as a rounding
    fine = gt.TriangleMesh(vertices, SQUARE.faces)
    path = tmp_path / "part.stl"
    path.write_text(text_stl(fine.vertices[fine.faces].reshape(-1, 3)))
    mesh = gt.read(path)
    assert mesh.n_vertices == 81
    assert (np.diff(np.sort(mesh.faces, axis=1), axis=1) > 0).all()


# -- polygons given twice ----------------------------------------------------------------------


@pytest.mark.parametrize("again", [[0, 1, 2, 3], [3, 2, 1, 0], [1, 2, 3, 0], [2, 1, 0, 3]])
def test_front_and_back_of_a_polygon_are_the_same_triangles(tmp_path, again):
    quads = np.array([[0, 1, 4, 3], [4, 5, 2, 1], [3, 4, 7, 6], [8, 5, 4, 7]])
    table = gt.testing.shapes.grid(3).vertices

    def read(rows):
        path = tmp_path / "quads.obj"
        lines = ["v " + " ".join(map(str, vertex)) for vertex in table.tolist()]
        path.write_text("\n".join([*lines, *("f " + " ".join(map(str, 1 + row)) for row in rows)]))
        with pytest.warns(gt.errors.ReadWarning, match="were split"):
            return gt.read(path)

    single, twice = read(quads), read(np.concatenate([quads, quads[:, again]]))
    assert twice.n_faces == 2 * single.n_faces
    np.testing.assert_array_equal(twice.faces[: single.n_faces], single.faces)
    assert gt.CotanLaplacian().assemble(twice).notes["dropped_faces"] == single.n_faces
