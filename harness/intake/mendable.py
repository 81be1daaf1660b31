"""What all errors have in common that a person can mend: the message says what is wrong, where, and what to do."""

from typing import ClassVar, Literal

LiesIn = Literal["usage", "machine"]


class Mendable(Exception):
    """An error that is no fault of the program.

    Terms: lies_in: 'usage' where something else was to be asked or written, 'machine' where the machine or a run folder is it.
    """

    lies_in: ClassVar[LiesIn] = "usage"
