"""An experiment of a study: which cases, engines and settings it asks for, what it sweeps, limits and repeats; and those of a
stored study.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, TypeVar

from pydantic import AfterValidator, Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from plumbline.harness.adapter import Settings
from plumbline.harness.case import Axis, Case, Clocks
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene.values import FROZEN, Name
from plumbline.harness.store.journal import StoreError

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

Track = Literal["default", "tuned"]
Change = Literal["iterations", "law"]
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


class StudyError(PlumblineError, ValueError):
    """A study file that breaks a rule; the message names file, element, value and expectation."""


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Variant:
    """A group of settings that users of an engine would try beside its tracks: what it says is laid over the track `on`.

    Terms: the fields of `Settings`; None keeps the track's own. options: added to the track's, one by one. changes: the one
    thing in which it differs from the track or variant `beside`; both None for one that stands for itself.
    """

    on: Track = "tuned"
    beside: Name | None = None
    changes: Change | None = None
    substeps: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    iterations: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    integrator: Name | None = None
    solver: Name | None = None
    tolerance: Annotated[float, Field(ge=0, lt=1)] | None = None
    pace: Name | None = None
    options: dict[Name, Value] = Field(default_factory=dict)
    source: Annotated[str, Field(max_length=2000)] = ""

    def __post_init__(self) -> None:
        if (self.beside is None) != (self.changes is None):
            raise ValueError(f"beside is {self.beside!r}, changes is {self.changes!r}, expected both or none")

    def over(self, tracks: Mapping[str, Settings]) -> Settings:
        """The settings of this variant of an engine with these tracks."""
        base = tracks[self.on]
        names = ("substeps", "iterations", "integrator", "solver", "tolerance", "pace")
        overrides = {name: value for name in names if (value := getattr(self, name)) is not None}
        return replace(
            base, **overrides, options={**base.options, **self.options}, source=self.source or f"a variant of {self.on}"
        )


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Limit:
    """A search for the value at which a case breaks; see `harness.search.first_break`.

    Terms:
        along: the parameter that is made harder: 'axis' for the case's own, 'dt' for the time step, or a parameter's name.
        easy, extreme: where the search starts and ends, the axis's own unless said. scan: values from easy to extreme that are
        tried one after the other before the first bracket is halved. within: the ratio of a bracket's ends at which it is close
        enough; along an axis that starts at 0, one more than four times their distance over the extreme. members: starts of
        each value. remedies: the tracks on which what is said to help is tried where a case breaks.
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
class Refinement:
    """How far a ladder of time steps goes on below the steps that an experiment names, and what is run where that ends.

    See `harness.search.refined_ladder`.

    Terms:
        finest [s]: the time step that every engine's ladder is halved down to. further: halvings beyond it, for an engine whose
        limit is not known to the end yet. budget [s]: CPU time of all runs of the experiment, shared alike by its engines and
        tracks. turns: settings of an engine that are turned one by one where its tracks end apart. members: perturbed starts
        that are run where no two engines' limits are known to the end, at the time step `member_dt` [s].
    """

    finest: Step = 1 / 3840
    further: Annotated[int, Field(ge=0, le=10)] = 2
    budget: Annotated[float, Field(ge=0, le=1e7)] = 120.0
    turns: Annotated[int, Field(ge=0, le=100)] = 8
    members: Annotated[int, Field(ge=0, le=1000)] = 8
    member_dt: Step = 1 / 960


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Experiment:
    """A block of trials: every case that a pattern names, on every engine that a pattern names.

    Terms:
        without: patterns of cases that are left out all the same.
        variants: patterns over '<engine>/<variant>' of the study's variants, run beside the tracks under their own names.
        dt: 'case' for each case's own step, 'ladder' for its ladder, or steps [s]. parameters: values to run each case at
        instead of its own, each a list; all combinations are run. timing: also clock it, by `samples` samples of
        `sample_seconds` [s] in each of `processes` processes. deadline [s] of a trial, in CPU time of its process once its
        engine is loaded; memory [MB] of its process: no less than a process needs, no more than a machine has.
        sweep: how many settings beyond these may be tried for each case on an engine, in search of its Pareto front (see
        `harness.search.front`); then only what lies near the front is clocked.
        clocks: what runs under the clock, each a trial of its own. workers: how many processes step the scene side by side,
        each number a trial of its own.
        effects: run each cell as it is, with every effect that the engine has, without each one that the scene calls for, and
        at half and a quarter of the time step; see `harness.search.needless_effects`.
        dominance: turn each knob of 'tuned' to each of its values, one at a time, to see whether the engine is better off; see
        `harness.search.dominance`. Its tracks are 'tuned' alone.
        determinism: run each cell again, alone, beside others, restored, reordered, nudged by a bit and on more threads; see
        `harness.findings.tables.determinism`. libraries: patterns of those cases that are also run again with other code of the
        numeric libraries; see `harness.study.library_variants`.
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
    libraries: Annotated[tuple[Pattern, ...], Each] = ()
    dominance: bool = False

    def asks(self, case: str) -> bool:
        """Is the case of that name among its own?"""
        wanted, left = (any(fnmatchcase(case, pattern) for pattern in patterns) for patterns in (self.cases, self.without))
        return wanted and not left

    def varies_libraries(self, case: str) -> bool:
        """Is the case of that name run with other code of the libraries?"""
        return any(fnmatchcase(case, pattern) for pattern in self.libraries)

    def __post_init__(self) -> None:
        if self.libraries and not self.determinism:
            raise ValueError(f"libraries: {', '.join(self.libraries)} without determinism, expected determinism = true or none")
        if self.dominance and self.tracks != ("tuned",):
            raise ValueError(f"tracks: {', '.join(self.tracks)} with dominance, expected tuned alone: what is held against it")
        for track in () if self.limit is None else self.limit.remedies:
            if track not in self.tracks:
                raise ValueError(
                    f"limit.remedies: '{track}', expected one of the experiment's tracks: {', '.join(self.tracks)}"
                )
        if self.limit is not None and self.limit.along == "dt" and set(self.limit.parts) - {1}:
            raise ValueError(
                f"limit.parts: {list(self.limit.parts)} along 'dt', expected none, or 1: the step itself is sought"
            )


def experiment_from(table: Any, source: str) -> Experiment:
    """The experiment that a part of a study file says; `source` names the file. Raises: StudyError."""
    try:
        return filled(TypeAdapter(Experiment), table, source)
    except FieldError as error:
        raise StudyError(str(error)) from None


BEYOND = 4.0
"""A limit along the time step is sought up to so many times the coarsest step of a case's ladder."""


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


@dataclass(frozen=True, slots=True)
class Departure:
    """How a variant differs in one thing. Terms: beside: the track or variant that it differs from. changes: the thing."""

    beside: str
    changes: str


def experiments_of(store: "Store") -> list[Experiment]:
    """All experiments in order; none where the folder does not hold its study. Raises: StoreError."""
    path = store.folder / "study.toml"
    try:
        return [experiment_from(table, str(path)) for table in store.study.get("experiments", [])]
    except StudyError as error:
        raise StoreError(str(error)) from error


def departures_of(store: "Store") -> Mapping[tuple[str, str], Departure]:
    """By engine and name, the variants that change one thing."""
    return {
        (engine, name): Departure(variant["beside"], variant["changes"])
        for engine, named in store.study.get("variants", {}).items()
        for name, variant in named.items()
        if "changes" in variant
    }
