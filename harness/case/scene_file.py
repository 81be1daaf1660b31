"""A case made of a scene file of the user's own: without a truth, it asks for finiteness and observes conservation."""

from pathlib import Path

from harness.case import Case, Check
from harness.importers.companion import beside, load_companion
from harness.metrics import divergence, energy
from harness.scene import Scene
from harness.scene.file import load

__all__ = ["own_case"]


def own_case(path: Path, prefix: str, duration: float = 5.0) -> Case:
    """The case that asks every engine to carry a scene file through `duration` [s]; its name is `prefix` and the path.

    What the companion file beside it, `NAME.plumb.toml`, says of the duration goes before.

    Raises:
        SceneError: where the file is no scene. RobotError: where its companion is none.
    """
    scene: Scene = load(path)
    duration = load_companion(beside(path)).duration or duration
    return Case(
        name=f"{prefix}{path}",
        title=path.stem,
        question="How does each engine carry this scene, and at what cost?",
        source=f"the file {path.name}",
        truth="conservation",
        scene=lambda: scene,
        checks=(Check(metric=divergence.METRIC, at_most=0.0, because="every number of every sampled state has to be finite"),),
        observe=tuple(metric for metric in energy.METRIC if metric.better == "lower"),
        duration=duration,
        with_contacts=False,
    )
