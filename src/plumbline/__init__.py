"""Plumbline: cross-engine validation and benchmarking of rigid-body physics.

    import plumbline

    run = plumbline.run("robot.urdf", engine="mujoco", duration=2.0)      # a Scene, a file, or the name of a case
    run.positions                                                         # (steps + 1, bodies, 3) [m]
    run.frame()                                                           # a DataFrame; run.show() opens rerun

    study = plumbline.compare("robot.urdf", engines=["mujoco", "dart"])   # what `plumbline run` does
    study = plumbline.open("build/compare")                               # the same, later
    study.trials, study.prices                                            # DataFrames; units and meanings in .attrs
    plumbline.select(study, need=["friction"], error=0.01)                # the ranking with its doubt
    plumbline.published()                                                 # a study that ships with the package

A scene is built of the nouns that its TOML has, in SI units and radians:

    scene = plumbline.Scene(bodies=[plumbline.Body(name="ball", mass=1.0, v_WB=(3.0, 0.0, 8.0))])
    print(plumbline.to_toml(scene))

The nouns:

    Scene, Body, PlacedShape, Surface                       what is there, its shapes, and what happens where materials touch
    Box, Sphere, Capsule, Cylinder, Ellipsoid, Plane, ConvexHull, TriangleMesh          shapes
    Revolute, Prismatic, Ball, Fixed, Distance              joints; with Limits, Drive, Spring, Coupling
    Imu, Lidar, Camera, DepthCamera                         sensors, with their noise
    box_inertia, sphere_inertia, ...                        moments of solids

`help(plumbline.run)` and `help(plumbline.Body)` have every argument, with its unit. Below stand the nouns, then the functions.

Wrong input raises `PlumblineError`; the message names file, element, value and what was expected. Each run is a process of
its own, so that an engine that crashes is an outcome with its reason. The names in `__all__` are the interface; all else may
change.

In a checkout, the packages beside `api` are links to the folders of the same names at the top; installed, they are folders.
"""

from enum import Flag
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plumbline.api.compare import compare as compare
    from plumbline.api.motion import Run as Run
    from plumbline.api.published import open_published as published  # noqa: F401  # the name of the interface
    from plumbline.api.ranking import Ranking as Ranking
    from plumbline.api.ranking import select as select
    from plumbline.api.results import Results as Results
    from plumbline.api.results import open_results as open  # noqa: A004, F401  # the name of the interface
    from plumbline.api.run import run as run
    from plumbline.api.sources import load as load
    from plumbline.harness.intake.error import PlumblineError as PlumblineError
    from plumbline.harness.scene import *  # noqa: F403  # the nouns below
    from plumbline.harness.scene.file import to_toml as to_toml

_NOUNS = (
    *("Scene", "Body", "PlacedShape", "Surface", "Effect", "Appearance", "Sun"),
    *("Box", "Sphere", "Capsule", "Cylinder", "Ellipsoid", "Plane", "ConvexHull", "TriangleMesh"),
    *("Revolute", "Prismatic", "Ball", "Fixed", "Distance", "Limits", "Drive", "Spring", "Coupling"),
    *("Prescribed", "Shift", "Turn", "Sinusoid", "Samples"),
    *("Imu", "ImuNoise", "AxisNoise", "Lidar", "LidarNoise", "Camera", "Distortion"),
    *("DepthCamera", "StereoNoise", "StructuredLightNoise", "TimeOfFlightNoise"),
    *("box_inertia", "sphere_inertia", "capsule_inertia", "cylinder_inertia", "ellipsoid_inertia", "principal_inertia"),
    *("axis_angle", "WORLD"),
)
_WHERE = {
    "run": "api.run",
    "compare": "api.compare",
    "open": "api.results",
    "published": "api.published",
    "select": "api.ranking",
    "load": "api.sources",
    "to_toml": "harness.scene.file",
    "Run": "api.motion",
    "Results": "api.results",
    "Ranking": "api.ranking",
    "PlumblineError": "harness.intake.error",
    **dict.fromkeys(_NOUNS, "harness.scene"),
}
"""The room of each public name."""
_CALLED = {"open": "open_results", "published": "open_published"}
"""What it is called there, if not the same."""

__all__ = [*_WHERE]


def __getattr__(name: str) -> Any:
    """A public name, whose room is loaded when it is first asked for: `import plumbline` itself loads nothing."""
    if name not in _WHERE:
        raise AttributeError(f"module 'plumbline' has no attribute {name!r}")
    value = getattr(import_module(f"plumbline.{_WHERE[name]}"), _CALLED.get(name, name))
    if callable(value) and not (isinstance(value, type) and issubclass(value, Exception | Flag)):
        value.__signature__ = import_module("plumbline.api.signatures").readable(value)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
