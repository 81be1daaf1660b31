"""Contact in Bullet: forces, rebounds, slopes, product rules, continuous collision, margins."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    ConvexHull,
    Cylinder,
    Effect,
    PlacedShape,
    Plane,
    Scene,
    Shape,
    Sphere,
    Surface,
    TriangleMesh,
    box_inertia,
    principal_inertia,
    sphere_inertia,
)

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")
from tests.conformance.bullet_scenes import (
    COORDINATES,
    DEFAULT,
    GROUND,
    MAXIMAL,
    MULTIBODY,
    NOWHERE,
    TUNED,
    G,
    ball,
    built,
    law,
    solid,
    state_of,
    with_options,
)


@COORDINATES
def test_contact_forces_of_a_resting_box_carry_its_weight_from_A_to_B(settings: Settings) -> None:
    box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1))
    for bodies, sign in (((GROUND, box), 1.0), ((box, GROUND), -1.0)):
        with built(Scene(bodies=bodies, surfaces=(law(0.5),)), replace(settings, tolerance=0.0)) as simulation:
            simulation.step(240)
            contacts = simulation.contacts()
        assert len(contacts) == 4
        assert (contacts.body_A == 0).all()
        assert contacts.normal_W[:, 2] == pytest.approx(np.full(4, sign), abs=1e-9)
        # Bullet lets contacts sink in by its slop of 1e-5 m.
        assert contacts.gap == pytest.approx(np.full(4, -1e-5), abs=2e-6)
        # After one second the solver's residual alone is left.
        assert contacts.force_W.sum(axis=0) == pytest.approx((0.0, 0.0, sign * 2.0 * G), abs=1e-4)


BARE = with_options(DEFAULT, damping="scene")
"""The default track without the vendor's damping, which is no contact force."""


@pytest.mark.parametrize("settings", [BARE, MULTIBODY, MAXIMAL], ids=["default", "multibody", "maximal"])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
@pytest.mark.parametrize("shape", ["ball", "tumbling box"])
def test_contact_forces_are_those_of_the_step_whose_momentum_they_change(shape: str, dt: float, settings: Settings) -> None:
    """Through flights, blows and rebounds: m dv = (f + m g) dt in every step, so that no force outlives its step."""
    body = solid(Sphere(radius=0.1), p_WB=(0.0, 0.0, 0.6), inertia=sphere_inertia(2.0, 0.1))
    if shape == "tumbling box":
        body = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.6), w_WB=(4.0, 3.0, 1.0), v_WB=(1.0, 0.0, 0.0))
    scene = Scene(bodies=(GROUND, body), surfaces=(law(0.5, restitution=0.5),))
    with built(scene, settings.with_dt(dt)) as simulation:
        before = state_of(simulation, scene).v_WB[1]
        for _ in range(round(1.0 / dt)):
            simulation.step()
            after = state_of(simulation, scene).v_WB[1]
            force = simulation.contacts().force_W.sum(axis=0)
            # Momentum is summed in double precision: forces of 1e4 N round at 1e-12, the change of velocity over dt at 1e-11.
            assert force == pytest.approx(2.0 * (after - before) / dt + (0.0, 0.0, 2.0 * G), abs=1e-6)
            before = after


@COORDINATES
def test_friction_forces_brake_the_sliding_body(settings: Settings) -> None:
    box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1), v_WB=(2.0, 0.0, 0.0))
    with built(Scene(bodies=(GROUND, box), surfaces=(law(0.4),)), settings.with_dt(1e-3)) as simulation:
        simulation.step(50)
        force = simulation.contacts().force_W.sum(axis=0)
    # On B, the box: against its motion with mu times its weight; 1 % for the wobble of a sliding manifold.
    assert force[0] == pytest.approx(-0.4 * 2.0 * G, rel=0.01)
    assert force[2] == pytest.approx(2.0 * G, rel=0.01)


def test_sliding_in_maximal_coordinates_stops_at_the_same_distance_in_all_directions() -> None:
    for azimuth in (0.0, math.pi / 8, math.pi / 4, math.pi / 2):
        v = (2 * math.cos(azimuth), 2 * math.sin(azimuth), 0.0)
        box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1), v_WB=v)
        scene = Scene(bodies=(GROUND, box), surfaces=(law(0.4),))
        with built(scene, MAXIMAL.with_dt(1e-3)) as simulation:
            simulation.step(1000)
            way = math.hypot(*state_of(simulation, scene).p_WB[1, :2])
        # d = v^2/(2 mu g) less v dt/2 (0.2 %); a box instead of a cone would be 29 % off at 45 degrees.
        assert way == pytest.approx(4 / (2 * 0.4 * G), rel=0.005)


