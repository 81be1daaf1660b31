"""The page of an importer audit in a real browser: it opens in silence, says what differs, and fits a phone."""

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from plumbline.harness.store.imported_scenes import ParityRecord, ParitySide, write
from plumbline.reports.standalone.parity import write_page

pytestmark = pytest.mark.browser

NAME = "<script>alert(1)</script>"


def row(**more: Any) -> dict[str, Any]:
    return {
        "quantity": "inertia", "element": f"what '{NAME}' moves: forearm_with_a_name_that_is_as_long_as_any_of_a_humanoid",
        "value_A": [0.05, 0.06, 0.04, 8.5e-4, -0.0079, 0.017], "value_B": [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], "unit": "kg m2",
        "tolerance": 1e-5, "absolute": 0.95, "relative": 15.8, "torque": 2.25, "torque_unit": "N m",
        "kind": "inertia replaced", "documented": "", "words": "worth up to 2.25 N m",
    } | more  # fmt: skip


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parity")
    limit = {
        "quantity": "upper", "value_A": 1.5, "value_B": None, "unit": "rad", "absolute": None, "relative": None, "torque": None,
        "kind": "limit ignored", "documented": "a guide", "words": "B is not stopped there",
    }  # fmt: skip
    sides = (
        ParitySide(
            name="bullet",
            engine="bullet",
            source="pybullet",
            rows=tuple(row(torque=float(k + 1)) for k in range(12)),
            matrix_gap=1e-8,
        ),
        ParitySide(
            name="dart", engine="dart", source="DART", rows=(row(**limit), row(quantity="mass matrix", kind="", torque=None))
        ),
        ParitySide(name="mujoco", engine="mujoco", source="MuJoCo", matrix_gap=1e-16),
        ParitySide(name="strange", engine="strange", refused="the loader died"),
    )
    record = ParityRecord(file=f"{NAME}.urdf", joints=7, root="floating", tolerance=1e-5, seed=0, sides=sides)
    write(folder, record)
    return write_page(folder)


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_it_opens_in_silence_and_says_what_each_difference_is_worth(page: Path, visit: Any, scheme: str) -> None:
    seen = visit(page, color_scheme=scheme)
    for width in (1440, 390):
        seen.page.set_viewport_size({"width": width, "height": 900})
        assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
    assert seen.said == []
    assert {urlsplit(url).scheme for url in seen.asked} <= {"file", "data"}
    assert seen.page.locator("h1").inner_text() == "What this engine's importer makes of your robot"
    first = seen.page.locator("#side-1 tbody tr").first
    assert "12 N m" in first.inner_text()
    for k in range(first.locator("td").count()):
        box = first.locator("td").nth(k).bounding_box()
        assert box is not None
        assert box["width"] > 40
        if width == 390:
            assert box["x"] + box["width"] <= width
    chips = [chip.split(" ", 1)[1] for chip in seen.page.locator(".strip .chip").all_inner_texts()]
    assert chips == ["12 differences", "1 by documented defaults", "same robot", "not read"]


def test_every_link_leads_somewhere(page: Path, visit: Any) -> None:
    for href in visit(page).page.eval_on_selector_all("link[href], script[src]", "all => all.map(one => one.href || one.src)"):
        address = urlsplit(href)
        assert address.scheme == "data" or Path(address.path).is_file(), href
