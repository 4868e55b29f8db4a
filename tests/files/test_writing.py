"""Distances to files: whole or not at all, and read again with every digit."""

import csv
import os
import sys

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    MissingDependencyError,
    PluginLoadError,
    WriteError,
)
from geodesic_toolkit.io import check_output, replacing, write
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
    write(path, sphere, field, sources=[3, 5])
    again = gt.read(path)
    np.testing.assert_array_equal(again.vertices, sphere.vertices)
    np.testing.assert_array_equal(again.faces, sphere.faces)
    table, lines = vertex_table(path)
    np.testing.assert_array_equal(table["distance"], field)
    assert "comment geodesic distance from vertices 3 5" in lines


def test_a_ply_is_coloured_and_grey_where_nothing_reaches(sphere, field, tmp_path):
    colormaps = pytest.importorskip("matplotlib").colormaps
    write(tmp_path / "d.ply", sphere, field)
    table, _ = vertex_table(tmp_path / "d.ply")
    colours = np.column_stack([table[name] for name in ("red", "green", "blue")])
    assert colours[7].tolist() == GREY
    np.testing.assert_allclose(colours[0], 255 * np.array(colormaps["viridis"](0.0)[:3]), atol=1)
    np.testing.assert_allclose(colours[-1], 255 * np.array(colormaps["viridis"](1.0)[:3]), atol=1)


def test_a_ply_has_no_colours_without_matplotlib(sphere, field, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    write(tmp_path / "d.ply", sphere, field)
    table, _ = vertex_table(tmp_path / "d.ply")
    assert table.dtype.names == ("x", "y", "z", "distance")


@pytest.mark.parametrize("value", [0.0, np.inf])
def test_a_ply_of_a_constant_field_is_written(sphere, value, tmp_path):
    write(tmp_path / "d.ply", sphere, np.full(sphere.n_vertices, value))
    assert (vertex_table(tmp_path / "d.ply")[0]["distance"] == value).all()


def test_a_ply_holds_a_cloud_with_its_normals_and_missing_points(tmp_path):
    points = [[5403849.123456789, 1, 2], [np.nan] * 3, [0, 0, 1]]
    cloud = gt.PointCloud(points, [[0, 0, 1], [0, 0, 1], [0.6, 0.8, 0]])
    path = tmp_path / "d.ply"
    write(path, cloud, [0.0, np.inf, 2.5], sources=0)
    again = gt.read(path)
    np.testing.assert_array_equal(again.points, cloud.points)
    np.testing.assert_allclose(again.normals, cloud.normals, atol=1e-15)
    assert "comment geodesic distance from vertices 0" in vertex_table(path)[1]


def test_the_comment_of_a_ply_lists_some_of_many_sources_and_no_others(sphere, field, tmp_path):
    path = tmp_path / "d.ply"
    write(path, sphere, field, sources=np.arange(30))
    assert f"from vertices {' '.join(map(str, range(20)))} and 10 more" in vertex_table(path)[1][2]
    write(path, sphere, field, sources=[[0.5, 0.5, 0.5]])
    assert vertex_table(path)[1][2] == "comment geodesic distance"


def test_an_npy_holds_the_distances_alone(sphere, field, tmp_path):
    write(str(tmp_path / "d.NPY"), sphere, field.tolist())
    again = np.load(tmp_path / "d.NPY")
    assert again.dtype == np.float64
    np.testing.assert_array_equal(again, field)


def test_a_csv_holds_every_digit(sphere, field, tmp_path):
    write(tmp_path / "d.csv", sphere, field)
    with (tmp_path / "d.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["vertex", "x", "y", "z", "distance"]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, 0], np.arange(len(field)))
    np.testing.assert_array_equal(table[:, 1:4], sphere.vertices)
    np.testing.assert_array_equal(table[:, 4], field)


def test_a_text_file_holds_every_digit(sphere, field, tmp_path):
    write(tmp_path / "d.txt", sphere, field)
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "d.txt"), field)


