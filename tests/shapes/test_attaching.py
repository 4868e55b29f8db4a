"""Distances on the objects that users have: the right value at every vertex, or an error."""

from types import SimpleNamespace

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

SPHERE = shapes.icosphere(1)
VERTICES, FACES = np.array(SPHERE.vertices), np.array(SPHERE.faces)
FAR = np.where(np.arange(42) == 7, np.inf, VERTICES[:, 2])
"""Values that name their vertex, one of them infinite."""

CORNERS = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]


@pytest.fixture
def box_with_seams(tmp_path):
    """An OBJ file whose 8 vertices have texture coordinates of their own on each of 6 faces."""
    path = tmp_path / "box.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in reversed(CORNERS)]
    lines += [f"vt {row / 6} {column / 4}" for row in range(6) for column in range(4)]
    for row, quad in enumerate(QUADS):
        texture = range(4 * row + 1, 4 * row + 5)
        corners = [f"{v}/{vt}" for v, vt in zip(quad, texture, strict=True)]
        lines += [f"f {' '.join(corners[i] for i in three)}" for three in ((0, 1, 2), (0, 2, 3))]
    path.write_text("\n".join(lines) + "\n")
    return path


# -- each library ----------------------------------------------------------------------------------


def test_trimesh():
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    assert gt.attach(mesh, FAR) is mesh
    np.testing.assert_array_equal(mesh.vertex_attributes["distance"], FAR)
    cloud = trimesh.PointCloud(VERTICES)
    gt.attach(cloud, FAR, "from the pole")
    np.testing.assert_array_equal(cloud.metadata["from the pole"], FAR)
    path = trimesh.load_path([[[0, 0, 0], [1, 0, 0]]])
    with pytest.raises(UnsupportedDomainError, match="Path3D holds no values of vertices"):
        gt.attach(path, [0.0, 1.0])


def test_attributes_of_trimesh_are_in_the_file_that_it_writes():
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    gt.attach(mesh, FAR.astype(np.float32), fill=-1)
    again = trimesh.load_mesh(
        trimesh.util.wrap_as_stream(mesh.export(file_type="ply")), file_type="ply", process=False
    )
    read = again.metadata["_ply_raw"]["vertex"]["data"]["distance"].ravel()
    np.testing.assert_array_equal(read, np.where(np.isinf(FAR), -1, FAR).astype(np.float32))


def test_a_scene_of_trimesh_with_one_mesh():
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    placement = trimesh.transformations.rotation_matrix(1.0, [1, 2, 3], [4, 5, 6])
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    name = scene.add_geometry(mesh, transform=placement)
    assert gt.attach(scene, FAR) is scene
    np.testing.assert_array_equal(scene.geometry[name].vertex_attributes["distance"], FAR)
    placed = gt.as_domain(scene)
    turned = gt.TriangleMesh(placed.vertices[::-1], 41 - placed.faces)
    gt.attach(scene, FAR[::-1], "again", domain=turned)
    np.testing.assert_array_equal(scene.geometry[name].vertex_attributes["again"], FAR)
    scene.add_geometry(mesh.copy())
    with pytest.raises(UnsupportedDomainError, match=r"holds 2 shapes; give one: scene.dump"):
        gt.attach(scene, FAR)


def test_open3d_tensors():
    o3d = pytest.importorskip("open3d")
    mesh = o3d.t.geometry.TriangleMesh()
    with pytest.raises(UnsupportedDomainError, match="TriangleMesh has no vertices"):
        gt.attach(mesh, FAR)
    mesh.vertex.positions = o3d.core.Tensor(VERTICES.astype(np.float32))
    mesh.triangle.indices = o3d.core.Tensor(FACES.astype(np.int32))
    assert gt.attach(mesh, FAR) is mesh
    np.testing.assert_array_equal(mesh.vertex.distance.numpy(), FAR[:, None])
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor(VERTICES))
    gt.attach(cloud, FAR)
    np.testing.assert_array_equal(cloud.point.distance.numpy(), FAR[:, None])
    gt.attach(cloud, np.arange(42) > 3, "near")
    assert cloud.point.near.numpy().dtype == np.bool_


