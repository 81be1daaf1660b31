"""A four-bar linkage in a vertical plane: as a world of bodies and joints, and as one angle on its own."""

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from plumbline import engine

__all__ = ["G", "MASSES", "PINS", "START", "Linkage", "Pose", "angles_of", "coordinates_of", "falls", "no_torque", "widest_gap"]

G = 9.81
Floats = NDArray[np.float64]

PINS = ("crank_pin", "coupler_pin", "coupler_end", "rocker_pin")
START = ((0.0, 0.0), (0.06, 0.1), (0.33, 0.19), (0.3, 0.0))
"""The pins, (x, z) [m]: the crank can go round; the rocker turns back where crank and coupler are in one line."""
MASSES = (0.2, 0.4, 0.4)


MOMENTS = tuple(m * math.dist(one, two) ** 2 / 12 for m, one, two in zip(MASSES, START, START[1:], strict=False))
"""Of the links, rods, about their middles [kg m2]."""


@dataclass(frozen=True)
class Linkage:
    """A four-bar linkage: what its pins have, what else there is."""

    limits: Mapping[str, engine.Limits] = field(default_factory=dict)
    spring: engine.Spring | None = None
    drive: engine.Drive | None = None
    last: str = "revolute"
    rope: engine.Limits | None = None
    beside: tuple[engine.Body, ...] = ()
    shapes: tuple[engine.Placed, ...] = ()

    def world(self, integrator: str, dt: float = 1e-3, **options: object) -> engine.World:
        """The rocker's pin has the spring, the crank's the drive; the rope holds the coupler's middle to a metre above."""
        corners = np.array([(x, 0.0, z + 1.0) for x, z in START])
        names = (engine.WORLD, "crank", "coupler", "rocker", engine.WORLD)
        bodies = [
            engine.Body(
                name=names[k + 1], mass=MASSES[k], inertia=MOMENTS[k] * np.eye(3), p_WB=corners[k : k + 2].mean(axis=0),
                shapes=self.shapes if k == 1 else (),
            )
            for k in range(3)
        ]  # fmt: skip
        joints: list[engine.Joint] = []
        for k, pin in enumerate(PINS):
            # The rocker's coordinate grows as it turns about +y against the world, as the crank's does.
            parent, child = (engine.WORLD, "rocker") if k == 3 else (names[k], names[k + 1])
            joints.append(
                engine.Revolute(
                    name=pin, parent=parent, child=child, anchor_W=corners[k], axis_W=(0, 1, 0),
                    limits=self.limits.get(pin), spring=self.spring if k == 3 else None, drive=self.drive if k == 0 else None,
                )
            )  # fmt: skip
        if self.last == "ball":
            joints[2] = engine.Ball(name="coupler_end", parent="coupler", child="rocker", anchor_W=corners[2])
        if self.rope is not None:
            middle = corners[1:3].mean(axis=0)
            joints.append(
                engine.Distance(
                    name="rope", parent=engine.WORLD, child="coupler", anchor_W=middle + np.array((0, 0, 0.5)),
                    child_anchor_W=middle, limits=self.rope,
                )
            )  # fmt: skip
        return engine.World([*bodies, *self.beside], joints, options=engine.Options(integrator=integrator, dt=dt, **options))  # type: ignore[arg-type]


def angles_of(world: engine.World) -> Floats:
    """How far crank, coupler and rocker have turned about +y [rad], each within half a turn."""
    q = world.state()[:3, 3:7]
    turned: Floats = 2 * np.arctan2(q[:, 2], q[:, 0])
    return (turned + math.pi) % (2 * math.pi) - math.pi


def widest_gap(world: engine.World) -> float:
    """The widest gap between the ends of links that meet [m]."""
    state, ends = world.state()[:3], []
    for k in range(3):
        middle = np.add(START[k], START[k + 1]) / 2
        turn = Rotation.from_quat(state[k, 3:7], scalar_first=True)
        for x, z in (START[k], START[k + 1]):
            ends.append(state[k, :3] + turn.apply((x - middle[0], 0.0, z - middle[1])))
    first, last = (np.array((x, 0.0, z + 1.0)) for x, z in (START[0], START[3]))
    pairs = ((ends[0], first), (ends[1], ends[2]), (ends[3], ends[4]), (ends[5], last))
    return max(float(np.linalg.norm(a - b)) for a, b in pairs)


