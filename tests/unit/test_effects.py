"""The audit of effects, carried out for real on small scenes: what is needed, a planted surplus and a planted gap."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Diverged
from plumbline.harness.case import Case, Check
from plumbline.harness.case.alteration import EVERYTHING, FINER, Alteration
from plumbline.harness.case.undropped import called
from plumbline.harness.cli.minimal_scene import write_minimal
from plumbline.harness.findings.effects_audit import NOT_JUDGED, EffectVerdict, Matters, Word, audit, idle, judged, savings
from plumbline.harness.findings.tables.effects import TABLE, sentences, verdicts
from plumbline.harness.metrics.errors import divergence, position_error_final
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.verify import problems
from plumbline.harness.scene import Body, Box, Effect, PlacedShape, Plane, Scene, Sphere, Surface, box_inertia, sphere_inertia
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.companion import beside, load_companion
from plumbline.harness.search.needless_effects import FLOOR, Consequence, Scale, compared, departure, scale_of, weighed
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trial.accuracy import run_trial
from plumbline.reports.pages.effects import PAGE
from tests.planted_faults.planting import Wrapped, plant

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
    check = Check(metric=divergence, at_most=0.0, because="")
    return Case(
        name=name,
        title="",
        question="",
        source="",
        truth="conservation",
        scene=lambda _: scene,
        checks=(check,),
        duration=0.25,
        **more,
    )  # type: ignore[arg-type]


Studied = Callable[..., Store]
Audited = Callable[[Case], list[EffectVerdict]]


@pytest.fixture
def studied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Studied:
    """A study of effects on a case and engines made here, in this process."""

    def of(case: Case, *adapters: Adapter) -> Store:
        named = {adapter.name: adapter for adapter in adapters}

        def here(trials: Sequence[Trial], folder: Path, workers: int) -> Iterator[Record]:
            for trial in trials:
                yield run_trial(trial, case, named[trial.engine], folder)

        monkeypatch.setattr("plumbline.harness.run.campaign.run_isolated", here)
        experiment = Experiment(name="effects", tracks=("tuned",), effects=True, timing=False)
        study = Study(name="effects", recordings=False, experiments=(experiment,))
        folder = tmp_path / "-".join((called(case.name), *named))
        return carry_out(study, folder, {case.name: case}, named, workers=1, resume=False)

    return of


@pytest.fixture
def audited(studied: Studied) -> Audited:
    """What a study of effects says of a case made here, judged by our own engine."""
    return lambda case: list(verdicts(studied(case, plugins.adapter("reference"))))


def against(found: Sequence[EffectVerdict]) -> list[str]:
    """What the audit has against the scenes."""
    return audit(found).sentences()


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
    assert any("declares continuous collision" in sentence for sentence in told)


def test_a_planted_gap_fails(audited: Audited) -> None:
    told = against(audited(case_of("slide_less", sliding(narrow=Effect.FRICTION))))
    assert len(told) == 1
    assert "leaves out friction, which matters" in told[0]
    (sentence,) = against(audited(case_of("tumble_made", replace(tumbling(), narrow=Effect.GYROSCOPIC))))
    assert "leaves out gyroscopic" in sentence


def test_an_engine_that_is_asked_alone_speaks_for_itself_and_gates_nothing(audited: Audited) -> None:
    """What the page, the table and the sentences say comes of the same rows, whoever was asked."""
    surplus = audited(case_of("slide_made", sliding(widen=Effect.GYROSCOPIC)))
    told = audit(surplus)
    assert (told.judges(), told.scenes, len(told.failed)) == ("Judged by reference alone", 1, 1)
    assert told.sentences()[0].endswith("by reference alone")
    assert told.gating.failed == ()
    assert audit([row for row in surplus if row.verdict == EVERYTHING]).judges() == "Judged by nobody"


def others(*names: str, scene: Callable[[Scene], Scene] = lambda same: same) -> list[Adapter]:
    """Engines that are not ours and do what ours does, of a scene that each is told otherwise."""
    return [
        replace(plant(plugins.adapter("reference"), scene=scene), name=name, title=name, distribution="elsewhere")
        for name in names
    ]


def smooth(scene: Scene) -> Scene:
    """Without friction: whoever is told so finds that friction does not matter, at every step."""
    return replace(scene, narrow=scene.narrow | Effect.FRICTION)


def wrong_reference() -> Adapter:
    """Ours, which never has friction."""
    return replace(others("reference", scene=smooth)[0], distribution="plumbline")


def of_friction(store: Store) -> dict[str, EffectVerdict]:
    """The rows about friction, by engine."""
    return {row.engine: row for row in verdicts(store) if row.effect == "friction"}


def test_a_reference_that_is_wrong_condemns_nobody_and_shows(studied: Studied) -> None:
    """Two that agree outvote it, and its own row says so; alone it would have had friction left out."""
    case = case_of("slide_made", sliding())
    alone = studied(case, wrong_reference())
    assert of_friction(alone)["reference"].verdict == "paid for without need"
    assert audit(verdicts(alone)).gating.failed == ()
    rows = of_friction(both := studied(case, wrong_reference(), *others("first", "second")))
    assert {engine: row.verdict for engine, row in rows.items()} == dict.fromkeys(rows, "needed and on")
    assert {(row.judge, row.against) for row in rows.values()} == {("first, second", "reference")}
    told = audit(verdicts(both))
    assert told.failed == ()
    assert told.dissent() == ["slide_made: friction matters by first, second; reference would have it otherwise"]
    assert f"Audit: {told.dissent()[0]}." in sentences(verdicts(both))
    assert "reference would have it otherwise" in str(PAGE.render(both)["effects.html"])


def test_two_engines_that_agree_against_one_show_and_one_word_against_another_says_nothing(studied: Studied) -> None:
    """Ours has no vote: with it on its side one engine is not believed against another."""
    case, odd = case_of("slide_made", sliding()), others("odd", scene=smooth)
    rows = of_friction(studied(case, plugins.adapter("reference"), *others("first", "second"), *odd))
    assert {(row.verdict, row.judge, row.against) for row in rows.values()} == {("needed and on", "first, second", "odd")}
    tied = of_friction(both := studied(case, plugins.adapter("reference"), *others("first"), *odd))
    assert {row.verdict for row in tied.values()} == {NOT_JUDGED}
    assert audit(verdicts(both)).failed == ()
    (doubt,) = (said for said in audit(verdicts(both)).doubts() if "friction" in said)
    assert "first says that it matters; odd says that it does not matter" in doubt


def test_the_truth_judges_where_a_case_has_one_and_one_engine_that_passes_is_enough(studied: Studied) -> None:
    """A ball in free flight: g dt t/2 off its closed form. Ours, without gravity, misses the check, and is no witness."""

    def expected(time: Floats, _: object) -> Trajectory:
        truth = Trajectory.at_rest(flying, time)
        truth.p_WB[:, 0, 2] -= 4.905 * truth.time**2
        truth.v_WB[:, 0, 2] -= 9.81 * truth.time
        return truth

    flying = Scene(bodies=(Body(name="ball", inertia=sphere_inertia(1.0, 0.1)),), widen=Effect.GYROSCOPIC)
    near = Check(
        metric=position_error_final, at_most=9.81 * 0.25 / 240, because="g dt t: twice the error of semi-implicit Euler"
    )
    case = replace(case_of("fall_made", flying), truth="closed form", expected=expected, checks=(near,))
    floating = plant(plugins.adapter("reference"), scene=lambda scene: replace(scene, narrow=scene.narrow | Effect.GRAVITY))
    rows = verdicts(studied(case, floating, *others("first", "second")))
    gravity = {row.engine: row for row in rows if row.effect == "gravity"}
    assert {(row.verdict, row.judge) for row in gravity.values()} == {("needed and on", "the truth")}
    (spun,) = audit(rows).gating.failed
    assert (spun.effect, spun.judge) == ("gyroscopic", "the truth")
    lone = audit(verdicts(studied(case, *others("first"))))
    assert lone.judges() == "Judged by the truth"
    assert [row.effect for row in lone.gating.failed] == ["gyroscopic"]


def test_an_engine_whose_error_hides_an_effect_does_not_deny_it() -> None:
    """Two coarse engines see nothing of a millimetre that ours and a sharp one see: nothing is said, and nobody is outvoted."""

    def word(moved: float, own: float, says: bool) -> Word:
        blank = np.zeros(1)
        return Word(Consequence(moved, own, matters=says), Scale(blank, blank, blank))

    coarse, sharp = word(1e-3, 5e-3, False), word(1e-3, 1e-6, True)
    assert judged({}, {"a": coarse, "b": coarse, "ours": sharp}, {"ours"}).matters is None
    assert judged({}, {"a": coarse, "b": coarse, "c": sharp, "d": sharp}, set()).judge == "c, d"
    blind = word(1e-9, 1e-6, False)
    assert judged({}, {"a": blind, "b": blind, "ours": sharp}, {"ours"}) == Matters(False, "", "a, b", ("ours",))


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
    assert [one.effects for one in found if one.verdict == "left out together"] == [("friction", "gyroscopic")]
    assert "friction, gyroscopic" in {one.effect for one in found}
    (scene,) = {(one.case, one.where) for one in found}
    assert idle(scene, found) == ["friction", "gyroscopic"]


def test_the_minimal_set_is_a_file_that_can_be_run(tmp_path: Path, studied: Studied) -> None:
    """Of a ball in free flight the gyroscopic term that its file asks for does not show."""
    path = tmp_path / "my_ball.toml"
    ball = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4), w_WB=(1, 2, 3))
    path.write_text(dump_toml(Scene(bodies=(ball,), widen=Effect.GYROSCOPIC)))
    (tmp_path / "my_ball.plumb.toml").write_text("duration = 0.25\nseed = 3\n")
    case = plugins.case(f"{plugins.SCENE_PREFIX}{path}")
    store = studied(case, plugins.adapter("reference"))
    told = [sentence for sentence in TABLE.said(store) if "gyroscopic" in sentence]
    assert told[0].startswith("Audit: My ball: declares gyroscopic")
    assert str(path) not in " ".join(told)
    written = write_minimal(store, case)
    assert written is not None
    file, without = written
    assert without == ["gyroscopic"]
    assert file.name == "my_ball.minimal.toml"
    minimal = plugins.case(f"{plugins.SCENE_PREFIX}{file}")
    assert minimal.scene(minimal.parameters).effects == Effect.GRAVITY
    assert (minimal.duration, load_companion(beside(file)).seed) == (0.25, 3)
    assert all("minimal" not in problem.path.relative_to(store.folder).parts for problem in problems(store.folder))


def run(p: list[float], time: list[float] | None = None) -> dict[str, object]:
    """One body's way along x."""
    places = np.zeros((len(p), 1, 3))
    places[:, 0, 0] = p
    turned = np.zeros((len(p), 1, 4))
    turned[..., 0] = 1.0
    return {"time": np.arange(float(len(p))) if time is None else np.array(time), "p_WB": places, "q_WB": turned}


