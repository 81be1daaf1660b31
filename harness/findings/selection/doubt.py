"""What would turn the answer: another weight of a criterion or of a family of cases, or one case less."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from plumbline.harness.findings.selection.evidence import Evidence
from plumbline.harness.findings.selection.rank import scores
from plumbline.harness.findings.selection.wish import CRITERIA, Wish

TIMES = 2.0


@dataclass(frozen=True, kw_only=True)
class Turn:
    """What would put another engine first. kind: 'criterion' or 'family', weighed double; 'case', left out. name: of it. first:
    who leads then."""

    kind: Literal["criterion", "family", "case"]
    name: str
    first: str


def _leader(evidence: Evidence, wish: Wish) -> str:
    found = scores(evidence, wish)
    return max(found, key=lambda engine: found[engine])


def turns(evidence: Evidence, wish: Wish) -> tuple[Turn, ...]:
    """Each change that by itself turns the leader."""
    return tuple(_turns(evidence, wish)) if len(evidence.engines) > 1 else ()


def _turns(evidence: Evidence, wish: Wish) -> Iterator[Turn]:
    today = _leader(evidence, wish)
    for criterion in CRITERIA:
        heavier = replace(wish, weights={**wish.weights, criterion: TIMES * wish.weight(criterion)})
        if (then := _leader(evidence, heavier)) != today:
            yield Turn(kind="criterion", name=criterion, first=then)
    for family in dict.fromkeys(evidence.families[case] for case in evidence.cases):
        cases = {case: weight * (TIMES if evidence.families[case] == family else 1) for case, weight in evidence.cases.items()}
        if (then := _leader(replace(evidence, cases=cases), wish)) != today:
            yield Turn(kind="family", name=family, first=then)
    for case in evidence.cases if len(evidence.cases) > 1 else ():
        fewer = {name: weight for name, weight in evidence.cases.items() if name != case}
        if (then := _leader(replace(evidence, cases=fewer), wish)) != today:
            yield Turn(kind="case", name=case, first=then)
