"""Checks of joints: what they let free, what they hold, and whether the bodies that they hold collide."""

from math import cos, pi, sin, sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, firm, near, refusable, that
from plumbline.harness.conformance.closed_forms import pendulum_end, swing
from plumbline.harness.conformance.engine import COARSE, Engine
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Y, Z, aligned, rotation, vector
from plumbline.harness.conformance.scenes import G, block, free, prismatic, revolute, tie, without_gravity
from plumbline.harness.scene import WORLD, Ball, Body, Fixed, Scene, Surface, axis_angle, multiply, rotate

_HELD = 5e-3
"""What a held degree of freedom may give way [m or rad]: constraints solved by iteration or with compliance stay below."""
_FIRST = "a staggered scheme of first order is off by half a step of motion"


def _pendulum(angle: float) -> Scene:
    """A rigid pendulum of 2 kg and 1 m that swings about the axis y through the origin, let go at `angle` [rad] from below."""
    bob = free("bob", moments=(0.2, 0.2, 0.2), p=pendulum_end(1.0, angle), q=axis_angle(Y, angle))
    return Scene(bodies=(bob,), joints=(revolute("pin", "bob", ORIGIN, Y),))


def _several(t: float) -> tuple[np.ndarray, float]:
    """Where the two slides and the hinge of `several_joints_move_one_body` are after t [s]."""
    arm, rate, angle = np.array((0.3, 0.1)), 3.0, 0.2

    def centre(a: float) -> np.ndarray:
        return np.array((arm[0] * cos(a) + arm[1] * sin(a), arm[1] * cos(a) - arm[0] * sin(a)))

    def swinging(a: float) -> np.ndarray:
        return rate * np.array((arm[1] * cos(a) - arm[0] * sin(a), -arm[0] * cos(a) - arm[1] * sin(a)))

    fallen = centre(angle) + (np.array((1.0, 0.5)) + swinging(angle)) * t - (0.0, G * t * t / 2)
    return fallen - centre(angle + rate * t), angle + rate * t


@check(
    "Do several joints, one after the other with no mass between them, move one body?",
    Feature.MASSLESS | Feature.REVOLUTE | Feature.PRISMATIC,
)
def several_joints_move_one_body(engine: Engine) -> Comparisons:
    """Slides along x and z, then a hinge about y, .32 m off the centre of mass: that falls as a free body's does, at 3 rad/s.

    What the slides carry alone stands where the hinge is, and does not turn.
    """
    t, start = 0.3, 0.2
    turn = axis_angle(Y, start)
    x, _, z = arm = rotate(turn, (0.3, 0.0, 0.1))
    body = free("body", moments=(0.1, 0.2, 0.3), p=arm, q=turn, v=(1.0 + 3.0 * z, 0.0, 0.5 - 3.0 * x), w=(0.0, 3.0, 0.0))
    bodies = (Body.between("ahead", v_WB=(1.0, 0.0, 0.0)), Body.between("above", v_WB=(1.0, 0.0, 0.5)), body)
    joints = (
        prismatic("x", "ahead", ORIGIN, X),
        prismatic("z", "above", ORIGIN, Z, parent="ahead"),
        revolute("y", "body", ORIGIN, Y, position=start, parent="above"),
    )
    end = engine.final(Scene(bodies=bodies, joints=joints), t)
    (x, z), angle = _several(t)
    turned = axis_angle(Y, angle)
    swung = rotate(turned, (0.3, 0.0, 0.1))
    yield near("body after .3 s [m]", end.p_WB[2], (x + swung[0], 0.0, z + swung[2]), _HELD, f"3 m/s times dt/2: {_FIRST}")
    yield aligned("turn of the body [rad]", end.q_WB[2], turned, _HELD, "nothing turns it")
    yield near("on the first slide [m]", end.p_WB[0], (x, 0.0, 0.0), _HELD, "where the hinge is, and at the height of the rail")
    yield near("on both slides [m]", end.p_WB[1], (x, 0.0, z), _HELD, "where the hinge is")
    yield near("turn of what slides [1]", np.abs(end.q_WB[:2]), [(1.0, 0.0, 0.0, 0.0)] * 2, 1e-9, "a slide turns nothing")
    yield near("its angular velocity [rad/s]", end.w_WB[:2], np.zeros((2, 3)), 1e-9, "nor does it while it moves")
    at_hinge, because = end.v_WB[2] - np.cross(end.w_WB[2], swung), "3 rad/s times how far off the arm may be"
    yield near("its velocity against the hinge's [m/s]", end.v_WB[1], at_hinge, 3.0 * _HELD, because)


