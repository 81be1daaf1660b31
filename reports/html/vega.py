"""Vega, Vega-Lite and the embedding as one script: made once for each version, since that takes a second or two."""

from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path

from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.reports.charts.figure import VEGA_LITE
from plumbline.reports.html.drawing import Drawing

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
class _Bundle:
    """Made as pictures are drawn: in a process of its own."""

    def kept(self, _report: Path) -> str:
        import vl_convert  # late: it brings a JavaScript engine

        return str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;", vl_version=VEGA_LITE))


def _made() -> str:
    with Drawing(Path()) as beside:
        return _TITLE + str(beside.ask(_Bundle()).result())
