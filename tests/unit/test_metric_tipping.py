"""The fates of boxes on inclines, made by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.statics import tipping_angle_error, wrong_fates
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Surface, axis_angle, rotate
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.kinematics import product

METRICS = (wrong_fates, tipping_angle_error)

HALF, G, T = (0.06, 0.1, 0.1), 9.81, 2.0
TALL = (PlacedShape(shape=Box(half_extents=HALF)),)
ROUGH, SLIPPERY = 0.9, 0.2
# (tan, friction, fate by statics with b/h = 0.6)
BOXES = [
    (0.5, ROUGH, "holds"),
    (0.58, ROUGH, "holds"),
    (0.62, ROUGH, "tips"),
    (0.8, ROUGH, "tips"),
    (0.15, SLIPPERY, "holds"),
    (0.25, SLIPPERY, "slides"),
    (0.7, SLIPPERY, "slides"),
]


def stage() -> Scene:
    bodies, laws = [], []
    for i, (slope, mu, _) in enumerate(BOXES):
        turn = axis_angle((0.0, 1.0, 0.0), math.atan(slope))
        bodies += [
            Body(name=f"i{i}", motion="static", material=f"i{i}", collision=TALL, q_WB=turn),
            Body(name=f"b{i}", material=f"b{i}", collision=TALL, q_WB=turn),
        ]
        laws.append(Surface(between=(f"b{i}", f"i{i}"), static_friction=mu, kinetic_friction=mu))
    n = len(BOXES)
    apart = [(f"b{i}", f"i{j}") for i in range(n) for j in range(n) if i != j]
    apart += [(f"b{i}", f"b{j}") for i in range(n) for j in range(i + 1, n)]
    return Scene(bodies=tuple(bodies), surfaces=tuple(laws), apart=tuple(apart))


def run(fates: list[str]) -> Trajectory:
    """Each box at rest, sliding as Coulomb says (at least at a tenth of g), or turned over about its lower edge."""
    scene, time = stage(), np.linspace(0.0, T, 5)
    made = Trajectory.of(time, len(scene.bodies))
    for place, body in enumerate(scene.bodies):
        made.q_WB[:, place] = body.q_WB
    for i, ((slope, mu, _), fate) in enumerate(zip(BOXES, fates, strict=True)):
        place, angle = 2 * i + 1, math.atan(slope)
        if fate == "slides":
            a = max(G * (math.sin(angle) - mu * math.cos(angle)), 0.1 * G)
            made.p_WB[:, place] = np.outer(a * time**2 / 2, rotate(scene.bodies[place].q_WB, (1.0, 0.0, 0.0)))
        if fate == "tips":
            made.q_WB[-1, place] = product(made.q_WB[-1, place], np.array(axis_angle((0.0, 1.0, 0.0), math.pi / 2)))
    return made


TRUE = [fate for _, _, fate in BOXES]


def test_boxes_with_the_fates_of_statics_have_no_error() -> None:
    assert wrong_fates(stage(), run(TRUE)) == 0.0
    middle = (math.atan(0.58) + math.atan(0.62)) / 2
    assert tipping_angle_error(stage(), run(TRUE)) == pytest.approx(abs(middle / math.atan(0.6) - 1))


@pytest.mark.parametrize("place", range(len(BOXES)))
@pytest.mark.parametrize("fate", ["holds", "slides", "tips"])
def test_every_other_fate_of_every_box_counts_as_one_wrong(place: int, fate: str) -> None:
    fates = [*TRUE[:place], fate, *TRUE[place + 1 :]]
    assert wrong_fates(stage(), run(fates)) == float(fate != TRUE[place])


def test_a_box_that_tips_early_moves_the_threshold() -> None:
    middle = (math.atan(0.5) + math.atan(0.58)) / 2
    found = tipping_angle_error(stage(), run(["holds", "tips", *TRUE[2:]]))
    assert found == pytest.approx(abs(middle / math.atan(0.6) - 1))


def test_a_box_that_creeps_by_a_tenth_of_its_length_still_holds() -> None:
    made = run(TRUE)
    made.p_WB[-1, 1] += 0.1 * 2 * HALF[0] * np.array(rotate(stage().bodies[1].q_WB, (0.99, 0.0, 0.0)))
    assert wrong_fates(stage(), made) == 0.0


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    made = run(TRUE)
    made.p_WB[2, 3, 0] = bad
    assert callable(metric)
    assert math.isnan(metric(stage(), made))


def test_no_time_and_no_incline_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="time"):
        wrong_fates(stage(), run(TRUE).between(5.0, 6.0))
    with pytest.raises(NotMeasurable, match="nothing to rest on"):
        wrong_fates(Scene(bodies=(Body(name="a", collision=TALL),)), Trajectory.of(np.arange(2.0), 1))
