"""A process that has many mutants of files read by the command line, up to the first trial, and prints what became of them.

Arguments: the first seed, how many, seconds of processor time for each file, sound files. Prints a JSON object for each file.
"""

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from tests.stress.mutator import mutant
from tests.stress.reading import Reading, peak, read_by_command


def _trouble(path: Path, found: Reading) -> str:
    """What is wrong with how a mutant was read; '' where nothing is."""
    if found.ended == "refused" and path.name not in found.text:
        return "the file is not named"
    return "" if found.ended in ("refused", "accepted") else found.ended


def _all(sound: Path, first: int, count: int, budget: float) -> dict[str, Any]:
    totals: dict[str, Any] = {"refused": 0, "accepted": 0, "slowest": 0.0, "troubles": [], "tried": 0}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / sound.name
        arguments = ["run", str(path), "--out", str(Path(folder) / "out")]
        content = sound.read_bytes()
        if b"kinetic_friction" in content:  # below the static one: three engines know one number
            arguments.append("--one-friction")
        path.write_bytes(content)
        found = read_by_command(arguments)  # the first one imports everything
        if found.ended != "accepted":
            raise AssertionError(f"{sound}: {found.ended}: {found.text}")
        start = time.process_time()
        for seed in range(first, first + count):
            path.write_bytes(mutant(content, seed))
            found = read_by_command(arguments)
            totals["slowest"] = max(totals["slowest"], found.seconds)
            totals["tried"] += 1
            if trouble := _trouble(path, found):
                totals["troubles"].append(f"seed {seed}: {trouble}")
            else:
                totals[found.ended] += 1
            if time.process_time() - start > budget:
                break
    totals["peak"] = peak()
    return totals


if __name__ == "__main__":
    first, count, budget, *names = sys.argv[1:]
    for name in names:
        print(json.dumps(_all(Path(name), int(first), int(count), float(budget))))