@pytest.mark.parametrize(
    ("name", "intent"),
    [("d.gii", "SHAPE"), ("lh.d.shape.gii", "SHAPE"), ("lh.d.func.gii", "NONE")],
)
def test_a_gifti_holds_the_distances_alone(name, intent, sphere, field, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    write(tmp_path / name, sphere, field)
    [array] = nibabel.load(tmp_path / name).darrays
    assert nibabel.nifti1.intent_codes.niistring[array.intent] == f"NIFTI_INTENT_{intent}"
    np.testing.assert_array_equal(array.data, field.astype(np.float32))


@pytest.mark.parametrize("suffix", ["vtp", "vtk", "vtu"])
def test_paraview_gets_the_mesh_and_its_distances(suffix, sphere, field, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / f"d.{suffix}"
    write(path, sphere, field)
    shape = pyvista.read(path)
    np.testing.assert_array_equal(shape.points, sphere.vertices)
    np.testing.assert_array_equal(shape.point_data["distance"], field)
    np.testing.assert_array_equal(gt.as_domain(shape).faces, sphere.faces)
    again = gt.read(path)
    np.testing.assert_array_equal(again.vertices, sphere.vertices)
    np.testing.assert_array_equal(again.faces, sphere.faces)


def test_meshio_reads_the_grid_that_was_written(sphere, field, tmp_path):
    meshio = pytest.importorskip("meshio")
    pytest.importorskip("vtk")
    write(tmp_path / "d.vtu", sphere, field)
    mesh = meshio.read(tmp_path / "d.vtu")
    np.testing.assert_array_equal(mesh.point_data["distance"], field)
    np.testing.assert_array_equal(mesh.cells_dict["triangle"], sphere.faces)


@pytest.mark.parametrize("suffix", ["vtp", "vtk", "vtu"])
def test_paraview_gets_a_cloud_with_its_normals_and_missing_points(suffix, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    points = [[5403849.123456789, 1, 2], [np.nan] * 3, [0, 0, 1]]
    cloud = gt.PointCloud(points, [[0, 0, 1], [0, 0, 1], [0.6, 0.8, 0]])
    path = tmp_path / f"d.{suffix}"
    write(path, cloud, [0.0, np.inf, 2.5])
    shape = pyvista.read(path)
    np.testing.assert_array_equal(shape.points, cloud.points)
    np.testing.assert_array_equal(shape.point_data["distance"], [0.0, np.inf, 2.5])
    np.testing.assert_allclose(shape.point_data["Normals"], cloud.normals)
    assert shape.n_cells == 3
    np.testing.assert_array_equal(gt.read(path).points, cloud.points)


@pytest.mark.parametrize("suffix", ["ply", "vtp", "vtk", "vtu"])
def test_a_graph_has_no_place_in_a_file_of_a_shape(suffix, tmp_path):
    pytest.importorskip("vtk")
    with pytest.raises(InvalidOptionError, match=rf"no positions to write to a \.{suffix} file"):
        write(tmp_path / f"d.{suffix}", gt.Graph(2, [[0, 1]]), [0, 1])


@pytest.mark.parametrize(
    ("suffix", "module", "package"),
    [("vtp", "vtkmodules", "vtk"), ("vtu", "vtkmodules", "vtk"), ("gii", "nibabel", "nibabel")],
)
def test_a_package_that_a_format_needs_is_named_and_the_old_file_stays(
    suffix, module, package, sphere, tmp_path, monkeypatch
):
    path = tmp_path / f"d.{suffix}"
    path.write_text("old")
    for name in [name for name in sys.modules if name.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    says = rf'writing \.{suffix} files needs {package}: pip install "geodesic-toolkit\[io\]"'
    with pytest.raises(MissingDependencyError, match=says):
        write(path, sphere, np.zeros(42))
    assert path.read_text() == "old"


def test_what_vtk_cannot_write_is_an_error_with_its_words(sphere, tmp_path, capfd):
    vtk_library = pytest.importorskip("geodesic_toolkit.io.readers.vtk_library")
    pytest.importorskip("vtk")
    with pytest.raises(WriteError, match=r"d\.vtp cannot be written: .*rror"):
        vtk_library.write_vtk(tmp_path / "missing" / "d.vtp", sphere, np.zeros(42))
    assert capfd.readouterr().err == ""


def test_a_csv_of_a_graph_has_no_positions(tmp_path):
    write(tmp_path / "d.csv", gt.Graph(2, [[0, 1]]), [0, 0.1])
    assert (tmp_path / "d.csv").read_text() == "vertex,distance\n0,0.0\n1,0.1\n"


# -- writers of plugins ----------------------------------------------------------------------------


class Row(gt.Domain):
    """A kind of domain without positions: vertices in a row."""

    def __init__(self, count):
        self.count = count

    @property
    def n_vertices(self):
        return self.count


def write_row(path, domain, distances):
    path.write_text(f"{domain.count}: {distances.tolist()}")


def test_a_writer_writes_distances_on_its_kinds_of_domain_alone(sphere, register, tmp_path):
    register(gt.writers, "row.txt", gt.Writer(write_row, (Row,)))
    register(gt.writers, "row", gt.Writer(write_row, (Row,)))
    for name in ("d.row", "d.row.txt"):
        write(tmp_path / name, Row(2), [0, 1])
        assert (tmp_path / name).read_text() == "2: [0.0, 1.0]"
    write(tmp_path / "d.row.txt", gt.Graph(2, [[0, 1]]), [0, 1])  # in the format of the core
    assert (tmp_path / "d.row.txt").read_text() == "0.0\n1.0\n"
    says = r"d\.row: this format is for Row, not for a TriangleMesh; can be written: \.ply"
    with pytest.raises(InvalidOptionError, match=says):
        write(tmp_path / "d.row", sphere, np.zeros(42))
    says = (
        r"a Row has no positions to write to a \.ply file; can be written: \.row, \.row\.txt, \.gii"
    )
    with pytest.raises(InvalidOptionError, match=says):
        write(tmp_path / "d.ply", Row(2), [0, 1])


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (ValueError("of its\nown"), "d.row cannot be written: ValueError: of its own"),
        (OSError(28, "No space left on device"), "d.row cannot be written: No space left"),
    ],
)
def test_a_writer_that_fails_leaves_the_old_file_and_is_an_error_of_ours(
    error, says, register, tmp_path
):
    def write_badly(path, domain, distances):
        path.write_text("begun")
        raise error

    register(gt.writers, "row", gt.Writer(write_badly, (Row,)))
    (tmp_path / "d.row").write_text("old")
    with pytest.raises(WriteError, match=says):
        write(tmp_path / "d.row", Row(2), [0, 1])
    assert [file.read_text() for file in tmp_path.iterdir()] == ["old"]


def test_a_package_that_a_writer_needs_is_found_before_the_file_is_touched(register, tmp_path):
    register(gt.writers, "row", gt.Writer(write_row, (Row,), ("acme_formats",)))
    with pytest.raises(MissingDependencyError, match=r"writing \.row files needs acme_formats"):
        write(tmp_path / "d.row", Row(2), [0, 1])
    assert not list(tmp_path.iterdir())


def test_a_function_alone_is_not_a_writer():
    with pytest.raises(PluginLoadError, match=r"write_row.* is not a Writer"):
        gt.writers.register("row", write_row)


# -- what cannot be written -----------------------------------------------------------------------


@pytest.mark.parametrize("distances", [[0.0, 1.0], np.zeros((42, 1)), 3.0])
def test_distances_must_be_one_a_vertex(distances, sphere, tmp_path):
    with pytest.raises(InvalidOptionError, match=r"real numbers of shape \(42,\)"):
        write(tmp_path / "d.npy", sphere, distances)


@pytest.mark.parametrize(("name", "says"), [("d.dat", r"cannot write \.dat"), ("d", "no suffix")])
def test_an_unknown_suffix_is_named_with_those_that_can_be_written(name, says, sphere, tmp_path):
    with pytest.raises(InvalidOptionError, match=rf"{says}; can be written: \.ply, \.pcd, \.las"):
        write(tmp_path / name, sphere, np.zeros(42))


@pytest.mark.parametrize("suffix", ["obj", "OFF", "stl"])
def test_a_format_that_holds_no_field_is_refused_with_those_that_do(suffix, sphere, tmp_path):
    says = rf"d\.{suffix}: .* cannot hold distances; can be written: \.ply, \.pcd, \.las"
    with pytest.raises(InvalidOptionError, match=says):
        write(tmp_path / f"d.{suffix}", sphere, np.zeros(42))


@pytest.mark.parametrize("name", ["d.surf.gii", "d.label.gii"])
def test_a_gifti_whose_name_promises_something_else_is_refused(name, sphere, tmp_path):
    with pytest.raises(InvalidOptionError, match=r"call it \.shape\.gii or \.func\.gii"):
        write(tmp_path / name, sphere, np.zeros(42))


def test_a_missing_directory_is_named(tmp_path):
    with pytest.raises(WriteError, match=r"there is no directory .*missing"):
        check_output(tmp_path / "missing" / "d.ply", (".ply",))


def test_a_directory_is_not_an_output(tmp_path):
    (tmp_path / "d.ply").mkdir()
    with pytest.raises(WriteError, match="is a directory"):
        check_output(tmp_path / "d.ply", (".ply",))


def test_a_file_is_not_a_directory_to_write_into(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError, match="there is no directory"):
        check_output(tmp_path / "file" / "d.ply", (".ply",))


@pytest.mark.skipif(sys.platform == "win32", reason="there are no device files")
def test_a_device_is_not_replaced():
    with pytest.raises(WriteError, match="not a regular file"), replacing("/dev/null"):
        pytest.fail("the block was entered")


def test_a_path_that_no_system_has_is_an_error_of_ours():
    with pytest.raises(WriteError, match="not a path"):
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
    write(target, sphere, np.zeros(42))

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", fail)
    with pytest.raises(WriteError, match=r"d\.npy cannot be written: No space left on device"):
        write(target, sphere, np.ones(42))
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


def test_the_older_name_of_write_writes_the_same_and_warns_at_the_line_of_its_caller(tmp_path):
    mesh = gt.testing.shapes.icosphere(0)
    gt.write(tmp_path / "new.ply", mesh, np.arange(12.0))
    message = r"io\.write_distances is deprecated since version 0\.1; use geodesic_toolkit\.write"
    with pytest.warns(DeprecationWarning, match=message) as warned:
        gt.io.write_distances(tmp_path / "old.ply", mesh, np.arange(12.0))
    assert (tmp_path / "old.ply").read_bytes() == (tmp_path / "new.ply").read_bytes()
    assert [warning.filename for warning in warned] == [__file__]
