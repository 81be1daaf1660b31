"""What is said of engines in a scene without a truth, made of the values last.

Drives and springs that swing faster than any step that was run: what engines agree on is what their steps make of them.

A stiffness k on an inertia I swings with w = sqrt(k/I), and its swing dies away by d/(2 I) a second. Where w h > 1 at the
finest step h no run follows it: an implicit step takes it away at once. Nobody sees the difference if it has died away by the
next sample anyway; else it is there, and no engine shows it. I is that of all behind the joint at the start, if that is stiff.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbline.harness.findings.agreement.perturbed_starts import LAWS, Balance, Outlook, foreseeable_until
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.scene import Prismatic, Revolute, Scene
from plumbline.harness.trajectory.kinematics import carried


def unresolved_words(agreement: Agreement) -> list[str]:
    """A sentence that names the joints whose swing no run follows, and that lasts from one sample to the next."""
    finest = [side.limit.finest for side in agreement.sides]
    steps = [rung.substep for rung in finest if rung is not None]
    runs = [rung.run for rung in finest if rung is not None and rung.run is not None]
    if agreement.scene is None or not steps:
        return []
    sample = float(runs[0].time[1] - runs[0].time[0])
    periods = {
        joint.name: 2 * math.pi / rate
        for joint in agreement.scene.joints
        if isinstance(joint, Revolute | Prismatic)
        for rate, decay in [_swing(agreement.scene, joint)]
        if rate * min(steps) > 1 and decay * sample < 1
    }
    if not periods:
        return []
    names, shortest = ", ".join(f"'{name}'" for name in periods), 1e3 * min(periods.values())
    return [
        f"No step that was run follows the swing of {names} (a period of {shortest:.2g} ms, hardly damped): what engines agree "
        "on there is what their steps make of it."
    ]


def _swing(scene: Scene, joint: Revolute | Prismatic) -> tuple[float, float]:
    """How fast the springs and drive of a joint swing [rad/s], and how fast that dies away [1/s]."""
    laws = [law for law in (joint.spring, joint.drive) if law is not None]
    inertia = carried(scene, joint)
    stiffness, damping = sum(law.stiffness for law in laws), sum(law.damping for law in laws)
    return (math.sqrt(stiffness / inertia), damping / (2 * inertia)) if inertia > 0 else (0.0, 0.0)


AT_START = 0.05
"""Of the run: who parts within it differs from the start on."""


def share(value: float) -> str:
    """A share of the size: '0.12 %', '138 %', '5e-08' where per cent say little."""
    return f"{100 * value:.{2 if value < 0.1 else 3}g} %" if 1e-5 <= value < 10 else f"{value:.2g}"


def metres(value: float, agreement: Agreement) -> str:
    """A share of the size as a length: '5.63 µm', 'under 1 nm'; '' where wholes have sizes of their own."""
    if not value or not len(agreement.scale.size) or agreement.scale.size.min() < 0.999 * agreement.scale.largest:
        return ""
    return distance_words(value * agreement.scale.largest)


def distance_words(distance: float) -> str:
    """A length [m] in the unit that suits it: '5.63 µm', 'under 1 nm'."""
    if distance < 1e-9:
        return "under 1 nm"
    units = ((1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
    by, unit = next(((by, unit) for by, unit in units if distance * by >= 1), units[-1])
    return f"{distance * by:.3g} {unit}"


def angle_words(angle: float) -> str:
    """An angle [rad]: '114 degrees', from two turns on '5.3 turns'."""
    degrees = float(np.degrees(angle))
    return f"{degrees:.3g} degrees" if degrees < 720 else f"{degrees / 360:.3g} turns"


def length(value: float, agreement: Agreement) -> str:
    """A share of the size with the length that it is behind it, where there is one: '5.6e-06 (5.63 µm)'."""
    in_metres = metres(value, agreement)
    return f"{share(value)} ({in_metres})" if in_metres else share(value)


def listed(names: Sequence[str]) -> str:
    """'a, b and c'."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else ""


