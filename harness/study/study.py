"""A study: a named list of experiments; the part of a study file that people write."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene.values import FROZEN, Name
from plumbline.harness.study.expansion import check_truths, trials_of
from plumbline.harness.study.experiment import Experiment, FolderName, Some, StudyError, Variant
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
