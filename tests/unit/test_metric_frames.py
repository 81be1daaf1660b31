"""The A-frame metrics on houses that stand and fall by hand."""

import math

import numpy as np
import pytest

from plumbline.cases.stack_card_house import P, scene
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.statics import critical_friction, frame_friction_error, frame_standing_time
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

METRICS = (frame_friction_error, frame_standing_time)

FIRM, LOOSE = 1, 4  # the first card of each house


def run(**falls: float) -> Trajectory:
    """The houses of the case with margin 0.2, of which some fall flat at a time [s]."""
    stage = scene(P(margin=0.2))
    made = Trajectory.of(np.arange(21) * 0.1, len(stage.bodies))
    made.p_WB[:] = [b.p_WB for b in stage.bodies]
    for name, time in falls.items():
        # One card alone is enough: the other may come to lie on it.
        made.p_WB[made.time >= time - 1e-9, (FIRM if name == "firm" else LOOSE) + 1, 2] = 0.02
    return made


def test_thin_cards_need_half_the_tangent() -> None:
    assert critical_friction(math.radians(30), 1.0, 0.0) == pytest.approx(math.tan(math.radians(30)) / 2)


@pytest.mark.parametrize(
    ("falls", "error"),
    [({"loose": 1.0}, 0.0), ({}, 0.6), ({"loose": 1.0, "firm": 1.5}, 0.8), ({"firm": 1.5}, 0.8)],
)
def test_the_middle_between_falling_and_standing_is_the_friction_found(falls: dict[str, float], error: float) -> None:
    # All stand: (0 + 0.8)/2; all fall: (1.2 + 2.4)/2; so too where the wrong one falls, since none stands with more.
    assert frame_friction_error(scene(P(margin=0.2)), run(**falls)) == pytest.approx(error, abs=1e-12)


def test_only_the_frame_that_should_stand_is_timed() -> None:
    stage = scene(P(margin=0.2))
    assert frame_standing_time(stage, run()) == 2.0
    assert frame_standing_time(stage, run(loose=0.3)) == 2.0
    assert frame_standing_time(stage, run(firm=0.7)) == pytest.approx(0.7)


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    made = run(loose=1.0)
    made.v_WB[2, 1, 0] = bad
    assert callable(metric)
    assert math.isnan(metric(scene(P(margin=0.2)), made))


def test_no_pair_of_cards_and_no_samples_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="pairs"):
        frame_standing_time(Scene(bodies=(Body(name="a"),)), Trajectory.of(np.arange(2.0), 1))
    with pytest.raises(NotMeasurable, match="no sample"):
        frame_standing_time(scene(P()), run().between(5.0, 6.0))
