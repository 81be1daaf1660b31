"""The planted faults themselves: each changes what an engine is told, or spoils one call of its simulation."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation, Unsupported
from harness.conformance.exact import rotation
from harness.conformance.faults.plant import Repaired, Rewritten, Wrapped, plant
from harness.scene import (
    Body,
    Box,
    Capsule,
    Effect,
    Matrix3,
    PlacedShape,
    Prismatic,
    Revolute,
    Scene,
    Sphere,
    Surface,
    principal_inertia,
)
from harness.trajectory import Contacts, Floats, Hits, State, Trajectory

__all__ = [
    "BodyAngularVelocity",
    "ClosesOnce",
    "Credulous",
    "EndlessRays",
    "FlippedNormal",
    "ForgetfulSave",
    "HalfForce",
    "NanWithoutAWord",
    "NoGyroscopicTorque",
    "NoSpinWritten",
    "OddWarnings",
    "OneStepBehind",
    "PositiveGap",
    "ReversedWrench",
    "ScalarLast",
    "Shuffled",
    "Taciturn",
    "approximating",
    "bodies",
    "capsule_to_sphere",
    "clamped",
    "damped",
    "deaf_to_methods",
    "deaf_to_options",
    "double_extents",
    "entangled",
    "gravity",
    "half_a_capsule",
    "joints",
    "losing_speed",
    "repairing",
    "rougher",
    "rounded",
    "share_seed",
    "sleepy",
    "stiffer",
    "surfaces",
    "swap_inertia",
    "told",
    "twice_the_step",
    "unrepeatable",
    "simulated",
    "wrapped",
]


def told(change: Callable[[Scene], Scene]) -> Callable[[Adapter], Adapter]:
    """The engine is told a changed scene."""
    return lambda adapter: plant(adapter, scene=change)


def simulated(simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation]) -> Callable[[Adapter], Adapter]:
    """The simulation is replaced by a spoilt one."""
    return lambda adapter: plant(adapter, simulation=simulation)


def wrapped(kind: type[Wrapped]) -> Callable[[Adapter], Adapter]:
    """The simulation is wrapped by that class."""
    return simulated(lambda inner, _, scene, settings: kind(inner, scene, settings))


def bodies(change: Callable[[Body], Body]) -> Callable[[Adapter], Adapter]:
    """Every body is changed."""
    return told(lambda scene: replace(scene, bodies=tuple(change(body) for body in scene.bodies)))


def gravity(factor: float) -> Callable[[Adapter], Adapter]:
    """Gravity times a factor."""

    def change(scene: Scene) -> Scene:
        x, y, z = scene.gravity
        return replace(scene, gravity=(factor * x, factor * y, factor * z))

    return told(change)


def surfaces(change: Callable[[Surface], Surface]) -> Callable[[Adapter], Adapter]:
    """Every surface is changed."""
    return told(lambda scene: replace(scene, surfaces=tuple(change(surface) for surface in scene.surfaces)))


def rougher(law: Surface) -> Surface:
    """Friction times 1.05."""
    return replace(law, static_friction=1.05 * law.static_friction, kinetic_friction=1.05 * law.kinetic_friction)


def swap_inertia(body: Body) -> Body:
    """The first two rows and columns of the inertia change places."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return replace(body, inertia=((yy, xy, yz), (xy, xx, xz), (yz, xz, zz)))


