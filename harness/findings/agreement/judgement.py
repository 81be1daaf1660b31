"""Engines against each other: whose limits are one, who differs, by how much and since when, and what is agreed.

Limits with their error bars are put in camps (`harness.findings.agreement.judgement`); two are compared up to the time to
which both are known. They agree where they lie no further apart than their bars, and what contacts are granted, together.

A limit is **agreed** where a camp has two engines or more that people can deploy, and more of them than any other camp. Each
engine has one vote, on its tuned track if that has a limit, else on its default one: two tracks of one engine are no two
witnesses, and an engine that is undecided between camps has none. One whose steps draw together faster than its integrator
promises is not near a limit yet: it stands in no camp, and is held against the agreed limit alone. The reference engine stands
with a camp like any other and is shown there, but it has no vote: else it would judge whom it is judged with. The agreed limit
is that of the sharpest voter which is known as long as two of them are; its bar is the nearest confirmation by another voter,
distance and that one's bar added.

Camps: who agrees with whom, where each says a value with an error bar and not all say the same.

Two agree where they lie no further apart than their bars together. Agreement is not passed on: A may agree with B and B with C
while A and C differ, when B's bar is wide. So whoever has the narrowest bar speaks first; the next one joins the camp with all
of whose members it agrees, or founds one of its own; one that agrees with all members of several camps is undecided, for its
bar is too wide to tell them apart.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.agreement.values import Agreement, CampGap, Side, Word
from plumbline.harness.scene import Scene
from plumbline.harness.search.own_limits import OwnLimit, granted_of
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.parting import NOTHING, Extent, extent, length, offsets

Flags: TypeAlias = NDArray[np.bool_]


def camps(agree: Flags, widths: Sequence[float]) -> list[tuple[int, ...]]:
    """The camps that each one belongs to, by number from 0 in the order of their founding: one, or several where it is
    undecided.

    Args: agree (n, n): does each pair agree? widths (n,): of the bars; the narrowest speaks first.
    """
    founded: list[list[int]] = []
    belongs: dict[int, tuple[int, ...]] = {}
    for bar in sorted(range(len(widths)), key=lambda bar: (widths[bar], bar)):
        fits = tuple(k for k, members in enumerate(founded) if all(agree[bar, other] for other in members))
        if not fits:
            fits = (len(founded),)
            founded.append([])
        if len(fits) == 1:
            founded[fits[0]].append(bar)
        belongs[bar] = fits
    return [belongs[bar] for bar in range(len(widths))]


LONGER = 2.0
"""Others converge so many times as long: beyond what a higher order or chance makes of a horizon."""


def judged(
    scene: Scene | None,
    duration: float,
    limits: Mapping[tuple[str, str], OwnLimit],
    ours: Collection[str],
    *,
    touching: bool = False,
    case: str = "",
    where: str = "",
) -> Agreement:
    """What engines say of a scene.

    Args: scene: None where no engine could be told it. duration [s]. limits: of each engine and track. ours: the engines of
    this project. touching: does any body touch another in any run? case, where: what it is of.
    """
    places = list(dict.fromkeys(engine for engine, _ in limits))
    sides = [
        Side(engine=engine, track=track, ours=engine in ours, word=limit.kind, why=limit.why, limit=limit)
        for (engine, track), limit in limits.items()
    ]
    sides.sort(key=lambda side: (side.ours, places.index(side.engine), side.track))
    scale = NOTHING if scene is None else extent(scene)
    plain = Agreement(
        case=case,
        where=where,
        duration=duration,
        scale=scale,
        granted=0.0 if scene is None else granted_of(scene, scale, touching=touching),
        sides=tuple(_stopped(sides)),
        differences=(),
        scene=scene,
    )
    return plain if scene is None else _against_each_other(plain, scene)


def _stopped(sides: Sequence[Side]) -> list[Side]:
    """Those whose answers part for good where others' go on drawing together do not converge."""
    longest: dict[str, float] = {}
    for side in sides:
        if not side.ours:
            longest[side.engine] = max(longest.get(side.engine, 0.0), side.limit.until)

    def judged(side: Side) -> Side:
        convergence = side.limit.said
        others = sorted((until for engine, until in longest.items() if engine != side.engine), reverse=True)
        if side.word != "converges" or convergence is None or convergence.ended != "no shrinking" or not others:
            return side
        if others[0] < LONGER * side.limit.until:
            return side
        since = f"from {side.limit.until:.3g} s on" if side.limit.until else "from the start on"
        why = f"{since} smaller steps do not draw together, others converge up to {others[0]:.3g} s"
        return replace(side, word="does not converge", why=why)

    return [judged(side) for side in sides]


