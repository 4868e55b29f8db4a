"""Files of the format, through ``gt.read``: those that are meshes, and those that are not."""

import pytest

import geodesic_toolkit as gt

SQUARE = """
# a square
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
t 0 1 2
t 0 2 3
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "shape.plugin-name"


def test_vertices_and_triangles_are_read(file):
    file.write_text(SQUARE)
    mesh = gt.read(file)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# nothing\n", "there are no vertices"),
        ("v 0 0 0\nn 0 0 1\n", "line 2 begins with 'n'"),
        ("v 0 0\n", "line 1 has 2 numbers after v, not three coordinates"),
        ("v 0 zero 0\n", "line 1: could not convert"),
        (SQUARE + "t 0 1 2.5\n", "line 9: invalid literal"),
        (SQUARE + "t 0 1 4\n", "refers to vertex 4"),
        ("v 0 0 0\n", "no faces"),
    ],
)
def test_a_file_that_is_not_a_mesh_is_refused_with_its_name(file, text, message):
    file.write_text(text)
    with pytest.raises(gt.errors.ReadError, match=message) as caught:
        gt.read(file)
    assert file.name in str(caught.value)


def test_a_file_that_is_not_text_is_refused(file):
    file.write_bytes(b"v \xff")
    with pytest.raises(gt.errors.ReadError, match="byte 2 is not UTF-8"):
        gt.read(file)
