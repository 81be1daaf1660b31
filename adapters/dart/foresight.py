"""Stable PD control: springs and drives as torques of the velocity that is foreseen for the end of the step."""

from collections.abc import Sequence

import numpy as np

from adapters.dart.built import Built
from adapters.dart.drives import by_skeleton
from adapters.dart.holds import Bearing, Holds, Touch, islands
from harness.trajectory import Floats, Integers

__all__ = ["Foresight"]

SHARED = 1e-10
"""Of the mean mobility: what makes redundant contacts share a load, too little to give way."""
_TINY = float(np.finfo(np.float64).tiny)


class Foresight:
    """Whose drives are to be foreseen, and by what they can be held."""

    def __init__(self, built: Built) -> None:
        self._built = built
        self._holds = Holds(built)
        numbers = {skeleton.getName(): k for k, skeleton in enumerate(built.skeletons)}
        self._laws = {numbers[laws.skeleton.getName()]: laws for laws in by_skeleton(built.motors.values())}
        driven = built.dart.dynamics.ActuatorType.VELOCITY
        self._led: list[Integers] = []
        for skeleton in built.skeletons:
            joints = [skeleton.getJoint(i) for i in range(skeleton.getNumJoints())]
            led = [j.getIndexInSkeleton(i) for j in joints if j.getActuatorType() == driven for i in range(j.getNumDofs())]
            self._led.append(np.array(led, dtype=np.int64))

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
        for island in islands(self._laws, self._holds.links(touches)):
            self._foresee(island, touches, begun)

    def _foresee(self, island: Sequence[int], touches: Sequence[Touch], begun: bool) -> None:
        """The torques of skeletons that are held together."""
        dt = self._built.world.getTimeStep()
        skeletons = {number: self._built.skeletons[number] for number in island}
        for skeleton in skeletons.values():
            skeleton.computeForwardDynamics()
        u = {k: s.getVelocities() + dt * s.getAccelerations() for k, s in skeletons.items()}
        masses = {k: s.getMassMatrix() for k, s in skeletons.items()}
        laws = {k: self._laws[k] for k in island if k in self._laws}
        forces = {k: some.forces(dt) for k, some in laws.items()}
        bearing = self._holds.bearing(island, touches, begun)
        while True:
            end = self._end(u, masses, forces, bearing, dt)
            exceeded = False
            for k, some in laws.items():
                still, slope = forces[k]
                free = still - slope * end[k]
                cut = np.minimum(np.maximum(free, -some.limit), some.limit)
                some.set((cut[0] + cut[1])[some.places])
                if (over := cut != free).any():
                    # Each of them pushes with its limit from now on, whatever the velocity.
                    forces[k], exceeded = (np.where(over, cut, still), np.where(over, 0.0, slope)), True
            if not exceeded:
                return

    def _end(
        self,
        u: dict[int, Floats],
        masses: dict[int, Floats],
        forces: dict[int, tuple[Floats, Floats]],
        bearing: Bearing,
        dt: float,
    ) -> dict[int, Floats]:
        """Velocities (n,) of each skeleton at the end of the step, under `forces` (at v = 0, and slopes) and what bears."""
        free, answers = dict[int, Floats](), dict[int, Floats]()
        count = 3 * len(bearing.outward)
        given, gap = np.zeros((count, count)), np.zeros(count)
        for k, rows in bearing.rows.items():
            resisting, pushes = masses[k].copy(), np.empty((len(u[k]), 1 + count))
            pushes[:, 0], pushes[:, 1:] = bearing.pull[k], rows.T
            if k in forces:
                still, slope = forces[k]
                slopes = slope[0] + slope[1]
                pushes[:, 0] += dt * (still[0] + still[1] - slopes * u[k])
                _diagonal(resisting)[:] += dt * slopes
            if len(led := self._led[k]):
                resisting[led], resisting[:, led], pushes[led] = 0.0, 0.0, 0.0
                resisting[led, led] = 1.0
            answer = np.linalg.solve(resisting, pushes)
            free[k], answers[k] = u[k] + answer[:, 0], answer[:, 1:]
            given += rows @ answers[k]
            gap += rows @ free[k]
        if not count:
            return free
        p = _impulses(given, gap, bearing.outward)
        return {k: v + answers[k] @ p for k, v in free.items()}


def _impulses(given: Floats, gap: Floats, outward: Floats) -> Floats:
    """The impulses (3 h,) by which holds bear; one that can only push `outward` (h, 3), and would pull, lets go.

    Terms: given: velocities (3 h, 3 h) that unit impulses give. gap: velocities (3 h,) without them.
    """
    diagonal = _diagonal(given)
    diagonal += SHARED * diagonal.mean() + _TINY
    let_go = np.zeros(len(outward), dtype=np.bool_)
    while True:
        p: Floats = np.linalg.solve(given, -gap)
        pulls = np.einsum("hi,hi->h", p.reshape(-1, 3), outward) < 0
        if not pulls.any():
            return p
        # A row that has let go is one of the unit matrix: its impulse is zero.
        let_go |= pulls
        rows = np.repeat(let_go, 3)
        given[rows], given[:, rows], gap[rows] = 0.0, 0.0, 0.0
        diagonal[rows] = 1.0


def _diagonal(matrix: Floats) -> Floats:
    """The diagonal of a square matrix (n, n), to be written to."""
    return matrix.reshape(-1)[:: len(matrix) + 1]
