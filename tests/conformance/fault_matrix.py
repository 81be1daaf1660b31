"""Which check of which case catches which planted fault: every fault on every case that it applies to.

The reference engine answers each case soundly, then once with each fault. The page `docs/planted_faults.md` is the answer;

    python -m tests.conformance.fault_matrix

writes it anew, after a case or a fault has changed.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Trajectory
from plumbline.reports.words.glossary import linked
from tests.conformance.put import put
from tests.fresh_faults import faults
from tests.planted_faults import FAULTS, Fault

__all__ = ["FILE", "NAMED", "Catch", "applied", "broken_checks", "caught", "head", "known", "steps", "sound_failures"]

FILE = Path(__file__).parents[2] / "docs" / "planted_faults.md"

NAMED = (
    "gravity_upside_down",
    "friction_five_percent_strong",
    "twice_the_time_step",
    "no_gyroscopic_torque",
    "angular_velocity_in_the_body_frame",
    "inertia_axes_exchanged",
    "hidden_damping",
    "sleeping",
    "state_one_step_behind",
    "noise_from_one_seed",
)
"""The faults that at least two cases have to catch, each by its own checks."""


HEAD = """# Planted faults

An engine is broken in one way, {count} ways in all. `make test` plants every one of them and wants it named by each check that
stands in its row here, which the sound engine passes: checks of the conformance kit, and for faults in readings the cases.

`python -m tests.conformance.fault_matrix` writes this page.

## What names them

| what is broken | fault | named by |
|---|---|---|
{rows}

## Faults that were thought out from the code

`tests/fresh_faults.toml` holds {fresh} more faults of one line, in adapters ({adapter}), in what reads sensors ({sensor}), in
metrics and verdicts ({metric}) and in pages and tables ({page}), each with the check or the tests that see it. They were
thought out from the code after the kit stood, and not from the kit; twelve of them later, from the code written last.

| what lies broken | faults | `plumbline check` alone saw at first | in the end | tests saw at first | in the end |
|---|---|---|---|---|---|
{told}

`python -m tests.fresh_faults` plants each in a copy of the tree and fails where it is not seen by what the table names. Each
check that fails on `tuned` of an engine that is always installed is one of `make test` too, so that tests are put only to what
no check sees; of adapters and sensors:
{slipped}.

What slipped at first is seen by nine checks more (of one limit, of what rays meet, of turned shapes on a body that turns, of a
closed loop, of the lead of forces, of sensors on turned principal axes, of wide beams, of what dry friction bears, of strong
damping of what hangs), by one that looks closer (instability of inertial noise), and by the tests of
`tests/unit/test_drawn_words.py` and `tests/unit/test_trend_charts.py`, of passages, of overlaps, of unstable timings, of the
nights that are read, of turning in the air, of one limit for several scenes and of Bullet's own motors. Of the twelve last ones
four were seen at first, by tests.

## What cases notice

The same faults are put to the cases that should notice them by their nature; here it is the checks of the cases alone that have
to see them. The engine is the reference engine on the `tuned` track, which passes every check of these cases when it is sound.
A fault is looked for at the case's own time step and, where that says nothing, at the finest of its ladder. Behind each check
that failed stand the value found and its bound.

`make test` runs two cases for most of the ten faults that an engine is most likely to have, one for the others, and
`make test-all` every row.

| fault | case | steps per second | checks that failed: value / bound |
|---|---|---|---|"""


@dataclass(frozen=True, slots=True)
class Catch:
    """How a case noticed a fault: at the time step dt [s], by the checks that failed, with value over bound in words."""

    dt: float
    checks: Mapping[str, str]


def broken_checks(
    case: Case,
    adapter: Adapter,
    dt: float,
    spoil: Callable[[Trajectory], Trajectory] = lambda trajectory: trajectory,
    sensors: Callable[[Scene], Scene] = lambda scene: scene,
) -> dict[str, str]:
    """The case's checks that an engine fails on the tuned track at a time step dt [s], each with what was found."""
    answer = put(case, adapter, adapter.tracks["tuned"].with_dt(dt), spoil, sensors=sensors)
    if answer.broke is not None:
        return {"divergence": "1 / 0"}
    return {name: f"{m.value:.2g} / {m.at_most:.2g}" for name, m in answer.broken.items()}


