"""The overhang metric on stacks that stand and fall by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.statics import harmonic_overhang, overhang_limit_error
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Surface
from plumbline.harness.trajectory import Trajectory

HALF, N = (0.25, 0.1, 0.05), 2
FACTORS = (0.5, 0.9, 1.2, 1.5)


def stage() -> Scene:
    """Of each factor a table that ends at x = 1 and two bricks, of which the lower has no overhang at all."""
    bodies = []
    for i, factor in enumerate(FACTORS):
        reach = factor * harmonic_overhang(N) * 2 * HALF[0]
        table = (PlacedShape(shape=Box(half_extents=(0.5, 0.2, 0.1))),)
        brick = (PlacedShape(shape=Box(half_extents=HALF)),)
        bodies += [
            Body(name=f"t{i}", motion="static", collision=table, p_WB=(0.5, i, 0.1)),
            Body(name=f"a{i}", collision=brick, p_WB=(1.0 - HALF[0], i, 0.25)),
            Body(name=f"b{i}", collision=brick, p_WB=(1.0 + reach - HALF[0], i, 0.35)),
        ]
    return Scene(bodies=tuple(bodies), surfaces=(Surface(),))


def run(fallen: set[int], sunk: float = 0.06) -> Trajectory:
    trajectory = Trajectory.of(np.arange(3.0), 3 * len(FACTORS))
    trajectory.p_WB[:] = [b.p_WB for b in stage().bodies]
    for i in fallen:
        trajectory.p_WB[-1, 3 * i + 2, 2] -= sunk
    return trajectory


def test_the_harmonic_limit_of_four_bricks_is_more_than_a_brick() -> None:
    assert [harmonic_overhang(n) for n in (1, 2, 4)] == pytest.approx([1 / 2, 3 / 4, 25 / 24])


@pytest.mark.parametrize(
    ("fallen", "middle"), [({2, 3}, 1.05), ({3}, 1.35), ({1, 2, 3}, 0.7), ({0, 1, 2, 3}, 0.25), (set(), 2.25), ({0, 3}, 0.25)]
)
def test_the_middle_of_the_bracket_is_the_limit_found(fallen: set[int], middle: float) -> None:
    assert overhang_limit_error(stage(), run(fallen)) == pytest.approx(abs(middle - 1))


def test_a_brick_that_settles_by_less_than_half_its_thickness_has_not_fallen() -> None:
    assert overhang_limit_error(stage(), run({1, 2, 3}, sunk=0.04)) == overhang_limit_error(stage(), run(set()))


@pytest.mark.parametrize(("others", "middle", "one_diverged"), [(4, 0.05, 0.2), (3, 0.2, 0.35)])
def test_of_eight_starts_the_middle_one_counts(others: int, middle: float, one_diverged: float) -> None:
    """The own start and `others` miss by .05, the rest by .35; what diverges counts as farther off than all."""
    fates = [{2, 3}] * others + [{3}] * (7 - others)
    starts = {f"start_{number}/p_WB": run(fallen).p_WB for number, fallen in enumerate(fates, start=1)}
    told = replace(run({2, 3}), streams=starts)
    assert overhang_limit_error(stage(), told) == pytest.approx(middle)
    starts["start_1/p_WB"][-1] = math.nan
    assert overhang_limit_error(stage(), told) == pytest.approx(one_diverged)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    broken = run({2, 3})
    broken.p_WB[1, 1, 0] = bad
    assert math.isnan(overhang_limit_error(stage(), broken))


def test_a_scene_without_bricks_and_a_run_without_samples_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="bricks"):
        overhang_limit_error(Scene(bodies=stage().bodies[:1]), Trajectory.of(np.arange(2.0), 1))
    with pytest.raises(NotMeasurable, match="sample"):
        overhang_limit_error(stage(), run(set()).between(5.0, 6.0))
