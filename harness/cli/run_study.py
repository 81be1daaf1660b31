"""The command that runs a study, or a scene file of one's own: what it says before and after, what its gate is about, and what
reaches past one machine.
"""

import re
import shlex
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from plumbline.api.engines import chosen_engines
from plumbline.api.present import present
from plumbline.harness.cli.guard import GATE, INTERRUPTED, USAGE, check_words, fail_for, say, stop
from plumbline.harness.cli.options import agreed, limited
from plumbline.harness.cli.own_scene import closing_count, closing_words, waiting
from plumbline.harness.cli.robot_options import NAMES, is_robot, is_scene, robot_options, run_options, scene_to_run
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case
    from plumbline.harness.run.cluster.workplace import Workplace
    from plumbline.harness.store.store import Store
    from plumbline.harness.study.study import Study


@contextmanager
def at_work(scheduler: str | None) -> "Iterator[Workplace | None]":
    """The workers of a scheduler while a run lasts; None where none was named. Raises: NoScheduler, NoDask."""
    if scheduler is None:
        yield None
        return

    from plumbline.harness.run.cluster.workplace import Workplace

    with Workplace(scheduler) as cluster:
        for sentence in cluster.described():
            say(sentence, err=True)
        yield cluster


@click.command()
@click.argument("folders", nargs=-1, required=True, metavar="DIR...", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(file_okay=False, path_type=Path), help="The folder of all of them.")
def merge(folders: tuple[Path, ...], out: Path) -> None:
    """Make the folders of one study's parts, run by --shard anywhere, into one."""
    from plumbline.harness.run.merge_folders import conflicts, merge_folders

    if sentences := conflicts(folders):
        for sentence in sentences:
            say(sentence, err=True)
        stop(GATE, f"{len(sentences)} conflicts; nothing was written")
    store, notes = merge_folders(folders, out)
    for note in notes:
        say(note, err=True)
    report = present(store, bool(store.study.get("recordings", True)))
    say(str(report.index))
    fail_for(report.sentences())


def failures(store: "Store") -> list[str]:
    """What the gate is about: the reference engine's checks on the tuned track and its determinism, the audit of effects, and
    tuned tracks of all engines that a change of one knob beats without a reason."""
    from plumbline.harness.findings.effects_audit import audit
    from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
    from plumbline.harness.findings.tables import determinism, dominance
    from plumbline.harness.findings.tables.effects import verdicts

    ours = [name for name in store.trials["engine"].unique() if store.described("engines", name)["ours"]]
    # Bounds are meant for the steps that a study names, not for those that a sweep goes on to.
    trials = store.asked[store.asked["round"] == 0]
    broken = trials[
        trials["engine"].isin(ours) & (trials["track"] == "tuned") & ~trials["status"].isin(("passed", "unsupported"))
    ]
    sentences = [
        f"gate: {row.case} on {row.engine}/{row.track} at dt {step_in_words(row.dt, substeps_of(str(row.resolved)))}: "
        f"{row.status}: {row.reason}"
        for row in broken.itertuples()
    ]
    sentences += [f"determinism: {sentence}" for sentence in determinism.broken(determinism.repetitions(store), ours)]
    sentences += [f"audit: {sentence}" for sentence in audit(verdicts(store)).gating.sentences()]
    return sentences + [f"dominance: {sentence}" for sentence in dominance.unexcused(store)]


