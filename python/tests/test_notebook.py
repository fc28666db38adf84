"""The example notebook, run as it is."""

from __future__ import annotations

from pathlib import Path

import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
pytest.importorskip("gymnasium")


def test_the_notebook_runs() -> None:
    file = Path(__file__).parents[2] / "examples" / "linear_policy.ipynb"
    notebook = nbformat.read(file, 4)
    nbformat.validate(notebook)
    try:
        nbclient.NotebookClient(notebook, timeout=300).execute()
    except RuntimeError as error:
        if "Kernel" not in str(error):
            raise
        pytest.skip(f"no notebook's kernel starts here: {error}")
    printed = [output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("with the gains" in text for text in printed), printed


def test_the_ten_lines_of_the_documentation_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
    code = text.split("```python\n")[1].split("```")[0]
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 11
    names: dict[str, object] = {}
    exec(compile(code, "docs/python.md", "exec"), names)
    found = names["found"]
    assert len(found.rows) == 10 and (tmp_path / "cut-in.png").stat().st_size > 10_000  # type: ignore[attr-defined]
