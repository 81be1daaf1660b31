"""The notebook of `examples/`, executed by Jupyter's own kernel, and kept without what an execution leaves behind."""

import json
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[2] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path: Path) -> None:
    for cell in nbformat.read(path, as_version=4).cells:
        assert not cell.get("outputs"), cell.source
        assert cell.get("execution_count") is None, cell.source


def test_the_notebook_runs_and_draws_the_chart_of_prices(tmp_path: Path) -> None:
    """As a reader would execute it; a cell behind the last prints the chart's specification."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    (path,) = NOTEBOOKS
    notebook = nbformat.read(path, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell("print(chart.to_json())"))
    folder = {"metadata": {"path": str(tmp_path / "examples")}}
    NotebookClient(notebook, timeout=250, kernel_name="python3", resources=folder).execute()
    results = [output for cell in notebook.cells for output in cell.get("outputs", ()) if "data" in output]
    assert sum("vega-lite" in output["data"].get("text/html", "") for output in results) == 2, "motion and prices are drawn"
    (printed,) = notebook.cells[-1]["outputs"]
    prices = json.loads(printed["text"])
    ((_, rows),) = prices["datasets"].items()
    assert {row["engine"] for row in rows} >= {"mujoco", "bullet", "dart"}
    assert all(row["cost"] > 0 for row in rows)
    assert prices["encoding"]["y"]["field"] == "cost"
    assert (tmp_path / "examples" / "build" / "notebook" / "report" / "index.html").is_file()
