"""A humanoid of 70 kg and 1.7 m with thirty driven hinges, standing with knees a little bent and arms hanging.

Shares of mass, places of centres of mass, lengths and radii of gyration are those of men (de Leva, J. Biomechanics 29 (1996)
1223, table 4, of a stature of 1.741 m); breadths and the height of the ankle are shares of stature (Winter, Biomechanics and
Motor Control of Human Movement, 4th ed., figure 4.1, after Drillis and Contini). Hip, shoulder, neck, waist, ankle and forearm
are rows of hinges through one point with a housing between each two, whose mass is taken from the segment beyond; housings and
gains are our own, of the order of humanoid robots.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from plumbline.harness.props.robots.robot import MATERIAL, RobotOnFeet, hinge, inertia_of
from plumbline.harness.scene import Body, Box, Capsule, Drive, PlacedShape, Revolute, Shape, Sphere, Vector3, axis_angle

MASS, STATURE = 70.0, 1.7
SCALE = STATURE / 1.741
ANKLE, HIPS, SHOULDERS, FOOT_BREADTH = 0.039 * STATURE, 0.09, 0.129 * STATURE, 0.055 * STATURE
"""Height of the ankle; hip joints and shoulders from the middle; breadth of a foot [m]."""
HEEL = 0.25
"""Share of the foot that lies behind the ankle."""
THIGH_LEAN, SHANK_LEAN = 0.1, 0.2
"""Angles of thighs, back, and shanks, forward, with the vertical [rad], from the ankle up: they bend the knees and bring the
centre of mass over the middle of the soles."""


@dataclass(frozen=True, slots=True)
class _Segment:
    """Share of mass; length [m] at the table's stature; centre of mass from the upper end; radii of gyration about x, y, z."""

    share: float
    length: float
    centre: float
    radii: Vector3

    @property
    def long(self) -> float:
        """Length [m]."""
        return self.length * SCALE


# The upper end is the joint that a part of a limb hangs on, and the head's or trunk's end nearer to the crown.
HEAD = _Segment(0.0694, 0.2429, 0.5002, (0.303, 0.315, 0.261))
CHEST = _Segment(0.1596, 0.1707, 0.2999, (0.716, 0.454, 0.659))
WAIST = _Segment(0.1633, 0.2155, 0.4502, (0.482, 0.383, 0.468))
PELVIS = _Segment(0.1117, 0.1457, 0.6115, (0.615, 0.551, 0.587))
UPPER_ARM = _Segment(0.0271, 0.2817, 0.5772, (0.285, 0.269, 0.158))
FOREARM = _Segment(0.0162, 0.2689, 0.4574, (0.276, 0.265, 0.121))
HAND = _Segment(0.0061, 0.0862, 0.7900, (0.628, 0.513, 0.401))
THIGH = _Segment(0.1416, 0.4222, 0.4095, (0.329, 0.329, 0.149))
SHANK = _Segment(0.0433, 0.4340, 0.4459, (0.255, 0.249, 0.103))
FOOT = _Segment(0.0137, 0.2581, 0.4415, (0.124, 0.245, 0.257))
"""Along x, from the heel."""

HOUSING = 0.05
"""Radius of a housing [m]: a ball."""
HIP_MOTOR, ANKLE_MOTOR, WAIST_MOTOR, NECK_MOTOR, SHOULDER_MOTOR, WRIST_MOTOR = 1.0, 0.3, 1.5, 0.4, 0.3, 0.15
"""Mass of one housing [kg]; hips, neck and shoulders have two."""
NECK_RISE = 0.0714 * SCALE
"""Of the seventh cervical vertebra over the breast bone's end, where the chest begins [m]: 0.2421 less 0.1707 of the table."""

DRIVES = {
    "leg": (2000.0, 15.0),
    "ankle": (1500.0, 100.0),
    "waist": (600.0, 5.0),
    "hip turn": (500.0, 10.0),
    "neck": (100.0, 3.0),
    "head turn": (50.0, 1.0),
    "shoulder": (150.0, 5.0),
    "arm turn": (20.0, 0.3),
    "elbow": (60.0, 1.5),
    "wrist": (10.0, 0.1),
}
"""Stiffness and damping [N m/rad, N m s/rad] by place. Both ankles together have to be stiffer than m g h, 600 N m/rad, or
the body falls over them, and damp its sway; arms and neck are damped about critically for what hangs on them."""

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def _drive(place: str, stiffness: float) -> Drive:
    k, d = DRIVES[place]
    return Drive(stiffness=k * stiffness, damping=d * math.sqrt(stiffness))


