"""Pictures of a case: its scene as a thumbnail, and what happened as strips, a row for engines that look alike."""

import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.reports.drawn.picture import Backdrop, backdrop_of, picture
from plumbline.reports.drawn.solids import DrawnSolid, opened, solids_of, stage_set
from plumbline.reports.drawn.view import Spheres, View, framed
from plumbline.reports.recordings.bodies import told_places, truth_at
from plumbline.reports.recordings.camera import anchors_of, around_held, held_by, reach
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.recordings.runs import Stage

DRAWN_BY = "8"
"""Rises with any change of how pictures are made, so that kept ones of before are not taken for them."""
SIZE, FRAME = (264, 176), (168, 126)
"""Pixels across and up, of a thumbnail and of one moment of a strip."""
MOMENTS, EXPOSURES, ROWS, MOST = 5, 7, 3, 5
"""Rows of a strip are ROWS, or as many as there are engines where no truth is told, at most MOST."""
ALIKE = 0.015
"""Of the width of a strip: engines whose bodies are nowhere farther apart share a row."""
SMALLEST = 0.032
"""Of what is seen: what moves is drawn larger where it would be smaller, since a page would not show it."""
FACES = 60_000
"""Triangles of meshes beyond which a scene is not drawn: a page must not wait for its pictures."""
BODIES = 1500
QUALITY = 82


@dataclass(frozen=True)
class Still:
    """A picture that is made when it is asked for. Terms: key: a digest of all that it shows. alt: in words."""

    key: str
    alt: str
    pixels: "partial[NDArray[np.uint8]]"

    @property
    def path(self) -> str:
        """Its file in the report."""
        return f"pictures/{self.key}.webp"

    @cached_property
    def content(self) -> bytes:
        """The bytes of a WebP."""
        from PIL import Image  # late: only a report with pictures needs it

        buffer = io.BytesIO()
        Image.fromarray(self.pixels()).save(buffer, format="WEBP", quality=QUALITY, alpha_quality=100, method=3)
        return buffer.getvalue()

    def standing(self, report: Path) -> bytes | None:
        """The same bytes in an earlier report of the folder, where they are whole."""
        try:
            content = (report / self.path).read_bytes()
        except OSError:
            return None
        whole = content[:4] == b"RIFF" and int.from_bytes(content[4:8], "little") + 8 == len(content)
        return content if whole else None

    def kept(self, report: Path) -> bytes:
        """The standing bytes, else those made now."""
        return self.standing(report) or self.content


@dataclass(frozen=True, slots=True)
class StripRow:
    """One strip. Terms: told: does the truth look so too? runs: (engine, track) of those that do."""

    told: bool
    runs: tuple[tuple[str, str], ...]
    still: Still


@dataclass(frozen=True, slots=True)
class Film:
    """Strips of the same moments [s]. Terms: larger: how many times what moves is drawn larger. left: runs beyond the rows."""

    moments: tuple[float, ...]
    rows: tuple[StripRow, ...]
    larger: float
    left: int


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """Poses at the moments (k, n, 3) m and (k, n, 4), as far as there are any: a run that ends early has fewer."""

    p: Floats
    q: Floats


_Group = tuple[_Motion, bool, list[tuple[str, str]]]
"""Poses, whether they are the truth's, and the runs that look so."""


def thumbnail(stage: Stage) -> Still | None:
    """The scene with what moves at several instants, earlier ones paler; None where it cannot be drawn."""
    if not _drawable(stage):
        return None
    moments = np.linspace(0.0, _end(stage), EXPOSURES)
    motion = _told(stage, moments) or _run(stage, 0, moments)
    low, high, larger = _framing(stage, [motion])
    travelled = _travelled(stage, motion)
    view = framed(low, high, *SIZE, _spheres(stage, [motion], larger, (low, high)))
    shown = range(len(motion.p)) if travelled and len(stage.moving) <= 12 else (0,)
    return _still(stage, f"The scene of {stage.case.get('title') or stage.name}", [[motion.p[k] for k in shown]],
                  [[motion.q[k] for k in shown]], view, larger)  # fmt: skip


