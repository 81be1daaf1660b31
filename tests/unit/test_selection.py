"""Selection: the better engine is named, equals share the resamples, and every number has its run."""

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from plumbline.harness.findings.selection import PresetError, Selection, Wish, choose, preset_names, read_preset
from plumbline.harness.findings.selection.choose import EXPRESSED
from plumbline.harness.findings.selection.decide import LEAST, WhatTurns, into
from plumbline.harness.findings.selection.words import decisive, headline, trade, turn_sentences
from plumbline.harness.store.store import Store
from plumbline.harness.study.plugins import names
from plumbline.reports.pages import index, select
from tests.conftest import Command
from tests.decided import decided
from tests.run_folder import CASES, LADDER
from tests.selection_folder import Made, write_selection_folder

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 20))]
GOOD, EQUAL, BAD = Made(error=0.3, cost=0.01), Made(error=2.0, cost=0.02), Made(error=12.0, cost=0.2)


Ask = Callable[..., Selection]


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> Ask:
    """What is chosen of runs of made engines; a run of the same ones by the same seed is made once, and only read."""
    runs: dict[str, Store] = {}

    def asked(engines: dict[str, Made], seed: int, wish: Wish | None = None) -> Selection:
        key = repr((engines, seed))
        if key not in runs:
            runs[key] = Store(write_selection_folder(tmp_path_factory.mktemp("made"), engines, seed))
        return choose(runs[key], wish or Wish(), draws=500)

    return asked


def numbers(found: Selection) -> dict[str, int]:
    assert found.rank is not None
    return {place.engine: place.number for place in found.rank.places}


def shares(found: Selection) -> dict[str, float]:
    assert found.rank is not None
    return {place.engine: place.first for place in found.rank.places}


@pytest.mark.parametrize("seed", SEEDS)
def test_the_known_best_is_first_in_nearly_all_resamples_and_the_dominated_one_never(answer: Ask, seed: int) -> None:
    found = answer({"dart": EQUAL, "mujoco": GOOD, "bullet": BAD}, seed)
    assert numbers(found) == {"mujoco": 1, "dart": 2, "bullet": 3}
    assert shares(found)["mujoco"] > 0.95
    assert shares(found)["bullet"] == 0.0
    assert headline(found, str).startswith("mujoco is first in ")


@pytest.mark.parametrize("seed", SEEDS)
def test_of_two_equal_ones_neither_is_certain(answer: Ask, seed: int) -> None:
    """Alike but for noise of a third from case to case; the seeds are fixed."""
    found = answer({"dart": EQUAL, "mujoco": EQUAL, "bullet": BAD}, seed)
    assert shares(found)["bullet"] == 0.0
    assert 0.005 < shares(found)["dart"] < 0.995


def test_equal_evidence_to_the_digit_shares_the_first_place_by_half(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path / "run", {"dart": EQUAL, "mujoco": EQUAL}, 0, noise=0.0)
    found = choose(Store(folder), Wish(), draws=500)
    assert found.rank is not None
    assert [place.first for place in found.rank.places] == [0.5, 0.5]


def test_there_is_no_order_where_all_that_is_known_counts_for_nothing(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path / "run", {"dart": EQUAL, "mujoco": GOOD}, 0, most=2)
    known = {criterion for criterion, _, _ in choose(Store(folder), Wish(), draws=10).evidence.table}
    found = choose(Store(folder), Wish(weights=dict.fromkeys(known, 0.0)), draws=10)
    assert found.rank is None
    assert headline(found, str) == "There is no evidence of these cases."


def test_what_an_engine_cannot_run_counts_as_nothing_in_each_criterion(answer: Ask) -> None:
    lacking = Made(error=0.3, cost=0.01, lacks=("joint_chain", "joint_pendulum", "stack_tower"))
    found = answer({"mujoco": lacking, "dart": GOOD}, 0)
    assert found.rank is not None
    means = {place.engine: place.by_criterion for place in found.rank.places}
    assert means["dart"]["capability"] == 1.0
    assert means["mujoco"]["capability"] == pytest.approx(0.7)
    assert means["mujoco"]["accuracy"] <= 0.7
    assert numbers(found)["dart"] == 1


