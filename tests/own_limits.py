"""Engines run on a ladder of time steps in this process, for tests of who is said to agree: scenes, planted engines, limits."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, cast

from plumbline.harness.adapter import Adapter, Diverged, Settings, Simulation
from plumbline.harness.findings.agreement.judgement import judged
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.scene import (
    Body,
    Box,
    Drive,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    Sphere,
    Surface,
    axis_angle,
    box_inertia,
    sphere_inertia,
)
from plumbline.harness.search.own_limits import OwnLimit, Rung, own_limit
from plumbline.harness.study import plugins
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trajectory.parting import extent
from plumbline.harness.trial.simulate import simulate
from tests.planted_faults.planting import every_body, gravity_times, plant

__all__ = [
    "G",
    "ENGINES",
    "LADDER",
    "agreement",
    "arm",
    "ball",
    "double_pendulum",
    "explosive",
    "heavier_to_turn",
    "pendulum",
    "pile",
    "restless",
]

G = 9.81
ENGINES = ("mujoco", "bullet", "dart")
"""The engines that people can deploy."""
LADDER = tuple(1 / 240 / 2**k for k in range(5))


def ball() -> Scene:
    """A sphere thrown up and aside in the void, spinning."""
    shape = PlacedShape(shape=Sphere(radius=0.1))
    body = Body(
        name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4), w_WB=(0, 5, 0), collision=(shape,)
    )
    return Scene(bodies=(body,), surfaces=(Surface(between=("default", "default"), static_friction=0, kinetic_friction=0),))


def pendulum(start: float = 1.0, length: float = 1.0) -> Scene:
    """A bar-bell on a weightless rod, let go at an angle [rad]: its inertia decides its period."""
    bob = Body(
        name="bob",
        inertia=sphere_inertia(1.0, 0.4),
        p_WB=(length * math.sin(start), 0, -length * math.cos(start)),
        q_WB=axis_angle((0, -1, 0), start),
    )
    hinge = Revolute(name="hinge", parent="world", child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0))
    return Scene(bodies=(bob,), joints=(hinge,))


def double_pendulum() -> Scene:
    """Two rods of a metre, the first level and the second upright on its end: chaotic from the first swing on."""
    half = (0.5, 0.02, 0.02)
    upper = Body(name="upper", inertia=box_inertia(1.0, half), p_WB=(0.5, 0, 0))
    lower = Body(name="lower", inertia=box_inertia(1.0, half), p_WB=(1, 0, 0.5), q_WB=axis_angle((0, 1, 0), -math.pi / 2))
    first = Revolute(name="first", parent="world", child="upper", anchor_W=(0, 0, 0), axis_W=(0, 1, 0))
    second = Revolute(name="second", parent="upper", child="lower", anchor_W=(1, 0, 0), axis_W=(0, 1, 0))
    return Scene(bodies=(upper, lower), joints=(first, second))


def arm() -> Scene:
    """Three links of 3, 2 and 1 kg held out level by driven hinges, with shapes to collide with."""
    bodies, joints, reach, above = [], [], 0.0, "world"
    for k, (length, mass, target) in enumerate(((0.4, 3.0, 0.5), (0.35, 2.0, -0.6), (0.25, 1.0, 0.4))):
        shape = PlacedShape(shape=Box(half_extents=(length / 2 - 0.02, 0.03, 0.03)))
        bodies.append(
            Body(
                name=f"link_{k}",
                mass=mass,
                inertia=box_inertia(mass, (length / 2, 0.03, 0.03)),
                p_WB=(reach + length / 2, 0, 0),
                collision=(shape,),
            )
        )
        drive = Drive(stiffness=200.0, damping=20.0, target=target)
        joints.append(
            Revolute(name=f"j{k}", parent=above, child=f"link_{k}", anchor_W=(reach, 0, 0), axis_W=(0, 1, 0), drive=drive)
        )
        reach, above = reach + length, f"link_{k}"
    return Scene(bodies=tuple(bodies), joints=tuple(joints), surfaces=(_rough(),))


def pile(count: int = 4) -> Scene:
    """Turned boxes, one above the other, that fall on a plane."""
    half = (0.1, 0.08, 0.06)
    boxes = tuple(
        Body(
            name=f"box_{k}",
            inertia=box_inertia(1.0, half),
            p_WB=(0.02 * k, -0.03 * k, 0.2 + 0.3 * k),
            q_WB=axis_angle((1.0, 0.3 * k, -0.5), 0.7 + k),
            collision=(PlacedShape(shape=Box(half_extents=half)),),
        )
        for k in range(count)
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    return Scene(bodies=(ground, *boxes), surfaces=(_rough(),))


def _rough() -> Surface:
    return Surface(between=("default", "default"), static_friction=0.5, kinetic_friction=0.5)


def heavier_to_turn(factor: float = 1.2) -> Callable[[Adapter], Adapter]:
    """A fault: every body is as much harder to turn."""

    def change(body: Body) -> Body:
        inertia = tuple(tuple(factor * value for value in row) for row in body.inertia)
        return replace(body, inertia=inertia) if body.movable else body

    return partial(plant, scene=every_body(change))


class _Exploding:
    """A simulation whose first step leaves the numbers."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def step(self, count: int = 1) -> None:
        raise Diverged(f"not finite after {count} steps")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._simulation, name)


