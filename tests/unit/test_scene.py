"""Scenes: what is refused at the door, and with which words."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Capsule,
    ConvexHull,
    Coupling,
    Cylinder,
    Distance,
    Drive,
    Effect,
    Fixed,
    Lidar,
    Limits,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    SceneError,
    Sphere,
    Surface,
    TriangleMesh,
    box_inertia,
    capsule_inertia,
    cylinder_inertia,
    principal_inertia,
    sphere_inertia,
)
from plumbline.harness.scene.file import dump_json, dump_toml, parse

ROUND = (PlacedShape(shape=Sphere(radius=0.1)),)
BALL = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), collision=ROUND, material="rubber")
GROUND = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),), material="floor")
LAW = Surface(between=("rubber", "floor"), static_friction=0.5, kinetic_friction=0.5)
TETRAHEDRON = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Sphere(radius=-1.0), "radius"),
        (lambda: Sphere(radius=math.nan), "radius"),
        (lambda: Sphere(radius=math.inf), "radius"),
        (lambda: Box(half_extents=(1.0, 0.0, 1.0)), "half_extents"),
        (lambda: Capsule(radius=0.1, half_length=-0.1), "half_length"),
        (lambda: Cylinder(radius=0.0, half_length=1.0), "radius"),
        (lambda: Plane(normal=(0.0, 0.0, 0.0)), "normal"),
        (lambda: ConvexHull(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0))), "span no volume"),
        (lambda: ConvexHull(vertices=TETRAHEDRON[:3]), "vertices"),
        (lambda: TriangleMesh(vertices=TETRAHEDRON, faces=((0, 1, 9),)), r"faces\[0\]"),
        (lambda: TriangleMesh(vertices=TETRAHEDRON, faces=((0, 1, 1),)), "no area"),
        (lambda: Body(name="b", mass=-1.0), "mass"),
        (lambda: Body(name="b", mass=0.0), "mass"),
        (lambda: Body(name="b", mass=math.nan), "mass"),
        (lambda: Body(name="b", inertia=principal_inertia(1, 1, 5)), "body 'b'.*triangle inequality"),
        (lambda: Body(name="b", inertia=principal_inertia(1, -1, 1)), "body 'b'.*not positive"),
        (
            lambda: Body(name="b", inertia=principal_inertia(0, 0, 0), collision=(PlacedShape(shape=Sphere(radius=0.1)),)),
            "body 'b': inertia is zero, and it has shapes that touch; a mass point has none",
        ),
        (lambda: Body(name="b", inertia=((1, 0.5, 0), (0, 1, 0), (0, 0, 1))), "body 'b'.*not symmetric"),
        (lambda: Body(name="b", q_WB=(0.0, 0.0, 0.0, 0.0)), "q_WB"),
        (lambda: Body(name="b", v_WB=(math.nan, 0.0, 0.0)), "v_WB"),
        (lambda: Body(name=" b"), "name"),
        (lambda: Body(name="b\x1b[31m"), "name"),
        (lambda: Body(name="b", linear_damping=-0.1), "linear_damping"),
        (lambda: Body(name="b", motion="static", v_WB=(1.0, 0.0, 0.0)), "static body moves"),
        (lambda: Body(name="b", collision=(PlacedShape(shape=Plane()),)), "plane has no bounds"),
        (lambda: Surface(static_friction=-0.1), "static_friction"),
        (lambda: Surface(static_friction=0.1, kinetic_friction=0.2), "below kinetic_friction"),
        (lambda: Surface(restitution=1.1), "restitution"),
        (lambda: Revolute(name="j", parent="world", child="b", anchor_W=(0, 0, 0), axis_W=(0, 0, 0)), "axis_W"),
        (lambda: Limits(lower=1.0, upper=0.0), "lower 1.0 lies above upper 0.0"),
        (lambda: Drive(limit=0.0), "limit"),
        (lambda: Distance(name="j", parent="world", child="b", anchor_W=(0, 0, 0), child_anchor_W=(0, 0, 0)), "joint 'j'"),
        (lambda: Lidar(name="l", body="b", rate=10.0, min_range=5.0, max_range=1.0), "sensor 'l'"),
        (lambda: Lidar(name="l", body="b", rate=-10.0), "rate"),
        (lambda: Scene(bodies=()), "bodies is empty"),
        (lambda: Scene(bodies=(BALL, BALL), surfaces=()), "body 'ball': name stands 2 times"),
        (lambda: Scene(bodies=(BALL, GROUND)), "surface floor/rubber: missing"),
        (lambda: Scene(bodies=(BALL,), joints=(Fixed(name="j", parent="world", child="x"),)), "joint 'j': child 'x'"),
        (lambda: Scene(bodies=(BALL,), joints=(Fixed(name="j", parent="ball", child="ball"),)), "parent and child"),
        (lambda: Scene(bodies=(GROUND,), joints=(Fixed(name="j", parent="world", child="ground"),)), "can move"),
        (lambda: Scene(bodies=(BALL,), sensors=(Lidar(name="l", body="x", rate=1.0),)), "sensor 'l': body 'x'"),
        (lambda: Scene(bodies=(Body(name="world"),)), "taken by the world frame"),
        (lambda: Scene(bodies=(BALL,), gravity=(0.0, 0.0, math.inf)), "gravity"),
    ],
)
def test_a_bad_value_is_refused_by_name(make: Callable[[], object], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        make()


def test_effects_are_read_off_the_content() -> None:
    assert Scene(bodies=(BALL,)).effects == Effect.GRAVITY
    assert Scene(bodies=(BALL,), gravity=(0, 0, 0)).effects == Effect.NONE
    touching = Scene(bodies=(BALL, GROUND), surfaces=(LAW,))
    assert touching.effects == Effect.GRAVITY | Effect.CONTACT | Effect.FRICTION
    bouncy = Surface(between=("rubber", "floor"), restitution=0.5)
    assert Scene(bodies=(BALL, GROUND), surfaces=(bouncy,)).effects == Effect.GRAVITY | Effect.CONTACT | Effect.RESTITUTION


def test_the_gyroscopic_effect_is_called_for_by_an_unequal_inertia_that_turns() -> None:
    top = Body(name="top", inertia=principal_inertia(1, 2, 2.5), w_WB=(0, 0, 1))
    still = Body(name="still", inertia=principal_inertia(1, 2, 2.5))
    assert Effect.GYROSCOPIC in Scene(bodies=(top,)).effects
    assert Effect.GYROSCOPIC not in Scene(bodies=(still,)).effects


def test_effects_can_be_widened_and_narrowed() -> None:
    scene = Scene(bodies=(BALL,), widen=Effect.CONTINUOUS_COLLISION, narrow=Effect.GRAVITY)
    assert scene.effects == Effect.CONTINUOUS_COLLISION


def test_a_surface_is_found_whatever_the_order_of_its_bodies() -> None:
    scene = Scene(bodies=(BALL, GROUND), surfaces=(LAW,))
    assert scene.surface(BALL, GROUND) is scene.surface(GROUND, BALL)


def test_joined_bodies_do_not_collide_unless_told_so() -> None:
    other = Body(name="other", collision=BALL.collision, material="rubber")
    own = Surface(between=("rubber", "rubber"))
    joint = Fixed(name="j", parent="ball", child="other")
    assert not Scene(bodies=(BALL, other), surfaces=(own,), joints=(joint,)).collides(BALL, other)
    assert Scene(bodies=(BALL, other), surfaces=(own,)).collides(BALL, other)


def test_inertias_of_solids_agree_with_a_monte_carlo_integral() -> None:
    """The standard error of a mean over n points is below 1/sqrt(n) of the moment; five of them are allowed."""
    import numpy as np

    number = 400_000
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (number, 3)) * (0.3, 0.3, 0.8)
    x, y, z = points.T
    across = np.hypot(x, y)
    inside = {
        "sphere": (np.linalg.norm(points, axis=1) < 0.3, sphere_inertia(2.0, 0.3)),
        "box": (np.ones(number, bool), box_inertia(2.0, (0.3, 0.3, 0.8))),
        "cylinder": (across < 0.3, cylinder_inertia(2.0, 0.3, 0.8)),
        "capsule": (np.hypot(across, np.maximum(np.abs(z) - 0.5, 0.0)) < 0.3, capsule_inertia(2.0, 0.3, 0.5)),
    }
    for mask, tensor in inside.values():
        px, py, pz = points[mask].T
        moments = 2.0 * np.array([np.mean(py**2 + pz**2), np.mean(px**2 + pz**2), np.mean(px**2 + py**2)])
        assert np.allclose(moments, np.diag(tensor), rtol=5.0 / math.sqrt(mask.sum()))


def _tied(**change: object) -> Scene:
    bodies = tuple(Body(name=name, p_WB=(0.0, y, 0.0)) for name, y in (("a", 0.0), ("b", 3.0)))
    first, second = (
        Revolute(name=b.name, parent=WORLD, child=b.name, anchor_W=b.p_WB, axis_W=(0.0, 0.0, 1.0), position=x)
        for b, x in zip(bodies, (0.7, 0.1), strict=True)
    )
    fields = {"coupling": Coupling(joint="b", ratio=2.0, offset=0.5)} | change
    return Scene(bodies=bodies, joints=(replace(first, **fields), second))  # type: ignore[arg-type]


def test_a_coupling_names_another_joint_with_a_coordinate_and_agrees_with_the_start() -> None:
    scene = _tied(armature=0.1, friction_loss=0.2)
    assert parse(dump_toml(scene), "x.toml") == scene
    for change, said in (
        ({"coupling": Coupling(joint="c", ratio=1.0)}, "coupling to 'c', which is no joint with one coordinate"),
        ({"coupling": Coupling(joint="a", ratio=1.0)}, "couplings lead from 'a' back to it"),
        ({"position": 0.8}, "position 0.8, expected 0.7 by its coupling to 'b'"),
    ):
        with pytest.raises(ValueError, match=said):
            _tied(**change)
    with pytest.raises(ValueError, match="ratio is 0"):
        Coupling(joint="b", ratio=0.0)


def test_a_scene_without_rotors_dry_friction_and_couplings_is_written_as_before_they_were_words() -> None:
    """The text is what a question's digest is made of: what is not there must not stand in it."""
    text = dump_json(_tied(coupling=None))
    assert not any(word in text for word in ("armature", "friction_loss", "coupling"))
