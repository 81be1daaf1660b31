"""Faults of input: each is refused with exit code 2 and by name, before any work, on one screen, without a traceback."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from tests.stress.input_faults import BALL, FAULTS, many, names_the_file
from tests.stress.ledger import Page
from tests.stress.reading import Reading

ROOT = Path(__file__).parents[2]


Asked = tuple[str, list[str], Mapping[str, str]]
"""A name, arguments of the command line, variables of the environment."""
READ = (sys.executable, "-m", "tests.stress.reading")
LIGHTER = ("a million bodies", "65 MB")
"""Bombs that are refused for their bytes alone, before any of them is read."""
BOMBS = ("a million bodies with room", "a million bodies in TOML")


def answered(command: Sequence[str], calls: Sequence[Asked]) -> dict[str, Reading]:
    told = json.dumps(calls)
    done = subprocess.run([*command], cwd=ROOT, input=told, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return {name: Reading(**found) for name, found in map(json.loads, done.stdout.splitlines())}


def written(folder: Path, family: str, name: str) -> Asked:
    """A fault as a file, and how it is run."""
    fault = FAULTS[family, name]
    path = folder / f"file{[*FAULTS].index((family, name))}.{fault.ending}"
    if callable(fault.content):
        fault.content(path)
    else:
        path.write_bytes(fault.content if isinstance(fault.content, bytes) else fault.content.encode())
    return f"{family}: {name}", ["run", str(path), "--out", str(folder / "out"), *fault.options], fault.environment


PEAK = """
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], input=sys.stdin.read(), capture_output=True, text=True)
sys.stdout.write(done.stdout)
sys.stderr.write(f"{done.stderr}\\n{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024}")
sys.exit(done.returncode)
"""
"""A command, with the most memory [MB] that it held as the last line on standard error."""


@dataclass(frozen=True)
class Bomb:
    """What was said of a file, and the most memory [MB] of the process that read it and nothing else."""

    reading: Reading
    peak: float


@pytest.fixture(scope="module")
def bomb(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Bomb]:
    """What becomes of a bomb, each in a process of its own."""
    folder = tmp_path_factory.mktemp("bombs")

    @cache
    def thrown(name: str) -> Bomb:
        (family,) = (family for family, other in FAULTS if other == name)
        call = written(folder, family, name)
        command = [sys.executable, "-c", PEAK, *READ]
        done = subprocess.run(
            command, cwd=ROOT, input=json.dumps([call]), capture_output=True, text=True, timeout=280, check=False
        )
        assert done.returncode == 0, done.stderr[-2000:]
        return Bomb(Reading(**json.loads(done.stdout)[1]), float(done.stderr.splitlines()[-1]))

    return thrown


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
def readings(tmp_path_factory: pytest.TempPathFactory, bomb: Callable[[str], Bomb]) -> dict[str, Reading]:
    """What was said of each file and of each command without a folder: of bombs each in a process, of all others in one."""
    folder = tmp_path_factory.mktemp("input")
    calls = [written(folder, family, name) for family, name in FAULTS if name not in BOMBS]
    for number, (name, (content, ending)) in enumerate(SOUND.items()):
        path = folder / f"sound{number}.{ending}"
        path.write_text(content)
        options = ["--limit", "bodies=10"] if name == "a limit that is kept" else []
        calls.append((name, ["run", str(path), "--out", str(folder / "out"), *options], {}))
    nowhere = str(folder / "nowhere")
    calls += [(words[0], [word.replace("DIR", nowhere) for word in words], {}) for words in ABSENT]
    alone = {f"{family}: {name}": bomb(name).reading for family, name in FAULTS if name in BOMBS}
    return answered(READ, calls) | alone


@pytest.mark.parametrize(("family", "name"), FAULTS)
def test_a_fault_of_input_is_refused_by_name(family: str, name: str, readings: dict[str, Reading], ledger: Page) -> None:
    found, fault = readings[f"{family}: {name}"], FAULTS[family, name]
    assert found.ended == "refused", found.text[-500:]
    for word in fault.words:
        assert word in found.text
    if names_the_file(family, name):
        assert f"file{list(FAULTS).index((family, name))}.{fault.ending}" in found.text
    ledger.survived(f"input: {family}", name, f"exit code 2, {len(found.text)} characters, {1000 * found.seconds:.0f} ms")


def test_what_is_sound_is_read(readings: dict[str, Reading]) -> None:
    found = {name: readings[name] for name in SOUND}
    assert {name: reading.ended for name, reading in found.items()} == dict.fromkeys(SOUND, "accepted")
    # All that is said is which engines run it.
    assert not [line for reading in found.values() for line in reading.text.splitlines() if not line.endswith(": runs")]


SLOW = pytest.mark.slow


@pytest.mark.parametrize("what", [*BOMBS, *(pytest.param(what, marks=SLOW) for what in LIGHTER)])
def test_a_bomb_costs_no_memory(what: str, bomb: Callable[[str], Bomb], ledger: Page) -> None:
    """Less than 200 MB, in a process of its own. Its time is told, not asserted."""
    found = bomb(what)
    assert found.reading.ended == "refused"
    assert found.peak < 200.0
    ledger.survived("input: bombs", what, f"exit code 2 after {found.reading.seconds:.2f} s, {found.peak:.0f} MB")


@pytest.mark.parametrize("told", ["/dev/null", pytest.param(str(Path(__file__) / "y"), marks=SLOW)])
def test_a_folder_for_compiled_code_that_can_be_none_is_no_crash_of_the_engine(told: str, ledger: Page) -> None:
    command = [sys.executable, "-m", "harness.cli", "engines", "--json"]
    environment = os.environ | {"PLUMBLINE_KERNEL_CACHE": told}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=280, check=True)
    (row,) = [row for row in json.loads(done.stdout) if row["name"] == "reference"]
    assert row["unavailable"].startswith(f"PLUMBLINE_KERNEL_CACHE: {told!r}")
    ledger.survived("input: environment", f"PLUMBLINE_KERNEL_CACHE in {Path(told).name}", "unavailable, with the reason")


@pytest.mark.parametrize("arguments", ABSENT, ids=lambda told: told[0])
def test_a_missing_folder_is_wrong_usage(arguments: tuple[str, ...], readings: dict[str, Reading], ledger: Page) -> None:
    found = readings[arguments[0]]
    assert found.ended == "refused"
    assert "nowhere: no run folder" in found.text
    ledger.survived("input: folder", f"{arguments[0]} of a folder that is not there", "exit code 2")