def by(plain: dict[str, object], other: dict[str, object], finer: list[float], finest: list[float]) -> Consequence:
    """The consequence where halving the step, and halving it again, puts the body at these places; effects move it by 1 m."""
    return compared(plain, other, scale_of(plain, run(finer), run(finest), [run([one + 1.0 for one in finer])]))


def test_what_is_lost_in_the_own_error_does_not_matter() -> None:
    plain, finer, finest = run([0.0, 1.0, 2.0]), [0.0, 1.001, 2.003], [0.0, 1.0015, 2.0045]
    assert by(plain, run([0.0, 1.0005, 2.0029]), finer, finest).matters is False
    assert by(plain, run([0.0, 1.001, 2.013]), finer, finest).matters is True
    exact = [0.0, 1.0, 2.0]
    assert by(plain, run([0.0, 1.0 + FLOOR / 3, 2.0]), exact, exact).matters is False


@pytest.mark.parametrize("moved", [0.0031, 0.0061, 0.0119])
def test_what_lies_within_a_factor_of_two_of_the_bar_is_not_judged_and_says_so(moved: float) -> None:
    """The bar is twice the .003 m of halving the step: another machine may find it on the other side."""
    plain, finer, finest = run([0.0, 1.0, 2.0]), [0.0, 1.001, 2.003], [0.0, 1.0015, 2.0045]
    found = by(plain, run([0.0, 1.0, 2.0 + moved]), finer, finest)
    assert found.matters is None
    assert found.near
    doubt = found.doubt(scale_of(plain, run(finer), run(finest), []))
    assert doubt == (
        f"moves a body by {moved:.2g} m or rad, within a factor of 2 of the bar, 2 times the 0.003 that halving the step does"
    )


