"""Text of strangers made harmless: no control character, no reversal of direction, no half of a character, no megabytes."""

import re
from reprlib import Repr

__all__ = ["LONGEST_TEXT", "quoted", "readable"]

LONGEST_TEXT = 8000
"""Characters of a text; what is longer is cut."""
_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


def readable(text: str, most: int = LONGEST_TEXT) -> str:
    """The text with escapes in place of control characters, reversals of direction and halves of characters, cut to `most`."""
    clean = _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text[: most + 1])
    return clean if len(clean) <= most else f"{clean[: most - 3]}..."


def quoted(value: object, most: int = 120) -> str:
    """A value as it would stand in a file, on one line, cut to `most` characters."""
    if value is None or isinstance(value, bool):
        return {True: "true", False: "false", None: "nothing"}[value]
    short = Repr()
    short.maxstring = short.maxother = short.maxlong = most
    try:
        return readable(short.repr(value), most)
    except ValueError:  # an integer with more digits than Python writes out
        return "a whole number too long to write out"
