"""Two robots, quantity by quantity: rows for what differs beyond a tolerance, with what each is worth.

Masses are compared relative to A's of the same link, lengths to the robot's extent, inertias to A's largest moment or that
of the link's mass at a hundredth of the extent, angles as they are [rad], dampers and the like relative to the larger one.
Gravity torques are relative to the largest of A or a thousandth of the weight at the extent, the mass matrix to the geometric
mean of the two diagonal entries.
Accelerations are judged by the torque that would make up for their difference, relative to the largest force of A's motion: an
ill-conditioned tree amplifies the last digits of its file in its accelerations, and not in the torques.

A with B's value in the one place is another robot: its residual torques are those that have to be exerted on A's motion. So the
differences of a pair are told apart, and each is worth the torque that makes up for it.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.scene import EARTH_GRAVITY
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Coordinate, Link, Servo, Solid
from plumbline.harness.scene.parity.bonds import bond_rows, shape_rows, touch_rows
from plumbline.harness.scene.parity.canonical import SCALAR, Canonical, aligned, turned_alike, with_free_root
from plumbline.harness.scene.parity.difference import Difference, Yardstick, six
from plumbline.harness.scene.parity.motion import Configuration, drawn, dynamics, first_rates, passive

TOLERANCE = 1e-5
"""Relative. Files hold decimals of five or six digits: a right angle written as 1.5708 is off by 3.7e-6 rad. Ten times
less than this would find the digits of a file; a hundred times more is what a scale or a drawing of a robot leaves open."""
SWEEP = 2 * np.pi
"""Angular frequency [rad/s] of the motion that excites what has to do with accelerations."""
_SMALLEST = 1e-300
_UNITS = {"revolute": "N m", "prismatic": "N", "ball": "N m", "free": "N m or N"}

Rows = list[tuple[Difference, Link | None]]
"""Each with A's link as it is with B's value, where that is worked out."""


def compare(a: Canonical, b: Canonical, tolerance: float = TOLERANCE, seed: int = 0) -> list[Difference]:
    """What differs, the causes before what follows from them."""
    b = turned_alike(a, with_free_root(a, b))
    gravity = np.array(a.gravity or b.gravity or EARTH_GRAVITY)
    by, wordless = Yardstick(tolerance, _extent(a)), a.wordless | b.wordless
    own, other = ({link.name: link for link in robot.moving} for robot in (a, b))
    rows: Rows = [(row, None) for name in own if name not in other for row in by.rows("joint", name, "present", "absent")]
    rows += [(row, None) for name in other if name not in own for row in by.rows("joint", name, "absent", "present")]
    common = [(link, other[name]) for name, link in own.items() if name in other]
    for mine, theirs in common:
        rows += _joint(mine, theirs, wordless, by)
    for mine, theirs in common:
        rows += _mass(mine, theirs, by)
    beside = bond_rows(a, b, by)
    beside += [] if "shape" in wordless else shape_rows(a, b, by)
    beside += [] if "touch" in wordless else touch_rows(a, b, by)
    if a.gravity is not None and b.gravity is not None:
        size, scale = float(np.linalg.norm(np.subtract(a.gravity, b.gravity))), float(np.linalg.norm(a.gravity))
        words = "everything falls otherwise"
        beside += by.rows("gravity", "", a.gravity, b.gravity, unit="m/s2", size=size, scale=scale, words=words)
    rows += [(row, None) for row in beside]
    partner = aligned(a, b)
    if partner is None:
        why = "the trees differ, so that no motion of both can be compared"
        return [replace(row, words=row.words or why) for row, _ in rows]
    if not own:
        return [row for row, _ in rows]
    states = drawn(a, partner, seed)
    if "drive" not in wordless:
        for k, (joint, rate) in enumerate(zip(a.joints, first_rates(a), strict=False)):
            if joint.kind in SCALAR:
                rows += [(row, None) for row in _drive(joint, partner.joints[k], k, rate, states, by)]
    return [*_with_worth(a, gravity, states, rows), *_derived(a, partner, gravity, states, by)]


_COMPARED = (
    ("joints, axes and anchors", ()),
    ("limits", ("lower", "upper")),
    ("dampers, springs and dry friction", ("damping", "stiffness", "friction_loss")),
    ("armature", ("armature",)),
    ("efforts and speeds", ("effort", "speed")),
    ("masses and inertias", ()),
    ("mimics, loops and tendons", ()),
    ("drives and their gains", ("drive",)),
    ("shapes", ("shape",)),
    ("pairs that touch and their friction", ("touch",)),
)
"""What is compared, and the words that both descriptions need for it."""
NEVER = ("sensors", "looks", "how soft contacts are", "where it starts")


def compared(a: Canonical, b: Canonical) -> tuple[list[str], list[str]]:
    """What `compare` looks at, and what it does not, each with who has no word for it."""
    looked_at, passed_over = [], []
    for subject, words in _COMPARED:
        lacking = {side: [word for word in words if word in robot.wordless] for side, robot in (("A", a), ("B", b))}
        silent = [side for side, missing in lacking.items() if missing]
        if len({word for missing in lacking.values() for word in missing}) < max(1, len(words)):
            looked_at.append(subject)
        if silent:
            missing = sorted({word for side in silent for word in lacking[side]})
            named = subject if len(missing) == len(words) else " and ".join(missing).replace("_", " ")
            passed_over.append(f"{named} ({' and '.join(silent)} {'has' if len(silent) == 1 else 'have'} no word for it)")
    if a.gravity is not None and b.gravity is not None:
        looked_at.append("gravity")
    return looked_at, [*passed_over, *NEVER]


def _extent(robot: Canonical) -> float:
    points = [joint.anchor for joint in robot.joints]
    points += [link.solid.centre for link in robot.moving if link.solid is not None and link.solid.mass > 0]
    size = float(np.linalg.norm(np.ptp(np.array(points), axis=0))) if points else 0.0
    return size if size > 0 else 1.0


@dataclass(frozen=True, slots=True)
class Amount:
    """A number of a coordinate.

    Terms: name: its field. units: of hinges and of slides. own: is it a force itself? changed: does A with B's value say what
    it is worth? position: is it a value of the coordinate? words: the consequence.
    """

    name: str
    units: tuple[str, str]
    own: bool = False
    changed: bool = False
    position: bool = False
    words: str = ""


QUANTITIES = (
    Amount("damping", ("N m s/rad", "N s/m"), changed=True),
    Amount("stiffness", ("N m/rad", "N/m"), changed=True),
    Amount("armature", ("kg m2", "kg"), changed=True),
    Amount("friction_loss", ("N m", "N"), own=True, words="dry friction holds or brakes the joint by as much more or less"),
    Amount("effort", ("N m", "N"), own=True, words="the motor of the joint may exert as much more or less"),
    Amount("speed", ("rad/s", "m/s"), words="at its bound the joint is elsewhere after a second by as many rad or m"),
    Amount("rest", ("rad", "m"), changed=True, position=True),
    Amount("lower", ("rad", "m"), position=True),
    Amount("upper", ("rad", "m"), position=True),
)


def _joint(a: Link, b: Link, wordless: frozenset[str], by: Yardstick) -> Rows:
    mine, other = a.coordinate, b.coordinate
    if mine.kind != other.kind:
        return [(row, None) for row in by.rows("type", a.name, mine.kind, other.kind)]
    if a.parent != b.parent:
        return [(row, None) for row in by.rows("parent", a.name, a.parent, b.parent)]
    rows: Rows = []
    scalar, slides = mine.kind in SCALAR, mine.kind == "prismatic"

    def with_B(field: str) -> Link:
        return replace(a, coordinates=(replace(mine, **{field: getattr(other, field)}),))

    if scalar:
        apart = float(np.linalg.norm(mine.axis - other.axis))  # the angle, where it is small and both are unit vectors
        differing = by.rows("axis", a.name, _numbers(mine.axis), _numbers(other.axis), size=apart)
        rows += [(row, with_B("axis")) for row in differing]
    if not slides and mine.kind != "free":
        gap = other.anchor - mine.anchor
        away = float(np.linalg.norm(gap - (gap @ mine.axis) * mine.axis if scalar else gap))
        points = _numbers(mine.anchor), _numbers(other.anchor)
        differing = by.rows("anchor", a.name, *points, unit="m", size=away, scale=by.extent)
        rows += [(row, with_B("anchor")) for row in differing]
    for quantity in QUANTITIES:
        x, y, unit = getattr(mine, quantity.name), getattr(other, quantity.name), quantity.units[slides]
        if quantity.name in wordless or x == y:
            continue
        size = None if x is None or y is None else abs(x - y)
        scale = by.lengths(unit) if quantity.position else max(abs(x or 0.0), abs(y or 0.0))
        words = _limit_words(x, y, unit) if quantity.name in ("lower", "upper") else quantity.words
        torque, torque_unit = (size, unit) if quantity.own and size is not None else (None, "")
        differing = by.rows(
            quantity.name, a.name, x, y, unit=unit, size=size, scale=scale, torque=torque, torque_unit=torque_unit, words=words
        )
        rows += [(row, with_B(quantity.name) if quantity.changed and size is not None else None) for row in differing]
    return rows


def _limit_words(x: float | None, y: float | None, unit: str) -> str:
    if x is None or y is None:
        return f"{'A' if x is None else 'B'} is not stopped there"
    return f"one is stopped {abs(x - y):.4g} {unit} before the other"


def _numbers(v: Array) -> tuple[float, ...]:
    return tuple(float(x) for x in v)


def _drive(
    a: Coordinate, b: Coordinate, index: int, rate: int, states: Sequence[Configuration], by: Yardstick
) -> list[Difference]:
    """Rows of one joint's drives, with the force that each is worth at the states. Args: index, rate: of the joint in them."""
    mine, other = a.servo or Servo(), b.servo or Servo()
    own, force = ("m", "N") if a.kind == "prismatic" else ("rad", "N m")
    held = max(abs(mine.target - state.q[index]) for state in states)
    swift = max(abs(mine.target_velocity - state.rates[rate]) for state in states)
    rows = []
    # Each number with what a change of it is times, to be a force on the joint.
    for quantity, field, unit, times in (
        ("drive stiffness", "stiffness", f"{force}/{own}", held),
        ("drive damping", "damping", f"{force} s/{own}", swift),
        ("drive target", "target", own, max(mine.stiffness, other.stiffness)),
        ("drive rate", "target_velocity", f"{own}/s", max(mine.damping, other.damping)),
        ("drive force", "feedforward", force, 1.0),
        ("drive push", "push", force, 1.0),
        ("drive limit", "limit", force, 1.0),
    ):
        x, y = getattr(mine, field), getattr(other, field)
        if x == y or (field in ("target", "target_velocity") and times == 0):
            continue
        more: dict[str, Any] = {"unit": unit, "words": "one is bounded, the other is not"}
        if x is not None and y is not None:
            size, torque = abs(x - y), float(abs(x - y) * times)
            more |= {"size": size, "scale": by.lengths(own) if field == "target" else max(abs(x), abs(y)), "torque": torque}
            more |= {"torque_unit": force, "words": f"worth up to {torque:.3g} {force} at the states drawn"}
        rows += by.rows(quantity, a.name, x, y, **more)
    return rows


