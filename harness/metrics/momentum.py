"""Momentum drift: how far linear and angular momentum, in W, leave the values that they start from.

Uniform gravity is allowed for: it adds M g t to the momentum, and no moment about the common centre of mass, about which the
angular momentum is taken. A joint to the world, a drive on the world or damping exchanges momentum: then nothing is measured.
Contact with a static body does so as well; a case that has it does not ask for this metric.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import last, maximum
from harness.scene import WORLD, Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable, rotate, rotate_back

LINEAR = "conservation of momentum: sum of m v, less M g t"
ANGULAR = "conservation of angular momentum: sum of r x m v + R I R^T w about the common centre of mass, over its start"


def _isolated(scene: Scene, actual: Trajectory) -> None:
    for joint in scene.joints:
        if joint.parent == WORLD or not scene.body(joint.parent).movable or not scene.body(joint.child).movable:
            raise NotMeasurable(f"joint '{joint.name}' holds to the world: momentum is not conserved")
    for body in scene.bodies:
        if body.movable and (body.linear_damping > 0 or body.angular_damping > 0):
            raise NotMeasurable(f"body '{body.name}' is damped: momentum is not conserved")
        if body.prescribed is not None:
            raise NotMeasurable(f"body '{body.name}' is led: momentum is not conserved")
    if len(movable(scene)) == 0:
        raise NotMeasurable("no body can move")
    if len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")


def _momentum(scene: Scene, actual: Trajectory) -> Floats:
    """Distance from the start, (t,) kg m/s."""
    _isolated(scene, actual)
    bodies = movable(scene)
    mass = np.array([scene.bodies[i].mass for i in bodies])
    momentum = np.einsum("i,tij->tj", mass, actual.v_WB[:, bodies])
    fallen = mass.sum() * np.outer(actual.time - actual.time[0], scene.gravity)
    change: Floats = np.linalg.norm(momentum - fallen - momentum[0], axis=-1)
    return change


def _angular(scene: Scene, actual: Trajectory) -> Floats:
    """Distance from the start, as a share of the sum of the bodies' own magnitudes there, (t,)."""
    _isolated(scene, actual)
    bodies = movable(scene)
    mass = np.array([scene.bodies[i].mass for i in bodies])
    share = mass / mass.sum()
    r = actual.p_WB[:, bodies] - np.einsum("i,tij->tj", share, actual.p_WB[:, bodies])[:, None]
    v = actual.v_WB[:, bodies] - np.einsum("i,tij->tj", share, actual.v_WB[:, bodies])[:, None]
    parts = np.cross(r, mass[:, None] * v)
    for column, place in enumerate(bodies):
        q_WB = actual.q_WB[:, place]
        inertia = np.array(scene.bodies[place].inertia)
        parts[:, column] += rotate(q_WB, rotate_back(q_WB, actual.w_WB[:, place]) @ inertia)
    scale = float(np.linalg.norm(parts[0], axis=-1).sum())
    if scale == 0.0:
        raise NotMeasurable("nothing turns at the start: there is no angular momentum to compare a drift with")
    total = parts.sum(axis=1)
    change: Floats = np.linalg.norm(total - total[0], axis=-1) / scale
    return change


MOMENTUM_MAX = Metric(
    name="momentum_drift_max", unit="kg m/s", source=LINEAR, measure=lambda s, a, _e: maximum(_momentum(s, a))
)
MOMENTUM_FINAL = Metric(
    name="momentum_drift_final", unit="kg m/s", source=LINEAR, measure=lambda s, a, _e: last(_momentum(s, a))
)
ANGULAR_MOMENTUM_MAX = Metric(
    name="angular_momentum_drift_max", unit="1", source=ANGULAR, measure=lambda s, a, _e: maximum(_angular(s, a))
)
ANGULAR_MOMENTUM_FINAL = Metric(
    name="angular_momentum_drift_final", unit="1", source=ANGULAR, measure=lambda s, a, _e: last(_angular(s, a))
)

METRIC = (MOMENTUM_MAX, MOMENTUM_FINAL, ANGULAR_MOMENTUM_MAX, ANGULAR_MOMENTUM_FINAL)
