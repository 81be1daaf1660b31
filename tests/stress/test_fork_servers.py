"""A fork server that is killed, busy or idle, costs no cell; an engine that kills its own costs its own cells alone."""

import os
import signal
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import pandas as pd
import psutil
import pytest

from plumbline.harness.run import fork_servers
from plumbline.harness.run.fork_servers import Origin
from plumbline.harness.run.fork_servers import start as start_process
from plumbline.harness.store.store import Store
from tests.conftest import Command
from tests.light_servers import light_servers
from tests.stress.ledger import Page
from tests.stress.test_interruption import start
from tests.told_by_processes import end

HEAD = """
name = "servers"
recordings = false
[[experiments]]
name = "servers"
cases = ["stress_fall"]
tracks = ["tuned"]
dt = [{steps}]
"""
MORE = {
    "plain": "timing = false",
    "loaded": "timing = false",
    "apart": "timing = false\ndeterminism = true",
    "clock": "timing = true\nsamples = 6\nsample_seconds = 0.05",
}
ENGINE = {"plain": "slow", "loaded": "loading", "apart": "slow", "clock": "slow"}
CELLS = {"plain": 6, "loaded": 24, "apart": 3, "clock": 2}
MARK = {
    "plain": "plumbline.harness.cli.main",
    "loaded": "xml.dom.pulldom",
    "apart": "plumbline.harness.cli.main",
    "clock": "plumbline.harness.cli.main",
}


def servers(of: int, mark: str) -> list[psutil.Process]:
    """The fork servers that a process has, by a module that they preload."""
    found = []
    with suppress(psutil.Error):  # what has just ended
        for child in psutil.Process(of).children():
            line = " ".join(child.cmdline())
            if "fork_server import main" in line and mark in line:
                found.append(child)
    return found


def study(folder: Path, kind: str) -> Path:
    path = folder / "servers.toml"
    steps = ", ".join(f"{0.5 / n:.17g}" for n in range(30, 30 + CELLS[kind]))
    path.write_text(HEAD.format(steps=steps) + MORE[kind] + "\n")
    return path


def answers(out: Path) -> pd.DataFrame:
    trials = Store(out).trials
    assert trials["trial"].is_unique
    return trials.set_index("trial").sort_index()


def busy(server: psutil.Process) -> bool:
    try:
        return bool(server.children())
    except psutil.Error:
        return False


SLOW = pytest.mark.slow


