"""What all tests share: the command line as a person calls it, faulty engines, a run of known prices and a first night."""

import ctypes
import gc
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from tests.known_prices import KnownPrices

pytest_plugins = ["tests.stress.ledger", "tests.scheduling"]

PLUGINS = Path(__file__).parent / "stress" / "plugins"
"""A folder with installed-looking plug-ins; on PYTHONPATH it is found like any package."""

WITHOUT_WHEELS = () if sys.version_info < (3, 12) else ("pybullet",)
"""Packages of engines that this Python has no wheel of."""

Command = Callable[..., subprocess.CompletedProcess[str]]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test that asks an engine which this Python has no wheel of is skipped with the reason."""
    if call.excinfo is not None and (missing := lacking(call.excinfo.value)):
        call.excinfo = pytest.ExceptionInfo.from_exc_info((type(missing), missing, call.excinfo.tb))
    return (yield)


def lacking(error: BaseException | None) -> BaseException | None:
    """A skip, where an error comes of an engine of `WITHOUT_WHEELS` that is not here."""
    while error is not None:
        for package in WITHOUT_WHEELS:
            if isinstance(error, ModuleNotFoundError) and error.name == package and importlib.util.find_spec(package) is None:
                return pytest.skip.Exception(f"{package} has no wheel for Python {sys.version_info[0]}.{sys.version_info[1]}")
        error = error.__cause__ or error.__context__
    return None


@pytest.fixture(scope="session")
def with_plugins() -> Mapping[str, str]:
    """The environment of a child that sees the faulty engines."""
    return os.environ | {"PYTHONPATH": str(PLUGINS)}


@pytest.fixture(scope="session")
def plumbline(with_plugins: Mapping[str, str]) -> Command:
    """Call the command line in a process of its own, with the faulty engines installed if asked for."""

    def call(*arguments: object, plugins: bool = False, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "plumbline", *map(str, arguments)],
            env=with_plugins if plugins else None,
            cwd=cwd,
            capture_output=True,
            text=True,
            timeout=280,
            check=False,
        )

    return call


@pytest.fixture(scope="session")
def printed() -> Command:
    """Call the command line in this process: for what it prints of a folder, not for how its own process starts and ends."""
    from click.testing import CliRunner

    from plumbline.harness.cli.main import main  # late: scripts in a vendor's words need nothing of ours

    def call(*arguments: object) -> subprocess.CompletedProcess[str]:
        heard = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            done = CliRunner().invoke(main, [*map(str, arguments)])
        finally:
            for number, handler in heard.items():
                signal.signal(number, handler)
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)

    return call


@pytest.fixture(scope="module")
def mjcf_here() -> Iterator[None]:
    """MJCF is compiled in this process: a test of `compile_apart` shows that a process of its own leaves the same."""
    from plumbline.harness.scene.importers import mjcf  # late, as above
    from tests.mjcf_here import compiled_here

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mjcf, "compile_apart", compiled_here)
        yield


@pytest.fixture(scope="session")
def known_prices(tmp_path_factory: pytest.TempPathFactory) -> "KnownPrices":
    """A run of engines whose price of an error is known, and the laws that they follow."""
    from tests.known_prices import run_known_prices  # late, as above

    return run_known_prices(tmp_path_factory.mktemp("known_prices") / "run")


@pytest.fixture(scope="session")
def first_night(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A history with one night, which is only read and copied."""
    from tests.nights import night, planted  # late, as above

    root = tmp_path_factory.mktemp("first_night") / "h"
    with planted():
        night(root)
    return root


@pytest.fixture(scope="session", autouse=True)
def _nothing_published(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test hangs on figures that ship with the package, but those that are about them."""
    from plumbline.harness.store import published

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(published, "FOLDER", tmp_path_factory.getbasetemp() / "nothing_published")
        yield


@pytest.fixture(scope="session", autouse=True)
def _pictures_drawn_once() -> Iterator[None]:
    """Equal specifications of charts are drawn once in a process: most tests of a report build one that was built before."""
    import vl_convert

    draw, drawn = vl_convert.vegalite_to_svg, dict[str, str]()

    def once(spec: Mapping[str, Any], **options: Any) -> str:
        key = json.dumps([spec, options])
        if key not in drawn:
            drawn[key] = draw(spec, **options)
        return drawn[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vl_convert, "vegalite_to_svg", once)
        yield


MEMORY, ENOUGH = Path("/dev/shm"), 12 * 2**30
"""A file system that is no disk, and the bytes that it needs free: twice what `make test-all` writes, 5 GB."""


M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
"""From malloc.h of glibc."""


def pytest_configure() -> None:
    """Tests write to memory where there is room: they wait for a disk ten thousand times otherwise.

    And a process keeps the memory that it frees: each of a thousand worlds of Bullet would ask the system for 29 MB anew.
    Threads for products of small matrices do little but wait for the next one, and take a core from the process beside this.
    Those of OpenMP, which step worlds on several threads, spin while they wait: for seconds, where others have the cores.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # NumPy is loaded later
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    with suppress(AttributeError):  # another C library
        for what, size in ((M_TRIM_THRESHOLD, 256 * 2**20), (M_MMAP_THRESHOLD, 32 * 2**20)):
            ctypes.CDLL(None).mallopt(what, size)
    if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free >= ENOUGH:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))


def pytest_collection() -> None:
    """What is imported and collected stays to the end: there is no garbage to search for meanwhile."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Take what was imported and collected out of the search for garbage: it stays to the end, and each search walks it."""
    gc.collect()
    gc.freeze()
    gc.enable()


SECONDS = defaultdict[str, float](float)
"""How long the tests of each file took, in whichever process."""


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    SECONDS[report.nodeid.partition("::")[0]] += report.duration


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which files take longest, where many were run."""
    if len(SECONDS) > 10:
        terminalreporter.section("slowest files")
        for file in sorted(SECONDS, key=lambda file: -SECONDS[file])[:10]:
            terminalreporter.line(f"{SECONDS[file]:7.1f} s  {file}")