@check("Does a rigid pendulum swing at its rate, inertia about the axis included?", Feature.REVOLUTE)
def joint_pendulum_period(engine: Engine) -> Comparisons:
    """(I + m l^2) a'' = -m g l sin a, from 1 rad for 1 s: nearly half a period."""
    angle, rate = swing(2.0 * G, 0.2 + 2.0, 1.0)
    end = engine.final(_pendulum(1.0), 1.0)
    yield near("bob after 1 s [m]", end.p_WB[0], pendulum_end(1.0, angle), _HELD, f"3 m/s times dt/2 = 1.5 mm: {_FIRST}")
    yield near("angular velocity [rad/s]", end.w_WB[0], (0.0, rate, 0.0), 0.02, "right-handed about the axis")
    yield aligned("orientation [rad]", end.q_WB[0], axis_angle(Y, float(angle)), _HELD)


@check("Does a pendulum keep its energy where the scene asks for no damping?", Feature.REVOLUTE)
def joint_damping_is_off(engine: Engine) -> Comparisons:
    run = engine.record(_pendulum(pi / 2), 3.0, every=4, dt=COARSE)
    # The energy of a staggered scheme oscillates by 6e-3 m g l; damping of .04 at the joint takes ten times that.
    energy = run.v_WB[:, 0] ** 2 @ np.ones(3) + 0.1 * (run.w_WB[:, 0] ** 2 @ np.ones(3)) + 2.0 * G * run.p_WB[:, 0, 2]
    yield near("energy over 3 s / (m g l)", energy[-60:].mean() / (2.0 * G), 0.0, 0.01, "kept; mean over the last second")
    yield that(float(np.ptp(run.p_WB[:, 0, 0])) > 1.0, "the pendulum swings")


@firm("Are anchor and axis in W, and the initial velocity kept?", Feature.REVOLUTE)
def revolute_turns_about_its_axis(engine: Engine) -> Comparisons:
    """A turned body runs round a slanted axis away from its centre, without gravity: at constant rate."""
    axis, anchor, arm = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.5, -0.3, 0.2]), np.array([0.6, 0.3, -0.6])
    w, t = 2.0, 0.15
    p = anchor + arm
    body = free("body", p=vector(p), q=TURNED, v=vector(np.cross(w * axis, arm)), w=vector(w * axis))
    pin = revolute("pin", "body", vector(anchor), vector(axis))
    end = engine.final(without_gravity(body, joints=(pin,)), t)
    turn = axis_angle(vector(axis), w * t)
    expected = anchor + rotation(turn) @ arm
    because = "5 % of the way, for default damping, judged elsewhere"
    yield near("place after turning by .3 rad [m]", end.p_WB[0], expected, 0.05 * 0.27, because)
    yield near("distance from the anchor [m]", np.linalg.norm(end.p_WB[0] - anchor), 0.9, _HELD, "it is held")
    yield aligned("orientation [rad]", end.q_WB[0], multiply(turn, TURNED), 0.05 * 0.3, because)
    yield near("w_WB [rad/s]", end.w_WB[0], w * axis, 0.05 * w, "no moment acts about the axis")


@firm("Does a slide move along its axis alone, in W?", Feature.PRISMATIC)
def prismatic_slides_along_its_axis(engine: Engine) -> Comparisons:
    axis, t = np.array([2.0, -1.0, 2.0]) / 3, 0.4
    body = free("body", p=(0.3, 0.2, 0.1), q=TURNED)
    slide = prismatic("slide", "body", ORIGIN, vector(axis))
    end = engine.final(Scene(bodies=(body,), joints=(slide,)), t)
    a = -G * axis[2]
    gone, expected, because = end.p_WB[0] - np.array(body.p_WB), a * t * t / 2 * axis, "5 % for default damping"
    yield near("way under gravity [m]", gone, expected, 0.05 * -a * t * t / 2, because)
    yield near("velocity [m/s]", end.v_WB[0], a * t * axis, 0.05 * -a * t, "gravity along the axis alone; 5 % for damping")
    yield aligned("orientation [rad]", end.q_WB[0], TURNED, _HELD, "it does not turn")


