"""A scene, a robot or a study on several engines: what `plumbline run` does."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Unpack

from plumbline.api.arguments import checked, within
from plumbline.api.engines import chosen_engines
from plumbline.api.present import present
from plumbline.api.results import Results
from plumbline.api.sources import ImportOptions, Source, case_of, is_case, refuse_two_frictions
from plumbline.api.studies import study_and_cases
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Scene


@checked
def compare(
    what: Source,
    engines: Sequence[str] = (),
    *,
    cases: Sequence[str] = (),
    out: str | PathLike[str] = "build/compare",
    duration: float | None = None,
    dt: float | None = None,
    budget: float | None = None,
    workers: int = 2,
    resume: bool = True,
    report: bool = True,
    install: bool = False,
    **options: Unpack[ImportOptions],
) -> Results:
    """Run a scene, a robot or a study on several engines, clock them, and keep all of it in a run folder.

    Progress goes to standard error. Each trial runs in a process of its own.

    Args:
        what: a `Scene`, the path of a scene or robot file, or a study: a built-in one ("quick", "accuracy", "price", ...) or
            the path of a study file.
        engines: all that are installed if empty; "mujoco==3.3.0" is a version of one.
        cases: of a study, patterns of the cases to run; all if empty.
        out: the run folder.
        duration, dt [s]: of a scene or robot; the coarsest step of its ladder of time steps.
        budget [s]: CPU time of that ladder, 120 s if None.
        workers: accuracy runs side by side; timing runs take turns.
        resume: keep what the folder holds of the same study and still stands; False refuses a folder that holds a run.
        report: write the HTML report and, if the study has them, the recordings, beside the summary.
        install: engines that Plumbline does not bring along, each in an environment of its own, unless it is there.
        options: how a robot file becomes a scene: root, scenario, start, drop, packages, convex, one_friction, strict.
    Raises: PlumblineError, with file, element, value and what was expected.
    """
    from plumbline.harness.findings.summary import write_summary
    from plumbline.harness.run.campaign import carry_out
    from plumbline.harness.study.experiment import StudyError
    from plumbline.harness.study.study import study_of

    within("workers", workers, 1, 1024)
    within("budget [s]", budget, 0, 1e7)
    folder, adapters = Path(out), chosen_engines(engines, install)
    if is_study(what):
        given = [name for name, value in (("duration", duration), ("dt", dt), ("budget", budget)) if value is not None]
        if given := [*given, *options]:
            raise StudyError(f"study {quoted(str(what))}: {given[0]}, expected none: it is for scene and robot files alone")
        plan, chosen = study_and_cases(str(what), cases)
    else:
        if cases:
            raise StudyError(f"cases: {quoted(cases[0])}, expected none: a scene is one case")
        case = case_of(what, folder, duration, dt, options)
        refuse_two_frictions(case.title, case.scene(case.parameters), adapters)
        plan, chosen = study_of(case, budget), {case.name: case}
    store = carry_out(plan, folder, chosen, adapters, workers=workers, resume=resume)
    if report:
        present(store, plan.recordings)
    else:
        write_summary(store)
    return Results(store)


def is_study(what: Source) -> bool:
    """Is it a study? By its name, which has no ending, or as a TOML file without bodies. Raises: PlumblineError."""
    from plumbline.harness.intake.documents import document

    if isinstance(what, Scene):
        return False
    return is_case(what) or (Path(what).suffix == ".toml" and "bodies" not in document(Path(what)))
