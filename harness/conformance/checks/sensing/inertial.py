"""Checks of an engine's own accelerometer and gyroscope, on a lever, in the sensor's frame, at this instant; and of noise."""

from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import CheckResult, Comparisons, NotApplicable, firm, judge, near
from plumbline.harness.conformance.engine import COARSE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, rotation, symmetric
from plumbline.harness.conformance.scenes import G, free
from plumbline.harness.scene import Body, Imu, Quaternion, Scene, multiply
from plumbline.harness.trajectory import Trajectory


@firm("Do the engine's own accelerometer and gyroscope count their lever, in their frame, at this instant?", Feature.WRENCH)
def inertial_sensors_say_what_they_feel(engine: Engine) -> Comparisons:
    """A body that a torque spins up in free fall carries a sensor on a lever, askew.

    Equation: f_S = R_SW (a + alpha x r + w x (w x r) - g); in free fall a = g, and a sphere has alpha = tau/I, all in W.
    The spin grows by alpha dt = 8 % a step, so that a reading one step late is off by as much.
    """
    return _felt(engine, free(p=(1.0, 2.0, 3.0), q=TURNED), multiply(TURNED, TURNED))


@firm(
    "Do the engine's own sensors keep their mount on a body whose principal axes are turned against it?",
    Feature.WRENCH | Feature.FULL_INERTIA,
)
def inertial_sensors_on_turned_principal_axes(engine: Engine) -> Comparisons:
    """As above, with products of inertia: I w' = tau - w x I w, all in W."""
    R_BM = rotation(multiply(TURNED, TURNED))
    inertia = symmetric(R_BM @ np.diag([0.3, 0.2, 0.25]) @ R_BM.T)
    return _felt(engine, replace(free(p=(1.0, 2.0, 3.0), q=TURNED, w=(2.0, -1.0, 3.0)), inertia=inertia), TURNED)


def _felt(engine: Engine, body: Body, q_BS: Quaternion) -> Comparisons:
    """What a sensor on a lever says after 12 steps under a torque, against the laws of motion."""
    tau = np.array([1.0, 2.0, -1.5])
    imu = Imu(name="imu", body="body", rate=1.0, p_BS=(0.4, -0.3, 0.2), q_BS=q_BS)
    scene = Scene(bodies=(body,), sensors=(imu,))
    with engine.built(scene, COARSE) as simulation:
        inertial: Any = getattr(simulation, "inertial", None)
        if inertial is None:
            raise NotApplicable("the engine has no sensors of its own")
        simulation.wrench(np.zeros((1, 3)), tau[None])
        simulation.step(12)
        at = state_of(simulation, scene)
        force, rate = inertial("imu")
    R_WB, w = rotation(at.q_WB[0]), at.w_WB[0]
    R_SW, r, inertia = (R_WB @ rotation(imu.q_BS)).T, R_WB @ imu.p_BS, R_WB @ np.array(body.inertia) @ R_WB.T
    alpha = np.linalg.solve(inertia, tau - np.cross(w, inertia @ w))
    felt = R_SW @ (np.cross(alpha, r) + np.cross(w, np.cross(w, r)))
    later = alpha * COARSE
    change = float(np.linalg.norm(np.cross(later, np.cross(w, r)) + np.cross(w, np.cross(later, r))))
    because = "a fifth of what one step changes"
    yield near("specific force in S [m/s2]", force, felt, 0.2 * change, because)
    yield near("angular velocity in S [rad/s]", rate, R_SW @ w, 0.2 * float(np.linalg.norm(later)), because)


@firm("Does the engine's own accelerometer feel what bears it?", Feature.WRENCH)
def inertial_sensors_feel_their_support(engine: Engine) -> Comparisons:
    """Pushed upwards by its weight a body hangs still, and its accelerometer says +g upwards, in the sensor's frame."""
    imu = Imu(name="imu", body="body", rate=1.0, p_BS=(0.4, -0.3, 0.2), q_BS=TURNED)
    scene = Scene(bodies=(free(q=TURNED),), sensors=(imu,))
    with engine.built(scene, COARSE) as simulation:
        inertial: Any = getattr(simulation, "inertial", None)
        if inertial is None:
            raise NotApplicable("the engine has no sensors of its own")
        simulation.wrench(np.array([[0.0, 0.0, 2.0 * G]]), np.zeros((1, 3)))
        simulation.step(5)
        force, rate = inertial("imu")
    up = (rotation(TURNED) @ rotation(TURNED)).T @ np.array([0.0, 0.0, G])
    yield near("specific force in S [m/s2]", force, up, 1e-6 * G, "the force that bears it, over its mass")
    yield near("angular velocity in S [rad/s]", rate, ORIGIN, 1e-9)


def noise_axes_are_independent(trajectory: Trajectory) -> CheckResult:
    """Are the channels of each stream (k, c) uncorrelated about their means, as separately seeded noise is?

    Equation: the correlation of k independent pairs has the standard deviation 1/sqrt(k); five of them are granted.
    """
    comparisons = []
    for name, signal in trajectory.streams.items():
        if name.endswith("/time") or signal.ndim != 2 or len(signal) < 100:
            continue
        moving = signal[:, signal.std(axis=0) > 0]
        for a in range(moving.shape[1]):
            for b in range(a + 1, moving.shape[1]):
                r = float(np.corrcoef(moving[:, a], moving[:, b])[0, 1])
                comparisons.append(near(f"correlation of axes {a} and {b} of {name}", r, 0.0, 5 / np.sqrt(len(signal))))
    if not comparisons:
        return CheckResult("not_applicable", "no stream with two noisy channels of 100 samples")
    return judge(*comparisons)
