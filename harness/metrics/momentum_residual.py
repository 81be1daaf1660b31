"""Momentum residual: by how much contact forces and gravity miss the change of momentum that the bodies show in the same step.

    r_k = m (v_k - v_{k-1}) - (F_k + m g) dt

for each movable body without joints, with the sum F_k of the recorded contact forces on it, which are averages over the last
step. Only samples one step apart can be judged: between others forces went unrecorded. The worst of all steps and bodies
counts, over the greatest m |v_k - v_{k-1}| of the record, so that 1 is a force that is missing where it matters most.

Source: Newton's second law in its integral form; Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988.
"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.contact_impulses import forces_on
from harness.scene import Effect, Scene
from harness.trajectory import Trajectory


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    steps = np.flatnonzero(np.abs(np.diff(actual.time) - actual.dt) < 1e-6 * actual.dt) + 1
    if len(steps) == 0:
        raise NotMeasurable("no two samples are one step apart, so that forces went unrecorded")
    jointed = {name for joint in scene.joints for name in (joint.parent, joint.child)}
    bodies = [k for k, b in enumerate(scene.bodies) if b.movable and b.name not in jointed and b.linear_damping == 0]
    if not bodies:
        raise NotMeasurable("no body moves under contacts and gravity alone")
    if not actual.finite:
        return math.nan
    mass = np.array([scene.bodies[k].mass for k in bodies])[:, None]
    gravity = np.array(scene.gravity) * (Effect.GRAVITY in scene.effects)
    gained = mass * (actual.v_WB[steps][:, bodies] - actual.v_WB[steps - 1][:, bodies])
    force = np.array([forces_on(actual.contacts[k], len(scene.bodies))[bodies] for k in steps])
    greatest = float(np.linalg.norm(gained, axis=-1).max())
    if greatest == 0.0:
        raise NotMeasurable("nothing changes its momentum")
    return float(np.linalg.norm(gained - (force + mass * gravity) * actual.dt, axis=-1).max()) / greatest


METRIC = MOMENTUM_RESIDUAL = Metric(
    even=True,
    name="momentum_residual",
    unit="1",
    source="Newton's second law over a step: |m dv - (F + m g) dt| at worst, over the greatest m |dv|",
    measure=_measure,
)
