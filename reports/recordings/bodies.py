"""Bodies in motion: their shapes once, their poses over time, and the ways that they took.

The point of a body that stays where it is, as the tip of a top does: told of it, a pose over time is an attitude alone.

The truth of a case: where it is told at given instants, and its ghost among the engines.

Contact forces as arrows at their points, of one scale for all engines of a case.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.harness.trajectory.kinematics import rotate
from plumbline.reports.recordings.layout import (
    GHOST,
    GRID,
    GROUND,
    STAGE,
    TRUTH,
    WORLD,
    Floats,
    Rgba,
    checked,
    columns,
    compose,
    rgba,
)
from plumbline.reports.recordings.runs import RecordedRun, Stage, at_instants, shown
from plumbline.reports.recordings.shapes import CROWD, OVERLAID, Paint, ShapeBatch, batches, drawn

if TYPE_CHECKING:
    import rerun as rr


ROUNDING = 2.0**-24
"""Half a unit in the last place of single precision, which recordings are written in."""

FAR = 2.0
"""No pivot and no arm is longer than this many times the body's own largest distance from the origin: the difference of two
large numbers would shake in single precision."""

SOUGHT = 32
"""Instants that a pivot is sought at; all of them say whether it is one."""


@dataclass(frozen=True, slots=True)
class Pivot:
    """A point P that a body turns about. Terms: p_WP (3,) m: where it is. p_BP (3,) m: the same point in the body."""

    p_WP: Floats
    p_BP: Floats


def pivot_of(p_WB: Floats, q_WB: Floats) -> Pivot | None:
    """The point about which a body at places p_WB (t, 3) m with attitudes q_WB (t, 4) turns; None where there is none.

    p_WB + R_WB p_BP = p_WP at all instants. With the means over some of them taken off, that is an equation for p_BP alone,
    solved by least squares; of an axis that stays, it gives the point next to the body's origin. What is found is a pivot if
    the place of the body put together again from single precision is everywhere the one that was given, but for roundings of
    the larger of both points' distances: one of p_WP, one of p_BP and two of the attitude (a quaternion says half of an angle).
    """
    reach = FAR * float(np.linalg.norm(p_WB, axis=1).max())
    if _outruns(p_WB, q_WB, reach):
        return None
    some = np.unique(np.linspace(0, len(p_WB) - 1, SOUGHT).astype(np.int64))
    near = p_WB[some]
    turned = rotate(q_WB[some][:, None], np.eye(3)).swapaxes(1, 2)
    swing, way = turned - turned.mean(axis=0), near - near.mean(axis=0)
    p_BP = np.linalg.lstsq(swing.reshape(-1, 3), -way.reshape(-1), rcond=1e-6)[0]
    p_WP = (near + turned @ p_BP).mean(axis=0)
    size = max(float(np.linalg.norm(p_WP)), float(np.linalg.norm(p_BP)))
    allowed = 4 * ROUNDING * size
    if size > reach or np.abs(near + turned @ p_BP - p_WP).max() > allowed:
        return None
    again = single(p_WP) - rotate(single(q_WB), single(p_BP))
    return Pivot(p_WP, p_BP) if np.abs(again - p_WB).max() <= allowed else None


def _outruns(p_WB: Floats, q_WB: Floats, reach: float) -> bool:
    """Does a body go farther between its first instant and its last than an arm of length `reach` [m] carries it as it turns?

    Turned by an angle a, such an arm has a chord of 2 sin(a/2) of its length, and cos(a/2) is the product of both quaternions.
    Most bodies that fly, fall or slide turn so little that nothing else needs to be asked. A pivot may be off by four roundings
    at either end, and the attitudes as recordings have them by as many.
    """
    half_cosine = min(1.0, abs(float(q_WB[0] @ q_WB[-1])))
    chord = 2.0 * math.sqrt(1.0 - half_cosine**2) * reach
    return float(np.linalg.norm(p_WB[-1] - p_WB[0])) > chord + 16 * ROUNDING * reach


def single(values: Floats) -> Floats:
    """The numbers as single precision has them."""
    return values.astype(np.float32).astype(np.float64)


GRID_LINES = 10
"""Lines of a ground plane's grid on each side of its middle."""

