"""The planted faults behind an engine"s back: hidden damping, clamps, sleep, and states that are repaired."""

from dataclasses import replace

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation
from harness.conformance.faults.plant import Repaired, Rewritten, plant
from harness.scene import (
    Body,
    Effect,
    Scene,
)
from harness.trajectory import State

__all__ = ["Sleepy", "clamped", "damped", "losing_speed", "repairing"]


def losing_speed(adapter: Adapter) -> Adapter:
    """Velocities lose 4 % a second: by the engine's own damping where it has one, else in the state behind its back."""
    damping = Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING
    if damping not in adapter.features:
        return plant(adapter, simulation=damped)

    def slowed(body: Body) -> Body:
        if not body.movable:
            return body
        return replace(body, linear_damping=body.linear_damping + 0.04, angular_damping=body.angular_damping + 0.04)

    def change(scene: Scene) -> Scene:
        hidden = Effect.LINEAR_DAMPING | Effect.ANGULAR_DAMPING
        return replace(scene, bodies=tuple(slowed(body) for body in scene.bodies), narrow=scene.narrow & ~hidden)

    return plant(adapter, scene=change)


def damped(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """Velocities lose 4 % a second."""

    def edit(_: State, after: State, dt: float) -> bool:
        after.v_WB[:] *= 1 - 0.04 * dt
        after.w_WB[:] *= 1 - 0.04 * dt
        return True

    return Rewritten(inner, adapter, scene, settings, edit)


def clamped(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """100 m/s and 100 rad/s are the most."""

    def edit(_: State, after: State, __: float) -> bool:
        cut = False
        for array in (after.v_WB, after.w_WB):
            size = np.linalg.norm(array, axis=1, keepdims=True)
            if (size > 100.0).any():
                array[:] *= np.minimum(1.0, 100.0 / np.maximum(size, 1e-300))
                cut = True
        return cut

    return Rewritten(inner, adapter, scene, settings, edit)


class Sleepy(Rewritten):
    """Below .1 m/s and .1 rad/s for .1 s a body is put to sleep; a faster push wakes it.

    Where all sleep and nothing pushes, the engine inside is not stepped: it would be built anew in each step.
    """

    def __init__(self, inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, adapter, scene, settings, self._put_to_sleep)
        self._quiet = np.zeros(len(scene.bodies))

    def _step_inside(self) -> None:
        pushed = self._push is not None and any(part.any() for part in self._push)
        if pushed or not (self._quiet > 0.1).all():
            super()._step_inside()

    def _put_to_sleep(self, before: State, after: State, dt: float) -> bool:
        slow = (np.linalg.norm(after.v_WB, axis=1) < 0.1) & (np.linalg.norm(after.w_WB, axis=1) < 0.1)
        self._quiet[:] = np.where(slow, self._quiet + dt, 0.0)
        asleep = self._quiet > 0.1
        if not (asleep.any() and (after.v_WB[asleep].any() or after.w_WB[asleep].any())):
            return False
        for target, source in ((after.p_WB, before.p_WB), (after.q_WB, before.q_WB)):
            target[asleep] = source[asleep]
        after.v_WB[asleep], after.w_WB[asleep] = 0.0, 0.0
        return True


def repairing(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """A broken state is replaced by the start at rest."""
    return Repaired(inner, adapter, scene, settings, lambda *_: False)
