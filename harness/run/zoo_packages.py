"""The packages of a zoo, in a folder beside the environments of engines: their files alone, without what their code needs.

Some would bring a whole training stack along for the sake of a few robot files. What `pip install 'plumbline[zoo]'` has put
beside plumbline is found first.
"""

import hashlib
import shutil
import sys
from pathlib import Path

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.user_cache import is_ours, make_ours
from plumbline.harness.run.make_environment import NotMade, last_error
from plumbline.harness.store import disk
from plumbline.harness.study import zoo
from plumbline.harness.study.environments import root

LOCK = Path(zoo.__file__).with_name("requirements.lock")
PRICE = "340 MB, a minute"
_WHOLE = "installed.lock"
"""What stands in the folder once all of them are there."""
_INSTALLS = 900.0
"""Seconds that installing may take."""


def folder() -> Path:
    """Where they lie, whether they are there or not."""
    return root() / f"zoo-{hashlib.sha256(LOCK.read_bytes()).hexdigest()[:16]}"


def look() -> None:
    """Have this process, and those that it starts, find what was installed there; a folder of somebody else's is left alone."""
    if is_ours(folder() / _WHOLE) and str(folder()) not in sys.path:
        sys.path.append(str(folder()))


def install() -> None:
    """Install them there by their hashes, unless they are there. Raises: NotMade, OSError."""
    if not is_ours(folder() / _WHOLE):
        shutil.rmtree(folder(), ignore_errors=True)
        folder().parent.mkdir(parents=True, exist_ok=True)
        uv = shutil.which("uv")
        pip = [uv, "pip", "install", "--quiet"] if uv else [sys.executable, "-m", "pip", "install", "--quiet", "--no-input"]
        ended = bounded([*pip, "--no-deps", "--require-hashes", "--target", str(folder()), "-r", str(LOCK)], _INSTALLS)
        if ended.code != 0:
            raise NotMade(last_error(ended.err.decode("utf-8", "replace")) or f"pip {ended.how}")
        disk.write_atomically(folder() / _WHOLE, LOCK.read_bytes())
        for path in (folder(), folder() / _WHOLE):
            make_ours(path)
    look()
