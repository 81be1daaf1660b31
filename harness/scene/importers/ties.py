"""Coordinates that follow others: mimics of URDF and linear equalities of MJCF, as couplings that hold from the start."""

from collections.abc import Mapping
from dataclasses import replace

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Omissions
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Coupling, Joint, Prismatic, Revolute
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Coordinate, Robot

MOVED = 1e-9
"""How far a start may lie beside its tie and be taken for it [rad or m]: rounding of a file's digits."""

FAR = 1e9
"""What no follower starts at, nor at a rate of: beyond it a turn has no digits left."""


def untied(robot: Robot) -> Robot:
    """The robot without the ties that its user leaves out, and a row that says so."""
    lost = [c.name for c in robot.coordinates() if lets_go(robot.dropped, c)]
    rows = Fidelity.left_out("joint", lost, "mimic was dropped by the user: each then moves freely")
    return robot.each(lambda c: replace(c, tie=None) if c.name in lost else c).told(rows) if lost else robot


def lets_go(dropped: Omissions, c: Coordinate) -> bool:
    """Has the coordinate a tie, and does its user leave it out?"""
    return c.tie is not None and any(dropped.takes(kind, c.name) for kind in c.tie.kinds)


def tied(robot: Robot) -> Robot:
    """The robot with each follower at the place and rate that its tie says. Raises: RobotError, where ties lead in a ring."""
    coordinates = {c.name: c for c in robot.coordinates()}
    moved, rows = dict[str, Coordinate](), list[Fidelity]()
    for c in coordinates.values():
        if c.tie is None:
            continue
        position, velocity = _where(c, coordinates)
        here = c.reference if c.position is None else c.position
        moved[c.name] = replace(c, position=position, velocity=velocity)
        if abs(position - here) > MOVED * max(1.0, abs(here)):
            rows += Fidelity.told(
                "start beside its tie",
                c.name,
                abs(position - here),
                position=position,
                joint=c.tie.joint,
                unit="rad" if c.kind == "revolute" else "m",
            )
    if not moved:
        return robot
    if any(c.tie is not None and c.tie.soft for c in moved.values()):
        words = "how softly the tie holds is each engine's own, not the file's solref and solimp"
        rows += Fidelity.approximated("equality", list(moved), "coupling", consequence=words)
    else:
        rows += Fidelity.exact("mimic", list(moved), "coupling")
    return robot.each(lambda c: moved.get(c.name, c)).told(rows)


def _where(c: Coordinate, coordinates: Mapping[str, Coordinate]) -> tuple[float, float]:
    """Place and rate of a coordinate at the end of its chain of ties. Raises: RobotError."""
    chain, seen = [c], {c.name}
    while (tie := chain[-1].tie) is not None:
        if tie.joint in seen:
            raise RobotError(f"{c.where}: joint {quoted(c.name, 80)} follows itself, expected an end to whom it follows")
        seen.add(tie.joint)
        chain.append(coordinates[tie.joint])
    last = chain.pop()
    position, velocity = last.reference if last.position is None else last.position, last.velocity
    for joint in reversed(chain):
        assert joint.tie is not None
        position, velocity = joint.tie.ratio * position + joint.tie.offset, joint.tie.ratio * velocity
    if not (abs(position) < FAR and abs(velocity) < FAR):
        raise RobotError(f"{c.where}: joint {quoted(c.name, 80)} follows to {position:g}, expected less than {FAR:g}")
    return position, velocity


def coupled(joints: list[Joint], robot: Robot, names: Mapping[str, str]) -> list[Joint]:
    """The joints of a scene with the couplings that its coordinates have. Args: names: of each coordinate, its joint's."""
    ties = {names[c.name]: c.tie for c in robot.coordinates() if c.tie is not None}
    with_couplings: list[Joint] = []
    for joint in joints:
        tie = ties.get(joint.name)
        if tie is not None and isinstance(joint, Revolute | Prismatic):
            joint = replace(joint, coupling=Coupling(joint=names[tie.joint], ratio=tie.ratio, offset=tie.offset))
        with_couplings.append(joint)
    return with_couplings
