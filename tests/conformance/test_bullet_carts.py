"""A cart of four driven wheels that steers by skidding, on Bullet: its wheels slip all the while."""

from typing import Any

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Settings
from plumbline.harness.scene import (
    Body,
    Box,
    Drive,
    Joint,
    PlacedShape,
    Revolute,
    Scene,
    Sphere,
    Surface,
    box_inertia,
    sphere_inertia,
)
from plumbline.harness.trajectory import Floats, State

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

G = 9.81
RADIUS, CHASSIS = 0.1, 10.0
TUNED = ADAPTER.tracks["tuned"]
TURNS = pytest.mark.parametrize("turn", [(5.0, 10.0), (-10.0, 10.0)], ids=["in a curve", "on the spot"])


def cart(
    left: float, right: float, damping: float, wheel: float = 1.0, friction: float = 0.8, limit: float | None = None
) -> Scene:
    """Wheels of `wheel` kg below a chassis, driven to these rates [rad/s] by `damping` [N m s/rad]."""
    slab = Box(half_extents=(20.0, 20.0, 0.5))
    bodies = [
        Body(name="ground", motion="static", material="ground", p_WB=(0, 0, -0.5), collision=(PlacedShape(shape=slab),)),
        Body(name="chassis", mass=CHASSIS, inertia=box_inertia(CHASSIS, (0.3, 0.2, 0.05)), p_WB=(0, 0, 0.15)),
    ]
    joints: list[Joint] = []
    for k, (x, y) in enumerate([(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)]):
        at, ball = (x, y, RADIUS), PlacedShape(shape=Sphere(radius=RADIUS))
        inertia = sphere_inertia(wheel, RADIUS)
        bodies.append(Body(name=f"w{k}", mass=wheel, inertia=inertia, p_WB=at, material="wheel", collision=(ball,)))
        drive = Drive(damping=damping, target_velocity=left if y > 0 else right, limit=limit)
        joints.append(Revolute(name=f"j{k}", parent="chassis", child=f"w{k}", anchor_W=at, axis_W=(0, 1, 0), drive=drive))
    law = Surface(between=("ground", "wheel"), static_friction=friction, kinetic_friction=friction)
    return Scene(bodies=tuple(bodies), joints=tuple(joints), surfaces=(law,), apart=(("wheel", "wheel"),))


def driven(scene: Scene, settings: Settings, seconds: float) -> tuple[Floats, Floats, float]:
    """The total momentum (n, 3) N s and the greatest rate of a wheel (n,) rad/s by steps, and the chassis' last yaw rate."""
    mass = np.array([body.mass if body.movable else 0.0 for body in scene.bodies])
    simulation: Any = ADAPTER.build(scene, settings)
    state, momenta, rates = State.empty(len(mass)), [], []
    try:
        for _ in range(round(seconds / settings.dt)):
            simulation.step()
            simulation.state(state)
            momenta.append(mass @ state.v_WB)
            rates.append(np.linalg.norm(state.w_WB[2:] - state.w_WB[1], axis=1).max())
        return np.array(momenta), np.array(rates), float(state.w_WB[1, 2])
    finally:
        simulation.close()


@TURNS
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
@pytest.mark.parametrize("damping", [2.0, 20.0, 2000.0])
def test_no_drive_pushes_a_cart_faster_than_its_wheels_roll(damping: float, dt: float, turn: tuple[float, float]) -> None:
    momenta, rates, _ = driven(cart(*turn, damping), TUNED.with_dt(dt), 0.5)
    mass, inertia = CHASSIS + 4, 0.4 * RADIUS**2
    assert np.linalg.norm(momenta, axis=1).max() < mass * max(turn) * RADIUS
    # A drive may push a wheel beyond its rate by what friction, mu m g/2 at the rim, held it by in a step; friction itself may
    # push as much. Statics leave open how four wheels share the weight: two across may bear all of it, and which ones do is up
    # to the last bit of the first step.
    assert rates.max() < max(turn) + 2 * 0.8 * mass * G / 2 * RADIUS * dt / inertia


@pytest.mark.parametrize("wheel", [0.2, 0.8, 2.0])
@pytest.mark.parametrize("friction", [0.4, 1.6])
def test_light_and_heavy_wheels_of_any_grip_stay_in_bounds(wheel: float, friction: float) -> None:
    momenta, rates, _ = driven(cart(10.0, 40.0, 50.0, wheel, friction), TUNED.with_dt(1 / 240), 0.5)
    mass, inertia = CHASSIS + 4 * wheel, 0.4 * wheel * RADIUS**2
    assert np.linalg.norm(momenta, axis=1).max() < mass * 40.0 * RADIUS
    # As above; a turn puts all of the weight on the two wheels of a side.
    assert rates.max() < 40.0 + 2 * friction * mass * G / 2 * RADIUS / 240 / inertia


@pytest.mark.parametrize("limit", [None, 3.0])
@pytest.mark.parametrize("damping", [2.0, 200.0])
def test_a_cart_turns_on_the_spot_alike_at_two_steps(damping: float, limit: float | None) -> None:
    coarse, fine = (driven(cart(-10.0, 10.0, damping, limit=limit), TUNED.with_dt(dt), 1.0)[2] for dt in (1 / 240, 1e-3))
    assert coarse > 0.5
    # First order in h/T; friction turns the cart in T = I_z w/(mu m g l) = 0.77 * 2/(0.8 * 14 * 9.81 * 0.28) = 0.05 s.
    assert coarse == pytest.approx(fine, rel=1 / 240 / 0.05)
