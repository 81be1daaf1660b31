"""Pictures of pages for the README and the docs: each page of a report as a person meets it, narrow and dark as well.

Usage: python docs/screenshots.py REPORT CHANGES [--case NAME] [--out docs/pictures], with the folders that hold index.html and
what-changed.html. Needs playwright and Chromium, both of which the browser tests use.
"""

import argparse
import io
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

__all__ = ["main"]

WIDE, NARROW = (1280, 860), (390, 844)
SCALE = 0.8
"""Of a wide picture, and QUALITY of its WebP: a README has to come quickly."""
QUALITY = 78


def pages(report: Path, changes: Path, case: str | None) -> Iterator[tuple[str, Path, str]]:
    """Name, file and the element that a picture begins with, of each page. Raises: SystemExit, where one is not there."""
    cases = sorted(report.glob("case-*.html"))
    chosen = report / f"case-{case}.html" if case else max(cases, key=lambda path: path.read_text("utf-8").count("pictures/"))
    for name, path, element in (
        ("front", report / "index.html", "body"),
        ("price", report / "price.html", "body"),
        ("case", chosen, "body"),
        ("selection", report / "select.html", "body"),
        ("changes", changes / "what-changed.html", "body"),
    ):
        if not path.is_file():
            raise SystemExit(
                f"{path}: missing, expected the page of the picture '{name}'; REPORT is of a run clocked at several steps"
            )
        yield name, path, element


def taken(browser: Any, path: Path, element: str, size: tuple[int, int], scheme: str) -> Image.Image:
    """A picture of the first screen of a page, its charts drawn. Raises: RuntimeError, where the page complained."""
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(path.resolve().as_uri())
    page.evaluate("for (const image of document.images) image.loading = 'eager'")
    page.wait_for_function("() => [...document.images].every((image) => image.complete)")
    # A chart in a closed fold is drawn when somebody opens it.
    charts = "[...document.querySelectorAll('figure.chart')].filter((figure) => figure.clientWidth > 0)"
    page.wait_for_function(f"() => {charts}.every((figure) => figure.dataset.drawn)")
    page.locator(element).first.scroll_into_view_if_needed()
    content = page.screenshot()
    context.close()
    if complaints:
        raise RuntimeError(f"{path}: {complaints[0]}")
    return Image.open(io.BytesIO(content)).convert("RGB")


def main() -> None:
    """Write <name>.webp, wide and light, and <name>-phone.webp, narrow and dark, of every page."""
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", type=Path)
    parser.add_argument("changes", type=Path)
    parser.add_argument("--case")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "pictures")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    found = next(
        (path for name in ("chromium-headless-shell", "chromium", "google-chrome") if (path := shutil.which(name))),
        os.environ.get("PLUMBLINE_CHROMIUM"),
    )
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--headless", "--no-sandbox", "--disable-gpu"])
        for name, path, element in pages(asked.report, asked.changes, asked.case):
            for mark, size, scheme in (("", WIDE, "light"), ("-dark", WIDE, "dark"), ("-phone", NARROW, "dark")):
                picture = taken(browser, path, element, size, scheme)
                if size == WIDE:
                    picture = picture.resize((round(SCALE * size[0]), round(SCALE * size[1])), Image.Resampling.LANCZOS)
                picture.save(asked.out / f"{name}{mark}.webp", quality=QUALITY, method=6)
        browser.close()


if __name__ == "__main__":
    main()
