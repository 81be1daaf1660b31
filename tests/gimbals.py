"""A wheel in a gimbal of two rings on hinges: the scene, and the energy of what moves."""

import math

import numpy as np

from plumbline.harness.adapter.rotations import matrix
from plumbline.harness.scene import Body, Drive, Revolute, Scene, axis_angle
from plumbline.harness.scene.values import Matrix3
from plumbline.harness.trajectory import State

__all__ = ["WHEEL", "energy", "gimbal", "wobble"]

WHEEL = (0.5e-3, 0.5e-3, 1e-3)
"""Moments of a disc [kg m2]."""
OUTER, INNER = (5.76e-4, 2.88e-4, 2.88e-4), (1.5e-4, 3e-4, 1.5e-4)
"""Moments of rings of 0.12 and 0.1 m about their centres, about their hinges' axes the greatest."""
TILT = 0.3


def _about(moments: tuple[float, float, float]) -> Matrix3:
    x, y, z = moments
    return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))


def gimbal(
    spin: float = 150.0,
    wheel: tuple[float, float, float] = WHEEL,
    tilt: float = TILT,
    turning: float = 1.0,
    drive: Drive | None = None,
) -> Scene:
    """A wheel that spins [rad/s] about z of a ring, which turns about y of another, which turns about x of the world.

    Args: turning: of the outer ring [rad/s]; the inner one turns half as fast.
    """
    q = axis_angle((0.0, 1.0, 0.0), tilt)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    w_inner = (turning, turning / 2, 0.0)
    w_wheel = (w_inner[0] + spin * axis[0], w_inner[1], spin * axis[2])
    bodies = (
        Body(name="outer", mass=0.04, inertia=_about(OUTER), w_WB=(turning, 0.0, 0.0)),
        Body(name="inner", mass=0.03, inertia=_about(INNER), q_WB=q, w_WB=w_inner),
        Body(name="wheel", mass=0.3, inertia=_about(wheel), q_WB=q, w_WB=w_wheel),
    )
    at = (0.0, 0.0, 0.0)
    joints = (
        Revolute(name="a", parent="world", child="outer", anchor_W=at, axis_W=(1.0, 0.0, 0.0)),
        Revolute(name="b", parent="outer", child="inner", anchor_W=at, axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="c", parent="inner", child="wheel", anchor_W=at, axis_W=axis, drive=drive),
    )
    return Scene(bodies=bodies, joints=joints, gravity=at)


def wobble(spin: float) -> float:
    """The rate [rad/s] at which an upright gimbal at rest nods: A x'' = -H y', B y'' = H x'; H/sqrt(A B)."""
    across = OUTER[0] + INNER[0] + WHEEL[0], INNER[1] + WHEEL[1]
    return WHEEL[2] * spin / math.sqrt(across[0] * across[1])


def energy(scene: Scene, state: State) -> float:
    """The kinetic energy [J]."""
    total = 0.0
    for k, body in enumerate(scene.bodies):
        w = matrix(state.q_WB[k]).T @ state.w_WB[k]
        total += float(body.mass * state.v_WB[k] @ state.v_WB[k] + w @ np.asarray(body.inertia) @ w) / 2
    return total
