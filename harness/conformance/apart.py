"""The whole kit put to a version of an engine, in a process on the interpreter of that version's environment.

`python -m harness.conformance.apart ENGINE OUT TRACK...` writes one line of JSON for each outcome, as soon as it is known, so
that a check that takes the process down is known by its place.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.harness.conformance.catalogue import CHECKS
from plumbline.harness.conformance.outcomes import Outcome, run_check
from plumbline.harness.run.child import named_signal
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import Environment, project_folders

LONGEST = 3600.0
"""Seconds that the kit may take: some minutes on engines that are fast."""


def outcomes_in(environment: Environment, name: str, tracks: Sequence[str]) -> tuple[Outcome, ...]:
    """All checks on these tracks; one that ends the process, or the time, fails, and those after it are not asked.

    Args: name: of the version, like 'mujoco 3.3.0'. Raises: OSError.
    """
    with TemporaryDirectory(prefix="plumbline-check-") as scratch:
        out = Path(scratch) / "outcomes.jsonl"
        command = [environment.executable, "-P", "-m", "plumbline.harness.conformance.apart", name, str(out), *tracks]
        surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join(project_folders())}
        try:
            done = subprocess.run(
                command, env=surroundings, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=LONGEST, check=False
            )
            code = done.returncode
            how = "" if code == 0 else f"died: {named_signal(-code)}" if code < 0 else f"ended with code {code}"
        except subprocess.TimeoutExpired:
            how = f"did not end within {LONGEST:g} s"
        lines = out.read_text(encoding="utf-8").splitlines() if out.is_file() else []
    outcomes = tuple(Outcome(**json.loads(line)) for line in lines)
    asked = [(track, check) for track in tracks for check in CHECKS]
    if not how and len(outcomes) == len(asked):
        return outcomes
    track, check = asked[min(len(outcomes), len(asked) - 1)]
    message = f"the process of the checks {how or 'ended early'}; those after this one were not asked"
    died = Outcome(engine=name, track=track, check=check.name, question=check.question, status="failed", message=message)
    return (*outcomes, died)


def _write(name: str, out: Path, tracks: Sequence[str]) -> None:
    adapter = plugins.adapter(name)
    with out.open("w", encoding="utf-8") as stream:
        for track in tracks:
            for check in CHECKS:
                stream.write(json.dumps(asdict(run_check(adapter, track, check))) + "\n")
                stream.flush()


if __name__ == "__main__":
    _write(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
