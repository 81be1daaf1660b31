"""The planted faults of sensing: rays, pictures, inertial sensors of an engine, and what the harness lays over signals."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Settings, Simulation
from harness.conformance.faults.plant import Wrapped, plant
from harness.scene import (
    AxisNoise,
    Camera,
    Imu,
    ImuNoise,
    Scene,
)
from harness.trajectory import Floats, Hits, Image, Trajectory

__all__ = [
    "AnyDirection",
    "EndlessRays",
    "LateInertial",
    "LatePicture",
    "LateRays",
    "NormalsOfRaysReversed",
    "ThroughKinematic",
    "dropouts_follow_ranges",
    "late_pictures",
    "laws",
    "one_seed_for_all_sensors",
    "read_downwards",
    "reversed_triad",
    "share_seed",
    "without_levers",
    "without_mounts",
]


class EndlessRays(Wrapped):
    """Casts further than asked."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, ten times as far."""
        return self.inner.cast(origins, directions, 10 * max_range)


class ThroughKinematic(Wrapped):
    """Casts rays that kinematic bodies do not stop."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, hits on kinematic bodies lost."""
        hits = self.inner.cast(origins, directions, max_range)
        kinematic = [k for k, body in enumerate(self.scene.bodies) if body.motion == "kinematic"]
        lost = np.isin(hits.body, kinematic)
        return Hits(
            np.where(lost, np.inf, hits.distance), np.where(lost, -1, hits.body), np.where(lost[:, None], 0.0, hits.normal_W)
        )


class NormalsOfRaysReversed(Wrapped):
    """Hands out the normals of hits inwards."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, normals turned round."""
        hits = self.inner.cast(origins, directions, max_range)
        return replace(hits, normal_W=-hits.normal_W)


class AnyDirection(Wrapped):
    """Takes rays of any length."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, directions brought to length 1 without a word."""
        rays = np.nan_to_num(np.asarray(directions, dtype=np.float64))
        length = np.linalg.norm(rays, axis=1, keepdims=True)
        return self.inner.cast(origins, rays / np.where(length > 0, length, 1.0), max_range)


class LateRays(Wrapped):
    """Casts into the bodies of one step ago, as an engine does that forgets to update its broad phase."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings, twin: Simulation) -> None:
        super().__init__(inner, scene, settings)
        self.twin, self._behind = twin, False

    def step(self, count: int = 1) -> None:
        """As inside; the twin stays one step behind."""
        self.inner.step(count)
        if count > 0:
            self.twin.step(count if self._behind else count - 1)
            self._behind = True

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """By the twin."""
        return self.twin.cast(origins, directions, max_range)

    def close(self) -> None:
        """Both."""
        self.inner.close()
        self.twin.close()


class LatePicture(LateRays):
    """Draws what there was one step ago."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside."""
        return self.inner.cast(origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """By the twin."""
        return self.twin.render(camera, colour)


def late_pictures(adapter: Adapter) -> Adapter:
    """Pictures are one step late."""
    return plant(
        adapter,
        simulation=lambda inner, engine, scene, settings: LatePicture(inner, scene, settings, engine.build(scene, settings)),
    )


class LateInertial(Wrapped):
    """Its own accelerometer and gyroscope speak of one step ago."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._said: dict[str, tuple[Floats, Floats]] = {}

    def step(self, count: int = 1) -> None:
        """As inside; what the sensors said before the last step is kept."""
        if count > 1:
            self.inner.step(count - 1)
        own: Any = self.inner
        self._said = {sensor.name: own.inertial(sensor.name) for sensor in self.scene.sensors if isinstance(sensor, Imu)}
        if count > 0:
            self.inner.step()

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        """What was kept."""
        return self._said[name]


def _mounted(change: Callable[[Imu], Imu]) -> Callable[[Adapter], Adapter]:
    def changed_scene(scene: Scene) -> Scene:
        return replace(scene, sensors=tuple(change(sensor) if isinstance(sensor, Imu) else sensor for sensor in scene.sensors))

    return lambda adapter: plant(adapter, scene=changed_scene)


without_levers = _mounted(lambda imu: replace(imu, p_BS=(0.0, 0.0, 0.0)))
"""Inertial sensors sit at the centre of mass."""
without_mounts = _mounted(lambda imu: replace(imu, q_BS=(1.0, 0.0, 0.0, 0.0)))
"""Inertial sensors speak in the frame of their body."""


def laws(change: Callable[[AxisNoise], AxisNoise]) -> Callable[[Scene], Scene]:
    """The readers of inertial sensors follow another law than the scene's."""

    def changed_scene(scene: Scene) -> Scene:
        return replace(scene, sensors=tuple(_other(sensor) if isinstance(sensor, Imu) else sensor for sensor in scene.sensors))

    def _other(imu: Imu) -> Imu:
        if imu.noise is None:
            return imu
        return replace(
            imu, noise=ImuNoise(accelerometer=change(imu.noise.accelerometer), gyroscope=change(imu.noise.gyroscope))
        )

    return changed_scene


def reversed_triad(law: AxisNoise) -> AxisNoise:
    """The triad of a channel is turned the other way."""
    x, y, z = law.misalignment
    return replace(law, misalignment=(-x, -y, -z))


def one_seed_for_all_sensors(trajectory: Trajectory) -> Trajectory:
    """Every inertial sensor draws the first one's noise: the k-th of its readings carries what the first one's k-th carries."""
    streams: dict[str, Floats] = dict(trajectory.streams)
    first: dict[str, Floats] = {}
    for name, signal in trajectory.streams.items():
        channel, ideal = name.rsplit("/", 1)[-1], trajectory.streams.get(f"{name}_ideal")
        if channel in ("accelerometer", "gyroscope") and ideal is not None:
            noise = first.setdefault(channel, signal - ideal)
            count = min(len(noise), len(signal))
            streams[name] = np.concatenate([ideal[:count] + noise[:count], signal[count:]])
    return replace(trajectory, streams=streams)


def dropouts_follow_ranges(trajectory: Trajectory) -> Trajectory:
    """As many beams are dropped as before, those whose range noise is greatest, as one stream for both would have it."""
    streams = dict(trajectory.streams)
    for name, noisy in trajectory.streams.items():
        ideal = trajectory.streams.get(f"{name}_ideal")
        if not name.endswith("/range") or ideal is None:
            continue
        hit, heard = np.isfinite(ideal), np.isfinite(ideal) & np.isfinite(noisy)
        dropped = int(hit.sum() - heard.sum())
        noise = noisy[heard] - ideal[heard]
        # Those that were dropped get the noise of others that were not, so that all who hit have some.
        whole = np.zeros(noisy.shape)
        whole[heard] = noise
        whole[hit & ~heard] = noise[:dropped]
        lost = np.zeros(noisy.size, dtype=bool)
        lost[np.argsort(np.where(hit, whole, -np.inf), axis=None)[noisy.size - dropped :]] = True
        streams[name] = np.where(hit & ~lost.reshape(noisy.shape), ideal + whole, np.inf)
    return replace(trajectory, streams=streams)


def read_downwards(steps: Mapping[str, float]) -> Callable[[Trajectory], Trajectory]:
    """Readings of a channel are the level below the signal, in steps of steps[channel], and not the nearest."""

    def spoilt(trajectory: Trajectory) -> Trajectory:
        streams = dict(trajectory.streams)
        for name, signal in trajectory.streams.items():
            step = steps.get(name.rsplit("/", 1)[-1])
            if step is not None:
                streams[name] = step * np.floor(signal / step)
        return replace(trajectory, streams=streams)

    return spoilt


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
