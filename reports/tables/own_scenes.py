"""Scenes of one's own in the report: who they are, their verdicts as chips, and what is known of them in sentences.

The robots of a zoo on a page: those that go in with a cell for each engine, those that do not with their reason.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.happened import end_words, happened_words, happenings
from plumbline.harness.findings.agreement.omissions import omission_words, omissions
from plumbline.harness.findings.agreement.setting_causes import cause_words, settings_turned
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.agreement.words import present_words, scene_words, side_words
from plumbline.harness.findings.once import once
from plumbline.harness.findings.tables.recorded import joint_errors, recorded_words
from plumbline.harness.findings.tables.zoo import RUNS, InZoo, in_zoo
from plumbline.harness.store.store import Store
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import titles
from plumbline.reports.words.status import FINITE, NOT_RUN, VERDICTS, StatusWord, outcome


@once
def by_case(store: Store) -> Mapping[str, tuple[Agreement, ...]]:
    """The agreements on each scene that is judged by them: one for each set of parameters."""
    by_scene: dict[str, tuple[Agreement, ...]] = {}
    for agreement in agreements(store):
        by_scene[agreement.case] = (*by_scene.get(agreement.case, ()), agreement)
    return by_scene


def chips(store: Store) -> Mapping[tuple[str, str, str], tuple[StatusWord, str]]:
    """By case, engine and track: the verdict, and it in words."""
    return {
        (agreement.case, side.engine, side.track): (VERDICTS[side.word], side_words(side, agreement))
        for agreement in agreements(store)
        for side in agreement.sides
    }


def summary(store: Store, case: str) -> list[str]:
    """What is known of a scene, in sentences."""
    return [
        sentence
        for agreement in by_case(store).get(case, ())
        for sentence in (
            *scene_words(agreement, titles(store)),
            *happened_words(happenings(store, agreement), agreement, titles(store)),
            *cause_words(settings_turned(store, agreement), agreement, titles(store)),
            *present_words(agreement, titles(store)),
            *end_words(happenings(store, agreement), store, agreement, titles(store)),
            *omission_words(omissions(store, agreement), titles(store)),
            *recorded_words([each for each in joint_errors(store) if each.case == case], titles(store)),
        )
    ]


def shown(name: str) -> StatusWord:
    """A status of a trial of such a scene: 'passed' says no more than that its numbers are finite."""
    return FINITE if name == "passed" else outcome(name)


STAGES = WORDS["stages"]
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
