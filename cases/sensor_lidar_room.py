"""Range finders that fly and turn in an empty room: all beams at once, and column by column over the interval of a scan."""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import ranges, readings
from plumbline.harness.scene import Body, Box, Lidar, Quaternion, Scene, Vector3, axis_angle
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import product, rotate

DURATION, RATE = 1.0, 10.0
CHANNELS, COLUMNS = 12, 120
HALF = (4.0, 3.0, 1.5)
"""Half extents of the inside of the room [m], about the origin."""
PLACE, FLIGHT = np.array([-1.0, 0.6, -0.2]), np.array([1.2, -0.8, 0.3])
AXIS = (0.2, -0.1, 1.0)
MOUNT_P: Vector3 = (0.15, 0.02, 0.08)
MOUNT_Q: Quaternion = axis_angle((0.1, 0.2, 1.0), 0.3)
ELEVATIONS = (-0.5, -0.35, -0.22, -0.12, -0.05, 0.0, 0.03, 0.08, 0.15, 0.25, 0.4, 0.6)
"""Uneven, as those of real instruments are [rad]."""
REFLECTIVITY = 1.0
GRAZING = 0.1
"""No beam of the default flight meets a wall at a smaller cosine of incidence; a test holds this."""


class P(Parameters):
    turning: NotNegative = 3.0


def scene(p: P) -> Scene:
    """Six walls and a ball without a body for rays, flying and turning at `turning` [rad/s], with two range finders."""
    t = 0.1
    x, y, z = HALF
    places = {
        "floor": ((x + 2 * t, y + 2 * t, t), (0.0, 0.0, -z - t)),
        "ceiling": ((x + 2 * t, y + 2 * t, t), (0.0, 0.0, z + t)),
        "east": ((t, y + 2 * t, z), (x + t, 0.0, 0.0)),
        "west": ((t, y + 2 * t, z), (-x - t, 0.0, 0.0)),
        "north": ((x, t, z), (0.0, y + t, 0.0)),
        "south": ((x, t, z), (0.0, -y - t, 0.0)),
    }
    walls = tuple(Body.fixed(name, Box(half_extents=half), p_WB=centre) for name, (half, centre) in places.items())
    axis = np.array(AXIS) / np.linalg.norm(AXIS)
    carrier = Body.ball(
        "carrier", 0.1, touches=False, p_WB=PLACE.tolist(), v_WB=FLIGHT.tolist(), w_WB=(p.turning * axis).tolist()
    )
    lidars = tuple(
        Lidar(
            name=name,
            body="carrier",
            rate=RATE,
            p_BS=MOUNT_P,
            q_BS=MOUNT_Q,
            channels=CHANNELS,
            columns=COLUMNS,
            elevations=ELEVATIONS,
            spinning=name == "spinning",
            max_range=20.0,
        )
        for name in ("flash", "spinning")
    )
    return Scene(bodies=(*walls, carrier), sensors=lidars, gravity=(0.0, 0.0, 0.0))


def _pose(time: Floats, turning: float) -> tuple[Floats, Floats]:
    """Place (k, 3) and attitude (k, 4) of the carrier, which nothing disturbs."""
    axis = np.array(AXIS) / np.linalg.norm(AXIS)
    angle = turning * time[:, None]
    return PLACE + FLIGHT * time[:, None], np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * axis], axis=1)


def walls_from_inside(origins: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Range [m] and cosine of incidence of rays (..., 3) that start inside the room: the first of six planes."""
    with np.errstate(divide="ignore"):
        reach = (np.copysign(np.array(HALF), directions) - origins) / directions
    reach = np.where(directions == 0.0, np.inf, reach)
    wall = np.argmin(reach, axis=-1)[..., None]
    return np.take_along_axis(reach, wall, axis=-1)[..., 0], np.abs(np.take_along_axis(directions, wall, axis=-1)[..., 0])


def scans(stamps: Floats, turning: float, spinning: bool) -> tuple[Floats, Floats]:
    """Ranges and cosines (k, channels, columns) of the scans with these stamps, each column at the instant of its firing."""
    azimuth = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    elevation = np.array(ELEVATIONS)[:, None]
    up = np.broadcast_to(np.sin(elevation), (CHANNELS, COLUMNS))
    pattern = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), up], axis=-1)
    ages = (COLUMNS - 1 - np.arange(COLUMNS)) / COLUMNS / RATE if spinning else np.zeros(COLUMNS)
    instants = stamps[:, None] - ages
    p_WB, q_WB = (a.reshape(*instants.shape, -1) for a in _pose(instants.ravel(), turning))
    q_WS = product(q_WB, np.broadcast_to(np.array(MOUNT_Q), q_WB.shape))
    p_WS = p_WB + rotate(q_WB, np.broadcast_to(np.array(MOUNT_P), p_WB.shape))
    shape = (len(stamps), CHANNELS, COLUMNS)
    directions = rotate(np.broadcast_to(q_WS[:, None], (*shape, 4)), np.broadcast_to(pattern, (*shape, 3)))
    return walls_from_inside(np.broadcast_to(p_WS[:, None], (*shape, 3)), directions)


def expected(time: Floats, p: P) -> Trajectory:
    """Straight flight and steady turning; the ranges to the walls from where the sensor is when a column is fired."""
    stage = scene(p)
    truth, carrier = Trajectory.at_rest(stage, time), stage.bodies[-1]
    truth.v_WB[:, -1], truth.w_WB[:, -1] = carrier.v_WB, carrier.w_WB
    truth.p_WB[:, -1], truth.q_WB[:, -1] = _pose(truth.time, p.turning)
    last = int(np.floor(float(truth.time[-1]) * RATE + 1e-6)) if len(truth) else -1
    streams: dict[str, Floats] = {}
    for name, first in (("flash", 0), ("spinning", 1)):
        stamps = np.arange(first, last + 1) / RATE
        ranges, cosines = scans(stamps, p.turning, name == "spinning")
        streams |= {f"{name}/time": stamps, f"{name}/range_ideal": ranges, f"{name}/intensity_ideal": REFLECTIVITY * cosines}
    return replace(truth, streams=streams)


LONGEST = 2.0 * float(np.linalg.norm(HALF))


def _turned(dt: float, p: P) -> float:
    """How far the attitude may be off at the end [rad]: 2 atan(w dt/2) a step, and rounding in single precision."""
    return p.turning**3 * dt**2 / 12 * DURATION + 64 * SINGLE


CASE = Case.of(
    globals(),
    title="Range finders in flight",
    question="Do a moving range finder's beams end on the walls, fired at once or column by column while it turns?",
    source="Distance to a plane along a ray; motion distortion of spinning range finders",
    truth="closed form",
    sample_interval=0.1,
    checks=(
        Check(
            ranges.range_error_max,
            lambda dt, p: LONGEST * _turned(dt, p) / GRAZING,
            "an attitude that is off by e moves the end of a beam of length r along its wall by r e/cos of incidence: "
            "e is w^3 dt^2/12 a second for 2 atan(w dt/2) a step, and rounding in single precision",
        ),
        Check(
            ranges.range_false_return_share,
            0.0,
            "a closed room returns every beam, and its corners lead on from wall to wall",
        ),
        Check(readings.time_stamp_error, 8 * 2.0**-52 * DURATION, "a few roundings of the time"),
    ),
    observe=(ranges.range_error_rms, ranges.intensity_error_max),
)
