"""A robot: a tree of bodies, the driven hinges between them, and the points of its soles.

Its drives are PD drives. A drive without load holds its joint at the target; one with load gives way by torque over stiffness.
`bearing` moves every target by that much, so that the pose in which a robot is described is its equilibrium, exactly, at any
stiffness: what moves in it afterwards is not its weight.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.scene import Body, Drive, Matrix3, Revolute, Vector3, principal_inertia
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import cross

MATERIAL = "machine"
"""The material of every part; a scene keeps it apart from itself, so that parts of one robot do not touch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotOnFeet:
    """Bodies in a pose at rest, hinges that all have a drive, and where each foot bears.

    Terms:
        soles: name of a foot to the point [m] in W at which the ground's force on it has no moment.
    """

    bodies: tuple[Body, ...]
    hinges: tuple[Revolute, ...]
    soles: Mapping[str, Vector3]

    @property
    def mass(self) -> float:
        """All of it [kg]."""
        return sum(body.mass for body in self.bodies)

    @property
    def centre(self) -> Floats:
        """Its centre of mass [m] in W, (3,)."""
        return sum((body.mass * np.array(body.p_WB) for body in self.bodies), np.zeros(3)) / self.mass

    def beyond(self, joint: Revolute) -> Iterator[Body]:
        """The bodies that the hinge carries, from its child on."""
        below = {joint.child}
        # Hinges stand in the order of the tree, so that one pass finds them all.
        for other in self.hinges:
            if other.parent in below:
                below.add(other.child)
        return (body for body in self.bodies if body.name in below)


def inertia_of(mass: float, length: float, radii: Vector3) -> Matrix3:
    """The inertia [kg m2] of a segment by its radii of gyration about x, y, z, each a share of its length [m]."""
    x, y, z = (mass * (share * length) ** 2 for share in radii)
    return principal_inertia(x, y, z)


def hinge(parent: str, child: str, anchor: Vector3, axis: Vector3, drive: Drive, position: float = 0.0) -> Revolute:
    """A driven hinge through `anchor` [m] about `axis`, both in W, held where it is: at `position` [rad]."""
    return Revolute(
        name=child,
        parent=parent,
        child=child,
        anchor_W=anchor,
        axis_W=axis,
        position=position,
        drive=replace(drive, target=position),
    )


def loads(robot: RobotOnFeet, gravity: Vector3) -> dict[str, Vector3]:
    """The force [N] of the ground on each foot, at its sole, that holds the robot: of all such the most even one.

    Raises: ValueError where its weight does not lie over its soles.
    """
    points = np.array(list(robot.soles.values()))
    weight = robot.mass * np.array(gravity)
    up = -weight / np.linalg.norm(weight)
    arms = np.cross(points - robot.centre, up)
    balance = np.vstack([np.ones(len(points)), arms.T])
    wanted = np.array([np.linalg.norm(weight), 0.0, 0.0, 0.0])
    shares = np.linalg.lstsq(balance, wanted, rcond=None)[0]
    if np.abs(balance @ shares - wanted).max() > 1e-9 * wanted[0] or (shares < 0).any():
        raise ValueError(f"machine: centre of mass {robot.centre.tolist()} m does not lie over its soles {points.tolist()}")
    return {name: tuple((share * up).tolist()) for name, share in zip(robot.soles, shares, strict=True)}


def bearing(robot: RobotOnFeet, gravity: Vector3) -> RobotOnFeet:
    """The same robot with targets at which it stands in its pose: target = position + torque / stiffness.

    The torque of a hinge balances the moments about its axis of all weights and ground forces beyond it.

    Raises: as `loads`.
    Source: equilibrium of a rigid body and of each part of it (Meriam and Kraige, Engineering Mechanics: Statics, chapter 4).
    """
    ground, pull = loads(robot, gravity), np.array(gravity)
    held = []
    for joint in robot.hinges:
        moment = np.zeros(3)
        for body in robot.beyond(joint):
            moment += cross(np.subtract(body.p_WB, joint.anchor_W), body.mass * pull)
            if body.name in ground:
                moment += cross(np.subtract(robot.soles[body.name], joint.anchor_W), np.array(ground[body.name]))
        assert joint.drive is not None
        give = -float(moment @ np.array(joint.axis_W)) / joint.drive.stiffness
        held.append(replace(joint, drive=replace(joint.drive, target=joint.position + give)))
    return replace(robot, hinges=tuple(held))


def copy_of(robot: RobotOnFeet, name: str, way: Vector3) -> RobotOnFeet:
    """The same robot `way` [m] further, with `name` before the name of each part."""

    def moved(point: Vector3) -> Vector3:
        return (point[0] + way[0], point[1] + way[1], point[2] + way[2])

    def named(part: str) -> str:
        return f"{name} {part}"

    return RobotOnFeet(
        bodies=tuple(replace(body, name=named(body.name), p_WB=moved(body.p_WB)) for body in robot.bodies),
        hinges=tuple(
            replace(
                joint,
                name=named(joint.name),
                parent=named(joint.parent),
                child=named(joint.child),
                anchor_W=moved(joint.anchor_W),
            )
            for joint in robot.hinges
        ),
        soles={named(foot): moved(point) for foot, point in robot.soles.items()},
    )
