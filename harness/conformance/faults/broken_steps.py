"""The planted faults of motion: of single steps, digits, forces, drives and saves."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation
from harness.conformance.exact import rotation
from harness.conformance.faults.plant import Rewritten, Wrapped, plant
from harness.scene import Body, Joint, Scene
from harness.trajectory import Floats, State

__all__ = [
    "CommandsFirstDriveOnly",
    "DeafToLengths",
    "DeafToUnknownJoints",
    "KinematicStandsStill",
    "NeverIdle",
    "NoGyroscopicTorque",
    "PushesAtShapes",
    "ReshapesWrench",
    "RestoreKeepsTargets",
    "RestoreKeepsWrench",
    "ReversedWrench",
    "SinglePrecision",
    "SlowIsStill",
    "TENTH",
    "TorqueDropped",
    "braked",
    "joined",
    "twice_the_step",
    "uneven",
]


def twice_the_step(adapter: Adapter) -> Adapter:
    """Each step advances 2 dt, and the settings in use say dt."""
    return plant(
        adapter,
        settings=lambda settings: settings.with_dt(2 * settings.dt),
        simulation=lambda inner, _, scene, settings: Wrapped(inner, scene, settings),
    )


class NoGyroscopicTorque(Wrapped):
    """Adds w x I w to every body in each step, which takes the gyroscopic torque away."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        n = len(scene.bodies)
        self._push: tuple[Floats, Floats] = np.zeros((n, 3)), np.zeros((n, 3))
        self._top = any(body.movable and np.ptp(np.linalg.eigvalsh(np.asarray(body.inertia))) > 0 for body in scene.bodies)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Kept, to be applied together with what is added."""
        self._push = f_B_W.copy(), tau_B_W.copy()
        self.inner.wrench(f_B_W, tau_B_W)

    def step(self, count: int = 1) -> None:
        """Step by step with the torque of the present state."""
        if not self._top:
            self.inner.step(count)
            return
        for _ in range(count):
            state, tau = self.now(), self._push[1].copy()
            for k, body in enumerate(self.scene.bodies):
                if body.movable:
                    R = rotation(state.q_WB[k])
                    # A spin whose square overflows is what a check asks for; the engine is told, and answers as it does.
                    with np.errstate(all="ignore"):
                        tau[k] += np.cross(state.w_WB[k], R @ np.asarray(body.inertia) @ R.T @ state.w_WB[k])
            self.inner.wrench(self._push[0], tau)
            self.inner.step()


class ReversedWrench(Wrapped):
    """Pushes the other way."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, with the other sign."""
        self.inner.wrench(-f_B_W, -tau_B_W)


TENTH = 10


def uneven(adapter: Adapter) -> Adapter:
    """Steps of .9 and 1.1 dt in turns."""

    class Uneven(Wrapped):
        _odd = False

        def step(self, count: int = 1) -> None:
            for _ in range(count):
                self.inner.step(TENTH + 1 if self._odd else TENTH - 1)
                self._odd = not self._odd

    return plant(
        adapter,
        settings=lambda settings: settings.with_dt(settings.dt / TENTH),
        simulation=lambda inner, _, scene, settings: Uneven(inner, scene, settings),
    )


def braked(rate: float) -> Callable[[Adapter], Adapter]:
    """Velocities lose `rate` [1/s]: by the engine's own damping where it has one, else in the state behind its back."""

    def edit(_: State, after: State, dt: float) -> bool:
        after.v_WB[:] *= 1 - rate * dt
        after.w_WB[:] *= 1 - rate * dt
        return True

    def slowed(scene: Scene) -> Scene:
        hidden = tuple(
            replace(b, linear_damping=b.linear_damping + rate, angular_damping=b.angular_damping + rate) if b.movable else b
            for b in scene.bodies
        )
        return replace(scene, bodies=hidden)

    def apply(adapter: Adapter) -> Adapter:
        if Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING in adapter.features:
            return plant(adapter, scene=slowed)
        return plant(adapter, simulation=lambda inner, engine, scene, settings: Rewritten(inner, engine, scene, settings, edit))

    return apply


def joined(change: Callable[[Any], Joint]) -> Callable[[Adapter], Adapter]:
    """Every joint is changed."""
    return lambda adapter: plant(
        adapter, scene=lambda scene: replace(scene, joints=tuple(change(joint) for joint in scene.joints))
    )


