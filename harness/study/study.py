"""A study: which cases are put to which engines, under which settings; it unfolds into trials."""

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

from pydantic import AfterValidator, Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from harness.adapter import Adapter, Settings, SettingsError
from harness.case import Axis, Case, Clocks
from harness.case.alteration import ALONE, AS_IT_IS, REFINED, Alteration, departures
from harness.case.forces import wrench_after
from harness.intake.allowance import beyond
from harness.intake.documents import InputError, document, named
from harness.intake.mendable import Mendable
from harness.intake.safe_text import quoted
from harness.intake.typed_fields import FieldError, filled
from harness.scene import Scene
from harness.scene.file import dump_json
from harness.scene.values import FROZEN, Name
from harness.store.record import digest
from harness.study.foreseen_cost import NoScene, misfit, scene_at, too_much
from harness.study.refinement import Refinement
from harness.trajectory import State

__all__ = [
    "Experiment",
    "Limit",
    "Study",
    "StudyError",
    "Trial",
    "Variant",
    "axis_among",
    "axis_of",
    "experiment_from",
    "load_study",
]

Track = Literal["default", "tuned"]
Value: TypeAlias = bool | int | float | str
T = TypeVar("T")


def _distinct(values: tuple[T, ...]) -> tuple[T, ...]:
    """Each once: what is listed twice would be run twice under one name."""
    seen: set[T] = set()
    for value in values:
        if value in seen:
            raise ValueError(f"{quoted(value)} stands twice, expected each once")
        seen.add(value)
    return values


def _file_name(name: str) -> str:
    """A name that a folder can have, and that leads nowhere else."""
    if len(name) > 100 or name[0] in ".-~" or set(name) & set('/\\:*?"<>|'):
        raise ValueError("the name of a study names its folder, expected up to 100 letters, digits, blanks, '-', '_' or '.'")
    return name


def _some(values: tuple[T, ...]) -> tuple[T, ...]:
    if not values:
        raise ValueError("the list is empty, expected at least one")
    return values


Each = AfterValidator(_distinct)
Some = AfterValidator(_some)
FolderName = Annotated[Name, AfterValidator(_file_name)]
Pattern = Annotated[str, Field(min_length=1, max_length=200)]
Step = Annotated[float, Field(ge=1e-12, le=1e3, allow_inf_nan=False)]
"""A time step [s], within what `Settings` take."""

BEYOND = 4.0
"""A limit along the time step is sought up to so many times the coarsest step of a case's ladder."""