@pytest.mark.parametrize("e", [0.5, 0.8])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
def test_tuned_rebounds_do_not_depend_on_the_phase_of_the_step(e: float, dt: float) -> None:
    for height in np.linspace(0.9, 1.1, 7):
        scene = Scene(bodies=(GROUND, ball(p_WB=(0.0, 0.0, 0.1 + height))), surfaces=(law(restitution=e),))
        with built(scene, TUNED.with_dt(dt)) as simulation:
            speeds = [0.0]
            while speeds[-1] <= 0.0:
                simulation.step()
                speeds.append(state_of(simulation, scene).v_WB[1, 2])
        # The impact speed is the last speed before: the product e v is formed of the velocity before that step's gravity.
        assert speeds[-1] / -speeds[-2] == pytest.approx(e, abs=1e-6)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3, 2e-5])
@pytest.mark.parametrize("e", [0.5, 1.0])
@pytest.mark.parametrize("shape", [Sphere(radius=0.1), Box(half_extents=(0.1, 0.1, 0.1))], ids=["ball", "box"])
def test_tuned_rebounds_do_not_depend_on_the_time_step(shape: Shape, e: float, dt: float) -> None:
    for phase in (0.1, 0.5, 0.9, 0.999):
        body = solid(shape, p_WB=(0.0, 0.0, 0.1 + (20 + phase) * dt), v_WB=(0.0, 0.0, -1.0))
        scene = Scene(bodies=(GROUND, body), surfaces=(law(restitution=e),), gravity=NOWHERE)
        with built(scene, TUNED.with_dt(dt)) as simulation:
            simulation.step(40)
            # The contact slop takes at most 1e-6 m/s, at any step.
            assert state_of(simulation, scene).v_WB[1, 2] == pytest.approx(e, abs=1.1e-6)


def leaning(slope: float) -> tuple[float, float, float]:
    """Gravity as on a slope [rad] towards +x."""
    return (G * math.sin(slope), 0.0, -G * math.cos(slope))


PLANE = replace(GROUND, p_WB=NOWHERE, collision=(PlacedShape(shape=Plane()),))
CUBE, CYLINDER = Box(half_extents=(0.1, 0.1, 0.1)), Cylinder(radius=0.1, half_length=0.1)
HULL = ConvexHull(vertices=tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)))


@pytest.mark.parametrize("ground", [GROUND, PLANE], ids=["on a box", "on a plane"])
@pytest.mark.parametrize("shape", [CUBE, CYLINDER, HULL], ids=["cube", "cylinder", "hull"])
@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside a bouncing ball"])
def test_what_slides_down_a_slope_on_tuned_goes_its_way(beside: bool, shape: Shape, ground: Body) -> None:
    slope = math.atan(0.55)
    body = solid(shape, p_WB=(0.0, 0.0, 0.1), inertia=box_inertia(2.0, (0.1, 0.1, 0.1)))
    bodies, surfaces = (ground, body), (law(0.5),)
    if beside:
        bouncing = replace(ball(name="ball", p_WB=(0.0, 5.0, 0.4)), material="rubber")
        pairs = {("ground", "rubber"): 0.5, ("rubber", "solid"): 0.0}
        bodies += (bouncing,)
        surfaces += tuple(law(0.5, restitution=e, pair=pair) for pair, e in pairs.items())
    scene = Scene(bodies=bodies, surfaces=surfaces, gravity=leaning(slope))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(1000)
        way = state_of(simulation, scene).p_WB[1, 0]
    # Bullet's multibodies go 1.00-1.03 of the way; friction that is 1 % off shows as 10 % here, and maximal coordinates go
    # 0.85-0.88 on the plane and with the cylinder.
    assert way == pytest.approx(G / 2 * (math.sin(slope) - 0.5 * math.cos(slope)), rel=0.03)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
@pytest.mark.parametrize("ground", [GROUND, PLANE], ids=["on a box", "on a plane"])
@pytest.mark.parametrize("shape", [CUBE, CYLINDER], ids=["cube", "cylinder"])
def test_what_friction_holds_creeps_less_than_bullets_own_residue(shape: Shape, ground: Body, dt: float) -> None:
    body = solid(shape, p_WB=(0.0, 0.0, 0.1), inertia=box_inertia(2.0, (0.1, 0.1, 0.1)))
    scene = Scene(bodies=(ground, body), surfaces=(law(0.5),))
    push = np.zeros((2, 3))
    push[1, 0] = 0.9 * 0.5 * 2.0 * G
    with built(scene, TUNED.with_dt(dt)) as simulation:
        simulation.wrench(push, np.zeros((2, 3)))
        simulation.step(round(1.5 / dt))
        # Contact slop and processing threshold both 0, right for rebounds, would let it creep 3-6 mm; a tenth of that is more
        # than twice what Bullet cannot help while its contact points gather, 0.02-0.22 mm.
        assert state_of(simulation, scene).p_WB[1, 0] < 0.55e-3


