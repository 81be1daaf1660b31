"""All that can be seen of each case of a store: its thumbnail, its strips, its series, and where to watch it."""

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from plumbline.harness.intake.safe_text import LONGEST, one_line
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.reports.charts.marks import looks
from plumbline.reports.pictures.motion import MotionPicture, RunLine, motion_of
from plumbline.reports.pictures.motion_chart import Panel, apart, overview
from plumbline.reports.pictures.stills import Film, Still, film, thumbnail
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.recordings.runs import stage_of
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.words.catalogue import cases, engines


@dataclass(frozen=True, slots=True)
class Watch:
    """Where a run is worth watching.

    Terms: moment [s]; why: what is there. worst: the largest error, in the unit of the series; bound: of it. address: of the
    viewer under `plumbline serve`, '' without a recording.
    """

    engine: str
    track: str
    trial: str
    moment: float
    why: str
    worst: float | None
    bound: float | None
    address: str


@dataclass(frozen=True, slots=True)
class CaseSight:
    """What a page shows of a case. Terms: parting: the moment at which engines part, None where they do not. missing: why
    something is not shown, in words, one each."""

    thumb: Still | None
    film: Film | None
    parting: Film | None
    motion: MotionPicture | None
    overview: Panel | None
    apart: tuple[Panel, ...]
    watches: tuple[Watch, ...]
    serve: str
    missing: tuple[str, ...]

    @property
    def stills(self) -> tuple[Still, ...]:
        """All pictures."""
        rows = [row for each in (self.film, self.parting) if each for row in each.rows]
        return (*([self.thumb] if self.thumb else []), *(row.still for row in rows))


def thumbnails(store: Store) -> dict[str, Still]:
    """The thumbnail of each case that has one, by its name."""
    return {name: thumb for name, seen in sights(store).items() if (thumb := seen.thumb) is not None}


def sights(store: Store) -> dict[str, CaseSight]:
    """By the names of all cases."""
    return {name: sight(store, name) for name in cases(store)}


@lru_cache(maxsize=512)
def sight(store: Store, name: str) -> CaseSight:
    """What there is to see of a case; whatever fails is a line that says so, since a page has more to tell."""
    serve = f"plumbline serve {shlex.quote(str(store.folder))}"
    try:
        stage = stage_of(store, name)
        motion = motion_of(store, stage)
        named = engines(store)
        titles = {engine: str(entry["title"]) for engine, entry in named.items()}
        chosen = looks(named)
        recording = file_name(name)
        partings = [split.since for agreement in by_case(store).get(name, ()) for split in agreement.differences]
        kept = (store.folder / "recordings" / recording).is_file()
        watches = tuple(
            Watch(line.engine, line.track, line.trial, moment, why, line.worst, line.bound,
                  f"/view?recording=/recordings/{recording}&at={moment:.6f}" if kept else "")
            for line in (motion.lines if motion else ())
            for moment, why in [_worth_watching(line, partings)]
        )  # fmt: skip
        return CaseSight(
            thumb=thumbnail(stage),
            film=film(stage),
            parting=film(stage, _about(min(partings), stage.length)) if partings else None,
            motion=motion,
            overview=overview(motion, chosen) if motion else None,
            apart=apart(motion, chosen, titles) if motion else (),
            watches=watches,
            serve=serve,
            missing=_missing(store, name, stage.notes, bool(stage.runs)),
        )
    except (StoreError, ValueError, KeyError, IndexError, TypeError) as error:
        print(one_line(f"pictures of case '{name}': {type(error).__name__}: {error}", LONGEST), file=sys.stderr)
        return CaseSight(
            None, None, None, None, None, (), (), serve, (f"Nothing could be drawn: {type(error).__name__}: {error}",)
        )


def _about(moment: float, duration: float) -> tuple[float, float]:
    """From a tenth of the run before a moment [s] to three tenths after it, within the run."""
    return max(0.0, moment - 0.1 * duration), min(duration, moment + 0.3 * duration)


def _worth_watching(line: RunLine, partings: Sequence[float]) -> tuple[float, str]:
    """When [s], and why in words: where a run leaves the truth, or without one where camps of engines part."""
    if len(line.off) or line.broken or not partings:
        return line.moment, line.why
    return min(partings), "where engines part"


def _missing(store: Store, name: str, notes: object, drawn: bool) -> tuple[str, ...]:
    """Why there is nothing to draw, or not of every run."""
    trials = store.trials
    mine = trials[trials["case"] == name]
    hashed = mine[mine["trajectory_hash"].map(lambda value: isinstance(value, str) and value != "")]
    if not len(hashed):
        return () if drawn else ("No trial of this case left a trajectory, so that there is no motion to draw.",)
    if not hashed["trajectory_kept"].any():
        return (f"Trajectories were kept by their hash alone: plumbline reproduce {shlex.quote(str(store.folder))} "
                f"{hashed['trial'].iloc[0]} runs one again.",)  # fmt: skip
    folder = store.folder / "trajectories"
    if not drawn:
        return (f"The trajectories are no longer in {folder.name}/, so that there is no motion to draw.",)
    return tuple(dict.fromkeys(str(note) for note in getattr(notes, "values", tuple)()))