def film(stage: Stage, between: tuple[float, float] | None = None) -> Film | None:
    """The strips of a case; None where it cannot be drawn or nothing moves visibly. Args: between [s]: all unless said."""
    if not _drawable(stage) or not len(stage.moving):
        return None
    moments = np.linspace(*(between or (0.0, _end(stage))), MOMENTS)
    told = _told(stage, moments)
    motions = [_run(stage, k, moments) for k in range(len(stage.runs))]
    low, high, larger = _framing(stage, [told] if told else motions)
    view = framed(low, high, *FRAME, () if told else _spheres(stage, motions, larger, (low, high)))
    near = ALIKE * view.pixel * view.width
    groups: list[_Group] = [(told, True, [])] if told else []
    for run, motion in zip(stage.runs, motions, strict=True):
        group = next((group for group in groups if _apart(group[0], motion, stage) < near), None)
        if group is None:
            groups.append((motion, False, group_runs := []))
            group_runs.append((run.engine, run.track))
        else:
            group[2].append((run.engine, run.track))
    title = stage.case.get("title") or stage.name
    rows = []
    listed, left = _listed(groups)
    for motion, is_truth, runs in listed:
        names = [*(["the truth"] if is_truth else []), *(f"{engine} {track}" for engine, track in runs)]
        alt = f"{title} at {len(moments)} moments: {', '.join(names)}"
        rows.append(
            StripRow(is_truth, tuple(runs), _still(stage, alt, [[p] for p in motion.p], [[q] for q in motion.q], view, larger))
        )
    return Film(tuple(moments.tolist()), tuple(rows), larger, sum(len(runs) for _, _, runs in left))


def _listed(groups: Sequence["_Group"]) -> tuple[list["_Group"], list["_Group"]]:
    """The groups that are shown, the truth's first and before all a second look at an engine each engine once; and the rest."""
    first: list[_Group] = []
    again: list[_Group] = []
    shown: set[str] = set()
    for group in groups:
        engines = {engine for engine, _ in group[2]}
        (first if group[1] or engines - shown else again).append(group)
        shown |= engines
    most = ROWS if groups and groups[0][1] else min(MOST, max(ROWS, len(shown)))
    return [*first, *again][:most], [*first, *again][most:]


def _drawable(stage: Stage) -> bool:
    shapes = [placed["shape"] for body in stage.bodies for placed in (body.get("visual") or body.get("collision", []))]
    solid = any(shape["type"] != "plane" for shape in shapes)
    faces = sum(len(shape.get("faces", ())) for shape in shapes)
    return bool(stage.runs) and solid and faces <= FACES and len(stage.bodies) <= BODIES


def _end(stage: Stage) -> float:
    return max(float(run.time[-1]) for run in stage.runs)


def _run(stage: Stage, place: int, moments: Floats) -> _Motion:
    """A run at the stored instants next to the moments, as far as it goes."""
    run = stage.runs[place]
    room = 0.5 * float(np.diff(run.time).max()) if len(run.time) > 1 else 0.0
    rows = [int(np.abs(run.time - moment).argmin()) for moment in moments if moment <= run.time[-1] + room + 1e-9] or [0]
    return _Motion(run.arrays["p_WB"][rows], run.arrays["q_WB"][rows])


def _told(stage: Stage, moments: Floats) -> _Motion | None:
    """The truth at the moments, what does not move as the scene has it; None where it does not tell all that moves."""
    if not stage.truth or set(told_places(stage)) != {int(k) for k in stage.moving}:
        return None
    time = stage.truth["time"]
    kept, p, q = truth_at(stage.truth, time)
    if not len(kept):
        return None
    rows = [int(np.abs(time[kept] - moment).argmin()) for moment in moments]
    p, q = np.array(p[rows]), np.array(q[rows])
    start = _run(stage, 0, moments[:1])
    still = [k for k in range(len(stage.bodies)) if k not in {int(k) for k in stage.moving}]
    p[:, still], q[:, still] = start.p[0, still], start.q[0, still]
    return _Motion(p, q) if np.isfinite(p).all() and np.isfinite(q).all() else None


def _framing(stage: Stage, motions: Sequence[_Motion]) -> tuple[Floats, Floats, float]:
    """The corners of the box around what moves, or around all where nothing does, and how much larger that is drawn."""
    places = [int(k) for k in stage.moving] or list(range(len(stage.bodies)))
    sizes = np.array([max(reach(stage.bodies[k]), 1e-6) for k in places])
    lows = [(motion.p[:, places] - sizes[:, None]).min(axis=(0, 1)) for motion in motions]
    highs = [(motion.p[:, places] + sizes[:, None]).max(axis=(0, 1)) for motion in motions]
    low, high = np.median(lows, axis=0), np.median(highs, axis=0)
    # All of it where what moves has no shape.
    low, high = around_held(stage, low, high, all_of_it=bool(sizes.max() <= 1e-6))
    larger = max(1.0, SMALLEST * float(np.linalg.norm(high - low)) / float(sizes.max()))
    return low - (larger - 1.0) * sizes.max(), high + (larger - 1.0) * sizes.max(), larger


