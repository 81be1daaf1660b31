"""A plug-in of pytest for the author of an engine: `pytest --plumbline ENGINE` asks its checks and cases as tests.

Each check of the conformance kit and each case is a test on each track, called `plumbline::ENGINE::TRACK::NAME`. Marks say
what it is about, so that `-m "contact and not slow"` chooses:

* `plumbline` all of them; `conformance` or `case`; the track, `default` or `tuned`;
* of a check its subject and file, like `contact` and `friction`; of a case its family, like `stack`, and each effect that its
  scene calls for, like `contact`, `friction`, `joints`; `slow` if it takes many steps.

A check or scene that the engine refuses by name is skipped, a failure that its adapter declares is an expected one (xfailed),
and all else that does not pass fails with its reason. `--plumbline-known FILE` names tests that are known to fail, in a line
each as pytest's summary has them: they are expected to fail, and one that passes is an error, so that an engine that improves
is noticed. `--plumbline-write-known FILE` writes that file. Each test runs in a process of its own.
"""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal

import pytest

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case
    from plumbline.harness.conformance import ConformanceCheck

TRACKS: tuple[Literal["default", "tuned"], ...] = ("default", "tuned")
_KNOWN = "known: "
"""Begins the reason of a failure that a file of known ones expects."""
SLOW_STEPS, SLOW_SECONDS = 20_000, 20.0
"""A case is slow if it takes more steps of a body, or more simulated time [s]."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option `--plumbline`."""
    group = parser.getgroup("plumbline")
    group.addoption(
        "--plumbline",
        action="append",
        default=[],
        metavar="ENGINE",
        help="Test this engine by Plumbline's conformance checks and cases; may be repeated.",
    )
    group.addoption(
        "--plumbline-known",
        default=None,
        metavar="FILE",
        help="Tests of --plumbline that are known to fail, a line each: [FAILED] plumbline::ENGINE::TRACK::NAME [- reason].",
    )
    group.addoption(
        "--plumbline-write-known",
        default=None,
        metavar="FILE",
        help="At the end of a whole run, write the tests of --plumbline that failed to this file, for --plumbline-known.",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Listen for failures if they are to be written; where tests are shared out, in the process that hears of all."""
    if (name := config.getoption("--plumbline-write-known")) and not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Listener(Path(name)))


class _Listener:
    """Hears which tests of `--plumbline` fail, and writes them to a file once all have run."""

    def __init__(self, file: Path) -> None:
        self._file, self._failed, self._written = file, dict[str, str](), False

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """What failed, or failed again as the file before this one says; what its adapter declares is no news."""
        expected, text = getattr(report, "wasxfail", ""), str(report.longrepr or "")
        again = report.skipped and expected.startswith(_KNOWN)
        if report.nodeid.startswith("plumbline::") and (again or (report.failed and not text.startswith("[XPASS"))):
            why = expected.removeprefix(_KNOWN) if again else text.strip().splitlines()[-1]
            self._failed[report.nodeid] = " ".join(why.replace("#", "no. ").split())[:160]

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Write the file whole, or leave the one that is there: a run that was cut short has not seen all."""
        whole = not session.shouldfail and not session.shouldstop
        if whole and exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
            lines = [f"{test} - {why}\n" for test, why in sorted(self._failed.items())]
            beside = self._file.with_name(f".{self._file.name}.new")
            beside.write_text("".join(lines), encoding="utf-8")
            beside.replace(self._file)
            self._written = True

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say what was written."""
        if self._written:
            terminalreporter.write_line(f"{self._file}: {len(self._failed)} known failures written")
        else:
            terminalreporter.write_line(f"{self._file}: not written, the run did not end")


class Failed(Exception):
    """A check or a case that did not pass; the text is its reason."""


class _Item(pytest.Item):
    """One check or case on one track of an engine."""

    def __init__(self, *, adapter: "Adapter", track: Literal["default", "tuned"], marks: tuple[str, ...], **rest: Any) -> None:
        super().__init__(**rest)
        self.adapter, self.track = adapter, track
        for mark in dict.fromkeys(("plumbline", track, *marks)):
            self.add_marker(mark)

    def repr_failure(self, excinfo: "pytest.ExceptionInfo[BaseException]", *arguments: Any) -> Any:
        """The reason alone, where it is one of an engine."""
        return str(excinfo.value) if isinstance(excinfo.value, Failed) else super().repr_failure(excinfo, *arguments)

    def reportinfo(self) -> tuple[Path, None, str]:
        """What a report calls it."""
        return self.path, None, self.nodeid


class CheckItem(_Item):
    """A conformance check."""

    def __init__(self, *, check: "ConformanceCheck", **rest: Any) -> None:
        super().__init__(**rest)
        self._check = check

    def runtest(self) -> None:
        """Put it to the engine, in a process that it may take down."""
        from plumbline.harness.conformance.forked import outcome_of

        outcome = outcome_of(self.adapter, self.track, self._check)
        if outcome.status == "not_applicable":
            pytest.skip(outcome.message)
        if outcome.status == "known":
            pytest.xfail(outcome.message)
        if outcome.status != "passed":
            raise Failed(f"{outcome.question}\n{outcome.message}")


class CaseItem(_Item):
    """A case at its own time step, with each of its seeds."""

    def __init__(self, *, case: "Case", **rest: Any) -> None:
        super().__init__(**rest)
        self._case = case

    def runtest(self) -> None:
        """Run it in processes of their own and judge the answers."""
        from plumbline.harness.run.isolated import run_isolated
        from plumbline.harness.study.experiment import Experiment
        from plumbline.harness.study.plugins import version_of
        from plumbline.harness.study.study import Study

        case, adapter = self._case, self.adapter
        study = Study(name="pytest", experiments=(Experiment(name="case", tracks=(self.track,), timing=False),))
        trials = study.trials({case.name: case}, {adapter.name: adapter}, {adapter.name: version_of(adapter)[0]})
        with TemporaryDirectory(prefix="plumbline-pytest-") as folder:
            records = list(run_isolated(list(trials), Path(folder), 1))
        wrong = [record for record in records if record.status not in ("passed", "unsupported")]
        if wrong:
            reasons = "\n".join(f"{record.status}: {record.reason}" for record in wrong)
            raise Failed(f"{case.question}\n{reasons}")
        if all(record.status == "unsupported" for record in records):
            pytest.skip(records[0].reason)


def _marks_of_case(case: "Case") -> tuple[str, ...]:
    scene = case.scene(case.parameters)
    steps = case.duration / case.dt * sum(body.movable for body in scene.bodies) * case.ensemble
    slow = ("slow",) if steps > SLOW_STEPS or case.duration > SLOW_SECONDS else ()
    return ("case", case.family, *scene.effects.names, *slow)


def _known_failures(config: pytest.Config) -> dict[str, str]:
    """By the name of a test, why it is known to fail. Raises: UsageError."""
    from plumbline.harness.intake.documents import InputError, read

    if (name := config.getoption("--plumbline-known")) is None:
        return {}
    try:
        lines = read(Path(name)).splitlines()
    except InputError as error:
        raise pytest.UsageError(f"--plumbline-known {error}") from None
    failures = {}
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].strip().removeprefix("FAILED ")
        if text:
            test, _, reason = text.partition(" - ")
            if not test.startswith("plumbline::"):
                raise pytest.UsageError(f"{name}: line {number}: {test!r}, expected plumbline::ENGINE::TRACK::NAME")
            failures[test] = _KNOWN + (reason or name)
    return failures


def _items(session: pytest.Session, engine: str) -> Iterator[_Item]:
    """The tests of an engine. Raises: UsageError, where there is none of that name, or it is not installed."""
    from plumbline.harness.conformance import CHECKS
    from plumbline.harness.intake.error import PlumblineError
    from plumbline.harness.study import plugins
    from plumbline.harness.study.environments import home_of

    try:
        adapter = plugins.adapter(engine)
    except PlumblineError as error:
        raise pytest.UsageError(f"--plumbline: {error}") from None
    if home_of(engine) is not None:
        raise pytest.UsageError(
            f"--plumbline {engine}: it lives in an environment of its own; plumbline check {engine} asks it"
        )
    if reason := plugins.version_of(adapter)[1]:
        raise pytest.UsageError(f"--plumbline {engine}: unavailable: {reason}")
    cases = [(case, _marks_of_case(case)) for case in plugins.cases().values()]

    def item(kind: type[_Item], track: str, name: str, marks: tuple[str, ...], **subject: Any) -> _Item:
        for mark in marks:
            session.config.addinivalue_line("markers", f"{mark}: of Plumbline's tests")
        nodeid = f"plumbline::{engine}::{track}::{name}"
        created: _Item = kind.from_parent(
            session, name=name, nodeid=nodeid, adapter=adapter, track=track, marks=marks, **subject
        )
        return created

    for track in TRACKS:
        for check in CHECKS:
            yield item(CheckItem, track, check.name, ("conformance", *check.subject), check=check)
        for case, marks in cases:
            yield item(CaseItem, track, case.name, marks, case=case)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the tests of the engines that are asked for, before others choose among all."""
    engines, failures = config.getoption("--plumbline"), _known_failures(config)
    for mark in ("plumbline", *TRACKS) if engines else ():
        config.addinivalue_line("markers", f"{mark}: of Plumbline's tests")
    for item in (item for engine in engines for item in _items(session, engine)):
        if reason := failures.pop(item.nodeid, ""):
            item.add_marker(pytest.mark.xfail(reason=reason, raises=Failed, strict=True))
        items.append(item)
    if failures:
        raise pytest.UsageError(f"{config.getoption('--plumbline-known')}: {next(iter(failures))}: no such test")
