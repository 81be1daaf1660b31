"""What stands in for a plane in Bullet, and in which coordinates what may slide is put."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    Cylinder,
    PlacedShape,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Surface,
    Vector3,
    axis_angle,
    box_inertia,
    multiply,
    rotate,
)

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")
from tests.conformance.bullet_scenes import DEFAULT, GROUND, MAXIMAL, TUNED, G, ball, built, law, solid, state_of, with_options

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
CUBE = Box(half_extents=(0.1, 0.1, 0.1))
TILT = axis_angle((0.0, 1.0, 0.0), 0.3)


def plane(normal: Vector3 = (0.0, 0.0, 1.0), **named: Any) -> Body:
    return Body(
        name="ground", motion="static", material="ground", collision=(PlacedShape(shape=Plane(normal=normal)),), **named
    )


LAWS = (law(0.5), law(0.5, pair=("solid", "solid")))


def grounds(*bodies: Body) -> list[str]:
    """Of the parts of the ground that are made in a scene of these bodies, what meets each."""
    with built(Scene(bodies=(plane(), *bodies), surfaces=LAWS[: len(bodies)]), TUNED) as simulation:
        made: Any = simulation
        return ["faces" if faces else "round" for _, faces in made._made.grounds]


def lying(shape: Shape, place: Vector3 = (0.0, 0.0, 0.1), name: str = "body", **named: Any) -> Body:
    return solid(shape, name=name, p_WB=place, inertia=box_inertia(2.0, (0.1, 0.1, 0.1)), **named)


def test_what_has_faces_meets_a_box_and_what_is_round_the_plane() -> None:
    cube, sphere = lying(CUBE), lying(Sphere(radius=0.1), (1.0, 0.0, 0.1), "sphere")
    cylinder = lying(Cylinder(radius=0.1, half_length=0.1), (2.0, 0.0, 0.1), "cylinder")
    assert grounds(cube) == ["faces"]
    assert grounds(sphere) == grounds(cylinder) == ["round"]
    assert grounds(cube, sphere) == ["faces", "round"]
    feet = (PlacedShape(shape=CUBE), PlacedShape(shape=Sphere(radius=0.05), p_BS=(0.0, 0.0, -0.1)))
    assert grounds(replace(cube, collision=feet)) == ["faces"]


@pytest.mark.parametrize("settings", [DEFAULT, TUNED], ids=["default", "tuned"])
def test_of_a_plane_and_the_box_in_its_place_each_body_meets_one(settings: Any) -> None:
    """Both would bear it by points of their own: it would be counted twice."""
    bodies = (plane(), lying(CUBE), lying(Sphere(radius=0.1), (1.0, 0.0, 0.1), "sphere"))
    scene = Scene(bodies=bodies, surfaces=LAWS)
    with built(scene, settings) as simulation:
        simulation.step(240)
        contacts = simulation.contacts()
        state = state_of(simulation, scene)
    met = [*zip(contacts.body_A.tolist(), contacts.body_B.tolist(), strict=True)]
    assert sorted(met) == [(0, 1)] * 4 + [(0, 2)]
    assert state.p_WB[1:, 2] == pytest.approx([0.1, 0.1], abs=2e-5)


@pytest.mark.parametrize(
    "normal", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (-2 / 3, 1 / 3, -2 / 3)]
)
@pytest.mark.parametrize("q_WB", [UPRIGHT, multiply(TILT, axis_angle((1.0, 2.0, 0.5), 2.0))], ids=["upright", "turned"])
def test_the_box_lies_below_the_plane_whatever_way_it_faces(normal: Vector3, q_WB: Quaternion) -> None:
    up = np.array(rotate(q_WB, normal))
    ground = plane(normal, p_WB=(1.0, -2.0, 3.0), q_WB=q_WB)
    # The cube is let go a little way off, turned as it likes, and far along the plane.
    along = np.cross(up, np.eye(3)[int(np.abs(up).argmin())])
    start = np.array(ground.p_WB) + 0.2 * up + 300.0 * along / np.linalg.norm(along)
    body = lying(CUBE, tuple(start.tolist()))
    scene = Scene(bodies=(ground, body), surfaces=(law(0.9),), gravity=tuple((-G * up).tolist()))
    with built(scene, TUNED) as simulation:
        simulation.step(480)
        height = float((state_of(simulation, scene).p_WB[1] - ground.p_WB) @ up)
    # On a face, an edge or a corner, less ten contact slops.
    assert 0.1 - 1e-4 < height < 0.1 * math.sqrt(3)


def test_the_box_goes_on_beyond_all_that_moves_and_rays_see_the_plane() -> None:
    far = lying(CUBE, (5000.0, 0.0, 0.1), "far")
    scene = Scene(bodies=(plane(), lying(CUBE), far), surfaces=LAWS)
    with built(scene, TUNED) as simulation:
        simulation.step(240)
        assert state_of(simulation, scene).p_WB[1:, 2] == pytest.approx([0.1, 0.1], abs=2e-5)
        hits = simulation.cast(np.array([[1e5, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]]), 10.0)
    assert hits.body.tolist() == [0]
    assert hits.distance[0] == pytest.approx(1.0, abs=1e-9)


def test_what_stands_apart_from_the_ground_passes_both_of_its_parts() -> None:
    ghost = replace(lying(CUBE), material="ghost")
    scene = Scene(
        bodies=(plane(), ghost, lying(Sphere(radius=0.1), (1.0, 0.0, 0.1), "sphere")),
        surfaces=(law(0.5), law(0.5, pair=("ghost", "solid"))),
        apart=(("ghost", "ground"),),
    )
    with built(scene, TUNED) as simulation:
        simulation.step(120)
        heights = state_of(simulation, scene).p_WB[1:, 2]
    assert heights[0] < -1.0
    assert heights[1] == pytest.approx(0.1, abs=2e-5)


def coordinates(*bodies: Body, settings: Any = TUNED, surface: Surface | None = None) -> tuple[str, bool]:
    """In which coordinates bodies are put, and whether a cone bounds friction, as is told."""
    scene = Scene(bodies=bodies, surfaces=(surface or law(0.5),))
    with built(scene, settings) as simulation:
        options = simulation.resolved.options
    return options["coordinates"], options["cone_friction"]


REDUCED, FREE = ("multibody", True), ("maximal", False)


@pytest.mark.parametrize(
    ("bodies", "due"),
    [
        pytest.param((GROUND, lying(CUBE)), FREE, id="a cube that stands"),
        pytest.param((plane(), lying(CUBE)), FREE, id="on a plane"),
        pytest.param((GROUND, lying(CUBE, v_WB=(1.0, 0.0, 0.0))), REDUCED, id="that moves"),
        pytest.param((GROUND, lying(CUBE, w_WB=(0.0, 0.0, 1.0))), FREE, id="that turns"),
        pytest.param((replace(GROUND, q_WB=TILT), lying(CUBE, (0.0, 0.0, 0.5), q_WB=TILT)), REDUCED, id="on a slope"),
        pytest.param((plane((0.6, 0.0, 0.8)), lying(CUBE, (0.0, 0.0, 0.5))), REDUCED, id="on a sloping plane"),
        pytest.param((GROUND, lying(CUBE, (0.0, 0.0, 0.5), q_WB=TILT)), REDUCED, id="that stands on an edge"),
        pytest.param((GROUND, lying(CUBE, q_WB=axis_angle((0.0, 0.0, 1.0), 0.3))), FREE, id="turned about the vertical"),
        pytest.param((GROUND, lying(Sphere(radius=0.1))), FREE, id="a ball"),
        pytest.param((GROUND, lying(Capsule(radius=0.1, half_length=0.1), (0.0, 0.0, 0.2))), FREE, id="a capsule"),
        pytest.param((GROUND, lying(Cylinder(radius=0.1, half_length=0.1))), REDUCED, id="a cylinder"),
    ],
)
def test_what_may_slide_is_put_in_multibody_coordinates(bodies: tuple[Body, ...], due: tuple[str, bool]) -> None:
    assert coordinates(*bodies) == due
    assert coordinates(*bodies, settings=DEFAULT) == REDUCED
    assert coordinates(*bodies, settings=MAXIMAL) == FREE


OBLONG = Box(half_extents=(0.2, 0.1, 0.1))
ASKEW = multiply(axis_angle((0.0, 0.0, 1.0), 0.6), TILT)


@pytest.mark.parametrize(
    ("bodies", "due"),
    [
        pytest.param((GROUND, lying(CUBE, v_WB=(0.6, 0.8, 0.0))), REDUCED, id="a cube goes askew"),
        pytest.param((GROUND, lying(OBLONG, v_WB=(0.0, 0.8, 0.0))), REDUCED, id="an oblong box along an axis"),
        pytest.param((GROUND, lying(OBLONG, v_WB=(0.6, 0.8, 0.0))), FREE, id="an oblong box askew"),
        pytest.param((replace(GROUND, q_WB=ASKEW), lying(CUBE, (0.0, 0.0, 0.5), q_WB=ASKEW)), FREE, id="a slope askew"),
        pytest.param(
            (replace(GROUND, q_WB=ASKEW), lying(Sphere(radius=0.1), (0.0, 0.0, 0.5))), REDUCED, id="a ball on a slope askew"
        ),
    ],
)
def test_what_has_faces_is_put_in_them_only_where_bullet_slides_it_right(
    bodies: tuple[Body, ...], due: tuple[str, bool]
) -> None:
    assert coordinates(*bodies) == due


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 4, 1.2])
@pytest.mark.parametrize("shape", [CUBE, OBLONG], ids=["cube", "oblong"])
def test_a_box_slides_down_a_slope_right_whatever_way_this_faces(shape: Box, angle: float) -> None:
    lean = math.atan(1.15 * 0.5)
    turn = multiply(axis_angle((0.0, 0.0, 1.0), angle), axis_angle((0.0, 1.0, 0.0), lean))
    up, down = (np.array(rotate(turn, axis)) for axis in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
    slope = replace(GROUND, q_WB=turn, p_WB=tuple((-0.5 * up).tolist()))
    body = lying(shape, tuple((0.1 * up).tolist()), q_WB=turn)
    scene = Scene(bodies=(slope, replace(body, inertia=box_inertia(2.0, shape.half_extents))), surfaces=(law(0.5),))
    with built(scene, TUNED) as simulation:
        simulation.step(240)
        v = state_of(simulation, scene).v_WB[1]
    # A step may pass before it rubs: g sin(lean) dt of .64 m/s are 3 %, and Bullet's own contacts start at once.
    due = G * (math.sin(lean) - 0.5 * math.cos(lean))
    assert v == pytest.approx(due * down, abs=0.01 * due)


def test_what_rebounds_or_is_damped_is_not() -> None:
    moving = lying(CUBE, v_WB=(1.0, 0.0, 0.0))
    assert coordinates(GROUND, moving, surface=law(0.5, restitution=0.5)) == FREE
    assert coordinates(GROUND, replace(moving, linear_damping=0.5)) == FREE
    # Without friction neither of the two has anything to bound.
    assert coordinates(GROUND, moving, surface=law(0.0))[0] == "maximal"


def test_a_cone_bounds_what_is_dragged_by_a_belt_and_no_box_of_other_solvers() -> None:
    belt = replace(GROUND, motion="kinematic", v_WB=(math.cos(0.5), math.sin(0.5), 0.0))
    cube = lying(CUBE)
    assert coordinates(belt, cube) == ("both", True)
    assert coordinates(belt, cube, settings=MAXIMAL) == FREE
    assert coordinates(belt, cube, settings=replace(TUNED, solver="dantzig"))[1] is False
    assert coordinates(belt, cube, settings=with_options(TUNED, cone_friction=False))[1] is False
    scene = Scene(bodies=(belt, cube), surfaces=(law(0.3),))
    with built(scene, TUNED) as simulation:
        simulation.step(48)
        v = state_of(simulation, scene).v_WB[1]
        contacts = simulation.contacts()
    # Dragged along by mu g until it goes with the belt.
    assert v[:2] == pytest.approx([0.3 * G * 0.2 * c for c in belt.v_WB[:2]], rel=2e-3)
    along = (contacts.force_W * contacts.normal_W).sum(axis=1)
    rubbed = np.linalg.norm(contacts.force_W - along[:, None] * contacts.normal_W, axis=1)
    assert (rubbed <= 0.3 * np.abs(along) * (1 + 1e-9)).all()


def test_a_ball_slips_down_a_groove_as_coulomb_says() -> None:
    mu, lean, radius = 0.05, 0.3, 0.1
    faces = []
    for side in (1, -1):
        turn = axis_angle((1.0, 0.0, 0.0), side * math.pi / 4)
        below = rotate(turn, (0.0, 0.0, -0.2))
        faces.append(
            replace(
                GROUND,
                name=f"face_{side}",
                q_WB=turn,
                p_WB=below,
                collision=(PlacedShape(shape=Box(half_extents=(5.0, 1.0, 0.2))),),
            )
        )
    leaning = (G * math.sin(lean), 0.0, -G * math.cos(lean))
    scene = Scene(
        bodies=(*faces, ball(name="ball", p_WB=(0.0, 0.0, radius * math.sqrt(2)))), surfaces=(law(mu),), gravity=leaning
    )
    with built(scene, TUNED) as simulation:
        simulation.step(240)
        speed = state_of(simulation, scene).v_WB[2, 0]
    # The contact slop of 1e-5 m is passed in the first step.
    assert speed == pytest.approx(G * (math.sin(lean) - math.sqrt(2) * mu * math.cos(lean)), rel=1e-3)
