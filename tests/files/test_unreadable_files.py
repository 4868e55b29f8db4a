"""Files that are not what they say, and readers that fail, are errors that name the file."""

import random
import sys
from functools import partial

import numpy as np
import pytest
from sample_files import (
    FACES,
    LISTS,
    POINTS,
    SAMPLES,
    SQUARE,
    TRIANGLE,
    WRITTEN,
    XYZ,
    npz_of,
    off,
    pcd_header,
    place,
    ply_header,
    stl,
)

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    MissingDependencyError,
    NotEnoughMemoryError,
    PluginLoadError,
    ReadError,
)

# -- what cannot be read --------------------------------------------------------------------------


def test_a_missing_file_does_not_exist(tmp_path):
    with pytest.raises(ReadError, match=r"none\.off does not exist"):
        gt.read(tmp_path / "none.off")


def test_a_directory_is_not_a_file(tmp_path):
    (tmp_path / "folder.off").mkdir()
    with pytest.raises(ReadError, match="is a directory"):
        gt.read(tmp_path / "folder.off")


@pytest.mark.skipif(sys.platform == "win32", reason="there are no device files")
def test_a_device_is_not_a_file():
    with pytest.raises(ReadError, match="not a regular file"):
        gt.read("/dev/zero")


def test_a_path_that_no_system_has_is_an_error_of_ours():
    with pytest.raises(ReadError, match=r"cannot be opened|does not exist"):
        gt.read("nul\0.off")


def test_a_file_that_may_not_be_opened_is_an_error_of_ours(tmp_path, monkeypatch):
    path = place(tmp_path, "t.off", off())

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", refuse)
    with pytest.raises(ReadError, match="Permission denied"):
        gt.read(path)


def test_an_unknown_suffix_is_named_with_those_that_can_be_read(tmp_path):
    with pytest.raises(ReadError, match=r"no reader for \.fbx; can be read: .*obj, off"):
        gt.read(place(tmp_path, "model.fbx", b"x"))
    with pytest.raises(ReadError, match="it has no suffix"):
        gt.read(place(tmp_path, "model", b"x"))


ALL_SUFFIXES = sorted({*SAMPLES, *(name.split()[0] for name in WRITTEN), "edgelist"})
PACKAGE_OF = {name.split()[0]: package for name, (package, _) in WRITTEN.items() if " " not in name}
GARBAGE = {
    "empty": b"",
    "blank": b"\n \n",
    "words": b"this is not a shape, it is a sentence\n",
    "zeros": b"\0" * 400,
    "noise": random.Random(1).randbytes(3000),
    "picture": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + b"\7" * 100,
}


