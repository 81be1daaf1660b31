"""Quadrupeds that hold themselves up: n machines side by side, each in the pose in which its PD drives bear its weight."""

from plumbline.harness.case import Axis, Case, Check, FloatCount, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.case.standing import SHARE, feet_stay, holds_its_pose, stands_up, still
from plumbline.harness.metrics import contacts, jitter, joints
from plumbline.harness.props.robots.floor import floor, grip
from plumbline.harness.props.robots.quadruped import DAMPING, LEG, STIFFNESS, quadruped
from plumbline.harness.props.robots.robot import MATERIAL, bearing, copy_of
from plumbline.harness.scene import EARTH_GRAVITY, Effect, Scene
from plumbline.harness.truths.friction import resting

SPACING, ROW = 1.0, 4
DURATION, SETTLED = 3.0, 1.5
STEADY = 1.0


class P(Parameters):
    n: FloatCount = 1
    stiffness: Positive = STIFFNESS
    damping: NotNegative = DAMPING
    friction: NotNegative = 0.8


def scene(p: P) -> Scene:
    """n machines in rows of four; drives of `stiffness` [N m/rad] and `damping` [N m s/rad]."""
    robot = bearing(quadruped(p.stiffness, p.damping), EARTH_GRAVITY)
    machines = [copy_of(robot, str(k), (SPACING * (k % ROW), SPACING * (k // ROW), 0.0)) for k in range(round(p.n))]
    return Scene(
        bodies=(floor(), *(body for machine in machines for body in machine.bodies)),
        joints=tuple(hinge for machine in machines for hinge in machine.hinges),
        surfaces=(grip(p.friction),),
        apart=((MATERIAL, MATERIAL),),
        narrow=Effect.GYROSCOPIC,
    )


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Standing quadrupeds",
    question="Do quadrupeds on PD drives stand still, bear their weight on their feet, and neither slip nor sag?",
    source="statics: drives whose targets make up for the weight; each part of a machine in equilibrium",
    truth="rest",
    # Every step: a tremble from step to step is invisible, or takes the look of a slow one, between samples further apart.
    sample_interval=0.0,
    steady=STEADY,
    hard=Axis(parameter="n", unit="1", easy=1, extreme=16),
    checks=(
        *stands_up(),
        holds_its_pose(LEG),
        Check(
            jitter.rms_speed,
            lambda dt, _: SHARE * G * dt,
            "0.01 g, the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz), over one step",
            start=SETTLED,
        ),
        still(LEG),
        feet_stay(SETTLED, DURATION),
        Check(
            contacts.support_force_error,
            lambda dt, _: SHARE * dt / (DURATION - SETTLED) + 1e-6,
            "the mean force over the window misses the weight by the change of momentum, m times the speed of 0.01 g "
            "over one step; 1e-6 for a solver's tolerance",
            start=SETTLED,
        ),
    ),
    observe=(joints.pose_error_rms, jitter.vibration_frequency, joints.joint_gap_max, contacts.penetration),
    insists={"friction": "a machine that stands straight is held by its drives; one that trembles stands on its grip"},
    headline="pose_error_max",
)
