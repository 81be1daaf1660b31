"""A study by its name or file, with the cases that it asks about."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from plumbline.api.engines import tell
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.case import Case
    from plumbline.harness.study.study import Study


def study_and_cases(name: str, globs: Sequence[str] = ()) -> "tuple[Study, dict[str, Case]]":
    """A study by its name or file, and those of the cases it asks about that a pattern names. Raises: StudyError."""
    from plumbline.harness.study import plugins
    from plumbline.harness.study.experiment import StudyError
    from plumbline.harness.study.study import call_roll, load_study, twice

    study = load_study(name)
    if double := twice(globs):
        raise StudyError(f"case pattern {quoted(double)} is given twice, expected once")
    for sentence in plugins.left_out_in_words("cases", "pages"):
        tell(sentence)
    names = plugins.names("cases")
    call_roll(study, names, plugins.names("adapters"))
    for glob in globs:
        if not any(fnmatchcase(case, glob) for case in names):
            raise StudyError(f"case pattern {quoted(glob)} names no case, expected a pattern over: {', '.join(names)}")

    def asked(case: str) -> bool:
        called = any(experiment.asks(case) for experiment in study.experiments)
        return called and (not globs or any(fnmatchcase(case, glob) for glob in globs))

    return study, plugins.cases(asked)
