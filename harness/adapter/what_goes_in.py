"""The door of an engine: what is handed to a simulation is checked here, once for all adapters, before the engine sees it.

Native code trusts shapes: an array that is too short is read beyond its end. Each function returns when all is well and raises
`ValueError` with what, got and expected otherwise. Stepping passes no door. A door that opens costs a few comparisons and one
sum: `x . x` is finite for finite numbers up to 1e154, and only where it is not is each number looked at.
"""

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from plumbline.harness.scene import Prismatic, Revolute, Scene, Vector3
from plumbline.harness.trajectory import Floats, State

DIRECTION = 1e-6
"""By how much the square of a direction's length may differ from 1: unit vectors that were rounded to single precision have
|d|^2 within 6 * 2^-24 = 4e-7, and a range is wrong by half of it, less than a micrometre in a metre."""

_FLOAT = np.dtype(np.float64)


def _numbers(what: str, value: Any, shape: tuple[int, ...], unit: str) -> None:
    """Is `value` an array of float64 of that shape, finite throughout? Raises: ValueError."""
    if not isinstance(value, np.ndarray):
        raise ValueError(f"{what}: got {type(value).__name__}, expected an array {shape} of float64 {unit}")
    if value.shape != shape or value.dtype != _FLOAT:
        raise ValueError(f"{what}: got {value.dtype} {value.shape}, expected float64 {shape} {unit}")
    if not isfinite(np.vdot(value, value)):
        bad = np.argwhere(~np.isfinite(value))
        if len(bad):
            index = tuple(int(k) for k in bad[0])
            raise ValueError(f"{what}: got {value[index]} at {index}, expected finite numbers {unit}")


def check_wrench(bodies: int, f_B_W: Floats, tau_B_W: Floats) -> None:
    """Forces (n, 3) N and torques (n, 3) N m on the n bodies of a scene, both finite. Raises: ValueError."""
    _numbers("wrench: f_B_W", f_B_W, (bodies, 3), "N")
    _numbers("wrench: tau_B_W", tau_B_W, (bodies, 3), "N m")


def check_rays(origins: Floats, directions: Floats, max_range: float) -> None:
    """Origins (r, 3) m, directions (r, 3) of length 1 to `DIRECTION`, and a finite reach [m] above 0. Raises: ValueError."""
    rays = len(directions) if isinstance(directions, np.ndarray) and directions.ndim else 0
    _numbers("cast: directions", directions, (rays, 3), "")
    _numbers("cast: origins", origins, (rays, 3), "m")
    if not (isinstance(max_range, int | float | np.floating) and max_range > 0.0 and isfinite(max_range)):
        raise ValueError(f"cast: max_range {max_range!r} m, expected a finite number above 0")
    off = np.abs(np.einsum("ij,ij->i", directions, directions) - 1.0)
    if rays and not off.max() <= DIRECTION:
        worst = int(off.argmax())
        raise ValueError(f"cast: direction {worst} has the length {np.linalg.norm(directions[worst]):.9g}, expected 1")


def check_targets(scene: Scene, targets: Mapping[str, float]) -> None:
    """Finite targets [rad or m] for joints of the scene that have a drive, acting or not. Raises: ValueError."""
    driven = {j.name: None for j in scene.joints if isinstance(j, Revolute | Prismatic) and j.drive is not None}
    for name, target in targets.items():
        if name not in driven:
            raise ValueError(f"command: joint {name!r} has no drive, expected one of {', '.join(driven) or 'none'}")
        if not isinstance(target, int | float | np.number) or not isfinite(target):
            raise ValueError(f"command: target {target!r} of joint {name!r}, expected a finite number")


def check_velocities(scene: Scene, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
    """Finite v_WB [m/s] and w_WB [rad/s] of bodies of the scene whose motion is prescribed. Raises: ValueError."""
    moved = {body.name: None for body in scene.bodies if body.prescribed is not None}
    for name, velocity in velocities.items():
        if name not in moved:
            raise ValueError(f"prescribe: body {name!r} is not prescribed, expected one of {', '.join(moved) or 'none'}")
        table = np.asarray(velocity, dtype=np.float64)
        if table.shape != (2, 3) or not np.isfinite(table).all():
            raise ValueError(f"prescribe: velocities {velocity!r} of body {name!r}, expected v_WB and w_WB, finite")


def check_state(bodies: int, out: State) -> None:
    """Arrays of float64 that the states of n bodies can be written into. Raises: ValueError."""
    p, q, v, w = out.p_WB, out.q_WB, out.v_WB, out.w_WB
    try:
        vectors = p.shape == v.shape == w.shape == (bodies, 3) and q.shape == (bodies, 4)
        if vectors and p.dtype is q.dtype is v.dtype is w.dtype is _FLOAT:
            return
    except AttributeError:
        pass
    for what, value, width in (("p_WB", p, 3), ("q_WB", q, 4), ("v_WB", v, 3), ("w_WB", w, 3)):
        if not isinstance(value, np.ndarray) or value.shape != (bodies, width) or value.dtype != _FLOAT:
            got = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
            raise ValueError(f"state: {what}: got {got}, expected float64 ({bodies}, {width})")
