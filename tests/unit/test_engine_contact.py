"""Contacts: bounces, friction, rest, stacks, fast bodies, and what can be read out of them."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from plumbline import engine

G = 9.81
DEFAULT = ("default", "default")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
HULL = engine.ConvexHull([(x, y, z) for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)])
H = 1 / 960
"""The sub-step [s] of four in a step of 1/240 s."""
SINK = G * (2 * H / math.pi) ** 2
"""How far [m] a body sinks into one contact spring of a quarter of the sub-step's rate: g / (2 pi / (4 h))^2 = 4.3 um."""


def _ball(radius: float = 0.05, name: str = "ball", mass: float = 1.0, **state: object) -> engine.Body:
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Sphere(radius))], **state)  # type: ignore[arg-type]


def _cube(half: float = 0.1, name: str = "cube", mass: float = 1.0, **state: object) -> engine.Body:
    inertia = mass * (2 * half) ** 2 / 6 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Box((half,) * 3))], **state)  # type: ignore[arg-type]


def _world(
    bodies: Sequence[engine.Body], law: engine.Surface | None = None, gravity: Sequence[float] = (0, 0, -G), **options: object
) -> engine.World:
    return engine.World(bodies, surfaces={DEFAULT: law or engine.Surface()}, gravity=gravity, options=engine.Options(**options))  # type: ignore[arg-type]


def _rough(static: float, kinetic: float | None = None) -> engine.Surface:
    return engine.Surface(static_friction=static, kinetic_friction=static if kinetic is None else kinetic)


@pytest.mark.parametrize("restitution", [0.5, 0.8, 1.0])
def test_a_ball_bounces_to_the_height_its_restitution_says(restitution: float) -> None:
    """h_1 = e^2 h.

    Between bounces the path is exact; a blow is placed within one sub-step, an error of (g h)^2 in v^2: 1e-4.
    """
    world = _world([GROUND, _ball(p_WB=(0, 0, 1.05))], engine.Surface(restitution=restitution), integrator="rk4")
    energy = []
    for _ in range(200):
        world.step()
        state = world.state()[1]
        energy.append((G * (state[2] - 0.05) + 0.5 * state[9] ** 2) / G)
    assert math.sqrt(energy[-1]) == pytest.approx(restitution, rel=2e-3)
    assert max(energy) < 1 + 1e-12


def test_semi_implicit_euler_bounces_within_one_percent() -> None:
    """Each flight loses h g = .01 m/s of 4.43 m/s in speed, a quarter of a percent; no more than that is lost in the blow."""
    world = _world([GROUND, _ball(p_WB=(0, 0, 1.05))], engine.Surface(restitution=0.8))
    world.step(200)
    state = world.state()[1]
    assert math.sqrt((state[2] - 0.05) + 0.5 * state[9] ** 2 / G) == pytest.approx(0.8, rel=0.01)


def test_a_ball_without_restitution_stays_down() -> None:
    """It rests at the depth where the contact spring carries it, and does not rise."""
    world = _world([GROUND, _ball(p_WB=(0, 0, 0.3))])
    world.step(240)
    assert world.state()[1, 2] == pytest.approx(0.05 - SINK, abs=1e-7)
    assert abs(world.state()[1, 9]) < 1e-9


@pytest.mark.parametrize("friction", [0.2, 0.4, 0.7])
def test_a_sliding_box_stops_after_v2_over_2_mu_g_in_every_direction(friction: float) -> None:
    """Semi-implicit Euler goes v_0 h / 2 = 1 mm less far; the rest, the settling of the contact, is below .1 % of the way."""
    way = 2.0**2 / (2 * friction * G)
    for azimuth in (0.0, 0.4, 1.2):
        start = (2 * math.cos(azimuth), 2 * math.sin(azimuth), 0)
        world = _world([GROUND, _cube(p_WB=(0, 0, 0.1), v_WB=start)], _rough(friction))
        world.step(int(240 * (2.0 / (friction * G) + 1.0)))
        x, y = world.state()[1, :2]
        assert math.hypot(x, y) == pytest.approx(way - 2.0 * H / 2, rel=1e-3)
        assert math.atan2(y, x) == pytest.approx(azimuth, abs=1e-4)
        assert np.abs(world.state()[1, 7:]).max() < 1e-6


def _incline(tangent: float) -> tuple[float, float, float]:
    angle = math.atan(tangent)
    return G * math.sin(angle), 0.0, -G * math.cos(angle)


