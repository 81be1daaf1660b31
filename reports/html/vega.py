"""Vega, Vega-Lite and the embedding as one script: made once for each version, since that takes a second or two."""

from functools import cache
from importlib.metadata import version

from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.reports.charts.figure import VEGA_LITE

_TITLE = "/* Vega, Vega-Lite, Vega-Embed and what they are made of: see vega-licences.txt beside this file */\n"


@cache
def vega_bundle() -> str:
    """The script, without imports, as it was made before on this machine where that can be read, and else made anew."""
    file = cache_folder("vega") / f"vega-{version('vl-convert-python')}-{VEGA_LITE}.js"
    script = read_kept(file)
    if script is None:
        script = _made().encode()
        keep(file, script)
    return script.decode()


def _made() -> str:
    import vl_convert  # late: it brings a JavaScript engine

    return _TITLE + str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;", vl_version=VEGA_LITE))
