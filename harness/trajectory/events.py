"""What happened to each body of a run, read off its poses and contacts: it bounced, tipped, slid, fell through, lies still.

Thresholds are shares of the body's own size, the diameter of a ball about its centre of mass that holds it; docs/method has
them in a table. A machine, whatever joints hold together, is told by its heaviest body, by the joint that swings or turns
farthest and by the stops that joints hit.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.scene import Box, Plane, Prismatic, Revolute, Scene, outer_radius
from plumbline.harness.scene.shape import Capsule, Cylinder, Ellipsoid, Sphere
from plumbline.harness.trajectory.blows import BLOW, LASTS, blows
from plumbline.harness.trajectory.kinematics import angle_between, joint_coordinate, rotate, rotate_back
from plumbline.harness.trajectory.trajectory import Floats, Integers, Trajectory

COUNTS = 0.1
"""Of the whole range: what turns back by less only settles."""


@dataclass(frozen=True, slots=True)
class Swing:
    """Terms: turns: how often it turned round. range: between its ends, in the unit of the coordinate; gone: from its start to
    where it stops, or all of the range where it comes back by more than half of that. begun: the sample by which its range
    was first more than the least that counts."""

    turns: int
    range: float
    gone: float
    begun: int


def swing(x: Floats, least: float) -> Swing | None:
    """Of a coordinate (t,); None where it goes no further than `least`."""
    span = float(np.ptp(x))
    if not span > least:
        return None
    back = max(least, COUNTS * span)
    turns, low, high, rising = 0, x[0], x[0], None
    for value in x:
        low, high = min(low, value), max(high, value)
        if rising is not False and high - value > back:
            turns, rising, low = turns + (rising is True), False, value
        elif rising is not True and value - low > back:
            turns, rising, high = turns + (rising is False), True, value
    net = float(abs(x[-1] - x[0]))
    so_far = np.maximum.accumulate(x) - np.minimum.accumulate(x)
    return Swing(turns, span, net if net > span / 2 else span, int(np.argmax(so_far > least)))


Booleans: TypeAlias = NDArray[np.bool_]

Kind: TypeAlias = Literal[
    "passed through", "bounced", "collided", "left the ground", "fell off", "tipped", "rolled", "slid", "moved", "sank",
    "rocked", "swung", "shuttled", "turned", "shifted", "hit the stop", "at rest",
]  # fmt: skip
MOVED = 0.01
"""Of the size: less is no motion that an eye sees, as everywhere where engines are compared."""
TURNED = 0.01
"""Radians: the same of an angle."""
TIPPED = np.pi / 4
"""How far what pointed up leans: beyond it no box stands."""
AT_END = 0.1
"""Of the run that a body lies still at its end at least, to be at rest."""
AT_START = 0.05
"""Seconds within which what touches stood there: what is put down needs a sample or two to press."""
AS_FAR = 0.9
"""Of the motion of the joint that goes farthest: the first that goes so far is told, so that legs that are alike are."""
STOP = 0.01
"""Of the range of a joint: so near its end it has hit the stop; of a radian or a metre where one end is open."""


ANGLES: frozenset[Kind] = frozenset(("tipped", "rocked", "swung", "turned"))
"""What has an angle for its value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """One thing that happened.

    Terms: body: its name. time [s]: when, or since when. value: how far [m], or how high; the angle [rad] of `ANGLES`; None
    where there is none. count: how often. other: the body or joint that it happened with, '' for none.
    """

    body: str
    kind: Kind
    time: float
    value: float | None = None
    count: int = 1
    other: str = ""


@dataclass(frozen=True, slots=True)
class Touched:
    """Contacts that press, of all samples: sample (k,), the places of both bodies first, second (k,)."""

    sample: Integers
    first: Integers
    second: Integers

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[np.float64]]) -> "Touched | None":
        """Of the arrays of a stored run; None where contacts were not recorded."""
        if "contacts_count" not in arrays:
            return None
        counts = np.asarray(arrays["contacts_count"], np.int64)
        press = (arrays["contacts_gap"] <= 0) | (np.linalg.norm(arrays["contacts_force_W"], axis=1) > 0)
        first, second = (np.asarray(arrays[f"contacts_body_{side}"], np.int64)[press] for side in "AB")
        return cls(np.repeat(np.arange(len(counts)), counts)[press], first, second)

    def partners(self, members: Sequence[int]) -> tuple[Integers, Integers]:
        """The samples at which bodies touch others than each other, and the places of those."""
        mine = [np.isin(side, members) for side in (self.first, self.second)]
        alone = mine[0] ^ mine[1]
        return self.sample[alone], np.where(mine[0], self.second, self.first)[alone]


