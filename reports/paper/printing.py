"""The report of a run folder as one PDF, printed by a browser of this machine."""

import os
import shutil
import subprocess
from pathlib import Path
from typing import ClassVar, Literal

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.store.disk import put_in_place
from plumbline.harness.store.store import Store
from plumbline.reports.html.policy import guarded
from plumbline.reports.page import pages
from plumbline.reports.paper.one_page import Sheet, joined
from plumbline.reports.words.citation import citation

VARIABLE = "PLUMBLINE_CHROMIUM"
NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
    "chromium-headless-shell",
)
LONGEST = 600.0
"""Seconds that a browser may take."""


class NotPrinted(PlumblineError):
    """There is no PDF: no browser, or one that failed; the message says what to do."""

    lies_in: ClassVar[Literal["usage", "machine"]] = "machine"


def browser() -> str:
    """The program that prints: `$PLUMBLINE_CHROMIUM`, else a browser of the Chromium family on the path. Raises: NotPrinted."""
    if named := os.environ.get(VARIABLE):
        if path := shutil.which(named):
            return path
        raise NotPrinted(f"${VARIABLE} is {named!r}, which is no program")
    for name in NAMES:
        if path := shutil.which(name):
            return path
    raise NotPrinted(
        f"no browser that prints to PDF: install Chromium, Chrome or Edge, or set {VARIABLE} to one; "
        "any browser prints a single page of the report"
    )


def _order(report: Path) -> list[Path]:
    """The pages as the navigation has them, then the others by name: those of cases and engines."""
    places = {f"{page.name}.html": place for place, page in enumerate(pages())}
    files = [path for path in report.glob("*.html") if not path.name.startswith(".")]
    return sorted(files, key=lambda path: (places.get(path.name, len(places)), path.name))


def print_report(store: Store, report: Path, out: Path) -> Path:
    """Write the PDF of the pages in `report`; returns its path. Raises: NotPrinted, OSError."""
    program, report = browser(), report.resolve()  # a browser takes addresses from the root alone
    sheets = [Sheet(path.stem, path.read_text(encoding="utf-8")) for path in _order(report)]
    title = f"Plumbline: {store.study.get('title') or store.study.get('name') or 'report'}"
    page, profile = report / f".print.{os.getpid()}.html", report / f".print.{os.getpid()}"
    draft = report / f".print.{os.getpid()}.pdf"
    try:
        page.write_text(guarded(joined(sheets, title, citation(store))), encoding="utf-8", errors="backslashreplace")
        command = [program, "--headless", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
        command += [f"--user-data-dir={profile}", "--no-pdf-header-footer", "--generate-pdf-document-outline"]
        # A browser of the super-user, as in containers, starts without its sandbox alone; the page runs no script.
        command += ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        done = subprocess.run(
            [*command, f"--print-to-pdf={draft}", page.as_uri()],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=LONGEST,
            check=False,
        )
        if done.returncode or not draft.is_file():
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise NotPrinted(f"{program} ended with exit code {done.returncode} and no PDF: {said[-1] if said else 'no word'}")
        out.parent.mkdir(parents=True, exist_ok=True)
        put_in_place(draft, out)
    except subprocess.TimeoutExpired:
        raise NotPrinted(f"{program} took longer than {LONGEST:.0f} s") from None
    finally:
        page.unlink(missing_ok=True)
        draft.unlink(missing_ok=True)
        shutil.rmtree(profile, ignore_errors=True)
    return out
