"""Many equal worlds stepped together: a box that lands, a quadruped that stands, an arm that grasps. What do they cost, and is
each world's answer that of a world alone?

Learning steps thousands of copies of one scene. A rate of steps says little without the error of the same settings, so the end
of each scene is one that statics knows: the box lies where it fell, the quadruped stands and the arm holds in the pose in which
their drives bear all weights.
"""

import math

from plumbline.harness.case import Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, settled_speed
from plumbline.harness.metrics import equivalence
from plumbline.harness.metrics.errors import position_error_final
from plumbline.harness.props.robots.arm import grasping_arm
from plumbline.harness.props.robots.floor import floor, grip
from plumbline.harness.props.robots.quadruped import quadruped
from plumbline.harness.props.robots.robot import MATERIAL, bearing
from plumbline.harness.scene import EARTH_GRAVITY, Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

KINDS = ("box", "quadruped", "arm")
HALF, DROP = 0.1, 0.01
PRESS = 5.0
"""Of each finger [N]: at a friction of 0.8 both hold eight times the weight of the box."""
DURATION, SETTLED = 0.5, 0.4


class P(Parameters):
    kind: str = "box"
    worlds: FloatCount = 1
    friction: NotNegative = 0.8


def scene(p: P) -> Scene:
    """'box': a cube of 1 kg a centimetre above a plane; 'quadruped': one on a floor, its drives bearing its weight; 'arm': one
    whose fingers touch a box of 100 g and press."""
    if p.kind == "box":
        box = Body.box("box", (HALF, HALF, HALF), mass=1.0, material="box", p_WB=(0.0, 0.0, HALF + DROP))
        return Scene(bodies=(Body.ground(), box), surfaces=(Surface.rough(p.friction, ("box", "ground")),))
    if p.kind == "quadruped":
        robot = bearing(quadruped(), EARTH_GRAVITY)
        return Scene(
            bodies=(floor(), *robot.bodies),
            joints=robot.hinges,
            surfaces=(grip(p.friction),),
            apart=((MATERIAL, MATERIAL),),
            narrow=Effect.GYROSCOPIC,
        )
    if p.kind == "arm":
        arm = grasping_arm(PRESS, EARTH_GRAVITY, "load")
        return Scene(
            bodies=arm.bodies,
            joints=arm.joints,
            surfaces=(Surface.rough(p.friction, (MATERIAL, "load")),),
            apart=((MATERIAL, MATERIAL),),
            narrow=Effect.GYROSCOPIC,
        )
    raise ValueError(f"kind '{p.kind}', expected one of {', '.join(KINDS)}")


def expected(time: Floats, p: P) -> Trajectory:
    """The pose at the start; of the box z = h - g t^2/2 until it lies on the plane."""
    truth = Trajectory.at_rest(scene(p), time)
    if p.kind == "box":
        flies = truth.time < math.sqrt(2 * DROP / G)
        truth.p_WB[:, 1, 2] = HALF + (DROP - G * truth.time**2 / 2) * flies
        truth.v_WB[:, 1, 2] = -G * truth.time * flies
    return truth


CASE = Case.of(
    globals(),
    title="Many worlds",
    question="What does a step of many equal worlds cost, is the end of each right, and is it that of a world alone?",
    source="statics of a body at rest; Galileo's fall; the price is measured",
    truth="closed form",
    sample_interval=1 / 20,
    worlds="worlds",
    checks=(
        Check(
            position_error_final,
            lambda dt, _: G * dt**2 + 2 * GIVE,
            "g dt^2, the fall of the one step before a contact can push; a millimetre that a contact may give way under weight "
            "or grip, and another for what hangs on it: a thousandth of a radian at the end of a limb less than a metre long",
        ),
        settled_speed(SETTLED),
        Check(equivalence.world_spread, 0.0, "equal input gives an equal future, bit for bit"),
    ),
    insists={"friction": "what stands or lies does not slide; under an engine's own noise friction is what keeps it in place"},
    scale=HALF,
)