def test_accuracy_falls_from_the_error_asked_for_to_ten_times_it_without_a_cliff(tmp_path: Path) -> None:
    """One step, at which errors are 1, the root of ten, and ten times the one asked for. All keep the bound of the check."""
    engines = {"mujoco": Made(0.05, 0.01), "dart": Made(0.05 * 10**0.5, 0.1), "bullet": Made(0.5, 1.0)}
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0, steps=(1 / 240,))
    found = choose(Store(folder), Wish(max_error=5e-4))
    assert found.rank is not None
    means = {place.engine: place.by_criterion for place in found.rank.places}
    accuracy = {engine: mean["accuracy"] for engine, mean in means.items()}
    assert accuracy == pytest.approx({"mujoco": 1.0, "dart": 0.5, "bullet": 0.0}, abs=1e-9)
    # A tenth of the highest speed is half of the way to no use, by the logarithm over two decades.
    speed = {engine: mean["speed"] for engine, mean in means.items()}
    assert speed == pytest.approx({"mujoco": 1.0, "dart": 0.5, "bullet": 0.0}, abs=1e-9)


def test_a_run_just_beyond_the_error_asked_for_keeps_its_speed(tmp_path: Path) -> None:
    """1.33 % at 385 times real time was worth nothing beside 0.98 % at 31.6 times, where 1 % was asked for."""
    engines = {"mujoco": Made(1.33, 1 / 385), "dart": Made(0.98, 1 / 31.6)}
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0, steps=(1 / 240,))
    found = choose(Store(folder), Wish(max_error=1e-2))
    assert found.rank is not None
    means = {place.engine: place.by_criterion for place in found.rank.places}
    assert means["mujoco"]["accuracy"] == pytest.approx(1 - math.log10(1.33), abs=1e-6)
    assert means["mujoco"]["speed"] == 1.0
    assert means["dart"]["speed"] == pytest.approx(1 - math.log10(385 / 31.6) / 2, abs=1e-6)
    assert numbers(found)["mujoco"] == 1


def test_robustness_is_not_measured_by_one_run(tmp_path: Path) -> None:
    for steps, known in (((1 / 240,), False), ((1 / 120, 1 / 240, 1 / 480), True)):
        folder = write_selection_folder(tmp_path / str(len(steps)), {"mujoco": GOOD, "dart": EQUAL}, 0, steps=steps)
        found = choose(Store(folder), Wish())
        assert found.rank is not None
        assert ("robustness" in found.rank.counted) == known


def test_requirements_leave_engines_out_with_a_reason_and_a_run(answer: Ask) -> None:
    engines = {"mujoco": GOOD, "dart": EQUAL, "bullet": BAD}
    error = answer(engines, 0, Wish(max_error=1e-3, strict=True))
    assert {drop.engine for drop in error.dropped} >= {"bullet"}
    assert all(drop.case and drop.trial and drop.value.startswith("best ") for drop in error.dropped)
    speed = answer(engines, 0, Wish(max_error=1e-1, realtime=20.0))
    assert {drop.engine for drop in speed.dropped} == {"bullet"}
    assert "times real time" in speed.dropped[0].requirement
    feature = answer(engines, 0, Wish(features=("anti_gravity",)))
    assert feature.rank is None
    assert headline(feature, str) == "No engine is left that there is evidence of."


