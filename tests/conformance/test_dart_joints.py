"""Joints in DART: reduced coordinates, constraints, and loops that are cut."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Fixed,
    Joint,
    Prismatic,
    Revolute,
    Scene,
    Vector3,
    axis_angle,
    multiply,
    principal_inertia,
)
from plumbline.harness.trajectory import State

pytest.importorskip("dartpy", reason="DART is not installed")

from plumbline.adapters.dart import ADAPTER
from plumbline.cases import joint_conical_pendulum, spin_heavy_top
from tests.conformance.dart_scenes import TUNED, G, free_body, state_after, state_of, with_options
from tests.conformance.put import put


def _four_bar(q: tuple[float, float, float, float], base: Vector3, cut: str = "revolute") -> Scene:
    """A four-bar linkage in its plane x-z, turned by q and moved to base, its bodies turned once more in their own way."""
    R = rotation(q)

    def at(point: Vector3) -> Vector3:
        x, y, z = (float(c) for c in R @ np.array(point) + np.array(base))
        return x, y, z

    def bar(name: str, p: Vector3, turn: tuple[float, float, float, float]) -> Body:
        return Body(name=name, inertia=principal_inertia(0.1, 0.12, 0.15), p_WB=at(p), q_WB=multiply(q, turn))

    bars = (
        bar("left", (0.0, 0.0, 0.5), (1.0, 0.0, 0.0, 0.0)),
        bar("top", (0.65, 0.0, 1.0), axis_angle((1.0, 2.0, 3.0), 0.7)),
        bar("right", (1.25, 0.0, 0.5), axis_angle((1.0, -2.0, 0.5), 1.7)),
    )
    pins = (
        (WORLD, "left", (0.0, 0.0, 0.0)),
        ("left", "top", (0.0, 0.0, 1.0)),
        ("top", "right", (1.3, 0.0, 1.0)),
        (WORLD, "right", (1.2, 0.0, 0.0)),
    )
    joints: list[Joint] = []
    for a, b, p in pins:
        if cut == "ball" and a == "top":
            joints.append(Ball(name=f"{a}-{b}", parent=a, child=b, anchor_W=at(p)))
        else:
            joints.append(Revolute(name=f"{a}-{b}", parent=a, child=b, anchor_W=at(p), axis_W=tuple(R @ (0.0, 1.0, 0.0))))
    return Scene(bodies=bars, joints=tuple(joints), gravity=tuple(R @ (3.0, 0.0, -G)))


@pytest.mark.parametrize("cut", ["revolute", "ball"])
def test_a_four_bar_linkage_closes_its_loop_the_same_in_every_frame(cut: str) -> None:
    upright = state_after(_four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), cut), 1.0)
    q, base = axis_angle((1.0, 2.0, 3.0), 1.1), (1.0, 2.0, 3.0)
    turned = state_after(_four_bar(q, base, cut), 1.0)
    back = (turned.p_WB - np.array(base)) @ rotation(q)
    # The same equations in another frame: rounding alone, grown for a thousand steps.
    np.testing.assert_allclose(back, upright.p_WB, atol=1e-8)
    assert np.abs(upright.v_WB).max() > 0.1


@pytest.mark.parametrize("share", [0.01, 0.2])
def test_the_gap_of_a_cut_joint_shrinks_with_the_square_of_the_time_step(share: float) -> None:
    """Each step adds a dt^2/2 and heals a share: a dt^2/(2 share) is left."""

    def gap(dt: float) -> float:
        end = state_after(_four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 1.0, with_options(dt, error_reduction=share))
        return abs(float(np.linalg.norm(end.p_WB[2] - (1.2, 0.0, 0.0)) - np.hypot(0.05, 0.5)))

    coarse, fine = gap(1e-3), gap(5e-4)
    # The bars swing at some g, a few of them at the turning points: 60 m/s2.
    assert coarse < 60 * 1e-6 / (2 * share)
    assert fine < coarse / 3


def test_an_error_reduction_belongs_to_its_world_though_dart_has_one_for_all() -> None:
    import dartpy

    constraint = dartpy.constraint.DynamicJointConstraint
    usual = constraint.getErrorReductionParameter()
    scene = _four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    shares = (0.01, 0.2, 0.5)
    alone = [state_after(scene, 0.5, with_options(error_reduction=share)) for share in shares]
    worlds = [ADAPTER.build(scene, with_options(error_reduction=share)) for share in shares]
    for _ in range(500):
        for world in worlds:
            world.step()
    for world, share, wanted in zip(worlds, shares, alone, strict=True):
        assert world.resolved.options["error_reduction"] == share
        assert (state_of(world, scene).p_WB == wanted.p_WB).all()
    assert (alone[0].p_WB != alone[1].p_WB).any()
    assert constraint.getErrorReductionParameter() == usual
    assert ADAPTER.build(scene, Settings()).resolved.options["error_reduction"] == usual


@pytest.mark.parametrize("spin", [100.0, 400.0, 1600.0])
def test_a_top_stays_on_its_way_on_a_constraint_and_is_lost_on_a_reduced_coordinate_ball_joint(spin: float) -> None:
    """The case's own axis calls a tenth of the stem lost."""

    def off(**options: object) -> float:
        answer = put(spin_heavy_top.CASE, ADAPTER, with_options(1 / 960, **options), parameters={"spin": spin})
        return np.inf if answer.broke else answer["position_error_max"]

    assert off() < spin_heavy_top.LENGTH / 10
    assert off(joints="coordinates") > spin_heavy_top.LENGTH / 10


