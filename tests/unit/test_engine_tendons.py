"""Fixed tendons in the engine: against the scheme written out, against a joint's own laws, and where bounds meet."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine import Body, Drive, Limits, NotSupported, Options, Prismatic, Revolute, Spring, Tendon, World
from plumbline.engine.maths.types import Floats

MASSES = np.diag([2.0, 3.0, 0.3])
ARMS = np.array([1.0, -2.0, 0.5])
NAMES = ("first", "second", "wheel")
EULER = Options(dt=0.01, integrator="semi_implicit_euler")


def three(start: tuple[float, float, float], gravity: float = 0.0, first: Limits | None = None, **laws: Any) -> World:
    """Two slides along x and a wheel about y that one tendon is on."""
    bodies = [
        Body(name=name, mass=mass, inertia=0.3 * np.eye(3), p_WB=(0.0, 3.0 * k, 0.0))
        for k, (name, mass) in enumerate(zip(NAMES, (2.0, 3.0, 1.0), strict=True))
    ]
    slide, other = (
        Prismatic(name=b.name, parent="world", child=b.name, anchor_W=b.p_WB, axis_W=(1, 0, 0), position=x)
        for b, x in zip(bodies[:2], start[:2], strict=True)
    )
    wheel = Revolute(name="wheel", parent="world", child="wheel", anchor_W=(0, 6, 0), axis_W=(0, 1, 0), position=start[2])
    tendon = Tendon(name="tendon", arms=dict(zip(NAMES, ARMS, strict=True)), **laws)
    joints: list[engine.Joint] = [replace(slide, limits=first), other, wheel]
    return World(bodies, [*joints, tendon], gravity=(gravity, 0.0, 0.0), options=EULER)


def coordinates(world: World) -> Floats:
    return np.array([world.joint_motion(name)[0] for name in NAMES])


def test_a_spring_of_a_tendon_is_taken_as_implicitly_as_one_of_a_joint() -> None:
    """(M + h (c + h k) a a^T) v = M v - h k (a x - r) a, x <- x + h v, to rounding, at rates far above 1/h too."""
    for k, c, rest in ((4.0, 0.6, 0.5), (1e6, 10.0, 0.0)):
        world = three((0.2, -0.3, 0.4), spring=Spring(stiffness=k, damping=c, rest=rest))
        world.step(40)
        x, v, h = np.array([0.2, -0.3, 0.4]), np.zeros(3), EULER.dt / world.substeps
        for _ in range(40 * world.substeps):
            v = np.linalg.solve(MASSES + h * (c + h * k) * np.outer(ARMS, ARMS), MASSES @ v - h * k * (ARMS @ x - rest) * ARMS)
            x = x + h * v
        np.testing.assert_allclose(coordinates(world), x, rtol=0, atol=1e-12)


def test_a_bound_holds_and_its_force_is_shared_by_the_arms() -> None:
    """Slides fall along x, the length shrinks by g t^2/2 to its bound, and M x'' = M g + f a with a x'' = 0 from there on."""
    world = three((0.0, 0.0, 0.0), gravity=1.0, limits=Limits(lower=-0.1))
    world.step(200)
    assert ARMS @ coordinates(world) == pytest.approx(-0.1, abs=1e-12)
    pull, back = np.array([1.0, 1.0, 0.0]), np.linalg.solve(MASSES, ARMS)
    meets = np.sqrt(0.2)
    after = 2.0 - meets
    speed = pull * meets + back * meets / (ARMS @ back)
    expected = pull * meets**2 / 2 + speed * after + (pull + back / (ARMS @ back)) * after**2 / 2
    # Euler's scheme is off by half a step of motion, at up to 3 m/s.
    np.testing.assert_allclose(coordinates(world), expected, rtol=0, atol=0.5 * EULER.dt / world.substeps * 3.0)


def test_a_drive_is_cut_off_at_its_limit() -> None:
    world = three((0.0, 0.0, 0.0), drive=Drive(stiffness=50.0, target=5.0, limit=0.4))
    world.step(50)
    h = EULER.dt / world.substeps
    np.testing.assert_allclose(coordinates(world), np.linalg.solve(MASSES, ARMS) * 0.4 * 0.5 * (0.5 + h) / 2, rtol=1e-12)


def test_a_joint_at_its_own_bound_takes_what_a_tendon_pulls_it_with() -> None:
    """A slide that is pulled against its stop stays there and the others move as if it were fixed; pulled away, it leaves."""
    stop = Limits(upper=0.0)
    world = three((0.0, 0.0, 0.0), first=stop, drive=Drive(damping=1e-6, target_velocity=1e6))
    world.step(50)
    h, (x, y, turned) = EULER.dt / world.substeps, coordinates(world)
    assert x == pytest.approx(0.0, abs=1e-15)
    assert (y, turned) == pytest.approx(np.array([-2.0 / 3.0, 0.5 / 0.3]) * 0.5 * (0.5 + h) / 2, rel=1e-5)
    away = three((0.0, 0.0, 0.0), first=stop, drive=Drive(damping=1e-6, target_velocity=-1e6))
    away.step(50)
    assert coordinates(away) == pytest.approx(-np.linalg.solve(MASSES, ARMS) * 0.5 * (0.5 + h) / 2, rel=1e-5)


def arm(
    tendon: Mapping[str, float], options: Options, ground: float | None, follows: float | None = None, **laws: Any
) -> World:
    """Two rods of a pendulum with a law on the second joint: its own where there is no tendon; else that of the tendon."""
    rods = [
        Body(
            name=name,
            inertia=np.diag([0.02, 0.03, 0.01]),
            p_WB=(0.25 + 0.5 * k, 0.0, 0.0),
            shapes=[engine.Placed(shape=engine.Sphere(radius=0.1))],
        )
        for k, name in enumerate(("upper", "lower"))
    ]
    joints = [
        Revolute(name="shoulder", parent="world", child="upper", anchor_W=(0, 0, 0), axis_W=(0, 1, 0)),
        Revolute(name="elbow", parent="upper", child="lower", anchor_W=(0.5, 0, 0), axis_W=(0, 1, 0)),
    ]
    if follows is not None:
        joints[1] = replace(joints[1], coupling=engine.Coupling(joint="shoulder", ratio=follows))
    tendons = [Tendon(name="tendon", arms=tendon, **laws)] if tendon else []
    if not tendon:
        joints[1] = replace(joints[1], **laws)
    floor = (
        []
        if ground is None
        else [Body(name="floor", motion="static", shapes=[engine.Placed(shape=engine.Plane())], p_WB=(0, 0, ground))]
    )
    return World([*rods, *floor], [*joints, *tendons], options=options)


LAWS: list[dict[str, Any]] = [
    {"spring": Spring(stiffness=3.0, damping=0.2, rest=0.3)},
    {"limits": Limits(lower=-0.2, upper=0.4)},
    {"drive": Drive(stiffness=8.0, damping=0.1, target=0.5, limit=1.0), "spring": Spring(damping=0.1)},
    {"drive": Drive(stiffness=8.0, target=1.0, limit=2.0), "limits": Limits(upper=0.3)},
]


@pytest.mark.parametrize("ground", [None, -0.4])
@pytest.mark.parametrize("laws", LAWS)
def test_a_tendon_on_one_joint_is_that_joints_own_law(laws: dict[str, Any], ground: float | None) -> None:
    """Two ways through the solver, a column's own law and a row beside the tree, free and against the ground."""
    options = replace(EULER, coordinates="joint", step_tolerance=1e-12)
    own, pulled = arm({}, options, ground, **laws), arm({"elbow": 1.0}, options, ground, **laws)
    for world in (own, pulled):
        world.step(60)
    for joint in ("shoulder", "elbow"):
        assert pulled.joint_motion(joint) == pytest.approx(own.joint_motion(joint), abs=1e-8)
    touched = bool(len(pulled.contacts().gap))
    assert touched == (ground is not None)


