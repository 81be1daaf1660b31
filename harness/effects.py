"""What a scene calls for, asked of the scene: each effect is left out once, and what that does to the motion is measured.

For each case on an engine there are the scene as it is; everything on, that is with every other effect of the engine present
so faintly that it changes nothing but the work; the scene without each of the effects that it declares; the scene with what it
declares to be off although its content has it, and with continuous collision where it has contacts but does not ask for it; and
the scene as it is at half the time step.

An effect matters where leaving it out (or taking it in) moves some body, at some sample, further than halving the time step
has moved any up to then, twice over and by more than `FLOOR`: what is smaller is lost in the error that the run has anyway. In
a chaotic scene both grow until neither says anything, which is why they are compared sample by sample and not at the end. An
effect also matters where a check that held breaks without it.

Declared effects that do not matter are a surplus, undeclared ones that do are missing: in both cases the scene fails its
audit, which is judged on the reference engine, the one that can switch everything off. A case may insist on an effect that its
own motion does not show, and says why.

Where several effects do not matter one by one, they are left out together, one more each time, as long as it makes no
difference: what remains is the minimal set, which is what is proposed for a scene of the user's own.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.adapter import Adapter
from harness.alteration import EVERYTHING, FINER, Alteration
from harness.case import Case
from harness.kinematics import angle_between
from harness.record import Record
from harness.scene import Effect
from harness.store import Store
from harness.study import Trial
from harness.trajectory import Floats

__all__ = ["FLOOR", "Consequence", "compared", "matters", "next_trials", "told_apart", "weighed"]

FLOOR = 1e-9
"""Metres and radians: what rounding makes of metres within some ten thousand steps."""
TWICE = 2.0
ANSWERED = ("passed", "failed")


@dataclass(frozen=True, slots=True)
class Consequence:
    """What a departure does.

    Terms:
        moved: how far it moves a body [m, rad], at the sample that says most. own: what halving the time step has done up to
        there. matters: is that more than the run's own error, or does a check break that held?
    """

    moved: float
    own: float
    matters: bool


def compared(plain: Mapping[str, Any], other: Mapping[str, Any], finer: Mapping[str, Any] | None) -> Consequence:
    """The consequence of a departure, from trajectories as a run folder keeps them; without a finer run the error is 0."""
    moved = apart(plain, other)
    own = np.zeros_like(moved) if finer is None else np.fmax.accumulate(apart(plain, finer))
    known = np.flatnonzero(~np.isnan(moved) & ~np.isnan(own))
    if len(known) == 0:
        return Consequence(0.0, 0.0, matters=False)
    beyond = known[moved[known] > np.maximum(TWICE * own[known], FLOOR)]
    shown = beyond if len(beyond) else known
    place = shown[np.argmax(moved[shown])]
    return Consequence(float(moved[place]), float(own[place]), matters=len(beyond) > 0)


def apart(one: Mapping[str, Any], other: Mapping[str, Any]) -> Floats:
    """The greatest distance [m] or angle [rad] of any body between two runs at each sample of the first, (t,).

    NaN where the other has no sample; a run that ended early is infinitely far off from there on.
    """
    found = np.full(len(one["time"]), np.nan)
    _, here, there = np.intersect1d(np.round(one["time"], 9), np.round(other["time"], 9), return_indices=True)
    way = np.linalg.norm(one["p_WB"][here] - other["p_WB"][there], axis=2).max(axis=1, initial=0.0)
    turn = angle_between(one["q_WB"][here], other["q_WB"][there]).max(axis=1, initial=0.0)
    found[here] = np.where(np.isfinite(way) & np.isfinite(turn), np.maximum(way, turn), np.inf)
    if len(other["time"]):
        found[one["time"] > other["time"][-1] + 1e-9] = np.inf
    return found


def matters(store: Store, plain: Any, other: Any, finer: Any) -> Consequence | None:
    """The consequence of a departure, of records or rows of the table of trials; None where a run gave no answer to compare."""
    if plain is None or other is None or plain.status not in ANSWERED:
        return None
    if other.status not in (*ANSWERED, "diverged"):
        return None
    if other.status == "diverged":
        return Consequence(float("inf"), 0.0, matters=True)
    best = finer if finer is not None and finer.status in ANSWERED else None
    names = "time", "p_WB", "q_WB"
    runs = [store.trajectory(run.trajectory_hash, names) if run is not None else None for run in (plain, other, best)]
    assert runs[0] is not None
    assert runs[1] is not None
    found = compared(runs[0], runs[1], runs[2])
    flips = plain.status == "passed" and other.status == "failed"
    return replace(found, matters=found.matters or flips)


def weighed(name: str, found: Consequence | None, plain: Any, run: Any, declared: Collection[str]) -> Consequence | None:
    """The consequence of the departure `name` from a scene that declares these effects, where motion is not what counts.

    Gravity that presses bodies together shows in forces. Continuous collision is a means to an end: it is missing where it
    mends a check, since where within a step a contact is found moves everything a little.
    """
    if found is None:
        return None
    if name == "without gravity" and "contact" in declared:
        return replace(found, matters=True)
    if name == "with continuous_collision":
        return replace(found, matters=plain.status == "failed" and run.status == "passed")
    return found


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
    found = []
    for group in groups.values():
        # Groups of several time steps are told apart by the step of what is as it is.
        for plain in (trial for trial in group if not trial.alteration.name):
            more = _dropping(plain, group, records, cases[plain.case], store)
            found += [] if more is None else [more]
    return found


def _dropping(plain: Trial, group: Sequence[Trial], records: Mapping[str, Record], case: Case, store: Store) -> Trial | None:
    same = [trial for trial in group if trial.settings.dt in (plain.settings.dt, plain.settings.dt / 2)]
    known = {trial.alteration.name: records.get(trial.trial) for trial in same if trial.settings.dt == plain.settings.dt}
    finer = next((records.get(trial.trial) for trial in same if trial.alteration.name == FINER), None)
    here = records.get(plain.trial)

    def idle(*effects: str) -> bool | None:
        name = f"without {', '.join(effects)}"
        if name not in known:
            return None
        found = weighed(name, matters(store, here, known[name], finer), here, known[name], declared)
        return found is not None and not found.matters

    declared = case.scene(**plain.parameters).effects.names
    single = [one for one in declared if one not in case.insists and idle(one)]
    dropped = single[:1]
    for one in single[1:]:
        verdict = idle(*dropped, one)
        if verdict is None:
            narrow = Effect.NONE
            for name in (*dropped, one):
                narrow |= Effect[name.upper()]
            told = Alteration(name=f"without {', '.join((*dropped, one))}", narrow=narrow)
            return plain.probing(case, alteration=told, round=max(trial.round for trial in group) + 1)
        if verdict:
            dropped.append(one)
    return None


def told_apart(name: str) -> tuple[str, ...]:
    """The effects that an alteration's name leaves out or takes in; none for the scene as it is and for everything on."""
    if name in ("", EVERYTHING, FINER):
        return ()
    return tuple(name.partition(" ")[2].split(", "))