@pytest.mark.parametrize("suffix", ALL_SUFFIXES)
@pytest.mark.parametrize("contents", GARBAGE)
def test_garbage_is_refused_in_one_line_that_names_the_file(suffix, contents, tmp_path):
    if suffix in PACKAGE_OF:
        pytest.importorskip(PACKAGE_OF[suffix])
    path = place(tmp_path, f"garbage.{suffix}", GARBAGE[contents])
    with pytest.raises(ReadError) as caught:
        gt.read(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < len(str(path)) + 400


@pytest.mark.parametrize(
    "suffix", sorted(set(SAMPLES) - {"obj", "xyz", "txt", "asc", "edges", "pts"})
)
@pytest.mark.parametrize("other", ["off", "obj", "ply", "stl"])
def test_a_file_of_another_format_is_refused(suffix, other, tmp_path):
    if suffix == other:
        pytest.skip("this is the right one")
    with pytest.raises(ReadError):
        gt.read(place(tmp_path, f"wrong.{suffix}", SAMPLES[other][0]()))


BAD = {
    "face-index.off": (
        "OFF\n3 1 0\n" + TRIANGLE + "3 0 1 3\n",
        "face 0 refers to vertex 3; there are 3",
    ),
    "nan.off": ("OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 is not finite"),
    "word.off": ("OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", "must be numbers .found 'x'"),
    "huge.off": ("OFF\n3 1 0\n" + TRIANGLE + f"3 0 1 {'9' * 30}\n", "must be integers .found '999"),
    "announced.off": ("OFF\n-3 1 0\n" + TRIANGLE, "-3 vertices and 1 faces are announced"),
    "four.off": ("4OFF\n3 1 0\n" + TRIANGLE, "four or more dimensions or in binary"),
    "short.off": (
        "OFF\n3 9 0\n" + TRIANGLE + "3 0 1 2\n",
        "the file ends within its 3 vertices and 9",
    ),
    "faces.off": ("OFF\n3 1 0\n" + TRIANGLE + "4 0 1 2\n", "face 0 is not a number of corners"),
    "scraps.off": ("OFF\n3 5 0\n" + TRIANGLE + "3 0 1 2 9\n", "ends within its 5 faces"),
    "zero.obj": (SQUARE + "f 0 1 2\n", "face 0 refers to vertex 0; there are 4, numbered from 1"),
    "past.obj": (SQUARE + "f 1 2 5\n", "face 0 refers to vertex 5"),
    "before.obj": (SQUARE + "f 1 2 3\nf -5 1 2\n", "face 1 refers to vertex -5"),
    "flat.obj": ("v 0 0\n", "vertex 0 has 2 coordinates"),
    "corner.obj": (SQUARE + "f 1 a 3\n", "corners of faces must be integers .found 'a'"),
    "columns.xyz": ("0 0 0\n1 1\n", "not a table of numbers"),
    "flat.xyz": ("0 0\n1 1\n", "at least three columns, not 2"),
    "first.pts": ("many\n0 0 0\n", "first line, 'many', names 1 columns, but there are 3"),
    "short.pts": ("3\n0 0 0\n1 1 1\n", "3 points are announced, but 2"),
    "columns.edges": ("0 1 2 3\n", "columns, i j .length., not 4"),
    "half.edges": ("0 1.5\n", "vertex numbers must be whole numbers .found 1.5"),
    "negative.edges": ("0 -1\n", "edge 0 refers to vertex -1"),
    "identifiers.edges": ("0 123456789012\n", "numbered from 0 without large gaps"),
    "length.edges": ("0 1 -2\n", "edge 0 has length -2.0"),
    "cut.stl": (stl()[:-1], "truncated one: 8 faces need 484 bytes, but there are 483"),
    "text.stl": (
        "solid x\nfacet normal 0 0 0\nvertex 0 0 0\n",
        "truncated or damaged: 0 facets with 1",
    ),
    "none.stl": (bytes(84), "the mesh has no vertices"),
    "header.ply": (
        "ply\nformat ascii 1.0\nelement vertex 3\n",
        "the PLY header has no end_header",
    ),
    "format.ply": ("ply\nformat morse 1.0\nend_header\n", "unknown format of PLY file: 'morse'"),
    "type.ply": (ply_header("ascii", ("vertex 1", ["quad x"])), "type in the PLY header: 'quad'"),
    "count.ply": (ply_header("ascii", ("vertex -1", XYZ)), "the number of elements vertex is '-1'"),
    "line.ply": (
        b"ply\nformat ascii 1.0\nwho knows\nend_header\n",
        "unrecognised line in the header",
    ),
    "list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["list float int vertex_indices"])),
        "the type float cannot count",
    ),
    "flat.ply": (
        ply_header("ascii", ("vertex 1", XYZ[:2])) + b"0 0\n",
        "no element vertex with prop",
    ),
    "few.ply": (
        ply_header("ascii", ("vertex 2", XYZ)) + b"0 0 0\n",
        "ends before the last of its 2 elements vertex",
    ),
    "few-binary.ply": (
        ply_header("binary_big_endian", ("vertex 2", XYZ)) + bytes(24),
        "ends before the last of its 2 elements vertex",
    ),
    "no-list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["int colour"])) + b"0 0 0\n1\n",
        "element face has no list vertex_indices",
    ),
    "half.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["list uchar float vertex_indices"]))
        + b"0 0 0\n3 0 0.5 0\n",
        "vertex indices of face must be whole numbers .found 0.5",
    ),
    "negative.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", LISTS)) + b"0 0 0\n-3 0 0 0\n",
        "a list vertex_indices of face has b'-3' entries",
    ),
    "negative-binary.ply": (
        ply_header(
            "binary_little_endian", ("vertex 1", XYZ), ("face 1", ["list char int vertex_indices"])
        )
        + bytes(24)
        + b"\xff" * 9,
        "a list vertex_indices of face has -1 entries",
    ),
    "long-list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", LISTS)) + b"0 0 0\n3 0 0\n",
        "ends before the last of its 1 elements face",
    ),
    "long-list-binary.ply": (
        ply_header("binary_little_endian", ("vertex 1", XYZ), ("face 1", LISTS))
        + bytes(24)
        + b"\x03" * 8,
        "ends before the last of its 1 elements face",
    ),
    "few-lists.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 2", LISTS)) + b"0 0 0\n3 0 0 0\n",
        "ends before the last of its 2 elements face",
    ),
    "header.pcd": ("FIELDS x y z\n", "its header has no DATA line"),
    "form.pcd": (pcd_header("morse"), "unknown form of PCD data: 'morse'"),
    "points.pcd": (pcd_header("ascii").replace(b"POINTS 6", b"POINTS six"), "valid number"),
    "none.pcd": (pcd_header("ascii").replace(b"POINTS 6", b"POINTS 0"), "announces 0 points"),
    "fields.pcd": (
        pcd_header("ascii").replace(b"FIELDS x y z", b"FIELDS x y"),
        "do not match",
    ),
    "names.pcd": (
        pcd_header("ascii").replace(b"FIELDS x y z", b"FIELDS a b c") + b"0 0 0\n" * 6,
        "the fields are a b c, without x, y and z",
    ),
    "type.pcd": (pcd_header("ascii", sizes="8 8 3"), "field 'z' has type 'F' of size '3'"),
    "counts.pcd": (pcd_header("ascii").replace(b"COUNT 1 1 1", b"COUNT 1 1 x"), "count 'x'"),
    "few.pcd": (pcd_header("ascii") + b"0 0 0\n", "ends before the last of its 6 points"),
    "few-binary.pcd": (pcd_header("binary") + bytes(100), "ends before the last of its 6 points"),
    "few-packed.pcd": (
        pcd_header("binary_compressed") + b"\xff\0\0\0\x90\0\0\0",
        "last of its compressed points",
    ),
    "size.pcd": (pcd_header("binary_compressed") + bytes(8), "announce 0 bytes"),
    "back.pcd": (
        pcd_header("binary_compressed") + b"\2\0\0\0\x90\0\0\0\x20\0",
        "before their start",
    ),
    "within.pcd": (
        pcd_header("binary_compressed") + b"\1\0\0\0\x90\0\0\0\x20",
        "within a repetition",
    ),
    "less.pcd": (pcd_header("binary_compressed") + b"\2\0\0\0\x90\0\0\0\0\0", "1 bytes, not 144"),
    "other.npz": (npz_of(a=POINTS, b=FACES), "the archive holds a, b, but not a sparse matrix"),
    "pickle.npz": (npz_of(vertices=np.array([None]), faces=FACES), "ValueError"),
    "complex.npz": (npz_of(points=POINTS * 1j), "must hold real numbers"),
    "index.npz": (
        npz_of(
            format=np.array(b"csr"),
            shape=np.array([2, 2]),
            data=np.ones(1),
            indices=np.array([7], dtype=np.int32),
            indptr=np.array([0, 1, 1], dtype=np.int32),
        ),
        "ValueError",
    ),
    "strange.npz": (
        npz_of(format=np.array(b"coo"), shape=[2, 2], data=[1j], row=[0], col=[1]),
        "edge lengths must be real numbers, not complex128",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_in_a_file_is_said(name, tmp_path):
    contents, says = BAD[name]
    with pytest.raises(ReadError, match=says) as caught:
        gt.read(place(tmp_path, name, contents))
    assert str(caught.value).startswith(str(tmp_path / name))


@pytest.mark.parametrize("text", ['{"asset": ', "[1]", "[" * 100_000])
def test_a_damaged_gltf_is_not_replaced_by_a_model_beside_it(text, tmp_path):
    place(tmp_path, "model.gltf", WRITTEN["gltf"][1](tmp_path))
    with pytest.raises(ReadError, match="not a glTF file"):
        gt.read(place(tmp_path, "other.gltf", text))


def test_a_gltf_without_shapes_is_refused(tmp_path):
    text = '{"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0}'
    with pytest.raises(ReadError):
        gt.read(place(tmp_path, "empty.gltf", text))


def test_an_array_alone_is_not_an_archive(tmp_path):
    np.save(tmp_path / "a.npy", POINTS)
    with pytest.raises(ReadError):
        gt.read((tmp_path / "a.npy").rename(tmp_path / "a.npz"))


def test_a_gifti_without_a_surface_is_refused(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    data = nibabel.gifti.GiftiDataArray(np.zeros(3, dtype="f4"), intent="NIFTI_INTENT_SHAPE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[data]), tmp_path / "thickness.gii")
    with pytest.raises(ReadError, match="holds no surface"):
        gt.read(tmp_path / "thickness.gii")


@pytest.mark.parametrize(
    ("at", "value", "says"),
    [
        (100, b"\xff\xff\xff\xff", "announces 4294967295 records"),
        (107, b"\xff\xff\xff\x0f", "ends before the last of its 268435455 points"),
    ],
)
def test_a_las_header_that_announces_too_much_is_refused(at, value, says, tmp_path):
    pytest.importorskip("laspy")
    data = bytearray(WRITTEN["las"][1](tmp_path))
    data[at : at + 4] = value
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "scan.las", bytes(data)))


@pytest.mark.parametrize(
    ("value", "says"), [(b"\xff\xff\xff\xff", "chunks is broken"), (None, "chunks is invalid")]
)
def test_a_laz_table_that_would_end_the_process_is_refused(value, says, tmp_path):
    pytest.importorskip("lazrs")
    data = bytearray(WRITTEN["laz"][1](tmp_path))
    start = int.from_bytes(data[96:100], "little")
    place_of_table = int.from_bytes(data[start : start + 8], "little")
    if value is None:
        data[start : start + 8] = b"\xfe" + b"\xff" * 7
    else:
        data[place_of_table + 4 : place_of_table + 8] = value
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "scan.laz", bytes(data)))


