"""The reference engine behind the adapter: which solver and continuous collision a setting calls for, and what is said."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.adapters.reference import ADAPTER, choose_solver
from plumbline.harness.adapter import Settings, SettingsError, Simulation, Unsupported
from plumbline.harness.scene import WORLD, Ball, Body, Box, Effect, PlacedShape, Plane, Prismatic, Scene, Sphere, Surface
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import scene_at
from plumbline.harness.trajectory import State
from tests.conformance.put import put

TUNED = ADAPTER.tracks["tuned"]
SHOT = Body(name="shot", collision=(PlacedShape(shape=Sphere(radius=0.05)),), p_WB=(-0.6, 0.0, 0.1501), v_WB=(90.0, 0.0, 0.0))
BLOCK = Body(name="block", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.1, 0.1, 0.1))),))
LAW = Surface(between=("default", "default"))
PASS = Scene(bodies=(BLOCK, SHOT), surfaces=(LAW,), gravity=(0.0, 0.0, 0.0), widen=Effect.CONTINUOUS_COLLISION)
"""A ball that passes a block at a tenth of a millimetre."""


def _end(simulation: Simulation, scene: Scene, steps: int) -> State:
    simulation.step(steps)
    state = State.initial(scene)
    simulation.state(state)
    return state


@pytest.mark.parametrize(("asked", "got"), [({}, "speculative"), ({"continuous": "swept"}, "swept")])
def test_continuous_collision_is_speculative_unless_the_sweep_is_asked_for(asked: dict[str, Any], got: str) -> None:
    """The ghost contact of the speculative way turns the ball aside by metres a second; the sweep leaves its velocity alone."""
    simulation = ADAPTER.build(PASS, replace(TUNED, options=asked))
    assert simulation.resolved.options["continuous"] == got
    aside = _end(simulation, PASS, 6).v_WB[1] - (90.0, 0.0, 0.0)
    assert (abs(aside).max() > 1.0) == (got == "speculative")
    assert simulation.warnings() == ()


def test_a_scene_without_the_effect_has_no_sweep_whatever_the_option() -> None:
    scene = replace(PASS, widen=Effect.NONE)
    simulation = ADAPTER.build(scene, replace(TUNED, options={"continuous": "swept"}))
    assert "continuous" not in simulation.resolved.options
    assert ADAPTER.build(scene, simulation.resolved).resolved == simulation.resolved


def test_the_sweep_refuses_joints_by_name() -> None:
    tie = Prismatic(name="tie", parent=WORLD, child="shot", anchor_W=(-0.6, 0.0, 1.0), axis_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="swept collision with joints"):
        ADAPTER.build(replace(PASS, joints=(tie,)), replace(TUNED, options={"continuous": "swept"}))
    ADAPTER.build(replace(PASS, joints=(tie,)), TUNED)


def test_sequential_impulses_are_a_solver_of_their_own() -> None:
    """A cube comes to rest on the ground; substeps and iterations are filled in, and springs have no place."""
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    ball = Body(name="ball", collision=(PlacedShape(shape=Sphere(radius=0.1)),), p_WB=(0.0, 0.0, 0.11))
    scene = Scene(bodies=(ground, ball), surfaces=(LAW,))
    simulation = ADAPTER.build(scene, Settings(solver="sequential_impulses"))
    used = simulation.resolved
    assert (used.solver, used.substeps, used.iterations) == ("sequential_impulses", 1, 10)
    assert not {"contact_hertz", "relaxations"} & used.options.keys()
    assert ADAPTER.build(scene, used).resolved == used
    end = _end(simulation, scene, 120)
    assert math.isclose(end.p_WB[1, 2], 0.1, abs_tol=1e-4)
    for wrong in (
        Settings(solver="sequential_impulses", options={"contact_hertz": 60.0}),
        Settings(solver="sequential_impulses", tolerance=1e-6),
        Settings(options={"continuous": "always"}),
    ):
        with pytest.raises(SettingsError):
            ADAPTER.build(scene, wrong)


GROUND = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
CUBE = (PlacedShape(shape=Box(half_extents=(0.1, 0.1, 0.1))),)
RUBS = Surface(static_friction=0.5, kinetic_friction=0.5)
SPLIT = "sequential_impulses"


def _pair(ratio: float = 1.0, overlap: float = 0.0, **changes: Any) -> Scene:
    """A cube of `ratio` kg on one of 1 kg, `overlap` [m] inside of it."""
    upper = Body(name="upper", mass=ratio, collision=CUBE, p_WB=(0.0, 0.0, 0.3 - overlap))
    lower = Body(name="lower", collision=CUBE, p_WB=(0.0, 0.0, 0.1))
    return replace(Scene(bodies=(GROUND, lower, upper), surfaces=(RUBS,)), **changes)


def _many(ratio: float) -> Scene:
    row = [Body(name=f"b{i}", mass=1.0 if i else ratio, collision=CUBE, p_WB=(0.3 * i, 0.0, 0.1)) for i in range(17)]
    return Scene(bodies=(GROUND, *row), surfaces=(RUBS,))


STICKS = Surface(static_friction=0.6, kinetic_friction=0.5)
TIE = Ball(name="tie", parent=WORLD, child="upper", anchor_W=(0.0, 0.0, 1.0))
UNLIKE = {
    "at the limit of eight sub-steps": (_pair(64.0), "tgs_soft"),
    "above it": (_pair(65.0), "exact"),
    "heavy below light": (_pair(1 / 65), "exact"),
    "without weight": (_pair(65.0, gravity=(0.0, 0.0, 0.0)), "tgs_soft"),
    "that never touch": (_pair(65.0, apart=(("default", "default"),), surfaces=(), bodies=_pair(65.0).bodies[1:]), "tgs_soft"),
    "with a law that the exact solver lacks": (_pair(65.0, surfaces=(STICKS,)), "tgs_soft"),
    "with joints": (_pair(65.0, joints=(TIE,)), "tgs_soft"),
    "of many bodies": (_many(65.0), "tgs_soft"),
}


@pytest.mark.parametrize("scene", UNLIKE)
def test_tuned_contacts_are_exact_where_few_bodies_of_unlike_masses_have_weight(scene: str) -> None:
    stage, solver = UNLIKE[scene]
    used = ADAPTER.build(stage, TUNED).resolved
    assert used.solver == solver
    substeps = 1 if solver == "exact" or scene == "that never touch" else 8  # without contacts RK4 takes a step whole
    assert (used.substeps, used.iterations) == (substeps, None if solver == "exact" else 2)
    assert ADAPTER.build(stage, used).resolved == used


def test_pairs_of_many_bodies_are_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """There are half a million among a thousand bodies, and exact contacts are for few."""
    for name in ("mass_ratio", "heap_gives_way"):
        monkeypatch.setattr(choose_solver, name, lambda *_: pytest.fail("looked at pairs"))
    assert ADAPTER.build(_many(65.0), TUNED).resolved.solver == "tgs_soft"


def test_the_sub_steps_that_are_told_are_those_that_are_taken() -> None:
    """Runge-Kutta takes dt whole where nothing can touch; whatever was asked for, the answer is the same there."""
    top = scene_at(plugins.case("spin_heavy_top"), {})
    assert ADAPTER.build(top, TUNED).resolved.substeps == 1
    assert ADAPTER.build(top, ADAPTER.tracks["default"]).resolved.substeps == 4
    ends = [_end(ADAPTER.build(top, replace(TUNED, substeps=parts)), top, 60) for parts in (1, 8)]
    assert np.array_equal(ends[0].q_WB, ends[1].q_WB)
    assert ADAPTER.build(_pair(), TUNED).resolved.substeps == 8


def _tower(n: int) -> Scene:
    boxes = [Body(name=f"b{i}", collision=CUBE, p_WB=(0.0, 0.0, 0.1 + 0.2 * i)) for i in range(n)]
    return Scene(bodies=(GROUND, *boxes), surfaces=(RUBS,))


@pytest.mark.parametrize(("n", "rate", "solver"), [
    (10, 240, "tgs_soft"), (10, 15, "exact"), (2, 15, "tgs_soft"), (17, 15, "tgs_soft"),
])  # fmt: skip
def test_tuned_contacts_are_exact_where_springs_would_give_way_under_a_heap_of_few(n: int, rate: int, solver: str) -> None:
    assert ADAPTER.build(_tower(n), TUNED.with_dt(1 / rate)).resolved.solver == solver


def test_a_lone_body_is_not_pressed_through_a_wall_by_any_weight() -> None:
    """Springs of sub-steps of 1/1920 s give by g/w^2: by 1 um at 10 m/s^2, and at 1e6 m/s^2 by .11 m, half of the cube."""
    for pull, solver in ((10.0, "tgs_soft"), (1e6, "exact")):
        scene = replace(_tower(1), gravity=(0.0, 0.0, -pull))
        simulation = ADAPTER.build(scene, TUNED)
        assert simulation.resolved.solver == solver
        assert _end(simulation, scene, 60).p_WB[1, 2] == pytest.approx(0.1, abs=1e-4)


def test_whole_steps_are_steps_of_a_part_of_dt() -> None:
    """Bit for bit, in a world and in a batch and with uneven steps; contacts are told of all, with their means of forces."""
    scene = _tower(3)
    four = Settings(substeps=8, options={"steps": 4})
    by_parts = Settings(dt=four.dt / 4, substeps=2)
    whole, parts = ADAPTER.build(scene, four), ADAPTER.build(scene, by_parts)
    assert (whole.resolved.substeps, whole.resolved.options["steps"]) == (8, 4)
    assert ADAPTER.build(scene, whole.resolved).resolved == whole.resolved
    assert np.array_equal(_end(whole, scene, 30).q_WB, _end(parts, scene, 120).q_WB)
    assert whole.force_lead == pytest.approx(0.5 * (1 - 1 / 8))
    whole.retime(four.dt / 2)
    parts.retime(by_parts.dt / 2)
    last = _end(whole, scene, 10)
    assert np.array_equal(last.p_WB, _end(parts, scene, 40).p_WB)
    assert len(whole.contacts().gap) == len(parts.contacts().gap)  # from the first question on each step is listened to
    before, after = _end(whole, scene, 0), _end(whole, scene, 1)
    lift = sum(force[2] for force in whole.contacts().force_W[whole.contacts().body_A == 0])
    gained = (after.v_WB[1:, 2] - before.v_WB[1:, 2]).sum()
    assert lift * four.dt / 2 == pytest.approx(gained + 3 * 9.81 * four.dt / 2, rel=1e-9)
    batch = ADAPTER.build_batch(scene, four, 2)
    batch.step(30)
    state = State.initial(scene)
    batch.state(1, state)
    assert np.array_equal(state.p_WB, _end(ADAPTER.build(scene, four), scene, 30).p_WB)
    for wrong in (0, 3, 16, 1.0, True):
        with pytest.raises(SettingsError, match="'steps' is"):
            ADAPTER.build(scene, replace(four, options={"steps": wrong}))


def test_tuned_takes_whole_steps_where_sub_steps_would_see_nothing() -> None:
    """A fast top under Runge-Kutta, and what would go through a wall between two looks; not a ball that only spins."""
    heavy_top = plugins.case("spin_heavy_top")
    assert "steps" not in ADAPTER.build(heavy_top.scene(heavy_top.at(spin=200.0)), TUNED).resolved.options
    used = ADAPTER.build(heavy_top.scene(heavy_top.at(spin=2000.0)), TUNED).resolved
    assert (used.substeps, used.options["steps"]) == (8, 8)
    assert ADAPTER.build(heavy_top.scene(heavy_top.at(spin=2000.0)), used).resolved == used
    for spin, integrator in ((1900.0, "rk4"), (2000.0, "implicit_midpoint")):
        assert ADAPTER.build(heavy_top.scene(heavy_top.at(spin=spin)), TUNED).resolved.integrator == integrator
    wall = plugins.case("tunnel_sphere_wall")
    for speed, continuous, steps in ((20.0, False, 8), (1.0, False, None), (20.0, True, None)):
        used = ADAPTER.build(wall.scene(wall.at(speed=speed, continuous=continuous)), TUNED).resolved
        assert used.options.get("steps") == steps
    pairs = plugins.case("tunnel_dynamic_pair")
    for speed, steps in ((20.0, 8), (10.0, None)):  # of each against the other
        used = ADAPTER.build(pairs.scene(pairs.at(speed=speed, continuous=False)), TUNED).resolved
        assert used.options.get("steps") == steps
    assert "steps" not in ADAPTER.build(scene_at(plugins.case("friction_backspin"), {}), TUNED.with_dt(1 / 60)).resolved.options


@pytest.mark.parametrize(("ball", "asked", "substeps", "sweeps"), [
    (1.0, 8, 1, 4), (1.0, 16, 2, 2), (1.0, 2, 1, 4), (4.0, 8, 2, 2), (15.0, 8, 4, 2), (1e-4, 8, 8, 2),
])  # fmt: skip
def test_tuned_takes_the_sub_steps_that_unlike_masses_call_for_where_trees_of_joints_are_touched(
    ball: float, asked: int, substeps: int, sweeps: int
) -> None:
    """A box on a vertical slide, which a loose ball of some mass may touch."""
    slide = Prismatic(name="slide", parent=WORLD, child="box", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0))
    loose = Body(name="ball", mass=ball, collision=(PlacedShape(shape=Sphere(radius=0.05)),), p_WB=(0.0, 0.0, 1.0))
    box = Body(name="box", collision=CUBE, p_WB=(0.0, 0.0, 0.1))
    scene = Scene(bodies=(GROUND, box, loose), joints=(slide,), surfaces=(RUBS,))
    used = ADAPTER.build(scene, replace(TUNED, substeps=asked)).resolved
    assert used.options["coordinates"] == "joint"
    assert (used.substeps, used.iterations, used.integrator) == (substeps, sweeps, "semi_implicit_euler")
    assert ADAPTER.build(scene, used).resolved == used


def test_the_tolerance_of_exact_contacts_leaves_room_for_the_rounding_of_the_load() -> None:
    assert ADAPTER.build(_pair(1e3), TUNED).resolved.tolerance == 1e-11
    assert ADAPTER.build(_pair(1e6), TUNED).resolved.tolerance == 1e-9


@pytest.mark.parametrize(("overlap", "solver"), [(0.0, "tgs_soft"), (0.0049, "tgs_soft"), (0.0051, SPLIT)])
def test_tuned_contacts_are_split_impulses_where_bodies_start_inside_each_other(overlap: float, solver: str) -> None:
    """From a twentieth of the half width on; what they leave of a depth, a tenth of the margin, shrinks with the step."""
    for dt in (1 / 60, 1 / 960):
        stage = _pair(overlap=overlap)
        used = ADAPTER.build(stage, TUNED.with_dt(dt)).resolved
        assert used.solver == solver
        if solver == SPLIT:
            assert used.options["margin"] == pytest.approx(min(1e-3, 9.81 * dt**2))
        assert ADAPTER.build(stage, used).resolved == used


def test_what_is_asked_for_by_name_is_what_is_used() -> None:
    asked = replace(TUNED, solver="tgs_soft")
    assert ADAPTER.build(_pair(1e3), asked).resolved.solver == "tgs_soft"
    assert ADAPTER.build(_pair(overlap=0.05), asked).resolved.solver == "tgs_soft"
    with pytest.raises(SettingsError, match="suited"):
        ADAPTER.build(_pair(), replace(TUNED, solver="best"))


@pytest.mark.parametrize("substeps", [1, 2, 4, 8])
def test_a_linkage_goes_through_its_singular_pose_wherever_the_steps_fall(substeps: int) -> None:
    """Joints that are closed by rounds with the Jacobian of the start may find it dependent there: the linkage must neither fly
    apart nor go on as an anti-parallelogram. Six steps and four numbers of sub-steps put starts close to the pose."""
    case = plugins.case("joint_fourbar")
    for dt in case.ladder:
        answer = put(case, ADAPTER, replace(ADAPTER.tracks["default"], substeps=substeps, dt=dt))
        assert answer.broke is None
        assert not answer.broken, (dt, answer.broken)
        # What a round leaves that was taken back is of the second order in the way of a step.
        assert answer["joint_gap_max"] < 1e-9


def test_a_level_of_detail_is_taken_where_it_is_asked_for_alone() -> None:
    """The slab of the case is convex, so that its hull stops the ball as the mesh does; unset, nothing is said of levels."""
    case = plugins.case("tunnel_thin_mesh")
    scene = case.scene(case.at(phases=1))
    plain = ADAPTER.build(scene, ADAPTER.tracks["default"])
    assert "level_of_detail" not in plain.resolved.options
    asked = replace(ADAPTER.tracks["default"], options={"level_of_detail": "hull"})
    hull = ADAPTER.build(scene, asked)
    assert hull.resolved.options["level_of_detail"] == "hull"
    assert ADAPTER.build(scene, hull.resolved).resolved == hull.resolved
    ends = [_end(simulation, scene, 60) for simulation in (plain, hull)]
    assert ends[1].p_WB == pytest.approx(ends[0].p_WB, abs=1e-3)
    for wrong in ("cube", 3):
        with pytest.raises(SettingsError, match="level_of_detail"):
            ADAPTER.build(scene, replace(asked, options={"level_of_detail": wrong}))
