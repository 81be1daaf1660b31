"""A heavy box on a light one of the same size: does the light one bear it?

The contact at the ground must carry ratio + 1 times the weight of the body that it holds. A solver that goes from contact to
contact passes on, each time, only what the light body alone can take.
"""

from harness.case import Axis, Case, Check
from harness.metrics.collapse import COLLAPSE_TIME
from harness.metrics.contact_force import SUPPORT_FORCE_ERROR
from harness.metrics.jitter import REST_DRIFT, RMS_SPEED
from harness.metrics.penetration import PENETRATION
from harness.metrics.stack import STACK_HEIGHT_ERROR
from harness.scene import EARTH_GRAVITY, Body, Box, PlacedShape, Plane, Scene, Surface, box_inertia
from harness.trajectory import Floats, Trajectory

G = -EARTH_GRAVITY[2]
RATIO, FRICTION, MASS, HALF = 1000.0, 0.5, 1.0, 0.1
SETTLED, DURATION = 1.0, 2.0
SOFTNESS = 1e-5
"""What a solver of constraints may mix into the diagonal of its matrix, relative to it, to keep it regular: ODE's and DART's
default constraint force mixing. A contact gives by that share, times the load that it bears over the body that it holds."""


def scene(ratio: float = RATIO, friction: float = FRICTION) -> Scene:
    """Two equal cubes, exactly touching: the lower of MASS, the upper of `ratio` times as much."""
    cube = (PlacedShape(shape=Box(half_extents=(HALF, HALF, HALF))),)
    boxes = [
        Body(
            name=name,
            mass=mass,
            inertia=box_inertia(mass, (HALF, HALF, HALF)),
            collision=cube,
            p_WB=(0.0, 0.0, height),
        )
        for name, mass, height in (("light", MASS, HALF), ("heavy", ratio * MASS, 3 * HALF))
    ]
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    return Scene(bodies=(ground, *boxes), surfaces=(Surface(static_friction=friction, kinetic_friction=friction),))


def expected(time: Floats, ratio: float = RATIO, friction: float = FRICTION) -> Trajectory:
    """Rest."""
    stage = scene(ratio, friction)
    truth = Trajectory.of(time, len(stage.bodies))
    truth.p_WB[:] = [body.p_WB for body in stage.bodies]
    return truth


CASE = Case(
    name="stack_mass_ratio",
    title="Heavy on light",
    question="Does a light box bear one that is a thousand times heavier, and bear it still?",
    source="statics: the ground bears both weights, the light box the heavy one's; nothing moves, whatever the ratio",
    truth="rest",
    scene=scene,
    expected=expected,
    parameters={"ratio": RATIO, "friction": FRICTION},
    duration=DURATION,
    with_contacts=True,
    steady=SETTLED,
    hard=Axis(parameter="ratio", unit="1", easy=1, extreme=1e6),
    checks=(
        Check(
            metric=COLLAPSE_TIME,
            at_most=lambda dt: DURATION - dt,
            because="the stack stands for the whole run, which ends within a step of its nominal length",
        ),
        Check(
            metric=STACK_HEIGHT_ERROR,
            at_most=lambda dt: 2 * G * dt**2 / (3 * HALF) * (1 + SOFTNESS * RATIO),
            because="before a contact can push, a box falls for one step, g dt^2; if each of the two contacts gave as much, "
            "the top would sink by this share of the height of its centre, whatever the ratio; 1e-5 times the ratio more for a "
            "solver that keeps its matrix regular by such a share (ODE User Guide, Constraint Force Mixing)",
        ),
        Check(
            metric=RMS_SPEED,
            at_most=lambda dt: G * dt,
            because="g dt, what one step of gravity gives a box before its support takes it away",
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
    observe=(PENETRATION, REST_DRIFT),
    headline="stack_height_error",
)
