"""The report and the web viewer of a run folder, on loopback only."""

import asyncio
import signal
from collections.abc import Callable
from pathlib import Path

from plumbline.harness.store.store import Store
from plumbline.reports.server.connections import HEAD_BYTES, MOST, Connections
from plumbline.reports.server.site import Site

LOOPBACK = "127.0.0.1"


def serve(folder: Path, port: int, announce: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Args:
        port: on 127.0.0.1; 0 takes a free one.
        announce: told the address once the server answers.

    Raises:
        StoreError: no run folder. OSError: the port is taken.
    """
    asyncio.run(_listen(Site(Store(folder)), port, announce))


async def _listen(site: Site, port: int, announce: Callable[[str], None]) -> None:
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    server = await asyncio.start_server(Connections(site.answer).take, LOOPBACK, port, limit=HEAD_BYTES, backlog=MOST)
    try:
        announce(f"http://{LOOPBACK}:{server.sockets[0].getsockname()[1]}/")
        await stop.wait()
        announce("stopped")
    finally:
        server.close()
        site.close()
