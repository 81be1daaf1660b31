"""The robots of a zoo on a page: those that were run with a cell for each engine, the others with their reason."""

from collections.abc import Mapping
from dataclasses import dataclass

from plumbline.harness.findings.tables.zoo import RUNS, InZoo, in_zoo
from plumbline.harness.store.store import Store
from plumbline.reports.words.status import VERDICTS, StatusWord

NOT_RUN = StatusWord(name="not run", symbol="○", meaning="the engine takes the robot, and time was up before it ran", rank=2)
STAGES = {
    "not here": "its files are not on this machine and could not be fetched",
    "not read": "reading its files did not end",
    "refused": "its files are refused",
    "no engine": "no engine can build it",
}
"""How far those came that do not go in, in words."""


@dataclass(frozen=True, slots=True)
class ZooCell:
    """One engine and a robot. Terms: outcome: as a chip. why: in words, '' where nothing is to be said. drops: what this engine
    alone would have to have left out, in words."""

    of: InZoo
    outcome: StatusWord
    why: str
    drops: str


@dataclass(frozen=True, slots=True)
class Inside:
    """A robot that was run. Terms: about: what its engines share. left_out: in words, '' for nothing. cells: by engine."""

    about: InZoo
    left_out: str
    cells: Mapping[str, ZooCell]

    @property
    def runs_on(self) -> str:
        """On how many engines it ran to its end, in words."""
        count = sum(cell.of.verdict in RUNS for cell in self.cells.values())
        return f"on {count} of {len(self.cells)} engines"


def inside(store: Store) -> list[Inside]:
    """The robots that were run, in the order of their names."""
    return [
        Inside(rows[0], kinds(rows[0].dropped), {each.engine: _cell(each) for each in rows})
        for rows in _by_robot(store)
        if any(each.verdict for each in rows)
    ]


def waiting(store: Store) -> list[InZoo]:
    """The robots that go in and of which nothing was run, each with the reason."""
    groups = (rows for rows in _by_robot(store) if not any(each.verdict for each in rows))
    return [next(each for each in rows if each.enters) for rows in groups]


def _by_robot(store: Store) -> list[list[InZoo]]:
    """The rows of each robot that goes in."""
    by_robot: dict[str, list[InZoo]] = {}
    for each in in_zoo(store):
        if each.stage == "in":
            by_robot.setdefault(each.robot, []).append(each)
    return [*by_robot.values()]


def outside(store: Store) -> list[InZoo]:
    """The robots that do not go in: those that are refused first, and last those that are not on this machine."""
    order = ("refused", "not read", "no engine", "not here")
    return sorted((each for each in in_zoo(store) if not each.engine), key=lambda each: (order.index(each.stage), each.robot))


def kinds(text: str) -> str:
    """Kinds of elements in words: 'armature, self collision'."""
    return ", ".join(kind.replace("_", " ") for kind in text.split())


def _cell(each: InZoo) -> ZooCell:
    outcome = VERDICTS["cannot"] if not each.enters else VERDICTS.get(each.verdict, NOT_RUN)
    return ZooCell(each, outcome, each.reason, kinds(each.drops))
