"""Do pictures show what there is, without a display, and say what is wrong?"""

import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    MissingDependencyError,
    UnsupportedDomainError,
    WriteError,
)
from geodesic_toolkit.testing import shapes

pytest.importorskip("pyvista", reason="pictures need the extra viz")
pytest.importorskip("matplotlib", reason="pictures need the extra viz")

from geodesic_toolkit.viz.camera import choose_views
from geodesic_toolkit.viz.colours import (
    INK,
    MARKER,
    UNREACHED,
    choose_style,
    colour_table,
    isoline_levels,
)
from geodesic_toolkit.viz.contours import contour_lines
from geodesic_toolkit.viz.opengl import check_opengl, quiet
from geodesic_toolkit.viz.page import Page
from geodesic_toolkit.viz.scene import make_scene

SIZE = (320, 160)


@pytest.fixture(scope="module", autouse=True)
def opengl():
    try:
        with quiet():
            check_opengl()
    except MissingDependencyError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def sphere():
    return shapes.icosphere(3)


@pytest.fixture(scope="module")
def angles(sphere):
    """The distance from vertex 0, in closed form."""
    return np.arccos(np.clip(sphere.vertices @ sphere.vertices[0], -1, 1))


def bar_free(image):
    """The part of a picture where the views are."""
    return image[:, : int(0.8 * image.shape[1])].astype(int)


def count_near(image, colour, tolerance=40):
    """Count the pixels of a colour, in light or shade."""
    wanted = np.round(255 * np.array(colour))
    return int((np.abs(image.astype(int) - wanted).max(axis=-1) < tolerance).sum())


def count_grey(image):
    """Count the grey pixels: neither white nor black nor coloured."""
    low, high = image.min(axis=-1), image.max(axis=-1)
    return int(((high - low < 4) & (low > 90) & (high < 240)).sum())


def count_coloured(image):
    """Count the pixels that are neither white nor grey nor black."""
    return int((image.max(axis=-1) - image.min(axis=-1) > 30).sum())


# -- what is on the picture --------------------------------------------------------------------


@pytest.mark.slow
def test_a_picture_is_the_array_that_the_file_holds(sphere, angles, tmp_path):
    from PIL import Image

    image = gt.viz.plot(sphere, angles, path=tmp_path / "a.png", size=SIZE)
    assert image.shape == (160, 320, 3)
    assert image.dtype == np.uint8
    with Image.open(tmp_path / "a.png") as written:
        np.testing.assert_array_equal(np.asarray(written), image)
    assert [file.name for file in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.slow
def test_front_and_back_stand_side_by_side(sphere, angles):
    image = bar_free(gt.viz.plot(sphere, angles, size=SIZE, isolines=0))
    left, right = image[:, :125], image[:, 135:]
    assert count_coloured(left) > 3000
    assert count_coloured(right) > 3000
    near, far = colour_table("viridis")[[10, -10]]
    assert count_near(left, near, 60) > count_near(right, near, 60)
    assert count_near(right, far, 60) > count_near(left, far, 60)


@pytest.mark.slow
def test_the_source_is_marked_and_an_empty_list_marks_none(sphere, angles):
    marked = gt.viz.plot(sphere, angles, size=SIZE, cmap="gray")
    unmarked = gt.viz.plot(sphere, angles, size=SIZE, cmap="gray", sources=[])
    assert count_near(marked, MARKER) > 10
    assert count_near(unmarked, MARKER) == 0


def test_several_sources_of_every_kind_are_marked(sphere, angles):
    scene = make_scene(sphere, angles, sources=[0, 1, 2])
    np.testing.assert_allclose(
        scene.points[[0, 1, 2]] * scene.radius + scene.centre, sphere.vertices[:3]
    )
    np.testing.assert_allclose(scene.sources, scene.points[:3])
    inside = make_scene(sphere, angles, sources=gt.SurfacePoint(7, (0.5, 0.25, 0.25)))
    corners = inside.points[sphere.faces[7]]
    np.testing.assert_allclose(inside.sources[0], [0.5, 0.25, 0.25] @ corners)
    anywhere = make_scene(sphere, angles, sources=[[0.0, 0.0, 2.0]])
    assert anywhere.sources[0, 2] > 0.5


def test_a_field_with_a_flat_part_at_zero_marks_no_sources(sphere, angles):
    assert len(make_scene(sphere, np.maximum(angles - 2, 0)).sources) == 0


@pytest.mark.slow
def test_isolines_are_dark_lines(sphere, angles):
    plain = gt.viz.plot(sphere, angles, size=SIZE, isolines=0, cmap="spring")
    lined = gt.viz.plot(sphere, angles, size=SIZE, isolines=10, cmap="spring")
    assert count_near(bar_free(lined), INK, 90) > count_near(bar_free(plain), INK, 90) + 100


def test_isolines_have_the_value_that_they_stand_for(sphere, angles):
    scene = make_scene(sphere, angles)
    points, segments = contour_lines(scene, np.array([0.5, 1.5]))
    at = points * scene.radius + scene.centre
    value = np.arccos(np.clip(at @ sphere.vertices[0] / np.linalg.norm(at, axis=1), -1, 1))
    assert len(segments) > 20
    assert np.minimum(np.abs(value - 0.5), np.abs(value - 1.5)).max() < 0.02


@pytest.mark.slow
def test_what_is_not_reached_is_grey():
    pair = shapes.disjoint_union(shapes.icosphere(2), shapes.icosphere(2))
    moved = pair.vertices + np.repeat([[0.0, 0, 0], [3.0, 0, 0]], 162, axis=0)
    pair = gt.TriangleMesh(moved, pair.faces)
    distance = np.concatenate([np.linspace(0, 1, 162), np.full(162, np.inf)])
    partly = bar_free(gt.viz.plot(pair, distance, size=SIZE, isolines=0))
    wholly = bar_free(gt.viz.plot(pair, np.linspace(0, 1, 324), size=SIZE, isolines=0))
    assert count_grey(partly) > count_grey(wholly) + 700
    assert 500 < count_coloured(partly) < count_coloured(wholly)


@pytest.mark.slow
@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf])
def test_a_field_without_any_value_is_all_grey(sphere, nothing):
    image = gt.viz.plot(sphere, np.full(sphere.n_vertices, nothing), size=SIZE)
    assert count_grey(image) > 5000
    assert count_coloured(image) == 0


