"""The planted faults of sensing: rays, pictures, an engine's own sensors, and what is laid over their signals."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.rotations import principal_frame
from plumbline.harness.scene import WORLD, AxisNoise, Body, Camera, Imu, Scene, Sensor, multiply, rotate
from plumbline.harness.trajectory import Floats, Hits, Image, Trajectory
from tests.planted_faults.fault import fault
from tests.planted_faults.planting import Wrapped

_R = Feature.BOX | Feature.RENDER


class _WithATwin(Wrapped):
    """Beside the simulation runs another one, a step behind."""

    def start(self) -> None:
        self.twin, self._behind = self.engine.build(self.scene, self.asked), False

    def step(self, count: int = 1) -> None:
        self.inner.step(count)
        if count > 0:
            self.twin.step(count if self._behind else count - 1)
            self._behind = True

    def close(self) -> None:
        self.inner.close()
        self.twin.close()


def _read_downwards(steps: Mapping[str, float]) -> Callable[[Trajectory], Trajectory]:
    """Readings of a channel are the level below the signal, in steps of steps[channel], and not the nearest."""

    def spoilt(trajectory: Trajectory) -> Trajectory:
        streams = dict(trajectory.streams)
        for name, signal in trajectory.streams.items():
            step = steps.get(name.rsplit("/", 1)[-1])
            if step is not None:
                streams[name] = step * np.floor(signal / step)
        return replace(trajectory, streams=streams)

    return spoilt


@fault("noise_axes_are_independent", cases=("sensor_imu_noise", "sensor_lidar_noise"))
def noise_from_one_seed(trajectory: Trajectory) -> Trajectory:
    """all axes of a sensor draw the same noise

    Every axis of a stream (k, c) gets the noise of the first axis, about its own mean, and every scan of a stream
    (k, channels, columns) that of the first scan.
    """
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


@fault("ray_beyond_max_range_misses", needs=Feature.RAYS)
class rays_without_end(Wrapped):
    """rays reach ten times as far as asked"""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        return self.inner.cast(origins, directions, 10 * max_range)


@fault("image_is_z_depth", "image_is_cut_near_the_camera", needs=_R)
class range_for_depth(Wrapped):
    """depth images hold distances from the pinhole"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        seen = self.inner.render(camera, colour)
        u = (np.arange(camera.width) + 0.5 - camera.centre_x) / camera.focal_x
        v = (np.arange(camera.height) + 0.5 - camera.centre_y) / camera.focal_y
        long: Floats = np.sqrt(1.0 + u[None, :] ** 2 + v[:, None] ** 2)
        return replace(seen, depth=seen.depth * long)


@fault("pixel_centre_is_at_half", needs=_R)
class half_a_pixel_off(Wrapped):
    """the centre of the first pixel is taken to be at (0, 0)"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        moved = replace(camera, centre_x=camera.centre_x + 0.5, centre_y=camera.centre_y + 0.5)
        return self.inner.render(moved, colour)


@fault("camera_is_mounted_on_what_turns", needs=_R)
class focal_lengths_exchanged(Wrapped):
    """the focal length along x is taken along y, and the other way round"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        return self.inner.render(replace(camera, focal_x=camera.focal_y, focal_y=camera.focal_x), colour)


@fault("camera_is_mounted_on_what_turns", needs=_R)
class camera_turned_before_its_body(Wrapped):
    """the turn of a camera on its body and the turn of the body are multiplied in the other order"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        if camera.body == WORLD:
            return self.inner.render(camera, colour)
        w, x, y, z = (float(c) for c in self.now().q_WB[self.scene.index(camera.body)])
        exchanged = multiply((w, -x, -y, -z), multiply(camera.q_BS, (w, x, y, z)))
        return self.inner.render(replace(camera, q_BS=exchanged), colour)


@fault("lidar_reads_between_its_bounds", needs=Feature.RAYS | Feature.BOX)
class rays_pass_what_is_near(Wrapped):
    """rays meet nothing within the first 1.5 m, and go on"""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        near = self.inner.cast(origins, directions, max_range)
        beyond = self.inner.cast(origins + 1.5 * directions, directions, max_range - 1.5)
        beyond = replace(beyond, distance=beyond.distance + 1.5)
        passed = near.distance < 1.5
        return Hits(
            np.where(passed, beyond.distance, near.distance),
            np.where(passed, beyond.body, near.body),
            np.where(passed[:, None], beyond.normal_W, near.normal_W),
        )


@fault("image_names_bodies", needs=_R)
class misnamed_bodies(Wrapped):
    """images count bodies from 1"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        seen = self.inner.render(camera, colour)
        return replace(seen, body=np.where(seen.body >= 0, seen.body + 1, -1))


