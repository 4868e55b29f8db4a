"""Does the page work in a real browser, on this computer alone?"""

import json
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from browser import open_browser
from command_line import fails, run

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    CoarseMeshWarning,
    InvalidOptionError,
    MissingDependencyError,
    SeamWarning,
)
from geodesic_toolkit.testing import shapes

pytest.importorskip("viser", reason="pages to click need the extra view")
pytest.importorskip("matplotlib", reason="pages to click need the extra view")

import viser
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

from geodesic_toolkit.viz.live.controls import MODES
from geodesic_toolkit.viz.live.session import Mode

YELLOW = "#fab005"  # as viser's client has it
AT_THE_ANTIPODE = 0.04  # an edge: linear in a face, a distance is cut off at the farthest point


@pytest.fixture(scope="module")
def sphere():
    return shapes.icosphere(5)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with open_browser(tmp_path_factory.mktemp("profile"), offline=False) as opened:
        yield opened


@pytest.fixture
def open_page(browser):
    """A function that opens the page of a view, and waits until its shape is drawn."""

    def open_page(view, drawn="window.gtSurface && window.gtSurface.updates > 0"):
        browser.requests.clear()
        browser.complaints.clear()
        browser.visit(view.url)
        browser.wait_for(drawn)
        return browser

    yield open_page
    browser.visit("about:blank")


@pytest.fixture
def view(sphere):
    with gt.viz.view(sphere, browser=False, block=False, name="ball", unit="mm") as opened:
        yield opened


def middle(page):
    """The middle of the canvas, where the camera looks."""
    box = "document.querySelector('canvas').getBoundingClientRect()"
    return tuple(
        page.evaluate(f"{box}.{a} + {box}.{b} / 2")
        for a, b in (("left", "width"), ("top", "height"))
    )


def on_page(view, page, point):
    """The place of a point of the scene on the page, in pixels."""
    (client,) = view._server.get_clients().values()
    camera = client.camera
    turned = viser.transforms.SO3(camera.wxyz).as_matrix().T @ (point - camera.position)
    scale = camera.image_height / 2 / np.tan(camera.fov / 2) / turned[2]
    x, y = middle(page)
    return x + scale * turned[0], y + scale * turned[1]


CAMERA = "window.__viserMutable.camera.position.toArray()"


def look_from_behind(view, page):
    """Bring the camera to the other side of the shape."""
    before = np.array(page.evaluate(CAMERA))
    (client,) = view._server.get_clients().values()
    client.camera.position = -np.array(client.camera.position)
    client.camera.look_at = (0.0, 0.0, 0.0)  # viser moves it along
    place = ",".join(map(repr, before.tolist()))
    page.wait_for(f"{CAMERA}.reduce((sum, x, i) => sum + x * [{place}][i], 0) < -1")


def set_mode(view, mode):
    view._controls._mode.value = next(name for name, one in MODES.items() if one is mode)


def click_until(page, place, condition, **options):
    page.click(*place, **options)
    page.wait_for(condition)


def shows(text):
    return f"document.body.innerText.includes({text!r})"


def count_of(text):
    return f"document.body.innerText.split({text!r}).length - 1"


def notice_colour(page, title):
    """The colour of the notice with a title."""
    return page.evaluate(
        "getComputedStyle([...document.querySelectorAll('.mantine-Notification-root')].find("
        f"notice => notice.innerText.includes({title!r}))).getPropertyValue('--notification-color')"
    )


@pytest.fixture
def seamed():
    """A square that is cut along its middle: vertices repeat there."""
    square = shapes.grid(12)
    is_left = square.vertices[square.faces].mean(axis=1)[:, 0] < 0.5
    halves = []
    for faces in (square.faces[is_left], square.faces[~is_left]):
        used, own = np.unique(faces, return_inverse=True)
        halves.append(gt.TriangleMesh(square.vertices[used], own.reshape(faces.shape)))
    return shapes.disjoint_union(*halves)


