"""The page on selection ranks prices that are only bounds as the command does."""

from pathlib import Path
from typing import Any

import pytest

from harness.findings.selection import Wish, choose
from harness.store.store import Store
from tests.browser.conftest import page_of
from tests.selection_folder import Made, write_selection_folder

pytestmark = pytest.mark.browser

ENGINES = {"mujoco": Made(error=0.02, cost=0.8), "dart": Made(error=0.9, cost=0.03), "bullet": Made(error=0.9, cost=0.3)}
"""The first errs less than is asked for at the coarsest step; what that costs lies between the prices of the others."""


def test_places_and_scores_of_the_page_are_those_of_the_command(tmp_path: Path, visit: Any) -> None:
    """At a price that counts fivefold: scores to the digits shown, shares to 4 sigma of a half in 2000 draws, 4.5 %."""
    folder = write_selection_folder(tmp_path / "run", ENGINES, 0, noise=0.0)
    store = Store(folder)
    found = choose(store, Wish(weights={"price": 5.0}))
    assert found.rank is not None
    assert any(datum.bounded for datum in found.evidence.table.values())
    page = visit(page_of(folder, "select")).page
    price = page.get_by_label("price", exact=False).first
    price.fill("5")
    page.wait_for_function("() => document.getElementById('headline').textContent.includes('2000 draws')")
    rows = "rows => Object.fromEntries(rows.map(row => [row.dataset.engine, [...row.cells].map(cell => cell.textContent)]))"
    shown = page.locator("#places tbody tr").evaluate_all(rows)
    for place in found.rank.places:
        assert shown[place.engine][0] == str(place.number)
        assert abs(int(shown[place.engine][3].split()[0]) - 100 * place.first) <= 5
        assert float(shown[place.engine][4]) == pytest.approx(place.score, abs=0.0051)
    page.get_by_label("times real time, at least").fill("15")
    page.wait_for_function("() => document.getElementById('left-out').textContent.includes('it is not known')")
    assert "Of MuJoCo it is not known: " in page.inner_text("#left-out")
