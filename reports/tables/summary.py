"""The findings of a run in sentences, made from the tables alone."""

from collections import Counter

from plumbline.harness.findings.emulations import whose
from plumbline.harness.findings.limits_found import searches_if_described
from plumbline.harness.findings.standing import axis_leads, reaches
from plumbline.harness.findings.standing import leaders as first_of
from plumbline.harness.findings.tables import determinism, effects
from plumbline.harness.findings.tables.orders import convergences
from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import NO_REASON, Glance, glances, leads
from plumbline.reports.tables.own_scenes import by_case, summary
from plumbline.reports.tables.verdicts import CaseVerdict, verdicts
from plumbline.reports.words.catalogue import cases, compared_tracks, engines, setting_words, titles
from plumbline.reports.words.catalogue import ours as yardsticks
from plumbline.reports.words.known_findings import disputed
from plumbline.reports.words.status import FINITE, STATUSES
from plumbline.reports.words.text import TIMES, amount, join_words, plural

WORDS = {"order": "the order of its integrator", "own law": "a law that the others lack", "defaults": "the vendors' defaults"}
"""What an advantage is called in a sentence, where its name is too short."""


def sentences(store: Store) -> list[str]:
    """The summary, most important first; a sentence without anything to say is left out."""
    if store.trials.empty:
        return ["The store holds no trial."]
    own = by_case(store)
    seen, cells = glances(store), {key: cell for key, cell in verdicts(store).items() if key[0] not in own}
    agreed = [f"{cases(store)[name]['title']}: {sentence}" for name in own for sentence in summary(store, name)]
    if not cells:
        return [*agreed, *studied(store), *silence(store), size(store)]
    written = [
        *agreed,
        *leaders(store, seen),
        *price(store, seen),
        *beside(store),
        *tuning(store, cells),
        *extremes(store, cells),
        *promises(store),
    ]
    return [
        *written,
        *studied(store),
        *ours(store, cells),
        *standing_beside(store, seen),
        *leading(store),
        *silence(store),
        size(store),
    ]


def studied(store: Store) -> list[str]:
    """What the studies of limits, effects and determinism say in a line each; their pages say the rest."""
    written = []
    if sentence := farthest(store):
        written.append(sentence)
    if rows := effects.verdicts_if_described(store):
        written += effects.sentences(rows, accusing=False, titles=titles(store))
    if repeated := determinism.repetitions(store):
        written += determinism.sentences(repeated, titles(store))
    return written


def farthest(store: Store) -> str:
    """How often each engine that people can deploy goes farthest at equal sub-steps; '' without limits."""
    at_equal = [lead for lead in axis_leads(reaches(searches_if_described(store))) if lead.at == "equal sub-step"]
    if not at_equal:
        return ""
    titles, condition = engines(store), at_equal[-1].condition
    level = [lead for lead in at_equal if lead.condition == condition]
    ranked = sorted((lead for lead in level if not lead.ours), key=lambda lead: -(lead.alone + lead.shared))
    counted = ", ".join(f"{titles[lead.engine]['title']} {lead.alone + lead.shared}" for lead in ranked)
    return (
        f"Of {plural(max(lead.of for lead in level), 'axis', 'axes')} along which cases were made harder, at sub-steps of "
        f"{condition}, farthest alone or with others: {counted}."
    )


def leading(store: Store) -> list[str]:
    """In how many cases the reference engine errs least, and by what."""
    by_track: dict[str, Counter[str]] = {}
    for lead in leads(store).values():
        by_track.setdefault(lead.track, Counter())[lead.by] += 1
    written = []
    for track, counts in by_track.items():
        given = [f"{WORDS.get(by, by)} in {count}" for by, count in counts.most_common() if by != NO_REASON]
        parts = [f"by {join_words(given)}"] if given else []
        parts += [f"with {NO_REASON} in {counts[NO_REASON]}"] if counts[NO_REASON] else []
        written.append(
            f"On the {track} track the reference engine is most accurate in {plural(counts.total(), 'case')}: "
            f"{', '.join(parts)}; their pages say more."
        )
    return written


