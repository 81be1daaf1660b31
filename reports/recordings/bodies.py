"""Bodies in motion: their shapes once, their poses over time, and the ways that they took."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.reports.recordings.colour import GRID, GROUND, Rgba
from plumbline.reports.recordings.layout import STAGE
from plumbline.reports.recordings.pivot import Pivot, pivot_of
from plumbline.reports.recordings.rotation import Floats, compose, rotate
from plumbline.reports.recordings.shapes import CROWD, Paint, ShapeBatch, batches, drawn
from plumbline.reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

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
    rec: "rr.RecordingStream",
    root: str,
    bodies: Sequence[ShapeBatch],
    arrays: Mapping[str, Floats],
    paint: Paint,
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
