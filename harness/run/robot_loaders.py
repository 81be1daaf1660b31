"""Engines' own loaders on a robot file, each in a process of its own with a deadline: vendors' parsers crash and hang."""

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.harness.adapter import Unsupported
from plumbline.harness.intake.safe_text import one_line
from plumbline.harness.scene.parity.loaded import Loaded, Request, restored

DEADLINE = 120.0
"""Seconds that a loader may take, its engine's import included."""


def loaded_apart(name: str, request: Request, path: Path) -> Loaded:
    """What an engine's loader makes of a file. Raises: Unsupported, with why it does not."""
    with TemporaryDirectory(prefix="plumbline-loader-") as scratch:
        out = Path(scratch) / "loaded.json"
        packages = [f"{package}={folder.resolve()}" for package, folder in request.packages.items()]
        asked = [name, str(path.resolve()), str(out), request.way, request.root, *packages]
        command = [sys.executable, "-m", "plumbline.harness.run.loader_child", *asked]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=DEADLINE, check=False)
        except subprocess.TimeoutExpired:
            raise Unsupported("the file", f"the loader did not end within {DEADLINE:g} s") from None
        if done.returncode != 0 or not out.is_file():
            message = one_line(done.stderr.decode("utf-8", "replace").strip()[-300:], 300)
            raise Unsupported("the file", f"the loader died with code {done.returncode}: {message}")
        answer = json.loads(out.read_text(encoding="utf-8"))
    if "why" in answer:
        raise Unsupported(answer["what"], one_line(answer["why"], 400))
    return restored(answer)
