"""What the commands that read run folders cost as folders grow: `python -m tests.growth [TRIALS...] [--keep DIR]`.

For each number of trials (1000, 10 000 and 100 000 by default) a folder is written as in `tests.large_store`, and each command
is run on it once as a process of its own. Printed is its CPU time [s] with that of its children, and the peak memory [MB] of
the largest of its processes. `verify` and `run --resume` are left out where the study and its searches ask for more trials than
were written: there they tell of an unfinished run.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

SIZES = (1000, 10_000, 100_000)
MOST = 1200.0
"""Seconds that a command may take."""


def commands(folder: Path, out: Path) -> Iterator[tuple[str, list[str]]]:
    """By what it is called, each command's arguments."""
    for table in ("price", "trials"):
        yield f"show --table {table}", ["show", str(folder), "--table", table]
    yield "select", ["select", str(folder)]
    yield "diff", ["diff", str(folder), str(folder), "--out", str(out / "changes")]
    yield "merge", ["merge", str(folder), str(folder), "--out", str(out / "merged")]
    yield "report", ["report", str(folder)]
    if finished(folder):
        yield "verify", ["verify", str(folder)]
        yield "run --resume", ["run", str(folder / "study.toml"), "--out", str(folder), "--resume"]


def finished(folder: Path) -> bool:
    """Does a folder hold all that its study asks for?"""
    return bool(json.loads((folder / "machine.json").read_text())["complete"])


def measured(arguments: list[str], told: Path) -> tuple[float, float, int]:
    """CPU seconds, peak memory [MB] and exit code of a command, -9 if `MOST` ended it; `told` gets what it says."""
    with told.open("wb") as file:
        process = subprocess.Popen([sys.executable, "-m", "plumbline", *arguments], stdout=file, stderr=file)
        timer = subprocess.Popen(["sleep", str(MOST)])
        while True:
            ended, status, usage = os.wait4(-1, 0)
            if ended == process.pid:
                timer.kill()
                timer.wait()
                return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, os.waitstatus_to_exitcode(status)
            process.kill()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", nargs="*", type=int, default=SIZES)
    parser.add_argument("--keep", type=Path, help="Where the folders of these sizes are, or stay.")
    parser.add_argument("--only", default="", help="Commands whose name has this in it.")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        for size in given.trials:
            folder = (given.keep or Path(scratch)) / str(size)
            if not folder.exists():
                # Apart: a child's peak memory begins at that of the process which starts it.
                subprocess.run(
                    [sys.executable, "-m", "tests.large_store", str(size), "--keep", folder, "--no-report"], check=True
                )
            for name, arguments in commands(folder, Path(scratch)):
                if given.only not in name:
                    continue
                seconds, memory, code = measured(arguments, Path(scratch) / "told.txt")
                print(f"{size:>7}  {name:<20} {seconds:7.1f} s {memory:6.0f} MB  exit {code}", flush=True)
            for made in Path(scratch).iterdir():
                if made.is_dir() and made != folder:
                    shutil.rmtree(made)


if __name__ == "__main__":
    main()
