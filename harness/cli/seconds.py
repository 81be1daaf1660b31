"""Times on the command line: seconds, or minutes and hours by their letter."""

import math
from typing import Any

import click

from plumbline.harness.intake.safe_text import quoted

DAY = 86400.0
"""Seconds."""

_UNITS = {"ms": 1e-3, "s": 1.0, "m": 60.0, "h": 3600.0}


class Seconds(click.ParamType[float]):
    """A finite time [s] from `low` to `high`: 0.002, 2ms, 90, 90s, 5m, 1h."""

    name = "seconds"

    def __init__(self, low: float, high: float) -> None:
        self._low, self._high = low, high

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The time [s]. Raises: click.BadParameter."""
        text = str(value).strip()
        unit = next((unit for unit in ("ms", "s", "m", "h") if text.endswith(unit)), "")
        try:
            number = float(text.removesuffix(unit)) * _UNITS[unit or "s"] if len(text) < 40 else math.nan
        except ValueError:
            number = math.nan
        if not self._low <= number <= self._high:
            self.fail(
                f"{quoted(text, 60)}, expected seconds from {self._low:g} to {self._high:g}, like 0.002, 2ms, 90s or 5m",
                param,
                ctx,
            )
        return number


class Age(Seconds):
    """Seconds, minutes, hours, or days by their letter."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The time [s]. Raises: click.BadParameter."""
        text = str(value).strip()
        days = text.removesuffix("d")
        if days != text and days.replace(".", "", 1).isdigit() and len(days) < 10:
            text = str(float(days) * DAY)
        return super().convert(text, param, ctx)
