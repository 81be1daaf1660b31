"""A quadruped of 15 kg with twelve driven hinges, knees bent backwards, feet under its hips.

Masses, lengths and gains are of the order of small research quadrupeds (Katz, Di Carlo, Kim, Mini Cheetah, ICRA 2019: 9 kg,
legs of 0.21 m and 0.18 m; Hutter et al., ANYmal, IROS 2016: 30 kg); the numbers are our own.
"""

import math

from plumbline.harness.props.robots.robot import MATERIAL, RobotOnFeet, hinge
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    Drive,
    PlacedShape,
    Sphere,
    Vector3,
    axis_angle,
    box_inertia,
    capsule_inertia,
)

TRUNK_MASS, HIP_MASS, THIGH_MASS, SHANK_MASS = 7.4, 0.7, 1.0, 0.2
"""Of the trunk, and of each leg's parts; motors sit in hip and thigh [kg]."""
TRUNK_HALF: Vector3 = (0.22, 0.10, 0.055)
REACH, SPREAD, OFFSET = 0.20, 0.05, 0.08
"""Hips from the trunk's middle along and across; thighs out from hips [m]."""
LEG = 0.20
"""Thigh, and shank down to the middle of the foot [m]."""
HIP_RADIUS, BONE, FOOT = 0.045, 0.015, 0.022
"""Radii of the hips' housings, of the legs and of the feet [m]."""
CROUCH = 0.6
"""Angle of the thighs with the vertical [rad]; knees are bent by twice that."""
STIFFNESS, DAMPING = 80.0, 2.0
"""Of each drive [N m/rad, N m s/rad]."""


def _bone(name: str, mass: float, top: Vector3, turn: float, foot: bool) -> Body:
    """A leg's part of length LEG from `top` down, turned about y by `turn` [rad] from the vertical."""
    middle = (top[0] - LEG / 2 * math.sin(turn), top[1], top[2] - LEG / 2 * math.cos(turn))
    looks = PlacedShape(shape=Capsule(radius=BONE, half_length=LEG / 2 - BONE))
    sole = PlacedShape(shape=Sphere(radius=FOOT), p_BS=(0.0, 0.0, -LEG / 2))
    return Body(
        name=name,
        mass=mass,
        inertia=capsule_inertia(mass, BONE, LEG / 2 - BONE),
        collision=(sole,) if foot else (),
        visual=(looks, sole) if foot else (looks,),
        material=MATERIAL,
        p_WB=middle,
        q_WB=axis_angle((0.0, 1.0, 0.0), turn),
    )


def quadruped(stiffness: float = STIFFNESS, damping: float = DAMPING) -> RobotOnFeet:
    """The robot over the origin, facing +x, its feet on z = 0, with drives of `stiffness` and `damping`."""
    drive = Drive(stiffness=stiffness, damping=damping)
    height = 2 * LEG * math.cos(CROUCH) + FOOT
    trunk = PlacedShape(shape=Box(half_extents=TRUNK_HALF))
    bodies = [
        Body(
            name="trunk",
            mass=TRUNK_MASS,
            inertia=box_inertia(TRUNK_MASS, TRUNK_HALF),
            collision=(trunk,),
            material=MATERIAL,
            p_WB=(0.0, 0.0, height),
        )
    ]
    hinges, soles = [], {}
    for along, x in (("front", REACH), ("hind", -REACH)):
        for side, way in (("left", 1.0), ("right", -1.0)):
            leg = f"{along} {side}"
            hip: Vector3 = (x, way * SPREAD, height)
            top: Vector3 = (x, way * (SPREAD + OFFSET), height)
            knee: Vector3 = (x - LEG * math.sin(CROUCH), top[1], height - LEG * math.cos(CROUCH))
            bodies += [
                Body.ball(
                    f"{leg} hip",
                    HIP_RADIUS,
                    mass=HIP_MASS,
                    touches=False,
                    material=MATERIAL,
                    p_WB=(x, way * (SPREAD + OFFSET / 2), height),
                ),
                _bone(f"{leg} thigh", THIGH_MASS, top, CROUCH, False),
                _bone(f"{leg} shank", SHANK_MASS, knee, -CROUCH, True),
            ]
            hinges += [
                hinge("trunk", f"{leg} hip", hip, (1.0, 0.0, 0.0), drive),
                hinge(f"{leg} hip", f"{leg} thigh", top, (0.0, 1.0, 0.0), drive, CROUCH),
                hinge(f"{leg} thigh", f"{leg} shank", knee, (0.0, 1.0, 0.0), drive, -2 * CROUCH),
            ]
            soles[f"{leg} shank"] = (x, top[1], 0.0)
    return RobotOnFeet(bodies=tuple(bodies), hinges=tuple(hinges), soles=soles)
