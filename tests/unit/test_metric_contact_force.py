"""The support-force metric on contact forces made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metric.contact_impulses import impulses_of
from plumbline.harness.metrics.contacts import support_force_error
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Contacts, Trajectory

G = 9.81
# The wall stands after the boxes, so that it is body B of its contacts.
STAGE = Scene(
    bodies=(
        Body(name="ground", motion="static"),
        Body(name="a", mass=2.0),
        Body(name="b", mass=3.0),
        Body(name="wall", motion="static"),
    )
)


def run(*instants: list[tuple[int, int, tuple[float, float, float]]]) -> Trajectory:
    contacts = tuple(
        Contacts.of(
            [a for a, _, _ in forces],
            [b for _, b, _ in forces],
            [[0.0] * 3] * len(forces),
            [[0.0, 0.0, 1.0]] * len(forces),
            [0.0] * len(forces),
            [list(f) for _, _, f in forces],
        )
        for forces in instants
    )
    return replace(Trajectory.of(np.arange(len(instants)) * 0.1, 4), contacts=contacts)


def test_a_ground_that_bears_all_the_weight_has_no_error() -> None:
    assert support_force_error(STAGE, run([(0, 1, (0, 0, 5 * G)), (1, 2, (0, 0, 3 * G))])) == pytest.approx(0.0, abs=1e-15)


def test_a_wall_that_is_body_b_counts_with_its_sign_turned() -> None:
    # The force on the wall points down, so the wall holds body b up.
    assert support_force_error(STAGE, run([(0, 1, (0, 0, 2 * G)), (2, 3, (0, 0, -3 * G))])) == pytest.approx(0.0, abs=1e-15)


def test_the_mean_over_the_window_counts() -> None:
    assert support_force_error(STAGE, run([(0, 1, (0, 0, 6 * G))], [(0, 1, (0, 0, 4 * G))])) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("mean", "error"), [(5.0, 0.0), (4.5, 0.1)])
def test_the_impulse_of_all_steps_counts_where_it_was_summed_up_and_not_what_samples_show(mean: float, error: float) -> None:
    """Samples meet the forces where they are large; what came before the first of them is no part of the mean."""
    shaking = run(*[[(0, 1, (0, 0, 9 * G))]] * 4)
    stretches = [1e3, *np.diff(shaking.time)]
    sums = [{(0, 1): np.array([0.0, 0.0, seconds * mean * G])} for seconds in stretches]
    borne = replace(shaking, streams=impulses_of(list(shaking.time), sums))
    assert support_force_error(STAGE, borne) == pytest.approx(error, abs=1e-14)
    assert support_force_error(STAGE, borne.between(0.1, 0.3)) == pytest.approx(error, abs=1e-14)
    sums[-1][0, 1][:] = math.nan
    assert math.isnan(support_force_error(STAGE, replace(borne, streams=impulses_of(list(shaking.time), sums))))


@pytest.mark.parametrize(
    ("force", "error"), [((0, 0, 4 * G), 0.2), ((0, 0, 5.5 * G), 0.1), ((0.5 * G, 0, 5 * G), 0.1), ((0, 0, -5 * G), 2.0)]
)
def test_missing_surplus_and_sideways_forces_are_errors(force: tuple[float, float, float], error: float) -> None:
    assert support_force_error(STAGE, run([(0, 1, force)])) == pytest.approx(error)


def test_forces_between_movable_bodies_bear_nothing() -> None:
    assert support_force_error(STAGE, run([(1, 2, (0, 0, 5 * G))])) == pytest.approx(1.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    assert not math.isfinite(support_force_error(STAGE, run([(0, 1, (0.0, 0.0, bad))])))
    broken = run([(0, 1, (0, 0, 5 * G))])
    broken.v_WB[0, 1, 0] = bad
    assert math.isnan(support_force_error(STAGE, broken))


def test_missing_contacts_and_missing_weight_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no contacts"):
        support_force_error(STAGE, Trajectory.of(np.arange(3.0), 4))
    floating = Scene(bodies=STAGE.bodies, gravity=(0.0, 0.0, 0.0))
    with pytest.raises(NotMeasurable, match="weight"):
        support_force_error(floating, run([]))