def test_a_box_just_below_the_threshold_does_not_creep() -> None:
    """Warm-started friction holds the load exactly: one micrometre in two seconds would already be creep."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.5), _incline(0.4995))
    world.step(240)
    start = world.state()[1, 0]
    world.step(480)
    assert abs(world.state()[1, 0] - start) < 1e-9


def test_a_box_just_above_the_threshold_slides() -> None:
    """a = g (sin - mu cos) = 4.4 mm/s2 over two seconds: 8.8 mm from rest, more with the speed of the first second."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.5), _incline(0.5005))
    world.step(480)
    assert world.state()[1, 0] > 0.004


def test_static_friction_holds_what_kinetic_friction_would_not() -> None:
    """tan = .55 lies between mu_kinetic = .4 and mu_static = .6: at rest it holds; the first sub-steps give micrometres."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.6, 0.4), _incline(0.55))
    world.step(480)
    assert abs(world.state()[1, 0]) < 1e-5
    assert abs(world.state()[1, 7]) < 1e-9


@pytest.mark.parametrize("substeps", [4, 16])
def test_corners_that_bear_unlike_loads_hold_what_static_friction_can(substeps: int) -> None:
    """tan = .599 of .6: there the lower corners bear four times what the upper ones do (1 + tan against 1 - tan); sweeps that
    start from nothing leave a thousandth."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.6, 0.4), _incline(0.599), substeps=substeps)
    world.step(480)
    assert abs(world.state()[1, 7]) < 1e-9


def test_a_drawn_body_breaks_away_within_a_step_of_when_its_pull_is_static_friction() -> None:
    """k v t = mu_static m g at 1.4715 s, whatever the step: the pull grows by 4 N/s, 2 mN a step of 5.9 N."""
    block = engine.Body(
        name="block", mass=1.0, inertia=np.diag([0.015, 0.015, 0.025]), p_WB=(0, 0, 0.05),
        shapes=[engine.Placed(engine.Box((0.2, 0.2, 0.05)))],
    )  # fmt: skip
    puller = engine.Body(name="puller", motion="kinematic", p_WB=(1, 0, 0.05), v_WB=(0.2, 0, 0))
    line = engine.Distance(
        name="line",
        parent="puller",
        child="block",
        anchor_W=(1, 0, 0.05),
        child_anchor_W=(0, 0, 0.05),
        spring=engine.Spring(stiffness=20.0, rest=1.0),
    )
    world = engine.World(
        [GROUND, block, puller], [line], {DEFAULT: _rough(0.6, 0.4)}, options=engine.Options(dt=1 / 1920, substeps=8)
    )
    due = 0.6 * G / (20.0 * 0.2)
    world.step(int(due * 1920) - 1)
    assert abs(world.state()[1, 7]) < 1e-6
    world.step(4)
    assert world.state()[1, 7] > 1e-4


def test_beyond_static_friction_a_box_slides_under_kinetic_friction() -> None:
    """tan = .61: v = g (sin - mu_kinetic cos) t; one sub-step under mu_static costs .2 g h = 2 mm/s of 1.76 m/s."""
    gravity = _incline(0.61)
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.6, 0.4), gravity)
    world.step(240)
    assert world.state()[1, 7] == pytest.approx(gravity[0] + 0.4 * gravity[2], abs=0.004)


def test_a_sliding_ball_ends_up_rolling_at_five_sevenths() -> None:
    """v = 5/7 v_0 whatever mu: angular momentum about the contact is kept; the lever errs by the sinking, 1e-4 of r."""
    world = _world([GROUND, _ball(0.1, p_WB=(0, 0, 0.1), v_WB=(5.0, 0, 0))], _rough(0.3))
    world.step(480)
    state = world.state()[1]
    assert state[7] == pytest.approx(5.0 * 5 / 7, rel=1e-3)
    assert state[11] == pytest.approx(state[7] / 0.1, rel=1e-3)


def test_rolling_friction_brakes_a_rolling_ball() -> None:
    """a = -(5/7) (b / r) g with the coefficient b [m], from both equations of motion and rolling; 1 % for the start."""
    law = engine.Surface(static_friction=0.8, kinetic_friction=0.8, rolling_friction=0.002)
    world = _world([GROUND, _ball(0.1, p_WB=(0, 0, 0.1), v_WB=(1.0, 0, 0), w_WB=(0, 10.0, 0))], law)
    world.step(240)
    assert 1.0 - world.state()[1, 7] == pytest.approx(5 / 7 * 0.002 / 0.1 * G, rel=0.02)


def test_torsional_friction_brakes_a_spinning_ball() -> None:
    """I w' = -b m g with the coefficient b [m]."""
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.5, torsional_friction=0.001)
    world = _world([GROUND, _ball(0.1, p_WB=(0, 0, 0.1), w_WB=(0, 0, 10.0))], law)
    world.step(240)
    assert 10.0 - world.state()[1, 12] == pytest.approx(0.001 * G / (0.4 * 0.01), rel=0.02)