def test_legacy_geometries_of_open3d_come_back_as_tensors():
    o3d = pytest.importorskip("open3d")
    points = o3d.utility.Vector3dVector(VERTICES)
    mesh = o3d.geometry.TriangleMesh(points, o3d.utility.Vector3iVector(FACES))
    mesh.paint_uniform_color([0.1, 0.2, 0.3])
    held = gt.attach(mesh, FAR)
    np.testing.assert_array_equal(held.vertex.distance.numpy(), FAR[:, None])
    np.testing.assert_array_equal(held.vertex.positions.numpy(), VERTICES)
    np.testing.assert_allclose(held.vertex.colors.numpy(), np.tile([0.1, 0.2, 0.3], (42, 1)))
    cloud = gt.attach(o3d.geometry.PointCloud(points), FAR)
    np.testing.assert_array_equal(cloud.point.distance.numpy(), FAR[:, None])


def test_pyvista():
    pv = pytest.importorskip("pyvista")
    surface = pv.PolyData.from_regular_faces(VERTICES, FACES)
    assert gt.attach(surface, FAR) is surface
    np.testing.assert_array_equal(surface.point_data["distance"], FAR)
    grid = surface.cast_to_unstructured_grid()
    np.testing.assert_array_equal(gt.attach(grid, FAR, "d").point_data["d"], FAR)
    image = pv.ImageData(dimensions=(7, 3, 2))
    np.testing.assert_array_equal(gt.attach(image, FAR).point_data["distance"], FAR)
    blocks = pv.MultiBlock([None, surface.copy()])
    assert gt.attach(blocks, FAR, "inside") is blocks
    np.testing.assert_array_equal(blocks[1].point_data["inside"], FAR)
    blocks.append(surface)
    with pytest.raises(UnsupportedDomainError, match=r"holds 2 shapes; give one: blocks\["):
        gt.attach(blocks, FAR)


def test_meshio():
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(VERTICES, [("triangle", FACES)])
    assert gt.attach(mesh, FAR) is mesh
    np.testing.assert_array_equal(mesh.point_data["distance"], FAR)
    plane = meshio.Mesh([[0, 0], [3, 0], [0, 4]], [("triangle", [[0, 1, 2]])])
    domain = gt.as_domain(plane)
    gt.attach(plane, gt.geodesic_distance(domain, 1), domain=domain)
    np.testing.assert_allclose(plane.point_data["distance"], [3, 0, 5])


def test_nilearn():
    surface = pytest.importorskip("nilearn.surface")
    left, right = surface.InMemoryMesh(VERTICES, FACES), surface.InMemoryMesh(2 * VERTICES, FACES)
    one, both = surface.PolyMesh(right=right), surface.PolyMesh(left=left, right=right)
    image = gt.attach(one, FAR)
    np.testing.assert_array_equal(image.data.parts["right"], FAR)
    again = gt.attach(image, FAR, fill=0)
    assert again is not image
    assert again.mesh is one
    assert again.data.parts["right"][7] == 0
    pair = gt.attach(both, {"left": FAR, "right": 2 * FAR})
    np.testing.assert_array_equal(pair.data.parts["right"], 2 * FAR)
    with pytest.raises(UnsupportedDomainError, match=r"each, {'left': ..., 'right': ...}"):
        gt.attach(pair, FAR)
    with pytest.raises(InvalidOptionError, match=r"given for 'left', and .* has 'left', 'right'"):
        gt.attach(both, {"left": FAR})
    with pytest.raises(InvalidOptionError, match=r"41 values, and .*InMemoryMesh has 42"):
        gt.attach(both, {"left": FAR, "right": FAR[1:]})
    with pytest.raises(UnsupportedDomainError, match=r"give the hemisphere .*PolyMesh\(left=mesh"):
        gt.attach(left, FAR)


