"""What is made for a paper: vector graphics of the charts, tables in LaTeX, and where they came from."""

import re
from pathlib import Path

import pytest

from plumbline.harness.cli.listing import _latex_number
from plumbline.harness.intake.safe_text import latex_cell
from plumbline.harness.store.store import Store
from plumbline.reports.words.citation import citation, run_digest
from tests.conftest import Command
from tests.run_folder import write_run_folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run_folder(tmp_path_factory.mktemp("paper") / "run", only=("joint_chain", "stack_tower"))


@pytest.mark.parametrize(
    ("form", "begins", "charts"),
    [("svg", b"<svg", ("step", "price")), ("pdf", b"%PDF-", ("step",)), ("png", b"\x89PNG", ("step",))],
)
def test_the_charts_of_a_case_are_files_of_the_format_asked_for(
    folder: Path, tmp_path: Path, printed: Command, form: str, begins: bytes, charts: tuple[str, ...]
) -> None:
    asked = ("--chart", *charts) if len(charts) == 1 else ()
    done = printed("figure", folder, "--case", "joint_chain", *asked, "--format", form, "--out", tmp_path)
    assert done.returncode == 0
    paths = [Path(line) for line in done.stdout.splitlines()]
    assert [path.name for path in paths] == [f"case-joint_chain-{chart}.{form}" for chart in charts]
    assert all(path.read_bytes().startswith(begins) for path in paths)


def test_one_chart_and_what_is_not_there(folder: Path, tmp_path: Path, printed: Command) -> None:
    done = printed("figure", folder, "--case", "stack_tower", "--chart", "step", "--format", "svg", "--out", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["case-stack_tower-step.svg"]
    assert done.returncode == 0
    wrong = printed("figure", folder, "--case", "stack_towr")
    assert wrong.returncode == 2
    assert "there are joint_chain, stack_tower" in wrong.stderr


def test_a_table_in_latex_has_booktabs_digits_and_its_source(folder: Path, printed: Command) -> None:
    text = printed("show", folder, "--table", "trials", "--format", "latex").stdout
    lines = text.splitlines()
    assert lines[0] == "% study: quick"
    assert any(re.fullmatch(r"% run's digest: [0-9a-f]{16}", line) for line in lines)
    for word in (r"\toprule", r"\midrule", r"\bottomrule", r"\end{tabular}"):
        assert lines.count(word) == 1
    columns = len(next(line for line in lines if line.startswith("Case &")).split(" & "))
    body = lines[lines.index(r"\midrule") + 1 : lines.index(r"\bottomrule")]
    assert body
    assert all(len(re.split(r"(?<!\\) & ", row)) == columns for row in body)
    assert {re.split(r"(?<!\\) & ", row)[0] for row in body} == {"Chain with a heavy end", "Tower of ten boxes"}
    assert {"MuJoCo", "Plumbline reference"} <= {re.split(r"(?<!\\) & ", row)[1] for row in body}
    # 1/60 s in the unit of the heading, to three digits; a missing number is a dash, an interval has two ends.
    assert "Time step [ms]" in text
    assert "$16.7$" in text
    assert re.search(r"& \$[\d.]+\$--\$[\d.]+\$ &", text)
    assert "{" not in "".join(body).replace("10^{", "")


def test_prices_in_latex_are_numbers_with_their_interval_and_say_what_is_a_bound(folder: Path, printed: Command) -> None:
    lines = printed("show", folder, "--table", "price", "--format", "latex").stdout.splitlines()
    body = [re.split(r"(?<!\\) & ", line) for line in lines[lines.index(r"\midrule") + 1 : lines.index(r"\bottomrule")]]
    assert {row[-1].removesuffix(r" \\") for row in body} <= {
        "priced",
        "upper bound",
        "not reached",
        "not clocked",
        "no answer",
    }
    assert "$10^{-5}$" in {row[1] for row in body}
    assert {row[0] for row in body} == {"Chain with a heavy end", "Tower of ten boxes"}
    assert {"MuJoCo", "Plumbline reference"} <= {row[2] for row in body}
    assert any(row[4].count("$") == 4 for row in body)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0.0, "$0$"),
        (0.3694, "$0.369$"),
        (1234.4, "$1234$"),
        (0.00999999, "$0.0100$"),
        (0.01, "$10^{-2}$"),
        (99999.0, "$10^{5}$"),
        (2.5e-7, r"$2.50 \times 10^{-7}$"),
        (-1e-9, "$-10^{-9}$"),
        (float("inf"), r"$\infty$"),
        (float("nan"), "--"),
    ],
)
def test_a_number_has_three_digits(number: float, text: str) -> None:
    assert _latex_number(number) == text


def test_nothing_in_a_cell_is_a_command() -> None:
    assert latex_cell(r"\input{x} & $a_b$ 5 % #1 ~^<>") == (
        r"\textbackslash{}input\{x\} \& \$a\_b\$ 5 \% \#1 \textasciitilde{}\textasciicircum{}\textless{}\textgreater{}"
    )


def test_the_digest_of_a_run_changes_with_any_answer(folder: Path) -> None:
    store = Store(folder)
    before = run_digest(store)
    assert dict(citation(store))["run's digest"] == before
    other = Store(folder)
    other.trials.loc[0, "trajectory_hash"] = "0123456789abcdef"
    assert run_digest(other) != before


def test_a_chart_for_a_column_has_titles_on_several_lines_and_is_no_higher_than_wide(
    folder: Path, tmp_path: Path, printed: Command
) -> None:
    def frame(width: int) -> tuple[float, str]:
        out = tmp_path / str(width)
        printed(
            "figure",
            folder,
            "--case",
            "joint_chain",
            "--chart",
            "price",
            "--format",
            "svg",
            "--width",
            str(width),
            "--out",
            out,
        )
        text = (out / "case-joint_chain-price.svg").read_text()
        (inner,) = re.findall(r'class="background" aria-hidden="true" d="M0.5,0.5h[\d.]+v([\d.]+)h', text)
        return float(inner), text

    title = "error, as a share of the case's scale"
    high, text = frame(640)
    assert title in text
    narrow, text = frame(250)
    assert narrow <= 200 < high
    assert title not in text
    assert ">error, as a share<" in text
