"""What each effect costs, what its absence does, and whether it was needed: the rows of the effects table."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from plumbline.harness.case.alteration import EVERYTHING, REFINED
from plumbline.harness.findings.columns import Column, Table, bracketed, known, names, outcome, plain, side
from plumbline.harness.findings.cost_point import BlockSample, SampledBlock, ratio_in_blocks, samples_by_block
from plumbline.harness.findings.effects_audit import (
    ALONE,
    AS_IT_IS,
    NOBODY,
    NOT_JUDGED,
    Effects,
    EffectVerdict,
    Matters,
    Word,
    audit,
    named_scene,
    needs,
    own_word,
    proposed,
    savings,
    scenes_of,
)
from plumbline.harness.findings.once import all_once
from plumbline.harness.findings.parameter_words import differing, in_words
from plumbline.harness.search.needless_effects import Consequence, departure, matters, scale_in, weighed
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.store import Store


def verdicts_if_described(store: Store) -> tuple[EffectVerdict, ...]:
    """The same for pages that are not about effects alone: none where the folder has lost the catalogue, which says what
    scenes call for."""
    return verdicts(store) if store.catalogue else ()


@all_once
def verdicts(store: Store) -> Iterator[EffectVerdict]:
    """All rows of a run."""
    trials = store.trials
    trials = trials.assign(departure=[json.loads(text).get("name", "") for text in trials["alteration"]])
    altered = set(trials.loc[trials["departure"] == EVERYTHING, "experiment"])
    chosen = trials[trials["experiment"].isin(altered) & (trials["members"] == 1)]
    samples = samples_by_block(store)
    for case, cells in chosen.groupby("case", sort=False):
        named = _where(cells["parameters"], store.described("cases", str(case))["parameters"])
        for parameters, scenes in cells.groupby("parameters", sort=False):
            needed = _needed(store, scenes)
            for (engine, track), group in scenes.groupby(["engine", "track"], sort=False):
                yield from _of_side(store, str(engine), str(track), named[str(parameters)], group, needed, samples)


Sampled = Mapping[str, Mapping[SampledBlock, BlockSample]]


def _where(parameters: Iterable[str], own: Mapping[str, Any]) -> dict[str, str]:
    """By parameters (JSON) of a case, what tells them apart and from the case as it is, in words."""
    read = {text: json.loads(text) for text in dict.fromkeys(parameters)}
    loose = sorted(differing(read.values(), own))
    return {text: in_words({name: values[name] for name in loose if name in values}) for text, values in read.items()}


def _runs(group: pd.DataFrame) -> dict[str, Any]:
    """A side's runs by the name of their departure."""
    return {row.departure: row for row in group.itertuples()}


def _needed(store: Store, scenes: pd.DataFrame) -> dict[Effects, Matters]:
    """By effects, whether they matter in a scene, where the truth or several engines say so on their tuned tracks."""
    tuned = scenes[scenes["track"] == "tuned"]
    sides = {str(engine): _runs(group) for engine, group in tuned.groupby("engine", sort=False)}
    return needs(store, sides, store.described("cases", scenes["case"].iloc[0])["effects"])


