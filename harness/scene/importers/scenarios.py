"""Scenarios for any robot: what happens to it where nothing but its file is given."""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Scenario, Wishes
from plumbline.harness.scene import Body, Distance, Fixed, PlacedShape, Plane, Scene, Vector3
from plumbline.harness.scene.importers.companion import Companion, Ground
from plumbline.harness.scene.importers.consequences import Massive, inertias
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Coordinate, Robot, Servo
from plumbline.harness.scene.motion import Sinusoid, multiply, rotate, rotation_matrix
from plumbline.harness.scene.shape import support

CLEARANCE = 0.1
"""How high above the ground the lowest point of what is dropped starts [m]."""
SWING = 0.3
"""How far a joint starts from its place [rad or m], where its range allows it; a slide by a tenth of that."""
HOLD_RATE = 2 * math.pi * 5
"""Natural frequency of a drive that holds a joint [rad/s], of its own inertia with the others held; critically damped."""

_ROOTS = {"drop": "floating", "swing": "fixed", "hold": "fixed", "sweep": "fixed"}


def rooted_for(scenario: Scenario | None, robot: Robot, companion: Companion, wishes: Wishes) -> tuple[Companion, Wishes]:
    """The wishes with the root as the scenario needs it, where nobody says otherwise. Raises: RobotError."""
    if scenario is None:
        return companion, wishes
    wanted, root = _ROOTS[scenario], wishes.root or companion.root or robot.root
    if root is None:
        return replace(companion, root=wanted), wishes  # type: ignore[arg-type]
    if root != wanted and scenario not in ("hold", "sweep"):
        raise RobotError(
            f"{robot.source}: scenario {scenario} needs a {wanted} root, and it is {root}; expected another scenario"
        )
    return companion, wishes


def unpowered(robot: Robot) -> Robot:
    """Without drives."""
    slack = tuple(replace(cord, servo=None) for cord in robot.tendons)
    return replace(robot.each(lambda c: replace(c, servo=None)), tendons=slack)


def swung(robot: Robot) -> Robot:
    """Without drives, each joint off its place by SWING towards the far end of its range, within it."""

    def off(c: Coordinate) -> Coordinate:
        if c.kind not in ("revolute", "prismatic"):
            return c
        here = c.reference if c.position is None else c.position
        way = SWING if c.kind == "revolute" else SWING / 10
        up = math.inf if c.upper is None else c.upper - here
        down = math.inf if c.lower is None else here - c.lower
        moved = here + min(way, 0.5 * up) if up >= down else here - min(way, 0.5 * down)
        return replace(c, position=moved, servo=None)

    return robot.each(off)


def held_by_drives(robot: Robot, poses: Sequence[Sequence[Massive]], names: Collection[str] | None = None) -> Robot:
    """Each joint without a drive gets one that holds it where it starts.

    Args: poses: that it is strong enough for. names: of these joints alone; of all if None.
    """
    own: dict[str, float] = {}
    for bodies in poses:
        scalars, M, places = inertias(bodies)
        for c, k in zip(scalars, places, strict=True):
            rotor = 0.0 if robot.dropped.takes("armature", c.name) else c.armature
            own[c.name] = max(own.get(c.name, 0.0), float(M[k, k]) + rotor)
    given = []

    def hold(c: Coordinate) -> Coordinate:
        stated = c.servo or Servo(target=c.reference if c.position is None else c.position, limit=c.effort)
        if (
            stated.stiffness > 0
            or (stated.damping > 0 and stated.motion is None)
            or c.tie is not None
            or c.name not in own
            or (names is not None and c.name not in names)
        ):
            return c
        given.append(c.name)
        gain, damping = own[c.name] * HOLD_RATE**2, 2 * own[c.name] * HOLD_RATE
        return replace(c, servo=replace(stated, stiffness=gain, damping=damping))

    made, becomes = robot.each(hold), "a critically damped drive that holds the start"
    words = "the file gives no gains; natural frequency of each with the other joints held"
    words += ", where its inertia is greatest" if len(poses) > 1 else ""
    rate = HOLD_RATE / (2 * math.pi)
    return made.told(Fidelity.approximated("drive", "", becomes, consequence=words, value=rate, unit="Hz", count=len(given)))


def grounded(companion: Companion) -> Companion:
    """With a ground where there is none."""
    return companion if companion.ground is not None else replace(companion, ground=Ground())


