"""What a user wants of an engine: weights of criteria and of cases, and requirements that leave engines out. Wishes for a
purpose are presets, TOML files that say which cases count and why; users write their own.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.intake.error import PlumblineError

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

CRITERIA: Mapping[str, str] = SPOKEN["criteria"]
"""By name, what each is measured by."""


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What is wanted.

    weights: by criterion, 0 or more; those left out weigh 1. cases: patterns of case names to weights; the first that matches
    counts, a case that none matches does not; all cases count alike where there is no pattern. features: that an engine has to
    claim. max_error: the error asked for, a share of each case's scale. strict: is an engine left out that does not reach
    it in each case? realtime: how many times faster than real time it has to reach it; None for as slow as it likes. licences:
    SPDX identifiers, of which an engine must have one. platform: that it must run on. with_reference: does the
    reference engine stand in the rank?"""

    weights: Mapping[str, float] = field(default_factory=dict)
    cases: Mapping[str, float] = field(default_factory=dict)
    features: tuple[str, ...] = ()
    max_error: float = 1e-2
    strict: bool = False
    realtime: float | None = None
    licences: tuple[str, ...] = ()
    platform: str = ""
    with_reference: bool = False

    def weight(self, criterion: str) -> float:
        """Of a criterion."""
        return self.weights.get(criterion, 1.0)

    def weight_of_case(self, case: str, family: str) -> float:
        """Of a case; 0 where it does not count."""
        if not self.cases:
            return 1.0
        return next((weight for pattern, weight in self.cases.items() if _matches(case, family, pattern)), 0.0)


def _matches(case: str, family: str, pattern: str) -> bool:
    return pattern == family or fnmatchcase(case, pattern)


@dataclass(frozen=True, kw_only=True)
class Dropped:
    """An engine that is left out. requirement: which it does not meet. value: what it has instead. case, trial: where that was
    seen, '' where it is of the engine itself."""

    engine: str
    requirement: str
    value: str
    case: str = ""
    trial: str = ""


_FOLDER = Path(__file__).parent / "presets"

Weight = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]


class PresetError(PlumblineError, ValueError):
    """A preset that is not there, or says something that none does."""


class _Cases(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    match: str = Field(min_length=1)
    weight: Weight = 1.0
    why: str = Field(min_length=1)


class Preset(BaseModel):
    """A wish with its reasons. order: among purposes, smallest first. match: a family, or a pattern of case names. why: of
    each, in words that can be argued with."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: str = Field(min_length=1)
    order: int = 100
    why: str = Field(min_length=1)
    weights: dict[str, Weight] = {}
    cases: tuple[_Cases, ...] = Field(min_length=1)
    features: tuple[str, ...] = ()
    max_error: Annotated[float, Field(gt=0, lt=1)] = 1e-2

    def wish(self) -> Wish:
        """What it asks for."""
        patterns = {cases.match: cases.weight for cases in self.cases}
        return Wish(weights=self.weights, cases=patterns, features=self.features, max_error=self.max_error)


def preset_names() -> tuple[str, ...]:
    """Those that are built in."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def read_preset(name: str) -> Preset:
    """A built-in preset by name, or one of a user's by the path of its file. Raises: PresetError, with file, key and value."""
    path = Path(name) if name.endswith(".toml") else _FOLDER / f"{name}.toml"
    if not path.is_file():
        built_in = ", ".join(preset_names())
        raise PresetError(f"preset '{name}': there is no such file and none is built in by that name; there are {built_in}")
    try:
        plain: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        preset = Preset.model_validate(plain)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise PresetError(f"{path}: {error}") from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise PresetError(f"{path}: {where}: {first['msg']}, not {str(first['input'])[:80]!r}") from None
    if unknown := sorted(set(preset.weights) - set(CRITERIA)):
        raise PresetError(f"{path}: weights.{unknown[0]}: no such criterion; there are {', '.join(CRITERIA)}")
    return preset


def merged(base: Wish, **given: Any) -> Wish:
    """A preset's wish with what was given beside it in its place."""
    return replace(base, **{name: value for name, value in given.items() if value not in (None, (), {}, "")})


def unmatched(store: "Store", need: Sequence[str]) -> Iterator[tuple[str, str]]:
    """What is needed but names no family and no case of the run; each with the families that the run has, in words."""
    about = store.catalogue.get("cases", {})
    families = {
        case: str(about.get(case, {}).get("family") or case.partition("_")[0]) for case in set(map(str, store.trials["case"]))
    }
    for name in need:
        if not any(Wish(cases={name: 1.0}).weight_of_case(case, family) for case, family in families.items()):
            yield name, ", ".join(sorted(set(families.values())))
