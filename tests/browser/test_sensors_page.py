"""The page on sensors in a real browser: its pictures open, its charts have a size, and a phone need not scroll sideways."""

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from tests.browser.conftest import page_of, width_on
from tests.sensor_folder import write_sensor_folder

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of(write_sensor_folder(tmp_path_factory.mktemp("sensors") / "run"), "sensors")


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_it_opens_in_silence_with_its_pictures_and_charts_and_fits_a_phone(page: Path, visit: Any, scheme: str) -> None:
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
    assert width_on(seen.page, 390) <= 390
    assert seen.said == []
