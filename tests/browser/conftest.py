"""What the tests of pages share: one browser, and visits to pages that keep all that a page said."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

__all__ = ["CHROMIUM", "Visit"]

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))),
    os.environ.get("PLUMBLINE_CHROMIUM"),
)


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
    """A browser for pages from disk; each visit has a context of its own."""
    chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
    yield chromium
    chromium.close()


class Visit:
    """A page that is open, and all that it said or asked for."""

    def __init__(self, browser: Any, path: Path, **context: Any) -> None:
        self.page = browser.new_context(**{"viewport": {"width": 1280, "height": 900}} | context).new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("dialog", lambda dialog: (self.said.append("dialog"), dialog.dismiss()))
        self.page.goto(path.as_uri())
        if context.get("java_script_enabled", True):
            self.page.wait_for_function(
                "() => [...document.querySelectorAll('figure.chart')].every(one => one.dataset.drawn || !one.clientWidth)",
                timeout=60_000,
            )

    def close(self) -> None:
        self.page.context.close()


@pytest.fixture
def visit(browser: Any) -> Iterator[Any]:
    """Open a page, and close it after the test."""
    opened: list[Visit] = []

    def go(path: Path, **context: Any) -> Visit:
        opened.append(Visit(browser, path, **context))
        return opened[-1]

    yield go
    for one in opened:
        one.close()
