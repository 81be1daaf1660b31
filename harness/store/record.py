"""A record: all that is kept of one trial, with the names of the table columns, and the notices in it. What a file of the store
says is checked against a form before anybody uses it: a right checksum makes no content right.
"""

import dataclasses
import hashlib
import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal, TypeVar

T = TypeVar("T")


@cache
def _form(of: Any) -> Any:
    from pydantic import TypeAdapter  # late: a listing reads no store

    return TypeAdapter(of)


def checked(form: type[T], value: object, what: str) -> T:
    """The value as one of a dataclass, each field of its type; fields that are not known are passed over.

    Args: value: of JSON or TOML. Raises: ValueError, with the field that is none.
    """
    try:
        typed: T = _form(form).validate_python(value)  # type: ignore[arg-type]  # a class can be hashed
    except ValueError as error:
        first = error.errors(include_url=False)[0]  # type: ignore[attr-defined]  # of pydantic, which is loaded late
        where = ".".join(map(str, first["loc"])) or what
        raise ValueError(f"holds no {what}: {where}: {first['msg']}, got {str(first['input'])[:80]!r}") from None
    return typed


@dataclass(frozen=True, slots=True)
class StoredNotice:
    """A notice in plain values.

    Terms: as of `harness.adapter.Notice`; effect: the name of it, '' for a note. by: who says it: the engine or its adapter,
    what judges the answer, what clocks it roughly beside its run, or its timing run.
    """

    text: str
    kind: Literal["note", "surplus", "missing", "capacity"] = "note"
    effect: str = ""
    by: Literal["engine", "judge", "rough clock", "timing"] = "engine"

    def __str__(self) -> str:
        """As a line for people, by its kind first."""
        return self.text if self.kind == "note" else f"{self.kind}: {self.text}"


def short_of(notices: Iterable[StoredNotice]) -> str:
    """What an engine could not hold, before the rest of a reason: 'contacts reached 1000, ...; '; '' if it held all."""
    return "".join(f"{notice.text}; " for notice in notices if notice.kind == "capacity")


def notice_of(line: str) -> StoredNotice:
    """The notice of a line for people, which names its effect as code or people do."""
    from plumbline.harness.scene import Effect  # late: who has a journal does not pay for scenes

    words = line.lower().replace(",", " ").replace(":", " ").replace("(", " ").split()
    effect = next((name for name in Effect(~0).names if name in words or name.replace("_", " ") in " ".join(words)), "")
    for kind in ("surplus", "missing", "capacity"):
        if line.startswith(f"{kind}: "):
            return StoredNotice(line.removeprefix(f"{kind}: "), kind, effect if kind != "capacity" else "")
    return StoredNotice(line)


SCHEMA_VERSION = 3
"""Raised when a field changes its meaning; a store with another number is refused."""

Status = Literal["passed", "failed", "diverged", "unsupported", "unavailable", "timeout", "crashed", "oom", "interrupted"]
Clocked = Literal["", "whole runs", "calls", "not clocked"]
"""What samples are of: whole runs of the scene (from its steady time on, where the case has one), casts or empty calls, which
have no end, or nothing, where no sample could be taken. '' where no timing was asked for, and in folders of older versions."""


def digest(value: Any) -> str:
    """Sixteen hexadecimal digits that name a JSON-ready value."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """A metric's value in one trial; `at_most` and `passed` are None where it is only observed.

    Where a higher value is better, `at_most` holds the bound that the value must reach and `because` says so.
    truth_error: how far off the truth itself may be, in the metric's unit.
    """

    metric: str
    value: float
    unit: str
    at_most: float | None = None
    passed: bool | None = None
    because: str = ""
    truth_error: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One timing sample: `steps` steps or casts took `cpu` and `wall` [s] in process number `process`, block number `block`.

    Terms:
        units: rays of one cast, worlds of one step; 1 where one scene is stepped; that many times more where several processes
        step side by side: `cpu` is then that of all of them, `wall` that of the slowest.
        run: steps of one whole run of the scene; 0 for casts and empty calls, and in folders of older versions.
        emulated: the share of the CPU time (0 to 1) that the adapter's own laws took, in a run apart from the samples of the
        process; None in folders of older versions.
    """

    process: int
    block: int
    steps: int
    cpu: float
    wall: float
    canary: float
    switches: int
    units: int = 1
    run: int = 0
    emulated: float | None = None


@dataclass(frozen=True, kw_only=True)
class Timing:
    """What the timing run of a trial gave, and the samples behind it.

    Terms:
        cpu_per_sim_s [s/s]: median with the 95 % bootstrap interval cpu_low..cpu_high; wall_per_sim_s likewise.
        realtime_factor: simulated over wall seconds. unstable_timing: the interval is too wide or the canary moved.
        unit: what was clocked, one of `harness.case.Unit`; cpu_per_unit [s] with its interval: the price of one.
        note: what went wrong there. clocked_on: the digest of the machine, '' where it was not said. clocked: what the samples
        are of; of nothing, the note says why. emulated: the share (0 to 1) of the price that is the adapter's own laws, the
        middle of that of the samples.
    """

    trial: str
    cpu_per_sim_s: float | None = None
    cpu_low: float | None = None
    cpu_high: float | None = None
    wall_per_sim_s: float | None = None
    realtime_factor: float | None = None
    unstable_timing: bool | None = None
    unit: str | None = None
    cpu_per_unit: float | None = None
    cpu_per_unit_low: float | None = None
    cpu_per_unit_high: float | None = None
    note: str = ""
    clocked_on: str = ""
    clocked: Clocked = ""
    emulated: float | None = None
    samples: tuple[Sample, ...] = ()


