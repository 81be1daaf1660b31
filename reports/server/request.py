"""The head of a request, read as a stranger's: whatever is not plainly a question for a file of this machine is refused."""

import re
from dataclasses import dataclass
from http import HTTPStatus

__all__ = ["Refused", "Request", "read_head"]

MOST_HEADERS = 64
METHODS = ("GET", "HEAD")

_FIRST = re.compile(r"([A-Za-z]{1,32}) ([!-~]+) HTTP/1\.[01]")
_HEADER = re.compile(r"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([\t -~\x80-\xff]*)")
_HERE = re.compile(r"(127\.0\.0\.1|localhost)(:\d{1,5})?", re.IGNORECASE)
"""The names of this machine; any port, since a tunnel may have another."""


class Refused(Exception):
    """A request that is not answered; the text says why."""

    def __init__(self, status: HTTPStatus, why: str) -> None:
        super().__init__(why)
        self.status = status


@dataclass(frozen=True, slots=True)
class Request:
    """A question. Terms: address: the path as it came, without what follows a '?'. content: is more than the head asked for?"""

    address: str
    content: bool


def read_head(head: bytes) -> Request:
    """The request that a head asks for.

    Args: head: the first line and the headers, each ended by CR LF.
    Raises: Refused.
    """
    first, *lines = head.decode("latin-1").removesuffix("\r\n\r\n").split("\r\n")
    asked = _FIRST.fullmatch(first)
    if asked is None:
        raise Refused(HTTPStatus.BAD_REQUEST, "expected a request of HTTP/1.1")
    if asked[1] not in METHODS:
        raise Refused(HTTPStatus.METHOD_NOT_ALLOWED, f"expected {' or '.join(METHODS)}")
    if len(lines) > MOST_HEADERS:
        raise Refused(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"expected at most {MOST_HEADERS} headers")
    headers: dict[str, list[str]] = {}
    for line in lines:
        header = _HEADER.fullmatch(line)
        if header is None:
            raise Refused(HTTPStatus.BAD_REQUEST, "expected headers, each on a line")
        headers.setdefault(header[1].lower(), []).append(header[2].strip())
    hosts = headers.get("host", [])
    if len(hosts) != 1:
        raise Refused(HTTPStatus.BAD_REQUEST, f"{len(hosts)} headers 'Host', expected one")
    # A page of another site whose name was made to point at this machine (DNS rebinding) sends its own name.
    if not _HERE.fullmatch(hosts[0]):
        raise Refused(HTTPStatus.FORBIDDEN, "expected the host 127.0.0.1")
    if "transfer-encoding" in headers or headers.get("content-length", ["0"]) != ["0"]:
        raise Refused(HTTPStatus.BAD_REQUEST, "expected a request without content")
    if not asked[2].startswith("/"):
        raise Refused(HTTPStatus.BAD_REQUEST, "expected an address that begins with '/'")
    return Request(re.split("[?#]", asked[2], maxsplit=1)[0], asked[1] == "GET")