def test_a_body_that_turns_fast_beside_a_slope_does_not_explode_on_tuned() -> None:
    w = (100.0, 100.0, 100.0)
    top = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 50.0), w_WB=w, inertia=principal_inertia(0.01, 0.02, 0.025))
    scene = Scene(bodies=(PLANE, top), surfaces=(law(0.5),), gravity=(1e-3, 0.0, -1e-3))
    with built(scene, TUNED) as simulation:
        simulation.step(480)
        # An implicit gyroscopic term takes energy at such a step and gives none; an explicit one gives 1e9 times as much.
        assert np.linalg.norm(state_of(simulation, scene).w_WB[1]) < np.linalg.norm(w)


def test_products_of_numbers_give_each_pair_its_value_or_the_pair_is_named() -> None:
    boxes = (solid(Box(half_extents=(0.2, 0.2, 0.05)), p_WB=(0.0, 0.0, 0.05)), ball(name="ball", p_WB=(0.0, 0.0, 0.2)))
    a, b = boxes[0], replace(boxes[1], material="rubber")
    pairs = {("ground", "solid"): 0.3, ("ground", "rubber"): 0.9, ("rubber", "solid"): 0.6}
    scene = Scene(bodies=(GROUND, a, b), surfaces=tuple(law(mu, pair=pair) for pair, mu in pairs.items()))
    # Three unknowns, three pairs: solvable. A fourth pair of no friction asks for a zero where none may be.
    ADAPTER.build(scene, TUNED).close()
    twin = replace(a, name="twin", p_WB=(3.0, 0.0, 0.05))
    with pytest.raises(Unsupported, match=r"surface .* multiplies the friction"):
        ADAPTER.build(Scene(bodies=(*scene.bodies, twin), surfaces=(*scene.surfaces, law(0.0, pair=("solid", "solid")))), TUNED)
    sticky = Surface(between=("ground", "solid"), static_friction=0.6, kinetic_friction=0.4)
    with pytest.raises(Unsupported, match="static and kinetic"):
        ADAPTER.build(Scene(bodies=(GROUND, a), surfaces=(sticky,)), TUNED)
    with pytest.raises(Unsupported, match="clamps friction"):
        ADAPTER.build(Scene(bodies=(GROUND, a), surfaces=(law(20.0),)), TUNED)


def test_friction_that_no_product_gives_is_refused_with_the_pair() -> None:
    """Six pairs of four materials for four numbers: mu of ground and a, b, c is x_g x_i, so mu_ab mu_gc = mu_ac mu_gb."""
    names = ("a", "b", "c")
    balls = tuple(replace(ball(name=n, p_WB=(0.5 * k, 0.0, 0.1)), material=n) for k, n in enumerate(names))
    pairs = dict.fromkeys([("ground", n) for n in names], 0.5) | {("a", "b"): 0.4, ("a", "c"): 0.4, ("b", "c"): 0.4}

    def scene(**changed: float) -> Scene:
        told = pairs | {(k[0], k[1]): mu for k, mu in changed.items()}
        return Scene(bodies=(GROUND, *balls), surfaces=tuple(law(mu, pair=pair) for pair, mu in told.items()))

    ADAPTER.build(scene(), TUNED).close()
    with pytest.raises(Unsupported, match=r"surface .*: Bullet multiplies the friction of the two bodies; no numbers give"):
        ADAPTER.build(scene(ab=0.8), TUNED)


def test_rolling_and_torsional_friction_are_lengths() -> None:
    rolling = ball(p_WB=(0.0, 0.0, 0.1), v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 10.0, 0.0))
    scene = Scene(bodies=(GROUND, rolling), surfaces=(law(0.5, rolling_friction=0.005),))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(500)
        # b N = torque: v' = -(5/7) b g / r.
        assert state_of(simulation, scene).v_WB[1, 0] == pytest.approx(1 - 0.5 * 5 / 7 * 0.005 * G / 0.1, abs=1e-4)
    spinning = ball(p_WB=(0.0, 0.0, 0.1), w_WB=(0.0, 0.0, 10.0))
    scene = Scene(bodies=(GROUND, spinning), surfaces=(law(0.5, torsional_friction=0.002),))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(100)
        assert state_of(simulation, scene).w_WB[1, 2] == pytest.approx(10 - 0.1 * 0.002 * G / 0.004, abs=1e-3)


