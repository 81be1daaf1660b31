"""Scene and study files with one fault each, and what has to be said of it."""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

__all__ = [
    "BALL",
    "ROUND",
    "MESH",
    "CAMERA",
    "STUDY",
    "TETRAHEDRON",
    "JOINT",
    "lidar",
    "many",
    "Fault",
    "told",
    "study",
    "without",
    "BODY",
    "ONE",
    "KIND",
    "TEXT",
    "VALUES",
    "LIMITS",
    "STUDIES",
    "FAMILIES",
    "FAULTS",
    "USAGE",
    "names_the_file",
]


BALL = '[[bodies]]\nname = "ball"\n'
ROUND = BALL + "[[bodies.collision]]\nshape = { type = 'sphere', radius = 0.1 }\n"
MESH = BALL + "motion = 'static'\n[[bodies.collision]]\n"
CAMERA = "[[sensors]]\ntype = 'camera'\nname = 'eye'\nbody = 'ball'\nrate = 10.0\n"
STUDY = 'name = "own"\n[[experiments]]\nname = "e"\ncases = ["flight_projectile"]\nengines = ["reference"]\n'
TETRAHEDRON = "[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
JOINT = "[[joints]]\nname = 'j'\nparent = 'world'\nchild = 'ball'\n"


def lidar(rate: str) -> str:
    return BALL + f"[[sensors]]\ntype = 'lidar'\nname = 'scan'\nbody = 'ball'\nrate = {rate}\n"


def many(count: int) -> str:
    return json.dumps({"bodies": [{"name": f"b{number}"} for number in range(count)]})


def crowd() -> str:
    """A million bodies, which are too many before anyone compares their names; made where it is wanted."""
    return '{"bodies": [' + '{"name": "b123456"}, ' * 999_999 + '{"name": "b123456"}]}'


FEW_BODIES = ("--limit", "bytes=1e8", "--limit", "bodies=20000")
"""For a crowd that is refused for its bodies, and soon; a limit that nobody set is met by other files."""


@dataclass(frozen=True)
class Fault:
    """A file and what must be said of it. A large one is written where it is wanted: this module is read by every worker.

    Terms: words: have to stand in what is said, beside the file's name. options: of the command line. environment: variables.
    """

    content: str | bytes | Callable[[Path], object]
    words: tuple[str, ...] = ()
    ending: str = "toml"
    options: tuple[str, ...] = ()
    environment: Mapping[str, str] = field(default_factory=dict)


def told(content: str | bytes, *words: str, ending: str = "toml", options: tuple[str, ...] = ()) -> Fault:
    return Fault(content, words, ending, options)


def study(line: str, *words: str, options: tuple[str, ...] = ()) -> Fault:
    """A line in the experiment of a study."""
    return Fault(STUDY + line + "\n", words, "toml", options)


def without(key: str, line: str, *words: str) -> Fault:
    """A line in the place of the one that sets this key."""
    rest = "".join(one for one in STUDY.splitlines(keepends=True) if not one.startswith(f"{key} "))
    return Fault(rest + line + "\n", words)


BODY = "bodies[0] 'ball' >"
ONE = "experiments[0] 'e' >"

