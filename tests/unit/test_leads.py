"""Who leads, by hand: at equal sub-steps, for equal time, with the reference engine and without it."""

from dataclasses import replace
from typing import Any

import pytest

from plumbline.harness.findings.limits_found import CONSTANT, Hold, Search, Signs
from plumbline.harness.findings.prices import Prices
from plumbline.harness.findings.standing import axis_leads, leaders, pair_leads, reaches
from plumbline.harness.findings.tables import limits, steps
from tests.unit.test_prices import Priced, Told, ladder

STEP = 0.01


def search(engine: str, parts: int, *holds: tuple[float, float, float | None], substep: float | None = None) -> Search:
    """On an axis from 0 to 1. Args: holds: value, next harder value, cost of a time step [s]."""
    made: Any = Search(
        experiment="e",
        case="c",
        where="",
        beside=(),
        engine=engine,
        track="tuned" if parts else "default",
        dt=STEP,
        axis="x",
        unit="1",
        easy=0.0,
        extreme=1.0,
        held=holds[-1][0] if holds else None,
        broke=None,
        share=None,
        signs=Signs(),
        verdict="limit",
        reason="",
        members=2,
        values=2,
        cost=None,
        reach=holds[-1][0] if holds else 0.0,
        trial_held="",
        trial_broke="",
        parts=parts,
        substep=STEP / (parts or 1) if substep is None else substep,
        holds=tuple(Hold(value=value, reach=value, further=further, cost=cost) for value, further, cost in holds),
    )
    return made


@pytest.mark.parametrize(
    ("extents", "first"),
    [
        ({"a": (0.5, 0.6), "b": (0.2, 0.3)}, {"a"}),
        ({"a": (0.5, 0.6), "b": (0.4, 0.55)}, {"a", "b"}),  # the limit of b may lie beyond a's
        ({"a": (0.5, 0.6), "b": (0.4, 0.5)}, {"a"}),  # b broke where a held
        ({"a": (1.0, 1.0), "b": (1.0, 1.0), "c": (0.9, 1.0)}, {"a", "b"}),
        ({"a": (0.0, 0.1)}, {"a"}),
        ({}, set()),
    ],
)
def test_an_order_is_stated_only_where_brackets_part(extents: dict[str, tuple[float, float]], first: set[str]) -> None:
    assert leaders(extents) == first


def test_more_sub_steps_do_not_lead_at_equal_sub_steps() -> None:
    """Ours comes to .2 in one part and to .8 in four, a vendor to .4 and .5: who leads depends on the level."""
    found = reaches(
        [
            search("reference", 1, (0.2, 0.3, 1e-5)),
            search("reference", 4, (0.8, 0.9, 4e-5)),
            search("dart", 1, (0.4, 0.5, 1e-5)),
            search("dart", 4, (0.5, 0.6, 4e-5)),
            search("bullet", 1, substep=STEP),
        ]
    )
    level = {(one.parts, one.search.engine): one.leads for one in found if one.at == "equal sub-step"}
    assert level == {
        (1, "reference"): False, (1, "dart"): True, (1, "bullet"): False, (4, "reference"): True, (4, "dart"): False,
    }  # fmt: skip
    assert {one.search.engine for one in found if one.parts == 4 and one.leads_without} == {"dart"}


def test_what_took_a_finer_step_than_it_was_asked_for_is_not_compared() -> None:
    found = reaches([search("dart", 1, (0.4, 0.5, 1e-5)), search("bullet", 1, (0.9, 1.0, 1e-5), substep=STEP / 8)])
    assert [(one.search.engine, one.leads) for one in found if one.parts] == [("dart", True)]
    coarse = reaches([search("dart", 4, (0.4, 0.5, 1e-5)), search("bullet", 4, (0.9, 1.0, 1e-5), substep=STEP)])
    assert [one.search.engine for one in coarse if one.parts and one.leads] == ["bullet"]


def test_for_equal_time_the_farthest_that_is_cheap_enough_counts_whatever_the_setting() -> None:
    """DART reaches .8 at 2 ms a step, and .5 for .9 of one: at a millisecond the cheaper counts; at a tenth its default."""
    found = reaches(
        [
            search("dart", 0, (0.1, 0.2, 5e-5)),
            search("dart", 4, (0.5, 0.8, 9e-4), (0.8, 0.9, 2e-3)),
            search("bullet", 0, (0.3, 0.4, 9e-5), (0.6, 0.7, None)),
        ]
    )
    told = {
        (one.condition, one.search.engine): (one.hold and one.hold.value, one.further, one.search.setting, one.leads)
        for one in found
        if not one.parts
    }
    assert told[1e-4, "dart"] == (0.1, 0.2, "default", False)
    assert told[1e-4, "bullet"] == (0.3, 0.4, "default", True)
    assert told[1e-3, "dart"] == (0.5, 0.8, "tuned, sub-step dt/4", True)
    assert told[1e-3, "bullet"] == (0.3, 0.4, "default", False)


