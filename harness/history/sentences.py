"""What a night has to say, in sentences, made last and never read back; and its gate: it fails where a gated engine is worse,
has no answer at all, or where too little could be judged.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any

from plumbline.harness.findings.changes import Change, Changes
from plumbline.harness.findings.changes.answers import as_good
from plumbline.harness.findings.changes.files import comment
from plumbline.harness.findings.changes.matching import LOST
from plumbline.harness.findings.changes.words import command, gate_in_short, headline, judged_in_short, sentence
from plumbline.harness.history.changes_since import News
from plumbline.harness.history.identity import Named, change_id, silenced
from plumbline.harness.intake.safe_text import markdown_cell


def without_answers(plan: Mapping[str, Any], engines: Iterable[str]) -> list[str]:
    """A sentence for each of these engines that was asked and has no answer at all. Args: plan: of the night."""
    outcomes: Mapping[str, Mapping[str, int]] = plan.get("outcomes", {})
    mute = [each for each in engines if each in outcomes and not outcomes[each].keys() - {*LOST, "unsupported"}]
    idle = [each for each in engines if each not in outcomes and (plan.get("left_out") or plan.get("unanswered"))]
    return [f"no answer of this engine: {counted(each, outcomes[each])}" for each in mute] + [
        f"no answer of this engine: {each}, time was up before" for each in idle
    ]


def counted(engine: str, outcomes: Mapping[str, int]) -> str:
    """How trials of an engine ended: 'mujoco 12 passed, 4 crashed'."""
    return f"{engine} {', '.join(f'{count} {status}' for status, count in outcomes.items())}"


def reasons(news: News | None, plan: Mapping[str, Any], gated: Collection[str], least: float) -> list[str]:
    """Why the gate on these engines fails, in sentences; nothing where it does not.

    Args: news, plan: of the night. least: share of what was asked that has to be judged.
    """
    sentences = without_answers(plan, gated)
    if news is None:
        return sentences + (["not judged: nothing of it was seen before"] if least > 0 else [])
    if news.regressions(gated) or news.changes.judged_of(gated).share < least:
        sentences.append(gate_in_short(news.changes, gated, least))
    return sentences


_KEPT = ("kind", "sense", "case", "engine", "track", "metric", "where", "dt", "before", "after", "regression")
_FIRST = 8
"""Names that a line has room for."""
_MOST = 25
"""Changes that are told line by line; nobody reads more in a mail."""


def told(row: Change, changes: Changes, since: str) -> dict[str, Any]:
    """A change as `night.json` keeps it: what it is called, what it is about, in a sentence, and what shows it again.

    Args: since: its first night. Returns: also 'lasting', what it is called whatever the night.
    """
    about = {"id": change_id(row, since), "lasting": change_id(row, ""), "first_seen": since}
    about |= {name: getattr(row, name) for name in _KEPT}
    return about | {"sentence": sentence(row), "command": command(row, changes)}


def left_out_in_short(rows: Sequence[Mapping[str, Any]]) -> str:
    """What the budget left out, in one line; '' for nothing."""
    if not rows:
        return ""
    counts = Counter(str(row["experiment"]) for row in rows)
    groups = []
    for experiment, count in counts.items():
        cases = [str(row["case"]) for row in rows if row["experiment"] == experiment]
        more = f" and {count - _FIRST} more" if count > _FIRST else ""
        groups.append(f"{experiment}: {', '.join(cases[:_FIRST])}{more}")
    return f"left out by the budget, {len(rows)}: {'; '.join(groups)}"


def unanswered_in_short(rows: Sequence[Mapping[str, Any]]) -> str:
    """What had no answer when time was up, in one line, what was waited for longest first; '' for nothing."""
    if not rows:
        return ""
    longest = sorted(rows, key=lambda row: -row["seconds"])
    names = [f"{row['case']} {row['engine']}/{row['track']} ({row['experiment']}) {row['seconds']:.0f} s" for row in longest]
    return f"without an answer when time was up, and since when: {', '.join(names[:_FIRST])}"


def worse_in_short(rows: Sequence[Mapping[str, Any]], gated: Collection[str]) -> list[str]:
    """Lines of what got worse: engines as a whole first, then the heaviest; of each id the first, how many more there are, and
    what shows it again.

    Args: rows: as `told` gives them. gated: engines that may not be worse.
    """
    named: dict[str, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: row["case"] != ""):
        if row["regression"]:
            named.setdefault(row["id"], []).append(row)
    lines = []
    for number, (first, *more) in islice(named.items(), _MOST):
        also = f"; {len(more)} more of it" if more else ""
        lines.append(f"{'gate: ' if first['engine'] in gated else ''}{first['sentence']}")
        lines.append(f"    {first['command']}  (id {number}{also})")
    rest = len(named) - _MOST
    return [*lines, f"… and {rest} more, in summary.md and changes.json"] if rest > 0 else lines


def in_short(plan: Mapping[str, Any]) -> str:
    """What a night did, in one line."""
    taken = plan["seconds"]["whole"]
    budget = "" if plan["budget"] is None else f" of {plan['budget']:.0f}"
    disk, memory = plan["bytes"], plan["memory_mb"]
    return (
        f"night {plan['stamp']}: {plan['answers']} answers, {plan['recalled']} recalled, {plan['computed']} computed "
        f"({plan['again']} of them known ones again, {plan['disagreements']} otherwise), {plan['clocked']} clocked; "
        f"{taken:.0f}{budget} s, {disk['night'] / 2**20:.0f} MB of its own and {disk['pool'] / 2**20:.0f} in the pool, "
        f"{memory['own']:.0f} MB of memory and {memory['largest_child']:.0f} in the largest process"
    )


def open_since(
    plans: Sequence[Mapping[str, Any]],
    known: Mapping[str, Named],
    over: Collection[str] = (),
    tonight: Sequence[Mapping[str, Any]] = (),
) -> list[Mapping[str, Any]]:
    """Regressions of earlier nights that nobody acknowledged and that no later night took back, the earliest first.

    Args: plans: of the nights before, the earliest first. over: ids of changes that the nights together say have ended.
    tonight: what this night tells.
    """
    standing: list[Mapping[str, Any]] = []
    for rows in (*(plan.get("told", ()) for plan in plans), [row for row in tonight if not row["regression"]]):
        better = [row for row in rows if row["sense"] == "better"]
        standing = [row for row in standing if not any(_mends(change, row) for change in better)]
        standing += [row for row in rows if row["regression"]]
    stamps = [str(plan["stamp"]) for plan in plans]
    first: dict[str, Mapping[str, Any]] = {}
    for row in standing:
        if row["id"] not in over and silenced(Named.told(row), known, stamps) is None:
            first.setdefault(row["lasting"], row)
    return [*first.values()]


def _mends(better: Mapping[str, Any], worse: Mapping[str, Any]) -> bool:
    """Does a change take another one back? Nights of an older version do not say at which step and from what to what."""
    verdicts = better["kind"] == worse["kind"] == "verdict"
    about = ["kind", "case", "engine", "track"] + ([] if verdicts or better["kind"] == "price" else ["metric"])
    about += ["where", "dt"] if "dt" in better and "dt" in worse else []
    if any(better[name] != worse[name] for name in about):
        return False
    return not (verdicts and "before" in worse) or as_good(str(better.get("after")), str(worse["before"]))


def outcomes_in_short(plan: Mapping[str, Any]) -> str:
    """How trials ended, engine by engine: 'outcomes: mujoco 12 passed, 4 crashed'; '' in nights of an older version."""
    outcomes = plan.get("outcomes", {})
    return f"outcomes: {'; '.join(counted(engine, of) for engine, of in outcomes.items())}" if outcomes else ""


def _ended(plan: Mapping[str, Any]) -> list[str]:
    """How trials ended, what the budget left out and what had no answer, a line each."""
    lines = outcomes_in_short(plan), left_out_in_short(plan["left_out"]), unanswered_in_short(plan.get("unanswered", ()))
    return [*filter(None, lines)]


def lines_of(news: News | None, plan: Mapping[str, Any], findings: Sequence[str], failing: Sequence[str]) -> list[str]:
    """What a night prints: how much was judged, what it did, what changed, why its gate fails. findings: as for `summary`."""
    return [
        *([] if news is None else [judged_in_short(news.changes.judged_of(plan["gated"]))]),
        in_short(plan),
        *_ended(plan),
        *(f"left out: {text}" for text in plan["unread"]),
        *findings,
        "nothing of it was seen before" if news is None else headline(news.changes),
        *worse_in_short(plan["told"], plan["gated"]),
        *unconfirmed_in_short(plan["unconfirmed"]),
        *(f"gate: {reason}" for reason in failing),
    ]


def unconfirmed_in_short(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lines of prices that are dearer by timings too unstable to judge by, each with what measures it again."""
    lines = [line for row in rows[:_FIRST] for line in (row["sentence"], f"    {row['command']}")]
    return [*lines, f"… and {len(rows) - _FIRST} more unconfirmed, in changes.json"] if len(rows) > _FIRST else lines


