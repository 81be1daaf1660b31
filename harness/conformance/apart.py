"""The whole kit put to an engine in processes of their own, on this interpreter or that of a version's environment.

`python -m harness.conformance.apart ENGINE CHECKS OUT` writes one line of JSON for each outcome, as soon as it is known. A
check that takes its process down, or that does not end, has failed; those after it are put to a new process.
"""

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from plumbline.harness.conformance.catalogue import CHECKS, NAMED
from plumbline.harness.conformance.outcomes import CheckOutcome, as_outcome, run_check
from plumbline.harness.intake.apart import START
from plumbline.harness.intake.bounded import Bounded, absolute
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import Environment, project_folders

LONGEST = 60.0
"""Seconds of CPU time that one check may take, as a trial of a study; most take less than one."""
MOST_LOST = 3
"""Checks in a row without an outcome, after which the others are not asked."""
_LINE: TypeAdapter[CheckOutcome] = TypeAdapter(CheckOutcome)
_Asked = tuple[str, str]
"""Track and name of a check."""


def outcomes_in(environment: Environment | None, name: str, tracks: Sequence[str]) -> tuple[CheckOutcome, ...]:
    """All checks on these tracks, in order.

    Args: environment: None for this interpreter. name: of the engine, or of a version like 'mujoco 3.3.0'. Raises: OSError.
    """
    left: list[_Asked] = [(track, check.name) for track in tracks for check in CHECKS]
    outcomes: list[CheckOutcome] = []
    lost = 0
    while left and lost < MOST_LOST:
        answered, how = _asked(environment, name, left)
        outcomes += answered
        left = left[len(answered) :]
        lost = 0 if answered else lost
        if left:
            lost += 1
            outcomes.append(_failed(name, left.pop(0), f"the process of the check {how}"))
    why = f"not asked: {lost} checks in a row had no outcome"
    return (*outcomes, *(_failed(name, asked, why) for asked in left))


def _failed(name: str, asked: _Asked, message: str) -> CheckOutcome:
    track, check = asked
    return as_outcome(name, track, NAMED[check], "failed", message)


def _asked(environment: Environment | None, name: str, checks: Sequence[_Asked]) -> tuple[list[CheckOutcome], str]:
    """The outcomes of the first of these checks, and how the process ended under the next one."""
    interpreter = sys.executable if environment is None else environment.executable
    folders = absolute(sys.path) if environment is None else project_folders()
    command = [interpreter, "-P", "-m", "plumbline.harness.conformance.apart", name, json.dumps(checks)]
    allowed = LONGEST + START + plugins.adapter(name).compile_allowance
    with Bounded(command, answers=True, env=os.environ | {"PYTHONPATH": os.pathsep.join(folders)}) as program:
        read = 0

        def further() -> bool:
            return program.answer.is_file() and program.answer.stat().st_size > read

        while program.running and program.wait(allowed, further) and program.running:
            read = program.answer.stat().st_size
        ended = program.ended()
    outcomes: list[CheckOutcome] = []
    for line, (track, check) in zip(ended.answer.split(b"\n"), checks, strict=False):
        try:
            outcome = _LINE.validate_json(line)
        except ValidationError:
            break
        if (outcome.engine, outcome.track, outcome.check) != (name, track, check):
            break
        outcomes.append(outcome)
    last = f": {ended.last_words}" if ended.code and ended.last_words else ""
    return outcomes, f"{ended.how}{last}"[:400]


def _write(name: str, checks: Sequence[_Asked], out: Path) -> None:
    adapter = plugins.adapter(name)
    with out.open("w", encoding="utf-8") as stream:
        for track, check in checks:
            stream.write(json.dumps(asdict(run_check(adapter, track, NAMED[check]))) + "\n")
            stream.flush()
    os._exit(0)


if __name__ == "__main__":
    _write(sys.argv[1], json.loads(sys.argv[2]), Path(sys.argv[3]))
