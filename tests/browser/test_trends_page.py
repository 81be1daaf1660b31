"""The page Trends in a browser: silent, the first bad night first, groups that unfold, no sideways scrolling on a phone."""

from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.history.regressions import read_trends
from plumbline.reports.standalone.trends import write_trends
from tests.browser.conftest import width_on
from tests.synthetic_history import write_history
from tests.unit.test_trends import planted

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trends")
    return write_trends(read_trends(write_history(folder / "h", 16, planted)), folder / "out").index


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_it_opens_in_silence_says_the_first_bad_night_first_fits_a_phone_and_unfolds(
    page: Path, visit: Any, scheme: str
) -> None:
    seen = visit(page, color_scheme=scheme)
    assert seen.said == []
    assert [url for url in seen.asked if not url.startswith(("file:", "data:"))] == []
    nights = seen.page.locator("#worse li > time:first-child").evaluate_all("times => times.map(one => one.dateTime)")
    assert len(set(nights)) > 1
    assert nights == sorted(nights)
    assert "plumbline reproduce" in seen.page.locator("#worse code").first.inner_text()
    assert seen.page.locator("#charts svg").count() > 0
    assert not seen.page.locator(".trend").first.is_visible()
    assert width_on(seen.page, 390) <= 390
    assert seen.page.evaluate("document.documentElement.scrollHeight") < 9000
    assert width_on(seen.page, 1280) <= 1280
    seen.page.locator("details.family summary").first.click()
    assert seen.page.locator(".trend").first.is_visible()
