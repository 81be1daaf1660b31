"""Checks of two things that stand together, each pair of a list, against the laws of motion alone."""

from dataclasses import replace

import numpy as np

from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Velocities
from plumbline.harness.conformance.check import Compared, Comparisons, all_near, check
from plumbline.harness.conformance.engine import ROUNDING, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, angle_between
from plumbline.harness.conformance.pairs import (
    ASTRAY,
    DURATION,
    LENGTHS,
    SAVED,
    STEP,
    SUBSTEPS,
    WRENCHES,
    Pair,
    PairPlan,
    all_pairs,
    task,
)
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State

DEFAULT_DAMPING = 0.16
"""The most [1/s] that a vendor's defaults take of a velocity on their own track: whether that is off on the other one is asked
elsewhere."""
_BECAUSE = (
    "a method of first order is off by dt/2 of what the acceleration changes by, and in position by dt/2 of the velocity "
    "gained; twice that, a sub-step of a velocity on a track that is declared as staggered, and 16 % a second for a damping "
    "that is on by default"
)


def carried_out(engine: Engine, plan: PairPlan, scene: Scene) -> State:
    """The state after `DURATION`, with the wrenches, lengths of steps and restoring of a plan."""
    steps, velocities = round(DURATION / STEP), _led(scene)
    lengths = [STEP * (LENGTHS[k % len(LENGTHS)] if plan.uneven else 1.0) for k in range(steps + ASTRAY)]
    if plan.uneven and "substeps" in engine.adapter.knobs:
        engine = replace(engine, settings=replace(engine.settings, substeps=SUBSTEPS))
    with engine.built(scene, STEP) as simulation:
        if plan.wrenches:
            pushes = [WRENCHES.get(body.name, (ORIGIN, ORIGIN)) for body in scene.bodies]
            simulation.wrench(np.array([f for f, _ in pushes]), np.array([tau for _, tau in pushes]))

        def step(first: int, last: int) -> None:
            if not plan.uneven and velocities is None:
                simulation.step(last - first)
                return
            for k in range(first, last):
                if plan.uneven:
                    simulation.retime(lengths[k])  # type: ignore[attr-defined]  # what an engine may offer, see the contract
                if velocities is not None:
                    simulation.prescribe(velocities(sum(lengths[:k]), lengths[k]))  # type: ignore[attr-defined]  # as above
                simulation.step()

        if plan.restored:
            step(0, SAVED)
            saved = simulation.save()
            step(SAVED, SAVED + ASTRAY)
            simulation.restore(saved)
            step(SAVED, steps)
        else:
            step(0, steps)
        return state_of(simulation, scene)


def _led(scene: Scene) -> Velocities | None:
    """The law of the bodies whose motion is prescribed; None where there are none."""
    control = acting(scene)
    return None if control is None else control.velocities


def compared(engine: Engine, pair: Pair) -> list[Compared]:
    """Positions, turns and velocities at the end, each within what the step allows on this motion."""
    plan, scene, exact = (worked_out := task(pair)).plan, worked_out.scene, worked_out.expected
    end = carried_out(engine, plan, scene)
    dt = STEP * (max(LENGTHS) if plan.uneven else 1.0)
    # What a body that is led says of its velocity is that of the step that led it there: asked elsewhere.
    moved = [k for k, body in enumerate(scene.bodies) if body.movable]
    fastest, spun = (float(np.linalg.norm(values, axis=1).max()) for values in (exact.v_WB, exact.w_WB))
    adapter, settings = engine.adapter, engine.settings
    lost = DEFAULT_DAMPING * DURATION if settings == adapter.tracks.get("default") else 0.0
    on = "on the world" if pair.hung else "on a body"
    # A led body moves through a step at the velocity of its middle, and takes along what hangs on it.
    staggered = any(settings == adapter.tracks[track] for track in adapter.staggered)
    substeps = SUBSTEPS if plan.uneven else settings.substeps or 1
    late = dt / DURATION * (1.0 if any(body.prescribed for body in scene.bodies) else staggered / substeps)
    turns = [angle_between(a, b) for a, b in zip(end.q_WB, exact.q_WB, strict=True)]
    v_off = dt * exact.varied + late * exact.gained + lost * fastest + ROUNDING
    w_off = dt * exact.swung + late * exact.turned + lost * spun + ROUNDING
    return all_near(
        (f"{on}: v_WB [m/s]", end.v_WB[moved], exact.v_WB[moved], v_off),
        (f"{on}: w_WB [rad/s]", end.w_WB[moved], exact.w_WB[moved], w_off),
        (f"{on}: p_WB [m]", end.p_WB, exact.p_WB, dt * exact.gained + lost * DURATION * fastest + ROUNDING),
        (f"{on}: turn [rad]", turns, np.zeros(len(turns)), dt * exact.turned + lost * DURATION * spun + ROUNDING),
        because=_BECAUSE,
    )


def _define(name: str, pairs: tuple[Pair, ...]) -> None:
    first, second = (noun.name for noun in pairs[0].nouns)

    @check(f"Do {first} and {second} stand together in one scene?", pairs[0].needs, name=name)
    def stand_together(engine: Engine) -> Comparisons:
        yield from (comparison for pair in pairs for comparison in compared(engine, pair))


for _name, _pairs in all_pairs():
    _define(_name, _pairs)
