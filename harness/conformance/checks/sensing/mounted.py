"""Checks of inertial sensors and range finders as they are read on a body that flies and turns: frames, bounds, errors, noise.

Judged by matrices alone. What is expected starts from the states that the engine gives, which other checks judge, and shares
nothing with `harness.sensors`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, firm, near, that, worst
from plumbline.harness.conformance.engine import COARSE, ROUNDING, Engine
from plumbline.harness.conformance.frames import rotation, symmetric, turned_by, vector
from plumbline.harness.conformance.room import MOUNT, SIGMAS, WALLS, carrier, in_a_room, mounted, read_on, seen_from
from plumbline.harness.conformance.scenes import G, without_gravity
from plumbline.harness.scene import AxisNoise, Imu, ImuNoise, Lidar, LidarNoise, Quaternion, Scene, axis_angle
from plumbline.harness.trajectory import Floats


def _errors(law: AxisNoise, signal: Floats) -> Floats:
    """What a channel with a bias, but without anything random, reads before it is rounded, (k, 3)."""
    turn = np.array(law.misalignment)
    angle = float(np.linalg.norm(turn))
    R_SA = rotation(axis_angle(vector(turn / angle), angle))
    return (1.0 + law.scale_error) * signal @ R_SA + law.bias


@firm("Do inertial sensors read their lever, their frame, their age and their errors on a body that turns?")
def inertial_readings_on_a_turning_body(engine: Engine) -> Comparisons:
    """Read every fourth step, two steps late: what is stamped 8 dt tells of the four steps that end at 6 dt.

    Equation: f = R_SW ((v_S - v_S')/T - g) with v_S = v + w x r, R half way between the two attitudes; rate R_SW w.
    Source: Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 11.3.
    """
    force_law = AxisNoise(misalignment=(0.1, -0.2, 0.15), scale_error=0.05, bias=0.7, quantisation=0.25, saturation=12.1)
    rate_law = AxisNoise(misalignment=(-0.2, 0.1, 0.05), scale_error=-0.1, bias=-0.4, quantisation=0.02, saturation=5.01)
    noise = ImuNoise(accelerometer=force_law, gyroscope=rate_law)
    imu = Imu(name="imu", rate=1 / (4 * COARSE), latency=2 * COARSE, reading="states", noise=noise, **MOUNT)
    scene = Scene(bodies=(carrier(v_WB=(1.0, 2.0, -1.0), w_WB=(4.0, -5.0, 6.0)),), sensors=(imu,), gravity=(1.0, -2.0, -G))
    streams, states = read_on(engine, scene, 18)
    instants, levers, forces, rates = (2, 6, 10, 14), [], [], []
    frames = [rotation(states[n].q_WB[0]) for n in instants]
    for n, R_WB in zip(instants, frames, strict=True):
        levers.append(states[n].v_WB[0] + np.cross(states[n].w_WB[0], R_WB @ MOUNT["p_BS"]))
        rates.append((R_WB @ rotation(imu.q_BS)).T @ states[n].w_WB[0])
    for k in range(3):
        halfway = _halfway(frames[k], frames[k + 1]) @ rotation(imu.q_BS)
        forces.append(halfway.T @ ((levers[k + 1] - levers[k]) / (4 * COARSE) - np.array(scene.gravity)))
    expected = {"accelerometer": np.array(forces), "gyroscope": np.array(rates[1:])}
    # Quaternions of engines in single precision are off unit length by as much as they round.
    within = {"accelerometer": ROUNDING * 9.0 / (4 * COARSE), "gyroscope": ROUNDING * 9.0}
    yield near("stamps [s]", streams["imu/time"], np.array([8, 12, 16]) * COARSE, 1e-9, "the instant and the latency")
    for channel, law in (("accelerometer", force_law), ("gyroscope", rate_law)):
        yield worst(f"{channel} in S", streams[f"imu/{channel}_ideal"], expected[channel], within[channel])
        read, unrounded = streams[f"imu/{channel}"], _errors(law, streams[f"imu/{channel}_ideal"])
        greatest = law.quantisation * np.floor((law.saturation or np.inf) / law.quantisation)
        levels = read / law.quantisation
        digit = law.quantisation * 0.5000001
        yield that(bool((np.abs(unrounded) > greatest).any()), f"scene: the {channel} is driven beyond its bound")
        yield worst(f"{channel} with errors", read, np.clip(unrounded, -greatest, greatest), digit, "half a digit")
        yield worst(f"digits of the {channel}", np.rint(levels), levels, 1e-6)


def _halfway(a: Floats, b: Floats) -> Floats:
    """The rotation (3, 3) half way from a to b, by the axis and angle of a^T b."""
    step = a.T @ b
    axis = np.array([step[2, 1] - step[1, 2], step[0, 2] - step[2, 0], step[1, 0] - step[0, 1]])
    sine = float(np.linalg.norm(axis)) / 2
    angle = float(np.arctan2(sine, (np.trace(step) - 1) / 2))
    if sine == 0.0:
        return a
    return a @ rotation(axis_angle(vector(axis / (2 * sine)), angle / 2))


@firm("Is inertial noise as strong as it is told: white noise, drifting bias, instability?")
def inertial_noise_has_its_strength(engine: Engine) -> Comparisons:
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
    sensors = []
    for name, law in laws.items():
        noise = ImuNoise(**{channel: law(amount) for channel, amount in size.items()})
        sensors.append(Imu(name=name, rate=1 / COARSE, reading="states", noise=noise, **MOUNT))
    streams, _ = read_on(engine, without_gravity(carrier(), sensors=tuple(sensors)), count)
    drawn = 3 * count
    for channel, amount in size.items():
        white, walk, drift = (streams[f"{name}/{channel}"] - streams[f"{name}/{channel}_ideal"] for name in laws)
        # Neighbours that are alike count for less: of n, n (1 - m^2)/(1 + m^2), m their correlation.
        memory = np.exp(-COARSE / tau)
        spread = {
            "white": (white, amount / np.sqrt(COARSE), 1.0),
            "walk": (np.diff(walk, axis=0), amount * np.sqrt(COARSE), 1.0),
            "drift": (drift, amount / 0.617364, (1 + memory**2) / (1 - memory**2)),
        }
        for name, (error, sigma, fewer) in spread.items():
            within = SIGMAS * np.sqrt(fewer / (2 * drawn))
            yield near(f"spread of {channel}/{name}", np.std(error) / sigma, 1.0, within, "5 sigma")
        beside = float(np.corrcoef(drift[:-1].ravel(), drift[1:].ravel())[0, 1])
        yield near(f"correlation of neighbours in {channel}/drift", beside, memory, SIGMAS / np.sqrt(drawn), "5 sigma")
        axes = max(abs(float(np.corrcoef(white[:, a], white[:, b])[0, 1])) for a, b in ((0, 1), (1, 2), (2, 0)))
        yield near(f"correlation of axes of {channel}/white", axes, 0.0, SIGMAS / np.sqrt(count), "5 sigma")
    both = float(np.corrcoef(streams["white/accelerometer"].ravel(), streams["white/gyroscope"].ravel())[0, 1])
    steps = np.diff(streams["walk/gyroscope"], axis=0, prepend=0.0)
    other = float(np.corrcoef(streams["white/gyroscope"].ravel(), steps.ravel())[0, 1])
    for name, r in (("both channels", both), ("two sensors", other)):
        yield near(f"correlation of {name}", r, 0.0, SIGMAS / np.sqrt(drawn), "5 sigma")


_LIDAR: dict[str, Any] = {"channels": 5, "columns": 24, "elevation_low": -0.5, "elevation_high": 0.9, **MOUNT}
_REACH: dict[str, Any] = {"min_range": 1.2, "max_range": 6.0}


def _beams(channels: int = 5, columns: int = 24) -> Floats:
    """Unit directions in S, (channels, columns, 3), counter-clockwise from x, the lowest channel first."""
    up = np.array([-0.5 + 1.4 * k / (channels - 1) for k in range(channels)])[:, None]
    turn = 2 * np.pi * np.arange(columns)[None, :] / columns
    return np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up) + 0.0 * turn], axis=-1)


@firm("Do range finders read between their bounds, from where they are mounted?", Feature.RAYS | Feature.BOX)
def lidar_reads_between_its_bounds(engine: Engine) -> Comparisons:
    """What stands nearer than the least range or farther than the greatest returns nothing; what does has its intensity."""
    lidar = Lidar(name="lidar", rate=1 / (6 * COARSE), **_REACH, **_LIDAR)
    scene = in_a_room(lidar, v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = read_on(engine, scene, 6)
    yield near("stamps [s]", streams["lidar/time"], (0.0, 6 * COARSE), 1e-9)
    for scan, state in enumerate((states[0], states[6])):
        origin, axes = mounted(state)
        met = seen_from(origin, _beams().reshape(-1, 3) @ axes.T)
        heard = (met.distance >= _REACH["min_range"]) & (met.distance <= _REACH["max_range"])
        expected = np.where(heard, met.distance, np.inf).reshape(5, 24)
        light = np.where(heard, np.array(WALLS)[met.body.astype(int) - 1] * met.cosine, 0.0).reshape(5, 24)
        got, bright = streams["lidar/range"][scan], streams["lidar/intensity"][scan]
        along = np.where(np.isfinite(got), got, 0.0)[..., None] * _beams()
        cut = int((met.distance < _REACH["min_range"]).sum()), int((met.distance > _REACH["max_range"]).sum())
        yield that(min(cut) > 1, f"scene: beams that meet something too near and too far: got {cut}, expected some of both")
        yield worst(f"ranges of scan {scan} [m]", got, expected, 1e-4, "rounding in single precision")
        yield worst(f"intensities of scan {scan}", bright, light, 1e-4, "reflectivity times the cosine of incidence")
        yield worst(f"points of scan {scan} in S [m]", np.nan_to_num(streams["lidar/points"][scan]), along, 1e-9)


@firm("Does each column of a spinning range finder leave from where the sensor then is?", Feature.RAYS | Feature.BOX)
def spinning_lidar_fires_column_by_column(engine: Engine) -> Comparisons:
    """A body that flies and turns evenly; the last column is fired at the stamp, each other one a share of a turn before."""
    steps, w = 6, (3.0, -4.0, 5.0)
    lidar = Lidar(name="lidar", rate=1 / (steps * COARSE), spinning=True, **_LIDAR)
    scene = in_a_room(lidar, v_WB=(2.0, -1.5, 1.0), w_WB=w, inertia=symmetric(0.3 * np.eye(3)))
    streams, states = read_on(engine, scene, steps)
    end, expected = states[steps], np.zeros((5, 24))
    turn: Quaternion = tuple(float(c) for c in end.q_WB[0])  # type: ignore[assignment]  # four numbers
    for column in range(24):
        ago = steps * COARSE * (23 - column) / 24
        q = turned_by(turn, -end.w_WB[0], ago) if ago else np.array(turn)
        then = replace(end, p_WB=end.p_WB - ago * end.v_WB, q_WB=np.tile(q, (len(end.q_WB), 1)))
        origin, axes = mounted(then)
        expected[:, column] = seen_from(origin, _beams()[:, column] @ axes.T).distance
    # A default damping takes .4 % of the velocities over a turn of the sensor, so .2 mm of the way and .4 mrad of the turn, at
    # up to 6 m and 60 degrees of incidence; a column fired elsewhere would be off by .03 rad of turn.
    got = streams["lidar/range"]
    if len(got) != 1:
        yield that(False, f"scans after one turn: got {len(got)}, expected 1")
        return
    yield near("stamp [s]", streams["lidar/time"], [steps * COARSE], 1e-9)
    yield worst("ranges [m]", got[0], expected, 0.01, "a default damping")


@firm("Is the noise of range finders as strong as it is told?", Feature.RAYS | Feature.BOX)
def lidar_noise_has_its_strength(engine: Engine) -> Comparisons:
    """One scan of 1440 beams: spread by range, beams lost by chance and for want of light."""
    law = LidarNoise(range_sigma=0.02, range_sigma_slope=0.01, dropout=0.2, intensity_sigma=0.03, least_intensity=0.2)
    lidar = Lidar(name="lidar", rate=1 / COARSE, noise=law, **(_LIDAR | {"channels": 16, "columns": 90}))
    streams, _ = read_on(engine, in_a_room(lidar), 0)
    range_, light = streams["lidar/range_ideal"], streams["lidar/intensity_ideal"]
    lit, heard = light >= law.least_intensity, np.isfinite(streams["lidar/range"])
    both = lit & heard
    score = (streams["lidar/range"] - range_)[both] / (law.range_sigma + law.range_sigma_slope * range_[both])
    bright = (streams["lidar/intensity"] - light)[both] / law.intensity_sigma
    count = int(both.sum())
    spread, share = SIGMAS / np.sqrt(2 * count), float((lit & ~heard).sum() / lit.sum())
    chance = SIGMAS * np.sqrt(law.dropout * (1 - law.dropout) / lit.sum())
    unlit, half = int((heard & ~lit).sum()), range_[both] > np.median(range_[both])
    yield that(unlit == 0, f"beams with too little light that return: got {unlit}, expected none")
    yield near("share of beams lost by chance", share, law.dropout, chance, "5 sigma")
    yield near("spread of ranges, as told 1", np.std(score), 1.0, spread, "5 sigma")
    yield near("spread of long ranges", np.std(score[half]), 1.0, spread * np.sqrt(2), "5 sigma")
    yield near("spread of intensities, as told 1", np.std(bright), 1.0, spread, "5 sigma")
    r = np.corrcoef(score, bright)[0, 1]
    yield near("correlation of ranges and intensities", r, 0.0, SIGMAS / np.sqrt(count), "5 sigma")


@firm("Does a beam that spreads read the mean over its cone?", Feature.RAYS | Feature.BOX)
def wide_beams_read_the_mean_of_their_cone(engine: Engine) -> Comparisons:
    """Beams whose cone meets one wall alone, against 1000 directions spread evenly over each cone.

    Equation: intensity is the mean of reflectivity times cosine; the range is the mean weighted by it. Evenly means cosines of
    the angle to the axis evenly spaced, and turns by the golden angle.
    """
    half, count = 0.08, 1000
    lidar = Lidar(name="lidar", rate=1 / COARSE, divergence=half, **_LIDAR)
    streams, states = read_on(engine, in_a_room(lidar), 0)
    origin, axes = mounted(states[0])
    along = 1.0 - (1.0 - np.cos(half)) * (np.arange(count) + 0.5) / count
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    cone = np.stack([np.sqrt(1 - along**2) * np.cos(turn), np.sqrt(1 - along**2) * np.sin(turn), along], axis=-1)
    errors, dims, met = [], [], 0
    for channel, column in ((0, 3), (1, 9), (2, 14), (3, 20), (4, 6), (2, 0)):
        z = _beams()[channel, column]
        x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        x /= np.linalg.norm(x)
        seen = seen_from(origin, cone @ np.stack([x, np.cross(z, x), z]) @ axes.T)
        if len(set(seen.body.tolist())) > 1:
            continue
        met += 1
        power = np.array(WALLS)[seen.body.astype(int) - 1] * seen.cosine
        errors.append(streams["lidar/range"][0, channel, column] - float(seen.distance @ power / power.sum()))
        dims.append(streams["lidar/intensity"][0, channel, column] - float(power.mean()))
    # Seven sub-rays err by terms in the fourth power of the half angle: 4e-5 of some metres, tan^4 of the incidence beside.
    yield that(met > 2, f"scene: beams that meet one wall alone: got {met}, expected three or more")
    because = "the fourth power of the half angle"
    yield near("worst error of ranges [m]", float(np.abs(errors).max(initial=0.0)), 0.0, 2e-3, because)
    yield near("worst error of intensities", float(np.abs(dims).max(initial=0.0)), 0.0, 1e-3, because)
