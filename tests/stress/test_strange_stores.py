"""Run folders of strangers: their checksums are right, and what they say is not; empty ones, links, pipes, and parts to merge.

Whoever writes a folder can work out its checksums. Each command then says in a line what is wrong with it, or works.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from plumbline.harness.cli.main import main
from plumbline.harness.run.campaign import carry_out as carry_out_study
from plumbline.harness.run.verify import problems
from plumbline.harness.store import journal as journals
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import sealed_json, sealed_toml
from plumbline.harness.store.store import Store, read_plain
from plumbline.harness.study import plugins
from tests.stress.ledger import Page
from tests.stress.light_run import STUDY, carry_out, light

Change = Callable[[str, dict[str, Any]], None]
"""Of the content of a journal's line, by its kind."""
COMMANDS = (
    ("show",),
    ("show", "--table", "price"),
    ("show", "--table", "determinism", "--format", "json"),
    ("select",),
    ("verify",),
    ("reproduce", "abc"),
)
"""What takes one run folder, but for the report, which takes a second."""


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder of two trials."""
    folder = tmp_path_factory.mktemp("sound") / "run"
    with pytest.MonkeyPatch.context() as patch:
        light(patch)
        carry_out(folder)
        yield folder


@pytest.fixture
def folder(sound: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(sound, tmp_path / "run"))


def told(folder: Path) -> list[tuple[str, dict[str, Any]]]:
    """Kind and content of each line."""
    lines = [json.loads(line.partition(b" ")[2]) for line in (folder / "journal.jsonl").read_bytes().splitlines()]
    return [(line["kind"], line["content"]) for line in lines]


def tell(folder: Path, lines: list[tuple[Any, Any]]) -> None:
    """Write a journal of these, each checksum right; the tables go, so that it is read."""
    before, content = "", b""
    for number, (kind, plain) in enumerate(lines, 1):
        before, line = journals._line(number, before, kind, plain)
        content += line
    (folder / "journal.jsonl").write_bytes(content)
    machine = read_plain(folder / "machine.json") | {"journal": {"lines": 0, "checksum": ""}, "tables": {}}
    (folder / "machine.json").write_bytes(sealed_json("machine.json", machine))


def called(*words: object) -> Result:
    return CliRunner().invoke(main, list(map(str, words)))


def in_a_line(done: Result) -> bool:
    """Did the command end well, or say what is wrong in so many words? Anything but an exit is a traceback."""
    return done.exception is None or (isinstance(done.exception, SystemExit) and done.exit_code in (0, 1, 2, 3))


def every_command_says(folder: Path, other: Path, what: str = "") -> None:
    """None has a traceback, and where `what` is given each names it and ends with 3."""
    for command, *more in COMMANDS:
        done = called(command, folder, *more)
        assert in_a_line(done), (command, more, done.exception)
        if what:
            assert (done.exit_code, what in done.stderr + done.stdout) == (3, True), (command, more, done.stderr)
    for pair in ((folder, other), (other, folder)):
        done = called("diff", *pair)
        assert in_a_line(done), (pair, done.exception)
        assert not what or (done.exit_code, what in done.stderr) == (3, True), done.stderr


def set_in(kind: str, name: str, value: object) -> Change:
    def change(of: str, content: dict[str, Any]) -> None:
        if of == kind:
            content[name] = value

    return change


def drop_from(kind: str, name: str) -> Change:
    def change(of: str, content: dict[str, Any]) -> None:
        if of == kind:
            content.pop(name, None)

    return change


WRONG: dict[str, tuple[Change, str]] = {
    "a status that is none": (set_in("accuracy", "status", "splendid"), "status: Input should be 'passed'"),
    "a status of another type": (set_in("accuracy", "status", 3), "status: "),
    "a record without its trial": (drop_from("accuracy", "trial"), "trial"),
    "a record without its case": (drop_from("accuracy", "case"), "case: Field required"),
    "a time step in words": (set_in("accuracy", "dt", "small"), "dt: Input should be a valid number"),
    "a time step that is a list": (set_in("accuracy", "dt", [0.1]), "dt: Input should be a valid number"),
    "measurements that are none": (set_in("accuracy", "measurements", [{"value": "x"}]), "measurements.0."),
    "measurements that are words": (set_in("accuracy", "measurements", "all fine"), "measurements: "),
    "warnings that are numbers": (set_in("accuracy", "warnings", [1]), "warnings.0: "),
    "parameters that are a list": (set_in("accuracy", "parameters", []), "parameters: "),
    "a trajectory outside": (
        set_in("accuracy", "trajectory_hash", "../../../etc/passwd"),
        "holds the trajectory_hash '../../..",
    ),
    "a trial outside": (set_in("accuracy", "trial", "../../x"), "holds the trial '../../x'"),
    "samples that are numbers": (set_in("accuracy", "timing", {"trial": "a", "samples": [1, 2]}), "timing.samples.0: "),
    "a session without a study": (drop_from("session", "study"), "study: Field required"),
    "a session of no trials": (set_in("session", "trials", None), "trials: "),
    "a session whose study is a word": (set_in("session", "study", "quick"), "study: "),
    "a session whose engines are a list": (set_in("session", "engines", ["mujoco"]), "engines: "),
    "a session whose machine is a word": (set_in("session", "machine", "mine"), "machine: "),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_content_under_a_right_checksum_is_named_by_every_command(
    name: str, folder: Path, sound: Path, ledger: Page
) -> None:
    change, what = WRONG[name]
    lines = told(folder)
    for kind, content in lines:
        change(kind, content)
    tell(folder, lines)
    every_command_says(folder, sound, what)
    done = called("merge", folder, sound, "--out", folder.parent / "whole")
    assert (done.exit_code, what in done.stderr) == (3, True), done.stderr
    assert not (folder.parent / "whole").exists()
    ledger.survived("strange stores", name, "named with line and field, exit code 3")


@pytest.mark.parametrize("kind", ["odd", "", None, 3, ["accuracy"]])
def test_a_line_of_a_kind_that_is_none_is_named(kind: object, folder: Path, sound: Path, ledger: Page) -> None:
    tell(folder, [*told(folder), (kind, {})])
    every_command_says(folder, sound, "kind: ")
    ledger.survived("strange stores", f"a line of kind {kind!r}", "named with its line, exit code 3")


@pytest.mark.parametrize("content", [[], "x", 3, None, {"trials": [1]}, {"trials": "abc"}])
def test_a_line_whose_content_is_none_is_named(content: object, folder: Path, sound: Path, ledger: Page) -> None:
    tell(folder, [*told(folder), ("withdrawn", content)])
    every_command_says(folder, sound, "line ")
    ledger.survived("strange stores", f"withdrawn {json.dumps(content)}", "named with its line, exit code 3")


DOCUMENTS: dict[str, tuple[str, bytes]] = {
    "a catalogue that is a list": ("catalogue.json", b"[]"),
    "a catalogue of lists": ("catalogue.json", sealed_json("catalogue.json", {"cases": [], "engines": []})),
    "a catalogue whose case is a word": ("catalogue.json", sealed_json("catalogue.json", {"cases": {"a": "b"}})),
    "a catalogue whose checks are words": (
        "catalogue.json",
        sealed_json("catalogue.json", {"cases": {"a": {"checks": ["b"]}}}),
    ),
    "a catalogue whose title is a number": ("catalogue.json", sealed_json("catalogue.json", {"engines": {"a": {"title": 3}}})),
    "a machine that is a number": ("machine.json", b"3"),
    "a machine whose journal is a word": ("machine.json", sealed_json("machine.json", {"journal": "long"})),
    "a machine whose lines are words": (
        "machine.json",
        sealed_json("machine.json", {"journal": {"lines": "x"}}),
    ),
    "a machine whose tables are a list": ("machine.json", sealed_json("machine.json", {"tables": []})),
    "a study whose experiments are a number": ("study.toml", sealed_toml("study.toml", "experiments = 3\n")),
    "a study whose name is a table": ("study.toml", sealed_toml("study.toml", "[name]\na = 1\n")),
    "a machine without its seal": ("machine.json", b'{"journal": {"lines": 0, "checksum": ""}}'),
    "a catalogue without its seal": ("catalogue.json", b'{"cases": {}, "engines": {}}'),
    "a study without its seal": ("study.toml", b'name = "light"\n'),
    "a catalogue nested deep": ("catalogue.json", b"[" * 100_000),
    "a machine of half letters": ("machine.json", b'{"a": "\xff"}'),
}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_a_document_that_is_none_is_named_and_no_command_breaks(name: str, folder: Path, sound: Path, ledger: Page) -> None:
    file, content = DOCUMENTS[name]
    (folder / file).write_bytes(content)
    (folder / "trials.parquet").unlink()
    every_command_says(folder, sound)
    with pytest.raises(StoreError, match=file):
        read_plain(folder / file)
    assert file in {problem.path.name for problem in problems(folder)}
    assert in_a_line(called("merge", folder, sound, "--out", folder.parent / "whole"))
    ledger.survived("strange stores", name, "named by verify, tracebacks 0")


@pytest.mark.parametrize("lines", [0, 1])
def test_a_run_killed_before_its_first_record_is_an_empty_folder_to_every_command(
    lines: int, folder: Path, sound: Path, ledger: Page
) -> None:
    tell(folder, told(folder)[:lines])
    for path in folder.glob("*.parquet"):
        path.unlink()
    every_command_says(folder, sound)
    assert called("show", folder).exit_code == 0
    assert called("diff", folder, sound).exit_code == 0
    assert called("diff", sound, folder).exit_code == 0
    assert called("report", folder).exit_code == 0
    merged = called("merge", sound, folder, "--out", folder.parent / "whole")
    assert merged.exit_code == 0, merged.stderr
    assert len(Store(folder.parent / "whole").trials) == len(Store(sound).trials)
    alone = called("merge", folder, "--out", folder.parent / "alone")
    assert (alone.exit_code, (folder.parent / "alone").exists()) == ((3, False) if lines == 0 else (0, True))
    ledger.survived("strange stores", f"killed after {lines} lines", "show, diff, report and merge work")


@pytest.mark.parametrize("name", ["journal.jsonl", "catalogue.json", "machine.json", "study.toml", "trials.parquet"])
@pytest.mark.parametrize("what", ["pipe", "folder", "link to itself"])
def test_what_is_no_file_keeps_nobody_waiting(name: str, what: str, folder: Path, sound: Path, ledger: Page) -> None:
    path = folder / name
    path.unlink()
    if what == "pipe":
        os.mkfifo(path)
    elif what == "folder":
        path.mkdir()
    else:
        path.symlink_to(path)
    every_command_says(folder, sound)
    if name != "trials.parquet":
        assert called("verify", folder).exit_code == 3
    ledger.survived("strange stores", f"{name} is a {what}", "waited for 0 s, tracebacks 0")


@pytest.mark.parametrize("room", ["trajectories", "truths"])
def test_a_pipe_among_the_arrays_is_named_by_verify(room: str, folder: Path, ledger: Page) -> None:
    (folder / room).mkdir(exist_ok=True)
    names = [path.name for path in (folder / room).glob("*.npz")] or ["0123456789abcdef.npz"]
    (folder / room / names[0]).unlink(missing_ok=True)
    os.mkfifo(folder / room / names[0])
    assert names[0] in {problem.path.name for problem in problems(folder)}
    ledger.survived("strange stores", f"a pipe in {room}", "named by verify, waited for 0 s")


def test_an_array_without_its_seal_is_not_believed(folder: Path, ledger: Page) -> None:
    (path,) = list((folder / "trajectories").glob("*.npz"))[:1]
    content = path.read_bytes()
    path.write_bytes(content[: -(len(b"plumbline ") + 64) - 2] + b"\0\0")
    with pytest.raises(StoreError, match="it has no checksum"):
        Store(folder).trajectory(path.stem)
    ledger.survived("strange stores", "an array without its seal", "not taken")


def test_a_truth_without_its_seal_is_made_again(folder: Path, capsys: pytest.CaptureFixture[str], ledger: Page) -> None:
    from plumbline.harness.trial import truth_cache

    (source,) = list((folder / "trajectories").glob("*.npz"))[:1]
    (folder / "truths").mkdir(exist_ok=True)
    truth = folder / "truths" / "0123456789abcdef.npz"
    content = source.read_bytes()
    truth.write_bytes(content[: -(len(b"plumbline ") + 64) - 2] + b"\0\0")
    assert truth_cache._read(truth) is None
    assert "it has no checksum; it is made again" in capsys.readouterr().err
    ledger.survived("strange stores", "a truth without its seal", "made again, and said")


@pytest.mark.parametrize(("place", "table"), [("scenes/abc/fidelity.json", "fidelity"), ("zoo/a.json", "zoo")])
@pytest.mark.parametrize("content", [b'{"name": "a"}', sealed_json("another.json", {"name": "a"}), b"[" * 100_000])
def test_what_robots_became_is_named_where_it_is_not_as_it_was_written(
    content: bytes, place: str, table: str, folder: Path, ledger: Page
) -> None:
    path = folder / place
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    done = called("show", folder, "--table", table)
    assert (done.exit_code, str(path) in done.stderr) == (3, True), (done.stderr, done.exception)
    assert path in {problem.path for problem in problems(folder)}
    ledger.survived("strange stores", f"a damaged table of {table}", "named, tracebacks 0")


# What is merged.


@pytest.fixture
def parts(sound: Path, tmp_path: Path) -> list[Path]:
    """Two folders of all trials each."""
    return [Path(shutil.copytree(sound, tmp_path / name)) for name in ("a", "b")]


def merge(*folders: Path) -> tuple[Result, Path]:
    out = folders[0].parent / "whole"
    return called("merge", *folders, "--out", out), out


def nothing_written(done: Result, out: Path, what: str) -> None:
    assert (done.exit_code, what in done.stderr) == (3, True), done.stderr
    assert sorted(path.name for path in out.parent.iterdir()) == ["a", "b"]


def test_a_link_in_a_part_is_refused_and_what_it_names_is_not_copied(
    parts: list[Path], tmp_path_factory: Any, ledger: Page
) -> None:
    secret = tmp_path_factory.mktemp("home") / "secret"
    secret.write_text("secret")
    for name in ("trajectories/0123456789abcdef.npz", "logs/0123.log", "scenes/0123456789ab"):
        link = parts[1] / name
        link.parent.mkdir(exist_ok=True)
        link.symlink_to(secret if link.suffix else secret.parent)
        done, out = merge(*parts)
        nothing_written(done, out, f"{link}: is a link")
        link.unlink()
        ledger.survived("merge", f"a link in {link.parent.name}", "refused by name, copied 0")


@pytest.mark.parametrize("first", [0, 1])
def test_of_two_copies_the_sound_one_is_taken_and_of_damaged_ones_none(first: int, parts: list[Path], ledger: Page) -> None:
    (path,) = list((parts[first] / "trajectories").glob("*.npz"))[:1]
    whole = path.read_bytes()
    path.write_bytes(whole[:100] + bytes([whole[100] ^ 1]) + whole[101:])
    done, out = merge(*parts)
    assert done.exit_code == 0, done.stderr
    assert (out / "trajectories" / path.name).read_bytes() == whole
    shutil.rmtree(out)
    (parts[1 - first] / "trajectories" / path.name).write_bytes(whole[:-1])
    nothing_written(*merge(*parts), "1 damaged files that no other folder holds whole")
    ledger.survived("merge", f"a damaged copy in folder {first}", "the sound one is taken; without one nothing is written")


def test_a_torn_record_is_said_and_the_whole_is_not_complete(parts: list[Path], ledger: Page) -> None:
    journal = parts[0] / "journal.jsonl"
    lines = journal.read_bytes().splitlines(keepends=True)
    answers = [number for number, line in enumerate(lines) if b'"kind": "accuracy"' in line]
    journal.write_bytes(b"".join(lines[: answers[-1]]) + lines[answers[-1]][:50])
    done, out = merge(parts[0])
    assert done.exit_code == 0, done.stderr
    assert "is torn, as a kill leaves it: 50 bytes are dropped" in done.stderr
    assert f"1 of {len(answers)} trials have no record in any folder" in done.stderr
    assert Store(out).machine["complete"] is False
    ledger.survived("merge", "a torn record", "said, and not complete")


def test_another_study_leaves_nothing_behind(parts: list[Path], ledger: Page) -> None:
    lines = told(parts[1])
    for kind, content in lines:
        if kind == "session":
            content["study"]["experiments"][0]["dt"] = [0.5]
    tell(parts[1], lines)
    done, out = merge(*parts)
    assert (done.exit_code, "is of another study" in done.stderr) == (2, True), done.stderr
    assert sorted(path.name for path in out.parent.iterdir()) == ["a", "b"]
    ledger.survived("merge", "another study", "refused, written 0")


def test_a_disk_that_fails_leaves_nothing_behind(parts: list[Path], monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    from plumbline.harness.store import disk

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    writes = disk.calls.write
    for number in range(1, 40):
        left = [number]

        def counted(descriptor: int, content: memoryview, left: list[int] = left) -> int:
            left[0] -= 1
            return writes(descriptor, content) if left[0] > 0 else full()

        monkeypatch.setattr(disk.calls, "write", counted)
        done, out = merge(*parts)
        monkeypatch.undo()
        if done.exit_code == 0:
            break
        assert done.exit_code == 3, done.stderr
        if out.exists():  # the whole is there, and a page that people look at was under way
            shutil.rmtree(out)
        else:
            assert sorted(path.name for path in out.parent.iterdir()) == ["a", "b"]
    assert number > 10
    ledger.survived("merge", "a disk that is full", f"{number - 1} writes failed in turn, halves left 0")


def test_a_folder_that_holds_anything_is_not_merged_into(parts: list[Path], ledger: Page) -> None:
    out = parts[0].parent / "whole"
    out.mkdir()
    assert merge(*parts)[0].exit_code == 0
    shutil.rmtree(out)
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    done, _ = merge(*parts)
    assert (done.exit_code, "holds files already" in done.stderr) == (2, True), done.stderr
    assert [path.name for path in out.iterdir()] == ["mine.txt"]
    ledger.survived("merge", "a folder that holds files", "refused, and left as it is")


def test_the_study_of_these_tests_is_carried_out_as_any_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is written today passes the forms that strangers are held against: a resume reads its own folder."""
    light(monkeypatch)
    cases, engines = {"stress_fall": plugins.case("stress_fall")}, {"sound": plugins.adapter("sound")}
    for _ in range(2):
        carry_out_study(STUDY, tmp_path / "run", cases, engines, workers=1, resume=True)
    assert [problem for problem in problems(tmp_path / "run") if problem.path.suffix not in (".xml", ".md")] == []
