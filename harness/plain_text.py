"""Text of strangers made harmless: no control character, no reversal of direction, no half of a character, no megabytes."""

from reprlib import Repr

__all__ = ["LONGEST_TEXT", "quoted", "readable"]

LONGEST_TEXT = 8000
"""Characters of a text; what is longer is cut."""


def readable(text: str, most: int = LONGEST_TEXT) -> str:
    """The text with escapes in place of control characters, reversals of direction, halves of characters and what nobody can
    see, cut to `most` characters; its lines stay."""
    clean = "".join(_escaped(sign) for sign in text[: most + 1])
    return clean if len(clean) <= most else f"{clean[: most - 3]}..."


def _escaped(sign: str) -> str:
    return sign if sign.isprintable() or sign in "\n\t" else f"\\u{ord(sign):04x}"


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
