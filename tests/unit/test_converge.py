"""Converged references: the error bar covers the true error wherever that is known, and is not absurdly wide."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import sleep

import numpy as np
import pytest

from plumbline.adapters.reference import ADAPTER
from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.scene import Body, Box, PlacedShape, Plane, Scene, Sphere, Surface, box_inertia
from plumbline.harness.statistics.richardson import extrapolate
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trial.accuracy import judge
from plumbline.harness.trial.truth_cache import LONG, bounded, converged, ladder, truth_of

G = 9.81
SAMPLES = np.arange(31) / 60
GROUND = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))


def _scene(body: Body, friction: float = 0.0, restitution: float = 0.0) -> Scene:
    law = Surface(between=("default", "default"), static_friction=friction, kinetic_friction=friction, restitution=restitution)
    return Scene(bodies=(GROUND, body), surfaces=(law,))


def _sphere(z: float = 0.1, speed: float = 0.0, down: float = 0.0) -> Body:
    shape = PlacedShape(shape=Sphere(radius=0.1))
    return Body(
        name="ball", inertia=tuple(map(tuple, 0.004 * np.eye(3))), collision=(shape,), p_WB=(0, 0, z), v_WB=(speed, 0, -down)
    )


def _thrown(time: Floats, speed: float) -> tuple[Floats, Floats]:
    return np.stack([speed * time, 5 - G * time**2 / 2], axis=1), np.stack([speed + 0 * time, -G * time], axis=1)


def _stopping(time: Floats, speed: float) -> tuple[Floats, Floats]:
    t = np.minimum(time, speed / (0.4 * G))
    return np.stack([speed * t - 0.2 * G * t**2, 0.05 + 0 * t], axis=1), np.stack([speed - 0.4 * G * t, 0 * t], axis=1)


def _rolling(time: Floats, speed: float) -> tuple[Floats, Floats]:
    t = np.minimum(time, 2 * speed / (7 * 0.3 * G))
    v = speed - 0.3 * G * t
    return np.stack([speed * t - 0.15 * G * t**2 + v * (time - t), 0.1 + 0 * t], axis=1), np.stack([v, 0 * t], axis=1)


def _bouncing(time: Floats, speed: float) -> tuple[Floats, Floats]:
    """Thrown down from a gap of 0.37 m with e = 0.7, by events."""
    from tests.event_driven import FlyingSphere, ImpactLaw, Wall, solve_events

    ball = FlyingSphere(mass=1.0, radius=0.1, position=(0, 0, 0.47), velocity=(0, 0, -speed))
    motion = solve_events([ball], [Wall()], time, (0, 0, -G), on_walls=ImpactLaw(restitution=0.7))
    return motion.position[:, 0, ::2], motion.velocity[:, 0, ::2]


def _block(speed: float) -> Body:
    half = (0.2, 0.2, 0.05)
    return Body(
        name="block", inertia=box_inertia(1.0, half), p_WB=(0, 0, 0.05), v_WB=(speed, 0, 0),
        collision=(PlacedShape(shape=Box(half_extents=half)),),
    )  # fmt: skip


KNOWN: dict[str, tuple[Callable[[float], Scene], Callable[[Floats, float], tuple[Floats, Floats]]]] = {
    "projectile": (lambda speed: _scene(_sphere(5.0, speed)), _thrown),
    "block that stops": (lambda speed: _scene(_block(speed), friction=0.4), _stopping),
    "sphere that starts to roll": (lambda speed: _scene(_sphere(0.1, speed), friction=0.3), _rolling),
    "bouncing sphere": (lambda speed: _scene(_sphere(0.47, down=speed), restitution=0.7), _bouncing),
}


STARTS = (1.3, 1.34, 1.39, 1.43, 1.47)
ALL = [
    ("projectile", STARTS),
    ("block that stops", STARTS[::3]),
    ("bouncing sphere", STARTS),
    pytest.param("block that stops", STARTS, marks=pytest.mark.slow),
    pytest.param("sphere that starts to roll", STARTS, marks=pytest.mark.slow),  # its friction ends as that of the block does
]


@pytest.mark.parametrize(("name", "starts"), ALL)
def test_the_bar_covers_every_true_error_and_stays_within_a_thousand_of_the_largest(
    name: str, starts: tuple[float, ...]
) -> None:
    """Where within a step an event falls is luck, and so is a small error: the width is judged over several starts."""
    scene, known = KNOWN[name]
    errors, bars = [], []
    for speed in starts:
        truth = converged(scene(speed), SAMPLES, ADAPTER, 1 / 240)
        values = truth.trajectory.p_WB, truth.trajectory.v_WB
        errors.append([float(np.abs(v[:, 1, ::2] - k).max()) for v, k in zip(values, known(SAMPLES, speed), strict=True)])
        bars.append([truth.position_error, truth.velocity_error])
    assert (np.array(errors) <= bars).all()
    wide = np.max(bars, axis=0) > np.maximum(1000 * np.max(errors, axis=0), 1e-9)
    assert not wide[0]
    # Near an impact the velocity of a sample has either sign, and a bar that says so is right, not wide.
    assert not wide[1] or name == "bouncing sphere"


@pytest.mark.parametrize("fewest", [1, 2, 3, 4, 5, 6, 8, 15, 30])
def test_the_steps_of_a_ladder_have_no_common_factors(fewest: int) -> None:
    counts = ladder(fewest)
    assert counts[0] >= fewest
    assert all(np.gcd(a, b) == 1 for k, a in enumerate(counts) for b in counts[:k])


def test_a_smooth_first_order_error_is_extrapolated_and_an_erratic_one_is_not() -> None:
    """f = 1 + h + h^2 gives R_3 = 1 - h_3 h_4; with errors of either sign differences do not shrink, and f_4 stands."""
    counts = ladder(16)
    h = [1 / n for n in counts]
    smooth = extrapolate([np.array([1 + x + x * x]) for x in h], counts, 1e-15)
    assert smooth.value[0] == pytest.approx(1 - h[2] * h[3], rel=1e-14)
    assert h[2] * h[3] <= smooth.error <= 20 * h[3] ** 2
    assert smooth.order == pytest.approx(1.0, abs=0.1)
    wild = extrapolate([np.array([1 + s * x]) for s, x in zip((1, -1, 1, -1), h, strict=True)], counts, 1e-15)
    assert wild.value[0] == 1 - h[3]
    assert h[3] <= wild.error <= 20 * h[3]


def test_the_bar_is_roaches_factor_times_what_the_differences_say() -> None:
    """1.25 of the larger difference of extrapolants where the first order shows, 3 of the largest one of runs elsewhere.

    Of f = 1 + h + h^2 the extrapolants are 1 - h_i h_(i+1) by hand; of f = 1 -+ h differences are h_i + h_(i+1), and each is
    brought to the finest step by h_4 / h_(i+1).
    """
    counts = ladder(16)
    h = [1 / n for n in counts]
    made = [1 - h[k] * h[k + 1] for k in range(3)]
    left = max(abs(made[2] - made[1]), abs(made[1] - made[0]) * (h[2] / h[1]) ** 2)
    smooth = extrapolate([np.array([1 + x + x * x]) for x in h], counts, 1e-12)
    assert smooth.error == pytest.approx(1.25 * left + 3e-12, rel=1e-9)
    wild = extrapolate([np.array([1 + s * x]) for s, x in zip((1, -1, 1, -1), h, strict=True)], counts, 1e-12)
    assert wild.error == pytest.approx(3 * max((h[k] + h[k + 1]) * h[3] / h[k + 1] for k in range(3)) + 1e-12, rel=1e-9)


def test_samples_that_are_not_evenly_spaced_are_refused() -> None:
    with pytest.raises(NotMeasurable, match="not evenly spaced"):
        converged(KNOWN["projectile"][0](1.0), np.array([0.0, 0.1, 0.15]), ADAPTER, 1 / 240)


def _case(at_most: float) -> Case:
    return Case(
        name="impact_made", title="", question="", source="", truth="converged reference", duration=0.25, coarsest=1 / 120,
        scene=lambda _: _scene(_sphere(0.47), restitution=0.7),
        checks=(
            Check(metric=position_error_max, at_most=at_most, because="test"), Check(metric=WAY, at_most=0.0, because="test"),
        ),
    )  # fmt: skip


WAY = Metric(name="way", unit="m", source="test", measure=lambda run: float(run.actual.p_WB[-1, 1, 2]))
"""A length that no truth is needed for."""


def test_the_bar_is_added_to_the_bound_of_what_is_measured_against_the_truth_and_to_no_other(tmp_path: Path) -> None:
    case = _case(0.0)
    scene = case.scene(case.parameters)
    time = np.arange(16) / 60
    made = truth_of(case, scene, time, {}, tmp_path)
    assert made is not None
    assert made.position_error > 0.0
    off = Trajectory.of(time, 2)
    off.p_WB[:] = made.trajectory.p_WB
    off.p_WB[3, 1, 0] += 0.5 * made.position_error
    near, way = judge(case, scene, off, made)
    assert near.passed
    assert near.at_most == made.position_error
    assert "that the truth itself may be off" in near.because
    assert not way.passed
    assert way.at_most == 0.0
    off.p_WB[3, 1, 0] += made.position_error
    assert not judge(case, scene, off, made)[0].passed


def test_a_truth_is_made_once_and_read_back_bit_for_bit(tmp_path: Path) -> None:
    case, time = _case(0.0), np.arange(4) / 60
    first = truth_of(case, case.scene(case.parameters), time, {}, tmp_path)
    (kept,) = (tmp_path / "truths").iterdir()
    stamp = kept.stat().st_mtime_ns
    second = truth_of(case, case.scene(case.parameters), time, {}, tmp_path)
    assert kept.stat().st_mtime_ns == stamp
    assert first is not None
    assert second is not None
    assert np.array_equal(first.trajectory.p_WB, second.trajectory.p_WB)
    assert (first.position_error, first.velocity_error) == (second.position_error, second.velocity_error)
    truth_of(case, case.scene(case.parameters), time[:3], {}, tmp_path)
    assert len(list((tmp_path / "truths").iterdir())) == 2


def test_a_slow_closed_form_is_made_once_for_a_folder_and_anew_when_anything_changes(tmp_path: Path) -> None:
    calls: list[int] = []

    class P(Parameters):
        turn: float = 1.0

    def slow(time: Floats, p: P) -> Trajectory:
        calls.append(1)
        sleep(1.5 * LONG)
        truth = Trajectory.of(time, 1)
        truth.p_WB[:, 0, 0] = p.turn * time
        return truth

    case = replace(_case(0.0), truth="closed form", coarsest=None, expected=slow, parameters=P())
    time, later = np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, 6)
    first = truth_of(case, case.scene(case.parameters), time, {"turn": 2.0}, tmp_path)
    again = truth_of(case, case.scene(case.parameters), time, {"turn": 2.0}, tmp_path)
    assert first is not None
    assert again is not None
    np.testing.assert_array_equal(first.trajectory.p_WB, again.trajectory.p_WB)
    assert len(calls) == 1
    truth_of(case, case.scene(case.parameters), later, {"turn": 2.0}, tmp_path)
    truth_of(case, case.scene(case.parameters), time, {"turn": 3.0}, tmp_path)
    assert len(calls) == 3
    truth_of(case, case.scene(case.parameters), time, {"turn": 2.0}, None)
    assert len(calls) == 4


def test_slow_bounds_are_worked_out_once_for_a_folder_and_a_step(tmp_path: Path) -> None:
    calls: list[float] = []

    def slow(dt: float, _: Parameters) -> float:
        calls.append(dt)
        sleep(1.5 * LONG)
        return dt / 3.0

    case = replace(_case(0.0), checks=(Check(metric=position_error_max, at_most=slow, because="test"), *_case(0.0).checks[1:]))
    first, again = bounded(case, 0.1, 0.1, {}, tmp_path), bounded(case, 0.1, 0.1, {}, tmp_path)
    assert first.checks[0].at_most == again.checks[0].at_most == 0.1 / 3.0
    assert calls == [0.1]
    assert [check.metric for check in again.checks] == [check.metric for check in case.checks]
    bounded(case, 0.2, 0.2, {}, tmp_path)
    bounded(case, 0.1, 0.1, {}, None)
    assert calls == [0.1, 0.2, 0.1]
