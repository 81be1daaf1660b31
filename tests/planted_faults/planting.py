"""How a fault is planted: a wrapped adapter that changes the scene, the settings or the simulation of the engine inside."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Diverged, Settings, Simulation
from plumbline.harness.scene import (
    AxisNoise,
    Body,
    Imu,
    ImuNoise,
    Joint,
    PlacedShape,
    Prismatic,
    Revolute,
    Scene,
    Surface,
    Vector3,
)
from plumbline.harness.trajectory import Floats, State

Change = Callable[[Scene], Scene]


def _same(unchanged: Any, *_: object) -> Any:
    return unchanged


@dataclass(frozen=True, kw_only=True)
class Broken(Adapter):
    """An adapter with one planted fault around a sound one; it declares nothing, so that a fault can hide behind nothing."""

    inner: Adapter
    scene: Change = _same
    settings: Callable[[Settings], Settings] = _same
    simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation] = _same

    def version(self) -> str:
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """The engine inside, told something else or read wrongly."""
        changed, solved = self.scene(scene), self.settings(settings)
        return self.simulation(self.inner.build(changed, solved), self.inner, changed, settings)


def plant(adapter: Adapter, kind: type[Broken] = Broken, **changes: Callable[..., Any]) -> Adapter:
    """The adapter with a fault in what the engine is told (scene, settings) or in what it does (simulation)."""
    return kind(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        knobs=adapter.knobs,
        inner=adapter,
        **changes,
    )


class Wrapped:
    """A simulation that passes every call on to the one inside; faults override the calls that they spoil."""

    def __init__(self, inner: Simulation, engine: Adapter, scene: Scene, settings: Settings) -> None:
        self.inner, self.engine, self.scene, self.asked = inner, engine, scene, settings
        self.start()

    def start(self) -> None:
        """What a fault keeps from before the first step."""

    @property
    def resolved(self) -> Settings:
        """What the engine says, at the step that was asked for: the fault is a silent one."""
        return replace(self.inner.resolved, dt=self.asked.dt)

    def __getattr__(self, name: str) -> Any:
        """Every other call, and what is offered beyond the protocol where the engine inside offers it."""
        if name.startswith("_") or name == "inner":
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return getattr(self.inner, name)

    def now(self) -> State:
        """The state of the engine inside, in fresh arrays."""
        out = State.empty(len(self.scene.bodies))
        self.inner.state(out)
        return out


class Rewritten(Wrapped):
    """A simulation whose state is edited after each step and put back into the engine by building it anew.

    Joints are anchored where the scene starts, so scenes with joints are left as they are.
    """

    _push: tuple[Floats, Floats] | None = None

    def edit(self, before: State, after: State, dt: float) -> bool:
        """Change the state after a step of dt [s] in place; was it changed?"""
        return False

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
            if self.edit(before, after, self.asked.dt):
                self.replace_state(after)

    def _step_inside(self) -> None:
        self.inner.step()

    def replace_state(self, state: State) -> None:
        """Build the engine anew from another state."""
        bodies = tuple(_moved(body, state, k) for k, body in enumerate(self.scene.bodies))
        self.inner.close()
        self.inner = self.engine.build(replace(self.scene, bodies=bodies), self.asked)
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


def gravity_times(scene: Scene, factor: float) -> Scene:
    """Gravity times a factor."""
    x, y, z = scene.gravity
    return replace(scene, gravity=(factor * x, factor * y, factor * z))


def every_body(change: Callable[[Body], Body]) -> Change:
    """The scene with every body changed."""
    return lambda scene: replace(scene, bodies=tuple(change(body) for body in scene.bodies))


def every_shape(change: Callable[[PlacedShape], PlacedShape]) -> Change:
    """The scene with every shape of every body changed."""
    return every_body(lambda body: replace(body, collision=tuple(change(placed) for placed in body.collision)))


def every_surface(change: Callable[[Surface], Surface]) -> Change:
    """The scene with every surface changed."""
    return lambda scene: replace(scene, surfaces=tuple(change(surface) for surface in scene.surfaces))


def every_joint(change: Callable[[Any], Joint]) -> Change:
    """The scene with every joint changed."""
    return lambda scene: replace(scene, joints=tuple(change(joint) for joint in scene.joints))


def every_coordinate(change: Callable[[Any], Joint]) -> Change:
    """The scene with every joint that has a coordinate changed."""
    return every_joint(lambda joint: change(joint) if isinstance(joint, Revolute | Prismatic) else joint)


def every_imu(change: Callable[[Imu], Imu]) -> Change:
    """The scene with every inertial sensor changed."""
    return lambda scene: replace(scene, sensors=tuple(change(s) if isinstance(s, Imu) else s for s in scene.sensors))


def every_noise(change: Callable[[AxisNoise], AxisNoise]) -> Change:
    """The scene with every law of inertial noise changed."""

    def changed(imu: Imu) -> Imu:
        if imu.noise is None:
            return imu
        return replace(
            imu, noise=ImuNoise(accelerometer=change(imu.noise.accelerometer), gyroscope=change(imu.noise.gyroscope))
        )

    return every_imu(changed)
