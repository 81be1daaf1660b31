"""Streams that are closed or full, names that are none, programs that print anything: rows and exit codes stand."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.cli.guard import check_words
from plumbline.harness.cli.main import main
from plumbline.harness.findings.vendor_findings import Finding, ask
from plumbline.harness.store.journal import Journal
from plumbline.reports.paper.printing import NotPrinted, _is_pdf, print_report
from tests.stress.ledger import Page

SCENE = Path(__file__).parent / "sound_files" / "ball.toml"


def shell(text: str, *words: object) -> subprocess.CompletedProcess[str]:
    """A line of a shell, in which $0 is the command line of ours."""
    command = f"{sys.executable} -m plumbline"
    return subprocess.run(
        ["/bin/sh", "-c", text.replace("plumbline", command, 1), *map(str, words)],
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of which there is something to say: its last line is torn."""
    folder = tmp_path_factory.mktemp("cut")
    (folder / "journal.jsonl").write_bytes(b"0123")
    return folder


@pytest.mark.parametrize("stream", ["2>/dev/full", "2>&-", "2>&- <&-", "2>/dev/null"])
def test_rows_and_exit_code_are_the_same_whoever_hears_the_notices(stream: str, cut: Path, ledger: Page) -> None:
    done = shell(f"plumbline show {cut} --format json {stream}")
    assert (done.returncode, json.loads(done.stdout)) == (0, [])
    ledger.survived("streams", f"notices to {stream}", "rows and exit code as ever")


@pytest.mark.parametrize(("stream", "code"), [(">/dev/full", 3), (">&-", 0)])
def test_rows_that_cannot_be_written_are_the_machines_fault(stream: str, code: int, cut: Path, ledger: Page) -> None:
    done = shell(f"plumbline show {cut} --format json {stream}")
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    ledger.survived("streams", f"rows to {stream}", f"exit code {code}, no traceback")


def test_a_closed_stream_is_taken_by_no_file_of_ours(tmp_path: Path, ledger: Page) -> None:
    """The next file that is opened would get the number of the stream, and what libraries print."""
    code = """
import os, sys
from plumbline.harness.cli.guard import open_streams
open_streams()
print(os.open("file", os.O_CREAT | os.O_WRONLY) > 2, file=open("said", "w"))
os.write(2, b"lost")
print("lost", file=sys.stderr)
"""
    subprocess.run(["/bin/sh", "-c", f"{sys.executable} -c '{code}' <&- >&- 2>&-"], cwd=tmp_path, check=True)
    assert (tmp_path / "said").read_text() == "True\n"
    assert (tmp_path / "file").read_bytes() == b""
    ledger.survived("streams", "all three closed", "written into files of ours 0")


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (["run", "quick", "--out", ""], "--out: got '', expected a value"),
        (["run", "quick", "--out="], "--out: got '', expected a value"),
        (["run", ""], "run: got '', expected a value"),
        (["merge", "a", "", "--out", "b"], "a: got '', expected a value"),
        (["report", ""], "report: got '', expected a value"),
        (["", "x"], "an argument: got '', expected a value"),
        (["scene", "check", "b\udcff.toml"], r"'b\udcff.toml': a name that is no UTF-8, expected one that is"),
        (["run", "b\udcff.toml"], r"'b\udcff.toml': a name that is no UTF-8, expected one that is"),
        (["run", "quick", "--out", "\udc80"], r"'\udc80': a name that is no UTF-8, expected one that is"),
    ],
)
def test_a_name_that_can_be_none_is_refused(
    words: list[str], what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, words)
    assert (done.exit_code, what in done.stderr) == (2, True), done.stderr
    assert list(tmp_path.iterdir()) == []
    ledger.survived("names", " ".join(words).encode("ascii", "backslashreplace").decode() or "none", "exit code 2, written 0")


def test_names_of_every_language_are_taken() -> None:
    check_words(["run", "scène.toml", "--out", "Прогон 試走", "--case=joint_*", "-h"])


def test_a_scene_under_a_folder_that_is_no_utf_8_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    folder = tmp_path / "b\udcff"
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this file system has names in UTF-8 alone")
    (folder / "ball.toml").write_bytes(SCENE.read_bytes())
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(main, ["run", "ball.toml", "--out", str(tmp_path / "out")])
    assert (done.exit_code, "no UTF-8" in done.stderr) == (2, True), done.stderr
    ledger.survived("names", "a folder that is no UTF-8", "exit code 2")


@pytest.mark.parametrize("address", ["nope", "tcp://nope", "nope:", "tcp://:", "a b:80", "host:123456789"])
def test_an_address_that_is_none_is_refused_at_once(address: str, tmp_path: Path, ledger: Page) -> None:
    done = CliRunner().invoke(main, ["run", "quick", "--scheduler", address, "--out", str(tmp_path / "out")])
    assert (done.exit_code, "expected the address of a scheduler, like tcp://HOST:8786" in done.stderr) == (2, True)
    assert not (tmp_path / "out").exists()
    ledger.survived("names", f"--scheduler {address}", "exit code 2, connected to 0")


SCRIPTS = {
    "bytes that are no UTF-8": ("import sys; sys.stdout.buffer.write(b'\\xff\\xfe\\nstill there: \\xff 3\\n')", "still there"),
    "a child that keeps the stream": (
        "import subprocess, sys\n"
        "subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'], start_new_session=False)\n"
        "print('still there: 3')",
        "still there",
    ),
    "a flood": ("print('x' * 3_000_000); print('gone: 3')", "gone"),
    "a signal": ("import os; os.kill(os.getpid(), 11)", "failed"),
    "an exit without a word": ("import os; os._exit(0)", "failed"),
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_finding_says_what_it_says_whatever_else_it_prints(name: str, tmp_path: Path, ledger: Page) -> None:
    code, verdict = SCRIPTS[name]
    script = tmp_path / "finding.py"
    script.write_text(code)
    fields = dict.fromkeys(Finding.__dataclass_fields__, ())
    finding = Finding(**{**fields, "script": script, "engine": "mujoco", "requires": ()})  # type: ignore[arg-type]
    standing = ask(finding)
    assert standing.verdict == verdict
    assert standing.seconds < 55
    ledger.survived("findings", name, f"told as {verdict}")


def test_a_browser_that_prints_garbage_has_printed_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    folder = tmp_path / "run"
    (folder / "report").mkdir(parents=True)
    (folder / "report" / "index.html").write_text("<!doctype html><title>t</title><main id='content'></main>")
    Journal(folder).close()
    browser = tmp_path / "browser"
    browser.write_text('#!/bin/sh\nfor a in "$@"; do case "$a" in --print-to-pdf=*) printf "$TEXT" > "${a#*=}";; esac; done\n')
    browser.chmod(0o755)
    monkeypatch.setenv("PLUMBLINE_CHROMIUM", str(browser))
    for text in ("garbage", "", "%%PDF-1.7 cut short"):
        monkeypatch.setenv("TEXT", text)
        with pytest.raises(NotPrinted, match="ended with exit code 0 and no PDF"):
            print_report(folder, tmp_path / "out.pdf")
        assert not (tmp_path / "out.pdf").exists()
        ledger.survived("browser", f"prints {text or 'nothing'}", "exit code 3, no file")
    assert not [path for path in (folder / "report").iterdir() if path.name.startswith(".print")]


def test_a_pdf_is_one_from_its_first_byte_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "a.pdf"
    path.write_bytes(b"%PDF-1.7\n" + os.urandom(5000) + b"\n%%EOF\n")
    assert _is_pdf(path)
    path.write_bytes(path.read_bytes()[:-6])
    assert not _is_pdf(path)
