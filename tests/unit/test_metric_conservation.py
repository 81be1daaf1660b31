"""Energy, momentum, phase and joint gap: planted leaks are measured, conserved motion is not flagged."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import (
    angular_momentum_drift_max,
    energy_drift_final,
    energy_drift_max,
    energy_drift_staggered_max,
    momentum_drift_max,
)
from plumbline.harness.metrics.joints import joint_gap_final, joint_gap_max
from plumbline.harness.metrics.periods import period_error, phase_error
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Drive,
    Limits,
    Prismatic,
    Revolute,
    Scene,
    Spring,
    Surface,
    principal_inertia,
)
from plumbline.harness.trajectory import Trajectory

SPRING = Prismatic(
    name="slide", parent=WORLD, child="mass", anchor_W=(0, 0, 0), axis_W=(1, 0, 0), spring=Spring(stiffness=8.0, rest=0.0)
)
OSCILLATOR = Scene(bodies=(Body(name="mass", mass=2.0),), joints=(SPRING,), gravity=(0.0, 0.0, 0.0))
RATE = 2.0
"""sqrt(8/2) rad/s."""


def _oscillation(time: np.ndarray, rate: float = RATE, amplitude: float = 0.5, dt: float = 0.0) -> Trajectory:
    made = replace(Trajectory.of(time, 1), dt=dt)
    made.p_WB[:, 0, 0] = amplitude * np.sin(rate * made.time)
    made.v_WB[:, 0, 0] = amplitude * rate * np.cos(rate * (made.time - dt / 2))
    return made


TIME = np.linspace(0.0, 20.0, 1201)


def test_a_mass_on_a_spring_keeps_its_energy() -> None:
    truth = _oscillation(TIME)
    assert energy_drift_max(OSCILLATOR, truth, truth) < 1e-14
    assert energy_drift_staggered_max(OSCILLATOR, truth, truth) < 1e-14


def test_an_energy_that_decays_is_measured_as_the_share_that_is_lost() -> None:
    truth, answer = _oscillation(TIME), _oscillation(TIME)
    decay = np.exp(-0.005 * TIME)[:, None, None]
    lossy = replace(answer, p_WB=answer.p_WB * decay, v_WB=answer.v_WB * decay)
    assert energy_drift_final(OSCILLATOR, lossy, truth) == pytest.approx(1 - np.exp(-0.2), rel=1e-12)
    assert energy_drift_max(OSCILLATOR, lossy, truth) == pytest.approx(1 - np.exp(-0.2), rel=1e-12)


def test_half_a_step_between_position_and_velocity_is_seen_raw_and_gone_corrected() -> None:
    truth, staggered = _oscillation(TIME), _oscillation(TIME, dt=1 / 60)
    # cos^2(x - h) - cos^2(x) lies within h of 0 to both sides, h = w dt/2; its start is at the middle of that range.
    assert energy_drift_max(OSCILLATOR, staggered, truth) == pytest.approx(RATE / 60 / 2, rel=0.05)
    # What is left is of second order: v is moved by its derivative at the staggered instant, an error (w dt/2)^2/2 each.
    assert energy_drift_staggered_max(OSCILLATOR, staggered, truth) < 2 * (RATE / 120) ** 2


def test_kinetic_energy_of_a_turning_body_uses_its_inertia_in_the_body_frame() -> None:
    scene = Scene(bodies=(Body(name="a", inertia=principal_inertia(1, 2, 3), w_WB=(1, 0, 0)),), gravity=(0, 0, 0))
    made = Trajectory.of(np.linspace(0, 1, 5), 1)
    made.w_WB[:, 0] = (1.0, 0.0, 0.0)
    # From the second sample on the body stands turned by 90 degrees about z: W's x is the body's -y, of twice the inertia.
    made.q_WB[1:, 0] = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    assert energy_drift_max(scene, made) == pytest.approx(1.0, rel=1e-12)
    made.w_WB[1:, 0] *= np.sqrt(0.5)
    assert energy_drift_max(scene, made) < 1e-14


def test_energy_is_not_measured_where_it_is_not_conserved_or_has_no_scale() -> None:
    truth = _oscillation(TIME)
    driven = replace(SPRING, spring=None, drive=Drive(stiffness=1.0))
    damped = replace(SPRING, spring=Spring(stiffness=8.0, damping=1.0))
    for joint, word in ((driven, "driven"), (damped, "damped")):
        with pytest.raises(NotMeasurable, match=word):
            energy_drift_max(replace(OSCILLATOR, joints=(joint,)), truth, truth)
    still = Trajectory.of(TIME, 1)
    with pytest.raises(NotMeasurable, match="nothing moves"):
        energy_drift_max(OSCILLATOR, still)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_conservation_never_swallows_a_bad_number(bad: float) -> None:
    truth, answer = _oscillation(TIME), _oscillation(TIME)
    answer.v_WB[7, 0, 1] = bad
    with np.errstate(invalid="ignore"):
        metrics = (energy_drift_max, energy_drift_final, energy_drift_staggered_max, phase_error, period_error)
        assert not np.isfinite([m(OSCILLATOR, answer, truth) for m in metrics]).any()
        free = replace(OSCILLATOR, joints=())
        assert not np.isfinite(momentum_drift_max(free, answer))
        assert not np.isfinite(angular_momentum_drift_max(PAIR, _bad_pair(bad)))


PAIR = Scene(
    bodies=(
        Body(name="a", mass=1.0, inertia=principal_inertia(1, 2, 2.5), p_WB=(1, 0, 0), v_WB=(0, 1, 0), w_WB=(0, 0, 1)),
        Body(name="b", mass=3.0, p_WB=(-1, 0, 0), v_WB=(0, 0, 2)),
    )
)


def _pair() -> Trajectory:
    """Both fall freely; a spins about its own third axis."""
    made = Trajectory.of(np.linspace(0, 2, 21), 2)
    t = made.time[:, None, None]
    g = np.array([0.0, 0.0, -9.81])
    v0 = np.array([b.v_WB for b in PAIR.bodies])
    made.p_WB[:] = np.array([b.p_WB for b in PAIR.bodies]) + v0 * t + 0.5 * g * t**2
    made.v_WB[:] = v0 + g * t
    made.w_WB[:, 0, 2] = 1.0
    made.q_WB[:, 0, 0], made.q_WB[:, 0, 3] = np.cos(made.time / 2), np.sin(made.time / 2)
    return made


def _bad_pair(bad: float) -> Trajectory:
    made = _pair()
    made.w_WB[3, 1, 0] = bad
    return made


def test_free_fall_conserves_momentum_and_angular_momentum() -> None:
    # Rounding of momenta of 80 kg m/s and of moments of 60.
    assert momentum_drift_max(PAIR, _pair()) < 1e-12
    assert angular_momentum_drift_max(PAIR, _pair()) < 1e-13


def test_a_push_and_a_twist_are_measured() -> None:
    pushed = _pair()
    pushed.v_WB[-1] += (0.0, 0.3, 0.0)
    assert momentum_drift_max(PAIR, pushed) == pytest.approx(4 * 0.3, rel=1e-12)
    twisted = _pair()
    twisted.w_WB[-1, 1] += (0.1, 0.0, 0.0)
    # At the start: r x m v of both about the centre of mass and I w of a; b's inertia is 1.
    centre, drift = np.array([-0.5, 0, 0]), np.array([0, 0.25, 1.5])
    a = np.cross(np.array([1.0, 0, 0]) - centre, np.array([0, 1.0, 0]) - drift) + np.array([0, 0, 2.5])
    b = 3 * np.cross(np.array([-1.0, 0, 0]) - centre, np.array([0, 0, 2.0]) - drift)
    assert angular_momentum_drift_max(PAIR, twisted) == pytest.approx(0.1 / (np.linalg.norm(a) + np.linalg.norm(b)), rel=1e-10)


def test_momentum_is_not_measured_where_the_world_holds_a_body() -> None:
    with pytest.raises(NotMeasurable, match="holds to the world"):
        momentum_drift_max(OSCILLATOR, _oscillation(TIME))


def test_a_period_that_is_off_by_a_thousandth_is_measured_as_that() -> None:
    truth = _oscillation(TIME)
    slow = _oscillation(TIME, rate=RATE / 1.001)
    # The fourth-order interpolation errs by (w h)^4/100, 1e-8 at 60 samples a second.
    assert period_error(OSCILLATOR, slow, truth) == pytest.approx(1e-3, abs=1e-6)
    assert period_error(OSCILLATOR, truth, truth) == 0.0
    late = np.floor(20.0 * RATE / 1.001 / (2 * np.pi)) * 2 * np.pi * 1e-3
    assert phase_error(OSCILLATOR, slow, truth) == pytest.approx(late, rel=1e-3)
    assert phase_error(OSCILLATOR, truth, truth) == 0.0


def test_an_oscillator_that_stands_still_or_runs_double_has_no_small_phase_error() -> None:
    truth = _oscillation(TIME)
    still = Trajectory.of(TIME, 1)
    still.p_WB[:, 0, 0] = 0.1
    assert period_error(OSCILLATOR, still, truth) == np.inf
    assert phase_error(OSCILLATOR, still, truth) == np.inf
    assert phase_error(OSCILLATOR, _oscillation(TIME, rate=2 * RATE), truth) > 2 * np.pi


def test_a_passage_that_comes_after_the_end_is_no_lost_turn() -> None:
    """The truth passes upwards six times, at 3.14 s and so on; slower by so much, the answer's sixth comes at 20.5 s."""
    slower = 20.5 / (6 * np.pi)
    late = 5 * np.pi * (slower - 1)
    error = phase_error(OSCILLATOR, _oscillation(TIME, rate=RATE / slower), _oscillation(TIME))
    assert error == pytest.approx(2 * late, rel=1e-3)