def _below(top: Vector3, way: float, turn: float = 0.0) -> Vector3:
    """The point `way` [m] down from `top` on a line turned about y by `turn` [rad] from the vertical."""
    return (top[0] - way * math.sin(turn), top[1], top[2] - way * math.cos(turn))


def _housing(name: str, mass: float, place: Vector3) -> Body:
    return Body.ball(name, HOUSING, mass=mass, touches=False, material=MATERIAL, p_WB=place)


def _part(
    name: str, segment: _Segment, top: Vector3, shape: Shape, given: float = 0.0, turn: float = 0.0, solid: bool = False
) -> Body:
    """A segment from `top` down that has given `given` [kg] to housings; its shape is centred on its length."""
    mass = segment.share * MASS - given
    drawn = (PlacedShape(shape=shape, p_BS=(0.0, 0.0, (segment.centre - 0.5) * segment.long)),)
    return Body(
        name=name,
        mass=mass,
        inertia=inertia_of(mass, segment.long, segment.radii),
        collision=drawn if solid else (),
        visual=drawn,
        material=MATERIAL,
        p_WB=_below(top, segment.centre * segment.long, turn),
        q_WB=axis_angle(Y, turn),
    )


def _limb(radius: float, segment: _Segment) -> Capsule:
    return Capsule(radius=radius, half_length=segment.long / 2 - radius)


def _slab(half_depth: float, half_breadth: float, segment: _Segment) -> Box:
    return Box(half_extents=(half_depth, half_breadth, segment.long / 2))


def _chain(
    root: str, rows: Iterable[tuple[Body, Vector3, Vector3, str, float]], s: float, side: str = ""
) -> tuple[list[Body], list[Revolute]]:
    """Bodies that hang on one another by hinges, the first on `root`: with anchor, axis, drive and position of its hinge."""
    bodies: list[Body] = []
    hinges: list[Revolute] = []
    for body, anchor, axis, drive, position in rows:
        bodies.append(replace(body, name=f"{side} {body.name}".strip()))
        hinges.append(hinge(root, bodies[-1].name, anchor, axis, _drive(drive, s), position))
        root = bodies[-1].name
    return bodies, hinges


def _leg(side: str, hip: Vector3, s: float) -> tuple[list[Body], list[Revolute]]:
    """From two housings at the hip down to the foot, which is a box from the heel on."""
    knee = _below(hip, THIGH.long, -THIGH_LEAN)
    ankle = _below(knee, SHANK.long, SHANK_LEAN)
    heel = ankle[0] - HEEL * FOOT.long
    mass = FOOT.share * MASS - ANKLE_MOTOR
    box = Box(half_extents=(FOOT.long / 2, FOOT_BREADTH / 2, ANKLE / 2))
    sole = PlacedShape(shape=box, p_BS=((0.5 - FOOT.centre) * FOOT.long, 0.0, 0.0))
    foot = Body(
        name="foot",
        mass=mass,
        inertia=inertia_of(mass, FOOT.long, FOOT.radii),
        collision=(sole,),
        material=MATERIAL,
        p_WB=(heel + FOOT.centre * FOOT.long, hip[1], ANKLE / 2),
    )
    rows = (
        (_housing("hip turn", HIP_MOTOR, hip), hip, Z, "hip turn", 0.0),
        (_housing("hip roll", HIP_MOTOR, hip), hip, X, "leg", 0.0),
        (_part("thigh", THIGH, hip, _limb(0.07, THIGH), 2 * HIP_MOTOR, -THIGH_LEAN), hip, Y, "leg", -THIGH_LEAN),
        (_part("shank", SHANK, knee, _limb(0.05, SHANK), 0.0, SHANK_LEAN), knee, Y, "leg", THIGH_LEAN + SHANK_LEAN),
        (_housing("ankle", ANKLE_MOTOR, ankle), ankle, Y, "ankle", -SHANK_LEAN),
        (foot, ankle, X, "ankle", 0.0),
    )
    return _chain("pelvis", rows, s, side)