@dataclass(frozen=True)
class Pose:
    """At a crank angle: turns [rad], inertia about the crank [kg m2], masses times heights [kg m]."""

    coupler: float
    rocker: float
    inertia: float
    height: float


A, B, C, D = (complex(*corner) for corner in START)
"""The pins as x + i z [m]: a turn by an angle about +y is a product with exp(-i angle), one with -i a rate per rad."""


def dot(one: complex, other: complex) -> float:
    return (one * other.conjugate()).real


def turned_by(arm: complex, start: complex) -> float:
    """How far an arm has turned about +y [rad]."""
    return cmath.phase(start * arm.conjugate())


def pose_at(angle: float, before: complex) -> tuple[Pose, complex]:
    """By two circles that meet, the meeting nearest to the one before. Returns: the pose, and that meeting."""
    coupler, rocker = abs(C - B), abs(C - D)
    b = (B - A) * cmath.exp(-1j * angle)
    far = abs(D - b)
    along = (coupler**2 - rocker**2 + far**2) / (2 * far)
    off, way = math.sqrt(coupler**2 - along**2), (D - b) / far
    foot = b + along * way
    end = min((foot + off * 1j * way, foot - off * 1j * way), key=lambda one: abs(one - before))
    # The end goes across the rocker, and along the coupler as fast as its other end.
    b_rate, across = -1j * b, -1j * (end - D)
    turns = dot(end - b, b_rate) / dot(end - b, across)
    c_rate = turns * across

    rates = (b_rate / 2, (b_rate + c_rate) / 2, c_rate / 2)
    spins = (1.0, dot(c_rate - b_rate, -1j * (end - b)) / coupler**2, turns)
    inertia = sum(m * abs(v) ** 2 + J * w * w for m, J, v, w in zip(MASSES, MOMENTS, rates, spins, strict=True))
    height = MASSES[0] * b.imag / 2 + MASSES[1] * (b + end).imag / 2 + MASSES[2] * end.imag / 2
    return Pose(turned_by(end - b, C - B), turned_by(end - D, C - D), inertia, height), end


Torque = Callable[[float, float, Pose], float]


def coordinates_of(angle: float, pose: Pose) -> dict[str, float]:
    """Of all pins [rad]."""
    return dict(zip(PINS, (angle, pose.coupler - angle, pose.rocker - pose.coupler, pose.rocker), strict=True))


def falls(
    seconds: float, torque: Torque, limits: Mapping[str, engine.Limits], start: float = 0.0, gravity: float = G
) -> tuple[float, float, Pose]:
    """As `_fallen`, worked out once for whoever compares with it."""
    return _fallen(seconds, torque, tuple(limits.items()), start, gravity)


@cache
def _fallen(
    seconds: float, torque: Torque, limited: tuple[tuple[str, engine.Limits], ...], start: float, gravity: float
) -> tuple[float, float, Pose]:
    """The linkage from rest at a crank angle, in one coordinate. Args: torque: on the crank, of angle, rate and pose.

    Returns: crank angle, time [s] and pose after so many seconds, or where a limit is met.
    """
    meeting, limits = C, dict(limited)

    def slope(_: float, y: Floats) -> list[float]:
        nonlocal meeting
        step = 1e-5
        pose, meeting = pose_at(y[0], meeting)
        ahead, behind = pose_at(y[0] + step, meeting)[0], pose_at(y[0] - step, meeting)[0]
        inertia, height = (ahead.inertia - behind.inertia) / (2 * step), (ahead.height - behind.height) / (2 * step)
        return [y[1], (torque(y[0], y[1], pose) - gravity * height - inertia * y[1] ** 2 / 2) / pose.inertia]

    def room(_: float, y: Floats) -> float:
        at = coordinates_of(y[0], pose_at(y[0], meeting)[0])
        return min((min(at[pin] - rng.lower, rng.upper - at[pin]) for pin, rng in limits.items()), default=1.0)

    room.terminal = True  # type: ignore[attr-defined]
    room.direction = -1.0  # type: ignore[attr-defined]
    run = solve_ivp(slope, (0, seconds), [start, 0.0], method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.01, events=room)
    return float(run.y[0, -1]), float(run.t[-1]), pose_at(float(run.y[0, -1]), meeting)[0]


def no_torque(*_: object) -> float:
    return 0.0