def size_of(scene: Scene, index: int) -> float:
    """The diameter [m] of a ball about a body's centre that holds its shapes; twice its radius of gyration without any.

    Of one without mass that of the body behind it.
    """
    body = scene.bodies[index]
    if body.massless:
        return size_of(scene, scene.index(next(joint.child for joint in scene.joints if joint.parent == body.name)))
    placed = [each for each in (*body.collision, *(body.visual or ())) if each.shape.type != "plane"]
    if placed:
        return 2 * max(float(np.linalg.norm(each.p_BS)) + outer_radius(each.shape) for each in placed)
    return 2 * float(np.sqrt(np.linalg.eigvalsh(np.array(body.inertia))[-1] / body.mass))


def happened(scene: Scene, run: Trajectory, touched: Touched | None) -> tuple[Event, ...]:
    """All that happened, body by body. Args: touched: None where contacts were not recorded."""
    events: list[Event] = []
    loose: list[int] = []
    for members, held in _wholes(scene):
        events += _of_whole(scene, run, touched, members, held)
        loose += members if len(members) == 1 and not held else []
    events += _collisions(scene, run, touched, loose)
    for joint in scene.joints:
        if isinstance(joint, Revolute | Prismatic) and joint.limits is not None:
            events += _stops(scene, run, joint)
    places = {body.name: index for index, body in enumerate(scene.bodies)}
    return tuple(sorted(events, key=lambda event: (places[event.body], event.kind == "at rest", event.time)))


def _wholes(scene: Scene) -> Iterator[tuple[list[int], bool]]:
    """The places of the bodies that joints hold together, the heaviest first, and whether something fixed holds them."""
    left = {index for index, body in enumerate(scene.bodies) if body.movable}
    names = {body.name: index for index, body in enumerate(scene.bodies)}
    ends = [(names.get(joint.parent, -1), names[joint.child]) for joint in scene.joints]
    while left:
        members, grown = {min(left)}, True
        while grown:
            more = {b for a, b in ends if a in members} | {a for a, b in ends if b in members}
            grown = bool((more & left) - members)
            members |= more & left
        left -= members
        held = any((a in members) != (b in members) and not {a, b} <= members for a, b in ends if {a, b} & members)
        yield sorted(members, key=lambda index: (-scene.bodies[index].mass, index)), held


def _of_whole(scene: Scene, run: Trajectory, touched: Touched | None, members: Sequence[int], held: bool) -> Iterator[Event]:
    base = members[0]
    name, size, time = scene.bodies[base].name, size_of(scene, base), run.time
    gravity = float(np.linalg.norm(scene.gravity))
    if not held and gravity > 0:
        up = -np.array(scene.gravity) / gravity
        height = (run.p_WB[:, base] - run.p_WB[0, base]) @ up
        samples, others = (None, None) if touched is None else touched.partners(members)
        touching = None if samples is None else np.isin(np.arange(len(time)), samples)
        yield from _through(scene, run, base)
        bounces = _bounces(time, run.v_WB[:, base] @ up, gravity, height, size)
        if len(members) == 1 and bounces:
            first = bounces[0]
            top = float(height[first : bounces[1] if len(bounces) > 1 else None].max() - height[first - 1 : first + 1].min())
            yield Event(body=name, kind="bounced", time=float(time[first]), value=top, count=len(bounces))
        if touching is not None and touching[time <= AT_START].any() and samples is not None and others is not None:
            leaving = _leaves(scene, name, size, time, height, samples, others)
            yield from (event for event in leaving if not (bounces and event.kind == "left the ground"))
        yield from _lies_otherwise(scene, run, base, up, size, len(members) == 1, touching)
    yield from _of_joints(scene, run, members, held)
    far = np.zeros(len(time))
    for index in members:
        moved = np.linalg.norm(run.p_WB[:, index] - run.p_WB[-1, index], axis=1) / (MOVED * size_of(scene, index))
        turned = angle_between(run.q_WB[:, index], np.broadcast_to(run.q_WB[-1, index], run.q_WB[:, index].shape)) / TURNED
        far = np.maximum(far, np.maximum(moved, turned))
    beyond = np.flatnonzero(far > 1)
    since = float(time[beyond[-1] + 1]) if len(beyond) else 0.0
    if since <= (1 - AT_END) * time[-1]:
        yield Event(body=name, kind="at rest", time=since)