_NOTHING = Solid(0.0, np.zeros(3), np.zeros((3, 3)))


def _mass(a: Link, b: Link, by: Yardstick) -> Rows:
    mine, other, rows = a.solid or _NOTHING, b.solid or _NOTHING, Rows()
    assert mine.inertia is not None
    assert other.inertia is not None
    element = f"what '{a.name}' moves: {a.where or b.where}"

    def add(quantity: str, x: "float | tuple[float, ...]", y: "float | tuple[float, ...]", unit: str, size: float,
            scale: float) -> None:  # fmt: skip
        changed = replace(a, solid=replace(mine, **{quantity: getattr(other, quantity)}))
        rows.extend((row, changed) for row in by.rows(quantity, element, x, y, unit=unit, size=size, scale=scale))

    add("mass", mine.mass, other.mass, "kg", abs(mine.mass - other.mass), mine.mass or other.mass)
    if mine.mass > 0 and other.mass > 0:
        away = float(np.linalg.norm(mine.centre - other.centre))
        add("centre", _numbers(mine.centre), _numbers(other.centre), "m", away, by.extent)
    moments = float(np.linalg.norm(mine.inertia, 2)) or float(np.linalg.norm(other.inertia, 2))
    apart = float(np.linalg.norm(mine.inertia - other.inertia, 2))
    scale = max(moments, mine.mass * (by.extent / 100) ** 2)
    add("inertia", six(mine.inertia), six(other.inertia), "kg m2", apart, scale)
    return rows


