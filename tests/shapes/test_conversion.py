"""The shapes of other libraries as domains."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp
from sklearn.feature_extraction import image

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, ReadWarning, UnsupportedDomainError
from geodesic_toolkit.geometry.cells import faces_of, surface_polygons
from geodesic_toolkit.geometry.polygons import split_polygons, unpadded_polygons
from geodesic_toolkit.testing import shapes

SPHERE = shapes.icosphere(1)
VERTICES, FACES = np.array(SPHERE.vertices), np.array(SPHERE.faces)
CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)[
    [0, 1, 3, 2, 4, 5, 7, 6]
]


def assert_sphere(domain, rtol=0.0):
    assert isinstance(domain, gt.TriangleMesh)
    np.testing.assert_allclose(domain.vertices, VERTICES, rtol=rtol)
    np.testing.assert_array_equal(domain.faces, FACES)


def assert_cloud(domain, normals=None):
    assert isinstance(domain, gt.PointCloud)
    np.testing.assert_array_equal(domain.points, VERTICES)
    if normals is None:
        assert domain.normals is None
    else:
        np.testing.assert_allclose(domain.normals, normals, atol=1e-12)


def outward_area(mesh):
    """The area of a mesh whose faces all turn away from the middle of its vertices."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    cross = np.cross(b - a, c - a) / 2
    middle = mesh.vertices[np.unique(mesh.faces)].mean(axis=0)
    assert (np.einsum("fd,fd->f", cross, (a + b + c) / 3 - middle) > 0).all()
    return np.linalg.norm(cross, axis=1).sum()


@pytest.mark.parametrize(
    "domain", [SPHERE, gt.PointCloud(VERTICES), gt.Graph(2, [[0, 1]])], ids=repr
)
def test_a_domain_is_itself(domain):
    assert gt.as_domain(domain) is domain


@pytest.mark.parametrize(
    "pair",
    [
        (VERTICES, FACES),
        [VERTICES, FACES],
        (VERTICES.tolist(), FACES.tolist()),
        (VERTICES, FACES.astype(np.uint16)),
    ],
    ids=["tuple", "list", "lists", "small indices"],
)
def test_vertices_and_faces_are_a_mesh(pair):
    assert_sphere(gt.as_domain(pair))


@pytest.mark.parametrize(
    "table",
    [VERTICES, VERTICES.tolist(), tuple(map(tuple, VERTICES))],
    ids=["array", "list", "tuple"],
)
def test_a_table_of_three_columns_is_a_cloud(table):
    assert_cloud(gt.as_domain(table))


def test_two_points_are_a_cloud_and_no_pair():
    assert repr(gt.as_domain([[0, 0, 0], [1, 0, 0]])) == "PointCloud(2 points)"


def test_trimesh():
    trimesh = pytest.importorskip("trimesh")
    assert_sphere(gt.as_domain(trimesh.Trimesh(VERTICES, FACES, process=False)))
    assert_cloud(gt.as_domain(trimesh.PointCloud(VERTICES)))
    with pytest.raises(UnsupportedDomainError, match="Scene is not a shape"):
        gt.as_domain(trimesh.Scene())
    path = trimesh.load_path([[[0, 0, 0], [1, 0, 0]]])
    with pytest.raises(UnsupportedDomainError, match="Path3D is not a shape"):
        gt.as_domain(path)


def test_open3d_legacy():
    o3d = pytest.importorskip("open3d")
    points = o3d.utility.Vector3dVector(VERTICES)
    assert_sphere(
        gt.as_domain(o3d.geometry.TriangleMesh(points, o3d.utility.Vector3iVector(FACES)))
    )
    cloud = o3d.geometry.PointCloud(points)
    assert_cloud(gt.as_domain(cloud))
    cloud.normals = points
    assert_cloud(gt.as_domain(cloud), normals=VERTICES)
    with pytest.raises(InvalidDomainError, match="no vertices"):
        gt.as_domain(o3d.geometry.TriangleMesh())
    with pytest.raises(UnsupportedDomainError, match="LineSet is not a shape"):
        gt.as_domain(o3d.geometry.LineSet())


