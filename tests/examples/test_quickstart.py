"""The notebook runs against a hosted server, and what it shows is true."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from arramon_dataset.release.importer import import_release
from tests import ROOT
from tests.serving import Server

NOTEBOOK = ROOT / "examples" / "quickstart.ipynb"


def test_the_notebook_plays_on_a_host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sample = ROOT / "examples" / "sample"
    import_release([sample / "sample.json", sample / "sample_hindi.json"], tmp_path)
    server = Server(tmp_path)
    monkeypatch.setenv("ARRAMON_SERVER", server.address)
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    try:
        NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    finally:
        assert server.stop() == 0

    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    said = "".join(output["text"] for output in outputs if output.output_type == "stream" and output.name == "stdout")
    assert "sample {'en': 24, 'hi': 24} open" in said
    assert "steps in 2 episodes" in said
    assert any("quickstart on sample, hi, 2 episodes" in str(output.get("data")) for output in outputs)
    assert any("image/png" in output.get("data", {}) for output in outputs)


def test_the_notebook_is_kept_without_outputs() -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]

    assert code
    assert all(cell.outputs == [] and cell.execution_count is None for cell in code)
