"""The charts of a case for a paper: the same as on its page."""

from dataclasses import dataclass
from pathlib import Path

from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import error_by_step
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.work_precision import work_precision
from plumbline.reports.tables.price_list import scenes
from plumbline.reports.tables.trial_results import answers, in_order
from plumbline.reports.words.catalogue import cases, engines, tracks
from plumbline.reports.words.text import slug


@dataclass(frozen=True, slots=True)
class Printed:
    """A chart as a file of its own. Terms: form: svg, pdf or png. width: of the frame [px, or pt in a PDF]."""

    figure: Figure
    form: str
    width: int

    def kept(self, _report: Path) -> bytes:
        """Drawn each time."""
        return self.figure.drawn(self.form, self.width)


def figures_of(store: Store, case: str) -> list[tuple[str, Figure]]:
    """Each with its kind: 'step', error against time step; 'price', cost against error, one a scene."""
    rows = answers(store, store.trials)
    sides = [(engine, track) for engine in engines(store) for track in tracks(store)]
    mine = in_order(rows[rows["case"] == case], sides)
    unit = next((str(unit) for unit in mine["unit"].dropna()), "1")
    asked = mine[mine["trial"].isin(set(store.asked["trial"]))]
    by_step = error_by_step(store, asked, f"case-{slug(case)}", cases(store)[case]["headline"], unit)
    figures = [("step", by_step)] if by_step is not None else []
    return figures + [("price", work_precision(store, scene)) for scene in scenes(store) if scene.case == case]
