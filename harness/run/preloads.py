"""What the processes of a run need, whatever their trial: it is loaded once, by the server that they come off."""

from collections.abc import Mapping

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.scene import Imu
from plumbline.harness.study import plugins, sources

_QUESTIONS = (
    "plumbline.cases",
    "plumbline.harness.metric",
    "plumbline.harness.metrics",
    "plumbline.harness.props",
    "plumbline.harness.sensors",
    "plumbline.harness.truths",
)
"""Where SciPy is imported within functions, so that a listing need not wait for it, and where trials call them."""
_OWN_SCENE = "plumbline.harness.case.scene_file"
_NOISE = "plumbline.harness.sensors.imu_noise"
"""What every scene of a user's own imports and inertial units alone call: its filter costs as much as all else together."""


def preloads(cases: Mapping[str, Case], engines: Mapping[str, Adapter]) -> tuple[str, ...]:
    """The modules of built-in cases and adapters, those of SciPy that the cases name, and the compiler of our own engine.

    A third party's modules are left to its processes: one that dies of them takes no server along. A vendor's package is in
    the server of its engine alone (`Adapter.loads`).
    """
    questions = [module for name in cases if (module := _built_in("cases", name))]
    adapters = [module for name in engines if (module := _built_in("adapters", name))]
    asked = [module for module in sources.closure(questions) if module.startswith(tuple(f"{room}." for room in _QUESTIONS))]
    scenes = (case.scene(case.parameters) for case in cases.values())
    if _NOISE in asked and not any(isinstance(sensor, Imu) for scene in scenes for sensor in scene.sensors):
        asked = [module for module in asked if module != _NOISE]
    compiled = any(module.startswith("plumbline.engine.") for engine in engines.values() for module in engine.loads)
    builders = [f"{module}.build" for module in adapters]
    return (*questions, *adapters, *builders, *sorted(sources.named(asked, "scipy")), *(["numba"] if compiled else []))


def _built_in(kind: str, name: str) -> str | None:
    """The module of a built-in plug-in; None for a third party's."""
    if name.startswith(plugins.SCENE_PREFIX):
        return _OWN_SCENE
    module = plugins.module_of(kind, name)
    return module if module is not None and module.startswith(f"plumbline.{kind}.") else None
