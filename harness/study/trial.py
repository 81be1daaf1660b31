"""A trial: one case at one set of parameters, on one engine, under one group of settings, and what it is called."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from plumbline.harness.adapter import Settings
from plumbline.harness.case import Case, Clocks, Problem
from plumbline.harness.case.alteration import AS_IT_IS, Alteration
from plumbline.harness.scene import Scene
from plumbline.harness.store.record import Answer, Asked, Record, digest
from plumbline.harness.study.experiment import Experiment, StudyError
from plumbline.harness.study.foreseen_cost import NoScene, scene_at
from plumbline.harness.study.sources import MOVING


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One cell: a case at one set of parameters, on one engine, under one group of settings.

    Terms:
        question: the digest of what is asked. trial: its name, the digest of all that decides its answer.
        clocks: what its timing run clocks, in `workers` processes side by side. round: of the search that proposed it, 0 for
        what the study names itself. alteration: how its scene departs from the case's. members: starts of the scene, each in a
        random phase, of which it says how many held; 1 for the scene as it is. remedy: what it tries to help with, where the
        trial `remedied` broke. parts: that the time step of the search was taken in, 0 where that is left to its settings.
        allowed [s]: its deadline, where a search gives it another than its experiment's; 0 where not.
        base: the track that turned settings descend from, '' where `track` is it.
        sources: digests of the texts that decide the answer, by what they are; see `harness.study.provenance`.
        motion: the digest of what of all this moves the run: trials of one motion differ in what judges them alone.
    """

    study: str
    experiment: Experiment
    case: str
    parameters: Mapping[str, Any]
    engine: str
    engine_version: str
    track: str
    settings: Settings
    seed: int
    question: str = ""
    trial: str = ""
    clocks: Clocks = "work"
    workers: int = 1
    round: int = 0
    alteration: Alteration = AS_IT_IS
    members: int = 1
    remedy: str = ""
    remedied: str = ""
    parts: int = 0
    allowed: float = 0.0
    base: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)
    motion: str = ""

    @property
    def deadline(self) -> float:
        """What its process may take for its answer [s]."""
        return self.allowed or self.experiment.deadline

    def scene(self, case: Case) -> Scene:
        """What is put to the engine."""
        whole = case.undropped if self.alteration.undropped else None
        return self.alteration.of(case.scene(case.at(**self.parameters)) if whole is None else whole)

    def problem(self, case: Case) -> Problem:
        """What is put to the engine, with what is read of it; `case` stands at the parameters of the trial."""
        return case.problem(self.scene(case))

    def named(self) -> "Trial":
        """The trial with its name, a digest of all that decides its answer, question, versions and sources included, and that
        of its motion, which leaves out the sources that only judge."""
        asked = {
            "study": self.study,
            "experiment": self.experiment.name,
            "case": self.case,
            "parameters": dict(self.parameters),
            "question": self.question,
            "engine": self.engine,
            "version": self.engine_version,
            "track": self.track,
            "settings": replace(self.settings, source="").plain(),
            "seed": self.seed,
        }
        unusual = {
            "clocks": (self.clocks, "work"),
            "workers": (self.workers, 1),
            "alteration": (self.alteration.plain(), AS_IT_IS.plain()),
            "members": (self.members, 1),
            "remedied": (self.remedied, ""),
            "parts": (self.parts, 0),
        }
        asked |= {name: value for name, (value, plain) in unusual.items() if value != plain}
        moving = {name: text for name, text in self.sources.items() if name in MOVING}
        motion, trial = (digest(asked | ({"sources": texts} if texts else {})) for texts in (moving, dict(self.sources)))
        return replace(self, trial=trial, motion=motion)

    def record(self, answer: Answer) -> Record:
        """What is kept of it with what came of it."""
        told: dict[str, Any] = {
            "experiment": self.experiment.name,
            "base": self.base or self.track,
            "dt": self.settings.dt,
            "settings": self.settings.plain(),
            "alteration": self.alteration.plain(),
        }
        alike = {each.name: getattr(self, each.name) for each in fields(Asked) if each.name not in told}
        return Record(**alike, **told, **{each.name: getattr(answer, each.name) for each in fields(Answer)})

    def probing(self, case: Case, **changes: Any) -> "Trial":
        """Another trial of a search, with other parameters, settings or alteration; its name follows from all of them."""
        if "parameters" in changes:
            parameters = changes["parameters"]
            changes["question"] = question_of(case, parameters, scene_of(case, parameters))
        return replace(self, **changes).named()


def scene_of(case: Case, parameters: Mapping[str, Any]) -> Scene:
    """The scene of a case. Raises: StudyError."""
    try:
        return scene_at(case, parameters)
    except NoScene as error:
        raise StudyError(str(error)) from error


def question_of(case: Case, parameters: Mapping[str, Any], scene: Scene) -> str:
    """A digest of what is asked of an engine."""
    return digest(case.put(parameters).problem(scene).plain())
