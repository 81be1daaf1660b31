"""What departs from a scene: effects off, on and faintly there, damping; and the way there and back through a record."""

import json

import pytest

from plumbline.harness.case.alteration import AS_IT_IS, EVERYTHING, FAINT, Alteration, departures
from plumbline.harness.scene import Body, Box, Effect, PlacedShape, Plane, Scene, Surface, box_inertia


def scene(**more: object) -> Scene:
    half = (0.1, 0.2, 0.3)
    box = Body(
        name="box",
        mass=1.0,
        inertia=box_inertia(1.0, half),
        collision=(PlacedShape(shape=Box(half_extents=half)),),
        p_WB=(0, 0, 0.3),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    law = Surface(static_friction=0.5, kinetic_friction=0.5)
    return Scene(bodies=(ground, box), surfaces=(law,), **more)  # type: ignore[arg-type]


def test_no_departure_leaves_the_very_same_scene() -> None:
    plain = scene()
    assert AS_IT_IS.of(plain) is plain
    assert Alteration(name="first", every_step=True).of(plain) is plain
    assert Alteration(name="other libraries", variables=(("A", "1"),)).of(plain) is plain


def test_an_effect_is_left_out_whatever_the_scene_says_of_it() -> None:
    plain = scene(widen=Effect.CONTINUOUS_COLLISION)
    assert Effect.CONTINUOUS_COLLISION in plain.effects
    for one in (Effect.FRICTION, Effect.CONTINUOUS_COLLISION):
        left = Alteration(name="x", narrow=one).of(plain)
        assert left.effects == plain.effects & ~one


def test_an_effect_that_the_scene_leaves_off_is_taken_in() -> None:
    plain = scene(narrow=Effect.FRICTION)
    assert Effect.FRICTION not in plain.effects
    assert Alteration(name="x", widen=Effect.FRICTION).of(plain).effects == plain.effects | Effect.FRICTION


def test_what_is_faintly_there_is_on_and_changes_no_value_that_was() -> None:
    told = Alteration(name="x", present=Effect.RESTITUTION | Effect.LINEAR_DAMPING | Effect.FRICTION).of(scene())
    assert {Effect.RESTITUTION, Effect.LINEAR_DAMPING} <= set(told.effects)
    assert told.surfaces[0].restitution == FAINT
    assert told.surfaces[0].static_friction == 0.5
    assert told.body("box").linear_damping == FAINT
    assert told.body("ground").linear_damping == 0.0


def test_departures_are_everything_each_without_and_what_is_left_off() -> None:
    names = [
        one.name for one in departures(scene(narrow=Effect.GYROSCOPIC), ("continuous_collision", "linear_damping", "sphere"))
    ]
    assert names == [
        EVERYTHING,
        "without gravity",
        "without contact",
        "without friction",
        "with continuous_collision",
        "with gyroscopic",
    ]
    everything = next(departures(scene(), ("linear_damping", "rolling_friction")))
    assert everything.present == Effect.ROLLING_FRICTION
    free = Scene(bodies=(Body(name="ball"),), gravity=(0.0, 0.0, 0.0))
    everything = next(departures(free, ("linear_damping", "rolling_friction")))
    assert everything.present == Effect.LINEAR_DAMPING | Effect.GRAVITY | Effect.FRICTION | Effect.GYROSCOPIC


@pytest.mark.parametrize(
    "one",
    [
        AS_IT_IS,
        Alteration(name="a", widen=Effect.GRAVITY | Effect.CONTACT, narrow=Effect.FRICTION),
        Alteration(name="b", linear_damping=1.5, every_step=True, told="nudged"),
        Alteration(name="c", undropped=("spring",), variables=(("A", "1"), ("B", "x y"))),
    ],
)
def test_a_departure_comes_back_from_its_record(one: Alteration) -> None:
    assert Alteration.from_plain(json.loads(json.dumps(one.plain()))) == one
