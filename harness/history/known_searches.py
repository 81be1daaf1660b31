"""Where earlier nights' searches ended: fronts that are clocked again, and brackets that are tried at their ends.

A front is searched anew where it errs otherwise than it did; a limit, where its bracket no longer holds and breaks: then the
search, which finds the ends among its values, goes on by itself.
"""

import json
import math
import random
from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from plumbline.harness.adapter import Settings
from plumbline.harness.case import Case
from plumbline.harness.history.blocks import Key, Seen
from plumbline.harness.history.folder import Pool
from plumbline.harness.search.first_break import bracket, ruler
from plumbline.harness.search.front import SMALLEST, TELLING
from plumbline.harness.statistics.pareto import on_front
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study.trial import Trial

BESIDE = 2
"""Settings of an engine that are clocked beside a front, drawn anew each night."""
Setting: TypeAlias = tuple[str, float]
"""Track, with what a search turned in it, and time step [s]."""
Group: TypeAlias = tuple[str, str, str, str]
"""Experiment, case, parameters, engine: one search of a front."""
Front: TypeAlias = tuple[Mapping[Setting, float], tuple[Setting, ...]]
"""A front as the last night that saw it clocked it: errors of its settings, as shares of the scale; and the other settings."""


class KnownSearches:
    """What earlier nights answered and found, each read once, when it is wanted. Terms: seen: the last night of each block.
    seed: of what is drawn at random."""

    def __init__(self, seen: Mapping[Key, Seen], cases: Mapping[str, Case], pool: Pool, seed: str) -> None:
        self.seen, self.cases, self.pool, self.seed = seen, cases, pool, seed
        self._stores, self._answers = dict[str, Store](), dict[str, dict[Hashable, Any]]()
        self._fronts = dict[Group, Front | None]()

    def last_answer(self, trial: Trial) -> Any:
        """What was answered the last time, whatever it rested on: a row of the table `trials`; None where nobody asked this
        before. Raises: StoreError."""
        if (store := self._store(trial)) is None:
            return None
        if store.folder.name not in self._answers:
            self._answers[store.folder.name] = {_question(row): row for row in store.trials.itertuples()}
        question = (trial.engine, trial.track, trial.settings.dt, trial.seed, trial.members, trial.parts, trial.remedy)
        plain = json.dumps(trial.alteration.plain(), sort_keys=True), _parameters(trial)
        return self._answers[store.folder.name].get((trial.experiment.name, trial.case, *question, *plain))

    def beside(self, trials: Sequence[Trial]) -> list[Trial]:
        """What is asked beside the trials of a study so that the searches begin where they ended: all that is in the pool
        under today's name, and where it is not, the settings of a front with a few others, and both ends of a bracket."""
        named, groups, made = {trial.trial for trial in trials}, set[Group](), dict[str, Trial]()
        for trial in trials:
            more: Iterator[Trial] = iter(())
            if trial.experiment.limit is not None and trial.round == 0:
                more = self._of_limit(trial)
            elif trial.experiment.sweep and group_of(trial) not in groups:
                groups.add(group_of(trial))
                more = self._of_front(trial)
            for other in more:
                if other.trial not in named:
                    made.setdefault(other.trial, other)
        return list(made.values())

    def goes_on(self, trial: Trial, records: Mapping[str, Record]) -> bool:
        """Is a front searched anew: is none known, or does it err otherwise now?"""
        front = self.front_of(trial)
        if front is None:
            return True
        cell = trial.experiment.name, trial.case, trial.engine
        near = (r for r in records.values() if (r.experiment, r.case, r.engine) == cell)
        now = {(r.track, r.dt): r for r in near if json.dumps(dict(r.parameters), sort_keys=True) == _parameters(trial)}
        return not all(self._as_before(now.get(setting), error) for setting, error in front[0].items())

    def clocked(self, trials: Sequence[Trial]) -> set[str]:
        """Of swept trials that are due for the clock: the known front, both tracks at the case's own step, a few others."""
        chosen, groups = list[Trial](), dict[Group, list[Trial]]()
        for trial in trials:
            groups.setdefault(group_of(trial), []).append(trial)
        for group, mine in groups.items():
            if (front := self.front_of(mine[0])) is None:
                chosen += mine
                continue
            own = self.cases[mine[0].case].dt
            wanted = [t for t in mine if (t.track, t.settings.dt) in front[0] or (t.round == 0 and t.settings.dt == own)]
            chosen += wanted + self._drawn(group, [t for t in mine if t not in wanted])
        return {trial.trial for trial in chosen}

    def front_of(self, trial: Trial) -> Front | None:
        """The known front of a trial's case on its engine; None where none is known."""
        group = group_of(trial)
        if group not in self._fronts:
            self._fronts[group] = self._read_front(trial)
        return self._fronts[group]

    def _drawn(self, group: Group, rest: Sequence[Any]) -> list[Any]:
        """A few of these at random."""
        return random.Random(f"{self.seed} {group}").sample(rest, min(BESIDE, len(rest)))

    def _store(self, trial: Trial) -> Store | None:
        """The last night that did all of a trial's block on its engine, with the blocks that no later one did; None where none
        did. Raises: StoreError."""
        if (known := self.seen.get((trial.experiment.name, trial.case))) is None:
            return None
        night = known.night_of(trial.engine)
        if night.stamp not in self._stores:
            self._stores[night.stamp] = night.store({key for key, known in self.seen.items() if night in known.nights})
        return self._stores[night.stamp]

    def _rows(self, trial: Trial) -> list[dict[str, Any]]:
        """What the last night that saw a trial's block has of its engine."""
        if (store := self._store(trial)) is None:
            return []
        table, bases = store.trials, store.bases
        mine = table[
            (table["experiment"] == trial.experiment.name) & (table["case"] == trial.case) & (table["engine"] == trial.engine)
        ]
        return [{**row, "base": bases[row["trial"]]} for row in mine.to_dict("records")]

    def _read_front(self, trial: Trial) -> Front | None:
        if (store := self._store(trial)) is None:
            return None
        case, table = self.cases[trial.case], store.measurements
        errors = {row.trial: abs(float(row.value)) for row in table[table["metric"] == case.headline].itertuples()}
        clocked = [
            ((str(row["track"]), float(row["dt"])), max(error / case.scale, SMALLEST), float(row["cpu_per_unit"]))
            for row in self._rows(trial)
            if row["parameters"] == _parameters(trial)
            and row["cpu_per_unit"] == row["cpu_per_unit"]
            and math.isfinite(error := errors.get(row["trial"], math.nan))
        ]
        if not clocked:
            return None
        settings, of_settings, costs = zip(*clocked, strict=True)
        first = on_front(of_settings, costs)
        errors_of_first = {s: error for s, error, best in zip(settings, of_settings, first, strict=True) if best}
        return errors_of_first, tuple(s for s, best in zip(settings, first, strict=True) if not best)

    def _as_before(self, record: Record | None, error: float) -> bool:
        if record is None or record.status not in ("passed", "failed"):
            return False
        case = self.cases[record.case]
        now = next((abs(m.value) for m in record.measurements if m.metric == case.headline), math.nan) / case.scale
        return max(now, SMALLEST) / error < TELLING and error / max(now, SMALLEST) < TELLING

    def _of_front(self, trial: Trial) -> Iterator[Trial]:
        if (front := self.front_of(trial)) is None:
            return
        errors, others = front
        near = {*errors, *self._drawn(group_of(trial), others)}
        for row in self._rows(trial):
            if row["parameters"] != _parameters(trial) or row["round"] == 0:
                continue
            other = trial.probing(
                self.cases[trial.case],
                track=row["track"],
                base=row["base"],
                settings=Settings(**json.loads(row["settings"])),
                round=int(row["round"]),
            )
            if self.pool.holds(other.trial) or (str(row["track"]), float(row["dt"])) in near:
                yield other

    def _of_limit(self, trial: Trial) -> Iterator[Trial]:
        case, by = self.cases[trial.case], ruler(trial, self.cases[trial.case])
        along_dt = by.axis.parameter == "dt"
        mine = {name: value for name, value in json.loads(_parameters(trial)).items() if name != by.axis.parameter}
        values = {}
        for row in self._rows(trial):
            given = json.loads(row["parameters"])
            others = {name: value for name, value in given.items() if name != by.axis.parameter}
            same = (row["track"], row["parts"], row["remedied"]) == (trial.track, trial.parts, "")
            if same and others == mine and (along_dt or row["dt"] == trial.settings.dt):
                values[float(row["dt"] if along_dt else given[by.axis.parameter])] = row, given.get(by.axis.parameter)
        found = bracket({value: row["status"] for value, (row, _) in values.items()}, by)
        for value, (row, hardness) in values.items():
            settings = trial.settings.with_dt(row["dt"]) if along_dt else trial.settings
            there = dict(trial.parameters) if along_dt else {**trial.parameters, by.axis.parameter: hardness}
            other = trial.probing(case, parameters=there, settings=settings, round=max(1, int(row["round"])))
            if self.pool.holds(other.trial) or value in (found.held, found.broke):
                yield other


def group_of(trial: Trial) -> Group:
    """The search of a front that a trial belongs to."""
    return trial.experiment.name, trial.case, _parameters(trial), trial.engine


def _parameters(trial: Trial) -> str:
    return json.dumps(dict(trial.parameters), sort_keys=True)


def _question(row: Any) -> Hashable:
    question = (row.engine, row.track, row.dt, row.seed, row.members, row.parts, row.remedy)
    return row.experiment, row.case, *question, row.alteration, row.parameters
