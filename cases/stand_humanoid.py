"""A humanoid that stands on its PD drives, in the pose in which they bear its weight: nothing should move.

What moves is the engine's: too few iterations of its solver, drives that fight the contacts, or too long a step.
"""

from harness.case import Axis, Case, Check
from harness.machines.humanoid import humanoid
from harness.machines.machine import MATERIAL, bearing
from harness.metrics.contact_force import SUPPORT_FORCE_ERROR
from harness.metrics.divergence import DIVERGENCE
from harness.metrics.energy import HELD_ENERGY_GAIN
from harness.metrics.foot_slip import FOOT_SLIP
from harness.metrics.jitter import RMS_SPEED
from harness.metrics.joint_gap import JOINT_GAP_MAX
from harness.metrics.penetration import PENETRATION
from harness.metrics.pose import POSE_ERROR_MAX, POSE_ERROR_RMS
from harness.metrics.stack import STANDING_HEIGHT
from harness.metrics.vibration import VIBRATION_FREQUENCY, VIBRATION_RMS
from harness.scene import EARTH_GRAVITY, Body, Box, PlacedShape, Scene, Surface
from harness.trajectory import Floats, Trajectory

G = -EARTH_GRAVITY[2]
FRICTION = 0.8
LEG = 0.4
"""Length of thighs and shanks [m], roughly."""
GIVE = 1e-3
"""What a joint may be off under weight and still hold its pose [rad]."""
DURATION, SETTLED = 3.0, 1.5
STEADY = 1.0
SHARE = 0.01
SLAB_DEPTH = 0.5
PRESSED = 1e-6
"""How deep the soles start in the ground [m]: what just touches, some engines find a step late, and by then the drives have
thrown the feet about."""
SLAB = Box(half_extents=(5.0, 5.0, SLAB_DEPTH))
"""The ground; a box, since some engines find a box on a plane by one corner more in each step."""


def scene(stiffness: float = 1.0, friction: float = FRICTION) -> Scene:
    """The machine on the ground, its drives `stiffness` times as stiff as described, with the same damping ratios."""
    machine = bearing(humanoid(stiffness), EARTH_GRAVITY)
    ground = Body(
        name="ground",
        motion="static",
        material="ground",
        collision=(PlacedShape(shape=SLAB),),
        p_WB=(0.0, 0.0, PRESSED - SLAB_DEPTH),
    )
    return Scene(
        bodies=(ground, *machine.bodies),
        joints=machine.hinges,
        surfaces=(Surface(between=("ground", MATERIAL), static_friction=friction, kinetic_friction=friction),),
        apart=((MATERIAL, MATERIAL),),
    )


def expected(time: Floats, stiffness: float = 1.0, friction: float = FRICTION) -> Trajectory:
    """Rest."""
    stage = scene(stiffness, friction)
    truth = Trajectory.of(time, len(stage.bodies))
    truth.p_WB[:] = [body.p_WB for body in stage.bodies]
    truth.q_WB[:] = [body.q_WB for body in stage.bodies]
    return truth


CASE = Case(
    name="stand_humanoid",
    title="Standing humanoid",
    question="Does a humanoid on PD drives stand still, or why does it tremble?",
    source="statics: drives whose targets make up for the weight; each part of a machine in equilibrium",
    truth="rest",
    scene=scene,
    expected=expected,
    parameters={"stiffness": 1.0, "friction": FRICTION},
    duration=DURATION,
    # Every step: a tremble from step to step is invisible, or takes the look of a slow one, between samples further apart.
    sample_interval=0.0,
    with_contacts=True,
    steady=STEADY,
    ladder=(1 / 60, 1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960),
    hard=Axis(parameter="stiffness", unit="1", easy=0.5, extreme=1000),
    checks=(
        Check(metric=DIVERGENCE, at_most=0.0, because="a machine that stands stays where it is"),
        Check(metric=STANDING_HEIGHT, at_most=0.5, because="the definition of a collapse: the top below half its height"),
        Check(
            metric=POSE_ERROR_MAX,
            at_most=lambda dt: G * dt**2 / LEG + GIVE,
            because="before a contact can push, the machine falls for one step, g dt^2: so far a foot may give way, over the "
            "length of a leg's part; and a thousandth of a radian, a millimetre at a metre, which a contact may give way under "
            "weight",
        ),
        Check(
            metric=HELD_ENERGY_GAIN,
            at_most=lambda dt: (G * dt) ** 2 / 2,
            because="drives that hold a target take energy and give none; (g dt)^2/2 is what one step of gravity gives before "
            "the ground takes it away",
        ),
        Check(
            metric=RMS_SPEED,
            at_most=lambda dt: G * dt,
            because="g dt, what one step of gravity gives a body before its support takes it away; the sway that this excites "
            "lives longer than the run",
            start=SETTLED,
        ),
        Check(
            metric=VIBRATION_RMS,
            at_most=lambda dt: SHARE * G * dt / LEG,
            because="0.01 g, the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz), over one step, at the "
            "end of a leg's part: a machine that trembles less does not feel it",
        ),
        Check(
            metric=FOOT_SLIP,
            at_most=lambda dt: SHARE * G * dt * (DURATION - SETTLED),
            because="the speed of 0.01 g over one step, kept up for the whole window",
            start=SETTLED,
        ),
        Check(
            metric=SUPPORT_FORCE_ERROR,
            at_most=lambda dt: dt / (DURATION - SETTLED),
            because="the mean force over the window misses the weight by the change of momentum, at most m g dt where speeds "
            "stay under one step of gravity",
            start=SETTLED,
        ),
    ),
    observe=(POSE_ERROR_RMS, VIBRATION_FREQUENCY, JOINT_GAP_MAX, PENETRATION),
    headline="pose_error_max",
)
