"""The truth that a trial is measured by: of the case, or made by the reference engine once and kept in the run's folder."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from harness.case import Case, Converged
from harness.converge import converged
from harness.discover import adapter
from harness.record import digest
from harness.scene import Scene
from harness.scene.file import dump_json
from harness.store import write_atomically
from harness.trajectory import Floats, Trajectory

__all__ = ["truth_of"]


def truth_of(case: Case, scene: Scene, time: Floats, parameters: Mapping[str, Any], folder: Path | None) -> Converged | None:
    """What the answer at the times (t,) s is measured by: a closed form has errors of zero.

    A truth that the reference engine has to make is kept under `folder`, named by all that it depends on.

    Raises: NotMeasurable, Unsupported: the reference cannot make it.
    """
    if case.coarsest is None:
        truth = case.truth_at(time, parameters)
        if isinstance(truth, Trajectory):
            return Converged(trajectory=truth, position_error=0.0, velocity_error=0.0)
        return truth
    reference = adapter("reference")
    depends = {"scene": dump_json(scene), "time": time.tolist(), "step": case.coarsest, "engine": reference.version()}
    kept = None if folder is None else folder / "truths" / f"{digest(depends)}.npz"
    if kept is not None and kept.is_file():
        with np.load(kept, allow_pickle=False) as file:
            arrays = dict(file)
        states = (arrays[name] for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
        position, velocity = arrays["errors"].tolist()
        return Converged(trajectory=Trajectory(*states), position_error=position, velocity_error=velocity)
    made = converged(scene, time, reference, case.coarsest)
    if kept is not None:
        t, buffer = made.trajectory, io.BytesIO()
        errors = np.array([made.position_error, made.velocity_error])
        np.savez(buffer, time=t.time, p_WB=t.p_WB, q_WB=t.q_WB, v_WB=t.v_WB, w_WB=t.w_WB, errors=errors)
        kept.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(kept, buffer.getvalue())
    return made
