"""The page on sensors in a real browser: its pictures open, its charts have a size, and a phone need not scroll sideways."""

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

import reports
from tests.sensor_folder import write_sensor_folder

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return reports.build(write_sensor_folder(tmp_path_factory.mktemp("sensors") / "run")).parent / "sensors.html"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_opens_in_silence_with_its_pictures_and_charts(page: Path, visit: Any, scheme: str) -> None:
    seen = visit(page, color_scheme=scheme)
    assert seen.said == []
    assert {urlsplit(url).scheme for url in seen.asked} <= {"file", "data"}
    widths = seen.page.eval_on_selector_all(".shots img", "all => all.map(one => one.naturalWidth)")
    assert widths == [32] * 9
    charts = seen.page.locator("figure.chart .plot svg.marks")
    assert charts.count() == seen.page.locator("figure.chart").count() > 4
    for k in range(charts.count()):
        box = charts.nth(k).bounding_box()
        assert box is not None
        assert box["width"] > 300
        assert charts.nth(k).locator(".mark-symbol path").count() > 0


def test_a_phone_needs_no_sideways_scrolling(page: Path, visit: Any) -> None:
    seen = visit(page)
    seen.page.set_viewport_size({"width": 390, "height": 844})
    seen.page.wait_for_timeout(300)
    assert seen.page.evaluate("document.documentElement.scrollWidth") <= 390