def test_hemispheres_are_taken_from_a_surface_image():
    surface = pytest.importorskip("nilearn.surface")
    one = surface.PolyMesh(left=surface.InMemoryMesh(VERTICES, FACES))
    image = surface.SurfaceImage(one, {"left": FAR})
    np.testing.assert_array_equal(gt.as_domain(image).faces, FACES)


@pytest.mark.filterwarnings("ignore::FutureWarning")  # anndata's own, of zarr and pandas
def test_anndata():
    anndata = pytest.importorskip("anndata")
    table = anndata.AnnData(np.ones((42, 3)))
    assert gt.attach(table, FAR, "pseudotime") is table
    np.testing.assert_array_equal(table.obs["pseudotime"], FAR)
    with pytest.raises(UnsupportedDomainError, match=r'graph of its neighbours, adata.obsp\["dist'):
        gt.as_domain(table)
    with pytest.raises(InvalidOptionError, match=r"41 values, and .*AnnData has 42"):
        gt.attach(table, FAR[1:])


def test_networkx():
    nx = pytest.importorskip("networkx")
    network = nx.path_graph(["a", "b", "c"])
    gt.attach(network, gt.geodesic_distance(network, 2))
    assert dict(network.nodes(data="distance")) == {"a": 2.0, "b": 1.0, "c": 0.0}


# -- names that an object has for other things -----------------------------------------------------


def of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    return trimesh.Trimesh(VERTICES, FACES, process=False)


def cloud_of_trimesh():
    return pytest.importorskip("trimesh").PointCloud(VERTICES, metadata={"title": "a sphere"})


def of_open3d():
    o3d = pytest.importorskip("open3d")
    mesh = o3d.t.geometry.TriangleMesh(o3d.core.Tensor(VERTICES), o3d.core.Tensor(FACES))
    mesh.vertex.uv = o3d.core.Tensor(VERTICES[:, :2].copy())
    return mesh


def cloud_of_open3d():
    o3d = pytest.importorskip("open3d")
    return o3d.t.geometry.PointCloud(o3d.core.Tensor(VERTICES))


def legacy_of_open3d():
    o3d = pytest.importorskip("open3d")
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(VERTICES))


def of_pyvista():
    cloud = pytest.importorskip("pyvista").PolyData(VERTICES)
    cloud.point_data["uv"] = VERTICES[:, :2]
    return cloud


def of_meshio():
    return pytest.importorskip("meshio").Mesh(VERTICES, [("triangle", FACES)])


def of_networkx():
    graph = pytest.importorskip("networkx").path_graph(42)
    graph.nodes[3]["pos"] = (0.0, 1.0)
    return graph


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (of_trimesh, ("x", "vertex", "s")),
        (cloud_of_trimesh, ("units", "name", "title")),
        (of_open3d, ("positions", "normals", "colors", "texture_uvs", "indices", "uv")),
        (cloud_of_open3d, ("positions", "normals", "colors", "opacity", "scale", "nx")),
        (legacy_of_open3d, ("positions", "normals", "colors")),
        (of_pyvista, ("Normals", "vtkGhostType", "uv")),
        (of_meshio, ("gmsh:dim_tags",)),
        (of_networkx, ("pos",)),
    ],
)
def test_names_of_other_things_are_refused_and_the_offered_name_is_taken(make, names):
    for name in names:
        obj = make()
        with pytest.raises(InvalidOptionError, match=f"^name '{name}' is that of ") as caught:
            gt.attach(obj, FAR, name)
        offered = str(caught.value).rpartition("such as ")[2].strip("'")
        changed = gt.attach(obj, FAR, offered)
        gt.attach(changed, 2 * FAR, offered)  # numbers are replaced
        with pytest.raises(InvalidOptionError, match=f"^name '{name}' is that of "):
            gt.attach(changed, FAR, name)  # nothing was lost
        assert gt.as_domain(changed).n_vertices == 42


