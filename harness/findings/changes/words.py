"""What changed, in sentences: made last, for people, and never read back; and the command that shows a change again."""

import re
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from plumbline.harness.case.undropped import OWN
from plumbline.harness.findings.changes.matching import LOST
from plumbline.harness.findings.changes.values import Change, Changes, Judged, Value
from plumbline.harness.findings.parameter_words import step_in_words
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.study.engine_versions import asked
from plumbline.harness.study.sources import ORIGINS

_TELLING = 1000.0
"""A ratio beyond this says only that an error was none before, or is none now."""
_MEASURED = re.compile(r"\b[a-z][a-z0-9]*(?:_[a-z0-9]+)+(?= = )")
"""The name of a metric in a reason, 'top_offset = 0.2 m'."""
_BESIDE = {"canary": "over the canary", "other engines": "over other engines of the same run"}


def headline(changes: Changes) -> str:
    """How much changed, in one line."""
    worse = sum(row.sense == "worse" for row in changes.rows)
    better = sum(row.sense == "better" for row in changes.rows)
    alike = sum(row.sense == "within tolerance" for row in changes.rows)
    summary = f"{_many(worse, 'thing')} worse, {better} better, {alike} changed within tolerance"
    return f"{summary}; of {_many(changes.matched, 'trial')} on both sides, {changes.same} are the same to the last bit"


def judged_in_short(judged: Judged) -> str:
    """How much could be judged: 'accuracy: all judged; prices: 17 of 48 judged'."""
    parts = (("accuracy", judged.answers, judged.all_answers), ("prices", judged.prices, judged.all_prices))
    return "; ".join(
        f"{what}: {'none to judge' if not whole else 'all judged' if count == whole else f'{count} of {whole} judged'}"
        for what, count, whole in parts
    )


def gate_in_short(changes: Changes, gated: Collection[str], least: float = 0.0) -> str:
    """What a gate says of these engines. Args: least: share, below which too little could be judged."""
    barred, judged = changes.regressions(gated), changes.judged_of(gated)
    verdict = [_many(len(barred), "regression")] if barred else []
    verdict += [f"not judged: less than {least:g} of it could be"] if judged.share < least else []
    return f"{', '.join(verdict) or 'no regression'} ({judged_in_short(judged)})"


def first_line(changes: Changes) -> str:
    """Which folders are compared."""
    sides = (
        f"{side.folder} ({' '.join(filter(None, (side.study, side.started))) or 'no date'})" for side in (changes.a, changes.b)
    )
    return " -> ".join(sides)


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _subject(row: Change) -> str:
    setting = f"{row.engine} ({row.track})" if row.engine and row.track else row.engine or row.track
    scene = " ".join(filter(None, (row.case, f"({row.where})" if row.where else "")))
    step = f", dt {step_in_words(row.dt, row.substeps)}" if row.dt else ""
    return f"{scene} on {setting}{step}" if scene and setting else (scene or setting) + step


def _value(value: Value, unit: str, beside: Value = None) -> str:
    """To three digits, or to as many as tell it from the one beside it."""
    if not isinstance(value, float):
        return "none" if value is None else value
    digits = next((d for d in range(3, 17) if not isinstance(beside, float) or f"{value:.{d}g}" != f"{beside:.{d}g}"), 3)
    return f"{value:.{digits}g}" + ("" if unit in ("1", "") else f" {unit}")


def _both(row: Change) -> tuple[str, str]:
    return _value(row.before, row.unit, row.after), _value(row.after, row.unit, row.before)


def _ratio(row: Change) -> str:
    if row.ratio is None:
        return ""
    bar = "" if row.low is None or row.high is None else f", {row.low:.3g} to {row.high:.3g}"
    return f"{row.ratio:.3g} times{bar}"


def _reading(row: Change) -> str:
    if _value(row.before, row.unit) == _value(row.after, row.unit):
        return f"{row.metric} {_value(row.after, row.unit)}, to three digits as before"
    ratio = f" ({_ratio(row)})" if row.ratio is not None else ""
    return f"{row.metric} {' -> '.join(_both(row))}{ratio}"


