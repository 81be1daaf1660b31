"""The gate of a night: it fails where a gated engine is worse, has no answer at all, or where too little could be judged."""

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from plumbline.harness.findings.changes.matching import LOST
from plumbline.harness.findings.changes.words import gate_in_short
from plumbline.harness.history.changes_since import News


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