def size(store: Store) -> str:
    """How much was run, and how it ended."""
    own, statuses = store.trials["case"].isin(list(by_case(store))), store.trials["status"]
    counts = statuses.mask(own & (statuses == "passed"), FINITE.name).value_counts()
    ended = join_words(f"{int(counts[name])} {name}" for name in (*STATUSES, FINITE.name) if name in counts)
    return (
        f"{plural(len(store.trials), 'trial')} of {plural(len(cases(store)), 'case')} on "
        f"{plural(len(engines(store)), 'engine')}: {ended}."
    )


def leaders(store: Store, seen: list[Glance]) -> list[str]:
    """Who passes most cases of the engines that people can deploy, on each track."""
    titles = {name: engine["title"] for name, engine in engines(store).items()}
    written = []
    for track in reversed(compared_tracks(store)):
        answered = [
            glance
            for glance in seen
            if glance.track == track and glance.cases > glance.counts["unavailable"] + glance.counts["unsupported"]
        ]
        judged = [glance for glance in answered if glance.engine not in yardsticks(store) and glance.asked]
        if len(judged) < 2:
            continue
        share = {glance.engine: glance.held / glance.asked for glance in judged}
        order = sorted(judged, key=lambda glance: -share[glance.engine])
        most = first_of({engine: (value, value) for engine, value in share.items()})
        first = [glance for glance in order if glance.engine in most]
        names = join_words(titles[glance.engine] for glance in first)
        rest = "; ".join(f"{titles[glance.engine]} {glance.held}/{glance.asked}" for glance in order[len(first) :])
        written.append(
            f"On the {track} track {names} {'passes' if len(first) == 1 else 'pass'} most cases at their nominal time step: "
            f"{first[0].held} of {first[0].asked}{' each' if len(first) > 1 else ''}"
            f"{f' ({rest})' if rest else ''}."
        )
    return written


def price(store: Store, seen: list[Glance]) -> list[str]:
    """Who is cheapest where all answered, and in the same breath whose errors are the smallest."""
    track = next(reversed(compared_tracks(store)), "")
    priced = [glance for glance in seen if glance.track == track and glance.relative_cost is not None]
    if len(priced) < 2:
        return []
    cost = ranked(store, {glance.engine: glance.relative_cost for glance in priced if glance.relative_cost is not None})
    error = ranked(
        store,
        {
            glance.engine: glance.relative_error
            for glance in seen
            if glance.track == track and glance.relative_error is not None
        },
    )
    shared = plural(priced[0].shared, "case")
    return [f"What accuracy costs, {track}, over the {shared} that all of them share: in CPU time {cost}; in error {error}."]


def beside(store: Store) -> list[str]:
    """Why settings that the study names beside the two tracks are in no ranking."""
    named = store.trials[["engine", "track"]][store.trials["round"] == 0].drop_duplicates()
    count = int((~named["track"].isin(compared_tracks(store))).sum())
    if not count:
        return []
    verb = "is one engine's own and is" if count == 1 else "are each one engine's own and are"
    return [
        f"{plural(count, 'setting')} beside the two tracks {verb} not ranked here; the verdicts and the pages of cases show "
        f"{'it' if count == 1 else 'them'}."
    ]


def ranked(store: Store, ratios: dict[str, float]) -> str:
    """'A 1x, B 2.3x': the engines that people can deploy from the best, relative to the best of each case."""
    titles = engines(store)
    order = sorted((name for name in ratios if name not in yardsticks(store)), key=lambda name: ratios[name])
    return ", ".join(f"{titles[name]['title']} {amount(ratios[name], 2)}{TIMES}" for name in order) or "none measured"


def tuning(store: Store, cells: dict[tuple[str, str, str], CaseVerdict]) -> list[str]:
    """What tuning changes, in whole cases."""
    if len(compared_tracks(store)) < 2:
        return []
    changed = []
    for name, engine in engines(store).items():
        pairs = [(cells.get((case, name, "default")), cells.get((case, name, "tuned"))) for case in cases(store)]
        gained = sum(bool(d and t and d.worst.name != "passed" and t.worst.name == "passed") for d, t in pairs)
        lost = sum(bool(d and t and d.worst.name == "passed" and t.worst.name != "passed") for d, t in pairs)
        if gained or lost:
            changes = [f"{verb} {count}" for verb, count in (("gains", gained), ("loses", lost)) if count]
            changed.append(f"{engine['title']} {' and '.join(changes)}")
    if not changed:
        return ["Tuning changes no case from not passed to passed, on any engine."]
    return [f"Cases that pass in full once an engine is tuned, against its defaults: {'; '.join(changed)}."]


