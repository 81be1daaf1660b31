"""What is sent back for a request: a status, headers that hold for every answer, and content of memory or of a file."""

from dataclasses import dataclass
from email.utils import formatdate
from http import HTTPStatus
from pathlib import Path

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