PATH_POINTS = 600
"""Points of a drawn way; a smooth curve needs no more."""


def poses(batch: ShapeBatch, p_WB: Floats, q_WB: Floats) -> tuple[Floats, Floats]:
    """Poses of the shapes of a batch, (t, n, 3) m and (t, n, 4), from those of all bodies."""
    p, q = p_WB[:, batch.bodies], q_WB[:, batch.bodies]
    return (p, q) if batch.centred else compose(p, q, batch.p_BS, batch.q_BS)


def sharing(bodies: Sequence[Mapping[str, Any]], places: Sequence[int]) -> list[ShapeBatch]:
    """The bodies at these places, those that move: of one kind of shape they share a path, since a row has a number, a time and
    offsets of its own."""
    return batches(bodies, places, most=1)


def log_moving(
    rec: "rr.RecordingStream", root: str, bodies: Sequence[ShapeBatch], arrays: Mapping[str, Floats], paint: Paint
) -> None:
    """Log bodies that move below `root`: shapes once, and so the poses of those that stay where they are; poses in columns.

    A viewer takes a pose from one row and never puts it together from two: each row says place and attitude. One of them that
    stays the same is packed to next to nothing. So what turns about a point is told from there: the pose of that point over
    time, and its shapes as they lie about it, once.

    Args: bodies: by kind of shape, as `sharing` has them.
    """
    import rerun as rr

    time = arrays["time"]
    for batch in bodies:
        path = f"{root}/{batch.path}"
        p_WS, q_WS = poses(batch, arrays["p_WB"], arrays["q_WB"])
        checked(path, time, p_WS, q_WS)
        shapes = drawn(batch, paint)
        p, q = p_WS.astype(np.float32), xyzw(q_WS)
        stays = (p == p[:1]).all()
        if len(time) > 1 and stays and (q == q[:1]).all():
            rec.log(path, *shapes, rr.InstancePoses3D(translations=p[0], quaternions=q[0]), static=True)
        elif not stays and (pivot := shared_pivot(batch, arrays)) is not None:
            p_PS = (batch.p_BS - pivot.p_BP).astype(np.float32)
            rec.log(path, *shapes, rr.InstancePoses3D(translations=p_PS, quaternions=xyzw(batch.q_BS)), static=True)
            p_WP = np.broadcast_to(pivot.p_WP.astype(np.float32), (len(time), 3))
            turns = rr.Transform3D.columns(translation=p_WP, quaternion=xyzw(arrays["q_WB"][:, batch.bodies[0]]))
            rec.send_columns(path, columns(time), turns)
        else:
            rec.log(path, *shapes, static=True)
            rows = rr.InstancePoses3D.columns(translations=p.reshape(-1, 3), quaternions=q.reshape(-1, 4))
            rec.send_columns(path, columns(time), rows.partition(np.full(len(time), len(batch.bodies))))


def xyzw(q: Floats) -> Floats:
    """Quaternions (..., 4) in single precision, in rerun's order."""
    return q[..., [1, 2, 3, 0]].astype(np.float32)


def shared_pivot(batch: ShapeBatch, arrays: Mapping[str, Floats]) -> Pivot | None:
    """The point that all shapes of a batch turn about: that of their body, where they have one body and it has one."""
    body = batch.bodies[0]
    return pivot_of(arrays["p_WB"][:, body], arrays["q_WB"][:, body]) if (batch.bodies == body).all() else None


