"""What a run says at its end of scenes of one's own: who agrees with whom, and nothing that only says that it ended."""

from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.listing import print_table
from plumbline.harness.findings import tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from plumbline.harness.case import Case
    from plumbline.harness.run.waiting_time import Waiting
    from plumbline.harness.store.record import Record
    from plumbline.harness.store.store import Store


def shown_status(case: str, status: str) -> str:
    """The status of a trial as it is shown: in a scene of one's own the only check is that numbers are finite."""
    from plumbline.harness.study.plugins import SCENE_PREFIX

    return "finite" if status == "passed" and case.startswith(SCENE_PREFIX) else status


def waiting(cases: "Mapping[str, Case]", folder: Path, budget: float | None) -> "Waiting":
    """What ends a run of a scene of one's own after its budget of waiting time [s], with a first look on the way."""
    from plumbline.harness.run.waiting_time import Waiting
    from plumbline.harness.study.study import BUDGET

    total = BUDGET if budget is None else budget
    return Waiting(total, cases, lambda records: _first_look(folder, records, total))


def _first_look(folder: Path, records: "Sequence[Record]", budget: float) -> None:
    """Print who lies together at the first steps. The tables of the run are written at its end; these lie in a folder of their
    own."""
    from tempfile import TemporaryDirectory

    from plumbline.harness.findings.agreement.found import agreements
    from plumbline.harness.findings.agreement.happened import COLUMNS, rows_so_far, words_so_far
    from plumbline.harness.run.waiting_time import elapsed, since_begun
    from plumbline.harness.store.store import Store
    from plumbline.harness.store.stored_tables import in_order, write_tables

    with TemporaryDirectory() as name:
        look = Path(name)
        for stored in ("trajectories", "catalogue.json", "study.toml", "machine.json"):
            (look / stored).symlink_to((folder / stored).resolve())
        write_tables(look, in_order(records))
        store = Store(look)
        rows = [row for agreement in agreements(store) for row in rows_so_far(agreement)]
        print_table(f"first look after {elapsed(since_begun())}: three steps each, no verdict yet", COLUMNS, rows)
        for agreement in agreements(store):
            for sentence in words_so_far(store, agreement, store.titles):
                say(sentence, err=True)
        say(f"refined until {elapsed(budget)} are over", err=True)


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
    from plumbline.harness.findings.agreement.costs import best_setting, cost_words
    from plumbline.harness.findings.agreement.found import agreements
    from plumbline.harness.findings.tables.recorded import joint_errors, recorded_words

    verdicts, effects = (table.said(store) for table in map(tables.table, ("agreement", "effects")))
    best = [f"Set: {words}" for agreement in agreements(store) if (words := best_setting(store, agreement))]
    return [*verdicts, *recorded_words(joint_errors(store), store.titles), *cost_words(store), *best, *effects]