def summary(
    news: News | None, plan: Mapping[str, Any], standing: Sequence[Mapping[str, Any]], findings: Sequence[str] = ()
) -> str:
    """In Markdown: what changed, what is still worse, and what the night did; fits a comment.

    Args: findings: about engines, that are gone or back, in sentences.
    """
    tail = ["", "## Findings about engines", "", *(f"* {markdown_cell(each)}" for each in findings)] if findings else []
    tail += ["", "## The night", "", markdown_cell(in_short(plan)) + "."]
    tail += [line for text in plan.get("unread", ()) for line in ("", f"Left out: {markdown_cell(text)}.")]
    tail += [line for text in _ended(plan) for line in ("", markdown_cell(text[0].upper() + text[1:]) + ".")]
    for line in without_answers(plan, plan.get("gated", ())):
        tail += ["", f"Gate: {markdown_cell(line)}."]
    if news is not None and news.acknowledged:
        tail += ["", f"Acknowledged and not told again: {len(news.acknowledged)}."]
    for row in standing[:_FIRST]:
        if row is standing[0]:
            tail += ["", f"## Still worse since an earlier night ({len(standing)})", ""]
        seen = f"plumbline history ack {row['id']} --note WHY --history DIR"
        tail.append(f"* {row['first_seen']}: {markdown_cell(row['sentence'])} `{seen}`")
    if news is None:
        head = "# What changed\n\nNothing of this night was seen before: there is nothing to compare it with.\n"
    else:
        head = comment(news.changes, plan["gated"], plan.get("least", 0.0))
    return head + "\n".join(tail) + "\n"