def test_a_panic_of_the_laz_decompressor_is_an_error_of_ours(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    data = WRITTEN["las"][1](tmp_path)

    class PanicException(BaseException):
        """The exception that lazrs raises."""

    def panic(*_, **__):
        raise PanicException("mid > len")

    monkeypatch.setattr(laspy, "open", panic)
    with pytest.raises(ReadError, match=r"compressed points are damaged \(mid > len"):
        gt.read(place(tmp_path, "scan.las", data))


def test_a_missing_laz_decompressor_is_named(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    pytest.importorskip("lazrs")
    data = WRITTEN["laz"][1](tmp_path)
    monkeypatch.setattr(laspy.LazBackend, "is_available", lambda _: False)
    with pytest.raises(MissingDependencyError, match="needs lazrs"):
        gt.read(place(tmp_path, "scan.laz", data))


@pytest.mark.parametrize(
    ("suffix", "module"),
    [
        ("msh", "meshio"),
        ("vtu", "meshio"),
        ("mesh", "meshio"),
        ("gii", "nibabel"),
        ("las", "laspy"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(suffix, module, tmp_path, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    says = rf'\.{suffix} files needs {module}: pip install "geodesic-toolkit\[io\]"'
    with pytest.raises(MissingDependencyError, match=says):
        gt.read(place(tmp_path, f"x.{suffix}", b"x"))


# -- plugins --------------------------------------------------------------------------------------


@pytest.fixture
def reader(register):
    """Registers a reader of .shape files, which the test gives."""
    return partial(register, gt.readers, "shape")


def test_a_reader_may_be_registered(reader, tmp_path):
    reader(lambda path: gt.Graph(int(path.read_text()), [[0, 1]]))
    assert gt.read(place(tmp_path, "x.shape", b"4")).n_vertices == 4


@pytest.mark.parametrize(
    ("failure", "error"),
    [
        (RuntimeError("two\nlines"), ReadError),
        (RuntimeError("long " * 1000), ReadError),
        (MemoryError(), NotEnoughMemoryError),
        (PluginLoadError("as it is"), PluginLoadError),
    ],
)
def test_what_a_reader_raises_becomes_an_error_of_ours(failure, error, reader, tmp_path):
    def fail(path):
        raise failure

    reader(fail)
    with pytest.raises(error) as caught:
        gt.read(place(tmp_path, "x.shape", b"4"))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_a_reader_that_returns_no_domain_is_at_fault(reader, tmp_path):
    reader(lambda path: 3)
    with pytest.raises(ReadError, match="returned int, not a domain"):
        gt.read(place(tmp_path, "x.shape", b"4"))
