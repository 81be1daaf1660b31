"""Where to look from: the part of the world that a case plays in, and an eye that sees its motion broadside."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.trajectory.kinematics import product, rotate
from plumbline.reports.recordings.bodies import told_places
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.recordings.shapes import placed_shapes

FIELD_OF_VIEW = math.radians(55.0)
"""The viewer's vertical opening angle."""

UNTURNED = (1.0, 0.0, 0.0, 0.0)


LONG = 5.0
"""A row that is longer than this many times its other size is looked along; from the side it would be a thread."""


@dataclass(frozen=True, slots=True)
class Framing:
    """What a view shows; all in W [m].

    Terms:
        centre, radius: a sphere that holds the motion. eye, target: from where to where it is looked at. low: the lowest point
        of the motion. size: of what fills the view, which lengths of arrows and lines follow.
    """

    centre: Floats
    radius: float
    eye: Floats
    target: Floats
    low: float
    size: float


def reach(body: Mapping[str, Any]) -> float:
    """Radius [m] about the centre of mass within which the body's bounded shapes lie."""
    return max((radius + math.hypot(*placed.get("p_BS", (0.0, 0.0, 0.0))) for placed, radius in _bounded(body)), default=0.0)


def _bounded(body: Mapping[str, Any]) -> Iterator[tuple[Mapping[str, Any], float]]:
    """The shapes of a body that have an end, each with its radius [m] about the middle of its frame."""
    for placed in placed_shapes(body):
        shape = placed["shape"]
        match shape["type"]:
            case "sphere":
                yield placed, shape["radius"]
            case "box":
                yield placed, math.hypot(*shape["half_extents"])
            case "ellipsoid":
                yield placed, max(shape["semi_axes"])
            case "cylinder":
                yield placed, math.hypot(shape["radius"], shape["half_length"])
            case "capsule":
                yield placed, shape["radius"] + shape["half_length"]
            case "convex_hull" | "triangle_mesh":
                yield placed, float(np.linalg.norm(np.asarray(shape["vertices"]), axis=1).max())


