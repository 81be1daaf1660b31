"""A case: one question in SI units, its scene, its truth and the checks that judge an answer."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Annotated, Any, Literal, Self, TypeAlias, dataclass_transform, get_type_hints

import numpy as np
from annotated_types import Ge, Gt, Interval
from pydantic import TypeAdapter, ValidationError

from plumbline.harness.case.forces import Control
from plumbline.harness.case.problem import Problem, Rays
from plumbline.harness.case.symmetries import Retelling
from plumbline.harness.metric import Metric
from plumbline.harness.metrics.errors import divergence
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory

Unit = Literal["step", "ray", "world-step", "read-step", "call", "sensing"]
"""What a price is paid for: one step of a scene, one ray of a cast, one step of one of many worlds, one step with the state of
all bodies read after it, one call that takes no step, one interval of a scene's sensors with all that they read in it."""
Clocks = Literal["work", "reading", "call", "casting", "sensing"]
"""What runs under the clock: the case's own work, its steps with all states read after each, `step(0)`, the bare rays of its
range finders, or its steps with all that its sensors read."""
Positive: TypeAlias = Annotated[float, Gt(0)]
NotNegative: TypeAlias = Annotated[float, Ge(0)]
Share: TypeAlias = Annotated[float, Interval(ge=0, le=1)]
Count: TypeAlias = Annotated[int, Ge(1)]
FloatCount: TypeAlias = Annotated[float, Ge(1)]
"""Domains of parameters: a size, a coefficient, a share of something, a number of things; and one that a search divides."""


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True, eq=False)
class Parameters(Mapping[str, Any]):
    """The parameters of a case: a class of fields, each with the case's own value; read as a mapping by their names too."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, eq=False)(cls)

    def __getitem__(self, name: str) -> Any:
        if name not in self.__dataclass_fields__:
            raise KeyError(name)
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.__dataclass_fields__)

    def __len__(self) -> int:
        return len(self.__dataclass_fields__)

    def __hash__(self) -> int:
        return hash((type(self), *self.values()))

    def misfit(self, name: str, value: Any) -> str:
        """What a value of a parameter would have to be, in words, where it lies outside its domain; '' where it lies inside."""
        try:
            TypeAdapter(get_type_hints(type(self), include_extras=True)[name]).validate_python(value)
        except ValidationError as error:
            return "; ".join(detail["msg"].removeprefix("Input should be ") for detail in error.errors())
        return ""


class Step(float):
    """The time step [s] that an engine really takes, a sub-step where it has some.

    Terms:
        outer: the step [s] between two calls, over which states are told and forces from outside are held.
    """

    outer: float

    def __new__(cls, taken: float, outer: float) -> Self:
        """A step of `taken` seconds within one of `outer` seconds."""
        step = super().__new__(cls, taken)
        step.outer = outer
        return step


class ByParameters(float):
    """A time [s] that follows from the parameters of a case, which works it out for those that it is put at; NaN until then.

    Terms:
        law: parameters to seconds.
    """

    law: Callable[[Any], float]

    def __new__(cls, law: Callable[[Any], float], parameters: "Parameters | None" = None) -> Self:
        """The law's time at these parameters."""
        time = super().__new__(cls, math.nan if parameters is None else law(parameters))
        time.law = law
        return time

    def __reduce__(self) -> tuple[type[float], tuple[float]]:
        """A copy is the time alone."""
        return float, (float(self),)


def _timed(time: float, parameters: "Parameters") -> float:
    return ByParameters(time.law, parameters) if isinstance(time, ByParameters) else time


@dataclass(frozen=True, slots=True)
class Check:
    """A bound on a metric, derived in words.

    Terms:
        at_most: the bound in the metric's unit (at least, where higher is better); either a number or a function of the step
        that the engine really takes, for errors that shrink with it, and of the case's parameters. because: the derivation.
        start, end [s]: the part of the run that is judged; a start may be `ByParameters`. another_truth: why the case's truth
        is no answer to this check: it is that of a simpler body, say; '' where it has to keep the bound itself.
    """

    metric: Metric
    at_most: float | Callable[[Step, Any], float]
    because: str
    _: KW_ONLY
    start: float = 0.0
    end: float | None = None
    another_truth: str = ""

    def judged(self, run: Trajectory) -> Trajectory:
        """The part of a run that counts; the very same one where all of it does."""
        end = math.inf if self.end is None else self.end
        return run.between(self.start, end) if self.start > 0 or self.end is not None else run

    def bound(self, dt: float, parameters: Parameters, substep: float | None = None) -> float:
        """The bound at parameters of the case, for a time step dt [s] that an engine takes in steps of `substep` [s]: in one
        where that is left out."""
        if not callable(self.at_most):
            return float(self.at_most)
        return float(self.at_most(Step(dt if substep is None else substep, dt), parameters))

    def passes(self, value: float, dt: float, parameters: Parameters, substep: float | None = None) -> bool:
        """Is the value finite and on the right side of the bound?"""
        if not np.isfinite(value):
            return False
        bound = self.bound(dt, parameters, substep)
        return value <= bound if self.metric.better == "lower" else value >= bound


