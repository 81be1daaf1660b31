"""Mimics, closed loops and the like of two robots, what touches of them, and what rubs on what."""

from collections.abc import Iterator

import numpy as np

from plumbline.harness.scene import Plane
from plumbline.harness.scene.importers.poses import Array, vector
from plumbline.harness.scene.importers.robot import Closure, Geometry, Tie
from plumbline.harness.scene.parity.canonical import FIXED, Canonical
from plumbline.harness.scene.parity.difference import Difference, Yardstick
from plumbline.harness.scene.shape import support

ALONE = "it binds coordinates that move freely without it; its effect is not worked out"
_GOLDEN = np.pi * (1 + 5**0.5)
_SHOWN = 6
"""Pairs of links that are named in a row."""


def bond_rows(a: Canonical, b: Canonical, by: Yardstick) -> list[Difference]:
    """What differs in mimics and loops, and which of tendons and the like are in one alone."""
    rows = list[Difference]()

    def alone(element: str, in_A: bool) -> None:
        there = ("present", "absent") if in_A else ("absent", "present")
        rows.extend(by.rows("law", element, *there, words=ALONE))

    slides = {joint.name for joint in a.joints if joint.kind == "prismatic"}
    ties_A, ties_B = ({joint.name: joint.tie for joint in robot.joints if joint.tie is not None} for robot in (a, b))
    for name in dict.fromkeys((*ties_A, *ties_B)):
        if name in ties_A and name in ties_B:
            rows += _mimic(name, ties_A[name], ties_B[name], slides, by)
        else:
            alone(f"mimic {name}", name in ties_A)
    others_A, others_B = list(_others(a)), list(_others(b))
    for element in dict.fromkeys((*others_A, *others_B)):
        if (element in others_A) != (element in others_B):
            alone(element, element in others_A)
    for loop_A, loop_B in _paired(a, b):
        if loop_A is not None and loop_B is not None:
            rows += _closure(loop_A, loop_B, by)
        elif (loop := loop_A or loop_B) is not None:
            alone(f"closure {loop.name}", loop_A is not None)
    return rows


def _others(robot: Canonical) -> Iterator[str]:
    """What has no numbers here, or is the same where its numbers are: by its kind, name and values."""
    for need in robot.needs:
        yield from (f"{need.kind} {name}" for name in need.names)
    for cord in robot.tendons:
        length = " + ".join(f"{arm:g} {name}" for name, arm in cord.arms)
        spring = f"{cord.stiffness:g} N/m, {cord.damping:g} N s/m, rest {cord.rest:g} m"
        yield f"tendon {cord.name} of {length}, {spring}, from {cord.lower} to {cord.upper}"
    for closure in robot.closures:
        if closure.kind == "spring":
            values = f"{closure.stiffness:g} N/m, {closure.damping:g} N s/m, rest {closure.rest:g} m"
            yield f"tendon {closure.name} of {values}"


def _mimic(name: str, a: Tie, b: Tie, slides: set[str], by: Yardstick) -> list[Difference]:
    element = f"mimic {name}"
    if not (a.joint and b.joint):  # one of the two does not tell its numbers
        return []
    if a.joint != b.joint:
        return by.rows("law", element, f"follows {a.joint}", f"follows {b.joint}", words="it follows another joint")
    own, led = ("m" if each in slides else "rad" for each in (name, a.joint))
    size, scale = abs(a.ratio - b.ratio), max(abs(a.ratio), abs(b.ratio))
    words = f"with the leader at 1 {led} it is {size:.4g} {own} elsewhere"
    rows = by.rows("ratio", element, a.ratio, b.ratio, unit=f"{own}/{led}", size=size, scale=scale, words=words)
    size = abs(a.offset - b.offset)
    words = f"it is {size:.4g} {own} elsewhere throughout"
    return rows + by.rows("offset", element, a.offset, b.offset, unit=own, size=size, scale=by.lengths(own), words=words)


def _paired(a: Canonical, b: Canonical) -> Iterator[tuple[Closure | None, Closure | None]]:
    """Loops that are each other's: of one name or, since formats make names up, of the same two sides."""
    mine, left = ([closure for closure in robot.closures if closure.kind != "spring"] for robot in (a, b))
    waiting = []
    for closure in mine:
        other = next((each for each in left if each.name == closure.name), None)
        if other is None:
            waiting.append(closure)
        else:
            left.remove(other)
            yield closure, other
    for closure in waiting:
        sides = {closure.link_A, closure.link_B}
        other = next((each for each in left if {each.link_A, each.link_B} == sides), None)
        if other is not None:
            left.remove(other)
        yield closure, other
    yield from ((None, closure) for closure in left)


