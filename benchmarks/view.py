"""Pages to click: the time from a click to distances, and to colours on the page.

python benchmarks/view.py                     three sizes, in a headless Chromium
python benchmarks/view.py --write             also docs/_tables/view.md
python benchmarks/view.py --picture FILE      the page of a knot instead, as a PNG

A Chromium without a graphics card draws by the processor: the last column is the time with that,
and the one before it that of everything else.
"""

import argparse
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import viser
from measuring.machine import machine, sentence
from measuring.tables import TABLES, markdown
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import geodesic_toolkit as gt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))

from browser import open_browser

from geodesic_toolkit.viz.live.controls import MODES
from geodesic_toolkit.viz.live.session import Mode

SIZES = {"10k": (126, 80), "100k": (400, 250), "500k": (1000, 500)}
CLICKS = 15
SIZE_OF_PICTURE = (1200, 800)
SIZE_OF_PAGE = (800, 400)  # small: it is the time to draw that a graphics card saves
HEADINGS = [
    "vertices", "pick", "distances", "server", "its CPU", "sent", "to the page", "in the frame",
    "all but drawing", "drawn",
]  # fmt: skip
DRAWN = "window.gtSurface && window.gtSurface.updates > {count}"
NOTICES = "document.querySelectorAll('.mantine-Notification-root').forEach(n => n.remove())"
NOTE = (
    "The least of {clicks} clicks, in ms. *Server*: from the click until its answer is sent, with "
    "*pick*, which finds the place, and the *distances*; *its CPU* is that of all its threads. "
    "*Sent*: kilobytes. *To the page*: through the socket, decoded, and handed to the page; "
    "*in the frame*: from there until the values are in the buffer of a frame, and its commands "
    "are given. "
    "*All but drawing*: from the release of the button to there, with three triangles of the mesh "
    "to draw. *Drawn*: the same with all triangles, on a page of {size} pixels, where a processor "
    "draws two frames in that time. {machine}"
)

STAMPS = """
window.gtClock = () => performance.timeOrigin + performance.now();
addEventListener('pointerup', () => { window.gtClick = gtClock(); }, true);
window.Worker = class extends Worker {
    constructor(...options) {
        super(...options);
        this.addEventListener('message', (event) => {
            const isValues = (one) => one.name === '/values' && one.updates?.colors;
            if (event.data?.messages?.some(isValues)) window.gtArrived = gtClock();
        });
    }
};
"""
"""Notes on the page when the button was released, and when values arrived; in ms of the system."""

DRAW = (
    "window.__viserMutable.nodeRefFromName['/shape']"
    ".traverse(one => one.geometry?.setDrawRange(0, {count})); 1"
)


class Counter:
    """Bytes that a second client of the page gets."""

    def __init__(self, url):
        protocol = [f"viser-v{viser.__version__}"]
        self._socket = connect(url.replace("http:", "ws:"), subprotocols=protocol, max_size=None)
        self.count = 0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            for message in self._socket:
                self.count += len(message)
        except ConnectionClosed:
            return

    def close(self):
        self._socket.close()


class Times(dict):
    """Times of the system, in ms, at which a click and its answer pass the session."""

    def __init__(self, view):
        self.answered = threading.Event()
        session, server = view.session, view._server  # noqa: SLF001 - to take the time in it
        pick, click, flush = session.pick, session.click, server.flush

        def timed_pick(*ray):
            self.update(began=1000 * time.time(), cpu=1000 * time.process_time())
            place = pick(*ray)
            self["picked"] = 1000 * time.time()
            return place

        def timed_click(*place, **how):
            click(*place, **how)
            self["solved"] = 1000 * time.time()

        def timed_flush():
            flush()
            self.update(sent=1000 * time.time(), cpu_sent=1000 * time.process_time())
            self.answered.set()

        session.pick, session.click, server.flush = timed_pick, timed_click, timed_flush

    def clear(self):
        super().clear()
        self.answered.clear()


def visit(page, view):
    page.visit(view.url)
    page.wait_for(DRAWN.format(count=0), seconds=300)
    time.sleep(2)
    page.evaluate(NOTICES)


def clicked(page, times, counter):
    """Return the stages of some clicks, in ms, and how much was sent."""
    rng, rows = np.random.default_rng(1), []
    box = page.evaluate(
        "(b => [b.left, b.top, b.width, b.height])"
        "(document.querySelector('canvas').getBoundingClientRect())"
    )
    while len(rows) < CLICKS:
        count, before = page.evaluate("gtSurface.updates"), counter.count
        x, y = np.array(box[:2]) + np.array(box[2:]) * rng.uniform(0.2, 0.8, 2)
        times.clear()
        page.click(float(x), float(y))
        assert times.answered.wait(60)
        if "solved" not in times:  # beside the shape
            continue
        page.wait_for(DRAWN.format(count=count), seconds=300)
        time.sleep(0.5)
        released, arrived, ended = page.evaluate(
            "[gtClick, gtArrived, performance.timeOrigin + gtSurface.ended]"
        )
        rows.append(
            [
                times["picked"] - times["began"],
                times["solved"] - times["picked"],
                times["sent"] - times["began"],
                times["cpu_sent"] - times["cpu"],
                (counter.count - before) / 1000,
                arrived - times["sent"],
                ended - arrived,
                ended - released,
            ]
        )
    return np.min(rows, axis=0)  # other work on the machine adds to the rest


def measure(page, mesh):
    """Return a row for one mesh."""
    with gt.viz.view(mesh, browser=False, block=False) as view:
        times = Times(view)
        visit(page, view)
        counter = Counter(view.url)
        time.sleep(3)
        drawn = clicked(page, times, counter)
        page.evaluate(DRAW.format(count=3))
        row = clicked(page, times, counter)
        counter.close()
        page.visit("about:blank")
    assert page.complaints == [], page.complaints
    return [*row, drawn[-1]]


def picture(page, file):
    """Save the page of a knot with a path."""
    knot = gt.testing.shapes.knot(1200, 48)
    with gt.viz.view(knot, sources=28_000, browser=False, block=False, name="knot") as view:
        visit(page, view)
        path = next(name for name, mode in MODES.items() if mode is Mode.PATH)
        view._controls._mode.value = path  # noqa: SLF001 - as the panel does
        for x, y in ((250, 140), (690, 330)):
            page.click(x, y)
            time.sleep(3)
        page.screenshot(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sizes", default=",".join(SIZES))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    profile = tempfile.mkdtemp()
    size = SIZE_OF_PICTURE if options.picture else SIZE_OF_PAGE
    with open_browser(profile, f"--window-size={size[0]},{size[1]}", offline=False) as page:
        if options.picture is not None:
            picture(page, options.picture)
            return
        page.call("Page.addScriptToEvaluateOnNewDocument", source=STAMPS)
        rows = []
        for size in options.sizes.split(","):
            mesh = gt.testing.shapes.bumpy_torus(*SIZES[size], rng=np.random.default_rng(0))
            figures = measure(page, mesh)
            rows.append(
                [
                    f"{mesh.n_vertices:,}",
                    *(
                        f"{figure:,.0f}" if figure >= 1000 else f"{figure:.3g}"
                        for figure in figures
                    ),
                ]
            )
            print(rows[-1], flush=True)
    text = markdown(
        HEADINGS,
        rows,
        NOTE.format(
            clicks=CLICKS, size="{} × {}".format(*SIZE_OF_PAGE), machine=sentence(machine()).strip()
        ),
    )
    print(text)
    if options.write:
        (TABLES / "view.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
