"""Is everything that users see of the catalogue and the command line still what it was, by its digest?

Numbers count by seven digits: sines and integrals of another processor differ from the ninth on.

After an intended change, write the digests anew with `PLUMBLINE_GOLDEN=write pytest tests/golden/test_record.py`;
`python -m tests.golden.record` before and after shows what changed.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

FILE = Path(__file__).parent / "record.json"
ROOT = Path(__file__).parents[2]
PRINTED = "import json; from tests.golden.record import of_no_run; print(json.dumps(dict(of_no_run())))"
"""In a process of its own: what other tests leave behind in one changes how help is printed."""
NUMBER = re.compile(r"-?\d+\.\d+(e[-+]?\d+)?")


def digest(text: str) -> str:
    """Of a text with its decimal numbers to seven digits."""
    return hashlib.sha256(NUMBER.sub(lambda number: f"{float(number[0]):.7g}", text).encode()).hexdigest()[:16]


def test_scenes_bounds_helps_errors_and_lists_are_exactly_what_they_were() -> None:
    done = subprocess.run([sys.executable, "-c", PRINTED], cwd=ROOT, capture_output=True, text=True, check=True)
    found = {name: digest(text) for name, text in json.loads(done.stdout).items()}
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        FILE.write_text(json.dumps(found, indent=1) + "\n")
    stored = json.loads(FILE.read_text())
    changed = sorted(name for name in stored.keys() | found.keys() if stored.get(name) != found.get(name))
    assert not changed, f"changed: {', '.join(changed)}"
    assert len(found) > 200