def _closure(a: Closure, b: Closure, by: Yardstick) -> list[Difference]:
    element = f"closure {a.name}"
    if a.kind != b.kind:
        held_A, held_B = ("all held" if closure.kind == "fixed" else "a point held" for closure in (a, b))
        return by.rows("law", element, held_A, held_B, words="the loop holds more or less")
    partners, others = (a.link_A, a.link_B), (b.link_A, b.link_B)
    points_B = (b.anchor_A, b.anchor_B)
    if partners != others:
        if partners != others[::-1]:
            sides_A, sides_B = (" and ".join(name or "the world" for name in names) for names in (partners, others))
            return by.rows("law", element, sides_A, sides_B, words="the loop closes between other links")
        points_B = points_B[::-1]
    gaps = [float(np.linalg.norm(p - q)) for p, q in zip((a.anchor_A, a.anchor_B), points_B, strict=True)]
    worst = int(np.argmax(gaps))
    point_A, point_B, size = vector((a.anchor_A, a.anchor_B)[worst]), vector(points_B[worst]), gaps[worst]
    words = f"the loop closes {size:.4g} m elsewhere on what '{partners[worst] or 'the world'}' moves"
    return by.rows("point", element, point_A, point_B, unit="m", size=size, scale=by.extent, words=words)


def _ways(count: int = 64) -> Array:
    """Directions spread over a sphere, (count, 3)."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, _GOLDEN * k
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


_WAYS = _ways()


def _reach(geometry: Geometry) -> Array:
    """How far a shape in W reaches along some directions [m]: one shape in two ways of telling reaches alike."""
    X = geometry.X_LG
    if isinstance(geometry.shape, Plane):
        normal = X.R @ np.array(geometry.shape.normal)
        return np.concatenate([normal, [normal @ X.p]])
    return support(geometry.shape, _WAYS @ X.R) + _WAYS @ X.p


def shape_rows(a: Canonical, b: Canonical, by: Yardstick) -> list[Difference]:
    """What touches in one of the two alone, a row for each link."""
    rows = []
    shapes_A, shapes_B = ({link.name: link.geometries for link in robot.links} for robot in (a, b))
    for name in dict.fromkeys((*shapes_A, *shapes_B)):
        left = [(shape, _reach(shape)) for shape in shapes_B.get(name, ())]
        alone, off = [], 0.0
        for shape in shapes_A.get(name, ()):
            mine = _reach(shape)
            apart = [float(np.abs(mine - other).max()) if len(mine) == len(other) else np.inf for _, other in left]
            nearest = int(np.argmin(apart)) if apart else -1
            if apart and apart[nearest] <= by.tolerance * by.extent:
                left.pop(nearest)
            else:
                alone.append(shape)
                off = max(off, min(apart, default=np.inf))
        if alone or left:
            words_A, words_B = _words(alone), _words([shape for shape, _ in left])
            size = off if np.isfinite(off) and len(alone) == len(left) else None
            element = f"what '{name}' moves" if name else "what is fixed"
            more = {"unit": "m", "size": size, "scale": by.extent, "words": "contacts begin elsewhere"}
            rows += by.rows("shape", element, words_A, words_B, **more)  # type: ignore[arg-type]
    return rows


def _words(shapes: list[Geometry]) -> str:
    kinds = [shape.shape.type.replace("_", " ") for shape in shapes]
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds)) or "none"


_FRICTIONS = {"static_friction": "1", "kinetic_friction": "1", "torsional_friction": "m", "rolling_friction": "m"}


def touch_rows(a: Canonical, b: Canonical, by: Yardstick) -> list[Difference]:
    """The pairs that may touch in one of the two alone, and the friction of those that may in both."""
    rows = []
    for mine, other, in_A, in_B in ((a, b, "touch", "never touch"), (b, a, "never touch", "touch")):
        alone = [pair for pair in mine.touches if pair not in other.touches]
        if alone:
            rows += by.rows("touch", _named(alone), in_A, in_B, words="excluded, masked or a neighbour in one alone")
    common = [pair for pair in a.touches if pair in b.touches]
    for quantity, unit in _FRICTIONS.items():
        values = {pair: (getattr(a.touches[pair], quantity), getattr(b.touches[pair], quantity)) for pair in common}
        off = {pair: abs(x - y) / max(abs(x), abs(y), 1e-300) for pair, (x, y) in values.items()}
        changed = [pair for pair, relative in off.items() if relative > by.tolerance]
        if changed:
            x, y = values[max(changed, key=lambda pair: off[pair])]
            rows += by.rows(
                "friction", f"{quantity.replace('_', ' ')} of {_named(changed)}", x, y, unit=unit, size=abs(x - y),
                scale=max(abs(x), abs(y)), words="times the normal force, they hold or brake by as much more or less",
            )  # fmt: skip
    return rows


def _named(pairs: list[frozenset[str]]) -> str:
    shown = [" and ".join(f"'{name}'" if name != FIXED else "what is fixed" for name in sorted(pair)) for pair in pairs]
    more = f" and {len(shown) - _SHOWN} more pairs" if len(shown) > _SHOWN else ""
    return "; ".join(shown[:_SHOWN]) + more
