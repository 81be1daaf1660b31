"""What happened to the bodies of a scene without a truth, engine by engine, and which engines differ in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbline.harness.findings.agreement.values import Agreement, Side, Word
from plumbline.harness.findings.agreement.words import angle_words, called, distance_words, length, listed, up_to
from plumbline.harness.findings.once import once
from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import parse
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.events import ANGLES, MOVED, Event, Touched, happened, size_of

_END = 0.01
"""Of the run: a time so near its end is the end, and none is named."""
ALIKE = 0.1
"""Of a distance or of the run: what two engines' events may differ by and be called alike, as wide as what words tell."""

FEW = 6
"""Bodies that a sentence tells of, those alike counted once: a heap has hundreds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Happened:
    """What happened alike on several sides. Terms: sides: (engine, track); events: of the first of them."""

    sides: tuple[tuple[str, str], ...]
    events: tuple[Event, ...]


@once
def events_of(store: Store, trial: str) -> tuple[Event, ...]:
    """Of one run of the store."""
    (name,) = store.trials.loc[store.trials["trial"] == trial, "trajectory_hash"]
    arrays = store.trajectory(str(name))
    time, p_WB, q_WB, v_WB, w_WB = (arrays[key] for key in ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
    run = Trajectory(time, p_WB, q_WB, v_WB, w_WB)
    return happened(parse(str(arrays["scene"]), "scene.json"), run, Touched.of(arrays))


def happenings(store: Store, agreement: Agreement) -> list[Happened]:
    """In the finest run of each side, those alike together: the largest group of engines that people can deploy first."""
    groups: list[Happened] = []
    if agreement.scene is None:
        return groups
    for side in sorted(agreement.sides, key=lambda side: (side.ours, not side.votes, side.camps != (agreement.agreed,))):
        if (rung := side.limit.finest) is None:
            continue
        events = events_of(store, rung.trial)
        for index, group in enumerate(groups):
            if alike(group.events, events, agreement.duration, agreement.scene):
                groups[index] = Happened(sides=(*group.sides, (side.engine, side.track)), events=group.events)
                break
        else:
            groups.append(Happened(sides=((side.engine, side.track),), events=events))
    ours = {side.engine for side in agreement.sides if side.ours}
    return sorted(groups, key=lambda group: -len({engine for engine, _ in group.sides} - ours))


def alike(some: Sequence[Event], others: Sequence[Event], duration: float, scene: Scene) -> bool:
    """Did the same happen, at about the same times and about as far?"""
    keyed = [{(event.body, event.kind, event.other): event for event in events} for events in (some, others)]
    return keyed[0].keys() == keyed[1].keys() and not any(
        _unlike(event, keyed[1][key], duration, scene) for key, event in keyed[0].items()
    )


def _unlike(event: Event, other: Event, duration: float, scene: Scene) -> bool:
    if event.kind == "at rest" and (event.time == 0.0) != (other.time == 0.0):
        return True  # one of them moved first
    if abs(event.time - other.time) > ALIKE * duration or abs(event.count - other.count) > max(1, ALIKE * event.count):
        return True
    if event.value is None or other.value is None:
        return False
    least = ALIKE if event.kind in ANGLES else MOVED * size_of(scene, scene.index(event.body))
    return abs(event.value - other.value) > max(least, ALIKE * max(event.value, other.value))


def event_words(event: Event) -> str:
    """'bounces 9 times, first by 245 mm at 0.32 s'."""
    if event.kind == "at rest" and event.time == 0.0:
        return "stays where it is"
    value = "" if event.value is None else angle_words(event.value) if event.kind in ANGLES else distance_words(event.value)
    times = "once" if event.count == 1 else f"{event.count} times"
    if event.kind == "collided" and (event.count > 1 or not event.other):
        first, other = f"{times}, first " if event.count > 1 else "", f"with '{event.other}' " if event.other else ""
        return f"collides {first}{other}at {event.time:.3g} s"
    return str(SPOKEN["happened"][event.kind]).format(other=event.other, time=f"{event.time:.3g} s", value=value, times=times)


def body_words(events: Sequence[Event]) -> str:
    """'ball bounces 9 times, ..., is at rest from 2 s on'; bodies to which the same happened together."""
    by_body: dict[str, list[str]] = {}
    for event in events:
        by_body.setdefault(event.body, []).append(event_words(event))
    together: dict[str, list[str]] = {}
    for body, words in by_body.items():
        together.setdefault(", ".join(words), []).append(f"'{body}'")
    return _first_few([f"{listed(bodies)}{' each' * (len(bodies) > 1)} {words}" for words, bodies in together.items()])


def _first_few(sentences: Sequence[str]) -> str:
    left = len(sentences) - FEW
    return "; ".join([*sentences[:FEW], *([f"and {left} more like these"] if left > 0 else [])])


def happened_words(groups: Sequence[Happened], agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """What happened on most engines, then in what others differ."""
    if not groups:
        return []
    first, *others = groups
    sentence = body_words(first.events) or "no body rests, bounces, collides, tips, slides, swings or meets a stop"
    lines = [f"What happens{'' if not others else ' on ' + called(first.sides, agreement, titles)}: {sentence}."]
    for other in others:
        lines.append(f"Otherwise on {called(other.sides, agreement, titles)}: {_differing(first.events, other.events)}.")
    return lines


def _differing(base: Sequence[Event], events: Sequence[Event]) -> str:
    """What of another's events are not those of the base, and what of the base it lacks."""
    keys = {(event.body, event.kind, event.other): event for event in base}
    own = {(event.body, event.kind, event.other) for event in events}
    shared = {(event.body, event_words(event)) for event in base}
    other = [event for event in events if (event.body, event_words(event)) not in shared]
    lacks = [event for key, event in keys.items() if key not in own]
    words = [body_words(other)] if other else []
    return _first_few(
        [*words, *(f"'{event.body}' {SPOKEN['lacking'][event.kind].format(other=event.other)}" for event in lacks)]
    )


