"""Does the HTML picture work offline in a real browser, and the widget in notebooks?"""

import re
import sys

import numpy as np
import pytest
from browser import open_browser

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    MissingDependencyError,
    UnsupportedDomainError,
    WriteError,
)
from geodesic_toolkit.testing import shapes
from geodesic_toolkit.viz import html

pytest.importorskip("k3d", reason="HTML pictures need the extra viz")
pytest.importorskip("pyvista", reason="isolines need the extra viz")


@pytest.fixture(scope="module")
def pair():
    """Two spheres side by side, and the distance from vertex 0, which does not reach the second."""
    one = shapes.icosphere(4)
    vertices = np.vstack([one.vertices, one.vertices + np.array([2.4, 0, 0])])
    mesh = gt.TriangleMesh(vertices, np.vstack([one.faces, one.faces + one.n_vertices]))
    near = np.arccos(np.clip(one.vertices @ one.vertices[0], -1, 1))
    return mesh, np.append(near, np.full(one.n_vertices, np.inf))


@pytest.fixture(scope="module")
def page(pair, tmp_path_factory):
    path = tmp_path_factory.mktemp("html") / "pair.html"
    gt.viz.save_html(*pair, path, unit="mm", title="<b> & two")
    return path


@pytest.fixture(scope="module")
def browser(page, tmp_path_factory):
    with open_browser(tmp_path_factory.mktemp("profile")) as opened:
        opened.open(page)
        opened.wait_for("!!document.querySelector('#canvasTarget canvas')")
        yield opened


def pixels(browser, path):
    from PIL import Image

    browser.screenshot(path)
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def settled(browser, tmp_path, name):
    """A screenshot once two in a row are alike and something is drawn."""
    before = pixels(browser, tmp_path / f"{name}.png")
    for _ in range(100):
        now = pixels(browser, tmp_path / f"{name}.png")
        if (now == before).all() and coloured(now[:, :750]) > 1000:
            return now
        before = now
    raise AssertionError(f"the page stayed blank or never came to rest; {browser.complaints}")


def coloured(image):
    return int((image.max(axis=-1) - image.min(axis=-1) > 40).sum())


def grey(image):
    low, high = image.min(axis=-1), image.max(axis=-1)
    return int(((high - low < 4) & (low > 60) & (high < 245)).sum())


@pytest.mark.slow
def test_the_shape_is_drawn_with_isolines_and_grey_for_the_unreached(browser, tmp_path):
    image = settled(browser, tmp_path, "drawn")[:, :750]
    assert coloured(image) > 10_000
    assert grey(image) > 10_000
    assert int((image.max(axis=-1) < 50).sum()) > 500  # the lines


@pytest.mark.slow
def test_the_page_turns_under_the_mouse(browser, tmp_path):
    before = settled(browser, tmp_path, "before")
    browser.drag((200, 560), (420, 500))
    after = settled(browser, tmp_path, "after")
    assert (np.abs(after - before).max(axis=-1) > 40).sum() > 5000


@pytest.mark.slow
def test_the_value_under_the_pointer_is_shown(browser, tmp_path):
    image = settled(browser, tmp_path, "pointed")[60:, :750]
    where = np.argwhere(image.max(axis=-1) - image.min(axis=-1) > 60)
    y, x = (int(part) for part in np.median(where, axis=0))
    browser.mouse("mouseMoved", x, y + 60)
    browser.mouse("mouseMoved", x + 2, y + 62)
    browser.wait_for("document.getElementById('gt-value').textContent.trim() !== ''")
    number, unit = browser.evaluate("document.getElementById('gt-value').textContent").split()
    assert unit == "mm"
    assert 0 <= float(number) <= np.pi


def test_title_and_legend_are_text_on_the_page(browser):
    assert browser.evaluate("document.title") == "<b> & two"
    assert browser.evaluate("document.getElementById('gt-title').textContent") == "<b> & two"
    assert browser.evaluate("document.getElementById('gt-label').textContent") == "distance [mm]"
    assert browser.evaluate("document.getElementById('gt-none').textContent") == "not reached"


def test_the_title_is_above_the_shape_and_not_behind_it(browser):
    bottom = browser.evaluate("document.getElementById('gt-title').getBoundingClientRect().bottom")
    canvas = "document.querySelector('#canvasTarget canvas').getBoundingClientRect()"
    assert browser.evaluate(f"{canvas}.top") >= bottom
    assert browser.evaluate(f"{canvas}.bottom") == browser.evaluate("innerHeight")


