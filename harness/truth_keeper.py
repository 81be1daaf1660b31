"""What a trial is measured by: the truth, of the case or made by the reference engine, and bounds; what takes long is kept."""

import hashlib
import inspect
import io
import json
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from harness import truths
from harness.case import Case, Converged
from harness.converge import converged
from harness.discover import adapter
from harness.record import digest
from harness.scene import Scene
from harness.scene.file import dump_json
from harness.store import write_atomically
from harness.trajectory import Floats, Trajectory

__all__ = ["bounded", "truth_of"]

LONG = 0.1
"""Seconds from which on a closed form or a bound is kept: reading it back takes a few milliseconds."""


def truth_of(case: Case, scene: Scene, time: Floats, parameters: Mapping[str, Any], folder: Path | None) -> Converged | None:
    """What the answer at the times (t,) s is measured by: a closed form has errors of zero.

    A truth that takes long to make is kept under `folder`, named by all that it depends on.

    Raises: NotMeasurable, Unsupported: the reference cannot make it.
    """
    if case.coarsest is not None:
        reference = adapter("reference")
        depends = {"scene": dump_json(scene), "time": time.tolist(), "step": case.coarsest, "engine": reference.version()}
        kept = _place(folder, depends)
        if kept is not None and kept.is_file():
            return _read(kept)
        made = converged(scene, time, reference, case.coarsest)
        if kept is not None:
            _write(kept, made)
        return made
    kept = _place(folder, {"case": case.name, "parameters": dict(parameters), "time": time.tolist(), "laws": _laws(case)})
    if kept is not None and kept.is_file():
        return _read(kept)
    start = clock.monotonic()
    truth = case.truth_at(time, parameters)
    if isinstance(truth, Trajectory):
        truth = Converged(trajectory=truth, position_error=0.0, velocity_error=0.0)
    plain = truth is not None and not truth.trajectory.streams and truth.trajectory.contacts is None
    if truth is not None and kept is not None and plain and clock.monotonic() - start > LONG:
        _write(kept, truth)
    return truth


def bounded(case: Case, dt: float, substep: float, parameters: Mapping[str, Any], folder: Path | None) -> Case:
    """The case with its bounds as they are at these parameters and a time step dt [s] that the engine takes in steps of
    `substep` [s]; kept under `folder` where they take long."""
    if not any(callable(check.at_most) for check in case.checks):
        return case
    kept = _place(
        folder, {"case": case.name, "bounds at": [dt, substep], "parameters": dict(parameters), "laws": _laws(case)}, "json"
    )
    if kept is not None and kept.is_file():
        bounds = json.loads(kept.read_text(encoding="utf-8"))
    else:
        start = clock.monotonic()
        bounds = [check.bound(dt, parameters, substep) for check in case.checks]
        if kept is not None and clock.monotonic() - start > LONG:
            kept.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(kept, json.dumps(bounds).encode())
    return replace(case, checks=tuple(replace(check, at_most=b) for check, b in zip(case.checks, bounds, strict=True)))


def _place(folder: Path | None, depends: Mapping[str, Any], kind: str = "npz") -> Path | None:
    return None if folder is None else folder / "truths" / f"{digest(depends)}.{kind}"


def _laws(case: Case) -> str:
    """A digest of the text that closed forms and bounds are made by: the case's own file and those of `harness.truths`."""
    return _told(inspect.getsourcefile(case.scene))


@cache
def _told(own: str | None) -> str:
    """Worked out once a process, which has read the text only once as well."""
    files = sorted(Path(folder) / name for folder in truths.__path__ for name in Path(folder).glob("*.py"))
    told = hashlib.sha256()
    for path in [*files, *([Path(own)] if own is not None else [])]:
        told.update(path.read_bytes())
    return told.hexdigest()


def _read(kept: Path) -> Converged:
    with np.load(kept, allow_pickle=False) as file:
        arrays = dict(file)
    states = (arrays[name] for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
    position, velocity = arrays["errors"].tolist()
    return Converged(trajectory=Trajectory(*states), position_error=position, velocity_error=velocity)


def _write(kept: Path, made: Converged) -> None:
    t, buffer = made.trajectory, io.BytesIO()
    errors = np.array([made.position_error, made.velocity_error])
    np.savez(buffer, time=t.time, p_WB=t.p_WB, q_WB=t.q_WB, v_WB=t.v_WB, w_WB=t.w_WB, errors=errors)
    kept.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(kept, buffer.getvalue())
