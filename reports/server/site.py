"""What is answered to which address: pages of our own, files of the run folder, and the viewer's program.

The two pages of the server's own: what there is, and the page that holds the viewer.

The program of rerun's web viewer, taken once from the viewer in the wheel, which carries it inside.

The wheel holds no files of it: its binary serves them. It is started on a free loopback port, asked for both files, and ended.
"""

import asyncio
import os
import re
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from http import HTTPStatus
from http.client import HTTPException
from pathlib import Path
from urllib.error import URLError
from urllib.parse import quote, unquote
from urllib.request import ProxyHandler, build_opener

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from plumbline.harness.intake.safe_text import LONGEST, one_line, visible
from plumbline.harness.store.store import Store
from plumbline.reports.html.policy import DATA, SERVED, VIEWER
from plumbline.reports.recordings import moment_recording
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.recordings.viewer import ENVIRONMENT, viewer_command
from plumbline.reports.server.request import PageRequest, Response, text
from plumbline.reports.words.text import plural

FILES = ("re_viewer.js", "re_viewer_bg.wasm")

PATIENCE = 60.0
"""Seconds that the viewer may take to start."""

NO_RECORDING = "http://127.0.0.1:9/none.rrd"
"""With an address to show, the viewer opens no port for recordings. It hands the address to the browser and never asks it."""


class AssetsMissing(Exception):
    """The viewer did not give its program; the message says what it said instead."""


_lock = threading.Lock()


def viewer_file(name: str) -> bytes | None:
    """One of the viewer's files; None for any other name. Raises: AssetsMissing."""
    if name not in FILES:
        return None
    with _lock:
        return fetched()[name]


@cache
def fetched() -> dict[str, bytes]:
    """All files of the web viewer, about 43 MB."""
    command = [*viewer_command(), "--serve-web", "--bind", "127.0.0.1", "--web-viewer-port", "0", NO_RECORDING]
    environment = os.environ | ENVIRONMENT | {"BROWSER": "true", "NO_COLOR": "1"}
    viewer = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    alarm = threading.Timer(PATIENCE, _end, (viewer,))
    alarm.start()
    try:
        return _ask(viewer)
    finally:
        alarm.cancel()
        _end(viewer)


def _ask(viewer: "subprocess.Popen[str]") -> dict[str, bytes]:
    output: list[str] = []
    for line in viewer.stdout or ():
        output.append(re.sub(r"\x1b\[[0-9;]*m", "", line))
        if address := re.search(r"web-viewer at (http://127\.0\.0\.1:\d+)", output[-1]):
            opener = build_opener(ProxyHandler({}))  # a proxy of the environment is not for loopback
            try:
                return {name: opener.open(f"{address[1]}/{name}", timeout=PATIENCE).read() for name in FILES}
            except (URLError, HTTPException, OSError) as error:
                raise AssetsMissing(f"web viewer at {address[1]}: {error}") from error
    raise AssetsMissing(f"the rerun viewer did not start its web server: {''.join(output)[-2000:]}")


def _end(viewer: "subprocess.Popen[str]") -> None:
    """End the viewer and the interpreter that started it, which share a session."""
    with suppress(ProcessLookupError):
        os.killpg(viewer.pid, signal.SIGKILL)
    viewer.wait()


STATIC = Path(__file__).parent / "static"


def template(name: str, **values: object) -> bytes:
    """A page with every string escaped."""
    page = Environment(loader=FileSystemLoader(STATIC), autoescape=True, undefined=StrictUndefined).get_template(name)
    return page.render(**values).encode()


def recordings(store: Store) -> list[dict[str, object]]:
    """A row for each case: its name and title, its recording if there is one, and how its trials ended."""
    rows = []
    for case, trials in store.trials.groupby("case", sort=False):
        entry = store.catalogue.get("cases", {}).get(case, {})
        path = store.folder / "recordings" / file_name(str(case))
        counts = trials["status"].value_counts(sort=False)
        rows.append(
            {
                "case": case,
                "title": entry.get("title") or case,
                "address": quote(f"/recordings/{path.name}") if path.is_file() else None,
                "megabytes": path.stat().st_size / 1e6 if path.is_file() else None,
                "outcomes": ", ".join(f"{count} {status}" for status, count in counts.items()),
                "trials": plural(len(trials), "trial"),
            }
        )
    return rows


def front_page(store: Store) -> bytes:
    """Links to the report and to each recording."""
    report = (store.folder / "report" / "index.html").is_file()
    return template("front.html", study=store.study.get("name", store.folder.name), report=report, rows=recordings(store))


def viewer_page(store: Store) -> bytes:
    """The page that loads the viewer; which recording is in the address."""
    return template("view.html", study=store.study.get("name", store.folder.name))


PAGE_MAKERS = 4
"""Threads; the program of the viewer, which takes seconds to come, has one of its own."""
PROGRAM = "/viewer/"
MOMENT = re.compile(r"/moment/(\d{1,9}(?:\.\d{1,12})?)/([A-Za-z0-9_.-]{1,200})")
"""A moment [s] and the recording whose stretch about it is asked for."""

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
