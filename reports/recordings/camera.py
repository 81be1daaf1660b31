"""Where to look from: the part of the world that a case plays in, and an eye that sees its motion broadside."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from reports.recordings.rotation import Floats
from reports.recordings.runs import Stage
from reports.recordings.shapes import placed_shapes
from reports.recordings.truth import told_places

__all__ = ["Framing", "framing"]

FIELD_OF_VIEW = math.radians(55.0)
"""The viewer's vertical opening angle."""


@dataclass(frozen=True, slots=True)
class Framing:
    """A sphere that holds the motion, and an eye outside it; all in W [m]."""

    centre: Floats
    radius: float
    eye: Floats


def reach(body: Mapping[str, Any]) -> float:
    """Radius [m] about the centre of mass within which the body's bounded shapes lie."""
    largest = 0.0
    for placed in placed_shapes(body):
        shape = placed["shape"]
        match shape["type"]:
            case "sphere":
                size = shape["radius"]
            case "box":
                size = math.hypot(*shape["half_extents"])
            case "cylinder":
                size = math.hypot(shape["radius"], shape["half_length"])
            case "capsule":
                size = shape["radius"] + shape["half_length"]
            case "convex_hull" | "triangle_mesh":
                size = float(np.linalg.norm(np.asarray(shape["vertices"]), axis=1).max())
            case _:
                continue
        largest = max(largest, math.hypot(*placed.get("p_BS", (0.0, 0.0, 0.0))) + size)
    return largest


def bounds(paths: Sequence[Floats], sizes: Floats) -> tuple[Floats, Floats]:
    """The box around bodies of these radii (n,) on each of these paths (t, n, 3); the median where several runs tell."""
    low = np.median([(p - sizes[:, None]).min(axis=(0, 1)) for p in paths], axis=0)
    high = np.median([(p + sizes[:, None]).max(axis=(0, 1)) for p in paths], axis=0)
    return low, high


def framing(stage: Stage) -> Framing:
    """The framing of a stage: from its truth, else from the runs, of which a diverged one cannot take the view away."""
    told = told_places(stage)
    places = told or [int(place) for place in stage.moving] or list(range(len(stage.bodies)))
    if not places:
        return Framing(np.zeros(3), 1.0, np.array([2.0, -2.0, 1.5]))
    sizes = np.array([reach(stage.bodies[place]) for place in places])
    paths = [stage.truth["p_WB"][:, places]] if told else [run.arrays["p_WB"][:, places] for run in stage.runs]
    low, high = bounds(paths, sizes)
    for joint in stage.scene.get("joints", []):
        if joint["parent"] == "world" and "anchor_W" in joint:
            low, high = np.minimum(low, joint["anchor_W"]), np.maximum(high, joint["anchor_W"])
    for sensor in stage.scene.get("sensors", []):
        if sensor["type"] == "lidar":
            fixed = [(np.asarray(b["p_WB"]), reach(b)) for b in stage.bodies if b["motion"] == "static" and 0 < reach(b)]
            low = np.min([low, *(p - 0.7 * r for p, r in fixed)], axis=0)
            high = np.max([high, *(p + 0.7 * r for p, r in fixed)], axis=0)
    extent = np.maximum(high - low, 1e-6)
    radius = float(np.linalg.norm(extent) / 2)
    centre = (low + high) / 2
    return Framing(centre, radius, centre + eye_direction(extent) * radius / math.sin(FIELD_OF_VIEW / 2))


def eye_direction(extent: Floats) -> Floats:
    """The unit vector from the middle to the eye: across the longer horizontal side, from above where all lies flat."""
    x, y, z = extent
    side = np.array([y + 0.35 * max(x, y), -(x + 0.35 * max(x, y))])
    side /= np.linalg.norm(side)
    flatness = 1.0 - min(1.0, z / max(x, y))
    rise = math.radians(12.0 + 30.0 * flatness * min(x, y) / max(x, y))
    return np.array([*(side * math.cos(rise)), math.sin(rise)])
