"""The audit of effects, carried out for real on small scenes: what is needed, a planted surplus and a planted gap."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from harness import discover
from harness.alteration import EVERYTHING, FINER
from harness.campaign import carry_out
from harness.case import Case, Check
from harness.effects import FLOOR, compared, told_apart
from harness.metrics.divergence import DIVERGENCE
from harness.record import Record
from harness.run import run_trial
from harness.scene import Body, Box, Effect, PlacedShape, Plane, Scene, Sphere, Surface, box_inertia, sphere_inertia
from harness.study import Experiment, Study, Trial
from harness.tables.effects import Verdict, audit, savings, verdicts

HALF = (0.1, 0.15, 0.2)


def sliding(narrow: Effect = Effect.NONE, widen: Effect = Effect.NONE, speed: float = 1.0) -> Scene:
    """A ball that slides over ground with friction; nothing else matters to it."""
    ball = Body(
        name="ball",
        mass=1.0,
        inertia=sphere_inertia(1.0, 0.1),
        collision=(PlacedShape(shape=Sphere(radius=0.1)),),
        p_WB=(0.0, 0.0, 0.1),
        v_WB=(speed, 0.0, 0.0),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    law = Surface(static_friction=0.3, kinetic_friction=0.3)
    return Scene(bodies=(ground, ball), surfaces=(law,), narrow=narrow, widen=widen)


def tumbling() -> Scene:
    """A box in flight that turns about no principal axis; gravity is there, and matters."""
    box = Body(name="box", mass=1.0, inertia=box_inertia(1.0, HALF), w_WB=(3.0, 2.0, 1.0))
    return Scene(bodies=(box,))


def case_of(name: str, scene: Scene, **more: object) -> Case:
    check = Check(metric=DIVERGENCE, at_most=0.0, because="")
    return Case(
        name=name,
        title="",
        question="",
        source="",
        truth="conservation",
        scene=lambda: scene,
        checks=(check,),
        duration=0.25,
        **more,
    )  # type: ignore[arg-type]


Audited = Callable[[Case], list[Verdict]]


@pytest.fixture
def audited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Audited:
    """A study of effects on a case made here, in this process."""

    def of(case: Case) -> list[Verdict]:
        adapter = discover.adapter("reference")

        def here(trials: Sequence[Trial], folder: Path, workers: int) -> Iterator[Record]:
            for trial in trials:
                yield run_trial(trial, case, adapter, folder)

        monkeypatch.setattr("harness.campaign.run_isolated", here)
        experiment = Experiment(name="effects", tracks=("tuned",), effects=True, timing=False)
        study = Study(name="effects", recordings=False, experiments=(experiment,))
        folder = tmp_path / case.name
        return verdicts(carry_out(study, folder, {case.name: case}, {"reference": adapter}, workers=1, resume=False))

    return of


def against(found: Sequence[Verdict]) -> list[str]:
    """What the audit has against the scenes."""
    return audit([asdict(one) for one in found]).sentences


def test_a_scene_that_calls_for_what_it_needs_passes(audited: Audited) -> None:
    found = audited(case_of("slide_made", sliding()))
    assert {one.effect: one.verdict for one in found} == {
        EVERYTHING: EVERYTHING,
        "gravity": "needed and on",
        "contact": "needed and on",
        "friction": "needed and on",
        "continuous_collision": "left out",
    }
    assert against(found) == []


def test_a_planted_surplus_fails(audited: Audited) -> None:
    found = audited(case_of("slide_made", sliding(widen=Effect.CONTINUOUS_COLLISION | Effect.GYROSCOPIC)))
    told = against(found)
    assert len(told) == 2
    assert any("declares gyroscopic" in sentence for sentence in told)
    assert any("declares continuous_collision" in sentence for sentence in told)


def test_a_planted_gap_fails(audited: Audited) -> None:
    told = against(audited(case_of("slide_less", sliding(narrow=Effect.FRICTION))))
    assert len(told) == 1
    assert "leaves out friction, which matters" in told[0]
    (sentence,) = against(audited(case_of("tumble_made", replace(tumbling(), narrow=Effect.GYROSCOPIC))))
    assert "leaves out gyroscopic" in sentence


def test_another_engine_stands_in_for_the_judge_and_is_named(audited: Audited) -> None:
    """What the page, the table and the sentences say comes of the same rows, whoever was asked."""
    surplus = audited(case_of("slide_made", sliding(widen=Effect.GYROSCOPIC)))
    elsewhere = [asdict(one) | {"engine": "another"} for one in surplus]
    told = audit(elsewhere)
    assert (told.judge, told.scenes, len(told.failed)) == ("another", 1, 1)
    both = audit([asdict(one) for one in surplus if one.effect != "gyroscopic"] + elsewhere)
    assert (both.judge, both.failed) == ("reference", ())
    assert audit([row for row in elsewhere if row["verdict"] == EVERYTHING]).judge == ""


def test_what_a_case_insists_on_is_no_surplus(audited: Audited) -> None:
    scene = sliding(speed=0.0)
    assert any("friction" in sentence for sentence in against(audited(case_of("rest_made", scene))))
    assert against(audited(case_of("rest_more", scene, insists={"friction": "real ground is rough"}))) == []


def test_the_minimal_set_is_found_by_leaving_out_together(audited: Audited) -> None:
    """Of a box at rest neither friction nor gyroscopic terms matter, and the two together do not either."""
    box = Body(
        name="box",
        mass=1.0,
        inertia=box_inertia(1.0, HALF),
        collision=(PlacedShape(shape=Box(half_extents=HALF)),),
        p_WB=(0.0, 0.0, HALF[2]),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    scene = Scene(bodies=(ground, box), surfaces=(Surface(static_friction=0.5, kinetic_friction=0.5),))
    found = audited(case_of("rest_made", scene))
    assert [one.effect for one in found if one.verdict == "left out together"] == ["friction, gyroscopic"]


def run(p: list[float], time: list[float] | None = None) -> dict[str, object]:
    """One body's way along x."""
    places = np.zeros((len(p), 1, 3))
    places[:, 0, 0] = p
    turned = np.zeros((len(p), 1, 4))
    turned[..., 0] = 1.0
    return {"time": np.arange(float(len(p))) if time is None else np.array(time), "p_WB": places, "q_WB": turned}


