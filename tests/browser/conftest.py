"""What the tests of pages share: one browser, one page that all visits take in turn, what each heard, and one report."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from plumbline.reports.html import report as html
from plumbline.reports.html.report import write_report
from plumbline.reports.page import pages
from tests.small_studies import WRITTEN

__all__ = ["CHROMIUM", "QUIET", "Visit", "page_of", "width_on"]

NOT_NEEDED = (
    "AimEnabled",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "PreloadTopChromeWebUI",
    "SpareRendererForSitePerProcess",
    "WebUIOmniboxAimPopup",
    "WebUIOmniboxFullPopup",
    "WebUIOmniboxPopup",
)
"""Features of a person's browser: what asks the network, and what keeps processes ready or draws windows that nobody sees here.

Of several lists Chromium heeds the last, so that those which playwright turns off are named again.
"""
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    f"--disable-features={','.join(NOT_NEEDED)}",
)
NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""Programs that drive as one; the first has no windows to draw, and takes two thirds of the others' time of the processor."""
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name))), os.environ.get("PLUMBLINE_CHROMIUM"))
SCREEN = {"width": 1280, "height": 900}
DARK = "() => matchMedia('(prefers-color-scheme: dark)').matches"


@pytest.fixture(scope="package")
def playwright() -> Iterator[Any]:
    """What starts browsers; no other event loop can run beside it in a process, so that it goes when these tests are over."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: no browser is driven")
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine (apt-get install chromium, or PLUMBLINE_CHROMIUM=path)")
    with sync_api.sync_playwright() as started:
        yield started


@pytest.fixture(scope="package")
def browser(playwright: Any) -> Iterator[Any]:
    """A browser for pages from disk."""
    chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=[*QUIET, "--disable-gpu"])
    yield chromium
    chromium.close()


@pytest.fixture(scope="package")
def tab(browser: Any) -> Any:
    """The page that visits take in turn: one of its own costs a window, a process, and every script compiled anew."""
    return browser.new_context(viewport=SCREEN).new_page()


class Visit:
    """A page that is open, and all that it said or asked for; it starts with nothing stored, on a screen like any other's."""

    def __init__(self, page: Any, path: Path, *, color_scheme: str = "light", viewport: Mapping[str, int] = SCREEN) -> None:
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        self._heard: dict[str, Callable[[Any], None]] = {
            "console": lambda message: self.said.append(f"{message.type}: {message.text}"),
            "pageerror": lambda error: self.said.append(f"error: {error}"),
            "request": lambda request: self.asked.append(request.url),
            "dialog": lambda dialog: (self.said.append("dialog"), dialog.dismiss()),
        }
        if page.viewport_size != viewport or page.evaluate(DARK) != (color_scheme == "dark"):
            page.goto("about:blank")  # the page before would draw its charts anew for the next one's screen
        for event, hear in self._heard.items():
            page.on(event, hear)
        page.emulate_media(color_scheme=color_scheme, media="screen")
        page.set_viewport_size(viewport)
        page.goto(path.as_uri())
        page.wait_for_function(
            "() => [...document.querySelectorAll('figure.chart')].every(one => one.dataset.drawn || !one.clientWidth)",
            polling=25,  # a question at each frame would have each frame drawn
            timeout=60_000,
        )

    def close(self) -> None:
        """Leave the page, and nothing in it for the next."""
        for event, hear in self._heard.items():
            self.page.remove_listener(event, hear)
        self.page.mouse.move(0, 0)
        self.page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")


@pytest.fixture
def visit(tab: Any) -> Iterator[Any]:
    """Open a page, in place of the one before."""
    opened: list[Visit] = []

    def go(path: Path, **screen: Any) -> Visit:
        if opened:
            opened.pop().close()
        opened.append(Visit(tab, path, **screen))
        return opened[-1]

    yield go
    for one in opened:
        one.close()


@pytest.fixture
def look(tab: Any) -> Callable[[Path], Any]:
    """Open a page, or take it as it stands open: whoever does not turn it back says so, and it is opened for the next."""

    def at(path: Path, *, turned_back: bool = True) -> Any:
        if tab.evaluate("window.lookedAt") != path.as_uri():
            Visit(tab, path).close()
        tab.evaluate("address => { window.lookedAt = address; }", path.as_uri() if turned_back else "")
        return tab

    return at


FITS = """() => [...document.querySelectorAll('figure.chart')].every((figure) => {
  const chart = figure.querySelector('.plot svg.marks');
  return !chart || chart.getBoundingClientRect().right <= figure.getBoundingClientRect().right + 1;
})"""


def width_on(page: Any, wide: int) -> int:
    """How wide an open page is on a screen of a width, both in px, once its charts are drawn for that. Raises: TimeoutError."""
    page.set_viewport_size({"width": wide, "height": 844})
    page.wait_for_function(FITS, polling=25, timeout=10_000)
    width: int = page.evaluate("document.documentElement.scrollWidth")
    return width


def page_of(folder: Path, name: str) -> Path:
    """A page as it stands in the report of a run folder; the pages and pictures beside it are not made."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(html, "pages", lambda: tuple(one for one in pages() if one.name == name))
        return write_report(folder).index.with_name(f"{name}.html")


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of the quick study, which is only read."""
    return write_report(WRITTEN["quick"](tmp_path_factory.mktemp("plain") / "run")).index.parent
