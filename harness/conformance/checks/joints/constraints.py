"""Checks of joints: what they let free, what they hold, and whether the bodies that they hold collide."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.conformance.check import CheckResult, NotApplicable, check, judge, near, that
from plumbline.harness.conformance.room import COARSE, FINE, final, record
from plumbline.harness.conformance.scenes import TURNED, G, angle_between, block, free, rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Fixed,
    Prismatic,
    Quaternion,
    Revolute,
    Scene,
    Surface,
    Vector3,
    axis_angle,
    multiply,
    rotate,
)

_NOWHERE: Vector3 = (0.0, 0.0, 0.0)
_HELD = 5e-3
"""What a held degree of freedom may give way [m or rad]: constraints solved by iteration or with compliance stay below."""
_FIRST = "a staggered scheme of first order is off by half a step of motion"


def _pendulum(angle: float, *, length: float = 1.0, moment: float = 0.2, mass: float = 2.0) -> Scene:
    """A rigid pendulum that swings about the axis y through the origin, let go at `angle` [rad] from below."""
    bob = free(
        "bob",
        mass=mass,
        moments=(moment, moment, moment),
        p=(-length * sin(angle), 0.0, -length * cos(angle)),
        q=axis_angle((0.0, 1.0, 0.0), angle),
    )
    pin = Revolute(name="pin", parent=WORLD, child="bob", anchor_W=_NOWHERE, axis_W=(0.0, 1.0, 0.0))
    return Scene(bodies=(bob,), joints=(pin,))


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
def several_joints_move_one_body(adapter: Adapter, settings: Settings) -> CheckResult:
    """Slides along x and z, then a hinge about y, .32 m off the centre of mass: that falls as a free body's does, at 3 rad/s.

    What the slides carry alone stands where the hinge is, and does not turn.
    """
    t, start = 0.3, 0.2
    turn = axis_angle((0.0, 1.0, 0.0), start)
    swing = rotate(turn, (0.3, 0.0, 0.1))
    moves = (1.0 + 3.0 * swing[2], 0.0, 0.5 - 3.0 * swing[0])
    body = replace(free("body", moments=(0.1, 0.2, 0.3), p=swing, q=turn), v_WB=moves, w_WB=(0.0, 3.0, 0.0))
    bodies = (
        Body.between("ahead", v_WB=(1.0, 0.0, 0.0)),
        Body.between("above", v_WB=(1.0, 0.0, 0.5)),
        body,
    )
    joints = (
        Prismatic(name="x", parent=WORLD, child="ahead", anchor_W=_NOWHERE, axis_W=(1.0, 0.0, 0.0)),
        Prismatic(name="z", parent="ahead", child="above", anchor_W=_NOWHERE, axis_W=(0.0, 0.0, 1.0)),
        Revolute(name="y", parent="above", child="body", anchor_W=_NOWHERE, axis_W=(0.0, 1.0, 0.0), position=start),
    )
    end = final(adapter, Scene(bodies=bodies, joints=joints), settings.with_dt(FINE), t)
    (x, z), angle = _several(t)
    turned = axis_angle((0.0, 1.0, 0.0), angle)
    swung = rotate(turned, (0.3, 0.0, 0.1))
    return judge(
        near("body after .3 s [m]", end.p_WB[2], (x + swung[0], 0.0, z + swung[2]), _HELD, f"3 m/s times dt/2: {_FIRST}"),
        near("turn of the body [rad]", angle_between(end.q_WB[2], turned), 0.0, _HELD, "nothing turns it"),
        near("on the first slide [m]", end.p_WB[0], (x, 0.0, 0.0), _HELD, "where the hinge is, and at the height of the rail"),
        near("on both slides [m]", end.p_WB[1], (x, 0.0, z), _HELD, "where the hinge is"),
        near("turn of what slides [1]", np.abs(end.q_WB[:2]), [(1.0, 0.0, 0.0, 0.0)] * 2, 1e-9, "a slide turns nothing"),
        near("its angular velocity [rad/s]", end.w_WB[:2], np.zeros((2, 3)), 1e-9, "nor does it while it moves"),
        near(
            "its velocity against the hinge's [m/s]",
            end.v_WB[1],
            _speed_at(end.v_WB[2], end.w_WB[2], swung),
            3.0 * _HELD,
            "3 rad/s times how far off the arm may be",
        ),
    )


def _speed_at(v: np.ndarray, w: np.ndarray, arm: Vector3) -> np.ndarray:
    """The velocity at a hinge of a body whose centre is off it by an arm [m]."""
    return v - np.cross(w, arm)


@check("Does a rigid pendulum swing at its rate, inertia about the axis included?", Feature.REVOLUTE)
def joint_pendulum_period(adapter: Adapter, settings: Settings) -> CheckResult:
    """(I + m l^2) a'' = -m g l sin a, from 1 rad for 1 s: nearly half a period."""
    start, t, inertia = 1.0, 1.0, 0.2 + 2.0
    swing = solve_ivp(lambda _, y: (y[1], -2.0 * G * sin(y[0]) / inertia), (0, t), (start, 0.0), rtol=1e-10, atol=1e-10).y[
        :, -1
    ]
    end = final(adapter, _pendulum(start), settings.with_dt(FINE), t)
    expected = (-sin(swing[0]), 0.0, -cos(swing[0]))
    return judge(
        near("bob after 1 s [m]", end.p_WB[0], expected, _HELD, f"3 m/s times dt/2 = 1.5 mm: {_FIRST}"),
        near("angular velocity [rad/s]", end.w_WB[0], (0.0, swing[1], 0.0), 0.02, "right-handed about the axis"),
        near("orientation [rad]", angle_between(end.q_WB[0], axis_angle((0.0, 1.0, 0.0), float(swing[0]))), 0.0, _HELD),
    )


@check("Does a pendulum keep its energy where the scene asks for no damping?", Feature.REVOLUTE)
def joint_damping_is_off(adapter: Adapter, settings: Settings) -> CheckResult:
    run = record(adapter, _pendulum(pi / 2), settings.with_dt(COARSE), 3.0, every=4)
    # The energy of a staggered scheme oscillates by 6e-3 m g l; damping of .04 at the joint takes ten times that.
    energy = run.v_WB[:, 0] ** 2 @ np.ones(3) + 0.1 * (run.w_WB[:, 0] ** 2 @ np.ones(3)) + 2.0 * G * run.p_WB[:, 0, 2]
    return judge(
        near("energy over 3 s / (m g l)", energy[-60:].mean() / (2.0 * G), 0.0, 0.01, "kept; mean over the last second"),
        that(float(np.ptp(run.p_WB[:, 0, 0])) > 1.0, "the pendulum swings"),
    )


@check("Are anchor and axis in W, and the initial velocity kept?", Feature.REVOLUTE, firm=True)
def revolute_turns_about_its_axis(adapter: Adapter, settings: Settings) -> CheckResult:
    """A turned body runs round a slanted axis away from its centre, without gravity: at constant rate."""
    axis, anchor, arm = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.5, -0.3, 0.2]), np.array([0.6, 0.3, -0.6])
    w, t = 2.0, 0.15
    p = anchor + arm
    body = free("body", p=_v(p), q=TURNED, v=_v(np.cross(w * axis, arm)), w=_v(w * axis))
    pin = Revolute(name="pin", parent=WORLD, child="body", anchor_W=_v(anchor), axis_W=_v(axis))
    end = final(adapter, Scene(bodies=(body,), joints=(pin,), gravity=_NOWHERE), settings.with_dt(FINE), t)
    turn = axis_angle(_v(axis), w * t)
    expected = anchor + rotation(turn) @ arm
    because = "5 % of the way, for default damping, judged elsewhere"
    return judge(
        near("place after turning by .3 rad [m]", end.p_WB[0], expected, 0.05 * 0.27, because),
        near("distance from the anchor [m]", np.linalg.norm(end.p_WB[0] - anchor), 0.9, _HELD, "it is held"),
        near("orientation [rad]", angle_between(end.q_WB[0], multiply(turn, TURNED)), 0.0, 0.05 * 0.3, because),
        near("w_WB [rad/s]", end.w_WB[0], w * axis, 0.05 * w, "no moment acts about the axis"),
    )


def _v(a: object) -> Vector3:
    x, y, z = (float(c) for c in np.asarray(a))
    return (x, y, z)


@check("Does a slide move along its axis alone, in W?", Feature.PRISMATIC, firm=True)
def prismatic_slides_along_its_axis(adapter: Adapter, settings: Settings) -> CheckResult:
    axis, t = np.array([2.0, -1.0, 2.0]) / 3, 0.4
    body = free("body", p=(0.3, 0.2, 0.1), q=TURNED)
    slide = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=_NOWHERE, axis_W=_v(axis))
    end = final(adapter, Scene(bodies=(body,), joints=(slide,)), settings.with_dt(FINE), t)
    a = -G * axis[2]
    return judge(
        near(
            "way under gravity [m]",
            end.p_WB[0] - np.array([0.3, 0.2, 0.1]),
            a * t * t / 2 * axis,
            0.05 * -a * t * t / 2,
            "5 % for default damping",
        ),
        near("velocity [m/s]", end.v_WB[0], a * t * axis, 0.05 * -a * t, "gravity along the axis alone; 5 % for damping"),
        near("orientation [rad]", angle_between(end.q_WB[0], TURNED), 0.0, _HELD, "it does not turn"),
    )


@check("Does a fixed joint hold place and orientation, to the world and between bodies?", Feature.FIXED)
def fixed_joint_holds(adapter: Adapter, settings: Settings) -> CheckResult:
    post, arm = free("post", p=(0.0, 0.0, 1.0)), free("arm", p=(0.8, 0.0, 1.2), q=TURNED)
    joints = (Fixed(name="foot", parent=WORLD, child="post"), Fixed(name="weld", parent="post", child="arm"))
    end = final(adapter, Scene(bodies=(post, arm), joints=joints), settings.with_dt(FINE), 0.3)
    return judge(
        near("places of two bodies welded to the world [m]", end.p_WB, [post.p_WB, arm.p_WB], _HELD, "they do not move"),
        near("turn of the outer one [rad]", angle_between(end.q_WB[1], TURNED), 0.0, 2 * _HELD),
    )


@check("Does a ball joint hold its anchor and nothing else?", Feature.BALL)
def ball_joint_holds_its_anchor(adapter: Adapter, settings: Settings) -> CheckResult:
    """Two links on ball joints, thrown sideways: anchors stay together, all rotations go on."""
    upper = free("upper", p=(0.0, 0.0, -0.5), moments=(0.1, 0.2, 0.25), w=(0.0, 0.0, 2.0))
    lower = free("lower", p=(0.5, 0.0, -1.0), q=TURNED, moments=(0.1, 0.2, 0.25))
    joints = (
        Ball(name="top", parent=WORLD, child="upper", anchor_W=_NOWHERE),
        Ball(name="elbow", parent="upper", child="lower", anchor_W=(0.0, 0.0, -1.0)),
    )
    end = final(adapter, Scene(bodies=(upper, lower), joints=joints), settings.with_dt(FINE), 0.5)
    R_upper, R_lower = rotation(end.q_WB[0]), rotation(end.q_WB[1])
    arm = np.array(rotate(_inverse(TURNED), (-0.5, 0.0, 0.0)))
    elbow = end.p_WB[0] + R_upper @ (0.0, 0.0, -0.5)
    return judge(
        near("the upper anchor [m]", end.p_WB[0] + R_upper @ (0.0, 0.0, 0.5), _NOWHERE, _HELD, "it stays in the world"),
        near("the elbow seen from below [m]", end.p_WB[1] + R_lower @ arm, elbow, _HELD, "both links share it"),
        that(
            end.p_WB[1, 0] < 0.4, f"x of the lower link: got {end.p_WB[1, 0]:.4g} m, expected below .4: it swings down from .5"
        ),
        that(abs(end.w_WB[0, 2]) > 0.5, f"spin about z: got {end.w_WB[0, 2]:.4g} rad/s, expected to go on from 2"),
    )


def _inverse(q: Quaternion) -> Quaternion:
    return (q[0], -q[1], -q[2], -q[3])


@check("Does a rod keep its length, in pull and push, without doing work?", Feature.DISTANCE)
def distance_joint_keeps_its_length(adapter: Adapter, settings: Settings) -> CheckResult:
    """A bob on a rod, thrown across: the distance stays, the rod carries push as well as pull."""
    rod = Distance(name="rod", parent=WORLD, child="bob", anchor_W=_NOWHERE, child_anchor_W=(0.0, 0.8, 0.6))
    bob = free("bob", p=(0.0, 0.8, 0.6), v=(1.0, 0.0, 0.0))
    run = record(adapter, Scene(bodies=(bob,), joints=(rod,)), settings.with_dt(FINE), 0.5, every=10)
    length = np.linalg.norm(run.p_WB[:, 0], axis=1)
    # Energy of a point on a sphere: v^2 = v0^2 + 2 g (z0 - z).
    speed = float(np.linalg.norm(run.v_WB[-1, 0]))
    expected = sqrt(1.0 + 2 * G * (0.6 - float(run.p_WB[-1, 0, 2])))
    return judge(
        near("distance over half a second [m]", [length.min(), length.max()], (1.0, 1.0), _HELD, "it is held"),
        near("speed from the height fallen [m/s]", speed, expected, 0.02 * expected, "the rod does no work; 2 %"),
    )


@check("Does a loop of joints stay closed in motion?", Feature.REVOLUTE | Feature.CLOSED_LOOP)
def closed_loop_stays_closed(adapter: Adapter, settings: Settings) -> CheckResult:
    """A parallelogram of three bars falls to one side: its coupler stays level, its four pins together."""
    w = 1.0
    left = free("left", p=(0.0, 0.0, 0.5), v=(0.5 * w, 0.0, 0.0), w=(0.0, w, 0.0), mass=1.0, moments=(0.1, 0.1, 0.1))
    top = free("top", p=(0.5, 0.0, 1.0), v=(w, 0.0, 0.0), mass=1.0, moments=(0.1, 0.1, 0.1))
    right = free("right", p=(1.0, 0.0, 0.5), v=(0.5 * w, 0.0, 0.0), w=(0.0, w, 0.0), mass=1.0, moments=(0.1, 0.1, 0.1))
    y = (0.0, 1.0, 0.0)
    joints = (
        Revolute(name="a", parent=WORLD, child="left", anchor_W=_NOWHERE, axis_W=y),
        Revolute(name="b", parent="left", child="top", anchor_W=(0.0, 0.0, 1.0), axis_W=y),
        Revolute(name="c", parent=WORLD, child="right", anchor_W=(1.0, 0.0, 0.0), axis_W=y),
        Revolute(name="d", parent="top", child="right", anchor_W=(1.0, 0.0, 1.0), axis_W=y),
    )
    end = final(adapter, Scene(bodies=(left, top, right), joints=joints), settings.with_dt(FINE), 0.4)
    tops = [end.p_WB[k] + rotation(end.q_WB[k]) @ (0.0, 0.0, 0.5) for k in (0, 2)]
    return judge(
        near(
            "left end of the coupler against the left crank [m]",
            end.p_WB[1] + rotation(end.q_WB[1]) @ (-0.5, 0, 0),
            tops[0],
            _HELD,
        ),
        near(
            "right end of the coupler against the right crank [m]",
            end.p_WB[1] + rotation(end.q_WB[1]) @ (0.5, 0, 0),
            tops[1],
            _HELD,
        ),
        near("tilt of the coupler [rad]", angle_between(end.q_WB[1], (1, 0, 0, 0)), 0.0, 2 * _HELD, "a parallelogram"),
        that(end.p_WB[1, 2] < 0.95, f"height of the coupler: got {end.p_WB[1, 2]:.4g} m, expected below .95: it falls"),
    )


def _leaves(apart: float, w: float, collide: bool) -> Scene:
    """Two boxes, one `apart` [m] above the other, on a hinge about y beside their common face; w [rad/s] opens it."""
    pin_W = (0.4, 0.0, 0.15)
    below, above = block("below", half=(0.3, 0.1, 0.1), p=_NOWHERE), (0.0, 0.0, 0.2 + apart)
    turning = _v(np.cross((0.0, w, 0.0), np.subtract(above, pin_W)))
    leaf = block("above", half=(0.3, 0.1, 0.1), p=above, v=turning, w=(0.0, w, 0.0))
    pin = Revolute(name="pin", parent="below", child="above", anchor_W=pin_W, axis_W=(0.0, 1.0, 0.0), collide=collide)
    return Scene(bodies=(below, leaf), joints=(pin,), surfaces=(Surface(between=("block", "block")),), gravity=_NOWHERE)


@check("Do bodies that a joint keeps from colliding overlap in peace?", Feature.REVOLUTE | Feature.BOX)
def joined_bodies_do_not_collide(adapter: Adapter, settings: Settings) -> CheckResult:
    end = final(adapter, _leaves(-0.005, 0.0, False), settings.with_dt(FINE), 0.1)
    because = "a joint keeps them from colliding"
    return judge(
        near("velocities of two overlapping boxes on one hinge [m/s]", end.v_WB, np.zeros((2, 3)), 1e-6, because),
        near("their angular velocities [rad/s]", end.w_WB, np.zeros((2, 3)), 1e-6, because),
    )


@check("Do bodies collide whose joint says that they do?", Feature.REVOLUTE | Feature.BOX)
def joined_bodies_collide_when_told(adapter: Adapter, settings: Settings) -> CheckResult:
    """The same hinge, closing at .2 rad/s over a gap of 2 mm: the boxes meet and stop, or the engine refuses such a joint."""
    try:
        end = final(adapter, _leaves(0.002, -0.2, True), settings.with_dt(FINE), 0.15)
    except Unsupported as refusal:
        raise NotApplicable(f"refused: {refusal}") from refusal
    rate = float(end.w_WB[1, 1] - end.w_WB[0, 1])
    return judge(that(rate > -0.05, f"rate of the hinge: got {rate:.4g} rad/s, expected above -.05: the boxes meet and stop"))


@check(
    "Does a loop that is closed between turned bodies rest where it was built?",
    Feature.REVOLUTE | Feature.BALL | Feature.CLOSED_LOOP,
)
def closed_loop_rests_where_it_was_built(adapter: Adapter, settings: Settings) -> CheckResult:
    """Two turned bodies on hinges to the world, a ball between them off both centres, at rest where nothing pulls."""
    left, right = free("left", p=(-0.5, 0.2, 0.0), q=TURNED), free("right", p=(0.5, -0.1, 0.3), q=multiply(TURNED, TURNED))
    joints = (
        Revolute(name="a", parent=WORLD, child="left", anchor_W=(-1.0, 0.0, 0.2), axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="b", parent=WORLD, child="right", anchor_W=(1.0, 0.0, -0.2), axis_W=(0.0, 1.0, 0.0)),
        Ball(name="shut", parent="left", child="right", anchor_W=(0.1, 0.3, 0.2)),
    )
    scene = Scene(bodies=(left, right), joints=joints, gravity=_NOWHERE)
    end = final(adapter, scene, settings.with_dt(FINE), 0.2)
    turns = [angle_between(end.q_WB[k], body.q_WB) for k, body in enumerate(scene.bodies)]
    return judge(
        near("places [m]", end.p_WB, [left.p_WB, right.p_WB], 1e-4, "nothing pulls, nothing moves"),
        near("turns [rad]", turns, (0.0, 0.0), 1e-4),
    )
