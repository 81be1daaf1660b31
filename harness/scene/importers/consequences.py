"""What an omission changes, as numbers: inertias of a robot's coordinates at the start against what is left out or put in."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.intake.import_wishes import Omissions
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.kinematics import Line, mass_matrix
from plumbline.harness.scene.importers.poses import Array, crossed
from plumbline.harness.scene.importers.robot import Coordinate

MOST = 4_000_000
"""Coordinates times coordinates times bodies up to which inertias are worked out."""
STIFF_RATE = 480.0
"""Rates [1/s] of a joint's damper above which an explicit step of 1/240 s is unstable: a factor of 1 - rate/240 below -1."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """The lines that move a body, those of what it hangs on first. Terms: above: of what it hangs on. own: its own."""

    above: "Chain | None"
    own: tuple[Line, ...]

    def nodes(self) -> "Iterator[Chain]":
        """The chain and those above it, its own first."""
        node: Chain | None = self
        while node is not None:
            yield node
            node = node.above

    def __iter__(self) -> Iterator[Line]:
        for node in reversed([*self.nodes()]):
            yield from node.own


@dataclass(frozen=True, slots=True, eq=False)
class Massive:
    """Something that moves.

    Terms:
        mass [kg], centre in W [m], inertia about it in W's axes [kg m2]; lines that move it; stated: did the user put it there?
        between: does it stand between the joints of a link, with a moment that the link does not have?
    """

    mass: float
    centre_W: Array
    inertia_W: Array
    lines: Chain
    stated: bool = False
    between: bool = False


def _columns(lines: Sequence[Line]) -> dict[str, list[tuple[Array, Array]]]:
    """Per coordinate its unit motions (w, v at W's origin): one, three of a ball, six of a free one."""
    columns = {}
    for line in lines:
        c = line.coordinate
        if c.kind in ("ball", "free"):
            turns = [(axis, crossed(line.anchor_W, axis)) for axis in np.eye(3)]
            ways = [(np.zeros(3), axis) for axis in np.eye(3)] if c.kind == "free" else []
            columns[c.name] = [*turns, *ways]
        else:
            columns[c.name] = [(line.unit.w, line.unit.v)]
    return columns


def _lines(bodies: Sequence[Massive]) -> dict[str, Line]:
    """All lines that move any of the bodies, by name, each looked at once."""
    lines: dict[str, Line] = {}
    seen = set[int]()
    for body in bodies:
        fresh = list[Chain]()
        for node in body.lines.nodes():
            if id(node) in seen:
                break
            fresh.append(node)
        seen |= {id(node) for node in fresh}
        lines |= {line.coordinate.name: line for node in reversed(fresh) for line in node.own}
    return lines


def inertias(bodies: Sequence[Massive]) -> tuple[list[Coordinate], Array, Array]:
    """The coordinates with one value each, the mass matrix of all coordinates, and the places of those in it."""
    lines = _lines(bodies)
    if len(lines) ** 2 * len(bodies) > MOST:
        return [], np.zeros((0, 0)), np.zeros(0, dtype=np.int64)
    motions = _columns(list(lines.values()))
    places: dict[str, int] = {}
    count = 0
    for name, columns in motions.items():
        places[name] = count
        count += len(columns)
    if count * count * len(bodies) > MOST:
        return [], np.zeros((0, 0)), np.zeros(0, dtype=np.int64)
    jacobians = []
    for body in bodies:
        J = np.zeros((6, count))
        for line in body.lines:
            for k, (w, v) in enumerate(motions[line.coordinate.name]):
                J[:3, places[line.coordinate.name] + k] = w
                J[3:, places[line.coordinate.name] + k] = v + crossed(w, body.centre_W)
        jacobians.append(J)
    scalars = [line.coordinate for line in lines.values() if line.coordinate.kind in ("revolute", "prismatic")]
    M = mass_matrix(jacobians, [(body.mass, body.centre_W, body.inertia_W) for body in bodies])
    return scalars, M, np.array([places[c.name] for c in scalars], dtype=np.int64)


