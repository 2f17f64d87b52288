"""The book's page and the notebook run as they stand."""

import json
import re
import shutil
from pathlib import Path

import nbclient
import nbformat
import pytest

HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "docs/python.md"
NOTEBOOK = HERE.parent / "examples/first_diagnosis.ipynb"


def test_every_snippet_of_the_book_runs(inside: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    # Snippets on a cluster are run by the test of Ray.
    blocks = [block for block in blocks if "ray" not in block]
    assert len(blocks) >= 3
    shutil.copy("m.toml", "machine.toml")
    shutil.copy("a.csv", "log.csv")
    shutil.copy("b.csv", "other.csv")
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert "coulomb_friction" in capsys.readouterr().out


def test_the_notebook_runs(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "it is kept without outputs"
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = json.dumps([cell.get("outputs", []) for cell in notebook.cells])
    assert "text/html" in shown and "coulomb_friction" in shown
