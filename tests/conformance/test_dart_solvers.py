"""Which of DART's solvers 'auto' takes: by how bodies start beside each other, whatever a scene is called."""

from dataclasses import replace

import pytest

from plumbline.harness.case import Case
from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Scene, Sphere, axis_angle

pytest.importorskip("dartpy", reason="DART is not installed")

from plumbline.adapters.dart import ADAPTER
from plumbline.adapters.dart.arrangement import Arrangement
from plumbline.cases import (
    friction_creep,
    friction_threshold,
    friction_wall_pinch,
    rest_jitter,
    stack_arch,
    stack_card_house,
    stack_heavy_on_two,
    stack_overhang,
    stack_overlap_recovery,
    stack_pile,
    stack_pyramid,
    stack_stirred,
    stack_tower,
    stand_quadruped,
    system_scaling,
)
from tests.conformance.dart_scenes import CUBE, TUNED, box_body, ground_body, solid_body, surface_law, with_options
from tests.conformance.put import put

DT = 1 / 240


@pytest.mark.parametrize(
    ("case", "parameters", "solver", "detector"),
    [
        (friction_threshold.CASE, {}, "nsgs", "ode"),
        (stack_arch.CASE, {}, "nsgs", "bullet"),
        (stack_arch.CASE, {"friction": 0.5, "blocks": 11}, "nsgs", "bullet"),
        (stack_arch.CASE, {"blocks": 18}, "matrix_free", "bullet"),
        (stack_card_house.CASE, {"margin": 0.5}, "nsgs", "ode"),
        (stack_tower.CASE, {}, "dantzig", "ode"),
        (stack_tower.CASE, {"n": 20}, "dantzig", "ode"),
        (stack_heavy_on_two.CASE, {}, "dantzig", "ode"),
        (stack_overhang.CASE, {}, "dantzig", "ode"),
        (stack_overlap_recovery.CASE, {}, "dantzig", "ode"),
        (stack_pyramid.CASE, {}, "dantzig", "ode"),
        (rest_jitter.CASE, {}, "dantzig", "ode"),
        (stack_pile.CASE, {"n": 4}, "nsgs", "ode"),
        (stack_pile.CASE, {"n": 5}, "matrix_free", "dart"),
        (stack_pile.CASE, {"n": 100}, "matrix_free", "dart"),
        (stack_stirred.CASE, {}, "matrix_free", "ode"),
        (system_scaling.CASE, {"n": 8}, "dantzig", "ode"),
        (system_scaling.CASE, {"n": 64}, "matrix_free", "dart"),
        (stand_quadruped.CASE, {}, "dantzig", "ode"),
    ],
    ids=lambda value: value.name if isinstance(value, Case) else str(value),
)
def test_a_scene_has_the_solver_of_its_arrangement(
    case: Case, parameters: dict[str, float], solver: str, detector: str
) -> None:
    scene = case.scene(case.at(**parameters))
    resolved = ADAPTER.build(scene, TUNED.with_dt(DT)).resolved
    assert (resolved.solver, resolved.options["detector"]) == (solver, detector)
    assert resolved.iterations == {"nsgs": 100, "matrix_free": 200, "dantzig": None}[solver]


@pytest.mark.parametrize(
    ("push", "dt", "tolerance"),
    [
        (1.0, DT, 1e-5),
        (1.6, DT, 1e-5),
        (2.0, DT, 1e-6),
        (4.0, DT, 1e-6),
        (2.0, DT / 2, 1e-5),
        (4.0, DT / 2, 1e-6),
        (1.0, 4 * DT, 1e-6),
    ],
)
def test_the_cone_is_solved_to_more_digits_where_a_step_of_gravity_is_fast(push: float, dt: float, tolerance: float) -> None:
    scene = friction_wall_pinch.CASE.scene(friction_wall_pinch.CASE.at(push=push))
    assert ADAPTER.build(scene, TUNED.with_dt(dt)).resolved.tolerance == tolerance
    # By sub-steps, which are what DART takes.
    assert ADAPTER.build(scene, replace(TUNED.with_dt(2 * dt), substeps=2)).resolved.tolerance == tolerance


