"""What all errors have in common that a person can mend: the message says what is wrong, where, and what to do."""

from typing import ClassVar, Literal

from plumbline.harness.intake.safe_text import quoted

LiesIn = Literal["usage", "machine"]


class PlumblineError(Exception):
    """Wrong input, or a machine or run folder that does not let us: no fault of the program.

    The message names file, element, value and what was expected.

    Terms: lies_in: 'usage' where something else was to be asked or written, 'machine' where the machine or a run folder is it.
    """

    lies_in: ClassVar[LiesIn] = "usage"


class RobotError(PlumblineError, ValueError):
    """A robot file that is refused; the message names file, line, element, attribute, value and what mends it."""


def listed(names: "tuple[str, ...] | list[str]", most: int = 3) -> str:
    """Some names of many in words: 'a', 'b', 'c' and 14 more."""
    shown = ", ".join(quoted(name, 80) for name in names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown
