"""The page on sensors: ideal signals against the truth, noise against its law, what cameras saw, and what rays cost."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.sensor_readings.findings import concerned, findings
from plumbline.harness.findings.tables import sensors as sensors_table
from plumbline.harness.store.store import Store
from plumbline.reports.charts.ideal_signals import error_charts, named, noise_charts, rays_chart
from plumbline.reports.html.template import filled_page
from plumbline.reports.pictures.camera_pictures import shots
from plumbline.reports.tables.trial_results import rows_shown
from plumbline.reports.words.catalogue import TRACK_ORDER, titled, titles


def concerns(store: Store) -> bool:
    """Only where a scene had sensors."""
    return len(concerned(store)) > 0


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    measured = findings(store)
    errors, noises, rays = error_charts(store, measured), noise_charts(store, measured), rays_chart(store, measured)
    listed = [measured[index] for index in rows_shown([finding.track not in TRACK_ORDER for finding in measured])]
    return {
        "said": sensors_table.sentences(measured, titles(store)),
        "errors": errors,
        "noises": noises,
        "rays": rays,
        "shots": shots(store, measured),
        "found": listed,
        "found_in_all": len(measured),
        "names": [
            named(store, finding) if finding.channel else titled(store, finding.case, finding.where) for finding in listed
        ],
    }


PAGE = filled_page("sensors", "Sensors", 18, told, tables=("sensors",), concerns=concerns)
