"""What an engine answered: states, contacts and ray hits as plain arrays in the world frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.scene import Scene

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]

UNSHARED = 8192
"""Numbers whose squares are added up in one thread: longer sums may be shared out over threads, which wait on busy cores."""


def _finite(numbers: Floats) -> bool:
    """Is each finite? A finite sum of squares says so in one call; that of huge numbers is infinite, and says nothing."""
    few = numbers.size <= UNSHARED
    return (few and math.isfinite(np.vdot(numbers, numbers))) or bool(np.isfinite(numbers).all())


@dataclass(frozen=True, slots=True)
class State:
    """Poses and velocities of all bodies, in the order of the scene.

    Terms:
        p_WB (n, 3) m of the centre of mass; q_WB (n, 4) unit, (w, x, y, z), B to W; v_WB (n, 3) m/s of the centre of
        mass; w_WB (n, 3) rad/s in W.
    """

    p_WB: Floats
    q_WB: Floats
    v_WB: Floats
    w_WB: Floats

    @classmethod
    def empty(cls, n: int) -> Self:
        """Room for n bodies: at the origin, unturned, at rest."""
        q_WB = np.zeros((n, 4))
        q_WB[:, 0] = 1.0
        return cls(np.zeros((n, 3)), q_WB, np.zeros((n, 3)), np.zeros((n, 3)))

    @classmethod
    def initial(cls, scene: Scene) -> Self:
        """The state that a scene starts from."""
        velocities = [b.velocity_at_start for b in scene.bodies]
        return cls(
            np.array([b.p_WB for b in scene.bodies], dtype=np.float64),
            np.array([b.q_WB for b in scene.bodies], dtype=np.float64),
            np.array([v for v, _ in velocities], dtype=np.float64),
            np.array([w for _, w in velocities], dtype=np.float64),
        )

    @property
    def finite(self) -> bool:
        """Is every number finite?"""
        return math.isfinite(self.size) or all(map(_finite, (self.p_WB, self.q_WB, self.v_WB, self.w_WB)))

    @property
    def size(self) -> float:
        """The sum of the squares of all numbers, in SI units: where it is finite, so is each of them."""
        p_WB, q_WB, v_WB, w_WB = self.p_WB, self.q_WB, self.v_WB, self.w_WB
        return float(np.vdot(p_WB, p_WB) + np.vdot(q_WB, q_WB) + np.vdot(v_WB, v_WB) + np.vdot(w_WB, w_WB))


@dataclass(frozen=True, slots=True)
class Contacts:
    """The contact points of one instant.

    Terms:
        body_A, body_B (k,): places in the scene's bodies, A < B. point_W (k, 3) m, half-way between the two surfaces.
        normal_W (k, 3) from A to B.
        gap (k,) m, negative in penetration. force_W (k, 3) N on B, averaged over the last step.
    """

    body_A: Integers
    body_B: Integers
    point_W: Floats
    normal_W: Floats
    gap: Floats
    force_W: Floats

    @classmethod
    def none(cls) -> Self:
        """No contact at all."""
        nobody, nowhere = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        return cls(nobody, nobody.copy(), nowhere, nowhere.copy(), np.zeros(0), nowhere.copy())

    @classmethod
    def of(
        cls,
        body_A: Sequence[int] | Integers,
        body_B: Sequence[int] | Integers,
        point_W: Sequence[Sequence[float]] | Floats,
        normal_W: Sequence[Sequence[float]] | Floats,
        gap: Sequence[float] | Floats,
        force_W: Sequence[Sequence[float]] | Floats,
    ) -> Self:
        """From sequences in any order of bodies: pairs are turned so that A < B, normal and force with them."""
        a, b = np.array(body_A, dtype=np.int64), np.array(body_B, dtype=np.int64)
        normal = np.array(normal_W, dtype=np.float64).reshape(-1, 3)
        force = np.array(force_W, dtype=np.float64).reshape(-1, 3)
        turn = a > b
        normal[turn] *= -1.0
        force[turn] *= -1.0
        return cls(
            np.where(turn, b, a),
            np.where(turn, a, b),
            np.array(point_W, dtype=np.float64).reshape(-1, 3),
            normal,
            np.array(gap, dtype=np.float64),
            force,
        )

    def __len__(self) -> int:
        return len(self.gap)


@dataclass(frozen=True, slots=True)
class Hits:
    """What rays met: distance (r,) m (inf: nothing), body (r,) place in the scene (-1: nothing), normal_W (r, 3) or zeros."""

    distance: Floats
    body: Integers
    normal_W: Floats


@dataclass(frozen=True, slots=True)
class Image:
    """What a camera saw.

    Terms:
        depth (height, width) m along the optical axis, inf where nothing is seen. body (height, width): place in the scene of
        what is seen, -1 for nothing. colour (height, width, 3): linear red, green, blue; None where only shapes were drawn.
    """

    depth: Floats
    body: Integers
    colour: Floats | None = None


@dataclass(frozen=True, slots=True)
class Trajectory:
    """States over time: time (t,) s, and the arrays of `State` with t in front.

    Terms:
        dt [s]: the step that made it, the longest of uneven ones; 0 for a truth. even: were all its steps of one length?
        contacts: one `Contacts` an instant, or None where they were not asked for.
        streams: sensor signals by name, "<sensor>/<channel>", each (k, ...), stamped (k,) s under "<sensor>/time".
    """

    time: Floats
    p_WB: Floats
    q_WB: Floats
    v_WB: Floats
    w_WB: Floats
    dt: float = 0.0
    contacts: tuple[Contacts, ...] | None = None
    streams: Mapping[str, Floats] = field(default_factory=dict)
    even: bool = True

    @classmethod
    def of(cls, time: Floats, n: int) -> Self:
        """Room for n bodies at rest, to be filled in."""
        t = len(time)
        q_WB = np.zeros((t, n, 4))
        q_WB[:, :, 0] = 1.0
        return cls(np.asarray(time, dtype=np.float64), np.zeros((t, n, 3)), q_WB, np.zeros((t, n, 3)), np.zeros((t, n, 3)))

    @classmethod
    def at_rest(cls, scene: Scene, time: Floats) -> Self:
        """The bodies of a scene in their places at each time [s], with no speed."""
        rest = cls.of(time, len(scene.bodies))
        rest.p_WB[:], rest.q_WB[:] = [body.p_WB for body in scene.bodies], [body.q_WB for body in scene.bodies]
        return rest

    @classmethod
    def at(cls, state: State) -> Self:
        """One sample, at time 0."""
        return cls(np.zeros(1), state.p_WB[None], state.q_WB[None], state.v_WB[None], state.w_WB[None])

    def __len__(self) -> int:
        return len(self.time)

    def state(self, k: int) -> State:
        """The k-th state, as a view."""
        return State(self.p_WB[k], self.q_WB[k], self.v_WB[k], self.w_WB[k])

    def between(self, start: float, end: float) -> "Trajectory":
        """The part with start <= time <= end [s], half a nanosecond of slack; streams are cut alike."""
        keep = (self.time >= start - 5e-10) & (self.time <= end + 5e-10)
        places = np.flatnonzero(keep)
        streams: dict[str, Floats] = {}
        for name, signal in self.streams.items():
            stamps = self.streams[name.rsplit("/", 1)[0] + "/time"]
            streams[name] = signal[(stamps >= start - 5e-10) & (stamps <= end + 5e-10)]
        return replace(
            self,
            time=self.time[keep],
            p_WB=self.p_WB[keep],
            q_WB=self.q_WB[keep],
            v_WB=self.v_WB[keep],
            w_WB=self.w_WB[keep],
            contacts=None if self.contacts is None else tuple(self.contacts[i] for i in places),
            streams=streams,
        )

    @property
    def finite(self) -> bool:
        """Is every number of every state finite?"""
        return all(map(_finite, (self.time, self.p_WB, self.q_WB, self.v_WB, self.w_WB)))
