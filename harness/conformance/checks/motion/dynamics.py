"""Checks of free motion: gravity, hidden damping, sleeping, clamps, gyroscopic torque, damping laws, and time step by step."""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Feature, SettingsError
from plumbline.harness.conformance.check import Comparisons, NotApplicable, check, firm, near, refusable
from plumbline.harness.conformance.closed_forms import turning
from plumbline.harness.conformance.engine import COARSE, ROUNDING, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Y, Z, aligned, vector
from plumbline.harness.conformance.scenes import G, block, damped, free, on_ground, revolute, without_gravity
from plumbline.harness.scene import Body, Joint, Scene, Vector3, axis_angle
from plumbline.harness.trajectory import Floats


def _fall(engine: Engine, gravity: tuple[float, float, float]) -> Comparisons:
    """From rest and for a short time, so that a vendor's default damping, judged elsewhere, takes less than half a percent."""
    t, dt = 0.05, COARSE
    end = engine.final(Scene(bodies=(free(),), gravity=gravity), t, dt)
    g = np.array(gravity)
    size = float(np.linalg.norm(g))
    because = "|g| dt t/2 is what a staggered scheme of first order leaves"
    exact = "1 %: every scheme is exact in v but for damping"
    yield near("v_WB after free fall [m/s]", end.v_WB[0], g * t, 0.01 * size * t, exact)
    yield near("p_WB after free fall [m]", end.p_WB[0], g * t * t / 2, 1.001 * size * dt * t / 2 + ROUNDING, because)


@firm("Does a free body fall with g, downwards?")
def free_fall_has_the_size_and_sign_of_g(engine: Engine) -> Comparisons:
    return _fall(engine, (0.0, 0.0, -G))


@firm("Does gravity act in any direction that the scene gives?")
def gravity_is_a_vector(engine: Engine) -> Comparisons:
    return _fall(engine, (3.0, -4.0, 5.0))


@firm("Is step(n) exactly n dt, and bit for bit n times step(1)?")
def step_advances_exactly_dt(engine: Engine) -> Comparisons:
    bodies = [free("fall"), free("spin", p=(5.0, 0.0, 0.0), q=TURNED, w=(3.0, 1.0, -2.0), moments=(0.1, 0.2, 0.25))]
    scene = Scene(bodies=tuple(bodies))
    if Feature.BOX in engine.features:
        scene = on_ground(engine, block(p=(0.0, 0.0, 0.05), v=(1.0, 0.5, 0.0)))
        scene = replace(scene, bodies=(*scene.bodies, *(replace(b, p_WB=(b.p_WB[0], 0.0, 50.0)) for b in bodies)))
    n, index = 24, scene.index("fall")
    with engine.built(scene, COARSE) as together, engine.built(scene, COARSE) as apart:
        together.step(n)
        for _ in range(n):
            apart.step()
        at_once, other = state_of(together, scene), state_of(apart, scene)
        together.step()
        later = state_of(together, scene)
    half = 0.5 * G * COARSE
    yield near("v_z after step(24) [m/s]", at_once.v_WB[index, 2], -G * n * COARSE, half, "g times 24 dt, half a step granted")
    yield near("v_z one step later [m/s]", later.v_WB[index, 2], -G * (n + 1) * COARSE, half, "g times 25 dt")
    for name, unit in (("p_WB", " [m]"), ("q_WB", ""), ("v_WB", " [m/s]"), ("w_WB", " [rad/s]")):
        what = f"{name} of step(24) against 24 step(1){unit}"
        yield near(what, getattr(at_once, name), getattr(other, name), 0.0, "the same bits")


@firm("Does time pass at the same rate with sub-steps?")
def substeps_divide_dt(engine: Engine) -> Comparisons:
    t, because = 0.1, "sub-steps divide dt, they do not add to it"
    try:
        end = replace(engine, settings=replace(engine.settings, substeps=4)).final(Scene(bodies=(free(),)), t, COARSE)
    except SettingsError as error:
        raise NotApplicable(f"the adapter takes no substeps: {error}") from error
    yield near("v_z of a fall in sub-steps [m/s]", end.v_WB[0, 2], -G * t, 0.02 * G * t, because)


