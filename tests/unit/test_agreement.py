"""Who is said to agree in a scene without a truth: shown right on closed forms and on engines with planted faults."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.findings.agreement.found import ways
from plumbline.harness.findings.agreement.judgement import judged
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import JOINTED, STILL, present_words, scene_words, side_sentence
from plumbline.harness.scene import Body, Drive, Revolute, Scene
from plumbline.harness.search.own_limits import OwnLimit, Rung, own_limit
from plumbline.harness.statistics.richardson import Convergence, convergence
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.parting import apart, extent
from tests.own_limits import (
    ENGINES,
    LADDER,
    G,
    agreement,
    arm,
    ball,
    double_pendulum,
    explosive,
    heavier_to_turn,
    pendulum,
    pile,
    restless,
)

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

SHORT = LADDER[:4]
SOUND = ("mujoco", "bullet", "dart")


def side(found: Agreement, engine: str) -> Side:
    (one,) = [one for one in found.sides if one.engine == engine]
    return one


def words(found: Agreement) -> dict[str, str]:
    return {one.engine: one.word for one in found.sides}


def within_its_bar(found: Agreement, truth: Trajectory) -> bool:
    """Is the agreed limit no farther from the truth than it says, at each sample?"""
    assert found.limit is not None
    assert found.bars is not None
    return bool((np.maximum.accumulate(apart(found.limit, truth, found.scale)) <= found.bars + 1e-12).all())


def test_a_projectile_has_an_agreed_limit_within_its_bar_of_the_closed_form() -> None:
    found = agreement(ball(), 1.0)
    assert found.agreed
    assert found.until == pytest.approx(1.0)
    t = found.limit.time
    truth = Trajectory.of(t, 1)
    truth.p_WB[:, 0] = np.stack([3 * t, 0 * t, 1 + 4 * t - G * t**2 / 2], axis=1)
    truth.q_WB[:, 0] = np.stack([np.cos(2.5 * t), 0 * t, np.sin(2.5 * t), 0 * t], axis=1)
    assert within_its_bar(found, truth)
    assert words(found) == dict.fromkeys(SOUND, "agrees")


@cache
def swinging() -> Agreement:
    return agreement(pendulum(), 2.0)


def swing(t: np.ndarray, inertia: float) -> np.ndarray:
    """The angle of a pendulum of 1 kg at 1 m that is let go at 1 rad, by an independent integrator."""
    moment = 1.0 + inertia
    found = solve_ivp(
        lambda _, y: [y[1], -G * math.sin(y[0]) / moment], (0, t[-1]), [1.0, 0.0], method="DOP853", t_eval=t, rtol=1e-12,
        atol=1e-13,
    )  # fmt: skip
    return found.y[0]


def hung(t: np.ndarray) -> Trajectory:
    angle = swing(t, 0.4 * 0.4**2)
    truth = Trajectory.of(t, 1)
    truth.p_WB[:, 0] = np.stack([np.sin(angle), 0 * t, -np.cos(angle)], axis=1)
    # The scene's hinge turns about +y, its angle opens towards +x: about -y.
    truth.q_WB[:, 0] = np.stack([np.cos(angle / 2), 0 * t, -np.sin(angle / 2), 0 * t], axis=1)
    return truth


def test_a_pendulum_has_an_agreed_limit_within_its_bar_of_the_closed_form() -> None:
    found = swinging()
    assert found.until == pytest.approx(2.0)
    assert within_its_bar(found, hung(found.limit.time))
    assert found.bar < 1e-5
    assert words(found) == dict.fromkeys(SOUND, "agrees")


def test_every_engines_own_bar_holds_the_truth() -> None:
    for one in swinging().sides:
        truth = hung(one.limit.value.time)
        error = np.maximum.accumulate(apart(one.limit.value, truth, swinging().scale))
        assert (error <= one.limit.bar + 1e-12).all(), one.engine


def test_an_engine_with_a_wrong_inertia_is_singled_out() -> None:
    """A tenth more inertia lengthens the period by (0.064 * 0.1) / (2 * 1.064), 0.3 %: a hundredth of a radian after 2 s."""
    found = agreement(pendulum(), 2.0, {"dart again": heavier_to_turn(1.1)}, engines=(*ENGINES, "dart again"))
    assert words(found) == dict.fromkeys(SOUND, "agrees") | {"dart again": "converges elsewhere"}
    wrong = side(found, "dart again")
    t = np.arange(121) / 60
    away = np.abs(swing(t, 1.1 * 0.064) - swing(t, 0.064)).max()
    # An angle moves the bob by itself times the length of 1 m, and turns it by its radius of gyration of .253 m.
    assert wrong.distance == pytest.approx(away * (1 + math.sqrt(0.064)) / found.scale.largest, rel=0.02)
    assert 0.0 < wrong.since < 0.5
    assert "converges elsewhere" in side_sentence(wrong, found, {})
    damped = replace(wrong, adds=("linear damping", "angular damping"))
    assert present_words(replace(found, sides=(damped, *found.sides[1:])), {}) == [
        "Computed although the scene does not call for it: linear damping and angular damping on dart again tuned."
    ]
    # What is merely there is no cause.
    assert "damping" not in side_sentence(damped, found, {})


def test_two_that_agree_on_a_wrong_answer_against_two_others_are_two_camps_and_no_limit_is_agreed() -> None:
    faults = {"bullet": heavier_to_turn(), "mujoco again": heavier_to_turn()}
    found = agreement(pendulum(), 2.0, faults, engines=(*ENGINES, "mujoco again"))
    assert found.agreed == ""
    assert found.limit is None
    camps = sorted(sorted(one.engine for one in found.members(letter)) for letter in found.camps)
    assert camps == [["bullet", "mujoco again"], ["dart", "mujoco"]]
    base, distances = ways(found)
    assert base in {f"{one.engine}, {one.track}" for one in found.sides}
    assert {engine for (engine, _), (_, way) in distances.items() if way[-1] > 100 * found.granted} in map(set, camps)
    (gap,) = found.differences
    assert gap.body == "bob"
    assert gap.distance > 100 * found.granted
    assert set(words(found).values()) == {"converges"}
    assert scene_words(found, {})[0].startswith("No limit is agreed. Camps: A: ")


def test_our_own_engine_beside_one_that_differs_makes_no_agreement() -> None:
    found = agreement(pendulum(), 1.0, {"mujoco": heavier_to_turn()}, engines=("mujoco", "reference"))
    assert found.agreed == ""
    assert len(found.camps) == 2


def test_our_own_engine_is_no_second_witness_and_breaks_no_tie() -> None:
    """With MuJoCo alone it agrees, and that settles nothing; beside two against two it stands with one camp, undeciding."""
    alone = agreement(pendulum(), 1.0, engines=("mujoco", "reference"))
    assert len(alone.camps) == 1
    assert alone.agreed == ""
    faults = {"bullet": heavier_to_turn(), "mujoco again": heavier_to_turn()}
    tied = agreement(pendulum(), 1.0, faults, engines=(*ENGINES, "mujoco again", "reference"))
    assert tied.agreed == ""
    assert side(tied, "reference").camps == side(tied, "mujoco").camps
    assert not side(tied, "reference").votes


def test_two_tracks_of_one_engine_are_one_witness() -> None:
    found = agreement(pendulum(), 1.0, engines=("mujoco",), tracks=("default", "tuned"))
    assert len(found.camps) == 1
    assert found.agreed == ""
    assert [one.votes for one in found.sides] == [False, True]


def test_an_engine_that_ends_elsewhere_at_every_step_does_not_converge() -> None:
    found = agreement(pendulum(), 2.0, {"dart again": restless}, engines=(*ENGINES, "dart again"))
    assert words(found) == dict.fromkeys(SOUND, "agrees") | {"dart again": "does not converge"}
    assert side(found, "dart again").camps == ()


def test_it_does_not_converge_alone_either() -> None:
    """Nobody is needed to see that: it is the engine against itself."""
    found = agreement(pendulum(), 2.0, {"mujoco": restless}, engines=("mujoco",))
    assert words(found) == {"mujoco": "does not converge"}


@pytest.mark.parametrize("engines", [("mujoco", "dart"), pytest.param(ENGINES, marks=pytest.mark.slow)])
def test_chaos_has_a_horizon_and_the_verdict_holds_up_to_it(engines: tuple[str, ...]) -> None:
    """Of the first order, bars of the double pendulum leave a hundredth before the end; of the fourth, they do not."""
    found = agreement(double_pendulum(), 5.0, engines=engines)
    first, fourth = side(found, "dart"), side(found, "mujoco")
    assert first.limit.said.ended == "horizon"
    assert 1.0 < first.limit.said.horizon < first.limit.until < 5.0
    assert list(first.limit.horizons.values()) == sorted(first.limit.horizons.values())
    assert fourth.limit.until == pytest.approx(5.0)
    assert words(found) == dict.fromkeys(engines, "agrees")
    assert found.until == first.limit.until
    # MuJoCo's fourth order is a witness of what is agreed with another method.
    assert apart(found.limit, fourth.limit.value.between(0.0, found.until), found.scale).max() <= found.bar


@pytest.mark.parametrize(("count", "tracks"), [(1, ("tuned",)), pytest.param(4, ("default", "tuned"), marks=pytest.mark.slow)])
def test_a_pile_is_known_for_a_moment_only(count: int, tracks: tuple[str, ...]) -> None:
    found = agreement(pile(count), 0.5, tracks=tracks)
    # All fall alike, and that is agreed, whatever they make of the first blow.
    assert found.agreed
    assert 0.05 < found.until < 0.3
    assert len({one.engine for one in found.members(found.agreed) if one.votes}) == 3
    for one in found.sides:
        assert one.word in ("agrees", "converges", "converges elsewhere"), one.why
        # The lowest box is 0.2 m up: its corners touch after at most sqrt(2 * 0.2 / 9.81) = 0.2 s.
        assert 0.05 < one.limit.until < 0.5


def test_the_arm_is_one_limit_for_three_engines_and_ours() -> None:
    found = agreement(arm(), 0.5, engines=(*ENGINES, "reference"), ladder=SHORT)
    assert words(found) == dict.fromkeys((*SOUND, "reference"), "agrees")
    assert found.until == pytest.approx(0.5)
    assert found.bar < 1e-4


def test_a_wrong_inertia_is_singled_out_on_the_arm_too() -> None:
    faults = {"mujoco again": heavier_to_turn()}
    found = agreement(arm(), 0.5, faults, engines=(*ENGINES, "mujoco again"), ladder=SHORT)
    assert words(found) == dict.fromkeys(SOUND, "agrees") | {"mujoco again": "converges elsewhere"}


def test_an_engine_that_leaves_the_numbers_at_its_finest_step_diverged() -> None:
    """It explodes at these steps and holds at finer ones: a ladder that stops here has no limit."""
    faults = {"mujoco again": explosive(1e-3)}
    found = agreement(arm(), 1.0, faults, engines=("mujoco again",), tracks=("default",), ladder=(1 / 240, 1 / 480, 1 / 960))
    (one,) = found.sides
    assert one.word == "diverged"
    assert "at every step" in one.why
    ladder = tuple(1 / 960 / 2**k for k in range(5))
    finer = agreement(arm(), 1.0, faults, engines=("mujoco again",), tracks=("default",), ladder=ladder)
    assert finer.sides[0].word == "converges"
    assert "diverged at 1.04 ms" in side_sentence(finer.sides[0], finer, {})


def test_too_few_steps_are_said_so() -> None:
    found = agreement(pendulum(), 1.0, engines=("mujoco",), ladder=(1 / 240, 1 / 480))
    assert found.sides[0].word == "cannot"
    assert "2 steps answered, 3 are needed" in found.sides[0].why


def test_what_hangs_still_is_said_to_and_what_swings_is_not() -> None:
    hanging, swinging = agreement(pendulum(start=0.0), 0.5), agreement(pendulum(), 0.5)
    assert hanging.still
    assert f"{STILL}{JOINTED}." in scene_words(hanging, {})
    assert hanging.scene is not None
    loose = replace(hanging, scene=replace(hanging.scene, joints=()))  # no scenario moves what has no joint
    assert f"{STILL}." in scene_words(loose, {})
    assert not swinging.still
    assert not any(STILL in line for line in scene_words(swinging, {}))


def flown(power: float, size: float, elsewhere: float = 0.0) -> tuple[Rung, ...]:
    """Runs of a ball that flies at 1 m/s and errs by size (240 h)^power m/s at steps h; its limit is `elsewhere` [m/s] off."""
    runs = []
    for dt in LADDER:
        run = Trajectory.of(np.arange(61) / 60, 1)
        run.p_WB[:, 0, 0] = (1.0 + elsewhere + size * (240 * dt) ** power) * run.time
        runs.append(
            Rung(dt=dt, substep=dt, trial="", status="passed", reason="", run=run, integrator="semi_implicit_euler")
        )  # fmt: skip
    return tuple(runs)


def of_orders(**sides: tuple[Rung, ...]) -> Agreement:
    scale, first = extent(ball()), {"semi_implicit_euler": 1}
    limits = {(name, "tuned"): own_limit(scale, rungs, first) for name, rungs in sides.items()}
    return judged(ball(), 1.0, limits, ())


def test_an_order_above_the_integrators_own_makes_no_camp() -> None:
    """Two of order 2.6 that end alike and elsewhere than two of order 1: without the rule, a tie."""
    wrong = flown(2.6, 0.02, 0.01)
    found = of_orders(a=flown(1.0, 0.01), b=flown(1.0, 0.02), c=wrong, d=wrong)
    assert words(found) == {"a": "agrees", "b": "agrees", "c": "does not converge", "d": "does not converge"}
    assert found.agreed == "A"
    assert side(found, "c").camps == ()
    assert "order 2.60, and its integrator has 1" in side_sentence(side(found, "c"), found, {})


def test_one_that_is_too_fast_and_lies_at_the_agreed_limit_agrees_without_a_vote() -> None:
    found = of_orders(a=flown(1.0, 0.01), b=flown(1.0, 0.02), c=flown(2.0, 0.02))
    assert words(found) == dict.fromkeys("abc", "agrees")
    assert not side(found, "c").votes
    assert side(found, "c").distance == pytest.approx(0.0, abs=found.bar)


def test_no_limit_is_agreed_is_not_said_where_orders_leave_too_few_to_tell() -> None:
    found = of_orders(a=flown(1.0, 0.01), c=flown(2.6, 0.02, 0.01))
    assert found.agreed == ""
    headline = scene_words(found, {"c": "Engine C"})[0]
    assert headline.startswith("Whether there is one limit cannot be told yet: steps of Engine C draw together faster")
    kept = of_orders(a=flown(1.4, 0.01), b=flown(1.4, 0.02))
    assert kept.agreed == "A"


@pytest.mark.parametrize(("stiffness", "damping", "told"), [(1e6, 0.0, True), (1e6, 300.0, False), (10.0, 0.0, False)])
def test_a_swing_that_no_step_follows_is_told_unless_it_dies_away_at_once(stiffness: float, damping: float, told: bool) -> None:
    """On .1 kg m2 a drive of 1e6 N m/rad swings with 3162 rad/s, .82 of a radian a step of 1/3840 s and 3.3 at 1/960 s; one of
    10 with 10 rad/s. 300 N m s/rad take the swing away by e in .7 ms, and samples are 100 ms apart."""
    body = Body.box("arm", (0.1, 0.1, 0.1), mass=15.0, touches=False)  # m (a^2 + b^2) / 3 of its halves is .1 kg m2
    servo = Revolute(
        name="servo", parent="world", child="arm", anchor_W=(0, 0, 0), axis_W=(0, 1, 0),
        drive=Drive(stiffness=stiffness, damping=damping),
    )  # fmt: skip
    scene = Scene(bodies=(body,), joints=(servo,))
    at = at_rest_beside(scene, 0.0, 0.001)

    def words_at(dt: float) -> list[str]:
        rung = Rung(dt=dt, substep=dt, trial="", status="passed", reason="", run=at.value)
        limits = {(name, "tuned"): replace(at, rungs=(rung,)) for name in ("mujoco", "dart")}
        return [line for line in scene_words(judged(scene, 1.0, limits, ()), {}) if line.startswith("No step that was run")]

    assert words_at(1 / 3840) == []
    assert bool(words_at(1 / 960)) == told
    if told:
        assert "follows the swing of 'servo' (a period of 2 ms, hardly damped)" in words_at(1 / 960)[0]


def at_rest_beside(scene: Scene, off: float, bar: float) -> OwnLimit:
    """A limit, known to the end to a bar, that lies off a place by a share of the size."""
    time = np.linspace(0.0, 1.0, 11)
    run = Trajectory.of(time, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.p_WB[..., 0] += off * extent(scene).largest
    said = Convergence(until=1.0, ended="end", horizon=1.0, order=1.0, moved=bar, regular=1.0)
    return OwnLimit(kind="converges", horizons={}, rungs=(), said=said, value=run, bar=np.full(len(time), bar))


def test_what_never_leaves_the_bars_of_the_agreed_limit_agrees_though_its_camp_is_another() -> None:
    """The sharpest at 0 is confirmed from .015 with a bar of .02: known to .035. Who lies at -.03 is beyond the bars of both of
    them, .001 and .02, and within that."""
    scene = ball()
    limits = {
        ("mujoco", "tuned"): at_rest_beside(scene, 0.0, 0.001),
        ("dart", "tuned"): at_rest_beside(scene, 0.015, 0.02),
        ("bullet", "tuned"): at_rest_beside(scene, -0.03, 0.001),
    }
    found = judged(scene, 1.0, limits, ())
    assert found.bar == pytest.approx(0.035)
    assert side(found, "bullet").camps == ("B",)
    assert set(words(found).values()) == {"agrees"}
    assert not any("part at" in line for line in scene_words(found, {}))
    further = judged(scene, 1.0, limits | {("bullet", "tuned"): at_rest_beside(scene, -0.04, 0.001)}, ())
    assert side(further, "bullet").word == "converges elsewhere"
    assert any("part at" in line for line in scene_words(further, {}))


def test_contacts_that_may_lie_a_millimetre_apart_need_not_draw_together_within_a_third_of_it() -> None:
    """Halvings that move a small cube by .0018 and then .0020 of its size, as a solver that iterates does: of 85 mm a
    millimetre is .0118, and three times .0020 is less. Where nothing touches that is no convergence."""
    time = np.linspace(0.0, 1.0, 5)
    moved = np.array([[0.004], [0.0018], [0.0020]]) * np.ones(5)
    bar = np.full(5, 3 * 0.0020)
    steps = [8.0, 4.0, 2.0, 1.0]
    assert convergence(time, steps, moved, bar, 0.01).until is None
    assert convergence(time, steps, moved, bar, 0.01, granted=0.0118).until == 1.0
    assert convergence(time, steps, 2.5 * moved, bar, 0.01, granted=0.0118).until is None  # .005 is more than a third


def test_engines_that_part_in_the_middle_of_a_run_have_no_limit_from_then_on() -> None:
    """Two of them, as one up to .5 s, and then a tenth of the size apart: what they share until then is not denied."""
    scene = ball()
    limits = {(name, "tuned"): at_rest_beside(scene, 0.0, 0.001) for name in ("mujoco", "dart")}
    moved = limits["dart", "tuned"].value
    assert moved is not None
    moved.p_WB[moved.time >= 0.5, :, 0] += 0.1 * extent(scene).largest
    found = judged(scene, 1.0, limits, ())
    assert found.agreed == ""
    assert scene_words(found, {})[0].startswith("No limit is agreed from 0.5 s on. Camps: A: ")
