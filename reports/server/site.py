"""What is answered to which address: pages of our own, files of the run folder, and the viewer's program."""

import shutil
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from socketserver import BaseServer
from typing import Any
from urllib.parse import unquote, urlsplit

from harness.store import Store
from reports.server.assets import AssetsMissing, viewer_file
from reports.server.pages import front_page, viewer_page

__all__ = ["Site", "requests_to"]

STATIC = Path(__file__).parent / "static"
OWN = {f"/static/{name}": STATIC / name for name in ("front.css", "view.css", "view.js")}

OPEN_FOLDERS = ("report", "recordings")
"""The parts of a run folder that are served; the rest of the disk is not."""

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".csv": "text/csv; charset=utf-8",
    ".rrd": "application/octet-stream",
    ".wasm": "application/wasm",
}
"""The kinds of files that are served, by their ending."""

OUR_POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",  # the viewer is WebAssembly
        "style-src 'self' 'unsafe-inline'",  # the viewer sets styles on its canvas
        "img-src 'self' data: blob:",
        "worker-src 'self' blob:",
        "connect-src 'self'",  # recordings come from here, and nothing leaves this machine
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'self'",
    ]
)

FILE_POLICY = "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
"""For pages of the report, which bring a stricter policy of their own."""


def file_of(folder: Path, address: str) -> Path | None:
    """The file that an address names below the open folders; None where there is none or it would lead out of them."""
    parts = [part for part in unquote(address).split("/") if part]
    if len(parts) < 2 or parts[0] not in OPEN_FOLDERS or "\0" in address or "%00" in address:
        return None
    base = (folder / parts[0]).resolve()
    try:
        path = base.joinpath(*parts[1:]).resolve()
        if not path.is_relative_to(base) or any(part.startswith(".") for part in parts) or path.suffix not in KINDS:
            return None
        return path if path.is_file() else None
    except OSError:  # a name that is too long, links in a circle
        return None


class Site(BaseHTTPRequestHandler):
    """Answers GET and HEAD for one run folder."""

    protocol_version = "HTTP/1.1"
    server_version, sys_version = "plumbline", ""
    timeout = 60

    def __init__(self, store: Store, request: Any, client_address: Any, server: BaseServer) -> None:
        self.store = store
        super().__init__(request, client_address, server)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002  the name is the base class's
        """Nothing: a person watches the address, not a list of requests."""

    def do_GET(self) -> None:
        """Answer with headers and content."""
        self._answer(content=True)

    def do_HEAD(self) -> None:
        """Answer with headers alone."""
        self._answer(content=False)

    def _answer(self, content: bool) -> None:
        # A page of another site whose name was made to point at this machine (DNS rebinding) sends its own name.
        if self.headers.get("Host", "").rsplit(":", 1)[0] not in {"127.0.0.1", "localhost"}:
            self._send(HTTPStatus.FORBIDDEN, b"expected the host 127.0.0.1\n", "text/plain", content)
            return
        address = urlsplit(self.path).path
        try:
            self._route(address, content)
        except AssetsMissing as error:
            self._send(HTTPStatus.SERVICE_UNAVAILABLE, f"{error}\n".encode(), "text/plain; charset=utf-8", content)
        except (BrokenPipeError, ConnectionResetError):
            self.close_connection = True

    def _route(self, address: str, content: bool) -> None:
        if address == "/":
            self._send(HTTPStatus.OK, front_page(self.store), KINDS[".html"], content)
        elif address == "/view":
            self._send(HTTPStatus.OK, viewer_page(self.store), KINDS[".html"], content)
        elif (own := OWN.get(address)) is not None:
            self._send(HTTPStatus.OK, own.read_bytes(), KINDS[own.suffix], content)
        elif address.startswith("/viewer/") and (program := viewer_file(address.removeprefix("/viewer/"))) is not None:
            self._send(HTTPStatus.OK, program, KINDS[Path(address).suffix], content, keep="max-age=3600")
        elif (path := file_of(self.store.folder, address)) is not None:
            self._send_file(path, content)
        else:
            self._send(HTTPStatus.NOT_FOUND, f"nothing at {address[:200]!r}\n".encode(), "text/plain; charset=utf-8", content)

    def _head(self, status: HTTPStatus, kind: str, length: int, policy: str, keep: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(length))
        self.send_header("Content-Security-Policy", policy)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Cache-Control", keep)
        self.end_headers()

    def _send(self, status: HTTPStatus, body: bytes, kind: str, content: bool, keep: str = "no-store") -> None:
        self._head(status, kind, len(body), OUR_POLICY, keep)
        if content:
            self.wfile.write(body)

    def _send_file(self, path: Path, content: bool) -> None:
        with path.open("rb") as file:
            self._head(HTTPStatus.OK, KINDS[path.suffix], path.stat().st_size, FILE_POLICY, "no-store")
            if content:
                shutil.copyfileobj(file, self.wfile)


def requests_to(store: Store) -> Any:
    """What a server calls for each connection."""
    return partial(Site, store)
