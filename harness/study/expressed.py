"""Which engines can express a scene: each is asked to build it, in a process of its own."""

from typing import Literal

from plumbline.harness.adapter import Unavailable, Unsupported
from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import elsewhere, project_folders
from plumbline.harness.study.experiment import Experiment

Verdict = Literal["can", "cannot", "unavailable", "failed"]


def expressed_apart(engine: str, scene: Scene) -> tuple[Verdict, str]:
    """Can an engine build a scene, on its track 'tuned'? With the reason where it cannot, or where it gave no answer."""
    adapter = plugins.adapter(engine)
    _, reason = plugins.version_of(adapter)
    if reason is not None:
        return "unavailable", reason
    allowed = Experiment(name="build").deadline + adapter.compile_allowance
    form, home = tuple[Verdict, str], elsewhere(engine)
    try:
        if home is None:
            return apart(form, allowed, expressed, engine, scene)
        return apart(form, allowed, expressed, engine, scene, interpreter=home.executable, path=project_folders())
    except NoAnswer as error:
        return "failed", f"build {error}"


def expressed(engine: str, scene: Scene) -> tuple[Verdict, str]:
    """The same, in the process that is given up to it."""
    adapter = plugins.adapter(engine)
    try:
        simulation: object = adapter.build(scene, adapter.tracks["tuned"])
        if simulation is None:
            return "failed", "build gave None, expected a Simulation"
        simulation.close()  # type: ignore[attr-defined]  # what it is is for `plumbline check`
    except Unavailable as error:
        return "unavailable", str(error)
    except Unsupported as error:
        return "cannot", str(error)
    return "can", ""
