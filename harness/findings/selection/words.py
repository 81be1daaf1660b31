"""The answer in sentences, for a terminal and for pages."""

import math
from collections.abc import Callable, Mapping, Sequence

from plumbline.harness.findings.selection.choose import EXPRESSED, Selection
from plumbline.harness.findings.selection.decide import WhatTurns
from plumbline.harness.findings.selection.rank import DRAWS
from plumbline.harness.findings.selection.wish import CRITERIA, Dropped
from plumbline.harness.findings.spoken import SPOKEN

Titled = Callable[[str], str]
"""From a name to what people call it."""

SENTENCES: Mapping[str, str] = SPOKEN["sentences"]
"""What the first sentence can be, and what follows it; the script of the page on selection fills in the same ones."""
COLUMN_WORDS = (
    f"First in: the share of {DRAWS} resamples (cases, timings and weights drawn anew) in which it leads; places go by it.",
    "Within: cases with no more than the error asked for, and every other check held.",
    "Speed: times real time, the geometric mean over the cases in which the engines have one. Error: that of the median case, "
    "in % of its scale.",
)
"""What stands in the table of places, for a terminal and for pages."""
CLEAR = 0.5
"""The share of resamples from which on the first engine is named alone: it leads more often than all others together."""
FEW = 8
"""Cases below which a bootstrap over them says little: of seven the most that one can weigh is a seventh."""
CERTAIN = 0.95
"""The share of resamples from which on nothing has to be decided."""
NAMED = 3
"""Cases of an engine that a sentence names; the others are counted."""
TRADED, FASTER = 0.05, 1.1
"""How far apart two engines' means of a criterion have to be for it to be phrases, and the ratio of their speeds."""


def _listed(names: Sequence[str], last: str = "and") -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {last} {names[-1]}"


def headline(answer: Selection, titled: Titled) -> str:
    """Who is first, how surely, who is second, and on how few cases, where they stand for others than the user's own.

    Where there is nobody to be first of, it says so in place of a share.

    Args: titled: an engine's name to its title."""
    first, count = who_leads(answer, titled), len(answer.evidence.cases)
    if answer.rank is None or answer.alone or count >= FEW or answer.evidence.cases.keys() <= answer.evidence.own:
        return first
    return f"{first} {SENTENCES['few'].format(cases='1 case' if count == 1 else f'{count} cases')}"


def who_leads(answer: Selection, titled: Titled) -> str:
    """The same without the number of cases."""
    if answer.rank is None:
        return SENTENCES["none" if answer.dropped else "unknown"]
    first, *others = answer.rank.places
    if answer.alone:
        scenes = "this scene" if len(answer.evidence.cases) == 1 else "these scenes"
        return SENTENCES[answer.alone].format(engine=titled(first.engine), scenes=scenes, asked=answer.asked)
    if first.first > CLEAR:
        second = titled(others[0].engine)
        return SENTENCES["first"].format(engine=titled(first.engine), share=percent(first.first), second=second)
    seen = [entry for entry in others if percent(entry.first) != percent(0)] or others[:1]
    rest = ", ".join(f"{titled(entry.engine)} in {percent(entry.first)}" for entry in seen)
    return SENTENCES["open"].format(engine=titled(first.engine), share=percent(first.first), others=rest)


def percent(share: float) -> str:
    """'83 %'."""
    return f"{math.floor(100 * share + 0.5)} %"


LEAST_ERROR = 1e-5
"""Share of the scale below which an error is said to be less than this."""


def error_percent(error: float) -> str:
    """'0.8 %' of an error as a share of the scale."""
    return f"<{100 * LEAST_ERROR:g} %" if error < LEAST_ERROR else f"{float(f'{100 * error:.2g}'):g} %"


_BETTER: Mapping[str, str] = {
    "limits": "holds harder cases",
    "robustness": "fails to answer less often",
    "determinism": "repeats the same bits more often",
    "capability": "can express more of the scenes",
}


def trade(answer: Selection, titled: Titled) -> str:
    """What the first two engines trade: 'MuJoCo is 3x faster; DART has 6 of 7 cases within 1 %, MuJoCo 4.'; '' if
    nothing sets them apart. Args: titled: an engine's name to its title."""
    if answer.rank is None or len(answer.rank.places) < 2:
        return ""
    pair = answer.rank.places[:2]
    parts: dict[str, list[str]] = {entry.engine: [] for entry in pair}
    for name in answer.rank.counted:
        better, worse = sorted(pair, key=lambda entry: -entry.by_criterion[name])
        if better.by_criterion[name] - worse.by_criterion[name] >= TRADED:
            if name == "speed":
                words = _faster(answer, better.engine, worse.engine)
            elif name == "accuracy":
                words = _nearer(answer, better.engine, worse.engine, titled)
            else:
                words = _BETTER[name]
            if words:
                parts[better.engine].append(words)
    phrases = [f"{titled(engine)} {_listed(mine)}" for engine, mine in parts.items() if mine]
    return f"{'; '.join(phrases)}." if phrases else ""


def _faster(answer: Selection, fast: str, slow: str) -> str:
    """'is 3x faster' by the speeds that stand beside the answer; '' if they say otherwise."""
    mine, other = answer.evidence.speed(fast), answer.evidence.speed(slow)
    if mine is None or other is None:
        return "passes cases that the other does not"
    return f"is {mine / other:.2g}\N{MULTIPLICATION SIGN} faster" if mine / other >= FASTER else ""