@check("Does a fixed joint hold place and orientation, to the world and between bodies?", Feature.FIXED)
def fixed_joint_holds(engine: Engine) -> Comparisons:
    post, arm = free("post", p=(0.0, 0.0, 1.0)), free("arm", p=(0.8, 0.0, 1.2), q=TURNED)
    joints = (Fixed(name="foot", parent=WORLD, child="post"), Fixed(name="weld", parent="post", child="arm"))
    end = engine.final(Scene(bodies=(post, arm), joints=joints), 0.3)
    yield near("places of two bodies welded to the world [m]", end.p_WB, [post.p_WB, arm.p_WB], _HELD, "they do not move")
    yield aligned("turn of the outer one [rad]", end.q_WB[1], TURNED, 2 * _HELD)


@check("Does a ball joint hold its anchor and nothing else?", Feature.BALL)
def ball_joint_holds_its_anchor(engine: Engine) -> Comparisons:
    """Two links on ball joints, thrown sideways: anchors stay together, all rotations go on."""
    upper = free("upper", p=(0.0, 0.0, -0.5), moments=(0.1, 0.2, 0.25), w=(0.0, 0.0, 2.0))
    lower = free("lower", p=(0.5, 0.0, -1.0), q=TURNED, moments=(0.1, 0.2, 0.25))
    joints = (
        Ball(name="top", parent=WORLD, child="upper", anchor_W=ORIGIN),
        Ball(name="elbow", parent="upper", child="lower", anchor_W=(0.0, 0.0, -1.0)),
    )
    end = engine.final(Scene(bodies=(upper, lower), joints=joints), 0.5)
    R_upper, R_lower = rotation(end.q_WB[0]), rotation(end.q_WB[1])
    arm = rotation(TURNED).T @ (-0.5, 0.0, 0.0)
    elbow = end.p_WB[0] + R_upper @ (0.0, 0.0, -0.5)
    yield near("the upper anchor [m]", end.p_WB[0] + R_upper @ (0.0, 0.0, 0.5), ORIGIN, _HELD, "it stays in the world")
    yield near("the elbow seen from below [m]", end.p_WB[1] + R_lower @ arm, elbow, _HELD, "both links share it")
    yield that(
        end.p_WB[1, 0] < 0.4, f"x of the lower link: got {end.p_WB[1, 0]:.4g} m, expected below .4: it swings down from .5"
    )
    yield that(abs(end.w_WB[0, 2]) > 0.5, f"spin about z: got {end.w_WB[0, 2]:.4g} rad/s, expected to go on from 2")


@check("Does a rod keep its length, in pull and push, without doing work?", Feature.DISTANCE)
def distance_joint_keeps_its_length(engine: Engine) -> Comparisons:
    """A bob on a rod, thrown across: the distance stays, the rod carries push as well as pull."""
    rod = tie("rod", "bob", ORIGIN, (0.0, 0.8, 0.6))
    bob = free("bob", p=(0.0, 0.8, 0.6), v=(1.0, 0.0, 0.0))
    run = engine.record(Scene(bodies=(bob,), joints=(rod,)), 0.5, every=10)
    length = np.linalg.norm(run.p_WB[:, 0], axis=1)
    # Energy of a point on a sphere: v^2 = v0^2 + 2 g (z0 - z).
    speed = float(np.linalg.norm(run.v_WB[-1, 0]))
    expected = sqrt(1.0 + 2 * G * (0.6 - float(run.p_WB[-1, 0, 2])))
    yield near("distance over half a second [m]", [length.min(), length.max()], (1.0, 1.0), _HELD, "it is held")
    yield near("speed from the height fallen [m/s]", speed, expected, 0.02 * expected, "the rod does no work; 2 %")