def _against_each_other(plain: Agreement, scene: Scene) -> Agreement:
    """The camps, the differences between them, and the limit that is agreed."""
    known = [side for side in plain.sides if side.word == "converges" and not side.limit.too_fast]
    if not known:
        return replace(plain, sides=tuple(map(_not_yet, plain.sides)))
    pairs = {
        (a, b): _compare(_known(known[a]), _known(known[b]), plain.scale, plain.granted)
        for a, b in combinations(range(len(known)), 2)
    }
    # The longer it is asked for, the fewer know, and the sooner those who know have parted: the longest that is agreed counts.
    for until in sorted({side.limit.until for side in known}, reverse=True):
        made = _in_camps(plain, scene, known, pairs, until)
        if agreed := _majority(made, until):
            return _agreed(made, agreed, until)
    apart = _in_camps(plain, scene, known, pairs, plain.duration)
    return replace(apart, sides=tuple(map(_not_yet, apart.sides)))


def _not_yet(side: Side) -> Side:
    """A side whose steps draw together too fast does not converge: nothing says where to."""
    if side.word != "converges" or not side.limit.too_fast:
        return side
    order = side.limit.said.order if side.limit.said is not None else None
    why = f"order {order:.2f}, and its integrator has {side.limit.promised}: smaller steps would tell where it ends"
    return replace(side, word="does not converge", why=why)


