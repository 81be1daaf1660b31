"""A range finder whose columns are fired one after the other while it moves: the distortion of its scans by that motion.

The columns k = 0..n-1 of the scan stamped t are fired at t - T (n - 1 - k)/n, over the interval T that ends with the last one
at the stamp. Each is fired from the pose of the sensor at its instant, taken between the two steps about it: the place by the
cubic that has their places and velocities, the attitude at a constant rate, which errs by at most a dt^2/8 for an angular
acceleration a. The other bodies stand where they are at the later of the two steps: that is known, and off by at most v dt.
There is no scan at time 0, before which no interval has passed.

Source: Hermite interpolation (Hairer, Norsett, Wanner I, section II.6); Shoemake, Animating rotation with quaternion curves
(1985), for the constant rate.
"""

import numpy as np

from plumbline.harness.scene import Lidar
from plumbline.harness.sensors.lidar import Scans, beams, returns, spread
from plumbline.harness.sensors.reader import Setting, row_of
from plumbline.harness.trajectory import Floats, Hits, State
from plumbline.harness.trajectory.kinematics import conjugate, product, rotate


def pose_between(early: Floats, late: Floats, interval: float, share: Floats) -> tuple[Floats, Floats]:
    """Places [m] (k, 3) and attitudes (k, 4) of a body at shares 0..1 (k,) of the way between two rows `interval` [s] apart.

    Args:
        early, late: p_WB, q_WB, v_WB, w_WB (13,).
    """
    s = share[:, None]
    p0, p1, v0, v1 = early[:3], late[:3], interval * early[7:10], interval * late[7:10]
    p_WB = p0 + (p1 - p0) * s * s * (3 - 2 * s) + v0 * s * (1 - s) ** 2 - v1 * s * s * (1 - s)
    step = product(conjugate(early[3:7]), late[3:7])
    step = -step if step[0] < 0 else step
    half = np.arctan2(np.linalg.norm(step[1:]), step[0])
    # sin(s h)/sin(h) tends to s for a turn by nothing.
    along = s if half == 0.0 else np.sin(s * half) / np.sin(half)
    turns = np.concatenate([np.cos(s * half), along * step[1:]], axis=1)
    return p_WB, product(early[3:7], turns)


class SpinningReader:
    """Scans, as `Scans` gives them; read at every step."""

    def __init__(self, lidar: Lidar, setting: Setting, start: State) -> None:
        self._lidar, self._setting = lidar, setting
        # Columns first, so that rays from one place stand together.
        rays = spread(beams(lidar), lidar.divergence)
        self._rays = np.ascontiguousarray(np.moveaxis(rays, 2, 0))
        self._scans = Scans(lidar, setting.seed)
        self._before, self._row = 0.0, row_of(setting.scene, lidar.body, start)
        self._fired = 0
        self._open = (np.zeros((lidar.channels, lidar.columns)), np.zeros((lidar.channels, lidar.columns)))

    def read(self, time: float, state: State) -> None:
        """Fire the columns that are due since the step before. Raises: Unsupported."""
        row = row_of(self._setting.scene, self._lidar.body, state)
        due = self._due(time)
        while self._fired < due:
            scan, first = divmod(self._fired, self._lidar.columns)
            last = min(self._lidar.columns, first + due - self._fired)
            self._fire(np.arange(first, last), scan, time, row)
            self._fired += last - first
            if last == self._lidar.columns:
                self._scans.add((scan + 1) / self._lidar.rate, *self._open)
                self._open = (np.zeros_like(self._open[0]), np.zeros_like(self._open[1]))
        self._before, self._row = time, row

    def _due(self, time: float) -> int:
        """Columns fired in all by `time` [s]; one is due at its own instant, whatever the rounding of the clock."""
        return int(np.floor(time * self._lidar.rate * self._lidar.columns * (1.0 + 1e-12) + 1e-6))

    def _fire(self, columns: np.ndarray[tuple[int], np.dtype[np.int64]], scan: int, time: float, row: Floats) -> None:
        lidar, setting = self._lidar, self._setting
        instants = (scan + (columns + 1) / lidar.columns) / lidar.rate
        interval = time - self._before
        share = np.clip((instants - self._before) / interval, 0.0, 1.0)
        p_WB, q_WB = pose_between(self._row, row, interval, share)
        q_WS = product(q_WB, np.broadcast_to(np.array(lidar.q_BS), q_WB.shape))
        p_WS = p_WB + rotate(q_WB, np.broadcast_to(np.array(lidar.p_BS), p_WB.shape))
        rays = self._rays[columns]
        directions = rotate(q_WS[:, None, None], rays).reshape(-1, 3)
        origins = np.repeat(p_WS, rays.shape[1] * rays.shape[2], axis=0)
        hits = setting.simulation.cast(origins, directions, lidar.max_range)
        # Sub-rays first, then channels, then columns, as `returns` and the scan have them.
        order = np.moveaxis(np.arange(len(directions)).reshape(rays.shape[:3]), 0, 2).ravel()
        hits = Hits(hits.distance[order], hits.body[order], hits.normal_W[order])
        measured = returns(lidar, setting.scene, directions[order], hits)
        for kept, values in zip(self._open, measured, strict=True):
            kept[:, columns] = values.reshape(lidar.channels, len(columns))

    def streams(self) -> dict[str, Floats]:
        """All whole scans, ideal and with noise."""
        return self._scans.streams()
