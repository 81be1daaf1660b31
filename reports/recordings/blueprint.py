"""The layout that a recording opens with: engines overlaid, each by itself, plots and text."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from plumbline.reports.recordings.camera import Framing
from plumbline.reports.recordings.layout import BACKGROUND, FLOOR, LOG, METRICS, SENSORS, SIM_TIME, STAGE, TRUTH, WORLD
from plumbline.reports.recordings.metrics import TITLES
from plumbline.reports.recordings.runs import RecordedRun, Stage, playing_time, touching
from plumbline.reports.recordings.sensors import CHANNELS, CameraView, Sensed
from plumbline.reports.recordings.shapes import OVERLAID, placed_shapes

if TYPE_CHECKING:
    import rerun.blueprint as rrb

NO_SENSORS = Sensed()

ALONE = "Solid"
"""How shapes are filled where one engine has a place to itself; where several share one, as `OVERLAID` says."""


def layout(stage: Stage, frame: Framing, metrics: Sequence[str], sensors: Sensed = NO_SENSORS) -> "rrb.Blueprint":
    """The blueprint of a case.

    Args: metrics: those that have a curve, the more telling first.
    """
    import rerun.blueprint as rrb

    text = rrb.TextDocumentView(origin=f"/{LOG}", name="Outcomes")
    if not stage.runs:
        return rrb.Blueprint(text, collapse_panels=True)
    end = max(float(run.time[-1]) for run in stage.runs)
    titles = {f"{METRICS}/{metric}": TITLES[metric] for metric in metrics}
    signals = {
        where: f"{where.removeprefix(SENSORS + '/')} [{CHANNELS[where.rsplit('/', 1)[1]]}]" for where in sensors.channels
    }
    plots = [plot(f"/{where}", name, False, end) for where, name in signals.items()]
    plots += [plot(f"/{where}", name, k == 0, end) for k, (where, name) in enumerate(titles.items())]
    side = rrb.Vertical(*plots[:2], rrb.Tabs(text, *plots[2:], active_tab=0), row_shares=[5, 4, 6][-1 - len(plots[:2]) :])
    spaces = rrb.Tabs(*worlds(stage, frame, sensors), *map(pictures, sensors.views), active_tab=0)
    return rrb.Blueprint(
        rrb.Horizontal(spaces, side, column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        time_panel(stage),
        auto_views=False,
    )


def time_panel(stage: Stage) -> "rrb.TimePanel":
    """Plays in a loop, in real time where that can be watched."""
    import rerun.blueprint as rrb

    length = stage.length
    speed = length / playing_time(length) if length > 0 else 1.0
    return rrb.TimePanel(state="collapsed", timeline=SIM_TIME, playback_speed=speed, play_state="playing", loop_mode="all")


def pictures(view: CameraView) -> "rrb.Grid":
    """What a camera saw, engine beside engine and the truth among them."""
    import rerun.blueprint as rrb

    across = 2 if len(view.paths) <= 4 else 3
    shown = [rrb.Spatial2DView(origin=f"/{path}", name=name) for name, path in view.paths.items()]
    return rrb.Grid(*shown, grid_columns=across, name=view.title)


def worlds(stage: Stage, frame: Framing, sensors: Sensed) -> "list[rrb.View | rrb.Container]":
    """Each track with all its engines in one space, and every engine and track in a space of its own."""
    import rerun.blueprint as rrb

    tracks = list(dict.fromkeys(run.track for run in stage.runs))
    look = furnishing(stage, frame)
    # A filling that all views share is logged with the shapes: a view that need not say it is a row less.
    overlaid, by_itself = (look, look) if touching(stage) else (look | fills(stage, OVERLAID), look | fills(stage, ALONE))
    together: list[Any] = [
        space(f"All engines, {track}", [run for run in stage.runs if run.track == track], sensors, overlaid) for track in tracks
    ]
    alone = [space(f"{run.engine} {run.track}", [run], sensors, by_itself) for run in stage.runs]
    across = 2 if len(alone) <= 4 else 3 if len(alone) <= 6 else 4
    return [*together, rrb.Grid(*alone, grid_columns=across, name="Side by side")]


def space(name: str, runs: Sequence[RecordedRun], sensors: Sensed, look: Mapping[str, Any]) -> "rrb.Spatial3DView":
    """A view of the world with these runs, the truth and what never moves."""
    import rerun.blueprint as rrb

    paths = [run.path for run in runs]
    contents = [f"+ /{STAGE}/**", f"+ /{WORLD}/{TRUTH}/**", *(f"+ /{WORLD}/{path}/**" for path in paths)]
    contents += [f"+ /{where}/{path}/**" for where in sensors.clouds for path in paths]
    # Together, engines show their frusta alone: pictures and depth would cover each other.
    below = "/**" if len(runs) == 1 else ""
    contents += [f"+ /{where}/{path}{below}" for where in sensors.cameras for path in paths]
    return rrb.Spatial3DView(origin=f"/{WORLD}", contents=contents, name=name, **look)


def furnishing(stage: Stage, frame: Framing) -> dict[str, Any]:
    """What all views of a stage have alike, made once: an eye, a background and a floor."""
    import rerun.blueprint as rrb

    floor = any(p["shape"]["type"] == "plane" for body in stage.bodies for p in body["collision"])
    return {
        "eye_controls": rrb.EyeControls3D(position=frame.eye, look_target=frame.target, eye_up=(0.0, 0.0, 1.0)),
        "background": rrb.Background(color=BACKGROUND),
        # Where a scene has no ground, a faint grid below the motion tells up from down and far from near.
        "line_grid": rrb.LineGrid3D(visible=False) if floor else floor_grid(frame),
    }


def fills(stage: Stage, fill: str) -> dict[str, Any]:
    """How a view fills the solids of a stage, for each kind that moves in it."""
    import rerun as rr

    mode: Any = rr.components.FillMode.auto(fill)
    moving = {shape["shape"]["type"] for k in stage.moving for shape in placed_shapes(stage.bodies[k])}
    kinds: dict[str, Any] = {
        "box": rr.Boxes3D,
        "sphere": rr.Ellipsoids3D,
        "ellipsoid": rr.Ellipsoids3D,
        "capsule": rr.Capsules3D,
        "cylinder": rr.Cylinders3D,
    }
    drawn = dict.fromkeys(archetype for kind, archetype in kinds.items() if kind in moving)
    # Its one component, made once: of an archetype every view would go through all fields again.
    made = [archetype.from_fields(fill_mode=mode).as_component_batches() for archetype in drawn]
    return {"defaults": [component for components in made for component in components]}


def floor_grid(frame: Framing) -> Any:
    """Lines in a level plane a little below the motion."""
    import rerun as rr
    import rerun.blueprint as rrb

    below = rr.components.Plane3D.XY.with_distance(frame.low - 0.1 * frame.size)
    return rrb.LineGrid3D(visible=True, spacing=frame.size / 4, plane=below, color=FLOOR, stroke_width=0.7)


def plot(origin: str, name: str, legend: bool, end: float) -> "rrb.TimeSeriesView":
    """A plot of all curves below a path, from 0 to `end` [s]; colours mean the same in all, so one legend will do."""
    import rerun.blueprint as rrb

    # Errors grow: a legend at the left hides the least.
    look = rrb.PlotLegend(corner="LeftTop", visible=legend)
    first, last = (rrb.TimeRangeBoundary.absolute(seconds=seconds) for seconds in (0.0, end if end > 0 else 1.0))
    axis = rrb.TimeAxis(view_range=rrb.TimeRange(start=first, end=last))
    return rrb.TimeSeriesView(origin=origin, name=name, plot_legend=look, axis_x=axis)
