"""Mass points are told to engines as bodies that move alike, or refused with the words that mend it; importers merge them."""

import math
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.mass_points import with_inertia
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Fixed,
    Joint,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Scene,
    box_inertia,
    principal_inertia,
)
from plumbline.harness.study import plugins
from tests.robot_files import imported, urdf

NOTHING = principal_inertia(0.0, 0.0, 0.0)
POINT = Body(name="point", mass=0.5, inertia=NOTHING, p_WB=(0.3, 0.1, -0.2))
BRICK = Body(name="brick", mass=2.0, inertia=box_inertia(2.0, (0.1, 0.2, 0.3)), q_WB=(0.5, 0.5, 0.5, 0.5))
ENDS = {"parent": "brick", "child": "point"}


def scene(*joints: Joint, point: Body = POINT, brick: Body = BRICK) -> Scene:
    return Scene(bodies=(brick, point), joints=joints)


def together(told: Scene) -> np.ndarray:
    """The inertia of both bodies as one, about the origin of W, along its axes [kg m2]."""
    from plumbline.harness.scene import rotation_matrix

    total = np.zeros((3, 3))
    for body in told.bodies:
        R, r = np.array(rotation_matrix(body.q_WB)), np.array(body.p_WB)
        total += R @ np.array(body.inertia) @ R.T + body.mass * (r @ r * np.eye(3) - np.outer(r, r))
    return total


def test_a_scene_without_mass_points_is_told_as_it_is() -> None:
    plain = Scene(bodies=(BRICK,))
    assert with_inertia(plain) is plain


def test_a_welded_point_and_its_body_have_the_inertia_that_they_had() -> None:
    """To rounding; both told bodies are bodies, which the scene's own door has checked."""
    asked = scene(Fixed(name="weld", **ENDS))
    told = with_inertia(asked)
    assert not any(body.mass_point for body in told.bodies)
    assert together(told) == pytest.approx(together(asked), abs=1e-15)


def test_several_points_share_what_one_body_gives() -> None:
    second = Body(name="second", mass=0.2, inertia=NOTHING, p_WB=(0.0, 0.5, 0.0))
    joints = (Fixed(name="weld", **ENDS), Fixed(name="on", parent="point", child="second"))
    asked = Scene(bodies=(BRICK, POINT, second), joints=joints)
    told = with_inertia(asked)
    assert together(told) == pytest.approx(together(asked), abs=1e-15)
    assert not any(body.mass_point for body in told.bodies)


SLIDE = {"anchor_W": POINT.p_WB, "axis_W": (1.0, 0.0, 0.0)}


@pytest.mark.parametrize(
    "joint",
    [
        Ball(name="j", anchor_W=POINT.p_WB, **ENDS),
        Distance(name="j", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=POINT.p_WB, **ENDS),
        Prismatic(name="j", parent=WORLD, child="point", **SLIDE),
        Fixed(name="j", parent=WORLD, child="point"),
    ],
    ids=lambda joint: joint.type,
)
def test_what_cannot_turn_a_point_may_hold_it(joint: Joint) -> None:
    told = with_inertia(scene(joint))
    assert not any(body.mass_point for body in told.bodies)
    assert told.bodies[0] == BRICK


@pytest.mark.parametrize(
    ("joint", "why"),
    [
        (Revolute(name="j", anchor_W=POINT.p_WB, axis_W=(0.0, 0.0, 1.0), **ENDS), "its axis goes through the point"),
        (Revolute(name="j", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0), **ENDS), "on a hinge; a small ball"),
        (Ball(name="j", anchor_W=(0.0, 0.0, 0.0), **ENDS), "its anchor is not at the point"),
        (Prismatic(name="j", **ENDS, **SLIDE), "the slide turns with 'brick'"),
    ],
    ids=["through", "swinging", "ball", "slide"],
)
def test_what_could_turn_a_point_is_refused_with_the_reason(joint: Joint, why: str) -> None:
    with pytest.raises(Unsupported, match=why):
        with_inertia(scene(joint))


def test_points_fixed_together_and_points_on_a_plate_are_refused() -> None:
    other = Body(name="other", mass=1.0, inertia=NOTHING)
    with pytest.raises(Unsupported, match="about their own line"):
        with_inertia(Scene(bodies=(POINT, other), joints=(Fixed(name="j", parent="other", child="point"),)))
    plate = Body(name="brick", inertia=principal_inertia(1.0, 2.0, 3.0))
    with pytest.raises(Unsupported, match="that is flat"):
        with_inertia(scene(Fixed(name="weld", **ENDS), brick=plate))


def test_a_point_that_spins_or_touches_is_refused() -> None:
    with pytest.raises(Unsupported, match="nothing that could turn"):
        with_inertia(Scene(bodies=(Body(name="point", inertia=NOTHING, w_WB=(1.0, 0.0, 0.0)),)))
    with pytest.raises(ValueError, match="it has shapes that touch"):
        Body(name="point", inertia=NOTHING, collision=(PlacedShape(shape=Plane()),))


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
def test_a_torque_on_a_mass_point_is_refused_and_a_force_is_not(engine: str) -> None:
    pytest.importorskip({"reference": "engine", "bullet": "pybullet", "dart": "dartpy"}.get(engine, engine))
    adapter = plugins.adapter(engine)
    push, twist = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    with Engine(adapter, adapter.tracks["default"]).built(Scene(bodies=(POINT,)), dt=1e-3) as simulation:
        simulation.wrench(push, np.zeros((1, 3)))
        with pytest.raises(ValueError, match="body 0, a mass point"):
            simulation.wrench(push, twist)


def test_a_link_of_mass_alone_is_merged_exactly_over_fixed_joints_or_slides_as_a_point(tmp_path: Path) -> None:
    """1 kg at .5 m below an arm of 2 kg: centre at a third of it, and m r^2 of both about that."""
    nothing = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    lump = f'<link name="lump"><inertial><mass value="1"/>{nothing}</inertial></link>'
    weld = '<joint name="w" type="{}"><parent link="arm"/><child link="lump"/><origin xyz="0 0 -0.5"/>{}</joint>'
    body = imported(tmp_path, urdf(lump, weld.format("fixed", ""))).scene.body("arm")
    assert body.mass == 3
    assert body.p_WB == pytest.approx((0, 0, 1 - 0.5 / 3))
    more = 2 * (0.5 / 3) ** 2 + (0.5 - 0.5 / 3) ** 2
    assert np.diag(body.inertia) == pytest.approx([0.02 + more, 0.03 + more, 0.04])
    limit = '<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    slid = imported(tmp_path, urdf(lump, weld.format("prismatic", limit))).scene
    assert slid.body("lump").mass_point
    assert math.isclose(slid.body("lump").mass, 1.0)
    with pytest.raises(RobotError, match="principal moments"):
        imported(tmp_path, urdf(lump, weld.format("revolute", limit)))
