"""What takes a tenth of a second or more to load: which command may, in one table, and what a fork server has of SciPy."""

import json
import subprocess
import sys
from pathlib import Path

from plumbline.harness.run.fork_servers import preloads
from plumbline.harness.scene import Body, Imu, Scene
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.study import plugins
from tests.robot_files import urdf
from tests.run_folder import write_run_folder

HEAVY = (
    *("altair", "dartpy", "jinja2", "mujoco", "networkx", "numba", "numpy", "pandas", "PIL", "pyarrow", "pybullet", "pydantic"),
    *("rerun", "rich", "scipy.integrate", "scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.spatial"),
    *("scipy.special", "scipy.stats", "trimesh", "vl_convert"),
)
BRINGS: tuple[tuple[str, set[str]], ...] = (
    ("--help", set()),
    ("run --help", set()),
    ("findings", {"pydantic", "rich"}),
    ("cases", {"numpy"}),
    ("scene show robot.urdf --root fixed", set()),
    ("show run", {"pandas", "pyarrow"}),
    ("verify run", set()),
    ("select run --need friction", set()),
    ("diff run run", {"scipy.special"}),
    ("report run", {"jinja2", "scipy.special"}),
)
"""Commands in the order in which one process carries them out, and what each may load beyond those before it."""
CALL = """
import json, sys
from contextlib import redirect_stdout, suppress
from plumbline.harness.cli.main import main
there = set()
for command in json.loads(sys.argv[1]):
    with redirect_stdout(sys.stderr), suppress(SystemExit):
        main(command.split())
    now = {name for name in json.loads(sys.argv[2]) if name in sys.modules}
    print(json.dumps(sorted(now - there)))
    there = now
"""


DRAWS = """
def javascript_bundle(*_, **__): return ""
def vegalite_to_svg(*_, **__): return "<svg/>"
"""
"""What stands for the library that draws: whether it is loaded is asked, and each picture takes a JavaScript engine's time."""


def test_a_command_loads_no_library_that_it_does_not_use(tmp_path: Path) -> None:
    (tmp_path / "vl_convert.py").write_text(DRAWS, encoding="utf-8")
    (tmp_path / "robot.urdf").write_text(urdf(), encoding="utf-8")
    write_run_folder(tmp_path / "run", only=("flight_projectile",))
    asked = [sys.executable, "-c", CALL, json.dumps([command for command, _ in BRINGS]), json.dumps(HEAVY)]
    done = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run" / "report" / "index.html").is_file()
    brought = dict(zip([command for command, _ in BRINGS], map(json.loads, done.stdout.splitlines()), strict=True))
    assert {command: found for command, may in BRINGS if (found := set(brought[command]) - may)} == {}


def test_a_fork_server_has_the_filter_of_noise_where_a_scene_has_an_inertial_unit(tmp_path: Path) -> None:
    modules = []
    for sensors in ((), (Imu(name="unit", body="ball", rate=60.0),)):
        path = tmp_path / f"{len(sensors)}.toml"
        path.write_text(dump_toml(Scene(bodies=(Body(name="ball"),), sensors=sensors)), encoding="utf-8")
        name = f"{plugins.SCENE_PREFIX}{path}"
        modules.append(preloads({name: plugins.case(name)}, {}))
    assert ["scipy.signal" in loaded for loaded in modules] == [False, True]
