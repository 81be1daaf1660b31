"""Steps of worlds with contact under the exact solver: find contacts, then in each sub-step kick, solve, certify, drift.

Joints act on the kick, and on every impulse of a contact (`held`).

Where surfaces have restitution a sub-step goes on from blow to blow: the gaps of bodies that fall one behind the other may
all close in it, and who strikes first decides how fast the next are struck. Up to the instant of a blow the velocities are
those that end the sub-step, as in semi-implicit Euler; the blow itself is solved with what the forces have given until then,
over the contacts that touch, and what they give in the rest is added again. No blow gives energy (`passive`).

Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (from impact to impact).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.engine.describe.bodies import Surface
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Joint
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.options import Options
from plumbline.engine.respond.exact.held import assemble_held, give, held_bodies, hold
from plumbline.engine.respond.exact.kernels import (
    BROUGHT,
    begin_step,
    drift_touched,
    give_impulses,
    kick_touched,
    look_at_joints,
)
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.passive import without_gain
from plumbline.engine.respond.exact.problem import (
    ContactRows,
    assemble_problem,
    closing,
    contact_rows,
    pace_of,
    rates,
    rebound,
    time_to_blow,
)
from plumbline.engine.respond.exact.solver import Solution, solve

INSTANT = 1e-6
"""Share of a sub-step [1] within which gaps that close do so at once."""
MOST_BLOWS = 64
"""Parts of a sub-step, after which all blows still to come in it are taken as one."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """What was certified so far.

    Terms:
        residual: the largest relative residual of a solve [1]; solves: how many there were; missed: how many ended above the
        tolerance, with the best that their effort had found; crowded: sub-steps with more blows than were told apart; lessened:
        groups of points that rebounded by less than their restitution, which would have given energy.
    """

    residual: float = 0.0
    solves: int = 0
    missed: int = 0
    crowded: int = 0
    lessened: int = 0


class ExactSteps:
    """The step of one world, with the record of its residuals.

    Args: options: time step, sub-steps and tolerance; surfaces: all laws of the world; joints: all of its joints.
    Raises: NotSupported for dry friction, limits of speed and limited drives in joints, for static friction above kinetic, for
    rolling and for torsional friction.
    """

    def __init__(self, options: Options, surfaces: Iterable[Surface], joints: Sequence[Joint]) -> None:
        for joint in joints:
            refuse_bounded(joint)
        surfaces = tuple(surfaces)
        for law in surfaces:
            if law.static_friction > law.kinetic_friction:
                raise NotSupported("static friction above kinetic", "the exact solver has Coulomb's law with one coefficient")
            if law.rolling_friction > 0.0 or law.torsional_friction > 0.0:
                raise NotSupported("rolling or torsional friction", "the exact solver has forces at points only")
        self._jointed = bool(joints)
        self._bounces = any(law.restitution > 0.0 for law in surfaces)
        self._h, self._substeps = options.dt / options.substeps, options.substeps
        self._tolerance, self._effort = options.tolerance, options.effort
        self.certificate = Certificate()

    def retime(self, dt: float) -> None:
        """The length [s] of the steps to come."""
        self._h = dt / self._substeps

    def compile(self, floats: Floats, ints: Ints) -> None:
        """Compile what a step with contacts runs beyond one without, on none and on one: for a world to be thrown away."""
        made = contact_rows(floats, ints)
        made = made.of(np.zeros(len(made.points), np.bool_))
        assemble_problem(floats, ints, made, closing(made, 1.0))
        give_impulses(floats, ints, made.points, made.body, made.row, np.zeros((0, 3)), 1)
        solve(Problem(np.eye(3), np.array([[-1.0, 0.0, 0.0]]), np.ones(1), 1.0), guess=np.zeros((1, 3)))

    def __call__(self, floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
        """Advance bodies in contact. Returns: steps done and a status, as `step_contact`."""
        for step in range(steps):
            status = int(begin_step(floats, ints))
            if status != DONE:
                return step, status
            for substep in range(self._substeps):
                if self._advance(floats, ints, int(substep == self._substeps - 1)):
                    return step + 1, DIVERGED
        if self._jointed:
            return steps, int(look_at_joints(floats, ints))
        return steps, DONE

    def _advance(self, floats: Floats, ints: Ints, last: int) -> bool:
        """One sub-step, from blow to blow. Args: last: 1 to end the step. Returns: whether it stopped being finite."""
        h, state = self._h, at.float_table(floats, ints, at.STATE)
        motion = state[:, at.V : at.W + 3]
        before = motion.copy()
        slow, held, pace = kick_touched(floats, ints, h), None, 0.0
        if self._jointed:
            made = contact_rows(floats, ints)
            pace = pace_of(rates(state, made.row, made.body).reshape(-1, 3))
            held = held_bodies(floats, ints, made, h)
            hold(floats, ints, held)
        if at.int_table(ints, at.COUNT)[0, at.MANIFOLDS] == 0 and (held is None or len(held.gap) == 0):
            return bool(drift_touched(floats, ints, h, last))
        kick, passed = motion - before, 0.0
        for _ in range(MOST_BLOWS if self._bounces else 0):
            made = contact_rows(floats, ints)
            wait = time_to_blow(state, made, h - passed, slow)
            first, struck = float(wait.min(initial=np.inf)), wait <= INSTANT * h
            if first == np.inf:
                break
            if struck.any():
                motion -= (1.0 - passed / h) * kick
                touching = made.of(struck | (closing(made, 1.0) == 0.0))
                bounce = rebound(state, touching, struck[np.isin(made.points, touching.points)])
                self._respond(floats, ints, touching, bounce, 0.0, pace)
                drift_touched(floats, ints, 0.0, 0)
                motion += (1.0 - passed / h) * kick
            else:
                self._respond(floats, ints, made, closing(made, first), first, pace)
                drift_touched(floats, ints, first, 0)
                passed += first
        made, left = contact_rows(floats, ints), max(h - passed, INSTANT * h)
        lift = closing(made, left)
        if self._bounces and (struck := np.isfinite(time_to_blow(state, made, left, slow))).any():
            lift = np.where(struck, rebound(state, made, struck), lift)
            self.certificate = replace(self.certificate, crowded=self.certificate.crowded + 1)
        self._respond(floats, ints, made, lift, left, pace)
        return bool(drift_touched(floats, ints, h - passed, last))

    def _respond(self, floats: Floats, ints: Ints, made: ContactRows, lift: Floats, left: float, pace: float) -> None:
        """Solve these contacts, apply the impulses, and record how exact they are.

        Args: lift: as `assemble_problem`; left [s]: as `assemble_held`; pace [m/s]: of the contacts before joints held them.
        """
        lessened = 0
        if self._jointed:
            held = held_bodies(floats, ints, made, self._h)
            beside = assemble_held(floats, ints, made, lift, held, left)
            problem, brought, lift = beside.problem, beside.brought, beside.lift
            problem = replace(problem, speed=max(problem.speed, pace))
        else:
            problem, brought = assemble_problem(floats, ints, made, lift), made.values[:, BROUGHT : BROUGHT + 3]
        if not math.isfinite(problem.speed):
            return
        solution = self._solve(problem, brought)
        if self._bounces and (lift < 0.0).any():
            blow = without_gain(problem, lift, solution, self._solve)
            solution, lessened = blow.solution, blow.lessened
        if self._jointed:
            give(floats, ints, held, beside, solution.impulse)
        else:
            give_impulses(floats, ints, made.points, made.body, made.row, np.ascontiguousarray(solution.impulse), 1)
        so_far = self.certificate
        self.certificate = replace(
            so_far,
            residual=max(so_far.residual, solution.residual),
            solves=so_far.solves + 1,
            missed=so_far.missed + int(solution.residual > self._tolerance),
            lessened=so_far.lessened + lessened,
        )

    def _solve(self, problem: Problem, guess: Floats | None = None) -> Solution:
        """A problem under the options of the world. Args: guess: impulses (k, 3) N s to start from."""
        return solve(problem, self._tolerance, guess=guess, effort=self._effort)


def refuse_bounded(joint: Joint) -> None:
    """Keep from the exact solver what acts along a coordinate within bounds. Raises: NotSupported."""
    drive = getattr(joint, "drive", None)
    for held, what in (
        (getattr(joint, "friction_loss", 0.0) > 0.0, "dry friction"),
        (getattr(joint, "speed_limit", math.inf) < math.inf, "a limit of speed"),
        (drive is not None and drive.limit < math.inf, "a limited drive"),
    ):
        if held:
            raise NotSupported(
                f"{what} in joint '{joint.name}' beside exact contacts",
                "the exact solver knows joints, springs, drives and stops",
            )