def test_leads_are_counted_alone_and_together_with_ours_and_without() -> None:
    found = reaches([search(name, 1, (reach, reach + 0.1, 1e-5)) for name, reach in (("reference", 0.9), ("dart", 0.5))])
    counted = {(one.ours, one.engine): (one.alone, one.shared, one.of) for one in axis_leads(found) if one.condition == "dt"}
    assert counted == {(True, "reference"): (1, 0, 1), (True, "dart"): (0, 0, 1), (False, "dart"): (1, 0, 1)}


def test_pairs_are_led_by_the_cheapest_and_by_the_coarsest_step_that_serves() -> None:
    """Both err by the same at their steps; ours is ten times dearer at a step twice as coarse.

    Of each a coarser step errs more: without it its price would be an upper bound.
    """
    told: list[Told] = [("a", "reference", "tuned", 0.02, 5e-2, 10.0), ("a", "dart", "tuned", 0.01, 5e-2, 1.0)]
    told += [("a", "reference", "tuned", 0.04, 5e-1, 5.0), ("a", "dart", "tuned", 0.02, 5e-1, 0.5)]
    prices = Prices(Priced(told))
    counted = {(one.at, one.ours, one.engine): one.alone for one in pair_leads(prices.prices, prices.points)}
    assert counted["equal time", True, "dart"] == 1
    assert counted["equal time", True, "reference"] == 0
    assert counted["equal sub-step", True, "reference"] == 1
    assert counted["equal sub-step", False, "dart"] == 1


def test_an_upper_bound_on_a_price_leads_with_others_for_it_may_be_less() -> None:
    """One step of each engine: that which costs more may cost less at a coarser one, which nobody tried."""
    told: list[Told] = [("a", "mujoco", "tuned", 0.02, 5e-2, 10.0), ("a", "dart", "tuned", 0.01, 5e-2, 1.0)]
    prices = Prices(Priced(told))
    equal_time = [lead for lead in pair_leads(prices.prices, prices.points) if lead.at == "equal time" and lead.ours]
    assert {lead.engine: (lead.alone, lead.shared) for lead in equal_time} == {"dart": (0, 1), "mujoco": (0, 1)}


def test_a_bar_that_a_constant_crosses_ranks_nobody() -> None:
    far, constant = search("a", 1, (0.5, 0.6, None)), replace(search("b", 1, (0.1, 0.2, None)), verdict=CONSTANT)
    assert {reach.search.engine for reach in reaches([far, constant])} == {"a"}


def test_the_table_of_limits_names_together_whose_brackets_meet_and_not_who_took_finer_steps() -> None:
    """DART holds .4 and breaks at .5, MuJoCo holds .45: no order. Bullet held .9 at an eighth of the step it was asked for."""
    found = [
        search("dart", 1, (0.4, 0.5, None)),
        search("mujoco", 1, (0.45, 0.55, None)),
        search("bullet", 1, (0.9, 1.0, None), substep=STEP / 8),
        search("reference", 1, (0.7, 0.8, None)),
    ]
    (sentence,) = limits.TABLE.sentences(found)
    assert sentence == (
        "c, sub-step dt/1: x up to 0.45: mujoco (tuned, dt/1), dart (tuned, dt/1) to 0.4; reference, not ranked, 0.7."
    )
    together = {reach.search.engine for reach in reaches(found) if reach.parts and reach.leads_without}
    assert together == {"dart", "mujoco"}


def test_the_table_of_steps_ranks_what_can_be_deployed_as_every_other_table_does() -> None:
    told = [*ladder("a", "reference", 1e-3), *ladder("a", "dart", 4e-3), *ladder("a", "bullet", 4e-3)]
    (sentence,) = steps.TABLE.said(Priced(told))
    paced = {name: f"{name} (tuned) at dt = 1/10 s" for name in ("dart", "bullet", "reference")}
    assert sentence.startswith(
        f"a: to stay within 1 %, of the steps that were run, fastest {paced['dart']}, 25 times real time"
    )
    assert f" and {paced['bullet']}" in sentence
    assert sentence.endswith(f"25 times real time; not ranked, {paced['reference']}, 100 times real time.")