def test_an_early_difference_counts_though_chaos_drowns_it_later() -> None:
    plain, finer, finest = run([0.0, 1.0, 2.0]), [0.0, 1.001, 7.0], [0.0, 1.0015, -3.0]
    found = by(plain, run([0.0, 1.1, 5.0]), finer, finest)
    assert found.matters is True
    assert found.moved == pytest.approx(0.1)


def test_what_shows_only_once_the_engine_has_lost_its_way_is_not_judged() -> None:
    """Three ways to be lost: a step halved again does as much, an error as large as what effects do, and no finer run."""
    plain, later = run([0.0, 1.0, 2.0]), run([0.0, 1.0, 9.0])
    assert by(plain, later, [0.0, 1.0, 2.01], [0.0, 1.0, 2.02]).matters is None
    assert by(plain, later, [0.0, 1.0, 2.01], [0.0, 1.0, 2.015]).matters is True
    assert by(plain, later, [0.0, 1.0, 2.3], [0.0, 1.0, 2.31]).matters is None
    assert compared(plain, later, scale_of(plain, run([0.0, 1.0, 2.01]), None, [later])).matters is None
    assert compared(plain, later, scale_of(plain, None, None, [later])).matters is None


def test_a_lost_engine_does_not_know_what_does_not_matter() -> None:
    plain = run([0.0, 1.0, 2.0])
    assert by(plain, run([0.0, 1.0, 2.0]), [0.0, 1.0, 2.01], [0.0, 1.0, 2.015]).matters is False
    assert by(plain, run([0.0, 1.0, 2.0]), [0.0, 1.0, 3.0], [0.0, 1.0, 9.0]).matters is None


