"""Why a standing machine trembles: the cause that each engine's runs can prove, from one change at a time.

A base is a run on a track, or on a variant that changes no other one, at the study's coarsest step. Beside it stand runs
that differ in one thing alone:

    iterations   a variant of which the study says so: more sweeps or steps of the solver
    law          another one: the same drives, taken implicitly instead of explicitly or the other way round
    softer       the next lower stiffness of the drives
    step         the next shorter step
    product      that step with drives so much stiffer that k dt^2 stays, and with the damping ratio d dt

A run trembles where its vibration exceeds the bound of the case at the base's step; what diverged or fell (a hinge more than
half a radian off) trembles without bound. A change heals where the vibration falls to a tenth, or under the bound and to a
third; it does not where it stays above a third; between the two it is unclear. The rule:

    still                                 none (still)
    iterations alone heal                 iterations
    softer and step heal, product not     drives: too stiff for the step, since k dt^2 alone decides
    law heals                             drives: the way in which they are taken fights the contacts
    softer heals, step not                drives: they fight the contacts, whatever the step
    step heals, softer not                time step
    all else                              not separated

Below the first two lines iterations must not heal; what was not run heals nothing, and proves nothing where it has to stay.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, TypeAlias

from plumbline.harness.findings.columns import Column, Table, plain
from plumbline.harness.findings.parameter_words import step_in_words, substeps_taken
from plumbline.harness.store.rows import finite, number
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import departures_of

CAUSES = ("iterations", "drives", "time step", "none (still)", "not separated")
CHANGES = ("iterations", "law", "softer", "step", "product")
FALLEN = 0.5
"""Pose error [rad] from which a machine no longer stands."""
HEALED, SAME = 10.0, 3.0
"""How many times smaller a vibration is that is healed, and how many times at most one that is not."""


_Key: TypeAlias = tuple[str, str, str, float, float]
"""Case, engine, track, stiffness and step of a run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrembleRun:
    """A run: vibration [rad/s], infinite where it fell or diverged; frequency [Hz]; the case's bound [rad/s]; its name."""

    vibration: float
    frequency: float
    bound: float
    trial: str = ""


@dataclass(frozen=True, slots=True)
class Tremble:
    """What one engine's base shows.

    Terms: stiffness in the case's own unit; dt [s], taken in substeps; shares: by
    change, how many times smaller the vibration became; cause: one
    of CAUSES; why: the rule that gave it.
    """

    case: str
    engine: str
    track: str
    stiffness: float
    dt: float
    base: TrembleRun
    shares: Mapping[str, float]
    cause: str
    why: str
    substeps: int = 1

    @property
    def vibration(self) -> float | None:
        """Of the base; None without bound."""
        return finite(self.base.vibration)

    @property
    def frequency(self) -> float | None:
        """Of the base; None where it has none."""
        return finite(self.base.frequency)

    @property
    def changed(self) -> Mapping[str, float]:
        """How many times smaller each change that was run made the vibration, `CURED` where it was without bound."""
        return {name: min(share, CURED) for name, share in self.shares.items()}

    @property
    def falls(self) -> bool:
        """Does the machine not stand at all?"""
        return math.isinf(self.base.vibration)


def _share(base: TrembleRun, changed: TrembleRun) -> float:
    if math.isinf(changed.vibration):
        return 1.0 if math.isinf(base.vibration) else 0.0
    return base.vibration / changed.vibration if changed.vibration > 0 else math.inf


def attribute(base: TrembleRun, changes: Mapping[str, TrembleRun]) -> tuple[Mapping[str, float], str, str]:
    """How many times smaller each change made the vibration, the cause, and the rule that gave it.

    Args: changes: runs by the names of CHANGES; those that an engine cannot make are left out.
    """
    shares = {name: _share(base, changes[name]) for name in CHANGES if name in changes}
    if base.vibration <= base.bound:
        return shares, "none (still)", "its vibration stays under the bound"

    def heals(name: str) -> bool:
        share = shares.get(name, 0.0)
        return share >= HEALED or (share >= SAME and changes[name].vibration <= base.bound)

    def stays(name: str) -> bool:
        return shares.get(name, 0.0) < SAME

    if stays("iterations"):
        if heals("softer") and heals("step") and "product" in shares and stays("product"):
            return shares, "drives", "too stiff for the step: softer or shorter heals it, both at one k dt^2 do not"
        if heals("law"):
            return shares, "drives", "by another law the same drives stand still: their law fights the contacts"
        if heals("softer") and "step" in shares and stays("step"):
            return shares, "drives", "softer drives heal it and a shorter step does not: they fight the contacts"
        if heals("step") and "softer" in shares and stays("softer"):
            return shares, "time step", "a shorter step alone heals it"
    elif heals("iterations") and {"softer", "step"} <= shares.keys() and all(map(stays, ("law", "softer", "step"))):
        return shares, "iterations", "more iterations alone heal it"
    healing = [name for name in CHANGES if heals(name)]
    return shares, "not separated", f"healed by {', '.join(healing) or 'none of the changes'}"


