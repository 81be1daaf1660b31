"""What a scene calls for, asked of the scene: each effect is left out once, and what that does to the motion is measured.

For each case on an engine there are the scene as it is; everything on, that is with every other effect of the engine present
so faintly that it changes nothing but the work; the scene without each of the effects that it declares; the scene with what it
declares to be off although its content has it, and with continuous collision where it has contacts but does not ask for it; and
the scene as it is at half the time step and at half of that.

An effect matters where leaving it out (or taking it in) moves some body, at some sample, further than halving the time step
has moved any up to then, twice over and by more than `FLOOR`: what is smaller is lost in the error that the run has anyway.
Machines differ in rounding, and a contact that one of them finds a step later may move such a figure by half: what lies within
a factor of `MARGIN` of that bar is not judged. In
a chaotic scene both grow until neither says anything, which is why they are compared sample by sample and not at the end. An
effect also matters where a check that held breaks without it.

An engine that is itself wrong says nothing of what a scene needs. Where the truth of the case is a motion, the answer of an
engine that passes its checks counts at the samples at which it is near that truth (`scale_by_truth`). Elsewhere at those at
which it has converged: up to then halving the step again has moved bodies by less than halving it once did, and neither by
more than `SMALL` of what the scene's effects move them by. That an effect matters takes one such sample; that it does not
takes the last one. Elsewhere nothing is said.

Declared effects that do not matter are a surplus, undeclared ones that do are missing: in both cases the scene fails its
audit, which truths judge, or at least two engines that agree (`harness.findings.effects_audit`). A case may insist on an effect
that its own motion does not show, and says why.

Where several effects do not matter one by one, they are left out together, one more each time, as long as it makes no
difference: what remains is the minimal set, which is what is proposed for a scene of the user's own.
"""

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import FINER, FINEST, REFINED, Alteration
from plumbline.harness.scene import Effect
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between

FLOOR = 1e-9
"""Metres and radians: what rounding makes of metres within some ten thousand steps."""
TWICE = 2.0
MARGIN = 2.0
"""Factor about the bar within which nothing is said, since another machine may say the opposite."""
SHRUNK = 0.75
"""Of what halving the step does, the share that halving it again may do: half in the first order, and half as much again for a
contact that falls elsewhere within its step."""
SMALL = 0.1
"""Of what the scene's effects do, the share that halving the step may do: an error as large as an effect hides it."""
ANSWERED = ("passed", "failed")
MOTIONS = ("closed form", "converged reference", "rest")
"""Kinds of truths of cases that may be a motion."""


@dataclass(frozen=True, slots=True)
class Consequence:
    """What a departure does.

    Terms:
        moved: how far it moves a body [m, rad], at the sample that says most. own: what halving the time step has done up to
        there. matters: is that more than the run's own error, or does a check break that held? None where the engine has not
        converged enough to say so, or `near` where it has and both are too near to each other.
    """

    moved: float
    own: float
    matters: bool | None
    near: bool = False

    def doubt(self, scale: "Scale") -> str:
        """Why it is not known whether it matters; nothing where it is."""
        if self.matters is not None:
            return ""
        if not self.near:
            return scale.doubt
        error = "it is off the truth" if scale.by_truth else "halving the step does"
        return (
            f"moves a body by {self.moved:.2g} m or rad, within a factor of {MARGIN:g} of the bar, {TWICE:g} times the "
            f"{self.own:.2g} that {error}"
        )


@dataclass(frozen=True, slots=True)
class Scale:
    """What the motion of a scene on an engine is measured by, at each sample of the scene as it is, (t,).

    Terms:
        own: the farthest [m, rad] that halving the time step has moved a body up to there; again: that halving it once more
        has; both NaN without such a run. effects: that leaving out or taking in any one effect has. by_truth: is `own` how far
        the engine is from the truth of the case, in place of a finer step? Then nothing has to shrink, and `again` is 0.
    """

    own: Floats
    again: Floats
    effects: Floats
    by_truth: bool = False

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Where the engine's own error shrinks with the step, or is known, and is small beside what effects do."""
        shrinks = (self.again <= SHRUNK * self.own) & (self.own <= SMALL * self.effects)
        return np.asarray((np.fmax(self.own, self.again) <= FLOOR) & ~np.isnan(self.own + self.again) | shrinks)

    @property
    def doubt(self) -> str:
        """Why the engine is not believed at the end of the run; nothing where it is."""
        known = np.flatnonzero(~np.isnan(self.own + self.again))
        if len(known) == 0:
            return "no answer at half and at a quarter of the step"
        last = known[-1]
        if self.converged[last]:
            return ""
        if self.by_truth:
            own, most = self.own[last], self.effects[last]
            return f"is {own:.2g} m or rad off the truth, where any effect moves a body by {most:.2g} at most"
        return (
            f"has not converged: halving the step moves a body by {self.own[last]:.2g} m or rad, halving it again by "
            f"{self.again[last]:.2g}, any effect by {self.effects[last]:.2g} at most"
        )


