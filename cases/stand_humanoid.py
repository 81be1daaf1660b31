"""A humanoid that stands on its PD drives, in the pose in which they bear its weight: nothing should move.

What moves is the engine's: too few iterations of its solver, drives that fight the contacts, or too long a step.
"""

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import G, supported
from plumbline.harness.case.standing import feet_stay, holds_its_pose, stands_up, still
from plumbline.harness.metrics import contacts, jitter, joints
from plumbline.harness.props.robots.floor import floor, grip
from plumbline.harness.props.robots.humanoid import humanoid
from plumbline.harness.props.robots.robot import MATERIAL, bearing
from plumbline.harness.scene import EARTH_GRAVITY, Effect, Scene
from plumbline.harness.truths.friction import resting

LEG = 0.4
"""Length of thighs and shanks [m], roughly."""
DURATION, SETTLED = 3.0, 1.5
STEADY = 1.0


class P(Parameters):
    stiffness: Positive = 1.0
    friction: NotNegative = 0.8


def scene(p: P) -> Scene:
    """The machine on the ground, its drives `stiffness` times as stiff as described, with the same damping ratios."""
    machine = bearing(humanoid(p.stiffness), EARTH_GRAVITY)
    return Scene(
        bodies=(floor(), *machine.bodies),
        joints=machine.hinges,
        surfaces=(grip(p.friction),),
        apart=((MATERIAL, MATERIAL),),
        narrow=Effect.GYROSCOPIC,
    )


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Standing humanoid",
    question="Does a humanoid on PD drives stand still, or why does it tremble?",
    source="statics: drives whose targets make up for the weight; each part of a machine in equilibrium",
    truth="rest",
    # Every step: a tremble from step to step is invisible, or takes the look of a slow one, between samples further apart.
    sample_interval=0.0,
    steady=STEADY,
    ladder=(1 / 60, 1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960),
    hard=Axis(parameter="stiffness", unit="1", easy=0.5, extreme=1000),
    checks=(
        *stands_up(),
        holds_its_pose(LEG),
        Check(
            jitter.rms_speed,
            lambda dt, _: G * dt,
            "g dt, what one step of gravity gives a body before its support takes it away; the sway that this excites "
            "lives longer than the run",
            start=SETTLED,
        ),
        still(LEG),
        feet_stay(SETTLED, DURATION),
        supported(SETTLED, DURATION),
    ),
    observe=(joints.pose_error_rms, jitter.vibration_frequency, joints.joint_gap_max, contacts.penetration),
    insists={"friction": "a machine that stands straight is held by its drives; one that trembles stands on its grip"},
    headline="pose_error_max",
)
