"""The example notebooks and the documentation's code, run as they are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
pytest.importorskip("gymnasium")


# A notebook and what one of its cells prints or shows.
NOTEBOOKS = {"linear_policy.ipynb": "with the gains", "tutorial.ipynb": "completed - mine - 2 faults"}


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_the_notebook_runs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    file = Path(__file__).parents[2] / "examples" / name
    notebook = nbformat.read(file, 4)
    nbformat.validate(notebook)
    if command := os.environ.get("TIMEGAP_COMMAND"):
        monkeypatch.setenv("TIMEGAP", command)
    elif name == "tutorial.ipynb":
        pytest.skip("TIMEGAP_COMMAND does not name the program")
    try:
        nbclient.NotebookClient(notebook, timeout=300).execute()
    except RuntimeError as error:
        if "Kernel" not in str(error):
            raise
        pytest.skip(f"no notebook's kernel starts here: {error}")
    printed = [output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any(NOTEBOOKS[name] in text for text in printed), printed


def test_the_ten_lines_of_the_documentation_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
    code = text.split("```python\n")[1].split("```")[0]
    lines = [line for line in code.splitlines() if line.strip() and '"""' not in line]
    assert len(lines) <= 10, f"{len(lines)} lines"
    names: dict[str, object] = {}
    exec(compile(code, "docs/python.md", "exec"), names)
    found = names["found"]
    assert len(found.rows) == 10 and (tmp_path / "cut-in.png").stat().st_size > 10_000  # type: ignore[attr-defined]