def test_the_forces_under_a_resting_box_add_up_to_its_weight() -> None:
    """At rest the impulses of all sub-steps over dt are the weight, to round-off; the force acts on B, which is the ground."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1), mass=3.0)], _rough(0.5))
    world.step(480)
    found = world.contacts()
    assert found.bodies.tolist() == [[1, 0]] * 4
    assert found.normal == pytest.approx(np.array([[0.0, 0.0, -1.0]] * 4), abs=1e-9)
    assert found.force.sum(axis=0) == pytest.approx([0.0, 0.0, -3.0 * G], abs=1e-7)
    assert found.gap == pytest.approx([-SINK] * 4, abs=1e-8)
    assert np.sqrt((world.state()[1, 7:] ** 2).mean()) < 1e-8


def test_a_stack_of_ten_boxes_stands_still() -> None:
    """The lowest contact carries ten boxes, ten times the sinking of one: 43 um if four corners share alike, else twice."""
    stack = [_cube(name=f"box{k}", p_WB=(0, 0, 0.1 + 0.2 * k)) for k in range(10)]
    world = _world([GROUND, *stack], _rough(0.5))
    world.step(720)
    speeds = []
    for _ in range(60):
        world.step()
        speeds.append(world.state()[1:, 7:10].copy())
    assert np.sqrt((np.array(speeds) ** 2).mean()) < 1e-3
    assert world.contacts().gap.min() > -1e-4
    below = world.contacts().bodies[:, 1] == 0
    assert -world.contacts().force[below, 2].sum() == pytest.approx(10 * G, rel=1e-3)


@pytest.mark.parametrize(
    ("order", "steps"),
    [
        pytest.param(range(10), 40, id="up"),
        pytest.param(range(10), 120, id="up for 3 s", marks=pytest.mark.slow),
        pytest.param(range(9, -1, -1), 120, id="down", marks=pytest.mark.slow),
        pytest.param((3, 7, 0, 9, 5, 1, 8, 2, 6, 4), 120, id="mixed", marks=pytest.mark.slow),
    ],
)
def test_a_stack_stands_under_a_top_a_thousand_times_heavier(order: Sequence[int], steps: int) -> None:
    """Sub-steps of 1/15360 s, 32 sweeps and 8 relaxing ones: the top sinks by less than 1 mm at once, in any order, and by no
    more later: a sway of 1 mm in 2 m lowers it by 3e-7 m.

    Between two boxes lie the springs of half a box, which sinks by g / (2 pi / (4 h))^2 = 17 nm under its own weight, so by
    34 um under 1 t; ten times that is 0.34 mm.
    """
    bodies = [_cube(name=f"box_{i}", mass=1000.0 if i == 9 else 1.0, p_WB=(0, 0, 0.1 + 0.2 * i)) for i in order]
    world, top = _world([GROUND, *bodies], _rough(0.5), substeps=64, iterations=32, relaxations=8), 1 + list(order).index(9)
    world.step(2 * steps)
    sunk = world.state()[top, 2]
    for _ in range(4):
        world.step(steps)
        assert abs(world.state()[top, 2] - 1.9) < 1e-3
        assert abs(world.state()[top, 2] - sunk) < 1e-6
    # A slow sway of millimetres is left, in which the top's height does not take part.
    assert np.abs(world.state()[1:, 7:10]).max() < 0.01


def test_a_resting_box_feels_what_strikes_it_and_what_is_taken_away_from_under_it() -> None:
    """Contacts kept from step to step while nothing moves give way to new ones: both momenta of the blow are there, m v."""
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1)), _ball(0.05, p_WB=(-2.15, 0, 0.1), v_WB=(2, 0, 0))], gravity=(0, 0, 0))
    world.step(480)
    state = world.state()
    assert state[1:, 7].sum() == pytest.approx(2.0, abs=1e-9)
    assert state[1, 7] > 0.9
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1)), _cube(name="top", p_WB=(0, 0, 0.3))], _rough(0.5))
    world.step(240)
    world.set_load([(0, 0, 0), (200, 0, 0), (0, 0, 0)], np.zeros((3, 3)))
    world.step(240)
    assert world.state()[1, 0] > 1.0
    assert world.state()[2, 2] == pytest.approx(0.1, abs=1e-3)


@pytest.mark.parametrize("speed", [1.0, 7.3, 50.0, 500.0])
def test_continuous_collision_never_lets_a_ball_through_a_thin_wall(speed: float) -> None:
    """The contact is made for the way of the whole step, so the phase of the step cannot matter; it stops at the surface."""
    wall = engine.Body(name="wall", motion="static", shapes=[engine.Placed(engine.Box((0.005, 1, 1)))])
    for phase in np.linspace(0, 1, 8, endpoint=False):
        ball = _ball(p_WB=(-0.3 - phase * speed / 240, 0, 0), v_WB=(speed, 0, 0))
        world = _world([wall, ball], gravity=(0, 0, 0), continuous="speculative")
        world.step(240)
        assert world.state()[1, 0] < -0.055 + 1e-6


@pytest.mark.parametrize("shape", [engine.Sphere(0.05), engine.Capsule(0.05, 0.1), engine.Cylinder(0.05, 0.1)])
@pytest.mark.parametrize("other", [engine.Sphere(0.02), engine.Box((0.3, 0.3, 0.02))])
@pytest.mark.parametrize("gap", [0.0199, 0.0201])
def test_without_continuous_collision_contacts_are_made_half_the_thickness_ahead(
    shape: engine.Shape, other: engine.Shape, gap: float
) -> None:
    """Of the thinner of the two, and no more, however fast they come: 20 m/s go 83 mm in a step."""
    low = engine.Body(name="low", motion="static", shapes=[engine.Placed(other)])
    reach = {engine.Sphere: 0.05, engine.Capsule: 0.15, engine.Cylinder: 0.1}[type(shape)]
    place = (0.0, 0.0, 0.02 + gap + reach)
    fast = engine.Body(name="fast", shapes=[engine.Placed(shape)], p_WB=place, v_WB=(0.0, 0.0, -20.0))
    world = _world([low, fast], gravity=(0, 0, 0))
    world.step(1)
    assert (len(world.contacts().gap) > 0) == (gap < 0.02)


def test_without_continuous_collision_a_fast_ball_may_pass() -> None:
    """At 500 m/s a step is 2 m, four hundred times half the wall, which it looks ahead: the effect is really off."""
    wall = engine.Body(name="wall", motion="static", shapes=[engine.Placed(engine.Box((0.005, 1, 1)))])
    world = _world([wall, _ball(p_WB=(-1.0, 0, 0), v_WB=(500.0, 0, 0))], gravity=(0, 0, 0))
    world.step(24)
    assert world.state()[1, 0] > 1.0


def test_a_collision_in_space_keeps_both_momenta() -> None:
    """Impulses are equal, opposite and at one point, so p and L change by round-off of 4 kg m/s in 30 sub-steps: 1e-12."""
    one = _cube(name="one", p_WB=(-0.3, 0.03, 0.02), v_WB=(2.0, 0, 0), w_WB=(1.0, 2.0, 0.5))
    two = _cube(name="two", p_WB=(0.3, 0, 0), v_WB=(-1.0, 0.1, 0), w_WB=(0, -1.0, 3.0), mass=2.0)
    world = _world([one, two], _rough(0.5), (0, 0, 0))

    def momenta() -> np.ndarray:
        s = world.state()
        spin = np.array([[1.0], [2.0]]) * 0.04 / 6 * s[:, 10:]
        p = np.array([[1.0], [2.0]]) * s[:, 7:10]
        return np.concatenate((p.sum(axis=0), (np.cross(s[:, :3], p) + spin).sum(axis=0)))

    before, start = momenta(), world.state().copy()
    world.step(120)
    assert np.abs(world.state()[:, 7:10] - start[:, 7:10]).max() > 0.5
    assert momenta() == pytest.approx(before, abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "p", "q", "height"),
    [
        (engine.Capsule(0.05, 0.1), (0, 0, 0.05), (math.sqrt(0.5), 0, math.sqrt(0.5), 0), 0.05),
        (engine.Box((0.1, 0.2, 0.3)), (0, 0, 0.1), (math.sqrt(0.5), 0, math.sqrt(0.5), 0), 0.1),
        (engine.Sphere(0.2), (0, 0, 0.2), (1, 0, 0, 0), 0.2),
        (engine.Cylinder(0.2, 0.3), (0, 0, 0.3), (1, 0, 0, 0), 0.3),
        (HULL, (0, 0, 0.1), (math.sqrt(0.5), 0, math.sqrt(0.5), 0), 0.1),
        (engine.Cylinder(0.2, 0.3), (0, 0, 0.2), (math.sqrt(0.5), 0, math.sqrt(0.5), 0), 0.2),
    ],
)
@pytest.mark.parametrize("table", ["plane", "box"])
def test_every_shape_rests_on_a_plane_and_on_a_box(
    shape: engine.Shape, p: Sequence[float], q: Sequence[float], height: float, table: str
) -> None:
    """Points share its weight, each with a spring for its own mass: less than twice the sinking of one; it stays put."""
    ground = GROUND
    if table == "box":
        top = engine.Placed(engine.Box((2, 2, 0.5)), p_BS=(0, 0, -0.5))
        ground = engine.Body(name="ground", motion="static", shapes=[top])
    body = engine.Body(name="b", inertia=np.diag([0.13, 0.1, 0.05]) / 3, shapes=[engine.Placed(shape)], p_WB=p, q_WB=q)
    world = _world([ground, body], _rough(0.5))
    world.step(240)
    assert world.state()[1, 2] == pytest.approx(height, abs=2 * SINK)
    assert np.abs(world.state()[1, :2]).max() < 1e-5
    assert np.abs(world.state()[1, 7:]).max() < 1e-6


def test_crossed_capsules_touch_in_the_middle() -> None:
    """Axes along x and y, 8 cm apart in height with radii of 5 cm: one point, 2 cm deep, normal up from low to high."""
    turn_x, turn_y = (math.sqrt(0.5), 0, math.sqrt(0.5), 0), (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
    low = engine.Body(name="low", shapes=[engine.Placed(engine.Capsule(0.05, 0.2), q_BS=turn_x)])
    high = engine.Body(name="high", shapes=[engine.Placed(engine.Capsule(0.05, 0.2), q_BS=turn_y)], p_WB=(0.03, 0.01, 0.08))
    world = _world([low, high], gravity=(0, 0, 0))
    world.step()
    found = world.contacts()
    assert found.gap == pytest.approx([-0.02], abs=1e-12)
    assert found.point[0] == pytest.approx([0.03, 0.0, 0.04], abs=1e-12)
    assert found.normal[0] == pytest.approx([0, 0, 1], abs=1e-12)


def test_crossed_edges_of_boxes_touch_in_one_point() -> None:
    """Two cubes turned onto their edges, crossed: the edges meet 1 cm deep on the vertical axis."""
    half, lift = 0.1, 0.1 * math.sqrt(2)
    s, c = math.sin(math.pi / 8), math.cos(math.pi / 8)
    low = engine.Body(name="low", shapes=[engine.Placed(engine.Box((half,) * 3))], q_WB=(c, s, 0, 0))
    high = engine.Body(
        name="high", shapes=[engine.Placed(engine.Box((half,) * 3))], q_WB=(c, 0, s, 0), p_WB=(0, 0, 2 * lift - 0.01)
    )
    world = _world([low, high], gravity=(0, 0, 0))
    world.step()
    found = world.contacts()
    assert found.gap == pytest.approx([-0.01], abs=1e-12)
    assert found.normal[0] == pytest.approx([0, 0, 1], abs=1e-12)
    assert found.point[0] == pytest.approx([0, 0, lift - 0.005], abs=1e-12)


def test_a_cylinder_on_a_slope_rolls_down_at_two_thirds_of_the_pull() -> None:
    """a = g sin / (1 + I / (m r^2)) = 2/3 g sin for a solid cylinder; 1 mm/s of 1.1 m/s for the first sub-steps."""
    peg = engine.Body(
        name="peg",
        inertia=np.diag([0.04, 0.04, 0.005]),
        shapes=[engine.Placed(engine.Cylinder(0.1, 0.2))],
        p_WB=(0, 0, 0.1),
        q_WB=(math.sqrt(0.5), math.sqrt(0.5), 0, 0),
    )
    gravity = _incline(math.tan(math.radians(10)))
    world = _world([GROUND, peg], _rough(0.5), gravity)
    world.step(240)
    assert world.state()[1, 7] == pytest.approx(2 / 3 * gravity[0], rel=2e-3)


def test_five_elastic_balls_in_touch_keep_momentum_and_energy() -> None:
    """Bodies in touch take a blow as one; sweeps converge by cos^2(pi / 5) = .65 each, 24 of them to 3e-5."""
    balls = [_ball(name=f"b{k}", p_WB=(0.1 * k, 0, 0)) for k in range(5)]
    balls[0] = _ball(name="b0", p_WB=(-0.05, 0, 0), v_WB=(1.0, 0, 0))
    world = _world(balls, engine.Surface(restitution=1.0), (0, 0, 0))
    world.step(60)
    v = world.state()[:, 7]
    assert v.sum() == pytest.approx(1.0, abs=1e-12)
    assert (v**2).sum() == pytest.approx(1.0, abs=1e-3)
