"""Options and arguments that several commands take: among them times, seconds, or minutes and hours by their letter."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.intake.allowance import allowing
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

json_rows = click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
agreed = click.option("--yes", "agreed", is_flag=True, help="Install engines that are asked for and are not here.")
run_folder = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))


def _allow(context: click.Context, _parameter: click.Parameter, given: tuple[str, ...]) -> None:
    if given:
        context.with_resource(allowing(given, "--limit"))


limited = click.option(
    "--limit",
    multiple=True,
    metavar="NAME=VALUE",
    expose_value=False,
    is_eager=True,
    callback=_allow,
    help="Allow a file so much: bytes, bodies, joints, vertices, rays, steps, ...; may be repeated.",
)


def opened(folder: Path) -> "Store":
    """The store of a folder; what a reader has to know of it goes to standard error."""
    from plumbline.harness.store.store import Store

    store = Store(folder)
    for note in store.notes:
        click.echo(note, err=True)
    return store


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
