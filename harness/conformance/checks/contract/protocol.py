"""Checks of the contract that need no physics: settings, lazy imports, ownership of arrays, bad arrays refused at the door."""

import ast
import inspect
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature, Notice, SettingsError
from plumbline.harness.conformance.check import CHECKS, Compared, Comparisons, firm, near, said, that
from plumbline.harness.conformance.engine import COARSE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X
from plumbline.harness.conformance.scenes import free, prismatic, static, without_gravity
from plumbline.harness.scene import Box, Drive, Scene, Sphere
from plumbline.harness.trajectory import State

_LIGHT = ("numpy", "scipy", "plumbline.harness")
"""What an adapter file may import when it is loaded, beside the standard library and its own package."""


@firm("Are both tracks there, and does every declared failure name a check that may be excused, with a reason?")
def declarations_are_well_formed(engine: Engine) -> Comparisons:
    adapter = engine.adapter
    known = {f"{track}/{defined.name}" for track in adapter.tracks for defined in CHECKS}
    firm = {f"{track}/{defined.name}" for track in adapter.tracks for defined in CHECKS if not defined.excusable}
    declared = set(adapter.known_failures)
    yield that({"default", "tuned"} <= set(adapter.tracks), f"tracks: got {sorted(adapter.tracks)}, expected default and tuned")
    yield that(declared <= known, f"known_failures names no check: {sorted(declared - known)}")
    yield that(not declared & firm, f"known_failures excuses what must hold on every track: {sorted(declared & firm)}")
    yield that(
        all(reason.strip() for reason in adapter.known_failures.values()),
        f"known_failures without a reason: {sorted(k for k, v in adapter.known_failures.items() if not v.strip())}",
    )
    yield that(bool(adapter.name and adapter.title and adapter.distribution), "name, title and distribution are given")


@firm("Is the version a string?")
def version_is_a_string(engine: Engine) -> Comparisons:
    version = engine.adapter.version()
    yield that(isinstance(version, str) and bool(version.strip()), f"version: got {version!r}, expected a non-empty string")