def test_open3d_tensors():
    o3d = pytest.importorskip("open3d")
    mesh = o3d.t.geometry.TriangleMesh()
    with pytest.raises(InvalidDomainError, match="no vertices"):
        gt.as_domain(mesh)
    mesh.vertex.positions = o3d.core.Tensor(VERTICES.astype(np.float32))
    mesh.triangle.indices = o3d.core.Tensor(FACES.astype(np.int32))
    assert_sphere(gt.as_domain(mesh), rtol=1e-6)
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor(VERTICES))
    assert_cloud(gt.as_domain(cloud))
    cloud.point.normals = o3d.core.Tensor(VERTICES)
    assert_cloud(gt.as_domain(cloud), normals=VERTICES)


def test_pyvista_surfaces():
    pv = pytest.importorskip("pyvista")
    assert_sphere(gt.as_domain(pv.PolyData.from_regular_faces(VERTICES, FACES)))
    strip = pv.PolyData(VERTICES[:4], strips=[4, 0, 1, 2, 3])
    np.testing.assert_array_equal(gt.as_domain(strip).faces, [[0, 1, 2], [2, 1, 3]])
    cloud = pv.PolyData(VERTICES)
    assert_cloud(gt.as_domain(cloud))
    cloud.point_data["Normals"] = VERTICES
    assert_cloud(gt.as_domain(cloud), normals=VERTICES)
    with pytest.raises(InvalidDomainError, match="it has lines, but no faces"):
        gt.as_domain(pv.Line())


def test_pyvista_polygons_are_split_with_a_warning():
    pv = pytest.importorskip("pyvista")
    mixed = pv.PolyData(CUBE, [4, 0, 3, 2, 1, 3, 4, 5, 6, 3, 4, 6, 7])
    with pytest.warns(
        ReadWarning, match="PolyData: 1 polygon was split into 2 triangles"
    ) as caught:
        mesh = gt.as_domain(mixed)
    np.testing.assert_array_equal(mesh.faces, [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7]])
    assert caught[0].filename == __file__


def test_pyvista_grids():
    pv = pytest.importorskip("pyvista")
    cells = pv.CellType
    flat = pv.UnstructuredGrid([3, 0, 1, 2, 2, 0, 1], [cells.TRIANGLE, cells.LINE], CUBE)
    np.testing.assert_array_equal(gt.as_domain(flat).faces, [[0, 1, 2]])
    solid = pv.UnstructuredGrid([8, *range(8)], [cells.HEXAHEDRON], CUBE)
    with pytest.warns(ReadWarning, match="6 polygons were split into 12"):
        assert outward_area(gt.as_domain(solid)) == pytest.approx(6)
    voxel = pv.UnstructuredGrid([8, *range(8)], [cells.VOXEL], CUBE)
    with pytest.raises(UnsupportedDomainError, match="voxels are not a surface"):
        gt.as_domain(voxel)


def test_meshio():
    meshio = pytest.importorskip("meshio")
    assert_sphere(gt.as_domain(meshio.Mesh(VERTICES, [("triangle", FACES)])))
    assert_cloud(gt.as_domain(meshio.Mesh(VERTICES, [])))
    vertices = np.arange(len(VERTICES))[:, None]
    assert_cloud(gt.as_domain(meshio.Mesh(VERTICES, [("vertex", vertices)])))
    plane = gt.as_domain(meshio.Mesh(CUBE[:3, :2], [("triangle", [[0, 1, 2]])]))
    np.testing.assert_array_equal(plane.vertices, CUBE[:3])
    with pytest.raises(InvalidDomainError, match="no solid cells; the cells are line"):
        gt.as_domain(meshio.Mesh(CUBE, [("line", [[0, 1]])]))


def test_meshio_polygons_are_split_with_a_warning():
    meshio = pytest.importorskip("meshio")
    pentagon = np.roll(np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 3, 0], [0, 2, 0]]), 1, axis=0)
    mixed = meshio.Mesh(
        np.vstack([CUBE, pentagon]),
        [("quad", [[0, 1, 2, 3]]), ("triangle", [[4, 5, 6]]), ("polygon", [range(8, 13)])],
    )
    with pytest.warns(ReadWarning, match="Mesh: 2 polygons were split into 5 triangles"):
        mesh = gt.as_domain(mixed)
    np.testing.assert_array_equal(mesh.faces[[0, 1, 2]], [[0, 1, 2], [0, 2, 3], [4, 5, 6]])
    assert mesh.n_faces == 6