def _through(scene: Scene, run: Trajectory, base: int) -> Iterator[Event]:
    """Fixed planes and boxes that the centre of a body has gone through: it lies a radius behind, or on the other side."""
    body = scene.bodies[base]
    for index, fixed in enumerate(scene.bodies):
        if fixed.movable or not scene.collides(body, fixed):
            continue
        for placed in fixed.collision:
            if not isinstance(placed.shape, Plane | Box):
                continue
            at = rotate(run.q_WB[:, index], np.array(placed.p_BS)) + run.p_WB[:, index]
            local = rotate_back(np.array(placed.q_BS), rotate_back(run.q_WB[:, index], run.p_WB[:, base] - at))
            if isinstance(placed.shape, Plane):
                behind = np.flatnonzero(local @ np.array(placed.shape.normal) < -size_of(scene, base) / 2)
            else:
                behind = _crossed(local, np.array(placed.shape.half_extents))
            if len(behind):
                yield Event(body=body.name, kind="passed through", time=float(run.time[behind[0]]), other=fixed.name)
                break


def _crossed(local: Floats, half: Floats) -> Integers:
    """The samples at which a centre (t, 3), in a box's frame, first is on the other side of its thinnest extent."""
    thin = int(np.argmin(half))
    outside = np.flatnonzero(np.abs(local[:, thin]) > half[thin])
    for before, after in pairwise(outside):
        a, b = local[before], local[after]
        if a[thin] * b[thin] < 0:
            met = a + (b - a) * (a[thin] / (a[thin] - b[thin]))
            if (np.abs(np.delete(met, thin)) <= np.delete(half, thin)).all():
                return np.array([after])
    return np.zeros(0, np.int64)


def _bounces(time: Floats, rise: Floats, gravity: float, height: Floats, size: float) -> list[int]:
    """The samples after a blow from below that throws a body up visibly. Args: rise (t,) m/s, height (t,) m."""
    kicked = np.flatnonzero((rise[1:] > 0) & (rise[:-1] <= 0) & (np.diff(rise) > BLOW * gravity * np.diff(time))) + 1
    low = np.minimum(height[kicked - 1], height[kicked])
    tops = np.array([height[a:b].max() for a, b in pairwise([*kicked.tolist(), len(time)])])
    return kicked[tops - low > MOVED * size].tolist() if len(kicked) else []


def _leaves(
    scene: Scene, name: str, size: float, time: Floats, height: Floats, samples: Integers, others: Integers
) -> Iterator[Event]:
    """It was on something at first: it rises from it, or it ends below where it last touched it."""
    under = others[time[samples] <= AT_START]
    ground = [index for index in np.unique(under).tolist() if not scene.bodies[index].movable]
    if ground:
        last = samples[np.isin(others, ground)]
        gone = np.flatnonzero(~np.isin(np.arange(len(time)), last) & (height > MOVED * size))
        if len(gone):
            yield Event(body=name, kind="left the ground", time=float(time[gone[0]]), value=float(height.max()))
    planes = {index for index, body in enumerate(scene.bodies) for each in body.collision if each.shape.type == "plane"}
    below = [index for index in np.unique(under).tolist() if index not in planes]
    if below:
        parted = int(samples[np.isin(others, below)].max())
        fallen = float(height[parted] - height[-1])
        if fallen > size / 2:
            yield Event(body=name, kind="fell off", time=float(time[parted]), value=fallen, other=scene.bodies[below[0]].name)


