"""What joints and springs make available is no sign of a break; a thousand times as much is."""

import numpy as np
import pytest

from plumbline.harness.metrics.collapse import first_break
from plumbline.harness.metrics.overlaps import inscribed_overlap
from plumbline.harness.scene import WORLD, Body, PlacedShape, Plane, Prismatic, Revolute, Scene, Sphere, Spring, Surface
from plumbline.harness.trajectory import Trajectory


def run(scene: Scene, speed: float) -> Trajectory:
    """Two samples: as the scene begins, and with its last body at `speed` [m/s] along x."""
    made = Trajectory.of(np.array([0.0, 1.0]), len(scene.bodies))
    for place, body in enumerate(scene.bodies):
        made.p_WB[:, place] = body.p_WB
    made.v_WB[1, -1, 0] = speed
    return made


def pendulum() -> Scene:
    bob = Body(name="bob", p_WB=(1.0, 0.0, 0.0))
    hinge = Revolute(name="hinge", parent=WORLD, child="bob", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    return Scene(bodies=(bob,), joints=(hinge,))


def drawn_spring() -> Scene:
    block = Body(name="block", p_WB=(0.0, 0.0, 0.0))
    slide = Prismatic(
        name="slide",
        parent=WORLD,
        child="block",
        anchor_W=(0.0, 0.0, 0.0),
        axis_W=(1.0, 0.0, 0.0),
        spring=Spring(stiffness=100.0, damping=0.0, rest=0.5),
    )
    return Scene(bodies=(block,), joints=(slide,), gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("scene", [pendulum(), drawn_spring()])
def test_a_swing_is_no_break_and_an_explosion_is(scene: Scene) -> None:
    """A metre's fall gives 4.4 m/s, half a metre of the spring 5 m/s; 500 m/s are ten thousand times that energy."""
    assert first_break(scene, run(scene, 5.0))[1] == ""
    assert first_break(scene, run(scene, 500.0)) == (1.0, "energy")


def test_a_ball_in_the_ground_is_as_deep_as_it_is() -> None:
    ball = Body(name="ball", collision=(PlacedShape(shape=Sphere(radius=0.1)),), p_WB=(0.0, 0.0, 0.1))
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    scene = Scene(bodies=(ground, ball), surfaces=(Surface(),))
    sunk = run(scene, 0.0)
    assert inscribed_overlap(scene, sunk) == 0.0
    sunk.p_WB[1, 1, 2] = 0.07
    assert inscribed_overlap(scene, sunk) == pytest.approx(0.03)
