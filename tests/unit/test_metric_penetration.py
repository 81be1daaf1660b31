"""The penetration metric on gaps made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.metric import NotMeasurable
from harness.metrics.penetration import PENETRATION
from harness.scene import Body, Scene
from harness.trajectory import Contacts, Trajectory

STAGE = Scene(bodies=(Body(name="ground", motion="static"), Body(name="a")))


def run(*gaps: list[float]) -> Trajectory:
    contacts = tuple(
        Contacts.of([0] * len(g), [1] * len(g), [[0.0] * 3] * len(g), [[0.0, 0.0, 1.0]] * len(g), g, [[0.0] * 3] * len(g))
        for g in gaps
    )
    return replace(Trajectory.of(np.arange(len(gaps)) * 0.1, 2), contacts=contacts)


def test_the_deepest_point_of_all_instants_counts() -> None:
    assert PENETRATION(STAGE, run([0.1, -0.001], [], [-0.003, 0.0])) == 0.003


@pytest.mark.parametrize("gaps", [[[], []], [[0.02, 0.0], [0.5]]])
def test_gaps_and_no_contact_at_all_are_no_penetration(gaps: list[list[float]]) -> None:
    assert PENETRATION(STAGE, run(*gaps)) == 0.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    assert math.isnan(PENETRATION(STAGE, run([0.1], [bad, -0.2])))
    broken = run([0.1])
    broken.p_WB[0, 1, 0] = bad
    assert math.isnan(PENETRATION(STAGE, broken))


def test_missing_contacts_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no contacts"):
        PENETRATION(STAGE, Trajectory.of(np.arange(3.0), 2))
    with pytest.raises(NotMeasurable, match="no samples"):
        PENETRATION(STAGE, run())
