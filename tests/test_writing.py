"""Distances to files: whole or not at all, and read again with every digit."""

import csv
import os
import sys

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, WriteError
from geodesic_toolkit.io import check_output, replacing, write_distances
from geodesic_toolkit.testing import shapes

GREY = [160, 160, 160]


@pytest.fixture
def sphere():
    return shapes.icosphere(1)


@pytest.fixture
def field(sphere):
    field = np.linspace(0, np.pi, sphere.n_vertices) ** 3
    field[7] = np.inf
    return field


def vertex_table(path):
    """The properties of a binary PLY's vertices, read without the code under test."""
    header, data = path.read_bytes().split(b"end_header\n", 1)
    lines = header.decode().splitlines()
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    properties = []
    for line in lines[lines.index(f"element vertex {count}") + 1 :]:
        if not line.startswith("property"):
            break
        _, kind, name = line.split()
        properties.append((name, {"double": "<f8", "uchar": "u1"}[kind]))
    return np.frombuffer(data, properties, count), lines


# -- the formats ----------------------------------------------------------------------------------


def test_a_ply_holds_the_mesh_and_its_distances(sphere, field, tmp_path):
    path = tmp_path / "d.ply"
    write_distances(path, sphere, field, sources=[3, 5])
    again = gt.read(path)
    np.testing.assert_array_equal(again.vertices, sphere.vertices)
    np.testing.assert_array_equal(again.faces, sphere.faces)
    table, lines = vertex_table(path)
    np.testing.assert_array_equal(table["distance"], field)
    assert "comment geodesic distance from vertices 3 5" in lines


def test_a_ply_is_coloured_and_grey_where_nothing_reaches(sphere, field, tmp_path):
    colormaps = pytest.importorskip("matplotlib").colormaps
    write_distances(tmp_path / "d.ply", sphere, field)
    table, _ = vertex_table(tmp_path / "d.ply")
    colours = np.column_stack([table[name] for name in ("red", "green", "blue")])
    assert colours[7].tolist() == GREY
    np.testing.assert_allclose(colours[0], 255 * np.array(colormaps["viridis"](0.0)[:3]), atol=1)
    np.testing.assert_allclose(colours[-1], 255 * np.array(colormaps["viridis"](1.0)[:3]), atol=1)