@check("Does a loop of joints stay closed in motion?", Feature.REVOLUTE | Feature.CLOSED_LOOP)
def closed_loop_stays_closed(engine: Engine) -> Comparisons:
    """A parallelogram of three bars falls to one side: its coupler stays level, its four pins together."""
    moments, half = (0.1, 0.1, 0.1), (0.5, 0.0, 0.0)
    left, right = (
        free(name, p=(x, 0.0, 0.5), v=half, w=Y, mass=1.0, moments=moments) for name, x in (("left", 0.0), ("right", 1.0))
    )
    top = free("top", p=(0.5, 0.0, 1.0), v=X, mass=1.0, moments=moments)
    y = (0.0, 1.0, 0.0)
    joints = (
        revolute("a", "left", ORIGIN, y),
        revolute("b", "top", Z, y, parent="left"),
        revolute("c", "right", X, y),
        revolute("d", "right", (1.0, 0.0, 1.0), y, parent="top"),
    )
    end = engine.final(Scene(bodies=(left, top, right), joints=joints), 0.4)
    tops = [end.p_WB[k] + rotation(end.q_WB[k]) @ (0.0, 0.0, 0.5) for k in (0, 2)]
    for side, x, crank in zip(("left", "right"), (-0.5, 0.5), tops, strict=True):
        tip = end.p_WB[1] + rotation(end.q_WB[1]) @ (x, 0, 0)
        yield near(f"{side} end of the coupler against the {side} crank [m]", tip, crank, _HELD)
    yield aligned("tilt of the coupler [rad]", end.q_WB[1], (1, 0, 0, 0), 2 * _HELD, "a parallelogram")
    yield that(end.p_WB[1, 2] < 0.95, f"height of the coupler: got {end.p_WB[1, 2]:.4g} m, expected below .95: it falls")


def _leaves(apart: float, w: float, collide: bool) -> Scene:
    """Two boxes, one `apart` [m] above the other, on a hinge about y beside their common face; w [rad/s] opens it."""
    pin_W = (0.4, 0.0, 0.15)
    below, above = block("below", half=(0.3, 0.1, 0.1), p=ORIGIN), (0.0, 0.0, 0.2 + apart)
    opening = vector(np.cross((0.0, w, 0.0), np.subtract(above, pin_W)))
    leaf = block("above", half=(0.3, 0.1, 0.1), p=above, v=opening, w=(0.0, w, 0.0))
    pin = revolute("pin", "above", pin_W, Y, collide=collide, parent="below")
    return without_gravity(below, leaf, joints=(pin,), surfaces=(Surface(between=("block", "block")),))


@check("Do bodies that a joint keeps from colliding overlap in peace?", Feature.REVOLUTE | Feature.BOX)
def joined_bodies_do_not_collide(engine: Engine) -> Comparisons:
    end = engine.final(_leaves(-0.005, 0.0, False), 0.1)
    because = "a joint keeps them from colliding"
    yield near("velocities of two overlapping boxes on one hinge [m/s]", end.v_WB, np.zeros((2, 3)), 1e-6, because)
    yield near("their angular velocities [rad/s]", end.w_WB, np.zeros((2, 3)), 1e-6, because)


@check("Do bodies collide whose joint says that they do?", Feature.REVOLUTE | Feature.BOX)
def joined_bodies_collide_when_told(engine: Engine) -> Comparisons:
    """The same hinge, closing at .2 rad/s over a gap of 2 mm: the boxes meet and stop, or the engine refuses such a joint."""
    with refusable():
        end = engine.final(_leaves(0.002, -0.2, True), 0.15)
    rate = float(end.w_WB[1, 1] - end.w_WB[0, 1])
    yield that(rate > -0.05, f"rate of the hinge: got {rate:.4g} rad/s, expected above -.05: the boxes meet and stop")


@check(
    "Does a loop that is closed between turned bodies rest where it was built?",
    Feature.REVOLUTE | Feature.BALL | Feature.CLOSED_LOOP,
)
def closed_loop_rests_where_it_was_built(engine: Engine) -> Comparisons:
    """Two turned bodies on hinges to the world, a ball between them off both centres, at rest where nothing pulls."""
    left, right = free("left", p=(-0.5, 0.2, 0.0), q=TURNED), free("right", p=(0.5, -0.1, 0.3), q=multiply(TURNED, TURNED))
    joints = (
        revolute("a", "left", (-1.0, 0.0, 0.2), Y),
        revolute("b", "right", (1.0, 0.0, -0.2), Y),
        Ball(name="shut", parent="left", child="right", anchor_W=(0.1, 0.3, 0.2)),
    )
    end = engine.final(without_gravity(left, right, joints=joints), 0.2)
    yield near("places [m]", end.p_WB, [left.p_WB, right.p_WB], 1e-4, "nothing pulls, nothing moves")
    yield aligned("turns [rad]", end.q_WB, [left.q_WB, right.q_WB], 1e-4)
