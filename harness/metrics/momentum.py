"""Momentum drift: how far linear and angular momentum, in W, leave the values that they start from.

Uniform gravity is allowed for: it adds M g t to the momentum, and no moment about the common centre of mass, about which the
angular momentum is taken. A joint to the world, a drive on the world or damping exchanges momentum: then nothing is measured.
Contact with a body that no force moves does so as well, and between two samples unseen: where there can be one, nothing is
measured.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import two
from plumbline.harness.scene import WORLD
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate, rotate_back


def _isolated(run: Run) -> None:
    for joint in run.scene.joints:
        if joint.parent == WORLD or not run.scene.body(joint.parent).movable or not run.scene.body(joint.child).movable:
            raise NotMeasurable(f"joint '{joint.name}' holds to the world: momentum is not conserved")
    for body in run.scene.bodies:
        if body.movable and (body.linear_damping > 0 or body.angular_damping > 0):
            raise NotMeasurable(f"body '{body.name}' is damped: momentum is not conserved")
        if body.prescribed is not None:
            raise NotMeasurable(f"body '{body.name}' is led: momentum is not conserved")
    for fixed in run.scene.bodies:
        if not fixed.movable and any(body.movable and run.scene.collides(body, fixed) for body in run.scene.bodies):
            raise NotMeasurable(f"body '{fixed.name}' stays and can be touched: momentum is not conserved")
    if len(run.movable) == 0:
        raise NotMeasurable("no body can move")
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")


def _momentum(run: Run) -> Floats:
    """Distance from the start, (t,) kg m/s."""
    _isolated(run)
    bodies = run.movable
    mass = np.array([run.scene.bodies[i].mass for i in bodies])
    momentum = np.einsum("i,tij->tj", mass, run.actual.v_WB[:, bodies])
    fallen = mass.sum() * np.outer(run.actual.time - run.actual.time[0], run.scene.gravity)
    change: Floats = np.linalg.norm(momentum - fallen - momentum[0], axis=-1)
    return change


def _angular(run: Run) -> Floats:
    """Distance from the start, as a share of the sum of the bodies' own magnitudes there, (t,)."""
    _isolated(run)
    bodies = run.movable
    mass = np.array([run.scene.bodies[i].mass for i in bodies])
    share = mass / mass.sum()
    r = run.actual.p_WB[:, bodies] - np.einsum("i,tij->tj", share, run.actual.p_WB[:, bodies])[:, None]
    v = run.actual.v_WB[:, bodies] - np.einsum("i,tij->tj", share, run.actual.v_WB[:, bodies])[:, None]
    parts = np.cross(r, mass[:, None] * v)
    for column, place in enumerate(bodies):
        q_WB = run.actual.q_WB[:, place]
        inertia = np.array(run.scene.bodies[place].inertia)
        parts[:, column] += rotate(q_WB, rotate_back(q_WB, run.actual.w_WB[:, place]) @ inertia)
    scale = float(np.linalg.norm(parts[0], axis=-1).sum())
    if scale == 0.0:
        raise NotMeasurable("nothing turns at the start: there is no angular momentum to compare a drift with")
    total = parts.sum(axis=1)
    change: Floats = np.linalg.norm(total - total[0], axis=-1) / scale
    return change


momentum_drift_max, momentum_drift_final = two(
    "momentum_drift", "kg m/s", "conservation of momentum: sum of m v, less M g t", _momentum
)
angular_momentum_drift_max, angular_momentum_drift_final = two(
    "angular_momentum_drift",
    "1",
    "conservation of angular momentum: sum of r x m v + R I R^T w about the common centre of mass, over its start",
    _angular,
)