def support_lines(cases: "Mapping[str, Case]", adapters: "Mapping[str, Adapter]", droppable: bool = False) -> list[str]:
    """By the features that scenes use and adapters claim; building one may still be refused, which is then its outcome.

    Reasons stand once, with the number of cases that each keeps from running.

    Args: droppable: is the one scene of a robot's file, of which `--drop` can leave out what an engine lacks?
    """
    from plumbline.harness.adapter.features import features_of
    from plumbline.harness.case.undropped import KINDS
    from plumbline.harness.study.plugins import version_of

    used = {name: features_of(case.scene(case.parameters)) for name, case in cases.items()}
    lines = []
    for name, adapter in adapters.items():
        version, reason = version_of(adapter)
        if reason is not None:
            lines.append(f"{name}: cannot: {reason}")
            continue
        lacking = {case: features & ~adapter.features for case, features in used.items()}
        runs = sum(not features for features in lacking.values())
        counts: dict[str, int] = {}
        for features in lacking.values():
            for word in features.names:
                counts[word] = counts.get(word, 0) + 1
        ranked = sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
        if len(cases) == 1:
            kinds = {**KINDS, "tendon": "tendon"}
            drops = " ".join(f"--drop {kinds[word]}" for word in counts if word in kinds)
            without = f"; it runs with {drops}" if droppable and counts.keys() <= kinds.keys() else ""
            lines.append(f"{name} {version}: " + ("runs" if runs else f"cannot: it lacks {', '.join(counts)}{without}"))
        else:
            without = ", ".join(f"{word} ({count})" for word, count in ranked)
            lines.append(f"{name} {version}: runs {runs} of {len(cases)} cases" + (f"; lacks {without}" if without else ""))
    return lines


def _parse_shard(_context: click.Context, _parameter: click.Parameter, text: str) -> tuple[int, int]:
    shard = re.fullmatch("([0-9]{1,6})/([0-9]{1,6})", text)
    index, count = (int(number) for number in shard.groups()) if shard else (0, 0)
    if not 1 <= index <= count:
        raise click.BadParameter(f"{quoted(text)}, expected i/n with 1 <= i <= n, like 2/4")
    return index, count


def _parse_address(_context: click.Context, _parameter: click.Parameter, text: str | None) -> str | None:
    if text is not None and not re.fullmatch(r"(\w+://)?[^/\s]+:[0-9]{1,5}", text):
        raise click.BadParameter(f"{quoted(text)}, expected the address of a scheduler, like tcp://HOST:8786")
    return text


def _study_and_cases(name: str, own: bool, globs: tuple[str, ...], budget: float | None) -> "tuple[Study, dict[str, Case]]":
    from plumbline.api.studies import study_and_cases
    from plumbline.harness.study import plugins
    from plumbline.harness.study.study import study_of

    if own:
        path = str(Path(name).resolve())
        check_words([path])
        case = plugins.case(f"{plugins.SCENE_PREFIX}{path}")
        if globs:
            raise click.BadParameter(f"{quoted(globs[0])}: a scene file is one case, expected none", param_hint="--case")
        return study_of(case, budget), {case.name: case}
    return study_and_cases(name, globs)


def _of_file(study: str, error: Exception) -> str:
    """What is wrong with a study, with the file that says it."""
    message = str(error)
    return message if not study.endswith(".toml") or message.startswith(study) else f"{study}: {message}"


def _propose(store: "Store", case: "Case") -> None:
    """Write the scene with what it needs alone, where the audit proposes one, and say how it is run."""
    from plumbline.harness.cli.minimal_scene import write_minimal

    written = write_minimal(store, case)
    if written is not None:
        say(f"without {', '.join(written[1])}: plumbline run {shlex.quote(str(written[0]))}", err=True)


ZOO = "zoo"
"""The study of the zoo, and the folder that it is run into unless another is named."""
_MERGE = "--resume-with-another-study"


class _Resumable(click.Command):
    """A command with a flag that may have a value: click would take the word behind a plain `--resume` for it."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does, where `--resume=merge` is a flag of its own."""
        for word in args:
            value = word.removeprefix("--resume=")
            if value not in (word, "merge"):
                raise click.BadParameter(f"'{value}', expected merge, or --resume alone", param_hint="--resume")
        try:
            return super().parse_args(ctx, [_MERGE if word == "--resume=merge" else word for word in args])
        except click.NoSuchOption as error:
            known = sorted(name for option in self.params for name in option.opts if name.startswith("--") and name != _MERGE)
            near = f"; did you mean {' or '.join(error.possibilities)}?" if error.possibilities else ""
            raise click.UsageError(
                f"no option {quoted(error.option_name, 60)}, expected some of {', '.join(known)}{near}", ctx
            ) from None


