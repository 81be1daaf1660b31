"""The planted faults of states: poses and velocities handed out wrongly, too late, or not at all."""

import numpy as np

from harness.adapter import Settings, Simulation
from harness.conformance.exact import rotation
from harness.conformance.faults.plant import Wrapped
from harness.scene import (
    Scene,
)
from harness.trajectory import State

__all__ = ["BodyAngularVelocity", "NanWithoutAWord", "NoSpinWritten", "OneStepBehind", "ScalarLast", "Shuffled"]


class BodyAngularVelocity(Wrapped):
    """Hands out w in B."""

    def state(self, out: State) -> None:
        """As inside, w turned into B."""
        self.inner.state(out)
        for k in range(len(out.w_WB)):
            out.w_WB[k] = rotation(out.q_WB[k]).T @ out.w_WB[k]


class ScalarLast(Wrapped):
    """Hands out (x, y, z, w)."""

    def state(self, out: State) -> None:
        """As inside, the quaternion's components in another order."""
        self.inner.state(out)
        out.q_WB[:] = np.roll(out.q_WB, -1, axis=1)


class Shuffled(Wrapped):
    """Hands out the bodies in another order."""

    def state(self, out: State) -> None:
        """As inside, the first body last."""
        self.inner.state(out)
        for array in (out.p_WB, out.q_WB, out.v_WB, out.w_WB):
            array[:] = np.roll(array, -1, axis=0)


class OneStepBehind(Wrapped):
    """Hands out the state of one step ago."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._before = self.now()

    def step(self, count: int = 1) -> None:
        """As inside; the state before the last step is kept."""
        if count > 1:
            self.inner.step(count - 1)
        self._before = self.now()
        self.inner.step()

    def state(self, out: State) -> None:
        """The kept state."""
        for target, source in zip(
            (out.p_WB, out.q_WB, out.v_WB, out.w_WB),
            (self._before.p_WB, self._before.q_WB, self._before.v_WB, self._before.w_WB),
            strict=True,
        ):
            target[:] = source


class NoSpinWritten(Wrapped):
    """Leaves w as it finds it."""

    def state(self, out: State) -> None:
        """As inside, without w."""
        self.inner.state(State(out.p_WB, out.q_WB, out.v_WB, out.w_WB.copy()))


class NanWithoutAWord(Wrapped):
    """After some steps positions are NaN, and no exception says so."""

    _steps = 0

    def step(self, count: int = 1) -> None:
        """As inside, counted."""
        self._steps += count
        self.inner.step(count)

    def state(self, out: State) -> None:
        """As inside, NaN after fifty steps."""
        self.inner.state(out)
        if self._steps > 50:
            out.p_WB[:] = np.nan
