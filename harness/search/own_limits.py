"""Each engine against itself: what a scene without a truth comes to on one engine, as its time step goes to zero.

The runs of an engine on one track, told apart by the step that it really takes, are extrapolated to a step of zero with an
error bar (`harness.statistics.richardson`), up to where that bar leaves the tolerance or the runs no longer draw together
(`harness.statistics.richardson`). Distances are shares of the size of what moves (`harness.trajectory.parting`).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.features import features_of
from plumbline.harness.scene import Scene
from plumbline.harness.statistics.richardson import Convergence, convergence, horizon, limit
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.parting import Extent, apart, common, displaced, length, offsets

TOLERANCE = 0.01
"""Of the size of what moves: a hundredth, which is a centimetre of a robot's metre, and what an eye sees in a picture."""
FEWEST = 3
"""Runs at steps of their own: two have one difference, which says nothing of whether it shrinks."""
ROUNDING = 1e-6
"""Share of the size that two limits may lie apart beyond their bars: what a last digit of a constant does, and nobody asks
for."""
SOFT = 1e-3
"""Metres that a contact, or a joint that closes a loop, may give under weight: granted to all engines whose contacts are
springs."""
ABOVE = 0.5
"""How far an order may lie above what an integrator promises: more says that errors of another kind still shrink, and not that
the answer comes near its limit."""
HALF = 0.5
"""Of the samples up to which runs lie near each other: where they draw together at fewer, they only have not parted yet."""
ANSWERED = ("passed", "failed")

