"""One scene on one engine: its trajectory as arrays."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from plumbline.api.arguments import checked
from plumbline.api.engines import chosen_engines
from plumbline.api.motion import Run
from plumbline.api.sources import ImportOptions, Source, case_of
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case
    from plumbline.harness.store.record import Record
    from plumbline.harness.study.trial import Trial


@checked
def run(
    what: Source,
    engine: str = "mujoco",
    duration: float | None = None,
    *,
    dt: float | None = None,
    track: str = "tuned",
    parameters: Mapping[str, Any] | None = None,
    isolated: bool = True,
    install: bool = False,
    deadline: float = 60.0,
    memory: float = 4096.0,
    **options: Unpack[ImportOptions],
) -> Run:
    """Run a scene on an engine and keep the state of every step.

    Args:
        what: a `Scene`, the path of a scene or robot file (TOML, JSON, URDF, MJCF, SDF), or the name of a case.
        engine: one of `plumbline engines`, or a version of it: "mujoco==3.3.0".
        duration [s]: 5 s if neither this nor the file's companion says; a case has its own.
        dt [s]: the time step, 1/240 s if neither this nor the file's companion or the case says.
        track: "tuned", what the engine's vendor recommends for the scene, or "default", what a newcomer gets.
        parameters: of a case, by name; the others keep the case's own values.
        isolated: run in a process of its own: a crash, a hang or a want of memory of the engine is an outcome with its
            reason. False runs it in this process, where an engine's exception is raised as it is.
        install: an engine that Plumbline does not bring along, in an environment of its own, unless it is there.
        deadline [s]: CPU time that an isolated run may take. memory [MB]: that it may take.
        options: how a robot file becomes a scene: root, scenario, start, drop, packages, convex, one_friction, strict.
    Raises: PlumblineError, with file, element, value and what was expected.
    """
    from plumbline.harness.study import plugins

    (adapter,) = chosen_engines((engine,), install).values()
    version, unavailable = plugins.version_of(adapter)
    folder = TemporaryDirectory(prefix="plumbline-run-")
    case = case_of(what, Path(folder.name), duration, dt, options)
    settings = {"dt": case.dt if dt is None else dt, "track": track, "deadline": deadline, "memory": memory}
    trial = _trial(case, adapter, version, parameters or {}, settings)
    if unavailable is not None:
        from plumbline.harness.trial.accuracy import outcome

        record = outcome(trial, "unavailable", unavailable)
    elif isolated:
        from plumbline.harness.run.isolated import run_isolated

        (record,) = run_isolated([trial], Path(folder.name), 1)
    else:
        record = _here(trial, case, adapter, Path(folder.name))
    return Run(record, trial.scene(case), case, adapter, folder)


def _trial(
    case: "Case", adapter: "Adapter", version: str, parameters: Mapping[str, Any], settings: Mapping[str, Any]
) -> "Trial":
    """The one trial, every step of which is kept. Raises: StudyError."""
    from pydantic import TypeAdapter

    from plumbline.harness.case.alteration import Alteration
    from plumbline.harness.study.experiment import Experiment, StudyError
    from plumbline.harness.study.foreseen_cost import too_much
    from plumbline.harness.study.provenance import sources_of
    from plumbline.harness.study.study import Study

    for name in parameters:
        if name not in case.parameters:
            names = ", ".join(case.parameters) or "none"
            near = did_you_mean(name, case.parameters)
            raise StudyError(f"case {quoted(case.name)}: parameter {quoted(name)}: unknown, expected one of {names}{near}")
    table = {
        "name": "run",
        "tracks": [settings["track"]],
        "dt": [settings["dt"]],
        "deadline": settings["deadline"],
        "memory": settings["memory"],
        "parameters": {name: [_plain(value)] for name, value in parameters.items()},
        "timing": False,
    }
    try:
        experiment = filled(TypeAdapter(Experiment), table, "run")
    except FieldError as error:
        raise StudyError(str(error)) from None
    study = Study(name="run", experiments=(experiment,))
    first = next(study.trials({case.name: case}, {adapter.name: adapter}, {adapter.name: version}, sources_of))
    trial = replace(first, alteration=Alteration(name="every step", every_step=True)).named()
    if excess := too_much(case, trial.scene(case), trial.settings.dt, every_step=True):
        raise StudyError(f"run: {excess}")
    return trial


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _here(trial: "Trial", case: "Case", adapter: "Adapter", folder: Path) -> "Record":
    from plumbline.harness.trial.accuracy import run_trial

    return run_trial(trial, case, adapter, folder)
