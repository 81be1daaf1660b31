"""Penetration by poses, and the depth that an engine reports, each on trajectories made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.contacts import penetration, reported_penetration
from plumbline.harness.scene import (
    Body,
    Box,
    Cylinder,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    Sphere,
    Surface,
    axis_angle,
    box_inertia,
    sphere_inertia,
)
from plumbline.harness.trajectory import Contacts, Trajectory

HALF, RADIUS = (0.1, 0.1, 0.1), 0.1
BOX = PlacedShape(shape=Box(half_extents=HALF))
GROUND = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
STAGE = Scene(
    bodies=(
        GROUND,
        Body(name="box", mass=1.0, inertia=box_inertia(1.0, HALF), collision=(BOX,), p_WB=(0.0, 0.0, 0.1)),
        Body(
            name="ball",
            mass=1.0,
            inertia=sphere_inertia(1.0, RADIUS),
            collision=(PlacedShape(shape=Sphere(radius=RADIUS), p_BS=(0.0, 0.0, 0.05)),),
            p_WB=(0.0, 0.0, 0.25),
        ),
    ),
    surfaces=(Surface(),),
)
ROUNDING = 1e-15


def stand(scene: Scene = STAGE, count: int = 3) -> Trajectory:
    run = Trajectory.of(np.arange(count) * 0.1, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.q_WB[:] = [body.q_WB for body in scene.bodies]
    return run


def told(*gaps: list[float]) -> Trajectory:
    contacts = tuple(
        Contacts.of([0] * len(g), [1] * len(g), [[0.0] * 3] * len(g), [[0.0, 0.0, 1.0]] * len(g), g, [[0.0] * 3] * len(g))
        for g in gaps
    )
    return replace(stand(count=len(gaps)), contacts=contacts)


def test_what_just_touches_does_not_penetrate() -> None:
    assert penetration(STAGE, stand()) <= ROUNDING


def test_the_deepest_pair_of_all_instants_counts_wherever_its_shapes_lie_in_their_bodies() -> None:
    run = stand()
    run.p_WB[0, 1, 2] -= 0.001
    run.p_WB[2, 2, 2] -= 0.003
    assert penetration(STAGE, run) == pytest.approx(0.003, abs=1e-12)
    # Upside down the ball's shape hangs 0.1 m lower: the shortest way out of the box is aside, by the box's and its own half.
    run.q_WB[2, 2] = axis_angle((1.0, 0.0, 0.0), math.pi)
    assert penetration(STAGE, run) == pytest.approx(0.103, abs=1e-12)


def test_what_engines_report_is_no_matter_of_poses() -> None:
    assert penetration(STAGE, told([-0.05], [-0.05])) <= ROUNDING
    assert reported_penetration(STAGE, told([-0.05], [-0.05])) == 0.05


def test_bodies_that_a_joint_or_the_scene_keeps_from_touching_do_not_count() -> None:
    run = stand()
    run.p_WB[:, 2, 2] -= 0.02
    hinge = Revolute(name="hinge", parent="box", child="ball", anchor_W=(0.0, 0.0, 0.2), axis_W=(0.0, 1.0, 0.0))
    assert penetration(replace(STAGE, joints=(hinge,)), run) <= ROUNDING
    apart = tuple(replace(body, material=body.name) for body in STAGE.bodies)
    laws = (Surface(between=("box", "ground")), Surface(between=("ball", "ground")))
    assert penetration(replace(STAGE, bodies=apart, surfaces=laws, apart=(("box", "ball"),)), run) <= ROUNDING


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    assert math.isnan(reported_penetration(STAGE, told([0.1], [bad, -0.2])))
    broken = told([0.1])
    broken.p_WB[0, 1, 0] = bad
    assert math.isnan(reported_penetration(STAGE, broken))
    assert math.isnan(penetration(STAGE, broken))


def test_what_cannot_be_known_is_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no sample"):
        penetration(STAGE, stand(count=0))
    with pytest.raises(NotMeasurable, match="no two bodies"):
        penetration(Scene(bodies=(GROUND,)), stand(Scene(bodies=(GROUND,))))
    can = PlacedShape(shape=Cylinder(radius=0.1, half_length=0.1))
    cans = replace(STAGE, bodies=(GROUND, STAGE.bodies[1], replace(STAGE.bodies[2], collision=(can,))))
    with pytest.raises(NotMeasurable, match="'ball' in 'box'"):
        penetration(cans, stand(cans))


@pytest.mark.parametrize("gaps", [[[], []], [[0.02, 0.0], [0.5]]])
def test_gaps_and_no_contact_at_all_are_reported_as_no_penetration(gaps: list[list[float]]) -> None:
    assert reported_penetration(STAGE, told(*gaps)) == 0.0


def test_the_deepest_point_that_is_reported_counts() -> None:
    assert reported_penetration(STAGE, told([0.1, -0.001], [], [-0.003, 0.0])) == 0.003


def test_missing_contacts_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="no contacts"):
        reported_penetration(STAGE, stand())
    with pytest.raises(NotMeasurable, match="no sample"):
        reported_penetration(STAGE, told())
