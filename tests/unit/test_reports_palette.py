"""Engines are told apart by colour and by shape, in the light and in the dark."""

import pytest

from plumbline.reports.charts.marks import BACKGROUNDS, ENGINES, SPARE, looks


def luminance(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def contrast(one: str, other: str) -> float:
    """Contrast ratio (WCAG 2.2)."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("background", BACKGROUNDS.values(), ids=BACKGROUNDS.keys())
@pytest.mark.parametrize("colour", [look.colour for look in (*ENGINES.values(), *SPARE)])
def test_every_colour_stands_out_from_the_page(colour: str, background: str) -> None:
    assert contrast(colour, background) >= 3.0  # WCAG 2.2, 1.4.11: graphical objects


def test_no_two_engines_share_a_colour_or_a_shape() -> None:
    assert len({look.colour for look in (*ENGINES.values(), *SPARE)}) == len(ENGINES) + len(SPARE)
    assert len({look.path for look in ENGINES.values()}) == len(ENGINES)


def test_an_engine_looks_the_same_whoever_runs_beside_it() -> None:
    assert looks(["mujoco", "zebra"])["mujoco"] == looks(["bullet", "mujoco"])["mujoco"]
    assert looks(["zebra", "ant"]) == dict(looks(["ant", "zebra"]))


def test_engines_of_third_parties_get_looks_of_their_own() -> None:
    given = looks([*ENGINES, "ant", "bee", "cat", "dog"])
    assert len({(look.colour, look.path) for look in given.values()}) == len(given)
