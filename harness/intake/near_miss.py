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


def misspelt(name: str, words: Iterable[str]) -> str | None:
    """The known word that a name is most likely a slip of the pen for: within two edits of it, one where either has less than
    five letters; None where there is none, and for a single letter."""
    if len(name) < 2 or len(name) > 100:
        return None
    near = [(edit_distance(name.lower(), word.lower()), word) for word in words if abs(len(word) - len(name)) <= 2]
    near = [(edits, word) for edits, word in near if edits <= (2 if min(len(name), len(word)) >= 5 else 1)]
    return min(near)[1] if near else None


def edit_distance(a: str, b: str) -> int:
    """Letters to change, insert, leave out or swap with the next one until one word is the other.

    No letter is edited twice.
    Source: Damerau, A Technique for Computer Detection and Correction of Spelling Errors, Commun. ACM 7 (1964) 171.
    """
    before, row = [0] * (len(b) + 1), list(range(len(b) + 1))
    for i, letter in enumerate(a, 1):
        older, before, row = before, row, [i]
        for j, other in enumerate(b, 1):
            edits = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                edits = min(edits, older[j - 2] + 1)
            row.append(edits)
    return row[-1]
