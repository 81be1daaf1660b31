"""Presets: wishes for a purpose, in a TOML file that says which cases count and why; users write their own."""

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from plumbline.harness.findings.selection.wish import CRITERIA, Wish
from plumbline.harness.intake.error import PlumblineError

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

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