@pytest.mark.slow
def test_a_constant_field_is_drawn(sphere):
    assert count_coloured(gt.viz.plot(sphere, np.ones(sphere.n_vertices), size=SIZE)) > 5000


@pytest.mark.slow
def test_vertices_of_no_face_do_not_change_the_picture(sphere, angles):
    more = gt.TriangleMesh(np.vstack([sphere.vertices, [[50.0, 0, 0]]]), sphere.faces)
    np.testing.assert_array_equal(
        gt.viz.plot(more, np.append(angles, 9.0), size=SIZE, sources=0),
        gt.viz.plot(sphere, angles, size=SIZE, sources=0),
    )


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "shift"), [(1e-6, 0.0), (1e5, 0.0), (1.0, 2.0**22)])
def test_neither_unit_nor_origin_changes_the_picture(sphere, angles, scale, shift):
    moved = gt.TriangleMesh(scale * sphere.vertices + shift, sphere.faces)
    difference = bar_free(gt.viz.plot(moved, angles, size=SIZE)) - bar_free(
        gt.viz.plot(sphere, angles, size=SIZE)
    )
    assert np.abs(difference).mean() < 0.5


@pytest.mark.slow
def test_clouds_are_drawn_without_their_missing_points(sphere, angles):
    cloud = gt.PointCloud(np.vstack([sphere.vertices, [[np.nan] * 3]]))
    image = bar_free(gt.viz.plot(cloud, np.append(angles, np.inf), size=SIZE))
    assert count_coloured(image) > 5000
    assert count_grey(image[20:-20, 20:120]) < 300  # the outlines, no points


@pytest.mark.slow
def test_a_single_point_and_a_single_triangle_are_drawn():
    assert count_coloured(gt.viz.plot(gt.PointCloud([[1.0, 2, 3]]), [0.0], size=SIZE)) > 0
    triangle = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert count_coloured(gt.viz.plot(triangle, [0.0, 1, 1], size=SIZE)) > 1000


@pytest.mark.slow
def test_graphs_need_positions():
    graph = gt.Graph(4, [[0, 1], [1, 2], [2, 3]])
    with pytest.raises(
        UnsupportedDomainError, match="Graph has no positions to draw; pass positions="
    ):
        gt.viz.plot(graph, [0.0, 1, 2, 3], size=SIZE)
    flat = gt.viz.plot(graph, [0.0, 1, 2, 3], positions=[[0, 0], [1, 0], [1, 1], [0, 1]], size=SIZE)
    assert count_coloured(flat) > 50
    with pytest.raises(InvalidOptionError, match=r"positions must have shape \(4, 3\)"):
        gt.viz.plot(graph, [0.0, 1, 2, 3], positions=[[0, 0]], size=SIZE)


