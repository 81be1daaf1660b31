"""Can every page of every study's report be read, on a wide screen and on a phone, light and dark? One visit asks all."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.study import study
from tests.browser.audit import faults
from tests.small_studies import STUDIES, report_of

pytestmark = pytest.mark.browser

SCREENS = [(1440, "light"), (1440, "dark"), (390, "light"), (390, "dark")]
FIRST = [("quick", 1440, "light", ("index",)), ("quick", 390, "dark", ("case-stack_tower",))]
"""A part of the lattice for every day: the pages with most on them."""


@pytest.fixture(scope="session")
def axe() -> str:
    """The source of axe-core."""
    package = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed: no page is checked")
    source: str = (Path(package.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
    return source


def carried_out(path: Path, out: Path, *more: str) -> Path:
    command = [sys.executable, "-m", "plumbline", "run", str(path), "--out", str(out), *more]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="session")
def reports_made(tmp_path_factory: pytest.TempPathFactory, plain: Path) -> Callable[[str], Path]:
    """The report of a study, made once in a session."""
    made = {"quick": plain}

    def report(kind: str) -> Path:
        if kind not in made:
            made[kind] = report_of(kind, tmp_path_factory.mktemp("study"), carried_out)
        return made[kind]

    return report


@pytest.fixture
def wrong(visit: Any, axe: str) -> Callable[..., list[str]]:
    """What is wrong with a page on a screen of a width in a scheme."""

    def ask(path: Path, width: int, scheme: str, *, whole: bool = True) -> list[str]:
        seen = visit(path, color_scheme=scheme, viewport={"width": width, "height": 900})
        return faults(seen, path, axe, phone=width < 640, whole=whole)

    return ask


@pytest.mark.parametrize(("kind", "width", "scheme", "names"), FIRST)
def test_the_fullest_pages_can_be_read(
    reports_made: Callable[[str], Path], wrong: Any, kind: str, width: int, scheme: str, names: tuple[str, ...]
) -> None:
    found = {name: wrong(reports_made(kind) / f"{name}.html", width, scheme, whole=False) for name in names}
    assert found == {name: [] for name in names}


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), SCREENS)
@pytest.mark.parametrize("kind", STUDIES)
def test_every_page_of_every_study_can_be_read(
    reports_made: Callable[[str], Path], wrong: Any, kind: str, width: int, scheme: str
) -> None:
    pages = sorted(reports_made(kind).glob("*.html"))
    assert len(pages) >= 3
    assert {page.name: said for page in pages if (said := wrong(page, width, scheme))} == {}


def test_the_studies_that_are_looked_at_are_those_there_are() -> None:
    alike = {
        "accuracy": "quick",
        "price": "quick",
        "nightly": "quick",
        "uneven_steps": "quick",
        "level_of_detail": "scaling",
        "throughput": "scaling",
    }
    named = {path.stem for path in (Path(study.__file__).parent / "built_in").glob("*.toml")}
    assert {alike.get(name, name) for name in named} <= set(STUDIES)
