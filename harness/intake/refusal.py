"""The error of a robot file: what stands where, and what was expected."""

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted


class RobotError(PlumblineError, ValueError):
    """A robot file that is refused; the message names file, line, element, attribute, value and what mends it."""


def listed(names: "tuple[str, ...] | list[str]", most: int = 3) -> str:
    """Some names of many in words: 'a', 'b', 'c' and 14 more."""
    shown = ", ".join(quoted(name, 80) for name in names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown
