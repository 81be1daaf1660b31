"""Sentences over which people stumbled do not come back: none of them stands in a file of the project."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STUMBLED = (
    "are level: no order holds",
    "It would be {",
    "against the scene's word",
    "is the ruler",
    "stands beside the others as a yardstick",
    "Our own engine is the",
    "too few for a share to mean much",
    "clocked within 1 %",
    "no coarser or cheaper run was tried",
    "a per cent is not seen",
    "poisons a batch",
    "smooth cases at two more steps, for their order",
    "what nobody has declared says so",
    "the deeper the shade",
    "the yardstick errs least",
    "Known by a bound alone",
    "asked for is {",
    "made under another lock",
    "Unasked for so long",
    "Whose charts",
    "what is known is recalled",
    "What is wrong or a trap",
    "Hide the yardstick",
    "Learning on many worlds",
    "Machines that walk",
    "Arms that grasp",
    "by what it says it used, or by what was asked",
    "no leap above what was told before",
    "reaches beyond what the best certainly comes to",
    "where links stand on what stays",
    "whose pipe has broken",
    "nobody knows whose fault it is",
    "of which one of a range is the lower",
    "What prices have come to over the nights",
    "What createMultiBody is told",
    "What lies around the front",
    "What is wrong with the place of a line",
    "those whose noise can be told",
    "where it stands in a camp",
    "What ensembles come to",
    "How long a process may work",
    "what stands in it by then is taken out",
    "At the target next to the one asked for",
    "Whose law it is",
    "was a matter of another machine",
    "What a change is called",
    "The name of a group of settings that a search went on to",
    "In what scenes depart",
    "The solver that suits a scene",
    "some that have the numeric libraries and no engine",
    "Going on with a run",
    "a scene pays only for the effects",
    "A first look",
    "It leans on",
    "Many bodies in a frame",
    "a world that explodes",
    "A case of each family once",
    "Take away environments",
    "what changed is told",
    "where nothing was learned",
    "none of none",
    "unless told softer",
    "as far as it is asked for",
    "by every night that tells it",
    "told by the first that sees it",
    "is told not again",
    "what is seldom needed stays small",
)
WORDS = re.compile(r"(?<![`\w-])(yardsticks?|rulers?|recalled|draws of|traps? of)(?![`\w-])", re.IGNORECASE)
"""Words that only the project had, for the reference engine, for what an earlier night answered, for resamples and pitfalls."""
FOR_USERS = ("README.md", "CONTRIBUTING.md", "docs", "examples", "reports/templates", "harness/study/built_in", "harness/cli")
LEFT_ALONE = ("CHANGELOG.md", "docs/decisions/", "tests/architecture/test_plain_sentences.py")
"""What tells of the past, and this list."""


def texts() -> dict[str, str]:
    """Every text file of the repository, on one line each."""
    names = subprocess.run(["git", "grep", "-lI", ""], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    current = [name for name in names if name and not name.startswith(LEFT_ALONE)]
    return {name: " ".join((ROOT / name).read_text(encoding="utf-8").split()) for name in current if (ROOT / name).is_file()}


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return texts()


@pytest.mark.parametrize("sentence", STUMBLED)
def test_a_sentence_that_people_stumbled_over_stands_nowhere(files: dict[str, str], sentence: str) -> None:
    assert [name for name, text in files.items() if sentence in text] == []


def test_texts_for_users_have_no_word_that_only_the_project_had(files: dict[str, str]) -> None:
    """Pages, their templates, examples, studies, and help texts by way of `docs/cli.md`; in templates the text alone."""
    shown = {name: text for name, text in files.items() if name.startswith(FOR_USERS) and not name.endswith((".py", ".ipynb"))}
    assert {"README.md", "docs/cli.md", "reports/templates/index.html", "harness/study/built_in/quick.toml"} <= shown.keys()
    bare = {name: re.sub(r"\{[{%#].*?[}%#]\}|<[^>]*>", " ", text) for name, text in shown.items()}
    assert {name: met for name, text in bare.items() if (met := WORDS.findall(text))} == {}
