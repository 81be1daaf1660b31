"""Checks of frames, signs, units and order: what a pose, a velocity and an inertia mean."""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, firm, near
from plumbline.harness.conformance.closed_forms import turning
from plumbline.harness.conformance.engine import COARSE, FINE, ROUNDING, Engine, state_of
from plumbline.harness.conformance.frames import TURNED, aligned, rotation, symmetric, turned_by
from plumbline.harness.conformance.scenes import free, on_ground, shaped, static, without_gravity
from plumbline.harness.scene import Body, Box, PlacedShape, Sphere
from plumbline.harness.trajectory import State


@firm("After build, is the state the scene's: poses, velocities, all bodies?")
def initial_state_comes_back(engine: Engine) -> Comparisons:
    bodies = (
        free("a", p=(1.0, -2.0, 3.0), q=TURNED, v=(0.5, -1.5, 2.5), w=(3.0, 1.0, -2.0), moments=(0.2, 0.3, 0.4)),
        free("b", p=(-4.0, 5.0, 6.0), v=(-1.0, 0.0, 7.0), w=(0.0, -4.0, 0.5)),
    )
    scene = without_gravity(*bodies)
    with engine.built(scene, COARSE) as simulation:
        got, expected = state_of(simulation, scene), State.initial(scene)
    yield near("p_WB [m]", got.p_WB, expected.p_WB, ROUNDING, "nothing but rounding lies between")
    yield aligned("angle to q_WB [rad]", got.q_WB, expected.q_WB, ROUNDING)
    yield near("v_WB [m/s]", got.v_WB, expected.v_WB, ROUNDING)
    yield near("w_WB [rad/s]", got.w_WB, expected.w_WB, ROUNDING)


@firm("Do states come in the order of the scene's bodies?")
def body_order_is_kept(engine: Engine) -> Comparisons:
    places = [3, 0, 4, 1, 2]
    bodies = [free(f"body{k}", mass=1.0 + k, p=(10.0 * k, 0.0, 0.0), v=(0.0, 1.0 + k, 0.0)) for k in places]
    end = engine.final(without_gravity(*bodies), 0.1, COARSE)
    # A tenth in speed tells the bodies apart and leaves room for default damping, judged elsewhere.
    yield near("x of the bodies in the order of the scene [m]", end.p_WB[:, 0], [10.0 * k for k in places], 1e-3)
    yield near("v_y in the same order [m/s]", end.v_WB[:, 1], [1.0 + k for k in places], 0.2)


@firm("Does a static body stand in the states at its own place?", Feature.BOX)
def fixed_bodies_keep_their_place(engine: Engine) -> Comparisons:
    """A static body between moving ones: states must not be packed."""
    wall = static("wall", Box(half_extents=(0.5, 0.5, 0.5)), p=(20.0, 1.0, 2.0), q=TURNED)
    scene = without_gravity(free("a", v=(1.0, 0.0, 0.0)), wall, free("b", p=(0.0, 9.0, 0.0)))
    end = engine.final(scene, 0.1, COARSE)
    yield near("p_WB of moving, static, moving [m]", end.p_WB, [[0.1, 0.0, 0.0], [20.0, 1.0, 2.0], [0.0, 9.0, 0.0]], 5e-3)
    yield aligned("angle to q_WB of the static body [rad]", end.q_WB[1], TURNED, ROUNDING)


@firm("Is q_WB (w, x, y, z), mapping B to W?")
def quaternion_is_wxyz(engine: Engine) -> Comparisons:
    scene = without_gravity(free(q=TURNED))
    with engine.built(scene, COARSE) as simulation:
        simulation.step(5)
        got = state_of(simulation, scene).q_WB[0]
    # Any other order of components is another rotation.
    yield aligned("angle to the attitude of a body that does not turn [rad]", got, TURNED, ROUNDING)


