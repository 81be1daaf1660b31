"""Kinematic bodies led by a law of time: what a scene may say of them, where they are, and who is told what."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline import engine
from plumbline.harness.adapter import Feature, Unsupported
from plumbline.harness.adapter.features import features_of
from plumbline.harness.case.commands import acting, velocities_of
from plumbline.harness.case.forces import Control, Controlled
from plumbline.harness.case.symmetries import in_motion, moved, scaled, turned
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import energy_change, momentum_drift_max
from plumbline.harness.scene import (
    Body,
    Box,
    PlacedShape,
    Prescribed,
    Revolute,
    Samples,
    Scene,
    SceneError,
    Shift,
    Sinusoid,
    Turn,
    axis_angle,
)
from plumbline.harness.scene.file import dump_json, dump_toml, parse, schema
from plumbline.harness.trajectory import State, Trajectory
from tests.conformance.engines import adapter

WAVE = Sinusoid(amplitude=0.2, frequency=1.5, phase=0.7)
SHAKER = Prescribed(shifts=(Shift(axis_W=(1.0, 0.0, 0.0), motion=WAVE),))
ARM = Prescribed(
    turn=Turn(anchor_W=(1.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0), motion=Samples(time=(0.0, 1.0), target=(0.5, 2.5)))
)


def scene(prescribed: Prescribed | None = SHAKER) -> Scene:
    table = Body(name="table", motion="kinematic", p_WB=(2.0, 0.0, 0.0), v_WB=(0.0, 0.0, 0.1), prescribed=prescribed)
    return Scene(bodies=(table, Body(name="load", p_WB=(0.0, 5.0, 0.0))), gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("prescribed", [SHAKER, ARM, replace(ARM, shifts=SHAKER.shifts)])
def test_a_scene_file_keeps_what_is_prescribed(prescribed: Prescribed) -> None:
    told = scene(prescribed)
    assert parse(dump_json(told)) == told
    assert parse(dump_toml(told), "scene.toml") == told
    assert "Prescribed" in json.dumps(schema())


def test_a_scene_without_it_says_nothing_of_it() -> None:
    assert "prescribed" not in dump_json(scene(None))
    assert features_of(scene()) == features_of(scene(None)) | Feature.PRESCRIBED_MOTION


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"motion": "dynamic"}, "expected motion 'kinematic', got 'dynamic'"),
        ({"motion": "static", "v_WB": [0, 0, 0]}, "expected motion 'kinematic', got 'static'"),
        ({"w_WB": [0, 0, 1]}, "beside a prescribed motion"),
        ({"prescribed": {}}, "neither shifts nor a turn"),
        (
            {"prescribed": {"shifts": [{"axis_W": [0, 0, 0], "motion": {"type": "sinusoid", "amplitude": 1, "frequency": 1}}]}},
            "axis_W",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(change: dict[str, object], said: str) -> None:
    told = json.loads(dump_json(scene()))
    told["bodies"][0].update(change)
    with pytest.raises(SceneError, match=said):
        parse(json.dumps(told))


def test_a_pose_begins_where_the_scene_has_it_and_adds_shift_turn_and_uniform_motion() -> None:
    """Half a second: 1 rad about z for a body a metre beside the axis, .05 m up, and what the wave has gone since 0."""
    law, q = replace(ARM, shifts=SHAKER.shifts), axis_angle((1.0, 2.0, 3.0), 0.4)
    start, first = law.pose((2.0, 0.0, 0.0), q, (0.0, 0.0, 0.1), 0.0)
    assert start == (2.0, 0.0, 0.0)
    assert first == pytest.approx(q, abs=1e-15)
    p, turned_q = law.pose((2.0, 0.0, 0.0), q, (0.0, 0.0, 0.1), 0.5)
    way = 0.2 * (math.sin(math.pi * 1.5 + 0.7) - math.sin(0.7))
    assert p == pytest.approx((1.0 + math.cos(1.0) + way, math.sin(1.0), 0.05), abs=1e-15)
    assert turned_q[0] == pytest.approx(math.cos(0.5) * q[0] - math.sin(0.5) * q[3], abs=1e-15)


def test_velocities_are_the_way_and_the_turn_of_a_step_over_it() -> None:
    velocities = velocities_of(scene(ARM))
    assert velocities is not None
    v, w = velocities(0.25, 0.125)["table"]
    assert w == pytest.approx((0.0, 0.0, 2.0), abs=1e-14)
    chord = np.subtract([np.cos(0.75), np.sin(0.75)], [np.cos(0.5), np.sin(0.5)]) / 0.125
    assert v == pytest.approx((*chord, 0.1), abs=1e-14)
    assert velocities_of(scene(None)) is None


def test_a_scene_and_its_case_do_not_both_lead_bodies() -> None:
    with pytest.raises(ValueError, match="both are moved"):
        acting(scene(), Control(velocities=lambda *_: {}))
    both = acting(scene(), Control(wrench=lambda *_: (np.zeros((2, 3)), np.zeros((2, 3)))))
    assert both is not None
    assert both.wrench is not None
    assert both.velocities is not None


@pytest.mark.parametrize("name", ["mujoco", "bullet", "dart", "reference"])
def test_only_bodies_that_are_led_are_told_and_only_finite_velocities(name: str) -> None:
    one = adapter(name)
    with Engine(one, one.tracks["tuned"]).built(scene(), dt=None) as simulation:
        for velocities, said in (
            ({"load": ((0.0,) * 3, (0.0,) * 3)}, "body 'load' is not prescribed, expected one of table"),
            ({"table": ((math.nan, 0.0, 0.0), (0.0,) * 3)}, "finite"),
            ({"table": ((0.0,) * 3,)}, "v_WB and w_WB"),
        ):
            with pytest.raises(ValueError, match=said):
                simulation.prescribe(velocities)  # type: ignore[attr-defined]


@pytest.mark.parametrize("tell", [lambda s: moved(s, (3.0, -1.0, 2.0)), lambda s: turned(s, axis_angle((1.0, 2.0, 3.0), 0.8))])
def test_a_scene_told_at_another_place_leads_its_bodies_there(tell: object) -> None:
    assert callable(tell)
    told, one, ends = scene(replace(ARM, shifts=SHAKER.shifts)), adapter("reference"), []
    for other in (told, tell(told).scene, in_motion(told, (0.3, 0.0, 0.0)).scene):
        with Engine(one, one.tracks["tuned"]).built(other, dt=0.01) as simulation:
            control = acting(other)
            assert control is not None
            Controlled(simulation, control, 0.01, 2).step(30)
            out = State.empty(2)
            simulation.state(out)
            ends.append(out.p_WB[0] - out.p_WB[1])
    assert np.linalg.norm(ends[1]) == pytest.approx(np.linalg.norm(ends[0]), abs=1e-12)
    np.testing.assert_allclose(ends[2], ends[0], atol=1e-12)
    with pytest.raises(ValueError, match="its motion is prescribed, which is not scaled"):
        scaled(told, "large", 2.0)


def test_energy_and_momentum_are_no_constants_where_a_body_is_led() -> None:
    run = Trajectory.of(np.zeros(2), 2)
    for law in (energy_change, momentum_drift_max):
        with pytest.raises(NotMeasurable, match="'table' is led"):
            law(scene(), run, None)
    from_rest = Prescribed(
        shifts=(Shift(axis_W=(1.0, 0.0, 0.0), motion=Samples(time=(0.0, 0.5, 1.0), target=(0.0, 0.0, 1.0))),)
    )
    table = Body(name="table", motion="kinematic", prescribed=from_rest)
    assert not np.any(table.velocity_at_start)
    with pytest.raises(NotMeasurable, match="'table' is led"):
        energy_change(Scene(bodies=(table, Body(name="load"))), run, None)
    belt = Scene(bodies=(Body.ball("parcel", 0.1, 1.0, touches=False), Body(name="belt", motion="kinematic", v_WB=(0.5, 0, 0))))
    with pytest.raises(NotMeasurable, match="'belt' is led"):
        energy_change(belt, run, None)


def test_a_sleeping_load_wakes_when_what_it_lies_on_is_led_away() -> None:
    box = engine.Placed(engine.Box((0.5, 0.5, 0.1)))
    bodies = [
        engine.Body(name="plate", motion="kinematic", shapes=[box]),
        engine.Body(name="load", mass=1.0, inertia=np.eye(3) * 0.1, p_WB=(0.0, 0.0, 0.2), shapes=[box]),
    ]
    world = engine.World(
        bodies,
        surfaces={("default", "default"): engine.Surface(static_friction=0.5, kinetic_friction=0.5)},
        options=engine.Options(dt=1 / 240, sleeping=True),
    )
    world.step(480)
    assert world.asleep()[1]
    world.prescribe(0, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    world.step(120)
    assert not world.asleep()[1]
    assert world.state()[1, 2] == pytest.approx(0.7, abs=5e-3)
    with pytest.raises(ValueError, match="body 1 is not kinematic"):
        world.prescribe(1, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


def test_a_box_on_a_conveyor_is_taken_along() -> None:
    """The plain kinematic body with v_WB is such a conveyor; a shift of samples says the same in words of time."""
    belt = Prescribed(shifts=(Shift(axis_W=(1.0, 0.0, 0.0), motion=Samples(time=(0.0, 9.0), target=(0.0, 9.0))),))
    one, ends = adapter("reference"), []
    for table in (
        Body(name="table", motion="kinematic", prescribed=belt),
        Body(name="table", motion="kinematic", v_WB=(1.0, 0.0, 0.0)),
    ):
        told = Scene(
            bodies=(
                replace(table, collision=(PlacedShape(shape=Box(half_extents=(1, 1, 1))),)),
                Body(name="load", p_WB=(0, 0, 9)),
            )
        )
        with Engine(one, one.tracks["tuned"]).built(told, dt=0.01) as simulation:
            control = acting(told)
            led = simulation if control is None else Controlled(simulation, control, 0.01, 2)
            led.step(50)
            out = State.empty(2)
            simulation.state(out)
            ends.append(out.p_WB[0])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


RISING = Sinusoid(amplitude=0.1, frequency=1.0)
"""It moves at t = 0, by 0.2 pi m/s or rad/s."""
RATE = 0.2 * math.pi


def hung(*, turning: bool, begun: bool) -> Scene:
    """A pendulum that hangs on a table which moves from the first instant on, and that has, or has not, begun with it."""
    shift = Prescribed(shifts=(Shift(axis_W=(1.0, 0.0, 0.0), motion=RISING),))
    turn = Prescribed(turn=Turn(anchor_W=(0.0, 0.0, 2.0), axis_W=(0.0, 1.0, 0.0), motion=RISING))
    rate = RATE if begun else 0.0
    # At 0.5 m below the axis a body that turns about y goes by -0.5 m times the rate along x.
    own = {"v_WB": (-0.5 * rate, 0.0, 0.0), "w_WB": (0.0, rate, 0.0)} if turning else {"v_WB": (rate, 0.0, 0.0)}
    return Scene(
        bodies=(
            Body(name="table", motion="kinematic", p_WB=(0.0, 0.0, 2.0), prescribed=turn if turning else shift),
            Body(name="bob", p_WB=(0.0, 0.0, 1.5), mass=2.0, inertia=((0.02, 0, 0), (0, 0.03, 0), (0, 0, 0.04)), **own),
        ),
        joints=(Revolute(name="j", parent="table", child="bob", anchor_W=(0.0, 0.0, 2.0), axis_W=(1.0, 0.0, 0.0)),)
        if turning
        else (Revolute(name="j", parent="table", child="bob", anchor_W=(0.0, 0.0, 2.0), axis_W=(0.0, 1.0, 0.0)),),
    )


@pytest.mark.parametrize("turning", [False, True], ids=["shifted", "turned"])
@pytest.mark.parametrize("name", ["mujoco", "bullet", "dart", "reference"])
def test_what_hangs_on_a_body_that_moves_at_once_starts_with_it(name: str, turning: bool) -> None:
    one = adapter(name)
    settings = replace(one.tracks["tuned"], dt=1e-3)
    with Engine(one, settings).built(hung(turning=turning, begun=True), dt=None) as simulation:
        start = State.empty(2)
        simulation.state(start)
        assert start.v_WB[1] == pytest.approx((-0.5 * RATE if turning else RATE, 0.0, 0.0), abs=1e-9)
        controlled = Controlled(simulation, acting(hung(turning=turning, begun=True), None), 1e-3, 2)
        controlled.step(20)
        after = State.empty(2)
        controlled.state(after)
    # Nothing pulls at once: within 20 ms the table's acceleration, 4e-3 m/s2 and below a metre per second squared of gravity on
    # a pendulum that has swung by 0.013 rad, change the speed by less than 20 ms times 1 m/s2.
    assert after.v_WB[1] == pytest.approx(start.v_WB[1], abs=0.02)
    with pytest.raises(Unsupported), Engine(one, settings).built(hung(turning=turning, begun=False), dt=None):
        pass


def test_a_motion_says_how_fast_it_is_at_the_start() -> None:
    assert RISING.rate_at_start() == pytest.approx(RATE)
    assert Samples(time=(0.0, 0.5), target=(1.0, 2.0)).rate_at_start() == 2.0
    assert Samples(time=(0.1, 0.5), target=(1.0, 2.0)).rate_at_start() == 0.0
    table = hung(turning=True, begun=True).bodies[0]
    assert table.velocity_at_start == ((0.0, 0.0, 0.0), (0.0, pytest.approx(RATE), 0.0))