def loaded_at_once(tree: ast.AST) -> Iterator[str]:
    """The names of modules that are imported when the file is, whatever stands inside functions."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level == 0 and node.module:
                yield node.module
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            for other in node.orelse:
                yield from loaded_at_once(other)
        else:
            yield from loaded_at_once(node)


@firm("Is the vendor's package imported inside functions only?")
def imports_without_its_vendor(engine: Engine) -> Comparisons:
    adapter = engine.adapter
    source = inspect.getsourcefile(type(adapter))
    if source is None:
        yield that(False, f"{type(adapter).__qualname__}: no source file to read its imports from")
        return
    parts = type(adapter).__module__.split(".")
    own = ".".join(parts[:3] if parts[0] == "plumbline" else parts[:1])
    allowed = {*_LIGHT, *sys.stdlib_module_names, *({own} - {adapter.distribution, adapter.name})}
    tree = ast.parse(Path(source).read_text(encoding="utf-8"))
    heavy = sorted(
        {name for name in loaded_at_once(tree) if not any(f"{name}.".startswith(f"{module}.") for module in allowed)}
    )
    yield that(
        not heavy, f"imports outside of functions: got {', '.join(heavy) or 'none'} beyond {', '.join(_LIGHT)}, expected none"
    )


@firm("Does the simulation say which step, integrator and solver it really uses?")
def resolved_settings_are_complete(engine: Engine) -> Comparisons:
    asked = engine.at(1 / 500)
    with engine.built(Scene(bodies=(free(),)), asked.dt) as simulation:
        got = simulation.resolved
    dropped = [
        name
        for name in ("substeps", "iterations", "integrator", "solver", "tolerance")
        if getattr(asked, name) is not None and getattr(got, name) is None
    ]
    yield near("resolved dt [s]", got.dt, asked.dt, 1e-9 * asked.dt, "the step is the harness's choice")
    yield that(not dropped, f"resolved leaves open what was asked for: {dropped}")
    yield that(got.integrator is not None, f"resolved integrator: got {got.integrator!r}, expected its name, default or not")


def _refusal_of(engine: Engine, name: str, **changed: Any) -> Comparisons:
    try:
        engine.adapter.build(Scene(bodies=(free(),)), replace(engine.settings, **changed)).close()
    except SettingsError as error:
        yield that(name in str(error), f"SettingsError {str(error)!r} does not name {name!r}")
    else:
        yield that(False, f"{name}: got a simulation, expected SettingsError")


@firm("Is an option that the adapter does not know an error that names it?")
def unknown_option_is_refused(engine: Engine) -> Comparisons:
    return _refusal_of(engine, "no_such_option", options={**engine.settings.options, "no_such_option": 1})


@firm("Is an integrator that the engine does not have an error that names it?")
def unknown_integrator_is_refused(engine: Engine) -> Comparisons:
    return _refusal_of(engine, "no_such_integrator", integrator="no_such_integrator")


@firm("Is a solver that the engine does not have an error that names it?")
def unknown_solver_is_refused(engine: Engine) -> Comparisons:
    return _refusal_of(engine, "no_such_solver", solver="no_such_solver")


@firm("May close be called twice?")
def close_may_be_called_twice(engine: Engine) -> Comparisons:
    simulation = engine.adapter.build(Scene(bodies=(free(),)), engine.settings)
    simulation.step()
    simulation.close()
    simulation.close()
    yield said("closed twice without an exception")


@firm("Are warnings a tuple of strings or notices?")
def warnings_are_strings(engine: Engine) -> Comparisons:
    with engine.built(Scene(bodies=(free(),)), None) as simulation:
        simulation.step(2)
        got = simulation.warnings()
    yield that(
        isinstance(got, tuple) and all(isinstance(warning, str | Notice) for warning in got),
        f"warnings: got {got!r}, expected a tuple of str or Notice",
    )


@firm("Is the whole state copied into the caller's arrays, so that it stays as it was?")
def state_is_written_into_the_given_arrays(engine: Engine) -> Comparisons:
    scene = without_gravity(free("a", q=TURNED, w=(1.0, 2.0, 3.0)), free("b", p=(3.0, 0.0, 0.0), v=(1.0, 0.0, 0.0)))
    with engine.built(scene, COARSE) as simulation:
        first = state_of(simulation, scene)
        kept = first.p_WB.copy(), first.q_WB.copy(), first.v_WB.copy(), first.w_WB.copy()
        simulation.step(10)
        second = state_of(simulation, scene)
    yield that(first.finite and second.finite, "state: got entries that were not written, expected all of p, q, v, w filled in")
    yield near("earlier state after later steps", first.p_WB, kept[0], 0.0, "what was handed out must not change")
    yield near("earlier orientation after later steps", first.q_WB, kept[1], 0.0)
    yield near("norm of the quaternions", np.linalg.norm(second.q_WB, axis=1), np.ones(2), 1e-6, "unit quaternions")


@firm("Are arrays that a state does not fit into refused by name?")
def bad_states_are_refused(engine: Engine) -> Comparisons:
    scene = without_gravity(free(), free("other", p=(5.0, 0.0, 0.0)))
    good = State.empty(_BODIES)
    with engine.built(scene, COARSE) as simulation:
        for name, width in (("p_WB", 3), ("q_WB", 4), ("v_WB", 3), ("w_WB", 3)):
            for what, bad in (
                ("one body short", np.zeros((1, width))),
                ("one body too long", np.zeros((3, width))),
                ("flat", np.zeros(_BODIES * width)),
                ("of float32", np.zeros((_BODIES, width), dtype=np.float32)),
            ):
                yield _refused(name, f"{name} {what}", simulation.state, replace(good, **{name: bad}))  # type: ignore[arg-type]


_BODIES = 2


def _refused(named: str, what: str, call: Callable[..., object], *arguments: Any) -> Compared:
    """Is the call a ValueError that names the argument? Anything else, an answer or another exception, is a failure."""
    try:
        call(*arguments)
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


@firm("Are forces and torques of a wrong shape, type or content refused by name, and nothing of them kept?", Feature.WRENCH)
def bad_wrenches_are_refused(engine: Engine) -> Comparisons:
    """Each bad array as force and as torque; afterwards the bodies fly on as if nothing had been said."""
    scene = without_gravity(free(v=(1.0, 0.0, 0.0)), free("other", p=(5.0, 0.0, 0.0)))
    good = np.zeros((_BODIES, 3))
    with engine.built(scene) as simulation:
        for what, bad in _bad_vectors().items():
            yield _refused("f_B_W", f"force {what}", simulation.wrench, bad, good)
            yield _refused("tau_B_W", f"torque {what}", simulation.wrench, good, bad)
        simulation.step(10)
        end = state_of(simulation, scene)
    yield near("p_WB afterwards [m]", end.p_WB, [(0.01, 0.0, 0.0), (5.0, 0.0, 0.0)], 1e-5, "v t: nothing bad was kept")


@firm("Are rays of a wrong shape, type, content or length refused by name, and a reach that is none?", Feature.RAYS)
def bad_rays_are_refused(engine: Engine) -> Comparisons:
    shape = Box(half_extents=(0.5, 0.5, 0.5)) if Feature.BOX in engine.features else Sphere(radius=0.5)
    scene = Scene(bodies=(static("target", shape),))
    o, d = np.tile((5.0, 0.0, 0.0), (_BODIES, 1)), np.tile((-1.0, 0.0, 0.0), (_BODIES, 1))

    with engine.built(scene, None) as simulation:
        for what, bad in _bad_vectors().items():
            yield _refused("origins", f"origins {what}", simulation.cast, bad, d, 9.0)
            if what not in {"(1, 3) for two bodies", "(3, 3) for two bodies", "(0, 3)"}:
                yield _refused("directions", f"directions {what}", simulation.cast, o, bad, 9.0)
        for what, long in (("of length 2", 2.0), ("of length 0", 0.0), ("of length 1.00001", 1.00001)):
            yield _refused("direction", f"directions {what}", simulation.cast, o, long * d, 9.0)
        for reach in (0.0, -1.0, float("nan"), float("inf")):
            yield _refused("max_range", f"max_range {reach}", simulation.cast, o, d, reach)
        ranges = simulation.cast(o, d, 9.0).distance
    yield near("ranges of good rays afterwards [m]", ranges, (4.5, 4.5), 1e-5, "rounding in single precision")


@firm(
    "Are targets of joints without a drive and targets that are no finite number refused by name?",
    Feature.PRISMATIC | Feature.DRIVES,
)
def bad_targets_are_refused(engine: Engine) -> Comparisons:
    drive = Drive(stiffness=50.0, damping=20.0)
    driven = prismatic("slide", "body", ORIGIN, X, drive=drive)
    loose = replace(driven, name="loose", child="other", drive=None)
    scene = without_gravity(free(), free("other", p=(0.0, 5.0, 0.0)), joints=(driven, loose))
    odd: tuple[Any, ...] = (float("nan"), float("inf"), np.zeros(2), "far")
    with engine.built(scene) as simulation:
        for name, target in (("loose", 0.1), ("nobody", 0.1), *(("slide", target) for target in odd)):
            yield _refused(name, f"target {target!r} of joint '{name}'", simulation.command, {name: target})
        simulation.step(10)
        end = state_of(simulation, scene)
    yield near("x of the driven body afterwards [m]", end.p_WB[0, 0], 0.0, 1e-6, "its target is still 0")
