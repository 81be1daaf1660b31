"""Faults of one line, each planted in a copy of the tree: do the tests that should see it fail?

    python -m tests.mutants [NAME...] [--workers N] [--list]

The table is `tests/mutants.toml`. A mutant is killed where its tests fail, or do not come to an end; it survives where they
pass. Its tests must pass without it, or their failing would say nothing, so those are run first, in a copy as well. Exit
code 1: some mutant survives, or has no verdict (its text is not found exactly once, its tests cannot be run or fail anyway).
"""

import argparse
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic

__all__ = ["FAILED", "PASSED", "Mutant", "copied", "main", "mutants", "planted", "tested"]

ROOT = Path(__file__).resolve().parents[1]
TABLE = Path(__file__).with_suffix(".toml")
CARRIED = (
    "harness",
    "adapters",
    "cases",
    "reports",
    "engine",
    "src",
    "tests",
    "docs",
    "examples",
    "findings",
    "pyproject.toml",
    "README.md",
    "CONTRIBUTING.md",
)
LONGEST = 600.0
"""Seconds until tests count as not coming to an end: twice the longest that one of them may take."""
PASSED, FAILED = 0, 1
"""Exit codes of pytest; all others mean that it could not run what it was asked to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """One fault.

    Terms:
        file: under the root of the tree. old, new: text that stands there exactly once, and what takes its place.
        tests: node ids of pytest that should see it. plain: run them with the engine as plain Python, which saves compiling it.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    plain: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a mutant: 'killed', 'survived' or 'no verdict'; why, and after how many seconds."""

    mutant: Mutant
    outcome: str
    why: str
    seconds: float


def mutants(table: Path = TABLE) -> tuple[Mutant, ...]:
    """All of the table."""
    rows = tomllib.loads(table.read_text(encoding="utf-8"))["mutant"]
    return tuple(Mutant(**{**row, "tests": tuple(row["tests"])}) for row in rows)


def planted(mutant: Mutant) -> str:
    """The file of a mutant with its fault in it. Raises: ValueError where the old text is not there exactly once."""
    text = (ROOT / mutant.file).read_text(encoding="utf-8")
    count = text.count(mutant.old)
    if count != 1 or mutant.old == mutant.new:
        raise ValueError(f"mutant '{mutant.name}': {mutant.file} holds its old text {count} times, expected once and changed")
    return text.replace(mutant.old, mutant.new)


@contextmanager
def copied() -> Iterator[Path]:
    """A copy of the tree that is gone afterwards."""
    with TemporaryDirectory(prefix="mutant-") as folder:
        tree = Path(folder) / "tree"
        tree.mkdir()
        for name in CARRIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, tree / name, symlinks=True)
            else:
                shutil.copy2(ROOT / name, tree / name)
        yield tree


def tested(tree: Path, tests: Sequence[str], plain: bool, cache: Path | None) -> tuple[int | None, str]:
    """The exit code of pytest in a tree, None where it came to no end, and the last lines of what it said."""
    environment = {**os.environ, "PYTHONPATH": f"{tree / 'src'}:{tree}", "PYTHONDONTWRITEBYTECODE": "1"}
    environment |= {"NUMBA_DISABLE_JIT": "1"} if plain else {}
    environment |= {"PLUMBLINE_KERNEL_CACHE": str(cache)} if cache is not None else {}
    command = [sys.executable, "-m", "pytest", "-x", "--no-header", "--tb=line", *tests]
    process = subprocess.Popen(
        command, cwd=tree, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    try:
        said = process.communicate(timeout=LONGEST)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.communicate()
        return None, f"no end within {LONGEST:g} s"
    return process.returncode, " / ".join(said.strip().splitlines()[-3:])


def judged(mutant: Mutant) -> Verdict:
    """Plant a mutant in a copy of the tree and run its tests there."""
    begun = monotonic()
    try:
        text = planted(mutant)
    except (OSError, ValueError) as error:
        return Verdict(mutant, "no verdict", str(error), 0.0)
    with copied() as tree:
        (tree / mutant.file).write_text(text, encoding="utf-8")
        # What is compiled of a mutant is of no use to anybody later: it goes with the copy.
        cache = tree.parent / "kernels" if mutant.file.startswith("engine/") else None
        code, said = tested(tree, mutant.tests, mutant.plain, cache)
    outcome = {PASSED: "survived", FAILED: "killed", None: "killed"}.get(code, "no verdict")
    if code == PASSED and " passed" not in said:
        outcome, said = "no verdict", f"all its tests were skipped: {said}"
    return Verdict(mutant, outcome, said, monotonic() - begun)


def sound(chosen: Sequence[Mutant]) -> Mapping[bool, str]:
    """Why the tests of the mutants fail without any, with and without compiling; empty where all of them pass."""
    found: dict[bool, str] = {}
    for plain in (False, True):
        tests = list(dict.fromkeys(test for mutant in chosen if mutant.plain == plain for test in mutant.tests))
        if tests:
            with copied() as tree:
                code, said = tested(tree, tests, plain, None)
            if code != PASSED:
                found[plain] = said
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge the mutants that are named, or all. Returns: the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description="Faults of one line that tests have to see.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="mutants of the table; all unless said")
    parser.add_argument("--workers", type=int, default=2, help="how many are tried side by side")
    parser.add_argument("--list", action="store_true", help="name them and end")
    asked = parser.parse_args(arguments)
    known = {mutant.name: mutant for mutant in mutants()}
    unknown = [name for name in asked.names if name not in known]
    if unknown:
        parser.error(f"no mutant '{unknown[0]}', expected some of: {', '.join(known)}")
    chosen = [known[name] for name in asked.names or known]
    if asked.list:
        print(*(f"{mutant.name}  {mutant.file}" for mutant in chosen), sep="\n")
        return 0
    if broken := sound(chosen):
        print(*(f"without a mutant{' (plain Python)' if plain else ''}: {said}" for plain, said in broken.items()), sep="\n")
        return 1
    spared = []
    with ThreadPoolExecutor(asked.workers) as pool:
        for verdict in pool.map(judged, chosen):
            print(f"{verdict.outcome:10} {verdict.mutant.name}  ({verdict.mutant.file}, {verdict.seconds:.0f} s)", flush=True)
            if verdict.outcome != "killed":
                spared.append(verdict)
                print(f"           {verdict.why}", flush=True)
    print(f"{len(chosen) - len(spared)} of {len(chosen)} mutants killed")
    return 1 if spared else 0


if __name__ == "__main__":
    sys.exit(main())
