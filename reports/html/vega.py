"""Vega, Vega-Lite and the embedding as one script: made once for each version, since that takes a second or two."""

import hashlib
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

from plumbline.harness.store.disk import write_atomically
from plumbline.reports.charts.figure import VEGA_LITE

_TITLE = "/* Vega, Vega-Lite, Vega-Embed and what they are made of: see vega-licences.txt beside this file */\n"


@cache
def vega_bundle() -> str:
    """The script, without imports, as it was made before on this machine where that can be read, and else made anew."""
    import platformdirs  # late: a listing needs no report

    folder = Path(platformdirs.user_cache_dir("plumbline"))
    stem = f"vega-{version('vl-convert-python')}-{VEGA_LITE}"
    with suppress(OSError, UnicodeDecodeError):
        for path in folder.glob(f"{stem}-*.js"):
            text = path.read_bytes().decode()
            if path.stem == f"{stem}-{_digest(text)}":
                return text
    text = _made()
    with suppress(OSError):  # where nothing can be kept it is made each time
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / f"{stem}-{_digest(text)}.js", text.encode())
    return text


def _made() -> str:
    import vl_convert  # late: it brings a JavaScript engine

    return _TITLE + str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;", vl_version=VEGA_LITE))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