def test_which_joints_are_constraints_is_told_as_it_turned_out() -> None:
    top, pendulum = (
        spin_heavy_top.CASE.scene(spin_heavy_top.CASE.parameters),
        joint_conical_pendulum.scene(joint_conical_pendulum.P()),
    )
    other = Revolute(name="hinge", parent=WORLD, child="wheel", anchor_W=(0.0, 9.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    mixed = Scene(bodies=(*top.bodies, free_body("wheel", (0.0, 9.0, 0.0))), joints=(*top.joints, other))
    for scene, track, joints in (
        (top, TUNED, "constraints"), (pendulum, TUNED, "coordinates"), (mixed, TUNED, "auto"), (top, Settings(), "coordinates")
    ):  # fmt: skip
        assert ADAPTER.build(scene, track).resolved.options["joints"] == joints


def test_a_pendulum_that_does_not_spin_keeps_its_reduced_coordinate_ball_joint() -> None:
    """It leaves no gap: a pendulum on its circle errs by rounding alone, a thousand steps of it."""
    for tilt in (5.0, 30.0, 85.0):
        answer = put(joint_conical_pendulum.CASE, ADAPTER, with_options(1 / 240), parameters={"tilt": tilt})
        assert answer["joint_gap_max"] < 1e-12


def test_a_chain_on_constraints_converges_to_the_same_chain_in_coordinates() -> None:
    """Both are of first order, so half the step brings them twice as near; on free bodies every joint has its gap."""
    y, axis = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    links = (free_body("a", (0.5, 0.0, 0.0)), free_body("b", (1.5, 0.0, 0.0)), free_body("c", (1.5, 0.5, 0.0)))
    joints = (
        Revolute(name="top", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=y),
        Ball(name="elbow", parent="a", child="b", anchor_W=(1.0, 0.0, 0.0)),
        Fixed(name="weld", parent="b", child="c"),
    )
    for some in (joints, (*joints[:2], Revolute(name="end", parent="b", child="c", anchor_W=(1.5, 0.3, 0.0), axis_W=axis))):
        scene = Scene(bodies=links, joints=some)
        apart = []
        for dt in (1e-3, 5e-4):
            ways = [state_after(scene, 0.5, with_options(dt, joints=how)).p_WB for how in ("coordinates", "constraints")]
            apart.append(np.abs(ways[0] - ways[1]).max())
        # It falls by half a metre; v dt of it is 5 mm.
        assert 0 < apart[0] < 5e-3
        assert apart[1] < 0.6 * apart[0]


def test_a_cut_hinge_holds_its_axis_under_load() -> None:
    """The vendor's RevoluteJointConstraint amplifies a misalignment by exp(erp t/dt); two ball constraints heal it."""
    bodies = tuple(free_body(name, p) for name, p in (("a", (0.0, 0.0, 0.0)), ("b", (1.0, 0.0, 0.0)), ("c", (0.0, 1.0, 0.0))))
    joints: tuple[Joint, ...] = (
        Ball(name="ab", parent="a", child="b", anchor_W=(0.5, 0.0, 0.0)),
        Ball(name="bc", parent="b", child="c", anchor_W=(0.5, 0.5, 0.0)),
        Revolute(name="ca", parent="c", child="a", anchor_W=(0.0, 0.5, 0.0), axis_W=(0.0, 0.0, 1.0)),
    )
    for order in (joints, joints[::-1], joints[1:] + joints[:1]):
        scene = Scene(bodies=bodies, joints=order, gravity=(0.0, 0.0, 0.0))
        simulation = ADAPTER.build(scene, with_options())
        simulation.wrench(np.array([(0.0, 0.0, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]), np.zeros((3, 3)))
        simulation.step(1000)
        end = state_of(simulation, scene)
        axes = [rotation(end.q_WB[i]) @ (0.0, 0.0, 1.0) for i in (0, 2)]
        # Healing at 1 % a step against a drift of order (w dt)^2 leaves far less than a thousandth.
        assert np.linalg.norm(np.cross(axes[0], axes[1])) < 1e-3


def test_a_loop_of_sliders_and_a_distance_joint_are_refused_by_name() -> None:
    bodies = (free_body("a"), free_body("b", (1.0, 0.0, 0.0)))
    slider = Prismatic(name="slider", parent="a", child="b", anchor_W=(0.5, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="closes a loop"):
        ADAPTER.build(Scene(bodies=bodies, joints=(slider, replace(slider, name="other"))), with_options())
    rod = Distance(name="rod", parent="a", child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="joint 'rod'"):
        ADAPTER.build(Scene(bodies=bodies, joints=(rod,)), with_options())


def test_initial_velocities_of_a_chain_come_back_and_those_that_break_a_joint_are_refused() -> None:
    a = free_body("a", (0.5, 0.0, 0.0), v_WB=(0.0, 0.0, -1.0), w_WB=(0.0, 2.0, 0.0))
    b = free_body("b", (1.5, 0.0, 0.0), v_WB=(0.0, 0.0, -0.5), w_WB=(0.0, -3.0, 0.0))
    joints = (
        Revolute(name="elbow", parent="b", child="a", anchor_W=(1.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="shoulder", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
    )
    scene = Scene(bodies=(b, a), joints=joints)
    got, expected = state_of(ADAPTER.build(scene, with_options()), scene), State.initial(scene)
    np.testing.assert_allclose(got.v_WB, expected.v_WB, atol=1e-13)
    np.testing.assert_allclose(got.w_WB, expected.w_WB, atol=1e-13)
    with pytest.raises(Unsupported, match="joint 'elbow'"):
        ADAPTER.build(Scene(bodies=(b, replace(a, v_WB=(0.0, 0.0, -1.1))), joints=joints), with_options())


def test_a_weld_holds_two_bodies_and_a_full_tensor_together() -> None:
    a, b = (
        free_body("a", v_WB=(0.0, 1.0, 0.0), w_WB=(0.0, 0.0, 2.0)),
        free_body("b", (1.0, 0.0, 0.0), v_WB=(0.0, 3.0, 0.0), w_WB=(0.0, 0.0, 2.0)),
    )
    scene = Scene(bodies=(a, b), joints=(Fixed(name="weld", parent="b", child="a"),), gravity=(0.0, 0.0, 0.0))
    end = state_after(scene, 1.0)
    # The common centre goes straight on and both turn by 2 rad; half a metre to either side of it. First order: 2e-3.
    turned = np.array([np.cos(2.0), np.sin(2.0), 0.0])
    centre = np.array([0.5, 2.0, 0.0])
    np.testing.assert_allclose(end.p_WB, [centre - turned / 2, centre + turned / 2], atol=2e-3)
