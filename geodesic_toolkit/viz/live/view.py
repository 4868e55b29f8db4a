"""The page as a whole: made, opened, stopped."""

import threading
import webbrowser
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from numpy.typing import ArrayLike

from geodesic_toolkit.core.warning import collected_warnings, warn
from geodesic_toolkit.errors import GeodesicWarning
from geodesic_toolkit.solver.solver import Refine
from geodesic_toolkit.viz.live.controls import Controls, check_look
from geodesic_toolkit.viz.live.server import HOST, close_server, open_server
from geodesic_toolkit.viz.live.session import Session

__all__ = ["View", "view"]


class View:
    """A page that is open until it is stopped; a context manager stops it at its end.

    Attributes
    ----------
    url : str
        Its address, on this computer only.
    """

    def __init__(self, server: Any, session: Session, controls: Controls) -> None:
        self._server, self._session, self._controls = server, session, controls
        self._stopped = threading.Event()
        self.url = f"http://{HOST}:{server.get_port()}"

    def warn(self, text: str, kind: str = "Warning") -> None:
        """Show a warning on the page, with those of this package.

        Parameters
        ----------
        text : str
        kind : str
            The line above it.
        """
        self._controls.warn([(text, kind)])

    @property
    def session(self) -> Session:
        """The state of the page: its ``sources``, ``distances`` and ``path`` after the clicks."""
        return self._session

    def wait(self) -> None:
        """Wait until the view is stopped, or Ctrl-C is pressed, which stops it."""
        try:
            while not self._stopped.wait(0.5):  # a wait without an end keeps Ctrl-C waiting, too
                pass
        except KeyboardInterrupt:
            self.stop()

    def stop(self) -> None:
        """Close the page's connection and end the server; a second call has no effect."""
        if not self._stopped.is_set():
            self._stopped.set()
            close_server(self._server)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"View({self.url}{', stopped' if self._stopped.is_set() else ''})"


def view(
    domain: Any,
    *,
    sources: Any = None,
    operator: Any = "auto",
    mask: ArrayLike | None = None,
    refine: Refine = "auto",
    time_factor: float = 1.0,
    positions: ArrayLike | None = None,
    cmap: str = "viridis",
    isolines: int = 20,
    unit: str = "",
    name: str = "shape",
    like: Path | None = None,
    port: int = 0,
    browser: bool = True,
    block: bool = True,
) -> View:
    """Show a shape in the browser, where a click sets the source of the distances.

    The page comes from a server on this computer that no other computer can reach, and needs no
    network. A shift-click adds a source. The panel draws the shortest path between two clicks,
    reads distances, changes isolines, colours and method, hides components, and saves.

    Parameters
    ----------
    domain : Domain, or whatever :class:`GeodesicSolver` takes
        A mesh, a point cloud, a kind of a plugin's with positions; a graph with `positions`.
    sources : optional
        The sources at the beginning, as :meth:`GeodesicSolver.distance` takes them, except for
        curves and offsets; by default one vertex.
    operator : LaplaceOperator or str
        As for :class:`GeodesicSolver`.
    mask : array-like of shape (N,), bool, optional
        As for :class:`GeodesicSolver`: True at vertices that paths may not cross. They are grey,
        and clicks there are refused.
    refine, time_factor : optional
        As for :class:`GeodesicSolver`, at the beginning; the panel changes them.
    positions : array-like of shape (N, 3) or (N, 2), optional
        Positions at which the vertices of a graph are drawn.
    cmap : str
        Name of a colour map of matplotlib.
    isolines : int
        Approximate number of isolines at the beginning, from 0 to 60.
    unit : str
        Unit of the distances.
    name : str
        Name of the shape, on the page and for saved files.
    like : path-like, optional
        The .ply file of the shape, whose other data are kept in a saved .ply.
    port : int
        Port of the server; 0 for any free one.
    browser : bool
        Whether to open the page in the default browser.
    block : bool
        True returns after Ctrl-C. False returns at once, with the page open.

    Returns
    -------
    View
        With the address of the page, and what is on it.

    Raises
    ------
    UnsupportedDomainError
        The shape has no positions.
    InvalidOptionError
        An unknown colour map, a number of isolines out of range, a port that is in use.
    InvalidSourceError
        Sources that name no place.
    MissingDependencyError
        viser or matplotlib is not installed: ``pip install "geodesic-toolkit[view]"``.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> with gt.viz.view(sphere, browser=False, block=False) as page:
    ...     page.url.startswith("http://127.0.0.1:")
    True
    """
    check_look(cmap, isolines)
    with collected_warnings(GeodesicWarning) as collected:
        session = Session(
            domain,
            positions=positions,
            sources=sources,
            operator=operator,
            mask=mask,
            refine=refine,
            time_factor=time_factor,
            name=name,
            like=like,
        )
    for text, category in collected:  # issued to the caller, too
        warn(text, category)
    server = open_server(port, name)
    try:
        controls = Controls(server, session, cmap=cmap, isolines=isolines, unit=unit)
        controls.warn([(text, category.__name__) for text, category in collected])
    except BaseException:
        close_server(server)
        raise
    page = View(server, session, controls)
    if browser:
        webbrowser.open(page.url)
    if block:
        page.wait()
    return page
