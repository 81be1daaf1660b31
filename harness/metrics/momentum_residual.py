"""Momentum residual: by how much contact forces and gravity miss the change of momentum that the bodies show in the same step.

    r_k = m (v_k - v_{k-1}) - (F_k + m g) dt

for each movable body without joints, with the sum F_k of the recorded contact forces on it, which are averages over the last
step. Only samples one step apart can be judged: between others forces went unrecorded. The worst of all steps and bodies
counts, over the greatest m |v_k - v_{k-1}| of the record, so that 1 is a force that is missing where it matters most.

Source: Newton's second law in its integral form; Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import forces_on
from plumbline.harness.scene import Effect


@metric("1", even=True)
def momentum_residual(run: Run) -> float:
    """Newton's second law over a step: |m dv - (F + m g) dt| at worst, over the greatest m |dv|"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    steps = np.flatnonzero(np.abs(np.diff(run.actual.time) - run.actual.dt) < 1e-6 * run.actual.dt) + 1
    if len(steps) == 0:
        raise NotMeasurable("no two samples are one step apart, so that forces went unrecorded")
    jointed = {name for joint in run.scene.joints for name in (joint.parent, joint.child)}
    bodies = [k for k, b in enumerate(run.scene.bodies) if b.movable and b.name not in jointed and b.linear_damping == 0]
    if not bodies:
        raise NotMeasurable("no body moves under contacts and gravity alone")
    mass = np.array([run.scene.bodies[k].mass for k in bodies])[:, None]
    gravity = np.array(run.scene.gravity) * (Effect.GRAVITY in run.scene.effects)
    gained = mass * (run.actual.v_WB[steps][:, bodies] - run.actual.v_WB[steps - 1][:, bodies])
    force = np.array([forces_on(run.actual.contacts[k], len(run.scene.bodies))[bodies] for k in steps])
    greatest = float(np.linalg.norm(gained, axis=-1).max())
    if greatest == 0.0:
        raise NotMeasurable("nothing changes its momentum")
    return float(np.linalg.norm(gained - (force + mass * gravity) * run.actual.dt, axis=-1).max()) / greatest