def called(sides: Sequence[tuple[str, str]], agreement: Agreement, titles: Mapping[str, str]) -> str:
    """'Bullet (default) and DART': engines, each once, with the track where only one of its tracks is meant."""
    tracks: dict[str, list[str]] = {}
    for engine, track in sides:
        tracks.setdefault(engine, []).append(track)
    every = {engine: {side.track for side in agreement.sides if side.engine == engine} for engine in tracks}
    return listed(
        [
            titles.get(engine, engine) + ("" if set(mine) == every[engine] else f" ({listed(mine)})")
            for engine, mine in tracks.items()
        ]
    )


def _camp(agreement: Agreement, letter: str, titles: Mapping[str, str]) -> str:
    return called([(side.engine, side.track) for side in agreement.members(letter)], agreement, titles)


def up_to(agreement: Agreement, time: float) -> str:
    """'up to 0.3 s'."""
    return "to the end" if time >= 0.999 * agreement.duration else f"up to {time:.3g} s"


def headline(agreement: Agreement, titles: Mapping[str, str]) -> str:
    """What is known of the scene, in one sentence."""
    if agreement.agreed:
        voters = [titles.get(side.engine, side.engine) for side in agreement.members(agreement.agreed) if side.votes]
        bar, until = agreement.bar or 0.0, up_to(agreement, agreement.until)
        in_metres = metres(bar, agreement)
        known = f"{share(bar)} of the size of what moves{f' ({in_metres})' if in_metres else ''}"
        return f"{listed(voters)} agree on one limit {until}, known to {known}."
    fast = list(
        dict.fromkeys(titles.get(side.engine, side.engine) for side in agreement.sides if side.limit.too_fast and not side.ours)
    )
    if fast:
        return (
            f"Whether there is one limit cannot be told yet: steps of {listed(fast)} draw together faster than the order of "
            "the integrator, so that smaller ones are needed (--dt, --budget)."
        )
    if not agreement.camps:
        return "No limit is agreed: no engine's answers draw together as its time step shrinks."
    camps = "; ".join(f"{letter}: {_camp(agreement, letter, titles)}" for letter in agreement.camps)
    begins = min((gap.since for gap in agreement.differences), default=0.0)
    since = f" from {begins:.3g} s on" if begins > AT_START * agreement.duration else ""
    return f"No limit is agreed{since}. {'Camps' if len(agreement.camps) > 1 else 'There is one camp'}: {camps}."


def side_words(side: Side, agreement: Agreement) -> str:
    """The verdict on one engine and track: 'agrees (order 1.00, to 5 µm)'."""
    convergence = side.limit.said
    order = "" if convergence is None else "no order" if convergence.order is None else f"order {convergence.order:.2f}"
    if side.word in ("cannot", "diverged", "does not converge"):
        return f"{side.word} ({side.why})" if side.why else side.word
    compared = min(side.limit.seen_until, agreement.until) if agreement.agreed else side.limit.until
    until = "" if compared >= 0.999 * agreement.duration else f", {up_to(agreement, compared)}"
    until += f"; {side.why}" if side.why else ""
    if side.word == "converges elsewhere":
        since = "" if side.since is None else f" since {side.since:.3g} s"
        return f"converges elsewhere ({order}{until}; {length(side.distance or 0.0, agreement)} away{since})"
    bar = side.limit.bar_at(compared) if side.limit.bar is not None else 0.0
    camp = f"; camp {' or '.join(side.camps)}" if side.word == "converges" and len(agreement.camps) > 1 else ""
    return f"{side.word} ({order}{until}; known to {length(bar, agreement)}{camp})"


