"""A study: a named list of experiments, the part of a study file that people write; whom it calls, and its trials."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from plumbline.harness.adapter import Adapter, Settings, SettingsError
from plumbline.harness.case import Case, Clocks
from plumbline.harness.case.alteration import ALONE, REFINED, Alteration, departures
from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene import Scene
from plumbline.harness.scene.values import FROZEN, Name
from plumbline.harness.study.axes import axis_of, steps_of
from plumbline.harness.study.engine_versions import engine_of, named_by
from plumbline.harness.study.experiment import Experiment, FolderName, Some, StudyError, Variant
from plumbline.harness.study.foreseen_cost import misfit, too_much
from plumbline.harness.study.library_variants import LIBRARY_VARIANTS
from plumbline.harness.study.trial import Trial, question_of, scene_of


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Study:
    """A named list of experiments; the part of a study file that people write.

    Terms:
        variants: by engine and name, the settings beyond the two tracks that its experiments can call for.
    """

    name: FolderName
    title: Annotated[str, Field(max_length=2000)] = ""
    purpose: Annotated[str, Field(max_length=20_000)] = ""
    recordings: bool = True
    variants: dict[Name, dict[Name, Variant]] = Field(default_factory=dict)
    experiments: Annotated[tuple[Experiment, ...], Some]

    def __post_init__(self) -> None:
        names = [experiment.name for experiment in self.experiments]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"experiments: '{name}' stands {names.count(name)} times, expected names of their own")
        for engine, variants in self.variants.items():
            if taken := {"default", "tuned"} & variants.keys():
                raise ValueError(f"variant '{engine}/{min(taken)}': the name is a track's, expected another")
            known = {None, "default", "tuned", *(name for name, variant in variants.items() if variant.changes is None)}
            for name, variant in variants.items():
                if variant.beside not in known:
                    others = ", ".join(sorted(other for other in known if other is not None))
                    raise ValueError(f"variant '{engine}/{name}': beside is '{variant.beside}', expected one of {others}")

    def trials(
        self,
        cases: Mapping[str, Case],
        adapters: Mapping[str, Adapter],
        versions: Mapping[str, str],
        sources: Callable[[str, str], Mapping[str, str]] = lambda _case, _engine: {},
    ) -> Iterator[Trial]:
        """All trials, engine by engine innermost so that engines are interleaved; every cell of the matrix is there.

        Args: sources: of a case and an engine, by name: digests of the texts that decide an answer.
        Raises: StudyError, where it asks for what there is not, or for more than is allowed.
        """
        _check_count(self, cases, adapters)
        for experiment in self.experiments:
            engines = [e for e in adapters.values() if any(named_by(e.name, pattern) for pattern in experiment.engines)]
            sides = [divided for side in _sides(self, experiment, engines) for divided in _divided(experiment, side)]
            for case in cases.values():
                if not experiment.asks(case.name):
                    continue
                for parameters, seed in parameters_of(experiment, case):
                    if experiment.limit is not None:
                        axis = axis_of(experiment, case)
                        parameters = parameters | ({} if axis.parameter == "dt" else {axis.parameter: axis.easy})
                    members = 1 if experiment.limit is None else experiment.limit.members
                    scene = scene_of(case, parameters)
                    question = question_of(case, parameters, scene)
                    clocked = list(_clocked(experiment, case, parameters))
                    for dt, (track, engine, settings, parts) in product(steps_of(experiment, case), sides):
                        if excess := too_much(case, scene, dt / (parts or 1), every_step=experiment.determinism):
                            raise StudyError(f"experiment '{experiment.name}': case '{case.name}': {excess}")
                        for clocks, workers in clocked:
                            trial = Trial(
                                study=self.name,
                                experiment=experiment,
                                case=case.name,
                                parameters=parameters,
                                question=question,
                                engine=engine.name,
                                engine_version=versions[engine.name],
                                track=track,
                                settings=in_parts(settings.with_dt(dt), engine, parts),
                                parts=parts,
                                seed=seed,
                                clocks=clocks,
                                workers=workers,
                                members=members,
                                sources=sources(case.name, engine.name),
                            ).named()
                            if not experiment.determinism:
                                yield trial
                            if experiment.effects:
                                yield from _altered(trial, case, engine, scene)
                            if experiment.determinism:
                                yield from _again(trial, case, engine)


def load_study(name: str) -> Study:
    """A built-in study by name, or a study file by its path ending in .toml.

    Raises:
        StudyError: naming file, element, field, value and expectation.
    """
    built_in = {path.stem: path for path in sorted((Path(__file__).parent / "built_in").glob("*.toml"))}
    if name.endswith(".toml"):
        path = Path(name)
    elif name in built_in:
        path = built_in[name]
    else:
        raise StudyError(
            f"study {quoted(name)}: no such study or file, expected one of {', '.join(built_in)}, or a path ending in .toml"
            f"{did_you_mean(name, built_in)}"
        )
    try:
        return filled(TypeAdapter(Study), document(path), named(path))
    except (InputError, FieldError) as error:
        raise StudyError(str(error)) from None


def twice(names: Iterable[str]) -> str:
    """The first name that stands more than once; '' where each stands once."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return ""