Kind: TypeAlias = Literal["converges", "does not converge", "diverged", "cannot"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """One run of a ladder. Terms: dt [s] as it was asked for, substep [s] as it was taken; trial, status, reason: of its
    record. integrator: as it is resolved, '' where that is not told."""

    dt: float
    substep: float
    trial: str
    status: str
    reason: str
    run: Trajectory | None = None
    integrator: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnLimit:
    """What an engine comes to on one track.

    Terms:
        kind: 'converges' and 'does not converge' are told apart here only where nothing shrinks at all. why: of a kind that
        is no 'converges', else what steps without an answer came to. said: how far the ladder converges; None without three
        runs. value: poses at a step of zero, bar (t,): how far off they may be up to each sample, as a share of the size;
        None where no time is known. horizons [s]: by the coarser step of each halving, up to when it moves the answer by no
        more than the tolerance. time (t,) s, moved (t,): what the last halving moves the answer by up to each sample; None
        without three runs. promised: the order of the integrator, None where none is told. granted: share of the size that two
        limits may lie apart; what moves less with the step has no order that matters.
    """

    kind: Kind
    why: str = ""
    said: Convergence | None = None
    value: Trajectory | None = None
    bar: Floats | None = None
    horizons: Mapping[float, float]
    rungs: tuple[Rung, ...]
    time: Floats | None = None
    moved: Floats | None = None
    promised: int | None = None
    granted: float = ROUNDING

    @property
    def too_fast(self) -> bool:
        """Do steps draw together faster than the integrator can, so that they say nothing of a limit yet?"""
        if self.said is None or self.said.order is None or self.promised is None or self.said.moved <= self.granted:
            return False
        return self.said.order > self.promised + ABOVE

    @property
    def seen_until(self) -> float:
        """Up to there [s] the runs draw together, whatever their order says; 0 where they never do."""
        return self.said.until or 0.0 if self.said is not None and self.kind == "converges" else 0.0

    @property
    def until(self) -> float:
        """Up to there [s] the limit is known; 0 where it never is."""
        return 0.0 if self.too_fast else self.seen_until

    @property
    def finest(self) -> Rung | None:
        """The run of the smallest step that has an answer; None without any."""
        return next((rung for rung in reversed(self.rungs) if rung.run is not None), None)

    def farthest(self, scale: Extent) -> float:
        """How far the finest run takes a body from its start, as a share of the size; 0 without a run."""
        run = None if self.finest is None else self.finest.run
        return 0.0 if run is None else float(apart(run, _still(run), scale).max(initial=0.0))

    def bar_at(self, time: float) -> float:
        """The error bar up to a time [s]."""
        assert self.value is not None
        assert self.bar is not None
        return float(self.bar[place_of(self.value.time, time)])


def place_of(time: Floats, until: float) -> int:
    """The last sample of (t,) s that is not later."""
    return max(int(np.searchsorted(time, until + 1e-9)) - 1, 0)


def read_run(store: Store, trajectory_hash: str, dt: float) -> Trajectory:
    """The states of a run in a store."""
    arrays = store.trajectory(trajectory_hash, ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
    time, p_WB, q_WB, v_WB, w_WB = (arrays[name] for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
    return Trajectory(time, p_WB, q_WB, v_WB, w_WB, dt=dt)


def rungs_of(store: Store, runs: Sequence[Any]) -> list[Rung]:
    """The runs of one engine and track, as records or rows of the table of trials, from coarse to fine; each step once."""
    by_substep: dict[float, Rung] = {}
    for row in sorted(runs, key=lambda row: -float(row.dt)):
        answered = row.status in ANSWERED and isinstance(row.trajectory_hash, str)
        told_substep = row.substep is not None and row.substep == row.substep
        rung = Rung(
            dt=float(row.dt),
            substep=float(row.substep) if told_substep else float(row.dt),
            trial=str(row.trial),
            status=str(row.status),
            reason=str(row.reason),
            run=read_run(store, str(row.trajectory_hash), float(row.dt)) if answered else None,
            integrator=_integrator(row.resolved),
        )
        # An engine that cuts coarse steps into more sub-steps takes one step on two rungs, and says nothing new on the second.
        by_substep.setdefault(round(rung.substep, 15), rung)
    return sorted(by_substep.values(), key=lambda rung: -rung.substep)


def _integrator(resolved: Mapping[str, Any] | str) -> str:
    """The integrator of resolved settings, of a record or as JSON of a table."""
    settings = json.loads(resolved) if isinstance(resolved, str) else resolved
    return str(settings.get("integrator") or "")


def granted_of(scene: Scene, scale: Extent, *, touching: bool) -> float:
    """What limits may lie apart beyond their bars, as a share of the smallest size. Args: touching: does anything touch?"""
    soft = touching or Feature.CLOSED_LOOP in features_of(scene)
    return ROUNDING + (SOFT / float(scale.size.min(initial=np.inf)) if soft else 0.0)


def own_limit(
    scale: Extent, rungs: Sequence[Rung], orders: Mapping[str, int] | None = None, granted: float = ROUNDING
) -> OwnLimit:
    """The limit of one engine and track, of its runs from coarse to fine.

    Args: orders: that integrators promise, by name. granted: share of the size that two limits may lie apart.
    """
    whole = tuple(rungs)
    answered = [rung for rung in whole if rung.run is not None]
    if len(answered) < FEWEST or whole[-1].status == "diverged":
        return _without(whole, len(answered))
    runs = common([rung.run for rung in answered if rung.run is not None])
    steps, finest = [rung.substep for rung in answered], runs[-1]
    time = finest.time
    parted = np.array([apart(coarser, finer, scale) for coarser, finer in pairwise(runs)])
    moved = [offsets(run, finest, scale) for run in runs]
    extrapolated = limit(moved, [1 / step for step in steps], _round_off(finest, steps[-1], scale), length)
    converged = convergence(time, steps, parted, extrapolated.bar, TOLERANCE, granted)
    horizons = {
        rung.dt: horizon(time, np.maximum.accumulate(distance), TOLERANCE)
        for rung, distance in zip(answered, parted, strict=False)
    }
    last = np.maximum.accumulate(parted[-1])
    plain = OwnLimit(
        kind="converges", why=_silent(whole), said=converged, horizons=horizons, rungs=whole, time=time, moved=last,
        promised=(orders or {}).get(answered[-1].integrator), granted=granted,
    )  # fmt: skip
    lost = converged.until is None or (converged.ended != "end" and converged.until < _begins(finest, scale))
    if lost or (converged.ended == "no shrinking" and converged.regular < HALF):
        before, last_moved = float(parted[-2].max()), float(last[-1])
        why = f"halving the step again moves it by {last_moved:.2g} of its size, halving it before by {before:.2g}"
        return replace(plain, kind="does not converge", why=why)
    return replace(plain, value=displaced(finest, extrapolated.value, scale), bar=extrapolated.bar)


def _silent(rungs: Sequence[Rung]) -> str:
    """At which steps there is no answer, and what there is instead; '' where all have one."""
    lost: dict[str, list[float]] = {}
    for rung in rungs:
        if rung.run is None:
            lost.setdefault(rung.status, []).append(1e3 * rung.dt)
    return "; ".join(f"{status} at {', '.join(f'{dt:.3g}' for dt in steps)} ms" for status, steps in lost.items())


def _begins(run: Trajectory, scale: Extent) -> float:
    """When [s] something has first moved by the tolerance: up to there all answers are alike, whatever engine gives them."""
    return horizon(run.time, np.maximum.accumulate(apart(run, _still(run), scale)), TOLERANCE)


def _still(run: Trajectory) -> Trajectory:
    """A run that stays at the start of another."""
    still = Trajectory.of(run.time, run.p_WB.shape[1])
    still.p_WB[:], still.q_WB[:] = run.p_WB[0], run.q_WB[0]
    return still


def _round_off(run: Trajectory, step: float, scale: Extent) -> Floats:
    """What the arithmetic of all steps may have cost, (t,): each rounds a number as large as the farthest place once."""
    far = np.abs(run.p_WB[:, scale.bodies]).max(axis=(1, 2), initial=0.0) / scale.size.min(initial=np.inf)
    bound: Floats = (1.0 + run.time / step) * 2.0**-53 * np.maximum.accumulate(np.maximum(far, 1.0))
    return bound


def _without(rungs: tuple[Rung, ...], answered: int) -> OwnLimit:
    """Of a ladder that has no limit: too few answers, or none at its finest step."""
    last = rungs[-1] if rungs else None
    if last is None:
        return OwnLimit(kind="cannot", why="not run", horizons={}, rungs=rungs)
    lost = [rung for rung in rungs if rung.run is None]
    shown = last if last.run is None else lost[-1] if lost else last
    if shown.status == "diverged":
        at = "every step" if not answered else f"{len(lost)} of {len(rungs)} steps"
        return OwnLimit(kind="diverged", why=f"at {at}; at {1e3 * shown.dt:.3g} ms {shown.reason}", horizons={}, rungs=rungs)
    if shown.run is None:
        return OwnLimit(kind="cannot", why=f"{shown.status}: {shown.reason}", horizons={}, rungs=rungs)
    return OwnLimit(kind="cannot", why=f"{answered} steps answered, {FEWEST} are needed", horizons={}, rungs=rungs)
