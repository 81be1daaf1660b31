"""Memory ends at each allocation in turn while a line is appended, until one runs through. For `test_failing_disk`.

Prints how many there were, and how many of them failed.
"""

import _testcapi
import sys
from pathlib import Path

from plumbline.harness.store.journal import Journal, read_written
from tests.unit.test_journal import record

ENOUGH = 10
"""Appends in a row that run through: the allocations that fail come after them, or are none."""

if __name__ == "__main__":
    folder, every = Path(sys.argv[1]), int(sys.argv[2])
    failed, through, number = 0, 0, 0
    while through < ENOUGH:
        number += every
        place = folder / str(number)
        place.mkdir()
        journal, entry = Journal(place), record("b")
        journal.append(record("a"))
        _testcapi.set_nomemory(number, number + 1)
        try:
            journal.append(entry)
        except MemoryError:
            failed, through = failed + 1, 0
        else:
            through += 1
        finally:
            _testcapi.remove_mem_hooks()
        journal.close()
        held = [*read_written(place / "journal.jsonl").records]
        if held not in (["a"], ["a", "b"]):
            raise SystemExit(f"allocation {number}: the journal holds {held}")
        again = Journal(place)
        if held == ["a"]:
            again.append(entry)
        again.close()
        if [*read_written(place / "journal.jsonl").records] != ["a", "b"]:
            raise SystemExit(f"allocation {number}: not completed")
    print(number - through * every, failed)