def scale_of(
    plain: Mapping[str, Any],
    finer: Mapping[str, Any] | None,
    finest: Mapping[str, Any] | None,
    others: Iterable[Mapping[str, Any]],
) -> Scale:
    """The scale of a scene, from trajectories as a run folder keeps them: as it is, at half and a quarter of the step, and
    under single departures."""
    blank = np.full(len(plain["time"]), np.nan)
    own = blank if finer is None else np.fmax.accumulate(apart(plain, finer))
    again = blank if finer is None or finest is None else np.fmax.accumulate(_at(finer, apart(finer, finest), plain))
    effects = np.zeros(len(blank))
    for other in others:
        moved = apart(plain, other)
        effects = np.fmax(effects, np.where(np.isfinite(moved), moved, 0.0))
    return Scale(own, again, np.maximum.accumulate(effects))


def _at(run: Mapping[str, Any], values: Floats, other: Mapping[str, Any]) -> Floats:
    """Values at the samples of a run, as values at those of another one; NaN where the run has none."""
    resampled = np.full(len(other["time"]), np.nan)
    _, here, there = np.intersect1d(np.round(other["time"], 9), np.round(run["time"], 9), return_indices=True)
    resampled[here] = values[there]
    return resampled


def compared(plain: Mapping[str, Any], other: Mapping[str, Any], scale: Scale) -> Consequence:
    """The consequence of a departure, from trajectories as a run folder keeps them."""
    moved = apart(plain, other)
    known = np.flatnonzero(~np.isnan(moved) & ~np.isnan(scale.own))
    if len(known) == 0:
        return Consequence(float(np.fmax.reduce(moved, initial=0.0)), float("nan"), matters=None)
    over = moved[known] / np.maximum(TWICE * scale.own[known], FLOOR)
    beyond, near = known[over > MARGIN], known[over > 1 / MARGIN]
    believed = beyond[scale.converged[beyond]]
    shown = next((samples for samples in (believed, beyond, near) if len(samples)), known)
    sample = shown[np.argmax(moved[shown])]
    converged = bool(scale.converged[known[-1]])
    matters = True if len(believed) else None if len(near) or not converged else False
    return Consequence(
        float(moved[sample]), float(scale.own[sample]), matters=matters, near=converged and not len(beyond) and bool(len(near))
    )


def apart(first: Mapping[str, Any], second: Mapping[str, Any]) -> Floats:
    """The greatest distance [m] or angle [rad] of any body between two runs at each sample of the first, (t,).

    NaN where the other has no sample; a run that ended early is infinitely far off from there on.
    """
    distance = np.full(len(first["time"]), np.nan)
    _, here, there = np.intersect1d(np.round(first["time"], 9), np.round(second["time"], 9), return_indices=True)
    way = np.linalg.norm(first["p_WB"][here] - second["p_WB"][there], axis=2).max(axis=1, initial=0.0)
    turn = angle_between(first["q_WB"][here], second["q_WB"][there]).max(axis=1, initial=0.0)
    distance[here] = np.where(np.isfinite(way) & np.isfinite(turn), np.maximum(way, turn), np.inf)
    if len(second["time"]):
        distance[first["time"] > second["time"][-1] + 1e-9] = np.inf
    return distance


NAMES = ("time", "p_WB", "q_WB")


def scale_in(store: Store, runs: Mapping[str, Any]) -> Scale | None:
    """The scale of a scene from its runs by the name of their departure, as records or rows of the table of trials; None where
    the scene as it is has no answer."""
    if (plain := runs.get("")) is None or plain.status not in ANSWERED:
        return None
    here = store.trajectory(plain.trajectory_hash, NAMES)
    return scale_of(here, _read(store, runs.get(FINER)), _read(store, runs.get(FINEST)), _single(store, runs))


def scale_by_truth(store: Store, runs: Mapping[str, Any]) -> Scale | None:
    """The same where the truth of the case takes the place of finer steps; None where it has no motion as its truth, or the
    engine misses a check of the scene as it is."""
    if (plain := runs.get("")) is None or plain.status != "passed":
        return None
    if store.described("cases", plain.case)["truth"] not in MOTIONS:
        return None
    plain_run = store.trajectory(plain.trajectory_hash)
    if not all(f"truth_{name}" in plain_run for name in NAMES):
        return None
    scale = scale_of(plain_run, {name: plain_run[f"truth_{name}"] for name in NAMES}, None, _single(store, runs))
    return replace(scale, again=np.where(np.isnan(scale.own), np.nan, 0.0), by_truth=True)