@pytest.mark.slow
def test_title_unit_and_legend_are_words_not_formulas(sphere, angles):
    plain = gt.viz.plot(sphere, angles, size=SIZE)
    titled = gt.viz.plot(sphere, angles, size=SIZE, title="cost_of $5_a", unit="mm", label="$x_")
    assert (plain != titled).any()


def test_limits_set_the_ends_of_the_colours(sphere, angles):
    dark = bar_free(gt.viz.plot(sphere, angles, size=SIZE, limits=(0, 100), isolines=0))
    low = colour_table("viridis")[4]
    assert count_near(dark, low, 60) > 5000


# -- where one looks from ----------------------------------------------------------------------


@pytest.mark.parametrize("source", [0, 17, 100, 411, 640])
def test_the_front_view_sees_the_source(sphere, source):
    scene = make_scene(sphere, sphere.vertices[:, 0], sources=source)
    front, back = choose_views(scene, ["front", "back"])
    assert front.toward @ scene.sources[0] > 0.1
    assert back.toward @ scene.sources[0] < front.toward @ scene.sources[0]


def test_front_and_back_have_the_same_side_up():
    scene = make_scene(shapes.knot(60, 8), np.zeros(480))
    front, back = choose_views(scene, ["front", "back"])
    assert front.up[1] > 0.8
    np.testing.assert_allclose(back.up[1], front.up[1])
    np.testing.assert_allclose(back.toward[[0, 2]], -front.toward[[0, 2]])


def test_a_flat_sheet_is_looked_at_squarely_however_it_lies():
    flat = shapes.grid(6)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    for rotation in (np.eye(3), turn):
        mesh = gt.TriangleMesh(flat.vertices @ rotation.T, flat.faces)
        front = choose_views(make_scene(mesh, np.arange(36.0)), ["front"])[0]
        np.testing.assert_allclose(abs(front.toward @ rotation[:, 2]), 1.0)


def test_views_are_orthonormal_and_may_be_axes_or_directions(sphere, angles):
    scene = make_scene(sphere, angles)
    views = choose_views(scene, ["front", "back", "x", "-y", "z", (1.0, 2.0, -1.0)])
    for view in views:
        frame = np.stack([view.right, view.up, view.toward])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(views[2].toward, [1, 0, 0])


def test_long_shapes_are_stacked_rather_than_shrunk():
    wide = shapes.grid(30, 4)
    scene = make_scene(wide, np.zeros(120))
    page = Page((800, 600), scene, choose_views(scene, ["front", "back"]), titled=False)
    assert page.columns == 1
    tall = gt.TriangleMesh(wide.vertices[:, [1, 0, 2]], wide.faces)
    scene = make_scene(tall, np.zeros(120))
    page = Page((800, 600), scene, choose_views(scene, ["front", "back"]), titled=False)
    assert page.columns == 2


# -- colours and levels ------------------------------------------------------------------------


