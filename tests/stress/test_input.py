"""Faults of input: each is refused with exit code 2 and by name, before any work, on one screen, without a traceback."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.stress.input_faults import BALL, FAULTS, many, names_the_file
from tests.stress.ledger import Page
from tests.stress.reading import Reading

ROOT = Path(__file__).parents[2]


Asked = tuple[str, list[str], Mapping[str, str], bool]
"""A name, arguments of the command line, variables of the environment; is it read in a process of its own?"""
LIGHTER = ("a million bodies", "65 MB")
"""Bombs that are refused for their bytes alone, before any of them is read."""
BOMBS = ("a million bodies with room", "a million bodies in TOML")
HEAVY = (
    *("message of megabytes", "key of megabytes", "100 000 troubles", "two million arrays"),
    *("a million bodies inline", "a million joints"),
)
"""Files that take long, with a smaller one of their kind beside each."""
SLOW = pytest.mark.slow


@dataclass(frozen=True)
class Found:
    """What was said of a file, and the most memory [MB] of the process that read it."""

    reading: Reading
    peak: float


def answered(calls: Sequence[Asked]) -> dict[str, Found]:
    command, told = [sys.executable, "-m", "tests.stress.reading"], json.dumps(calls)
    done = subprocess.run(command, cwd=ROOT, input=told, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return {name: Found(Reading(**found), peak) for name, found, peak in map(json.loads, done.stdout.splitlines())}


def written(folder: Path, family: str, name: str) -> Asked:
    """A fault as a file, and how it is run."""
    fault = FAULTS[family, name]
    path = folder / f"file{[*FAULTS].index((family, name))}.{fault.ending}"
    if callable(fault.content):
        fault.content(path)
    else:
        path.write_bytes(fault.content if isinstance(fault.content, bytes) else fault.content.encode())
    apart = name in (*LIGHTER, *BOMBS)
    return f"{family}: {name}", ["run", str(path), "--out", str(folder / "out"), *fault.options], fault.environment, apart


SOUND = {
    "a whole number for a mass": (BALL + "mass = 2", "toml"),
    "a number of 300 digits behind a point": (BALL + "mass = 0." + "3" * 300, "toml"),
    "dots within texts": ("# " + "a." * 500 + '\n[[bodies]]\nname = "' + "b." * 99 + 'b"', "toml"),
    "brackets within texts": ("# " + "[{" * 500 + '\n[[bodies]]\nname = "' + "[{" * 50 + '"', "toml"),
    "brackets within JSON texts": (json.dumps({"bodies": [{"name": '[{"\\' * 40}]}), "json"),
    "arrays 8 deep": (BALL + "inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "toml"),
    "a list of both kinds of quotes": ("[[bodies]]\nname = '''a\"'b'''\nmaterial = \"\"\"c'\"d\"\"\"", "toml"),
    "a thousand bodies": (many(1000), "json"),
    "a limit that is kept": (many(10), "json"),
}
"""Files that are none of these."""
ABSENT = [("show", "DIR"), ("report", "DIR"), ("view", "DIR", "x"), ("serve", "DIR"), ("reproduce", "DIR", "x")]
"""Commands on a folder that is not there."""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Found]:
    """What was said of each file and of each command without a folder, all asked of one process; of heavy files when asked for.

    Bombs are read behind the first file, which has what reads files loaded, and before anything takes memory.
    """
    folder = tmp_path_factory.mktemp("input")
    first, *others = [written(folder, family, name) for family, name in FAULTS if name not in HEAVY]
    calls = [first, *sorted(others, key=lambda call: not call[-1])]
    for number, (name, (content, ending)) in enumerate(SOUND.items()):
        path = folder / f"sound{number}.{ending}"
        path.write_text(content)
        options = ["--limit", "bodies=10"] if name == "a limit that is kept" else []
        calls.append((name, ["run", str(path), "--out", str(folder / "out"), *options], {}, False))
    nowhere = str(folder / "nowhere")
    calls += [(words[0], [word.replace("DIR", nowhere) for word in words], {}, False) for words in ABSENT]
    answers = answered(calls)

    def of(name: str) -> Found:
        if name not in answers:
            (fault,) = (fault for fault in FAULTS if ": ".join(fault) == name)
            answers.update(answered([written(folder, *fault)]))
        return answers[name]

    return of


@pytest.mark.parametrize(
    ("family", "name"), [pytest.param(*fault, marks=[SLOW] if fault[1] in HEAVY else []) for fault in FAULTS]
)
def test_a_fault_of_input_is_refused_by_name(family: str, name: str, found: Callable[[str], Found], ledger: Page) -> None:
    read, fault = found(f"{family}: {name}").reading, FAULTS[family, name]
    assert read.ended == "refused", read.text[-500:]
    for word in fault.words:
        assert word in read.text
    if names_the_file(family, name):
        assert f"file{list(FAULTS).index((family, name))}.{fault.ending}" in read.text
    ledger.survived(f"input: {family}", name, f"exit code 2, {len(read.text)} characters, {1000 * read.seconds:.0f} ms")


def test_what_is_sound_is_read(found: Callable[[str], Found]) -> None:
    read = {name: found(name).reading for name in SOUND}
    assert {name: reading.ended for name, reading in read.items()} == dict.fromkeys(SOUND, "accepted")
    # All that is said is which engines run it.
    assert not [line for reading in read.values() for line in reading.text.splitlines() if not line.endswith(": runs")]


@pytest.mark.parametrize("what", [*BOMBS, *(pytest.param(what, marks=SLOW) for what in LIGHTER)])
def test_a_bomb_costs_no_memory(what: str, found: Callable[[str], Found], ledger: Page) -> None:
    """Less than 200 MB, in a process of its own. Its time is told, not asserted."""
    (family,) = (family for family, other in FAULTS if other == what)
    bomb = found(f"{family}: {what}")
    assert bomb.reading.ended == "refused"
    assert bomb.peak < 200.0
    ledger.survived("input: bombs", what, f"exit code 2 after {bomb.reading.seconds:.2f} s, {bomb.peak:.0f} MB")


@pytest.mark.parametrize("told", ["/dev/null", pytest.param(str(Path(__file__) / "y"), marks=SLOW)])
def test_a_folder_for_compiled_code_that_can_be_none_is_no_crash_of_the_engine(told: str, ledger: Page) -> None:
    command = [sys.executable, "-m", "plumbline", "engines", "--json"]
    environment = os.environ | {"PLUMBLINE_KERNEL_CACHE": told}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=280, check=True)
    (row,) = [row for row in json.loads(done.stdout) if row["name"] == "reference"]
    assert row["unavailable"].startswith(f"PLUMBLINE_KERNEL_CACHE: {told!r}")
    ledger.survived("input: environment", f"PLUMBLINE_KERNEL_CACHE in {Path(told).name}", "unavailable, with the reason")


@pytest.mark.parametrize("arguments", ABSENT, ids=lambda told: told[0])
def test_a_missing_folder_is_wrong_usage(arguments: tuple[str, ...], found: Callable[[str], Found], ledger: Page) -> None:
    read = found(arguments[0]).reading
    assert read.ended == "refused"
    assert "nowhere: no run folder" in read.text
    ledger.survived("input: folder", f"{arguments[0]} of a folder that is not there", "exit code 2")