def log_paths(rec: "rr.RecordingStream", path: str, p_WB: Floats, colour: Rgba, extent: float) -> None:
    """Log the ways of few bodies, (t, n, 3) m, as lines for all time; bodies that hardly move leave none."""
    import rerun as rr

    if not 0 < p_WB.shape[1] <= CROWD:
        return
    stride = max(1, len(p_WB) // PATH_POINTS)
    ways = [way for way in np.moveaxis(p_WB, 1, 0) if np.ptp(way, axis=0).max() > 0.02 * extent]
    if ways:
        strips = [np.concatenate([way[:-1:stride], way[-1:]]).astype(np.float32) for way in ways]
        rec.log(path, rr.LineStrips3D(strips, colors=[colour], radii=rr.Radius.ui_points(1.0)), static=True)


def log_stage(rec: "rr.RecordingStream", scene: Mapping[str, Any], middle: Floats, extent: float, fill: str) -> None:
    """Log what never moves, once for all engines: static bodies, and joints that hold to the world."""
    import rerun as rr

    bodies = scene.get("bodies", [])
    still = [index for index, body in enumerate(bodies) if body["motion"] == "static"]
    for batch in batches(bodies, still):
        p_WB = np.array([bodies[k].get("p_WB", (0.0, 0.0, 0.0)) for k in batch.bodies], dtype=np.float64)
        q_WB = np.array([bodies[k].get("q_WB", (1.0, 0.0, 0.0, 0.0)) for k in batch.bodies], dtype=np.float64)
        p_WS, q_WS = compose(p_WB, q_WB, batch.p_BS, batch.q_BS)
        path = f"{STAGE}/{batch.path}"
        if batch.kind == "plane":
            normals = rotate(q_WS, np.broadcast_to([0.0, 0.0, 1.0], p_WS.shape))
            # A plane has no middle: it is drawn around the bodies.
            p_WS = middle - np.sum((middle - p_WS) * normals, axis=1, keepdims=True) * normals
            log_grid(rec, f"{path}/grid", p_WS, q_WS, extent)
        paint = Paint(GROUND, extent, "Solid" if batch.kind == "plane" and fill != "MajorWireframe" else fill)
        rec.log(path, *drawn(batch, paint), static=True)
        rec.log(path, rr.InstancePoses3D(translations=p_WS, quaternions=q_WS[:, [1, 2, 3, 0]]), static=True)
    held = [joint for joint in scene.get("joints", []) if joint["parent"] == "world" and "anchor_W" in joint]
    if held:
        pins = rr.Points3D(
            [joint["anchor_W"] for joint in held],
            colors=[GRID],
            radii=rr.Radius.ui_points(6.0),
            labels=[joint["name"] for joint in held],
            show_labels=False,
        )
        rec.log(f"{STAGE}/joints", pins, static=True)


def log_grid(rec: "rr.RecordingStream", path: str, p_WS: Floats, q_WS: Floats, extent: float) -> None:
    """Log a grid of lines on planes through p_WS with +z of S as normal."""
    import rerun as rr

    ticks = np.linspace(-extent, extent, 2 * GRID_LINES + 1)
    lift = extent / 2000
    lines = [np.array([[t, -extent, lift], [t, extent, lift]]) for t in ticks]
    lines += [np.array([[-extent, t, lift], [extent, t, lift]]) for t in ticks]
    strips = [p + rotate(q, line) for p, q in zip(p_WS, q_WS, strict=True) for line in lines]
    rec.log(path, rr.LineStrips3D(strips, colors=[GRID], radii=rr.Radius.ui_points(0.6)), static=True)


def truth_at(truth: Mapping[str, Floats], time: Floats) -> tuple[Floats, Floats, Floats]:
    """Places of the instants within the truth's range, and p_WB, q_WB there; between its instants by linear interpolation."""
    none = np.zeros(0, dtype=np.int64), np.zeros((0, 0, 3)), np.zeros((0, 0, 4))
    if "p_WB" not in truth or not len(time):
        return none
    known, p_WB, q_WB = truth["time"], truth["p_WB"], truth["q_WB"]
    slack = 1e-9 * max(1.0, float(known[-1]))
    kept = np.flatnonzero((time >= known[0] - slack) & (time <= known[-1] + slack))
    if len(known) < 2:
        return kept, p_WB[np.zeros(len(kept), dtype=np.int64)], q_WB[np.zeros(len(kept), dtype=np.int64)]
    after = np.clip(np.searchsorted(known, time[kept] - slack), 1, len(known) - 1)
    share = np.clip((time[kept] - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)
    share = np.where(share > 1 - 1e-6, 1.0, np.where(share < 1e-6, 0.0, share))[:, None, None]
    exact = (share == 0.0) | (share == 1.0)
    p = np.where(share == 1.0, p_WB[after], p_WB[after - 1])
    q = np.where(share == 1.0, q_WB[after], q_WB[after - 1])
    # Only where needed: a truth that is not told (NaN) at one end would spoil the other.
    p = np.where(exact, p, (1 - share) * p_WB[after - 1] + share * p_WB[after])
    near = np.where(np.sum(q_WB[after] * q_WB[after - 1], axis=-1, keepdims=True) < 0, -1.0, 1.0) * q_WB[after]
    mixed = (1 - share) * q_WB[after - 1] + share * near
    length = np.linalg.norm(mixed, axis=-1, keepdims=True)
    return kept, p, np.where(exact, q, mixed / np.where(length > 0, length, 1.0))


def told_places(stage: Stage) -> list[int]:
    """The moving bodies whose pose the truth tells at all times."""
    if "p_WB" not in stage.truth:
        return []
    poses = np.concatenate([stage.truth["p_WB"], stage.truth["q_WB"]], axis=2)
    finite = np.asarray(np.isfinite(poses).all(axis=(0, 2)))
    return [int(index) for index in stage.moving if finite[index]]


def log_truth(rec: "rr.RecordingStream", stage: Stage, extent: float) -> None:
    """Log the ghost of the truth, below world/truth."""
    places = told_places(stage)
    if not places:
        return
    seen = at_instants(stage.truth, shown(stage.truth["time"], stage.length))
    root = f"{WORLD}/{TRUTH}"
    paint = Paint(GHOST, extent, OVERLAID)
    log_moving(rec, root, sharing(stage.bodies, places), seen, paint)
    log_paths(rec, f"{root}/paths", stage.truth["p_WB"][:, places], (*GHOST[:3], 160), extent)


LONGEST = 3.0
"""No arrow is drawn longer than this many times the typical largest one; an impact would cover the view."""


def arrow_scale(runs: Sequence[RecordedRun], length: float) -> float:
    """Metres per newton: the median run's 99th percentile of force is drawn `length` [m] long; 0 where no force is."""
    large = []
    for run in runs:
        forces = np.linalg.norm(run.arrays.get("contacts_force_W", np.zeros((0, 3))), axis=1)
        forces = forces[np.isfinite(forces) & (forces > 0)]
        if len(forces):
            large.append(float(np.percentile(forces, 99)))
    return length / float(np.median(large)) if large else 0.0


def log_contacts(rec: "rr.RecordingStream", run: RecordedRun, scale: float, length: float) -> None:
    """Log an arrow for each contact with a force, scale [m/N], with an empty row where there is none."""
    import rerun as rr

    if scale == 0.0 or "contacts_count" not in run.arrays:
        return
    counts = run.arrays["contacts_count"]
    force, point = run.arrays["contacts_force_W"], run.arrays["contacts_point_W"]
    arrows = force * scale
    lengths = np.linalg.norm(arrows, axis=1)
    kept = np.isfinite(lengths) & np.isfinite(point).all(axis=1) & (lengths > 1e-3 * length)
    row = np.repeat(np.arange(len(counts)), counts)
    shown = np.bincount(row[kept], minlength=len(counts))
    shrink = np.minimum(1.0, LONGEST * length / np.where(kept, lengths, 1.0))
    arrows = arrows * np.where(kept, shrink, 0.0)[:, None]
    path = f"{WORLD}/{run.path}/contacts"
    checked(path, run.time, arrows[kept], point[kept])
    rec.log(path, rr.Arrows3D.from_fields(colors=[rgba(run.colour)], radii=[length / 40]), static=True)
    batch = rr.Arrows3D.columns(vectors=arrows[kept].astype(np.float32), origins=point[kept].astype(np.float32))
    rec.send_columns(path, columns(run.time), batch.partition(shown))
