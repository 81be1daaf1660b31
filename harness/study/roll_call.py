"""Whom a study calls: every pattern of it, and every name on the command line, has to call somebody, and once."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.study.experiment import StudyError
from plumbline.harness.study.study import Study


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