@check("Does a free body keep its velocities where the scene asks for no damping?")
def hidden_damping_is_off(engine: Engine) -> Comparisons:
    v, w = (3.0, -2.0, 1.0), (1.0, 2.0, -3.0)
    end = engine.final(without_gravity(free(v=v, w=w)), 1.0, COARSE)
    because = "no force acts; a damping of .04 1/s would take 4 %"
    yield near("v_WB after 1 s [m/s]", end.v_WB[0], v, 1e-4, because)
    yield near("w_WB of a spherical inertia after 1 s [rad/s]", end.w_WB[0], w, 1e-4, because)


@check("May a body be fast: 400 m/s, 300 rad/s?")
def velocity_is_not_clamped(engine: Engine) -> Comparisons:
    v, w, t = (400.0, 0.0, 0.0), (0.0, 0.0, 300.0), 0.1
    end = engine.final(without_gravity(free(v=v, w=w)), t)
    yield near("v_WB [m/s]", end.v_WB[0], v, 0.1, "nothing slows it down")
    yield near("w_WB [rad/s]", end.w_WB[0], w, 0.1, "nothing slows it down")
    yield near("way [m]", end.p_WB[0, 0], 400.0 * t, 0.05, "v t")


@check("May a body turn by one radian in a step?")
def fast_spin_is_not_cut(engine: Engine) -> Comparisons:
    """One radian a step: an engine that cuts the turn of a step at pi/4 falls behind by 2 rad in ten."""
    steps, w = 10, 1.0 / COARSE
    end = engine.final(without_gravity(free(w=(0.0, 0.0, w))), steps * COARSE, COARSE)
    because = "(w dt)^2/12 = 8 % of ten radians for an orientation update of first order"
    what = "angle to the exact orientation after ten steps of 1 rad [rad]"
    yield aligned(what, end.q_WB[0], axis_angle(Z, float(steps)), 1.0, because)


def _woken(engine: Engine) -> float:
    """The speed [m/s] that .05 N give to 1 kg on ice in half a second after it has rested for one."""
    scene = on_ground(engine, block(), friction=0.0)
    push = np.zeros((2, 3))
    push[1, 0] = 0.05
    with engine.built(scene, COARSE) as simulation:
        simulation.step(round(1 / COARSE))
        simulation.wrench(push, np.zeros((2, 3)))
        simulation.step(round(0.5 / COARSE))
        return float(state_of(simulation, scene).v_WB[1, 0])


@check("Does a slow body keep moving, free or in contact?")
def sleeping_is_off(engine: Engine) -> Comparisons:
    """Slow motion in empty space and, where there is ground, slow sliding without friction: both go on for ever."""
    v, w, t = 0.005, 0.02, 3.0
    end = engine.final(without_gravity(free(v=(v, 0.0, 0.0), w=(0.0, 0.0, w))), t, COARSE)
    because = "nothing stops it; an engine that puts slow bodies to sleep does"
    yield near("v_WB of a slow body after 3 s [m/s]", end.v_WB[0], (v, 0, 0), 1e-4, because)
    yield near("w_WB of a slow body after 3 s [rad/s]", end.w_WB[0], (0, 0, w), 1e-4, because)
    yield near("its way [m]", end.p_WB[0], (v * t, 0, 0), 1e-3, because)
    if Feature.BOX in engine.features:
        slid = engine.final(on_ground(engine, block(v=(v, 0.0, 0.0)), friction=0.0), t, COARSE)
        yield near("way of a slow box on ice in 3 s [m]", slid.p_WB[1, 0], v * t, 0.1 * v * t, because)
    if Feature.BOX | Feature.WRENCH in engine.features:
        woken = _woken(engine)
        yield near("v_x of a rested box on ice, after .05 N for .5 s [m/s]", woken, 0.025, 0.003, "F t / m")


@check("Does a free asymmetric top precess?")
def gyroscopic_term_is_present(engine: Engine) -> Comparisons:
    moments, w, t = (0.1, 0.2, 0.25), (3.0, 1.0, -2.0), 0.25
    body = free(moments=moments, q=TURNED, w=w)
    got = engine.final(without_gravity(body), t).w_WB[0]
    expected = turning(body.inertia, TURNED, w, t)[1]
    change = float(np.linalg.norm(expected - w))
    because = "5 % of its change in a quarter second; a scheme of first order errs by about w dt/2 = 0.2 %"
    yield near("w_WB of a free asymmetric top [rad/s]", got, expected, 0.05 * change, because)


@check("Is linear damping v' = -c v with the scene's c in 1/s?", Feature.LINEAR_DAMPING)
def linear_damping_law(engine: Engine) -> Comparisons:
    end = engine.final(without_gravity(damped(free(v=(3.0, 0.0, 0.0)), linear=2.0)), 0.5, COARSE)
    return _damped_away("v_WB under v' = -c v [m/s]", end.v_WB[0], X)


