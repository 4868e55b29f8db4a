"""The server that gives the page to the browser: viser, bound to this computer."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from typing import Any
from urllib.parse import urlsplit

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError

__all__ = ["HOST", "close_server", "open_server"]

HOST = "127.0.0.1"
"""The loopback address: other computers cannot connect."""

HOSTS_OF_PAGES = frozenset({HOST, "localhost"})
"""Hosts of pages that may connect. Browsers send the host of the page that connects."""

SECONDS_TO_CLOSE = 0.2
"""Seconds that the end of the server waits for a page that does not answer."""

POLICY_VIOLATION = 1008
"""Status with which a connection from another page is closed."""


def open_server(port: int, label: str) -> Any:
    """Start a server on a thread, and return it.

    Parameters
    ----------
    port : int
        0 for any free one.
    label : str
        The name at the top of the panel.

    Returns
    -------
    viser.ViserServer

    Raises
    ------
    InvalidOptionError
        The port is not one, or is in use.
    MissingDependencyError
        viser is not installed, or is of a version with another inside.
    """
    if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port < 2**16:
        raise InvalidOptionError(f"port must be an integer from 0 to 65535, not {port!r}")
    viser = require("viser", "view", "Pages to click need")
    messages = require("viser._messages", "view", "Pages to click need")
    with _quiet():
        server = viser.ViserServer(host=HOST, port=port, label=label, verbose=False)
    try:
        if port not in (0, server.get_port()):  # viser goes on to the next free one
            raise InvalidOptionError(f"port {port} is in use; give another one, or 0 for any")
        _keep_private(server)
        script = resources.files(__package__).joinpath("surface.js").read_text(encoding="utf-8")
        _run_script(server, messages, script)
    except BaseException:
        close_server(server)
        raise
    return server


def close_server(server: Any) -> None:
    """Stop the server and its threads."""
    with _quiet():
        server.stop()


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep viser from printing its own banner on stdout."""
    console = require("rich", "view", "Pages to click need").get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def _keep_private(server: Any) -> None:
    """Refuse pages of other sites, and requests to share the page through a server of others.

    A browser lets any site connect to this computer, and viser takes every connection.
    """

    async def admit(client: Any) -> None:
        connection = connections[client.client_id]
        connection.close_timeout = SECONDS_TO_CLOSE
        origin = connection.request.headers.get("Origin")
        if origin is not None and urlsplit(origin).hostname not in HOSTS_OF_PAGES:
            await connection.close(POLICY_VIOLATION, "pages of other sites may not connect")

    def refuse_to_share(verbose: bool = True) -> None:  # noqa: ARG001 - the signature of viser
        return None

    try:
        web = server._websock_server  # noqa: SLF001 - viser has no public name for it
        connections = web._live_connections  # noqa: SLF001
    except AttributeError as error:
        raise _other_version(error) from error
    web.on_client_connect(admit)
    server.request_share_url = refuse_to_share


def _run_script(server: Any, messages: Any, script: str) -> None:
    """Run JavaScript on the pages of all clients, present and future."""
    try:
        message = messages.RunJavascriptMessage(source=script)
        server._websock_server.queue_message(message)  # noqa: SLF001 - viser has no public name
    except (AttributeError, TypeError) as error:
        raise _other_version(error) from error


def _other_version(error: Exception) -> MissingDependencyError:
    return MissingDependencyError(
        f"the installed viser differs from version 1.1, with which the page works ({error}); "
        'install a suitable one: pip install -U "geodesic-toolkit[view]"'
    )