def _read(store: Store, run: Any) -> Mapping[str, Any] | None:
    return store.trajectory(run.trajectory_hash, NAMES) if run is not None and run.status in ANSWERED else None


def _single(store: Store, runs: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """The trajectories of departures in one effect."""
    single = (_read(store, run) for run in runs.values() if run is not None and len(departure(run).single.names) == 1)
    return (run for run in single if run is not None)


def matters(store: Store, plain: Any, other: Any, scale: Scale | None) -> Consequence | None:
    """The consequence of a departure, of records or rows of the table of trials; None where a run gave no answer to compare."""
    if plain is None or other is None or plain.status not in ANSWERED or scale is None:
        return None
    if other.status not in (*ANSWERED, "diverged"):
        return None
    if other.status == "diverged":
        return Consequence(float("inf"), 0.0, matters=True if scale.converged.any() else None)
    here, there = (store.trajectory(run.trajectory_hash, NAMES) for run in (plain, other))
    consequence = compared(here, there, scale)
    flips = plain.status == "passed" and other.status == "failed"
    return replace(consequence, matters=True) if flips else consequence


def departure(run: Any) -> Alteration:
    """What a run departed in, of a record or a row of the table of trials."""
    alteration = run.alteration
    return Alteration.from_plain(json.loads(alteration) if isinstance(alteration, str) else alteration)


def weighed(
    departed: Alteration, consequence: Consequence | None, plain: Any, run: Any, declared: Collection[str]
) -> Consequence | None:
    """The consequence of a departure from a scene that declares these effects, where motion is not what counts.

    Gravity that presses bodies together shows in forces. Continuous collision is a means to an end: it is missing where it
    mends a check, since where within a step a contact is found moves everything a little. What is off, and changes nothing
    where it is on, is no gap, whoever says so: nothing is proposed by that.
    """
    if consequence is None:
        return None
    if departed.narrow == Effect.GRAVITY and "contact" in declared:
        return replace(consequence, matters=True)
    if departed.widen == Effect.CONTINUOUS_COLLISION:
        return replace(consequence, matters=plain.status == "failed" and run.status == "passed")
    if departed.widen and consequence.matters is None and consequence.moved <= FLOOR:
        return replace(consequence, matters=False)
    return consequence


def next_trials(
    trials: Sequence[Trial],
    records: Mapping[str, Record],
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],  # noqa: ARG001 -- all searches are called alike
    *,
    store: Store,
) -> list[Trial]:
    """The next round of leaving out together what does not matter one by one; empty where every minimal set is known."""
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.experiment.effects:
            name = (trial.experiment.name, trial.case, dict(trial.parameters), trial.engine, trial.track, trial.seed)
            groups.setdefault(repr(name), []).append(trial)
    probes = []
    for group in groups.values():
        # Groups of several time steps are told apart by the step of what is as it is.
        for plain in (trial for trial in group if not trial.alteration.name):
            more = _dropping(plain, group, records, cases[plain.case], store)
            probes += [] if more is None else [more]
    return probes


def _dropping(plain: Trial, group: Sequence[Trial], records: Mapping[str, Record], case: Case, store: Store) -> Trial | None:
    # Of several time steps, what stands at this one, and at the parts of it.
    known = {
        trial.alteration.name: records.get(trial.trial)
        for trial in group
        if trial.settings.dt == plain.settings.dt / REFINED.get(trial.alteration.name, 1)
    }
    here, scale = known.get(""), scale_in(store, known)

    def idle(*effects: str) -> bool | None:
        name = f"without {', '.join(effects)}"
        if name not in known:
            return None
        run = known[name]
        consequence = None if run is None else weighed(departure(run), matters(store, here, run, scale), here, run, declared)
        return consequence is not None and consequence.matters is False

    declared = case.scene(case.at(**plain.parameters)).effects.names
    single = [effect for effect in declared if effect not in case.insists and idle(effect)]
    dropped = single[:1]
    for effect in single[1:]:
        verdict = idle(*dropped, effect)
        if verdict is None:
            narrow = Effect.NONE
            for name in (*dropped, effect):
                narrow |= Effect[name.upper()]
            alteration = Alteration(name=f"without {', '.join((*dropped, effect))}", narrow=narrow)
            return plain.probing(case, alteration=alteration, round=max(trial.round for trial in group) + 1)
        if verdict:
            dropped.append(effect)
    return None
