"""Checks of frames, signs, units and order: what a pose, a velocity and an inertia mean."""

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.conformance.check import CheckResult, check, judge, near
from plumbline.harness.conformance.room import COARSE, FINE, ROUNDING, built, final, state_of
from plumbline.harness.conformance.scenes import (
    TURNED,
    angle_between,
    floor,
    free,
    ground,
    rotation,
    turned_by,
    turning,
    without_gravity,
)
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Sphere
from plumbline.harness.trajectory import State


@check("After build, is the state the scene's: poses, velocities, all bodies?", firm=True)
def initial_state_comes_back(adapter: Adapter, settings: Settings) -> CheckResult:
    bodies = (
        free("a", p=(1.0, -2.0, 3.0), q=TURNED, v=(0.5, -1.5, 2.5), w=(3.0, 1.0, -2.0), moments=(0.2, 0.3, 0.4)),
        free("b", p=(-4.0, 5.0, 6.0), v=(-1.0, 0.0, 7.0), w=(0.0, -4.0, 0.5)),
    )
    scene = without_gravity(*bodies)
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        got, expected = state_of(simulation, scene), State.initial(scene)
    return judge(
        near("p_WB [m]", got.p_WB, expected.p_WB, ROUNDING, "nothing but rounding lies between"),
        near("angle to q_WB [rad]", [angle_between(got.q_WB[k], expected.q_WB[k]) for k in range(2)], (0.0, 0.0), ROUNDING),
        near("v_WB [m/s]", got.v_WB, expected.v_WB, ROUNDING),
        near("w_WB [rad/s]", got.w_WB, expected.w_WB, ROUNDING),
    )


@check("Do states come in the order of the scene's bodies?", firm=True)
def body_order_is_kept(adapter: Adapter, settings: Settings) -> CheckResult:
    places = [3, 0, 4, 1, 2]
    bodies = [free(f"body{k}", mass=1.0 + k, p=(10.0 * k, 0.0, 0.0), v=(0.0, 1.0 + k, 0.0)) for k in places]
    end = final(adapter, without_gravity(*bodies), settings.with_dt(COARSE), 0.1)
    # A tenth in speed tells the bodies apart and leaves room for default damping, judged elsewhere.
    return judge(
        near("x of the bodies in the order of the scene [m]", end.p_WB[:, 0], [10.0 * k for k in places], 1e-3),
        near("v_y in the same order [m/s]", end.v_WB[:, 1], [1.0 + k for k in places], 0.2),
    )


@check("Does a static body stand in the states at its own place?", Feature.BOX, firm=True)
def fixed_bodies_keep_their_place(adapter: Adapter, settings: Settings) -> CheckResult:
    """A static body between moving ones: states must not be packed."""
    shape = Box(half_extents=(0.5, 0.5, 0.5))
    wall = Body(
        name="wall",
        motion="static",
        collision=(PlacedShape(shape=shape),),
        material="ground",
        p_WB=(20.0, 1.0, 2.0),
        q_WB=TURNED,
    )
    scene = Scene(bodies=(free("a", v=(1.0, 0.0, 0.0)), wall, free("b", p=(0.0, 9.0, 0.0))), gravity=(0.0, 0.0, 0.0))
    end = final(adapter, scene, settings.with_dt(COARSE), 0.1)
    return judge(
        near("p_WB of moving, static, moving [m]", end.p_WB, [[0.1, 0.0, 0.0], [20.0, 1.0, 2.0], [0.0, 9.0, 0.0]], 5e-3),
        near("angle to q_WB of the static body [rad]", angle_between(end.q_WB[1], TURNED), 0.0, ROUNDING),
    )


@check("Is q_WB (w, x, y, z), mapping B to W?", firm=True)
def quaternion_is_wxyz(adapter: Adapter, settings: Settings) -> CheckResult:
    scene = without_gravity(free(q=TURNED))
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        simulation.step(5)
        got = state_of(simulation, scene).q_WB[0]
    # Any other order of components is another rotation.
    return judge(near("angle to the attitude of a body that does not turn [rad]", angle_between(got, TURNED), 0.0, ROUNDING))


@check("Is w_WB in W, both given and read, and does the orientation follow it?", firm=True)
def angular_velocity_is_in_W(adapter: Adapter, settings: Settings) -> CheckResult:
    w, t = (0.5, -1.0, 2.0), 0.2
    end = final(adapter, without_gravity(free(q=TURNED, w=w)), settings.with_dt(COARSE), t)
    return judge(
        near(
            "w_WB of a body of spherical inertia [rad/s]",
            end.w_WB[0],
            w,
            0.12,
            "constant in W, not in B; 5 % for default damping, judged elsewhere",
        ),
        near(
            "angle to exp(w t) q_0 [rad]",
            angle_between(end.q_WB[0], turned_by(TURNED, w, t)),
            0.0,
            0.05 * 2.3 * t,
            "5 % of the turn: a wrong frame is off by the turn itself",
        ),
    )


