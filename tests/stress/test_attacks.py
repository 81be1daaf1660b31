"""A hundred attacks on the finished program: robot files, run folders, plug-ins, full disks, other users, slow file systems.

Each ends with exit code 0, 1, 2 or 3 and a line, or with the result of an undisturbed run; never with a traceback.
"""

import contextlib
import errno
import json
import os
import struct
import sys
import time
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from plumbline.engine.compile import jit, kernel_cache
from plumbline.harness.cli.main import main
from plumbline.harness.intake import strangers, user_cache
from plumbline.harness.store import disk
from plumbline.harness.store.record import Record
from tests.stress.ledger import Page
from tests.stress.light_run import carry_out, light
from tests.stress.test_strange_stores import tell, told

LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>{}</link>'
)


def called(*words: object) -> Result:
    return CliRunner().invoke(main, list(map(str, words)))


def ends_in_a_line(done: Result) -> None:
    assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)
    assert done.exit_code in (0, 1, 2, 3)
    assert "Traceback" not in done.stderr
    assert len(done.stderr) < 20_000


def urdf(*links: str, joints: str = "", before: str = "") -> bytes:
    return f'{before}<robot name="r">{"".join(links)}{joints}</robot>'.encode()


def mesh(name: str) -> bytes:
    return urdf(LINK.format("a", f'<collision><geometry><mesh filename="{name}"/></geometry></collision>'))


def joint(parent: str, child: str, more: str = "", kind: str = "revolute") -> str:
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>' if kind == "revolute" else ""
    return f'<joint name="{parent}{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{limit}{more}</joint>'


MANY = b" ".join(b"a%d='1'" % k for k in range(10_000))
REPLICAS = b'<mujoco><worldbody><replicate count="1000000"><body/></replicate></worldbody></mujoco>'
STAYS = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(300)'])"
WORDLESS = "class E(Exception):\n    def __str__(self): raise ValueError('none')\nraise E"
A, B = LINK.format("a", ""), LINK.format("b", "")
ROBOTS: dict[str, tuple[str, bytes]] = {
    "nothing": ("a.urdf", b""),
    "blanks": ("a.urdf", b"   \n"),
    "half a tag": ("a.urdf", b"<robot name='r'><link"),
    "UTF-16": ("a.urdf", urdf(A).decode().encode("utf-16")),
    "another encoding than it says": ("a.urdf", b"<?xml version='1.0' encoding='utf-7'?>" + urdf(A)),
    "an encoding that is none": ("a.urdf", b"<?xml version='1.0' encoding='nope'?>" + urdf(A)),
    "a byte of zero": ("a.urdf", urdf(A).replace(b"1", b"1\0", 1)),
    "a name of a megabyte": ("a.urdf", urdf(LINK.format("x" * 1_000_000, ""))),
    "a name of control characters": ("a.urdf", urdf(LINK.format("&#7;", ""))),
    "a name that turns the line round": ("a.urdf", urdf(LINK.format("&#x202e;a", ""))),
    "a comment of a megabyte": ("a.urdf", urdf(A, before=f"<!--{'x' * 1_000_000}-->")),
    "a processing instruction": ("a.urdf", urdf(A, before="<?php system('true') ?>")),
    "a stylesheet from elsewhere": ("a.urdf", urdf(A, before="<?xml-stylesheet href='file:///etc/passwd'?>")),
    "a document type": ("a.urdf", urdf(A, before="<!DOCTYPE r SYSTEM 'file:///etc/passwd'>")),
    "entities": ("a.urdf", urdf(A, before="<!DOCTYPE r [<!ENTITY a 'b'>]>")),
    "ten thousand attributes": ("a.urdf", urdf(A).replace(b"<robot", b"<robot " + MANY)),
    "a joint to itself": ("a.urdf", urdf(A, joints=joint("a", "a"))),
    "a circle": ("a.urdf", urdf(A, B, joints=joint("a", "b") + joint("b", "a"))),
    "a child of two": ("a.urdf", urdf(A, B, LINK.format("c", ""), joints=joint("a", "c") + joint("b", "c"))),
    "mimics in a circle": ("a.urdf", urdf(A, B, joints=joint("a", "b", '<mimic joint="ab"/>'))),
    "a mimic of nobody": ("a.urdf", urdf(A, B, joints=joint("a", "b", '<mimic joint="x"/>'))),
    "limits the wrong way round": ("a.urdf", urdf(A, B, joints=joint("a", "b").replace('"-1"', '"2"'))),
    "a mesh that is /dev/zero": ("a.urdf", mesh("/dev/zero")),
    "a mesh that is a file address": ("a.urdf", mesh("file:///etc/passwd")),
    "a mesh from above": ("a.urdf", mesh("package://r/../../../etc/passwd")),
    "a mesh with a byte of zero": ("a.urdf", mesh("a&#0;.stl")),
    "a mesh from the network": ("a.urdf", mesh("http://localhost:1/a.stl")),
    "a mesh that is itself": ("a.urdf", mesh("a.urdf")),
    "MJCF that includes itself": ("a.xml", b'<mujoco><include file="a.xml"/></mujoco>'),
    "MJCF that includes what is outside": ("a.xml", b'<mujoco><include file="/etc/passwd"/></mujoco>'),
    "MJCF of a million replicas": ("a.xml", REPLICAS),
    "MJCF with a plug-in": ("a.xml", b'<mujoco><extension><plugin plugin="evil"/></extension><worldbody/></mujoco>'),
    "SDF that includes itself": ("a.sdf", b'<sdf version="1.7"><include><uri>a.sdf</uri></include></sdf>'),
    "SDF of version x": ("a.sdf", b'<sdf version="x"><model name="m"><link name="l"/></model></sdf>'),
    "TOML with a date": ("a.toml", b"gravity = 1979-05-27\n"),
    "JSON with a key twice": ("a.json", b'{"bodies": [], "bodies": [{"name": "a"}]}'),
    "JSON of not a number": ("a.json", b'{"gravity": [NaN, 0, 0]}'),
    "JSON that is a number": ("a.json", b"3"),
}  # fmt: skip


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_file_of_an_enemy(name: str, tmp_path: Path, ledger: Page) -> None:
    file, content = ROBOTS[name]
    (tmp_path / file).write_bytes(content)
    begun = time.process_time()
    done = called("scene", "show", tmp_path / file, "--json", *(("--root", "fixed") if file.endswith("urdf") else ()))
    ends_in_a_line(done)
    assert done.exit_code == 0 or file in done.stderr
    assert "root:x:0" not in done.output
    assert time.process_time() - begun < 20
    ledger.survived("attack: robot file", name, "read, or refused by name")