@dataclass(frozen=True, kw_only=True)
class _Explosive(Adapter):
    """An engine that leaves the numbers at long time steps."""

    inner: Adapter
    stable: float

    def version(self) -> str:
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        simulation = self.inner.build(scene, settings)
        return cast(Simulation, _Exploding(simulation)) if settings.dt > self.stable else simulation


def explosive(stable: float) -> Callable[[Adapter], Adapter]:
    """A fault: nothing is finite at time steps beyond this one [s]."""

    def fault(inner: Adapter) -> Adapter:
        return _Explosive(
            name=inner.name,
            title=inner.title,
            distribution=inner.distribution,
            features=inner.features,
            tracks=inner.tracks,
            inner=inner,
            stable=stable,
        )

    return fault


@dataclass(frozen=True, kw_only=True)
class _Restless(Adapter):
    """An engine whose gravity depends on the time step, without rhyme or reason."""

    inner: Adapter

    def version(self) -> str:
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        rung = round(math.log2(1 / 240 / settings.dt))
        factor = (1.0, 1.07, 0.96, 1.04, 0.97, 1.06, 0.95)[rung % 7]
        return self.inner.build(gravity_times(scene, factor), settings)


def restless(adapter: Adapter) -> Adapter:
    """A fault: it ends elsewhere at every time step, by some per cent of gravity."""
    return _Restless(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        inner=adapter,
    )


def agreement(
    scene: Scene,
    duration: float,
    faults: Mapping[str, Callable[[Adapter], Adapter]] | None = None,
    *,
    engines: tuple[str, ...] = ENGINES,
    ours: tuple[str, ...] = ("reference",),
    tracks: tuple[str, ...] = ("tuned",),
    ladder: tuple[float, ...] = LADDER,
) -> Agreement:
    """What engines are said to agree on, the named ones with a fault. A name 'mujoco again' is MuJoCo under another name."""
    limits: dict[tuple[str, str], OwnLimit] = {}
    scale = extent(scene)
    for name in engines:
        fault = (faults or {}).get(name)
        for track in tracks:
            asked = name.split()[0], track, scene, duration, ladder
            limits[name, track] = own_limit(scale, _sound(*asked) if fault is None else _climb(*asked, fault))
    return judged(scene, duration, limits, ours)


def _climb(
    name: str,
    track: str,
    scene: Scene,
    duration: float,
    ladder: tuple[float, ...],
    fault: Callable[[Adapter], Adapter] = lambda adapter: adapter,
) -> tuple[Rung, ...]:
    adapter = fault(plugins.adapter(name))
    return tuple(_rung(adapter, scene, duration, adapter.tracks[track].with_dt(dt)) for dt in ladder)


_sound = cache(_climb)
"""Without a fault: run once, whichever tests ask for it."""


def _rung(adapter: Adapter, scene: Scene, duration: float, settings: Settings) -> Rung:
    simulation = adapter.build(scene, settings)
    try:
        run, broke = simulate(
            simulation,
            scene,
            pace=Pace(settings.dt),
            duration=duration,
            sample_interval=1 / 60,
            with_contacts=False,
            seed=0,
        )
        substeps = simulation.resolved.substeps or 1
    finally:
        simulation.close()
    status, reason = ("passed", "") if broke is None else ("diverged", broke)
    return Rung(
        dt=settings.dt,
        substep=settings.dt / substeps,
        trial="",
        status=status,
        reason=reason,
        run=run if broke is None else None,
    )
