"""Who tells a signal: an engine's run or the truth, with its colour and its name."""

from collections.abc import Mapping
from dataclasses import dataclass

from plumbline.reports.recordings.colour import GHOST, Rgba, rgba
from plumbline.reports.recordings.layout import TRUTH
from plumbline.reports.recordings.rotation import Floats
from plumbline.reports.recordings.runs import Stage


@dataclass(frozen=True, slots=True)
class Source:
    """One teller of signals.

    Terms:
        path: its part of a path. arrays: as in the store. truth: is it the truth, which tells of ideal signals only?
    """

    path: str
    name: str
    arrays: Mapping[str, Floats]
    colour: Rgba
    truth: bool = False

    def signal(self, sensor: str, channel: str) -> Floats | None:
        """What was read, by the truth what should have been; None where it was not recorded."""
        plain, ideal = f"stream:{sensor}/{channel}", f"stream:{sensor}/{channel}_ideal"
        first, other = (ideal, plain) if self.truth else (plain, ideal)
        signal = self.arrays.get(first, self.arrays.get(other))
        return signal if signal is not None and len(signal) and f"stream:{sensor}/time" in self.arrays else None

    def stamps(self, sensor: str) -> Floats:
        """The times [s] of a sensor's readings."""
        return self.arrays[f"stream:{sensor}/time"]


def sources(stage: Stage) -> list[Source]:
    """All runs of a stage, then its truth."""
    runs = [Source(run.path, f"{run.engine} {run.track}", run.arrays, rgba(run.colour)) for run in stage.runs]
    return [*runs, Source(TRUTH, "truth", stage.truth, (*GHOST[:3], 255), truth=True)]
