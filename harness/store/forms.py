"""The forms of a journal's lines and of the files beside it: the type of each field that a reader asks for."""

from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["accuracy", "timing", "session", "withdrawn", "restored"]
"""Of a line of a journal."""


@dataclass(frozen=True)
class StoredStudy:
    """A study in plain values; its experiments are for `harness.study.experiment`."""

    experiments: list[dict[str, Any]] = field(default_factory=list)
    name: str = ""
    title: str = ""
    variants: dict[str, Any] = field(default_factory=dict)
    recordings: bool = True


@dataclass(frozen=True)
class JournalLine:
    """A line behind its checksum."""

    schema: int
    number: int
    before: str
    kind: Kind
    content: dict[str, Any]


@dataclass(frozen=True)
class TrialNames:
    """The content of a line that takes trials out, or brings them back."""

    trials: list[str]
    because: str = ""


@dataclass(frozen=True)
class Session:
    """What a session begins under."""

    study: StoredStudy
    machine: dict[str, Any]
    catalogue: str
    trials: list[str]
    engines: dict[str, str] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)


CONTENTS = {"session": Session, "withdrawn": TrialNames, "restored": TrialNames}
"""By kind, of what lines hold; records and timings check themselves."""


@dataclass(frozen=True)
class JournalEnd:
    """How far a journal had come when a run last ended."""

    lines: int
    checksum: str
    content: str = ""


@dataclass(frozen=True)
class Machine:
    """The machine of a run, and how the run ended."""

    journal: JournalEnd | None = None
    tables: dict[str, str] = field(default_factory=dict)
    complete: bool = False
    command: list[str] = field(default_factory=list)
    packages: dict[str, str] = field(default_factory=dict)
    load: list[float] = field(default_factory=list)
    memory_mb: float | None = None
    cores: int | None = None
    processor: str = ""
    system: str = ""
    python: str = ""
    commit: str = ""
    started: str = ""
    finished: str = ""


@dataclass(frozen=True)
class Described:
    """A case, as `harness.study.catalogue.describe_case` has it."""

    title: str = ""
    question: str = ""
    truth: str = ""
    source: str = ""
    effects: list[str] = field(default_factory=list)
    features: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)
    ladder: list[float] = field(default_factory=list)
    checks: list[dict[str, Any]] = field(default_factory=list)
    duration: float | None = None
    steady: float | None = None
    dt: float | None = None
    scale: float | None = None
    bodies: int | None = None
    headline: str = ""
    hard: dict[str, Any] | None = None


@dataclass(frozen=True)
class DescribedEngine:
    """An engine, as `harness.study.catalogue.describe_engine` has it."""

    title: str = ""
    distribution: str = ""
    version: str | None = None
    unavailable: str | None = None
    ours: bool = False
    batch: bool = False
    features: list[str] = field(default_factory=list)
    tracks: dict[str, dict[str, Any]] = field(default_factory=dict)
    knobs: dict[str, list[Any]] = field(default_factory=dict)
    known_failures: dict[str, str] = field(default_factory=dict)
    deviations: list[str] = field(default_factory=list)
    emulated: list[dict[str, Any]] = field(default_factory=list)
    advantages: dict[str, dict[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Catalogue:
    """What was asked, and of whom."""

    cases: dict[str, Described] = field(default_factory=dict)
    engines: dict[str, DescribedEngine] = field(default_factory=dict)


FORMS: dict[str, type] = {"machine.json": Machine, "catalogue.json": Catalogue, "study.toml": StoredStudy}
"""By the name of the file."""