def applied(fault: Fault) -> Iterator[Case]:
    """The cases that should notice a fault."""
    for case in plugins.cases().values():
        if any(fnmatchcase(case.name, pattern) for pattern in fault.cases):
            yield case


def steps(case: Case) -> tuple[float, float]:
    """Where a fault is looked for: at the case's own step, then at the finest of its ladder, where bounds are tightest."""
    return case.dt, min(case.ladder)


@cache
def sound_failures(case: str, dt: float) -> Mapping[str, str]:
    """The checks that the sound engine fails: what it fails, a fault cannot be caught by."""
    return broken_checks(plugins.case(case), plugins.adapter("reference"), dt)


def caught(fault: Fault, case: Case, only: float | None = None) -> Catch | None:
    """How a case notices a fault, at the first step where it does; None where it does not, or where a sound engine fails."""
    for dt in steps(case) if only is None else (only,):
        if sound_failures(case.name, dt):
            return None
        if found := broken_checks(case, fault.plant(plugins.adapter("reference")), dt, fault.spoil, fault.sensors):
            return Catch(dt, found)
    return None


def known() -> dict[tuple[str, str], tuple[float, frozenset[str]]]:
    """The page read back: (fault, case) to the step [s] and the names of the checks that failed there."""
    rows = (line.strip("| \n").split(" | ") for line in FILE.read_text(encoding="utf-8").splitlines() if line.startswith("| `"))
    return {
        (fault.strip("`"), case.strip("`")): (1 / float(rate), frozenset(check.split()[0] for check in checks.split("; ")))
        for fault, case, rate, checks in rows
    }


KINDS = {"adapter": "adapters", "sensor": "what reads sensors", "metric": "metrics and verdicts", "page": "pages and tables"}
AT_FIRST = {"adapter": 12, "sensor": 8, "metric": 20, "page": 7}
"""How many of each kind were seen before anything was done about the rest: by `plumbline check` alone, and by tests."""


def thought_out() -> dict[str, str]:
    """What the page says of the faults that were thought out from the code."""
    fresh = faults()
    counts, checked = Counter(fault.kind for fault in fresh), Counter(fault.kind for fault in fresh if fault.check)
    rows = []
    for kind, words in KINDS.items():
        first, last = f"{AT_FIRST[kind]}", f"{checked[kind] if kind in checked else counts[kind]}"
        cells = (first, last, "", "") if kind in checked else ("", "", first, last)
        rows.append(" | ".join((f"| {words}", f"{counts[kind]}", *cells)) + " |")
    slipped = [f"`{fault.name}`" for fault in fresh if fault.kind in checked and not fault.check]
    return {
        "fresh": f"{len(fresh)}",
        "told": "\n".join(rows),
        "slipped": ",\n".join(slipped),
        **{kind: f"{counts[kind]}" for kind in KINDS},
    }


def head() -> str:
    """The page down to what cases notice."""
    rows = []
    for fault in FAULTS:
        namers = ", ".join(f"`{name}`" for name in fault.seen_by or fault.cases)
        rows.append(f"| {fault.words} | `{fault.name}` | {namers} |")
    return linked(HEAD.format(count=len(FAULTS), rows="\n".join(rows), **thought_out()), "glossary.md")


def page() -> Iterator[str]:
    """The lines of the page."""
    yield from head().splitlines()
    for fault in FAULTS:
        for case in applied(fault):
            found = caught(fault, case)
            told = "nothing" if found is None else "; ".join(f"{name} {what}" for name, what in found.checks.items())
            print(f"{fault.name:40} {case.name:30} {told}")
            if found is not None:
                yield f"| `{fault.name}` | `{case.name}` | {1 / found.dt:g} | {told} |"


if __name__ == "__main__":
    FILE.write_text("\n".join(page()) + "\n", encoding="utf-8")
