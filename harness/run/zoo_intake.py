"""Taking in the robots of a zoo side by side: those that a folder knows already are not read again."""

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import psutil

from plumbline.harness.run.progress import Progress
from plumbline.harness.store import zoo_record
from plumbline.harness.store.zoo_record import Entry
from plumbline.harness.study import plugins, sources
from plumbline.harness.study.zoo.robots import Robot, at_hand
from plumbline.harness.study.zoo.taking_in import take_in, unread


def taken_in(folder: Path, robots: Sequence[Robot], engines: Sequence[str], workers: int) -> list[Entry]:
    """An entry for each robot, in their order, kept in the folder as they come.

    Whose publisher could not be reached once is not asked again for the rest of a package. Raises: OSError.
    """
    entries = {entry.name: entry for entry in zoo_record.entries(folder)}
    keys = {robot.name: key for robot, key in zip(robots, _keys(robots, engines), strict=True)}
    new = [robot for robot in robots if not _holds(folder, entries.get(robot.name), keys[robot.name])]
    unreached: dict[str, str] = {}

    def take(robot: Robot) -> Entry:
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


def _holds(folder: Path, entry: Entry | None, key: str) -> bool:
    """Does an entry still hold? What was not on this machine may be by now."""
    if entry is None or entry.key != key or entry.stage == "not here":
        return False
    return not entry.scene or (folder / entry.scene).is_file()


def _keys(robots: Sequence[Robot], engines: Sequence[str]) -> Iterator[str]:
    """Of each robot a digest of all that its entry rests on: what it is, the importers, the engines with their adapters."""
    modules = ["plumbline.harness.study.zoo.taking_in", "plumbline.harness.scene.importers.reading"]
    modules += [module for engine in engines if (module := plugins.module_of("adapters", engine))]
    rests = [sources.digest_of(sources.closure(modules))]
    rests += [f"{engine} {plugins.version_of(plugins.adapter(engine))}" for engine in engines]
    for robot in robots:
        yield hashlib.sha256("\n".join([*rests, repr(robot)]).encode()).hexdigest()[:16]
