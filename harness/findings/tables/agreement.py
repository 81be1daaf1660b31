"""Who agrees in a scene without a truth: the rows of the agreement table, one an engine and track, made from a run folder.

What an engine errs at each step stands beside what that step costs, so that its rows can be joined with prices.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from plumbline.harness.findings.agreement.found import agreements, errors_of, scenes_to_judge
from plumbline.harness.findings.agreement.happened import end_words, happened_words, happenings
from plumbline.harness.findings.agreement.omissions import Omission, omission_words, omissions
from plumbline.harness.findings.agreement.perturbed_starts import balances, outlooks
from plumbline.harness.findings.agreement.setting_causes import cause_words, settings_turned
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import beyond_words, present_words, scene_words, side_sentence
from plumbline.harness.findings.columns import Column, Row, Table, known, plain
from plumbline.harness.store.store import Store

COLUMNS = (
    "case", "where", "engine", "track", "ours", "verdict", "why", "order", "bar", "known_until", "horizon", "camp",
    "votes", "distance", "since", "agreed", "agreed_until", "agreed_bar", "size", "finding", "summary", "steps",
    "errors", "offs", "costs", "trials", "left_out", "omission", "omission_turn", "omission_until",
)  # fmt: skip


def _verdicts(store: Store) -> list[dict[str, Any]]:
    """One row for each engine and track of each scene without a truth."""
    if store.trials.empty or not scenes_to_judge(store):
        return []
    costs = dict(zip(store.trials["trial"], store.trials["cpu_per_sim_s"], strict=True))
    titles = store.titles
    table = []
    for agreement in agreements(store):
        lost = omissions(store, agreement)
        summary = [
            *scene_words(agreement, titles),
            *happened_words(happenings(store, agreement), agreement, titles),
            *cause_words(settings_turned(store, agreement), agreement, titles),
            *present_words(agreement, titles),
            *end_words(happenings(store, agreement), store, agreement, titles),
            *beyond_words(balances(store, agreement), outlooks(store, agreement), agreement, titles),
            *omission_words(lost, titles),
        ]
        by_side = {(omission.engine, omission.track): omission for omission in lost}
        table += [
            _row(
                store,
                agreement,
                side,
                costs,
                side_sentence(side, agreement, titles),
                summary,
                by_side.get((side.engine, side.track)),
            )
            for side in agreement.sides
        ]
    return table


def _row(
    store: Store,
    agreement: Agreement,
    side: Side,
    costs: Mapping[str, float],
    finding: str,
    summary: list[str],
    lost: Omission | None,
) -> dict[str, Any]:
    """One engine on one track.

    Terms:
        where: parameters, as JSON, if not the case's own. ours: is it the reference engine, which has no vote? verdict: agrees,
        converges elsewhere, converges (where no limit is agreed), does not converge, diverged, cannot; why: of the last three.
        order: of convergence, None without one. bar: of its own limit, a share of the size; known_until [s]: up to there.
        horizon [s]: up to there its last halving moves the answer by no more than a hundredth. camp: a letter, several where it
        is undecided. votes: does it count for its engine? distance: of its limit from the agreed one, a share of the size;
        since [s]: from then on beyond the bars. agreed: the camp whose limit is agreed on; agreed_until [s], agreed_bar: how
        long and how well it is known. size [m]: of the largest whole that moves.
        finding: the verdict in a sentence; summary: what is known of the scene, in sentences.
        steps [s], errors, offs, costs, trials: of each run from coarse to fine; error: from the agreed limit, from the
        engine's own where none is; off: of that limit; cost: CPU seconds per simulated second, None where it was not clocked.
        left_out: kinds of elements that the user dropped and that the engine was also run with, '' where it was not.
        omission [m], omission_turn [rad]: how far that moves any body up to omission_until [s]; None where it is not known.
    """
    limit, errors = side.limit, errors_of(store)
    measured = [errors.get(rung.trial) for rung in limit.rungs]
    clocked = [costs.get(rung.trial) for rung in limit.rungs]
    return {
        "case": agreement.case,
        "where": agreement.where,
        "engine": side.engine,
        "track": side.track,
        "ours": side.ours,
        "verdict": side.word,
        "why": side.why,
        **known(limit.said, "order", "horizon"),
        "bar": limit.bar_at(limit.until) if limit.bar is not None and limit.until > 0 else None,
        "known_until": limit.until,
        "camp": " ".join(side.camps),
        "votes": side.votes,
        "distance": side.distance,
        "since": side.since,
        "agreed": agreement.agreed,
        "agreed_until": agreement.until if agreement.agreed else None,
        "agreed_bar": agreement.bar,
        "size": agreement.scale.largest,
        "finding": finding,
        "summary": summary,
        "steps": [rung.dt for rung in limit.rungs],
        "errors": [None if each is None else each.error for each in measured],
        "offs": [None if each is None else each.off for each in measured],
        "costs": [None if each is None or pd.isna(each) else float(each) for each in clocked],
        "trials": [rung.trial for rung in limit.rungs],
        "left_out": "" if lost is None else " ".join(lost.kinds),
        "omission": None if lost is None else lost.position,
        "omission_turn": None if lost is None else lost.angle,
        "omission_until": None if lost is None or lost.position is None else lost.until,
    }


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """What has a value for each run is JSON, as in the table of trials."""
    return {name: json.dumps(row[name]) if isinstance(row[name], list) else row[name] for name in COLUMNS}


def _sentences(rows: Sequence[Row]) -> list[str]:
    """What is known of each scene, then the verdict on each engine and track."""
    lines: list[str] = []
    for row in rows:
        lines += [sentence for sentence in json.loads(row["summary"]) if sentence not in lines]
    return lines + [row["finding"] for row in rows]


def _costs(row: Row) -> str:
    return " ".join("-" if cost is None else f"{cost:.2g}" for cost in json.loads(row["costs"]))


TABLE = Table(
    columns=COLUMNS,
    objects=_verdicts,
    row=_flat,
    shown=(
        Column("scene", lambda row: row["case"].rsplit("/", 1)[-1]),
        *plain("engine", "track"),
        Column("verdict", lambda row: f"cannot ({row['why'][:60]})" if row["verdict"] == "cannot" else row["verdict"]),
        Column("order", "order", ".2f"),
        Column("known to", "bar", ".2g"),
        Column("until", lambda row: f"{row['known_until']:.3g} s" if row["known_until"] else ""),
        Column("horizon", "horizon", ".3g", " s"),
        Column("camp", "camp"),
        Column("away", "distance", ".2g"),
        Column("cost, coarse to fine", _costs),
    ),
    sentences=_sentences,
)