@firm("Is w_WB in W, both given and read, and does the orientation follow it?")
def angular_velocity_is_in_W(engine: Engine) -> Comparisons:
    w, t = (0.5, -1.0, 2.0), 0.2
    end = engine.final(without_gravity(free(q=TURNED, w=w)), t, COARSE)
    because = "constant in W, not in B; 5 % for default damping, judged elsewhere"
    yield near("w_WB of a body of spherical inertia [rad/s]", end.w_WB[0], w, 0.12, because)
    because = "5 % of the turn: a wrong frame is off by the turn itself"
    yield aligned("angle to exp(w t) q_0 [rad]", end.q_WB[0], turned_by(TURNED, w, t), 0.05 * 2.3 * t, because)


def _inertia(engine: Engine, body: Body) -> Comparisons:
    """Spin up a turned body by a torque in W where the engine takes one; otherwise watch it precess."""
    scene = without_gravity(body)
    if Feature.WRENCH in engine.features:
        tau, t = np.array([0.3, -0.2, 0.5]), 0.05
        with engine.built(scene) as simulation:
            simulation.wrench(np.zeros((1, 3)), tau[None])
            simulation.step(round(t / FINE))
            got = state_of(simulation, scene).w_WB[0]
        expected = turning(body.inertia, body.q_WB, body.w_WB, t, tau)[1]
        because = "1 %: the torque turns the body by 1e-3 rad, gyroscopic terms are 0.3 %"
        size = float(np.linalg.norm(expected))
        yield near("w_WB after a torque in W [rad/s]", got, expected, 0.01 * size, because)
        return
    w, t = (3.0, 1.0, -2.0), 0.2
    got = engine.final(without_gravity(replace(body, w_WB=w)), t).w_WB[0]
    expected = turning(body.inertia, body.q_WB, w, t)[1]
    change = float(np.linalg.norm(expected - w))
    yield near("w_WB of a free top [rad/s]", got, expected, 0.05 * change, "5 % of its change; first order errs by w dt/2")


@firm("Is the inertia in the body's frame, its three moments each on its own axis?")
def inertia_is_in_B(engine: Engine) -> Comparisons:
    return _inertia(engine, free(moments=(0.1, 0.2, 0.25), q=TURNED))


@firm("Does an inertia with products act along its true principal axes?", Feature.FULL_INERTIA)
def products_of_inertia_count(engine: Engine) -> Comparisons:
    R = rotation(TURNED)
    return _inertia(engine, replace(free(q=TURNED), inertia=symmetric(R @ np.diag([0.1, 0.2, 0.25]) @ R.T)))


@firm("Is the state that of the centre of mass, and the shape where the scene places it?", Feature.SPHERE)
def centre_of_mass_off_the_shape_origin(engine: Engine) -> Comparisons:
    """The same sphere, placed off the centre of mass of a body that spins in space or rests on the ground."""
    body = shaped("body", PlacedShape(shape=Sphere(radius=0.2), p_BS=(0.0, 0.0, 0.1)), inertia=free().inertia)
    spin = replace(body, name="spin", p_WB=(1.0, 2.0, 3.0), q_WB=TURNED, w_WB=(5.0, -4.0, 3.0))
    end = engine.final(without_gravity(spin), 0.3)
    # Head down: the shape's origin lies 0.1 m below the centre of mass, which is 0.3 m above the ground.
    rest = replace(body, name="rest", p_WB=(0.0, 0.0, 0.3), q_WB=(0.0, 1.0, 0.0, 0.0))
    down = engine.final(on_ground(engine, rest), 0.15)
    yield near("p_WB of the spinning centre of mass [m]", end.p_WB[0], spin.p_WB, 1e-4, "no force acts")
    yield near("v_WB of the spinning centre of mass [m/s]", end.v_WB[0], (0, 0, 0), 1e-3, "the shape's origin moves at 0.7 m/s")
    yield near("height of the resting centre of mass [m]", down.p_WB[1, 2], 0.3, 3e-3, "contacts give way by less than 3 mm")
