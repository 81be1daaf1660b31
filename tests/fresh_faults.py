"""Faults thought out from the code after the kit stood: what sees each of them today?

    python -m tests.fresh_faults [NAME...] [--workers N]

The table is `tests/fresh_faults.toml`. Each fault is planted in a copy of the tree. One that lies in an adapter or in what
reads sensors is put to the check of conformance that is said to see it, then to all of them, then to its tests; all others are
put to their tests, which must pass without them. Exit code 1: some fault is seen by nothing, or by another kind of thing than
the table says.
"""

import argparse
import json
import os
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.mutants import FAILED, PASSED, Mutant, copied, planted, tested
from tests.mutants import sound as tests_fail

__all__ = ["FreshFault", "faults", "main"]

TABLE = Path(__file__).with_suffix(".toml")
_ASK = """
import json, sys
from plumbline.harness.conformance import CHECKS, run_conformance
from plumbline.harness.study import plugins
chosen = [check for check in CHECKS if not sys.argv[2:] or check.name in sys.argv[2:]]
outcomes = run_conformance(plugins.adapter(sys.argv[1]), ("tuned", "default"), chosen)
print(json.dumps([f"{o.track}/{o.check}" for o in outcomes if o.status in ("failed", "improved")]))
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class FreshFault(Mutant):
    """One fault.

    Terms:
        kind: what lies broken. checked_on: the engine that is checked, '' for none. check: the check that sees it, '' for none.
    """

    kind: str
    checked_on: str = ""
    check: str = ""


def faults(table: Path = TABLE) -> tuple[FreshFault, ...]:
    """All of the table."""
    rows = tomllib.loads(table.read_text(encoding="utf-8"))["fault"]
    return tuple(FreshFault(**{**row, "tests": tuple(row["tests"])}) for row in rows)


def failing(tree: Path, engine: str, checks: Iterable[str]) -> frozenset[str]:
    """'track/check' of what an engine fails in a tree, of these checks or of all. Raises: RuntimeError."""
    environment = {**os.environ, "PYTHONPATH": f"{tree / 'src'}:{tree}", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", _ASK, engine, *checks]
    ended = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise RuntimeError(f"check {engine}: {ended.stderr.strip().splitlines()[-1:]}")
    return frozenset(json.loads(ended.stdout.strip().splitlines()[-1]))


@cache
def sound(engine: str) -> frozenset[str]:
    """What an engine fails without a fault."""
    with copied() as tree:
        return failing(tree, engine, ())


def seen(fault: FreshFault) -> tuple[str, str]:
    """What sees a fault, 'check', 'tests' or 'nothing', and which checks, or what pytest said."""
    text = planted(fault)
    with copied() as tree:
        (tree / fault.file).write_text(text, encoding="utf-8")
        # That the one check passes without the fault is what test_conformance says.
        found = failing(tree, fault.checked_on, [fault.check]) if fault.check else frozenset()
        if not found and fault.checked_on:
            found = failing(tree, fault.checked_on, ()) - sound(fault.checked_on)
        if found:
            return "check", ", ".join(sorted(found))
        code, said = tested(tree, fault.tests, fault.plain, None)
    if code not in (PASSED, FAILED, None) or (code == PASSED and " passed" not in said):
        raise RuntimeError(f"fault '{fault.name}': its tests say nothing: {said}")
    return ("nothing" if code == PASSED else "tests"), said


def main(arguments: Sequence[str] | None = None) -> int:
    """Look for the faults that are named, or for all. Returns: the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.fresh_faults", description="What sees faults from the code.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults of the table; all unless said")
    parser.add_argument("--workers", type=int, default=2, help="how many are tried side by side")
    asked = parser.parse_args(arguments)
    table = {fault.name: fault for fault in faults()}
    if unknown := [name for name in asked.names if name not in table]:
        parser.error(f"no fault '{unknown[0]}', expected some of: {', '.join(table)}")
    others = [table[name] for name in asked.names or table if not table[name].check]
    if broken := tests_fail(others):
        print(*broken.values(), sep="\n")
        return 1
    chosen, counts, astray = [table[name] for name in asked.names or table], Counter[tuple[str, str]](), 0
    with ThreadPoolExecutor(asked.workers) as pool:
        for fault, (by, why) in zip(chosen, pool.map(seen, chosen), strict=True):
            counts[fault.kind, by] += 1
            astray += by != ("check" if fault.check else "tests")
            print(f"{fault.kind:8} {by:8} {fault.name}: {why}", flush=True)
    for kind in sorted({kind for kind, _ in counts}):
        print(kind, *(f"{by} {counts[kind, by]}" for by in ("check", "tests", "nothing")), sep=", ")
    return int(astray > 0)


if __name__ == "__main__":
    sys.exit(main())
