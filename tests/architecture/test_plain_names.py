"""Do variables say what they hold? Names that could be anything are counted, and each count may only fall.

After some have been renamed, write the lower counts: `PLUMBLINE_GOLDEN=write pytest tests/architecture/test_plain_names.py`.
"""

import ast
import json
import os
import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILE = Path(__file__).with_name("vague_names.json")
VAGUE = ("place", "one", "made", "way", "known", "kept", "found", "told", "asked", "said", "part", "here")


def names_of(text: str) -> Counter[str]:
    """How often each vague name is given to a variable, an argument or a field."""
    counts: Counter[str] = Counter()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            counts[node.id] += 1
        elif isinstance(node, ast.arg):
            counts[node.arg] += 1
    return Counter({name: counts[name] for name in VAGUE if counts[name]})


def in_all() -> dict[str, int]:
    """The counts in everything but tests."""
    files = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    counts = sum(
        (names_of((ROOT / name).read_text(encoding="utf-8")) for name in files if not name.startswith("tests/")), Counter()
    )
    return {name: counts[name] for name in VAGUE}


def test_vague_names_become_fewer() -> None:
    counts, allowed = in_all(), json.loads(FILE.read_text())
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        allowed = {name: min(count, allowed[name]) for name, count in counts.items()}
        FILE.write_text(json.dumps(allowed, indent=1) + "\n")
    assert set(allowed) == set(VAGUE)
    more = {name: (count, allowed[name]) for name, count in counts.items() if count > allowed[name]}
    assert not more, f"more than there were (now, then): {more}; say what the variable holds"
    fewer = {name: (count, allowed[name]) for name, count in counts.items() if count < allowed[name]}
    assert not fewer, f"fewer than there were (now, then): {fewer}; write the lower counts down"


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("one = 1", 1),
        ("for one, part in pairs: pass", 2),
        ("def f(known): return known", 1),
        ("class A:\n    kept: int\n", 1),
        ("one.part = here(said)", 0),
    ],
)
def test_variables_arguments_and_fields_are_counted_and_uses_are_not(text: str, count: int) -> None:
    assert names_of(text).total() == count
