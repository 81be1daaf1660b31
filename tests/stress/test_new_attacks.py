"""Attacks on the newest code: logs of joints, links in a run folder, the dataset, Python, pytest, fork servers, clusters.

Each ends in a refusal that names what is wrong, or with the result of an undisturbed run, and nothing outside is touched.
"""

import io
import json
import os
import resource
import shutil
import signal
import stat
import struct
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from errno import ENOLCK, ENOSPC
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.harness.case.undropped import OWN
from plumbline.harness.findings.tables.recorded import joint_errors
from plumbline.harness.intake import user_cache
from plumbline.harness.intake.error import PlumblineError, RobotError
from plumbline.harness.run.cluster.cells import Answered
from plumbline.harness.run.cluster.workplace import _stored
from plumbline.harness.run.fork_servers import Origin
from plumbline.harness.run.fork_servers import start as start_process
from plumbline.harness.scene.importers.replay import read_log
from plumbline.harness.store import disk, journal
from plumbline.harness.store.imported_scenes import states_of
from plumbline.harness.store.journal import DamagedFile, StoreError
from plumbline.harness.store.published import publish, published
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import Store
from tests.conftest import PLUGINS
from tests.light_servers import light_servers
from tests.stress.ledger import Page
from tests.stress.light_run import carry_out, light
from tests.stress.test_attacks import called, ends_in_a_line
from tests.told_by_processes import end, tamper

ROOT = Path(__file__).parents[2]
DYING = PLUGINS.with_name("dying_plugins")
ARM = ROOT / "examples" / "arm.urdf"


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("sound") / "run"
    with pytest.MonkeyPatch.context() as patch:
        light(patch)
        carry_out(folder)
        yield folder


@pytest.fixture
def folder(sound: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(sound, tmp_path / "run"))


# Logs of joints.


def member(shape: str, content: bytes = b"\0" * 16) -> bytes:
    """An array of doubles as npz files hold it, with this for its shape."""
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".encode()
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + content


