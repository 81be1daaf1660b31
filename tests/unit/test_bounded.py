"""A program that is run is bounded in time and in what it writes; a call into code of strangers answers, or says why not."""

import os
import sys
import time
from pathlib import Path

import psutil
import pytest

from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.bounded import bounded


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


def test_what_a_program_says_and_how_it_ended_are_told() -> None:
    ended = bounded(python("import sys; print('out'); print('first\\nlast', file=sys.stderr); sys.exit(7)"), 20.0)
    assert (ended.code, ended.out, ended.how, ended.last_words) == (7, b"out\n", "ended with exit code 7", "last")
    killed = bounded(python("import os; os.kill(os.getpid(), 11)"), 20.0)
    assert (killed.code, killed.how) == (-11, "was killed by SIGSEGV")


def test_a_program_that_does_nothing_is_ended_and_so_is_what_it_started(tmp_path: Path) -> None:
    """Its child is in a session of its own, and has its streams."""
    said = tmp_path / "pid"
    code = f"""
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], start_new_session=True)
open({str(said)!r}, "w").write(str(child.pid))
time.sleep(600)
"""
    ended = bounded(python(code), 1.0)
    assert (ended.code, ended.how) == (None, "did not end within 1 s")
    pid = int(said.read_text())
    assert not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE


def test_a_child_that_keeps_the_streams_keeps_nobody_waiting() -> None:
    """It outlives its parent by ten minutes unless it is ended, and reading to the end of a pipe would wait for it."""
    code = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)']); print('done')"
    begun = time.monotonic()
    assert bounded(python(code), 60.0).out == b"done\n"
    assert time.monotonic() - begun < 300


def test_an_answer_is_read_whatever_is_printed_and_a_flood_is_cut() -> None:
    code = "import sys; print('x' * 5_000_000); open(sys.argv[1], 'w').write('answer')"
    ended = bounded(python(code), 20.0, answers=True)
    assert (ended.answer, len(ended.out)) == (b"answer", 2**20)


def test_a_program_that_is_not_there_is_an_error_of_the_system(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        bounded([str(tmp_path / "nothing")], 1.0)


def doubled(number: int) -> int:
    return 2 * number


def ends(code: int) -> None:
    os._exit(code)


def raises() -> None:
    raise LookupError("nothing there")


def hangs() -> None:
    time.sleep(600)


def gives(thing: object) -> object:
    return thing


def test_a_call_apart_gives_what_it_gives_here() -> None:
    assert apart(int, 20.0, doubled, 21) == 42


@pytest.mark.parametrize(
    ("function", "arguments", "reason"),
    [
        (ends, (0,), "ended with exit code 0 and no answer"),
        (ends, (3,), "ended with exit code 3 and no answer"),
        (raises, (), "LookupError: nothing there"),
        (gives, ("two",), "its answer is none: .*valid integer"),
        (gives, (None,), "its answer is none"),
        (gives, ({"a": 1},), "its answer is none"),
    ],
)
def test_a_call_without_an_answer_says_why(function: object, arguments: tuple[object, ...], reason: str) -> None:
    with pytest.raises(NoAnswer, match=f"^{reason}"):
        apart(int, 20.0, function, *arguments)  # type: ignore[arg-type]


def test_a_call_that_hangs_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plumbline.harness.intake.apart.START", 1.5)
    with pytest.raises(NoAnswer, match=r"did not end within 2 s and no answer"):
        apart(int, 0.5, hangs)
