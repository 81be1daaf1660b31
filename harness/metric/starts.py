"""The other starts of a case that is judged from several, which differ by less than anybody can build."""

import re

from plumbline.harness.metric import Run
from plumbline.harness.trajectory import Floats

START = "start_"
"""The streams of another start are named so, with its number: 'start_3/v_WB'."""


def other_starts(run: Run, of: str) -> list[Floats]:
    """A stream of each other start, 'p_WB' (k, n, 3) m say."""
    return [stream for name, stream in run.actual.streams.items() if re.fullmatch(rf"{START}\d+/{of}", name)]