def _in_camps(
    plain: Agreement, scene: Scene, known: Sequence[Side], pairs: "Mapping[tuple[int, int], _Pair]", until: float
) -> Agreement:
    """The agreement with its camps, as they are up to a time [s], votes and differences."""
    agree = np.ones((len(known), len(known)), bool)
    for (a, b), pair in pairs.items():
        agree[a, b] = agree[b, a] = pair.since is None or pair.since > until
    shortest = min(side.limit.until for side in known)
    # Whose limit is known for long speaks before one that is sharp for a moment.
    widths = [side.limit.bar_at(shortest) + max(until - side.limit.until, 0.0) * _SHORT for side in known]
    letters = {
        (side.engine, side.track): tuple(chr(ord("A") + number % 26) * (1 + number // 26) for number in camp)
        for side, camp in zip(known, camps(agree, widths), strict=True)
    }
    sides = _counted_tracks([replace(side, camps=letters.get((side.engine, side.track), ())) for side in plain.sides])
    return replace(plain, sides=tuple(sides), differences=_differences(sides, plain, scene))


def _majority(made: Agreement, until: float) -> str:
    """The camp with more votes than any other, two of whose voters are known up to a time [s]; '' for none."""
    votes = {letter: [side for side in made.members(letter) if side.votes] for letter in made.camps}
    first, *others = sorted(votes, key=lambda letter: -len(votes[letter])) or [""]
    if not first or any(len(votes[other]) == len(votes[first]) for other in others):
        return ""
    return first if sum(side.limit.until >= until for side in votes[first]) >= 2 else ""


_SHORT = 1.0
"""Share of the size for each second that a limit is not known: more than any bar of one that is."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two limits: how far apart up to `time` [s], since when [s] more than their bars, and the place of the body there."""

    distance: float
    time: float
    since: float | None
    body: int


@dataclass(frozen=True, slots=True)
class _Known:
    """Poses, with how far off they may be up to each sample (t,), and the time [s] up to which they are known."""

    poses: Trajectory
    bars: Floats
    until: float


def _known(side: Side) -> _Known:
    assert side.limit.value is not None
    assert side.limit.bar is not None
    return _Known(side.limit.value, side.limit.bar, side.limit.seen_until)


def _compare(first: _Known, second: _Known, scale: Extent, granted: float) -> _Pair:
    time = min(first.until, second.until)
    here, there = first.poses.between(0.0, time), second.poses.between(0.0, time)
    offset, end = offsets(here, there, scale), len(here)
    distance = np.maximum.accumulate(length(offset))
    beyond = np.flatnonzero(distance > first.bars[:end] + second.bars[:end] + granted)
    parts = np.linalg.norm(offset[..., :3], axis=-1) + np.linalg.norm(offset[..., 3:], axis=-1)
    body = int(scale.bodies[int(np.argmax(parts.max(axis=0)))])
    return _Pair(float(distance[-1]), time, float(here.time[beyond[0]]) if len(beyond) else None, body)


def _counted_tracks(sides: Sequence[Side]) -> list[Side]:
    """The track of each engine that votes: tuned if it is in a cluster, else another one that is."""
    chosen: dict[str, Side] = {}
    for side in sorted(sides, key=lambda side: side.track != "tuned"):
        if len(side.camps) == 1 and not side.ours:
            chosen.setdefault(side.engine, side)
    return [replace(side, votes=side is chosen.get(side.engine)) for side in sides]


def _differences(sides: Sequence[Side], plain: Agreement, scene: Scene) -> tuple[CampGap, ...]:
    letters = sorted({side.camps[0] for side in sides if len(side.camps) == 1})
    sharpest = {letter: _known(_sharpest([side for side in sides if side.camps == (letter,)])) for letter in letters}
    differences = []
    for first, second in combinations(letters, 2):
        pair = _compare(sharpest[first], sharpest[second], plain.scale, plain.granted)
        if pair.since is not None:
            name, distance = scene.bodies[pair.body].name, pair.distance
            differences.append(CampGap(one=first, other=second, distance=distance, time=pair.time, since=pair.since, body=name))
    return tuple(differences)


def _sharpest(sides: Sequence[Side]) -> Side:
    """The one that is known longest, and of several the one with the narrowest bar."""
    return min(sides, key=lambda side: (-side.limit.until, side.limit.bar_at(side.limit.until)))


def _agreed(made: Agreement, letter: str, until: float) -> Agreement:
    """The agreement on the limit of a camp, known up to a time [s], and the words that follow from it."""
    there = [side for side in made.members(letter) if side.votes and side.limit.until >= until]
    centre = min(there, key=lambda side: side.limit.bar_at(until))
    limit = _known(centre).poses.between(0.0, until)
    nearest = np.full(len(limit), np.inf)
    for other in (_known(side) for side in there if side is not centre):
        way = np.maximum.accumulate(length(offsets(other.poses.between(0.0, until), limit, made.scale)))
        nearest = np.minimum(nearest, way + other.bars[: len(limit)])
    bars = np.maximum(_known(centre).bars[: len(limit)], nearest)
    agreed = replace(made, agreed=letter, until=until, limit=limit, bars=bars, bar=float(bars[-1]))
    return replace(agreed, sides=tuple(_placed(side, agreed) for side in agreed.sides))


def _placed(side: Side, agreed: Agreement) -> Side:
    """A side with its distance from the agreed limit, and the word for that."""
    if side.word != "converges" or agreed.limit is None or agreed.bars is None:
        return side
    pair = _compare(_known(side), _Known(agreed.limit, agreed.bars, agreed.until), agreed.scale, agreed.granted)
    if side.limit.too_fast:
        return replace(_not_yet(side) if pair.since is not None else replace(side, word="agrees"), distance=pair.distance)
    # A camp forms about its sharpest member; what never leaves the bars of the agreed limit is no other answer.
    word: Word = "agrees" if agreed.agreed in side.camps or pair.since is None else "converges elsewhere"
    since = pair.since if word == "converges elsewhere" else None
    return replace(side, word=word, distance=pair.distance, since=since)