def double_extents(body: Body) -> Body:
    """Every box is twice as large."""

    def doubled(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Box(half_extents=(a, b, c)):
                return replace(placed, shape=Box(half_extents=(2 * a, 2 * b, 2 * c)))
            case _:
                return placed

    return replace(body, collision=tuple(doubled(placed) for placed in body.collision))


def capsule_to_sphere(body: Body) -> Body:
    """Every capsule becomes a sphere of .1 m."""
    kept = tuple(replace(p, shape=Sphere(radius=0.1)) if p.shape.type == "capsule" else p for p in body.collision)
    return replace(body, collision=kept)


def half_a_capsule(scene: Scene) -> Scene:
    """Beside boxes every capsule touches with one of its ends alone."""
    if not any(placed.shape.type == "box" for body in scene.bodies for placed in body.collision):
        return scene

    def halved(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Capsule(radius=r, half_length=h):
                end = rotation(np.array(placed.q_BS)) @ (0.0, 0.0, h) + np.array(placed.p_BS)
                return replace(placed, shape=Sphere(radius=r), p_BS=(float(end[0]), float(end[1]), float(end[2])))
            case _:
                return placed

    return replace(
        scene, bodies=tuple(replace(body, collision=tuple(halved(one) for one in body.collision)) for body in scene.bodies)
    )


def joints(change: Callable[[Revolute | Prismatic], Any]) -> Callable[[Adapter], Adapter]:
    """Every joint with a coordinate is changed."""

    def apply(scene: Scene) -> Scene:
        return replace(scene, joints=tuple(change(j) if isinstance(j, Revolute | Prismatic) else j for j in scene.joints))

    return told(apply)


def stiffer(joint: Revolute | Prismatic) -> Revolute | Prismatic:
    """Springs are 10 % stiffer."""
    return (
        joint if joint.spring is None else replace(joint, spring=replace(joint.spring, stiffness=1.1 * joint.spring.stiffness))
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


class FlippedNormal(Wrapped):
    """Hands out normals from B to A."""

    def contacts(self) -> Contacts:
        """As inside, the normal turned round."""
        got = self.inner.contacts()
        return replace(got, normal_W=-got.normal_W)


class PositiveGap(Wrapped):
    """Hands out penetration as a positive number."""

    def contacts(self) -> Contacts:
        """As inside, the gap with the other sign."""
        got = self.inner.contacts()
        return replace(got, gap=-got.gap)


class HalfForce(Wrapped):
    """Loses half of each contact force, as one who reads two impulses as one would."""

    def contacts(self) -> Contacts:
        """As inside, the forces halved."""
        got = self.inner.contacts()
        return replace(got, force_W=got.force_W / 2)


class EndlessRays(Wrapped):
    """Casts further than asked."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, ten times as far."""
        return self.inner.cast(origins, directions, 10 * max_range)


class ReversedWrench(Wrapped):
    """Pushes the other way."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, with the other sign."""
        self.inner.wrench(-f_B_W, -tau_B_W)


class ForgetfulSave(Wrapped):
    """Keeps nothing in a save, so that restore goes nowhere."""

    def save(self) -> object:
        """Nothing."""
        return None

    def restore(self, saved: object) -> None:
        """Nowhere."""


class ClosesOnce(Wrapped):
    """Fails when it is closed a second time."""

    _closed = False

    def close(self) -> None:
        """As inside, once."""
        if self._closed:
            raise RuntimeError("closed twice")
        self._closed = True
        self.inner.close()


class Taciturn(Wrapped):
    """Does not say what the engine uses."""

    @property
    def resolved(self) -> Settings:
        """Settings without content."""
        return Settings()


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


class OddWarnings(Wrapped):
    """Declares a surplus that is no effect."""

    def warnings(self) -> tuple[str, ...]:
        """One odd warning."""
        return ("surplus: magnetism",)


def unrepeatable(adapter: Adapter) -> Adapter:
    """Each build starts from another rounding of the same scene."""
    builds = iter(range(1, 1_000_000_000))

    def nudge(scene: Scene) -> Scene:
        step = 1e-12 * next(builds)
        return replace(scene, bodies=tuple(replace(b, p_WB=(b.p_WB[0] + step, *b.p_WB[1:])) for b in scene.bodies))

    return plant(adapter, scene=nudge)


def entangled(adapter: Adapter) -> Adapter:
    """Stepping one simulation steps all that are open, as one world behind all of them would."""
    opened: list[Simulation] = []

    class Entangled(Wrapped):
        def step(self, count: int = 1) -> None:
            for simulation in opened:
                simulation.step(count)

        def close(self) -> None:
            if self.inner in opened:
                opened.remove(self.inner)
            self.inner.close()

    def join(inner: Simulation, _: Adapter, scene: Scene, settings: Settings) -> Simulation:
        opened.append(inner)
        return Entangled(inner, scene, settings)

    return plant(adapter, simulation=join)


def deaf_to_methods(adapter: Adapter) -> Adapter:
    """An integrator or solver by an unknown name is replaced by the engine's own without a word."""

    def drop(settings: Settings) -> Settings:
        return replace(settings, integrator=None, solver=None)

    return plant(adapter, settings=drop)


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


def sleepy(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """Below .1 m/s and .1 rad/s for .1 s a body is put to sleep; a faster push wakes it."""
    quiet = np.zeros(len(scene.bodies))

    def edit(before: State, after: State, dt: float) -> bool:
        slow = (np.linalg.norm(after.v_WB, axis=1) < 0.1) & (np.linalg.norm(after.w_WB, axis=1) < 0.1)
        quiet[:] = np.where(slow, quiet + dt, 0.0)
        asleep = quiet > 0.1
        if not (asleep.any() and (after.v_WB[asleep].any() or after.w_WB[asleep].any())):
            return False
        for target, source in ((after.p_WB, before.p_WB), (after.q_WB, before.q_WB)):
            target[asleep] = source[asleep]
        after.v_WB[asleep], after.w_WB[asleep] = 0.0, 0.0
        return True

    return Rewritten(inner, adapter, scene, settings, edit)


def repairing(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """A broken state is replaced by the start at rest."""
    return Repaired(inner, adapter, scene, settings, lambda *_: False)


def twice_the_step(adapter: Adapter) -> Adapter:
    """Each step advances 2 dt, and the settings in use say dt."""
    return plant(
        adapter,
        settings=lambda settings: settings.with_dt(2 * settings.dt),
        simulation=lambda inner, _, scene, settings: Wrapped(inner, scene, settings),
    )


def deaf_to_options(adapter: Adapter) -> Adapter:
    """Unknown options are dropped without a word."""
    known = {name for settings in adapter.tracks.values() for name in settings.options}

    def drop(settings: Settings) -> Settings:
        return replace(settings, options={k: v for k, v in settings.options.items() if k in known})

    return plant(adapter, settings=drop)


@dataclass(frozen=True, kw_only=True)
class Credulous(Adapter):
    """Builds the nearest thing where the engine inside says Unsupported: the same bodies without shapes, joints and laws."""

    inner: Adapter

    def version(self) -> str:
        """The version of the engine inside. Raises: Unavailable."""
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """What the engine inside can, or something like it. Raises: Unavailable, SettingsError."""
        try:
            return self.inner.build(scene, settings)
        except Unsupported:
            bare = tuple(
                replace(b, collision=(), linear_damping=0.0, angular_damping=0.0, inertia=rounded(b))
                for b in scene.bodies
                if b.movable
            )
            return self.inner.build(Scene(bodies=bare, gravity=scene.gravity), settings)


def rounded(body: Body) -> Matrix3:
    """The spherical inertia [kg m2] of the same trace."""
    mean = float(np.trace(np.asarray(body.inertia))) / 3
    return principal_inertia(mean, mean, mean)


def approximating(adapter: Adapter) -> Adapter:
    """What is not supported is left out without a word."""
    return Credulous(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        inner=adapter,
    )


def share_seed(trajectory: Trajectory) -> Trajectory:
    """One seed for all that should differ: every axis of a stream (k, c) gets the noise of the first axis, about its own mean,
    and every scan of a stream (k, channels, columns) that of the first scan."""
    streams = dict(trajectory.streams)
    for name, signal in trajectory.streams.items():
        ideal = trajectory.streams.get(f"{name}_ideal")
        if not name.endswith("/time") and signal.ndim == 2 and len(signal) > 2:
            noise = signal[:, :1] - signal[:, :1].mean(axis=0)
            streams[name] = signal.mean(axis=0) + np.repeat(noise, signal.shape[1], axis=1)
        elif signal.ndim == 3 and ideal is not None:
            heard = np.isfinite(ideal[0])
            noise = np.where(heard, signal[0] - np.where(heard, ideal[0], 0.0), 0.0)
            streams[name] = ideal + noise
    return replace(trajectory, streams=streams)
