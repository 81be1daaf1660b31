"""The rank of engines and its doubt: scores drawn again over cases, timings and weights.

A score is the weighted mean over criteria of the weighted mean over cases. Each draw takes the cases anew with replacement
(the same for all engines: the bootstrap of B. Efron & R. J. Tibshirani, 1993, chapter 6), prices and limits from their
intervals, and weights of criteria from a Dirichlet distribution about the user's. Of an engine of which a price is known by a
bound alone, all bounds are taken at what they show in one half of the draws, and as good as is asked in the other: nothing says
how likely either is, and an order that is stated has to hold at both.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.selection.evidence import Evidence
from plumbline.harness.findings.selection.wish import CRITERIA, Wish

Floats = NDArray[np.float64]

DRAWS = 10_000
"""By which a share of a half is known to 1 %: 1.96 sqrt(1/4/10 000)."""
APART = 0.99
"""In this share of the draws an engine has to be ahead of another for their order to be stated. Of two equal engines either may
come out ahead by chance, so that one pair in fifty of equals is given an order."""
CONCENTRATION = 30.0
"""Of the Dirichlet distribution, all weights together: of six equal weights each is off by two fifths, sqrt(5/31) of itself."""
_EQUAL = 1e-12


@dataclass(frozen=True, kw_only=True)
class Place:
    """An engine in the rank. number: 1 for the first; engines whose order is not stated share one. score: at the weights asked
    for, 0 to 1, low..high its 95 % interval. first: the share of draws in which it leads, alone or in part. by_criterion: its
    mean of each criterion of which there is evidence."""

    engine: str
    number: int
    score: float
    low: float
    high: float
    first: float
    by_criterion: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Rank:
    """places: best first. ahead: the share of draws in which one engine is ahead of another, ties by half, by pair. counted:
    cases by criterion."""

    places: tuple[Place, ...]
    ahead: Mapping[tuple[str, str], float]
    counted: Mapping[str, int]


@dataclass(frozen=True, kw_only=True)
class _Arrays:
    """value, low, high, bounded: (criteria, cases, engines); has: (criteria, cases), 1 where there is evidence; weights:
    (cases,)."""

    criteria: tuple[str, ...]
    value: Floats
    low: Floats
    high: Floats
    bounded: NDArray[np.bool_]
    has: Floats
    weights: Floats


def _arrays(evidence: Evidence, wish: Wish) -> _Arrays:
    known = {criterion for criterion, _, _ in evidence.table}
    criteria = tuple(name for name in CRITERIA if name in known and wish.weight(name) > 0)
    cases, engines = list(evidence.cases), evidence.engines
    shape = len(criteria), len(cases), len(engines)
    value, low, high = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    has, bounded = np.zeros(shape[:2]), np.zeros(shape, dtype=bool)
    for k, criterion in enumerate(criteria):
        for c, case in enumerate(cases):
            for e, engine in enumerate(engines):
                datum = evidence.table.get((criterion, case, engine))
                if datum is not None:
                    value[k, c, e], low[k, c, e], high[k, c, e], has[k, c] = datum.value, datum.low, datum.high, 1.0
                    bounded[k, c, e] = datum.bounded
    weights = np.array([evidence.cases[case] for case in cases])
    return _Arrays(criteria=criteria, value=value, low=low, high=high, bounded=bounded, has=has, weights=weights)


def _scores(value: Floats, has: Floats, weights_of_cases: Floats, weights: Floats) -> Floats:
    """(..., engines) from value (..., criteria, cases, engines), has (criteria, cases), weights_of_cases (..., cases), weights
    (..., criteria); a criterion none of whose cases counts is left out."""
    shares = weights_of_cases[..., None, :] * has
    total = shares.sum(axis=-1)
    means = np.einsum("...kc,...kce->...ke", shares, value) / np.maximum(total, _EQUAL)[..., None]
    counts = weights * (total > 0)
    mean: Floats = np.einsum("...k,...ke->...e", counts, means) / np.maximum(counts.sum(axis=-1), _EQUAL)[..., None]
    return mean


def scores(evidence: Evidence, wish: Wish, end: Literal["low", "high"] | None = None) -> dict[str, float]:
    """At the weights asked for, by engine. Args: end: of its bounds at which each is taken; their middles unless said."""
    arrays = _arrays(evidence, wish)
    weights = np.array([wish.weight(name) for name in arrays.criteria])
    ends = {"low": arrays.low, "high": arrays.high}
    value = arrays.value if end is None else np.where(arrays.bounded, ends[end], arrays.value)
    found = _scores(value, arrays.has, arrays.weights, weights)
    return {engine: float(score) for engine, score in zip(evidence.engines, found, strict=True)}


def rank(evidence: Evidence, wish: Wish, draws: int = DRAWS, seed: int = 0) -> Rank:
    """Args: seed: of the draws: the same evidence gives the same rank. Raises: ValueError, where there is no evidence."""
    arrays = _arrays(evidence, wish)
    if not arrays.criteria or not evidence.engines:
        raise ValueError("no evidence: no criterion has anything to say of these cases and engines")
    draw = np.random.default_rng(seed)
    asked = np.array([wish.weight(name) for name in arrays.criteria])
    weights = draw.dirichlet(CONCENTRATION * asked / asked.sum(), size=draws)
    # One case less than there are: the spread of a mean over n cases is then without bias (J. N. K. Rao & C. F. J. Wu, 1988).
    count = len(arrays.weights)
    cases = draw.multinomial(max(count - 1, 1), np.full(count, 1 / count), size=draws)
    # One position in its interval for each engine and case, the same for all criteria: low..high is central 95 %, so that a
    # normal deviate of 1.96 is an end.
    within = np.clip(draw.normal(size=(draws, *arrays.value.shape[1:])) / 1.96, -1.0, 1.0)
    best = draw.integers(2, size=(draws, len(evidence.engines))) > 0 if arrays.bounded.any() else None
    found = np.empty((draws, len(evidence.engines)))
    for block in np.array_split(np.arange(draws), math.ceil(draws / 500)):
        up = within[block][:, None]
        value = arrays.value + np.where(up > 0, up * (arrays.high - arrays.value), up * (arrays.value - arrays.low))
        if best is not None:
            ends = np.where(best[block][:, None, None], arrays.high, arrays.low)
            value = np.where(arrays.bounded, ends, value)
        found[block] = _scores(value, arrays.has, cases[block] * arrays.weights, weights[block])
    middle = _scores(arrays.value, arrays.has, arrays.weights, asked)
    return _placed(evidence, arrays, middle, found)


def _placed(evidence: Evidence, arrays: _Arrays, middle: Floats, found: Floats) -> Rank:
    engines = evidence.engines
    best = found >= found.max(axis=1, keepdims=True) - _EQUAL
    first = (best / best.sum(axis=1, keepdims=True)).mean(axis=0)
    ahead = {}
    for a, one in enumerate(engines):
        for b, other in enumerate(engines):
            apart = found[:, a] - found[:, b]
            ahead[one, other] = float(((apart > _EQUAL) + 0.5 * (np.abs(apart) <= _EQUAL)).mean())
    order = sorted(range(len(engines)), key=lambda e: (-first[e], -middle[e], engines[e]))
    numbers = _numbers([engines[e] for e in order], ahead)
    low, high = np.percentile(found, (2.5, 97.5), axis=0)
    shares = arrays.weights * arrays.has
    means = np.einsum("kc,kce->ke", shares, arrays.value) / np.maximum(shares.sum(axis=1), _EQUAL)[:, None]
    return Rank(
        places=tuple(
            Place(
                engine=engines[e],
                number=numbers[engines[e]],
                score=float(middle[e]),
                low=float(low[e]),
                high=float(high[e]),
                first=float(first[e]),
                by_criterion={name: float(means[k, e]) for k, name in enumerate(arrays.criteria)},
            )
            for e in order
        ),
        ahead=ahead,
        counted={name: int(arrays.has[k].sum()) for k, name in enumerate(arrays.criteria)},
    )


def _numbers(order: Sequence[str], ahead: Mapping[tuple[str, str], float]) -> dict[str, int]:
    """A new number only where every engine before is ahead of every one from here on."""
    numbers: dict[str, int] = {}
    number = 1
    for k, engine in enumerate(order):
        if k and all(ahead[before, after] >= APART for before in order[:k] for after in order[k:]):
            number = k + 1
        numbers[engine] = number
    return numbers