def test_an_effect_that_is_off_and_would_change_nothing_is_no_gap_whoever_says_so() -> None:
    spun, unspun = Alteration(widen=Effect.GYROSCOPIC), Alteration(narrow=Effect.GYROSCOPIC)
    unknown = Consequence(0.0, 3.1, matters=None)
    assert weighed(spun, unknown, None, None, ["gravity"]) == replace(unknown, matters=False)
    assert weighed(spun, replace(unknown, moved=1.0), None, None, ["gravity"]).matters is None  # type: ignore[union-attr]
    assert weighed(unspun, unknown, None, None, ["gravity"]) == unknown


def test_a_run_that_ended_early_is_far_off() -> None:
    finer, finest = [0.0, 1.0, 2.001], [0.0, 1.0, 2.0015]
    assert by(run([0.0, 1.0, 2.0]), run([0.0, 1.0]), finer, finest).matters is True


def test_the_doubt_says_by_how_much_halving_the_step_moves_a_body() -> None:
    doubtful = Scale(np.array([0.0, 0.5]), np.array([0.0, 0.6]), np.array([0.0, 2.0]))
    assert doubtful.doubt == (
        "has not converged: halving the step moves a body by 0.5 m or rad, halving it again by 0.6, any effect by 2 at most"
    )
    assert Scale(np.array([0.0, 0.1]), np.array([0.0, 0.05]), np.array([0.0, 2.0])).doubt == ""
    assert "no answer" in Scale(np.array([0.0, 0.1]), np.full(2, np.nan), np.array([0.0, 2.0])).doubt


def test_a_judge_without_an_answer_judges_nothing(studied: Studied) -> None:
    """Neither the whole scene, where it diverges as it is, nor an effect without which it gives no answer."""
    sound = plugins.adapter("reference")
    lost = plant(sound, simulation=Lost)
    told = verdicts(studied(case_of("slide_made", sliding()), lost))
    assert audit(told).judged == ()
    assert sentences(told) == [
        "Audit: slide_made: nothing is said of any effect: reference: diverged: by step 1 of 60 (t = 0 s): lost."
    ]
    plain = verdicts(studied(case_of("slide_more", sliding()), sound))
    late = [replace(one, verdict="timeout", reason="late") if one.effect == "contact" else one for one in plain]
    assert (audit(plain).scenes, audit(late).scenes) == (1, 0)
    assert audit(late).doubts() == ["slide_more: nothing is said of contact: reference: timeout: late"]
    titles = {"slide_more": "Sliding on", "reference": "Plumbline reference engine"}
    spoken = "Sliding on: nothing is said of contact: Plumbline reference engine: timeout: late"
    assert audit(late).doubts(titles) == [spoken]
    assert f"Audit: {spoken}." in sentences(late, titles=titles)


class Lost(Wrapped):
    """An engine that gives up at once."""

    def step(self, count: int = 1) -> None:
        """It raises. Raises: Diverged."""
        raise Diverged("lost")


class Wrong(Wrapped):
    """An engine whose bodies drift aside at a speed [m/s] of its own, that depends on the time step and not on the scene."""

    def __init__(self, *built: Any, aside: Callable[[float], float]) -> None:
        super().__init__(*built)
        self.speed, self.steps = aside(self.asked.dt), 0

    def step(self, count: int = 1) -> None:
        """As inside, counted."""
        self.steps += count
        self.inner.step(count)

    def state(self, out: State) -> None:
        """Where bodies are inside, and the drift."""
        self.inner.state(out)
        out.p_WB[1:, 1] += self.speed * self.steps * self.asked.dt


