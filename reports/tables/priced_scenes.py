"""The scenes of a run in which something was clocked that has an error."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import pandas as pd

from plumbline.harness.findings.cost_point import Point
from plumbline.harness.findings.prices import priced, unit_of
from plumbline.harness.store.store import Store
from plumbline.reports.words.text import slug


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A case at one set of parameters.

    Terms:
        name: of its chart, unique in the report. unit: what costs count. points: its trials with an error and a cost;
        silent: the rows of those that lack one or both.
    """

    case: str
    where: str
    name: str
    unit: str
    points: Sequence[Point]
    silent: pd.DataFrame


@lru_cache(maxsize=1)
def scenes(store: Store) -> tuple[Scene, ...]:
    """All scenes in which something was clocked that has an error."""
    listed: list[Scene] = []
    for case, where, trials in priced(store).groups():
        points = priced(store).by_scene.get((case, where), [])
        if any(point.clocked for point in points):
            earlier = sum(scene.case == case for scene in listed)
            name = f"case-{slug(case)}-price" + (f"-{earlier}" if earlier else "")
            silent = trials[~trials["trial"].isin([point.trial for point in points])]
            listed.append(Scene(case, where, name, unit_of(trials), points, silent))
    return tuple(listed)