def _two(joint: Ball | Distance | Prismatic | Revolute) -> tuple[Scene, Trajectory]:
    scene = Scene(bodies=(Body(name="a"), Body(name="b", p_WB=(2.0, 0, 0))), joints=(joint,))
    made = Trajectory.of(np.linspace(0, 1, 3), 2)
    # The whole turns as one by 90 degrees about z and moves: no joint opens.
    made.p_WB[:, 1] = (2.0, 0.0, 0.0)
    half = np.sqrt(0.5)
    made.q_WB[1:] = (half, 0.0, 0.0, half)
    made.p_WB[1:, 0], made.p_WB[1:, 1] = (0.0, 0.0, 5.0), (0.0, 2.0, 5.0)
    return scene, made


@pytest.mark.parametrize(
    ("joint", "move", "gap"),
    [
        (Ball(name="j", parent="a", child="b", anchor_W=(1, 0, 0)), (0.3, 0.4, 0.0), 0.5),
        (Revolute(name="j", parent="a", child="b", anchor_W=(1, 0, 0), axis_W=(0, 0, 1)), (0.3, 0.4, 0.0), 0.5),
        # In the turned frame the sliding axis x points along W's y.
        (Prismatic(name="j", parent="a", child="b", anchor_W=(1, 0, 0), axis_W=(1, 0, 0)), (0.3, 0.4, 0.0), 0.3),
        (Distance(name="j", parent="a", child="b", anchor_W=(0, 0, 0), child_anchor_W=(2, 0, 0)), (0.0, 0.4, 0.0), 0.4),
        (
            Distance(name="j", parent="a", child="b", anchor_W=(0, 0, 0), child_anchor_W=(2, 0, 0), limits=Limits(upper=2.3)),
            (0.0, 0.4, 0.0),
            0.1,
        ),
    ],
    ids=["ball", "revolute", "prismatic", "rod", "rope"],
)
def test_a_joint_pulled_open_shows_its_gap_and_a_moved_one_none(
    joint: Ball | Distance | Prismatic | Revolute, move: tuple[float, float, float], gap: float
) -> None:
    scene, made = _two(joint)
    assert joint_gap_max(scene, made) < 1e-14
    made.p_WB[-1, 1] += move
    assert joint_gap_max(scene, made) == pytest.approx(gap, rel=1e-12)
    assert joint_gap_final(scene, made) == pytest.approx(gap, rel=1e-12)
    made.p_WB[1, 0, 0] = np.nan
    assert np.isnan(joint_gap_max(scene, made))


def test_a_scene_without_joints_has_no_gap() -> None:
    with pytest.raises(NotMeasurable, match="no joint"):
        joint_gap_max(PAIR, _pair())


def test_momentum_is_not_measured_where_something_fixed_can_be_touched() -> None:
    """A cup on a floor is turned by the floor, and no engine has lost what the floor took."""
    law = Surface(between=("default", "default"), static_friction=0.5, kinetic_friction=0.5)
    standing = Scene(bodies=(Body.ground("default"), Body.ball("ball", 0.1, w_WB=(0.0, 0.0, 3.0))), surfaces=(law,))
    run = Trajectory.of(TIME, 2)
    for metric in (momentum_drift_max, angular_momentum_drift_max):
        with pytest.raises(NotMeasurable, match="body 'ground' stays and can be touched"):
            metric(standing, run)
    apart = replace(standing, surfaces=(), apart=(("default", "default"),))
    run.w_WB[:, 1, 2] = np.linspace(3.0, 2.7, len(TIME))
    assert angular_momentum_drift_max(apart, run) == pytest.approx(0.1)
