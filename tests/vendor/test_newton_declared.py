"""What Newton's adapter declares of contacts, joints and materials, in newton's own words."""

import inspect
from typing import Any

import pytest

from tests.vendor.test_newton import G, mujoco, newton, run, wp

pytestmark = pytest.mark.newton


def on_a_cylinder(**options: Any) -> tuple[float, float]:
    """How deep [m] a box of 0.2 m is in the flat end of a cylinder after 2 s, and how far [1] it has turned."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0)
    below = wp.transform((0.0, 0.0, -0.5), wp.quat_identity())
    builder.add_shape_cylinder(-1, xform=below, radius=1.0, half_height=0.5, cfg=config)
    body = builder.add_body(
        xform=wp.transform((0.0, 0.0, 0.1), wp.quat_identity()),
        mass=1.0,
        inertia=wp.mat33(1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150),
        lock_inertia=True,
    )
    builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config)
    model = builder.finalize(device="cpu")
    pose = run(model, mujoco(model, **options), 480, 1 / 240)[0][0]
    return 0.1 - float(pose[2]), 1.0 - abs(float(pose[6]))


def test_a_box_on_a_cylinder_has_one_point_as_it_comes_and_several_if_enable_multiccd_is_told() -> None:
    deep, turned = on_a_cylinder()
    assert deep > 3e-3
    assert turned > 1e-4
    deep, turned = on_a_cylinder(enable_multiccd=True)
    assert deep < 2e-4
    assert turned < 1e-6


SHAPE = set(newton.ModelBuilder.ShapeConfig.__dataclass_fields__)
BUILDER = {name for name in dir(newton.ModelBuilder) if name.startswith("add_")}


def test_what_a_shape_and_a_builder_have_words_for() -> None:
    """Rolling and torsional friction, mimics, tendons and distances among them, which the adapter does not tell yet."""
    assert {"mu", "mu_rolling", "mu_torsional", "restitution"} <= SHAPE
    assert {"add_constraint_mimic", "add_tendon", "add_joint_distance", "add_spring"} <= BUILDER
    assert "not supported" in str(newton.solvers.SolverMuJoCo.__doc__).split("DISTANCE")[1][:40]


@pytest.mark.parametrize("word", ["static", "kinetic", "pair_friction", "gyro", "ccd", "continuous"])
def test_no_shape_builder_or_rigid_solver_has_such_a_word(word: str) -> None:
    """But `ccd_iterations`, of MuJoCo's distances, and `include_static_kinematic_pairs`, of who meets whom."""
    known = {"ccd_iterations", "ccd_tolerance", "enable_multiccd", "include_static_kinematic_pairs"}
    calls = (newton.solvers.SolverMuJoCo, newton.solvers.SolverXPBD, newton.CollisionPipeline)
    names = SHAPE | BUILDER | {name for call in calls for name in inspect.signature(call.__init__).parameters}
    assert not [name for name in names - known if word in name.lower()]


def test_speculative_contacts_are_told_to_be_no_continuous_collision() -> None:
    text = " ".join(str(newton.solvers.SolverMuJoCo.__init__.__doc__).split())
    assert "mitigates tunneling; it is not continuous collision detection" in text
