"""Scenes of one's own in the report: who they are, their verdicts as chips, and what is known of them in sentences."""

from collections.abc import Mapping

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.happened import end_words, happened_words, happenings
from plumbline.harness.findings.agreement.omissions import omission_words, omissions
from plumbline.harness.findings.agreement.setting_causes import cause_words, settings_turned
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.agreement.words import present_words, scene_words, side_words
from plumbline.harness.findings.once import once
from plumbline.harness.findings.tables.recorded import joint_errors, recorded_words
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import titles
from plumbline.reports.words.status import FINITE, VERDICTS, StatusWord, outcome


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