def parts_of_runs(timing: Timing) -> list[Sample]:
    """The samples that are no whole runs, of a timing that says it is of such."""
    whole = timing.clocked == "whole runs"
    return [s for s in timing.samples if whole and (s.run < 1 or s.steps < s.run or s.steps % s.run)]


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a record says of its trial, in plain values.

    Terms:
        parameters, settings: JSON. alteration: JSON, of the scene; empty for none. track: 'default', 'tuned', the name of a
        variant of the study, or one of them with what a search turned in it. base: the one that it descends from; no column.
        clocks, workers, round, members, remedy, remedied, parts: of the trial. sources: digests of the texts that decide the
        answer, by what they are; see `harness.study.sources`. motion: the digest of all that moves the run, and of nothing that
        judges it.
    """

    trial: str
    study: str
    experiment: str
    case: str
    parameters: Mapping[str, Any]
    engine: str
    engine_version: str
    track: str
    base: str = ""
    dt: float
    settings: Mapping[str, Any]
    seed: int = 0
    clocks: str = "work"
    workers: int = 1
    round: int = 0
    alteration: Mapping[str, Any] = field(default_factory=dict)
    members: int = 1
    remedy: str = ""
    remedied: str = ""
    parts: int = 0
    sources: Mapping[str, str] = field(default_factory=dict)
    motion: str = ""

    def cell(self, *without: str) -> str:
        """What is asked, whatever the versions, settings and sources, in which round. Args: without: names of fields."""
        own = (name for name in _CELL if name not in without)
        return repr([sorted(value.items(), key=str) if isinstance(value := getattr(self, n), Mapping) else value for n in own])


_CELL = (
    *("study", "experiment", "case", "parameters", "engine", "track", "dt", "seed"),
    *("clocks", "workers", "alteration", "members", "remedied", "parts"),
)


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What came of a trial, as its process tells it.

    Terms:
        resolved: JSON. sim_seconds [s] simulated, steps taken. warnings: what the engine, its adapter or the harness said; in
        the table as sentences. detail: trace or tail of standard error, for people.
        substep [s]: the step that the engine really took, dt over the sub-steps that it says it used; None without an answer.
        rough_cost: CPU seconds per simulated second (per unit, where that is no step), from short samples beside the run
        of a sweep, or of an ensemble, which tables of limits show as rough; of a run of a ladder all that its process took,
        from an engine that is ready to a judged answer. rough_ratio: the same over that of the engine's default track (tuned,
        where that does not run) at the case's own step, clocked in turns with it: a sweep goes by it.
        idle: knobs and values to which a search need not turn one from here, since the engine resolves its settings as before;
        no column.
        broke: when and how it diverged, None where it did not; no column.
        memory [B]: by how much the process of the accuracy run grew while worlds were built and stepped; None of a case without
        a number of worlds.
        simulated_as: of a kept answer that was judged anew, the trial that simulated it; '' of one that was simulated.
    """

    status: Status
    reason: str
    detail: str = ""
    resolved: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[StoredNotice, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    sim_seconds: float = 0.0
    steps: int = 0
    substep: float | None = None
    trajectory_hash: str | None = None
    rough_cost: float | None = None
    rough_ratio: float | None = None
    idle: tuple[tuple[str, Any], ...] = ()
    broke: str | None = None
    memory: float | None = None
    simulated_as: str = ""

    @property
    def answer(self) -> str:
        """The hash of what the engine said, or the status of a trial without an answer."""
        return self.trajectory_hash or self.status


@dataclass(frozen=True, kw_only=True)
class Record(Answer, Asked):
    """All that is kept of one trial: what was asked, what came of it, and what its timing run gave; None without one.

    Terms:
        answered_on: the digest of the machine of the accuracy run, and rough cost; see `harness.store.machine_fingerprint`.
        recalled: the night of a history that computed the answer, '' where this run did. again: of a known answer that was
        computed again all the same, what was known: its hash, or its status where it has none; '' of any other.
        trajectory_kept: False where a trajectory is kept by its hash alone.
    """

    answered_on: str = ""
    recalled: str = ""
    again: str = ""
    trajectory_kept: bool = True
    timing: Timing | None = None

    @property
    def disagrees(self) -> bool:
        """Was it computed again, and gave another answer to the same digest?"""
        return self.again not in ("", self.answer)

    @property
    def notices(self) -> tuple[StoredNotice, ...]:
        """All that was said, of the timing run too."""
        note = "" if self.timing is None else self.timing.note
        return (*self.warnings, StoredNotice(f"timing: {note}", by="timing")) if note else self.warnings


Entry = TypeVar("Entry", Record, Timing)
_NAME = re.compile(r"[0-9A-Za-z_-]{1,64}")
"""Of a trial and of an answer: files are called by them."""


def plain(entry: Record | Timing) -> dict[str, Any]:
    """A JSON-ready mapping, non-finite numbers as the words 'nan', 'inf', '-inf'; `from_plain` reads it back.

    Not by pydantic, which panics where memory ends.
    """
    mapping: dict[str, Any] = _worded(dataclasses.asdict(entry))
    return mapping


def _worded(value: Any) -> Any:
    """The same value with non-finite numbers as words, which strict JSON lacks."""
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(key): _worded(element) for key, element in value.items()}
    return [_worded(element) for element in value] if isinstance(value, list | tuple) else value


def from_plain(of: type[Entry], mapping: Mapping[str, Any]) -> Entry:
    """What `plain` wrote, each field of its type; fields that are not known are passed over.

    Raises: ValueError, with the field that is none.
    """
    entry: Entry = checked(of, mapping, of.__name__.lower())
    for field_name in ("trial", "trajectory_hash"):
        name = getattr(entry, field_name, None)
        if name is not None and not _NAME.fullmatch(name):
            raise ValueError(f"holds the {field_name} {name[:80]!r}, expected letters and digits")
    return entry