def test_any_map_of_matplotlib_goes_by_its_name_or_itself():
    import matplotlib as mpl

    np.testing.assert_allclose(colour_table("brg")[[0, -1]], [[0, 0, 1], [0, 1, 0]], atol=0.01)
    np.testing.assert_allclose(colour_table(mpl.colormaps["magma"]), colour_table("magma"))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("virids", "no colour map 'virids'; did you mean 'viridis'"),
        ("Viridis", "did you mean 'viridis'"),
        ("no such thing at all", "use a name in matplotlib.colormaps"),
        (7, "cmap must be a name or a matplotlib Colormap, not 7"),
    ],
)
def test_a_wrong_colour_map_is_named_with_near_misses(sphere, angles, name, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.viz.plot(sphere, angles, cmap=name, size=SIZE)


@given(
    st.integers(1, 60),
    st.floats(-1e6, 1e6),
    st.floats(1e-3, 1e6),
)
def test_levels_increase_inside_the_range_and_are_about_as_many_as_asked(wanted, low, width):
    limits = (low, low + width)
    levels = isoline_levels(wanted, limits)
    assert (np.diff(levels) > 0).all()
    assert ((levels > limits[0]) & (levels < limits[1])).all()
    assert wanted / 3 - 1 <= len(levels) <= 1.5 * wanted + 2


def test_levels_may_be_given_and_no_lines_are_none():
    np.testing.assert_array_equal(isoline_levels([3, 1, 9.0], (0, 5)), [1, 3])
    assert len(isoline_levels(0, (0, 1))) == 0


@pytest.mark.parametrize("isolines", [-1, 2.5, "many", [0.1, np.nan], None, True])
def test_isolines_that_are_none_are_refused(isolines):
    with pytest.raises(InvalidOptionError, match="isolines"):
        isoline_levels(isolines, (0.0, 1.0))


def test_a_coarse_cloud_has_fewer_levels_but_round_ones():
    sphere = shapes.icosphere(3)
    values = np.arccos(np.clip(sphere.vertices @ sphere.vertices[0], -1, 1))
    scene = make_scene(gt.PointCloud(sphere.vertices), values)
    levels = choose_style(scene, "viridis", 20).levels
    assert 1 < len(levels) < 20
    assert np.diff(levels).min() >= 6 * scene.band
    np.testing.assert_allclose(levels / levels[0], np.round(levels / levels[0]))


# -- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": (10, 100)}, "100 to 8000 pixels"),
        ({"size": 400}, "size must be"),
        ({"views": "front"}, "views is a sequence"),
        ({"views": []}, "views is a sequence"),
        ({"views": ["front"] * 13}, "at most 12 views"),
        ({"views": ["sideways"]}, "a view is 'front'"),
        ({"views": [(0, 0, 0)]}, "a view is 'front'"),
        ({"limits": (1, 0)}, "finite and increasing"),
        ({"limits": "ab"}, "limits must be two numbers"),
        ({"limits": (0, np.inf)}, "finite and increasing"),
    ],
)
def test_options_out_of_range_are_refused(sphere, angles, options, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.viz.plot(sphere, angles, **{"size": SIZE, **options})


@pytest.mark.parametrize("distance", [[0.0], np.zeros((642, 1)), "abc", [[1.0], [2.0, 3.0]]])
def test_values_that_do_not_fit_the_domain_are_refused(sphere, distance):
    with pytest.raises(InvalidOptionError, match=r"^(the )?distance (must|cannot)"):
        gt.viz.plot(sphere, distance, size=SIZE)


def test_sources_that_name_no_place_are_refused(sphere, angles):
    with pytest.raises(InvalidSourceError, match="vertex 9999 does not exist"):
        gt.viz.plot(sphere, angles, sources=9999, size=SIZE)


def test_only_domains_are_drawn():
    with pytest.raises(UnsupportedDomainError, match="not a dict"):
        gt.viz.plot({}, [0.0])


@pytest.mark.slow
def test_a_failure_leaves_the_old_picture(sphere, angles, tmp_path):
    target = tmp_path / "old.png"
    target.write_text("old")
    with pytest.raises(InvalidOptionError):
        gt.viz.plot(sphere, angles, path=target, cmap="none such", size=SIZE)
    assert target.read_text() == "old"
    with pytest.raises(WriteError, match="directory"):
        gt.viz.plot(sphere, angles, path=tmp_path / "absent" / "new.png", size=SIZE)


# -- what is missing ---------------------------------------------------------------------------


@pytest.mark.parametrize("package", ["pyvista", "matplotlib"])
def test_a_missing_package_is_named_with_its_extra(sphere, angles, package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependencyError, match=r'geodesic-toolkit\[viz\]"') as failure:
        gt.viz.plot(sphere, angles, size=SIZE)
    assert package in str(failure.value)


def test_polyscope_is_asked_for_by_its_extra(sphere, angles, monkeypatch):
    monkeypatch.setitem(sys.modules, "polyscope", None)
    with pytest.raises(MissingDependencyError, match=r'geodesic-toolkit\[gui\]"'):
        gt.viz.polyscope(sphere, angles)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere OpenGL is part of the system")
def test_a_system_without_opengl_is_an_error_and_no_crash(sphere, angles, monkeypatch):
    # the fallback of VTK without X and EGL
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    with pytest.raises(MissingDependencyError, match="libegl1"):
        gt.viz.plot(sphere, angles, size=SIZE)


# -- in a process of its own -------------------------------------------------------------------


def run(code, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=kept | environment,
    )


def test_importing_viz_imports_none_of_the_packages_behind_it():
    code = (
        "import sys, geodesic_toolkit.viz\n"
        "heavy = {'pyvista', 'vtkmodules', 'matplotlib', 'k3d', 'polyscope', 'PIL', 'viser'}\n"
        "print(sorted(heavy & set(sys.modules)), dir(geodesic_toolkit.viz))"
    )
    answer = run(code)
    assert answer.stdout.strip() == (
        "[] ['Checkers', 'OF_PARTS', 'View', 'by_part', 'plot', 'polyscope', 'save_html', 'show', "
        "'two_sided', 'view']"
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="displays are X's there only")
@pytest.mark.parametrize("display", [{}, {"DISPLAY": ":987"}])
def test_no_display_is_needed_and_nothing_is_said_about_it(display):
    code = (
        "import geodesic_toolkit as gt\n"
        "sphere = gt.testing.shapes.icosphere(1)\n"
        "print(gt.viz.plot(sphere, sphere.vertices[:, 0], size=(200, 100)).shape)"
    )
    answer = run(code, **display)
    assert answer.stderr == ""
    assert answer.stdout.strip() == "(100, 200, 3)"


def test_polyscope_holds_what_is_reached_the_rest_and_the_sources():
    pytest.importorskip("polyscope", reason="windows need the extra gui")
    code = (
        "import numpy as np, polyscope, geodesic_toolkit as gt\n"
        "polyscope.set_allow_headless_backends(True)\n"
        "polyscope.set_verbosity(0)\n"
        "one = gt.testing.shapes.icosphere(1)\n"
        "two = gt.testing.shapes.disjoint_union(one, one)\n"
        "field = np.append(np.arange(42.0), np.full(42, np.inf))\n"
        "shape = gt.viz.polyscope(two, field, block=False)\n"
        "print(shape.n_vertices(), polyscope.get_surface_mesh('not reached').n_vertices(),\n"
        "      polyscope.get_point_cloud('sources').n_points())\n"
        "cloud = gt.viz.polyscope(gt.PointCloud(two.vertices), field, block=False)\n"
        "print(cloud.n_points())\n"
        "graph = gt.Graph(84, [[0, 1], [1, 2]])\n"
        "lines = gt.viz.polyscope(graph, field, positions=two.vertices, block=False)\n"
        "print(lines.n_nodes())"
    )
    answer = run(code)
    assert answer.stdout.split() == ["42", "42", "1", "42", "3"], answer.stderr


def test_without_a_display_polyscope_says_so():
    pytest.importorskip("polyscope", reason="windows need the extra gui")
    if sys.platform != "linux":
        pytest.skip("displays are X's there only")
    code = (
        "import geodesic_toolkit as gt\n"
        "sphere = gt.testing.shapes.icosphere(1)\n"
        "try:\n"
        "    gt.viz.polyscope(sphere, sphere.vertices[:, 0])\n"
        "except gt.errors.MissingDependencyError as error:\n"
        "    print('display' in str(error) and 'save_html' in str(error))"
    )
    answer = run(code, WAYLAND_DISPLAY="")
    assert "True" in answer.stdout.splitlines(), answer.stderr


# -- on real shapes ----------------------------------------------------------------------------


@pytest.mark.slow
def test_a_real_mesh_with_unreferenced_vertices_is_drawn(shared_data):
    trimesh = pytest.importorskip("trimesh")
    loaded = trimesh.load(shared_data("meshlab__Laurana50k.ply"), process=False)
    mesh = gt.TriangleMesh(loaded.vertices, loaded.faces)
    image = gt.viz.plot(mesh, mesh.vertices[:, 1], size=SIZE, sources=[])
    assert count_coloured(bar_free(image)) > 3000
    assert count_near(image, UNREACHED, 3) < 50


@pytest.mark.parametrize(
    ("limits", "arrows"),
    [(None, "neither"), ((-1, 0.5), "max"), ((-0.5, 1), "min"), ((-0.5, 0.5), "both")],
)
def test_the_bar_has_arrows_where_values_lie_beyond_it(limits, arrows):
    sphere = shapes.icosphere(2)
    scene = make_scene(sphere, sphere.vertices[:, 2], limits=limits)
    assert Page._beyond(SimpleNamespace(scene=scene)) == arrows


@pytest.mark.slow
def test_a_picture_can_colour_by_part(tmp_path):
    small, large = shapes.icosphere(2).vertices, shapes.icosphere(3).vertices
    aside, alone = np.array([4.0, 0, 0]), np.full((1, 3), np.nan)
    cloud = gt.PointCloud(np.concatenate([small, large + aside, alone]))
    parts = gt.viz.by_part(gt.GeodesicSolver(cloud).method.metric.components)
    assert set(parts[: len(small)]) == {1.0}
    assert set(parts[len(small) : -1]) == {0.0}
    assert np.isnan(parts[-1])
    image = gt.viz.plot(cloud, parts, path=tmp_path / "parts.png", size=SIZE, **gt.viz.OF_PARTS)
    assert (tmp_path / "parts.png").stat().st_size > 0
    assert count_coloured(bar_free(image)) > 500


def test_parts_behind_the_twentieth_share_colours_but_the_first():
    shown = gt.viz.by_part(np.repeat(np.arange(45), 2))
    assert shown[0] == 0
    assert (shown[2:] >= 1).all()
    assert shown.max() == 19