@pytest.mark.parametrize(
    ("kind", "corners", "area"),
    [
        ("tetra", [0, 1, 3, 4], 1.5 + np.sqrt(3) / 2),
        ("hexahedron", range(8), 6),
        ("wedge", [0, 1, 3, 4, 5, 7], 3 + np.sqrt(2)),
        ("pyramid", [0, 1, 2, 3, 4], 2 + np.sqrt(2)),
    ],
)
def test_a_solid_becomes_its_surface_seen_from_outside(kind, corners, area):
    block = SimpleNamespace(type=kind, data=np.array([list(corners)]))
    sizes, flat = surface_polygons([(block.type, block.data)])
    faces, _ = split_polygons(CUBE, sizes, flat)
    assert outward_area(gt.TriangleMesh(CUBE, faces)) == pytest.approx(area)


@pytest.mark.parametrize(
    ("kind", "n_faces"), [("triangle6", 4), ("triangle7", 6), ("quad8", 6), ("quad9", 8)]
)
@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.ReadWarning")  # quadrangles are split
def test_every_node_of_a_second_order_cell_has_its_distance(kind, n_faces):
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], dtype=float)
    corners = corners[[0, 1, 3]] if kind.startswith("triangle") else corners
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    nodes = np.concatenate([corners, middles, [corners.mean(axis=0)]])
    nodes = nodes[: int(kind[-1])]
    cells = [SimpleNamespace(type=kind, data=np.array([range(len(nodes))]))]
    mesh = gt.as_domain(SimpleNamespace(points=nodes, cells=cells))
    assert mesh.n_faces == n_faces
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    up = np.cross(b - a, c - a)[:, 2] / 2
    assert (up > 0).all()
    assert up.sum() == pytest.approx(2 if kind.startswith("triangle") else 4)
    np.testing.assert_allclose(gt.geodesic_distance(mesh, 0), np.linalg.norm(nodes, axis=1))


@pytest.mark.parametrize(
    ("kind", "number", "n_inside"),
    [
        ("tetra10", 24, 0),
        ("hexahedron20", 25, 0),
        ("hexahedron27", 29, 1),
        ("wedge15", 26, 0),
        ("wedge18", 32, 0),
        ("pyramid13", 27, 0),
        ("pyramid19", 37, 1),
    ],
)
def test_faces_of_second_order_solids_have_the_nodes_that_vtk_gives_them(kind, number, n_inside):
    data_model = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    cell = data_model.vtkGenericCell()
    cell.SetCellType(number)
    size = cell.GetNumberOfPoints()
    for node in range(size):
        cell.GetPointIds().SetId(node, node)
    theirs = set()
    for number in range(cell.GetNumberOfFaces()):
        ids = cell.GetFace(number).GetPointIds()
        theirs.add(frozenset(ids.GetId(place) for place in range(ids.GetNumberOfIds())))
    assert {frozenset(nodes) for nodes, _ in faces_of(kind, size)} == theirs
    sizes, corners = surface_polygons([(kind, [range(size)])])
    assert len(np.unique(corners)) == size - n_inside
    directed = [edge for polygon in np.split(corners, np.cumsum(sizes)[:-1]) for edge in
                zip(polygon.tolist(), np.roll(polygon, -1).tolist(), strict=True)]  # fmt: skip
    assert len(set(directed)) == len(directed)
    assert {(head, tail) for tail, head in directed} == set(directed)  # closed, of one orientation


@pytest.mark.parametrize("kind", ["triangle10", "tetra20", "quad16"])
def test_cells_of_a_third_order_are_refused_rather_than_cut_to_their_corners(kind):
    size = int(kind[-2:])
    with pytest.raises(InvalidDomainError, match=f"'{kind}' have more nodes than.*second order"):
        surface_polygons([(kind, [range(size)])])