@check("Is angular damping w' = -c w with the scene's c in 1/s?", Feature.ANGULAR_DAMPING)
def angular_damping_law(engine: Engine) -> Comparisons:
    end = engine.final(without_gravity(damped(free(w=(0.0, 3.0, 0.0)), angular=2.0)), 0.5, COARSE)
    return _damped_away("w_WB under w' = -c w [rad/s]", end.w_WB[0], Y)


def _damped_away(what: str, got: Floats, axis: Vector3) -> Comparisons:
    """What is left of 3 m/s or rad/s along an axis after .5 s at 2/s."""
    c, t = 2.0, 0.5
    left = 3.0 * np.exp(-c * t)
    within = 1.2 * left * c * c * t * COARSE / 2 + ROUNDING
    yield near(what, got, left * np.array(axis), within, "(1 - c dt)^n errs by c^2 t dt/2")


@firm("Do force and torque act in W, at the centre of mass, on the right body, until told otherwise?", Feature.WRENCH)
def wrench_has_sign_and_size(engine: Engine) -> Comparisons:
    scene = without_gravity(free("idle"), free("pushed", p=(5.0, 0.0, 0.0), mass=2.0, q=TURNED))
    f, tau, t = np.array([1.0, -2.0, 3.0]), np.array([0.3, -0.1, 0.2]), 0.02
    with engine.built(scene) as simulation:
        simulation.wrench(np.array([np.zeros(3), f]), np.array([np.zeros(3), tau]))
        simulation.step(8)
        simulation.step(12)
        pushed = state_of(simulation, scene)
        simulation.wrench(np.zeros((2, 3)), np.zeros((2, 3)))
        simulation.step(20)
        coasting = state_of(simulation, scene)
    because = "f t / m, in every step until told otherwise"
    yield near("v_WB of the pushed body [m/s]", pushed.v_WB[1], f * t / 2.0, 0.02 * 0.037, because)
    because = "tau t / I for a spherical inertia"
    yield near("w_WB of the pushed body [rad/s]", pushed.w_WB[1], tau * t / 0.3, 0.02 * 0.025, because)
    yield near("v_WB of the other body [m/s]", pushed.v_WB[0], (0, 0, 0), 1e-9, "each row acts on its own body")
    yield near("v_WB after the push has ended [m/s]", coasting.v_WB[1], pushed.v_WB[1], 0.02 * 0.037, "2 % for default damping")


def _falling() -> Scene:
    """One body falls, another flies on and turns."""
    return Scene(bodies=(free(), free("other", p=(5.0, 0.0, 0.0), q=TURNED, v=(3.0, 0.0, 0.0), w=(1.0, 2.0, -1.0))))


@firm("Does step(0) leave the state as it is, bit for bit?")
def no_step_is_no_step(engine: Engine) -> Comparisons:
    scene = _falling()
    with engine.built(scene, COARSE) as simulation:
        for when in ("right after build", "after 5 steps"):
            before = state_of(simulation, scene)
            simulation.step(0)
            after = state_of(simulation, scene)
            for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
                what = f"change of {name} by step(0) {when}"
                yield near(what, getattr(after, name) - getattr(before, name), np.zeros_like(getattr(after, name)), 0.0)
            simulation.step(5)


@firm("Is every single step dt long, not only the mean of many?")
def steps_are_even(engine: Engine) -> Comparisons:
    """Each step adds g dt to the speed of what falls and v dt to the way of what flies, not only all of them together."""
    run = engine.record(_falling(), 8 * COARSE, dt=COARSE)
    dv, dx = np.diff(run.v_WB[:, 0, 2]), np.diff(run.p_WB[:, 1, 0])
    because = "1 %: default damping, judged elsewhere, takes .1 %; steps of .9 and 1.1 dt are 10 % off"
    yield near("speed gained in each of 8 steps [m/s]", dv, np.full(8, -G * COARSE), 0.01 * G * COARSE, because)
    yield near("way gained in each of 8 steps [m]", dx, np.full(8, 3.0 * COARSE), 0.01 * 3.0 * COARSE, because)


LENGTHS = (1.0, 0.5, 2.0, 1.25, 0.75, 0.5)
"""Of steps, in dt: each may be shorter or longer than the one before; their mean is 1."""


