"""The planted faults of kinematic bodies that are led: not moved, moved late, or moved without a velocity."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.adapter import Adapter, Settings, Simulation
from harness.conformance.faults.plant import Rewritten, Wrapped
from harness.scene import Scene, Vector3, axis_angle, multiply
from harness.trajectory import State

__all__ = ["Deaf", "Late", "Teleported", "TurnsInPlace"]

Velocities = Mapping[str, tuple[Vector3, Vector3]]
_STILL: Vector3 = (0.0, 0.0, 0.0)


class Deaf(Wrapped):
    """Takes no notice of prescribed velocities."""

    def prescribe(self, velocities: Velocities) -> None:
        """Nothing."""


class Late(Wrapped):
    """Moves kinematic bodies as they were told before the last step."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._before: Velocities = {}

    def prescribe(self, velocities: Velocities) -> None:
        """What was told the last time."""
        inner: Any = self.inner
        inner.prescribe(self._before)
        self._before = velocities


class TurnsInPlace(Wrapped):
    """Turns kinematic bodies about their own middle, whatever the axis passes through."""

    def prescribe(self, velocities: Velocities) -> None:
        """Without the way of what turns."""
        inner: Any = self.inner
        inner.prescribe({name: (_STILL if any(w) else v, w) for name, (v, w) in velocities.items()})


class Teleported(Rewritten):
    """Puts kinematic bodies where they belong after each step, and tells contacts nothing of their velocity."""

    def __init__(self, inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, adapter, scene, settings, self._put)
        self._velocities: Velocities = {}

    def prescribe(self, velocities: Velocities) -> None:
        """Kept for the pose alone."""
        self._velocities = velocities

    def _put(self, _: State, after: State, dt: float) -> bool:
        """Move the poses on."""
        for name, (v, w) in self._velocities.items():
            k = self.scene.index(name)
            after.p_WB[k] += dt * np.array(v)
            speed = float(np.linalg.norm(w))
            if speed > 0.0:
                q_w, q_x, q_y, q_z = (float(c) for c in after.q_WB[k])
                after.q_WB[k] = multiply(axis_angle(w, speed * dt), (q_w, q_x, q_y, q_z))
            after.v_WB[k] = after.w_WB[k] = 0.0
        return bool(self._velocities)
