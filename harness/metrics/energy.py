"""Energy drift: the largest departure of the mechanical energy from its start, as a share of the energy in play.

Where energy may be lost but never won, the gain alone is read; where it is to stay, also the rate at which it grows. Drives
that hold their targets are springs and dampers: with their share counted, the energy of what they hold may fall but never grow.

Semi-implicit Euler keeps velocity half a step behind position (v_k belongs to t_k - dt/2), so that its raw energy oscillates to
first order in dt without any drift. The staggered figure moves velocities on by half a step, v + dt/2 dv/dt, before it squares
them. For an integrator that does not stagger the raw figure is the right one; both are always given and none is chosen.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import two
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import joint_coordinate, movable, rotate_back

SOURCE = "conservation of energy; half-step correction: Hairer, Lubich, Wanner, Geometric Numerical Integration, section I.1.4"


def _kinetic(scene: Scene, trajectory: Trajectory, v_WB: Floats, w_WB: Floats) -> Floats:
    """(t,) J."""
    energy = np.zeros(len(trajectory))
    for place in movable(scene):
        body = scene.bodies[place]
        w_B = rotate_back(trajectory.q_WB[:, place], w_WB[:, place])
        energy += 0.5 * body.mass * np.sum(np.square(v_WB[:, place]), axis=-1)
        energy += 0.5 * np.sum(w_B * (w_B @ np.array(body.inertia)), axis=-1)
    return energy


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


def _check(scene: Scene, actual: Trajectory) -> None:
    for joint in scene.joints:
        if getattr(joint, "drive", None) is not None:
            raise NotMeasurable(f"joint '{joint.name}' is driven: mechanical energy is not conserved")
        spring = getattr(joint, "spring", None)
        if spring is not None and spring.damping > 0:
            raise NotMeasurable(f"joint '{joint.name}' is damped: mechanical energy is not conserved")
    for body in scene.bodies:
        if body.movable and (body.linear_damping > 0 or body.angular_damping > 0):
            raise NotMeasurable(f"body '{body.name}' is damped: mechanical energy is not conserved")
    _check_led(scene)
    if len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")


def _check_led(scene: Scene) -> None:
    """Raises: NotMeasurable, where a body is led, by a law of time or at a constant velocity, which does work on the others."""
    for body in scene.bodies:
        if body.prescribed is not None or (body.motion == "kinematic" and np.any(body.velocity_at_start)):
            raise NotMeasurable(f"body '{body.name}' is led: mechanical energy is not conserved")


def _scale(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    """The energy in play [J]: largest kinetic energy of the truth, else that at the start, else the swing of the potential."""
    if expected is not None and len(expected) > 0:
        scale = float(np.max(_kinetic(scene, expected, expected.v_WB, expected.w_WB)))
    else:
        scale = float(_kinetic(scene, actual, actual.v_WB, actual.w_WB)[0])
        if scale == 0.0:
            scale = float(np.ptp(_potential(scene, actual)))
    if scale == 0.0:
        raise NotMeasurable("nothing moves: there is no energy to compare a drift with")
    return scale


def energy_change(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    """Energy won since the start, as a share of the energy in play, (t,)."""
    _check(scene, actual)
    energy = _kinetic(scene, actual, actual.v_WB, actual.w_WB) + _potential(scene, actual)
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
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    energy = _kinetic(run.scene, run.actual, run.actual.v_WB, run.actual.w_WB) + _potential(run.scene, run.actual) + held
    change: Floats = (energy - energy[0]) / sum(run.scene.bodies[place].mass for place in run.movable)
    return change


def _rise(energy: Floats) -> Floats:
    """How much more there is than there was before, (t,): over the least so far; not finite from where one sample is not."""
    rise: Floats = energy - np.minimum.accumulate(energy)
    return rise


def _drift(run: Run) -> Floats:
    return np.abs(energy_change(run.scene, run.actual, run.expected))


def _growth(run: Run) -> float:
    """Slope [1/s] of a straight line through the energy, by least squares; not finite where one sample is not."""
    change = energy_change(run.scene, run.actual, run.expected)
    if len(change) < 3:
        raise NotMeasurable(f"{len(change)} samples, at least 3 are needed for a slope")
    since = run.actual.time - run.actual.time.mean()
    return float(since @ change / (since @ since))


def _staggered_drift(run: Run) -> Floats:
    from scipy.interpolate import CubicSpline  # late: a listing must not pay for it

    _check(run.scene, run.actual)
    if len(run.actual) < 4:
        raise NotMeasurable(f"{len(run.actual)} samples, at least 4 are needed to differentiate velocities")
    half = run.actual.dt / 2
    v_WB = run.actual.v_WB + half * CubicSpline(run.actual.time, run.actual.v_WB).derivative()(run.actual.time)
    w_WB = run.actual.w_WB + half * CubicSpline(run.actual.time, run.actual.w_WB).derivative()(run.actual.time)
    energy = _kinetic(run.scene, run.actual, v_WB, w_WB) + _potential(run.scene, run.actual)
    drift: Floats = np.abs(energy - energy[0]) / _scale(run.scene, run.actual, run.expected)
    return drift


energy_drift_max, energy_drift_final = two("energy_drift", "1", SOURCE, _drift)


@metric("1", SOURCE, even=True)
def energy_drift_staggered_max(run: Run) -> Floats:
    return _staggered_drift(run)


@metric("1")
def energy_gain_max(run: Run) -> Floats:
    """conservation of energy: energy won since the start, as a share of the energy in play; 0 where it only falls"""
    return energy_change(run.scene, run.actual, run.expected)


@metric("1/s")
def energy_growth_rate(run: Run) -> float:
    """conservation of energy: magnitude of the slope of a straight line through the energy over that in play"""
    return abs(_growth(run))


@metric("J/kg")
def held_energy_gain_max(run: Run) -> Floats:
    """dissipation: kinetic energy, and that of weight, springs and drives, won since the start, over the movable mass"""
    return _held_change(run)


@metric("J/kg")
def energy_rise_max(run: Run) -> Floats:
    """dissipation: kinetic energy, and that of weight, springs and drives, over its least so far, over the movable mass"""
    return _rise(_held_change(run))