def titled(row: Change, titles: Mapping[str, str]) -> Change:
    """The same change with titles for names of cases and engines, and words for those of metrics and axes.

    Args: titles: by name; what is not among them keeps its name.
    """
    measured = row.kind in ("verdict", "error", "price")
    return replace(
        row,
        case=titles.get(row.case, row.case),
        engine=titles.get(row.engine, row.engine),
        metric=metric_title(row.metric) if measured else row.metric.replace("_", " "),
        detail=_MEASURED.sub(lambda found: metric_title(found[0]), row.detail) if row.kind == "verdict" else row.detail,
    )


def sentence(row: Change) -> str:
    """One change in one sentence; of a row of `titled` one for people who do not know the names."""
    subject = _subject(row)
    if row.kind == "verdict":
        by = (
            f"; {row.metric} {_ratio(row)} what it was"
            if row.ratio is not None and 1 / _TELLING < row.ratio < _TELLING and f"{row.ratio:.3g}" != "1"
            else ""
        )
        now = f"lost: {row.after}" if row.after in LOST and row.before not in LOST else f"now {row.after}"
        return f"{subject}: {row.before}, {now}: {row.detail}{by}."
    if row.kind == "error":
        way = {"worse": "errs more", "better": "errs less", "within tolerance": "other bits, within tolerance"}.get(
            row.sense, ""
        )
        return f"{subject}: {way or row.detail}: {_reading(row)}." if row.metric else f"{subject}: {way or row.detail}."
    if row.kind == "price":
        ways: dict[str, str] = {"worse": "dearer", "unconfirmed": "unconfirmed, its timing is unstable"}
        way = ways.get(row.sense, "cheaper")
        whole = f"as a whole, over {_many(row.count, 'price')}, " if not row.case else ""
        bar = "" if row.low is None or row.high is None else f" ({row.low:.3g} to {row.high:.3g})"
        beside = "; ".join(filter(None, (_BESIDE.get(row.beside, "as clocked"), row.detail)))
        return f"{subject}: {whole}{way}: {row.ratio:.3g} times the {row.metric}{bar}, {beside}."
    if row.kind == "limit":
        way = {"worse": "breaks earlier", "better": "holds longer", "within tolerance": "may be as before"}.get(
            row.sense, "changed"
        )
        return f"{subject}: {row.metric} held to {', now '.join(_both(row))}: {way}."
    if row.kind == "determinism":
        return f"{subject}: repeated {row.metric}: {row.before}, now {row.after}{' ' + row.detail if row.detail else ''}."
    if row.kind == "digest":
        return f"{subject}: same digest, another answer: {row.before}, now {row.after}."
    if row.kind == "warning":
        way = "warns no more" if row.after is None else "warns anew" if row.before is None else "warns in other words"
        return f"{subject}: {way}, in {_many(row.count, 'trial')}: {row.detail}"
    if row.kind == "trials":
        return f"{subject}: {_value(row.after, '1')} trials are new, {_value(row.before, '1')} are gone."
    if row.kind == "version":
        return f"{row.engine}: version {row.before}, now {row.after}."
    if row.kind == "sources":
        versions = f"{row.before or 'none'}, now {row.after or 'none'}"
        return f"{subject or 'all'}: {ORIGINS.get(row.metric, row.metric)} {versions} ({_many(row.count, 'trial')})."
    if row.kind == "settings":
        return f"{subject}: {row.metric} {row.before}, now {row.after} ({_many(row.count, 'trial')})."
    return f"the machine: {row.metric} {row.before}, now {row.after}."


def command(row: Change, changes: Changes) -> str:
    """What shows a change again; '' for what is a fact about the runs."""
    return command_in(row, changes.b.folder)