def zigzag(dt: float) -> float:
    """To the left at one step, to the right at half of it."""
    return 4.0 * (-1.0) ** round(np.log2(dt * 240))


def coarse(dt: float) -> float:
    """At the case's own step alone: whatever is finer is right, as where a drive is unstable at one step, not at the next."""
    return 4.0 if dt > 1 / 300 else 0.0


@pytest.mark.parametrize(
    ("aside", "name"),
    [
        (zigzag, "reference"),
        (coarse, "another"),
        pytest.param(zigzag, "another", marks=pytest.mark.slow),
        pytest.param(coarse, "reference", marks=pytest.mark.slow),
    ],
)
def test_a_judge_that_is_itself_wrong_proposes_nothing_and_says_so(
    studied: Studied, aside: Callable[[float], float], name: str
) -> None:
    """Whether it is our engine or one that stands in for it; in .25 s its bodies drift by a metre, and friction does some 9 cm.

    Gyroscopic terms of a ball do nothing at all: a sound judge proposes to leave them out.
    """
    sound = plugins.adapter("reference")
    wrong = replace(plant(sound, simulation=partial(Wrong, aside=aside)), name=name)
    store = studied(case_of("slide_made", sliding(widen=Effect.GYROSCOPIC)), wrong)
    told = {one.effect: one for one in verdicts(store)}
    assert told["friction"].verdict == NOT_JUDGED
    assert told["friction"].reason.startswith(f"{name}: has not converged: halving the step moves a body by ")
    found = audit([*told.values()])
    assert found.failed == ()
    assert {"friction", "gyroscopic"} <= {one.effect for one in found.open}
    said = sentences([*told.values()])
    assert not any("Proposed" in one or "declares" in one for one in said)
    (doubt,) = (one for one in said if "nothing is said of" in one)
    assert "friction" in doubt
    assert "has not converged" in doubt
    page = str(PAGE.render(store)["effects.html"])
    assert doubt.removeprefix("Audit: ").removesuffix(".") in page
    assert "Not judged, and nothing is proposed" in page


def test_a_turn_is_seen_and_the_sign_of_a_quaternion_is_not() -> None:
    plain, other = run([0.0, 0.0]), run([0.0, 0.0])
    still = Scale(np.zeros(2), np.zeros(2), np.zeros(2))
    other["q_WB"] = -np.array(other["q_WB"])
    assert compared(plain, other, still).matters is False
    quarter = np.array(plain["q_WB"]).copy()
    quarter[1, 0] = [np.cos(0.1), np.sin(0.1), 0.0, 0.0]
    other["q_WB"] = quarter
    assert compared(plain, other, still).moved == pytest.approx(0.2)


def test_a_departure_says_which_effects_it_is_about_in_a_record_and_in_a_table() -> None:
    both = Alteration(name="any words", narrow=Effect.FRICTION | Effect.GYROSCOPIC)
    for said in (both.plain(), json.dumps(both.plain())):
        assert departure(SimpleNamespace(alteration=said)) == both
    assert both.single.names == ("friction", "gyroscopic")
    assert Alteration(widen=Effect.CONTINUOUS_COLLISION).single.names == ("continuous_collision",)
    assert not Alteration(name=EVERYTHING, present=Effect.FRICTION).single
    assert not Alteration(name=FINER).single


def test_the_saving_is_a_mean_of_ratios_and_a_ratio_of_sums() -> None:
    told = [("a", 2.0, 1.0), ("b", 0.5, 3.0), ("rays", 4.0, None)]

    def row(verdict: str, cost: float, second: float | None, case: str = "") -> SimpleNamespace:
        return SimpleNamespace(engine="e", verdict=verdict, cost=Interval(cost), cpu_as_it_is=second, case=case)

    rows = [row(EVERYTHING, cost, second, name) for name, cost, second in told]
    (one,) = savings([*rows, row("needed and on", 9.0, 1.0)])
    assert one.mean == pytest.approx(4.0 ** (1 / 3))
    assert (one.low, one.high, one.scenes) == (0.5, 4.0, 3)
    assert one.summed == pytest.approx((2.0 * 1.0 + 0.5 * 3.0) / 4.0)