KIND: dict[str, Fault] = {
    "missing file": Fault(lambda _path: None, ("No such file",)),
    "missing JSON file": Fault(lambda _path: None, ("No such file",), "json"),
    "folder": Fault(lambda path: path.mkdir(), ("is a folder",)),
    "folder as JSON": Fault(lambda path: path.mkdir(), ("is a folder",), "json"),
    "pipe without a writer": Fault(lambda path: os.mkfifo(path), ("is a pipe",)),
    "pipe as JSON": Fault(lambda path: os.mkfifo(path), ("is a pipe",), "json"),
    "endless device": Fault(lambda path: path.symlink_to("/dev/zero"), ("is a device",)),
    "endless device as JSON": Fault(lambda path: path.symlink_to("/dev/zero"), ("is a device",), "json"),
    "empty device": Fault(lambda path: path.symlink_to("/dev/null"), ("is a device",), "json"),
    "link to itself": Fault(lambda path: path.symlink_to(path), ("symbolic links",)),
    "link to itself as JSON": Fault(lambda path: path.symlink_to(path), ("symbolic links",), "json"),
    "link to nothing": Fault(lambda path: path.symlink_to("nowhere"), ("No such file",)),
    "65 MB": Fault(lambda path: path.write_bytes(b"#" * 65_000_000), ("65000000 bytes", "at most 16000000", "--limit bytes=")),
    "65 MB of JSON": Fault(lambda path: path.write_bytes(b" " * 65_000_000), ("65000000 bytes", "--limit bytes="), "json"),
    "empty TOML": told("", "Field required"),
    "empty JSON": told("", "not readable", ending="json"),
}
TEXT: dict[str, Fault] = {
    "bytes that are no UTF-8": told(BALL.encode() + b"# \xff\xfe", "line 3", "0xff", "UTF-8"),
    "JSON that is no UTF-8": told(b'{"bodies": "\xff"}', "0xff", "UTF-8", ending="json"),
    "UTF-16": told(BALL.encode("utf-16"), "0xff", "UTF-8"),
    "byte order mark": told(b"\xef\xbb\xbf{}", "not readable", "BOM", ending="json"),
    "half of a character": told(b'{"bodies": [{"name": "b\\ud800"}]}', "bodies[0]", "half of a character", ending="json"),
    "half of a character in a key": told(b'{"bodies": [{"name": "b", "\\udfff": 1}]}', "half of a character", ending="json"),
    "null byte": told(BALL + "mass = 1\x00", "not readable"),
    "arrays 20 000 deep": told("bodies = " + "[" * 20_000 + "]" * 20_000, "65 arrays", "--limit depth="),
    "arrays 200 000 deep in JSON": told("[" * 200_000, "65 arrays", "--limit depth=", ending="json"),
    "objects 20 000 deep in JSON": told('{"a":' * 20_000 + "1" + "}" * 20_000, "65 arrays", ending="json"),
    "inline tables 20 000 deep": told("a = " + "{a = " * 20_000 + "1" + "}" * 20_000, "65 arrays", "--limit depth="),
    "a key of 20 000 parts": told(BALL + ".".join("a" * 20_000) + " = 1", "line 3", "20000 tables", "--limit depth="),
    "a key of 20 000 parts in a line": told("a = {" + ".".join("a" * 20_000) + " = 1}", "20000 tables"),
    "a header of 20 000 parts": told("[" + ".".join("a" * 20_000) + "]", "20000 tables", "--limit depth="),
    "quoted key of 100 parts": told('"a"' + '."a"' * 99 + " = 1", "100 tables in each other"),
    "number of 5000 digits": told(BALL + "mass = " + "9" * 5000, "line 3", "mass = 999", "5000 digits", "--limit digits="),
    "5000 digits in JSON": told('{"mass": ' + "9" * 5000 + "}", '"mass": 999', "5000 digits", ending="json"),
    "5000 digits behind a point": told(BALL + "mass = 0." + "3" * 5000, "5000 digits of a number"),
    "5000 digits in a study": study("samples = " + "9" * 5000, "samples = 999", "5000 digits"),
    "5000 hexadecimal digits": told(BALL + "mass = 0x" + "f" * 5000, "bodies[0] 'ball'", "mass"),
    "key twice in JSON": told('{"bodies": [{"name": "b", "mass": 1, "mass": 2}]}', "'mass' of 'b'", "1 and 2", ending="json"),
    "bodies twice in JSON": told('{"bodies": [], "bodies": [1]}', "'bodies' stands twice", ending="json"),
    "key twice in TOML": told(BALL + "mass = 1.0\nmass = 2.0", "not readable", "overwrite"),
    "NaN in JSON": told('{"bodies": [{"name": "b", "mass": NaN}]}', "bodies[0] 'b' > mass", "nan", ending="json"),
    "Infinity in JSON": told('{"bodies": [{"name": "b", "mass": -Infinity}]}', "bodies[0] 'b' > mass", "-inf", ending="json"),
    "1e999 in JSON": told('{"bodies": [{"name": "b", "mass": 1e999}]}', "mass", "finite", ending="json"),
    "cut off in the middle": told('{"bodies": [{"name": "b', "not readable", ending="json"),
    "JSON as TOML": told('{"bodies": []}', "not readable"),
    "a list at the top": told("[1]", "got [1]", ending="json"),
    "a number at the top": told("5", "got 5", ending="json"),
    "nothing at the top": told("null", "got nothing", ending="json"),
    "message of a third of a megabyte": told('[[bodies]]\nname = "' + "x" * 300_000 + '"', "bodies[0]", "name"),
    "message of megabytes": told('[[bodies]]\nname = "' + "x" * 3_000_000 + '"', "bodies[0]", "name"),
    "key of a third of a megabyte": told(BALL + '"' + "k" * 300_000 + '" = 1', "unknown, got 1, expected one of name, mass"),
    "key of megabytes": told(BALL + '"' + "k" * 1_000_000 + '" = 1', "unknown, got 1, expected one of name, mass"),
    "10 000 troubles": told('{"bodies": [' + ",".join(["1"] * 10_000) + "]}", "and 9980 more of this kind", ending="json"),
    "100 000 troubles": told('{"bodies": [' + ",".join(["1"] * 100_000) + "]}", "more of this kind", ending="json"),
    "escape sequence in a value": told('[[bodies]]\nname = "b\\u001b[31m"', "printable", "\\x1b[31m"),
    "escape sequence in a key": told(BALL + '"\\u001b]0;x\\u0007" = 1', "unknown, got 1, expected one of name, mass"),
    "escape sequence in a parameter": study('parameters = { "\\u001b[2J" = [1] }', "printable"),
    "reversal of direction": told('[[bodies]]\nname = "b\\u202egnp"', "printable"),
    "an invisible sign in a key": told(BALL + '"ma\ufeffss" = 1.0', f"{BODY} ma\\ufeffss"),
    "line breaks in a name": told('[[bodies]]\nname = "b\\n\\n\\ngate: all passed"', "printable"),
}
VALUES: dict[str, Fault] = {
    "a key misspelt": told(BALL + "mas = 1.0", f"{BODY} mas: unknown, got 1.0", "of name, mass, inertia", "did you mean mass?"),
    "a key misspelt in a list": told(
        BALL + "collision = [{ shape = { type = 'sphere', radius = 1.0 }, p_BC = [0, 0, 0] }]",
        "collision[0] > p_BC: unknown",
        "expected one of shape, p_BS, q_BS; did you mean p_BS?",
    ),
    "a key misspelt of one kind": told(
        BALL + "collision = [{ shape = { type = 'sphere', radiu = 1.0 } }]",
        "shape > radiu: unknown",
        "expected one of radius, type; did you mean radius?",
    ),
    "a key misspelt of one kind that may be nothing": told(
        BALL
        + JOINT
        + "type = 'revolute'\ndrive = { stiffness = 1.0, damping = 1.0, motion = { type = 'sinusoid', amp = 1.0 } }",
        "drive > motion > amp: unknown",
        "expected one of amplitude, frequency, phase, type",
    ),
    "a key misspelt at the top of a study": told("body = []", "body: unknown", "one of variants, name, title"),
    "a key misspelt in a study": study("trakcs = ['default']", "experiments[0] 'e' > trakcs", "did you mean tracks?"),
    "true for a mass": told(BALL + "mass = true", f"{BODY} mass", "got true"),
    "a text for a mass": told(BALL + 'mass = "5"', f"{BODY} mass", "got '5'"),
    "a text for a coordinate": told(BALL + 'p_WB = [0.0, "1", 0.0]', f"{BODY} p_WB[1]", "got '1'"),
    "true for a coordinate": told(BALL + "v_WB = [0.0, true, 0.0]", f"{BODY} v_WB[1]", "got true"),
    "true in an inertia": told(BALL + "inertia = [[true, 0, 0], [0, 1, 0], [0, 0, 1]]", f"{BODY} inertia[0]", "got true"),
    "true for a width": told(BALL + CAMERA + "width = true", "sensors[0] 'eye' > width", "got true"),
    "64.0 for a width": told(BALL + CAMERA + "width = 64.5", "sensors[0] 'eye' > width", "got 64.5"),
    "1 for true": told(BALL + JOINT + "type = 'fixed'\ncollide = 1", "joints[0] 'j'", "collide", "got 1"),
    "a number for a name": told("[[bodies]]\nname = 5", "bodies[0] > name", "got 5"),
    "a date for a mass": told(BALL + "mass = 1979-05-27", f"{BODY} mass", "date", "1979-05-27"),
    "a time for a title": told("name = 'own'\ntitle = 07:32:00\nexperiments = []", "title", "07:32:00"),
    "a list for a mass": told(BALL + "mass = [1.0]", f"{BODY} mass", "got [1.0]"),
    "a table for bodies": told("bodies = { name = 'b' }", "bodies"),
    "two coordinates": told(BALL + "p_WB = [0.0, 0.0]", f"{BODY} p_WB"),
    "four coordinates": told(BALL + "p_WB = [0.0, 0.0, 0.0, 0.0]", f"{BODY} p_WB"),
    "a number beyond doubles": told(BALL + "mass = 1" + "0" * 400, f"{BODY} mass", "at most 1e+60"),
    "negative zero of mass": told(BALL + "mass = -0.0", "body 'ball': mass is 0 kg", "above 0"),
    "a quaternion of norm 0": told(BALL + "q_WB = [0.0, 0.0, 0.0, 0.0]", f"{BODY} q_WB", "norm"),
    "nan in a list": told(BALL + "p_WB = [nan, 0.0, 0.0]", f"{BODY} p_WB[0]", "nan"),
    "an effect that is none": told("widen = ['magic']\n" + BALL, "widen", "'magic'"),
    "an effect that is a number": told("narrow = [1]\n" + BALL, "narrow", "1"),
    "a face without its vertex": told(
        MESH + f"shape = {{ type = 'triangle_mesh', vertices = {TETRAHEDRON}, faces = [[0, 1, 9]] }}", "faces[0]", "9"
    ),
    "a face of fractions": told(
        MESH + f"shape = {{ type = 'triangle_mesh', vertices = {TETRAHEDRON}, faces = [[0, 1, 1.5]] }}", "faces[0][2]", "1.5"
    ),
    "a flat hull": told(MESH + "shape = { type = 'convex_hull', vertices = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]] }", "no volume"),
    "a joint to nobody": told(BALL + JOINT.replace("world", "nobody") + "type = 'fixed'", "joint 'j'", "'nobody'"),
    "a sensor on nobody": told(BALL + CAMERA.replace("ball", "nobody"), "sensor 'eye'", "'nobody'"),
    "a body called world": told("[[bodies]]\nname = 'world'", "'world'"),
    "two bodies of a name": told(BALL + BALL, "body 'ball'", "2 times"),
    "no body": told("bodies = []", "bodies is empty"),
}
LIMITS: dict[str, Fault] = {
    "a million bodies": Fault(lambda path: path.write_text(crowd()), ("bytes", "--limit bytes="), "json"),
    "a million bodies with room": Fault(
        lambda path: path.write_text(crowd()),
        ("bodies: at least 20001", "at most 20000"),
        "json",
        options=FEW_BODIES,
    ),
    "a million bodies in TOML": Fault(
        lambda path: path.write_text('[[bodies]]\nname = "b123456"\n' * 1_000_000),
        ("bodies: at least 1000000",),
        options=FEW_BODIES,
    ),
    "a million bodies inline": Fault(
        lambda path: path.write_text("bodies = [" + '{name="b123456"},' * 1_000_000 + "]"),
        ("1000001 arrays",),
        options=("--limit", "bytes=1e8"),
    ),
    "bodies inline, two too many": told(
        "bodies = [" + '{name="b123456"},' * 2002 + "]", "2002", options=("--limit", "bodies=2000")
    ),
    "joints, two too many": told(
        '{"joints": [' + '{"type": "fixed"},' * 2002,
        "joints: at least 2001",
        ending="json",
        options=("--limit", "joints=2000"),
    ),
    "a million joints": told(
        '{"joints": [' + '{"type": "fixed"},' * 1_000_000,
        "joints: at least 100001",
        ending="json",
        options=("--limit", "bytes=1e8"),
    ),
    "bodies beyond a limit of one's own": told(
        many(11), "bodies: ", "at most 10", ending="json", options=("--limit", "bodies=10")
    ),
    "bodies told in escapes": told(
        many(11).replace("bodies", "b\\u006fdies"), "11 bodies", "at most 10", ending="json", options=("--limit", "bodies=10")
    ),
    "1001 sensors": told(BALL + "".join(CAMERA for _ in range(1001)), "sensors", "1001", "--limit sensors="),
    "arrays beyond a limit of one's own": told(
        "[" + "[]," * 100_000, "100001 arrays", "at most 50000", ending="json", options=("--limit", "parts=50000")
    ),
    "two million arrays": told("[" * 1 + "[]," * 2_000_000, "2000001 arrays", "--limit parts=", ending="json"),
    "vertices beyond a limit": told(
        MESH + f"shape = {{ type = 'convex_hull', vertices = {TETRAHEDRON} }}",
        "bodies[0] 'ball'",
        "4 vertices",
        options=("--limit", "vertices=3"),
    ),
    "faces beyond a limit": told(
        MESH + f"shape = {{ type = 'triangle_mesh', vertices = {TETRAHEDRON}, faces = {[[0, 2, 1]] * 9} }}",
        "9 faces",
        "at most 8",
        options=("--limit", "vertices=8"),
    ),
    "a range finder at 1e9 Hz": told(
        lidar("1e9"), "sensor 'scan'", "rate 1e+09 Hz", "a whole divisor of the 240 steps", "--dt"
    ),
    "a range finder at 1e50 Hz": told(lidar("1e50"), "sensor 'scan'", "rate 1e+50 Hz", "a whole divisor of the 240 steps"),
    "a camera of 16384 pixels squared": told(BALL + CAMERA + "width = 16384\nheight = 16384", "sensor 'eye'", "--limit rays="),
    "an IMU at 1e12 Hz": told(BALL + CAMERA.replace("camera", "imu").replace("10.0", "1e12"), "sensor 'eye'", "rate 1e+12 Hz"),
    "a range finder of 1e8 rays a second": told(
        lidar("240.0") + "channels = 4096\ncolumns = 65536\n", "sensor 'scan'", "rays", "--limit rays="
    ),
    "1e9 steps": study("dt = [1e-9]", "dt 1e-09 s", "2000000000 steps", "--limit steps="),
    "2e12 steps": study("dt = [1e-12]", "steps", "at most 100000000", "--limit steps="),
    "steps beyond a limit of one's own": study("dt = [0.01]", "200 steps", "at most 199", options=("--limit", "steps=199")),
    "samples beyond a limit": study("dt = [0.01]", "120 samples", "at most 100", options=("--limit", "samples=100")),
    "every one of 1e8 steps recorded": study("dt = [2e-8]\ndeterminism = true", "samples", "--limit samples="),
    "a million trials": study(f"parameters = {{ mass = {list(range(1, 1001))}, radius = {list(range(1, 1001))} }}", "trials"),
    "1e9 bodies by a parameter": without(
        "cases",
        "cases = ['stack_tower']\nparameters = { n = [1_000_000_000] }",
        "parameter 'n'",
        "1000000000 things",
        "--limit things=",
    ),
    "limit that is none": told(BALL, "'bodys=5'", "bodies, joints", options=("--limit", "bodys=5")),
    "limit without a number": told(BALL, "bodies is 'many'", options=("--limit", "bodies=many")),
    "limit of nan": told(BALL, "bodies is 'nan'", options=("--limit", "bodies=nan")),
    "limit of 0": told(BALL, "bodies is '0'", options=("--limit", "bodies=0")),
    "limit twice": told(BALL, "bodies stands twice", options=("--limit", "bodies=5", "--limit", "bodies=6")),
    "limit in a broken environment": Fault(BALL, ("PLUMBLINE_LIMITS", "'bodies'"), environment={"PLUMBLINE_LIMITS": "bodies"}),
    "limit by the environment": Fault(many(3), ("at most 2",), "json", environment={"PLUMBLINE_LIMITS": "bodies=2"}),
}
STUDIES: dict[str, Fault] = {
    "a name that is a path": told(STUDY.replace('"own"', '"../escaped"'), "name", "'../escaped'"),
    "a name that is an absolute path": told(STUDY.replace('"own"', '"/tmp/escaped"'), "name", "'/tmp/escaped'"),
    "a name that is the folder itself": told(STUDY.replace('"own"', '"."'), "name", "'.'"),
    "a name that is the folder above": told(STUDY.replace('"own"', '".."'), "name", "'..'"),
    "a name with backslashes": told(STUDY.replace('"own"', "'..\\own'"), "name"),
    "a name like an option": told(STUDY.replace('"own"', '"--out"'), "name", "'--out'"),
    "a name too long for a folder": told(STUDY.replace("own", "x" * 150), "name"),
    "an empty name": told(STUDY.replace("own", ""), "name"),
    "a title of a megabyte": told("title = '" + "x" * 1_000_000 + "'\n" + STUDY, "title", "2000"),
    "no experiments": told("name = 'own'\nexperiments = []", "experiments", "empty"),
    "two experiments of a name": told(STUDY + STUDY.partition("\n")[2], "'e' stands 2 times"),
    "a time step twice": study("dt = [0.01, 0.01]", f"{ONE} dt", "0.01 stands twice"),
    "a time step twice in two ways": study("dt = [1, 1.0]", f"{ONE} dt", "1.0 stands twice"),
    "a track twice": study("tracks = ['tuned', 'tuned']", f"{ONE} tracks", "'tuned' stands twice"),
    "a case twice": without("cases", "cases = ['flight_box', 'flight_box']", f"{ONE} cases", "'flight_box' stands twice"),
    "an engine twice": without("engines", "engines = ['dart', 'dart']", f"{ONE} engines", "'dart' stands twice"),
    "a parameter's value twice": study("parameters = { mass = [1.0, 1] }", "parameters > mass", "1 stands twice"),
    "a number of workers twice": study("workers = [2, 2]", f"{ONE} workers", "2 stands twice"),
    "a clock twice": study("clocks = ['work', 'work']", f"{ONE} clocks", "'work' stands twice"),
    "a variant twice": study("variants = ['a/b', 'a/b']", f"{ONE} variants", "'a/b' stands twice"),
    "an unknown case beside a known one": without(
        "cases", "cases = ['flight_box', 'flight_bos']", "'e'", "cases", "'flight_bos'"
    ),
    "an unknown case left out": study("without = ['flight_bos']", "'e'", "without", "'flight_bos'"),
    "an unknown engine beside a known one": without("engines", "engines = ['dart', 'drat']", "'e'", "engines", "'drat'"),
    "an unknown variant": study("variants = ['mujoco/fast']", "'e'", "variants", "'mujoco/fast'"),
    "a variant of an unknown engine": told(STUDY + "[variants.drat.fast]\nsubsteps = 2", "variants", "'drat'"),
    "a variant called as a track": told(STUDY + "[variants.dart.tuned]\nsubsteps = 2", "'dart/tuned'"),
    "no engine": without("engines", "engines = []", f"{ONE} engines", "empty"),
    "no case": without("cases", "cases = []", f"{ONE} cases", "empty"),
    "no time step": study("dt = []", f"{ONE} dt", "empty"),
    "no value of a parameter": study("parameters = { mass = [] }", "parameters > mass", "empty"),
    "a parameter that there is not": study("parameters = { colour = [1] }", "'flight_projectile' has no parameter 'colour'"),
    "a text for a parameter": study("parameters = { mass = ['heavy'] }", "parameter 'mass'", "'heavy'", "number"),
    "true for a parameter": study("parameters = { mass = [true] }", "parameter 'mass'", "true"),
    "a parameter without a scene": study(
        "parameters = { mass = [-1.0] }", "'flight_projectile'", "'mass'", "-1.0", "greater than 0"
    ),
    "nan for a parameter": study("parameters = { mass = [nan] }", "parameters > mass", "nan"),
    "a vector's parameter": study("parameters = { velocity = [1.0] }", "parameter 'velocity'", "cannot set it"),
    "a deadline of 1e300 s": study("deadline = 1e300", f"{ONE} deadline", "1e+300"),
    "a deadline of 1e-300 s": study("deadline = 1e-300", f"{ONE} deadline", "1e-300"),
    "a deadline of nan": study("deadline = nan", f"{ONE} deadline", "nan"),
    "a negative deadline": study("deadline = -1.0", f"{ONE} deadline", "-1.0"),
    "a deadline in words": study("deadline = '60'", f"{ONE} deadline", "'60'"),
    "a deadline of true": study("deadline = true", f"{ONE} deadline", "true"),
    "a memory of 1e300 MB": study("memory = 1e300", f"{ONE} memory", "1e+300"),
    "a memory of 0 MB": study("memory = 0", f"{ONE} memory", "got 0"),
    "1e9 workers": study("workers = [1_000_000_000]", f"{ONE} workers", "1000000000"),
    "half a worker": study("workers = [0.5]", f"{ONE} workers", "0.5"),
    "1e9 samples": study("samples = 1_000_000_000", f"{ONE} samples", "1000000000"),
    "samples in words": study("samples = '5'", f"{ONE} samples", "'5'"),
    "1e9 processes": study("processes = 1_000_000_000", f"{ONE} processes", "1000000000"),
    "samples of 1e300 s": study("sample_seconds = 1e300", f"{ONE} sample_seconds", "1e+300"),
    "samples of 0 s": study("sample_seconds = 0.0", f"{ONE} sample_seconds", "got 0.0"),
    "a sweep of 1e9": study("sweep = 1_000_000_000", f"{ONE} sweep", "1000000000"),
    "a time step of 1e-30 s": study("dt = [1e-30]", f"{ONE} dt", "1e-30"),
    "a time step of 1e30 s": study("dt = [1e30]", f"{ONE} dt", "1e+30"),
    "a time step of 0 s": study("dt = [0.0]", f"{ONE} dt", "got 0.0"),
    "a time step in words": study("dt = ['0.01']", f"{ONE} dt", "'0.01'"),
    "timing of 1": study("timing = 1", f"{ONE} timing", "got 1"),
    "an unknown field": study("dead_line = 5", f"{ONE} dead_line", "got 5"),
    "1e9 sub-steps of a variant": told(
        STUDY + "[variants.dart.fast]\nsubsteps = 1_000_000_000", "variants > dart > fast", "substeps"
    ),
    "a tolerance of 2": told(STUDY + "[variants.dart.fast]\ntolerance = 2.0", "variants > dart > fast", "tolerance"),
    "infinity as an option": told(STUDY + "[variants.dart.fast]\noptions = { x = inf }", "variants > dart > fast", "options"),
    "a limit along nothing": study("limit = { along = 'colour' }", "'colour'", "expected one of"),
    "a limit with 1e9 members": study("limit = { along = 'dt', members = 1_000_000_000 }", "limit > members", "1000000000"),
    "an engine twice on the command line": study(
        "", "engine 'dart'", "twice", options=("--engine", "dart", "--engine", "dart")
    ),
    "an unknown engine on the command line": study("", "'drat'", options=("--engine", "dart", "--engine", "drat")),
    "a pattern twice on the command line": study("", "case pattern 'f*'", "twice", options=("--case", "f*", "--case", "f*")),
    "an unknown case on the command line": study(
        "", "case pattern 'flight_bos'", "names no case", options=("--case", "f*", "--case", "flight_bos")
    ),
    "an escape sequence on the command line": study("", "case pattern", options=("--case", "\x1b[31m")),
    "an unknown option with an escape sequence": study("", "no option", options=("--\x1b[31m",)),
    "0 workers on the command line": study("", "--workers", options=("--workers", "0")),
    "1e99 workers on the command line": study("", "--workers", options=("--workers", "9" * 99)),
    "a shard of 0": study("", "--shard", options=("--shard", "0/4")),
    "a shard of superscripts": study("", "--shard", options=("--shard", "²/4")),
    "a shard of 5000 digits": study("", "--shard", options=("--shard", "1/" + "9" * 5000)),
}
FAMILIES = {"file": KIND, "text": TEXT, "values": VALUES, "limits": LIMITS, "study": STUDIES}
FAULTS = {(family, name): fault for family, faults in FAMILIES.items() for name, fault in faults.items()}
USAGE = {
    ("limits", "limit that is none"),
    ("limits", "limit without a number"),
    ("limits", "limit of nan"),
    ("limits", "limit of 0"),
    ("limits", "limit twice"),
    ("limits", "limit in a broken environment"),
}


def names_the_file(family: str, name: str) -> bool:
    """What is wrong with the command line or the environment names that instead."""
    return (family, name) not in USAGE and "command line" not in name and not name.startswith(("a shard", "an unknown option"))
