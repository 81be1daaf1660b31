"""Taking in the robots of a zoo side by side: those that a folder knows already are not read again.

The packages of a zoo, in a folder beside the environments of engines: their files alone, without what their code needs.

Some would bring a whole training stack along for the sake of a few robot files. What `pip install 'plumbline[zoo]'` has put
beside plumbline is found first.
"""

import hashlib
import shutil
import sys
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import psutil

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.user_cache import is_ours, make_ours
from plumbline.harness.run.known_results import Waited
from plumbline.harness.run.make_environment import NotMade, last_error
from plumbline.harness.run.waiting_time import Progress
from plumbline.harness.store import disk, zoo_record
from plumbline.harness.store.zoo_record import ZooEntry
from plumbline.harness.study import plugins, sources, zoo
from plumbline.harness.study.environments import root
from plumbline.harness.study.trial import Trial
from plumbline.harness.study.zoo.robots import ZooRobot, at_hand
from plumbline.harness.study.zoo.taking_in import take_in, unread


def taken_in(folder: Path, robots: Sequence[ZooRobot], engines: Sequence[str], workers: int) -> list[ZooEntry]:
    """An entry for each robot, in their order, kept in the folder as they come.

    Whose publisher could not be reached once is not asked again for the rest of a package. Raises: OSError.
    """
    entries = {entry.name: entry for entry in zoo_record.entries(folder)}
    keys = {robot.name: key for robot, key in zip(robots, _keys(robots, engines), strict=True)}
    new = [robot for robot in robots if not _holds(folder, entries.get(robot.name), keys[robot.name])]
    unreached: dict[str, str] = {}

    def take(robot: ZooRobot) -> ZooEntry:
        if robot.package in unreached and not at_hand(robot):
            return replace(unread(robot, keys[robot.name]), reason=unreached[robot.package])
        entry = take_in(folder, robot, engines, keys[robot.name])
        if entry.stage == "not here":
            unreached.setdefault(robot.package, entry.reason)
        return entry

    with Progress("taking in", len(new)) as progress, ThreadPoolExecutor(workers) as side_by_side:
        try:
            for entry in side_by_side.map(take, new):
                zoo_record.write(folder, entry)
                entries[entry.name] = entry
                progress.advance(f"{entry.name} {entry.stage}")
        except BaseException:
            side_by_side.shutdown(wait=False, cancel_futures=True)
            for child in psutil.Process().children(recursive=True):  # else whoever asked to stop would wait for them
                with suppress(psutil.Error):
                    child.kill()
            raise
    return [entries[robot.name] for robot in robots]


def _holds(folder: Path, entry: ZooEntry | None, key: str) -> bool:
    """Does an entry still hold? What was not on this machine may be by now."""
    if entry is None or entry.key != key or entry.stage == "not here":
        return False
    return not entry.scene or (folder / entry.scene).is_file()


def _keys(robots: Sequence[ZooRobot], engines: Sequence[str]) -> Iterator[str]:
    """Of each robot a digest of all that its entry rests on: what it is, the importers, the engines with their adapters."""
    modules = ["plumbline.harness.study.zoo.taking_in", "plumbline.harness.scene.importers.reading"]
    modules += [module for engine in engines if (module := plugins.module_of("adapters", engine))]
    rests = [sources.digest_of(sources.closure(modules))]
    rests += [f"{engine} {plugins.version_of(plugins.adapter(engine))}" for engine in engines]
    for robot in robots:
        yield hashlib.sha256("\n".join([*rests, repr(robot)]).encode()).hexdigest()[:16]


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


class RobotByRobot(Waited):
    """The zoo goes robot by robot, as many at a time as workers: broken off, it has whole robots, and --resume goes on.

    Terms: end [s]: on the monotonic clock. cases: in their order.
    """

    def __init__(self, cases: Collection[str], at_once: int, end: float) -> None:
        self._cases, self._at_once, self._end = [*cases], at_once, end

    def end(self) -> float:
        """When its time is up."""
        return self._end

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """Some robots after the others."""
        for first in range(0, len(self._cases), self._at_once):
            mine = set(self._cases[first : first + self._at_once])
            if batch := [trial for trial in trials if trial.case in mine]:
                yield batch
