"""A process that reads many mutants of one robot file, and prints what became of them.

MJCF is compiled here, in this process, so that a crash of the compiler is seen as one: whoever started this process notes the
seed and goes on behind it. `plumbline` itself compiles each file in a process of its own.

Arguments: the sound file, the first seed, how many, a file that is told the seed before each mutant. Prints one JSON object.
"""

import json
import os
import re
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.import_wishes import DROPPABLE, Wishes
from plumbline.harness.scene.importers.companion import Companion, Massless
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.mjcf_text import Prepared
from plumbline.harness.scene.importers.reading import read
from tests.mjcf_here import compiled_here
from tests.stress.mutator import mutant
from tests.stress.reading import peak

DEADLINE = 20
"""Seconds of processor time after which a mutant counts as a hang."""
OUTSIDE = ("/etc", "/root", "/home", "/usr/share", "/var")
OURS = re.compile(r"asset\d+\.[a-z]+")


class Hang(BaseException):
    """The deadline of one mutant."""


def _stop(_number: int, _frame: object) -> None:
    raise Hang


class _Opened:
    """Which files Python opened, while a mutant is read, that lie in none of the folders that it may read."""

    def __init__(self) -> None:
        self.on, self.seen = False, list[str]()

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.on and event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
            path = os.fsdecode(arguments[0])
            if path.startswith(OUTSIDE) and not path.startswith(sys.prefix):
                self.seen.append(path)


def compile_watched(text: Prepared, file: str) -> Model:
    """As `compile_apart`, in this process. Raises: RobotError."""
    for asset in re.findall(r'file="([^"]*)"', text.text):
        assert OURS.fullmatch(asset), f"the compiler was shown the file {asset}"
    return compiled_here(text, file)


def _one(path: Path) -> str:
    """What became of a file: 'read', 'refused', or what is wrong with how it ended."""
    wishes = Wishes(root="floating" if path.suffix == ".urdf" else None, drop=frozenset(DROPPABLE), looks=True)
    signal.setitimer(signal.ITIMER_PROF, DEADLINE)
    try:
        read(path, wishes, Companion(massless=Massless(mass=1e-3)))
    except PlumblineError as error:
        return (
            "refused" if path.name in str(error) or "joints >" in str(error) else f"the file is not named: {str(error)[:200]}"
        )
    except Hang:
        return f"no end within {DEADLINE} s"
    except BaseException as error:
        return f"{type(error).__name__}: {error} ({traceback.extract_tb(error.__traceback__)[-1].filename})"[:500]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return "read"


def _all(sound: Path, first: int, count: int, note: Path) -> dict[str, Any]:
    opened = _Opened()
    sys.addaudithook(opened)
    signal.signal(signal.SIGPROF, _stop)
    from plumbline.harness.scene.importers import mjcf

    mjcf.compile_apart = compile_watched
    totals: dict[str, Any] = {"refused": 0, "read": 0, "slowest": 0.0, "troubles": [], "tried": 0, "outside": []}
    content = sound.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / sound.name
        path.write_bytes(content)
        assert _one(path) == "read", _one(path)
        for seed in range(first, first + count):
            note.write_text(str(seed))
            path.write_bytes(mutant(content, seed))
            start = time.process_time()
            opened.on = True
            ended = _one(path)
            opened.on = False
            totals["slowest"] = max(totals["slowest"], time.process_time() - start)
            totals["tried"] += 1
            if ended in ("read", "refused"):
                totals[ended] += 1
            else:
                totals["troubles"].append(f"seed {seed}: {ended}")
    totals["outside"] = sorted(set(opened.seen))
    totals["peak"] = peak()
    return totals


if __name__ == "__main__":
    name, first, count, note = sys.argv[1:]
    print(json.dumps(_all(Path(name), int(first), int(count), Path(note))))
