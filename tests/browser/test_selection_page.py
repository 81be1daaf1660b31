"""The page on selection ranks prices that are only bounds as the command does, and answers in the same words."""

import re
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.findings.selection import Wish, choose, read_preset
from plumbline.harness.findings.selection.words import headline
from plumbline.harness.store.store import Store
from tests.browser.conftest import page_of
from tests.run_folder import CASES
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
    page.wait_for_function("() => document.getElementById('headline').textContent.includes('2000 resamples')")
    rows = "rows => Object.fromEntries(rows.map(row => [row.dataset.engine, [...row.cells].map(cell => cell.textContent)]))"
    shown = page.locator("#places tbody tr").evaluate_all(rows)
    for place in found.rank.places:
        assert shown[place.engine][0] == str(place.number)
        assert abs(int(shown[place.engine][3].split()[0]) - 100 * place.first) <= 5
        assert float(shown[place.engine][4]) == pytest.approx(place.score, abs=0.0051)
    page.get_by_label("times real time, at least").fill("15")
    page.wait_for_function("() => document.getElementById('left-out').textContent.includes('it is not known')")
    assert "Of MuJoCo it is not known: " in page.inner_text("#left-out")


ON_FEET = tuple(name for name in CASES if name.split("_")[0] in ("joint", "friction", "impact"))
"""The cases of the purpose of machines that walk."""
TITLES = {"mujoco": "MuJoCo", "dart": "DART", "bullet": "Bullet"}


def test_the_page_says_first_level_left_and_alone_in_the_words_of_the_command(tmp_path: Path, visit: Any) -> None:
    """Shares are drawn by another generator in the browser, so that they are left out of what is compared."""
    engines = {
        "mujoco": Made(error=0.3, cost=0.01),
        "dart": Made(error=0.9, cost=0.03, lacks=ON_FEET),
        "bullet": Made(error=0.9, cost=0.3, lacks=ON_FEET),
    }
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0)
    store, page = Store(folder), visit(page_of(folder, "select")).page
    purpose, weight = page.get_by_label("purpose"), page.get_by_label("price", exact=False).first
    realtime = page.get_by_label("times real time, at least")

    def told(wish: Wish, kind: str) -> None:
        words = headline(choose(store, wish, draws=2000), TITLES.__getitem__)
        assert kind in words
        expected = re.sub(r"\d+ %", "", words)
        seen = "document.getElementById('headline').textContent.replaceAll('\\u00a0', ' ').replace(/\\d+ %/g, '')"
        page.wait_for_function(f"text => {seen} === text", arg=expected)

    weight.fill("5")
    told(Wish(weights={"price": 5.0}), "first, in ")
    weight.fill("0")
    purpose.select_option("legged")
    told(read_preset("legged").wish(), "is the only engine that can express these scenes, of 3 asked")
    assert page.locator("#places tbody tr:visible").count() == 1
    assert page.locator("#places tbody tr:visible td").nth(2).inner_text() == "\N{EN DASH}"
    purpose.select_option("")
    weight.fill("1")
    realtime.fill("100")
    told(Wish(realtime=100.0), "is the only engine left, of 3 asked")
    realtime.fill("1000000")
    told(Wish(realtime=1e6), "No engine is left")
