"""A study: a named list of experiments; the part of a study file that people write.

The study of a scene of the user's own: a ladder of time steps on both tracks of every engine, and what the scene calls
for.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.intake.allowance import allowance
from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene.values import FROZEN, Name
from plumbline.harness.study.expansion import check_truths, trials_of
from plumbline.harness.study.experiment import Experiment, FolderName, Refinement, Some, StudyError, Variant
from plumbline.harness.study.trial import Trial


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

    def check_truths(self, cases: Mapping[str, Case]) -> None:
        """Raises: StudyError, where a case does not hold at parameters that it names."""
        check_truths(self.experiments, cases)

    def trials(
        self,
        cases: Mapping[str, Case],
        adapters: Mapping[str, Adapter],
        versions: Mapping[str, str],
        sources: Callable[[str, str], Mapping[str, str]] = lambda _case, _engine: {},
    ) -> Iterator[Trial]:
        """Its trials; see `harness.study.expansion.trials_of`. Raises: StudyError."""
        return trials_of(self.name, self.experiments, self.variants, cases, adapters, versions, sources)


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


HALVED = 16
"""What part of the first step the ladder is halved down to at least."""
BUDGET = 120.0
"""Seconds that a person waits for all of it; as many CPU seconds are the ladder's, which has half of the time on two cores."""
SAMPLE = 0.01
"""Seconds of a timing sample: runs of many engines and steps have to be clocked within the minutes that one waits."""


def study_of(case: Case, budget: float | None = None) -> Study:
    """Where every engine ends in this scene, what that costs at each step, and which effects the scene needs.

    The ladder ends at a step at which a run takes as many of them as are allowed, however long it lasts.

    Args: budget [s]: of waiting time, BUDGET if None.
    """
    finest = max(case.dt / HALVED, case.duration / max(allowance().steps - 1, 1))
    refined = Refinement(finest=finest, member_dt=case.ladder[-1], budget=BUDGET if budget is None else budget)
    ladder = Experiment(name="ladder", dt="ladder", refine=refined, sample_seconds=SAMPLE)
    # Effects are told from an engine's own error, so that they are asked about at a step at which it is small.
    needs = Experiment(name="effects", tracks=("tuned",), dt=(case.ladder[1],), effects=True, samples=3, sample_seconds=SAMPLE)
    return Study(name="scene", title=case.title, purpose=case.question, experiments=(ladder, needs))


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