def _frozen(value: Any) -> Any:
    """What came through JSON as lists, as the tuples that it was: bounds that take long are kept by their parameters."""
    return tuple(_frozen(element) for element in value) if isinstance(value, list | tuple) else value


@dataclass(frozen=True, slots=True, kw_only=True)
class Converged:
    """A reference without a closed form: a trajectory with its own error bars in p_WB [m] and v_WB [m/s]."""

    trajectory: Trajectory
    position_error: float
    velocity_error: float

    @classmethod
    def between(cls, fine: Trajectory, coarse: Trajectory) -> Self:
        """The finer of two, whose error bars are the largest distances to the coarser one."""
        p, v = (np.linalg.norm(a - b, axis=-1) for a, b in ((fine.p_WB, coarse.p_WB), (fine.v_WB, coarse.v_WB)))
        return cls(trajectory=fine, position_error=float(p.max(initial=0.0)), velocity_error=float(v.max(initial=0.0)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """The parameter that makes a case harder, from `easy` to `extreme`, in a unit.

    Terms:
        lost: the share of the case's scale beyond which the headline counts as broken (below which, where higher is better),
        beside the signs that need no truth; None where those are enough.
    """

    parameter: str
    unit: str
    easy: float
    extreme: float
    lost: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One question put to every engine.

    Terms:
        name: the file's; its prefix is the family. duration [s], which may be `ByParameters`.
        parameters: what study files and searches may set, with the case's own values, each of a type that says its domain
        (`Positive`, `Annotated[float, Interval(ge=0, lt=1)]`). scene(parameters) gives the scene;
        expected(time (t,), parameters) the truth at those times, a `Converged`, or None where only conservation, statistics,
        or the engines' agreement on a limit judge. truth: what kind of truth that is, in words. coarsest [s]: without
        `expected`, the truth is the exact solver of the reference engine, extrapolated from runs of at most this step.
        sample_interval [s]: distance of recorded samples, 0 for every step. dt [s]: the step of a quick look; ladder: the
        steps of an accuracy run. with_contacts: record contacts at each sample.
        headline: the metric drawn against time step and cost. scale: the size of that metric's value that counts as 1.
        converges: 'smoothly' where nothing breaks the motion, so that the headline shrinks with the integrator's own order;
        'once' where contacts begin, end or go from slip to roll within a step, which leaves the first order; '' where the
        headline is no error that has to shrink with the step.
        ensemble: number of seeds, each a trial of its own that gets `seed` as a parameter.
        steady [s]: from there on every step costs alike, so the clock starts there; None clocks whole runs.
        control(parameters): the forces that act from outside, told anew before the steps.
        retellings(parameters): the scene told in other ways, each run beside it into streams '<name>/...'.
        rays(parameters): what is cast at time 0, into the streams 'rays/...', and what the clock counts instead of steps.
        insists: effects that the case declares though its own motion does not show them, by name, each with its reason.
        eased: by name, other parameters that make the scene a saner one, as a remedy where it breaks.
        worlds: the parameter that says how many equal worlds are stepped together, '' for none.
        undropped: the scene with what its user left out of it; None where nothing was.
    """

    name: str
    title: str
    question: str
    source: str
    truth: Literal["closed form", "converged reference", "conservation", "statistics", "rest", "agreed limit"]
    scene: Callable[[Any], Scene]
    checks: tuple[Check, ...]
    duration: float
    expected: Callable[[Floats, Any], Trajectory | Converged | None] | None = None
    coarsest: float | None = None
    observe: tuple[Metric, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)
    hard: Axis | None = None
    ensemble: int = 1
    sample_interval: float = 1 / 60
    dt: float = 1 / 240
    ladder: tuple[float, ...] = (1 / 60, 1 / 120, 1 / 240, 1 / 480, 1 / 960, 1 / 1920)
    with_contacts: bool = False
    headline: str = ""
    scale: float = 1.0
    converges: Literal["smoothly", "once", ""] = ""
    steady: float | None = None
    control: Callable[[Any], Control] | None = None
    retellings: Callable[[Any], tuple[Retelling, ...]] | None = None
    rays: Callable[[Any], Rays] | None = None
    worlds: str = ""
    undropped: Scene | None = None
    insists: Mapping[str, str] = field(default_factory=dict)
    eased: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @classmethod
    def of(cls, module: Mapping[str, Any], **fields: Any) -> Self:
        """The case that a file is: named like it, with the class `P` for its parameters, the constant `DURATION` [s], and the
        functions `scene`, `expected`, `control`, `retellings` and `rays`, those of them that it has. Every state has to be
        finite, whatever else is checked.

        Args: module: the file's `globals()`. fields: all else that a case states; the headline is the first check's metric, and
        contacts are recorded where a metric reads them, unless they say otherwise.
        """
        checks: tuple[Check, ...] = fields["checks"]
        metrics = (*(check.metric for check in checks), *fields.get("observe", ()))
        own = {name: module[name] for name in ("scene", "expected", "control", "retellings", "rays") if name in module}
        own |= {"name": module["__name__"].rpartition(".")[2], "parameters": module.get("P", Parameters)()}
        own |= {"duration": module["DURATION"]} if "DURATION" in module else {}
        own |= {"headline": checks[0].metric.name, "with_contacts": any(metric.contacts for metric in metrics)}
        finite = Check(divergence, 0.0, "every number of every sampled state has to be finite")
        return cls(**{**own, **fields, "checks": (finite, *checks)})

    def count_of_worlds(self, parameters: Mapping[str, Any]) -> int:
        """How many worlds are stepped together."""
        return int(parameters[self.worlds]) if self.worlds else 1

    def unit(self, parameters: Mapping[str, Any], clocks: Clocks = "work") -> Unit:
        """What the clock counts."""
        if clocks != "work":
            units: Mapping[Clocks, Unit] = {"reading": "read-step", "call": "call", "casting": "ray", "sensing": "sensing"}
            return units[clocks]
        if self.rays is not None:
            return "ray"
        return "world-step" if self.count_of_worlds(parameters) > 1 else "step"

    def __post_init__(self) -> None:
        if self.coarsest is not None and self.expected is not None:
            raise ValueError(f"case '{self.name}': has both a truth and a coarsest step to make one from, expected one of them")
        object.__setattr__(self, "duration", _timed(self.duration, self.parameters))
        checks = tuple(replace(check, start=_timed(check.start, self.parameters)) for check in self.checks)
        object.__setattr__(self, "checks", checks)

    def at(self, **parameters: Any) -> Parameters:
        """The case's parameters with other values for some of them. Raises: TypeError: for one that it does not have."""
        return replace(self.parameters, **{name: _frozen(value) for name, value in parameters.items()})

    def put(self, parameters: Mapping[str, Any]) -> Self:
        """The case with these parameters as its own, and the times that follow from them. Raises: TypeError."""
        return replace(self, parameters=self.at(**parameters))

    def problem(self, scene: Scene | None = None) -> Problem:
        """What reaches an engine at the case's own parameters. Args: scene: in place of the case's."""
        own = self.parameters
        return Problem(
            scene=self.scene(own) if scene is None else scene,
            duration=self.duration,
            sample_interval=self.sample_interval,
            contacts=self.with_contacts,
            impulses=self.with_contacts and any(metric.impulses for metric in self.metrics),
            control=None if self.control is None else self.control(own),
            rays=None if self.rays is None else self.rays(own),
            retellings=None if self.retellings is None else self.retellings(own),
            worlds=self.count_of_worlds(own) if self.worlds else 0,
            readings_due=self.truth == "agreed limit",
        )

    @property
    def family(self) -> str:
        """The prefix of the name: flight, spin, orbit, joint, impact, friction, rest, stack, tunnel, stand, system, sensor;
        scene for one of the user's own."""
        return re.split("[_:]", self.name, maxsplit=1)[0]

    @property
    def metrics(self) -> tuple[Metric, ...]:
        """All metrics, checked or only observed, each once."""
        seen = {check.metric.name: check.metric for check in self.checks}
        seen.update({metric.name: metric for metric in self.observe})
        return tuple(seen.values())

    def truth_at(self, time: Floats, parameters: Mapping[str, Any]) -> Trajectory | Converged | None:
        """The truth at the given times [s], shape (t,)."""
        return None if self.expected is None else self.expected(time, self.at(**parameters))