def _check(where: str, field: str, patterns: Iterable[str], known: Sequence[str]) -> None:
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in known):
            there = ", ".join(known) or "none"
            raise StudyError(f"{where}: {field}: {quoted(pattern)} names nothing, expected a pattern over: {there}")


def call_roll(study: Study, cases: Sequence[str], engines: Sequence[str]) -> None:
    """Check a study against the names of all cases and engines that there are. Raises: StudyError."""
    where = f"study '{study.name}'"
    for engine in study.variants:
        if engine not in engines:
            raise StudyError(f"{where}: variants: {quoted(engine)} is no engine, expected one of: {', '.join(engines)}")
    variants = [f"{engine}/{name}" for engine, named in study.variants.items() for name in named]
    for experiment in study.experiments:
        here = f"{where}: experiment '{experiment.name}'"
        _check(here, "cases", experiment.cases, cases)
        _check(here, "without", experiment.without, cases)
        _check(here, "engines", experiment.engines, engines)
        _check(here, "variants", experiment.variants, variants)


def _check_count(study: Study, cases: Mapping[str, Case], adapters: Mapping[str, Adapter]) -> None:
    """Refuse more trials than are allowed before the first one is made."""
    total = 0
    for experiment in study.experiments:
        sides = sum(any(named_by(name, pattern) for pattern in experiment.engines) for name in adapters)
        sides *= len(experiment.tracks) + max(map(len, study.variants.values()), default=0)
        each = math.prod(map(len, experiment.parameters.values())) * len(experiment.clocks) * len(experiment.workers)
        asked = [case for case in cases.values() if experiment.asks(case.name)]
        total += sides * each * sum(case.ensemble * len(steps_of(experiment, case)) for case in asked)
        if excess := beyond("trials", total):
            raise StudyError(f"study '{study.name}': with experiment '{experiment.name}' up to {excess}")


def _sides(study: Study, experiment: Experiment, engines: Sequence[Adapter]) -> Iterator[tuple[str, Adapter, Settings]]:
    """Tracks, then variants, each with the engines that have it and the settings that it means there."""
    for track in experiment.tracks:
        for engine in engines:
            yield track, engine, engine.tracks[track]
    for engine in engines:
        for name, variant in study.variants.get(engine_of(engine.name), {}).items():
            if any(fnmatchcase(f"{engine_of(engine.name)}/{name}", pattern) for pattern in experiment.variants):
                if variant.pace and (experiment.timing or experiment.limit or experiment.sweep or experiment.refine):
                    raise StudyError(
                        f"experiment '{experiment.name}': variant '{engine.name}/{name}' has the pace '{variant.pace}', "
                        "expected timing = false and no limit, sweep or refine: the clock and the searches take even steps"
                    )
                try:
                    yield name, engine, variant.over(engine.tracks)
                except SettingsError as error:
                    raise StudyError(f"study '{study.name}': variant '{engine.name}/{name}': {error}") from None


Side: TypeAlias = tuple[str, Adapter, Settings]