@pytest.mark.parametrize("mu", [0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
def test_torsional_and_rolling_friction_act_whichever_body_of_the_pair_bears_the_lever(mu: float) -> None:
    """The lever of a pair is shared out between two numbers, and rounding may give all of it to the ground."""
    spinning = ball(p_WB=(0.0, 0.0, 0.1), w_WB=(0.0, 0.0, 20.0))
    with built(Scene(bodies=(GROUND, spinning), surfaces=(law(mu, torsional_friction=0.002),)), TUNED.with_dt(1e-3)) as run:
        run.step(100)
        # w' = -b g/(2/5 r^2); contact is solved in each of the 100 steps.
        assert state_of(run, Scene(bodies=(GROUND, spinning), surfaces=(law(mu),))).w_WB[1, 2] == pytest.approx(
            20 - 0.1 * 0.002 * G / 0.004, abs=1e-3
        )
    rolling = ball(p_WB=(0.0, 0.0, 0.1), v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 10.0, 0.0))
    with built(Scene(bodies=(GROUND, rolling), surfaces=(law(mu, rolling_friction=0.002),)), TUNED.with_dt(1e-3)) as run:
        run.step(100)
        assert state_of(run, Scene(bodies=(GROUND, rolling), surfaces=(law(mu),))).v_WB[1, 0] == pytest.approx(
            1 - 0.1 * 5 / 7 * 0.002 * G / 0.1, abs=1e-4
        )


@pytest.mark.parametrize("mu", [0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
def test_effects_that_bullet_has_in_other_coordinates_only_are_refused_together(mu: float) -> None:
    damped = ball(p_WB=(0.0, 0.0, 0.1), linear_damping=0.1)
    scene = Scene(bodies=(GROUND, damped), surfaces=(law(mu, rolling_friction=0.005),))
    with pytest.raises(Unsupported, match="damping with rolling"):
        ADAPTER.build(scene, TUNED)
    swinging = Body(name="bob", p_WB=(1.0, 0.0, 0.0), angular_damping=0.1)
    with pytest.raises(Unsupported, match="damping of body 'bob'"):
        ADAPTER.build(Scene(bodies=(swinging,), joints=(Ball(name="j", parent=WORLD, child="bob", anchor_W=NOWHERE),)), TUNED)


@COORDINATES
def test_fast_bodies_stay_fast_on_tuned(settings: Settings) -> None:
    scene = Scene(bodies=(Body(name="body", v_WB=(200.0, 0.0, 0.0), w_WB=(0.0, 0.0, 500.0)),), gravity=NOWHERE)
    with built(scene, settings) as simulation:
        simulation.step(240)
        got = state_of(simulation, scene)
    assert got.v_WB[0, 0] == pytest.approx(200.0, rel=1e-9)
    assert got.p_WB[0, 0] == pytest.approx(200.0, rel=1e-9)
    assert got.w_WB[0, 2] == pytest.approx(500.0, rel=1e-9)


@pytest.mark.parametrize("speed", [10.0, 500.0])
def test_continuous_collision_stops_a_ball_at_a_thin_wall_in_every_phase(speed: float) -> None:
    wall = replace(GROUND, p_WB=NOWHERE, collision=(PlacedShape(shape=Box(half_extents=(0.005, 1.0, 1.0))),))
    for phase in np.linspace(0.0, 1.0, 8, endpoint=False):
        bullet = ball(0.05, p_WB=(-1.0 - phase * speed / 240, 0.0, 0.0), v_WB=(speed, 0.0, 0.0))
        scene = Scene(bodies=(bullet, wall), surfaces=(law(),), gravity=NOWHERE, widen=Effect.CONTINUOUS_COLLISION)
        with built(scene, TUNED) as simulation:
            simulation.step(60 + int(480 / speed))
            assert state_of(simulation, scene).p_WB[0, 0] < -0.02


@pytest.mark.parametrize("static", [True, False], ids=["on a mesh", "as a hull"])
def test_hulls_and_meshes_have_no_margin_on_tuned(static: bool) -> None:
    corners = tuple((x, y, z) for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.1, 0.1))
    square = ((-5.0, -5.0, 0.0), (5.0, -5.0, 0.0), (5.0, 5.0, 0.0), (-5.0, 5.0, 0.0))
    mesh = PlacedShape(shape=TriangleMesh(vertices=square, faces=((0, 1, 2), (0, 2, 3))))
    ground = replace(GROUND, p_WB=NOWHERE, collision=(mesh,)) if static else GROUND
    body = solid(Box(half_extents=(0.2, 0.15, 0.1)) if static else ConvexHull(vertices=corners), p_WB=(0.3, 0.0, 0.1))
    scene = Scene(bodies=(ground, body), surfaces=(law(0.5),))
    with built(scene, TUNED) as simulation:
        simulation.step(480)
        height = state_of(simulation, scene).p_WB[1, 2]
    # The slop of 1e-5 m is left; the vendor's margin is 1e-3 m.
    assert height == pytest.approx(0.1, abs=5e-5)
