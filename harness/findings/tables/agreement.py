"""Who agrees in a scene without a truth: the rows of the agreement table, one an engine and track, made from a run folder.

What an engine errs at each step stands beside what that step costs, so that its rows can be joined with prices.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from plumbline.harness.findings.agreement.found import Errors, agreements, errors_of, scenes_to_judge
from plumbline.harness.findings.agreement.happened import end_words, happened_words, happenings
from plumbline.harness.findings.agreement.omissions import Omission, omission_words, omissions
from plumbline.harness.findings.agreement.perturbed_starts import balances, outlooks
from plumbline.harness.findings.agreement.setting_causes import cause_words, settings_turned
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import beyond_words, present_words, scene_words, side_sentence
from plumbline.harness.findings.columns import Column, Table, plain
from plumbline.harness.findings.once import all_once
from plumbline.harness.store.rows import finite
from plumbline.harness.store.store import Store


@dataclass(frozen=True, slots=True, kw_only=True)
class SideVerdict:
    """One engine on one track of a scene.

    Terms: finding: the verdict in a sentence; summary: what is known of the scene, in sentences. errors: of each run from
    coarse to fine, from the agreed limit, from the engine's own where none is; None without an answer. costs: CPU seconds per
    simulated second of each run, None where it was not clocked. lost: what leaving out elements that the user dropped does,
    where the engine was also run with them.
    """

    agreement: Agreement
    side: Side
    finding: str
    summary: tuple[str, ...]
    errors: tuple[Errors | None, ...]
    costs: tuple[float | None, ...]
    lost: Omission | None

    @property
    def where(self) -> str:
        """Parameters, as JSON, if not the case's own."""
        return self.agreement.where

    @property
    def bar(self) -> float | None:
        """Of its own limit, a share of the size."""
        limit = self.side.limit
        return limit.bar_at(limit.until) if limit.bar is not None and limit.until > 0 else None

    @property
    def camp(self) -> str:
        """A letter, several where it is undecided."""
        return " ".join(self.side.camps)

    @property
    def agreed_until(self) -> float | None:
        """Up to there [s] the agreed limit is known."""
        return self.agreement.until if self.agreement.agreed else None

    @property
    def left_out(self) -> str:
        """Kinds of elements that the user dropped and that the engine was also run with."""
        return "" if self.lost is None else " ".join(self.lost.kinds)

    @property
    def omission_until(self) -> float | None:
        """Up to there [s] it is known what leaving them out moves."""
        return None if self.lost is None or self.lost.position is None else self.lost.until

    @property
    def runs(self) -> Mapping[str, str]:
        """What has a value for each run is JSON, as in the table of trials."""
        rungs = self.side.limit.rungs
        lists: Mapping[str, Sequence[object]] = {
            "steps": [rung.dt for rung in rungs],
            "errors": [each and each.error for each in self.errors],
            "offs": [each and each.off for each in self.errors],
            "costs": self.costs,
            "trials": [rung.trial for rung in rungs],
            "summary": self.summary,
        }
        return {name: json.dumps(values) for name, values in lists.items()}


@all_once
def side_verdicts(store: Store) -> Iterator[SideVerdict]:
    """One for each engine and track of each scene without a truth."""
    if store.trials.empty or not scenes_to_judge(store):
        return
    costs = dict(zip(store.trials["trial"], store.trials["cpu_per_sim_s"], strict=True))
    errors, titles = errors_of(store), store.titles
    for agreement in agreements(store):
        lost = omissions(store, agreement)
        summary = (
            *scene_words(agreement, titles),
            *happened_words(happenings(store, agreement), agreement, titles),
            *cause_words(settings_turned(store, agreement), agreement, titles),
            *present_words(agreement, titles),
            *end_words(happenings(store, agreement), store, agreement, titles),
            *beyond_words(balances(store, agreement), outlooks(store, agreement), agreement, titles),
            *omission_words(lost, titles),
        )
        by_side = {(omission.engine, omission.track): omission for omission in lost}
        for side in agreement.sides:
            yield SideVerdict(
                agreement=agreement, side=side, finding=side_sentence(side, agreement, titles), summary=summary,
                errors=tuple(errors.get(rung.trial) for rung in side.limit.rungs),
                costs=tuple(finite(costs.get(rung.trial)) for rung in side.limit.rungs),
                lost=by_side.get((side.engine, side.track)),
            )  # fmt: skip


def _sentences(verdicts: Sequence[SideVerdict]) -> list[str]:
    """What is known of each scene, then the verdict on each engine and track."""
    return [*dict.fromkeys(line for each in verdicts for line in each.summary), *(each.finding for each in verdicts)]


def _verdict(each: SideVerdict) -> str:
    return f"cannot ({each.side.why[:60]})" if each.side.word == "cannot" else each.side.word


TABLE = Table(
    holds="case=agreement.case where engine=side.engine track=side.track ours=side.ours verdict=side.word why=side.why "
    "order=side.limit.said.order bar known_until=side.limit.until horizon=side.limit.said.horizon camp votes=side.votes "
    "distance=side.distance since=side.since agreed=agreement.agreed agreed_until agreed_bar=agreement.bar "
    "size=agreement.scale.largest finding summary=runs.summary steps=runs.steps errors=runs.errors offs=runs.offs "
    "costs=runs.costs trials=runs.trials left_out omission=lost.position omission_turn=lost.angle omission_until",
    objects=side_verdicts,
    shown=(
        Column("scene", lambda each: each.agreement.case.rsplit("/", 1)[-1]),
        *plain("engine=side.engine", "track=side.track"),
        Column("verdict", _verdict),
        *plain("order=side.limit.said.order:.2f", "known to=bar:.2g"),
        Column("until", lambda each: f"{each.side.limit.until:.3g} s" if each.side.limit.until else ""),
        *plain("horizon=side.limit.said.horizon:.3g s", "camp", "away=side.distance:.2g"),
        Column("cost, coarse to fine", lambda each: " ".join("-" if c is None else f"{c:.2g}" for c in each.costs)),
    ),
    sentences=_sentences,
)