def test_a_tendon_over_joints_of_which_one_follows_the_other_is_one_on_the_leader() -> None:
    laws = {"spring": Spring(stiffness=3.0, damping=0.2, rest=0.3), "limits": Limits(lower=-0.3, upper=0.9)}
    both = arm({"shoulder": 1.0, "elbow": 2.0}, EULER, None, follows=0.5, **laws)
    one = arm({"shoulder": 2.0}, EULER, None, follows=0.5, **laws)
    for world in (both, one):
        world.step(60)
    assert both.joint_motion("elbow") == pytest.approx(one.joint_motion("elbow"), abs=1e-10)
    assert both.joint_motion("elbow")[0] == pytest.approx(0.5 * both.joint_motion("shoulder")[0], abs=1e-14)


def test_what_a_tendon_cannot_be_is_refused_by_name() -> None:
    with pytest.raises(NotSupported, match="semi_implicit_euler alone knows tendons"):
        arm({"elbow": 1.0}, replace(EULER, integrator="rk4"), None)
    with pytest.raises(ValueError, match="tendon 'tendon': 'knee' is no joint with one coordinate"):
        arm({"knee": 1.0}, EULER, None)
    with pytest.raises(ValueError, match=r"arm of 'elbow' 0\.0, expected another than 0"):
        arm({"elbow": 0.0}, EULER, None)
    with pytest.raises(ValueError, match="no arms"):
        Tendon(name="idle", arms={})


def test_a_saved_state_with_a_tendon_goes_on_to_the_bit() -> None:
    world = arm({"shoulder": 1.0, "elbow": -1.0}, EULER, -0.4, spring=Spring(stiffness=3.0), limits=Limits(upper=0.2))
    world.step(20)
    saved = world.save()
    world.step(20)
    state = world.state().copy()
    world.restore(saved)
    world.step(20)
    np.testing.assert_array_equal(world.state(), state)
