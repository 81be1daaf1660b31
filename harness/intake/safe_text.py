"""Text of engines and files as what it is, text: it acts on no terminal, in no spreadsheet and in no reader of Markdown."""

import re
import unicodedata
from numbers import Number
from reprlib import Repr
from typing import Any

LONGEST = 2000
"""Characters of one string that people are shown; a vendor's error text may be a megabyte, its beginning says what is wrong."""

LONGEST_TEXT = 8000
"""Characters of a text of several lines."""

_HIDDEN = frozenset(("Cc", "Cf", "Cs", "Zl", "Zp"))
_SHORT = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}
_NUMBER = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")
_FORMULA = "=+@-\uff1d\uff0b\uff20\uff0d"
"""What begins a formula; the wide forms do in spreadsheets of East Asia."""
_NEXT_CELL = re.compile(f"(; *)([{re.escape(_FORMULA)}])")
"""Where a spreadsheet that splits at semicolons, as it does in much of Europe, would begin a cell with a formula."""
_MARKS = re.compile(r"[\\`*\[\]|~]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])")


def _spelled(character: str) -> str:
    code = ord(character)
    return _SHORT.get(character) or (f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}")


def _is_hidden(character: str) -> bool:
    """Is it a control, a format mark (reversals of direction among them), half a character, or none at all?"""
    return unicodedata.category(character) in _HIDDEN or ord(character) & 0xFFFE == 0xFFFE


def visible(text: str, keep: str = "\n\t") -> str:
    """The text with control and direction-changing characters spelled out, but for those to keep.

    A right-to-left override would reorder what stands around it, an escape sequence would act in a terminal it is pasted to.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep or not _is_hidden(c) else _spelled(c) for c in text)


def readable(text: str, most: int = LONGEST_TEXT) -> str:
    """The text with its lines, without hidden characters, cut to `most` characters."""
    clean = visible(text[: most + 1])
    return clean if len(clean) <= most else f"{clean[: most - 3]}..."


def quoted(value: object, most: int = 120) -> str:
    """A value as it would stand in a file, on one line, cut to `most` characters."""
    if value is None or isinstance(value, bool):
        return {True: "true", False: "false", None: "nothing"}[value]
    if type(value) is str and value.isprintable() and len(plain := repr(value)) <= most:
        return plain
    short = Repr()
    short.maxstring = short.maxother = short.maxlong = most
    try:
        return readable(short.repr(value), most)
    except ValueError:  # an integer with more digits than Python writes out
        return "a whole number too long to write out"


def one_line(text: str, most: int | None = None) -> str:
    """The text on one line without hidden characters; what is longer than `most` characters is cut, and says so."""
    tail = "" if most is None or len(text) <= most else f" … ({len(text) - most} characters more)"
    return visible(re.sub(r"\r\n|[\n\t\r]", " ", text[:most])) + tail


def csv_cell(value: Any) -> Any:
    """A cell on one line that no spreadsheet takes for a formula; numbers, and texts that are numbers, stay as they are.

    Source:
        OWASP, 'CSV injection': cells that start with = + - @, tab, carriage return or line feed are evaluated.
    """
    if value is None or isinstance(value, (float, int, Number)):  # the first two are told at once, and are nearly all
        return value
    text = str(value)
    shown = visible(text, keep="")
    if _NUMBER.fullmatch(shown):
        return shown
    guarded = text[:1] in _SHORT or text.lstrip()[:1] in tuple(_FORMULA)
    return ("'" if guarded else "") + _NEXT_CELL.sub(r"\1'\2", shown)


def markdown_cell(value: object) -> str:
    """A cell of a table in Markdown: on one line, and nothing in it is markup, a link, a picture or a cell's end."""
    text = _MARKS.sub(r"\\\g<0>", one_line(str(value), LONGEST))
    return text.replace("&", "&amp;").replace("<", "&lt;")


_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def latex_cell(value: object) -> str:
    """A cell of a table in LaTeX: on one line, and nothing in it is a command."""
    return "".join(_LATEX.get(character, character) for character in one_line(str(value), LONGEST))