def _lies_otherwise(
    scene: Scene, run: Trajectory, base: int, up: Floats, size: float, alone: bool, touching: Booleans | None
) -> Iterator[Event]:
    """It tipped, rolled, slid away or sank into what it lies on; a machine moved away."""
    name, time = scene.bodies[base].name, run.time
    shapes = [placed.shape for placed in scene.bodies[base].collision]
    round_ = bool(shapes) and all(isinstance(shape, Sphere | Capsule | Cylinder | Ellipsoid) for shape in shapes)
    was_up = rotate(run.q_WB[:, base], rotate_back(run.q_WB[0, base], up))
    lean = np.arccos(np.clip(was_up @ up, -1.0, 1.0))
    path = run.p_WB[:, base] - run.p_WB[0, base]
    away = float(np.linalg.norm(path[-1] - (path[-1] @ up) * up))
    on = np.zeros(len(time), bool) if touching is None else _about(touching)
    w_across = run.w_WB[:, base] - (run.w_WB[:, base] @ up)[:, None] * up
    dt = np.diff(time, prepend=time[:1])
    angle = float(np.sum(np.linalg.norm(w_across, axis=1) * dt * on))
    rolled = round_ and alone and angle * size / 2 > away / 2 and angle > TURNED
    turns_over = not rolled and not all(isinstance(shape, Sphere) for shape in shapes)
    if turns_over and lean[-1] > TIPPED and (touching is None or touching.any()):
        yield Event(body=name, kind="tipped", time=float(time[np.flatnonzero(lean <= TIPPED)[-1]]), value=float(lean[-1]))
    elif turns_over and alone and lean[-1] > TURNED and MOVED * size < away <= lean[-1] * size / 2:
        first = int(np.flatnonzero(lean > TURNED)[0])
        yield Event(body=name, kind="rocked", time=float(time[first]), value=float(lean[-1]))
    elif away > MOVED * size and on.mean() > AT_END:
        begun = np.flatnonzero(np.linalg.norm(path - (path @ up)[:, None] * up, axis=1) > MOVED * size)
        kind: Kind = "rolled" if rolled else "slid" if alone else "moved"
        yield Event(body=name, kind=kind, time=float(time[begun[0]]), value=away)
    elif alone and on[0] and on[-1] and (sunk := -float(path[-1] @ up)) > MOVED * size:
        yield Event(body=name, kind="sank", time=float(time[np.flatnonzero(path @ up < -MOVED * size)[0]]), value=sunk)


def _collisions(scene: Scene, run: Trajectory, touched: Touched | None, loose: Sequence[int]) -> Iterator[Event]:
    """Blows from the side or from above, body by body."""
    partners = {} if touched is None else {index: touched.partners([index]) for index in loose}
    mine: dict[int, list[tuple[int, int | None]]] = {}
    for blow in blows(scene, run, {index: size_of(scene, index) for index in loose}, partners):
        mine.setdefault(blow.body, []).append((blow.sample, blow.other))
    for index, hits in mine.items():
        sample, other = hits[0]
        name = "" if other is None else scene.bodies[other].name
        yield Event(body=scene.bodies[index].name, kind="collided", time=float(run.time[sample]), count=len(hits), other=name)


def _about(touching: Booleans) -> Booleans:
    """What touches now and again rests or rolls all the while: contact within LASTS samples counts."""
    return np.convolve(touching, np.ones(2 * LASTS + 1), "same") > 0


def _of_joints(scene: Scene, run: Trajectory, members: Sequence[int], held: bool) -> Iterator[Event]:
    """The joint of a machine that swings farthest; where none does and the machine is held, the one that turns farthest."""
    names = {scene.bodies[index].name for index in members}
    moves: list[tuple[Revolute | Prismatic, Swing, float]] = []
    for joint in scene.joints:
        if isinstance(joint, Revolute | Prismatic) and joint.child in names:
            least = TURNED if isinstance(joint, Revolute) else MOVED * size_of(scene, scene.index(joint.child))
            if (motion := swing(joint_coordinate(scene, joint, run), least)) is not None:
                moves.append((joint, motion, motion.range / least))
    swinging = [each for each in moves if each[1].turns >= 2]
    chosen = swinging or (moves if held else [])
    if chosen:
        most = AS_FAR * max(far for *_, far in chosen)
        joint, motion, _ = next(each for each in chosen if each[2] >= most)
        revolute = isinstance(joint, Revolute)
        kind: Kind = ("swung" if revolute else "shuttled") if swinging else "turned" if revolute else "shifted"
        yield Event(
            body=joint.child, kind=kind, time=float(run.time[motion.begun]), value=motion.range if swinging else motion.gone,
            count=motion.turns if swinging else 1, other=joint.name,
        )  # fmt: skip


def _stops(scene: Scene, run: Trajectory, joint: Revolute | Prismatic) -> Iterator[Event]:
    """The ends of its range that a joint comes to, having been away from them."""
    assert joint.limits is not None
    x = joint_coordinate(scene, joint, run)
    lower, upper = joint.limits.lower, joint.limits.upper
    near = STOP * (upper - lower if lower is not None and upper is not None and upper > lower else 1.0)
    gaps = [] if lower is None else [x - lower]
    gaps += [] if upper is None else [upper - x]
    hits = [int(np.flatnonzero(gap <= near)[0]) for gap in gaps if gap[0] > near and (gap <= near).any()]
    if hits:
        yield Event(body=joint.child, kind="hit the stop", time=float(run.time[min(hits)]), other=joint.name)