class StudyError(Mendable, ValueError):
    """A study file that breaks a rule; the message names file, element, value and expectation."""


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Variant:
    """A group of settings that users of an engine would try beside its tracks: what it says is laid over the track `on`.

    Terms: the fields of `Settings`; None keeps the track's own. options: added to the track's, one by one.
    """

    on: Track = "tuned"
    substeps: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    iterations: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    integrator: Name | None = None
    solver: Name | None = None
    tolerance: Annotated[float, Field(ge=0, lt=1)] | None = None
    options: dict[Name, Value] = Field(default_factory=dict)
    source: Annotated[str, Field(max_length=2000)] = ""

    def over(self, tracks: Mapping[str, Settings]) -> Settings:
        """The settings of this variant of an engine with these tracks."""
        base = tracks[self.on]
        names = ("substeps", "iterations", "integrator", "solver", "tolerance")
        said = {name: value for name in names if (value := getattr(self, name)) is not None}
        return replace(base, **said, options={**base.options, **self.options}, source=self.source or f"a variant of {self.on}")


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Limit:
    """A search for the value at which a case breaks; see `harness.search.first_break`.

    Terms:
        along: the parameter that is made harder: 'axis' for the case's own, 'dt' for the time step, or a parameter's name.
        easy, extreme: where the search starts and ends, the axis's own unless said. scan: values from easy to extreme that are
        tried one after the other before the first bracket is halved. within: the ratio of a bracket's ends at which it is close
        enough; along an axis that starts at 0, one more than their distance over the extreme. members: starts of each value.
        remedies: the tracks on which what is said to help is tried where a case breaks.
        parts: of the time step, each a search of its own on 'tuned' in place of that track as it comes, so that all engines are
        compared at equal sub-steps: an engine that takes sub-steps takes so many, another one steps of dt / parts.
    """

    along: Name = "axis"
    easy: float | None = None
    extreme: float | None = None
    scan: int = Field(default=4, ge=2, le=1000)
    within: float = Field(default=1.25, gt=1.0, le=100.0)
    members: int = Field(default=16, ge=2, le=100_000)
    remedies: Annotated[tuple[Track, ...], Each] = ()
    parts: Annotated[tuple[Annotated[int, Field(ge=1, le=1000)], ...], Each] = ()


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Experiment:
    """A block of trials: every case that a pattern names, on every engine that a pattern names.

    Terms:
        without: patterns of cases that are left out all the same.
        variants: patterns over '<engine>/<variant>' of the study's variants, run beside the tracks under their own names.
        dt: 'case' for each case's own step, 'ladder' for its ladder, or steps [s]. parameters: values to run each case at
        instead of its own, each a list; all combinations are run. timing: also clock it, by `samples` samples of
        `sample_seconds` [s] in each of `processes` processes. deadline [s] of a trial, memory [MB] of its process: no less than
        a process needs, no more than a machine has.
        sweep: how many settings beyond these may be tried for each case on an engine, in search of its Pareto front (see
        `harness.search.front`); then only what lies near the front is clocked.
        clocks: what runs under the clock, each a trial of its own. workers: how many processes step the scene side by side,
        each number a trial of its own.
        effects: run each cell as it is, with every effect that the engine has, without each one that the scene calls for, and
        at half and a quarter of the time step; see `harness.search.needless_effects`.
        determinism: run each cell again, alone, beside others, restored, reordered, nudged by a bit and on more threads; see
        `harness.findings.tables.determinism`.
        limit: search for the value at which each case breaks on each engine, from the easy end on; without it none is sought.
        refine: go on halving the time step, until each engine's limit is known; see `harness.search.refined_ladder`.
    """

    name: Name
    cases: Annotated[tuple[Pattern, ...], Some, Each] = ("*",)
    without: Annotated[tuple[Pattern, ...], Each] = ()
    engines: Annotated[tuple[Pattern, ...], Some, Each] = ("*",)
    tracks: Annotated[tuple[Track, ...], Each] = ("default", "tuned")
    variants: Annotated[tuple[Pattern, ...], Each] = ()
    dt: Literal["case", "ladder"] | Annotated[tuple[Step, ...], Some, Each] = "case"
    parameters: dict[Name, Annotated[tuple[Value, ...], Some, Each]] = Field(default_factory=dict)
    timing: bool = True
    clocks: Annotated[tuple[Clocks, ...], Some, Each] = ("work",)
    workers: Annotated[tuple[Annotated[int, Field(ge=1, le=1000)], ...], Some, Each] = (1,)
    samples: int = Field(default=5, ge=1, le=10_000)
    processes: int = Field(default=1, ge=1, le=100)
    sample_seconds: Annotated[float, Field(ge=1e-6, le=3600)] = 0.05
    deadline: Annotated[float, Field(ge=1e-3, le=1e7)] = 60.0
    memory: Annotated[float, Field(ge=16, le=2**24)] = 4096.0
    sweep: int = Field(default=0, ge=0, le=10_000)
    limit: Limit | None = None
    refine: Refinement | None = None
    effects: bool = False
    determinism: bool = False

    def asks(self, case: str) -> bool:
        """Is the case of that name among its own?"""
        wanted, left = (any(fnmatchcase(case, one) for one in some) for some in (self.cases, self.without))
        return wanted and not left

    def __post_init__(self) -> None:
        for track in () if self.limit is None else self.limit.remedies:
            if track not in self.tracks:
                raise ValueError(
                    f"limit.remedies: '{track}', expected one of the experiment's tracks: {', '.join(self.tracks)}"
                )
        if self.limit is not None and self.limit.along == "dt" and set(self.limit.parts) - {1}:
            raise ValueError(
                f"limit.parts: {list(self.limit.parts)} along 'dt', expected none, or 1: the step itself is sought"
            )


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

    def trials(
        self,
        cases: Mapping[str, Case],
        adapters: Mapping[str, Adapter],
        versions: Mapping[str, str],
        sources: "Callable[[str, str], Mapping[str, str]]" = lambda _case, _engine: {},
    ) -> "Iterator[Trial]":
        """All trials, engine by engine innermost so that engines are interleaved; every cell of the matrix is there.

        Args: sources: of a case and an engine, by name: digests of the texts that decide an answer.
        Raises: StudyError, where it asks for what there is not, or for more than is allowed.
        """
        self._check_count(cases, adapters)
        for experiment in self.experiments:
            engines = [e for e in adapters.values() if any(fnmatchcase(e.name, pattern) for pattern in experiment.engines)]
            sides = [part for side in self._sides(experiment, engines) for part in _divided(experiment, side)]
            for case in cases.values():
                if not experiment.asks(case.name):
                    continue
                for parameters, seed in parameters_of(experiment, case):
                    if experiment.limit is not None:
                        axis = axis_of(experiment, case)
                        parameters = parameters | ({} if axis.parameter == "dt" else {axis.parameter: axis.easy})
                    members = 1 if experiment.limit is None else experiment.limit.members
                    scene = _scene(case, parameters)
                    question = _question(case, parameters, scene)
                    clocked = list(_clocked(experiment, case, parameters))
                    for dt, (track, engine, settings, parts) in product(steps_of(experiment, case), sides):
                        if said := too_much(case, scene, dt / (parts or 1), every_step=experiment.determinism):
                            raise StudyError(f"experiment '{experiment.name}': case '{case.name}': {said}")
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

    def _check_count(self, cases: Mapping[str, Case], adapters: Mapping[str, Adapter]) -> None:
        """Refuse more trials than are allowed before the first one is made."""
        total = 0
        for experiment in self.experiments:
            sides = sum(any(fnmatchcase(name, one) for one in experiment.engines) for name in adapters)
            sides *= len(experiment.tracks) + max(map(len, self.variants.values()), default=0)
            each = math.prod(map(len, experiment.parameters.values())) * len(experiment.clocks) * len(experiment.workers)
            asked = [case for case in cases.values() if experiment.asks(case.name)]
            total += sides * each * sum(case.ensemble * len(steps_of(experiment, case)) for case in asked)
            if said := beyond("trials", total):
                raise StudyError(f"study '{self.name}': with experiment '{experiment.name}' up to {said}")

    def _sides(self, experiment: Experiment, engines: Sequence[Adapter]) -> Iterator[tuple[str, Adapter, Settings]]:
        """Tracks, then variants, each with the engines that have it and the settings that it means there."""
        for track in experiment.tracks:
            for engine in engines:
                yield track, engine, engine.tracks[track]
        for engine in engines:
            for name, variant in self.variants.get(engine.name, {}).items():
                if any(fnmatchcase(f"{engine.name}/{name}", pattern) for pattern in experiment.variants):
                    try:
                        yield name, engine, variant.over(engine.tracks)
                    except SettingsError as error:
                        raise StudyError(f"study '{self.name}': variant '{engine.name}/{name}': {error}") from None


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
            if said := misfit(case.parameters[name], value):
                raise StudyError(f"experiment '{experiment.name}': case '{case.name}': parameter '{name}': {said}")
    for values in product(*experiment.parameters.values()):
        chosen = dict(case.parameters) | dict(zip(experiment.parameters, values, strict=True))
        for seed in range(case.ensemble):
            yield chosen | ({"seed": seed} if case.ensemble > 1 else {}), seed


