"""A film strip of a scene: what the engine that is known best made of it, at a few instants, as pictures in the page."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from harness.store.imported_scenes import looks_of
from reports.contents import ours
from reports.drawing import drawn, view_of
from reports.pixels import data_uri
from reports.recordings.rotation import Floats, rotate
from reports.recordings.runs import dressed
from reports.solids import triangles_of
from reports.text import amount

if TYPE_CHECKING:
    from harness.findings.agreement import Agreement
    from harness.store.store import Store

__all__ = ["Film", "Frame", "film_of"]

FRAMES = 5
WIDTH, HEIGHT = 400, 320
MOST = 60_000
"""Triangles of a scene beyond which it is not drawn: a page must not wait for its pictures."""
BACKGROUND = (238, 241, 245)
GROUND = (0.80, 0.83, 0.87)
PLAIN = (0.45, 0.58, 0.72)
"""Of bodies whose scene states no colour."""
STATED = [0.8, 0.8, 0.8]
"""What a scene file has where nothing is stated."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One picture. Terms: address: of a PNG that holds itself, safe as it is; time [s]."""

    address: Markup
    time: float

    @property
    def caption(self) -> str:
        """When it is."""
        return f"{amount(self.time)} s"


@dataclass(frozen=True, slots=True)
class Film:
    """Pictures in their order. Terms: engine, track, dt [s]: of the run that is shown."""

    frames: tuple[Frame, ...]
    engine: str
    track: str
    dt: float


def film_of(store: "Store", agreement: "Agreement") -> Film | None:
    """The strip of the finest run of the side whose limit is known best; None where no run has an answer to draw."""
    yardsticks = ours(store)
    ranked = sorted(
        (side for side in agreement.sides if any(rung.run is not None for rung in side.limit.rungs)),
        key=lambda side: (
            side.engine in yardsticks,
            side.word != "agrees",
            side.track != "tuned",
            -side.limit.until,
            _bar(side),
        ),
    )
    if not ranked:
        return None
    side = ranked[0]
    rung = [rung for rung in side.limit.rungs if rung.run is not None][-1]
    trials = store.trials
    hashes = trials.loc[trials["trial"] == rung.trial, "trajectory_hash"]
    arrays = store.trajectory(str(hashes.iloc[0]), ("scene", "time", "p_WB", "q_WB"))
    scene = dressed(json.loads(str(arrays["scene"])), looks_of(store.folder, agreement.case))
    frames = _frames(scene.get("bodies", []), arrays)
    return Film(frames, side.engine, side.track, rung.dt) if frames else None


def _bar(side: Any) -> float:
    """How far off a side's limit may be; infinite where it has none."""
    return math.inf if side.limit.bar is None else float(side.limit.bar_at(side.limit.until))


def _frames(bodies: Sequence[Mapping[str, Any]], arrays: Mapping[str, Any]) -> tuple[Frame, ...]:
    time, p, q = (np.asarray(arrays[name], dtype=np.float64) for name in ("time", "p_WB", "q_WB"))
    sound = np.isfinite(p).all(axis=(1, 2)) & np.isfinite(q).all(axis=(1, 2))
    time, p, q = time[sound], p[sound], q[sound]
    solids = [triangles_of(body) for body in bodies]
    if not len(time) or not 0 < sum(map(len, solids)) <= MOST:
        return ()
    places = sorted({int(k) for k in np.linspace(0, len(time) - 1, FRAMES).round()})
    paint = np.concatenate(
        [np.broadcast_to(_colour(body), (len(triangles), 3)) for body, triangles in zip(bodies, solids, strict=True)]
    )
    posed = [np.concatenate([_posed(triangles, p[k, b], q[k, b]) for b, triangles in enumerate(solids)]) for k in places]
    moving = np.concatenate([triangles.reshape(-1, 3) for triangles in posed])
    floor = _floor(bodies, moving)
    view = view_of(np.concatenate([moving, floor.reshape(-1, 3)]) if len(floor) else moving, WIDTH, HEIGHT)
    ground = np.broadcast_to(np.array(GROUND), (len(floor), 3))
    return tuple(
        Frame(
            Markup(data_uri(_pixels(view, np.concatenate([floor, triangles]), np.concatenate([ground, paint])))), float(time[k])
        )
        for triangles, k in zip(posed, places, strict=True)
    )


def _pixels(view: Any, triangles: Floats, paint: Floats) -> NDArray[np.uint8]:
    return drawn(view, triangles, paint, BACKGROUND)


def _posed(triangles: Floats, p: Floats, q: Floats) -> Floats:
    return rotate(np.broadcast_to(q, (*triangles.shape[:2], 4)), triangles) + p if len(triangles) else triangles


def _colour(body: Mapping[str, Any]) -> Floats:
    """For a screen, of the linear one that the scene states."""
    stated = body.get("appearance", {}).get("colour", STATED)
    if list(stated) == STATED:
        return np.array(GROUND if body["motion"] == "static" else PLAIN)
    colour: Floats = np.clip(np.array(stated, dtype=np.float64), 0.0, 1.0) ** (1 / 2.2)
    return colour


def _floor(bodies: Sequence[Mapping[str, Any]], points: Floats) -> Floats:
    """A square of the first level plane, around what is drawn, as triangles (2, 3, 3) m; none where there is no plane."""
    for body in bodies:
        for placed in body.get("collision", []):
            shape = placed["shape"]
            if shape["type"] == "plane" and list(shape.get("normal", [0.0, 0.0, 1.0])) == [0.0, 0.0, 1.0]:
                z = body.get("p_WB", (0.0, 0.0, 0.0))[2] + placed.get("p_BS", (0.0, 0.0, 0.0))[2]
                (x0, y0, _), (x1, y1, _) = points.min(axis=0), points.max(axis=0)
                room = 0.15 * max(x1 - x0, y1 - y0, 1e-9)
                a, b, c, d = (
                    (x, y, z)
                    for x, y in (
                        (x0 - room, y0 - room),
                        (x1 + room, y0 - room),
                        (x1 + room, y1 + room),
                        (x0 - room, y1 + room),
                    )
                )
                return np.array([[a, b, c], [a, c, d]])
    return np.zeros((0, 3, 3))
