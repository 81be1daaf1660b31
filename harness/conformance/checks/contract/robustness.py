"""Checks of honesty: nothing non-finite is hidden, runs repeat bit for bit, simulations share nothing, saves are whole."""

from hashlib import sha256

import numpy as np

from plumbline.harness.adapter import Diverged, Feature, Simulation
from plumbline.harness.conformance.check import Compared, Comparisons, check, firm, near, said, that
from plumbline.harness.conformance.engine import COARSE, FINE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X
from plumbline.harness.conformance.scenes import G, ball, block, free, on_ground, prismatic, without_gravity
from plumbline.harness.scene import Drive, Scene
from plumbline.harness.trajectory import Floats, State


def _refused_or_seen(what: str, simulation: Simulation, scene: Scene, steps: int = 20) -> Compared:
    """After a non-finite input: an exception at once, or a state that shows it; never a healthy one."""
    try:
        for _ in range(steps):
            simulation.step()
            if not state_of(simulation, scene).finite:
                return said(f"{what}: the state shows it")
    except Diverged as error:
        return said(f"{what}: Diverged: {error}")
    return that(False, f"{what}: got a finite state after {steps} steps, expected Diverged or a state that shows it")


@firm("After a NaN or an overflow, is there Diverged or a state that shows it, never a healthy one?")
def nan_is_reported(engine: Engine) -> Comparisons:
    """By a NaN force where the engine takes forces; and by a spin whose square overflows."""
    scene = without_gravity(free(v=(1.0, 0.0, 0.0)))
    if Feature.WRENCH in engine.features:
        with engine.built(scene, COARSE) as simulation:
            simulation.step(2)
            try:
                simulation.wrench(np.full((1, 3), np.nan), np.zeros((1, 3)))
            except (Diverged, ValueError) as error:
                yield said(f"NaN force: refused: {error}")
            else:
                yield _refused_or_seen("NaN force", simulation, scene)
    huge = 1e160
    spin = without_gravity(free(moments=(0.1, 0.2, 0.25), w=(huge, 0.5 * huge, -0.3 * huge)))
    with engine.built(spin, COARSE) as simulation:
        try:
            for _ in range(20):
                simulation.step()
            end = state_of(simulation, spin)
        except Diverged as error:
            yield said(f"spin of 1e160 rad/s: Diverged: {error}")
        else:
            with np.errstate(all="ignore"):
                kept = float(np.linalg.norm(end.w_WB[0] / huge))
            # Angular momentum is kept, so w stays within the ratio of the moments, 0.25 : 0.1; a reset gives 0 or the start.
            honest = not end.finite or 0.3 < kept < 3.0
            wrong = f"spin of 1e160 rad/s: got a finite {kept * huge:.3g} rad/s, expected Diverged, NaN, or the spin kept"
            yield said("as expected") if honest else that(False, wrong)


@check("Is a huge but finite velocity kept, or reported as Diverged, never reset in silence?")
def huge_state_is_not_reset(engine: Engine) -> Comparisons:
    """1e12 m/s is finite: either it is carried through rightly, or the engine's limit is reported as Diverged."""
    v, steps = 1e12, 20
    scene = without_gravity(free(v=(v, 0.0, 0.0)))
    with engine.built(scene, COARSE) as simulation:
        try:
            simulation.step(steps)
        except Diverged as error:
            yield said(f"Diverged: {error}")
            return
        end = state_of(simulation, scene)
        if not end.finite:
            yield said("the state shows that it is not finite")
            return
    yield near("v_WB of a body at 1e12 m/s [m/s]", end.v_WB[0, 0], v, 1e-3 * v, "kept, or Diverged; never reset")
    yield near("its way [m]", end.p_WB[0, 0], v * steps * COARSE, 1e-3 * v * steps * COARSE, "v t")


def _crowd(engine: Engine, scale: float = 1.0) -> Scene:
    """What meets in contact where the engine has shapes for it, beside free tops; different for each scale."""
    tops = tuple(
        free(f"top{k}", p=(0.0, 9.0 + k, 5.0), q=TURNED, w=(3.0 * scale, 1.0, -k), moments=(0.1, 0.2, 0.25)) for k in range(2)
    )
    if Feature.SPHERE not in engine.features or not engine.features & (Feature.PLANE | Feature.BOX):
        return Scene(bodies=tops)
    balls = tuple(ball(f"ball{k}", p=(0.05 * k * scale, 0.02 * k, 0.1 + 0.19 * k), w=(0.0, scale, 0.0)) for k in range(3))
    return on_ground(engine, *balls, *tops, friction=0.0, gravity=(0.0, 0.0, -G * scale))


def _bits(state: State) -> str:
    digest = sha256()
    for array in (state.p_WB, state.q_WB, state.v_WB, state.w_WB):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]


def _alone(engine: Engine, scene: Scene, steps: int, dt: float) -> str:
    with engine.built(scene, dt) as simulation:
        for _ in range(steps):
            simulation.step()
        return _bits(state_of(simulation, scene))


@check("Do two equal runs end in the same bits?")
def same_input_same_hash(engine: Engine) -> Comparisons:
    scene = _crowd(engine)
    first, second = (_alone(engine, scene, 120, COARSE) for _ in range(2))
    yield that(first == second, f"state hashes of two equal runs: got {first} and {second}, expected the same")


