"""The split of a load on forces made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metrics.contacts import load_shares, load_split_error
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Contacts, Trajectory

G = 9.81
# The load stands between its supports, so that it is body A of one contact and body B of the other.
STAGE = Scene(
    bodies=(
        Body(name="ground", motion="static"),
        Body(name="left", mass=1.0),
        Body(name="load", mass=40.0),
        Body(name="right", mass=1.0),
    )
)


def run(left: float, right: float, *, ground: float = 0.0) -> Trajectory:
    """Shares of the load on the left, on the right and, past both, on the ground; the load pushes back on each support."""
    contacts = Contacts.of(
        [1, 3, 0, 0, 0],
        [2, 2, 2, 1, 3],
        [[0.0] * 3] * 5,
        [[0.0, 0.0, 1.0]] * 5,
        [0.0] * 5,
        [[0.0, 0.0, f * G] for f in (left * 40, right * 40, ground * 40, left * 40 + 1, right * 40 + 1)],
    )
    return replace(Trajectory.of(np.arange(3) * 0.1, 4), contacts=(contacts,) * 3)


def test_half_each_has_no_error() -> None:
    assert load_shares(Run(STAGE, run(0.5, 0.5))) == pytest.approx([0.5, 0.5])
    assert load_split_error(STAGE, run(0.5, 0.5)) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("left", "right", "error"), [(0.6, 0.4, 0.1), (0.0, 1.0, 0.5), (0.45, 0.45, 0.05), (-0.1, 1.1, 0.6)])
def test_what_one_bears_more_or_less_than_its_share_is_the_error(left: float, right: float, error: float) -> None:
    assert load_split_error(STAGE, run(left, right)) == pytest.approx(error)


def test_a_load_that_lies_on_the_ground_is_borne_by_no_support() -> None:
    assert load_split_error(STAGE, run(0.0, 0.0, ground=1.0)) == pytest.approx(0.5)


def test_of_equally_heavy_bodies_the_highest_is_the_load() -> None:
    bodies = [replace(b, mass=40.0, p_WB=(0.0, 0.0, 1.0 if b.name == "load" else 0.0)) for b in STAGE.bodies]
    assert load_shares(Run(Scene(bodies=tuple(bodies)), run(0.5, 0.5))) == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    assert not math.isfinite(load_split_error(STAGE, run(bad, 0.5)))
    broken = run(0.5, 0.5)
    broken.p_WB[1, 2, 0] = bad
    assert math.isnan(load_split_error(STAGE, broken))


def test_missing_contacts_and_supports_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="contacts"):
        load_split_error(STAGE, Trajectory.of(np.arange(3.0), 4))
    with pytest.raises(NotMeasurable, match="supports"):
        load_split_error(Scene(bodies=STAGE.bodies[:2]), run(0.5, 0.5))
