"""What became of pages and pictures: where they were written, and why some could not be made.

Vega, Vega-Lite and the embedding as one script: made once for each version, since that takes a second or two.
"""

from collections.abc import MutableMapping
from concurrent.futures import Future
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Literal, NamedTuple

from markupsafe import escape

from plumbline.harness.intake.safe_text import LONGEST, one_line
from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.reports.charts.figure import VEGA_LITE
from plumbline.reports.html.drawing import Drawing, NotDrawn
from plumbline.reports.page import Picture
from plumbline.reports.words.catalogue import case_file

_TITLE = "/* Vega, Vega-Lite, Vega-Embed and what they are made of: see vega-licences.txt beside this file */\n"


@cache
def vega_bundle() -> str:
    """The script, without imports, as it was made before on this machine where that can be read, and else made anew.

    Raises: NotDrawn.
    """
    file = cache_folder("vega") / f"vega-{version('vl-convert-python')}-{VEGA_LITE}.js"
    script = read_kept(file)
    if script is None:
        script = _made().encode()
        keep(file, script)
    return script.decode()


@dataclass(frozen=True, slots=True)
class _Bundle(Picture):
    """Made as pictures are drawn: in a process of its own."""

    def kept(self, _report: Path) -> str:
        import vl_convert  # late: it brings a JavaScript engine

        return str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;", vl_version=VEGA_LITE))


def _made() -> str:
    with Drawing(Path()) as beside:
        return _TITLE + str(beside.ask(_Bundle()).result())


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
