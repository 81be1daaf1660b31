"""What is said to help where a simulation breaks, each tried as it stands in textbooks and manuals.

Sources: Ericson, Real-Time Collision Detection (2005), section 2.4.3 (tunnelling); Catto, Solver2D (2024) (sub-steps rather
than iterations); Bender, Erleben, Trinkle, Interactive Simulation of Rigid Body Dynamics in Computer Graphics, Computer
Graphics Forum 33 (2014) 246 (iterations, damping, time steps); Hairer, Lubich, Wanner, Geometric Numerical Integration (2006),
chapter I (symplectic integrators); the PyBullet Quickstart Guide and MuJoCo's documentation, chapter Modeling (sizes, masses);
the documentation of an engine for what its adapter names (`Adapter.remedies`).
"""

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import Alteration
from plumbline.harness.scene import Effect
from plumbline.harness.study.axes import axis_of
from plumbline.harness.study.one_knob import position, turned
from plumbline.harness.study.trial import Trial

DAMPING = 1.0
"""Added to every body [1/s]: a motion halves in 0.7 s."""
SPLIT = 4
"""By what a time step is divided, and by what sub-steps are multiplied."""


def remedied(sick: Trial, case: Case, adapter: Adapter, number: int, idle: Collection[tuple[str, Any]] = ()) -> Iterator[Trial]:
    """The trial that broke once more with each remedy that the engine and the case know, in round `number`.

    Args: idle: knobs and values that would change nothing there.
    """

    def tried(remedy: str, **changes: Any) -> Trial:
        return sick.probing(case, remedy=remedy, remedied=sick.trial, round=number, **changes)

    def settled(remedy: str, **settings: Any) -> Trial:
        return tried(remedy, settings=replace(sick.settings, **settings, source=f"remedy: {remedy}"))

    knobs, now = adapter.knobs, sick.settings
    along_step = axis_of(sick.experiment, case).parameter == "dt"
    if "substeps" in knobs:
        yield settled(f"sub-steps x {SPLIT}", substeps=SPLIT * (now.substeps or 1))
        if not along_step:
            yield settled(f"time step / {SPLIT}", dt=now.dt / SPLIT)
    elif not along_step:
        # Without sub-steps of its own an engine takes shorter steps: the same to it as to divide the time step.
        yield settled(f"sub-steps x {SPLIT}", dt=now.dt / SPLIT)
    most = max((value for value in knobs.get("iterations", ()) if value is not None), default=0)
    if most > (now.iterations or 0) and ("iterations", most) not in idle:
        yield settled("more iterations", iterations=most)
    for knob in ("solver", "integrator"):
        for value in knobs.get(knob, ()):
            if value is not None and value != getattr(now, knob) and (knob, value) not in idle:
                yield settled(f"{knob} {value}", **{knob: value})
    scene = sick.scene(case)
    for remedy, (knob, value) in adapter.remedies.items():
        if knob in adapter.knobs_in(scene) and position(now, knob) != value:
            yield tried(remedy, settings=replace(turned(now, knob, value), source=f"remedy: {remedy}"))
    if Effect.CONTACT in scene.effects and Effect.CONTINUOUS_COLLISION not in scene.effects:
        yield tried(
            "continuous collision", alteration=Alteration(name="continuous collision", widen=Effect.CONTINUOUS_COLLISION)
        )
    yield tried("damping", alteration=Alteration(name="damping", linear_damping=DAMPING, angular_damping=DAMPING))
    for name, parameters in case.eased.items():
        yield tried(name, parameters={**sick.parameters, **parameters})
