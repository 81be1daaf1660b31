"""Legends of charts that are half as wide as a page: in one line, with a switch for whatever has a look of its own."""

from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import page_of
from tests.settings_folder import ONE, SEVERAL, write_settings_folder

pytestmark = pytest.mark.browser

WIDE = {"width": 1440, "height": 900}
MARKS = "#overview-error .plot svg .mark-symbol path[aria-label]"
LINES = """() => [...document.querySelectorAll('.switches')].map(
    (strip) => new Set([...strip.children].filter((one) => one.checkVisibility()).map((one) => one.offsetTop)).size)"""


@pytest.mark.parametrize(
    ("settings", "third"),
    [
        pytest.param((), "", marks=pytest.mark.slow),
        (ONE, "default with solver cg, tolerance 10⁻⁵"),
        pytest.param(SEVERAL, "others", marks=pytest.mark.slow),
    ],
)
def test_the_legend_is_one_line_and_switches_off_a_third_track(
    tmp_path: Path, visit: Any, settings: tuple[tuple[str, str], ...], third: str
) -> None:
    # Four engines, as there are here; the folder's fifth was never there.
    page = visit(page_of(write_settings_folder(tmp_path / "run", *settings, without="newton"), "index"), viewport=WIDE).page
    assert page.evaluate(LINES) == [1, 1]
    names = page.locator(".switches").first.locator("button").evaluate_all("all => all.map((one) => one.ariaLabel)")
    assert names == ["MuJoCo", "Bullet", "DART", "Plumbline reference (ours)", "default", "tuned", *([third] if third else [])]
    # In two cases each, all on tuned answer.
    marks, gone = page.locator(MARKS).count(), 2 * len(settings) if third else 2 * 4
    button = page.locator("#overview-error").get_by_role("button", name=third or "tuned", exact=True)
    for pressed, left in (("false", marks - gone), ("true", marks)):
        button.click()
        page.wait_for_function("([marks, left]) => document.querySelectorAll(marks).length === left", arg=[MARKS, left])
        assert button.get_attribute("aria-pressed") == pressed
