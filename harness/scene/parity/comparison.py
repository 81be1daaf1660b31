"""Two robots of facts, quantity by quantity: rows for what differs beyond a tolerance.

Masses are compared relative to A's of the same group, lengths to the robot's extent, inertias to A's largest moment or that
of the group's mass at a hundredth of the extent, angles as they are [rad], dampers and the like relative to the larger one.
Gravity torques are relative to the largest of A or a thousandth of the weight at the extent, the mass matrix to the geometric
mean of the two diagonal entries.
Accelerations are judged by the torque that would make up for their difference, relative to the largest force of A's motion: an
ill-conditioned tree amplifies the last digits of its file in its accelerations, and not in the torques.
"""

from dataclasses import replace

import numpy as np

from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.parity.consequence import Change, joint_changed, mass_changed, reference, worth
from plumbline.harness.scene.parity.contacts import renamed_pairs, shape_rows, touch_rows
from plumbline.harness.scene.parity.difference import Difference, Quantity, Value
from plumbline.harness.scene.parity.drives import drive_rows
from plumbline.harness.scene.parity.facts import JointFacts, MassFacts, RobotFacts
from plumbline.harness.scene.parity.laws import rows_of
from plumbline.harness.scene.parity.motion import Configuration, dynamics, first_rates, passive
from plumbline.harness.scene.parity.planar import turned_alike
from plumbline.harness.scene.parity.states import drawn

TOLERANCE = 1e-5
"""Relative. Files hold decimals of five or six digits: a right angle written as 1.5708 is off by 3.7e-6 rad. Ten times
less than this would find the digits of a file; a hundred times more is what a scale or a drawing of a robot leaves open."""
EARTH = (0.0, 0.0, -9.81)
_SMALLEST = 1e-300


def renamed(robot: RobotFacts, names: "dict[str, str]") -> RobotFacts:
    """The robot with its joints by other names. Args: names: new by old; what is not in it keeps its own."""

    def new(name: str) -> str:
        return names.get(name, name)

    return replace(
        robot,
        joints=tuple(replace(joint, name=new(joint.name), parent=new(joint.parent)) for joint in robot.joints),
        masses={new(name): replace(solid, joint=new(name)) for name, solid in robot.masses.items()},
        shapes={new(name): shapes for name, shapes in robot.shapes.items()},
        touches=renamed_pairs(robot.touches, names),
        laws=tuple(
            replace(law, name=new(law.name) if law.kind == "mimic" else law.name, partners=tuple(map(new, law.partners)))
            for law in robot.laws
        ),
    )


def with_free_root(a: RobotFacts, b: RobotFacts) -> RobotFacts:
    """B with its free joint by A's name, where each has one: formats name it in ways of their own."""
    free_A, free_B = ([joint.name for joint in robot.joints if joint.kind == "free"] for robot in (a, b))
    return renamed(b, {free_B[0]: free_A[0]}) if len(free_A) == 1 and len(free_B) == 1 else b


def aligned(a: RobotFacts, b: RobotFacts) -> RobotFacts | None:
    """B with its joints in the order of A's and its free root by A's name; None where their trees differ."""
    b = with_free_root(a, b)
    return _in_order(a, b) if same_tree(a, b) else None


def same_tree(a: RobotFacts, b: RobotFacts) -> bool:
    """Have both the same joints of the same types under the same parents?"""
    return {(j.name, j.kind, j.parent) for j in a.joints} == {(j.name, j.kind, j.parent) for j in b.joints}


def compare(a: RobotFacts, b: RobotFacts, tolerance: float = TOLERANCE, seed: int = 0) -> list[Difference]:
    """What differs, the causes before what follows from them."""
    b = turned_alike(a, with_free_root(a, b))
    gravity = np.array(a.gravity or b.gravity or EARTH)
    rows: list[tuple[Difference, Change | None]] = []
    names_A, names_B = [joint.name for joint in a.joints], [joint.name for joint in b.joints]
    rows += [(_missing("joint", name, "present", "absent", tolerance), None) for name in names_A if name not in names_B]
    rows += [(_missing("joint", name, "absent", "present", tolerance), None) for name in names_B if name not in names_A]
    extent = _extent(a)
    for name in names_A:
        if name in names_B:
            rows += _joint(a.joint(name), b.joint(name), a.wordless | b.wordless, extent, tolerance)
    for name in names_A:
        if name in names_B:
            rows += _mass(name, a.masses.get(name), b.masses.get(name), extent, tolerance)
    slides = frozenset(joint.name for joint in a.joints if joint.kind == "prismatic")
    rows += [(row, None) for row in rows_of(a.laws, b.laws, slides, extent, tolerance)]
    if "shape" not in a.wordless | b.wordless:
        rows += [(row, None) for row in shape_rows(a, b, extent, tolerance)]
    if "touch" not in a.wordless | b.wordless:
        rows += [(row, None) for row in touch_rows(a, b, tolerance)]
    if a.gravity is not None and b.gravity is not None:
        size = float(np.linalg.norm(np.subtract(a.gravity, b.gravity)))
        scale = max(float(np.linalg.norm(a.gravity)), _SMALLEST)
        if size / scale > tolerance:
            rows.append(
                (
                    Difference(
                        quantity="gravity", element="", value_A=a.gravity, value_B=b.gravity, unit="m/s2", tolerance=tolerance,
                        absolute=size, relative=size / scale, words="everything falls otherwise",
                    ),
                    None,
                )
            )  # fmt: skip
    if not same_tree(a, b):
        why = "the trees differ, so that no motion of both can be compared"
        return [replace(row, words=row.words or why) for row, _ in rows]
    b = _in_order(a, b)
    states = drawn(a, b, seed)
    if not a.joints:
        return [row for row, _ in rows]
    if "drive" not in a.wordless | b.wordless:
        for k, (mine, other, first) in enumerate(zip(a.joints, b.joints, first_rates(a), strict=False)):
            if mine.kind in ("revolute", "prismatic"):
                rows += [(row, None) for row in drive_rows(mine, other, k, first, states, extent, tolerance)]
    return [*_with_worth(a, gravity, states, rows), *_derived(a, b, gravity, states, tolerance)]


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


