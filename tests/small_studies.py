"""One small run of each kind of study, and of a scene of one's own: what the pages of a report are looked at with.

Those of a formula are written in a second; the others run through the command line, on engines that come compiled.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

from plumbline.harness.scene import Body, Scene, sphere_inertia
from plumbline.harness.scene.file import dump_toml
from plumbline.reports.html.report import write_report
from tests import study_texts
from tests.run_folder import write_run_folder
from tests.sensor_folder import write_sensor_folder

__all__ = ["STUDIES", "WRITTEN", "report_of"]

WRITTEN: Mapping[str, Callable[[Path], Path]] = {
    "quick": lambda folder: write_run_folder(folder, only=("flight_projectile", "joint_pendulum", "stack_tower")),
    "sensors": write_sensor_folder,
}
RUN = {
    "limits": study_texts.limits(),
    "effects": study_texts.effects(),
    "determinism": study_texts.determinism(),
    "scaling": study_texts.SCALING,
    "tremble": study_texts.TREMBLE,
    "dominance": study_texts.DOMINANCE,
}
OWN = "own scene"
STUDIES = (*WRITTEN, *RUN, OWN)


def report_of(study: str, folder: Path, run: Callable[..., Path]) -> Path:
    """The folder of the report of a small run. Args: run: carries out `plumbline run` with these arguments into a folder."""
    if study in WRITTEN:
        return write_report(WRITTEN[study](folder / "run")).index.parent
    path = folder / ("thrown_ball.toml" if study == OWN else "study.toml")
    if study == OWN:
        ball = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4))
        path.write_text(dump_toml(Scene(bodies=(ball,))), encoding="utf-8")
        engines = ("--engine", "mujoco", "--engine", "bullet", "--duration", "0.5", "--budget", "60")
        return write_report(run(path, folder / "run", *engines)).index.parent
    path.write_text(RUN[study], encoding="utf-8")
    return write_report(run(path, folder / "run")).index.parent
