"""One conformance check in a process off a fork server: an engine that ends its process, or hangs, fails that check alone."""

import dataclasses
import os
from multiprocessing.connection import Connection
from typing import Literal

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.conformance.apart import LONGEST
from plumbline.harness.conformance.catalogue import NAMED
from plumbline.harness.conformance.check import ConformanceCheck
from plumbline.harness.conformance.outcomes import CheckOutcome, as_outcome, run_check
from plumbline.harness.intake.bounded import limit_files, named_signal
from plumbline.harness.intake.deadline import Deadline
from plumbline.harness.run.fork_servers import WORTH_A_SERVER, expect, loaded, start
from plumbline.harness.run.message import BrokenMessage, Inbox, read_value, send
from plumbline.harness.study import plugins

_REFUSED: dict[tuple[str, str, Feature], CheckOutcome] = {}
"""By engine, track and the features that it lacks: an outcome that said it refuses them, as it should."""
_LISTENS = 1.0
"""Seconds between looks at its deadline."""


def outcome_of(adapter: Adapter, track: Literal["default", "tuned"], check: ConformanceCheck) -> CheckOutcome:
    """What the check found, or that its process ended without a word, in how many seconds of CPU time it may.

    An engine that lacks what a check needs is asked once whether it refuses that, and not once for each such check."""
    lacks = adapter.name, track, check.needs & ~adapter.features
    if lacks in _REFUSED and f"{track}/{check.name}" not in adapter.known_failures:
        return dataclasses.replace(_REFUSED[lacks], check=check.name, question=check.question)
    outcome = _asked(adapter, track, check)
    if lacks[2] and outcome.status == "not_applicable":
        _REFUSED[lacks] = outcome
    return outcome


def _asked(adapter: Adapter, track: Literal["default", "tuned"], check: ConformanceCheck) -> CheckOutcome:
    expect([__name__])
    process = start(loaded(adapter.loads, WORTH_A_SERVER), _put, adapter.name, track, check.name)
    inbox, deadline = Inbox(process.pipe), Deadline(process.pid, LONGEST + adapter.compile_allowance)
    how = ""
    try:
        while not how:
            if (message := inbox.next(_LISTENS)) is not None:
                return read_value(CheckOutcome, message[1])
            if late := deadline.passed():
                how = f"did not end within {LONGEST + adapter.compile_allowance:g} s, {late}"
    except EOFError:
        code = process.exit_code()
        how = f"was killed by {named_signal(-code)}" if code is not None and code < 0 else f"ended with exit code {code}"
    except BrokenMessage as error:
        how = f"said what is no outcome: {error}"
    finally:
        process.end()
        inbox.pipe.close()
    return as_outcome(adapter.name, track, check, "failed", f"the process of the check {how}")


def _put(pipe: Connection, name: str, track: Literal["default", "tuned"], check: str) -> None:
    """Put a check to an engine, and tell what it found."""
    os.setpgid(0, 0)  # what it starts ends with it
    limit_files()
    send(pipe, "outcome", dataclasses.asdict(run_check(plugins.adapter(name), track, NAMED[check])))