def test_voxels_are_refused_with_what_to_give_instead():
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=(4, 3, 2))
    flat = pyvista.ImageData(dimensions=(4, 3, 1))
    for shape in (grid, grid.cast_to_unstructured_grid(), flat.cast_to_unstructured_grid()):
        with pytest.raises(UnsupportedDomainError, match=r"extract_surface\(.*grid_to_graph"):
            gt.as_domain(shape)
    graph = image.grid_to_graph(*grid.dimensions[::-1])
    steps = gt.geodesic_distance(graph, 0, refine=True)  # in the order of the points
    np.testing.assert_allclose(steps, grid.points.sum(axis=1))


def test_the_faces_between_solids_are_inside():
    stacked = np.vstack([CUBE, CUBE[4:] + np.eye(3)[2]])
    sizes, corners = surface_polygons([("hexahedron", [range(8), range(4, 12)])])
    mesh = gt.TriangleMesh(stacked, split_polygons(stacked, sizes, corners)[0])
    assert outward_area(mesh) == pytest.approx(10)


def test_faces_with_fewer_than_three_corners_are_left_out():
    faces, remarks = split_polygons(np.zeros((9, 3)), np.array([2, 3]), np.array([7, 8, 0, 1, 2]))
    np.testing.assert_array_equal(faces, [[0, 1, 2]])
    assert remarks == ["1 faces have fewer than three corners and were dropped"]


@pytest.mark.parametrize(
    ("row", "sizes", "corners"),
    [
        ([], [], []),
        ([1, 9], [1], [9]),
        ([3, 0, 1, 2, 4, 5, 6, 7, 8], [3, 4], [0, 1, 2, 5, 6, 7, 8]),
    ],
)
def test_polygons_stand_behind_their_sizes(row, sizes, corners):
    found = unpadded_polygons(np.array(row, dtype=np.int64))
    assert [part.tolist() for part in found] == [sizes, corners]


@pytest.mark.parametrize(
    "form", [sp.csr_array, sp.csc_matrix, sp.coo_array, sp.lil_matrix, sp.dok_array, sp.dia_array]
)
def test_entries_of_a_sparse_matrix_are_lengths(form):
    both = form(np.array([[5.0, 1, 0], [1, 0, 2.5], [0, 2.5, 0]]))
    graph = gt.as_domain(both)
    assert graph.n_vertices == 3
    assert graph.edges.tolist() == [[0, 1], [1, 2]]
    assert graph.lengths.tolist() == [1.0, 2.5]


