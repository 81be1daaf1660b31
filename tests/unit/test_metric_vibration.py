"""Vibration, pose and slip on motions made by hand: a planted fault is found at its size, a clean run is not flagged."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics.conservation import held_energy_gain_max
from plumbline.harness.metrics.jitter import vibration_frequency, vibration_rms
from plumbline.harness.metrics.joints import pose_error_max, pose_error_rms
from plumbline.harness.metrics.slide import foot_slip
from plumbline.harness.scene import Body, Drive, Revolute, Scene
from plumbline.harness.trajectory import Contacts, Floats, Trajectory

STIFFNESS, G = 50.0, 9.81
ARM = Revolute(
    name="arm",
    parent="base",
    child="arm",
    anchor_W=(0.0, 0.0, 1.0),
    axis_W=(0.0, 1.0, 0.0),
    position=0.2,
    drive=Drive(stiffness=STIFFNESS, damping=1.0, target=0.2),
)
LEG = replace(ARM, name="leg", child="leg", axis_W=(1.0, 0.0, 0.0), position=0.0, drive=None)
STAGE = Scene(
    bodies=(
        Body(name="ground", motion="static"),
        Body(name="base", mass=2.0, p_WB=(0.0, 0.0, 1.0)),
        Body(name="arm", p_WB=(0.0, 0.0, 1.0)),
        Body(name="leg", p_WB=(0.0, 0.0, 1.0)),
    ),
    joints=(ARM, LEG),
)
DT = 1 / 500


def rest(samples: int = 2001, dt: float = DT) -> Trajectory:
    run = replace(Trajectory.of(np.linspace(0.0, (samples - 1) * dt, samples), 4), dt=dt)
    run.p_WB[:] = [body.p_WB for body in STAGE.bodies]
    return run


def swing(rate: Floats, angle: Floats, dt: float = DT) -> Trajectory:
    """The arm alone turns about its hinge, while the base turns about the same axis at 0.1 rad/s."""
    run = rest(len(rate), dt)
    carried = 0.1 * run.time
    for k, turn in ((1, carried), (2, carried + angle), (3, carried)):
        run.q_WB[:, k, 0], run.q_WB[:, k, 2] = np.cos(turn / 2), np.sin(turn / 2)
        run.w_WB[:, k, 1] = 0.1
    run.w_WB[:, 2, 1] += rate
    return run


def trembling(amplitude: float, frequency: float, noise: float = 0.0, dt: float = DT) -> Trajectory:
    time = np.linspace(0.0, 4.0, round(4 / dt) + 1)
    rate = amplitude * np.sin(2 * np.pi * frequency * time) + noise * np.random.default_rng(1).standard_normal(len(time))
    return swing(rate, -amplitude / (2 * np.pi * frequency) * np.cos(2 * np.pi * frequency * time), dt)


@pytest.mark.parametrize("frequency", [7.0, 31.0, 113.0, 240.0])
def test_a_tremble_is_found_at_its_frequency_and_size(frequency: float) -> None:
    """A second of window resolves 1 Hz; a Hann window keeps a line's power to a part in a hundred."""
    run = trembling(0.02, frequency)
    assert vibration_frequency(STAGE, run) == pytest.approx(frequency, abs=1.0)
    assert vibration_rms(STAGE, run) == pytest.approx(0.02 / math.sqrt(2), rel=0.02)


def test_a_tremble_is_found_in_noise_of_twice_its_size() -> None:
    run = trembling(0.02, 31.0, noise=0.04)
    assert vibration_frequency(STAGE, run) == pytest.approx(31.0, abs=1.0)
    # Powers add: 0.02^2/2 + 0.04^2; a thousand samples estimate the noise's to some 5 %.
    assert vibration_rms(STAGE, run) == pytest.approx(math.sqrt(0.02**2 / 2 + 0.04**2), rel=0.1)


def test_a_rate_that_alternates_from_step_to_step_is_at_half_the_sampling_rate() -> None:
    time = np.linspace(0.0, 4.0, 2001)
    run = swing(np.where(np.arange(2001) % 2 == 0, 1e-3, -1e-3), 0.0 * time)
    assert vibration_frequency(STAGE, run) == pytest.approx(1 / (2 * DT), abs=1.0)
    assert vibration_rms(STAGE, run) == pytest.approx(1e-3, rel=0.05)


def test_rest_drift_and_what_the_whole_machine_does_are_no_vibration() -> None:
    time = np.linspace(0.0, 4.0, 2001)
    for run in (rest(), swing(0.0 * time, 0.0 * time), swing(0.05 * time, 0.025 * time**2)):
        assert vibration_rms(STAGE, run) < 1e-12
        assert vibration_frequency(STAGE, run) == 0.0