def compared(a: RobotFacts, b: RobotFacts) -> tuple[list[str], list[str]]:
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


def _in_order(a: RobotFacts, b: RobotFacts) -> RobotFacts:
    return replace(b, joints=tuple(b.joint(joint.name) for joint in a.joints))


def _extent(robot: RobotFacts) -> float:
    points = [joint.anchor for joint in robot.joints] + [solid.centre for solid in robot.masses.values() if solid.mass > 0]
    if not points:
        return 1.0
    size = float(np.linalg.norm(np.ptp(np.array(points), axis=0)))
    return size if size > 0 else 1.0


def _missing(quantity: Quantity, name: str, value_A: str, value_B: str, tolerance: float) -> Difference:
    return Difference(quantity=quantity, element=name, value_A=value_A, value_B=value_B, unit="", tolerance=tolerance)


_SCALARS: tuple[tuple[Quantity, str, str], ...] = (
    ("damping", "N m s/rad", "N s/m"),
    ("stiffness", "N m/rad", "N/m"),
    ("armature", "kg m2", "kg"),
    ("friction_loss", "N m", "N"),
    ("effort", "N m", "N"),
    ("speed", "rad/s", "m/s"),
)
_OFFSETS: tuple[Quantity, ...] = ("rest", "lower", "upper")


def _joint(
    a: JointFacts, b: JointFacts, wordless: frozenset[str], extent: float, tolerance: float
) -> list[tuple[Difference, Change | None]]:
    rows: list[tuple[Difference, Change | None]] = []

    def add(quantity: Quantity, value_A: Value, value_B: Value, unit: str, size: float | None, relative: float | None,
            change: Change | None = None, words: str = "") -> None:  # fmt: skip
        if relative is None or not relative <= tolerance:
            own = size if quantity in ("friction_loss", "effort") else None  # these are forces themselves
            row = Difference(
                quantity=quantity, element=a.name, value_A=value_A, value_B=value_B, unit=unit, tolerance=tolerance,
                absolute=size, relative=relative, torque=own, torque_unit="" if own is None else unit, words=words,
            )  # fmt: skip
            rows.append((row, change))

    if a.kind != b.kind:
        add("type", a.kind, b.kind, "", None, None)
        return rows
    if a.parent != b.parent:
        add("parent", a.parent, b.parent, "", None, None)
        return rows
    scalar, slides = a.kind in ("revolute", "prismatic"), a.kind == "prismatic"
    if scalar:
        apart = float(np.linalg.norm(a.axis - b.axis))  # the angle, where it is small and both are unit vectors
        add("axis", _numbers(a.axis), _numbers(b.axis), "", apart, apart, joint_changed(a.name, axis=b.axis))
    if not slides and a.kind != "free":
        gap = b.anchor - a.anchor
        away = float(np.linalg.norm(gap - (gap @ a.axis) * a.axis if scalar else gap))
        add("anchor", _numbers(a.anchor), _numbers(b.anchor), "m", away, away / extent, joint_changed(a.name, anchor=b.anchor))
    for quantity, turning, sliding in _SCALARS:
        x, y, unit = getattr(a, quantity), getattr(b, quantity), sliding if slides else turning
        if quantity in wordless or x == y:
            continue
        if x is None or y is None:
            add(quantity, x, y, unit, None, None, words=_BOUND_WORDS[quantity])
            continue
        size = abs(x - y)
        change = joint_changed(a.name, **{quantity: y}) if quantity in ("damping", "stiffness", "armature") else None
        add(quantity, x, y, unit, size, size / max(abs(x), abs(y), _SMALLEST), change, _BOUND_WORDS.get(quantity, ""))
    for quantity in _OFFSETS:
        x, y, unit = getattr(a, quantity), getattr(b, quantity), "m" if slides else "rad"
        if quantity in wordless or x == y:
            continue
        size = None if x is None or y is None else abs(x - y)
        relative = None if size is None else size / (extent if slides else 1.0)
        change = joint_changed(a.name, rest=y) if quantity == "rest" else None
        add(quantity, x, y, unit, size, relative, change, "" if quantity == "rest" else _limit_words(x, y, unit))
    return rows