@pytest.mark.slow
def test_a_click_on_a_sphere_sets_the_source_and_the_antipode_is_half_a_turn_away(
    view, open_page, sphere
):
    page = open_page(view)
    before = page.evaluate("gtSurface.updates")
    click_until(page, middle(page), f"gtSurface.updates > {before}")
    (source,) = view.session.sources
    assert len(source.vertices) == 3
    (client,) = view._server.get_clients().values()
    toward = np.array(client.camera.position) / np.linalg.norm(client.camera.position)
    at = source.of(sphere.vertices)
    assert at @ toward > 0.9999 * np.linalg.norm(at)
    exact = np.arccos(np.clip(sphere.vertices @ toward, -1, 1))
    assert np.abs(view.session.distances - exact).max() < 0.02

    set_mode(view, Mode.MEASURE)
    look_from_behind(view, page)
    click_until(page, middle(page), shows("Distance there"))
    assert view.session.measured[1] == pytest.approx(np.pi, abs=AT_THE_ANTIPODE)
    assert page.evaluate(shows(f"{view.session.measured[1]:.6g} mm"))
    assert page.complaints == []


@pytest.mark.slow
def test_the_page_asks_nothing_of_another_computer(view, open_page):
    page = open_page(view)
    before = page.evaluate("gtSurface.updates")
    click_until(page, middle(page), f"gtSurface.updates > {before}")
    own = (f"{view.url}/", f"blob:{view.url}/", view.url.replace("http:", "ws:"), "data:")
    assert len(page.requests) >= 2
    assert [url for url in page.requests if not url.startswith(own)] == []
    assert not page.evaluate("!!document.querySelector('[aria-label*=hare]')")


@pytest.mark.slow
def test_a_click_with_shift_adds_a_source_and_two_clicks_draw_a_path(view, open_page):
    page = open_page(view)
    x, y = middle(page)
    click_until(page, (x, y), "gtSurface.updates > 1")
    click_until(page, (x + 60, y), shows("Sources\t2"), shift=True)
    set_mode(view, Mode.PATH)
    click_until(page, (x, y), shows("Click where the path ends."))
    click_until(page, (x + 60, y), shows("Length of the path"))
    length = view.session.path.length
    assert page.evaluate(shows(f"{length:.6g} mm"))
    line = view.session.line()
    np.testing.assert_allclose(line[0], view.session.positions_of(view.session.sources)[0])
    straight = np.linalg.norm(line[-1] - line[0]) * view.session.scene.radius
    assert 0.1 < straight < length < 1.1 * straight
    page.click(5, 5)  # beside the shape: nothing changes
    set_mode(view, Mode.MEASURE)
    click_until(page, (x, y), shows("Distance there"))
    assert view.session.path.length == length


@pytest.mark.slow
def test_the_shape_is_drawn_in_the_colours_of_the_map_with_lines(view, open_page, tmp_path):
    image = pytest.importorskip("PIL.Image")
    page = open_page(view)
    view._controls._map.value = "gray"

    def pixels():
        page.screenshot(tmp_path / "page.png")
        with image.open(tmp_path / "page.png") as picture:
            return np.asarray(picture.convert("RGB")).astype(int)[:, :600]

    def until(condition):
        for _ in range(200):
            drawn = pixels()
            if condition(drawn):
                return drawn
        raise AssertionError("the page does not show it")

    def coloured(drawn):
        return (np.ptp(drawn, axis=-1) > 40).sum()

    def dark(drawn):
        return (drawn.max(axis=-1) < 60).sum()

    until(lambda drawn: coloured(drawn) < 3000 and (drawn.max(axis=-1) < 240).sum() > 20_000)
    view._controls._map.value = "viridis"
    with_lines = dark(until(lambda drawn: coloured(drawn) > 20_000))
    view._controls._lines.value = 0
    until(lambda drawn: dark(drawn) < with_lines - 500)


@pytest.mark.slow
def test_the_buttons_save_a_picture_a_table_and_the_sources(view, open_page, tmp_path, sphere):
    page = open_page(view)
    target = tmp_path / "saved"
    target.mkdir()
    page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(target))
    for label, name in (("PNG", "ball.png"), ("PLY", "ball.ply"), ("JSON", "ball.sources.json")):
        page.evaluate(
            f"[...document.querySelectorAll('button')].find(b => b.innerText === {label!r}).click()"
        )
        for _ in range(600):
            if (target / name).exists():
                break
            page.wait_for("true")
            threading.Event().wait(0.05)
    assert (target / "ball.png").read_bytes().startswith(b"\x89PNG")
    assert gt.read(target / "ball.ply").n_vertices == sphere.n_vertices
    assert json.loads((target / "ball.sources.json").read_text())["shape"] == "ball"