Motions = list[tuple[Configuration, Array, Array]]
"""States, each with the accelerations of all rates and the forces that they take."""


def motions_of(robot: Canonical, gravity: Array, states: Sequence[Configuration], seed: int = 0) -> Motions:
    """The robot as it moves by itself, where all its coordinates have inertia, and in a sweep of all its joints.

    In the sweep each joint is anywhere within a sine of SWEEP whose rate comes to 1 rad/s or m/s, or its bound: what gravity
    alone does not excite, a rotor about an upright axis say, counts too.
    """
    rng = np.random.default_rng(seed)
    speeds = np.repeat([min(1.0, joint.speed or 1.0) for joint in robot.joints], np.diff(first_rates(robot)))
    motions = []
    for state in states:
        M, forces = passive(robot, state, gravity)
        with suppress(np.linalg.LinAlgError):
            free = _solved(M, forces)
            motions.append((state, free, M @ free + forces))
        for swing in (0.0, np.pi / 2):
            phase = rng.choice((0.0, np.pi), len(speeds)) + swing
            swept = Configuration(state.q, state.turned, speeds * np.cos(phase))
            M, forces = passive(robot, swept, gravity)
            pushed: Array = SWEEP * speeds * np.sin(phase)
            motions.append((swept, pushed, M @ pushed + forces))
    return motions


