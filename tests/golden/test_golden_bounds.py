"""Every bound of every case, at the case's own step and parameters, is still what it was: nothing is widened unseen.

A bound that is changed on purpose is written anew by `PLUMBLINE_GOLDEN=write pytest tests/golden/test_golden_bounds.py`, and
the message of the commit says why: the file stands beside the case in its difference.
"""

import json
import os
from pathlib import Path

from plumbline.harness.case import Case
from plumbline.harness.study import plugins

FILE = Path(__file__).with_name("bounds.json")
ROUNDING = 1e-3
"""Share by which a bound that is itself integrated may differ from machine to machine; all others are closed forms."""


def bounds_of(case: Case) -> dict[str, float]:
    """By metric, with its part of the run where it judges no more than that: the bound in the metric's unit."""
    named = {}
    for check in case.checks:
        part = (
            ""
            if check.start == 0 and check.end is None
            else f" {check.start:g}..{'' if check.end is None else f'{check.end:g}'} s"
        )
        named[f"{check.metric.name} [{check.metric.unit}]{part}"] = check.bound(case.dt, case.parameters)
    assert len(named) == len(case.checks), f"{case.name}: two checks of one metric over one part of the run"
    return named


def in_all() -> dict[str, dict[str, float]]:
    """Those of all cases, to six digits."""
    return {
        name: {check: float(f"{bound:.6g}") for check, bound in bounds_of(case).items()}
        for name, case in sorted(plugins.cases().items())
    }


def test_no_bound_has_changed() -> None:
    now = in_all()
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        FILE.write_text(json.dumps(now, indent=1) + "\n", encoding="utf-8")
    then = json.loads(FILE.read_text(encoding="utf-8"))
    assert {name: list(checks) for name, checks in now.items()} == {name: list(checks) for name, checks in then.items()}
    changed = {
        f"{name}: {check}": (then[name][check], bound)
        for name, checks in now.items()
        for check, bound in checks.items()
        if not abs(bound - then[name][check]) <= ROUNDING * abs(then[name][check])
    }
    assert not changed, f"bounds that were (first) and are (second): {changed}; write them anew, and say why in the commit"
