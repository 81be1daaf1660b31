"""Bodies, surfaces and runs that the tests of DART's adapter share."""

import gc
import sys
from collections.abc import Callable
from dataclasses import replace

from plumbline.adapters.dart import ADAPTER
from plumbline.harness.adapter import Settings, Simulation
from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Drive,
    Limits,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    Shape,
    Spring,
    Surface,
    Vector3,
    box_inertia,
    capsule_inertia,
    principal_inertia,
    sphere_inertia,
)
from plumbline.harness.trajectory import State

__all__ = [
    "CUBE",
    "DEFAULT",
    "FINE",
    "FLOOR",
    "G",
    "PD",
    "TUNED",
    "box_body",
    "calls_of",
    "free_body",
    "ground_body",
    "hinged_wheel",
    "solid_body",
    "state_after",
    "state_of",
    "surface_law",
    "with_options",
]

TUNED, DEFAULT = ADAPTER.tracks["tuned"], ADAPTER.tracks["default"]
FINE = 1e-3
G = 9.81
FLOOR = Plane()
CUBE = tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1))


def calls_of(work: Callable[[], object]) -> int:
    """How many functions of Python and of bindings `work` calls."""
    calls = 0

    def count(_: object, event: str, __: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    usual, collects = sys.getprofile(), gc.isenabled()
    gc.disable()  # whoever listens to the search for garbage is called by it
    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(usual)
        if collects:
            gc.enable()
    return calls


def with_options(dt: float = FINE, track: Settings = TUNED, **options: object) -> Settings:
    return replace(track, dt=dt, options={**track.options, **options})


def state_of(simulation: Simulation, scene: Scene) -> State:
    out = State.empty(len(scene.bodies))
    simulation.state(out)
    return out


def state_after(scene: Scene, duration: float, settings: Settings | None = None) -> State:
    settings = settings or with_options()
    simulation = ADAPTER.build(scene, settings)
    simulation.step(round(duration / settings.dt))
    return state_of(simulation, scene)


def solid_body(name: str, shape: Shape, p: Vector3, material: str = "b", **more: object) -> Body:
    inertia = {
        "sphere": lambda: sphere_inertia(1.0, shape.radius),  # type: ignore[union-attr]
        "capsule": lambda: capsule_inertia(1.0, shape.radius, shape.half_length),  # type: ignore[union-attr]
    }.get(shape.type, lambda: box_inertia(1.0, (0.1, 0.1, 0.1)))()
    return Body(name=name, inertia=inertia, collision=(PlacedShape(shape=shape),), p_WB=p, material=material, **more)  # type: ignore[arg-type]


def box_body(name: str = "box", p: Vector3 = (0.0, 0.0, 0.1), **more: object) -> Body:
    return solid_body(name, Box(half_extents=(0.1, 0.1, 0.1)), p, **more)  # type: ignore[arg-type]


def ground_body(shape: Shape = FLOOR, p: Vector3 = (0.0, 0.0, 0.0)) -> Body:
    return Body(name="ground", motion="static", material="g", collision=(PlacedShape(shape=shape),), p_WB=p)


def surface_law(friction: float = 0.5, restitution: float = 0.0, between: tuple[str, str] = ("g", "b")) -> Surface:
    return Surface(between=between, static_friction=friction, kinetic_friction=friction, restitution=restitution)


def free_body(name: str, p: Vector3 = (0.0, 0.0, 0.0), moment: float = 0.1, **more: object) -> Body:
    return Body(name=name, inertia=principal_inertia(moment, moment, moment), p_WB=p, **more)  # type: ignore[arg-type]


def hinged_wheel(
    position: float = 0.2, limits: Limits | None = None, spring: Spring | None = None, drive: Drive | None = None
) -> Scene:
    hinge = Revolute(
        name="hinge",
        parent=WORLD,
        child="wheel",
        anchor_W=(0.0, 0.0, 0.0),
        axis_W=(0.0, 0.0, 1.0),
        position=position,
        limits=limits,
        spring=spring,
        drive=drive,
    )
    return Scene(bodies=(free_body("wheel", moment=0.5),), joints=(hinge,), gravity=(0.0, 0.0, 0.0))


PD = Drive(stiffness=50.0, damping=5.0, target=1.2, target_velocity=0.3)
