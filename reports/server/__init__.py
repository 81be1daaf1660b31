"""The report and the web viewer of a run folder, on loopback only."""

from collections.abc import Callable
from http.server import ThreadingHTTPServer
from pathlib import Path

from harness.store import Store
from reports.server.site import requests_to

__all__ = ["serve"]

LOOPBACK = "127.0.0.1"


def serve(folder: Path, port: int, announce: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Args:
        port: on 127.0.0.1; 0 takes a free one.
        announce: told the address once the server answers.

    Raises:
        StoreError: no run folder. OSError: the port is taken.
    """
    with ThreadingHTTPServer((LOOPBACK, port), requests_to(Store(folder))) as server:
        server.daemon_threads = True
        announce(f"http://{LOOPBACK}:{server.server_port}/")
        try:
            server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            announce("stopped")
