"""Mimics, closed loops and the like of two robots: which are in one alone, and whose numbers differ."""

from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene.parity.difference import Difference, Quantity, Value
from plumbline.harness.scene.parity.facts import Law

ALONE = "it binds coordinates that move freely without it; its effect is not worked out"


def paired(a: Sequence[Law], b: Sequence[Law]) -> list[tuple[Law | None, Law | None]]:
    """Laws that are each other's: of one kind and name, or, of loops, whose names formats make up, of the same two sides."""
    left, pairs = list(b), []
    waiting: list[Law] = []
    for law in a:
        other = next((candidate for candidate in left if (candidate.kind, candidate.name) == (law.kind, law.name)), None)
        if other is None:
            waiting.append(law)
            continue
        left.remove(other)
        pairs.append((law, other))
    matched: list[tuple[Law | None, Law | None]] = list(pairs)
    for law in waiting:
        sides = set(law.partners)
        other = next(
            (candidate for candidate in left if law.kind == candidate.kind == "closure" and set(candidate.partners) == sides),
            None,
        )
        if other is not None:
            left.remove(other)
        matched.append((law, other))
    return matched + [(None, law) for law in left]


def rows_of(a: Sequence[Law], b: Sequence[Law], slides: frozenset[str], extent: float, tolerance: float) -> list[Difference]:
    """What differs. Args: slides: the joints whose offset is a length. extent [m]: that lengths are held against."""
    rows = []
    for law_A, law_B in paired(a, b):
        law = law_A or law_B
        assert law is not None
        if law_A is None or law_B is None:
            there_A, there_B = ("present", "absent") if law_B is None else ("absent", "present")
            rows.append(_row("law", f"{law.kind} {law.name}", there_A, there_B, tolerance, words=ALONE))
        elif law.kind == "mimic":
            rows += _mimic(law_A, law_B, slides, extent, tolerance)
        elif law.kind == "closure":
            rows += _closure(law_A, law_B, extent, tolerance)
    return rows


def _row(quantity: Quantity, element: str, value_A: Value, value_B: Value, tolerance: float, unit: str = "",
         size: float | None = None, relative: float | None = None, words: str = "") -> Difference:  # fmt: skip
    return Difference(
        quantity=quantity, element=element, value_A=value_A, value_B=value_B, unit=unit, tolerance=tolerance,
        absolute=size, relative=relative, words=words,
    )  # fmt: skip


def _mimic(a: Law, b: Law, slides: frozenset[str], extent: float, tolerance: float) -> list[Difference]:
    element = f"mimic {a.name}"
    if a.ratio is None or b.ratio is None:  # one of the two does not tell its numbers
        return []
    if a.partners != b.partners:
        led_A, led_B = (f"follows {law.partners[0]}" for law in (a, b))
        return [_row("law", element, led_A, led_B, tolerance, words="it follows another joint")]
    ratio_A, ratio_B, offset_A, offset_B = (x or 0.0 for x in (a.ratio, b.ratio, a.offset, b.offset))
    own, led = ("m" if name in slides else "rad" for name in (a.name, a.partners[0]))
    rows = []
    size = abs(ratio_A - ratio_B)
    relative = size / max(abs(ratio_A), abs(ratio_B), 1e-300)
    if not relative <= tolerance:
        words = f"with the leader at 1 {led} it is {size:.4g} {own} elsewhere"
        rows.append(_row("ratio", element, ratio_A, ratio_B, tolerance, f"{own}/{led}", size, relative, words))
    size = abs(offset_A - offset_B)
    relative = size / (extent if own == "m" else 1.0)
    if not relative <= tolerance:
        words = f"it is {size:.4g} {own} elsewhere throughout"
        rows.append(_row("offset", element, offset_A, offset_B, tolerance, own, size, relative, words))
    return rows


def _closure(a: Law, b: Law, extent: float, tolerance: float) -> list[Difference]:
    element = f"closure {a.name}"
    if a.whole != b.whole:
        whole_A, whole_B = ("all held" if law.whole else "a point held" for law in (a, b))
        return [_row("law", element, whole_A, whole_B, tolerance, words="the loop holds more or less")]
    if a.points is None or b.points is None:
        return []
    if a.partners != b.partners and a.partners == b.partners[::-1]:
        b_points = b.points[::-1]
    elif a.partners == b.partners:
        b_points = b.points
    else:
        sides_A, sides_B = (" and ".join(name or "the world" for name in law.partners) for law in (a, b))
        return [_row("law", element, sides_A, sides_B, tolerance, words="the loop closes between other links")]
    gaps = [float(np.linalg.norm(np.subtract(p, q))) for p, q in zip(a.points, b_points, strict=True)]
    worst = int(np.argmax(gaps))
    size = gaps[worst]
    if size / extent <= tolerance:
        return []
    words = f"the loop closes {size:.4g} m elsewhere on what '{a.partners[worst] or 'the world'}' moves"
    return [_row("point", element, a.points[worst], b_points[worst], tolerance, "m", size, size / extent, words)]
