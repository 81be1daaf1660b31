"""Settings that a study names beside the two tracks: in words, in the legend, in the matrix, and in no ranking."""

from pathlib import Path

import pytest

from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import across_cases, error_by_step
from plumbline.reports.charts.marks import HALF, OPEN
from plumbline.reports.tables.summary import sentences
from plumbline.reports.tables.trial_results import answers, at_own_step
from plumbline.reports.words.catalogue import compared_tracks, named_tracks, setting_words
from tests.links import texts_of
from tests.run_folder import write_run_folder
from tests.settings_folder import ONE, SEVERAL, write_settings_folder


def written(folder: Path, *settings: tuple[str, str]) -> Store:
    return Store(write_settings_folder(folder, *settings))


@pytest.fixture
def several(tmp_path: Path) -> Store:
    return written(tmp_path / "run", *SEVERAL)


def test_a_setting_is_named_by_its_track_and_what_it_changes_there(several: Store) -> None:
    assert named_tracks(several) == ["default", "tuned", "cg-loose", "pgs"]
    assert compared_tracks(several) == ["default", "tuned"]
    assert setting_words(several, "mujoco", "cg-loose") == "default with solver cg, tolerance 10⁻⁵"
    assert setting_words(several, "mujoco", "pgs") == "tuned with solver pgs, split impulse on"
    assert setting_words(several, "dart", "pgs") == "tuned with solver pgs"
    assert setting_words(several, "mujoco 3.3.0", "pgs") == "tuned with solver pgs, split impulse on"
    assert setting_words(several, "bullet", "pgs") == "pgs", "it has none of that name"
    assert setting_words(several, "bullet", "tuned, split_impulse True") == "tuned, split impulse on"
    assert setting_words(several, "mujoco", "tuned") == "tuned"


@pytest.mark.parametrize("variants", ['variants = { mujoco = "x" }', "variants = { mujoco = { pgs = 1 } }"])
def test_a_study_that_says_nonsense_of_its_settings_leaves_their_names(tmp_path: Path, variants: str) -> None:
    store = written(tmp_path / "run", ("mujoco", "pgs"))
    tmp_path.joinpath("run", "study.toml").write_text(variants, encoding="utf-8")
    assert setting_words(store, "mujoco", "pgs") == "pgs"


def test_a_study_without_a_table_of_variants_is_refused_by_name(tmp_path: Path) -> None:
    store = written(tmp_path / "run", ("mujoco", "pgs"))
    tmp_path.joinpath("run", "study.toml").write_text("variants = 3", encoding="utf-8")
    with pytest.raises(StoreError, match=r"study\.toml: holds no study: variants"):
        setting_words(store, "mujoco", "pgs")


def test_the_key_results_say_settings_in_words_and_rank_none(several: Store) -> None:
    said = sentences(several)
    assert not [one for one in said if "cg-loose" in one or "On the pgs" in one]
    (unranked,) = [one for one in said if "beside the two tracks" in one]
    assert unranked.startswith("3 settings beside the two tracks are each one engine's own and are not ranked")
    (ranked,) = [one for one in said if one.startswith("What accuracy costs")]
    assert ranked.startswith("What accuracy costs, tuned, over")
    (broken,) = [one for one in said if "than the integrator promises" in one]
    assert "MuJoCo (default with solver cg, tolerance 10⁻⁵) in “Pendulum from 90 degrees”" in broken
    assert "DART (tuned with solver pgs) in “Pendulum from 90 degrees”" in broken


def test_without_such_settings_no_sentence_speaks_of_them(tmp_path: Path) -> None:
    store = Store(write_run_folder(tmp_path / "run", only=("joint_pendulum", "stack_tower")))
    assert not [one for one in sentences(store) if "beside the two tracks" in one]


def test_the_matrix_has_a_column_for_each_setting_that_an_engine_has_and_no_other(several: Store) -> None:
    page = texts_of(several, "index")["index.html"]
    heads = page.partition('<table class="matrix">')[2].partition("</thead>")[0]
    assert heads.count('class="track') == 2 * 5 + 3
    assert heads.count("default with solver cg, tolerance 10⁻⁵") == 1
    glance = page.partition('id="engines"')[2].partition("</table>")[0]
    assert {cell.count(" → ") for cell in glance.split("</td>")} == {0, 1}, "from default to tuned, and no farther"


def legend(store: Store) -> dict[str, float]:
    figure = across_cases(store, at_own_step(store, answers(store)), "error", "any", "e", "c")
    assert figure is not None
    filling = next(one["encoding"]["fillOpacity"] for one in figure.spec["layer"] if "fillOpacity" in one["encoding"])
    return dict(zip(filling["scale"]["domain"], filling["scale"]["range"], strict=True))


def test_what_is_neither_track_is_half_filled(several: Store) -> None:
    assert legend(several) == {
        "default": OPEN,
        "tuned": 1,
        "default with solver cg, tolerance 10⁻⁵": HALF,
        "tuned with solver pgs": HALF,
        "tuned with solver pgs, split impulse on": HALF,
    }


@pytest.mark.parametrize(("settings", "third"), [(ONE, "default with solver cg, tolerance 10⁻⁵"), (SEVERAL, "others")])
def test_a_still_chart_names_a_third_track_and_several_together(
    tmp_path: Path, settings: tuple[tuple[str, str], ...], third: str
) -> None:
    store = written(tmp_path / "run", *settings)
    rows = answers(store)
    for figure in (
        across_cases(store, at_own_step(store, rows), "error", "any", "e", "c"),
        error_by_step(store, rows[rows["case"] == "stack_tower"], "any", "e", "m"),
    ):
        assert figure is not None
        for name in ("default", "tuned", third):
            assert figure.svg.count(f">{name}</text>") == 1, name
