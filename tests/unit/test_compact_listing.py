"""Lists of trials that did not pass: those that read alike are one row, and what tells two rows apart is said."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest

from plumbline.harness.case.alteration import AS_IT_IS, Alteration
from plumbline.harness.findings.summary import rows, summaries, told_apart
from plumbline.harness.scene import Effect
from plumbline.harness.store.store import Store
from tests.recorded_folder import Folder, record

CATALOGUE = {"cases": {"slide": {"parameters": {"edge": 6, "velocity": [3.0, 1.0]}}}}


@dataclass(frozen=True, kw_only=True)
class Tried:
    """A trial of the case, as the table of trials has it."""

    edge: int = 6
    velocity: tuple[float, ...] = (3.0, 1.0)
    alteration: Alteration = AS_IT_IS
    remedy: str = ""
    seed: int = 0
    dt: float = 1 / 240
    substeps: int | None = None
    reason: str = "gap = 2 m, bound 1"
    experiment: str = "ladder"


def table(*tried: Tried) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "study": "made",
            "experiment": one.experiment,
            "case": "slide",
            "engine": "mujoco",
            "track": "tuned",
            "dt": one.dt,
            "resolved": json.dumps({"substeps": one.substeps}),
            "parameters": json.dumps({"edge": one.edge, "velocity": list(one.velocity)}),
            "alteration": json.dumps(one.alteration.plain()),
            "remedy": one.remedy,
            "seed": one.seed,
            "status": "failed",
            "reason": one.reason,
        }
        for one in tried
    )


REPETITIONS = [
    Alteration(every_step=True),
    *(Alteration(name=name, every_step=True) for name in ("again", "alone", "2 threads")),
    Alteration(name="reordered", every_step=True, told="reordered"),
    Alteration(name="nudged", every_step=True, told="nudged"),
]


def test_repetitions_that_end_alike_are_one_row_with_their_number() -> None:
    listed = rows(table(Tried(), *(Tried(alteration=one, experiment="determinism") for one in REPETITIONS)), CATALOGUE)
    assert [(row.dt, row.apart, row.count) for row in listed] == [("1/240 s", "", 7)]


def test_repetitions_that_end_differently_say_which_they_are() -> None:
    """The run that records each step may see a peak that the ladder's misses: neither is 'as it is' twice."""
    worse = replace(Tried(), reason="gap = 3 m, bound 1")
    listed = rows(table(Tried(), *(replace(worse, alteration=one) for one in REPETITIONS)), CATALOGUE)
    assert [(row.apart, row.count) for row in listed] == [
        ("as it is", 1),
        ("every step recorded, again, alone, 2 threads, reordered, nudged", 6),
    ]


def test_an_end_that_only_repetitions_come_to_says_which_they_are() -> None:
    """Whoever reads of a crash has to know that it takes other code of a library."""
    varied = Alteration(name="BLAS for Prescott", every_step=True, variables=(("OPENBLAS_CORETYPE", "Prescott"),))
    listed = rows(table(Tried(alteration=varied)), CATALOGUE)
    assert [row.apart for row in listed] == ["BLAS for Prescott"]


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (Tried(edge=9), "edge 9"),
        (Tried(velocity=(3.0, 2.0)), "velocity [3.0, 2.0]"),
        (Tried(alteration=Alteration(name="without friction", narrow=Effect.FRICTION)), "without friction"),
        (Tried(alteration=Alteration(linear_damping=0.1)), "altered"),
        (Tried(remedy="sub-steps x 4"), "sub-steps x 4"),
        (Tried(seed=3), "seed 3"),
    ],
)
def test_a_scene_of_its_own_is_a_row_of_its_own(other: Tried, words: str) -> None:
    """A finer step, another parameter, an effect left out: what tells them apart is in words that the two rows do not share."""
    listed = rows(table(Tried(), other, other), CATALOGUE)
    assert [row.count for row in listed] == [1, 2]
    assert words in listed[1].apart
    assert words not in listed[0].apart


def test_a_rung_of_a_ladder_is_a_row_of_its_own() -> None:
    listed = rows(table(Tried(), Tried(dt=1 / 480), Tried(dt=0.0033), Tried(dt=1 / 60, substeps=4)), CATALOGUE)
    assert [row.dt for row in listed] == ["1/240 s", "1/480 s", "0.0033 s", "1/60 s (4 sub-steps)"]


def test_tests_of_a_build_server_have_names_of_their_own() -> None:
    """A server takes two cases of one class and name for one, and shows the last."""
    tried = [Tried(), Tried(edge=9), *(Tried(alteration=one, experiment="determinism") for one in REPETITIONS)]
    told = told_apart(table(*tried), CATALOGUE)
    assert len(set(told)) == len(tried)


def test_the_summary_of_a_folder_holds_no_row_twice(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    for alteration in REPETITIONS:
        plain = alteration.plain()
        folder.add(record("slide", "mujoco", status="failed", reason="gap = 2 m", alteration=plain, parameters={"edge": 6}))
    folder.write(slide=CATALOGUE["cases"]["slide"])
    files = summaries(Store(folder.path))
    listed = [line for line in files["summary.md"].decode().splitlines() if line.startswith("| slide |")]
    assert len(listed) == 1
    assert listed[0].endswith(f"| {len(REPETITIONS)} |")
    named = [(test.get("classname"), test.get("name")) for test in ElementTree.fromstring(files["junit.xml"]).iter("testcase")]
    assert len(set(named)) == len(REPETITIONS)
