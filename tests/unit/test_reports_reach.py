"""What the page on limits says of one search."""

from dataclasses import replace
from typing import Any

from plumbline.harness.findings.limits_found import Search, Signs
from plumbline.harness.findings.standing import Lead
from plumbline.harness.store.record import StoredNotice
from plumbline.reports.tables.limit_table import cell, standings

BROKEN: Any = Search(
    experiment="axes",
    case="wall",
    where="",
    beside=(),
    engine="one",
    track="default",
    dt=0.01,
    axis="speed",
    unit="m/s",
    easy=1.0,
    extreme=100.0,
    held=10.0,
    broke=20.0,
    share=0.5,
    signs=Signs(counts=(("passage", 3),)),
    verdict="limit",
    reason="",
    members=6,
    values=4,
    cost=None,
    reach=0.5,
    trial_held="a",
    trial_broke="b",
)


def test_a_limit_at_which_the_case_s_own_start_holds_says_so() -> None:
    assert "own start" not in cell(replace(BROKEN, own_holds=False)).why
    assert "the case's own start holds" in cell(replace(BROKEN, own_holds=True)).why


def test_a_finding_names_the_effects_that_no_scene_called_for() -> None:
    damping = StoredNotice("angular damping, by the vendor's default of 0.04", "surplus", "angular_damping")
    assert "surplus: angular damping, by the vendor's default of 0.04" in cell(replace(BROKEN, noticed=(damping,))).hint


def test_leads_without_ours_are_of_what_the_others_reach() -> None:
    """Two pairs that ours alone reaches are none of those that the others share."""
    counts: Any = {(True, "ours"): (9, 5), (True, "other"): (3, 5), (False, "other"): (10, 2)}
    leads = [
        Lead(
            what="pairs",
            at="equal time",
            condition="",
            ours=ours,
            engine=engine,
            alone=alone,
            shared=shared,
            of=14 if ours else 12,
        )
        for (ours, engine), (alone, shared) in counts.items()
    ]
    (row,) = standings(leads)
    assert (row.of, row.of_with_ours) == (12, 14)
    assert row.engines["ours"][1] is None