def test_one_triangle_of_a_matrix_is_enough_and_the_shorter_length_counts():
    upper = gt.as_domain(sp.coo_array(np.triu(np.full((3, 3), 4))))
    assert upper.edges.tolist() == [[0, 1], [0, 2], [1, 2]]
    uneven = gt.as_domain(sp.csr_array([[0.0, 3.0], [2.0, 0.0]]))
    assert uneven.lengths.tolist() == [2.0]
    assert gt.as_domain(sp.csr_array([[False, True], [True, False]])).lengths.tolist() == [1.0]


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (sp.csr_array(np.ones((2, 3))), "square, not 2 x 3"),
        (sp.coo_array(np.ones(4)), "square, not 4"),
        (sp.csr_array([[0, 1j], [1j, 0]]), "edge lengths must be real numbers, not complex128"),
        (sp.coo_array(([-1.0], ([0], [1])), shape=(2, 2)), "edge 0 has length -1.0"),
        (sp.csr_array([[0, -1.0], [-1.0, 0]]), "edge 0 has length -1.0"),
        (sp.csr_array([[0, 1.0], [np.nan, 0]]), "edge 1 has length nan"),
    ],
)
def test_a_matrix_that_holds_no_lengths_is_refused(matrix, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.as_domain(matrix)


def test_networkx():
    nx = pytest.importorskip("networkx")
    network = nx.Graph()
    network.add_edge("b", "a", length=2.0, weight=9.0)
    network.add_edge("a", "c", weight=3)
    network.add_edge("c", "d")
    network.add_node("alone")
    graph = gt.as_domain(network)
    assert graph.n_vertices == 5  # b, a, c, d, alone
    assert graph.edges.tolist() == [[0, 1], [1, 2], [2, 3]]
    assert graph.lengths.tolist() == [2.0, 3.0, 1.0]
    assert repr(gt.as_domain(nx.DiGraph([(0, 1), (1, 0), (1, 2)]))) == "Graph(3 vertices, 3 edges)"
    assert repr(gt.as_domain(nx.MultiGraph([(0, 1), (0, 1)]))) == "Graph(2 vertices, 2 edges)"
    assert repr(gt.as_domain(nx.empty_graph(2))) == "Graph(2 vertices, 0 edges)"


def test_networkx_lengths_that_are_none_are_refused():
    nx = pytest.importorskip("networkx")
    with pytest.raises(InvalidDomainError, match="the graph has no vertices"):
        gt.as_domain(nx.Graph())
    network = nx.Graph()
    network.add_edge(0, 1, length="long")
    with pytest.raises(InvalidDomainError, match="lengths must hold real numbers"):
        gt.as_domain(network)


def test_nilearn_names_its_arrays_coordinates_and_faces():
    mesh = SimpleNamespace(coordinates=VERTICES, faces=FACES)  # as InMemoryMesh does
    assert_sphere(gt.as_domain(mesh))


def test_gifti_images():
    gifti = pytest.importorskip("nibabel.gifti")
    points = gifti.GiftiDataArray(VERTICES.astype(np.float32), "NIFTI_INTENT_POINTSET")
    triangles = gifti.GiftiDataArray(FACES.astype(np.int32), "NIFTI_INTENT_TRIANGLE")
    assert_sphere(gt.as_domain(gifti.GiftiImage(darrays=[points, triangles])), rtol=1e-6)
    with pytest.raises(InvalidDomainError, match="the GIFTI image holds no surface"):
        gt.as_domain(gifti.GiftiImage(darrays=[points]))


@pytest.mark.parametrize(
    ("thing", "named"),
    [
        (7, "int"),
        (gt.TriangleMesh, "the class TriangleMesh"),
        (np.zeros((2, 2, 3)), r"an array of shape \(2, 2, 3\)"),
        (np.zeros((4, 3), complex), r"an array of shape \(4, 3\) and dtype complex128"),
        ([], "list"),
        (object(), "object"),
    ],
    ids=lambda value: None,
)
def test_an_object_that_is_not_a_shape_is_refused_by_name(thing, named):
    with pytest.raises(
        UnsupportedDomainError, match=f"^{named}.* is not a shape; give a TriangleMesh"
    ):
        gt.as_domain(thing)


@pytest.mark.parametrize(
    ("thing", "cure"),
    [
        (None, "None is not a shape; did a function return nothing"),
        ("bunny.off", r"'bunny.off' is not a shape \(to read a file: geodesic_toolkit.read\)"),
        (
            Path("bunny.off"),
            r"'bunny.off' is not a shape \(to read a file: geodesic_toolkit.read\)",
        ),
        ({"vertices": VERTICES, "faces": FACES}, r'as a pair, \(d\["vertices"\], d\["faces"\]\)'),
        ({"v": VERTICES, "f": FACES}, r"its keys are 'v', 'f'"),
        (
            VERTICES[:, :2],
            r"size 42 x 2 is not a shape; .* numpy.column_stack\(\[xy, 0 \* xy\[:, 0\]\]\)",
        ),
        (np.zeros((30, 10)), r"points in 10 dimensions .*kneighbors_graph\(table, 10, mode="),
        (np.zeros((30, 10)).tolist(), "points in 10 dimensions"),
        (np.zeros((30, 1)), "has 1 column of float64"),
        (VERTICES > 0, "has 3 columns of bool"),
        (np.zeros((5, 5)), r"lengths of edges.* scipy.sparse.csr_array\(table\)"),
        ([SPHERE, SPHERE], "list of 2, the first .*TriangleMesh, is not a shape; give one shape"),
        ([[0, 0, 0], "abc"], "list of 2, the first list, is not a shape"),
        ((1, 2), "tuple of 2, the first int, is not a shape"),
    ],
    ids=lambda value: None,
)
def test_what_people_hold_instead_of_a_shape_is_refused_with_the_cure(thing, cure):
    with pytest.raises(UnsupportedDomainError, match=cure):
        gt.as_domain(thing)


@pytest.mark.slow
def test_the_cures_that_messages_give_are_taken():
    flat = VERTICES[:, :2]
    assert repr(gt.as_domain(np.column_stack([flat, 0 * flat[:, 0]]))) == "PointCloud(42 points)"
    neighbors = pytest.importorskip("sklearn.neighbors")
    table = np.random.default_rng(0).normal(size=(30, 10))
    graph = gt.as_domain(neighbors.kneighbors_graph(table, 10, mode="distance"))
    assert graph.n_vertices == 30
    assert gt.as_domain(sp.csr_array(np.array([[0.0, 2], [2, 0]]))).lengths.tolist() == [2]
    quads = np.array([[0, 1, 2, 3], [4, 5, 6, 7]])
    halves = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    assert gt.as_domain((CUBE, halves)).n_faces == 4


@pytest.mark.parametrize("make", [gt.TriangleMesh, lambda *pair: gt.as_domain(pair)])
def test_faces_of_four_corners_are_refused_with_the_cure(make):
    with pytest.raises(InvalidDomainError, match=r"shape \(n, 3\), not \(1, 4\). Split quad"):
        make(CUBE, [[0, 1, 2, 3]])


def test_freesurfer_surfaces_may_have_metadata_and_a_stamp(tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    freesurfer.write_geometry(str(tmp_path / "lh.pial"), VERTICES, FACES, volume_info=None)
    assert_sphere(gt.as_domain((VERTICES, FACES, {"valid": "1"})))
    assert_sphere(gt.as_domain((VERTICES, FACES, {}, "created by a program")))
    read = freesurfer.read_geometry(str(tmp_path / "lh.pial"), read_stamp=True)
    assert_sphere(gt.as_domain(read), rtol=1e-6)
    assert isinstance(gt.as_domain([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), gt.PointCloud)


# -- several shapes in one object -----------------------------------------------------------------


def test_a_scene_of_one_mesh_is_the_mesh_where_the_scene_puts_it():
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.Trimesh(VERTICES, FACES, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(ball, transform=trimesh.transformations.translation_matrix([1, 2, 3]))
    mesh = gt.as_domain(scene)
    np.testing.assert_allclose(mesh.vertices, VERTICES + np.array([1, 2, 3]))
    np.testing.assert_array_equal(mesh.faces, FACES)
    np.testing.assert_array_equal(ball.vertices, VERTICES)  # is left as it was


def advice(refused):
    """Return the codes that a message offers: for each shape, and for all as one."""
    with pytest.raises(UnsupportedDomainError, match=r"holds \d+ shapes; give one: ") as caught:
        gt.as_domain(refused)
    each, _, joined = str(caught.value).partition("give one: ")[2].partition("; ")
    codes = [code.partition(" (")[0] for code in each.split(", ")]
    return codes, joined.removeprefix("or all as one shape: ")


def placed_scene(trimesh, *shapes):
    """Return a scene with each shape, and the first one once more, 5 beside it."""
    scene = trimesh.Scene({f"shape {i}": shape for i, shape in enumerate(shapes)})
    aside = trimesh.transformations.translation_matrix([5, 0, 0])
    scene.graph.update("again", matrix=aside, geometry="shape 0")
    return scene


def test_a_scene_of_several_meshes_is_refused_with_code_for_each_and_for_the_whole():
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.Trimesh(VERTICES, FACES, process=False)
    for scene, count in ((placed_scene(trimesh, ball), 2), (placed_scene(trimesh, ball, ball), 3)):
        codes, joined = advice(scene)
        shapes_ = [gt.as_domain(eval(code, {"scene": scene})) for code in codes]
        assert [len(one.vertices) for one in shapes_] == count * [42]
        np.testing.assert_allclose(shapes_[-1].vertices, VERTICES + np.array([5, 0, 0]))
        whole = gt.as_domain(eval(joined, {"scene": scene}))
        np.testing.assert_allclose(
            whole.vertices, np.concatenate([one.vertices for one in shapes_]), atol=1e-15
        )
    with pytest.raises(UnsupportedDomainError, match="Scene is not a shape: it is empty"):
        gt.as_domain(trimesh.Scene())


def test_clouds_of_a_scene_are_joined_by_their_points_and_not_with_meshes():
    trimesh = pytest.importorskip("trimesh")
    ball, cloud = trimesh.Trimesh(VERTICES, FACES, process=False), trimesh.PointCloud(VERTICES)
    scene = placed_scene(trimesh, cloud)
    codes, joined = advice(scene)
    assert len(codes) == 2
    assert gt.as_domain(eval(joined, {"numpy": np, "scene": scene})).n_vertices == 84
    codes, joined = advice(placed_scene(trimesh, cloud, ball))  # trimesh leaves the clouds out
    assert len(codes) == 3
    assert not joined


def test_blocks_of_one_shape_are_the_shape_and_several_are_refused_with_the_cure():
    pv = pytest.importorskip("pyvista")
    surface = pv.PolyData.from_regular_faces(VERTICES, FACES)
    for inner in ([surface], [None, surface], [None, pv.MultiBlock([None, surface])]):
        assert_sphere(gt.as_domain(pv.MultiBlock(inner)))
    other = surface.translate([5, 0, 0])
    pair = pv.MultiBlock({"left": surface, "right": other})
    for blocks, count in ((pair, 2), (pv.MultiBlock({"both": pair, "third": surface}), 3)):
        codes, joined = advice(blocks)
        assert len(codes) == count
        assert_sphere(gt.as_domain(eval(codes[0])))
        assert gt.as_domain(eval(joined)).n_vertices == 42 * count
    for empty in (pv.MultiBlock(), pv.MultiBlock([None, pv.MultiBlock()])):
        with pytest.raises(UnsupportedDomainError, match="MultiBlock is not a shape: it is empty"):
            gt.as_domain(empty)


def test_structured_grids_are_refused_with_the_cure():
    pv = pytest.importorskip("pyvista")
    axis = np.arange(4.0)
    for grid in (
        pv.ImageData(dimensions=(4, 4, 1)),
        pv.RectilinearGrid(axis, axis, axis[:1]),
        pv.StructuredGrid(*np.meshgrid(axis, axis, axis[:1])),
    ):
        with pytest.raises(UnsupportedDomainError, match=r"give its surface, grid.extract_surface"):
            gt.as_domain(grid)


def test_a_pair_of_hemispheres_is_taken_where_it_is_one_and_else_the_message_says_which():
    left = SimpleNamespace(coordinates=VERTICES, faces=FACES)
    one, both = (SimpleNamespace(parts=dict.fromkeys(names, left)) for names in ("l", "lr"))
    assert_sphere(gt.as_domain(one))
    assert_sphere(gt.as_domain(SimpleNamespace(mesh=one, data=None)))  # as SurfaceImage does
    says = r"holds 2 shapes; give one: mesh.parts\['l'\], mesh.parts\['r'\]"
    with pytest.raises(UnsupportedDomainError, match=says):
        gt.as_domain(both)


def test_the_hemispheres_of_nilearn():
    surface = pytest.importorskip("nilearn.surface")
    left = surface.InMemoryMesh(VERTICES, FACES)
    assert_sphere(gt.as_domain(surface.PolyMesh(left=left)))
    says = r"give one: mesh.parts\['left'\], mesh.parts\['right'\]"
    with pytest.raises(UnsupportedDomainError, match=says):
        gt.as_domain(surface.PolyMesh(left=left, right=left))


@pytest.mark.parametrize(
    ("thing", "message"),
    [
        ((VERTICES, FACES + 1), "refers to vertex 42"),
        ((VERTICES, []), "no faces"),
        ((VERTICES, [[0, 1, 2], [0, 1]]), "faces cannot be read as an array: row 1 has 2"),
        ([[[0, 0, 0], [1]], [[0, 1, 2]]], "vertices cannot be read as an array: row 1 has 1"),
        ([[0, 0, 0], [1]], "points cannot be read as an array: row 1 has 1 entries, where row 0"),
        (np.zeros((0, 3)), "no points"),
    ],
)
def test_a_shape_with_something_wrong_is_an_invalid_domain(thing, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.as_domain(thing)


@pytest.mark.slow
def test_no_foreign_package_is_imported():
    code = (
        "import sys, geodesic_toolkit as gt\n"
        "gt.as_domain(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))\n"
        "try:\n    gt.as_domain(object())\nexcept gt.errors.UnsupportedDomainError:\n    pass\n"
        "print(*{name.partition('.')[0] for name in sys.modules})"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    foreign = {"trimesh", "open3d", "pyvista", "vtk", "meshio", "networkx", "nibabel", "nilearn"}
    assert not foreign & set(result.stdout.split())
