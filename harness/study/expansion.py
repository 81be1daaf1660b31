"""How a study unfolds into trials: every cell of the matrix, engines innermost."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import product
from typing import Any, TypeAlias

from plumbline.harness.adapter import Adapter, Settings, SettingsError
from plumbline.harness.case import Case, Clocks
from plumbline.harness.case.alteration import ALONE, REFINED, Alteration, departures
from plumbline.harness.case.own_truth import refused
from plumbline.harness.intake.allowance import beyond
from plumbline.harness.scene import Scene
from plumbline.harness.study.engine_versions import engine_of, named_by
from plumbline.harness.study.experiment import Experiment, StudyError, Variant, axis_of, steps_of
from plumbline.harness.study.foreseen_cost import misfit, too_many_steps, too_much
from plumbline.harness.study.library_variants import LIBRARY_VARIANTS
from plumbline.harness.study.trial import Trial, question_of, scene_of

Variants: TypeAlias = Mapping[str, Mapping[str, Variant]]
"""By engine and name."""


def trials_of(
    study: str,
    experiments: Sequence[Experiment],
    variants: Variants,
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
    versions: Mapping[str, str],
    sources: Callable[[str, str], Mapping[str, str]],
) -> Iterator[Trial]:
    """All trials, engine by engine innermost so that engines are interleaved; every cell of the matrix is there.

    Args: study: its name. sources: of a case and an engine, by name: digests of the texts that decide an answer.
    Raises: StudyError, where it asks for what there is not, or for more than is allowed.
    """
    _check_count(study, experiments, variants, cases, adapters)
    for experiment in experiments:
        engines = [e for e in adapters.values() if any(named_by(e.name, pattern) for pattern in experiment.engines)]
        sides = [divided for side in _sides(study, variants, experiment, engines) for divided in _divided(experiment, side)]
        for case in cases.values():
            if not experiment.asks(case.name):
                continue
            for parameters, seed in parameters_of(experiment, case):
                if experiment.limit is not None:
                    axis = axis_of(experiment, case)
                    parameters = parameters | ({} if axis.parameter == "dt" else {axis.parameter: axis.easy})
                check_search(experiment, case)
                members = 1 if experiment.limit is None else experiment.limit.members
                scene = scene_of(case, parameters)
                question = question_of(case, parameters, scene)
                clocked = list(_clocked(experiment, case, parameters))
                for dt, (track, engine, settings, parts) in product(steps_of(experiment, case), sides):
                    if excess := too_much(case.put(parameters), scene, dt / (parts or 1), every_step=experiment.determinism):
                        raise StudyError(f"experiment '{experiment.name}': case '{case.name}': {excess}")
                    for clocks, workers in clocked:
                        trial = Trial(
                            study=study,
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


def check_truths(experiments: Sequence[Experiment], cases: Mapping[str, Case]) -> None:
    """Put each closed form to its case's own checks, at all parameters that an experiment names.

    Raises: StudyError: naming the case and the parameters at which its truth breaks a bound of its own; where there are more of
    them alone than a study may have trials.
    """
    for experiment in experiments:
        count = sum(experiment.asks(name) for name in cases)
        if excess := beyond("trials", count * math.prod(map(len, experiment.parameters.values()))):
            raise StudyError(f"experiment '{experiment.name}': at least {excess}")
        for case in (case for case in cases.values() if experiment.asks(case.name)):
            for parameters, _ in parameters_of(experiment, case):
                scene_of(case, parameters)
                if reason := refused(case, parameters, min(steps_of(experiment, case))):
                    raise StudyError(f"experiment '{experiment.name}': {reason}")


def _check_count(
    study: str,
    experiments: Sequence[Experiment],
    variants: Variants,
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
) -> None:
    """Refuse more trials than are allowed before the first one is made."""
    total = 0
    for experiment in experiments:
        sides = sum(any(named_by(name, pattern) for pattern in experiment.engines) for name in adapters)
        sides *= len(experiment.tracks) + max(map(len, variants.values()), default=0)
        each = math.prod(map(len, experiment.parameters.values())) * len(experiment.clocks) * len(experiment.workers)
        asked = [case for case in cases.values() if experiment.asks(case.name)]
        total += sides * each * sum(case.ensemble * len(steps_of(experiment, case)) for case in asked)
        if excess := beyond("trials", total):
            raise StudyError(f"study '{study}': with experiment '{experiment.name}' up to {excess}")


def _sides(
    study: str, variants: Variants, experiment: Experiment, engines: Sequence[Adapter]
) -> Iterator[tuple[str, Adapter, Settings]]:
    """Tracks, then variants, each with the engines that have it and the settings that it means there."""
    for track in experiment.tracks:
        for engine in engines:
            yield track, engine, engine.tracks[track]
    for engine in engines:
        for name, variant in variants.get(engine_of(engine.name), {}).items():
            if any(fnmatchcase(f"{engine_of(engine.name)}/{name}", pattern) for pattern in experiment.variants):
                if variant.pace and (experiment.timing or experiment.limit or experiment.sweep or experiment.refine):
                    raise StudyError(
                        f"experiment '{experiment.name}': variant '{engine.name}/{name}' has the pace '{variant.pace}', "
                        "expected timing = false and no limit, sweep or refine: the clock and the searches take even steps"
                    )
                try:
                    yield name, engine, variant.over(engine.tracks)
                except SettingsError as error:
                    raise StudyError(f"study '{study}': variant '{engine.name}/{name}': {error}") from None


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
            if reason := misfit(case.parameters, name, value):
                raise StudyError(f"experiment '{experiment.name}': case '{case.name}': parameter '{name}': {reason}")
    for values in product(*experiment.parameters.values()):
        chosen = dict(case.parameters) | dict(zip(experiment.parameters, values, strict=True))
        for seed in range(case.ensemble):
            yield chosen | ({"seed": seed} if case.ensemble > 1 else {}), seed


def check_search(experiment: Experiment, case: Case) -> None:
    """Refuse ends of a search that no trial could reach, before the first trial. Raises: StudyError."""
    limit, where = experiment.limit, f"experiment '{experiment.name}'"
    both = {} if limit is None else {"limit.easy": limit.easy, "limit.extreme": limit.extreme}
    ends = {field: value for field, value in both.items() if value is not None}
    if limit is not None and ends and (name := axis_of(experiment, case).parameter) != "dt":
        for field, value in ends.items():
            whole = isinstance(case.parameters[name], int) and math.isfinite(value)
            if reason := misfit(case.parameters, name, round(value) if whole else value):
                raise StudyError(f"{where}: {field}: case '{case.name}': parameter '{name}': {reason}")
        ends = {}
    if experiment.refine is not None:
        ends |= {"refine.finest": experiment.refine.finest}
    for field, dt in ends.items():
        if excess := too_many_steps(case.duration, dt) if dt > 0 else f"{dt:g}, expected a time step above 0 s":
            raise StudyError(f"{where}: {field}: case '{case.name}': {excess}")


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