def consequences(bodies: Sequence[Massive], dropped: Omissions) -> list[Fidelity]:
    """Rows for armature, dry friction, stiff dampers and stated masses, each with its number.

    Args: dropped: what the user leaves out; rotors and dry friction that are not are part of the scene.
    """
    scalars, M, places = inertias(bodies)
    held = {c.name: float(M[k, k]) for c, k in zip(scalars, places, strict=True)}
    lost = [c for c in scalars if dropped.takes("armature", c.name)]
    loose = [c for c in scalars if dropped.takes("friction_loss", c.name)]
    rows = _armature(lost, held) + _carried([c for c in scalars if c not in lost], "armature", "armature")
    rows += _dry(loose) + _carried([c for c in scalars if c not in loose], "friction_loss", "friction loss")
    M[places, places] += [0.0 if c in lost else c.armature for c in scalars]
    rows += _stiff(scalars, M, places)
    if any(body.stated for body in bodies):
        rows += _stated(bodies, held)
    if any(body.between for body in bodies):
        rows += _between(bodies, held)
    return rows


def _carried(scalars: Sequence[Coordinate], law: str, element: str) -> list[Fidelity]:
    return Fidelity.exact(element, [c.name for c in scalars if getattr(c, law) > 0], law)


def _armature(scalars: Sequence[Coordinate], held: Mapping[str, float]) -> list[Fidelity]:
    shares = {c.name: c.armature / held[c.name] for c in scalars if c.armature > 0}
    worst = max(shares, key=lambda name: shares[name], default="")
    return Fidelity.told("armature", list(shares), 1 + shares.get(worst, 0.0), worst=worst)


def _dry(scalars: Sequence[Coordinate]) -> list[Fidelity]:
    having = [c for c in scalars if c.friction_loss > 0]
    most = max(having, key=lambda c: c.friction_loss, default=Coordinate(name="", kind="revolute"))
    words = f"joints move where dry friction would hold or brake them; the largest is that of '{most.name}'"
    unit = "N m" if most.kind == "revolute" else "N"
    return Fidelity.left_out("friction loss", [c.name for c in having], words, value=most.friction_loss, unit=unit)


def _stiff(scalars: Sequence[Coordinate], M: Array, places: Array) -> list[Fidelity]:
    damped = [(c, int(k)) for c, k in zip(scalars, places, strict=True) if c.damping > 0]
    if not damped:
        return []
    try:
        inverse = np.linalg.inv(M)
    except np.linalg.LinAlgError:
        return []
    rates = {c.name: c.damping * float(inverse[k, k]) for c, k in damped}
    stiff = [name for name, rate in rates.items() if not rate <= STIFF_RATE]
    worst = max(stiff, key=lambda name: rates[name], default="")
    words = f"an explicit integrator explodes or needs steps below 2 over the rate; the highest is that of '{worst}'"
    return Fidelity.exact("damping", stiff, "damping", consequence=words, value=rates.get(worst), unit="1/s")


def _added(without: Sequence[Massive], held: Mapping[str, float]) -> tuple[str, float | None]:
    """The joint to whose inertia what is not among these adds most, and its share in what they have; None if they have none."""
    scalars, M, places = inertias(without)
    bare = {c.name: float(M[k, k]) for c, k in zip(scalars, places, strict=True)}
    shares = {name: value / bare[name] - 1 if bare.get(name, 0) > 0 else float("inf") for name, value in held.items()}
    worst = max(shares, key=lambda name: shares[name], default="")
    return worst, shares[worst] if shares.get(worst, float("inf")) < float("inf") else None


def _between(bodies: Sequence[Massive], held: Mapping[str, float]) -> list[Fidelity]:
    worst, value = _added([body for body in bodies if not body.between], held)
    return Fidelity.told("several joints of a link", "", value, count=sum(body.between for body in bodies), worst=worst)


def _stated(bodies: Sequence[Massive], held: Mapping[str, float]) -> list[Fidelity]:
    stated = [body for body in bodies if body.stated]
    worst, value = _added([body for body in bodies if not body.stated], held)
    return Fidelity.told("link without mass", "", value, count=len(stated), mass=stated[0].mass, worst=worst)
