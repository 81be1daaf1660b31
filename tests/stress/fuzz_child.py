"""A process that has many mutants of one file read by the command line, up to the first trial, and prints what became of them.

Arguments: the sound file, the first seed, how many, seconds of processor time in all. Prints one JSON object.
"""

import contextlib
import io
import json
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NoReturn

import harness.campaign
from harness.catalogue import describe_case
from harness.cli import main
from harness.discover import SCENE_PREFIX
from harness.study import Study
from tests.stress.mutator import mutant

LONGEST = 2.0
"""Seconds of processor time that one file may cost."""
MOST_SAID = 10_000
"""Characters that may be said of one file."""


class Hang(BaseException):
    """The file took longer."""


class Accepted(BaseException):
    """The file is sound: what comes next would be the first trial."""


def _stop(*_: Any) -> NoReturn:
    raise Hang


def _up_to_here(study: Study, _folder: Path, cases: Any, adapters: Any, **_more: Any) -> NoReturn:
    """In the place of `carry_out`: unfold all trials, describe the file's own case, run none."""
    trials = list(study.trials(cases, adapters, dict.fromkeys(adapters, "1")))
    for name in dict.fromkeys(trial.case for trial in trials if trial.case.startswith(SCENE_PREFIX)):
        describe_case(cases[name])
    raise Accepted


def _trouble(path: Path) -> tuple[str, str]:
    """What became of a file, and what was said: 'refused', 'accepted', or a trouble in words."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            main(["run", str(path), "--out", str(path.parent / "out")])
        ended = "ended without a word"
    except SystemExit as error:
        ended = "refused" if error.code == 2 else f"exit code {error.code}"
    except Accepted:
        ended = "accepted"
    except Hang:
        ended = f"more than {LONGEST} s"
    except BaseException as error:
        ended = f"traceback: {type(error).__name__}: {error}"
    text = said.getvalue()
    if any(not sign.isprintable() and sign not in "\n\t" for sign in text):
        ended = "control characters are printed"
    if len(text) > MOST_SAID:
        ended = f"{len(text)} characters are printed"
    if ended == "refused" and path.name not in text:
        ended = "the file is not named"
    return ended, text


def _all(sound: Path, first: int, count: int, budget: float) -> dict[str, Any]:
    harness.campaign.carry_out = _up_to_here  # type: ignore[assignment]
    signal.signal(signal.SIGPROF, _stop)
    found: dict[str, Any] = {"refused": 0, "accepted": 0, "slowest": 0.0, "troubles": [], "tried": 0}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / sound.name
        content = sound.read_bytes()
        path.write_bytes(content)
        ended, text = _trouble(path)  # the first one imports everything
        if ended != "accepted":
            raise AssertionError(f"{sound}: {ended}: {text}")
        start = time.process_time()
        for seed in range(first, first + count):
            path.write_bytes(mutant(content, seed))
            before = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
            try:
                ended, text = _trouble(path)
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
            found["slowest"] = max(found["slowest"], time.process_time() - before)
            found["tried"] += 1
            if ended in ("refused", "accepted"):
                found[ended] += 1
            else:
                found["troubles"].append(f"seed {seed}: {ended}")
            if time.process_time() - start > budget:
                break
    found["peak"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return found


if __name__ == "__main__":
    name, first, count, budget = sys.argv[1:]
    print(json.dumps(_all(Path(name), int(first), int(count), float(budget))))