def _with_worth(a: Canonical, gravity: Array, states: list[Configuration], rows: Rows) -> list[Difference]:
    """The rows with what each is worth: the largest torque that a change takes, at the worst of the motions and joints."""
    motions = motions_of(a, gravity, states) if any(changed is not None for _, changed in rows) else []
    worthy = []
    for row, changed in rows:
        if changed is not None:
            other = replace(a, links=tuple(changed if link.name == changed.name else link for link in a.links))
            terms = [(passive(other, state, gravity), pushed, taken) for state, pushed, taken in motions]
            most = np.max([np.abs(M @ pushed + forces - taken) for (M, forces), pushed, taken in terms], axis=0)
            torque, unit = float(most.max()), _UNITS[a.joints[_joint_at(a, int(np.argmax(most)))].kind]
            words = f"worth up to {torque:.3g} {unit} at the states drawn and in a sweep of all joints"
            row = replace(row, torque=torque, torque_unit=unit, words=words)
        worthy.append(row)
    return worthy


def _joint_at(robot: Canonical, rate: int) -> int:
    """The joint that a rate is of."""
    return int(np.searchsorted(first_rates(robot), rate, side="right")) - 1


def _solved(M: Array, forces: Array) -> Array:
    acceleration: Array = np.asarray(np.linalg.solve(M, -forces), dtype=np.float64)
    return acceleration


def _derived(a: Canonical, b: Canonical, gravity: Array, states: list[Configuration], by: Yardstick) -> list[Difference]:
    """Gravity torques, mass matrix and accelerations at the states: the worst joint of each."""
    worst: dict[str, tuple[float, float, float, float, int]] = {}

    def hold(quantity: str, x: Array, y: Array, scale: "float | Array", judged: Array | None = None) -> None:
        apart = np.abs(x - y)
        relative = (apart if judged is None else np.abs(judged)) / np.maximum(scale, _SMALLEST)
        k = int(np.argmax(relative))
        if quantity not in worst or relative[k] > worst[quantity][0]:
            worst[quantity] = (float(relative[k]), float(apart[k]), float(x[k]), float(y[k]), k)

    least = a.weight * float(np.linalg.norm(gravity)) * by.extent / 1000
    for state in states:
        rest = Configuration(state.q, state.turned, np.zeros_like(state.rates))
        tau_A, tau_B = (dynamics(robot, rest, gravity).bias for robot in (a, b))
        hold("gravity torque", tau_A, tau_B, float(max(np.abs(tau_A).max(), np.abs(tau_B).max(), least)))
        (M_A, f_A), (M_B, f_B) = (passive(robot, state, gravity) for robot in (a, b))
        scales = np.sqrt(np.outer(np.diag(M_A), np.diag(M_A)))
        rows = np.argmax(np.abs(M_A - M_B) / np.maximum(scales, _SMALLEST), axis=1)
        at = (np.arange(len(rows)), rows)
        hold("mass matrix", M_A[at], M_B[at], scales[at])
        try:
            a_A, a_B = _solved(M_A, f_A), _solved(M_B, f_B)
        except np.linalg.LinAlgError:
            continue
        forces = max(least, float(np.abs(f_A).max()), float((np.abs(M_A) @ np.abs(a_A)).max()))
        hold("acceleration", a_A, a_B, forces, M_A @ (a_A - a_B))
    units = {"gravity torque": "N m or N", "mass matrix": "SI", "acceleration": "rad/s2 or m/s2"}
    return [
        Difference(
            quantity=quantity, element=a.joints[_joint_at(a, k)].name, value_A=x, value_B=y, unit=units[quantity],
            tolerance=by.tolerance, absolute=size, relative=relative,
            words="follows from the rows above, at the worst of the states drawn",
        )
        for quantity, (relative, size, x, y, k) in worst.items()
        if not relative <= by.tolerance
    ]  # fmt: skip
