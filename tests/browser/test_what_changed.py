"""The page What changed in a real browser: silent, sortable, and nothing to scroll sideways on a phone."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from plumbline.harness.findings.changes import compare
from plumbline.harness.store.store import Store
from plumbline.reports.standalone.what_changed import write_what_changed
from tests.browser.conftest import width_on
from tests.two_runs import write_two_runs

pytestmark = pytest.mark.browser


def planted(trials: pd.DataFrame, measurements: pd.DataFrame, samples: pd.DataFrame) -> None:
    mine = trials["engine"] == "dart"
    trials.loc[mine, ["trajectory_hash", "engine_version"]] = ["0123456789abcdef", "2.0.0"]
    measurements.loc[measurements["trial"].isin(trials.loc[mine, "trial"]), "value"] *= 1.5
    samples.loc[samples["trial"].isin(trials.loc[mine, "trial"]), "cpu"] *= 1.4


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("changed")
    changes = compare(*map(Store, write_two_runs(folder, planted)))
    return write_what_changed(changes, folder / "out", ["dart"])


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_it_opens_in_silence_says_the_worst_first_and_fits_a_phone(page: Path, visit: Any, scheme: str) -> None:
    seen = visit(page, color_scheme=scheme)
    assert seen.said == []
    assert "DART: as a whole" in seen.page.locator("#worse li").first.inner_text()
    assert "errs more" in seen.page.locator("#worse li").nth(1).inner_text()
    assert "plumbline reproduce" in seen.page.locator("#worse li code").nth(1).inner_text()
    rows = seen.page.locator("#all tbody tr")
    assert rows.count() > 50
    assert width_on(seen.page, 390) <= 390
    assert width_on(seen.page, 1280) <= 1280
    seen.page.locator("#all select").select_option("worse")
    assert set(seen.page.locator("#all tbody tr:visible td:first-child").all_inner_texts()) == {"worse"}
