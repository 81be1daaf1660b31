"""The section of published figures, with another version and another verdict beside them, on a wide screen and on a phone."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from plumbline.harness.store.store import Store
from plumbline.reports.html.report import write_report
from plumbline.reports.tables import published
from tests.browser.audit import faults
from tests.browser.test_every_page import axe
from tests.two_runs import write_two_runs

__all__ = ["axe"]

pytestmark = pytest.mark.browser


def planted(trials: pd.DataFrame, _measurements: pd.DataFrame, _samples: pd.DataFrame) -> None:
    """Another version of Bullet, and a verdict of DART's that is another."""
    trials.loc[trials["engine"] == "bullet", "engine_version"] = "99.0"
    passed = trials.index[(trials["engine"] == "dart") & (trials["status"] == "passed")]
    trials.loc[passed[0], "status"] = "failed"


@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_the_section_can_be_read(
    visit: Any, axe: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, width: int, scheme: str
) -> None:
    dataset, run = write_two_runs(tmp_path, planted, only=("flight_projectile", "joint_pendulum", "stack_tower"))
    monkeypatch.setattr(published, "published", lambda: Store(dataset))
    index = write_report(run).index
    seen = visit(index, color_scheme=scheme, viewport={"width": width, "height": 900})
    section = seen.page.locator("#published")
    assert section.locator("tr.other-version").count() == 1
    assert "here 99.0" in section.inner_text()
    assert "passed → failed" in section.inner_text()
    assert faults(seen, index, axe, phone=width < 640, whole=False) == []
