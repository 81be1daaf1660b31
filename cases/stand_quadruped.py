"""Quadrupeds that hold themselves up: n machines side by side, each in the pose in which its PD drives bear its weight."""

from harness.case import Axis, Case, Check
from harness.machines.machine import MATERIAL, bearing, copy_of
from harness.machines.quadruped import DAMPING, LEG, STIFFNESS, quadruped
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
FRICTION, SPACING, ROW = 0.8, 1.0, 4
DURATION, SETTLED = 3.0, 1.5
STEADY = 1.0
SHARE = 0.01
GIVE = 1e-3
"""What a joint may be off under weight and still hold its pose [rad]."""
SLAB_DEPTH = 0.5
PRESSED = 1e-6
"""How deep the soles start in the ground [m]: what just touches, some engines find a step late, and by then the drives have
thrown the feet about."""
SLAB = Box(half_extents=(5.0, 5.0, SLAB_DEPTH))


def scene(n: float = 1, stiffness: float = STIFFNESS, damping: float = DAMPING, friction: float = FRICTION) -> Scene:
    """n machines in rows of four; drives of `stiffness` [N m/rad] and `damping` [N m s/rad]."""
    one = bearing(quadruped(stiffness, damping), EARTH_GRAVITY)
    machines = [copy_of(one, str(k), (SPACING * (k % ROW), SPACING * (k // ROW), 0.0)) for k in range(round(n))]
    ground = Body(
        name="ground",
        motion="static",
        material="ground",
        collision=(PlacedShape(shape=SLAB),),
        p_WB=(0.0, 0.0, PRESSED - SLAB_DEPTH),
    )
    return Scene(
        bodies=(ground, *(body for machine in machines for body in machine.bodies)),
        joints=tuple(hinge for machine in machines for hinge in machine.hinges),
        surfaces=(Surface(between=("ground", MATERIAL), static_friction=friction, kinetic_friction=friction),),
        apart=((MATERIAL, MATERIAL),),
    )


def expected(
    time: Floats, n: float = 1, stiffness: float = STIFFNESS, damping: float = DAMPING, friction: float = FRICTION
) -> Trajectory:
    """Rest."""
    stage = scene(n, stiffness, damping, friction)
    truth = Trajectory.of(time, len(stage.bodies))
    truth.p_WB[:] = [body.p_WB for body in stage.bodies]
    truth.q_WB[:] = [body.q_WB for body in stage.bodies]
    return truth


CASE = Case(
    name="stand_quadruped",
    title="Standing quadrupeds",
    question="Do quadrupeds on PD drives stand still, bear their weight on their feet, and neither slip nor sag?",
    source="statics: drives whose targets make up for the weight; each part of a machine in equilibrium",
    truth="rest",
    scene=scene,
    expected=expected,
    parameters={"n": 1, "stiffness": STIFFNESS, "damping": DAMPING, "friction": FRICTION},
    duration=DURATION,
    # Every step: a tremble from step to step is invisible, or takes the look of a slow one, between samples further apart.
    sample_interval=0.0,
    with_contacts=True,
    steady=STEADY,
    hard=Axis(parameter="n", unit="1", easy=1, extreme=16),
    checks=(
        Check(metric=DIVERGENCE, at_most=0.0, because="a machine that stands stays where it is"),
        Check(metric=STANDING_HEIGHT, at_most=0.5, because="the definition of a collapse: the top below half its height"),
        Check(
            metric=POSE_ERROR_MAX,
            at_most=lambda dt: G * dt**2 / LEG + GIVE,
            because="before a contact can push, a machine falls for one step, g dt^2: so far a foot may give way, over the "
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
            at_most=lambda dt: SHARE * G * dt,
            because="0.01 g, the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz), over one step",
            start=SETTLED,
        ),
        Check(
            metric=VIBRATION_RMS,
            at_most=lambda dt: SHARE * G * dt / LEG,
            because="the speed of 0.01 g over one step, at the end of a leg's part",
        ),
        Check(
            metric=FOOT_SLIP,
            at_most=lambda dt: SHARE * G * dt * (DURATION - SETTLED),
            because="the speed of 0.01 g over one step, kept up for the whole window",
            start=SETTLED,
        ),
        Check(
            metric=SUPPORT_FORCE_ERROR,
            at_most=lambda dt: SHARE * dt / (DURATION - SETTLED) + 1e-6,
            because="the mean force over the window misses the weight by the change of momentum, m times the speed of 0.01 g "
            "over one step; 1e-6 for a solver's tolerance",
            start=SETTLED,
        ),
    ),
    observe=(POSE_ERROR_RMS, VIBRATION_FREQUENCY, JOINT_GAP_MAX, PENETRATION),
    headline="pose_error_max",
)
