"""A quadruped that stands on drives of Newton's joints, and a box that slides, in newton's own words.

Why `system_worlds` fails on Newton as it comes: `implicitfast`, its integrator where none is told, takes the damping of drives
implicitly after contacts were solved without it, and feet slide. MuJoCo does the same under that integrator.
"""

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.vendor import quadruped

wp = pytest.importorskip("warp", reason="installed when it is asked for")
wp.config.enable_backward = False
newton = pytest.importorskip("newton", reason="installed when it is asked for")
pytestmark = pytest.mark.newton
G = 9.81


def matrix(moments: Any) -> Any:
    return wp.mat33(*np.diag(moments).ravel().tolist())


def run(builder: Any, own: bool, seconds: float, seen: Callable[[Any], None], **options: Any) -> None:
    """Step by 1/240 s over MuJoCo-Warp from a graph, two steps at a time. Args: own: by Newton's own collisions."""
    model = builder.finalize(device="cpu")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        solver = newton.solvers.SolverMuJoCo(model, njmax=256, nconmax=64, use_mujoco_contacts=not own, **options)
    pipeline = newton.CollisionPipeline(model) if own else None
    contacts, control = pipeline.contacts() if own else None, model.control()
    here, there = model.state(), model.state()
    for state in (here, there):
        newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    with wp.ScopedCapture(device="cpu", force_module_load=False) as capture:
        for before, after in ((here, there), (there, here)):
            if own:
                pipeline.collide(before, contacts)
            solver.step(before, after, control, contacts, 1 / 240)
    seen(here)
    for _ in range(round(120 * seconds)):
        wp.capture_launch(capture.graph)
        seen(here)


def stand(**options: Any) -> float:
    """How far [mm] any hinge or the trunk is after half a second from where statics has it."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    rough = newton.ModelBuilder.ShapeConfig(density=0.0, mu=0.8)
    slab = wp.transform((0.0, 0.0, 1e-6 - 0.5), wp.quat_identity())
    builder.add_shape_box(-1, xform=slab, hx=5.0, hy=5.0, hz=0.5, cfg=rough)
    x, y, z = (quadruped.TRUNK_MASS / 3 * half**2 for half in quadruped.TRUNK_HALF)
    links = {"": builder.add_link(mass=quadruped.TRUNK_MASS, inertia=matrix((y + z, x + z, x + y)), lock_inertia=True)}
    chain = [builder.add_joint_free(links[""])]
    builder.joint_q[:] = [0.0, 0.0, quadruped.HEIGHT, 0.0, 0.0, 0.0, 1.0]
    for hinge in quadruped.hinges():
        centre, moments = wp.vec3(*hinge.centre), matrix(hinge.inertia)
        link = links[hinge.name] = builder.add_link(mass=hinge.mass, inertia=moments, com=centre, lock_inertia=True)
        joint = builder.add_joint_revolute(
            links[hinge.above],
            link,
            parent_xform=wp.transform(hinge.at, wp.quat_identity()),
            child_xform=wp.transform_identity(),
            axis=hinge.axis,
            target_q=hinge.target,
            target_ke=quadruped.STIFFNESS,
            target_kd=quadruped.DAMPING,
            actuator_mode=newton.JointTargetMode.POSITION,
        )
        chain.append(joint)
        builder.joint_q[-1] = hinge.angle
        if hinge.foot:
            sole = wp.transform((0.0, 0.0, -quadruped.LEG), wp.quat_identity())
            builder.add_shape_sphere(link, xform=sole, radius=quadruped.FOOT, cfg=rough)
    builder.add_articulation(chain)
    places: list[Any] = []
    run(builder, False, 0.5, lambda state: places.append(state.body_q.numpy()[:, :3].copy()), **options)
    return 1e3 * float(np.linalg.norm(places[-1] - places[0], axis=1).max())


def test_implicitfast_lets_it_slide_by_centimetres_where_euler_and_discrete_hold_it() -> None:
    assert stand() > 20.0
    assert stand(integrator="euler") < 1.5
    assert stand(integrator="discrete") < 1.5


def test_no_tolerance_or_iteration_holds_it_under_implicitfast() -> None:
    for options in ({"tolerance": 1e-10}, {"iterations": 400}, {"ls_iterations": 200}, {"solver": "cg"}):
        assert stand(**options) == pytest.approx(stand(), rel=0.01)


def hop(own: bool, cone: str = "elliptic", gain: float | None = None) -> float:
    """How high [mm] a cube of 0.2 m and 1 kg gets off a plane on which it slides from 3 m/s. Args: gain: kf."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    config = newton.ModelBuilder.ShapeConfig(density=0.0, mu=0.3)
    if gain is not None:
        config.kf = gain
    builder.add_shape_plane(width=0.0, length=0.0, cfg=config)
    body = builder.add_body(mass=1.0, inertia=matrix((1 / 150,) * 3), lock_inertia=True)
    builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config)
    builder.joint_q[2], builder.joint_qd[0] = 0.1, 3.0
    heights: list[float] = []
    run(builder, own, 1.0, lambda state: heights.append(float(state.body_q.numpy()[0, 2])), cone=cone)
    assert math.isfinite(heights[-1])
    return 1e3 * (max(heights) - 0.1)


def test_the_vendor_s_gain_of_friction_makes_what_slides_hop_under_own_collisions_and_elliptic_cones_alone() -> None:
    """kf is 1000 N s/m: friction of 1 kg is held at 2 ms, half a step. Below 0 it is as soft as its contact."""
    assert newton.ModelBuilder.ShapeConfig().kf == 1000.0
    assert hop(own=True) > 30.0
    assert hop(own=False) < 8.0
    assert hop(own=True, gain=-1.0) == pytest.approx(hop(own=False), rel=1e-3)
    assert hop(own=True, gain=10.0) < 0.5
    assert hop(own=True, cone="pyramidal") == pytest.approx(hop(own=False, cone="pyramidal"), rel=1e-3)