@fault("image_is_cut_near_the_camera", needs=_R)
class distant_near_plane(Wrapped):
    """images leave out what is nearer than half a metre"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        seen = self.inner.render(camera, colour)
        near = seen.depth < 0.5
        return replace(seen, depth=np.where(near, np.inf, seen.depth), body=np.where(near, -1, seen.body))


@fault("image_is_lit_by_sun_and_sky", needs=_R)
class encoded_colours(Wrapped):
    """colours are encoded for screens"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        seen = self.inner.render(camera, colour)
        return seen if seen.colour is None else replace(seen, colour=seen.colour ** (1 / 2.2))


@fault("ray_traced_image_has_shadows", needs=Feature.RAY_TRACING | Feature.BOX)
class shadows_left_out(Wrapped):
    """a rasterised image is passed off as a ray-traced one"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        return self.inner.render(replace(camera, renderer="rasterised", distortion=None), colour)


@fault("rays_meet_kinematic_bodies", needs=Feature.RAYS | Feature.KINEMATIC | Feature.BOX | Feature.SPHERE)
class rays_pass_kinematic_bodies(Wrapped):
    """rays pass through kinematic bodies"""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        hits = self.inner.cast(origins, directions, max_range)
        kinematic = [k for k, body in enumerate(self.scene.bodies) if body.motion == "kinematic"]
        lost = np.isin(hits.body, kinematic)
        return Hits(
            np.where(lost, np.inf, hits.distance), np.where(lost, -1, hits.body), np.where(lost[:, None], 0.0, hits.normal_W)
        )


@fault("rays_meet_what_collides", needs=Feature.RAYS | Feature.BOX)
def rays_meet_what_is_drawn(body: Body) -> Body:
    """rays meet the shapes that are drawn"""
    return body if body.visual is None else replace(body, collision=body.visual)


@fault(
    "rays_see_the_present_state",
    "rays_meet_turned_shapes_of_a_body_that_turns",
    needs=Feature.RAYS | Feature.SPHERE | Feature.BOX,
)
class rays_one_step_late(_WithATwin):
    """rays meet bodies where they were one step ago

    So does an engine that forgets to update its broad phase.
    """

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        return self.twin.cast(origins, directions, max_range)


@fault("ray_names_body_and_normal", needs=Feature.RAYS)
class normals_of_rays_reversed(Wrapped):
    """the normals of hits point inwards"""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        hits = self.inner.cast(origins, directions, max_range)
        return replace(hits, normal_W=-hits.normal_W)


@fault("bad_rays_are_refused", needs=Feature.RAYS)
class rays_of_any_length(Wrapped):
    """directions are brought to length 1 without a word"""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        rays = np.nan_to_num(np.asarray(directions, dtype=np.float64))
        length = np.linalg.norm(rays, axis=1, keepdims=True)
        return self.inner.cast(origins, rays / np.where(length > 0, length, 1.0), max_range)


@fault("pictures_show_the_present", needs=Feature.RENDER | Feature.BOX | Feature.SPHERE)
class picture_one_step_late(_WithATwin):
    """pictures show what there was one step ago"""

    def render(self, camera: Camera, colour: bool = True) -> Image:
        return self.twin.render(camera, colour)


@fault("inertial_sensors_say_what_they_feel", needs=Feature.WRENCH)
def lever_of_the_accelerometer_dropped(imu: Imu) -> Imu:
    """the engine's own accelerometer sits at the centre of mass"""
    return replace(imu, p_BS=(0.0, 0.0, 0.0))


@fault("inertial_sensors_say_what_they_feel", needs=Feature.WRENCH)
def own_sensors_in_the_body_frame(imu: Imu) -> Imu:
    """the engine's own sensors speak in the frame of their body"""
    return replace(imu, q_BS=(1.0, 0.0, 0.0, 0.0))