STL = b"\0" * 80
MESHES: dict[str, tuple[str, bytes]] = {
    "OBJ that counts from zero": ("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"),
    "OBJ that points beyond": ("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999\n"),
    "OBJ that points far back": ("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -99\n"),
    "OBJ of not a number": ("m.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    "OBJ with a library from elsewhere": ("m.obj", b"mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"),
    "OBJ of numbers that are words": ("m.obj", b"v a b c\nf x y z\n"),
    "STL that promises four thousand million triangles": ("m.stl", STL + struct.pack("<I", 2**32 - 1)),
    "STL that ends in a triangle": ("m.stl", STL + struct.pack("<I", 2) + b"\0" * 60),
    "STL of triangles without a side": ("m.stl", STL + struct.pack("<I", 4) + b"\0" * 200),
    "STL in words that are none": ("m.stl", b"solid x\nfacet normal a b c\n"),
    "DAE with entities": ("m.dae", b"<!DOCTYPE c [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><COLLADA>&b;</COLLADA>"),
    "DAE of nothing": ("m.dae", b"<COLLADA/>"),
    "a picture": ("m.stl", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4),
}


@pytest.mark.parametrize("name", MESHES)
def test_a_mesh_of_an_enemy(name: str, tmp_path: Path, ledger: Page) -> None:
    file, content = MESHES[name]
    (tmp_path / file).write_bytes(content)
    (tmp_path / "a.urdf").write_bytes(mesh(file))
    done = called("scene", "show", tmp_path / "a.urdf", "--root", "fixed", "--json")
    ends_in_a_line(done)
    assert done.exit_code == 0 or "a.urdf: line 1" in done.stderr
    ledger.survived("attack: mesh", name, "read, or refused by name")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("attacked") / "run"
    with pytest.MonkeyPatch.context() as patch:
        light(patch)
        carry_out(folder)
        yield folder


OTHERS: tuple[Any, ...] = ([1], {"a": 1}, "<script>", -1, True)
FIELDS = tuple(name for name in Record.__dataclass_fields__ if name not in ("trial",))


@pytest.mark.parametrize("field", FIELDS)
def test_a_field_of_a_record_holds_something_else(field: str, run: Path, tmp_path: Path, ledger: Page) -> None:
    """Five values each: what is no value of the field is named with it, what may be one is shown."""
    folder = tmp_path / "run"
    folder.mkdir()
    lines = told(run)
    sound = {kind: json.dumps(content) for kind, content in lines}
    for value in OTHERS:
        for kind, content in lines:
            content.clear()
            content.update(json.loads(sound[kind]))
            if kind == "accuracy":
                content[field] = value
        (folder / "machine.json").unlink(missing_ok=True)
        tell(folder, [line for line in lines if line[0] == "session"] + [line for line in lines if line[0] == "accuracy"][:1])
        for table in ("trials", "measurements", "price"):
            done = called("show", folder, "--table", table, "--format", "json")
            ends_in_a_line(done)
            assert done.exit_code in (0, 3)
            assert done.exit_code == 0 or f"{field}" in done.stderr, done.stderr
    ledger.survived("attack: run folder", f"{field} of five other kinds", "named with its field, or shown")


PLUGINS: dict[str, tuple[str, str]] = {
    "an interrupt": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    "an exit with a word": ("import sys; sys.exit('bye')", "SystemExit: bye"),
    "an exception without words": (WORDLESS, "exit code 1"),
    "an exception of ten megabytes": ("raise ValueError('x' * 10_000_000)", "ValueError: xxx"),
    "an exception that is no text": ("raise ValueError('\\udcff\\x1b[31m')", "ValueError"),
    "an end of all recursion": ("def f(): f()\nf()", "RecursionError"),
    "an abort": ("import os; os.abort()", "was killed by SIGABRT"),
    "a child that stays": (STAYS, ""),
    "streams that are closed": ("import os\nfor k in range(3): os.close(k)", ""),
    "a folder that is left": ("import os; os.chdir('/')", ""),
    "a flood of words": ("print('x' * 5_000_000)", ""),
    "another program": ("import os; os.execv('/bin/true', ['true'])", "ended with exit code 0 and no answer"),
    "a thread that never ends": ("import threading, time; threading.Thread(target=time.sleep, args=(300,)).start()", ""),
    "a file too large": ("f = open('big', 'wb'); f.truncate(2**40)", "OSError"),
}  # fmt: skip


@pytest.mark.parametrize("name", PLUGINS)
def test_a_plug_in_of_an_enemy(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    code, reason = PLUGINS[name]
    (tmp_path / "enemy.py").write_text(f"{code}\nTHING = 1\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    strangers._tried.cache_clear()
    begun = time.monotonic()
    trouble = strangers.trouble(EntryPoint("enemy", "enemy:THING", "plumbline.pages"))
    assert (reason in trouble) if reason else not trouble, trouble
    assert len(trouble) < 3000
    assert "\x1b" not in trouble
    assert time.monotonic() - begun < 250  # nobody waits for what it left behind
    assert "enemy" not in sys.modules
    ledger.survived("attack: plug-in", name, "told in a line" if reason else "loads, and leaves nothing behind")


FAULTS = {
    "a full disk": errno.ENOSPC,
    "a quota": errno.EDQUOT,
    "a read-only disk": errno.EROFS,
    "no rights": errno.EACCES,
    "a stale handle": errno.ESTALE,
    "an error of the device": errno.EIO,
    "no locks": errno.ENOLCK,
    "a time that is out": errno.ETIMEDOUT,
}


def failing(code: int) -> Callable[..., Any]:
    def fail(*_: object, **__: object) -> Any:
        raise OSError(code, os.strerror(code), "there")

    return fail


@pytest.mark.parametrize("name", FAULTS)
@pytest.mark.parametrize("call", ["open", "replace", "fsync"])
def test_a_cache_on_a_bad_disk_costs_the_time_alone(
    call: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    path = tmp_path / "kernels" / "step.nbc"
    kernel_cache._say_once.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(*((Path, "replace") if call == "replace" else (os, call)), failing(FAULTS[name]))
        user_cache.keep(tmp_path / "pieces" / "a", b"corners")
        with pytest.warns(RuntimeWarning, match="cannot be kept"):
            kernel_cache.write_checked(path, b"code")
    assert not path.exists()
    kernel_cache.write_checked(path, b"code")
    assert kernel_cache.read_checked(path) == b"code"
    assert [child.name for child in path.parent.iterdir()] == ["step.nbc"]
    ledger.survived("attack: cache", f"{name} at {call}", "said once, nothing half written")


@pytest.mark.parametrize("name", FAULTS)
def test_a_lock_that_cannot_be_had_is_done_without(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.setattr(jit.fcntl, "flock", failing(FAULTS[name]))
    with jit._one_at_a_time(tmp_path / "kernels", "step"):
        pass
    ledger.survived("attack: lock of compiled code", name, "compiled without it")


@pytest.mark.parametrize("name", FAULTS)
@pytest.mark.parametrize("call", ["read", "reader"])
def test_a_folder_on_a_bad_disk_is_the_machines_fault(
    call: str, name: str, run: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.setattr(disk.calls, call, failing(FAULTS[name]))
    for words in (("show", run), ("verify", run), ("diff", run, run), ("merge", run, "--out", run.parent / "whole")):
        done = called(*words)
        ends_in_a_line(done)
        assert done.exit_code == 3 or (done.exit_code == 0 and words[0] in ("show", "diff")), (words, done.exit_code)
    assert not (run.parent / "whole").exists()
    ledger.survived("attack: run folder on a bad disk", f"{name} at {call}", "exit code 3 in a line")


@pytest.mark.parametrize("day", [0.0, 4e9, 2**33])
def test_files_of_another_time_are_files(day: float, run: Path, tmp_path: Path, ledger: Page) -> None:
    """A file system whose clock is another one."""
    for path in run.iterdir():
        with contextlib.suppress(OSError, OverflowError):
            os.utime(path, (day, day))
    done = called("show", run, "--format", "json")
    assert done.exit_code == 0
    assert len(json.loads(done.stdout)) == 2
    ledger.survived("attack: clock", f"files of second {day:.0f}", "read as ever")