@pytest.mark.slow
def test_a_browser_without_webgl_says_so_where_the_shape_would_be(browser, page, tmp_path):
    words = "document.getElementById('gt-no-webgl')"
    assert browser.evaluate(f"{words} === null")
    with open_browser(tmp_path, "--disable-3d-apis") as without:
        without.open(page)
        without.wait_for("document.readyState === 'complete'")
        assert "does not offer WebGL 2" in without.evaluate(f"{words}.textContent")
        assert "another browser" in without.evaluate(f"{words}.textContent")
        assert without.evaluate(f"{words}.checkVisibility()")


@pytest.mark.slow
def test_nothing_is_asked_of_the_network_and_nothing_complained(browser, page, tmp_path):
    settled(browser, tmp_path, "quiet")
    outside = [url for url in browser.requests if not re.match(r"(data|blob):", url)]
    assert outside == [page.as_uri()]
    assert browser.complaints == []


def test_the_file_refers_to_no_other(page):
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert not re.search(r"<(script|link|img|iframe)[^>]*\b(src|href)\s*=", text)
    assert not re.search(r"[$](title|css|legend|viewer|scene|script)\b", text)


def test_the_widget_has_the_shape_the_rest_the_lines_and_the_sources(pair):
    widget = gt.viz.show(*pair, cmap="brg", label="d", height=300)
    assert [item.name for item in widget.objects] == ["d", "not reached", "isolines", "sources"]
    assert widget.height == 300
    assert widget.objects[0].vertices.shape == (2562, 3)
    np.testing.assert_allclose(widget.objects[0].color_range, [0, np.pi], rtol=1e-6)


def test_clouds_and_graphs_with_positions_are_shown_too():
    sphere = shapes.icosphere(2)
    values = sphere.vertices[:, 2]
    cloud = gt.viz.show(gt.PointCloud(sphere.vertices), values, sources=[0, 3])
    assert [item.name for item in cloud.objects] == ["distance", "sources"]
    assert len(cloud.objects[0].colors) == 162
    graph = gt.Graph(162, sphere.faces[:, :2])
    network = gt.viz.show(graph, values, positions=sphere.vertices, sources=[])
    assert [item.name for item in network.objects] == ["distance", "edges"]
    with pytest.raises(UnsupportedDomainError, match="positions"):
        gt.viz.show(graph, values)


def test_a_field_without_any_value_is_a_page_without_a_bar(pair, tmp_path):
    mesh, _ = pair
    gt.viz.save_html(mesh, np.full(mesh.n_vertices, np.nan), tmp_path / "none.html")
    text = (tmp_path / "none.html").read_text(encoding="utf-8")
    assert 'id="gt-bar"' not in text
    assert 'id="gt-none"' in text


def test_a_failure_leaves_the_old_file(pair, tmp_path):
    target = tmp_path / "old.html"
    target.write_text("old")
    with pytest.raises(InvalidOptionError, match="did you mean"):
        gt.viz.save_html(*pair, target, cmap="plasme")
    assert target.read_text() == "old"
    with pytest.raises(WriteError, match="directory"):
        gt.viz.save_html(*pair, tmp_path / "absent" / "new.html")


def test_a_missing_k3d_is_named_with_its_extra(pair, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "k3d", None)
    with pytest.raises(MissingDependencyError, match=r'k3d.*geodesic-toolkit\[viz\]"'):
        gt.viz.save_html(*pair, tmp_path / "a.html")
    with pytest.raises(MissingDependencyError, match="k3d"):
        gt.viz.show(*pair)


@pytest.mark.parametrize(
    ("constant", "value"), [("VIEWER", "static/other.js"), ("ENTRY", "CreateSomethingElse")]
)
def test_a_k3d_without_the_viewer_is_an_error_and_not_a_blank_file(
    pair, monkeypatch, tmp_path, constant, value
):
    monkeypatch.setattr(html, constant, value)
    with pytest.raises(MissingDependencyError, match="no viewer for HTML pages"):
        gt.viz.save_html(*pair, tmp_path / "a.html")
    assert not (tmp_path / "a.html").exists()