def command_in(row: Change, folder: str) -> str:
    """The same, from the run folder that the change was first seen in."""
    if row.kind == "price":
        case = ["--case", row.case] if row.case else []
        return shlex.join(
            ["plumbline", "run", f"{folder}/study.toml", "--engine", asked(row.engine), *case, "--out", "build/again"]
        )
    if not row.trial_b and row.kind == "verdict":
        return shlex.join(["plumbline", "run", row.case.removeprefix(OWN), "--out", "build/again"])
    return shlex.join(["plumbline", "reproduce", folder, row.trial_b]) if row.trial_b else ""


def folded(rows: Iterable[Change], titles: Mapping[str, str] | None = None) -> list[tuple[str, Sequence[Change]]]:
    """Sentences with the rows behind each: what is within tolerance, and facts of one kind, in one for each engine.

    Args: titles: as `titled` takes them; none where sentences shall have the names that commands take.
    """
    made: dict[object, list[Change]] = {}
    for number, row in enumerate(rows):
        single = row.kind == "price" and bool(row.case)
        alone = (row.sense in ("worse", "better") and not single) or row.kind in (
            "version",
            "machine",
            "verdict",
            "determinism",
        )
        folds = (row.kind, row.sense, row.engine, row.metric if row.kind == "sources" else "")
        made.setdefault(number if alone else folds, []).append(row)
    told = {number: group if titles is None else [titled(row, titles) for row in group] for number, group in made.items()}
    return [(sentence(rows[0]) if len(rows) == 1 else _of_many(rows), made[number]) for number, rows in told.items()]


def one_a_side(groups: Iterable[tuple[str, Sequence[Change]]]) -> list[tuple[str, Sequence[Change]]]:
    """The groups of `folded`, engines that are dearer as a whole first; of what changed alike in one case on one track of an
    engine the heaviest alone, with how many more there are."""
    alike: dict[tuple[str, ...], list[tuple[str, Sequence[Change]]]] = {}
    for number, (text, rows) in enumerate(groups):
        first = rows[0]
        about = (first.kind, first.sense, first.case, first.engine, first.track)
        alike.setdefault(about if len(rows) == 1 and first.case else (str(number),), []).append((text, rows))
    told: list[tuple[str, Sequence[Change]]] = []
    for each in sorted(alike.values(), key=lambda each: not _whole(each[0][1][0])):
        text, rows = each[0]
        more = f" Likewise {len(each) - 1} more of this case, at other steps or parameters." if len(each) > 1 else ""
        told.append((text + more, [row for _, group in each for row in group]))
    return told


def _whole(row: Change) -> bool:
    """Is an engine dearer as a whole?"""
    return row.kind == "price" and row.sense == "worse" and not row.case


def _of_many(group: Sequence[Change]) -> str:
    first = group[0]
    cases = len({row.case for row in group})
    who = first.engine or "all engines"
    if first.kind == "error":
        what = "the same bits are measured otherwise" if first.sense == "neither" else "other bits, within tolerance"
        most = f"most of all {_subject(first)}: {_reading(first)}" if first.metric else _subject(first)
        return f"{who}: {what}: {_many(len(group), 'answer')} in {_many(cases, 'case')}, {most}."
    if first.kind == "trials":
        counts = ([row.before for row in group], [row.after for row in group])
        gone, new = (sum(count for count in side if isinstance(count, float)) for side in counts)
        return f"{who}: {new:.0f} trials are new, {gone:.0f} are gone, in {_many(cases, 'case')}."
    if first.kind == "price":
        return f"{who}: {_many(len(group), 'single price')} of their own, most of all {sentence(first)}"
    facts = {
        "warning": "warnings came, went or have other words",
        "settings": "settings changed",
        "limit": "brackets moved and may hold the same limit",
    }
    if first.kind == "sources":
        return (
            f"{who}: {ORIGINS.get(first.metric, first.metric)} changed for {_many(sum(row.count for row in group), 'trial')}."
        )
    return f"{who}: {facts.get(first.kind, first.kind)}: {len(group)}, the first: {sentence(first)}"