def _arm(side: str, shoulder: Vector3, s: float) -> tuple[list[Body], list[Revolute]]:
    """From two housings at the shoulder down to the hand."""
    elbow = _below(shoulder, UPPER_ARM.long)
    wrist = _below(elbow, FOREARM.long)
    housing = replace(_housing("wrist", WRIST_MOTOR, wrist), visual=(PlacedShape(shape=Sphere(radius=0.03)),))
    upper = _part("upper arm", UPPER_ARM, shoulder, _limb(0.04, UPPER_ARM), 2 * SHOULDER_MOTOR)
    rows = (
        (_housing("shoulder pitch", SHOULDER_MOTOR, shoulder), shoulder, Y, "shoulder", 0.0),
        (_housing("shoulder roll", SHOULDER_MOTOR, shoulder), shoulder, X, "shoulder", 0.0),
        (upper, shoulder, Z, "arm turn", 0.0),
        (_part("forearm", FOREARM, elbow, _limb(0.035, FOREARM), WRIST_MOTOR), elbow, Y, "elbow", 0.0),
        (housing, wrist, Z, "wrist", 0.0),
        (_part("hand", HAND, wrist, _slab(0.04, 0.015, HAND)), wrist, Y, "wrist", 0.0),
    )
    return _chain("chest", rows, s, side)


def _trunk(hips: float, s: float) -> tuple[list[Body], list[Revolute], Vector3]:
    """Pelvis, waist, chest and head over hips at that height [m]; with them the middle of the shoulders."""
    navel: Vector3 = (0.0, 0.0, hips + PELVIS.long)
    midriff: Vector3 = (0.0, 0.0, navel[2] + WAIST.long)
    shoulders: Vector3 = (0.0, 0.0, midriff[2] + CHEST.long)
    neck: Vector3 = (0.0, 0.0, shoulders[2] + NECK_RISE)
    crown: Vector3 = (0.0, 0.0, neck[2] + HEAD.long)
    pelvis = _part("pelvis", PELVIS, navel, _slab(0.10, 0.16, PELVIS), solid=True)
    head = _part("head", HEAD, crown, Capsule(radius=0.085, half_length=HEAD.long / 2 - 0.085), 2 * NECK_MOTOR, solid=True)
    rows = (
        (_housing("waist roll", WAIST_MOTOR, navel), navel, X, "waist", 0.0),
        (_part("waist", WAIST, midriff, _slab(0.09, 0.13, WAIST), WAIST_MOTOR), navel, Y, "waist", 0.0),
        (_part("chest", CHEST, shoulders, _slab(0.11, 0.17, CHEST), solid=True), midriff, Z, "waist", 0.0),
        (_housing("neck turn", NECK_MOTOR, neck), neck, Z, "head turn", 0.0),
        (_housing("neck pitch", NECK_MOTOR, neck), neck, Y, "neck", 0.0),
        (head, neck, X, "neck", 0.0),
    )
    bodies, hinges = _chain("pelvis", rows, s)
    return [pelvis, *bodies], hinges, shoulders


def humanoid(stiffness: float = 1.0) -> RobotOnFeet:
    """The robot over the origin, facing +x, its soles on z = 0.

    Args: stiffness: what all stiffnesses of DRIVES are multiplied by; dampings by its root, so that damping ratios stay.
    """
    hips = ANKLE + THIGH.long * math.cos(THIGH_LEAN) + SHANK.long * math.cos(SHANK_LEAN)
    bodies, hinges, shoulders = _trunk(hips, stiffness)
    for side, way in (("left", 1.0), ("right", -1.0)):
        for parts, joints in (
            _leg(side, (0.0, way * HIPS, hips), stiffness),
            _arm(side, (0.0, way * SHOULDERS, shoulders[2]), stiffness),
        ):
            bodies += parts
            hinges += joints
    standing = RobotOnFeet(bodies=tuple(bodies), hinges=tuple(hinges), soles={})
    # The ground's force has to pass below the centre of mass, and is taken to act below the ankle's middle across.
    below = float(standing.centre[0])
    soles: dict[str, Vector3] = {f"{side} foot": (below, way * HIPS, 0.0) for side, way in (("left", 1.0), ("right", -1.0))}
    return replace(standing, soles=soles)
