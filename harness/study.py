"""A study: which cases are put to which engines, under which settings; it unfolds into trials."""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as validated

from harness.adapter import Adapter, Settings
from harness.case import Case
from harness.record import digest
from harness.scene.values import FROZEN, Name, Positive

__all__ = ["Experiment", "Study", "StudyError", "Trial", "load_study"]


class StudyError(ValueError):
    """A study file that breaks a rule; the message names file, element, value and expectation."""


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Experiment:
    """A block of trials: every case that a pattern names, on every engine that a pattern names.

    Terms:
        dt: 'case' for each case's own step, 'ladder' for its ladder, or steps [s]. parameters: values to run each case at,
        each a list; all combinations are run. timing: also clock it. deadline [s] of a trial, memory [MB] of its process.
    """

    name: Name
    cases: tuple[str, ...] = ("*",)
    engines: tuple[str, ...] = ("*",)
    tracks: tuple[Literal["default", "tuned"], ...] = ("default", "tuned")
    dt: Literal["case", "ladder"] | tuple[Positive, ...] = "case"
    timing: bool = True
    samples: int = Field(default=5, ge=1, le=10_000)
    processes: int = Field(default=1, ge=1, le=100)
    sample_seconds: Positive = 0.05
    deadline: Positive = 60.0
    memory: Positive = 4096.0


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Study:
    """A named list of experiments; the part of a study file that people write."""

    name: Name
    title: str = ""
    purpose: str = ""
    recordings: bool = True
    experiments: tuple[Experiment, ...]

    def trials(
        self, cases: Mapping[str, Case], adapters: Mapping[str, Adapter], versions: Mapping[str, str]
    ) -> "Iterator[Trial]":
        """All trials, engine by engine innermost so that engines are interleaved; every cell of the matrix is there."""
        for experiment in self.experiments:
            for case in cases.values():
                if not any(fnmatchcase(case.name, pattern) for pattern in experiment.cases):
                    continue
                for dt in steps_of(experiment, case):
                    for seed in range(case.ensemble):
                        for track in experiment.tracks:
                            for adapter in adapters.values():
                                if any(fnmatchcase(adapter.name, pattern) for pattern in experiment.engines):
                                    yield Trial.of(self, experiment, case, adapter, track, dt, seed, versions[adapter.name])


def steps_of(experiment: Experiment, case: Case) -> tuple[float, ...]:
    """The time steps [s] at which an experiment runs a case."""
    if experiment.dt == "case":
        return (case.dt,)
    if experiment.dt == "ladder":
        return case.ladder
    return tuple(experiment.dt)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One cell: a case at one set of parameters, on one engine, under one group of settings."""

    trial: str
    study: str
    experiment: Experiment
    case: str
    parameters: Mapping[str, Any]
    engine: str
    engine_version: str
    track: str
    settings: Settings
    seed: int

    @classmethod
    def of(
        cls,
        study: Study,
        experiment: Experiment,
        case: Case,
        adapter: Adapter,
        track: str,
        dt: float,
        seed: int,
        version: str,
    ) -> "Trial":
        """The trial with its name: a digest of all that decides its answer, versions included."""
        settings = adapter.tracks[track].with_dt(dt)
        parameters = dict(case.parameters) | ({"seed": seed} if case.ensemble > 1 else {})
        name = digest(
            {
                "study": study.name,
                "experiment": experiment.name,
                "case": case.name,
                "parameters": parameters,
                "engine": adapter.name,
                "version": version,
                "track": track,
                "settings": replace(settings, source="").plain(),
                "seed": seed,
            }
        )
        return cls(
            trial=name,
            study=study.name,
            experiment=experiment,
            case=case.name,
            parameters=parameters,
            engine=adapter.name,
            engine_version=version,
            track=track,
            settings=settings,
            seed=seed,
        )


def load_study(name: str) -> Study:
    """A built-in study by name, or a study file by its path ending in .toml.

    Raises:
        StudyError: naming file, element, field, value and expectation.
    """
    folder = Path(__file__).parent / "studies"
    path = Path(name) if name.endswith(".toml") else folder / f"{name}.toml"
    if not path.is_file():
        built_in = ", ".join(sorted(p.stem for p in folder.glob("*.toml")))
        raise StudyError(f"study '{name}': no such study or file, expected one of {built_in}, or a path ending in .toml")
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        return TypeAdapter(Study).validate_python(document)
    except tomllib.TOMLDecodeError as error:
        raise StudyError(f"{path}: not readable: {error}") from error
    except ValidationError as error:
        lines = (
            f"{path}: {'.'.join(map(str, p['loc']))}: {p['msg'].removeprefix('Value error, ')}, got {p['input']!r:.120}"
            for p in error.errors(include_url=False)
        )
        raise StudyError("\n".join(lines)) from error
