"""A name that is not known beside those that are: which of them may have been meant."""

import difflib
from collections.abc import Iterable

from plumbline.harness.intake.safe_text import one_line


def did_you_mean(name: str, known: Iterable[str], form: str = "{}") -> str:
    """The end of a sentence that refuses a name: '; did you mean mass?', or '' where none of the known ones is near.

    `form` is how a name is written there: '<{}>' for an element.
    """
    near = difflib.get_close_matches(name[:200], known, 1)
    return f"; did you mean {form.format(one_line(near[0], 80))}?" if near else ""
