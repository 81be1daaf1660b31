"""Many worlds advanced side by side, each exactly as it would be alone."""

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np

from plumbline.engine.articulated.assembly import grow_world
from plumbline.engine.describe.check import finite
from plumbline.engine.describe.errors import Diverged, NotSupported
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import CONVEX_PENDING, FULL
from plumbline.engine.options import GAUSS_SEIDEL
from plumbline.engine.steps.choice import Kernels, load_collide
from plumbline.engine.steps.many_worlds import COLLIDE, SEARCH, STEP, address_of, advance_worlds, advance_worlds_parallel
from plumbline.engine.world import World

LINE = 8
"""Numbers in a cache line: worlds begin on lines of their own, so that threads do not write to the same one."""


class Batch:
    """Copies of worlds, advanced together; their memory lies in a row.

    A world in a batch ends with the same bits as alone, on any number of threads.

    Args:
        worlds: of any kinds, with the same number of bodies; they are copied. threads: how many run at once at most, of those
        that Numba was started with (NUMBA_NUM_THREADS).
    Raises: ValueError for no world, for worlds of other numbers of bodies, and for worlds with threads of their own;
        NotSupported for the exact solver, swept collision, and sweeps of which threads share the contacts of one world.
    """

    def __init__(self, worlds: Sequence[World], threads: int = 1) -> None:
        if not worlds:
            raise ValueError("batch: no worlds, expected at least 1")
        if threads < 1:
            raise ValueError(f"batch: threads {threads}, expected at least 1")
        self._bodies = len(worlds[0].state())
        for k, world in enumerate(worlds):
            if len(world.state()) != self._bodies:
                raise ValueError(f"batch: world {k} has {len(world.state())} bodies, expected {self._bodies} as world 0")
            if world.options.threads > 1:
                raise ValueError(f"batch: world {k} has {world.options.threads} threads, expected 1: a batch has its own")
            for found, what in ((world.certificate, "the solver 'exact'"), (world.impacts, "swept collision")):
                if found is not None:
                    raise NotSupported(f"a batch of worlds with {what}", "it does not run in one compiled step")
            if world.sweeps != GAUSS_SEIDEL:
                raise NotSupported(f"a batch of worlds with sweeps '{world.sweeps}'", "a batch shares worlds among threads")
        self._threads = threads
        self._worlds = [copy(world) for world in worlds]
        self._kinds: dict[Kernels, Ints] = {
            kernels: np.array([k for k, world in enumerate(worlds) if world.kernels == kernels])
            for kernels in dict.fromkeys(world.kernels for world in worlds)
        }
        self._addresses = {kernels: _addresses(kernels) for kernels in self._kinds}
        self._collide: dict[bool, Any] = {}
        self._left, self._status = np.zeros(len(worlds), np.int64), np.zeros(len(worlds), np.int64)
        self._lay_out()

    @classmethod
    def replicate(cls, world: World, count: int, threads: int = 1) -> "Batch":
        """The same world `count` times."""
        return cls([world] * count, threads)

    def __len__(self) -> int:
        return len(self._worlds)

    def step(self, count: int = 1) -> None:
        """Advance every world by count * dt.

        Raises: Diverged with the number of the first world that did, once all others have been advanced; ValueError for
            count < 0.
        """
        if count < 0:
            raise ValueError(f"batch: step count {count}, expected at least 0")
        self._left[:] = count
        for kernels, which in self._kinds.items():
            while self._advance(kernels, which):
                states = self._status[which]
                if (states == CONVEX_PENDING).any() and kernels.moving_meshes not in self._collide:
                    self._collide[kernels.moving_meshes] = address_of(load_collide(kernels.moving_meshes), COLLIDE)
                self._grow([int(k) for k in which[states == FULL]])
                which = which[(states == FULL) | (states == CONVEX_PENDING)]
        for k in np.flatnonzero(self._status).tolist():
            world = self._worlds[k]
            why = world.why_lost(int(self._status[k]))
            if why:
                raise Diverged(world.steps, why, k)

    def state(self) -> Floats:
        """A copy of the states (k, n, 13), each as `World.state`."""
        return self._floats[self._state].reshape(len(self), self._bodies, 13)

    def set_load(self, f_B_W: Any, tau_B_W: Any) -> None:
        """Apply forces (k, n, 3) N at the centres of mass and torques (k, n, 3) N m, in W, from now on. Raises: ValueError."""
        shape = (len(self), self._bodies, 3)
        load = (finite("batch", "f_B_W", f_B_W, shape, "N"), finite("batch", "tau_B_W", tau_B_W, shape, "N m"))
        self._floats[self._load] = np.concatenate(load, axis=2).reshape(len(self), -1)

    def world(self, k: int) -> World:
        """World k in place: to read its contacts, cast rays and command its joints until the next step of the batch.

        Advance or restore the batch, not the world: that would part the two.
        """
        return self._worlds[k]

    def save(self) -> list[tuple[Floats, Ints]]:
        """All that decides the future of every world."""
        return [world.save() for world in self._worlds]

    def restore(self, saved: Sequence[tuple[Floats, Ints]]) -> None:
        """Back to a saved state of this batch."""
        for world, one in zip(self._worlds, saved, strict=True):
            world.restore(one)
        self._lay_out()

    def _advance(self, kernels: Kernels, which: Ints) -> int:
        """Advance the worlds of one kind as far as they go. Returns: how many stopped before."""
        addresses = (*self._addresses[kernels], self._collide.get(kernels.moving_meshes, 0))
        given = (addresses, self._floats, self._ints, self._place, which, self._left, self._status)
        return advance_worlds(*given) if self._threads == 1 else advance_worlds_parallel(*given, self._threads)

    def _grow(self, which: Sequence[int]) -> None:
        """Give these worlds room for twice as many pairs."""
        for k in which:
            world = self._worlds[k]
            world.restore(grow_world(*world.save(), world.in_joint_coordinates))
        if which:
            self._lay_out()

    def _lay_out(self) -> None:
        """Move the worlds' memory into one row, and let them work there."""
        sizes = np.array([[len(array) for array in world.save()] for world in self._worlds])
        begins = np.cumsum(-(-sizes // LINE) * LINE, axis=0)
        total = begins[-1]
        begins = np.vstack((np.zeros((1, 2), np.int64), begins[:-1]))
        self._place = np.column_stack((begins[:, 0], begins[:, 0] + sizes[:, 0], begins[:, 1], begins[:, 1] + sizes[:, 1]))
        self._floats, self._ints = np.zeros(total[0]), np.zeros(total[1], np.int64)
        states, loads = [], []
        for world, (f0, f1, i0, i1) in zip(self._worlds, self._place.tolist(), strict=True):
            self._floats[f0:f1], self._ints[i0:i1] = world.save()
            world.adopt(self._floats[f0:f1], self._ints[i0:i1])
            states.append(f0 + self._ints[i0 + 3 * at.STATE])
            loads.append(f0 + self._ints[i0 + 3 * at.LOAD])
        self._state = np.array(states)[:, None] + np.arange(13 * self._bodies)
        self._load = np.array(loads)[:, None] + np.arange(6 * self._bodies)


def _addresses(kernels: Kernels) -> tuple[Any, Any, Any]:
    """Where the step, the search and the test of its pairs lie; 0 for what there is none of."""
    return (
        address_of(kernels.step, STEP),
        0 if kernels.find_pairs is None else address_of(kernels.find_pairs, SEARCH),
        0 if kernels.drop_apart is None else address_of(kernels.drop_apart, COLLIDE),
    )
