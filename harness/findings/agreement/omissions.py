"""What the user left out of a robot, as a number: how far each engine that has it ends from where it ends without.

Both runs are of one engine at one step, so that what its step errs by is in both. They are compared up to where the engine's
own limit without it is known: beyond that any two runs lie apart.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.case.alteration import UNDROPPED
from plumbline.harness.findings.agreement.perturbed_starts import horizon_of
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.columns import Cell
from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
from plumbline.harness.search.own_limits import ANSWERED
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between

_NAMES = ("time", "p_WB", "q_WB")


@dataclass(frozen=True, slots=True, kw_only=True)
class Omission(Cell):
    """One engine with what was left out, against itself without.

    Terms:
        kinds: what was left out. dt [s]: the step of both runs, and the sub-steps that it was taken in. until [s]: up to there
        they are compared. position [m], angle [rad]: the largest of any body up to then; None where why says that there is
        none.
    """

    kinds: tuple[str, ...]
    dt: float
    substeps: int
    until: float
    position: float | None
    angle: float | None
    why: str


def omissions(store: Store, one: Agreement) -> list[Omission]:
    """One for each engine that was run with nothing dropped."""
    trials = store.trials
    mine = trials[(trials["case"] == one.case) & trials["alteration"].str.contains(f'"name": "{UNDROPPED}"', regex=False)]
    known = {(side.engine, side.track): side.limit.until for side in one.sides}
    found = []
    for row in mine.itertuples():
        if ("" if row.parameters == "{}" else row.parameters) != one.where:
            continue
        until = min(known.get((row.engine, row.track), 0.0), horizon_of(one))
        position, angle, why = _apart(store, row, until)
        found.append(
            Omission(
                case=one.case, where=one.where, engine=str(row.engine), track=str(row.track),
                kinds=tuple(json.loads(str(row.alteration))["undropped"]), dt=float(row.dt),
                substeps=substeps_of(str(row.resolved)), until=until, position=position, angle=angle, why=why,
            )
        )  # fmt: skip
    return found


def _apart(store: Store, whole: Any, until: float) -> tuple[float | None, float | None, str]:
    """Way [m] and angle [rad] between a run and the one without what was left out; or why there are none."""
    if whole.status not in ANSWERED:
        return None, None, f"{whole.status}: {whole.reason}"
    asked = store.asked
    same = [
        asked[name] == getattr(whole, name) for name in ("experiment", "case", "parameters", "engine", "track", "dt", "seed")
    ]
    plain = asked[np.logical_and.reduce(same) & asked["status"].isin(ANSWERED)]
    if plain.empty:
        return None, None, "no run without it at this step"
    if until <= 0.0:
        return None, None, "its answers without it do not draw together, so that any two runs lie apart"
    one, other = (store.trajectory(name, _NAMES) for name in (whole.trajectory_hash, plain["trajectory_hash"].iloc[0]))
    return *_farthest(one, other, until), ""


def _farthest(one: Mapping[str, Floats], other: Mapping[str, Floats], until: float) -> tuple[float, float]:
    """The largest way [m] and angle [rad] of any body between two runs up to a time [s]."""
    _, here, there = np.intersect1d(np.round(one["time"], 9), np.round(other["time"], 9), return_indices=True)
    within = one["time"][here] <= until + 1e-9
    here, there = here[within], there[within]
    way = np.linalg.norm(one["p_WB"][here] - other["p_WB"][there], axis=2)
    return float(way.max(initial=0.0)), float(angle_between(one["q_WB"][here], other["q_WB"][there]).max(initial=0.0))


def omission_words(found: Sequence[Omission], titles: Mapping[str, str]) -> list[str]:
    """'MuJoCo, tuned: what leaving out armature does is up to 0.12 m and 0.3 rad within 2 s (step 1/3840 s).'"""
    return [
        f"{titles.get(each.engine, each.engine)}, {each.track}: what leaving out {' and '.join(each.kinds)} does "
        + (
            f"is not known ({each.why})."
            if each.position is None
            else f"is up to {each.position:.3g} m and {each.angle:.3g} rad within {each.until:.3g} s (step "
            f"{step_in_words(each.dt, each.substeps)})."
        )
        for each in found
    ]
