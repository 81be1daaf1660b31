"""A quadruped of 15 kg on twelve hinges, and where springs on them rest for it to stand: statics, for vendors' scripts."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["CROUCH", "DAMPING", "FOOT", "HEIGHT", "LEG", "STIFFNESS", "TRUNK_HALF", "TRUNK_MASS", "Hinge", "hinges", "mass"]

G = 9.81
CROUCH = 0.6
"""The angle of the thighs with the vertical [rad]; knees are bent by twice that."""
LEG, FOOT = 0.2, 0.022
"""Length of thigh and shank, and radius of a foot [m]."""
HEIGHT = 2 * LEG * math.cos(CROUCH) + FOOT
"""Of the trunk's centre [m]."""
TRUNK_MASS, TRUNK_HALF = 7.4, (0.22, 0.10, 0.055)
STIFFNESS, DAMPING = 80.0, 2.0
"""Of each hinge [N m/rad, N m s/rad]."""
REACH, SPREAD, OFFSET = 0.20, 0.05, 0.08
"""Hips along and across the trunk; thighs out from hips [m]."""
HIP, THIGH, SHANK = 0.7, 1.0, 0.2
"""Masses of a leg's parts [kg]."""
HIP_RADIUS, BONE = 0.045, 0.015


@dataclass(frozen=True)
class Hinge:
    """A leg's hinge and the part that it carries.

    Terms:
        above: '' for the trunk. at [m]: where it is in the frame of the part above, whose origin is that part's own hinge.
        angle [rad]: in the pose. target [rad]: the rest of a spring that bears the weight there. mass [kg]. centre [m]: from
        the hinge, in the part's frame, whose z is along the bone. inertia [kg m2]: about the centre. foot: has it one?
    """

    name: str
    above: str
    at: tuple[float, float, float]
    axis: tuple[float, float, float]
    angle: float
    target: float
    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]
    foot: bool


def mass() -> float:
    """Of all [kg]."""
    return TRUNK_MASS + 4 * (HIP + THIGH + SHANK)


def _bone(mass: float) -> tuple[float, float, float]:
    """Principal moments of a capsule of length LEG along z."""
    r, half = BONE, LEG / 2 - BONE
    ends = mass * (4 * r / 3) / (2 * half + 4 * r / 3)
    rod = mass - ends
    along = rod * r * r / 2 + 0.4 * ends * r * r
    across = rod * (r * r / 4 + half * half / 3) + ends * (0.4 * r * r + half * half + 0.75 * half * r)
    return (across, across, along)


def hinges() -> Iterator[Hinge]:
    """Leg by leg, from the trunk down."""
    back = LEG / 2 * math.sin(CROUCH)
    """How far a bone's middle is behind its end."""
    lean = -4 * (THIGH + SHANK) * back / mass()
    for x in (REACH, -REACH):
        # The feet stand under the hips; two of them bear what keeps the moments about the centre of mass in balance.
        load = mass() * G * (0.5 + lean / (2 * x)) / 2
        for side in (1.0, -1.0):
            name = f"{'front' if x > 0 else 'hind'}_{'left' if side > 0 else 'right'}"
            roll = side * (OFFSET * (load - (THIGH + SHANK) * G) - OFFSET / 2 * HIP * G)
            pitch = -back * (THIGH + SHANK) * G
            bend = back * SHANK * G - 2 * back * load
            ball = 0.4 * HIP * HIP_RADIUS**2
            middle, down, y = (0.0, 0.0, -LEG / 2), (0.0, 0.0, -LEG), (0.0, 1.0, 0.0)
            hip, thigh, shank = f"{name}_hip", f"{name}_thigh", f"{name}_shank"
            out, aside = (0.0, side * OFFSET, 0.0), (0.0, side * OFFSET / 2, 0.0)
            at = (x, side * SPREAD, 0.0)
            yield Hinge(hip, "", at, (1.0, 0.0, 0.0), 0.0, -roll / STIFFNESS, HIP, aside, (ball, ball, ball), False)
            target = CROUCH - pitch / STIFFNESS
            yield Hinge(thigh, hip, out, y, CROUCH, target, THIGH, middle, _bone(THIGH), False)
            target = -2 * CROUCH - bend / STIFFNESS
            yield Hinge(shank, thigh, down, y, -2 * CROUCH, target, SHANK, middle, _bone(SHANK), True)