def test_what_is_lost_in_the_own_error_does_not_matter() -> None:
    plain, finer = run([0.0, 1.0, 2.0]), run([0.0, 1.001, 2.003])
    assert not compared(plain, run([0.0, 1.001, 2.005]), finer).matters
    assert compared(plain, run([0.0, 1.001, 2.007]), finer).matters
    assert not compared(plain, run([0.0, 1.0 + FLOOR / 2, 2.0]), None).matters


def test_an_early_difference_counts_though_chaos_drowns_it_later() -> None:
    plain, finer = run([0.0, 1.0, 2.0]), run([0.0, 1.0, 7.0])
    found = compared(plain, run([0.0, 1.1, 5.0]), finer)
    assert found.matters
    assert found.moved == pytest.approx(0.1)


def test_a_run_that_ended_early_is_far_off() -> None:
    assert compared(run([0.0, 1.0, 2.0]), run([0.0, 1.0]), None).matters


def test_a_turn_is_seen_and_the_sign_of_a_quaternion_is_not() -> None:
    plain, other = run([0.0, 0.0]), run([0.0, 0.0])
    other["q_WB"] = -np.array(other["q_WB"])
    assert not compared(plain, other, None).matters
    quarter = np.array(plain["q_WB"]).copy()
    quarter[1, 0] = [np.cos(0.1), np.sin(0.1), 0.0, 0.0]
    other["q_WB"] = quarter
    assert compared(plain, other, None).moved == pytest.approx(0.2)


def test_names_say_which_effects_they_are_about() -> None:
    assert told_apart("without friction, gyroscopic") == ("friction", "gyroscopic")
    assert told_apart("with continuous_collision") == ("continuous_collision",)
    assert told_apart(EVERYTHING) == told_apart(FINER) == told_apart("") == ()


def test_the_saving_is_a_mean_of_ratios_and_a_ratio_of_sums() -> None:
    told = [("a", 2.0, 1.0), ("b", 0.5, 3.0), ("rays", 4.0, None)]
    rows = [{"engine": "e", "verdict": EVERYTHING, "cost": c, "cpu_as_it_is": s, "case": name} for name, c, s in told]
    (one,) = savings([*rows, {"engine": "e", "verdict": "needed and on", "cost": 9.0, "cpu_as_it_is": 1.0}])
    assert one.mean == pytest.approx(4.0 ** (1 / 3))
    assert (one.low, one.high, one.scenes) == (0.5, 4.0, 3)
    assert one.summed == pytest.approx((2.0 * 1.0 + 0.5 * 3.0) / 4.0)