def _altered(trial: "Trial", case: Case, engine: Adapter, scene: Scene) -> "Iterator[Trial]":
    """The trial's scene with its effects switched, and the trial at half its time step and at half of that."""
    for told in departures(scene, engine.features.names):
        yield trial.probing(case, alteration=told)
    for name, parts in REFINED.items():
        yield trial.probing(case, alteration=Alteration(name=name), settings=trial.settings.with_dt(trial.settings.dt / parts))


AGAIN = ("again", ALONE, "restored", "reordered", "nudged")
"""What a run is repeated as."""


def _again(trial: "Trial", case: Case, engine: Adapter) -> "Iterator[Trial]":
    """The trial with every step recorded: as it is, and once more in each way that must not, or may, change its bits."""
    yield trial.probing(case, alteration=Alteration(every_step=True))
    for name in AGAIN:
        told: Any = name if name in ("restored", "reordered", "nudged") else ""
        yield trial.probing(case, alteration=Alteration(name=name, every_step=True, told=told))
    for count in engine.threads:
        settings = replace(trial.settings, options={**trial.settings.options, "threads": count})
        yield trial.probing(case, settings=settings, alteration=Alteration(name=f"{count} threads", every_step=True))


def _clocked(experiment: Experiment, case: Case, parameters: Mapping[str, Any]) -> Iterator[tuple[Clocks, int]]:
    """What is clocked, and in how many processes side by side. Raises: StudyError."""
    for clocks, workers in product(experiment.clocks, experiment.workers):
        if clocks != "work" and case.unit(parameters) != "step":
            raise StudyError(
                f"experiment '{experiment.name}': clocks '{clocks}' of case '{case.name}', whose unit is a "
                f"{case.unit(parameters)}, expected 'work' alone"
            )
        if clocks in ("casting", "sensing"):
            sensors = case.scene(**parameters).sensors
            kind = "range finder" if clocks == "casting" else "sensor"
            if not any(clocks == "sensing" or sensor.type == "lidar" for sensor in sensors):
                raise StudyError(
                    f"experiment '{experiment.name}': clocks '{clocks}' of case '{case.name}', which has no {kind}"
                )
        yield clocks, workers


def _scene(case: Case, parameters: Mapping[str, Any]) -> Scene:
    """The scene of a case. Raises: StudyError."""
    try:
        return scene_at(case, parameters)
    except NoScene as error:
        raise StudyError(str(error)) from error