def test_what_settles_in_the_first_half_is_no_vibration() -> None:
    run = trembling(0.02, 31.0)
    run.w_WB[1000:, 2, 1] = 0.1
    assert vibration_rms(STAGE, run) < 1e-12


def test_pose_errors_are_angles_from_the_truth() -> None:
    run = swing(np.zeros(101), np.linspace(0.0, 0.1, 101))
    assert pose_error_max(STAGE, run, rest(101)) == pytest.approx(0.1, rel=1e-9)
    assert pose_error_rms(STAGE, run, rest(101)) == pytest.approx(0.1 * math.sqrt(201 / 600 / 2), rel=1e-9)
    assert pose_error_max(STAGE, rest(), rest()) < 1e-12
    with pytest.raises(NotMeasurable, match="no truth"):
        pose_error_max(STAGE, run)


def standing(run: Trajectory, force: float = 10.0) -> Trajectory:
    """The leg bears at one point of the ground, half a metre below it."""
    contact = Contacts.of([0], [3], [[0.1, 0.0, 0.5]], [[0.0, 0.0, 1.0]], [0.0], [[0.0, 0.0, force]])
    return replace(run, contacts=(contact,) * len(run))


def test_slip_is_the_way_of_the_point_that_bears() -> None:
    assert foot_slip(STAGE, standing(rest())) == 0.0
    slid = rest()
    slid.p_WB[:, 3, 0] += np.linspace(0.0, 3e-3, len(slid))
    slid.p_WB[:, 3, 2] -= 1e-2  # what sinks does not slip
    slid.p_WB[0, 3, 2] += 1e-2
    assert foot_slip(STAGE, standing(slid)) == pytest.approx(3e-3, rel=1e-9)
    twisted = rest()
    turn = np.linspace(0.0, 0.2, len(twisted))
    twisted.q_WB[:, 3, 0], twisted.q_WB[:, 3, 3] = np.cos(turn / 2), np.sin(turn / 2)
    assert foot_slip(STAGE, standing(twisted)) == pytest.approx(2 * 0.1 * math.sin(0.1), rel=1e-9)


def test_a_foot_that_bears_nothing_is_not_on_the_ground() -> None:
    assert foot_slip(STAGE, standing(rest(), force=0.0)) == math.inf
    with pytest.raises(NotMeasurable, match="no contacts"):
        foot_slip(STAGE, rest())


def test_held_energy_counts_weight_motion_and_the_springs_of_drives() -> None:
    # Base, arm and leg are 2, 1 and 1 kg; each term is planted apart.
    mass = 4.0
    risen = rest()
    risen.p_WB[-1, 1, 2] += 0.1
    assert held_energy_gain_max(STAGE, risen) == pytest.approx(2.0 * G * 0.1 / mass)
    moving = rest()
    moving.v_WB[-1, 2, 0] = 0.3
    assert held_energy_gain_max(STAGE, moving) == pytest.approx(0.5 * 0.3**2 / mass)
    strained = swing(np.zeros(101), np.linspace(0.0, 0.1, 101))
    strained.w_WB[:] = 0.0
    assert held_energy_gain_max(STAGE, strained) == pytest.approx(0.5 * STIFFNESS * 0.1**2 / mass)
    fallen = rest()
    fallen.p_WB[1:, 1, 2] -= 0.1
    assert held_energy_gain_max(STAGE, fallen) == 0.0


def test_a_drive_that_moves_is_no_spring() -> None:
    assert ARM.drive is not None
    moving = replace(ARM, drive=replace(ARM.drive, target_velocity=1.0))
    with pytest.raises(NotMeasurable, match="moves, pushes or has a limit"):
        held_energy_gain_max(Scene(bodies=STAGE.bodies, joints=(moving,)), rest())


@pytest.mark.parametrize(
    "metric", [vibration_rms, vibration_frequency, pose_error_max, pose_error_rms, foot_slip, held_energy_gain_max]
)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("place", [3, 1500])
def test_what_is_not_finite_is_never_swallowed(metric: Metric, bad: float, place: int) -> None:
    run = standing(rest())
    run.p_WB[place, 1] = bad
    with np.errstate(invalid="ignore"):
        assert not math.isfinite(metric(STAGE, run, rest()))


@pytest.mark.parametrize("metric", [vibration_rms, vibration_frequency])
def test_too_short_a_record_or_uneven_samples_have_no_spectrum(metric: Metric) -> None:
    with pytest.raises(NotMeasurable, match="samples"):
        metric(STAGE, rest(20))
    uneven = rest()
    uneven.time[1500:] += 0.5 * DT
    with pytest.raises(NotMeasurable, match="even"):
        metric(STAGE, uneven)
    with pytest.raises(NotMeasurable, match="no hinge"):
        metric(Scene(bodies=STAGE.bodies), rest())