def held_by(stage: Stage, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """What holds a machine that joints hang on what never moves: centres (n, 3) and radii (n,) [m] of spheres about shapes.

    Those fixed ones that are no larger than the box of what moves, between `low` and `high`, and no farther from such a joint
    than half of that: the trunk of a robot that is welded to the world, and no wall behind it.
    """
    size = float(np.linalg.norm(high - low))
    anchors = anchors_of(stage)
    spheres = [
        (
            np.asarray(body["p_WB"])
            + rotate(np.asarray(body.get("q_WB", UNTURNED)), np.asarray(placed.get("p_BS", (0, 0, 0)), float)),
            r,
        )
        for body in stage.bodies
        if body["motion"] == "static"
        for placed, r in _bounded(body)
        if 2.0 * r <= size
    ]
    near = [(c, r) for c, r in spheres if len(anchors) and np.linalg.norm(anchors - c, axis=1).min() - r <= size / 2.0]
    return np.array([c for c, _ in near]).reshape(-1, 3), np.array([r for _, r in near])


def anchors_of(stage: Stage) -> Floats:
    """Where joints hang what moves on what never does, the world or a static body, (n, 3) m."""
    fixed = {"world", *(body["name"] for body in stage.bodies if body["motion"] == "static")}
    anchors = []
    for joint in stage.scene.get("joints", []):
        on_parent, on_child = joint["parent"] in fixed, joint["child"] in fixed
        if "anchor_W" in joint and on_parent != on_child:
            anchors.append(joint["anchor_W"] if on_parent else joint.get("child_anchor_W", joint["anchor_W"]))
    return np.array(anchors, dtype=np.float64).reshape(-1, 3)


def around_held(stage: Stage, low: Floats, high: Floats, *, all_of_it: bool = False) -> tuple[Floats, Floats]:
    """The box of what moves, grown around where joints hang it on what never moves, what holds it there, and what a scan sees.

    Args: all_of_it: grown around all that never moves?
    """
    centres, radii = held_by(stage, low, high)
    points = [anchors_of(stage), centres - radii[:, None], centres + radii[:, None], np.stack([low, high])]
    if all_of_it or any(sensor["type"] == "lidar" for sensor in stage.scene.get("sensors", [])):
        still = ((np.asarray(body["p_WB"]), half_sides(body)) for body in stage.bodies if body["motion"] == "static")
        points += [np.stack([p - sides, p + sides]) for p, sides in still if sides.any()]
    corners = np.concatenate(points)
    return corners.min(axis=0), corners.max(axis=0)


def bounds(paths: Sequence[Floats], sizes: Floats) -> tuple[Floats, Floats]:
    """The box around bodies of these radii (n,) on each of these paths (t, n, 3); the median where several runs tell."""
    low = np.median([(p.min(axis=0) - sizes[:, None]).min(axis=0) for p in paths], axis=0)
    high = np.median([(p.max(axis=0) + sizes[:, None]).max(axis=0) for p in paths], axis=0)
    return low, high


def half_sides(body: Mapping[str, Any]) -> Floats:
    """Half the sides (3,) m of a box along W around a body at its start; exact for boxes, generous for all else."""
    sides = np.zeros(3)
    for placed in placed_shapes(body):
        if placed["shape"]["type"] == "box":
            q_WS = product(np.asarray(body.get("q_WB", UNTURNED)), np.asarray(placed.get("q_BS", UNTURNED)))
            edges = rotate(np.broadcast_to(q_WS, (3, 4)), np.diag(placed["shape"]["half_extents"]))
            sides = np.maximum(sides, np.abs(edges).sum(axis=0))
        else:
            sides = np.maximum(sides, reach(body))
    return sides


def framing(stage: Stage) -> Framing:
    """The framing of a stage: from its truth, else from the runs, of which a diverged one cannot take the view away."""
    with_truth = told_places(stage)
    places = with_truth or [int(index) for index in stage.moving] or list(range(len(stage.bodies)))
    paths = [stage.truth["p_WB"][:, places]] if with_truth else [run.arrays["p_WB"][:, places] for run in stage.runs]
    if not places or not paths:
        return Framing(np.zeros(3), 1.0, np.array([2.0, -2.0, 1.5]), np.zeros(3), -1.0, 1.0)
    low, high = bounds(paths, np.array([reach(stage.bodies[index]) for index in places]))
    return framed(*around_held(stage, low, high))


def framed(low: Floats, high: Floats) -> Framing:
    """The framing of a box: broadside, or along it where it is a long row."""
    extent = np.maximum(high - low, 1e-6)
    radius, centre = float(np.linalg.norm(extent) / 2), (low + high) / 2
    along = 0 if extent[0] > extent[1] else 1
    across = math.hypot(extent[1 - along], extent[2])
    if extent[along] < LONG * across:
        eye = centre + eye_direction(extent) * radius / math.sin(FIELD_OF_VIEW / 2)
        return Framing(centre, radius, eye, centre, float(low[2]), radius)
    # From beside the near end of the row, over its shoulder, towards its middle.
    depth, side = np.eye(3)[along], np.eye(3)[1 - along] * (1.0 if along else -1.0)
    if along == 0:
        depth = -depth
    near = centre - depth * extent[along] / 2
    eye = near - depth * 1.2 * across + side * 1.5 * across + np.array([0.0, 0.0, 1.3 * across])
    return Framing(centre, radius, eye, near + depth * 1.6 * across, float(low[2]), 1.5 * across)


def eye_direction(extent: Floats) -> Floats:
    """The unit vector from the middle to the eye: across the longer horizontal side, from above where all lies flat."""
    x, y, z = extent
    side = np.array([y + 0.35 * max(x, y), -(x + 0.35 * max(x, y))])
    side /= np.linalg.norm(side)
    flatness = 1.0 - min(1.0, z / max(x, y))
    rise = math.radians(14.0 + 30.0 * flatness * min(x, y) / max(x, y))
    return np.array([*(side * math.cos(rise)), math.sin(rise)])