def test_an_engine_that_ran_in_few_of_the_cases_is_left_out_and_spoils_nothing(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": EQUAL, "bullet": BAD}, 0)
    frame = pd.read_parquet(folder / "trials.parquet")
    kept = frame[(frame["engine"] != "bullet") | frame["case"].isin(["joint_chain", "stack_tower"])]
    kept.to_parquet(folder / "trials.parquet", index=False)
    found = choose(Store(folder), Wish(), draws=200)
    assert numbers(found) == {"mujoco": 1, "dart": 2}
    assert [(drop.engine, drop.value) for drop in found.dropped] == [("bullet", "20 %")]


NOTHING = Made(error=0.3, cost=0.01, lacks=tuple(CASES))


def test_where_one_engine_alone_can_express_the_scenes_there_is_no_contest_and_no_share(answer: Ask) -> None:
    """An engine without an answer is beaten by nobody: its zeros made the other first in 100 % of draws."""
    found = answer({"mujoco": GOOD, "dart": NOTHING, "bullet": NOTHING}, 0)
    assert numbers(found) == {"mujoco": 1}
    assert found.alone == "expresses"
    assert headline(found, str) == "mujoco is the only engine that can express these scenes, of 3 asked: there is no contest."
    assert {drop.engine: (drop.requirement, drop.value) for drop in found.dropped} == dict.fromkeys(
        ("dart", "bullet"), (EXPRESSED, "planted: no such thing")
    )
    assert all(drop.case and drop.trial for drop in found.dropped)
    one = answer({"mujoco": GOOD, "dart": NOTHING}, 1, Wish(cases={"joint_chain": 1.0}))
    assert headline(one, str) == "mujoco is the only engine that can express this scene, of 2 asked: there is no contest."


def test_an_engine_whose_answers_were_not_measured_expresses_the_scenes(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": NOTHING}, 0)
    frame = pd.read_parquet(folder / "trials.parquet")
    frame.loc[frame["engine"] == "dart", ["steps", "reason"]] = [240, "not measured: judging the answer took too much"]
    frame.to_parquet(folder / "trials.parquet", index=False)
    assert choose(Store(folder), Wish(), draws=200).alone != "expresses"


def test_an_engine_that_can_express_one_of_the_scenes_is_a_contestant(answer: Ask) -> None:
    lacking = Made(error=0.3, cost=0.01, lacks=tuple(name for name in CASES if name != "joint_chain"))
    found = answer({"mujoco": GOOD, "dart": lacking}, 0)
    assert found.alone == ""
    assert numbers(found) == {"mujoco": 1, "dart": 2}


def test_who_is_left_alone_by_requirements_or_was_asked_alone_is_not_called_first(answer: Ask) -> None:
    fast = answer({"mujoco": GOOD, "dart": NOTHING, "bullet": BAD}, 0, Wish(max_error=1e-1, realtime=20.0))
    assert fast.alone == "left"
    assert headline(fast, str) == "mujoco is the only engine left, of 3 asked: there is no contest."
    single = answer({"reference": GOOD, "mujoco": GOOD}, 0)
    assert single.alone == "single"
    assert headline(single, str) == "mujoco alone was asked: there is no contest."


def test_the_command_its_json_the_page_and_the_cards_say_that_there_is_no_contest(tmp_path: Path, printed: Command) -> None:
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": NOTHING, "bullet": NOTHING}, 0)
    words = "MuJoCo is the only engine that can express these scenes, of 3 asked: there is no contest."
    said = printed("select", folder).stdout
    assert said.startswith(words)
    assert "DART is left out: it can express no scene that counts (planted: no such thing, in “" in said
    assert "100 %" not in said
    rows = json.loads(printed("select", folder, "--json").stdout)
    assert {row["engine"]: (row["first"], row["alone"]) for row in rows} == {
        "mujoco": (None, "expresses"), "dart": (None, None), "bullet": (None, None)
    }  # fmt: skip
    store = Store(folder)
    pages = {name: str(page.render(store)[f"{name}.html"]) for name, page in (("select", select), ("index", index))}
    assert words in pages["select"]
    assert "Bullet is left out: it can express no scene that counts" in pages["select"]
    assert pages["index"].count(words) >= 3
    assert not any("in 100 % of" in page.replace("\u00a0", " ") for page in pages.values())


def test_a_run_of_one_engine_has_no_page_of_selection_and_no_link_to_it(tmp_path: Path) -> None:
    store = Store(write_selection_folder(tmp_path / "run", {"reference": GOOD, "mujoco": GOOD}, 0, most=2))
    assert not select.concerns(store)
    assert "select.html" not in str(index.render(store)["index.html"])


def test_few_cases_are_said_beside_the_share_that_they_give(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": EQUAL}, 0)
    few = choose(Store(folder), Wish(cases={"joint": 1.0}), draws=100)
    assert headline(few, str).endswith("Only 2 cases: treat the percentages as rough.")
    assert "rough" not in headline(choose(Store(folder), Wish(), draws=100), str)


def test_what_would_turn_the_answer_and_what_the_first_two_trade_is_told(tmp_path: Path) -> None:
    """One is exact and slow, the other off and fast: the latter leads once speed counts double."""
    engines = {"mujoco": Made(0.5, 0.9), "dart": Made(5.0, 0.05)}
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0, steps=(1 / 240,))
    found = choose(Store(folder), Wish())
    assert list(numbers(found)) == ["mujoco", "dart"]
    assert [(turn.kind, turn.name, turn.first) for turn in found.turns if turn.kind == "criterion"] == [
        ("criterion", "speed", "dart")
    ]
    assert trade(found, str) == ("mujoco has 10 of 10 cases within 1 %, dart 0; dart is 18\N{MULTIPLICATION SIGN} faster.")


def test_the_ratio_told_is_that_of_the_speeds_shown_and_these_are_of_the_same_cases(tmp_path: Path) -> None:
    """Costs differ by case, and one engine has no speed in three: what is fast there must not count for the other alone."""
    engines = {"mujoco": Made(0.5, 0.9), "dart": Made(5.0, 0.05, lacks=tuple(CASES)[:3])}
    found = choose(Store(write_selection_folder(tmp_path / "run", engines, 0, steps=(1 / 240,))), Wish(max_error=0.5))
    evidence = found.evidence
    assert len(evidence.compared) == len(CASES) - 3
    logs = [
        math.log(evidence.speeds[case, "dart"].times.value / evidence.speeds[case, "mujoco"].times.value)
        for case in evidence.compared
    ]
    ratio = math.exp(sum(logs) / len(logs))
    shown = {engine: evidence.speed(engine) for engine in engines}
    assert shown["dart"] == pytest.approx(ratio * shown["mujoco"])
    assert f"dart is {ratio:.2g}\N{MULTIPLICATION SIGN} faster" in trade(found, str)


def test_an_engine_without_a_speed_in_most_cases_has_none_and_takes_none_from_the_others(tmp_path: Path) -> None:
    engines = {"mujoco": Made(0.5, 0.9), "dart": Made(5.0, 0.05, lacks=tuple(CASES)[:6])}
    evidence = choose(
        Store(write_selection_folder(tmp_path / "run", engines, 0, steps=(1 / 240,))), Wish(max_error=0.5)
    ).evidence
    assert evidence.speed("dart") is None
    assert len(evidence.compared) == len(CASES)


def test_what_would_turn_the_answer_is_said_without_ids() -> None:
    titles = {"dart": "DART", "stack_tower": "A tower of boxes", "rest_jitter": "Standing still", "friction": "friction"}
    case, other = (WhatTurns(kind="case", name=name, first="dart") for name in ("stack_tower", "rest_jitter"))
    heavier = (WhatTurns(kind="criterion", name="speed", first="dart"), WhatTurns(kind="family", name="friction", first="dart"))

    def said(*turns: WhatTurns) -> list[str]:
        return turn_sentences(turns, titles.__getitem__, titles.__getitem__)

    assert said(case) == ["Without “A tower of boxes”, DART would be first."]
    assert said(case, other) == ["Without one of “A tower of boxes”, “Standing still”, DART would be first."]
    assert said(*heavier, case) == [
        "If speed or friction counted double, DART would be first.",
        "Without “A tower of boxes”, DART would be first.",
    ]


def test_our_own_engine_is_ranked_only_where_it_is_asked_for(answer: Ask) -> None:
    engines = {"reference": Made(0.1, 0.001), "dart": EQUAL}
    assert set(numbers(answer(engines, 0))) == {"dart"}
    assert set(numbers(answer(engines, 0, Wish(with_reference=True)))) == {"dart", "reference"}


def test_each_preset_asks_for_cases_that_there_are_and_says_why() -> None:
    families = {name.partition("_")[0] for name in names("cases")}
    for name in preset_names():
        preset = read_preset(name)
        for cases in preset.cases:
            wish = Wish(cases={cases.match: 1.0})
            assert any(wish.weight_of_case(case, case.partition("_")[0]) for case in names("cases")), (name, cases.match)
            assert len(cases.why) > 10
        assert families
    assert set(preset_names()) == {"games", "legged", "manipulation", "rl-throughput", "sensors", "teaching", "vehicles"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title = 1\n", "title"),
        ('title = "t"\nwhy = "w"\n[[cases]]\nmatch = "joint"\n', "cases.0.why"),
        (
            'title = "t"\nwhy = "w"\n[weights]\nbeauty = 1\n[[cases]]\nmatch = "joint"\nwhy = "because of it"\n',
            "weights.beauty",
        ),
        ("= \n", "line 1"),
    ],
)
def test_a_preset_that_is_wrong_is_refused_by_file_and_key(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(PresetError, match=words) as caught:
        read_preset(str(path))
    assert str(path) in str(caught.value)


def test_the_command_prints_places_reasons_and_gaps(tmp_path: Path, printed: Command) -> None:
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": EQUAL, "bullet": BAD}, 0)
    done = printed("select", folder, "--realtime", "20", "--max-error", "0.1", "--weight", "speed=3")
    assert done.returncode == 0
    assert done.stdout.startswith("MuJoCo is first in ")
    assert "Bullet is excluded: required 20 times real time" in done.stdout
    assert "Not measured in this run: limits, determinism." in done.stdout
    rows = json.loads(printed("select", folder, "--json").stdout)
    assert [row["engine"] for row in rows] == ["mujoco", "dart", "bullet"]
    assert rows[0]["place"] == 1
    for wrong in (("--weight", "beauty=1"), ("--weight", "speed=much"), ("--need", "joy"), ("--preset", "joy")):
        assert printed("select", folder, *wrong).returncode == 2


def test_what_would_decide_is_the_figure_whose_interval_moves_the_answer_most(tmp_path: Path) -> None:
    """Two are alike but for noise of a tenth; in one case the speed of one is known to a factor of ten alone."""
    folder = write_selection_folder(tmp_path / "run", {"mujoco": GOOD, "dart": GOOD}, 0, noise=0.1, steps=(1 / 240,))
    frame = pd.read_parquet(folder / "trials.parquet")
    wide = (frame["engine"] == "dart") & (frame["case"] == "joint_chain")
    frame.loc[wide, "cpu_low"], frame.loc[wide, "cpu_high"] = 0.1 * frame["cpu_per_sim_s"], 10 * frame["cpu_per_sim_s"]
    frame.to_parquet(folder / "trials.parquet", index=False)
    found = choose(Store(folder), Wish(max_error=1e-2))
    assert found.decider is not None
    assert (found.decider.criterion, found.decider.engine, found.decider.case) == ("speed", "dart", "joint_chain")
    command = "plumbline run accuracy --engine dart --case joint_chain"
    assert found.decider.command == command
    assert found.decider.runs == 1
    sentence, shown = decisive(found, str, str)
    assert shown == command
    assert sentence.startswith("What would decide it: to measure the speed of dart in “joint_chain” further; ")
    assert "'s share will then lie between " in sentence
    assert "(1 run of it here took " in sentence
    (folder / "journal.jsonl").touch()
    assert into(Store(folder)) == f" --out {folder} --resume=merge"
    certain = choose(Store(write_selection_folder(tmp_path / "far", {"mujoco": GOOD, "dart": BAD}, 0)), Wish())
    assert decisive(certain, str, str) == ("", "")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_decides_is_carried_out_until_nothing_is_left_that_would(tmp_path: Path, seed: int) -> None:
    """Each engine was run at its cases' own step alone. The ladder of the case and engine named puts the first engine where it
    was said to come out, is asked for once, and in the end the answer is that of all ladders.

    MuJoCo errs less than asked even at the ladder's largest step in most cases: there it is faster by four, and no more runs of
    the ladder would help, though its speed at the error asked for is still not known.
    """
    engines = {"mujoco": Made(error=0.15, cost=1.3), "dart": Made(error=0.6, cost=1.0), "bullet": Made(error=2.0, cost=0.5)}
    whole, now = (
        write_selection_folder(tmp_path / name, engines, seed, most=6, steps=steps)
        for name, steps in (("whole", LADDER), ("now", (1 / 240,)))
    )
    asked = list[tuple[str, str]]()
    while (decider := (answer := choose(Store(now), Wish(max_error=1e-2))).decider) is not None:
        assert answer.rank is not None
        first = answer.rank.places[0].engine
        assert decider.low - 0.02 <= answer.rank.places[0].first <= decider.high + 0.02
        assert (decider.case, decider.engine) not in asked
        asked.append((decider.case, decider.engine))
        now = with_ladder(tmp_path / str(len(asked)), now, whole, *asked[-1])
        then = choose(Store(now), Wish(max_error=1e-2)).rank
        assert then is not None
        (share,) = (place.first for place in then.places if place.engine == first)
        assert decider.low - 0.02 <= share <= decider.high + 0.02
    assert asked
    # What is left moves less than LEAST each, to either side.
    last, all_ = ({place.engine: place.first for place in choose(Store(each), Wish()).rank.places} for each in (now, whole))
    assert last == pytest.approx(all_, abs=2 * LEAST)


def test_a_run_of_one_step_knows_no_price_by_more_than_a_bound_and_says_who_is_first_all_the_same(tmp_path: Path) -> None:
    engines = {"mujoco": GOOD, "dart": BAD}
    single, several = (
        decided(Store(write_selection_folder(tmp_path / name, engines, 0, steps=steps)))
        for name, steps in (("single", (1 / 240,)), ("several", LADDER))
    )
    assert single[0] == 0 < several[0]
    assert single[1] <= several[1]
    assert single[2]["legged"][0] == several[2]["legged"][0] == "mujoco"


def with_ladder(folder: Path, before: Path, whole: Path, case: str, engine: str) -> Path:
    """The folder once `whole`'s runs of a case on an engine are in it too."""
    shutil.copytree(before, folder)
    runs = pd.read_parquet(whole / "trials.parquet")
    mine = set(runs["trial"][(runs["case"] == case) & (runs["engine"] == engine)])
    for name in ("trials.parquet", "measurements.parquet"):
        old, new = pd.read_parquet(before / name), pd.read_parquet(whole / name)
        rows = [old[~old["trial"].isin(mine)], new[new["trial"].isin(mine)]]
        pd.concat(rows, ignore_index=True).to_parquet(folder / name, index=False)
    return folder
