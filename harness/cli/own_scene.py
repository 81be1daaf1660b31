"""What a run says at its end of scenes of one's own: who agrees with whom, and nothing that only says that it ended."""

from typing import TYPE_CHECKING

from plumbline.harness.findings import tables

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


def shown_status(case: str, status: str) -> str:
    """The status of a trial as it is shown: in a scene of one's own the only check is that numbers are finite."""
    from plumbline.harness.study.plugins import SCENE_PREFIX

    return "finite" if status == "passed" and case.startswith(SCENE_PREFIX) else status


def closing_count(store: "Store") -> str:
    """How many trials ended how."""
    trials = store.trials
    counts: dict[str, int] = {}
    for case, status in zip(trials["case"], trials["status"], strict=True):
        name = shown_status(str(case), str(status))
        counts[name] = counts.get(name, 0) + 1
    ranked = sorted(counts.items(), key=lambda pair: -pair[1])
    return f"{len(trials)} trials: " + ", ".join(f"{count} {name}" for name, count in ranked)


def closing_words(store: "Store") -> list[str]:
    """The sentences: the verdicts on all engines, what a per cent of error costs, then what of the scene's effects it needs."""
    from plumbline.harness.findings.agreement.costs import cost_words
    from plumbline.harness.findings.recorded_robot import joint_errors, recorded_words

    verdicts, effects = (table.sentences(table.rows(store)) for table in map(tables.table, ("agreement", "effects")))
    return [*verdicts, *recorded_words(joint_errors(store)), *cost_words(store), *effects]
