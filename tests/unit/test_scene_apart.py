"""Which bodies of a scene can touch: motions, shapes, joints and materials that are apart."""

import pytest

from plumbline.harness.scene import Ball, Body, Effect, PlacedShape, Plane, Scene, Sphere, Surface
from plumbline.harness.scene.file import dump_toml, parse

BALL = (PlacedShape(shape=Sphere(radius=0.1)),)


def ball(name: str, material: str, **more: object) -> Body:
    return Body(name=name, material=material, collision=BALL, **more)  # type: ignore[arg-type]


GROUND = Body(name="ground", motion="static", material="stone", collision=(PlacedShape(shape=Plane()),))
A, B, C = ball("a", "x"), ball("b", "y"), ball("c", "y")
LAWS = (Surface(between=("x", "stone")), Surface(between=("y", "stone")))
SCENE = Scene(bodies=(GROUND, A, B, C), surfaces=LAWS, apart=(("y", "x"), ("y", "y")))


def test_materials_that_are_apart_need_no_surface_and_never_collide_in_either_order() -> None:
    assert not SCENE.collides(A, B)
    assert not SCENE.collides(B, A)
    assert not SCENE.collides(B, C)
    assert SCENE.collides(GROUND, A)
    assert SCENE.collides(C, GROUND)


def test_without_apart_the_missing_surface_is_refused() -> None:
    with pytest.raises(ValueError, match="surface x/y: missing"):
        Scene(bodies=(GROUND, A, B, C), surfaces=LAWS, apart=(("y", "y"),))
    with pytest.raises(ValueError, match="surface y/y: missing"):
        Scene(bodies=(GROUND, A, B, C), surfaces=LAWS, apart=(("x", "y"),))


def test_a_law_between_materials_that_are_apart_is_refused() -> None:
    with pytest.raises(ValueError, match="these materials are apart"):
        Scene(bodies=(GROUND, A, B), surfaces=(*LAWS, Surface(between=("x", "y"))), apart=(("x", "y"),))


def test_an_unknown_material_in_apart_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no body is of material 'z'"):
        Scene(bodies=(GROUND, A), surfaces=LAWS[:1], apart=(("x", "z"),))


def test_materials_that_are_apart_from_all_others_call_for_no_contact() -> None:
    scene = Scene(bodies=(GROUND, A), apart=(("x", "stone"),))
    assert Effect.CONTACT not in scene.effects
    assert Effect.CONTACT in SCENE.effects


def test_fixed_pairs_joined_pairs_shapeless_bodies_and_a_body_itself_do_not_collide() -> None:
    wall = ball("wall", "x", motion="static")
    belt = ball("belt", "x", motion="kinematic")
    ghost = Body(name="ghost", material="x")
    d = ball("d", "x")
    law = (Surface(between=("x", "x")),)
    held = Ball(name="hinge", parent="a", child="d", anchor_W=(0.0, 0.0, 0.0))
    scene = Scene(bodies=(A, d, wall, belt, ghost), surfaces=law, joints=(held,))
    assert not scene.collides(wall, belt)
    assert not scene.collides(A, ghost)
    assert not scene.collides(A, A)
    assert not scene.collides(A, d)
    assert scene.collides(A, wall)
    assert scene.collides(belt, d)


def test_a_scene_file_keeps_what_is_apart() -> None:
    assert parse(dump_toml(SCENE), "scene.toml") == SCENE
