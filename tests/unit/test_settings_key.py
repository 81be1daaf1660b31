"""What tells the settings of one trial from those of another: every field that decides an answer, and no other."""

from dataclasses import fields, replace
from typing import Any

import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.study.one_knob import OPTION, key_of

PLAIN = Settings(dt=1 / 240, options={"cone": "elliptic", "warm_start": True})
OTHER: dict[str, Any] = {
    "dt": 1 / 120,
    "substeps": 2,
    "iterations": 50,
    "integrator": "rk4",
    "solver": "newton",
    "tolerance": 1e-8,
    "options": {"cone": "pyramidal", "warm_start": True},
    "pace": "loaded",
}


def test_every_field_but_the_source_has_another_value_here() -> None:
    assert OTHER.keys() == {one.name for one in fields(Settings)} - {"source"}


@pytest.mark.parametrize("name", OTHER)
def test_another_value_of_a_field_is_another_key_until_the_field_is_left_out(name: str) -> None:
    other = replace(PLAIN, **{name: OTHER[name]})
    assert key_of(other) != key_of(PLAIN)
    left = f"{OPTION}cone" if name == "options" else name
    assert key_of(other, left) == key_of(PLAIN, left)
    assert all(key_of(other, knob) != key_of(PLAIN, knob) for knob in (*OTHER, f"{OPTION}warm_start") if knob != left)


def test_who_recommends_settings_and_the_order_of_their_options_make_no_other_key() -> None:
    assert key_of(replace(PLAIN, source="a manual", options={"warm_start": True, "cone": "elliptic"})) == key_of(PLAIN)


def test_an_option_that_is_given_differs_from_one_that_is_left_and_from_another_kind_of_value() -> None:
    keys = [key_of(Settings(options=options)) for options in ({}, {"slop": None}, {"slop": 1}, {"slop": True}, {"slop": 1.0})]
    assert len(set(keys)) == len(keys)
    assert key_of(Settings(options={"solref": (0.02, 1.0)})) == key_of(Settings(options={"solref": [0.02, 1.0]}))