def cut_words(agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """On whom time ended before all steps were run: one sentence, or none."""
    sides = [(side.engine, side.track) for side in agreement.cut_short]
    who = called(sides, agreement, titles)
    return (
        [f"Time ended before all steps were run on {who}: smaller ones may change the verdict on them (--budget)."]
        if who
        else []
    )


STILL = "Nothing moves in it, so that engines have little to differ in"
JOINTED = ": --scenario swing or sweep moves a robot's joints"


def scene_words(agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """The headline, whether nothing moves, and the differences between camps."""
    lines = [headline(agreement, titles), *unresolved_words(agreement), *cut_words(agreement, titles)]
    if agreement.still and not agreement.moving:
        jointed = agreement.scene is not None and bool(agreement.scene.joints)
        lines.append(f"{STILL}{JOINTED if jointed else ''}.")
    elif agreement.still:
        movers = list(dict.fromkeys(f"{titles.get(side.engine, side.engine)} ({side.track})" for side in agreement.moving))
        lines.append(f"In that limit nothing moves; it does on {listed(movers)}.")
    for gap in agreement.differences:
        apart = [side for side in (*agreement.members(gap.one), *agreement.members(gap.other)) if side.word != "agrees"]
        if not agreement.agreed or (agreement.agreed in (gap.one, gap.other) and apart):
            here, there = (_camp(agreement, letter, titles) for letter in (gap.one, gap.other))
            lines.append(
                f"Camp {gap.one} ({here}) and camp {gap.other} ({there}) part at {gap.since:.3g} s; up to {gap.time:.3g} "
                f"s they come to lie {length(gap.distance, agreement)} apart, most at '{gap.body}'."
            )
    return lines


def present_words(agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """The effects that engines compute although the scene does not call for them: a list, and no cause of anything."""
    by_effects: dict[tuple[str, ...], list[str]] = {}
    for side in agreement.sides:
        if side.adds:
            by_effects.setdefault(side.adds, []).append(f"{titles.get(side.engine, side.engine)} {side.track}")
    parts = [f"{listed(effects)} on {listed(sides)}" for effects, sides in by_effects.items()]
    return [f"Computed although the scene does not call for it: {'; '.join(parts)}."] if parts else []


def side_sentence(side: Side, agreement: Agreement, titles: Mapping[str, str]) -> str:
    """'MuJoCo, tuned: agrees (order 1.00, known to 5e-06).'"""
    ours = " (ours, without a vote)" if side.ours else ""
    return f"{titles.get(side.engine, side.engine)}, {side.track}{ours}: {side_words(side, agreement)}."


def beyond_words(
    broken: Sequence[Balance], outlooks: Sequence[Outlook], agreement: Agreement, titles: Mapping[str, str]
) -> list[str]:
    """What is judged where poses cannot be: the laws that a run breaks, whether starts part, and means over them if they do."""
    lines = []
    for law, word in LAWS.items():
        sides = [balance for balance in broken if balance.law == law and balance.holds is False]
        if sides:
            values = [f"{titles.get(b.engine, b.engine)} {b.track} {b.value:.2g}" for b in sides]
            lines.append(f"Beyond a hundredth, {word}: {listed(values)}.")
    parted = [each for each in outlooks if each.parted is not None]
    if outlooks and not parted:
        lines.append(f"Of {max(each.starts for each in outlooks)} perturbed starts on each engine all stay together.")
    if parted:
        when = listed([f"{titles.get(each.engine, each.engine)} {each.track} ({each.parted:.3g} s)" for each in parted])
        until = foreseeable_until(agreement, outlooks)
        if until is None:
            lines.append(
                f"Perturbed starts part on {when} and stay together on most engines: the motion can be foreseen, those answers "
                "cannot."
            )
            return lines
        lines.append(f"Perturbed starts part on {when}: beyond {until:.3g} s poses cannot be foreseen.")
        lines.append(
            f"Means over {max(each.starts for each in parted)} of them from {parted[0].since:.3g} s on: "
            + "; ".join(
                f"{titles.get(each.engine, each.engine)} {each.track} rms speed {_mean(each.speed)}, "
                f"height {_mean(each.height)}, spread {_mean(each.spread)}"
                for each in parted
            )
            + " (in sizes of what moves, and seconds)."
        )
    return lines


def _mean(mean: Any) -> str:
    return f"{mean.value:.3g} +- {mean.half:.2g}" if mean.half < float("inf") else f"{mean.value:.3g}"
