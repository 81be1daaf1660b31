"""What changed, as people read it: titles for names, steps as parts of a second, three digits, and one sentence a case."""

import pytest

from plumbline.harness.findings.changes import Change, Changes
from plumbline.harness.findings.changes.values import ComparedRun
from plumbline.harness.findings.changes.words import folded, sentence, titled
from plumbline.reports.standalone.what_changed import what_changed_page

TITLES = {"stack_tower": "Tower of ten boxes", "dart": "DART", "joint_chain": "Chain with a heavy end"}
SIDE = ComparedRun(
    folder="build/a", study="quick", started="2025-01-02T03:04:05+00:00", machine="", trials=9, versions=(("dart", "1"),)
)


def change(**fields: object) -> Change:
    about = {"kind": "error", "sense": "worse", "case": "stack_tower", "engine": "dart", "track": "tuned", "dt": 1 / 240}
    read = {"metric": "position_error_max", "unit": "m", "before": 0.0012345, "after": 0.0045678, "ratio": 3.7, "trial_b": "ab"}
    return Change(**{**about, **read, **fields})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("row", "said"),
    [
        (
            change(),
            "Tower of ten boxes on DART (tuned), dt 1/240 s: errs more: largest position error 0.00123 m -> 0.00457 m (3.7 "
            "times).",
        ),
        (
            change(sense="within tolerance", after=0.00123451, ratio=1.0, dt=0.003),
            "Tower of ten boxes on DART (tuned), dt 0.003 s: other bits, within tolerance: largest position error 0.00123 m, "
            "to three digits as before.",
        ),
        (
            change(kind="verdict", before="passed", after="failed", ratio=1.0, detail="top_offset = 0.2 m, bound 0.1"),
            "Tower of ten boxes on DART (tuned), dt 1/240 s: passed, now failed: top offset = 0.2 m, bound 0.1.",
        ),
        (
            change(kind="limit", metric="mass_ratio", unit="1", before=10.001, after=10.002, dt=0.0),
            "Tower of ten boxes on DART (tuned): mass ratio held to 10.001, now 10.002: breaks earlier.",
        ),
        (change(case="", kind="version", before="1", after="2"), "DART: version 1, now 2."),
        (change(case="of_no_catalogue"), None),
    ],
)
def test_a_change_is_said_with_titles_and_three_digits(row: Change, said: str | None) -> None:
    assert sentence(titled(row, TITLES)) == (said or sentence(titled(change(), TITLES)).replace("Tower of ten boxes", row.case))


def test_without_titles_names_stay_as_commands_take_them() -> None:
    assert sentence(change()).startswith("stack_tower on dart (tuned), dt 1/240 s: errs more: position_error_max 0.00123 m")
    ((text, rows),) = folded([change()], TITLES)
    assert (text, rows) == (sentence(titled(change(), TITLES)), [change()])


def page(*rows: Change) -> str:
    changes = Changes(a=SIDE, b=SIDE, rows=rows, matched=9, same=0, clocked=0, titles=TITLES)
    return what_changed_page(changes, ["dart"])


def test_what_changed_alike_in_a_case_is_one_sentence_of_the_page_and_all_its_rows_tell_their_step() -> None:
    steps = [1 / 240, 1 / 120, 1 / 60]
    text = page(*(change(dt=dt) for dt in steps), change(case="joint_chain"))
    listed = text.partition('id="worse"')[2].partition("</section>")[0]
    assert "Worse (4)" in listed
    assert listed.count("<li>") == 2
    assert listed.count("Likewise 2 more of this case, at other steps or parameters.") == 1
    assert "stack_tower" not in listed
    assert "-&gt;" not in listed
    assert "plumbline reproduce build/a ab" in listed
    assert "Gate (DART)" in text
    assert "2025-01-02 03:04 UTC" in text
    rows = text.partition('id="all"')[2]
    for step in ("1/240 s", "1/120 s", "1/60 s"):
        assert f">{step}</td>" in rows


def test_of_many_sentences_the_first_stand_open_and_the_others_fold() -> None:
    text = page(*(change(case=f"case_{number}") for number in range(60)))
    listed = text.partition('id="worse"')[2].partition("</section>")[0]
    opened, _, folds = listed.partition("<details>")
    assert opened.count("<li>") + folds.count("<li>") == 60
    assert f"<summary>{folds.count('<li>')} more</summary>" in folds
    assert opened.count("<li>") < 30
