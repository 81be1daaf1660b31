"""The contact residuals on forces made by hand: a clean slide has none, and each planted fault shows in its own law alone."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics.contacts import cone_residual, dissipation_residual, signorini_residual
from plumbline.harness.scene import Body, Box, Effect, PlacedShape, Plane, Scene, Surface
from plumbline.harness.trajectory import Contacts, Trajectory

METRICS = (signorini_residual, cone_residual, dissipation_residual)

G, MASS, STATIC, KINETIC, DT = 9.81, 2.0, 0.5, 0.4, 0.01
ROUNDING = 1e-15  # of forces over the weight, both of order one
TURN = math.asin(G * DT)  # by how much weight may turn a slip of 1 m/s within a step [rad]
STAGE = Scene(
    bodies=(
        Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),)),
        Body(name="box", mass=MASS, collision=(PlacedShape(shape=Box(half_extents=(0.1, 0.1, 0.1))),), p_WB=(0.0, 0.0, 0.1)),
    ),
    surfaces=(Surface(static_friction=STATIC, kinetic_friction=KINETIC),),
)


def slide(
    speed: float = 1.0, gap: float = 0.0, force: tuple[float, float, float] | None = None, turned: bool = False
) -> Trajectory:
    """Three samples of a box that slides along x on one point, borne and rubbed as Coulomb says, or by `force` [N].

    Args: speed [m/s]; gap [m] of the point; turned: the record names the box as body A, its normal down.
    """
    run = replace(Trajectory.of(np.arange(3) * DT, 2), dt=DT)
    run.p_WB[:, 1, 2] = 0.1
    run.v_WB[:, 1, 0] = speed
    on_box = (-KINETIC * MASS * G, 0.0, MASS * G) if force is None else force
    sign = -1.0 if turned else 1.0
    contact = Contacts(
        np.array([1 if turned else 0]),
        np.array([0 if turned else 1]),
        np.zeros((1, 3)),
        np.array([[0.0, 0.0, sign]]),
        np.array([gap]),
        sign * np.array([on_box]),
    )
    return replace(run, contacts=(contact,) * 3)


def residuals(run: Trajectory) -> list[float]:
    return [metric(STAGE, run) for metric in (signorini_residual, cone_residual, dissipation_residual)]


@pytest.mark.parametrize("turned", [False, True])
def test_a_slide_under_coulombs_law_has_no_residual_whichever_body_comes_first(turned: bool) -> None:
    assert residuals(slide(turned=turned)) == pytest.approx([0.0, 0.0, 0.0], abs=ROUNDING)


def test_what_sticks_inside_its_cone_has_no_residual_whatever_the_direction() -> None:
    for angle in np.linspace(0, 2 * np.pi, 7):
        force = (0.49 * MASS * G * np.cos(angle), 0.49 * MASS * G * np.sin(angle), MASS * G)
        assert residuals(slide(speed=0.0, force=force)) == pytest.approx([0.0, 0.0, 0.0], abs=ROUNDING)


def test_a_force_outside_of_the_cone_is_seen() -> None:
    # The corner of a pyramid of friction 0.5: sqrt(2) times too long, by (sqrt(2) - 1) 0.5 weights.
    force = (STATIC * MASS * G, STATIC * MASS * G, MASS * G)
    found = residuals(slide(speed=0.0, force=force))
    assert found == pytest.approx([0.0, (math.sqrt(2) - 1) * STATIC, 0.0], abs=ROUNDING)


def test_a_force_that_pulls_is_seen_and_bears_no_friction() -> None:
    found = residuals(slide(speed=0.0, force=(0.1 * MASS * G, 0.0, -0.3 * MASS * G)))
    assert found == pytest.approx([0.3, 0.1, 0.0], abs=ROUNDING)


def test_a_force_across_a_gap_that_the_step_cannot_close_is_seen() -> None:
    # At rest a box falls by g dt^2 = 1 mm in a step of 10 ms; half of that may close, a centimetre may not.
    assert signorini_residual(STAGE, slide(gap=5e-4)) == 0.0
    assert signorini_residual(STAGE, slide(gap=1e-2)) == pytest.approx(1.0)
    falling = slide(gap=1e-2)
    falling.v_WB[:, 1, 2] = -2.0
    assert signorini_residual(STAGE, falling) == 0.0


def test_an_open_contact_without_force_is_none() -> None:
    assert residuals(slide(gap=1.0, force=(0.0, 0.0, 0.0))) == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("along", "across", "error"),
    [
        (KINETIC, 0.0, 2 * KINETIC * math.cos(TURN / 2)),
        (0.0, KINETIC, 2 * KINETIC * math.sin((math.pi / 2 - TURN) / 2)),
        (-KINETIC / 2, 0.0, KINETIC / 2),
        (0.0, 0.0, KINETIC),
    ],
)
def test_friction_along_the_slip_aside_of_it_or_too_weak_dissipates_too_little(
    along: float, across: float, error: float
) -> None:
    found = residuals(slide(force=(along * MASS * G, across * MASS * G, MASS * G)))
    assert found == pytest.approx([0.0, 0.0, error], abs=ROUNDING)


def test_a_slip_that_one_step_of_gravity_can_stop_has_no_direction_yet() -> None:
    assert dissipation_residual(STAGE, slide(speed=0.9 * G * DT, force=(0.0, 0.0, MASS * G))) == 0.0
    assert dissipation_residual(STAGE, slide(speed=1.1 * G * DT, force=(0.0, 0.0, MASS * G))) == pytest.approx(KINETIC)


def test_the_slip_is_that_of_the_point_not_of_the_centre() -> None:
    # A box that turns about y at v/r as a wheel would: its lowest point stands still, so that nothing rubs.
    rolling = slide(force=(0.0, 0.0, MASS * G))
    rolling.w_WB[:, 1, 1] = 10.0
    assert dissipation_residual(STAGE, rolling) == 0.0


def test_without_the_effect_of_friction_any_tangential_force_is_too_much() -> None:
    bare = replace(STAGE, narrow=Effect.FRICTION)
    assert cone_residual(bare, slide()) == pytest.approx(KINETIC)


def test_the_worst_instant_counts() -> None:
    run = slide()
    assert run.contacts is not None
    bad = replace(run.contacts[1], force_W=np.array([[0.0, 0.0, -0.25 * MASS * G]]))
    assert signorini_residual(STAGE, replace(run, contacts=(run.contacts[0], bad, run.contacts[2]))) == pytest.approx(0.25)


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: Metric, bad: float) -> None:
    assert math.isnan(metric(STAGE, slide(force=(0.0, 0.0, bad))))
    assert math.isnan(metric(STAGE, slide(gap=bad)))
    broken = slide()
    broken.v_WB[1, 1, 0] = bad
    assert math.isnan(metric(STAGE, broken))


@pytest.mark.parametrize("metric", METRICS)
def test_missing_contacts_samples_and_weight_are_not_measurable(metric: Metric) -> None:
    with pytest.raises(NotMeasurable, match="contacts"):
        metric(STAGE, replace(slide(), contacts=None))
    with pytest.raises(NotMeasurable, match="sample"):
        metric(STAGE, slide().between(5.0, 6.0))
    with pytest.raises(NotMeasurable, match="weight"):
        metric(replace(STAGE, gravity=(0.0, 0.0, 0.0)), slide())


@pytest.mark.parametrize(("share", "missed"), [(0.99, 0.0), (2.0, 2 * math.sin(TURN / 2))])
def test_a_force_may_follow_the_slip_of_any_instant_of_its_step_and_no_other(share: float, missed: float) -> None:
    """A force turned by twice the angle that weight may turn the slip by is off by the chord of the rest."""
    angle = share * TURN
    force = (-KINETIC * MASS * G * math.cos(angle), -KINETIC * MASS * G * math.sin(angle), MASS * G)
    assert dissipation_residual(STAGE, slide(force=force)) == pytest.approx(KINETIC * missed, abs=ROUNDING)


def test_a_force_along_the_slip_that_is_too_weak_is_off_by_what_it_lacks() -> None:
    """However uncertain the slip's direction is, a fifth of mu N is missing here."""
    force = (-0.8 * KINETIC * MASS * G, 0.0, MASS * G)
    assert dissipation_residual(STAGE, slide(speed=0.2, force=force)) == pytest.approx(0.2 * KINETIC, abs=ROUNDING)


@pytest.mark.parametrize(("share", "missed"), [(1.0, 0.0), (0.5, 0.5 * (1 - math.sin(0.3) / 0.3))])
def test_a_force_that_turns_with_its_body_may_be_its_mean_over_the_step(share: float, missed: float) -> None:
    """A body that turns by 0.6 rad in a step turns the slip of its points along: what is shorter than that mean is missing."""
    mean = 1 - (1 - math.sin(0.3) / 0.3) * (2 - share)
    run = slide(force=(-mean * KINETIC * MASS * G, 0.0, MASS * G))
    run.w_WB[:, 1, 2] = 0.6 / DT
    assert dissipation_residual(STAGE, run) == pytest.approx(KINETIC * missed, abs=ROUNDING)