class NeverIdle(Wrapped):
    """Takes a step when none is asked for."""

    def step(self, count: int = 1) -> None:
        """As inside, at least once."""
        self.inner.step(max(count, 1))


class DeafToLengths(Wrapped):
    """Takes each step as long as it was built with."""

    def retime(self, dt: float) -> None:
        """Not heard."""


class SlowIsStill(Wrapped):
    """Reads speeds below a threshold as none."""

    threshold = 1e-3

    def state(self, out: State) -> None:
        """As inside, without what is slow."""
        self.inner.state(out)
        for array in (out.v_WB, out.w_WB):
            array[np.linalg.norm(array, axis=1) < self.threshold] = 0.0


class SinglePrecision(Wrapped):
    """Hands out what went through single precision."""

    def state(self, out: State) -> None:
        """As inside, with seven digits."""
        self.inner.state(out)
        for array in (out.p_WB, out.q_WB, out.v_WB, out.w_WB):
            array[:] = array.astype(np.float32)


class PushesAtShapes(Wrapped):
    """Applies forces where the first shape of a body is."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, with the moment of the lever at the present pose."""
        tau, state = tau_B_W.copy(), self.now()
        for k, body in enumerate(self.scene.bodies):
            if body.movable and body.collision:
                tau[k] += np.cross(rotation(state.q_WB[k]) @ np.array(body.collision[0].p_BS), f_B_W[k])
        self.inner.wrench(f_B_W, tau)


class TorqueDropped(Wrapped):
    """Applies forces and forgets torques."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, without the torque."""
        self.inner.wrench(f_B_W, np.zeros_like(tau_B_W))


class ReshapesWrench(Wrapped):
    """Makes do with what it gets: cuts, pads, casts and cleans."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, of whatever was handed in."""
        n = len(self.scene.bodies)
        made = (np.nan_to_num(np.resize(np.asarray(loads, dtype=np.float64), (n, 3))) for loads in (f_B_W, tau_B_W))
        self.inner.wrench(*made)


class CommandsFirstDriveOnly(Wrapped):
    """Commands reach the first drive of the scene."""

    def command(self, targets: Mapping[str, float]) -> None:
        """As inside, for the first drive alone."""
        driven = [joint.name for joint in self.scene.joints if getattr(joint, "drive", None) is not None]
        self.inner.command({name: target for name, target in targets.items() if name in driven[:1]})


class DeafToUnknownJoints(Wrapped):
    """Ignores commands to what it does not know."""

    def command(self, targets: Mapping[str, float]) -> None:
        """As inside, for drives of the scene."""
        driven = {joint.name for joint in self.scene.joints if getattr(joint, "drive", None) is not None}
        self.inner.command({name: target for name, target in targets.items() if name in driven})


class RestoreKeepsWrench(Wrapped):
    """The wrench outlives a restore."""

    _last: tuple[Floats, Floats] | None = None

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, and kept."""
        self.inner.wrench(f_B_W, tau_B_W)
        self._last = f_B_W.copy(), tau_B_W.copy()

    def restore(self, saved: object) -> None:
        """As inside, then the last wrench again."""
        self.inner.restore(saved)
        if self._last is not None:
            self.inner.wrench(*self._last)


class RestoreKeepsTargets(Wrapped):
    """The targets of drives outlive a restore."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._last: dict[str, float] = {}

    def command(self, targets: Mapping[str, float]) -> None:
        """As inside, and kept."""
        self.inner.command(targets)
        self._last.update(targets)

    def restore(self, saved: object) -> None:
        """As inside, then the last targets again."""
        self.inner.restore(saved)
        self.inner.command(self._last)


class KinematicStandsStill(Wrapped):
    """Kinematic bodies that stand still in the states."""

    def state(self, out: State) -> None:
        """As inside, kinematic bodies at their start."""
        self.inner.state(out)
        start = State.initial(self.scene)
        for k, body in enumerate(self.scene.bodies):
            if _kinematic(body):
                out.p_WB[k], out.q_WB[k] = start.p_WB[k], start.q_WB[k]


def _kinematic(body: Body) -> bool:
    return body.motion == "kinematic"