def _nearer(answer: Selection, near: str, far: str, titled: Titled) -> str:
    """'has 6 of 7 cases within 1 %, MuJoCo 4'; of as many, that it misses the others by less."""
    (most, cases), (least, _) = answer.evidence.within(near), answer.evidence.within(far)
    if most <= least:
        return "is beyond it by less in the other cases"
    return f"has {most} of {cases} cases within {_asked(answer)}, {titled(far)} {least}"


def _asked(answer: Selection) -> str:
    return f"{100 * answer.wish.max_error:g} %"


def beyond(answer: Selection, titled: Titled, called: Titled) -> str:
    """In which cases engines are beyond the error asked for, or break another check; '' where none does.

    Args: titled: an engine's name to its title. called: that of a case."""
    parts = []
    for entry in answer.rank.places if answer.rank is not None else ():
        cases = [f"“{called(case)}”" for case in answer.evidence.beyond(entry.engine)]
        if cases:
            more = [f"{len(cases) - NAMED} more"] if len(cases) > NAMED + 1 else []
            parts.append(f"{titled(entry.engine)} in {_listed((cases[:NAMED] if more else cases) + more)}")
    return f"Beyond {_asked(answer)} or another bound: {'; '.join(parts)}." if parts else ""


def gaps(answer: Selection) -> list[str]:
    """What there is no evidence of, or rough evidence alone, so that nobody takes silence for a good mark."""
    if answer.rank is None:
        return []
    sentences, evidence, (noisy, timed) = list[str](), answer.evidence, answer.noisy
    if 2 * noisy > timed:
        sentences.append(f"{noisy} of {timed} timings of this run are noisy: speeds are rough.")
    without = [name for name in CRITERIA if name not in answer.rank.counted and answer.wish.weight(name) > 0]
    if without:
        sentences.append(f"Not measured in this run: {', '.join(without)}.")
    exact = sum(speed.at_error for speed in evidence.speeds.values())
    if exact < len(evidence.speeds):
        sentences.append(
            f"Speed at {_asked(answer)} error is known in {exact} of {len(evidence.speeds)} pairs of engine and case; else it "
            "is that of the cheapest run that passes its case's own checks, at whatever error."
        )
    if evidence.incomplete:
        cases = ", ".join(dict.fromkeys(case for _, case in evidence.incomplete))
        count = len(evidence.incomplete)
        sentences.append(f"Not counted, since it is not known of every engine: {count} pairs of criterion and case ({cases}).")
    return sentences


def decisive(answer: Selection, titled: Titled, called: Titled) -> tuple[str, str]:
    """What would decide it, and the command that measures it; ('', '') where nothing has to be decided, and no command where no
    built-in study would. Args: titled: an engine's name to its title. called: that of a case."""
    if answer.rank is None or answer.alone or answer.rank.places[0].first >= CERTAIN:
        return "", ""
    decider = answer.decider
    if decider is None:
        return "No single figure that a built-in study measures would decide it: it rests on which cases count.", ""
    what = "speed" if decider.criterion == "speed" else "limit"
    took = f"{decider.runs} run{'' if decider.runs == 1 else 's'} of it here took {decider.seconds:.2g} s"
    first, low, high = titled(answer.rank.places[0].engine), percent(decider.low), percent(decider.high)
    then = f"{first}'s share will then lie between {low} and {high}"
    start = "What would make it surer" if decider.low > CLEAR else "What would decide it"
    return (
        f"{start}: to measure the {what} of {titled(decider.engine)} in “{called(decider.case)}” further; {then} ({took}).",
        decider.command,
    )


def turn_sentences(turns: Sequence[WhatTurns], titled: Titled, called: Titled) -> list[str]:
    """What would put another engine first, one sentence an engine and way.

    Args: titled: an engine's name to its title. called: that of a case or of a family of cases."""
    sentences = []
    for first in dict.fromkeys(turn.first for turn in turns):
        mine = [turn for turn in turns if turn.first == first]
        doubled = [called(turn.name) if turn.kind == "family" else turn.name for turn in mine if turn.kind != "case"]
        left_out = [f"“{called(turn.name)}”" for turn in mine if turn.kind == "case"]
        if doubled:
            either = doubled[0] if len(doubled) == 1 else f"{', '.join(doubled[:-1])} or {doubled[-1]}"
            sentences.append(f"If {either} counted double, {titled(first)} would be first.")
        if left_out:
            either = left_out[0] if len(left_out) == 1 else f"one of {', '.join(left_out)}"
            sentences.append(f"Without {either}, {titled(first)} would be first.")
    return sentences


def dropped_sentence(drop: Dropped, titled: Titled, called: Titled) -> str:
    """Who is left out, and why. Args: called: a case's name to its title."""
    where = f" in “{called(drop.case)}”" if drop.case else ""
    if drop.requirement == EXPRESSED:
        shown = f"{drop.value},{where}" if where else drop.value
        return f"{SENTENCES['expressed'].format(engine=titled(drop.engine))[:-1]} ({shown})."
    return f"{titled(drop.engine)} is excluded: required {drop.requirement}, found {drop.value}{where}."


def undecided_sentence(drop: Dropped, titled: Titled, called: Titled) -> str:
    """What is asked for and not known of an engine that is left. Args: called: a case's name to its title."""
    where = f" in “{called(drop.case)}”" if drop.case else ""
    return f"Of {titled(drop.engine)} it is not known whether it has {drop.requirement}{where}: {drop.value}."
