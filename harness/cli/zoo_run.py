"""Running the zoo: its packages, each robot taken in, then the study of those that go in."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from plumbline.api.engines import chosen_engines
from plumbline.api.present import present
from plumbline.harness.adapter import Adapter
from plumbline.harness.cli.guard import INTERRUPTED, USAGE, check_words, fail_for, say, stop
from plumbline.harness.cli.own_scene import closing_count
from plumbline.harness.findings.tables import table
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.run import zoo_intake
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.interrupt import until
from plumbline.harness.run.make_environment import NotMade
from plumbline.harness.run.zoo_intake import RobotByRobot, taken_in
from plumbline.harness.store.journal import FolderTaken
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import StudyError
from plumbline.harness.study.zoo.robots import ZooRobot, chosen, robots
from plumbline.harness.study.zoo.study import BUDGET, study_of


def zoo_robots(globs: Sequence[str], agreed: bool) -> list[ZooRobot]:
    """The robots of the zoo that a pattern names, with their packages installed where that is agreed to.

    Raises: PlumblineError, of a pattern that names none, and where nothing is installed.
    """
    if agreed:
        try:
            zoo_intake.install()
        except NotMade as error:
            raise PlumblineError(f"the packages of the zoo were not installed: {error}") from None
    zoo_intake.look()
    wanted = chosen(robots(), globs)
    if not any(robot.version for robot in wanted):
        raise PlumblineError(
            f"none of the packages of the zoo is installed: add --yes to install them ({zoo_intake.PRICE}) in a folder of "
            "their own, or: pip install 'plumbline[zoo]'"
        )
    return wanted


def run_zoo(
    folder: Path,
    globs: Sequence[str],
    engine_names: Sequence[str],
    *,
    agreed: bool,
    workers: int,
    resume: bool | Literal["merge"],
    budget: float | None,
) -> None:
    """The command `run zoo`: take all robots in, run the study on those that go in, write the report.

    Args: budget [s]: of waiting time; the zoo's own if None.
    """
    robots = zoo_robots(globs, agreed)
    adapters = chosen_engines(engine_names, agreed)
    try:
        store = carried_out(folder, robots, adapters, workers=workers, resume=resume, budget=budget)
    except StudyError as error:
        stop(USAGE, str(error))
    except KeyboardInterrupt:
        stop(INTERRUPTED, f"interrupted; what finished is in {folder}; go on with the same command and --resume")
    say(closing_count(store), err=True)
    rows = table("zoo").rows(store)
    for sentence in table("zoo").sentences(rows):
        say(sentence, err=True)
    say("writing the report", err=True)
    report = present(store, recordings=False)
    say(str(report.index.with_name("zoo.html")))
    fail_for(report.sentences())


def carried_out(
    folder: Path,
    robots: Sequence[ZooRobot],
    adapters: Mapping[str, Adapter],
    *,
    workers: int,
    resume: bool | Literal["merge"],
    budget: float | None,
) -> Store:
    """Take all robots in and run the study on those that go in.

    Raises: as `carry_out`; StudyError where no robot goes in.
    """
    begun, total = time.monotonic(), BUDGET if budget is None else budget
    if (folder / "journal.jsonl").exists() and not resume:
        raise FolderTaken(f"{folder}: holds a run already; add --resume to go on with it, or choose another --out")
    entries = taken_in(folder, robots, tuple(adapters), workers)
    going_in = sorted((entry for entry in entries if entry.stage == "in"), key=lambda entry: (entry.bodies, entry.name))
    say(f"{len(going_in)} of {len(entries)} robots go in; show --table zoo says why the others do not", err=True)
    if not going_in:
        raise StudyError(f"no robot goes in, first: {entries[0].name}: {entries[0].reason}")
    paths = [str((folder / entry.scene).resolve()) for entry in going_in]
    check_words(paths)
    cases = {case.name: case for path in paths for case in [plugins.case(f"{plugins.SCENE_PREFIX}{path}")]}
    guide = RobotByRobot(cases, workers, begun + total)
    with until(guide.end):
        store = carry_out(study_of(), folder, cases, adapters, workers=workers, resume=resume, guide=guide)
    if guide.over:
        say(f"{total / 60:.0f} minutes are over; the same command with --resume goes on", err=True)
    return store
