"""An arm on a stand whose two fingers close on a box: a shoulder and an elbow, and a slide for each finger.

The drives of the hinges have targets that make up for the weight of all they carry, the box among it; those of the fingers have
targets inside the box, so that each presses with a force that is told. The pose in which the arm is described is then its
equilibrium: what moves in it afterwards is neither its weight nor its grip.
Source: equilibrium of a rigid body and of each part of it (Meriam and Kraige, Engineering Mechanics: Statics, chapter 4).
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.props.robots.robot import MATERIAL
from plumbline.harness.scene import WORLD, Body, Drive, Joint, Prismatic, Revolute, Vector3, axis_angle
from plumbline.harness.trajectory.kinematics import cross

LINK, THICK = 0.15, 0.02
"""Half the length of upper arm and forearm, half their thickness [m]."""
LINK_MASS, FINGER_MASS, LOAD_MASS = 1.0, 0.1, 0.1
"""Of each link, of each finger and of what they hold [kg]."""
FINGER: Vector3 = (0.02, 0.005, 0.03)
LOAD: Vector3 = (0.02, 0.02, 0.02)
"""Half sizes of a finger and of the box [m]; the fingers close along y."""
SHOULDER: Vector3 = (0.0, 0.0, 0.5)
STIFFNESS, DAMPING = 200.0, 10.0
"""Of a hinge's drive [N m/rad, N m s/rad]."""
GRASP_STIFFNESS, GRASP_DAMPING = 1000.0, 30.0
"""Of a finger's drive [N/m, N s/m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Grasp:
    """The bodies and joints of an arm, and what it holds."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]


def grasping_arm(press: float, gravity: Vector3, load: str) -> Grasp:
    """The arm in its pose, each finger of which touches the box and presses with `press` [N]. Args: load: its material."""
    x, y, z = SHOULDER
    elbow: Vector3 = (x, y, z + 2 * LINK)
    wrist: Vector3 = (x + 2 * LINK, y, z + 2 * LINK)
    held: Vector3 = (wrist[0] + FINGER[0], y, wrist[2])
    links = (
        Body.box("upper arm", (THICK, THICK, LINK), mass=LINK_MASS, touches=False, p_WB=(x, y, z + LINK)),
        Body.box(
            "forearm",
            (THICK, THICK, LINK),
            mass=LINK_MASS,
            touches=False,
            p_WB=(x + LINK, y, z + 2 * LINK),
            q_WB=axis_angle((0.0, 1.0, 0.0), np.pi / 2),
        ),
    )
    reach = LOAD[1] + FINGER[1]
    sides = (("left", 1.0), ("right", -1.0))
    fingers = tuple(
        Body.box(f"{side} finger", FINGER, mass=FINGER_MASS, material=MATERIAL, p_WB=(held[0], y + way * reach, held[2]))
        for side, way in sides
    )
    box = Body.box("box", LOAD, mass=LOAD_MASS, material=load, p_WB=held)
    carried = (*links, *fingers, box)
    hinges = tuple(
        Revolute(
            name=name,
            parent=parent,
            child=child,
            anchor_W=anchor,
            axis_W=(0.0, 1.0, 0.0),
            drive=Drive(stiffness=STIFFNESS, damping=DAMPING, target=_give(carried[first:], anchor, gravity) / STIFFNESS),
        )
        for first, (name, parent, child, anchor) in enumerate(
            (("shoulder", WORLD, "upper arm", SHOULDER), ("elbow", "upper arm", "forearm", elbow))
        )
    )
    slides = tuple(
        Prismatic(
            name=f"{side} slide",
            parent="forearm",
            child=finger.name,
            anchor_W=finger.p_WB,
            axis_W=(0.0, -way, 0.0),
            drive=Drive(stiffness=GRASP_STIFFNESS, damping=GRASP_DAMPING, target=press / GRASP_STIFFNESS),
        )
        for (side, way), finger in zip(sides, fingers, strict=True)
    )
    return Grasp(bodies=carried, joints=(*hinges, *slides))


def _give(carried: tuple[Body, ...], anchor: Vector3, gravity: Vector3) -> float:
    """The torque [N m] about y through `anchor` that bears the weight of these bodies."""
    moment = np.zeros(3)
    for body in carried:
        moment += cross(np.subtract(body.p_WB, anchor), body.mass * np.array(gravity))
    return -float(moment[1])