def extremes(store: Store, cells: dict[tuple[str, str, str], CaseVerdict]) -> list[str]:
    """The cases that all pass, and those that nobody passes."""
    everybody, nobody = [], []
    for name, case in cases(store).items():
        judged = [cell for (of, _, _), cell in cells.items() if of == name and any(o.answered for o, _ in cell.counts)]
        if len(judged) > 1 and all(cell.worst.name == "passed" for cell in judged):
            everybody.append(case["title"])
        if judged and not any(o.name == "passed" for cell in judged for o, _ in cell.counts):
            nobody.append(case["title"])
    written = []
    if nobody:
        names = join_words(f"“{title}”" for title in nobody[:4])
        written.append(f"At no step and setting that was run does any engine pass {names}{more(nobody)}.")
    if everybody:
        written.append(
            f"Every engine that answers passes {join_words(f'“{title}”' for title in everybody[:4])}{more(everybody)}."
        )
    return written


def promises(store: Store) -> list[str]:
    """Whose errors do not shrink with the step as the integrator promises; each has a sentence on its case's page."""
    ladders = [row for row in convergences(store) if row.promised is not None and row.verdict != "open"]
    broken: dict[tuple[str, str], list[str]] = {}
    for row in ladders:
        if row.verdict == "broken":
            law = whose(store.catalogue, row.engine, row.case, row.track)
            words = ", ".join(word for word in (law, "disputed" if disputed(store, row.engine, row.case) else "") if word)
            quoted = f"“{cases(store)[row.case]['title']}”{f' ({words})' if words else ''}"
            broken.setdefault((row.engine, row.track), []).append(quoted)
    if not ladders:
        return []
    if not broken:
        return [
            f"The order of convergence that an integrator promises is kept on all {plural(len(ladders), 'ladder')} that tell."
        ]
    parts = [
        f"{engines(store)[engine]['title']} ({setting_words(store, engine, track)}) in {join_words(titles[:4])}{more(titles)}"
        for (engine, track), titles in broken.items()
    ]
    count = sum(map(len, broken.values()))
    return [
        f"Errors shrink less with the time step than the integrator promises on {count} of {plural(len(ladders), 'ladder')}: "
        f"{'; '.join(parts)}."
    ]


def more(titles: list[str]) -> str:
    """A tail for a list that was cut to four."""
    return f" and {len(titles) - 4} more" if len(titles) > 4 else ""


def ours(store: Store, cells: dict[tuple[str, str, str], CaseVerdict]) -> list[str]:
    """The reference engine's failures, by name: nobody should have to look for them."""
    written = []
    for name, engine in engines(store).items():
        if engine["ours"] and any(of == name and track == "tuned" for _, of, track in cells):
            short = [
                cases(store)[case]["title"]
                for (case, of, track), cell in cells.items()
                if of == name and track == "tuned" and cell.worst.name != "passed"
            ]
            written.append(
                f"{engine['title']} is ours; tuned, it falls short in {join_words(f'“{t}”' for t in short[:4])}{more(short)}."
                if short
                else f"{engine['title']} is ours; tuned, it passes every trial that was put to it."
            )
    return written


def standing_beside(store: Store, seen: list[Glance]) -> list[str]:
    """What the reference engine costs and errs on the scale of those that people can deploy: in no headline."""
    return [
        f"Beside them {engines(store)[glance.engine]['title']}, {glance.track}, takes {amount(glance.relative_cost, 2)}{TIMES} "
        f"the CPU time of the cheapest of each case, at {amount(glance.relative_error, 2)}{TIMES} the smallest error."
        for glance in seen
        if glance.engine in yardsticks(store) and None not in (glance.relative_cost, glance.relative_error)
    ]


def silence(store: Store) -> list[str]:
    """What the reader should not rely on: engines that were away, and noisy clocks."""
    written = [
        f"{engine['title']} was unavailable: {engine['unavailable']}"
        for engine in engines(store).values()
        if engine["unavailable"]
    ]
    timed = store.trials["unstable_timing"].dropna()
    if (noisy := int(timed.astype(bool).sum())) > 0:
        written.append(f"{noisy} of {plural(len(timed), 'timing')} were noisy and are marked unstable.")
    return written