def test_names_of_the_index_and_of_categories_in_a_table_are_refused():
    class Observations(dict):
        index = SimpleNamespace(name="cell")

    obs = Observations(cluster=np.array(["B", "T"] * 21), depth=np.zeros(42))
    table = SimpleNamespace(obs=obs, obsm={}, n_obs=42)
    for name in ("cell", "_index", "cluster"):
        with pytest.raises(InvalidOptionError, match=f"name '{name}' is that of "):
            gt.attach(table, FAR, name)
    np.testing.assert_array_equal(gt.attach(table, FAR, "depth").obs["depth"], FAR)


def test_values_on_a_cloud_of_open3d_are_in_the_file_that_it_writes(tmp_path):
    o3d = pytest.importorskip("open3d")
    cloud = gt.attach(cloud_of_open3d(), FAR)
    file = str(tmp_path / "cloud.ply")
    assert o3d.t.io.write_point_cloud(file, cloud)
    again = o3d.t.io.read_point_cloud(file)
    np.testing.assert_array_equal(again.point.distance.numpy().ravel(), FAR)


# -- infinite values, and other kinds of value -----------------------------------------------------


def holder(points=VERTICES):
    return SimpleNamespace(points=points, point_data={})


def test_infinite_values_stay_unless_a_fill_replaces_them():
    held = gt.attach(holder(), FAR).point_data["distance"]
    assert np.isinf(held[7])
    filled = gt.attach(holder(), FAR, fill=np.nan).point_data["distance"]
    assert np.isnan(filled[7])
    np.testing.assert_array_equal(np.delete(filled, 7), np.delete(FAR, 7))


def test_values_are_a_copy_in_a_type_that_every_library_has():
    given = FAR.copy()
    held = gt.attach(holder(), given).point_data["distance"]
    given[:] = 0
    np.testing.assert_array_equal(held, FAR)
    for dtype, expected in {">f8": "<f8", "f2": "f8", "f4": "f4", "u2": "i8", "?": "?"}.items():
        values = np.ones(42, dtype=dtype)
        assert gt.attach(holder(), values).point_data["distance"].dtype == np.dtype(expected)


