"""What Newton's adapter works out before Newton is asked: numbers of shapes, what a drive aims at, whose options hold."""

from dataclasses import replace

import pytest

from plumbline.adapters.newton import ADAPTER
from plumbline.adapters.newton.build import is_smooth, resolved
from plumbline.adapters.newton.joints import Aim, aim_of
from plumbline.adapters.newton.options import resolved_settings
from plumbline.adapters.newton.surfaces import numbers_of, rebounds
from plumbline.harness.adapter import Settings, SettingsError, Unsupported
from plumbline.harness.adapter.rolling import CORRECTIONS
from plumbline.harness.scene import Body, Drive, Effect, PlacedShape, Scene, Sphere, Surface, sphere_inertia
from plumbline.harness.study import plugins


def balls(laws: dict[tuple[str, str], tuple[float, float]], ground: str, *moving: str) -> Scene:
    """A ball that stands still and others that move, by their materials, with friction and restitution of pairs."""
    shape = (PlacedShape(shape=Sphere(radius=0.1)),)
    bodies = [Body(name="ground", motion="static", material=ground, collision=shape)]
    bodies += [
        Body(name=name, mass=1.0, inertia=sphere_inertia(1.0, 0.1), material=name, p_WB=(k + 1.0, 0.0, 0.0), collision=shape)
        for k, name in enumerate(moving)
    ]
    surfaces = tuple(
        Surface(between=pair, static_friction=mu, kinetic_friction=mu, restitution=e) for pair, (mu, e) in laws.items()
    )
    return Scene(bodies=tuple(bodies), surfaces=surfaces)


LAWS = {
    ("floor", "ice"): (0.1, 0.0),
    ("floor", "wood"): (0.5, 0.0),
    ("ice", "wood"): (0.5, 0.0),
    ("floor", "floor"): (0.9, 0.0),
}


def test_the_greater_of_two_numbers_is_the_law_of_each_pair_that_can_touch() -> None:
    numbers = numbers_of(balls(LAWS, "floor", "ice", "wood"), "mujoco").friction
    for pair in (("floor", "ice"), ("floor", "wood"), ("ice", "wood")):
        of = [numbers[name, name != "floor"] for name in pair]
        assert max(of) == LAWS[pair][0]


def test_a_pair_below_both_that_its_bodies_have_elsewhere_is_refused_over_mujoco() -> None:
    laws = {("floor", "ice"): (0.5, 0.0), ("floor", "wood"): (0.1, 0.0), ("ice", "wood"): (0.5, 0.0)}
    assert numbers_of(balls(laws, "floor", "ice", "wood"), "mujoco").friction["ice", True] == 0.5
    laws[("ice", "wood")] = (0.7, 0.0)
    with pytest.raises(Unsupported, match=r"kinetic friction of .*the greater of two numbers"):
        numbers_of(balls(laws, "floor", "ice", "wood"), "mujoco")


def test_the_mean_of_two_numbers_is_the_law_of_each_pair_under_xpbd() -> None:
    laws = {("floor", "ice"): (0.2, 0.3), ("floor", "wood"): (0.4, 0.5), ("ice", "wood"): (0.5, 0.6)}
    numbers = numbers_of(balls(laws, "floor", "ice", "wood"), "xpbd")
    for pair, (mu, e) in laws.items():
        kinds = [(name, name != "floor") for name in pair]
        assert sum(numbers.friction[kind] for kind in kinds) / 2 == pytest.approx(mu, abs=1e-9)
        assert sum(numbers.restitution[kind] for kind in kinds) / 2 == pytest.approx(e, abs=1e-9)


def test_a_scene_rebounds_where_a_pair_that_can_touch_does() -> None:
    assert not rebounds(balls(LAWS, "floor", "ice"))
    assert rebounds(balls({("floor", "ice"): (0.1, 0.5)}, "floor", "ice"))


def test_all_that_is_constant_in_a_drive_shifts_what_it_aims_at() -> None:
    both = Drive(stiffness=50.0, damping=4.0, target=0.2, target_velocity=0.5, feedforward=3.0)
    # 50 (.2 - x) + 4 (.5 - v) + 3 = 50 (.3 - x) - 4 v, and x counts from .1.
    assert aim_of(both, 0.2, 0.1) == Aim(position=pytest.approx(0.2))
    damped = Drive(stiffness=0.0, damping=4.0, target=0.0, target_velocity=0.5, feedforward=3.0)
    assert aim_of(damped, 0.0, 0.1) == Aim(rate=1.25)
    motor = Drive(stiffness=0.0, damping=0.0, target=0.0, feedforward=-3.0, limit=2.0)
    assert aim_of(motor, 0.0, 0.1) == Aim(push=-2.0)


def test_options_of_the_solver_that_is_not_used_are_left_out_and_its_integrator_is_not_taken() -> None:
    told = Settings(options={"cone": "elliptic", "contact_weighting": False})
    over_mujoco, xpbd = (resolved_settings(told, solver, Effect.CONTACT) for solver in ("mujoco", "xpbd"))
    assert (over_mujoco.solver, over_mujoco.integrator, over_mujoco.iterations) == ("mujoco", "implicitfast", 100)
    assert over_mujoco.options["cone"] == "elliptic"
    assert "contact_weighting" not in over_mujoco.options
    assert (xpbd.solver, xpbd.integrator, xpbd.iterations) == ("xpbd", "semi_implicit_euler", 2)
    assert xpbd.options == {"contact_relaxation": 0.8, "contact_weighting": False, "restitution_iterations": 2}
    with pytest.raises(SettingsError, match=r"integrator 'rk4', expected 'semi_implicit_euler'"):
        resolved_settings(Settings(solver="xpbd", integrator="rk4"), "mujoco", Effect.CONTACT)
    with pytest.raises(SettingsError, match=r"option 'cones'"):
        resolved_settings(Settings(options={"cones": 1}), "mujoco", Effect.CONTACT)


@pytest.mark.parametrize(
    ("case", "integrator", "corrections"),
    [
        ("flight_box", "rk4", 0),
        ("joint_chain", "rk4", 0),
        ("joint_spring", "rk4", 0),
        ("joint_limits", "euler", 0),
        ("rest_penetration", "euler", 0),
        ("friction_slip_to_roll", "euler", CORRECTIONS),  # a ball alone
        ("friction_turntable", "euler", 0),  # which is led
    ],
)
def test_a_scene_is_given_the_integrator_and_slip_correction_that_suit_it(case: str, integrator: str, corrections: int) -> None:
    scene = plugins.case(case).scene(plugins.case(case).at())
    used = resolved(scene, replace(ADAPTER.tracks["tuned"], dt=1 / 240))
    assert (used.integrator, used.options["noslip_iterations"]) == (integrator, corrections)


def test_a_spring_whose_time_a_step_does_not_resolve_is_left_to_euler() -> None:
    scene = plugins.case("joint_spring").scene(plugins.case("joint_spring").at())
    assert [is_smooth(scene, scene.joints[0], h) for h in (1 / 240, 1.0)] == [True, False]
