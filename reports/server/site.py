"""What is answered to which address: pages of our own, files of the run folder, and the viewer's program."""

import asyncio
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from pathlib import Path
from urllib.parse import unquote

from plumbline.harness.intake.safe_text import LONGEST, one_line, visible
from plumbline.harness.store.store import Store
from plumbline.reports.html.policy import DATA, SERVED, VIEWER
from plumbline.reports.recordings import moment_recording
from plumbline.reports.server.answer import Response, text
from plumbline.reports.server.assets import AssetsMissing, viewer_file
from plumbline.reports.server.pages import front_page, viewer_page
from plumbline.reports.server.request import PageRequest

PAGE_MAKERS = 4
"""Threads; the program of the viewer, which takes seconds to come, has one of its own."""
PROGRAM = "/viewer/"
MOMENT = re.compile(r"/moment/(\d{1,9}(?:\.\d{1,12})?)/([A-Za-z0-9_.-]{1,200})")
"""A moment [s] and the recording whose stretch about it is asked for."""

STATIC = Path(__file__).parent / "static"
OWN = {f"/static/{name}": STATIC / name for name in ("front.css", "view.css", "view.js")}

OPEN_FOLDERS = ("report", "recordings", "changes")
"""The parts of a run folder that are served; the rest of the disk is not."""

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".webp": "image/webp",
    ".json": "application/json",
    ".csv": "text/csv; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
    ".rrd": "application/octet-stream",
    ".wasm": "application/wasm",
}
"""The kinds of files that are served, by their ending."""


def file_of(folder: Path, address: str) -> Path | None:
    """The file that an address names below the open folders; None where there is none or a link leads out of them."""
    parts = unquote(address).split("/")[1:]
    if len(parts) < 2 or parts[0] not in OPEN_FOLDERS or "\0" in address or "%00" in address:
        return None
    if any(not name or name.startswith(".") for name in parts):
        return None
    try:
        base = folder.resolve() / parts[0]
        path = base.joinpath(*parts[1:]).resolve()
        if not path.is_relative_to(base) or path.suffix not in KINDS:
            return None
        return path if path.is_file() else None
    except (OSError, RuntimeError):  # a name that is too long, links in a circle
        return None


class Site:
    """Answers for one run folder, worked out on a few threads: what one of them waits for keeps no other answer."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._pages = ThreadPoolExecutor(PAGE_MAKERS)
        self._viewer = ThreadPoolExecutor(1)

    def close(self) -> None:
        """Begin no further answer."""
        for pool in (self._pages, self._viewer):
            pool.shutdown(wait=False, cancel_futures=True)

    async def answer(self, request: PageRequest) -> Response:
        """What is at an address of this site."""
        pool = self._viewer if request.address.startswith(PROGRAM) else self._pages
        try:
            return await asyncio.get_running_loop().run_in_executor(pool, self._route, request.address)
        except AssetsMissing as error:
            return text(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        except Exception as error:
            message = f"{request.address}: {type(error).__name__}: {error}"
            print(one_line(message, LONGEST), file=sys.stderr)
            return text(HTTPStatus.INTERNAL_SERVER_ERROR, visible(message[:LONGEST]))

    def _route(self, address: str) -> Response:
        if address == "/":
            return Response(HTTPStatus.OK, KINDS[".html"], front_page(self._store), SERVED)
        if address == "/view":
            return Response(HTTPStatus.OK, KINDS[".html"], viewer_page(self._store), VIEWER)
        if (own := OWN.get(address)) is not None:
            return Response(HTTPStatus.OK, KINDS[own.suffix], own)
        if address.startswith(PROGRAM) and (program := viewer_file(address.removeprefix(PROGRAM))) is not None:
            return Response(HTTPStatus.OK, KINDS[Path(address).suffix], program, keep="max-age=3600")
        if (asked := MOMENT.fullmatch(address)) is not None:
            stretch = moment_recording(self._store, asked[2], float(asked[1]))
            if stretch is not None:
                return Response(HTTPStatus.OK, KINDS[".rrd"], stretch, DATA)
        if (path := file_of(self._store.folder, address)) is not None:
            return Response(HTTPStatus.OK, KINDS[path.suffix], path, SERVED if path.suffix == ".html" else DATA)
        return text(HTTPStatus.NOT_FOUND, f"nothing at {address[:200]!r}")