def lifted(scene: Scene, ground: str, source: str) -> Scene:
    """The scene with all that can move raised or lowered until its lowest point is CLEARANCE above the ground of that name."""
    height = scene.body(ground).p_WB[2]
    low = min((_lowest(body, placed) for body in scene.bodies if body.movable for placed in body.collision), default=math.inf)
    if not math.isfinite(low):
        raise RobotError(f"{source}: scenario drop: no shape of the robot touches anything; expected a collision shape")
    rise = height + CLEARANCE - low

    def up(p: Vector3) -> Vector3:
        return (p[0], p[1], p[2] + rise)

    bodies = tuple(replace(body, p_WB=up(body.p_WB)) if body.movable else body for body in scene.bodies)
    joints = tuple(
        joint if isinstance(joint, Fixed | Distance) else replace(joint, anchor_W=up(joint.anchor_W)) for joint in scene.joints
    )
    return replace(scene, bodies=bodies, joints=joints)


def _lowest(body: Body, placed: PlacedShape) -> float:
    """The least z of a placed shape in W [m]; infinite of a plane."""
    if isinstance(placed.shape, Plane):
        return math.inf
    q = multiply(body.q_WB, placed.q_BS)
    z = body.p_WB[2] + rotate(body.q_WB, placed.p_BS)[2]
    return float(z - support(placed.shape, -np.array(rotation_matrix(q))[2]))


FREQUENCY = 0.5
"""Of the sinusoid [Hz]: through the range and back in two seconds, where that is not too fast."""
FASTEST = 2.0
"""Greatest speed of a target [rad/s], a slide's a tenth of that [m/s]: what arms do whose makers say so."""
INSTANTS = 4
"""Poses on the way for which drives are made strong enough, beside the start."""
SHARE = 0.8
"""Of half the range: the stops are not what is asked about, and a drive overshoots."""
OPEN = 1.0
"""Half the range of a joint that has no end on a side [rad]; a slide's is a tenth of that [m]."""


def poses_of(robot: Robot) -> list[Robot]:
    """The robot at the start and at instants of its sweep; at the start alone where loops are closed."""
    made = [robot]
    for k in range(0 if robot.closures else INSTANTS):
        share = math.sin(math.pi * (k + 0.5) / INSTANTS) * (-1.0) ** k

        def there(c: Coordinate, share: float = share) -> Coordinate:
            middle, reach = _reach(c)
            return replace(c, position=middle + share * reach) if c.kind in ("revolute", "prismatic") else c

        made.append(robot.each(there))
    return made


def swept(robot: Robot, poses: Sequence[Sequence[Massive]]) -> Robot:
    """The robot with a drive on each joint, whose target goes through the range, and what is to be said of that.

    Where the companion moves a target that motion stays. In a machine with closed loops joints do not move freely of each
    other: there those with a drive of their own are swept or, where none has one, the first.
    """
    moving = [c for c in robot.coordinates() if c.kind in ("revolute", "prismatic")]
    if robot.closures:
        moving = [c for c in moving if c.servo is not None] or moving[:1]
    names = {c.name for c in moving}
    driven = held_by_drives(robot, poses, names if robot.closures else None)
    frequencies = {c.name: _frequency(c, _reach(c)[1]) for c in moving}
    slow = Fidelity.told(
        "slower sweep",
        [name for name, frequency in frequencies.items() if frequency < FREQUENCY],
        min(frequencies.values(), default=FREQUENCY),
        fastest=FASTEST,
        slide=FASTEST / 10,
    )
    return driven.each(lambda c: _swept(c) if c.name in names else c).told(slow)


def _swept(c: Coordinate) -> Coordinate:
    if c.servo is None or c.servo.motion is not None:
        return c
    middle, reach = _reach(c)
    here = c.reference if c.position is None else c.position
    phase = math.asin(min(max((here - middle) / reach, -1.0), 1.0)) if reach > 0 else 0.0
    motion = Sinusoid(amplitude=reach, frequency=_frequency(c, reach), phase=phase)
    return replace(c, servo=replace(c.servo, target=middle, motion=motion))


def _reach(c: Coordinate) -> tuple[float, float]:
    """The middle of the way that a joint is driven, and how far to each side [rad or m]."""
    here = c.reference if c.position is None else c.position
    wide = OPEN if c.kind == "revolute" else OPEN / 10
    lower = here - wide if c.lower is None else c.lower
    upper = here + wide if c.upper is None else c.upper
    return (lower + upper) / 2, max(SHARE * (upper - lower) / 2, 0.0)


def _frequency(c: Coordinate, reach: float) -> float:
    """Such that the target is never faster than the joint may be, nor than arms are."""
    if reach <= 0:
        return FREQUENCY
    fastest = FASTEST if c.kind == "revolute" else FASTEST / 10
    return min(FREQUENCY, min(fastest, c.speed or math.inf) / (2 * math.pi * reach))
