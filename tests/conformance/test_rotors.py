"""Rotors that adapters make: the motion of an arm against its equations of motion, and what a run ends at."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Adapter, Unsupported
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.scene import WORLD, Body, Drive, Limits, PlacedShape, Plane, Revolute, Scene, Sphere, Spring, Surface
from plumbline.harness.trajectory import Floats
from tests.conformance.engines import adapter
from tests.joint_space import JointSpace

ROTORS = (0.5, 0.3, 0.2)
"""kg m2, 5 to 40 times what the links have about the last two axes."""
DURATION = 0.5
AXES = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.6, 0.8, 0.0))
DRIVES = (Drive(stiffness=40.0, damping=3.0, target=1.0), Drive(stiffness=60.0, damping=2.0, target=0.4, limit=6.0), None)


def arm(*rotors: float) -> Scene:
    """Three links of .3 m on hinges whose axes are askew: one driven, one driven up to a limit, one sprung."""
    bodies = tuple(
        Body(
            name=f"link{k}", mass=1.0 - 0.3 * k, p_WB=(0.15 + 0.3 * k, 0.02, 0.0),
            inertia=((3e-3, 0.0, 0.0), (0.0, 9e-3, 1e-3), (0.0, 1e-3, 8e-3)),
        )
        for k in range(3)
    )  # fmt: skip
    joints = tuple(
        Revolute(
            name=f"joint{k}", parent=f"link{k - 1}" if k else WORLD, child=f"link{k}", anchor_W=(0.3 * k, 0.0, 0.0),
            axis_W=AXES[k], armature=rotors[k] if rotors else None, drive=DRIVES[k],
            spring=Spring(stiffness=5.0, damping=0.2, rest=0.7) if k == 2 else None,
        )
        for k in range(3)
    )  # fmt: skip
    return Scene(bodies=bodies, joints=joints)


@cache
def truth(scene: Scene) -> Floats:
    """Where the links are at the end, (3, 3) m: (M + armature) q'' = efforts - h, by Newton and Euler and DOP853."""
    space = JointSpace(scene)

    def rate(_time: float, y: Floats) -> Floats:
        q, qd = y[:3], y[3:]
        M, h, _ = space.at(q, qd)
        d0, d1 = 40.0 * (1.0 - q[0]) - 3.0 * qd[0], 60.0 * (0.4 - q[1]) - 2.0 * qd[1]
        efforts = np.array([d0, np.clip(d1, -6.0, 6.0), 5.0 * (0.7 - q[2]) - 0.2 * qd[2]])
        return np.concatenate([qd, np.linalg.solve(M, efforts - h)])

    # The clipped drive makes one kink, which costs the tolerance alone.
    y = solve_ivp(rate, (0, DURATION), np.zeros(6), method="DOP853", rtol=1e-10, atol=1e-10, max_step=0.01).y[:, -1]
    return np.array([centre for _, centre, *_ in space.at(y[:3], y[3:])[2].values()])


def error(one: Adapter, scene: Scene, right: Floats, dt: float) -> float:
    """How far the worst link is off at the end [m]."""
    return float(np.linalg.norm(Engine(one, one.tracks["tuned"]).final(scene, DURATION, dt=dt).p_WB - right, axis=1).max())


def test_the_equations_of_motion_are_those_of_an_engine_with_rotors_of_its_own() -> None:
    # Runge-Kutta's method is of fourth order but for the kink of the clipped drive; the truth is solved to 1e-10.
    assert error(adapter("mujoco"), arm(*ROTORS), truth(arm(*ROTORS)), 1 / 1000) < 1e-7


@pytest.mark.parametrize("engine", ["bullet", "dart"])
def test_an_arm_with_rotors_moves_as_its_equations_say(engine: str) -> None:
    one, scene = adapter(engine), arm(*ROTORS)
    right, without = truth(scene), truth(arm())
    coarse, fine = (error(one, scene, right, dt) for dt in (1 / 1000, 1 / 4000))
    # First order: a quarter of the step leaves a quarter of the error, half of it at most where a second term still counts.
    assert fine < 0.5 * coarse
    # The adapters keep efforts over a step: of some 3 rad/s2 the error is a x dt T/2, a millimetre at 1/1000 s, ten times over.
    assert coarse < 1e-2
    # What leaving the rotors out would do.
    assert np.linalg.norm(without - right, axis=1).max() > 20 * coarse


@pytest.mark.parametrize("engine", ["bullet", "dart"])
@pytest.mark.parametrize("floating", [False, True])
def test_a_run_ends_where_a_stop_or_a_contact_strikes_a_tree_with_rotors(engine: str, floating: bool) -> None:
    one, scene = adapter(engine), arm(*ROTORS)
    if floating:
        scene = replace(scene, joints=scene.joints[1:])
    joints = (*scene.joints[:-1], replace(scene.joints[-1], limits=Limits(lower=-2.0, upper=0.05)))
    settings = one.tracks["tuned"].with_dt(1 / 1000)
    assert np.isfinite(Engine(one, settings).final(scene, 0.02, dt=None).p_WB).all()
    with pytest.raises(Unsupported, match=r"'joint2' at the end of its range.*--drop armature"):
        Engine(one, settings).final(replace(scene, joints=joints), DURATION, dt=None)
    ball = (PlacedShape(shape=Sphere(radius=0.05)),)
    ground = Body(name="ground", motion="static", p_WB=(0.0, 0.0, -0.06), collision=(PlacedShape(shape=Plane()),))
    bodies = (*scene.bodies[:-1], replace(scene.bodies[-1], collision=ball), ground)
    law = Surface(between=("default", "default"), static_friction=0.5, kinetic_friction=0.5)
    with pytest.raises(Unsupported, match="contact of bodies on joints with rotors"):
        Engine(one, settings).final(replace(scene, bodies=bodies, surfaces=(law,)), DURATION, dt=None)


@pytest.mark.parametrize("engine", ["bullet", "dart"])
def test_dry_friction_beside_rotors_is_refused(engine: str) -> None:
    one, scene = adapter(engine), arm(*ROTORS)
    rubbing = replace(scene, joints=(replace(scene.joints[0], friction_loss=0.1), *scene.joints[1:]))
    with pytest.raises(Unsupported, match="'joint0': friction loss beside joints with rotors"):
        one.build(rubbing, one.tracks["tuned"])
    alone = replace(rubbing, joints=tuple(replace(joint, armature=None) for joint in rubbing.joints))  # type: ignore[call-arg]
    one.build(alone, one.tracks["tuned"]).close()


@pytest.mark.parametrize(("engine", "option"), [("bullet", "motor"), ("dart", "servo")])
def test_an_engines_own_motor_beside_rotors_is_refused(engine: str, option: str) -> None:
    one = adapter(engine)
    settings = replace(one.tracks["tuned"], options={**one.tracks["tuned"].options, "drives": option})
    with pytest.raises(Unsupported, match=r"motor beside joints with rotors|own servo moves its joint by impulses"):
        one.build(arm(*ROTORS), settings)
