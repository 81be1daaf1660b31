"""The rank of engines and its doubt: scores of resamples of the cases, the timings and the weights.

A score is the weighted mean over criteria of the weighted mean over cases. Each resample takes the cases anew with replacement
(the same for all engines: the bootstrap of B. Efron & R. J. Tibshirani, 1993, chapter 6), speeds and limits from their
intervals, and the weights of criteria off by a factor from a log-normal distribution.

The page on selection draws the same numbers in a browser, so that page, command line and JSON say the same share: numbers come
from one small generator, and each resample takes the same count of them.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.selection.evidence import Evidence
from plumbline.harness.findings.selection.wish import CRITERIA, Wish

Floats = NDArray[np.float64]

DRAWS = 2000
"""Resamples: a share of a half is known to 2 %, 1.96 sqrt(1/4/2000)."""
SEED = 1
DOUBT_OF_WEIGHTS = 0.4
"""Spread of the logarithm of each weight: two thirds of the draws lie between 2/3 and 3/2 of what was asked for."""
_EQUAL = 1e-12


@dataclass(frozen=True, kw_only=True)
class Place:
    """An engine in the rank. number: 1 for the first. score: at the weights asked for, 0 to 1, low..high its 95 % interval.
    first: the share of resamples in which it leads; those that lead together share one. by_criterion: its mean of each
    criterion of which there is evidence."""

    engine: str
    number: int
    score: float
    low: float
    high: float
    first: float
    by_criterion: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Rank:
    """places: by share, best first; equals by score and name. counted: cases by criterion."""

    places: tuple[Place, ...]
    counted: Mapping[str, int]


@dataclass(frozen=True, kw_only=True)
class Resampled:
    """criteria, cases: in the order of the arrays. value: (criteria, cases, engines). share: (draws, criteria, cases), of the
    score that a case has by a criterion; fixed: (criteria, cases), the same at the weights asked for. scores: (draws, engines).
    """

    criteria: tuple[str, ...]
    cases: tuple[str, ...]
    value: Floats
    share: Floats
    fixed: Floats
    has: Floats
    scores: Floats
    drawn: Floats


def uniform(count: int, seed: int = SEED) -> Floats:
    """Numbers in 0..1, shape (count,), as the page's script draws them: mulberry32, by T. Ettinger (2017), in the public
    domain, whose state is a counter."""
    state = np.uint32(seed) + np.arange(1, count + 1, dtype=np.uint32) * np.uint32(0x6D2B79F5)
    mixed = (state ^ (state >> np.uint32(15))) * (state | np.uint32(1))
    mixed ^= mixed + (mixed ^ (mixed >> np.uint32(7))) * (mixed | np.uint32(61))
    return np.asarray((mixed ^ (mixed >> np.uint32(14))) / 2.0**32, dtype=np.float64)


def _normal(pairs: Floats) -> Floats:
    """Normal deviates from pairs of uniform numbers, (..., 2): G. E. P. Box & M. E. Muller (1958)."""
    deviates: Floats = np.sqrt(-2 * np.log(1 - pairs[..., 0])) * np.cos(2 * math.pi * pairs[..., 1])
    return deviates


def _shares(has: Floats, cases: Floats, weights: Floats) -> Floats:
    """The part (..., criteria, cases) of the score that each case has by each criterion; a criterion none of whose cases counts
    has none. Args: has: (criteria, cases). cases: weights (..., cases). weights: (..., criteria)."""
    of_cases = cases[..., None, :] * has
    total = of_cases.sum(axis=-1)
    counts = weights * (total > 0)
    shares: Floats = of_cases * (counts / np.maximum(total, _EQUAL) / np.maximum(counts.sum(-1), _EQUAL)[..., None])[..., None]
    return shares


def _table(evidence: Evidence, wish: Wish) -> tuple[tuple[str, ...], Floats, Floats]:
    """The criteria that count, (3, criteria, cases, engines) of value, low and high, and (criteria, cases) of what is known."""
    known = {criterion for criterion, _, _ in evidence.table}
    criteria = tuple(name for name in CRITERIA if name in known and wish.weight(name) > 0)
    values = np.zeros((3, len(criteria), len(evidence.cases), len(evidence.engines)))
    has = np.zeros(values.shape[1:3])
    for k, criterion in enumerate(criteria):
        for c, case in enumerate(evidence.cases):
            for e, engine in enumerate(evidence.engines):
                datum = evidence.table.get((criterion, case, engine))
                if datum is not None:
                    values[:, k, c, e], has[k, c] = (datum.value, datum.low, datum.high), 1.0
    return criteria, values, has


def scores(evidence: Evidence, wish: Wish) -> dict[str, float]:
    """At the weights asked for, by engine."""
    criteria, values, has = _table(evidence, wish)
    shares = _shares(has, np.array([*evidence.cases.values()]), np.array([wish.weight(name) for name in criteria]))
    return dict(zip(evidence.engines, map(float, np.einsum("kc,kce->e", shares, values[0])), strict=True))


def resampled(evidence: Evidence, wish: Wish, draws: int = DRAWS) -> Resampled:
    """Raises: ValueError, where there is no evidence."""
    criteria, (value, low, high), has = _table(evidence, wish)
    if not criteria or not evidence.engines:
        raise ValueError("no evidence: no criterion has anything to say of these cases and engines")
    of_cases, wanted = np.array([*evidence.cases.values()]), np.array([wish.weight(name) for name in criteria])
    count, engines = len(of_cases), len(evidence.engines)
    # One case less than there are: the spread of a mean over n cases is then without bias (J. N. K. Rao & C. F. J. Wu, 1988).
    taken = max(count - 1, 1)
    numbers = uniform(draws * (taken + 2 * count * engines + 2 * len(criteria))).reshape(draws, -1)
    chosen = np.floor(numbers[:, :taken] * count).astype(np.intp)
    times = (chosen[:, :, None] == np.arange(count)).sum(axis=1)
    # One position in its interval for each engine and case, the same for all criteria: low..high is central 95 %, so that a
    # normal deviate of 1.96 is an end.
    middle, end = taken + 2 * count * engines, numbers.shape[1]
    within = np.clip(_normal(numbers[:, taken:middle].reshape(draws, 1, count, engines, 2)) / 1.96, -1.0, 1.0)
    factors = np.exp(DOUBT_OF_WEIGHTS * _normal(numbers[:, middle:end].reshape(draws, -1, 2)))
    share = _shares(has, times * of_cases, wanted * factors)
    totals = np.empty((draws, engines))
    drawn = np.empty((draws, *value.shape), dtype=np.float64)
    for block in np.array_split(np.arange(draws), math.ceil(draws / 500)):
        up = within[block]
        drawn[block] = value + np.where(up > 0, up * (high - value), up * (value - low))
        totals[block] = np.einsum("dkc,dkce->de", share[block], drawn[block])
    return Resampled(
        criteria=criteria,
        cases=tuple(evidence.cases),
        value=value,
        share=share,
        fixed=_shares(has, of_cases, wanted),
        has=has,
        scores=totals,
        drawn=drawn,
    )


def first_shares(scores: Floats) -> Floats:
    """The share of resamples in which each engine leads, (engines,), of scores (draws, engines)."""
    best = scores >= scores.max(axis=1, keepdims=True) - _EQUAL
    shares: Floats = (best / best.sum(axis=1, keepdims=True)).mean(axis=0)
    return shares


def rank(evidence: Evidence, samples: Resampled) -> Rank:
    """The engines by the share of resamples in which they lead."""
    engines, first = evidence.engines, first_shares(samples.scores)
    middle = np.einsum("kc,kce->e", samples.fixed, samples.value)
    order = sorted(range(len(engines)), key=lambda e: (-first[e], -middle[e], engines[e]))
    low, high = np.percentile(samples.scores, (2.5, 97.5), axis=0)
    counts = samples.has * np.array([*evidence.cases.values()])
    means = np.einsum("kc,kce->ke", counts, samples.value) / np.maximum(counts.sum(axis=1), _EQUAL)[:, None]
    return Rank(
        places=tuple(
            Place(
                engine=engines[e],
                number=number,
                score=float(middle[e]),
                low=float(low[e]),
                high=float(high[e]),
                first=float(first[e]),
                by_criterion={name: float(means[k, e]) for k, name in enumerate(samples.criteria)},
            )
            for number, e in enumerate(order, start=1)
        ),
        counted={name: int(samples.has[k].sum()) for k, name in enumerate(samples.criteria)},
    )