@pytest.mark.slow
def test_a_path_that_does_not_exist_is_explained_on_the_page(open_page):
    small = shapes.icosphere(3)
    pair = shapes.disjoint_union(
        gt.TriangleMesh(small.vertices + np.array([0, 0, 1.2]), small.faces),
        gt.TriangleMesh(small.vertices - np.array([0, 0, 1.2]), small.faces),
    )
    with gt.viz.view(pair, browser=False, block=False) as view:
        page = open_page(view)
        set_mode(view, Mode.PATH)
        middles = [
            view.session.scene.points[part].mean(axis=0) for part in (slice(642), slice(642, None))
        ]
        click_until(page, on_page(view, page, middles[0]), shows("Click where the path ends."))
        click_until(page, on_page(view, page, middles[1]), shows("UnreachableError"))
        view._controls._parts[0].value = False
        page.wait_for("true")
        assert view.session.hidden == {0}
        view._controls._parts[1].value = False  # all but one: an empty page has nothing to click
        assert view.session.hidden == {1}


@pytest.mark.slow
def test_points_and_edges_have_a_page_too_and_are_hidden_with_their_part(open_page):
    ring = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    places = np.column_stack([np.cos(ring), np.sin(ring), 0 * ring])
    edges = np.column_stack([np.arange(60), np.roll(np.arange(60), -1)])
    graph, places = gt.Graph(61, edges), np.vstack([places, [0, 0, 0]])  # one vertex by itself
    with gt.viz.view(graph, positions=places, browser=False, block=False) as view:
        page = open_page(view, drawn=shows("Largest distance"))
        view._controls._lines.value = 5
        drawn = "window.__viserMutable?.nodeRefFromName"
        page.wait_for(f"!!{drawn}['/edges']")
        view._controls._parts[0].value = False
        page.wait_for(f"!{drawn}['/edges'] && !!{drawn}['/shape']")
        assert page.complaints == []


# -- warnings and masks --------------------------------------------------------------------------


@pytest.mark.slow
def test_a_warning_of_another_method_is_on_the_page_once_and_is_not_red(open_page, recwarn):
    with gt.viz.view(shapes.icosphere(1), browser=False, block=False) as view:
        page = open_page(view)
        assert not page.evaluate(shows("Warnings"))
        view._controls._time.value = 2.0
        view._controls._refine.value = False
        view._controls._time.value = 1.7
        page.wait_for(f"{count_of('CoarseMeshWarning')} == 2")  # the notice, and the list
        ((kind, text),) = view._controls.warnings.values()
        assert kind == CoarseMeshWarning.__name__
        page.wait_for(shows(text))
        assert notice_colour(page, "CoarseMeshWarning") == YELLOW
        assert page.complaints == []
    assert list(recwarn) == []  # not on stderr as well


@pytest.mark.slow
def test_a_warning_of_the_beginning_reaches_the_caller_and_every_page(open_page, seamed):
    with pytest.warns(SeamWarning) as issued:
        view = gt.viz.view(seamed, browser=False, block=False)
    assert [Path(one.filename).name for one in issued] == [Path(__file__).name]
    with view:
        for _ in range(2):  # also a page that is opened again
            page = open_page(view)
            page.wait_for(f"{count_of('SeamWarning')} == 1")
            assert page.evaluate(shows(str(issued[0].message)))
        x, y = middle(page)
        for place in ((x - 60, y), (x + 60, y)):  # both sides, with other numbers in the message
            before = page.evaluate("gtSurface.updates")
            click_until(page, place, f"gtSurface.updates > {before}")
        assert page.evaluate(count_of("SeamWarning")) == 1
        assert len(view._controls.warnings) == 1
        view.warn("a polygon was split", "ReadWarning")
        view.warn("a polygon was split", "ReadWarning")
        page.wait_for(f"{count_of('a polygon was split')} == 2")


