"""What all errors have in common that a person can mend: the message says what is wrong, where, and what to do."""

from typing import ClassVar, Literal

LiesIn = Literal["usage", "machine"]


class PlumblineError(Exception):
    """Wrong input, or a machine or run folder that does not let us: no fault of the program.

    The message names file, element, value and what was expected.

    Terms: lies_in: 'usage' where something else was to be asked or written, 'machine' where the machine or a run folder is it.
    """

    lies_in: ClassVar[LiesIn] = "usage"