@click.command(cls=_Resumable)
@click.argument("study")
@click.option("--engine", "engine_names", multiple=True, help="Only this engine, or its ==VERSION or =WHEEL; may be repeated.")
@click.option("--case", "globs", multiple=True, metavar="GLOB", help="Only cases of this pattern; may be repeated.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="The run folder [build/STUDY].")
@click.option("--workers", type=click.IntRange(1, 1024), default=2, show_default=True, help="Accuracy runs side by side.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    callback=_parse_address,
    help="Run on the workers of a dask.distributed scheduler, tcp://HOST:PORT.",
)
@click.option("--shard", default="1/1", callback=_parse_shard, metavar="I/N", help="Only the I-th of N parts.")
@click.option("--resume", "resume", flag_value="same", help="Go on with a stopped run; =merge: with another study.")
@click.option(_MERGE, "resume", flag_value="merge", hidden=True)
@robot_options
@run_options
@limited
@agreed
def run(
    study: str,
    engine_names: tuple[str, ...],
    globs: tuple[str, ...],
    out: Path | None,
    workers: int,
    scheduler: str | None,
    shard: tuple[int, int],
    resume: Literal["same", "merge"] | None,
    budget: float | None,
    agreed: bool,
    **robot: Any,
) -> None:
    """Run STUDY: a built-in name (quick, accuracy, price, limits, effects, ...), a study file, a scene or robot of your own."""
    how: bool | Literal["merge"] = "merge" if resume == "merge" else resume is not None
    if study == ZOO and not any(robot.values()):
        from plumbline.harness.cli.zoo_run import run_zoo

        if scheduler is not None or shard != (1, 1):
            raise click.BadParameter("its robots lie on this machine, expected none", param_hint="--scheduler, --shard")
        run_zoo(out or Path("build") / ZOO, globs, engine_names, agreed=agreed, workers=workers, resume=how, budget=budget)
        return
    own, of_robot = is_scene(study), is_robot(Path(study))
    if own:
        study = scene_to_run(study, out or Path("build") / "scene", robot)
    elif any(robot.values()) or budget is not None:
        raise click.BadParameter(f"for scene and robot files alone; {quoted(study)} is none", param_hint=NAMES)

    from plumbline.harness.run.campaign import carry_out
    from plumbline.harness.run.interrupt import until
    from plumbline.harness.run.known_results import UNGUIDED
    from plumbline.harness.study.experiment import StudyError

    try:
        plan, chosen = _study_and_cases(study, own, globs, budget)
        plan.check_truths(chosen)
    except StudyError as error:
        stop(USAGE, _of_file(study, error))
    adapters = chosen_engines(engine_names, agreed)
    if own:
        from plumbline.api.sources import refuse_two_frictions

        case = next(iter(chosen.values()))
        refuse_two_frictions(study, case.scene(case.parameters), adapters)
    folder = out or Path("build") / plan.name
    for sentence in support_lines(chosen, adapters, of_robot):
        say(sentence, err=True)
    try:
        guide = waiting(chosen, folder, budget) if own else UNGUIDED
        with at_work(scheduler) as cluster, until(guide.end):
            store = carry_out(
                plan, folder, chosen, adapters, workers=workers, resume=how, shard=shard, cluster=cluster, guide=guide
            )
    except StudyError as error:
        stop(USAGE, _of_file(study, error))
    except KeyboardInterrupt:
        stop(INTERRUPTED, f"interrupted; what finished is in {folder}; go on with the same command and --resume")
    say(closing_count(store), err=True)
    # On a robot of the user's own nobody is gated: an engine that fails it, ours too, is a finding.
    failed = [] if own else failures(store)
    for sentence in [*failed, *(closing_words(store) if own else [])]:
        say(sentence, err=True)
    if own:
        _propose(store, next(iter(chosen.values())))
        say("writing the report", err=True)
    report = present(store, plan.recordings, anew=False)
    say(str(report.page_of(next(iter(chosen))) if own else report.index))
    fail_for(report.sentences())
    if failed:
        sys.exit(GATE)
