"""The page on sensors: ideal signals against the truth, noise against its law, what cameras saw, and what rays cost."""

from collections.abc import Mapping

from plumbline.harness.findings.sensor_readings.findings import concerned, findings
from plumbline.harness.findings.tables import sensors as sensors_table
from plumbline.harness.store.store import Store
from plumbline.reports.charts.ideal_signals import error_charts, named, noise_charts, rays_chart
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.pictures.camera_pictures import shots
from plumbline.reports.tables.csv import sheet
from plumbline.reports.tables.trial_results import rows_shown
from plumbline.reports.words.catalogue import TRACK_ORDER, titled, titles


def concerns(store: Store) -> bool:
    """Only where a scene had sensors."""
    return len(concerned(store)) > 0


def render(store: Store) -> Mapping[str, Rendered]:
    """The page, its charts and its table as CSV."""
    measured = findings(store)
    errors, noises, rays = error_charts(store, measured), noise_charts(store, measured), rays_chart(store, measured)
    listed = [measured[index] for index in rows_shown([finding.track not in TRACK_ORDER for finding in measured])]
    page = fill(
        "sensors.html",
        store,
        title="Sensors",
        said=sensors_table.sentences(measured, titles(store)),
        errors=errors,
        noises=noises,
        rays=rays,
        shots=shots(store, measured),
        found=listed,
        found_in_all=len(measured),
        names=[named(store, finding) if finding.channel else titled(store, finding.case, finding.where) for finding in listed],
    )
    figures = [*errors, *noises, *([rays] if rays is not None else [])]
    sheets = {"sensors.csv": sheet(sensors_table.TABLE.columns, map(sensors_table.TABLE.flat, measured))}
    return {"sensors.html": page} | sheets | {figure.path: figure for figure in figures}


PAGE = Page(name="sensors", title="Sensors", order=18, render=render, concerns=concerns)
