"""Which setting makes an engine's track end elsewhere: each is turned alone, and the run that comes nearest tells.

An engine is asked where its two tracks end apart by more than their bars and what is granted: the settings of `default` are
turned to those of `tuned` one by one, at one step that both have answered. Where the tracks end alike and apart from two others
that end alike, the knobs of `tuned` are turned. The likeliest come first: those called like an effect that the engine adds,
then like a law of the scene, then those that act on what it has, then the others; as many as the experiment allows and the
engine's share of the budget pays for.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import TURNED, Alteration
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.search.own_limits import ANSWERED, TOLERANCE, OwnLimit, granted_of
from plumbline.harness.store.record import Record
from plumbline.harness.study.one_knob import Turn, differing, label_of, turned, turns
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory.parting import Extent, apart, common

_GENERAL = Effect.GRAVITY | Effect.CONTACT | Effect.JOINTS | Effect.DRIVES | Effect.SENSING
"""What nearly every setting is about."""
Side = tuple[str, str]
"""Engine and track."""


def turned_trials(
    ladders: Mapping[Side, Sequence[Trial]],
    limits: Mapping[Side, OwnLimit],
    records: Mapping[str, Record],
    case: Case,
    adapters: Mapping[str, Adapter],
    scale: Extent,
    *,
    near: float,
    most: int,
    affordable: Mapping[Side, float],
    number: int,
) -> Iterator[Trial]:
    """The runs of one setting turned each. Args: near [s]: the step that is asked for. affordable [s]: CPU time by side."""
    for engine in dict.fromkeys(engine for engine, _ in ladders):
        track = _questioned(engine, limits, case.scene(case.at(**next(iter(ladders.values()))[0].parameters)), scale)
        if track is None:
            continue
        base = _at(ladders[engine, track], records, near)
        target = _at(ladders.get((engine, "tuned"), ()), records, near)
        if base is None or target is None or (track == "default" and base.settings.dt != target.settings.dt):
            continue
        cost = (records[base.trial].rough_cost or 0.0) * case.duration
        count = most if cost <= 0 else min(most, int(affordable[engine, track] / cost))
        likely = candidates(base, target, records[base.trial], case, adapters[engine])
        for turn in islice(likely, count):
            yield base.probing(
                case,
                track=label_of(track, [(turn.name, turn.value)]),
                base=track,
                settings=turned(base.settings, turn.knob, turn.value),
                alteration=Alteration(name=TURNED),
                round=number,
            )


def _questioned(engine: str, limits: Mapping[Side, OwnLimit], scene: Scene, scale: Extent) -> str | None:
    """The track whose settings are turned; None where nothing is to be explained."""
    default, tuned = limits.get((engine, "default")), limits.get((engine, "tuned"))
    if default is not None and tuned is not None and _part(default, tuned, scene, scale):
        return "default"
    others = [limit for (name, track), limit in limits.items() if name != engine and track == "tuned" and limit.finest]
    if tuned is None or len(others) < 2 or not all(_part(tuned, other, scene, scale) for other in others):
        return None
    return "tuned" if any(not _part(a, b, scene, scale) for k, a in enumerate(others) for b in others[:k]) else None


def _part(first: OwnLimit, second: OwnLimit, scene: Scene, scale: Extent) -> bool:
    """Do two end apart: their limits by more than both bars and what is granted, else their finest runs by the tolerance?"""
    if first.value is not None and second.value is not None and min(first.seen_until, second.seen_until) > 0:
        until = min(first.seen_until, second.seen_until)
        first_cut, second_cut = common([first.value.between(0.0, until), second.value.between(0.0, until)])
        granted = granted_of(scene, scale, touching=Effect.CONTACT in scene.effects)
        allowed = first.bar_at(until) + second.bar_at(until) + granted
    else:
        runs = [rung.run for limit in (first, second) if (rung := limit.finest) is not None and rung.run is not None]
        if len(runs) < 2:
            return False
        first_cut, second_cut = common(runs)
        allowed = TOLERANCE
    return float(apart(first_cut, second_cut, scale).max(initial=0.0)) > allowed


def _at(ladder: Sequence[Trial], records: Mapping[str, Record], near: float) -> Trial | None:
    """The run of a ladder that has an answer and whose step is nearest to one [s]."""
    answered = [trial for trial in ladder if trial.trial in records and records[trial.trial].status in ANSWERED]
    return min(answered, key=lambda trial: abs(trial.settings.dt - near), default=None)


def candidates(base: Trial, target: Trial, record: Record, case: Case, adapter: Adapter) -> list[Turn]:
    """The turns of one setting, the likeliest first: to where the other track has it, or of a knob where there is none."""
    scene = base.scene(case)
    meant = adapter.knobs_in(scene)
    every = differing(base.settings, target.settings) or list(turns(base.settings, meant, adapter.knobs))
    first: dict[tuple[str, object], Turn] = {}
    for turn in every:
        if turn.knob not in adapter.knobs or turn.knob in meant:
            first.setdefault((turn.knob, turn.value), turn)
    added = [notice.effect for notice in record.warnings if notice.kind == "surplus" and notice.effect]

    def like(turn: Turn, effects: Iterable[str]) -> bool:
        return any(turn.name in effect or effect in turn.name for effect in effects)

    def rank(turn: Turn) -> tuple[bool, bool, bool, bool]:
        unlike = not like(turn, added), not like(turn, (scene.effects & ~_GENERAL).names)
        return *unlike, turn.knob not in adapter.acts_on, turn.knob not in adapter.knobs

    return sorted(first.values(), key=rank)
