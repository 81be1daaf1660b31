"""What a metric takes of the machine is never an engine's outcome: the engine answered, and its answer was not measured."""

from pathlib import Path

from plumbline.harness.store.store import Store
from tests.conftest import Command

STUDY = """
name = "judging"
recordings = false
[[experiments]]
name = "judging"
cases = ["stress_memory", "stress_time", "stress_refused"]
tracks = ["tuned"]
timing = false
deadline = 3.0
memory = 1000.0
"""


def test_a_metric_that_takes_too_much_is_told_as_not_measured(tmp_path: Path, plumbline: Command) -> None:
    (tmp_path / "judging.toml").write_text(STUDY)
    done = plumbline("run", tmp_path / "judging.toml", "--engine", "sound", "--out", tmp_path / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    store = Store(tmp_path / "out")
    trials = store.trials.set_index("case")
    for case, limit in (("stress_memory", "more than 1000 MB"), ("stress_time", "deadline of 3 s passed")):
        assert trials.loc[case]["status"] == "unsupported"
        assert trials.loc[case]["reason"].startswith(f"not measured: judging the answer took too much: {limit}")
        assert trials.loc[case]["steps"] > 0
    # One metric that is refused its memory leaves the others their values.
    assert trials.loc["stress_refused"]["status"] == "passed"
    rows = store.measurements
    (refused,) = rows[rows["metric"] == "refused_metric"].to_dict("records")
    assert refused["because"].startswith("not measured: out of memory")
