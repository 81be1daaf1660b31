"""The metric of contact flips on contact sets made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.contacts import contact_flips
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Contacts, Trajectory

STAGE = Scene(bodies=(Body(name="ground", motion="static"), Body(name="a"), Body(name="b")))


def touching(pairs: list[tuple[int, int]], force: float = 1.0) -> Contacts:
    k = len(pairs)
    zero = [[0.0, 0.0, 0.0]] * k
    return Contacts.of([a for a, _ in pairs], [b for _, b in pairs], zero, zero, [0.0] * k, [[0.0, 0.0, force]] * k)


def run(*contacts: Contacts) -> Trajectory:
    return replace(Trajectory.of(np.arange(len(contacts)) * 0.01, 3), dt=0.01, contacts=contacts)


FOUR = [(0, 1)] * 4 + [(1, 2)] * 4


def test_a_constant_set_never_flips_in_whatever_order_it_is_listed() -> None:
    assert contact_flips(STAGE, run(touching(FOUR), touching(FOUR[::-1]), touching(FOUR))) == 0.0


def test_each_point_that_comes_or_goes_counts_once_a_step() -> None:
    # Two points of one pair go (2), one comes back (1), and the other pair loses all four (4), in four steps.
    sets = [FOUR, FOUR[2:], FOUR[2:], FOUR[1:], FOUR[1:4]]
    assert contact_flips(STAGE, run(*(touching(s) for s in sets))) == pytest.approx(7 / 4)


def test_points_that_change_pairs_flip_although_their_number_stays() -> None:
    assert contact_flips(STAGE, run(touching([(0, 1)]), touching([(0, 2)]))) == 2.0


def test_a_listed_point_without_force_does_not_touch() -> None:
    near = touching([(0, 2)], force=0.0)
    first = touching([(0, 1)])
    joined = Contacts(*(np.concatenate((getattr(first, f), getattr(near, f))) for f in first.__slots__))
    assert contact_flips(STAGE, run(first, joined, first)) == 0.0


def test_bodies_that_touch_nothing_do_not_pass_for_steady_ones() -> None:
    assert math.isnan(contact_flips(STAGE, run(touching([]), touching([]))))


def test_what_is_not_finite_is_never_swallowed() -> None:
    assert math.isnan(contact_flips(STAGE, run(touching(FOUR), touching(FOUR, force=math.nan))))


def test_missing_contacts_and_skipped_steps_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no contacts"):
        contact_flips(STAGE, Trajectory.of(np.arange(3.0), 3))
    with pytest.raises(NotMeasurable, match="every step"):
        contact_flips(STAGE, replace(run(touching(FOUR), touching(FOUR)), dt=0.005))
    with pytest.raises(NotMeasurable, match="samples, expected at least"):
        contact_flips(STAGE, run(touching(FOUR)))