def _spheres(stage: Stage, motions: Sequence[_Motion], larger: float, box: tuple[Floats, Floats]) -> Spheres:
    """Of the bodies that move, where they hang on what never does and what holds them; none where what stands around is part
    of the show."""
    if stage.truth or not len(stage.moving) or any(sensor["type"] == "lidar" for sensor in stage.scene.get("sensors", [])):
        return ()
    places = [int(k) for k in stage.moving]
    sizes = larger * np.array([reach(stage.bodies[k]) for k in places])
    anchors, (held, radii) = anchors_of(stage), held_by(stage, *box)
    return [
        (
            np.concatenate([motion.p[:, places].reshape(-1, 3), anchors, held]),
            np.concatenate([np.tile(sizes, len(motion.p)), np.zeros(len(anchors)), radii]),
        )
        for motion in motions
    ]


def _travelled(stage: Stage, motion: _Motion) -> bool:
    """Does anything go farther than half its size?"""
    places = [int(k) for k in stage.moving]
    sizes = np.array([reach(stage.bodies[k]) for k in places])
    way = np.linalg.norm(motion.p[:, places] - motion.p[:1, places], axis=2).max(axis=0)
    return bool(len(places) and (way > 0.5 * sizes).any())


def _apart(a: _Motion, b: _Motion, stage: Stage) -> float:
    """The largest distance [m] between points of the moving bodies at shared moments; infinite where one ends early."""
    if len(a.p) != len(b.p):
        return float("inf")
    places = [int(k) for k in stage.moving]
    sizes = np.array([reach(stage.bodies[k]) for k in places])
    moved = np.linalg.norm(a.p[:, places] - b.p[:, places], axis=2)
    q, r = a.q[:, places], b.q[:, places]
    turned = np.minimum(np.linalg.norm(q - r, axis=2), np.linalg.norm(q + r, axis=2)) * 2.0 * sizes
    return float(np.max(moved + turned)) if len(places) else 0.0


def _still(
    stage: Stage, alt: str, places: Sequence[Sequence[Floats]], turns: Sequence[Sequence[Floats]], view: View, larger: float
) -> Still:
    """Panels side by side, each with one or more instants of all bodies."""
    digest = hashlib.sha256(f"{DRAWN_BY} {view.R} {view.middle} {view.pixel} {view.width} {view.height} {larger}".encode())
    digest.update(json.dumps(stage.scene, sort_keys=True).encode())
    for panel in (*places, *turns):
        digest.update(np.round(np.asarray(panel), 9).tobytes())
    return Still(digest.hexdigest()[:20], alt, partial(_panels, stage.scene, places, turns, view, larger))


@lru_cache(maxsize=2)
def _around(fixed: str, view: View) -> tuple[list[DrawnSolid], Backdrop]:
    """What pictures of one view share. Args: fixed: bodies that never move, as JSON."""
    solids, ground = stage_set(json.loads(fixed), view)
    return solids, backdrop_of(view, ground)


def _panels(scene: Any, places: Any, turns: Any, view: View, larger: float) -> NDArray[np.uint8]:
    bodies: list[Any] = scene.get("bodies", [])
    panels: list[NDArray[np.uint8]] = []
    fixed, backdrop = _around(json.dumps([b for b in bodies if b["motion"] == "static"]), view)
    for number, (p, q) in enumerate(zip(places, turns, strict=True)):
        if number and np.allclose(p, places[number - 1], atol=1e-9) and np.allclose(q, turns[number - 1], atol=1e-9):
            panels.append(panels[-1])
            continue
        last = len(p) - 1
        solids = [
            solid
            for k in range(len(p))
            for solid in solids_of(
                opened(bodies, p[k], q[k], view.R[2]), p[k], q[k], fade=(last - k) / max(last, 1), larger=larger
            )
        ]
        panels.append(picture(backdrop, [*solids, *fixed]))
    ended = [np.zeros_like(panels[0])] * (MOMENTS - len(panels) if len(panels) > 1 or view.width == FRAME[0] else 0)
    wide: NDArray[np.uint8] = np.concatenate([*panels, *ended], axis=1)
    return wide
