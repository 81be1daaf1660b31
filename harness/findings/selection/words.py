"""The answer in sentences, for a terminal and for pages."""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby

from plumbline.harness.findings.selection.choose import EXPRESSED, Answer
from plumbline.harness.findings.selection.doubt import Turn
from plumbline.harness.findings.selection.rank import Place
from plumbline.harness.findings.selection.wish import Dropped

Titled = Callable[[str], str]
"""From a name to what people call it."""

SENTENCES: Mapping[str, str] = {
    "first": "{engine} is first, in {share} of {draws} resamples.",
    "level": "No clear winner between {engines}; share of {draws} resamples in which each is first: {shares}.",
    "expresses": "{engine} is the only engine that can express {scenes}, of {asked} asked: there is no contest.",
    "left": "{engine} is the only engine left, of {asked} asked: there is no contest.",
    "single": "{engine} alone was asked: there is no contest.",
    "none": "No engine is left that there is evidence of.",
    "unknown": "There is no evidence of these cases.",
    "few": "Only {cases}: treat the percentages as rough.",
    "expressed": "{engine} is left out: it can express no scene that counts.",
}
"""What the first sentence can be, and what follows it; the script of the page on selection fills in the same ones."""


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


FEW = 8
"""Cases below which a bootstrap over them says little: of seven the most that one can weigh is a seventh."""


def headline(answer: Answer, titled: Titled) -> str:
    """Who is first, how surely, who shares the place, and on how few cases, where they stand for others than the user's own.

    Where there is nobody to be first of, it says so in place of a share.

    Args: titled: an engine's name to its title."""
    first, count = _first(answer, titled), len(answer.evidence.cases)
    if answer.rank is None or answer.alone or count >= FEW or answer.evidence.cases.keys() <= answer.evidence.own:
        return first
    return f"{first} {SENTENCES['few'].format(cases='1 case' if count == 1 else f'{count} cases')}"


def _first(answer: Answer, titled: Titled) -> str:
    if answer.rank is None:
        return SENTENCES["none" if answer.dropped else "unknown"]
    groups = [list(group) for _, group in groupby(answer.rank.places, key=lambda place: place.number)]
    first = groups[0]
    if answer.alone:
        scenes = "this scene" if len(answer.evidence.cases) == 1 else "these scenes"
        return SENTENCES[answer.alone].format(engine=titled(first[0].engine), scenes=scenes, asked=answer.asked)
    if len(first) == 1:
        return SENTENCES["first"].format(engine=titled(first[0].engine), share=_percent(first[0]), draws=answer.draws)
    names = _listed([titled(place.engine) for place in first])
    shares = ", ".join(f"{titled(place.engine)} {_percent(place)}" for place in first)
    return SENTENCES["level"].format(engines=names, draws=answer.draws, shares=shares)


def _percent(place: Place) -> str:
    return f"{100 * place.first:.0f} %"


def turn_sentences(turns: Sequence[Turn], titled: Titled, called: Titled) -> list[str]:
    """What would put another engine first, one sentence an engine and way.

    Args: titled: an engine's name to its title. called: that of a case or of a family of cases."""
    sentences = []
    for first in dict.fromkeys(turn.first for turn in turns):
        mine = [turn for turn in turns if turn.first == first]
        doubled = [called(turn.name) if turn.kind == "family" else turn.name for turn in mine if turn.kind != "case"]
        left_out = [f"“{called(turn.name)}”" for turn in mine if turn.kind == "case"]
        if doubled:
            either = doubled[0] if len(doubled) == 1 else f"{', '.join(doubled[:-1])} or {doubled[-1]}"
            sentences.append(f"{titled(first)} if {either} counted double.")
        if left_out:
            either = left_out[0] if len(left_out) == 1 else f"one of {', '.join(left_out)}"
            sentences.append(f"{titled(first)} without {either}.")
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
