"""The page on selection says what the command says, to the digit: the same resamples, shares, order and words."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.findings.selection import Selection, Wish, choose, read_preset
from plumbline.harness.findings.selection.words import headline, percent, trade
from plumbline.harness.store.store import Store
from tests.browser.conftest import page_of
from tests.run_folder import CASES
from tests.selection_folder import Made, write_selection_folder

pytestmark = pytest.mark.browser

ENGINES = {"mujoco": Made(error=0.02, cost=0.8), "dart": Made(error=0.9, cost=0.03), "bullet": Made(error=0.9, cost=0.04)}
"""The first errs less than is asked for at the coarsest step; the others are alike but for noise from case to case."""
compact = partial(json.dumps, separators=(",", ":"), ensure_ascii=False)
TITLES = {"mujoco": "MuJoCo", "dart": "DART", "bullet": "Bullet"}


def told(page: Any, found: Selection) -> None:
    """Headline, order, shares and scores of the page are those of an answer."""
    words = headline(found, TITLES.__getitem__)
    seen = "document.getElementById('headline').textContent.replaceAll('\\u00a0', ' ')"
    rows = "[...document.querySelectorAll('#places tbody tr:not([hidden])')]"
    texts = f"{rows}.map(row => [row.dataset.engine, ...[0, 3, 4, 7].map(cell => row.cells[cell].textContent)])"
    assert found.rank is not None
    share = [None if found.alone else percent(place.first) for place in found.rank.places]
    expected = [
        [
            place.engine,
            str(place.number),
            first or "\N{EN DASH}",
            "{}/{}".format(*found.evidence.within(place.engine)),
            f"{place.score:.2f}",
        ]
        for place, first in zip(found.rank.places, share, strict=True)
    ]
    # A change of weights may leave the first sentence as it was: both have to be there.
    page.wait_for_function(f"told => {seen} === told[0] && JSON.stringify({texts}) === told[1]", arg=[words, compact(expected)])


def test_places_shares_and_scores_of_the_page_are_those_of_the_command(tmp_path: Path, visit: Any) -> None:
    folder = write_selection_folder(tmp_path / "run", ENGINES, 0)
    store, page = Store(folder), visit(page_of(folder, "select")).page
    told(page, choose(store, Wish()))
    page.get_by_label("speed", exact=False).first.fill("5")
    told(page, choose(store, Wish(weights={"speed": 5.0})))
    for preset in ("legged", "games"):
        page.get_by_label("purpose").select_option(preset)
        found = choose(store, read_preset(preset).wish())
        told(page, found)
        assert page.inner_text("#purpose").lower() == read_preset(preset).title.lower()
        assert page.locator("#turns li").all_inner_texts()[0] == trade(found, TITLES.__getitem__)
        assert page.inner_text("#command") == found.decider.command if found.decider else page.locator("#command").is_hidden()
    page.get_by_label("speed", exact=False).first.fill("5")
    page.wait_for_function("() => document.querySelectorAll('#turns li').length === 0")
    assert page.locator("#command").is_hidden()


def test_a_requirement_of_speed_leaves_out_whom_the_command_leaves_out(tmp_path: Path, visit: Any) -> None:
    folder = write_selection_folder(tmp_path / "run", ENGINES, 0)
    page = visit(page_of(folder, "select")).page
    page.get_by_label("times real time, at least").fill("15")
    page.wait_for_function("() => document.getElementById('left-out').textContent.includes('it is not known')")
    assert "Of MuJoCo it is not known: " in page.inner_text("#left-out")


ON_FEET = tuple(name for name in CASES if name.split("_")[0] in ("joint", "friction", "impact"))
"""The cases of the purpose of machines that walk."""


def test_the_page_says_first_left_and_alone_in_the_words_of_the_command(tmp_path: Path, visit: Any) -> None:
    engines = {
        "mujoco": Made(error=0.3, cost=0.01),
        "dart": Made(error=0.9, cost=0.03, lacks=ON_FEET),
        "bullet": Made(error=0.9, cost=0.3, lacks=ON_FEET),
    }
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0)
    store, page = Store(folder), visit(page_of(folder, "select")).page
    purpose, realtime = page.get_by_label("purpose"), page.get_by_label("times real time, at least")
    purpose.select_option("legged")
    found = choose(store, read_preset("legged").wish())
    assert found.alone == "expresses"
    told(page, found)
    purpose.select_option("")
    realtime.fill("100")
    alone = choose(store, Wish(realtime=100.0))
    assert alone.alone == "left"
    told(page, alone)
    realtime.fill("1000000")
    page.wait_for_function("() => document.getElementById('headline').textContent.startsWith('No engine is left')")