def npz(**members: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(f"{name}.npy", content)
    return stream.getvalue()


def patched(content: bytes, local: tuple[int, bytes], central: tuple[int, bytes]) -> bytes:
    """Bytes of every local and central head of a zip file changed."""
    changed = bytearray(content)
    for mark, (offset, value) in ((b"PK\x03\x04", local), (b"PK\x01\x02", central)):
        place = content.find(mark)
        while place >= 0:
            changed[place + offset : place + offset + len(value)] = value
            place = content.find(mark, place + 4)
    return bytes(changed)


def garbled() -> bytes:
    """The packed bytes behind the first head are no packed bytes."""
    content = bytearray(npz(time=member("(2,)"), hip=member("(2,)")))
    place = 30 + len("time.npy")
    content[place : place + 8] = b"\xff" * 8
    return bytes(content)


SOUND = npz(time=member("(2,)"), hip=member("(2,)"))
LOGS: dict[str, bytes] = {
    "an array of ten million million numbers": npz(time=member("(10000000000000,)"), hip=member("(2,)")),
    "a shape that nests": npz(time=member(f"{'-' * 5000}1"), hip=member("(2,)")),
    "a shape below zero": npz(time=member("(-5,)"), hip=member("(2,)")),
    "parts under a password": patched(SOUND, (6, b"\x01\x00"), (8, b"\x01\x00")),
    "parts packed in a way that is none": patched(SOUND, (8, b"\x63\x00"), (10, b"\x63\x00")),
    "packed bytes that are none": garbled(),
    "an archive without an array": npz(),
    "a folder of entries that points beyond": SOUND[:-6] + b"\xff\xff\xff\x7f\0\0",
}


@pytest.mark.parametrize("name", LOGS)
def test_a_log_of_an_enemy_is_refused_by_name(name: str, tmp_path: Path, ledger: Page) -> None:
    (path := tmp_path / "log.npz").write_bytes(LOGS[name])
    with pytest.raises(RobotError, match=r"log\.npz: "):
        read_log(path)
    ledger.survived("new attack: log of joints", name, "refused by name")


@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_a_log_that_is_a_pipe_keeps_nobody_waiting(ending: str, tmp_path: Path, ledger: Page) -> None:
    os.mkfifo(path := tmp_path / f"log.{ending}")
    refused: list[str] = []

    def read() -> None:
        try:
            read_log(path)
        except RobotError as error:
            refused.append(str(error))

    reading = threading.Thread(target=read, daemon=True)
    reading.start()
    reading.join(30)
    assert refused
    assert f"log.{ending}" in refused[0]
    ledger.survived("new attack: log of joints", f"a pipe called {ending}", "refused by name")


WHERE = ("--root", "fixed", "--out")
ROBOT = """<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
</inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
</link><joint name="hip" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint></robot>"""
COMMANDS = {
    "times from the least to the largest number": ("time,hip:torque\n-1e308,0\n1e308,0\n", ()),
    "a torque of 1e308": ("time,hip:torque\n0,1e308\n1,1e308\n", ()),
    "a velocity that overflows under its damping": ("time,hip:velocity\n0,1e300\n1,1e300\n", ("--gains", "0,1e50")),
    "a gain that is not a number": ("time,hip\n0,0\n1,1\n", ("--gains", "nan,1")),
    "steps of a billionth for a year": ("time,hip:torque\n0,1\n3e7,1\n", ("--dt", "1e-9")),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_of_an_enemy_are_refused_before_anything_is_kept(name: str, tmp_path: Path, ledger: Page) -> None:
    text, words = COMMANDS[name]
    (tmp_path / "r.urdf").write_text(ROBOT)
    (tmp_path / "log.csv").write_text(text)
    done = called("run", tmp_path / "r.urdf", "--commands", tmp_path / "log.csv", *words, *WHERE, tmp_path / "out")
    ends_in_a_line(done)
    assert done.exit_code == 2, done.output
    assert not (tmp_path / "out").exists()
    ledger.survived("new attack: commands", name, "exit code 2 before anything is kept")


# The folder of a colleague.

VICTIM = {"notes.txt": b"dear diary", ".bashrc.1": b"alias", ".notes.toml.77": b"draft", f"{'a' * 24}.npz": b"an archive"}


@pytest.fixture
def victim(tmp_path: Path) -> Iterator[Path]:
    """A folder beside, of which nothing may be lost and to which nothing may be added."""
    (beside := tmp_path / "home").mkdir()
    for name, content in VICTIM.items():
        (beside / name).write_bytes(content)
    yield beside
    assert {path.name: path.read_bytes() for path in beside.iterdir()} == VICTIM


@pytest.mark.parametrize("name", ["truths", "trajectories", "recordings", "scenes", "logs"])
def test_a_folder_that_is_a_link_is_not_gone_on_with(
    name: str, folder: Path, victim: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    """A resume takes drafts and damaged truths away: not those of who is lent the folder."""
    light(monkeypatch)
    shutil.rmtree(folder / name, ignore_errors=True)
    (folder / name).symlink_to(victim)
    with pytest.raises(StoreError, match=f"{name}: is a link"):
        carry_out(folder)
    ledger.survived("new attack: run folder", f"{name} is a link, --resume", "refused by name, nothing lost there")


def test_a_report_is_not_written_through_a_link(folder: Path, victim: Path, ledger: Page) -> None:
    for name in ("report", f".report.{os.getpid()}", f".report.{os.getpid()}.old"):
        (folder / name).symlink_to(victim)
    done = called("report", folder)
    ends_in_a_line(done)
    assert done.exit_code == 0, done.stderr
    assert (folder / "report" / "index.html").is_file()
    assert not [path for path in folder.iterdir() if path.is_symlink()]
    ledger.survived("new attack: run folder", "report and its drafts are links", "replaced, nothing written there")


def test_a_draft_that_is_a_link_is_not_written_through(folder: Path, victim: Path, ledger: Page) -> None:
    """Whoever may write to the folder can foresee the number of the process."""
    for name in ("summary.md", "junit.xml", "machine.json", "study.toml", "catalogue.json"):
        (folder / f".{name}.{os.getpid()}").symlink_to(victim / "notes.txt")
    with pytest.raises(OSError, match="symbolic link"):
        disk.write_atomically(folder / "summary.md", b"mine")
    user_cache.keep(folder / "summary.md", b"mine")
    ledger.survived("new attack: run folder", "drafts are links", "refused, nothing written there")


def test_a_journal_that_is_a_link_is_not_grown(
    folder: Path, victim: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    light(monkeypatch)
    (folder / "journal.jsonl").unlink()
    (folder / "journal.jsonl").symlink_to(victim / "notes.txt")
    with pytest.raises(StoreError, match=r"journal\.jsonl"):
        carry_out(folder)
    ledger.survived("new attack: run folder", "the journal is a link", "refused by name")


def states(**changes: Any) -> dict[str, Any]:
    return {"source": "log.csv", "time": [0.0, 1.0], "positions": {"hip": [0.0, 1.0]}} | changes


STATES: dict[str, dict[str, Any]] = {
    "times that fall": states(time=[1.0, 0.0]),
    "times that are words": states(time=["a", "b"]),
    "no times": states(time=[]),
    "fewer positions than times": states(positions={"hip": [0.0]}),
    "positions that are a list": states(positions=[0.0, 1.0]),
    "positions that are no numbers": states(positions={"hip": [{}, None]}),
    "nothing but a source": {"source": "log.csv"},
    "a source that is a number": states(source=3),
}


@pytest.mark.parametrize("name", STATES)
def test_states_of_an_enemy_are_refused_by_name(name: str, tmp_path: Path, ledger: Page) -> None:
    (directory := tmp_path / "scenes" / "abc").mkdir(parents=True)
    (directory / "states.json").write_bytes(sealed_json("states.json", STATES[name]))
    with pytest.raises(DamagedFile, match=r"states\.json"):
        states_of(tmp_path, f"{OWN}scenes/abc/r.toml")
    ledger.survived("new attack: run folder", f"states with {name}", "refused by name")


def test_a_states_file_beside_another_robot_has_no_rows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, ledger: Page) -> None:
    """A joint that the scene does not have is compared with nothing."""
    from types import SimpleNamespace

    from plumbline.harness.findings.tables import recorded

    scene = plumbline.load(ARM, root="fixed")
    agreement = SimpleNamespace(case=f"{OWN}scenes/abc/r.toml", scene=scene, sides=[])
    run = SimpleNamespace(time=np.linspace(0, 1, 5))
    rung = SimpleNamespace(run=run, trial="t")
    agreement.sides.append(SimpleNamespace(engine="e", track="t", limit=SimpleNamespace(finest=rung)))
    (directory := tmp_path / "scenes" / "abc").mkdir(parents=True)
    (directory / "states.json").write_bytes(sealed_json("states.json", states(positions={"nobody": [0.0, 1.0]})))
    monkeypatch.setattr(recorded, "agreements", lambda _: [agreement])
    store: Any = SimpleNamespace(folder=tmp_path)
    with pytest.raises(StoreError, match="nobody"):
        joint_errors.__wrapped__(store)
    ledger.survived("new attack: run folder", "states of a joint that is none", "refused by name")


# The dataset.


def test_a_dataset_is_not_written_over_the_run_that_it_is_made_of(folder: Path, ledger: Page) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    done = called("publish", folder, "--out", folder)
    ends_in_a_line(done)
    assert done.exit_code in (2, 3)
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    ledger.survived("new attack: dataset", "published into its own run folder", "refused, the run is whole")


def test_a_dataset_is_not_written_over_another_run(folder: Path, sound: Path, ledger: Page) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    done = called("publish", sound, "--out", folder)
    ends_in_a_line(done)
    assert done.exit_code in (2, 3)
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    ledger.survived("new attack: dataset", "published over another run", "refused, that run is whole")


def test_a_disk_that_is_full_amid_a_dataset_leaves_the_old_one_or_one_that_says_so(
    sound: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    publish(Store(sound), tmp_path / "set")
    calls, fails_at = 0, 0
    usual = disk.Calls.write

    def write(self: disk.Calls, descriptor: int, content: memoryview) -> int:
        nonlocal calls
        calls += 1
        if calls == fails_at:
            raise OSError(ENOSPC, os.strerror(ENOSPC))
        return usual(self, descriptor, content)

    monkeypatch.setattr(disk.Calls, "write", write)
    for fails_at in range(1, 7):  # noqa: B007  # read by `write`
        calls = 0
        with pytest.raises(OSError, match="No space left"):
            publish(Store(sound), tmp_path / "set")
        with suppress(StoreError):
            assert len(published(tmp_path / "set").trials) == 2
    ledger.survived("new attack: dataset", "a disk full at each of its files", "the old one, or damaged by name")


# Python.

NUMBERS: dict[str, dict[str, Any]] = {
    "a duration that is not a number": {"duration": float("nan")},
    "a duration without end": {"duration": float("inf")},
    "a duration of nothing": {"duration": 0.0},
    "a step of the least number": {"dt": 5e-324},
    "a step that is not a number": {"dt": float("nan")},
    "a deadline that is not a number": {"deadline": float("nan")},
    "a deadline below zero": {"deadline": -1.0},
    "memory that is not a number": {"memory": float("nan")},
    "memory below zero": {"memory": -5.0},
}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_of_an_enemy_is_refused_by_its_name(name: str, ledger: Page) -> None:
    with pytest.raises(PlumblineError, match=next(iter(NUMBERS[name]))):
        plumbline.run(ARM, "mujoco", root="fixed", **NUMBERS[name])
    ledger.survived("new attack: Python", name, "refused by its name")


NAMES: dict[str, Callable[[Path], object]] = {
    "an engine from above": lambda _: plumbline.run("flight_box", "../mujoco"),
    "a case from above": lambda _: plumbline.run("../flight_box", "mujoco"),
    "an empty name of a folder": lambda _: plumbline.compare("quick", ["mujoco"], cases=["flight_box"], out=""),
    "a byte of zero in a folder": lambda _: plumbline.open("a\0b"),
    "a byte of zero in a file": lambda _: plumbline.run("a\0b.urdf"),
    "a folder that is a pipe": lambda path: plumbline.open(_pipe(path / "pipe")),
    "a name of ten thousand letters": lambda _: plumbline.open("x" * 10_000),
    "a scene that is a folder": lambda path: plumbline.run(_made(path / "a.toml")),
    "a table from above": lambda _: plumbline.published().table("../trials"),
}


def _pipe(path: Path) -> Path:
    os.mkfifo(path)
    return path


def _made(path: Path) -> Path:
    path.mkdir()
    return path


@pytest.mark.parametrize("name", NAMES)
def test_a_name_of_an_enemy_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    monkeypatch.chdir(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    with pytest.raises(PlumblineError):
        NAMES[name](tmp_path)
    assert {path.name for path in tmp_path.iterdir()} - before <= {"pipe", "a.toml"}
    ledger.survived("new attack: Python", name, "refused")


GONE = """
import os, sys, tempfile
import plumbline
folder = tempfile.mkdtemp()
os.chdir(folder)
os.rmdir(folder)
run = plumbline.run(sys.argv[1], "dart", 0.1, root="fixed")
print(run.status, len(run.time))
"""


def test_a_present_folder_that_is_gone_hinders_no_run(ledger: Page) -> None:
    done = subprocess.run([sys.executable, "-c", GONE, str(ARM)], capture_output=True, text=True, timeout=280, check=False)
    assert done.stdout.startswith("finite"), done.stderr
    listed = subprocess.run(
        ["bash", "-c", f'd=$(mktemp -d); cd $d; rmdir $d; exec "{sys.executable}" -m plumbline run quick'],
        capture_output=True, text=True, timeout=280, check=False,
    )  # fmt: skip
    assert listed.returncode in (2, 3)
    assert "Traceback" not in listed.stderr
    ledger.survived("new attack: Python", "the present folder is gone", "runs; the command says it")


def test_threads_run_scenes_at_once(tmp_path: Path, ledger: Page) -> None:
    with ThreadPoolExecutor(4) as threads:
        runs = list(threads.map(lambda _: plumbline.run(ARM, "mujoco", 0.05, root="fixed"), range(8)))
    assert {run.status for run in runs} == {"finite"}
    assert all(np.array_equal(run.positions, runs[0].positions) for run in runs)
    ledger.survived("new attack: Python", "four threads at once", "eight runs, the same bits")


def test_a_full_disk_under_temporary_files_is_said(monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    def full(*_: object, **__: object) -> str:
        raise OSError(ENOSPC, os.strerror(ENOSPC))

    monkeypatch.setattr("tempfile.mkdtemp", full)
    with pytest.raises((PlumblineError, OSError), match="No space left"):
        plumbline.run(ARM, "mujoco", 0.05, root="fixed")
    ledger.survived("new attack: Python", "no room for temporary files", "said")


# pytest.


def asked(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    plugin = ["-p", "plumbline.pytest_plugin", "-p", "no:cacheprovider"]
    folders = os.pathsep.join((str(PLUGINS), str(DYING)))
    variables = os.environ | {"PYTHONPATH": folders, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "COLUMNS": "200"}
    command = [sys.executable, "-m", "pytest", *plugin, *words]
    return subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, timeout=280, check=False)


def test_an_engine_that_ends_the_process_fails_its_check_and_no_other(tmp_path: Path, ledger: Page) -> None:
    """Exit code 0 without a word would be a green build."""
    words = ("--plumbline", "leaves_build", "-m", "tuned and conformance", "-k", "sign_of_g or version_is_a_string")
    done = asked(tmp_path, *words)
    assert done.returncode == 1, (done.returncode, done.stdout, done.stderr)
    assert "1 failed, 1 passed" in done.stdout
    assert "ended with exit code 0" in done.stdout
    ledger.survived("new attack: pytest", "an engine that ends the process", "its check failed, the others are asked")


@pytest.mark.parametrize("name", ["a pipe", "a folder", "no end"])
def test_known_failures_of_an_enemy_are_refused(name: str, tmp_path: Path, ledger: Page) -> None:
    file = tmp_path / "known.txt"
    if name == "no end":
        file.symlink_to("/dev/zero")
    else:
        (os.mkfifo if name == "a pipe" else os.mkdir)(file)
    done = asked(tmp_path, "--plumbline", "sound", "--plumbline-known", "known.txt", "--collect-only", "-q")
    assert done.returncode == 4
    assert "known.txt: is " in done.stderr
    ledger.survived("new attack: pytest", f"known failures that are {name}", "a usage error")


# Fork servers.


@pytest.fixture
def servers() -> Iterator[None]:
    with light_servers():
        yield


@pytest.mark.parametrize("how", ["writes into every pipe", "takes its files", "closes everything"])
def test_an_engine_that_tampers_with_its_server_costs_its_own_run_alone(how: str, servers: None, ledger: Page) -> None:
    bystander = start_process(Origin(), tamper, "waits")
    hostile = start_process(Origin(), tamper, how)
    hostile.join(60.0)
    after = [start_process(Origin(), end, code) for code in (0, 7, 255)]
    assert all(process.join(60.0) for process in after)
    assert [process.code for process in after] == [0, 7, 255]
    bystander.kill()
    assert bystander.join(60.0)
    assert bystander.lost or bystander.code == -signal.SIGKILL
    ledger.survived("new attack: fork servers", f"an engine that {how}", "other processes lost 0, none misjudged")


def test_a_server_with_few_descriptors_serves_on(servers: None, ledger: Page) -> None:
    """Forty processes at once where twenty descriptors are allowed: some cannot be had, and the server lives."""
    first = start_process(Origin(), end, 0)
    assert first.join(60.0)
    resource.prlimit(first.server, resource.RLIMIT_NOFILE, (24, 24))
    held = []
    for _ in range(40):
        try:
            held.append(start_process(Origin(), tamper, "waits"))
        except (ConnectionError, OSError):
            break
    for process in held:
        process.kill()
    assert all(process.join(60.0) for process in held)
    last = start_process(Origin(), end, 7)
    assert last.join(60.0)
    assert last.code == 7
    ledger.survived("new attack: fork servers", "few descriptors", "each order is answered or refused")


# Clusters.


class _Cell:
    trial = "abc"


@pytest.mark.parametrize("place", ["../outside.txt", "{}/outside.txt", "logs/../../outside.txt", "machine.json", "logs/.a.1"])
def test_a_worker_that_answers_with_a_file_elsewhere_is_refused(place: str, tmp_path: Path, ledger: Page) -> None:
    (folder := tmp_path / "run").mkdir()
    cell: Any = _Cell()
    with pytest.raises(StoreError, match="a worker"):
        _stored(Answered({}, {place.format(tmp_path): b"mine"}), cell, folder)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
    ledger.survived("new attack: cluster", f"a file at {place}", "refused by name")


# Other users, and disks that are far away.


def test_a_mask_that_hides_nothing_leaves_a_cache_that_is_taken_over(tmp_path: Path, ledger: Page) -> None:
    before = os.umask(0)
    try:
        user_cache.keep(tmp_path / "cache" / "pieces" / "a", b"corners")
    finally:
        os.umask(before)
    assert user_cache.read_kept(tmp_path / "cache" / "pieces" / "a") == b"corners"
    assert not (tmp_path / "cache" / "pieces" / "a").stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    ledger.survived("new attack: other users", "a umask of 0", "nobody else may write")


def test_a_journal_where_no_locks_can_be_had_says_so(folder: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    light(monkeypatch)

    def none(*_: object) -> None:
        raise OSError(ENOLCK, os.strerror(ENOLCK))

    monkeypatch.setattr(journal.fcntl, "flock", none)
    with pytest.raises((StoreError, OSError), match="No locks available"):
        carry_out(folder)
    ledger.survived("new attack: network disk", "no locks for the journal", "said")


def test_names_that_a_network_disk_leaves_are_passed_over(folder: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    """A file that is open while it is removed lives on as .nfs..., until it is closed."""
    light(monkeypatch)
    for place in (folder, folder / "trajectories"):
        (place / ".nfs000000000123").write_bytes(b"half")
    store = carry_out(folder)
    assert len(store.trials) == 2
    done = called("show", folder, "--format", "json")
    assert done.exit_code == 0
    assert len(json.loads(done.stdout)) == 2
    ledger.survived("new attack: network disk", "names that removed files leave", "passed over")
