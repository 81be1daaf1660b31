"""The head of a request, read as a stranger's: whatever is not plainly a question for a file of this machine is refused.

What is sent back for a request: a status, headers that hold for every answer, and content of memory or of a file.
"""

import re
from dataclasses import dataclass
from email.utils import formatdate
from http import HTTPStatus
from pathlib import Path

import h11

from plumbline.reports.html.policy import DATA

PLAIN = "text/plain; charset=utf-8"


@dataclass(frozen=True, slots=True)
class Response:
    """Terms: kind: of the content. content: the bytes, or the file that holds them. policy: what a browser may do with it.
    keep: how long it may be kept.
    """

    status: HTTPStatus
    kind: str
    content: bytes | Path
    policy: str = DATA
    keep: str = "no-store"

    def head(self, length: int) -> bytes:
        """The first line and the headers, for content of so many bytes."""
        lines = [
            f"HTTP/1.1 {self.status.value} {self.status.phrase}",
            f"Date: {formatdate(usegmt=True)}",
            f"Content-Type: {self.kind}",
            f"Content-Length: {length}",
            f"Content-Security-Policy: {self.policy}",
            "X-Content-Type-Options: nosniff",
            "Referrer-Policy: no-referrer",
            "Cross-Origin-Resource-Policy: same-origin",
            f"Cache-Control: {self.keep}",
            "Connection: close",
        ]
        if self.status == HTTPStatus.METHOD_NOT_ALLOWED:
            lines.append("Allow: GET, HEAD")
        return "".join(f"{line}\r\n" for line in (*lines, "")).encode("ascii")


def text(status: HTTPStatus, line: str) -> Response:
    """A line of text."""
    return Response(status, PLAIN, f"{line}\n".encode())


MOST_HEADERS = 64
METHODS = ("GET", "HEAD")
VERSIONS = (b"1.0", b"1.1")

_HERE = re.compile(r"(127\.0\.0\.1|localhost)(:\d{1,5})?", re.IGNORECASE)
"""The names of this machine; any port, since a tunnel may have another."""


class Refused(Exception):
    """A request that is not answered; the text says why."""

    def __init__(self, status: HTTPStatus, why: str) -> None:
        super().__init__(why)
        self.status = status


@dataclass(frozen=True, slots=True)
class PageRequest:
    """A question. Terms: address: the path as it came, without what follows a '?'. content: is more than the head asked for?"""

    address: str
    content: bool


def read_head(head: bytes) -> PageRequest:
    """The request that a head asks for.

    Args: head: the first line and the headers, each ended by CR LF.
    Raises: Refused.
    """
    reader = h11.Connection(h11.SERVER, max_incomplete_event_size=len(head))
    reader.receive_data(head)
    try:
        asked = reader.next_event()
    except h11.RemoteProtocolError as error:
        raise Refused(HTTPStatus.BAD_REQUEST, f"expected a request of HTTP/1.1: {error}") from error
    if not isinstance(asked, h11.Request) or asked.http_version not in VERSIONS:
        raise Refused(HTTPStatus.BAD_REQUEST, "expected a request of HTTP/1.1")
    method, address = asked.method.decode("latin-1"), asked.target.decode("latin-1")
    if method not in METHODS:
        raise Refused(HTTPStatus.METHOD_NOT_ALLOWED, f"expected {' or '.join(METHODS)}")
    if len(asked.headers) > MOST_HEADERS:
        raise Refused(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"expected at most {MOST_HEADERS} headers")
    headers: dict[str, list[str]] = {}
    for name, value in asked.headers:
        headers.setdefault(name.decode("latin-1"), []).append(value.decode("latin-1"))
    hosts = headers.get("host", [])
    if len(hosts) != 1:
        raise Refused(HTTPStatus.BAD_REQUEST, f"{len(hosts)} headers 'Host', expected one")
    # A page of another site whose name was made to point at this machine (DNS rebinding) sends its own name.
    if not _HERE.fullmatch(hosts[0]):
        raise Refused(HTTPStatus.FORBIDDEN, "expected the host 127.0.0.1")
    if "transfer-encoding" in headers or headers.get("content-length", ["0"]) != ["0"]:
        raise Refused(HTTPStatus.BAD_REQUEST, "expected a request without content")
    if not address.startswith("/"):
        raise Refused(HTTPStatus.BAD_REQUEST, "expected an address that begins with '/'")
    return PageRequest(re.split("[?#]", address, maxsplit=1)[0], method == "GET")
