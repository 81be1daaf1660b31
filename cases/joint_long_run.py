"""A pendulum for a million steps: does its energy stay where it is, or creep away?"""

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import conservation, joints
from plumbline.harness.scene import WORLD, Body, Effect, Revolute, Scene, box_inertia
from plumbline.harness.truths.pendulum import hanging

DURATION = 1000.0
AMPLITUDE = 60.0
LENGTH, MASS, THICKNESS = 1.0, 1.0, 0.05
HALF = (THICKNESS, THICKNESS, LENGTH / 2)
D = LENGTH / 2
RATE = float(np.sqrt(MASS * G * D / (box_inertia(MASS, HALF)[1][1] + MASS * D**2)))
"""Angular frequency of small swings [rad/s]."""


class P(Parameters):
    amplitude: float = AMPLITUDE


def scene(p: P) -> Scene:
    """A rod on a hinge about y at the origin, at rest at `amplitude` [degrees from hanging]."""
    p_WB, q_WB = hanging(np.array(np.radians(p.amplitude)), D)
    rod = Body.box("rod", HALF, mass=MASS, touches=False, p_WB=p_WB.tolist(), q_WB=q_WB.tolist())
    hinge = Revolute(name="hinge", parent=WORLD, child="rod", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    return Scene(bodies=(rod,), joints=(hinge,), narrow=Effect.GYROSCOPIC)


def _gap(dt: float, p: P) -> float:
    """A step along the tangent leaves the circle by (v dt)^2/(2 d); a solver that takes back a fifth a step keeps five."""
    fastest = 2 * float(np.sin(np.radians(p.amplitude) / 2)) * RATE * D
    return 5 * (fastest * dt) ** 2 / (2 * D) + 1e-6


def _swing(dt: float, p: P) -> float:
    """Twice (w0/2) dt for half a step between position and velocity, and the gap's height, over the energy in play."""
    return RATE * dt + _gap(dt, p) / (D * (1 - float(np.cos(np.radians(p.amplitude)))))


CASE = Case.of(
    globals(),
    title="A million steps",
    question="Does the energy of a frictionless pendulum stay bounded over a million steps, without a trend?",
    source="Hairer, Lubich, Wanner, Geometric Numerical Integration, section IX.8: long-time energy conservation",
    truth="conservation",
    sample_interval=0.5,
    dt=1 / 1000,
    # A million steps belong to the case's own step; over the ladder the thousand seconds take 20 000 to 120 000.
    ladder=(1 / 20, 1 / 30, 1 / 45, 1 / 60, 1 / 90, 1 / 120),
    headline=conservation.energy_growth_rate.name,
    checks=(
        Check(
            conservation.energy_drift_max,
            _swing,
            "position and velocity half a step apart make an energy that swings by (w0/2) dt, taken twice, and a "
            "hinge's gap adds its height. Neither grows with the length of the run",
        ),
        Check(
            conservation.energy_growth_rate,
            lambda dt, p: _swing(dt, p) / DURATION,
            "what only swings has no trend beyond its swing over the length of the run. A damping of 1e-3/s would lose "
            "the energy of half an hour's motion in this run",
        ),
        Check(joints.joint_gap_max, _gap, "as in a short run: five steps' departure along the tangent"),
    ),
    observe=(conservation.energy_drift_final, conservation.energy_drift_staggered_max, joints.joint_gap_final),
)