@fault("inertial_sensors_say_what_they_feel", needs=Feature.WRENCH)
class own_sensors_one_step_late(Wrapped):
    """the engine's own sensors speak of one step ago"""

    def start(self) -> None:
        self._said: dict[str, tuple[Floats, Floats]] = {}

    def step(self, count: int = 1) -> None:
        if count > 1:
            self.inner.step(count - 1)
        self._said = {sensor.name: self.inner.inertial(sensor.name) for sensor in self.scene.sensors if isinstance(sensor, Imu)}
        if count > 0:
            self.inner.step()

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        return self._said[name]


@fault("inertial_sensors_say_what_they_feel", "inertial_sensors_feel_their_support", needs=Feature.WRENCH)
class units_of_own_sensors_exchanged(Wrapped):
    """the engine's own accelerometer speaks in rad/s, its gyroscope in m/s2: each tells what the other feels"""

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        force, rate = self.inner.inertial(name)
        return rate, force


@fault("inertial_sensors_on_turned_principal_axes", needs=Feature.WRENCH | Feature.FULL_INERTIA)
def own_sensors_in_the_principal_frame(scene: Scene) -> Scene:
    """the engine's own sensors are mounted on the principal axes of their body"""

    def moved(imu: Sensor) -> Sensor:
        if not isinstance(imu, Imu):
            return imu
        _, q_BM = principal_frame(scene.body(imu.body))
        return replace(imu, p_BS=rotate(q_BM, imu.p_BS), q_BS=multiply(q_BM, imu.q_BS))

    return replace(scene, sensors=tuple(moved(sensor) for sensor in scene.sensors))


@fault(cases=("sensor_streams",))
def one_seed_for_all_sensors(trajectory: Trajectory) -> Trajectory:
    """all inertial sensors draw the same noise

    The k-th reading of each carries what the first one's k-th carries.
    """
    streams: dict[str, Floats] = dict(trajectory.streams)
    first: dict[str, Floats] = {}
    for name, signal in trajectory.streams.items():
        channel, ideal = name.rsplit("/", 1)[-1], trajectory.streams.get(f"{name}_ideal")
        if channel in ("accelerometer", "gyroscope") and ideal is not None:
            noise = first.setdefault(channel, signal - ideal)
            count = min(len(noise), len(signal))
            streams[name] = np.concatenate([ideal[:count] + noise[:count], signal[count:]])
    return replace(trajectory, streams=streams)


@fault(cases=("sensor_lidar_noise",))
def dropouts_follow_ranges(trajectory: Trajectory) -> Trajectory:
    """range noise and dropouts come from one stream

    As many beams are dropped as before, those whose range noise is greatest.
    """
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


@fault(cases=("sensor_imu_readout",))
def misalignment_reversed(law: AxisNoise) -> AxisNoise:
    """the triad of an inertial channel is turned the other way"""
    x, y, z = law.misalignment
    return replace(law, misalignment=(-x, -y, -z))


@fault(cases=("sensor_imu_readout",))
def scale_error_dropped(law: AxisNoise) -> AxisNoise:
    """the scale error of an inertial channel is left out"""
    return replace(law, scale_error=0.0)


@fault(cases=("sensor_imu_readout",), spoil=_read_downwards({"accelerometer": 0.05, "gyroscope": 0.02}))
def rounded_downwards(law: AxisNoise) -> AxisNoise:
    """readings are rounded down instead of to the nearest step"""
    return replace(law, quantisation=0.0)


@fault(cases=("sensor_imu_readout",))
def saturation_dropped(law: AxisNoise) -> AxisNoise:
    """readings go beyond their bound"""
    return replace(law, saturation=None)


@fault(cases=("sensor_imu_noise",))
def random_walk_strong_by_sqrt_2(law: AxisNoise) -> AxisNoise:
    """the random walk of inertial noise is sqrt(2) times as strong"""
    return replace(law, random_walk=sqrt(2) * law.random_walk)


@fault(cases=("sensor_imu_noise", "sensor_streams"))
def white_noise_weak_by_sqrt_2(law: AxisNoise) -> AxisNoise:
    """the white noise of an inertial channel is taken for a one-sided density"""
    return replace(law, density=law.density / sqrt(2))