_BOUND_WORDS = {
    "friction_loss": "dry friction holds or brakes the joint by as much more or less",
    "effort": "the motor of the joint may exert as much more or less",
    "speed": "at its bound the joint is elsewhere after a second by as many rad or m",
}


def _limit_words(x: float | None, y: float | None, unit: str) -> str:
    if x is None or y is None:
        return f"{'A' if x is None else 'B'} is not stopped there"
    return f"one is stopped {abs(x - y):.4g} {unit} before the other"


def _numbers(v: Array) -> tuple[float, ...]:
    return tuple(float(x) for x in v)


def _mass(
    name: str, a: MassFacts | None, b: MassFacts | None, extent: float, tolerance: float
) -> list[tuple[Difference, Change | None]]:
    none = MassFacts(joint=name, members=(), mass=0.0, centre=np.zeros(3), inertia=np.zeros((3, 3)))
    a, b = a or none, b or none
    rows: list[tuple[Difference, Change | None]] = []

    def add(quantity: Quantity, value_A: Value, value_B: Value, unit: str, size: float, scale: float, change: Change) -> None:
        relative = size / max(scale, _SMALLEST)
        if not relative <= tolerance:
            members = ", ".join(a.members or b.members)
            row = Difference(
                quantity=quantity, element=f"what '{name}' moves: {members}", value_A=value_A, value_B=value_B, unit=unit,
                tolerance=tolerance, absolute=size, relative=relative,
            )  # fmt: skip
            rows.append((row, change))

    size = abs(a.mass - b.mass)
    add("mass", a.mass, b.mass, "kg", size, a.mass or b.mass, mass_changed(name, mass=b.mass))
    if a.mass > 0 and b.mass > 0:
        away = float(np.linalg.norm(a.centre - b.centre))
        add("centre", _numbers(a.centre), _numbers(b.centre), "m", away, extent, mass_changed(name, centre=b.centre))
    moments = float(np.linalg.norm(a.inertia, 2)) or float(np.linalg.norm(b.inertia, 2))
    apart = float(np.linalg.norm(a.inertia - b.inertia, 2))
    scale = max(moments, a.mass * (extent / 100) ** 2)
    add("inertia", _six(a.inertia), _six(b.inertia), "kg m2", apart, scale, mass_changed(name, inertia=b.inertia))
    return rows


def _six(tensor: Array) -> tuple[float, ...]:
    """xx, yy, zz, xy, xz, yz."""
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(tensor[index]) for index in places)


def _with_worth(
    a: RobotFacts, gravity: Array, states: list[Configuration], rows: list[tuple[Difference, Change | None]]
) -> list[Difference]:
    """The rows with what each is worth."""
    if all(change is None for _, change in rows):
        return [row for row, _ in rows]
    of = reference(a, gravity, states)
    worthy = []
    for row, change in rows:
        if change is not None:
            torque, unit = worth(of, change)
            words = f"worth up to {torque:.3g} {unit} at the states drawn and in a sweep of all joints"
            row = replace(row, torque=torque, torque_unit=unit, words=words)
        worthy.append(row)
    return worthy


def _solved(M: Array, forces: Array) -> Array:
    acceleration: Array = np.asarray(np.linalg.solve(M, -forces), dtype=np.float64)
    return acceleration


def _derived(a: RobotFacts, b: RobotFacts, gravity: Array, states: list[Configuration], tolerance: float) -> list[Difference]:
    """Gravity torques, mass matrix and accelerations at the states: the worst joint of each."""
    starts = first_rates(a)

    def named(rate: int) -> str:
        return a.joints[int(np.searchsorted(starts, rate, side="right")) - 1].name

    worst: dict[Quantity, tuple[float, float, float, float, int]] = {}

    def hold(quantity: Quantity, x: Array, y: Array, scale: "float | Array", judged: Array | None = None) -> None:
        apart = np.abs(x - y)
        relative = (apart if judged is None else np.abs(judged)) / np.maximum(scale, _SMALLEST)
        k = int(np.argmax(relative))
        held = (float(relative[k]), float(apart[k]), float(x[k]), float(y[k]), k)
        if quantity not in worst or held[0] > worst[quantity][0]:
            worst[quantity] = held

    weight = sum(solid.mass for solid in a.masses.values()) * float(np.linalg.norm(gravity))
    least = weight * _extent(a) / 1000
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
    units: dict[Quantity, str] = {"gravity torque": "N m or N", "mass matrix": "SI", "acceleration": "rad/s2 or m/s2"}
    return [
        Difference(
            quantity=quantity, element=named(k), value_A=x, value_B=y, unit=units[quantity], tolerance=tolerance,
            absolute=size, relative=relative, words="follows from the rows above, at the worst of the states drawn",
        )
        for quantity, (relative, size, x, y, k) in worst.items()
        if not relative <= tolerance
    ]  # fmt: skip
