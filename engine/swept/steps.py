"""Swept steps: advance the world to its next impact, let it strike, and go on with the rest of the step.

    left = dt
    repeat  try the step `left`; find the earliest impact t on the paths from its start to its end
            none: done.  Else go back, advance by t alone, put the bodies where their paths are, strike, left -= t

The trial is any contact step of the engine, so that whatever does not strike moves exactly as without the sweep. A pair is
swept if it could go farther than the margin in a step; it has no contact before it touches, and so is never deflected by what
it passes. After `MAX_IMPACTS` of one step the rest is done with speculative contacts, which let nothing through either.

Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, chapter 2; Catto, Continuous Collision, GDC 2013.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbline.engine.contact.points import Contacts, fit_impulses, joined, manifold_points
from plumbline.engine.describe.errors import ManyImpacts
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import CONVEX_PENDING, DIVERGED, DONE, FULL
from plumbline.engine.options import Options
from plumbline.engine.swept.earliest import earliest_impact
from plumbline.engine.swept.path import PATH_COLUMNS
from plumbline.engine.swept.strike import place_bodies, strike

Step = Callable[[Floats, Ints, int], tuple[int, int]]
Search = Callable[[Floats, Ints], int]

MAX_IMPACTS = 256
"""Impacts of one step [1] that are followed one by one."""
SWEEPS = 24
"""Sweeps of a blow, which has no impulses to start from: as many as a blow of the soft solver has."""


@dataclass(frozen=True, slots=True)
class Impacts:
    """What was swept so far. Terms: count: impacts; crowded: steps that had more than `MAX_IMPACTS`."""

    count: int = 0
    crowded: int = 0


class SweptSteps:
    """The step of one world, with the record of its impacts.

    Args: options; step: of the contact solver, compiled; search: for the pairs of the coming part of a step, or None where the
    step finds them itself; bodies, shapes: their numbers.
    """

    def __init__(self, options: Options, step: Step, search: Search | None, bodies: int, shapes: int) -> None:
        self._dt, self._trial, self._search = options.dt, step, search
        self._path, self._bounds = np.zeros((bodies + 1, PATH_COLUMNS)), np.zeros((shapes, 6))
        self._order = np.arange(shapes)
        self._left, self._done, self._strikes = 0.0, 0, False
        self._parts: list[Contacts] = []
        self.impacts = Impacts()

    def __call__(self, floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
        """Advance bodies in contact. Returns: steps done and a status, as `step_contact`."""
        for step in range(steps):
            status = self._step(floats, ints)
            if status != DONE:
                return step + int(status == DIVERGED), status
        return steps, DONE

    def retime(self, dt: float) -> None:
        """The length [s] of the steps to come."""
        self._dt = dt

    def joined(self, last: Contacts) -> Contacts:
        """The contact points of all parts of the last step. Args: last: those of its last part."""
        return joined(*self._parts, last)

    def _step(self, floats: Floats, ints: Ints) -> int:
        """One whole step, or what is left of one that waited for a larger arena. Returns: a status."""
        count = at.int_table(ints, at.COUNT)[0]
        if self._left == 0.0:
            self._left, self._done, self._parts = self._dt, 0, []
        number = int(count[at.STEPS])
        status = self._finish(floats, ints, number)
        at.float_table(floats, ints, at.SETTING)[0, at.DT] = self._dt
        count[at.CONTINUOUS], count[at.STEPS] = at.SWEPT, number + int(status != FULL)
        if status != FULL:
            self._left = 0.0
        return status

    def _finish(self, floats: Floats, ints: Ints, number: int) -> int:
        """Strike and advance until nothing is left of the step that follows step `number`. Returns: a status."""
        state, count = at.float_table(floats, ints, at.STATE), at.int_table(ints, at.COUNT)[0]
        while True:
            if self._strikes:
                status = self._strike(floats, ints)
                if status != DONE:
                    return status
            follows, manifolds = self._done < MAX_IMPACTS, int(count[at.MANIFOLDS])
            count[at.CONTINUOUS] = at.SWEPT if follows else at.SPECULATIVE
            start, saved = state.copy(), [table.copy() for table in _moving(floats, ints)]
            status = self._advance(floats, ints, self._left)
            if status != DONE:
                return status
            time = math.inf
            if follows:
                time = earliest_impact(floats, ints, start, self._left, self._path, self._bounds, self._order)
            if not time < self._left:
                break
            count[at.MANIFOLDS] = manifolds
            for table, old in zip(_moving(floats, ints), saved, strict=True):
                table[:] = old
            if time > 0.0:
                status = self._advance(floats, ints, time)
                if status != DONE:
                    return status
                self._note(floats, ints)
            place_bodies(floats, ints, self._path, time)
            self._left, self._done, self._strikes = self._left - time, self._done + 1, True
        if self._done == MAX_IMPACTS:
            warnings.warn(ManyImpacts(f"step {number + 1} had {MAX_IMPACTS} impacts or more"), stacklevel=2)
        past = self.impacts
        self.impacts = Impacts(past.count + self._done, past.crowded + int(self._done == MAX_IMPACTS))
        return DONE if np.isfinite(state).all() else DIVERGED

    def _strike(self, floats: Floats, ints: Ints) -> int:
        """The blow of this instant. Returns: a status."""
        status = self._once_found(floats, ints, lambda: int(strike(floats, ints, SWEEPS)))
        if status == DONE:
            self._strikes = False
            self._note(floats, ints)
        return status

    def _advance(self, floats: Floats, ints: Ints, span: float) -> int:
        """A contact step of `span` seconds, started from impulses that fit its length. Returns: a status."""
        setting = at.float_table(floats, ints, at.SETTING)[0]
        setting[at.DT] = span
        fit_impulses(floats, ints, span)
        return self._once_found(floats, ints, lambda: self._trial(floats, ints, 1)[1])

    def _once_found(self, floats: Floats, ints: Ints, run: Callable[[], int]) -> int:
        """Run what begins with the contacts of the present poses: find their pairs, and count no body as still.

        Contacts kept from part to part would miss bodies that are put where their paths are. Returns: a status.
        """
        at.float_table(floats, ints, at.REST)[:] = np.inf
        status = DONE if self._search is None else self._search(floats, ints)
        if status == DONE:
            status = run()
        if status == CONVEX_PENDING:
            from plumbline.engine.contact.collide_convex import collide_convex

            collide_convex(floats, ints)
            status = run()
        return status

    def compile(self, floats: Floats, ints: Ints) -> None:
        """Compile what only an impact calls for, in a world to be thrown away."""
        place_bodies(floats, ints, self._path, 0.0)
        self._strike(floats, ints)

    def _note(self, floats: Floats, ints: Ints) -> None:
        """Keep the impulses of this part of the step, which the next part will not know."""
        count = int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
        self._parts.append(manifold_points(floats, ints, count, -math.inf, self._dt))


def _moving(floats: Floats, ints: Ints) -> list[Floats | Ints]:
    """Views of all that a step changes and the next one reads."""
    n = int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
    return [
        at.float_table(floats, ints, at.STATE),
        at.float_table(floats, ints, at.TURNED),
        at.float_table(floats, ints, at.SETTING),
        at.float_table(floats, ints, at.MANIFOLD)[:n],
        at.float_table(floats, ints, at.POINT)[: 4 * n],
        at.int_table(ints, at.MANIFOLD_KEY)[:n],
        at.int_table(ints, at.POINT_KEY)[: 4 * n],
        at.int_table(ints, at.COUNT),
    ]
