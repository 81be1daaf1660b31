"""What the gate of a run is about: the reference engine's checks, its determinism, the audit of effects, and tuned tracks."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


def failures(store: "Store") -> list[str]:
    """What the gate is about: the reference engine's checks on the tuned track and its determinism, the audit of effects, and
    tuned tracks of all engines that a change of one knob beats without a reason."""
    from plumbline.harness.findings.effects_audit import JUDGE, audit
    from plumbline.harness.findings.steps_taken import step_in_words, substeps_of
    from plumbline.harness.findings.tables import determinism, dominance
    from plumbline.harness.findings.tables.effects import TABLE

    ours = [name for name in store.trials["engine"].unique() if store.described("engines", name)["ours"]]
    # Bounds are meant for the steps that a study names, not for those that a sweep goes on to.
    trials = store.asked[store.asked["round"] == 0]
    broken = trials[
        trials["engine"].isin(ours) & (trials["track"] == "tuned") & ~trials["status"].isin(("passed", "unsupported"))
    ]
    sentences = [
        f"gate: {row.case} on {row.engine}/{row.track} at dt {step_in_words(row.dt, substeps_of(str(row.resolved)))}: "
        f"{row.status}: {row.reason}"
        for row in broken.itertuples()
    ]
    sentences += [f"determinism: {sentence}" for sentence in determinism.broken(determinism.repetitions(store), ours)]
    # Another engine that stands in for the judge may see worse than it: its word is in the table, and gates nothing.
    judged = audit([row for row in TABLE.rows(store) if row["engine"] == JUDGE])
    sentences += [f"audit: {sentence}" for sentence in judged.sentences()]
    return sentences + [f"dominance: {sentence}" for sentence in dominance.unexcused(store)]
