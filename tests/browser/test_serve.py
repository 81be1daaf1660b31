"""The loopback server: what it gives, what it refuses, and that a browser can watch a recording without a network."""

import http.client
import io
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from plumbline.reports.charts.marks import ENGINES
from plumbline.reports.html.report import write_report
from tests.browser.conftest import CHROMIUM, QUIET
from tests.recorded_folder import Folder, record, rising, zoo

# WebGL in software: the viewer draws with it, and a machine for tests has no graphics card.
FLAGS = (*QUIET, "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = Folder(tmp_path_factory.mktemp("serve") / "run")
    scene = zoo()
    made.add(record("rise", "mujoco"), scene, rising(scene, 2.0), rising(scene))
    made.add(record("<script>window.attacked=1</script>", "dart", status="crashed", reason="gone"))
    made.write(rise={"title": "Bodies that rise", "dt": 0.01})
    write_report(made.path)
    (made.path.parent / "secret.html").write_text("secret")
    (made.path / "report" / ".hidden.html").write_text("secret")
    (made.path / "report" / "way_out.html").symlink_to(made.path.parent / "secret.html")
    return made.path


class Served:
    """A server in a process of its own, as a person starts it."""

    def __init__(self, folder: Path, first: Sequence[str] = ()) -> None:
        command = [*first, sys.executable, "-m", "plumbline", "serve", str(folder), "--port", "0"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        self.port = int(self.address.rstrip("/").rsplit(":", 1)[1])

    def ask(self, path: str, method: str = "GET", host: str | None = None) -> tuple[http.client.HTTPResponse, bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        connection.putrequest(method, path, skip_host=True)
        connection.putheader("Host", host or f"127.0.0.1:{self.port}")
        connection.putheader("Connection", "close")
        connection.endheaders()
        answer = connection.getresponse()
        return answer, answer.read()

    def interrupt(self, by: signal.Signals = signal.SIGINT) -> int:
        self.process.send_signal(by)
        self.process.communicate(timeout=60)
        return self.process.returncode


@pytest.fixture(scope="module")
def served(folder: Path) -> Iterator[Served]:
    server = Served(folder)
    yield server
    if server.process.poll() is None:
        server.interrupt()


IN_THE_BACKGROUND = ("bash", "-c", 'trap "" INT; exec "$@"', "bash")
"""As a shell without job control starts what is to run in the background: it ignores an interrupt."""


STOPS = [
    pytest.param(IN_THE_BACKGROUND, signal.SIGINT, id="interrupted in the background"),
    pytest.param((), signal.SIGINT, id="interrupted in front", marks=pytest.mark.slow),
    pytest.param(IN_THE_BACKGROUND, signal.SIGTERM, id="terminated in the background", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("first", "by"), STOPS)
def test_a_request_to_stop_stops_the_server_and_frees_its_port(folder: Path, first: Sequence[str], by: signal.Signals) -> None:
    server = Served(folder, first)
    assert server.ask("/")[0].status == 200
    assert server.interrupt(by) in {0, 130}
    with pytest.raises(ConnectionRefusedError):
        server.ask("/")


def test_only_loopback_is_listened_to(served: Served) -> None:
    assert served.address == f"http://127.0.0.1:{served.port}/"
    with socket.socket() as other, pytest.raises(OSError, match=r"refused|unreachable|assign"):
        # Another address of this machine's own network: a server on all interfaces would answer there.
        other.connect(("127.0.0.2", served.port))


def test_report_recordings_and_the_viewer_are_given_as_what_they_are(served: Served, folder: Path) -> None:
    for path, kind, content in (
        ("/report/index.html", "text/html", (folder / "report" / "index.html").read_bytes()),
        ("/recordings/rise.rrd", "application/octet-stream", (folder / "recordings" / "rise.rrd").read_bytes()),
        ("/viewer/re_viewer_bg.wasm", "application/wasm", None),
        ("/viewer/re_viewer.js", "text/javascript", None),
    ):
        answer, body = served.ask(path)
        assert answer.status == 200, path
        assert answer.headers["Content-Type"].startswith(kind), path
        assert content is None or body == content, path
        if path.endswith(".wasm"):
            assert body.startswith(b"\0asm")


def test_a_question_for_the_head_is_answered_without_the_body(served: Served, folder: Path) -> None:
    answer, body = served.ask("/recordings/rise.rrd", method="HEAD")
    assert answer.status == 200
    assert int(answer.headers["Content-Length"]) == (folder / "recordings" / "rise.rrd").stat().st_size
    assert body == b""


@pytest.mark.parametrize(
    "path",
    [
        "/../secret.html",
        "/report/../../secret.html",
        "/report/%2e%2e/%2e%2e/secret.html",
        "/report/..%2f..%2fsecret.html",
        "/report//../../secret.html",
        "/report/%2fetc/passwd",
        "//etc/passwd",
        "/report/way_out.html",
        "/report/.hidden.html",
        "/report/%00index.html",
        "/report/",
        "/report",
        "/recordings/",
        "/journal.jsonl",
        "/catalogue.json",
        "/trajectories/",
        "/static/../site.py",
        "/viewer/../../viewer.py",
        "/report/" + "a" * 5000 + ".html",
    ],
)
def test_nothing_outside_of_report_and_recordings_is_given(served: Served, path: str) -> None:
    answer, body = served.ask(path)
    assert answer.status == 404
    assert b"secret" not in body.replace(path.encode(), b"")
    assert b"journal" not in body.replace(path.encode(), b"")


def test_a_page_under_another_name_of_this_machine_gets_nothing(served: Served) -> None:
    assert served.ask("/report/index.html", host="evil.example:80")[0].status == 403
    assert served.ask("/report/index.html", host=f"localhost:{served.port}")[0].status == 200


def test_nothing_can_be_written(served: Served) -> None:
    for method in ("POST", "PUT", "DELETE"):
        answer, _ = served.ask("/recordings/rise.rrd", method=method)
        assert answer.status == 405
        assert answer.headers["Allow"] == "GET, HEAD"


@pytest.mark.parametrize(
    ("path", "method", "status"),
    [
        ("/", "GET", 200),
        ("/view?recording=/recordings/rise.rrd", "GET", 200),
        ("/report/index.html", "GET", 200),
        ("/report/index.html", "HEAD", 200),
        ("/report/style/report.js", "GET", 200),
        ("/nowhere", "GET", 404),
        ("/", "POST", 405),
    ],
)
def test_every_answer_says_whose_scripts_run_and_forbids_connections_to_elsewhere(
    served: Served, path: str, method: str, status: int
) -> None:
    answer, _ = served.ask(path, method)
    assert answer.status == status
    rules = dict(rule.strip().split(" ", 1) for rule in answer.headers["Content-Security-Policy"].split(";"))
    assert set(rules["script-src"].split()) <= {"'self'", "'none'", "'wasm-unsafe-eval'"}
    assert rules["connect-src"] in ("'self'", "'none'")
    assert rules["default-src"] == "'none'"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"


@pytest.fixture(scope="module")
def browser(playwright: Any) -> Iterator[Any]:
    """One with WebGL."""
    chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS])
    yield chromium
    chromium.close()


# The viewer's compiler of shaders tells the console 9000 times what it does, and each line goes through three processes.
# Here only warnings and errors are told, and no more than five pictures are drawn a second.
SPARING = """
for (const told of ["debug", "info", "log", "trace"]) console[told] = () => {};
const draw = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (frame) => setTimeout(() => draw(frame), 200);
"""


class Visit:
    """A page that is open, what it asked for and what went wrong."""

    def __init__(self, browser: Any, address: str) -> None:
        # Small: what the viewer draws is drawn by the processor, point by point.
        self.page = browser.new_page(viewport={"width": 320, "height": 240})
        self.page.add_init_script(SPARING)
        self.asked: list[str] = []
        self.errors: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)
        self.page.goto(address)


@pytest.fixture
def visit(browser: Any) -> Iterator[Callable[[str], Visit]]:
    """Open an address; what is open is closed behind the test, since a viewer that nobody looks at goes on drawing."""
    opened: list[Visit] = []

    def go(address: str) -> Visit:
        opened.append(Visit(browser, address))
        return opened[-1]

    yield go
    for one in opened:
        one.page.close()


@pytest.mark.browser
def test_the_first_page_leads_to_the_report_and_to_each_recording(visit: Callable[[str], Visit], served: Served) -> None:
    first = visit(served.address)
    links = first.page.eval_on_selector_all("a", "all => all.map(a => a.getAttribute('href'))")
    assert "/report/index.html" in links
    assert "/view?recording=/recordings/rise.rrd" in links
    for link in links:
        assert served.ask(link)[0].status == 200, link
    assert first.page.evaluate("window.attacked") is None
    first.page.click("text=Read the report")
    first.page.wait_for_url("**/report/index.html")
    assert first.page.title()
    assert not first.errors


@pytest.mark.browser
def test_watch_on_the_page_of_a_case_shows_its_moment_in_the_viewer_and_nobody_else_is_asked(
    visit: Callable[[str], Visit], served: Served
) -> None:
    seen = visit(f"{served.address}report/case-rise.html")
    watch = seen.page.locator("#happened a.watch")
    # The run rises twice as fast as the truth, so that it is farthest off where it ends.
    assert watch.inner_text() == "▶ Watch at 0.1 s"
    watch.click()
    seen.page.wait_for_url("**/view?recording=/recordings/rise.rrd&at=0.100000")
    seen.page.wait_for_selector("#state", state="hidden", timeout=200_000)
    # The engine's own colour is on the screen once the viewer has drawn what the recording holds.
    for _ in range(100):
        picture = seen.page.screenshot(timeout=120_000)
        if shows(picture, ENGINES["mujoco"].colour):
            break
        seen.page.wait_for_timeout(300)
    assert shows(picture, ENGINES["mujoco"].colour)
    assert f"{served.address}moment/0.100000/rise.rrd" in seen.asked
    outside = [url for url in seen.asked if not url.startswith((served.address, "data:", "blob:"))]
    assert not outside
    assert not seen.errors


def shows(png: bytes, colour: str) -> bool:
    """Is a colour, '#rrggbb', among those of a picture?"""
    listed: Any = Image.open(io.BytesIO(png)).convert("RGB").getcolors(maxcolors=1 << 24)
    wanted = tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return any(found == wanted for _, found in listed)


@pytest.mark.browser
@pytest.mark.parametrize("asked", ["https://example.org/x.rrd", "//example.org/x.rrd", "/report/index.html", ""])
def test_the_viewer_takes_recordings_of_this_server_only(visit: Callable[[str], Visit], served: Served, asked: str) -> None:
    seen = visit(f"{served.address}view?recording={asked}")
    seen.page.wait_for_selector("text=names no recording of this server", timeout=60_000)
    assert not [url for url in seen.asked if "example.org" in url.split("view?")[0]]


def test_a_server_that_has_answered_all_this_is_terminated_in_front(served: Served) -> None:
    """The last test of this file: those above are answered by the server that it stops."""
    assert served.ask("/")[0].status == 200
    assert served.interrupt(signal.SIGTERM) in {0, 130}
    with pytest.raises(ConnectionRefusedError):
        served.ask("/")
