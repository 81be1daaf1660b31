"""Stable PD control: springs and drives as torques of the velocity that is foreseen for the end of the step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.drives import Laws, by_skeleton
from plumbline.adapters.dart.holds import Holds, Spans, Touch, islands
from plumbline.harness.trajectory import Floats, Integers

SHARED = 1e-10
"""Of the mobility of all mass at once: what makes redundant holds share a load, too little to give way."""


@dataclass(frozen=True, slots=True)
class Island:
    """Skeletons that are held together, their coordinates n one after the other.

    Terms:
        spans: those of each skeleton, by its number. led: those that move as told. limit: of springs and drives (2, n).
        give: what redundant holds give way [1/kg].
    """

    laws: tuple[Laws, ...]
    spans: Spans
    led: Integers
    limit: Floats
    give: float


class Foresight:
    """Whose drives are to be foreseen, and by what they can be held."""

    def __init__(self, built: Built) -> None:
        self._built = built
        self._holds = Holds(built)
        self._islands: dict[tuple[int, ...], Island] = {}
        laws = {some.skeleton.getName(): some for some in by_skeleton(built.motors.values())}
        self._laws = [laws.get(skeleton.getName()) or Laws(skeleton, ()) for skeleton in built.skeletons]
        self._driven = [k for k, some in enumerate(self._laws) if len(some.places)]

    def foresee(self, begun: bool) -> None:
        """Springs and drives as torques of the velocity v' that is foreseen for the end of the step (stable PD control).

        M (v' - u) = dt f(v') + J^T p and J v' = 0: u is what the step brings without springs and drives, f are their forces
        where v' leads, J the contacts, limits and loops that bore in the last step. DART finds p itself, under these torques.
        Skeletons that nothing holds together are foreseen one by one.

        Args:
            begun: is the first batch of steps over? In it whatever touches bears.

        Source: J. Tan, K. Liu, G. Turk, Stable Proportional-Derivative Controllers, IEEE CG&A 31(4), 2011.
        """
        touches = self._holds.touches(begun)
        for numbers in islands(self._driven, self._holds.links(touches)):
            if numbers not in self._islands:
                self._islands[numbers] = self._island(numbers)
            self._foresee(self._islands[numbers], touches, begun)

    def _island(self, numbers: tuple[int, ...]) -> Island:
        """These skeletons together."""
        laws = tuple(self._laws[k] for k in numbers)
        told, spans, led, end = self._built.dart.dynamics.ActuatorType.VELOCITY, dict[int, slice](), list[int](), 0
        for k, some in zip(numbers, laws, strict=True):
            joints = [some.skeleton.getJoint(i) for i in range(some.skeleton.getNumJoints())]
            led += [end + j.getIndexInSkeleton(i) for j in joints if j.getActuatorType() == told for i in range(j.getNumDofs())]
            spans[k] = slice(end, end + some.limit.shape[1])
            end = spans[k].stop
        give = SHARED / sum(some.skeleton.getMass() for some in laws)
        return Island(laws, spans, np.array(led, dtype=np.int64), _joined([some.limit for some in laws]), give)

    def _foresee(self, island: Island, touches: Sequence[Touch], begun: bool) -> None:
        """The torques of skeletons that are held together: v' and p of all in one system of equations."""
        dt, laws = self._built.world.getTimeStep(), island.laws
        for some in laws:
            some.skeleton.computeForwardDynamics()
        u = _joined([some.skeleton.getVelocities() + dt * some.skeleton.getAccelerations() for some in laws])
        still, slope = map(_joined, zip(*(some.forces(dt) for some in laws), strict=True))
        bearing = self._holds.bearing(island.spans, touches, begun)
        n, rows = len(u), bearing.rows.reshape(-1, len(u))
        system = np.zeros((n + len(rows), n + len(rows)))
        system[n:, :n], system[:n, n:] = rows, -rows.T
        known = np.concatenate((bearing.pull, -rows @ u))
        for some, span in zip(laws, island.spans.values(), strict=True):
            # With rotors: these are the only dampers of DART where all others are foreseen.
            system[span, span] = some.skeleton.getAugMassMatrix() if self._built.rotors else some.skeleton.getMassMatrix()
        if len(island.led):
            system[island.led], system[:n, island.led], known[island.led] = 0.0, 0.0, 0.0
            system[island.led, island.led] = 1.0
        diagonal = system.reshape(-1)[:: len(system) + 1]
        diagonal[n:] = island.give
        unsprung = diagonal[:n].copy()
        while True:
            gain = dt * (slope[0] + slope[1])
            diagonal[:n] = unsprung + gain
            push = dt * (still[0] + still[1]) - gain * u
            free = still - slope * (u + _answer(system, known, push, bearing.outward))
            cut = np.minimum(np.maximum(free, -island.limit), island.limit)
            over = cut != free
            if not over.any():
                break
            # Each of them pushes with its limit from now on, whatever the velocity.
            still, slope = np.where(over, cut, still), np.where(over, 0.0, slope)
        force = cut[0] + cut[1]
        for some, span in zip(laws, island.spans.values(), strict=True):
            some.set(force[span][some.places])


def _answer(system: Floats, known: Floats, push: Floats, outward: Floats) -> Floats:
    """The changes of velocity (n,) by impulses `push` (n,) and what bears; what can only push `outward` (h, 3), and would pull,
    lets go.

    Terms: system: M, -J^T; J, 0, and what the velocity changes of both. known: the right side without `push`.
    """
    n, right = len(push), known.copy()
    right[:n] += push
    while True:
        answer = np.asarray(np.linalg.solve(system, right), dtype=np.float64)
        pulls = np.einsum("hi,hi->h", answer[n:].reshape(-1, 3), outward) < 0
        if not pulls.any():
            return answer[:n]
        gone = n + np.flatnonzero(np.repeat(pulls, 3))
        system = system.copy()
        system[gone], system[:, gone], right[gone] = 0.0, 0.0, 0.0
        system[gone, gone] = 1.0


def _joined(parts: Sequence[Floats]) -> Floats:
    """The arrays of skeletons one after the other."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-1)
