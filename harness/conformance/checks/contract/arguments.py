"""Checks of the door: arrays of a wrong shape, type or content are refused before the engine sees them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation
from harness.conformance.check import Comparison, Finding, check, judge, near, that
from harness.conformance.runs import COARSE, FINE, built, state_of
from harness.conformance.scenes import free, static, without_gravity
from harness.scene import WORLD, Box, Drive, Prismatic, Scene, Sphere
from harness.trajectory import State


@check("Are arrays that a state does not fit into refused by name?", firm=True)
def bad_states_are_refused(adapter: Adapter, settings: Settings) -> Finding:
    scene = without_gravity(free(), free("other", p=(5.0, 0.0, 0.0)))
    good, comparisons = State.empty(_BODIES), []
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        bad: Any
        for name, width in (("p_WB", 3), ("q_WB", 4), ("v_WB", 3), ("w_WB", 3)):
            for what, bad in (
                ("one body short", np.zeros((1, width))),
                ("one body too long", np.zeros((3, width))),
                ("flat", np.zeros(_BODIES * width)),
                ("of float32", np.zeros((_BODIES, width), dtype=np.float32)),
            ):
                out = replace(good, **{name: bad})
                comparisons.append(_refused(simulation, name, f"{name} {what}", lambda s, out=out: s.state(out)))  # type: ignore[misc]
    return judge(*comparisons)


_BODIES = 2


def _refused(simulation: Simulation, named: str, what: str, call: Callable[[Simulation], object]) -> Comparison:
    """Is the call a ValueError that names the argument? Anything else, an answer or another exception, is a failure."""
    try:
        call(simulation)
    except ValueError as error:
        return that(named in str(error), f"{what}: got ValueError {str(error)!r}, expected it to name {named!r}")
    except Exception as error:
        return that(False, f"{what}: got {type(error).__name__}: {error}, expected ValueError")
    return that(False, f"{what}: got no error, expected ValueError")


def _bad_vectors() -> dict[str, Any]:
    """What is no (2, 3) array of finite numbers of double precision."""
    holed = np.zeros((_BODIES, 3))
    holed[1, 2] = np.nan
    return {
        "(3,)": np.zeros(3),
        "(3, 3) for two bodies": np.zeros((3, 3)),
        "(1, 3) for two bodies": np.zeros((1, 3)),
        "(2, 2)": np.zeros((_BODIES, 2)),
        "(0, 3)": np.zeros((0, 3)),
        "NaN": holed,
        "Inf": np.full((_BODIES, 3), np.inf),
        "float32": np.zeros((_BODIES, 3), dtype=np.float32),
        "whole numbers": np.zeros((_BODIES, 3), dtype=np.int64),
        "a list": [[0.0, 0.0, 0.0]] * _BODIES,
    }


@check(
    "Are forces and torques of a wrong shape, type or content refused by name, and nothing of them kept?",
    Feature.WRENCH,
    firm=True,
)
def bad_wrenches_are_refused(adapter: Adapter, settings: Settings) -> Finding:
    """Each bad array as force and as torque; afterwards the bodies fly on as if nothing had been said."""
    scene = without_gravity(free(v=(1.0, 0.0, 0.0)), free("other", p=(5.0, 0.0, 0.0)))
    good, comparisons = np.zeros((_BODIES, 3)), []
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        for what, bad in _bad_vectors().items():
            comparisons.append(_refused(simulation, "f_B_W", f"force {what}", lambda s, bad=bad: s.wrench(bad, good)))  # type: ignore[misc]
            comparisons.append(_refused(simulation, "tau_B_W", f"torque {what}", lambda s, bad=bad: s.wrench(good, bad)))  # type: ignore[misc]
        simulation.step(10)
        end = state_of(simulation, scene)
    comparisons.append(
        near("p_WB afterwards [m]", end.p_WB, [(0.01, 0.0, 0.0), (5.0, 0.0, 0.0)], 1e-5, "v t: nothing bad was kept")
    )
    return judge(*comparisons)


@check("Are rays of a wrong shape, type, content or length refused by name, and a reach that is none?", Feature.RAYS, firm=True)
def bad_rays_are_refused(adapter: Adapter, settings: Settings) -> Finding:
    shape = Box(half_extents=(0.5, 0.5, 0.5)) if Feature.BOX in adapter.features else Sphere(radius=0.5)
    scene = Scene(bodies=(static("target", shape),))
    o, d = np.tile((5.0, 0.0, 0.0), (_BODIES, 1)), np.tile((-1.0, 0.0, 0.0), (_BODIES, 1))
    comparisons = []
    with built(adapter, scene, settings) as simulation:
        for what, bad in _bad_vectors().items():
            comparisons.append(_refused(simulation, "origins", f"origins {what}", lambda s, bad=bad: s.cast(bad, d, 9.0)))  # type: ignore[misc]
            if what not in {"(1, 3) for two bodies", "(3, 3) for two bodies", "(0, 3)"}:
                comparisons.append(
                    _refused(simulation, "directions", f"directions {what}", lambda s, bad=bad: s.cast(o, bad, 9.0))  # type: ignore[misc]
                )
        for what, long in (("of length 2", 2.0), ("of length 0", 0.0), ("of length 1.00001", 1.00001)):
            comparisons.append(
                _refused(simulation, "direction", f"directions {what}", lambda s, long=long: s.cast(o, long * d, 9.0))  # type: ignore[misc]
            )
        for reach in (0.0, -1.0, float("nan"), float("inf")):
            comparisons.append(
                _refused(simulation, "max_range", f"max_range {reach}", lambda s, reach=reach: s.cast(o, d, reach))  # type: ignore[misc]
            )
        ranges = simulation.cast(o, d, 9.0).distance
    comparisons.append(near("ranges of good rays afterwards [m]", ranges, (4.5, 4.5), 1e-5, "rounding in single precision"))
    return judge(*comparisons)


@check(
    "Are targets of joints without a drive and targets that are no finite number refused by name?",
    Feature.PRISMATIC | Feature.DRIVES,
    firm=True,
)
def bad_targets_are_refused(adapter: Adapter, settings: Settings) -> Finding:
    drive = Drive(stiffness=50.0, damping=20.0)
    driven = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0), drive=drive)
    loose = replace(driven, name="loose", child="other", drive=None)
    scene = Scene(bodies=(free(), free("other", p=(0.0, 5.0, 0.0))), joints=(driven, loose), gravity=(0.0, 0.0, 0.0))
    bad: tuple[tuple[str, Any], ...] = (
        *(("loose", 0.1), ("nobody", 0.1)),
        *(("slide", target) for target in (float("nan"), float("inf"), np.zeros(2), "far")),
    )
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        comparisons = [
            _refused(simulation, name, f"target {target!r} of joint '{name}'", lambda s, n=name, t=target: s.command({n: t}))  # type: ignore[misc]
            for name, target in bad
        ]
        simulation.step(10)
        end = state_of(simulation, scene)
    comparisons.append(near("x of the driven body afterwards [m]", end.p_WB[0, 0], 0.0, 1e-6, "its target is still 0"))
    return judge(*comparisons)