@pytest.mark.parametrize(
    ("values", "options", "message"),
    [
        (np.zeros((2, 42)), {}, r"shape \(2, 42\) \(attach one row at a time: distances\[0\]\)"),
        (np.zeros(()), {}, r"not the shape \(\)"),
        ([[1.0], [1.0, 2.0]], {}, "distance cannot be read as an array"),
        (np.full(42, 2**63, dtype=np.uint64), {}, "integers that are too large for int64"),
        (["a"] * 42, {}, "must hold real numbers, not <U1"),
        (np.ma.masked_equal(np.arange(42), 3), {}, r"entry \[3\] is masked"),
        (FAR[1:], {}, "distance has 41 values, and types.SimpleNamespace has 42 vertices"),
        (FAR, {"name": ""}, "name must be the name of the values, not ''"),
        (FAR, {"name": 3}, "not 3"),
        (FAR, {"fill": "nan"}, "fill must be a number or None, not 'nan'"),
        (FAR, {"fill": True}, "fill must be a number or None, not True"),
        ({"left": FAR}, {}, "a mapping of values is for the hemispheres of nilearn"),
        (FAR[1:], {"domain": SPHERE}, "distance has 41 values, and .*TriangleMesh has 42 vertices"),
    ],
)
def test_values_that_are_not_one_per_vertex_are_refused(values, options, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.attach(holder(), values, **options)


def test_objects_that_hold_no_values_are_refused_with_what_to_do():
    with pytest.raises(UnsupportedDomainError, match=r"immutable; write\(file, shape, distance\)"):
        gt.attach(SPHERE, FAR)
    with pytest.raises(UnsupportedDomainError, match=r"tuple holds no values .* give a mesh"):
        gt.attach((VERTICES, FACES), FAR)


# -- vertices in another order ---------------------------------------------------------------------


def test_values_of_a_file_do_not_fit_a_mesh_that_was_split_along_seams(box_with_seams):
    trimesh = pytest.importorskip("trimesh")
    mesh, file = trimesh.load_mesh(box_with_seams), gt.read(box_with_seams)
    assert (len(mesh.vertices), file.n_vertices) == (24, 8)
    distance = gt.geodesic_distance(file, 7)  # of the corner at the origin
    with pytest.raises(InvalidOptionError, match=r"8 values, and .*Trimesh has 24 vertices. After"):
        gt.attach(mesh, distance)
    gt.attach(mesh, distance, domain=file)
    held = mesh.vertex_attributes["distance"]
    order = np.argsort(np.linalg.norm(mesh.vertices, axis=1), kind="stable")
    np.testing.assert_array_equal(held[order[:3]], 0)
    np.testing.assert_allclose(held[order[3:12]], 1)
    np.testing.assert_allclose(held[order[12:21]], np.sqrt(2))
    np.testing.assert_allclose(held[order[21:]], np.sqrt(5))


def test_values_of_merged_vertices_come_back_by_their_new_numbers(box_with_seams):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.load_mesh(box_with_seams)
    merged, new = gt.merge_vertices(mesh)
    distance = gt.geodesic_distance(merged, 0)
    gt.attach(mesh, distance[new], "by number")
    gt.attach(mesh, distance, "by position", domain=merged)
    by_number, by_position = (mesh.vertex_attributes[f"by {way}"] for way in ("number", "position"))
    np.testing.assert_array_equal(by_number, by_position)


def test_values_follow_the_positions_where_the_order_is_another():
    order = np.random.default_rng(0).permutation(42)
    shuffled = holder(VERTICES[order].astype(np.float32))
    held = gt.attach(shuffled, FAR, domain=SPHERE).point_data["distance"]
    np.testing.assert_array_equal(held, FAR[order])


def test_points_without_a_position_keep_their_values_in_the_same_order():
    points = VERTICES.copy()
    points[3] = np.nan
    held = gt.attach(holder(points), FAR, domain=gt.PointCloud(points)).point_data["distance"]
    np.testing.assert_array_equal(held, FAR)


def test_vertices_that_were_not_measured_are_refused():
    more = np.concatenate([VERTICES, [[9.0, 9.0, 9.0], [np.nan] * 3]])
    with pytest.raises(
        InvalidOptionError, match=r"2 of 44 .*has 42; the first is vertex 42, at \["
    ):
        gt.attach(holder(more), FAR, domain=SPHERE)


def test_two_values_at_one_position_are_refused():
    twice = gt.TriangleMesh(
        np.concatenate([VERTICES, VERTICES]), np.concatenate([FACES, FACES + 42])
    )
    both = np.concatenate([FAR, FAR])
    held = gt.attach(holder(), both, domain=twice).point_data["distance"]
    np.testing.assert_array_equal(held, FAR)
    both[44] += 1
    with pytest.raises(InvalidOptionError, match="vertices 2 and 44 of the domain are at one posi"):
        gt.attach(holder(), both, domain=twice)


def test_a_graph_has_the_order_of_the_object():
    graph = gt.Graph(42, [[0, 1]])
    held = gt.attach(holder(), FAR, domain=graph).point_data["distance"]
    np.testing.assert_array_equal(held, FAR)


# -- objects of plugins ----------------------------------------------------------------------------


class Volume(gt.Domain):
    """A kind of domain of a plugin, which has objects of its own."""

    n_vertices = 3

    def attach(self, obj, values, name):
        obj.fields = {name: values}
        return obj


def test_a_kind_of_domain_attaches_to_objects_of_its_own():
    image = SimpleNamespace()
    assert gt.attach(image, [0, 1, np.inf], "d", domain=Volume(), fill=9) is image
    np.testing.assert_array_equal(image.fields["d"], [0, 1, 9])
    with pytest.raises(InvalidOptionError, match=r"2 values, and .*Volume has 3 vertices"):
        gt.attach(image, [0, 1], domain=Volume())
    known = holder(VERTICES[:3])
    assert gt.attach(known, [0, 1, 2], domain=Volume()).point_data["distance"].tolist() == [0, 1, 2]
