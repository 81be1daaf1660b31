"""One small run of each kind of study, and of a scene of one's own: what the pages of a report are looked at with.

Those of a formula are written in a second; the others run through the command line, on engines that come compiled.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import reports
from harness.scene import Body, Scene, sphere_inertia
from harness.scene.file import dump_toml
from tests.run_folder import write_run_folder
from tests.sensor_folder import write_sensor_folder

__all__ = ["STUDIES", "WRITTEN", "report_of"]

LIMITS = """
name = "small-limits"
recordings = false
[[experiments]]
name = "walls"
cases = ["tunnel_sphere_wall"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
parameters = { continuous = [false] }
timing = false
limit = { members = 2, remedies = ["tuned"], within = 1.5 }
[[experiments]]
name = "steps"
cases = ["tunnel_sphere_wall"]
engines = ["mujoco"]
tracks = ["tuned"]
dt = [0.0041666666666666667, 0.0083333333333333333, 0.016666666666666666]
parameters = { continuous = [false] }
timing = false
limit = { members = 2, within = 2.0, parts = [1] }
"""
EFFECTS = """
name = "small-effects"
recordings = false
[[experiments]]
name = "effects"
cases = ["flight_projectile", "friction_stop"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
effects = true
samples = 2
sample_seconds = 0.002
"""
DETERMINISM = """
name = "small-determinism"
recordings = false
[[experiments]]
name = "determinism"
cases = ["system_determinism"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
timing = false
determinism = true
"""
SCALING = """
name = "small-scaling"
recordings = false
[[experiments]]
name = "pile"
cases = ["stack_pile"]
engines = ["mujoco", "bullet"]
tracks = ["default"]
parameters = { n = [4, 6, 8] }
samples = 2
sample_seconds = 0.002
"""
TREMBLE = """
name = "small-tremble"
recordings = false
[variants.mujoco]
"default law" = { beside = "default", changes = "law", on = "default", integrator = "implicitfast", source = "the study" }
[[experiments]]
name = "coarse"
cases = ["stand_humanoid"]
engines = ["mujoco"]
tracks = ["default"]
dt = [0.004166666666666667]
parameters = { stiffness = [1.0] }
variants = ["*"]
timing = false
"""
WRITTEN: Mapping[str, Callable[[Path], Path]] = {
    "quick": lambda folder: write_run_folder(folder, only=("flight_projectile", "joint_pendulum", "stack_tower")),
    "sensors": write_sensor_folder,
}
RUN = {"limits": LIMITS, "effects": EFFECTS, "determinism": DETERMINISM, "scaling": SCALING, "tremble": TREMBLE}
OWN = "own scene"
STUDIES = (*WRITTEN, *RUN, OWN)


def report_of(study: str, folder: Path, run: Callable[..., Path]) -> Path:
    """The folder of the report of a small run. Args: run: carries out `plumbline run` with these arguments into a folder."""
    if study in WRITTEN:
        return reports.build(WRITTEN[study](folder / "run")).parent
    path = folder / ("thrown_ball.toml" if study == OWN else "study.toml")
    if study == OWN:
        ball = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4))
        path.write_text(dump_toml(Scene(bodies=(ball,))), encoding="utf-8")
        engines = ("--engine", "mujoco", "--engine", "bullet", "--duration", "0.5", "--budget", "4")
        return reports.build(run(path, folder / "run", *engines)).parent
    path.write_text(RUN[study], encoding="utf-8")
    return reports.build(run(path, folder / "run")).parent
