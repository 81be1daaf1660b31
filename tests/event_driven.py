"""Few spheres and planes by events: exact parabolas between impacts, each impact at the root of a polynomial.

Between two events every sphere has a constant acceleration, so that its path is known exactly; the gap to a plane is then of
degree two in time, the squared distance of two spheres of degree two or, where one of them rests, four. The next event is the
earliest root; there the law is applied:

    normal      u_N' = -e u_N                                       Newton's restitution
    tangent     the impulse that ends slipping, if at most mu times the normal one, otherwise mu times it, against slip
    together    impacts at the same instant are taken one by one, spheres in the order of their list before planes, until none
                is left approaching; a row of touching spheres then hands a blow on from one to the next.

Bounces that shrink forever end in rest: with the speed u after a bounce, the flights still to come last 2 u / g_N, e times
that, ..., 2 u / (g_N (1 - e)) together (Zeno's time). Once u is below `ZENO` of the fastest blow, the sphere is set to rest on
the plane and that sum is reported as the time of rest. On a level plane it then slides with the deceleration mu g until it
rolls.

Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (events); Goldsmith, Impact, 1960, chapter II
(restitution and friction of spheres); Brogliato, Nonsmooth Mechanics, 2016, section 1.3 (accumulation of impacts).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbline.engine.describe.check import finite, not_negative, positive
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.maths.types import Floats

ZENO = 1e-12
"""Speed after a bounce, relative to the fastest blow, below which a sphere rests: the error in its velocity."""
TOUCH = 1e-12
"""Distance, in radii, that counts as touching: ten thousand times the round-off of a position."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyingSphere:
    """A sphere: mass [kg], radius [m], position [m], velocity [m/s], spin [rad/s]; inertia is its moment over m r^2 [1]."""

    mass: float
    radius: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: float = 0.4

    def __post_init__(self) -> None:
        for name, unit in (("mass", "kg"), ("radius", "m"), ("inertia", "1")):
            positive("sphere", name, getattr(self, name), unit)
        for name, unit in (("position", "m"), ("velocity", "m/s"), ("spin", "rad/s")):
            finite("sphere", name, getattr(self, name), (3,), unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """A fixed half-space below a plane through `point` [m] with an outward `normal` [1]."""

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ImpactLaw:
    """Restitution e in 0..1 and Coulomb's friction mu [1]."""

    restitution: float = 0.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        not_negative("law", "friction", self.friction, "1")
        if not 0.0 <= self.restitution <= 1.0:
            raise ValueError(f"law: restitution {self.restitution}, expected 0..1")


@dataclass(frozen=True, slots=True)
class Event:
    """What happened: 'impact' of a sphere with another or with a wall, 'rest' on a wall, 'roll' without slip from then on.

    Terms: time [s]; sphere: its index; other: index of the other sphere, or the number of spheres plus that of the wall.
    """

    time: float
    kind: str
    sphere: int
    other: int


@dataclass(frozen=True, slots=True)
class Motion:
    """States at the times (t,) s asked for: position (t, n, 3) m, velocity (t, n, 3) m/s, spin (t, n, 3) rad/s; the events."""

    time: Floats
    position: Floats
    velocity: Floats
    spin: Floats
    events: tuple[Event, ...]


@dataclass
class _Play:
    """Where the spheres are (n, 3), how they move, and what they rest on (n,), -1 for nothing."""

    spheres: Sequence[FlyingSphere]
    point: Floats
    normal: Floats
    gravity: Floats
    pairs: ImpactLaw
    walls: ImpactLaw
    now: float = 0.0
    fastest: float = 0.0
    events: list[Event] = field(default_factory=list)

    def __post_init__(self) -> None:
        n = len(self.spheres)
        self.p, self.v, self.w = (
            np.array([getattr(s, a) for s in self.spheres], float) for a in ("position", "velocity", "spin")
        )
        self.a, self.turn = np.tile(self.gravity, (n, 1)), np.zeros((n, 3))
        self.rests, self.slip_ends = np.full(n, -1), np.full(n, np.inf)
        self.m, self.r, self.k = (np.array([getattr(s, a) for s in self.spheres], float) for a in ("mass", "radius", "inertia"))

    def state(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Positions, velocities and spins at a time before the next event."""
        t = time - self.now
        return self.p + t * (self.v + 0.5 * t * self.a), self.v + t * self.a, self.w + t * self.turn

    def advance(self, time: float) -> None:
        """Move to a time before or at the next event."""
        self.p, self.v, self.w = self.state(time)
        self.now = time

    def next_event(self) -> tuple[float, int, int]:
        """Time from now, sphere and other of the earliest impact; for the end of a slip the other is -1."""
        n, first = len(self.spheres), (np.inf, -1, -1)
        for i in range(n):
            for j in range(i + 1, n):
                t = self.meeting(i, j)
                first = min(first, (t, i, j), key=lambda e: e[0])
            for j in range(len(self.point)):
                if self.rests[i] != j:
                    t = self.landing(i, j)
                    first = min(first, (t, i, n + j), key=lambda e: e[0])
            first = min(first, (max(self.slip_ends[i] - self.now, 0.0), i, -1), key=lambda e: e[0])
        return first

    def landing(self, i: int, j: int) -> float:
        """Time until sphere i reaches wall j."""
        normal = self.normal[j]
        gap = float(normal @ (self.p[i] - self.point[j])) - self.r[i]
        speed, pull = float(normal @ self.v[i]), float(normal @ self.a[i])
        if gap <= TOUCH * self.r[i]:
            if speed < 0.0 or (speed == 0.0 and pull < 0.0):
                return 0.0
            return -2.0 * speed / pull if pull < 0.0 else np.inf
        inside = speed * speed - 2.0 * pull * gap
        if inside < 0.0 or (speed >= 0.0 and pull >= 0.0):
            return np.inf
        root = np.sqrt(inside)
        # Of the two forms of the root the one without cancellation.
        return float(2.0 * gap / (root - speed) if speed < 0.0 else -(speed + root) / pull)

    def meeting(self, i: int, j: int) -> float:
        """Time until spheres i and j touch."""
        d, v, a, reach = self.p[j] - self.p[i], self.v[j] - self.v[i], self.a[j] - self.a[i], self.r[i] + self.r[j]
        size = float(np.sqrt(d @ d))
        c, b = (size - reach) * (size + reach), float(d @ v)
        touching = size - reach <= TOUCH * reach
        if touching and b < 0.0:
            return 0.0
        if not a.any():
            square = float(v @ v)
            inside = b * b - square * c
            return np.inf if touching or b >= 0.0 or inside <= 0.0 else float(c / (np.sqrt(inside) - b))
        # |d + v t + a t^2 / 2|^2 = reach^2
        rate = [0.25 * float(a @ a), float(v @ a), float(v @ v + d @ a), 2.0 * b, 0.0 if touching else c]
        found = np.roots(rate[:-1] if touching else rate)
        times = np.sort(found[(np.abs(found.imag) <= 1e-9 * np.abs(found)) & (found.real > 0.0)].real)
        slope = np.polyder(np.array(rate))
        for t in times:
            if np.polyval(slope, t) < 0.0:
                for _ in range(3):
                    t -= np.polyval(rate, t) / np.polyval(slope, t)
                return float(t)
        return np.inf

    def strike(self, i: int, other: int) -> None:
        """The impact of sphere i with a sphere or a wall."""
        n = len(self.spheres)
        wall = other - n
        law = self.walls if wall >= 0 else self.pairs
        if wall >= 0:
            normal, light = -self.normal[wall], 1.0 / self.m[i]
            end = np.zeros(3)
            loose = (1.0 + 1.0 / self.k[i]) / self.m[i]
        else:
            normal = self.p[other] - self.p[i]
            normal = normal / np.sqrt(normal @ normal)
            light = 1.0 / self.m[i] + 1.0 / self.m[other]
            end = self.v[other] + np.cross(self.w[other], -self.r[other] * normal)
            loose = (1.0 + 1.0 / self.k[i]) / self.m[i] + (1.0 + 1.0 / self.k[other]) / self.m[other]
        u = end - self.v[i] - np.cross(self.w[i], self.r[i] * normal)
        approach = float(normal @ u)
        slip = u - approach * normal
        self.fastest = max(self.fastest, -approach)
        blow = -(1.0 + law.restitution) * approach / light
        speed = float(np.sqrt(slip @ slip))
        rub = min(law.friction * blow, speed / loose) if law.friction > 0.0 else 0.0
        impulse = blow * normal - (rub / speed * slip if rub > 0.0 else 0.0)
        self.kick(i, -impulse, self.r[i] * normal)
        self.release(i)
        if wall < 0:
            self.kick(other, impulse, -self.r[other] * normal)
            self.release(other)
        self.events.append(Event(self.now, "impact", i, other))
        if wall >= 0:
            self.settle(i, wall, -law.restitution * approach)

    def kick(self, i: int, impulse: Floats, arm: Floats) -> None:
        """An impulse [N s] on sphere i at an arm [m] from its centre."""
        self.v[i] += impulse / self.m[i]
        self.w[i] += np.cross(arm, impulse) / (self.k[i] * self.m[i] * self.r[i] ** 2)

    def release(self, i: int) -> None:
        """Sphere i flies; where it should rest again, the next impact finds out."""
        self.rests[i], self.slip_ends[i] = -1, np.inf
        self.a[i], self.turn[i] = self.gravity, 0.0

    def settle(self, i: int, wall: int, speed: float) -> None:
        """Let sphere i rest on a wall that it leaves with no more than ZENO of the fastest blow [m/s]."""
        normal = self.normal[wall]
        pull = -float(normal @ self.gravity)
        if speed > ZENO * self.fastest or pull <= 0.0:
            return
        if self.rests[i] >= 0:
            raise NotSupported("a sphere at rest on two walls", "events know rest on one")
        self.v[i] -= float(normal @ self.v[i]) * normal
        self.rests[i] = wall
        self.a[i] = self.gravity + pull * normal
        self.events.append(
            Event(self.now + 2.0 * speed / (pull * (1.0 - self.walls.restitution)), "rest", i, len(self.m) + wall)
        )
        if self.walls.friction > 0.0:
            self.slide(i, normal, pull)

    def slide(self, i: int, normal: Floats, pull: float) -> None:
        """Kinetic friction on a sphere at rest on a level wall, until it rolls. Raises: NotSupported on a slope."""
        if np.abs(self.a[i]).max() > TOUCH * pull:
            raise NotSupported("friction on a slope", "the slip turns there, and the acceleration with it")
        self.a[i] = 0.0
        slip = self.v[i] + np.cross(self.w[i], -self.r[i] * normal)
        slip -= float(normal @ slip) * normal
        speed = float(np.sqrt(slip @ slip))
        if speed <= ZENO * max(self.fastest, float(np.abs(self.v[i]).max())):
            return
        self.a[i] = -self.walls.friction * pull / speed * slip
        self.turn[i] = np.cross(-self.r[i] * normal, self.a[i]) / (self.k[i] * self.r[i] ** 2)
        self.slip_ends[i] = self.now + speed / (self.walls.friction * pull * (1.0 + 1.0 / self.k[i]))

    def roll(self, i: int) -> None:
        """The slip of sphere i has ended."""
        self.a[i], self.turn[i], self.slip_ends[i] = 0.0, 0.0, np.inf
        self.events.append(Event(self.now, "roll", i, len(self.m) + int(self.rests[i])))


def solve_events(
    spheres: Sequence[FlyingSphere],
    walls: Sequence[Wall],
    time: Any,
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    between_spheres: ImpactLaw | None = None,
    on_walls: ImpactLaw | None = None,
    most: int = 100_000,
) -> Motion:
    """The motion of spheres among walls.

    Args: time (t,) s, increasing, from 0 on: where states are wanted; a state at the instant of an impact is the one after it;
        most: impacts allowed.
    Raises: ValueError for spheres that overlap at the start; NotSupported for rest on two walls, friction on a slope, and for
        impacts that accumulate between spheres.
    """
    wanted = np.asarray(time, float)
    normal = np.array([w.normal for w in walls], float).reshape(-1, 3)
    normal /= np.sqrt((normal * normal).sum(axis=1, keepdims=True))
    point = np.array([w.point for w in walls], float).reshape(-1, 3)
    play = _Play(spheres, point, normal, np.array(gravity, float), between_spheres or ImpactLaw(), on_walls or ImpactLaw())
    _apart(play)
    shape = (len(wanted), len(spheres), 3)
    out, here = Motion(wanted, np.empty(shape), np.empty(shape), np.empty(shape), ()), 0
    while here < len(wanted):
        wait, i, other = play.next_event()
        while here < len(wanted) and wanted[here] < play.now + wait:
            out.position[here], out.velocity[here], out.spin[here] = play.state(float(wanted[here]))
            here += 1
        if here == len(wanted):
            break
        play.advance(play.now + wait)
        if other < 0:
            play.roll(i)
        else:
            play.strike(i, other)
        if len(play.events) > most:
            raise NotSupported("impacts that accumulate", f"more than {most} events by t = {play.now:.6g} s")
    return Motion(out.time, out.position, out.velocity, out.spin, tuple(play.events))


def _apart(play: _Play) -> None:
    """Raises: ValueError where a sphere starts inside another or inside a wall."""
    for i, r in enumerate(play.r):
        for j in range(i + 1, len(play.r)):
            gap = float(np.linalg.norm(play.p[j] - play.p[i])) - r - play.r[j]
            if gap < -TOUCH * (r + play.r[j]):
                raise ValueError(f"spheres {i} and {j}: overlap by {-gap:g} m, expected none")
        for j, normal in enumerate(play.normal):
            gap = float(normal @ (play.p[i] - play.point[j])) - r
            if gap < -TOUCH * r:
                raise ValueError(f"sphere {i}: lies {-gap:g} m inside wall {j}, expected none")