@SLOW
@pytest.mark.parametrize("kind", MARK)
def test_a_fork_server_that_is_killed_at_work_costs_no_cell(
    kind: str, tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    process = start(study(tmp_path, kind), tmp_path / "out", with_plugins, engine=ENGINE[kind])
    killed, until = 0, time.monotonic() + 200.0
    while process.poll() is None and not killed and time.monotonic() < until:
        for server in servers(process.pid, MARK[kind]):
            if busy(server) and _at_work(tmp_path / "out"):
                server.kill()
                killed += 1
        time.sleep(0.03)
    _, errors = process.communicate(timeout=200)
    assert killed
    assert process.returncode == 0, errors
    found = answers(tmp_path / "out")
    # Repetitions that need a saved state are unsupported: this engine has none.
    assert set(found["status"]) <= {"passed", "unsupported"}
    assert (found["status"] == "passed").sum() >= CELLS[kind]
    if kind == "clock":
        assert found["cpu_per_sim_s"].notna().all()
    ledger.survived("fork servers", f"{kind}, killed at work", f"servers killed {killed}, cells lost 0 of {len(found)}")


def _at_work(out: Path) -> bool:
    journal = out / "journal.jsonl"
    return journal.is_file() and journal.stat().st_size > 0


@SLOW
@pytest.mark.parametrize("timing", ["false", "true"])
def test_an_engine_that_kills_its_fork_server_costs_its_own_cells_alone(
    timing: str, tmp_path: Path, plumbline: Command, ledger: Page
) -> None:
    (tmp_path / "servers.toml").write_text(HEAD.format(steps="0.01, 0.02") + f"timing = {timing}\nsamples = 3\n")
    engines = [word for name in ("sound", "patricide", "slow") for word in ("--engine", name)]
    done = plumbline("run", tmp_path / "servers.toml", *engines, "--out", tmp_path / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    found = answers(tmp_path / "out").set_index("engine")
    assert set(found.loc[["sound", "slow"], "status"]) == {"passed"}
    assert set(found.loc["patricide", "status"]) == {"crashed"}
    assert set(found.loc["patricide", "reason"]) == {"its fork server died with it, alone too"}
    ledger.survived("fork servers", f"killed by an engine, timing {timing}", "other cells lost 0")


def _nothing(_pipe: Connection) -> None:
    pass


def _sleep(_pipe: Connection) -> None:
    time.sleep(600)


ORIGINS = {
    "plain": Origin(),
    "loaded": Origin(modules=("xml.dom.pulldom",)),
    "apart": Origin(number=7),
    "its own": Origin(number=7, only="a trial"),
}


@pytest.fixture
def light() -> Iterator[None]:
    with light_servers():
        yield


@pytest.mark.parametrize("kind", [kind if kind == "plain" else pytest.param(kind, marks=SLOW) for kind in ORIGINS])
def test_a_fork_server_that_is_killed_has_a_successor(kind: str, light: None, ledger: Page) -> None:
    """Idle, and with a process whose end nobody can tell then; an exit code of the engine's own is no such end."""
    origin = ORIGINS[kind]
    process = start_process(origin, end, 255)
    assert process.join(60.0)
    assert (process.code, process.lost) == (255, False)
    os.kill(process.server, signal.SIGKILL)
    second = start_process(origin, _sleep)
    assert not psutil.pid_exists(process.server)
    assert second.server != process.server
    os.kill(second.server, signal.SIGKILL)
    assert second.join(60.0)
    assert (second.code, second.lost) == (None, True)
    until = time.monotonic() + 60.0
    while psutil.pid_exists(second.pid) and time.monotonic() < until:
        time.sleep(0.01)
    assert not psutil.pid_exists(second.pid)  # it went along
    third = start_process(origin, _nothing)
    assert third.join(60.0)
    assert (third.code, third.lost) == (0, False)
    for when in ("idle", "with a process"):
        ledger.survived("fork servers", f"{kind}, killed {when}", "processes that could not start 0")


def test_threads_that_order_at_once_lose_nothing_to_a_server_that_is_killed(light: None, ledger: Page) -> None:
    """As those of a worker of a cluster do: each order has one answer, whoever finds the server dead."""
    first = start_process(Origin(), _sleep)
    with ThreadPoolExecutor(8) as threads:
        orders = [threads.submit(start_process, Origin(), end, code) for code in range(20)]
        os.kill(first.server, signal.SIGKILL)
        orders += [threads.submit(start_process, Origin(), end, code) for code in range(20, 40)]
        processes = [order.result(60.0) for order in orders]
    assert all(process.join(60.0) for process in processes)
    assert all(process.lost or process.code == code for code, process in enumerate(processes))
    assert {process.server for process in processes if process.lost} <= {first.server}
    assert list(fork_servers._servers) == [Origin()]
    ledger.survived("fork servers", "killed while eight threads order", "orders without an answer 0")


def test_an_order_that_never_comes_is_no_traceback(
    light: None, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], ledger: Page
) -> None:
    """Whoever ordered was killed before it said what is to be done."""

    def dies(_: object) -> bytes:
        raise ConnectionError

    monkeypatch.setattr(fork_servers.pickle, "dumps", dies)
    process = start_process(Origin(), _sleep)
    process.pipe.close()
    assert process.join(60.0)
    assert process.code == 1
    assert "Traceback" not in capfd.readouterr().err
    ledger.survived("fork servers", "an order that never comes", "no traceback")


def test_a_server_of_ones_own_ends_with_its_process(light: None, ledger: Page) -> None:
    process, other = start_process(ORIGINS["its own"], _sleep), start_process(ORIGINS["apart"], _sleep)
    assert other.server != process.server
    process.end()
    assert not psutil.pid_exists(process.server)
    assert list(fork_servers._servers) == [ORIGINS["apart"]]
    ledger.survived("fork servers", "a server of one's own", "ends with its process")


@pytest.mark.parametrize("code", [0, 1, 3, 255, -signal.SIGKILL, -signal.SIGSEGV])
def test_how_a_process_ended_is_told_as_it_was(code: int, light: None, ledger: Page) -> None:
    process = start_process(Origin(), end, code) if code >= 0 else start_process(Origin(), _sleep)
    if code < 0:
        os.kill(process.pid, -code)
    assert process.join(60.0)
    assert (process.exit_code(), process.lost) == (code, False)
    ledger.survived("fork servers", f"a process that ends with {code}", "told as it was")


def test_whoever_orders_is_gone_and_so_are_servers_and_processes(light: None, ledger: Page) -> None:
    """A pipe that closes is all that a server hears."""
    process = start_process(Origin(), _sleep)
    fork_servers._servers[Origin()]._orders.close()
    until = time.monotonic() + 60.0
    while psutil.pid_exists(process.pid) and time.monotonic() < until:
        time.sleep(0.01)
    assert not psutil.pid_exists(process.pid)
    assert process.lost or process.join(60.0)
    ledger.survived("fork servers", "whoever orders is gone", "orphans 0")
