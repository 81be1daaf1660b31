"""The style sheet and scripts that lie beside a page."""

import shutil
from pathlib import Path

from plumbline.harness.store.disk import make_folder

STYLE = Path(__file__).parents[1] / "style"


def copy_style(folder: Path, *more: str) -> None:
    """Those that every page needs, and more by their names, into `folder/style`."""
    make_folder(folder / "style")
    for name in ("report.css", "frame.js", "report.js", *more):
        shutil.copyfile(STYLE / name, folder / "style" / name)
