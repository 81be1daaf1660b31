"""Which part of its motion a scene was clocked over: prices of different parts are prices of different things."""

from collections.abc import Mapping
from typing import Any

__all__ = ["clocked_part"]


def clocked_part(row: Any, steps: int, case: Mapping[str, Any]) -> int:
    """The steps of the first half, quarter, eighth, ... that a sample ran over; 0 for whole runs and for what is steady.

    Args: row: of the table `trials`. steps: of a sample. case: as the catalogue has it.
    """
    duration = case.get("duration")
    if duration is None or row.unit != "step":
        return 0
    whole = max(1, round(float(duration) / float(row.dt)))
    return steps if steps in {whole >> k for k in range(1, whole.bit_length())} else 0