def _question(case: Case, parameters: Mapping[str, Any], scene: Scene) -> str:
    """A digest of what is asked: the scene, how long it runs, what is sampled, what acts on it, its retellings, its rays."""
    told = hashlib.sha256(dump_json(scene).encode()).hexdigest()
    asked = [told, case.duration, case.sample_interval, case.with_contacts]
    if case.control is not None:
        control = case.control(**parameters)
        asked += [control.interval, hashlib.sha256(wrench_after(control, State.initial(scene))).hexdigest()]
    if case.retellings is not None:
        asked += [
            [told.name, told.clock, told.restored_at, hashlib.sha256(dump_json(told.scene).encode()).hexdigest()]
            for told in case.retellings(**parameters)
        ]
    if case.rays is not None:
        rays = case.rays(**parameters)
        asked.append(hashlib.sha256(rays.origins.tobytes() + rays.directions.tobytes()).hexdigest())
        asked.append(rays.max_range)
    return digest(asked)


def axis_of(experiment: Experiment, case: Case) -> Axis:
    """What the limit of an experiment is sought along, with the ends that the experiment sets. Raises: StudyError."""
    return axis_among(experiment, case.name, case.hard, case.ladder, case.parameters)


def axis_among(
    experiment: Experiment, case: str, hard: Axis | None, ladder: Sequence[float], parameters: Mapping[str, Any]
) -> Axis:
    """The same for a case of which these are known. Raises: StudyError."""
    limit = experiment.limit or Limit()
    if limit.along == "dt":
        axis = Axis(parameter="dt", unit="s", easy=min(ladder), extreme=BEYOND * max(ladder))
    elif hard is not None and limit.along in ("axis", hard.parameter):
        axis = hard
    elif limit.along in parameters:
        if limit.easy is None or limit.extreme is None:
            raise StudyError(
                f"experiment '{experiment.name}': limit along '{limit.along}' has no ends, expected easy and extreme"
            )
        axis = Axis(parameter=limit.along, unit="1", easy=limit.easy, extreme=limit.extreme)
    else:
        known = ", ".join(("dt", *parameters))
        raise StudyError(f"experiment '{experiment.name}': case '{case}' has no axis '{limit.along}', expected one of: {known}")
    easy = axis.easy if limit.easy is None else limit.easy
    return replace(axis, easy=easy, extreme=axis.extreme if limit.extreme is None else limit.extreme)


def steps_of(experiment: Experiment, case: Case) -> tuple[float, ...]:
    """The time steps [s] at which an experiment runs a case."""
    if experiment.limit is not None and experiment.limit.along == "dt":
        return (axis_of(experiment, case).easy,)
    if experiment.dt == "case":
        return (case.dt,)
    if experiment.dt == "ladder":
        return case.ladder
    return tuple(experiment.dt)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One cell: a case at one set of parameters, on one engine, under one group of settings.

    Terms:
        question: the digest of what is asked. trial: its name, the digest of all that decides its answer.
        clocks: what its timing run clocks, in `workers` processes side by side. round: of the search that proposed it, 0 for
        what the study names itself. alteration: how its scene departs from the case's. members: starts of the scene, each in a
        random phase, of which it says how many held; 1 for the scene as it is. remedy: what it tries to help with, where the
        trial `remedied` broke. parts: that the time step of the search was taken in, 0 where that is left to its settings.
        sources: digests of the texts that decide the answer, by what they are; see `harness.study.provenance`.
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
    sources: Mapping[str, str] = field(default_factory=dict)

    def scene(self, case: Case) -> Scene:
        """What is put to the engine."""
        return self.alteration.of(case.scene(**self.parameters))

    def named(self) -> "Trial":
        """The trial with its name: a digest of all that decides its answer, question, versions and sources included."""
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
            "sources": (dict(self.sources), {}),
        }
        return replace(self, trial=digest(asked | {name: value for name, (value, plain) in unusual.items() if value != plain}))

    def probing(self, case: Case, **changes: Any) -> "Trial":
        """Another trial of a search, with other parameters, settings or alteration; its name follows from all of them."""
        if "parameters" in changes:
            parameters = changes["parameters"]
            changes["question"] = _question(case, parameters, _scene(case, parameters))
        return replace(self, **changes).named()


def experiment_from(told: Any, source: str) -> Experiment:
    """The experiment that a part of a study file says; `source` names the file. Raises: StudyError."""
    try:
        return filled(TypeAdapter(Experiment), told, source)
    except FieldError as error:
        raise StudyError(str(error)) from None


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
        )
    try:
        return filled(TypeAdapter(Study), document(path), named(path))
    except (InputError, FieldError) as error:
        raise StudyError(str(error)) from None