def _runs(store: Store) -> Iterator[tuple[dict[str, Any], float, TrembleRun]]:
    """Each trial that has a stiffness and was asked for its vibration, with that stiffness."""
    asked = {
        name
        for name, case in store.catalogue.get("cases", {}).items()
        if any(check["metric"] == "vibration_rms" for check in case.get("checks", ()))
    }
    trials = store.trials[store.trials["case"].isin(asked)]
    values: dict[str, dict[str, Any]] = {}
    for measurement in store.measurements[store.measurements["trial"].isin(trials["trial"])].to_dict("records"):
        values.setdefault(measurement["trial"], {}).setdefault(measurement["metric"], measurement)
    for row in trials.to_dict("records"):
        stiffness = json.loads(row["parameters"]).get("stiffness")
        if stiffness is None or row["status"] not in ("passed", "failed", "diverged"):
            continue
        mine = values.get(row["trial"], {})
        fallen = row["status"] == "diverged" or not mine.get("pose_error_max", {}).get("value", 0.0) <= FALLEN
        vibration = mine.get("vibration_rms", {})
        size = float(vibration.get("value", math.nan))
        lost = fallen or not math.isfinite(size)
        bound = number(vibration.get("at_most"))
        yield (
            row,
            float(stiffness),
            TrembleRun(
                vibration=math.inf if lost else size,
                frequency=float(mine.get("vibration_frequency", {}).get("value", math.nan)),
                bound=bound if math.isfinite(bound) else _bound(store, row),
                trial=row["trial"],
            ),
        )


def _bound(store: Store, row: Mapping[str, Any]) -> float:
    """The case's bound [rad/s] for a run that recorded none, scaled from the catalogue's to the step that it took."""
    about = store.described("cases", row["case"])
    check = next(check for check in about["checks"] if check["metric"] == "vibration_rms")
    taken = number(row.get("substep"))
    return float(check["at_most"]) * (taken if math.isfinite(taken) else float(row["dt"])) / float(about["dt"])


def findings(store: Store) -> tuple[Tremble, ...]:
    """All bases of a run folder that have a softer run to be compared with, engine by engine."""
    runs = {
        (row["case"], row["engine"], row["track"], stiffness, float(row["dt"])): run for row, stiffness, run in _runs(store)
    }
    departures = departures_of(store)
    variants = {(engine, to.beside, to.changes): name for (engine, name), to in departures.items()}
    made = []
    for key, run in runs.items():
        case, engine, track, _, dt = key
        if (engine, track) in departures or store.bases[run.trial] != track:
            continue  # what was changed in another one is no base
        together = {other: peer for other, peer in runs.items() if other[0] == case}
        changes = _changes(together, key, variants)
        # The softest of a series is there to be compared with, and so is every finer step.
        if dt < max(other[-1] for other in together) or "softer" not in changes:
            continue
        made.append(Tremble(*key, run, *attribute(run, changes), substeps=substeps_taken(store).get(run.trial, 1)))
    return tuple(sorted(made, key=attrgetter("case", "engine", "track", "stiffness")))


def _changes(
    runs: Mapping[_Key, TrembleRun], base: _Key, variants: Mapping[tuple[str, str, str], str]
) -> dict[str, TrembleRun]:
    """The runs that differ from a base in one thing. Args: variants: by engine, track and change."""
    case, engine, track, stiffness, dt = base
    changes = {}
    for name in ("iterations", "law"):
        changed = (case, engine, variants.get((engine, track, name), ""), stiffness, dt)
        if changed in runs:
            changes[name] = runs[changed]
    mine = {(k, h): run for (a, b, c, k, h), run in runs.items() if (a, b, c) == (case, engine, track)}
    softer = [k for k, h in mine if h == dt and k < stiffness]
    if softer:
        changes["softer"] = mine[max(softer), dt]
    shorter = [h for k, h in mine if h < dt and k == stiffness]
    if shorter:
        h = max(shorter)
        changes["step"] = mine[stiffness, h]
        stiffer = [k for k, other in mine if other == h and math.isclose(k * h * h, stiffness * dt * dt, rel_tol=1e-9)]
        if stiffer:
            changes["product"] = mine[stiffer[0], h]
    return changes


CURED = 1e99
"""How many times smaller a vibration is said to be where it was without bound."""


def _share_of(change: str) -> Column:
    """How many times smaller a change made the vibration."""

    def cell(base: Tremble) -> str:
        share = base.changed.get(change)
        return "" if share is None else "stands" if share >= CURED else f"{share:.3g}x"

    return Column(change, cell)


TABLE = Table(
    holds="case engine track stiffness dt substeps vibration_rad_s=vibration frequency_hz=frequency bound_rad_s=base.bound "
    f"{' '.join(f'{name}=changed.{name}' for name in CHANGES)} cause why trial=base.trial",
    objects=findings,
    shown=(
        *plain("engine", "setting=track", "stiffness=stiffness:g"),
        Column("dt", lambda base: step_in_words(base.dt, base.substeps)),
        Column("vibration", lambda base: "falls" if base.falls else f"{base.base.vibration:.2g} rad/s"),
        Column("at", "frequency", ".3g", " Hz"),
        *map(_share_of, CHANGES),
        *plain("cause", "why"),
    ),
)
