"""Bad input is refused with element, field and value; a run that diverges says in which step."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from plumbline import engine

P = engine.Placed
BALL = P(engine.Sphere(0.1))
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
NAN, INF = math.nan, math.inf


def _joint(kind: type, **values: object) -> Callable[[], object]:
    return lambda: kind(**({"name": "j", "parent": "world", "child": "b", "anchor_W": (0, 0, 0)} | values))


def _body(**values: object) -> Callable[[], object]:
    return lambda: engine.Body(name="bob", **values)  # type: ignore[arg-type]


def _options(**values: object) -> Callable[[], object]:
    return lambda: engine.Options(**values)  # type: ignore[arg-type]


def _world(*bodies: engine.Body, **values: object) -> Callable[[], object]:
    return lambda: engine.World(bodies or [engine.Body(name="b")], **values)  # type: ignore[arg-type]


def _mesh(vertices: object, faces: object) -> Callable[[], object]:
    return lambda: engine.TriangleMesh(vertices, faces)  # type: ignore[arg-type]


def _drive(name: str, **values: object) -> engine.Revolute:
    drive = engine.Drive(**values)  # type: ignore[arg-type]
    return engine.Revolute(name=name, parent="world", child="b", anchor_W=(0, 0, 0), axis_W=(0, 0, 1), drive=drive)


TRIANGLES = [(0, 1, 2), (0, 1, 3)]
SLIVER = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 1e-14, 0.0)]
TIED = engine.Ball(name="j", parent="world", child="b", anchor_W=(0, 0, 0))
BAD: list[tuple[Callable[[], object], str]] = [
    (_body(mass=0.0), "body 'bob': mass 0.0 kg"),
    (_body(mass=-1.0), "body 'bob': mass -1.0 kg"),
    (_body(mass=NAN), "body 'bob': mass nan kg"),
    (_body(mass=INF), "body 'bob': mass inf kg"),
    (_body(mass="heavy"), "body 'bob': mass 'heavy', expected a number"),
    (_body(inertia=np.zeros((3, 3))), "body 'bob': inertia with principal moments (0, 0, 0) kg m2 is not positive definite"),
    (_body(inertia=np.diag([1.0, 1.0, -1.0])), "body 'bob': inertia with principal moments (-1, 1, 1)"),
    (_body(inertia=np.diag([1.0, 1.0, 3.0])), "body 'bob': inertia (1, 1, 3) kg m2 breaks the triangle inequality"),
    (_body(inertia=np.diag([1.0, 1.0, NAN])), "body 'bob': inertia [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, nan]]"),
    (_body(inertia=(1.0, 1.0, 1.0)), "body 'bob': inertia has shape (3,), expected (3, 3)"),
    (_body(p_WB=(0, INF, 0)), "body 'bob': p_WB [0.0, inf, 0.0] m"),
    (_body(p_WB="here"), "body 'bob': p_WB 'here', expected numbers of shape (3,)"),
    (_body(v_WB=(0, NAN, 0)), "body 'bob': v_WB [0.0, nan, 0.0] m/s"),
    (_body(w_WB=(-INF, 0, 0)), "body 'bob': w_WB [-inf, 0.0, 0.0] rad/s"),
    (_body(q_WB=(0, 0, 0, 0)), "body 'bob': q_WB [0.0, 0.0, 0.0, 0.0] has no direction"),
    (_body(q_WB=(1, NAN, 0, 0)), "body 'bob': q_WB [1.0, nan, 0.0, 0.0]"),
    (_body(linear_damping=NAN), "body 'bob': linear_damping nan 1/s"),
    (_body(angular_damping=-2.0), "body 'bob': angular_damping -2.0 1/s"),
    (_body(motion="asleep"), "body 'bob': motion 'asleep'"),
    (_body(motion="static", v_WB=(1, 0, 0)), "body 'bob': static, but v_WB (1, 0, 0)"),
    (_body(shapes=[engine.Sphere(0.1)]), "body 'bob': shape 0 is Sphere(radius=0.1), expected a Placed"),
    (lambda: engine.Body(name=""), "body: name '', expected words"),
    (lambda: engine.Sphere(0.0), "sphere: radius 0.0 m"),
    (lambda: engine.Sphere(NAN), "sphere: radius nan m"),
    (lambda: engine.Box((1.0, -1.0, 1.0)), "box: half_extents -1.0 m"),
    (lambda: engine.Box((1.0, 1.0)), "box: half_extents has shape (2,)"),
    (lambda: engine.Capsule(0.1, 0.0), "capsule: half_length 0.0 m"),
    (lambda: engine.Cylinder(INF, 1.0), "cylinder: radius inf m"),
    (lambda: engine.Plane((0, 0, 0)), "plane: normal (0, 0, 0), expected a direction"),
    (lambda: engine.ConvexHull([(0, 0, NAN), *CORNERS]), "convex hull: vertices"),
    (lambda: engine.ConvexHull(CORNERS[:3]), "convex hull: 3 vertices, expected at least 4"),
    (_world(engine.Body(name="b", shapes=[P(engine.ConvexHull([*CORNERS[:3], (1, 1, 0)]))])), "body 'b': convex hull"),
    (_mesh([*CORNERS[:3], (0, 0, INF)], TRIANGLES), "triangle mesh: vertices"),
    (_mesh(CORNERS, [(0, 1, 4)]), "triangle mesh: faces name vertices 0 to 4, expected 0 to 3"),
    (_mesh(CORNERS, [(0, 1, -1)]), "triangle mesh: faces name vertices -1 to 1"),
    (_mesh(CORNERS, []), "triangle mesh: faces have shape"),
    (_mesh(CORNERS, [(0, 1, 2), (0, 1, 1)]), "triangle mesh: face 1 of vertices [0, 1, 1] has no area"),
    (_mesh(SLIVER, [(0, 1, 2)]), "triangle mesh: face 0 of vertices [0, 1, 2] has no area"),
    (lambda: P("ball"), "placed shape: shape 'ball', expected one of Sphere, Box"),  # type: ignore[arg-type]
    (lambda: P(engine.Sphere(1), p_BS=(0, NAN, 0)), "placed shape: p_BS"),
    (lambda: P(engine.Sphere(1), q_BS=(0, 0, 0, 0)), "placed shape: q_BS [0.0, 0.0, 0.0, 0.0] has no direction"),
    (lambda: engine.Surface(static_friction=NAN), "surface: static_friction nan"),
    (lambda: engine.Surface(kinetic_friction=0.5), "surface: static_friction 0.0 lies below kinetic_friction 0.5"),
    (lambda: engine.Surface(restitution=1.1), "surface: restitution 1.1"),
    (lambda: engine.Limits(lower=1.0, upper=0.0), "limits: lower 1.0, upper 0.0"),
    (lambda: engine.Limits(lower=NAN), "limits: lower nan"),
    (lambda: engine.Limits(lower=INF), "limits: lower inf"),
    (lambda: engine.Spring(stiffness=-1.0), "spring: stiffness -1.0"),
    (lambda: engine.Drive(damping=NAN), "drive: damping nan"),
    (lambda: engine.Drive(limit=NAN), "drive: limit nan"),
    (lambda: engine.Drive(target=INF), "drive: target inf"),
    (_joint(engine.Ball, anchor_W=(0, NAN, 0)), "joint 'j': anchor_W [0.0, nan, 0.0]"),
    (_joint(engine.Revolute, axis_W=(0, 0, 0)), "joint 'j': axis_W (0, 0, 0), expected a direction"),
    (_joint(engine.Revolute, axis_W=(0, 0, 1), position=NAN), "joint 'j': position nan rad or m"),
    (_joint(engine.Prismatic, axis_W=(0, INF, 1)), "joint 'j': axis_W [0.0, inf, 1.0]"),
    (_joint(engine.Distance, child_anchor_W=(0, 0, 0)), "joint 'j': both anchors lie at [0.0, 0.0, 0.0] m"),
    (_options(dt=0.0), "options: dt 0.0 s"),
    (_options(dt=-1.0), "options: dt -1.0 s"),
    (_options(dt=NAN), "options: dt nan s"),
    (_options(substeps=0), "options: substeps 0"),
    (_options(substeps=2.5), "options: substeps 2.5, expected a whole number of at least 1"),
    (_options(relaxations=-1), "options: relaxations -1"),
    (_options(margin=NAN), "options: margin nan m"),
    (_options(contact_hertz=0.0), "options: contact_hertz 0.0 Hz"),
    (_options(bounce_speed=-1.0), "options: bounce_speed -1.0 m/s"),
    (_options(tolerance=0.0), "options: tolerance 0.0"),
    (_options(solver="magic"), "options: solver 'magic'"),
    (_options(continuous="always"), "options: continuous 'always'"),
    (_world(engine.Body(name="b"), engine.Body(name="b")), "body 'b': the name is taken"),
    (_world(engine.Body(name="world")), "body 'world': the name is taken"),
    (_world(joints=[TIED, TIED]), "joint 'j': the name is taken"),
    (_world(engine.Body(name="c"), joints=[TIED]), "joint 'j': child 'b' is no body, expected one of c, world"),
    (_world(engine.Body(name="b", motion="static"), joints=[TIED]), "joint 'j': neither 'world' nor 'b' is dynamic"),
    (_world(gravity=(0, 0, NAN)), "world: gravity [0.0, 0.0, nan] m/s2"),
    (_world(surfaces={"ab": engine.Surface()}), "world: surfaces names 'ab', expected a pair of materials"),
    (_world(apart=["ab"]), "world: apart names 'ab', expected a pair of materials"),
    (
        _world(surfaces={("a", "b"): engine.Surface(), ("b", "a"): engine.Surface(restitution=0.5)}),
        "world: surfaces give ('a', 'b') and ('b', 'a') different laws",
    ),
    (_world(engine.Body(shapes=[P(engine.Plane())])), "body 'body': a plane is endless"),
]


@pytest.mark.parametrize(("make", "words"), BAD, ids=[words for _, words in BAD])
def test_bad_input_is_refused_with_element_field_and_value(make: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        make()


ASKED: list[tuple[Callable[[engine.World], object], str]] = [
    (lambda w: w.set_load([[0, 0, 0], [0, NAN, 0]], np.zeros((2, 3))), "body 'b': f_B_W [0.0, nan, 0.0] N is not finite"),
    (lambda w: w.set_load(np.zeros((2, 3)), [[INF, 0, 0], [0, 0, 0]]), "body 'a': tau_B_W [inf, 0.0, 0.0] N m is not finite"),
    (lambda w: w.set_load(np.zeros((3, 3)), np.zeros((2, 3))), "world: f_B_W has shape (3, 3), expected (2, 3)"),
    (lambda w: w.add_force(0, (NAN, 0, 0), (0, 0, 0)), "world: f_W [nan, 0.0, 0.0] N"),
    (lambda w: w.add_force(-1, (1, 0, 0), (0, 0, 0)), "world: body -1, expected a whole number of at least 0"),
    (lambda w: w.add_force(2, (1, 0, 0), (0, 0, 0)), "world: body 2, expected at most 1"),
    (lambda w: w.command("motor", NAN), "joint 'motor': target nan rad or m"),
    (lambda w: w.command("nobody", 1.0), "joint 'nobody': has no drive to command"),
    (lambda w: w.step(-1), "world: step count -1"),
    (lambda w: w.step(1.5), "world: step count 1.5"),  # type: ignore[arg-type]
    (lambda w: w.cast([[0, 0, 0]], [[0, 0, 0]]), "rays: direction 0 has length 0"),
    (lambda w: w.cast([[0, 0, NAN]], [[0, 0, 1]]), "rays: origins [[0.0, 0.0, nan]] m"),
    (lambda w: w.cast([[0, 0, 0]], [[0, 0, 1]], NAN), "rays: max_range nan m"),
    (lambda w: w.restore(engine.World([engine.Body(name="a")]).save()), "world: saved state of [1, 0, 0]"),
]


@pytest.mark.parametrize(("ask", "words"), ASKED, ids=[words for _, words in ASKED])
def test_what_is_asked_of_a_world_is_checked_before_anything_changes(ask: Callable[[engine.World], object], words: str) -> None:
    world = engine.World([engine.Body(name="a"), engine.Body(name="b")], [_drive("motor", stiffness=1.0)])
    before = [table.tobytes() for table in world.save()]
    with pytest.raises(ValueError, match=re.escape(words)):
        ask(world)
    assert [table.tobytes() for table in world.save()] == before


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4", "velocity_verlet", "implicit_midpoint", "splitting_4"])
def test_a_load_that_overflows_is_reported_at_the_step_where_it_does(integrator: str) -> None:
    """v = k dt f with f = 1e308 m/s2 leaves float64, 1.797e308, in step 432 = ceil(1.797 x 240); p = v t / 2 would in 456."""
    body = engine.Body(name="b", inertia=np.eye(3))
    world = engine.World([body], gravity=(0, 0, 0), options=engine.Options(integrator=integrator))
    world.set_load([[1e308, 0, 0]], np.zeros((1, 3)))
    with pytest.raises(engine.Diverged) as caught:
        world.step(1000)
    assert caught.value.step == world.steps == 432


def _run_until_it_diverges(world: engine.World, stride: int) -> int:
    """The step that is reported, in runs of `stride` steps, of which each but the last leaves a finite state."""
    for _ in range(1000):
        try:
            world.step(stride)
        except engine.Diverged as error:
            return error.step
        assert np.isfinite(world.state()).all()
    raise AssertionError("it never diverges")


SOLVERS = [("exact", "off"), *((solver, sweep) for solver in ("tgs_soft", "sequential_impulses") for sweep in ("off", "swept"))]


@pytest.mark.parametrize(("solver", "continuous"), SOLVERS)
def test_a_world_in_contact_that_diverges_says_in_which_step(solver: str, continuous: str) -> None:
    """A load far beyond all bounds on a resting ball: the step named is that after which the state is not finite, and the one
    before it is, whether they are done at once or one by one. In steps of 1/4 s that is so after some seven.
    """
    ground = engine.Body(name="ground", motion="static", shapes=[P(engine.Plane())])
    # One sub-step: the exact solver works for seconds on a contact whose velocity squared is no number.
    options = engine.Options(dt=1 / 4, solver=solver, continuous=continuous, substeps=1 if solver == "exact" else 4)
    found = []
    for stride in (1000, 1):
        ball = engine.Body(name="ball", shapes=[BALL], p_WB=(0, 0, 0.1))
        world = engine.World([ground, ball], options=options)
        world.step(3)
        world.set_load([[0, 0, 0], [0, 0, 1e308]], np.zeros((2, 3)))
        found.append(_run_until_it_diverges(world, stride))
        assert not np.isfinite(world.state()).all()
        assert found[-1] == world.steps > 3
    assert found[0] == found[1]
