"""How a fault is planted: a wrapped adapter that changes the scene, the settings or the simulation of the engine inside."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Diverged, Notice, Settings, Simulation
from harness.scene import Body, Camera, Scene, Vector3
from harness.trajectory import Contacts, Floats, Hits, Image, State

__all__ = ["Broken", "Edit", "Repaired", "Rewritten", "Wrapped", "plant", "simulated", "changed_scene", "wrapped"]


BEYOND = ("inertial", "caster", "force_lead", "joint_states", "prescribe", "retime")
"""What a simulation may offer beyond the protocol, see `harness.adapter`."""


def _same_scene(scene: Scene) -> Scene:
    return scene


def _same_settings(settings: Settings) -> Settings:
    return settings


def _same_simulation(simulation: Simulation, *_: Adapter | Scene | Settings) -> Simulation:
    return simulation


@dataclass(frozen=True, kw_only=True)
class Broken(Adapter):
    """An adapter with one planted fault around a sound one; it declares nothing, so that a fault can hide behind nothing."""

    inner: Adapter
    scene: Callable[[Scene], Scene] = _same_scene
    settings: Callable[[Settings], Settings] = _same_settings
    simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation] = _same_simulation

    def version(self) -> str:
        """The version of the engine inside. Raises: Unavailable."""
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """The engine inside, told something else or read wrongly. Raises: Unsupported, Unavailable, SettingsError."""
        changed, solved = self.scene(scene), self.settings(settings)
        return self.simulation(self.inner.build(changed, solved), self.inner, changed, settings)


def plant(
    adapter: Adapter,
    *,
    scene: Callable[[Scene], Scene] = _same_scene,
    settings: Callable[[Settings], Settings] = _same_settings,
    simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation] = _same_simulation,
) -> Adapter:
    """The adapter with a fault in what the engine is told (scene, settings) or in what it does (simulation)."""
    return Broken(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        inner=adapter,
        scene=scene,
        settings=settings,
        simulation=simulation,
    )


class Wrapped:
    """A simulation that passes every call on to the one inside; faults override the call that they spoil."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        self.inner, self.scene, self.asked = inner, scene, settings

    @property
    def resolved(self) -> Settings:
        """What the engine says, at the step that was asked for: the fault is a silent one."""
        return replace(self.inner.resolved, dt=self.asked.dt)

    def step(self, count: int = 1) -> None:
        """As inside."""
        self.inner.step(count)

    def state(self, out: State) -> None:
        """As inside."""
        self.inner.state(out)

    def contacts(self) -> Contacts:
        """As inside."""
        return self.inner.contacts()

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside."""
        return self.inner.cast(origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """As inside."""
        return self.inner.render(camera, colour)

    def command(self, targets: Mapping[str, float]) -> None:
        """As inside."""
        self.inner.command(targets)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside."""
        self.inner.wrench(f_B_W, tau_B_W)

    def warnings(self) -> tuple[str | Notice, ...]:
        """As inside."""
        return self.inner.warnings()

    def save(self) -> object:
        """As inside."""
        return self.inner.save()

    def restore(self, saved: object) -> None:
        """As inside."""
        self.inner.restore(saved)

    def close(self) -> None:
        """As inside."""
        self.inner.close()

    def __getattr__(self, name: str) -> Any:
        """What is offered beyond the protocol, where the engine inside offers it."""
        if name in BEYOND:
            return getattr(self.inner, name)
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")

    def now(self) -> State:
        """The state of the engine inside, in fresh arrays."""
        out = State.empty(len(self.scene.bodies))
        self.inner.state(out)
        return out


Edit = Callable[[State, State, float], bool]
"""(state before the step, state after it, dt [s]): changes the latter in place and says whether it did."""


class Rewritten(Wrapped):
    """A simulation whose state is edited after each step and put back into the engine by building it anew.

    Joints are anchored where the scene starts, so scenes with joints are left as they are.
    """

    def __init__(self, inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings, edit: Edit) -> None:
        super().__init__(inner, scene, settings)
        self._adapter, self._edit = adapter, edit
        self._push: tuple[Floats, Floats] | None = None

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, and kept for the engine that is built anew."""
        self.inner.wrench(f_B_W, tau_B_W)
        self._push = f_B_W.copy(), tau_B_W.copy()

    def step(self, count: int = 1) -> None:
        """One step at a time, each followed by the edit."""
        if self.scene.joints:
            self.inner.step(count)
            return
        for _ in range(count):
            before = self.now()
            self._step_inside()
            after = self.now()
            if self._edit(before, after, self.asked.dt):
                self.replace_state(after)

    def _step_inside(self) -> None:
        self.inner.step()

    def replace_state(self, state: State) -> None:
        """Build the engine anew from another state."""
        bodies = tuple(_moved(body, state, k) for k, body in enumerate(self.scene.bodies))
        self.inner.close()
        self.inner = self._adapter.build(replace(self.scene, bodies=bodies), self.asked)
        if self._push is not None:
            self.inner.wrench(*self._push)


class Repaired(Rewritten):
    """An engine that answers NaN and overflow by a fresh start at rest, without a word."""

    def _step_inside(self) -> None:
        try:
            self.inner.step()
            broken = not self.now().finite
        except Diverged:
            broken = True
        if broken:
            start = State.initial(self.scene)
            start.v_WB[:], start.w_WB[:] = 0.0, 0.0
            self._push = None
            self.replace_state(start)


def changed_scene(change: Callable[[Scene], Scene]) -> Callable[[Adapter], Adapter]:
    """The engine is told a changed scene."""
    return lambda adapter: plant(adapter, scene=change)


def simulated(simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation]) -> Callable[[Adapter], Adapter]:
    """The simulation is replaced by a spoilt one."""
    return lambda adapter: plant(adapter, simulation=simulation)


def wrapped(kind: type[Wrapped]) -> Callable[[Adapter], Adapter]:
    """The simulation is wrapped by that class."""
    return simulated(lambda inner, _, scene, settings: kind(inner, scene, settings))


def _vector(row: Floats) -> Vector3:
    x, y, z = (float(c) for c in row)
    return (x, y, z)


def _moved(body: Body, state: State, k: int) -> Body:
    """The body in the k-th pose and velocity of a state; static bodies stay."""
    if body.motion == "static":
        return body
    w, x, y, z = (float(c) for c in state.q_WB[k] / np.linalg.norm(state.q_WB[k]))
    return replace(
        body, p_WB=_vector(state.p_WB[k]), q_WB=(w, x, y, z), v_WB=_vector(state.v_WB[k]), w_WB=_vector(state.w_WB[k])
    )
