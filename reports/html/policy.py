"""What a page may do: nothing inline runs, nothing comes from elsewhere, and nothing can be sent.

A page that is opened from disk carries its policy itself; the server says it again in the header of every answer.

The style sheet and scripts that lie beside a page.
"""

import re
import shutil
from pathlib import Path

from plumbline.harness.store.disk import make_folder

PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'none'; font-src 'none'; base-uri 'none'; form-action 'none'"
)
SERVED = f"{PAGE}; frame-ancestors 'none'"
"""A page of the report or of the server; who may frame a page can be said in a header alone."""
VIEWER = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; "  # the viewer is WebAssembly
    "style-src 'self' 'unsafe-inline'; "  # and sets styles on its canvas
    "img-src 'self' data: blob:; worker-src 'self' blob:; "
    "connect-src 'self'; "  # recordings come from the server
    "font-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
DATA = (
    "default-src 'none'; script-src 'none'; style-src 'unsafe-inline'; img-src data:; connect-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""What is not a page: a picture, for one, may be opened by itself, and has styles of its own."""

META = f'<meta http-equiv="Content-Security-Policy" content="{PAGE}">'
_START = re.compile(r"\ufeff?(\s|<!--.*?-->)*(<!doctype[^>]*>)?\s*(<html[^>]*>)?\s*(<head[^>]*>)?", re.IGNORECASE | re.DOTALL)


def guarded(page: str) -> str:
    """The page with the policy before all else in it that could run; one that a third party wrote may not think of it."""
    start = _START.match(page)
    end = start.end() if start else 0
    return f"{page[:end]}{META}{page[end:]}"


STYLE = Path(__file__).parents[1] / "style"


def copy_style(folder: Path, *more: str) -> None:
    """Those that every page needs, and more by their names, into `folder/style`."""
    make_folder(folder / "style")
    for name in ("report.css", "frame.js", "report.js", *more):
        shutil.copyfile(STYLE / name, folder / "style" / name)