def _inertia(adapter: Adapter, settings: Settings, body: Body) -> CheckResult:
    """Spin up a turned body by a torque in W where the engine takes one; otherwise watch it precess."""
    scene, tensor = without_gravity(body), np.asarray(body.inertia)
    if Feature.WRENCH in adapter.features:
        tau, t = np.array([0.3, -0.2, 0.5]), 0.05
        with built(adapter, scene, settings.with_dt(FINE)) as simulation:
            simulation.wrench(np.zeros((1, 3)), tau[None])
            simulation.step(round(t / FINE))
            got = state_of(simulation, scene).w_WB[0]
        expected = turning(tensor, body.q_WB, body.w_WB, t, tau)[1]
        because = "1 %: the torque turns the body by 1e-3 rad, gyroscopic terms are 0.3 %"
        size = float(np.linalg.norm(expected))
        return judge(near("w_WB after a torque in W [rad/s]", got, expected, 0.01 * size, because))
    w, t = (3.0, 1.0, -2.0), 0.2
    spinning = Body(name="body", mass=body.mass, inertia=body.inertia, q_WB=body.q_WB, w_WB=w)
    got = final(adapter, without_gravity(spinning), settings.with_dt(FINE), t).w_WB[0]
    expected = turning(tensor, body.q_WB, w, t)[1]
    change = float(np.linalg.norm(expected - w))
    return judge(
        near("w_WB of a free top [rad/s]", got, expected, 0.05 * change, "5 % of its change; first order errs by w dt/2")
    )


@check("Is the inertia in the body's frame, its three moments each on its own axis?", firm=True)
def inertia_is_in_B(adapter: Adapter, settings: Settings) -> CheckResult:
    return _inertia(adapter, settings, free(moments=(0.1, 0.2, 0.25), q=TURNED))


@check("Does an inertia with products act along its true principal axes?", Feature.FULL_INERTIA, firm=True)
def products_of_inertia_count(adapter: Adapter, settings: Settings) -> CheckResult:
    R = rotation(TURNED)
    tensor = R @ np.diag([0.1, 0.2, 0.25]) @ R.T
    tensor = (tensor + tensor.T) / 2
    rows = [[float(c) for c in row] for row in tensor]
    full = ((rows[0][0], rows[0][1], rows[0][2]), (rows[1][0], rows[1][1], rows[1][2]), (rows[2][0], rows[2][1], rows[2][2]))
    return _inertia(adapter, settings, Body(name="body", mass=2.0, inertia=full, q_WB=TURNED))


@check("Is the state that of the centre of mass, and the shape where the scene places it?", Feature.SPHERE, firm=True)
def centre_of_mass_off_the_shape_origin(adapter: Adapter, settings: Settings) -> CheckResult:
    """The same sphere, placed off the centre of mass of a body that spins in space or rests on the ground."""
    placed = (PlacedShape(shape=Sphere(radius=0.2), p_BS=(0.0, 0.0, 0.1)),)
    inertia = free().inertia
    spin = Body(name="spin", inertia=inertia, collision=placed, p_WB=(1.0, 2.0, 3.0), q_WB=TURNED, w_WB=(5.0, -4.0, 3.0))
    end = final(adapter, without_gravity(spin), settings.with_dt(FINE), 0.3)
    # Head down: the shape's origin lies 0.1 m below the centre of mass, which is 0.3 m above the ground.
    rest = Body(
        name="rest", inertia=inertia, collision=placed, material="block", p_WB=(0.0, 0.0, 0.3), q_WB=(0.0, 1.0, 0.0, 0.0)
    )
    down = final(adapter, Scene(bodies=(floor(adapter), rest), surfaces=(ground(0.5),)), settings.with_dt(FINE), 0.15)
    return judge(
        near("p_WB of the spinning centre of mass [m]", end.p_WB[0], spin.p_WB, 1e-4, "no force acts"),
        near("v_WB of the spinning centre of mass [m/s]", end.v_WB[0], (0, 0, 0), 1e-3, "the shape's origin moves at 0.7 m/s"),
        near("height of the resting centre of mass [m]", down.p_WB[1, 2], 0.3, 3e-3, "contacts give way by less than 3 mm"),
    )
