"""Tops: which bodies on a ball joint spin, as they wobble faster than they would swing."""

import math

import numpy as np

from adapters.dart.vectors import cross_matrix
from harness.scene import Body, Effect, Scene, Vector3, rotation_matrix
from harness.trajectory import Floats

__all__ = ["SPUN", "spins"]

SPUN = 2.0
"""By how much faster than it swings a body must wobble to count as a top.

What swings on a circle has 1 at most, a disc on a stem as long as its radius that spins fast enough not to fall 3 and more.
"""


def spins(scene: Scene, body: Body, anchor_W: Vector3) -> bool:
    """Does a body that is held at a point [m, in W] wobble faster by SPUN than it would swing?"""
    anchor = np.array(anchor_W)
    return _wobble(body, anchor) > SPUN * _swing(scene, body, anchor)


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