def test_a_warning_that_is_an_error_leaves_no_server(seamed):
    threads = set(threading.enumerate())
    with pytest.raises(SeamWarning):  # the tests turn warnings into errors
        gt.viz.view(seamed, browser=False, block=False)
    assert set(threading.enumerate()) == threads


@pytest.mark.slow
def test_a_click_on_masked_vertices_is_answered_by_a_notice(open_page, sphere):
    front = sphere.vertices[:, 2] > 0.5
    with gt.viz.view(sphere, mask=front, browser=False, block=False) as view:
        page = open_page(view)
        page.wait_for(shows(f"{front.sum()} vertices"))
        (client,) = view._server.get_clients().values()
        if client.camera.position[2] < 0:
            look_from_behind(view, page)
        top = on_page(view, page, view.session.scene.points[front].mean(axis=0))
        click_until(page, top, shows("InvalidSourceError"))
        assert page.evaluate(shows("click where the shape has a distance"))
        assert notice_colour(page, "InvalidSourceError") == YELLOW
        assert len(view.session.sources[0].vertices) == 1
        assert page.complaints == []


@pytest.mark.slow
def test_a_narrow_page_shows_all_of_the_shape(open_page, browser, view):
    size = {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **size)
    try:
        page = open_page(view)
        page.wait_for("window.__viserMutable.camera.fov > 40")
        (client,) = view._server.get_clients().values()
        while client.camera.fov < np.radians(40):
            page.wait_for("true")
        places = np.array([on_page(view, page, one) for one in view.session.scene.points[::50]])
        assert places.min() > 0
        assert (places.max(axis=0) < [400, 800]).all()
    finally:
        browser.call("Emulation.clearDeviceMetricsOverride")


# -- the server ----------------------------------------------------------------------------------


def test_the_server_is_on_this_computer_alone_and_ends(sphere):
    threads = set(threading.enumerate())
    with gt.viz.view(sphere, browser=False, block=False) as view:
        assert view.url.startswith("http://127.0.0.1:")
        assert view._server.get_host() == "127.0.0.1"
        with urllib.request.urlopen(view.url) as answer:
            assert answer.status == 200
    assert "stopped" in repr(view)
    view.stop()  # has no effect
    view.wait()  # returns at once
    for thread in set(threading.enumerate()) - threads:
        thread.join(10)
    assert set(threading.enumerate()) == threads


def test_a_page_that_does_not_answer_does_not_hold_up_the_end(sphere, capsys):
    threads = set(threading.enumerate())
    with gt.viz.view(sphere, browser=False, block=False) as view:
        port = int(view.url.rpartition(":")[2])
        page = socket.create_connection(("127.0.0.1", port))
        page.sendall(
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Protocol: viser-v" + viser.__version__.encode() + b"\r\n\r\n"
        )
        assert page.recv(12) == b"HTTP/1.1 101"
    for thread in set(threading.enumerate()) - threads:
        assert "ThreadPool" in thread.name  # they have nothing to do, and end
    page.close()
    assert capsys.readouterr() == ("", "")


def test_nothing_is_printed(sphere, capsys):
    with gt.viz.view(sphere, browser=False, block=False):
        pass
    assert capsys.readouterr() == ("", "")


def websocket(view, origin):
    return connect(
        view.url.replace("http:", "ws:"),
        origin=origin,
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    )


def test_pages_of_other_sites_may_not_connect(view):
    with websocket(view, "https://example.org") as connection:
        with pytest.raises(ConnectionClosedError) as closed:
            list(connection)
        assert closed.value.rcvd.code == 1008
    with websocket(view, view.url) as connection:
        assert connection.recv(timeout=30)


def test_the_page_is_not_shared_through_a_server_of_others(view):
    assert view._server.request_share_url() is None
    assert view._server._share_tunnel is None


def test_a_port_in_use_is_an_error_and_leaves_nothing_open(view, sphere):
    port = int(view.url.rpartition(":")[2])
    with pytest.raises(InvalidOptionError, match=f"port {port} is in use"):
        gt.viz.view(sphere, browser=False, block=False, port=port)


