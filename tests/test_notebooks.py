"""Every notebook runs from top to bottom in its short form, asserts included, and is stored without its output."""

from pathlib import Path

import pytest
from conftest import imported

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs_and_is_stored_clean(path: Path, monkeypatch: pytest.MonkeyPatch):
    nbformat, nbclient = imported("nbformat"), imported("nbclient")
    imported("ipykernel")
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "clear the outputs before storing the notebook"
    # The kernel inherits it: fewer angles and points, the same asserts.
    monkeypatch.setenv("SHADOWLAB_SHORT", "1")
    # A failing cell or assert raises, with the cell in the message.
    done = nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(path.parent)}}).execute()
    assert any("image/png" in output.get("data", {}) for cell in done.cells for output in cell.get("outputs", []))
