"""Tops and rotors: which bodies on a ball joint wobble faster than they would swing, and the steps that rotors ask for."""

import math

import numpy as np

from plumbline.adapters.dart.vectors import cross_matrix
from plumbline.harness.adapter.fast_rotors import fast_rotors
from plumbline.harness.scene import Body, Effect, Scene, Vector3, rotation_matrix
from plumbline.harness.trajectory import Floats

ROTOR_STEP = 1 / 960
"""The longest (sub)step [s] of a fast rotor on `joints` = "auto".

In one of 1/240 s the axis of a wheel of 150 rad/s on a constraint in a gimbal of light rings is lost (1.8 of 2 at most), in one
of 1/960 s it errs by 0.08 at most.
"""

SPUN = 2.0
"""By how much faster than it swings a body must wobble to count as a top.

What swings on a circle has 1 at most, a disc on a stem as long as its radius that spins fast enough not to fall 3 and more.
"""


def spins(scene: Scene, body: Body, anchor_W: Vector3) -> bool:
    """Does a body that is held at a point [m, in W] wobble faster by SPUN than it would swing?"""
    anchor = np.array(anchor_W)
    return _wobble(body, anchor) > SPUN * _swing(scene, body, anchor)


def substeps_of(scene: Scene, dt: float, joints: str | None) -> int:
    """As many sub-steps of dt [s] as a fast rotor asks for on `joints` = "auto", else one."""
    if joints != "auto" or Effect.JOINTS not in scene.effects or not fast_rotors(scene):
        return 1
    return max(1, math.ceil(dt / ROTOR_STEP * (1 - 1e-9)))


def _wobble(body: Body, anchor: Floats) -> float:
    """The rate [rad/s] at which a body that is held at `anchor` [m, in W] wobbles about its spin by Euler's equations.

    w' = I^-1 (I w x w), linearised at the initial w; I about the anchor, in B.
    """
    R_WB = np.array(rotation_matrix(body.q_WB))
    moments = _about(body, anchor)
    w = R_WB.T @ np.array(body.w_WB)
    turned = np.linalg.solve(moments, cross_matrix(moments @ w) - cross_matrix(w) @ moments)
    return float(np.abs(np.linalg.eigvals(turned).imag).max())


def _swing(scene: Scene, body: Body, anchor: Floats) -> float:
    """The rate [rad/s] at which gravity would have that body swing, at most."""
    g = float(np.linalg.norm(scene.gravity)) if Effect.GRAVITY in scene.effects else 0.0
    lever = float(np.linalg.norm(np.array(body.p_WB) - anchor))
    return math.sqrt(body.mass * g * lever / float(np.linalg.eigvalsh(_about(body, anchor))[-1]))


def _about(body: Body, anchor: Floats) -> Floats:
    """The moments (3, 3) [kg m2] of a body about a point in W, along the axes of B."""
    R_WB = np.array(rotation_matrix(body.q_WB))
    lever = cross_matrix(R_WB.T @ (np.array(body.p_WB) - anchor))
    return np.asarray(body.inertia) + body.mass * lever.T @ lever
