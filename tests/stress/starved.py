"""Memory ends at the n-th allocation while a line is appended: prints what the journal then holds. For `test_failing_disk`."""

import _testcapi
import sys
from pathlib import Path

from harness.journal import Journal, read_written
from tests.unit.test_journal import record

if __name__ == "__main__":
    folder, first, last = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    failed = 0
    for number in range(first, last):
        place = folder / str(number)
        place.mkdir()
        journal, entry = Journal(place), record("b")
        journal.append(record("a"))
        _testcapi.set_nomemory(number, number + 1)
        try:
            journal.append(entry)
        except MemoryError:
            failed += 1
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
    print(failed)
