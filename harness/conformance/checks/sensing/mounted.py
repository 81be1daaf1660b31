"""Checks of sensors as they are read on a body that flies and turns: frames, bounds, errors, noise, judged by matrices alone.

Scans and frames are taken inside a room of six walls, whose ranges have a closed form; a small box stands near. What is
expected starts from the states that the engine gives, which other checks judge, and shares nothing with `harness.sensors`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.conformance.check import Comparison, Finding, check, judge, near, that
from plumbline.harness.conformance.exact import first_hit, rotation, turned_by
from plumbline.harness.conformance.runs import COARSE, ROUNDING, built, state_of
from plumbline.harness.conformance.scenes import TURNED, G, free, static
from plumbline.harness.scene import (
    Appearance,
    AxisNoise,
    Body,
    Box,
    Camera,
    DepthCamera,
    Imu,
    ImuNoise,
    Lidar,
    LidarNoise,
    Quaternion,
    Scene,
    Sensor,
    StereoNoise,
    TimeOfFlightNoise,
    axis_angle,
    multiply,
)
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.trajectory import Floats, State

_MOUNT: dict[str, Any] = {
    "body": "carrier",
    "p_BS": (0.4, -0.3, 0.2),
    "q_BS": multiply(axis_angle((0.0, 1.0, 0.0), -0.9), axis_angle((3.0, -1.0, 2.0), 0.6)),
}
"""On a lever and askew, so that no two rotations may change places."""
_SEED = 5
_SIGMAS = 5.0
"""Standard deviations that a statistic of noise may be off; its seed is fixed, so that it is off alike each time."""
_LOW, _HIGH = np.array([-4.0, -3.0, -2.0]), np.array([5.0, 6.0, 4.0])
"""Corners of the room [m]."""
_NEAR: tuple[float, float, float] = (0.35, 0.45, 0.55)
"""Half extents [m] of the box."""
_WALLS = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
"""Reflectivities of the walls, the low and the high one along x, y and z, and of the box."""


def _carrier(**fields: Any) -> Body:
    return replace(free("carrier", moments=(0.3, 0.2, 0.25), q=TURNED), **fields)


def _read(adapter: Adapter, settings: Settings, scene: Scene, steps: int) -> tuple[dict[str, Floats], list[State]]:
    """The streams of a scene's sensors after so many steps, and the states at all of them, the start's first."""
    with built(adapter, scene, settings) as simulation:
        recorder = SensorRecorder(scene, simulation, _SEED, settings.dt)
        states = [state_of(simulation, scene)]
        recorder.read(0.0, states[0])
        for k in range(1, steps + 1):
            simulation.step(1)
            states.append(state_of(simulation, scene))
            if k % recorder.interval_steps == 0:
                recorder.read(k * settings.dt, states[k])
        return recorder.streams(), states


def _in_a_room(*sensors: Sensor, **carried: Any) -> Scene:
    """The carrier in the middle of the room, and the box beside it."""
    middle, half = (_LOW + _HIGH) / 2, (_HIGH - _LOW) / 2
    bodies = [_carrier(**carried)]
    for axis, name in enumerate("xyz"):
        for side in (-1.0, 1.0):
            centre, extents = middle.copy(), half + 1.0
            centre[axis], extents[axis] = middle[axis] + side * (half[axis] + 0.5), 0.5
            x, y, z = (float(c) for c in centre)
            wall = static(f"{name} {'low' if side < 0 else 'high'}", Box(half_extents=_three(extents)), p=(x, y, z))
            bodies.append(replace(wall, appearance=Appearance(reflectivity=_WALLS[len(bodies) - 1])))
    box = static("near", Box(half_extents=_NEAR), p=(1.3, 0.2, 0.6), q=TURNED)
    bodies.append(replace(box, appearance=Appearance(reflectivity=_WALLS[6])))
    return Scene(bodies=tuple(bodies), sensors=sensors, gravity=(0.0, 0.0, 0.0))


def _three(row: Floats) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in row)
    return x, y, z


@dataclass(frozen=True, slots=True)
class _Seen:
    """What rays from one point meet: distance [m], place in the scene, cosine of incidence, each (r,)."""

    distance: Floats
    body: Floats
    cosine: Floats


def _seen(origin: Floats, directions: Floats) -> _Seen:
    """In the room, for unit directions (r, 3) in W."""
    with np.errstate(divide="ignore"):
        walls = (np.where(directions > 0, _HIGH, _LOW) - origin) / directions
    axis, rows = np.argmin(walls, axis=1), np.arange(len(directions))
    distance = walls[rows, axis]
    body, cosine = 1.0 + 2 * axis + (directions[rows, axis] > 0), np.abs(directions[rows, axis])
    R = rotation(TURNED)
    o, d = R.T @ (origin - (1.3, 0.2, 0.6)), directions @ R
    for k in rows:
        reach = first_hit(Box(half_extents=_NEAR), o, d[k])
        if reach < distance[k]:
            face = int(np.argmax(np.abs(o + reach * d[k]) / _NEAR))
            distance[k], body[k], cosine[k] = reach, 7.0, abs(d[k, face])
    return _Seen(distance, body, cosine)


def _mounted(state: State) -> tuple[Floats, Floats]:
    """Origin (3,) and axes (3, 3) in W of what is mounted on the carrier, the first body."""
    R_WB = rotation(state.q_WB[0])
    return state.p_WB[0] + R_WB @ _MOUNT["p_BS"], R_WB @ rotation(_MOUNT["q_BS"])


def _worst(what: str, got: Floats, expected: Floats, within: float, because: str = "") -> Comparison:
    """Is all of an array, infinities apart, near what is expected? NaN is near to nothing."""
    if got.shape != expected.shape:
        return near(what, got, expected, within)
    both = np.isinf(got) & (got == expected)
    off = np.abs(np.where(both, 0.0, got) - np.where(both, 0.0, expected))
    return near(f"worst error of {what}", float(off.max()), 0.0, within, because)


def _errors(law: AxisNoise, signal: Floats) -> Floats:
    """What a channel with a bias, but without anything random, reads before it is rounded, (k, 3)."""
    turn = np.array(law.misalignment)
    angle = float(np.linalg.norm(turn))
    R_SA = rotation(axis_angle(_three(turn / angle), angle))
    return (1.0 + law.scale_error) * signal @ R_SA + law.bias


@check("Do inertial sensors read their lever, their frame, their age and their errors on a body that turns?", firm=True)
def inertial_readings_on_a_turning_body(adapter: Adapter, settings: Settings) -> Finding:
    """Read every fourth step, two steps late: what is stamped 8 dt tells of the four steps that end at 6 dt.

    Equation: f = R_SW ((v_S - v_S')/T - g) with v_S = v + w x r, R half way between the two attitudes; rate R_SW w.
    Source: Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 11.3.
    """
    force_law = AxisNoise(misalignment=(0.1, -0.2, 0.15), scale_error=0.05, bias=0.7, quantisation=0.25, saturation=12.1)
    rate_law = AxisNoise(misalignment=(-0.2, 0.1, 0.05), scale_error=-0.1, bias=-0.4, quantisation=0.02, saturation=5.01)
    imu = Imu(
        name="imu",
        rate=1 / (4 * COARSE),
        latency=2 * COARSE,
        reading="states",
        noise=ImuNoise(accelerometer=force_law, gyroscope=rate_law),
        **_MOUNT,
    )
    scene = Scene(bodies=(_carrier(v_WB=(1.0, 2.0, -1.0), w_WB=(4.0, -5.0, 6.0)),), sensors=(imu,), gravity=(1.0, -2.0, -G))
    streams, states = _read(adapter, settings.with_dt(COARSE), scene, 18)
    instants, levers, forces, rates = (2, 6, 10, 14), [], [], []
    frames = [rotation(states[n].q_WB[0]) for n in instants]
    for n, R_WB in zip(instants, frames, strict=True):
        levers.append(states[n].v_WB[0] + np.cross(states[n].w_WB[0], R_WB @ _MOUNT["p_BS"]))
        rates.append((R_WB @ rotation(imu.q_BS)).T @ states[n].w_WB[0])
    for k in range(3):
        halfway = _halfway(frames[k], frames[k + 1]) @ rotation(imu.q_BS)
        forces.append(halfway.T @ ((levers[k + 1] - levers[k]) / (4 * COARSE) - np.array(scene.gravity)))
    expected = {"accelerometer": np.array(forces), "gyroscope": np.array(rates[1:])}
    # Quaternions of engines in single precision are off unit length by as much as they round.
    within = {"accelerometer": ROUNDING * 9.0 / (4 * COARSE), "gyroscope": ROUNDING * 9.0}
    comparisons = [near("stamps [s]", streams["imu/time"], np.array([8, 12, 16]) * COARSE, 1e-9, "the instant and the latency")]
    for channel, law in (("accelerometer", force_law), ("gyroscope", rate_law)):
        comparisons.append(_worst(f"{channel} in S", streams[f"imu/{channel}_ideal"], expected[channel], within[channel]))
        read, unrounded = streams[f"imu/{channel}"], _errors(law, streams[f"imu/{channel}_ideal"])
        greatest = law.quantisation * np.floor((law.saturation or np.inf) / law.quantisation)
        levels = read / law.quantisation
        digit = law.quantisation * 0.5000001
        comparisons += [
            that(bool((np.abs(unrounded) > greatest).any()), f"scene: the {channel} is driven beyond its bound"),
            _worst(f"{channel} with errors", read, np.clip(unrounded, -greatest, greatest), digit, "half a digit"),
            _worst(f"digits of the {channel}", np.rint(levels), levels, 1e-6),
        ]
    return judge(*comparisons)


def _halfway(a: Floats, b: Floats) -> Floats:
    """The rotation (3, 3) half way from a to b, by the axis and angle of a^T b."""
    step = a.T @ b
    axis = np.array([step[2, 1] - step[1, 2], step[0, 2] - step[2, 0], step[1, 0] - step[0, 1]])
    sine = float(np.linalg.norm(axis)) / 2
    angle = float(np.arctan2(sine, (np.trace(step) - 1) / 2))
    return a @ rotation(axis_angle(_three(axis / (2 * sine)), angle / 2))


@check("Is inertial noise as strong as it is told: white noise, drifting bias, instability?", firm=True)
def inertial_noise_has_its_strength(adapter: Adapter, settings: Settings) -> Finding:
    """Three sensors on a body at rest, each with one process in each channel, read at every step.

    Equation: samples at an interval T have the standard deviations N/sqrt(T) (white), K sqrt(T) (differences of a random walk)
    and B/.617 (a Gauss-Markov process whose Allan deviation is at most B), with a correlation exp(-T/tau) of neighbours.
    Source: IEEE Std 952-1997, annex C.
    """
    count, size, tau = 400, {"accelerometer": 0.3, "gyroscope": 0.05}, 2 * COARSE
    laws: dict[str, Callable[[float], AxisNoise]] = {
        "white": lambda amount: AxisNoise(density=amount),
        "walk": lambda amount: AxisNoise(random_walk=amount),
        "drift": lambda amount: AxisNoise(instability=amount, instability_time=tau),
    }
    sensors = [
        Imu(
            name=name,
            rate=1 / COARSE,
            reading="states",
            noise=ImuNoise(**{channel: law(amount) for channel, amount in size.items()}),
            **_MOUNT,
        )
        for name, law in laws.items()
    ]
    scene = Scene(bodies=(_carrier(),), sensors=tuple(sensors), gravity=(0.0, 0.0, 0.0))
    streams, _ = _read(adapter, settings.with_dt(COARSE), scene, count)
    comparisons, drawn = [], 3 * count
    for channel, amount in size.items():
        white, walk, drift = (streams[f"{name}/{channel}"] - streams[f"{name}/{channel}_ideal"] for name in laws)
        spread = {
            "white": (white, amount / np.sqrt(COARSE)),
            "walk": (np.diff(walk, axis=0), amount * np.sqrt(COARSE)),
            "drift": (drift, amount / 0.617364),
        }
        # Neighbours that are alike count for less: of n, n (1 - m^2)/(1 + m^2), m their correlation.
        memory = np.exp(-COARSE / tau)
        fewer = {"white": 1.0, "walk": 1.0, "drift": (1 + memory**2) / (1 - memory**2)}
        comparisons += [
            near(
                f"spread of {channel}/{name}",
                np.std(noise) / sigma,
                1.0,
                _SIGMAS * np.sqrt(fewer[name] / (2 * drawn)),
                "5 sigma",
            )
            for name, (noise, sigma) in spread.items()
        ]
        beside = float(np.corrcoef(drift[:-1].ravel(), drift[1:].ravel())[0, 1])
        comparisons.append(
            near(f"correlation of neighbours in {channel}/drift", beside, memory, _SIGMAS / np.sqrt(drawn), "5 sigma")
        )
        axes = max(abs(float(np.corrcoef(white[:, a], white[:, b])[0, 1])) for a, b in ((0, 1), (1, 2), (2, 0)))
        comparisons.append(near(f"correlation of axes of {channel}/white", axes, 0.0, _SIGMAS / np.sqrt(count), "5 sigma"))
    both = float(np.corrcoef(streams["white/accelerometer"].ravel(), streams["white/gyroscope"].ravel())[0, 1])
    steps = np.diff(streams["walk/gyroscope"], axis=0, prepend=0.0)
    other = float(np.corrcoef(streams["white/gyroscope"].ravel(), steps.ravel())[0, 1])
    comparisons += [
        near(f"correlation of {name}", r, 0.0, _SIGMAS / np.sqrt(drawn), "5 sigma")
        for name, r in (("both channels", both), ("two sensors", other))
    ]
    return judge(*comparisons)


_LIDAR: dict[str, Any] = {"channels": 5, "columns": 24, "elevation_low": -0.5, "elevation_high": 0.9, **_MOUNT}
_REACH: dict[str, Any] = {"min_range": 1.2, "max_range": 6.0}


def _beams(channels: int = 5, columns: int = 24) -> Floats:
    """Unit directions in S, (channels, columns, 3), counter-clockwise from x, the lowest channel first."""
    up = np.array([-0.5 + 1.4 * k / (channels - 1) for k in range(channels)])[:, None]
    turn = 2 * np.pi * np.arange(columns)[None, :] / columns
    return np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up) + 0.0 * turn], axis=-1)


@check("Do range finders read between their bounds, from where they are mounted?", Feature.RAYS | Feature.BOX, firm=True)
def lidar_reads_between_its_bounds(adapter: Adapter, settings: Settings) -> Finding:
    """What stands nearer than the least range or farther than the greatest returns nothing; what does has its intensity."""
    lidar = Lidar(name="lidar", rate=1 / (6 * COARSE), **_REACH, **_LIDAR)
    scene = _in_a_room(lidar, v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = _read(adapter, settings.with_dt(COARSE), scene, 6)
    comparisons = [near("stamps [s]", streams["lidar/time"], (0.0, 6 * COARSE), 1e-9)]
    for scan, state in enumerate((states[0], states[6])):
        origin, axes = _mounted(state)
        met = _seen(origin, _beams().reshape(-1, 3) @ axes.T)
        heard = (met.distance >= _REACH["min_range"]) & (met.distance <= _REACH["max_range"])
        expected = np.where(heard, met.distance, np.inf).reshape(5, 24)
        light = np.where(heard, np.array(_WALLS)[met.body.astype(int) - 1] * met.cosine, 0.0).reshape(5, 24)
        got, bright = streams["lidar/range"][scan], streams["lidar/intensity"][scan]
        along = np.where(np.isfinite(got), got, 0.0)[..., None] * _beams()
        cut = int((met.distance < _REACH["min_range"]).sum()), int((met.distance > _REACH["max_range"]).sum())
        comparisons += [
            that(min(cut) > 1, f"scene: beams that meet something too near and too far: got {cut}, expected some of both"),
            _worst(f"ranges of scan {scan} [m]", got, expected, 1e-4, "rounding in single precision"),
            _worst(f"intensities of scan {scan}", bright, light, 1e-4, "reflectivity times the cosine of incidence"),
            _worst(f"points of scan {scan} in S [m]", np.nan_to_num(streams["lidar/points"][scan]), along, 1e-9),
        ]
    return judge(*comparisons)


@check(
    "Does each column of a spinning range finder leave from where the sensor then is?", Feature.RAYS | Feature.BOX, firm=True
)
def spinning_lidar_fires_column_by_column(adapter: Adapter, settings: Settings) -> Finding:
    """A body that flies and turns evenly; the last column is fired at the stamp, each other one a share of a turn before."""
    steps, w = 6, (3.0, -4.0, 5.0)
    lidar = Lidar(name="lidar", rate=1 / (steps * COARSE), spinning=True, **_LIDAR)
    even: Any = tuple(tuple(0.3 * float(a == b) for b in range(3)) for a in range(3))
    scene = _in_a_room(lidar, v_WB=(2.0, -1.5, 1.0), w_WB=w, inertia=even)
    streams, states = _read(adapter, settings.with_dt(COARSE), scene, steps)
    end, expected = states[steps], np.zeros((5, 24))
    turn: Quaternion = tuple(float(c) for c in end.q_WB[0])  # type: ignore[assignment]  # four numbers
    for column in range(24):
        ago = steps * COARSE * (23 - column) / 24
        q = turned_by(turn, -end.w_WB[0], ago) if ago else np.array(turn)
        then = replace(end, p_WB=end.p_WB - ago * end.v_WB, q_WB=np.tile(q, (len(end.q_WB), 1)))
        origin, axes = _mounted(then)
        expected[:, column] = _seen(origin, _beams()[:, column] @ axes.T).distance
    # A default damping takes .4 % of the velocities over a turn of the sensor, so .2 mm of the way and .4 mrad of the turn, at
    # up to 6 m and 60 degrees of incidence; a column fired elsewhere would be off by .03 rad of turn.
    got = streams["lidar/range"]
    if len(got) != 1:
        return Finding("failed", f"scans after one turn: got {len(got)}, expected 1")
    return judge(
        near("stamp [s]", streams["lidar/time"], [steps * COARSE], 1e-9),
        _worst("ranges [m]", got[0], expected, 0.01, "a default damping"),
    )


@check("Is the noise of range finders as strong as it is told?", Feature.RAYS | Feature.BOX, firm=True)
def lidar_noise_has_its_strength(adapter: Adapter, settings: Settings) -> Finding:
    """One scan of 1440 beams: spread by range, beams lost by chance and for want of light."""
    law = LidarNoise(range_sigma=0.02, range_sigma_slope=0.01, dropout=0.2, intensity_sigma=0.03, least_intensity=0.2)
    lidar = Lidar(name="lidar", rate=1 / COARSE, noise=law, **(_LIDAR | {"channels": 16, "columns": 90}))
    streams, _ = _read(adapter, settings.with_dt(COARSE), _in_a_room(lidar), 0)
    range_, light = streams["lidar/range_ideal"], streams["lidar/intensity_ideal"]
    lit, heard = light >= law.least_intensity, np.isfinite(streams["lidar/range"])
    both = lit & heard
    score = (streams["lidar/range"] - range_)[both] / (law.range_sigma + law.range_sigma_slope * range_[both])
    bright = (streams["lidar/intensity"] - light)[both] / law.intensity_sigma
    count = int(both.sum())
    spread, share = _SIGMAS / np.sqrt(2 * count), float((lit & ~heard).sum() / lit.sum())
    chance = _SIGMAS * np.sqrt(law.dropout * (1 - law.dropout) / lit.sum())
    unlit, half = int((heard & ~lit).sum()), range_[both] > np.median(range_[both])
    return judge(
        that(unlit == 0, f"beams with too little light that return: got {unlit}, expected none"),
        near("share of beams lost by chance", share, law.dropout, chance, "5 sigma"),
        near("spread of ranges, as told 1", np.std(score), 1.0, spread, "5 sigma"),
        near("spread of long ranges", np.std(score[half]), 1.0, spread * np.sqrt(2), "5 sigma"),
        near("spread of intensities, as told 1", np.std(bright), 1.0, spread, "5 sigma"),
        near(
            "correlation of ranges and intensities", np.corrcoef(score, bright)[0, 1], 0.0, _SIGMAS / np.sqrt(count), "5 sigma"
        ),
    )


@check("Does a beam that spreads read the mean over its cone?", Feature.RAYS | Feature.BOX, firm=True)
def wide_beams_read_the_mean_of_their_cone(adapter: Adapter, settings: Settings) -> Finding:
    """Beams whose cone meets one wall alone, against 1000 directions spread evenly over each cone.

    Equation: intensity is the mean of reflectivity times cosine; the range is the mean weighted by it. Evenly means cosines of
    the angle to the axis evenly spaced, and turns by the golden angle.
    """
    half, count = 0.08, 1000
    lidar = Lidar(name="lidar", rate=1 / COARSE, divergence=half, **_LIDAR)
    streams, states = _read(adapter, settings.with_dt(COARSE), _in_a_room(lidar), 0)
    origin, axes = _mounted(states[0])
    along = 1.0 - (1.0 - np.cos(half)) * (np.arange(count) + 0.5) / count
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    cone = np.stack([np.sqrt(1 - along**2) * np.cos(turn), np.sqrt(1 - along**2) * np.sin(turn), along], axis=-1)
    errors, dims, met = [], [], 0
    for channel, column in ((0, 3), (1, 9), (2, 14), (3, 20), (4, 6), (2, 0)):
        z = _beams()[channel, column]
        x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        x /= np.linalg.norm(x)
        seen = _seen(origin, cone @ np.stack([x, np.cross(z, x), z]) @ axes.T)
        if len(set(seen.body.tolist())) > 1:
            continue
        met += 1
        power = np.array(_WALLS)[seen.body.astype(int) - 1] * seen.cosine
        errors.append(streams["lidar/range"][0, channel, column] - float(seen.distance @ power / power.sum()))
        dims.append(streams["lidar/intensity"][0, channel, column] - float(power.mean()))
    # Seven sub-rays err by terms in the fourth power of the half angle: 4e-5 of some metres, tan^4 of the incidence beside.
    return judge(
        that(met > 2, f"scene: beams that meet one wall alone: got {met}, expected three or more"),
        near(
            "worst error of ranges [m]", float(np.abs(errors).max(initial=0.0)), 0.0, 2e-3, "the fourth power of the half angle"
        ),
        near(
            "worst error of intensities", float(np.abs(dims).max(initial=0.0)), 0.0, 1e-3, "the fourth power of the half angle"
        ),
    )


_VIEW: dict[str, Any] = {
    "width": 24,
    "height": 18,
    "focal_x": 16.0,
    "focal_y": 11.0,
    "centre_x": 10.5,
    "centre_y": 8.0,
    **_MOUNT,
}
"""Two focal lengths, and a centre off the middle."""


def _depths(state: State) -> tuple[Floats, Floats, Floats]:
    """z-depth [m], place in the scene, and share of the range that is depth, of the pixels of `_VIEW`, each (18, 24)."""
    u, v = np.meshgrid((np.arange(24) + 0.5 - 10.5) / 16.0, (np.arange(18) + 0.5 - 8.0) / 11.0)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    origin, axes = _mounted(state)
    met = _seen(origin, rays @ axes.T)
    return (met.distance * rays[:, 2]).reshape(18, 24), met.body.reshape(18, 24), rays[:, 2].reshape(18, 24)


@check(
    "Do depth cameras read z-depth between their bounds, from where they are mounted?", Feature.RAYS | Feature.BOX, firm=True
)
def depth_camera_reads_between_its_bounds(adapter: Adapter, settings: Settings) -> Finding:
    """Two focal lengths, on a body that flies and turns; then the noise of a stereo camera and of one by time of flight."""
    view = {"rate": 1 / (6 * COARSE), **_VIEW}
    wide = {"near": 0.01, "far": 50.0, **view}
    cameras = (
        DepthCamera(name="plain", near=1.5, far=4.5, **view),
        DepthCamera(name="stereo", noise=StereoNoise(baseline=0.1, disparity_sigma=0.05, occlusion=False), **wide),
        DepthCamera(name="flight", noise=TimeOfFlightNoise(range_sigma=0.01, range_sigma_slope=0.02, missing=0.1), **wide),
    )
    scene = _in_a_room(*cameras, v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = _read(adapter, settings.with_dt(COARSE), scene, 6)
    depth, body, ahead = _depths(states[6])
    expected = np.where(depth < 1.5, -np.inf, np.where(depth > 4.5, np.inf, depth))
    got, names = streams["plain/depth"][1], streams["plain/body"][1]
    cut = int((depth < 1.5).sum()), int((depth > 4.5).sum())
    odd = int((names != np.where(expected == np.inf, -1, body)).sum())
    stereo = (1 / streams["stereo/depth"][1] - 1 / depth) * 16.0 * 0.1 / 0.05
    flight = (streams["flight/depth"][1] - depth) / ahead / (0.01 + 0.02 * depth / ahead)
    kept = np.isfinite(flight)
    return judge(
        near("stamps [s]", streams["plain/time"], (0.0, 6 * COARSE), 1e-9),
        that(min(cut) > 1, f"scene: pixels that see something too near and too far: got {cut}, expected some of both"),
        _worst("z-depths [m]", got, expected, 1e-4, "rounding in single precision; -inf below the bounds, inf beyond"),
        that(odd == 0, f"bodies: got {odd} pixels of others, expected none; -1 beyond the bounds"),
        near("spread of disparities, as told 1", np.std(stereo), 1.0, _SIGMAS / np.sqrt(2 * stereo.size), "5 sigma"),
        near("spread by time of flight, as told 1", np.std(flight[kept]), 1.0, _SIGMAS / np.sqrt(2 * kept.sum()), "5 sigma"),
        near("share of pixels missing", 1 - kept.mean(), 0.1, _SIGMAS * np.sqrt(0.09 / kept.size), "5 sigma"),
    )


@check("Do pictures have two focal lengths, from where the camera is mounted?", Feature.RENDER | Feature.BOX, firm=True)
def camera_is_mounted_on_what_turns(adapter: Adapter, settings: Settings) -> Finding:
    """The same view as the engine draws it itself, before any step and after six."""
    scene = _in_a_room(Camera(name="camera", rate=1 / (6 * COARSE), **_VIEW), v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = _read(adapter, settings.with_dt(COARSE), scene, 6)
    comparisons = [near("stamps [s]", streams["camera/time"], (0.0, 6 * COARSE), 1e-9)]
    for frame, state in enumerate((states[0], states[6])):
        depth, body, _ = _depths(state)
        comparisons.append(
            _worst(f"z-depths of frame {frame} [m]", streams["camera/depth"][frame], depth, 0.02, "depth buffers")
        )
        odd = int((streams["camera/body"][frame] != body).sum())
        comparisons.append(that(odd == 0, f"bodies of frame {frame}: got {odd} pixels of others, expected none"))
    return judge(*comparisons)