@firm("Do two simulations taken in turns give what each gives alone?")
def two_simulations_share_no_state(engine: Engine) -> Comparisons:
    """Two different scenes at different steps, taken in turns, each equal to the same run on its own."""
    first_scene, second_scene = _crowd(engine), _crowd(engine, 1.7)
    expected = _alone(engine, first_scene, 60, COARSE), _alone(engine, second_scene, 60, FINE)
    with engine.built(first_scene, COARSE) as a, engine.built(second_scene, FINE) as b:
        for _ in range(60):
            a.step()
            b.step()
        got = _bits(state_of(a, first_scene)), _bits(state_of(b, second_scene))
    yield that(got == expected, f"state hashes in turns: got {got}, expected those of each run alone, {expected}")


@check("Is the future after restore the same, bit for bit, as after save?", Feature.SAVE)
def save_and_restore_is_exact(engine: Engine) -> Comparisons:
    scene = _crowd(engine)
    with engine.built(scene, COARSE) as simulation:
        simulation.step(40)
        here, saved = _bits(state_of(simulation, scene)), simulation.save()
        simulation.step(60)
        there = _bits(state_of(simulation, scene))
        simulation.restore(saved)
        back = _bits(state_of(simulation, scene))
        simulation.step(60)
        again = _bits(state_of(simulation, scene))
    yield that(back == here, f"state hash after restore: got {back}, expected {here}, that of the save")
    yield that(again == there, f"state hash 60 steps after restore: got {again}, expected {there}, that of the first time")


@firm("Does the adapter copy the arrays handed in, and leave them as they were?", Feature.WRENCH)
def inputs_are_left_alone(engine: Engine) -> Comparisons:
    """What the caller hands in stays as it was, and is not kept by reference."""
    scene = without_gravity(free(), free("other", p=(5.0, 0.0, 0.0)))
    f, tau = np.zeros((2, 3)), np.zeros((2, 3))
    f[0, 0] = 2.0
    with engine.built(scene) as simulation:
        simulation.wrench(f, tau)
        unchanged = bool(f[0, 0] == 2.0 and np.count_nonzero(f) == 1 and not tau.any())
        f[:] = 1e6
        simulation.step(100)
        end = state_of(simulation, scene)
    yield that(unchanged, f"forces handed in: got {f[0]} afterwards, expected them untouched")
    what, because = "v_WB although the caller reused the array [m/s]", "F t / m of what was handed in"
    yield near(what, end.v_WB[0], (0.1, 0.0, 0.0), 0.002, because)


@firm("Is a state that came out of a hard contact problem finite, or Diverged?", Feature.BOX)
def heavy_on_light_is_finite_or_diverged(engine: Engine) -> Comparisons:
    """50 kg on 1 kg: nothing asks for accuracy here, only that the state is finite or Diverged says that it is not."""
    half = (0.1, 0.1, 0.1)
    light, heavy = block("light", half=half, p=(0.0, 0.0, 0.1)), block("heavy", mass=50.0, half=half, p=(0.0, 0.0, 0.3))
    scene = on_ground(engine, light, heavy, friction=0.0)
    with engine.built(scene, COARSE) as simulation:
        try:
            simulation.step(60)
        except Diverged as error:
            yield said(f"Diverged: {error}")
            return
        end = state_of(simulation, scene)
    yield that(end.finite, "state of 50 kg on 1 kg: got a number that is not finite and no Diverged")
    yield near("norms of the quaternions", np.linalg.norm(end.q_WB, axis=1), np.ones(3), 1e-6, "unit")


def _after(simulation: Simulation, scene: Scene, steps: int = 20) -> Floats:
    simulation.step(steps)
    return state_of(simulation, scene).p_WB


@check("Does restore bring back the forces that were told when it was saved, and no others?", Feature.SAVE | Feature.WRENCH)
def restore_brings_back_the_wrench(engine: Engine) -> Comparisons:
    """A push told after a save is forgotten with it; one told before it acts again."""
    scene = without_gravity(free(), free("other", p=(5.0, 0.0, 0.0)))
    push, none = np.zeros((2, 3)), np.zeros((2, 3))
    push[0, 0] = 10.0
    with engine.built(scene, COARSE) as simulation:
        simulation.step(5)
        quiet = simulation.save()
        unpushed = _after(simulation, scene)
        simulation.wrench(push, none)
        pushed_from = simulation.save()
        pushed = _after(simulation, scene)
        simulation.restore(quiet)
        first = _after(simulation, scene)
        simulation.wrench(none, none)
        simulation.restore(pushed_from)
        second = _after(simulation, scene)
    yield near("p_WB after restoring what nobody pushed [m]", first, unpushed, 0.0, "the same bits")
    yield near("p_WB after restoring what was pushed [m]", second, pushed, 0.0, "the same bits")
    yield near("way of what was pushed [m]", pushed[0, 0], 5.0 / 2 * (20 * COARSE) ** 2, 2e-3, "F t^2/2m, and half a step")


@check("Does restore bring back the targets of the drives?", Feature.SAVE | Feature.PRISMATIC | Feature.DRIVES)
def restore_brings_back_the_targets(engine: Engine) -> Comparisons:
    drive = Drive(stiffness=50.0, damping=20.0)
    slide = prismatic("slide", "body", ORIGIN, X, drive=drive)
    scene = without_gravity(free(), joints=(slide,))
    with engine.built(scene) as simulation:
        simulation.command({"slide": 0.1})
        simulation.step(50)
        saved = simulation.save()
        expected = _after(simulation, scene, 200)
        simulation.command({"slide": -0.4})
        simulation.step(10)
        simulation.restore(saved)
        got = _after(simulation, scene, 200)
    yield near("p_WB on the way to the target of the save [m]", got, expected, 0.0, "the same bits")
