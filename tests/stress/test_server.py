"""Hostile clients of `plumbline serve`: raw bytes, slow ones, many, and paths that would lead out of the folder."""

import contextlib
import os
import re
import resource
import select
import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.run_folder import write_run_folder
from tests.stress.ledger import Page
from tests.stress.served import BIG, FIRST, HOST, LONG, SECRET, SHORT, Served, everything, served_with


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = write_run_folder(tmp_path_factory.mktemp("server") / "run", only=("joint_pendulum",))
    report = made / "report"
    (report / "style").mkdir(parents=True)
    (made / "recordings").mkdir(exist_ok=True)
    (report / "index.html").write_text("<!doctype html><title>The report</title>")
    with (made / "recordings" / "big.rrd").open("wb") as big:
        big.truncate(BIG)
    outside = made.parent / "outside"
    outside.mkdir()
    for name in ("secret.html", "secret.json", ".hidden.html"):
        (outside / name).write_bytes(SECRET)
    (report / "secret").write_bytes(SECRET)
    (report / "secret.toml").write_bytes(SECRET)
    (report / ".hidden.html").write_bytes(SECRET)
    (report / "file.html").symlink_to(outside / "secret.html")
    (report / "folder").symlink_to(outside)
    (report / "up").symlink_to("..")
    (report / "round.html").symlink_to("round.html")
    (report / "dangling.html").symlink_to("nowhere.html")
    (report / "style" / "root").symlink_to("/")
    os.mkfifo(report / "pipe.html")
    (made / "catalogue.html").write_bytes(SECRET)
    return made


@pytest.fixture(scope="module")
def servers(folder: Path) -> Iterator[list[Served]]:
    with served_with(folder, LONG, SHORT) as started:
        yield started


@pytest.fixture(scope="module")
def served(servers: list[Served]) -> Served:
    return servers[0]


@pytest.fixture(scope="module")
def hasty(servers: list[Served]) -> Served:
    """A server that waits for nobody longer than a second."""
    return servers[1]


