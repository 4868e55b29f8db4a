"""Labels, annotations and GIFTI: vertices of neuroimaging as masks and as sources."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit.io import read_mask, read_vertices

nibabel = pytest.importorskip("nibabel")


def masked(path, n, region=None):
    return np.flatnonzero(read_mask(path, n, region=region)).tolist()


@pytest.fixture
def annotation(tmp_path):
    """Six vertices: two of V1, one of V2, two of the wall, one of none."""
    path = tmp_path / "lh.atlas.annot"
    colours = np.array([[25, 5, 25, 0], [9, 120, 30, 0], [70, 20, 170, 0], [1, 2, 3, 0]])
    nibabel.freesurfer.write_annot(
        str(path), np.array([1, 1, 2, 0, 0, -1]), colours, ["wall", "V1", "V2", "empty"]
    )
    return path


def gifti(path, data, *, names=None):
    image = nibabel.gifti.GiftiImage()
    intent = "NIFTI_INTENT_SHAPE"
    if names is not None:
        intent = "NIFTI_INTENT_LABEL"
        for key, name in names.items():
            label = nibabel.gifti.GiftiLabel(key)
            label.label = name
            image.labeltable.labels.append(label)
    for column in data:
        image.add_gifti_data_array(nibabel.gifti.GiftiDataArray(column, intent=intent))
    nibabel.save(image, path)
    return path


def test_a_label_lists_vertices(tmp_path):
    path = tmp_path / "lh.V1.label"
    for rows, vertices in [
        ("3\n5 0 0 0 0\n1 0 0 0 0\n2 0 0 0 0\n", [5, 1, 2]),
        ("1\n4 0 0 0 0\n", [4]),
    ]:
        path.write_text("#!ascii label  , from subject bert\n" + rows)
        assert read_vertices(path).tolist() == vertices
        assert masked(path, 6) == sorted(vertices)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("#!ascii label\n2\n5 0 0 0 0\n", "announces 2 vertices, but 1 follow"),
        ("#!ascii label\n0\n", "announces 0 vertices, but 0 follow"),
        ("nothing of that", "lh.V1.label: damaged, or not a .label file"),
    ],
)
def test_a_damaged_label_is_refused_by_name(text, says, tmp_path):
    path = tmp_path / "lh.V1.label"
    path.write_text(text)
    for read in (read_vertices, lambda path: read_mask(path, 6)):
        with pytest.raises(ReadError, match=says):
            read(path)


def test_a_label_of_another_surface_is_refused(tmp_path):
    path = tmp_path / "lh.V1.label"
    path.write_text("#!ascii label\n1\n6 0 0 0 0\n")
    with pytest.raises(InvalidOptionError, match="there is no vertex 6: they are 0 to 5"):
        read_mask(path, 6)


def test_a_region_of_an_annotation_is_a_mask_and_a_source(annotation):
    assert read_vertices(annotation, region="V1").tolist() == [0, 1]
    assert masked(annotation, 6, "wall") == [3, 4]


def test_a_region_of_a_gifti_label_file_is_a_mask_and_a_source(tmp_path):
    labels = np.array([0, 3, 3, 7, 0, 0], dtype=np.int32)
    path = gifti(tmp_path / "lh.label.gii", [labels], names={0: "???", 3: "V1", 7: "V2"})
    assert read_vertices(path, region="V1").tolist() == [1, 2]
    assert masked(path, 6, "V2") == [3]


def test_zeros_and_ones_of_a_gifti_are_a_mask_and_a_source(tmp_path):
    path = gifti(tmp_path / "roi.shape.gii", [np.array([0, 1, 0, 0, 1, 0], dtype=np.float32)])
    assert read_vertices(path).tolist() == [1, 4]
    assert masked(path, 6) == [1, 4]


def test_regions_are_asked_for_by_name(annotation, tmp_path):
    for region, says in [
        (None, "lh.atlas.annot holds 4 regions; choose a region: wall, V1, V2, empty"),
        ("V9", "lh.atlas.annot has no region 'V9'; it has wall, V1, V2, empty"),
    ]:
        with pytest.raises(InvalidOptionError, match=says):
            read_vertices(annotation, region=region)
    with pytest.raises(ReadError, match="the region 'empty' has no vertices"):
        read_vertices(annotation, region="empty")
    with pytest.raises(InvalidOptionError, match="6 regions, but the shape has 7 vertices"):
        read_mask(annotation, 7, region="V1")
    table = tmp_path / "v.txt"
    table.write_text("1 2")
    for read in (read_vertices, lambda path, region: read_mask(path, 6, region=region)):
        with pytest.raises(InvalidOptionError, match="has no regions: omit region='V1'"):
            read(table, region="V1")


def test_a_gifti_that_marks_no_vertices_is_refused(tmp_path):
    path = gifti(tmp_path / "d.shape.gii", [np.array([0, 0.5], dtype=np.float32)])
    with pytest.raises(ReadError, match="numbers must be 0 and 1"):
        read_vertices(path)
    path = gifti(tmp_path / "d.shape.gii", [np.zeros(2, dtype=np.float32)] * 2)
    with pytest.raises(ReadError, match="one number per vertex is needed"):
        read_mask(path, 2)


def test_a_region_is_a_source(annotation):
    path = gt.Graph(6, [[k, k + 1] for k in range(5)])
    distance = gt.geodesic_distance(path, read_vertices(annotation, region="V2"))
    assert distance[2] == 0