def _divided(experiment: Experiment, side: Side) -> Iterator[tuple[str, Adapter, Settings, int]]:
    """A track or variant as it comes (0), or once for each number of parts that a limit is sought at."""
    parts = experiment.limit.parts if experiment.limit is not None and side[0] == "tuned" else ()
    yield from ((*side, count) for count in parts or (0,))


def in_parts(settings: Settings, engine: Adapter, parts: int) -> Settings:
    """The settings with their time step taken in so many parts; as they are for none."""
    if not parts:
        return settings
    if "substeps" in engine.knobs:
        return replace(settings, substeps=parts)
    return settings.with_dt(settings.dt / parts)


def parameters_of(experiment: Experiment, case: Case) -> Iterator[tuple[dict[str, Any], int]]:
    """The parameters and seeds at which an experiment runs a case.

    Raises:
        StudyError: for a parameter that the case does not have.
    """
    for name in experiment.parameters:
        if name not in case.parameters:
            known = ", ".join(case.parameters) or "none"
            raise StudyError(f"experiment '{experiment.name}': case '{case.name}' has no parameter '{name}', expected: {known}")
    for name, values in experiment.parameters.items():
        for value in values:
            if reason := misfit(case.parameters[name], value):
                raise StudyError(f"experiment '{experiment.name}': case '{case.name}': parameter '{name}': {reason}")
    for values in product(*experiment.parameters.values()):
        chosen = dict(case.parameters) | dict(zip(experiment.parameters, values, strict=True))
        for seed in range(case.ensemble):
            yield chosen | ({"seed": seed} if case.ensemble > 1 else {}), seed


def _altered(trial: Trial, case: Case, engine: Adapter, scene: Scene) -> Iterator[Trial]:
    """The trial's scene with its effects switched, and the trial at half its time step and at half of that."""
    for alteration in departures(scene, engine.features.names):
        yield trial.probing(case, alteration=alteration)
    for name, parts in REFINED.items():
        yield trial.probing(case, alteration=Alteration(name=name), settings=trial.settings.with_dt(trial.settings.dt / parts))


AGAIN = ("again", ALONE, "restored", "reordered", "nudged")
"""What a run is repeated as."""


def _again(trial: Trial, case: Case, engine: Adapter) -> Iterator[Trial]:
    """The trial with every step recorded: as it is, and once more in each way that must not, or may, change its bits."""
    yield trial.probing(case, alteration=Alteration(every_step=True))
    for name in AGAIN:
        retelling: Any = name if name in ("restored", "reordered", "nudged") else ""
        yield trial.probing(case, alteration=Alteration(name=name, every_step=True, told=retelling))
    for count in engine.threads:
        settings = replace(trial.settings, options={**trial.settings.options, "threads": count})
        yield trial.probing(case, settings=settings, alteration=Alteration(name=f"{count} threads", every_step=True))
    for variant in LIBRARY_VARIANTS if trial.experiment.varies_libraries(case.name) else ():
        alteration = Alteration(name=variant.name, every_step=True, variables=variant.variables)
        yield trial.probing(case, alteration=alteration)


def _clocked(experiment: Experiment, case: Case, parameters: Mapping[str, Any]) -> Iterator[tuple[Clocks, int]]:
    """What is clocked, and in how many processes side by side. Raises: StudyError."""
    for clocks, workers in product(experiment.clocks, experiment.workers):
        if clocks != "work" and case.unit(parameters) != "step":
            raise StudyError(
                f"experiment '{experiment.name}': clocks '{clocks}' of case '{case.name}', whose unit is a "
                f"{case.unit(parameters)}, expected 'work' alone"
            )
        if clocks in ("casting", "sensing"):
            sensors = case.scene(case.at(**parameters)).sensors
            kind = "range finder" if clocks == "casting" else "sensor"
            if not any(clocks == "sensing" or sensor.type == "lidar" for sensor in sensors):
                raise StudyError(
                    f"experiment '{experiment.name}': clocks '{clocks}' of case '{case.name}', which has no {kind}"
                )
        yield clocks, workers