def test_a_box_on_an_incline_is_held_at_coarse_steps() -> None:
    """At a sixtieth of a second it creeps by half a millimetre a second where the cone is solved to the vendor's 1e-5."""
    answer = put(friction_creep.CASE, ADAPTER, TUNED.with_dt(1 / 60))
    assert not answer.broken


def test_an_arch_of_enough_friction_stands_where_dantzig_lets_it_fall() -> None:
    """Nine voussoirs a fifth of a radius thick need less than .4."""
    case = replace(stack_arch.CASE, duration=1.25, checks=())
    tuned, dantzig = (
        put(case, ADAPTER, settings.with_dt(DT), parameters={"friction": 0.5})["stack_height_error"]
        for settings in (TUNED, replace(TUNED, solver="dantzig"))
    )
    # Of its height, which is a radius: a block that is down has lost most of it.
    assert tuned < 0.01
    assert dantzig > 0.3


def test_a_house_of_cards_of_little_more_friction_than_it_needs_stands() -> None:
    answer = put(stack_card_house.CASE, ADAPTER, TUNED.with_dt(DT))
    assert not answer.broken


def _two(lower: float, upper: float, turn: float, **more: object) -> Scene:
    """Two cubes of 0.2 m at these heights [m], the upper turned about x by `turn` [rad]."""
    cubes = (box_body("a", (0.0, 0.0, lower)), box_body("b", (0.0, 0.0, upper), q_WB=axis_angle((1.0, 0.0, 0.0), turn), **more))
    return Scene(bodies=(ground_body(), *cubes), surfaces=(surface_law(), surface_law(between=("b", "b"))))


@pytest.mark.parametrize(
    ("scene", "stacked", "touching"),
    [
        (_two(0.1, 0.3, 0.0), True, True),
        (_two(0.1, 0.25, 0.0), True, True),
        (_two(0.1, 0.301, 0.0), False, False),
        (_two(0.1, 0.3, 0.0, v_WB=(1.0, 0.0, 0.0)), False, True),
        (_two(0.1, 0.2 + 0.1 * 2**0.5, 0.7853981633974483), False, True),
        (_two(0.1, 0.201 + 0.1 * 2**0.5, 0.7853981633974483), False, False),
    ],
    ids=["on each other", "sunk in", "a gap", "moving", "on an edge", "above on an edge"],
)
def test_stacks_and_touching_bodies_are_seen(scene: Scene, stacked: bool, touching: bool) -> None:
    start = Arrangement(scene)
    assert (start.stacked, start.touching) == (stacked, touching)


def test_shapes_of_all_kinds_are_seen_to_touch_and_not_to() -> None:
    for shape in (
        Sphere(radius=0.1),
        Box(half_extents=(0.1, 0.1, 0.1)),
        Capsule(radius=0.1, half_length=0.1),
        Cylinder(radius=0.1, half_length=0.1),
        ConvexHull(vertices=CUBE),
    ):
        for gap, touching in ((0.0, True), (1e-3, False)):
            bodies = (solid_body("a", shape, (0.0, 0.0, 0.0)), solid_body("b", Sphere(radius=0.1), (0.2 + gap, 0.0, 0.0)))
            assert Arrangement(Scene(bodies=bodies, surfaces=(surface_law(between=("b", "b")),))).touching is touching


def test_bodies_apart_by_their_materials_are_not_near_each_other() -> None:
    boxes = tuple(box_body(f"x{k}", (0.0, 0.2 * k, 0.1)) for k in range(3))
    together = Scene(bodies=(ground_body(), *boxes), surfaces=(surface_law(), surface_law(between=("b", "b"))))
    apart = replace(together, surfaces=(surface_law(),), apart=(("b", "b"),))
    assert Arrangement(together).near
    assert not Arrangement(apart).near
    assert ADAPTER.build(apart, with_options(DT)).resolved.solver == "nsgs"
