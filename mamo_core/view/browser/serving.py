"""viser's server, on this machine alone."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from typing import TYPE_CHECKING

from mamo_core.errors import InputError, PluginError

if TYPE_CHECKING:
    from viser import ViserServer

LOOPBACK = "127.0.0.1"


@contextlib.contextmanager
def local_server(port: int = 0) -> Iterator[ViserServer]:
    """A server that nobody beyond this machine can reach; port 0 is any free one.

    Raises:
        PluginError: viser is not installed.
        InputError: the port is in use.
    """
    try:
        from viser import ViserServer
    except ModuleNotFoundError as error:
        hint = "pip install 'mamo[view]'"
        raise PluginError(f"a view in the browser needs {error.name}: {hint}") from None
    with _silence():
        server = ViserServer(host=LOOPBACK, port=port, verbose=False)
    try:
        if port not in (0, server.get_port()):  # viser goes on to the next free one
            raise InputError(f"--port {port}: in use, expected a free port, or 0 for any")
        yield server
    finally:
        with _silence():
            server.stop()


def _silence() -> contextlib.redirect_stdout[io.StringIO]:
    """The server greets and says goodbye on stdout, which is for results."""
    return contextlib.redirect_stdout(io.StringIO())
