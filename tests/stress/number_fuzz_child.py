"""A process that reads a file with one of its numbers exchanged, again and again, and has the scene built by every engine.

MJCF is compiled in this process, and engines crash where they crash: whoever started this process notes the example, and goes
on behind it. Arguments: the sound file, the first example, how many, a file that is told each before it begins, engines. Prints
one JSON object.
"""

import json
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

from plumbline.harness.adapter import SettingsError, Unavailable, Unsupported
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.import_wishes import DROPPABLE, Wishes
from plumbline.harness.scene import Scene
from plumbline.harness.scene.importers.companion import Companion, Massless, load_companion
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.study import plugins
from tests.mjcf_here import compiled_here

DEADLINE = 20
"""Seconds of processor time after which an example counts as a hang."""
NUMBER = re.compile(rb"(?<![\w.#-])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
VALUES = (
    *(
        b"1e308",
        b"-1e308",
        b"1e60",
        b"-9e59",
        b"1e61",
        b"1e300",
        b"-1e200",
        b"1e155",
        b"1e100",
        b"1e39",
        b"1e20",
        b"-1e20",
        b"1e12",
        b"1e7",
    ),
    *(b"1e-7", b"1e-12", b"1e-20", b"1e-39", b"1e-160", b"1e-308", b"5e-324", b"-5e-324", b"0", b"-0.0", b"-1", b"0.5"),
    *(b"2147483648", b"9007199254740993", b"-9223372036854775809", b"nan", b"inf"),
)
"""What is finite until it is squared, multiplied or made single, what is zero, and what no machine word holds."""


class Hang(BaseException):
    """The deadline of one example."""


def _stop(_number: int, _frame: object) -> NoReturn:
    raise Hang


def examples(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Numbers and what they are exchanged for, every number first with another value: as many as anybody asks for."""
    places = list(NUMBER.finditer(content))
    chance = random.Random(len(content))
    rounds = [random.Random(number).sample(VALUES, len(VALUES)) for number in range(len(places))]
    order = list(range(len(places)))
    while True:
        for turn in range(len(VALUES)):
            chance.shuffle(order)
            for number in order:
                start, end = places[number].span()
                yield number, content[:start] + rounds[number][turn] + content[end:]


def _scene(path: Path) -> Scene:
    if path.name.endswith(".plumb.toml"):
        robot = path.with_name(path.name.removesuffix(".plumb.toml") + ".urdf")
        return read(robot, Wishes(root="floating", drop=frozenset(DROPPABLE)), load_companion(path)).scene
    wishes = Wishes(root="floating" if path.suffix == ".urdf" else None, drop=frozenset(DROPPABLE), looks=True)
    own = path.suffix in (".toml", ".json")
    return read(path, Wishes() if own else wishes, Companion() if own else Companion(massless=Massless(mass=1e-3))).scene


def _one(path: Path, engines: list[str]) -> str:
    """What became of a file: 'built', 'refused', or what is wrong with how it ended."""
    signal.setitimer(signal.ITIMER_PROF, DEADLINE)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)  # what overflows says so
            scene = _scene(path)
        for name in engines:
            adapter = plugins.adapter(name)
            try:
                adapter.build(scene, adapter.tracks["tuned"]).close()
            except (Unsupported, Unavailable, SettingsError):
                pass
            except Hang:
                raise
            except BaseException as error:
                return f"{name}: {type(error).__name__}: {error} ({_where(error)})"[:500]
    except PlumblineError:
        return "refused"
    except Hang:
        return f"no end within {DEADLINE} s"
    except BaseException as error:
        return f"{type(error).__name__}: {error} ({_where(error)})"[:500]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return "built"


def _where(error: BaseException) -> str:
    return " < ".join(
        f"{Path(frame.filename).name}:{frame.lineno}" for frame in traceback.extract_tb(error.__traceback__)[-1:-4:-1]
    )


def _all(sound: Path, first: int, count: int, note: Path, engines: list[str]) -> dict[str, Any]:
    signal.signal(signal.SIGPROF, _stop)
    from plumbline.harness.scene.importers import mjcf

    mjcf.compile_apart = compiled_here
    totals: dict[str, Any] = {"refused": 0, "built": 0, "slowest": 0.0, "troubles": []}
    with tempfile.TemporaryDirectory() as folder:
        for beside in sound.parent.iterdir():
            (Path(folder) / beside.name).write_bytes(beside.read_bytes())
        path = Path(folder) / sound.name
        content = sound.read_bytes()
        assert _one(path, engines) == "built", _one(path, engines)
        for number, (field, text) in zip(range(first + count), examples(content), strict=False):
            if number < first:
                continue
            note.write_text(str(number))
            path.write_bytes(text)
            start = time.process_time()
            ended = _one(path, engines)
            totals["slowest"] = max(totals["slowest"], time.process_time() - start)
            if ended in ("built", "refused"):
                totals[ended] += 1
            else:
                totals["troubles"].append(f"example {number}, number {field}: {ended}")
    return totals


if __name__ == "__main__":
    name, first, count, note, *engines = sys.argv[1:]
    print(json.dumps(_all(Path(name), int(first), int(count), Path(note), engines)))