RAW = {
    "no host": (FIRST + b"\r\n", 400),
    "no host, in the older version": (b"GET / HTTP/1.0\r\n\r\n", 400),
    "an empty host": (FIRST + b"Host:\r\n\r\n", 403),
    "a second host, foreign": (FIRST + HOST + b"Host: evil.example\r\n\r\n", 400),
    "a second host, the same": (FIRST + HOST + HOST + b"\r\n", 400),
    "a second host before": (FIRST + b"Host: evil.example\r\n" + HOST + b"\r\n", 400),
    "two hosts in one header": (FIRST + b"Host: 127.0.0.1, evil.example\r\n\r\n", 403),
    "a foreign host (rebinding)": (FIRST + b"Host: evil.example\r\n\r\n", 403),
    "a foreign host with our port": (FIRST + b"Host: evil.example:8800\r\n\r\n", 403),
    "a foreign host that begins like ours": (FIRST + b"Host: 127.0.0.1.evil.example\r\n\r\n", 403),
    "a foreign host that ends like ours": (FIRST + b"Host: evil.localhost\r\n\r\n", 403),
    "our host with a port that is none": (FIRST + b"Host: 127.0.0.1:evil.example\r\n\r\n", 403),
    "our host with a user before": (FIRST + b"Host: localhost@evil.example\r\n\r\n", 403),
    "another address of this machine": (FIRST + b"Host: 0.0.0.0\r\n\r\n", 403),
    "a host folded over two lines": (FIRST + b"Host: 127.0.0.1\r\n .evil.example\r\n\r\n", 403),
    "a space before the colon": (FIRST + b"Host : 127.0.0.1\r\n\r\n", 400),
    "a whole address": (b"GET http://evil.example/ HTTP/1.1\r\n" + HOST + b"\r\n", 400),
    "a tunnel": (b"CONNECT evil.example:80 HTTP/1.1\r\n" + HOST + b"\r\n", 405),
    **{
        f"method {method}": (f"{method} /report/index.html HTTP/1.1\r\n".encode() + HOST + b"\r\n", 405)
        for method in ("POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "PROPFIND", "get", "GETGET")
    },
    "content with a question": (FIRST + HOST + b"Content-Length: 5\r\n\r\nhello", 400),
    "content in parts": (FIRST + HOST + b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400),
    "two lengths": (FIRST + HOST + b"Content-Length: 0\r\nContent-Length: 9\r\n\r\n", 400),
    "a negative length": (FIRST + HOST + b"Content-Length: -1\r\n\r\n", 400),
    "no version": (b"GET /report/index.html\r\n\r\n", 400),
    "a version to come": (b"GET / HTTP/9.9\r\n" + HOST + b"\r\n", 400),
    "a null byte in the address": (b"GET /\x00 HTTP/1.1\r\n" + HOST + b"\r\n", 400),
    "an escape in the address": (b"GET /\x1b[2J HTTP/1.1\r\n" + HOST + b"\r\n", 400),
    "bytes beyond ASCII in the address": (b"GET /\xff\xfe HTTP/1.1\r\n" + HOST + b"\r\n", 400),
    "a null byte in a header": (FIRST + HOST + b"X: a\x00b\r\n\r\n", 400),
    "a bare carriage return in a header": (FIRST + HOST + b"X: a\rHost: evil.example\r\n\r\n", 400),
    "a bare line feed in a header": (FIRST + HOST + b"X: a\nHost: evil.example\r\n\r\n", 400),
    "a header without a name": (FIRST + HOST + b": a\r\n\r\n", 400),
    "a header without a colon": (FIRST + HOST + b"nothing\r\n\r\n", 400),
    "nothing but an end": (b"\r\n\r\n", 400),
    "a greeting of TLS": (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 400),
    "noise": (bytes(range(256)) * 8 + b"\r\n\r\n", 400),
    "a thousand headers": (FIRST + HOST + b"X: a\r\n" * 1000 + b"\r\n", 431),
    "an address of 20 kB": (b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\n" + HOST + b"\r\n", 431),
    "a header of 20 kB": (FIRST + HOST + b"X: " + b"a" * 20_000 + b"\r\n\r\n", 431),
    "a head of 20 MB without an end": (FIRST + HOST + b"X: " + b"a" * 20_000_000, 431),
}


@pytest.mark.parametrize("name", RAW)
def test_a_request_that_is_not_plain_is_refused_and_the_next_is_answered(name: str, served: Served, ledger: Page) -> None:
    raw, status = RAW[name]
    with served.connect() as connection:
        with contextlib.suppress(ConnectionResetError, BrokenPipeError):
            connection.sendall(raw)
        answer = everything(connection)
    if len(raw) < 100_000:  # of what is longer, the rest may be cut off while it is still being sent
        assert answer.startswith(f"HTTP/1.1 {status} ".encode()), answer[:200]
        assert b"Content-Security-Policy: default-src 'none'; script-src 'none'" in answer
        assert len(re.findall(rb"^HTTP/1\.1 ", answer, re.MULTILINE)) == 1
    assert b"The report" not in answer
    served.is_well()
    ledger.survived("server", name, f"refused with {status}, the next answered")


OUT = [
    *("/../outside/secret.html", "/report/../../outside/secret.html", "/report/%2e%2e/%2e%2e/outside/secret.html"),
    *("/report/..%2f..%2foutside%2fsecret.html", "/report/%252e%252e/outside/secret.html", "/report/..%5c..%5coutside"),
    *("/report/....//....//outside/secret.html", "//etc/passwd", "/report//etc/passwd", "/report/%2fetc%2fpasswd"),
    *("/report/file.html", "/report/folder/secret.html", "/report/folder/secret.json", "/report/up/catalogue.html"),
    *("/report/round.html", "/report/dangling.html", "/report/pipe.html", "/report/style/root/etc/hostname"),
    *("/report/.hidden.html", "/report/secret", "/report/secret.toml", "/report/index.html%00.html", "/report/index.html/"),
    *("/report", "/report/", "/recordings/", "/journal.jsonl", "/trials.parquet", "/catalogue.json", "/catalogue.html"),
    *("/static/../site.py", "/static/%2e%2e/site.py", "/viewer/../site.py", "/viewer/", "/viewer/secret.html", "/view/"),
    *("/report/%ff%fe.html", "/report/%c0%ae%c0%ae/secret.html", "/report/" + "a/" * 3000 + "x.html", "/report/%0d%0aX:y.html"),
    *("/report/index.html;/../../outside/secret.html", "/report/~/secret.html", "/report/" + "a" * 5000 + ".html"),
]


@pytest.mark.parametrize("path", OUT, ids=lambda path: path[:60])
def test_no_path_leads_out_of_the_folder(path: str, served: Served, ledger: Page) -> None:
    answer = served.get(path)
    assert answer.startswith(b"HTTP/1.1 404 "), answer[:100]
    assert answer.count(b"\r\nX:y") == 0
    assert SECRET not in answer
    ledger.survived("server", f"path {path[:60]}", "404")


@pytest.mark.parametrize("where", ["report", "recordings"])
def test_an_open_folder_that_is_itself_a_link_opens_nothing(where: str, folder: Path, tmp_path: Path, ledger: Page) -> None:
    from plumbline.reports.server.site import file_of

    (tmp_path / where).symlink_to(folder.parent / "outside")
    assert file_of(tmp_path, f"/{where}/secret.html") is None
    assert file_of(folder, "/report/index.html") == (folder / "report" / "index.html").resolve()
    ledger.survived("server", f"the folder '{where}' is a link to elsewhere", "files opened 0")


PACE = 0.02
"""Seconds from one byte of a dripped head to the next."""


def drip(connections: list[socket.socket]) -> None:
    """One byte of a head from each; those that the server has closed are left."""
    for one in connections:
        with contextlib.suppress(OSError):
            one.send(b"a")
    time.sleep(PACE)


@pytest.fixture
def many_files() -> Iterator[None]:
    """Room for a thousand connections in this process."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, hard), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.usefixtures("many_files")
def test_five_hundred_that_never_end_their_head_do_not_stop_a_good_client(served: Served, ledger: Page) -> None:
    slow = [served.connect() for _ in range(500)]
    try:
        for one in slow:
            with contextlib.suppress(OSError):
                one.sendall(FIRST + HOST + b"X: ")
        for _ in range(20):
            drip(slow)
            served.is_well()
        taken = served.taken()
    finally:
        for one in slow:
            one.close()
    served.is_well()
    ledger.survived("server", "500 clients that never end their head", f"20 of 20 answered beside them, {taken}")


@pytest.mark.usefixtures("many_files")
def test_three_hundred_that_say_nothing_do_not_stop_a_good_client(served: Served, ledger: Page) -> None:
    silent = [served.connect() for _ in range(300)]
    try:
        for _ in range(20):
            served.is_well()
        taken = served.taken()
    finally:
        for one in silent:
            one.close()
    ledger.survived("server", "300 clients that say nothing", f"20 of 20 answered beside them, {taken}")


@pytest.mark.usefixtures("many_files")
def test_two_hundred_that_never_read_their_answer_do_not_stop_a_good_client(served: Served, ledger: Page) -> None:
    ask = f"GET /recordings/big.rrd HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\n\r\n".encode()
    deaf = [served.connect() for _ in range(200)]
    try:
        for one in deaf:
            with contextlib.suppress(OSError):
                one.sendall(ask)
        for _ in range(20):
            served.is_well()
        taken = served.taken()
    finally:
        for one in deaf:
            one.close()
    ledger.survived("server", "200 clients that never read 40 MB", f"20 of 20 answered beside them, {taken}")


def closed_by_the_server(connection: socket.socket, *, dripped: bool = False, seconds: float = 20.0) -> bool:
    """Does the server close the connection by itself, also while more of a head comes? What it says before is dropped."""
    until = time.monotonic() + seconds
    with contextlib.suppress(ConnectionResetError):
        while time.monotonic() < until:
            if dripped:
                drip([connection])
            if select.select([connection], [], [], 0.0 if dripped else 0.5)[0] and not connection.recv(2**16):
                return True
        return False
    return True


def test_a_head_that_does_not_end_in_time_is_told_so_and_closed(hasty: Served, ledger: Page) -> None:
    begun = {"nothing said": b"", "half a head": FIRST + HOST, "line feeds alone": b"GET / HTTP/1.1\n\n"}
    with contextlib.ExitStack() as opened:
        kept = {name: opened.enter_context(hasty.connect()) for name in begun}
        for name, connection in kept.items():
            connection.sendall(begun[name])
        assert closed_by_the_server(opened.enter_context(hasty.connect()), dripped=True)
        for name, connection in kept.items():
            assert everything(connection).startswith(b"HTTP/1.1 408 "), name
            ledger.survived("server", f"a head that does not end: {name}", "408, closed")
    ledger.survived("server", "a byte of a head every fiftieth of a second", "closed when the time of the whole head was over")


def test_an_answer_that_is_not_read_in_time_is_given_up(hasty: Served, ledger: Page) -> None:
    ask = f"GET /recordings/big.rrd HTTP/1.1\r\nHost: 127.0.0.1:{hasty.port}\r\n\r\n".encode()
    hasty.is_well()
    before = hasty.watched.num_fds()
    with hasty.connect() as connection:
        connection.sendall(ask)
        assert connection.recv(4).startswith(b"HTTP")
        for _ in range(200):
            if hasty.watched.num_fds() <= before:
                break
            time.sleep(0.1)
        assert hasty.watched.num_fds() <= before
    hasty.is_well()
    ledger.survived("server", "an answer that is never read", "given up, its file and its socket closed")


def test_a_client_that_does_not_close_is_closed(hasty: Served, ledger: Page) -> None:
    with hasty.connect() as connection:
        connection.sendall(FIRST + HOST + b"\r\n" + b"more " * 1000)
        assert closed_by_the_server(connection)
    ledger.survived("server", "a client that goes on after its answer", "one answer, closed")


def test_a_second_question_on_a_connection_is_not_answered(served: Served, ledger: Page) -> None:
    answer = served.ask((FIRST + HOST + b"\r\n") * 5)
    assert answer.count(b"HTTP/1.1 200 ") == 1
    assert b"Connection: close" in answer
    ledger.survived("server", "five questions at once on a connection", "one answer")


def test_clients_that_break_off_leave_nothing_behind(served: Served, ledger: Page) -> None:
    ask = f"GET /recordings/big.rrd HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\n\r\n".encode()
    served.is_well()
    for _ in range(200):
        connection = served.connect()
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        connection.sendall(ask)
        connection.close()  # with a reset
    for _ in range(100):
        served.is_well()
        if served.watched.num_fds() < 40:
            break
        time.sleep(0.1)
    assert served.watched.num_fds() < 40
    ledger.survived("server", "200 clients that break off with a reset", served.taken())


def test_a_client_that_ends_its_side_first_is_answered(served: Served, ledger: Page) -> None:
    with served.connect() as connection:
        connection.sendall(FIRST + HOST + b"\r\n")
        connection.shutdown(socket.SHUT_WR)
        assert everything(connection).endswith(b"The report</title>")
    ledger.survived("server", "a client that ends its side first", "answered whole")


def test_a_file_that_shrinks_while_it_is_sent_is_cut_and_one_that_grows_is_not_run_over(
    served: Served, folder: Path, ledger: Page
) -> None:
    path = folder / "recordings" / "changing.rrd"
    for name, size in (("shrinks", 0), ("grows", 2 * BIG)):
        with path.open("wb") as file:
            file.truncate(BIG)
        with served.connect() as connection:
            connection.sendall(b"GET /recordings/changing.rrd HTTP/1.1\r\n" + HOST + b"\r\n")
            first = connection.recv(2**16)
            os.truncate(path, size)
            head, _, body = (first + everything(connection)).partition(b"\r\n\r\n")
        assert int(re.search(rb"Content-Length: (\d+)", head)[1]) == BIG  # type: ignore[index]
        assert len(body) <= BIG
        assert (len(body) == BIG) == (name == "grows")
        served.is_well()
        ledger.survived("server", f"a file that {name} while it is sent", f"{len(body) / BIG:.0%} of its first length sent")


def test_a_page_that_cannot_be_made_is_said_so_in_text(folder: Path, tmp_path: Path, ledger: Page) -> None:
    import asyncio
    from concurrent.futures import ThreadPoolExecutor

    from plumbline.harness.store.store import Store
    from plumbline.reports.server import site
    from plumbline.reports.server.request import PageRequest

    hostile = site.Site(Store(folder))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(site, "front_page", lambda _store: 1 / 0)
        # In a thread: another test's browser may have left an event loop to this one.
        with ThreadPoolExecutor(1) as pool:
            answer = pool.submit(lambda: asyncio.run(hostile.answer(PageRequest("/", True)))).result()
    hostile.close()
    assert answer.status == 500
    assert answer.kind.startswith("text/plain")
    assert b"ZeroDivisionError" in answer.content  # type: ignore[operator]
    ledger.survived("server", "a page that cannot be made", "500 in plain text")