@pytest.mark.parametrize(
    "options",
    [
        {"port": -1},
        {"port": 65536},
        {"port": "80"},
        {"port": True},
        {"isolines": 61},
        {"isolines": -1},
        {"isolines": 2.0},
        {"cmap": "virids"},
        {"cmap": 3},
    ],
)
def test_wrong_options_are_refused(sphere, options):
    with pytest.raises(InvalidOptionError):
        gt.viz.view(sphere, browser=False, block=False, **options)


def test_without_viser_the_error_names_the_extra(sphere, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingDependencyError, match=r"geodesic-toolkit\[view\]"):
        gt.viz.view(sphere, browser=False, block=False)


def test_a_viser_of_another_kind_is_an_error_that_names_the_extra(sphere, monkeypatch):
    from viser import _messages

    threads = set(threading.enumerate())
    monkeypatch.delattr(_messages, "RunJavascriptMessage")
    with pytest.raises(MissingDependencyError, match=r"differs from version 1\.1"):
        gt.viz.view(sphere, browser=False, block=False)
    for thread in set(threading.enumerate()) - threads:
        thread.join(10)
    assert set(threading.enumerate()) == threads


def test_the_default_browser_is_opened(sphere, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    with gt.viz.view(sphere, block=False) as view:
        assert opened == [view.url]


# -- the command ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_prints_the_address_and_ctrl_c_ends_it(sphere_file):
    command = [sys.executable, "-m", "geodesic_toolkit", "view", str(sphere_file), "--no-open"]
    with subprocess.Popen(
        [*command, "--source", "5", "--source", "7"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            url = process.stdout.readline().strip()
            assert url.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(url) as answer:
                assert b"<title>" in answer.read(10_000)
            process.send_signal(signal.SIGINT)
            rest, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0
    assert rest == ""
    assert "error" not in errors
    assert "interrupted" not in errors


def test_ctrl_c_right_after_the_address_ends_the_page_too(sphere_file, monkeypatch):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("geodesic_toolkit.cli.view.show", interrupted)
    result = run("view", sphere_file, "--no-open")
    assert (result.exit_code, result.stderr) == (0, "")


@pytest.fixture
def opened(monkeypatch):
    """The pages that commands open, which end at once."""
    pages = []

    def wait(page):
        pages.append(page)

    monkeypatch.setattr("geodesic_toolkit.viz.live.view.View.wait", wait)
    return pages


def test_the_command_takes_masks_costs_and_the_method_as_distance_does(
    sphere_file, tmp_path, opened
):
    mesh = gt.read(sphere_file)
    mask, cost = tmp_path / "mask.npy", tmp_path / "cost.npy"
    masked = mesh.vertices[:, 2] > 0.5
    np.save(mask, masked)
    np.save(cost, np.full(mesh.n_vertices, 2.0))
    options = ["--mask", mask, "--cost", cost, "--no-refine", "--time-factor", 2]
    result = run("view", sphere_file, "--no-open", "--json", *options)
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["mask"], found["cost"]) == (str(mask), str(cost))
    (page,) = opened
    shape = gt.MetricMesh(mesh, cost=np.full(mesh.n_vertices, 2.0))
    solver = gt.GeodesicSolver(shape, mask=masked, refine=False, time_factor=2.0)
    source = page.session.sources[0].vertices[0]
    np.testing.assert_array_equal(page.session.distances, solver.distance(int(source)))
    assert [f"{text} [{kind}]" for kind, text in page._controls.warnings.values()] == (
        found["warnings"]
    )


def test_what_reading_warned_of_is_on_the_page_of_the_command(tmp_path, opened):
    file = tmp_path / "square.off"
    file.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    result = run("view", file, "--no-open", "--json", "--operator", "cotan")
    (warning,) = json.loads(result.stdout)["warnings"]
    assert "ReadWarning" in warning
    (page,) = opened
    assert [text for _, text in page._controls.warnings.values()] == [warning]


def test_the_command_refuses_a_graph_and_a_wrong_source(sphere_file, graph_file):
    fails(run("view", graph_file, "--no-open"), 3, "no positions")
    fails(run("view", sphere_file, "--no-open", "--source", "x"), 2, "--source x")
    fails(run("view", sphere_file, "--no-open", "--cmap", "virids"), 2, "viridis")
    fails(run("view", sphere_file, "--no-open", "--time-factor", "-1"), 2, "--time-factor")