def end_words(groups: Sequence[Happened], store: Store, agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """Whose steps no longer draw together before the end of the run, from when on, and what differs then."""
    if not groups or agreement.scene is None:
        return []
    ends: dict[tuple[float, str], list[tuple[str, str]]] = {}
    for side in agreement.sides:
        runs = [rung for rung in side.limit.rungs if rung.run is not None]
        if side.limit.said is None or len(runs) < 2 or side.limit.seen_until >= (1 - _END) * agreement.duration:
            continue
        finest_events, coarser = (events_of(store, rung.trial) for rung in (runs[-1], runs[-2]))
        what = ""
        if not alike(finest_events, coarser, agreement.duration, agreement.scene):
            what = f": at half the step {_differing(coarser, finest_events)}"
        elif not alike(groups[0].events, finest_events, agreement.duration, agreement.scene):
            what = f": {_differing(groups[0].events, finest_events)}"
        ends.setdefault((side.limit.seen_until, what), []).append((side.engine, side.track))
    parts = [
        f"{called(sides, agreement, titles)} from {f'{time:.3g} s' if time else 'the start'} on{what}"
        for (time, what), sides in sorted(ends.items())
    ]
    return [f"Smaller steps no longer agree with each other on {'; on '.join(parts)}."] if parts else []


SO_FAR: dict[Word, str] = SPOKEN["so_far"]
COLUMNS = ("scene", "engine", "track", "so far", "up to", "moved by the last halving", "away")


def rows_so_far(agreement: Agreement) -> list[tuple[str, ...]]:
    """One row for each engine and track, as `COLUMNS`."""
    return [(agreement.case.rsplit("/", 1)[-1], side.engine, side.track, *_cells(side, agreement)) for side in agreement.sides]


def _cells(side: Side, agreement: Agreement) -> tuple[str, ...]:
    limit = side.limit
    until = f"{limit.seen_until:.3g} s" if limit.seen_until else ""
    moved = "" if limit.moved is None else length(float(limit.moved[-1]), agreement)
    return SO_FAR[side.word], until, moved, "" if side.distance is None else length(side.distance, agreement)


def words_so_far(store: Store, agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """Who lies together and who does not, then what happens at the finest of the steps."""
    by_word = {word: [side for side in agreement.sides if side.word == word] for word in SO_FAR}
    parts = [
        f"{SO_FAR[word]}{_how(word, sides, agreement)}: {called([(s.engine, s.track) for s in sides], agreement, titles)}"
        for word, sides in by_word.items()
        if sides
    ]
    first, *others = happened_words(happenings(store, agreement), agreement, titles) or [""]
    at_finest = [f"At the finest of these steps: {first}", *others] if first else []
    return [f"So far {'; '.join(parts)}. Smaller steps may change that.", *at_finest]


def _how(word: Word, sides: list[Side], agreement: Agreement) -> str:
    if word == "agrees":
        return f" {up_to(agreement, agreement.until)}"
    away = max((side.distance or 0.0 for side in sides), default=0.0)
    return f", by {length(away, agreement)} at most" if word == "converges elsewhere" else ""