def _of_side(
    store: Store,
    engine: str,
    track: str,
    where: str,
    group: pd.DataFrame,
    needed: Mapping[Effects, Matters],
    samples: Sampled,
) -> Iterator[EffectVerdict]:
    runs = _runs(group)
    plain = runs.get("")
    if plain is None:
        return
    cell = {"case": plain.case, "where": where, "engine": engine, "track": track}
    about = store.described("cases", plain.case)
    declared, insists = set(about["effects"]), about.get("insists", {})
    scale = scale_in(store, runs)
    notices = [notice for notice in store.notices[plain.trial] if notice.effect]

    def row(
        subject: str | tuple[str, ...],
        run: Any,
        consequence: Consequence | None,
        verdict: str,
        price: Interval | None,
        reason: str = "",
        need: Matters = NOBODY,
    ) -> EffectVerdict:
        effects = () if isinstance(subject, str) else subject
        return EffectVerdict(
            **cell,
            effect=subject if isinstance(subject, str) else ", ".join(subject),
            effects=effects,
            declared=declared.issuperset(effects) and bool(effects),
            insists=str(insists.get(effects[0], "")) if len(effects) == 1 else "",
            cost=price,
            cpu_as_it_is=None if pd.isna(plain.cpu_per_sim_s) else float(plain.cpu_per_sim_s),
            verdict=verdict,
            judge=need.judge,
            against=", ".join(need.against),
            reason=reason,
            trial=str(run.trial),
            **known(consequence, "moved", "own", "matters"),
        )

    if plain.status not in ("passed", "failed"):
        yield row(AS_IT_IS, plain, None, plain.status, None, plain.reason)
        return
    surplus, missing = (
        {notice.effect: notice.text for notice in notices if notice.kind == kind} for kind in ("surplus", "missing")
    )
    for name, run in runs.items():
        departed = departure(run)
        effects = departed.single.names
        if name in ("", *REFINED) or (departed.widen and effects[0] in surplus):
            continue  # what cannot be switched off is told by its notice, below
        if run.status in ("unsupported", "unavailable", "timeout", "oom", "crashed"):
            yield row(effects or name, run, None, run.status, None, run.reason)
            continue
        consequence = weighed(departed, matters(store, plain, run, scale), plain, run, declared)
        if name == EVERYTHING:
            yield row(name, run, consequence, name, _price(run, plain, samples))
            continue
        taken_in = bool(departed.widen)
        price = _price(run, plain, samples) if taken_in else _price(plain, run, samples)
        need = needed.get(effects) or _of_itself(engine, own_word(store, runs, run, scale, declared))
        (effect,) = effects if len(effects) == 1 else ("",)
        if effect in insists and not taken_in and effect not in missing:
            verdict, reason = "insisted on", str(insists[effect])
        elif need.matters is None:
            verdict, reason = NOT_JUDGED, need.doubt
        elif not effect:
            verdict, reason = ("needed together" if need.matters else "left out together"), ""
        elif effect in missing:
            verdict, reason = ("needed but missing" if need.matters else "missing without need"), missing[effect]
        elif taken_in:
            verdict, reason = ("needed but missing" if need.matters else "left out"), ""
        else:
            verdict, reason = ("needed and on" if need.matters else "paid for without need"), ""
        yield row(effects, run, consequence, verdict, price, reason, need)
    for effect, text in surplus.items():
        if effect not in declared:
            yield row((effect,), plain, None, "cannot be switched off", None, text)


def _of_itself(engine: str, word: Word | None) -> Matters:
    """What an engine says where it speaks for itself."""
    if word is None:
        return NOBODY
    return Matters(word.consequence.matters, f"{engine}: {word.doubt}" if word.doubt else "", f"{engine} {ALONE}")


def _price(cost: Any, base: Any, samples: Sampled) -> Interval | None:
    """CPU time of a unit of one run over that of another, in the blocks that both were sampled in."""
    return ratio_in_blocks(samples.get(cost.trial, {}), samples.get(base.trial, {}))


def sentences(rows: Sequence[EffectVerdict], *, accusing: bool = True, titles: Mapping[str, str] | None = None) -> list[str]:
    """What leaving effects out saves, engine by engine, and what the audit says.

    Args: accusing: of each scene that fails it too. titles: what engines and cases are called, by name.
    """
    lines = []
    for saving in savings(rows):
        added = "" if saving.summed is None else f"; a simulated second of each, added up, {saving.summed:.3g} times"
        several = f" (geometric mean over {saving.scenes} scenes, {saving.low:.3g} to {saving.high:.3g}{added})"
        lines.append(
            f"{(titles or {}).get(saving.engine, saving.engine)}: a step with everything on costs {saving.mean:.3g} times that "
            f"of the scene as it is{several if saving.scenes > 1 else ''}."
        )
    audited = audit(rows)
    if audited.scenes:
        beside = f"; {audited.in_doubt} more are not judged in full" if audited.in_doubt else ""
        call = f"{audited.clean} of {audited.scenes} scenes call for exactly what they need"
        if audited.clean == audited.scenes == 1 and not audited.in_doubt:
            call = "the scene calls for exactly what it needs"
        lines.append(f"Audit: {call}{beside}. {audited.judges(titles)}.")
    spoken = (*(audited.sentences(titles) if accusing else ()), *audited.dissent(titles), *audited.doubts(titles))
    lines += [f"Audit: {sentence}." for sentence in spoken]
    return lines + [proposal for scene in scenes_of(audited.failed) if (proposal := proposed(scene, audited.judged))]


TABLE = Table(
    # the cell `effect` holds the names of `effects`
    holds=names(EffectVerdict, "effects").replace("cost..", "cost(low,high)"),
    beside="effects",
    objects=verdicts,
    shown=(
        Column("case", named_scene),
        Column("engine", side),
        Column("effect", "effect"),
        Column("cost", lambda row: "" if row.cost is None else f"x {row.cost.value:.3g} ({bracketed(row.cost, '.3g', '..')})"),
        *plain("moves=moved:.2g", "own error=own:.2g"),
        Column("verdict", lambda row: row.verdict if row.verdict == "insisted on" else outcome(row, 70)),
    ),
    sentences=sentences,
)