@firm("Is every step as long as was told for it, where lengths are uneven?", Feature.STEP_LENGTHS)
def step_lengths_are_kept(engine: Engine) -> Comparisons:
    """Step h adds g h to the speed of what falls and v h to the way of what flies, and the fall is the sum of all of them.

    Semi-implicit Euler falls by g sum(h_k (h_1 + .. + h_k)), g sum(h_k^2)/2 more than g t^2/2; explicit Euler by as much less,
    and what is more exact, or takes sub-steps, lies between the two.
    """
    lengths = COARSE * np.array(LENGTHS)
    states, scene = [], _falling()
    with engine.built(scene, COARSE) as simulation:
        states.append(state_of(simulation, scene))
        for length in lengths.tolist():
            simulation.retime(length)  # type: ignore[attr-defined]  # what an engine may offer, see harness.adapter
            simulation.step()
            states.append(state_of(simulation, scene))
    v, x = np.array([state.v_WB[0, 2] for state in states]), np.array([state.p_WB[1, 0] for state in states])
    t, fallen = float(lengths.sum()), states[0].p_WB[0, 2] - states[-1].p_WB[0, 2]
    because = "1 % of dt: a default damping of .16 1/s takes half of it; a length that is ignored is 25 % of dt off or more"
    staggered = 1.01 * G * float((lengths**2).sum()) / 2 + ROUNDING
    yield near("speed gained in each of 6 steps [m/s]", np.diff(v), -G * lengths, 0.01 * G * COARSE, because)
    yield near("way gained in each of 6 steps [m]", np.diff(x), 3.0 * lengths, 0.01 * 3.0 * COARSE, because)
    yield near("way fallen [m]", fallen, G * t * t / 2, staggered, "g sum(h^2)/2 of a scheme of first order")


@firm("Is the lead of a force what the way of one step shows?", Feature.WRENCH)
def force_lead_is_what_a_step_shows(engine: Engine) -> Comparisons:
    """From rest a step under a force goes c f dt^2 / m: an engine that says its lead says 1 - c."""
    dt, push = 0.05, np.array([[3.0, -4.0, 12.0]])
    scene = without_gravity(free(mass=2.0))
    with engine.built(scene, dt) as simulation:
        lead = getattr(simulation, "force_lead", None)
        if lead is None:
            raise NotApplicable("the engine says nothing of a lead")
        simulation.wrench(push, np.zeros((1, 3)))
        simulation.step()
        end = state_of(simulation, scene)
    gone = float(end.p_WB[0] @ push[0]) / 13.0
    travel = 13.0 / 2.0 * dt**2
    because = "a damping that is on by default takes .3 % in this step; half a step of lead is half of it"
    yield near("way of the first step [m]", gone, (1.0 - lead) * travel, 0.02 * travel, because)


@check("Does a strong damping bring a body to rest?", Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING)
def strong_damping_brings_to_rest(engine: Engine) -> Comparisons:
    """At 600/s nothing is left after 48 steps of 1/240 s; a force that is held over its step goes 2.5 times too far, and back.

    The classical Runge-Kutta method, of explicit ones the usual, leaves .65 of it a step.
    """
    return _rests(engine, free(v=(1.0, -2.0, 3.0), w=(3.0, 1.0, -2.0)))


@check(
    "Does a strong damping bring what hangs on a joint to rest?",
    Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING | Feature.REVOLUTE,
)
def strong_damping_brings_what_hangs_to_rest(engine: Engine) -> Comparisons:
    """The same about a hinge: engines damp what hangs by other code than what is free."""
    pivot, axis = (0.2, -0.1, 0.4), (0.6, 0.0, 0.8)
    spin = 3.0 * np.array(axis)
    body = free(v=vector(-np.cross(spin, pivot)), w=vector(spin))
    with refusable("the engine damps nothing that hangs"):
        yield from _rests(engine, body, revolute("hinge", body.name, pivot, axis))


def _rests(engine: Engine, body: Body, *joints: Joint) -> Comparisons:
    """Damped by 600/s, a body is at rest after .2 s."""
    end = engine.final(without_gravity(damped(body, linear=600.0, angular=600.0), joints=joints), 0.2, COARSE)
    yield near("velocity [m/s]", end.v_WB[0], ORIGIN, 1e-6, "e^(-120); .65 a step leaves 1e-9")
    yield near("angular velocity [rad/s]", end.w_WB[0], ORIGIN, 1e-6, "the same")
