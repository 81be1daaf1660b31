"""Fork servers: what is loaded in which, where things lie in memory, and what happens where loading kills one."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from plumbline.harness.run.fork_servers import WORTH_A_SERVER, Origin, loaded, start
from tests.light_servers import light_servers
from tests.told_by_processes import show_flags, show_place, show_threads, tell

SELDOM = ("xml.dom.pulldom",)
"""What nobody else here loads."""
WAIT = 60.0


@pytest.fixture(scope="module", autouse=True)
def _servers_of_these_tests() -> Iterator[None]:
    with light_servers():
        yield


def is_loaded(name: str, modules: tuple[str, ...], foreseen: int = WORTH_A_SERVER) -> bool:
    """Is a module there from the first moment of a process that starts with these?"""
    process = start(loaded(modules, foreseen), tell, name)
    assert process.pipe.poll(WAIT)
    found: bool = process.pipe.recv()
    process.join(WAIT)
    assert process.code == 0
    return found


def test_a_few_processes_get_no_server_of_their_own_but_use_one_that_is_there() -> None:
    assert not is_loaded("xml.sax.saxutils", ("xml.sax.saxutils",), WORTH_A_SERVER - 1)
    assert is_loaded("xml.sax.saxutils", ("xml.sax.saxutils",))
    assert is_loaded("xml.sax.saxutils", ("xml.sax.saxutils",), 1)


def test_each_server_has_its_own_modules_and_the_plain_one_none_of_them() -> None:
    assert is_loaded(SELDOM[0], SELDOM)
    assert not is_loaded(SELDOM[0], ())
    assert not is_loaded(SELDOM[0], ("xml.sax.saxutils",))
    assert is_loaded("numpy", SELDOM)


def test_a_module_that_is_not_installed_is_left_to_the_process() -> None:
    assert not is_loaded("not_installed_anywhere", ("not_installed_anywhere", "xml.sax.saxutils"))


def test_a_module_that_kills_its_server_does_not_keep_processes_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "deadly_to_load.py").write_text("import os\nos._exit(3)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    for foreseen in (WORTH_A_SERVER, 1):
        assert not is_loaded("deadly_to_load", ("deadly_to_load",), foreseen)


def test_processes_have_one_thread_each_and_who_starts_them_keeps_its_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba refuses to compile in a process whose threads run already, once its environment asks for another number of them."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    before = dict(os.environ)
    for number in (0, 1):
        process = start(Origin(number=number), show_threads)
        assert process.pipe.poll(WAIT)
        assert process.pipe.recv() == ["1", "1"]
        process.join(WAIT)
        assert dict(os.environ) == before


@pytest.mark.parametrize("writes", [True, False])
def test_processes_write_bytecode_where_we_do_and_leave_interrupts_to_us(writes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module that is written anew within a second, as an engine of a drill, would be loaded as it was."""
    monkeypatch.setattr(sys, "dont_write_bytecode", not writes)
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    process = start(Origin(only=str(writes)), show_flags)
    assert process.pipe.poll(WAIT)
    assert process.pipe.recv() == (not writes, signal.SIG_IGN)


def place(number: int) -> int:
    """Where the interpreter's own code lies in a process off this server."""
    process = start(Origin(number=number), show_place)
    assert process.pipe.poll(WAIT)
    found: int = process.pipe.recv()
    process.join(WAIT)
    return found


def test_processes_of_one_server_are_laid_out_alike_and_those_of_two_are_not() -> None:
    """The chance that the speed of an engine is left to; the second half of it where the system places programs at random."""
    randomised = Path("/proc/sys/kernel/randomize_va_space")
    assert place(0) == place(0)
    if not randomised.is_file() or randomised.read_text().strip() == "0":
        pytest.skip("the system loads programs at the same place each time")
    assert place(0) != place(1)
