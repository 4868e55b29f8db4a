"""Pictures of log maps, of vectors and of signed distances."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError
from geodesic_toolkit.testing import shapes

pytest.importorskip("pyvista", reason="pictures need the extra viz")
pytest.importorskip("matplotlib", reason="pictures need the extra viz")

from geodesic_toolkit.viz.colours import CURVE, colour_table
from geodesic_toolkit.viz.contours import contour_lines
from geodesic_toolkit.viz.opengl import check_opengl, quiet
from geodesic_toolkit.viz.scene import make_scene

SQUARE = shapes.grid(9)
CENTRED = SQUARE.vertices[:, :2] - 0.5
RADII = np.hypot(*CENTRED.T)
LOOK = {"views": ["z"], "sources": [], "isolines": 0, "size": (260, 220)}


@pytest.fixture(scope="module", autouse=True)
def opengl():
    try:
        with quiet():
            check_opengl()
    except MissingDependencyError as error:
        pytest.skip(str(error))


def changed(one, other):
    return (np.abs(one.astype(int) - other.astype(int)).max(axis=-1) > 20).mean()


def test_checkers_lighten_every_second_cell():
    table, limits = colour_table("viridis"), (0.0, 1.0)
    texture = gt.viz.Checkers(CENTRED, size=0.25, sectors=0).texture(table, limits).astype(int)

    def at(x, y):
        """The colour at a place, of which row 0 is the top."""
        row, column = (1024 * (1 + part / RADII.max()) for part in (-y, x))
        return texture[int(row), int(column)]

    assert at(0.1, -0.1).sum() > at(0.1, 0.1).sum() + 100
    np.testing.assert_allclose(at(0.1, 0.1), at(-0.1, -0.1), atol=2)
    polar = gt.viz.Checkers(CENTRED, size=0.25, sectors=4).texture(table, limits).astype(int)
    assert polar.shape == texture.shape


def test_a_picture_shows_checkers_on_a_mesh_and_on_a_cloud():
    checkers = gt.viz.Checkers(CENTRED, size=0.25, sectors=0)
    plain = gt.viz.plot(SQUARE, RADII, **LOOK)
    patterned = gt.viz.plot(SQUARE, RADII, checkers=checkers, **LOOK)
    assert 0.1 < changed(plain, patterned) < 0.5  # half of the square
    cloud = gt.PointCloud(SQUARE.vertices)
    scene = make_scene(cloud, RADII, checkers=checkers)
    assert scene.checkers.shares().min() < 1


def test_faces_across_a_jump_of_the_map_have_no_pattern():
    torn = CENTRED + np.where(CENTRED[:, :1] > 0.3, 5.0, 0.0)
    covered = gt.viz.Checkers(torn, size=0.25).patterned(SQUARE.vertices, SQUARE.faces)
    beyond = SQUARE.vertices[SQUARE.faces, 0] > 0.8
    across = beyond.any(axis=1) & ~beyond.all(axis=1)
    np.testing.assert_array_equal(covered, ~across)
    coarse = gt.viz.Checkers(CENTRED, size=0.01).patterned(SQUARE.vertices, SQUARE.faces)
    assert coarse.all()  # cells smaller than faces are not a jump


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gt.viz.Checkers("a"), "cannot be read"),
        (lambda: gt.viz.Checkers(np.zeros((3, 3))), r"shape \(N, 2\)"),
        (lambda: gt.viz.Checkers(np.zeros((3, 2))), "not 0 at one vertex"),
        (lambda: gt.viz.Checkers(CENTRED, size=-1), "size must be positive"),
        (lambda: gt.viz.Checkers(CENTRED, sectors=5), "even number"),
        (lambda: make_scene(SQUARE, RADII, checkers=gt.viz.Checkers(CENTRED[:3])), "do not fit"),
        (lambda: make_scene(SQUARE, RADII, checkers="polar"), "must be gt.viz.Checkers"),
        (lambda: make_scene(SQUARE, RADII, arrows=np.zeros((3, 3))), "one vector per vertex"),
        (lambda: make_scene(SQUARE, RADII, arrows="up"), "arrows must hold real numbers"),
        (lambda: gt.viz.two_sided("a"), "must hold real numbers"),
    ],
)
def test_wrong_patterns_and_arrows_are_refused(make, words):
    with pytest.raises(InvalidOptionError, match=words):
        make()


def test_arrows_are_spread_and_to_scale():
    mesh = shapes.grid(41)
    vectors = np.zeros_like(mesh.vertices)
    vectors[:, 0] = 1 + mesh.vertices[:, 0]
    vectors[0] = np.nan
    places, shown = make_scene(mesh, mesh.vertices[:, 0], arrows=vectors).arrows
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(places), 1)]
    assert 50 < len(places) < 400
    assert gaps.min() > 0.1
    assert shown[:, 0].max() < 2.01 * shown[:, 0].min()
    nothing, _ = make_scene(mesh, mesh.vertices[:, 0], arrows=np.zeros_like(vectors)).arrows
    assert len(nothing) == 0


def test_a_picture_shows_arrows():
    arrows = np.tile([1.0, 0.0, 0.0], (SQUARE.n_vertices, 1))
    image = gt.viz.plot(SQUARE, RADII, arrows=arrows, **LOOK).astype(int)
    near = np.abs(image - np.round(255 * np.array(CURVE))).max(axis=-1) < 60
    assert near.sum() > 100


def test_sides_differ_at_zero_and_have_the_same_scale():
    options = gt.viz.two_sided([-1.0, 3.0, np.nan, np.inf])
    assert options["limits"] == (-3.0, 3.0)
    assert options["sources"] == []
    red, blue = colour_table(options["cmap"])[[127, 128]]
    assert red[0] > red[2] + 0.05
    assert blue[2] > blue[0] + 0.05
    assert gt.viz.two_sided([0.0])["limits"] == (-1.0, 1.0)


def test_isolines_that_would_blacken_a_face_are_omitted():
    values = np.where(SQUARE.vertices[:, 0] > 0.55, 100.0, 0.0) + SQUARE.vertices[:, 0]
    scene = make_scene(SQUARE, values)
    points, _ = contour_lines(scene, np.linspace(0, 101, 500))
    x = (points * scene.radius + scene.centre)[:, 0]
    assert len(x)
    assert not ((x > 0.51) & (x < 0.61)).any()
