"""Conservation of energy and of momentum.

Energy drift: the largest departure of the mechanical energy from its start, as a share of the energy in play.

Where energy may be lost but never won, the gain alone is read; where it is to stay, also the rate at which it grows. Drives
that hold their targets are springs and dampers: with their share counted, the energy of what they hold may fall but never grow.

Semi-implicit Euler keeps velocity half a step behind position (v_k belongs to t_k - dt/2), so that its raw energy oscillates to
first order in dt without any drift. The staggered figure moves velocities on by half a step, v + dt/2 dv/dt, before it squares
them. For an integrator that does not stagger the raw figure is the right one; both are always given and none is chosen.

Momentum drift: how far linear and angular momentum, in W, leave the values that they start from.

Uniform gravity is allowed for: it adds M g t to the momentum, and no moment about the common centre of mass, about which the
angular momentum is taken. A joint to the world, a drive on the world or damping exchanges momentum: then nothing is measured.
Contact with a body that no force moves does so as well, and between two samples unseen: where there can be one, nothing is
measured.
"""

from dataclasses import replace

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import two
from plumbline.harness.scene import WORLD, Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import joint_coordinate, kinetic_energy, movable, rotate, rotate_back

SOURCE = "conservation of energy; half-step correction: Hairer, Lubich, Wanner, Geometric Numerical Integration, section I.1.4"


def _potential(scene: Scene, trajectory: Trajectory) -> Floats:
    """Of gravity and of springs, (t,) J."""
    energy = np.zeros(len(trajectory))
    for place in movable(scene):
        energy -= scene.bodies[place].mass * (trajectory.p_WB[:, place] @ np.array(scene.gravity))
    for joint in scene.joints:
        spring = getattr(joint, "spring", None)
        if spring is not None:
            stretch = joint_coordinate(scene, joint, trajectory) - spring.rest
            energy += 0.5 * spring.stiffness * np.square(stretch)
    return energy


def _check(scene: Scene) -> None:
    for joint in scene.joints:
        if getattr(joint, "drive", None) is not None:
            raise NotMeasurable(f"joint '{joint.name}' is driven: mechanical energy is not conserved")
        spring = getattr(joint, "spring", None)
        if spring is not None and spring.damping > 0:
            raise NotMeasurable(f"joint '{joint.name}' is damped: mechanical energy is not conserved")
    _check_damped(scene, "mechanical energy")
    _check_led(scene)


def _check_damped(scene: Scene, what: str) -> None:
    """Raises: NotMeasurable, where a body is damped. Args: what: is not conserved then, in words."""
    for body in scene.bodies:
        if body.movable and (body.linear_damping > 0 or body.angular_damping > 0):
            raise NotMeasurable(f"body '{body.name}' is damped: {what} is not conserved")


def _check_led(scene: Scene) -> None:
    """Raises: NotMeasurable, where a body is led, by a law of time or at a constant velocity, which does work on the others."""
    for body in scene.bodies:
        if body.prescribed is not None or (body.motion == "kinematic" and np.any(body.velocity_at_start)):
            raise NotMeasurable(f"body '{body.name}' is led: mechanical energy is not conserved")


def _scale(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    """The energy in play [J]: largest kinetic energy of the truth, else that at the start, else the swing of the potential."""
    if expected is not None and len(expected) > 0:
        scale = float(np.max(kinetic_energy(scene, expected)))
    else:
        scale = float(kinetic_energy(scene, actual)[0])
        if scale == 0.0:
            scale = float(np.ptp(_potential(scene, actual)))
    if scale == 0.0:
        raise NotMeasurable("nothing moves: there is no energy to compare a drift with")
    return scale


def energy_change(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    """Energy won since the start, as a share of the energy in play, (t,)."""
    _check(scene)
    energy = kinetic_energy(scene, actual) + _potential(scene, actual)
    change: Floats = (energy - energy[0]) / _scale(scene, actual, expected)
    return change


def _held_change(run: Run) -> Floats:
    """Energy won since the start, drives' springs included, over the mass, (t,) J/kg."""
    held = np.zeros(len(run.actual))
    for joint in run.scene.joints:
        drive = getattr(joint, "drive", None)
        if drive is None:
            continue
        if drive.target_velocity != 0 or drive.limit is not None or drive.motion is not None or drive.feedforward:
            raise NotMeasurable(f"joint '{joint.name}': its drive moves, pushes or has a limit, so that it is no spring")
        held += 0.5 * drive.stiffness * np.square(joint_coordinate(run.scene, joint, run.actual) - drive.target)
    _check_led(run.scene)
    energy = kinetic_energy(run.scene, run.actual) + _potential(run.scene, run.actual) + held
    change: Floats = (energy - energy[0]) / sum(run.scene.bodies[place].mass for place in run.movable)
    return change


energy_drift_max, energy_drift_final = two(
    "energy_drift", "1", SOURCE, lambda run: np.abs(energy_change(run.scene, run.actual, run.expected))
)


@metric("1", SOURCE, even=True, samples=4)
def energy_drift_staggered_max(run: Run) -> Floats:
    from scipy.interpolate import CubicSpline  # late: a listing must not pay for it

    _check(run.scene)
    half = run.actual.dt / 2
    v_WB = run.actual.v_WB + half * CubicSpline(run.actual.time, run.actual.v_WB).derivative()(run.actual.time)
    w_WB = run.actual.w_WB + half * CubicSpline(run.actual.time, run.actual.w_WB).derivative()(run.actual.time)
    energy = kinetic_energy(run.scene, replace(run.actual, v_WB=v_WB, w_WB=w_WB)) + _potential(run.scene, run.actual)
    drift: Floats = np.abs(energy - energy[0]) / _scale(run.scene, run.actual, run.expected)
    return drift


@metric("1")
def energy_gain_max(run: Run) -> Floats:
    """conservation of energy: energy won since the start, as a share of the energy in play; 0 where it only falls"""
    return energy_change(run.scene, run.actual, run.expected)


@metric("1/s", samples=3)
def energy_growth_rate(run: Run) -> float:
    """conservation of energy: magnitude of the slope of a straight line through the energy over that in play"""
    change, since = energy_change(run.scene, run.actual, run.expected), run.actual.time - run.actual.time.mean()
    return abs(float(since @ change / (since @ since)))


@metric("J/kg")
def held_energy_gain_max(run: Run) -> Floats:
    """dissipation: kinetic energy, and that of weight, springs and drives, won since the start, over the movable mass"""
    return _held_change(run)


@metric("J/kg")
def energy_rise_max(run: Run) -> Floats:
    """dissipation: kinetic energy, and that of weight, springs and drives, over its least so far, over the movable mass"""
    energy = _held_change(run)
    rise: Floats = energy - np.minimum.accumulate(energy)
    return rise


def _isolated(run: Run) -> None:
    for joint in run.scene.joints:
        if joint.parent == WORLD or not run.scene.body(joint.parent).movable or not run.scene.body(joint.child).movable:
            raise NotMeasurable(f"joint '{joint.name}' holds to the world: momentum is not conserved")
    _check_damped(run.scene, "momentum")
    for body in run.scene.bodies:
        if body.prescribed is not None:
            raise NotMeasurable(f"body '{body.name}' is led: momentum is not conserved")
    for fixed in run.scene.bodies:
        if not fixed.movable and any(body.movable and run.scene.collides(body, fixed) for body in run.scene.bodies):
            raise NotMeasurable(f"body '{fixed.name}' stays and can be touched: momentum is not conserved")
    if len(run.movable) == 0:
        raise NotMeasurable("no body can move")


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
