"""The time of collapse: each sign of a broken run is planted and found at its time, under its name."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.collapse import collapse_time, first_break
from plumbline.harness.scene import (
    Body,
    Box,
    Cylinder,
    Drive,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    Surface,
    axis_angle,
    box_inertia,
)
from plumbline.harness.trajectory import Contacts, Trajectory

HALF, G = (0.1, 0.2, 0.3), 9.81
CUBE = (PlacedShape(shape=Box(half_extents=HALF)),)
STAGE = Scene(
    bodies=(
        Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),)),
        Body(name="low", mass=2.0, inertia=box_inertia(2.0, HALF), collision=CUBE, p_WB=(0.0, 0.0, 0.3)),
        Body(name="top", mass=2.0, inertia=box_inertia(2.0, HALF), collision=CUBE, p_WB=(0.0, 0.0, 0.9)),
    ),
    surfaces=(Surface(static_friction=0.5, kinetic_friction=0.5),),
)
AVAILABLE = 2 * G * (0.3 + 0.9)
"""What the stage can turn into motion [J]: both bodies fall to z = 0."""


def stand(scene: Scene = STAGE) -> Trajectory:
    run = Trajectory.of(np.arange(11) * 0.1, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.q_WB[:] = [body.q_WB for body in scene.bodies]
    return run


def test_what_stands_stands_to_the_end() -> None:
    assert first_break(STAGE, stand()) == (1.0, "")
    assert collapse_time(STAGE, stand()) == 1.0


@pytest.mark.parametrize(("height", "time"), [(0.46, 1.0), (0.44, 0.7)])
def test_a_top_below_half_its_height_is_a_collapse(height: float, time: float) -> None:
    run = stand()
    run.p_WB[7:, 2] = (1.0, 0.0, height)
    assert first_break(STAGE, run) == (pytest.approx(time), "height" if time < 1 else "")


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_energy_a_thousand_times_what_is_there_is_a_collapse_whether_of_motion_or_of_turning(share: float) -> None:
    moves, turns = stand(), stand()
    moves.v_WB[4, 1, 0] = math.sqrt(share * 1e3 * AVAILABLE)
    # About the body's z axis, which a quarter turn about x has laid along -y of the world.
    turns.q_WB[4, 1] = axis_angle((1.0, 0.0, 0.0), math.pi / 2)
    turns.w_WB[4, 1, 1] = math.sqrt(2 * share * 1e3 * AVAILABLE / box_inertia(2.0, HALF)[2][2])
    expected = (pytest.approx(0.4), "energy") if share > 1 else (1.0, "")
    assert first_break(STAGE, moves) == expected
    assert first_break(STAGE, turns) == expected


@pytest.mark.parametrize(("depth", "name"), [(0.09, ""), (0.11, "penetration")])
def test_a_body_deeper_in_another_than_half_the_thinner_is_a_collapse_whatever_is_listed(depth: float, name: str) -> None:
    listed = Contacts.of([0], [1], [[0.0] * 3], [[0.0, 0.0, 1.0]], [-1.0], [[0.0] * 3])
    run = replace(stand(), contacts=(listed,) * 11)
    run.p_WB[2:, 1, 2] -= depth
    assert first_break(STAGE, run) == (pytest.approx(0.2 if name else 1.0), name)


@pytest.mark.parametrize(("angle", "name"), [(0.45, ""), (0.55, "drive"), (-0.55, "drive")])
def test_a_drive_half_a_radian_off_is_a_collapse(angle: float, name: str) -> None:
    arm = Body(name="arm", p_WB=(0.0, 0.0, 0.0))
    drive = Drive(stiffness=1.0, damping=0.1, target=0.2)
    hinge = Revolute(name="hinge", parent="world", child="arm", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0), drive=drive)
    scene = Scene(bodies=(arm,), joints=(hinge,), gravity=(0.0, 0.0, 0.0))
    run = stand(scene)
    run.q_WB[:, 0] = axis_angle((0.0, 1.0, 0.0), 0.2)
    run.q_WB[6:, 0] = axis_angle((0.0, 1.0, 0.0), 0.2 + angle)
    assert first_break(scene, run) == (pytest.approx(0.6 if name else 1.0), name)


def test_each_of_several_highest_bodies_is_watched() -> None:
    twins = Scene(bodies=(STAGE.bodies[0], *(Body(name=n, p_WB=(x, 0.0, 0.9)) for n, x in (("a", 0.0), ("b", 2.0)))))
    run = stand(twins)
    run.p_WB[5:, 2, 2] = 0.3
    assert first_break(twins, run) == (pytest.approx(0.5), "height")


def test_the_first_sign_counts() -> None:
    run = stand()
    run.p_WB[8:, 2, 2] = 0.1
    run.v_WB[3, 1, 0] = 1e3
    assert first_break(STAGE, run) == (pytest.approx(0.3), "energy")


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    run = stand()
    run.p_WB[5, 1, 0] = bad
    assert math.isnan(collapse_time(STAGE, run))


@pytest.mark.parametrize(
    ("gap", "found"), [(-0.09, (1.0, "")), (-0.11, (0.0, "penetration")), (math.nan, (0.0, "penetration"))]
)
def test_where_no_exact_depth_is_known_the_engine_s_own_points_count(gap: float, found: tuple[float, str]) -> None:
    can = (PlacedShape(shape=Cylinder(radius=0.1, half_length=0.3)),)
    scene = replace(STAGE, bodies=(*STAGE.bodies[:2], replace(STAGE.bodies[2], collision=can)))
    told = Contacts.of([1], [2], [[0.0] * 3], [[0.0, 0.0, 1.0]], [gap], [[0.0] * 3])
    assert first_break(scene, replace(stand(scene), contacts=(told,) * 11)) == found
    # Between other bodies, whose depth the poses tell, points do not.
    other = replace(told, body_A=np.array([0]), body_B=np.array([1]))
    assert first_break(scene, replace(stand(scene), contacts=(other,) * 11)) == (1.0, "")


def test_no_samples_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="sample"):
        collapse_time(STAGE, stand().between(5.0, 6.0))
