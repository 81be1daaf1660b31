"""What became of pages and pictures: where they were written, and why some could not be made."""

from collections.abc import MutableMapping
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from markupsafe import escape

from plumbline.harness.intake.safe_text import LONGEST, one_line
from plumbline.reports.html.drawing import NotDrawn
from plumbline.reports.html.vega import vega_bundle
from plumbline.reports.words.catalogue import case_file

SCRIPT = "style/vega.js"
"""What lets somebody hover over a chart; without it its static picture stands."""
MISSING = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="640" height="60" font-family="sans-serif" font-size="13">'
    '<rect width="640" height="60" fill="#fff" stroke="#9aa3b0"/><text x="12" y="26">This chart could not be drawn:</text>'
    '<text x="12" y="46">{}</text></svg>'
)
"""In the place of a chart, with the reason."""


class NotWritten(NamedTuple):
    """What could not be made, and why, in a line."""

    kind: Literal["page", "picture", "script"]
    title: str
    reason: str

    def sentence(self) -> str:
        """All of it in a line."""
        return one_line(f"{self.kind} '{self.title}' could not be made: {self.reason}", LONGEST)


@dataclass(frozen=True, slots=True)
class WrittenReport:
    """Terms: index: its first page. failed: each page and picture that could not be made."""

    index: Path
    failed: tuple[NotWritten, ...]

    def page_of(self, case: str) -> Path:
        """The page of a case; the first one where that could not be made."""
        page = self.index.with_name(case_file(case))
        return page if page.is_file() else self.index

    def sentences(self) -> list[str]:
        """A line for each page and picture that could not be made."""
        return [each.sentence() for each in self.failed]


def picture_file(name: str, drawn: Future[str | bytes], failures: MutableMapping[str, NotWritten]) -> str | bytes | None:
    """The file of a picture, waited for; one that says why there is none, which is noted in `failures`.

    None where there is none and words stand beside it.
    """
    try:
        return drawn.result()
    except NotDrawn as error:
        failures[name] = NotWritten("picture", name, str(error))
        return MISSING.format(escape(one_line(str(error), 90))) if name.endswith(".svg") else None


def script_file(failures: MutableMapping[str, NotWritten]) -> str:
    """The script of charts; a remark in its place where it cannot be made, which is noted in `failures`."""
    try:
        return vega_bundle()
    except NotDrawn as error:
        failures[SCRIPT] = NotWritten("script", SCRIPT, str(error))
        return "/* This script could not be made: charts are the static pictures. */\n"