def test_a_ply_has_no_colours_without_matplotlib(sphere, field, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    write_distances(tmp_path / "d.ply", sphere, field)
    table, _ = vertex_table(tmp_path / "d.ply")
    assert table.dtype.names == ("x", "y", "z", "distance")


@pytest.mark.parametrize("value", [0.0, np.inf])
def test_a_ply_of_a_constant_field_is_written(sphere, value, tmp_path):
    write_distances(tmp_path / "d.ply", sphere, np.full(sphere.n_vertices, value))
    assert (vertex_table(tmp_path / "d.ply")[0]["distance"] == value).all()


def test_a_ply_holds_a_cloud_with_its_normals_and_missing_points(tmp_path):
    points = [[5403849.123456789, 1, 2], [np.nan] * 3, [0, 0, 1]]
    cloud = gt.PointCloud(points, [[0, 0, 1], [0, 0, 1], [0.6, 0.8, 0]])
    path = tmp_path / "d.ply"
    write_distances(path, cloud, [0.0, np.inf, 2.5], sources=0)
    again = gt.read(path)
    np.testing.assert_array_equal(again.points, cloud.points)
    np.testing.assert_allclose(again.normals, cloud.normals, atol=1e-15)
    assert "comment geodesic distance from vertices 0" in vertex_table(path)[1]


def test_the_comment_of_a_ply_lists_some_of_many_sources_and_no_others(sphere, field, tmp_path):
    path = tmp_path / "d.ply"
    write_distances(path, sphere, field, sources=np.arange(30))
    assert f"from vertices {' '.join(map(str, range(20)))} and 10 more" in vertex_table(path)[1][2]
    write_distances(path, sphere, field, sources=[[0.5, 0.5, 0.5]])
    assert vertex_table(path)[1][2] == "comment geodesic distance"


def test_an_npy_holds_the_distances_alone(sphere, field, tmp_path):
    write_distances(str(tmp_path / "d.NPY"), sphere, field.tolist())
    again = np.load(tmp_path / "d.NPY")
    assert again.dtype == np.float64
    np.testing.assert_array_equal(again, field)


def test_a_csv_holds_every_digit(sphere, field, tmp_path):
    write_distances(tmp_path / "d.csv", sphere, field)
    with (tmp_path / "d.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["vertex", "x", "y", "z", "distance"]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, 0], np.arange(len(field)))
    np.testing.assert_array_equal(table[:, 1:4], sphere.vertices)
    np.testing.assert_array_equal(table[:, 4], field)


def test_a_csv_of_a_graph_has_no_positions(tmp_path):
    write_distances(tmp_path / "d.csv", gt.Graph(2, [[0, 1]]), [0, 0.1])
    assert (tmp_path / "d.csv").read_text() == "vertex,distance\n0,0.0\n1,0.1\n"


# -- what cannot be written -----------------------------------------------------------------------


def test_a_graph_has_no_positions_for_a_ply(tmp_path):
    with pytest.raises(InvalidOptionError, match="a Graph has no positions"):
        write_distances(tmp_path / "d.ply", gt.Graph(2, [[0, 1]]), [0, 1])
    assert not (tmp_path / "d.ply").exists()


@pytest.mark.parametrize("distances", [[0.0, 1.0], [["a"] * 42], np.zeros((42, 1)), ["x"] * 42])
def test_distances_must_be_one_a_vertex(distances, sphere, tmp_path):
    with pytest.raises(InvalidOptionError, match=r"real numbers of shape \(42,\)"):
        write_distances(tmp_path / "d.npy", sphere, distances)


@pytest.mark.parametrize(("name", "says"), [("d.txt", r"cannot write \.txt"), ("d", "no suffix")])
def test_an_unknown_suffix_is_named_with_those_that_can_be_written(name, says, sphere, tmp_path):
    with pytest.raises(InvalidOptionError, match=rf"{says}; can be written: \.ply, \.npy, \.csv"):
        write_distances(tmp_path / name, sphere, np.zeros(42))


def test_a_missing_directory_is_named(tmp_path):
    with pytest.raises(WriteError, match=r"there is no directory .*nowhere"):
        check_output(tmp_path / "nowhere" / "d.ply", (".ply",))


def test_a_directory_is_no_output(tmp_path):
    (tmp_path / "d.ply").mkdir()
    with pytest.raises(WriteError, match="is a directory"):
        check_output(tmp_path / "d.ply", (".ply",))


def test_a_file_is_no_directory_to_write_into(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError, match="there is no directory"):
        check_output(tmp_path / "file" / "d.ply", (".ply",))


@pytest.mark.skipif(sys.platform == "win32", reason="there are no device files")
def test_a_device_is_not_replaced():
    with pytest.raises(WriteError, match="not a regular file"), replacing("/dev/null"):
        pytest.fail("the block was entered")


def test_a_path_that_no_system_has_is_an_error_of_ours():
    with pytest.raises(WriteError, match="no path"):
        check_output("nul\0.ply", (".ply",))


def test_missing_permissions_are_named(tmp_path, monkeypatch):
    target = tmp_path / "d.ply"
    target.write_text("old")
    # By what the system says, as tests may run with all permissions.
    monkeypatch.setattr(os, "access", lambda path, _: path != tmp_path)
    with pytest.raises(WriteError, match="no permission in"):
        check_output(target, (".ply",))
    monkeypatch.setattr(os, "access", lambda path, _: path == tmp_path)
    with pytest.raises(WriteError, match="it is read-only"):
        check_output(target, (".ply",))


def test_a_path_that_can_be_an_output_is_returned(tmp_path):
    assert check_output(str(tmp_path / "d.PLY"), (".ply",)) == tmp_path / "d.PLY"
    assert list(tmp_path.iterdir()) == []


# -- whole or not at all --------------------------------------------------------------------------


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, MemoryError, InvalidOptionError])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(interruption, tmp_path):
    target = tmp_path / "d.csv"
    target.write_text("old")

    def write():
        with replacing(target) as temporary:
            temporary.write_text("half of the new")
            raise interruption

    with pytest.raises(interruption):
        write()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_full_disk_leaves_the_old_file_and_nothing_else(sphere, tmp_path, monkeypatch):
    target = tmp_path / "d.npy"
    write_distances(target, sphere, np.zeros(42))

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", fail)
    with pytest.raises(WriteError, match=r"d\.npy cannot be written: No space left on device"):
        write_distances(target, sphere, np.ones(42))
    np.testing.assert_array_equal(np.load(target), np.zeros(42))
    assert list(tmp_path.iterdir()) == [target]


def test_a_temporary_file_that_cannot_be_made_is_an_error_of_ours(tmp_path, monkeypatch):
    def fail(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", fail)
    with pytest.raises(WriteError, match="Permission denied"), replacing(tmp_path / "d.ply"):
        pytest.fail("the block was entered")


def test_the_temporary_file_is_beside_the_target_and_has_its_suffix(tmp_path):
    with replacing(tmp_path / "d.png") as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".png"
        assert not (tmp_path / "d.png").exists()
        temporary.write_text("new")
    assert (tmp_path / "d.png").read_text() == "new"
    assert list(tmp_path.iterdir()) == [tmp_path / "d.png"]


@pytest.mark.skipif(sys.platform == "win32", reason="permissions and links are those of POSIX")
def test_permissions_and_links_stay(tmp_path):
    target, link = tmp_path / "real.csv", tmp_path / "link.csv"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert target.stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are those of POSIX")
def test_a_new_file_has_the_permissions_that_the_umask_leaves(tmp_path):
    old = os.umask(0o027)
    try:
        with replacing(tmp_path / "d.csv") as temporary:
            temporary.write_text("new")
    finally:
        os.umask(old)
    assert (tmp_path / "d.csv").stat().st_mode & 0o777 == 0o640
