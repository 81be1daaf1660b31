"""The reference engine behind the adapter: which solver and continuous collision a setting calls for, and what is said."""

import math
from dataclasses import replace
from typing import Any

import pytest

from adapters.reference import ADAPTER
from harness import discover
from harness.adapter import Settings, SettingsError, Simulation, Unsupported
from harness.scene import WORLD, Ball, Body, Box, Effect, PlacedShape, Plane, Scene, Sphere, Surface
from harness.trajectory import State
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
    tie = Ball(name="tie", parent=WORLD, child="shot", anchor_W=(-0.6, 0.0, 1.0))
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


@pytest.mark.parametrize("substeps", [1, 2, 4, 8])
def test_a_linkage_goes_through_its_singular_pose_wherever_the_steps_fall(substeps: int) -> None:
    """Joints that are closed by rounds with the Jacobian of the start may find it dependent there: the linkage must neither fly
    apart nor go on as an anti-parallelogram. Six steps and four numbers of sub-steps put starts close to the pose."""
    case = discover.case("joint_fourbar")
    for dt in case.ladder:
        answer = put(case, ADAPTER, replace(ADAPTER.tracks["default"], substeps=substeps, dt=dt))
        assert answer.broke is None
        assert not answer.broken, (dt, answer.broken)
        # What a round leaves that was taken back is of the second order in the way of a step.
        assert answer["joint_gap_max"] < 1e-9
