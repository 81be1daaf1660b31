"""The layout that a recording opens with: engines overlaid, each by itself, plots and text."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from reports.recordings.camera import Framing
from reports.recordings.layout import LOG, METRICS, SENSORS, SIM_TIME, STAGE, TRUTH, WORLD
from reports.recordings.metrics import TITLES
from reports.recordings.runs import Run, Stage
from reports.recordings.sensors import CHANNELS

if TYPE_CHECKING:
    import rerun.blueprint as rrb

__all__ = ["layout"]

WATCH = 6.0
"""Seconds that a case takes to play; shorter ones are slowed down to it."""


def layout(stage: Stage, frame: Framing, metrics: set[str], signals: set[str]) -> "rrb.Blueprint":
    """The blueprint of a case."""
    import rerun.blueprint as rrb

    text = rrb.TextDocumentView(origin=f"/{LOG}", name="Outcomes")
    if not stage.runs:
        return rrb.Blueprint(text, collapse_panels=True)
    tracks = list(dict.fromkeys(run.track for run in stage.runs))
    clouds = sorted(where for where in signals if where.endswith("/points"))
    views = [
        space(f"All engines, {track}", [run for run in stage.runs if run.track == track], frame, clouds, "MajorWireframe")
        for track in tracks
    ]
    alone = [space(f"{run.engine} {run.track}", [run], frame, clouds, "Solid") for run in stage.runs]
    views += [rrb.Grid(*alone, grid_columns=2 if len(alone) <= 4 else 3 if len(alone) <= 9 else 4, name="Side by side")]
    plots = [plot(f"/{METRICS}/{metric}", TITLES[metric]) for metric in TITLES if metric in metrics]
    channels = sorted(signals - set(clouds))
    plots += [
        plot(f"/{where}", f"{where.removeprefix(SENSORS + '/')} [{CHANNELS[where.rsplit('/', 1)[1]]}]") for where in channels
    ]
    if channels:
        plots = plots[-len(channels) :] + plots[: -len(channels)]
    side = rrb.Vertical(rrb.Vertical(*plots[:2]), rrb.Tabs(text, *plots[2:]), row_shares=[3, 2])
    end = max(float(run.time[-1]) for run in stage.runs)
    panel = rrb.TimePanel(
        state="collapsed",
        timeline=SIM_TIME,
        playback_speed=min(1.0, end / WATCH) if end > 0 else 1.0,
        play_state="playing",
        loop_mode="all",
    )
    return rrb.Blueprint(
        rrb.Horizontal(rrb.Tabs(*views, active_tab=0), side, column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        panel,
        auto_views=False,
    )


def space(name: str, runs: Iterable[Run], frame: Framing, clouds: Iterable[str], fill: str) -> "rrb.Spatial3DView":
    """A view of the world with these runs, the truth and what never moves; solids are filled as told."""
    import rerun as rr
    import rerun.blueprint as rrb

    shown = [run.path for run in runs]
    contents = [f"+ /{STAGE}/**", f"+ /{WORLD}/{TRUTH}/**"]
    contents += [f"+ /{WORLD}/{path}/**" for path in shown]
    contents += [f"+ /{where}/{path}/**" for where in clouds for path in shown]
    mode: Any = rr.components.FillMode.auto(fill)
    defaults = [
        archetype.from_fields(fill_mode=mode) for archetype in (rr.Boxes3D, rr.Ellipsoids3D, rr.Capsules3D, rr.Cylinders3D)
    ]
    eye = rrb.EyeControls3D(position=frame.eye, look_target=frame.centre, eye_up=(0.0, 0.0, 1.0))
    return rrb.Spatial3DView(
        origin=f"/{WORLD}", contents=contents, name=name, defaults=defaults, eye_controls=eye, line_grid=False
    )


def plot(origin: str, name: str) -> "rrb.TimeSeriesView":
    """A plot of all curves below a path."""
    import rerun.blueprint as rrb

    return rrb.TimeSeriesView(origin=origin, name=name, plot_legend=rrb.PlotLegend(visible=True))
