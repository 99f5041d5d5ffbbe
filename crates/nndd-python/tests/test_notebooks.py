"""Every notebook runs, and its assertions hold."""

from __future__ import annotations

from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))


#: The package that makes the mesh of each.
NEEDS = {"bracket": "gmsh", "gmsh": "gmsh", "scikit_fem": "skfem"}


def test_there_are_three() -> None:
    assert [notebook.stem for notebook in NOTEBOOKS] == list(NEEDS)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_keeps_its_outputs(notebook: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    cells = [cell for cell in nbformat.read(notebook, as_version=4).cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == [k + 1 for k in range(len(cells))]
    outputs = [output for cell in cells for output in cell.outputs]
    assert not [output for output in outputs if output.output_type == "error"]
    # What the last expression of a cell shows, and the pictures.
    plots = [cell for cell in cells if ".plot(" in cell.source or ".figures[" in cell.source]
    assert plots
    for plot in plots:
        assert any(output.get("data", {}).keys() & {"image/png", "image/svg+xml"} for output in plot.outputs)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_runs(notebook: Path) -> None:
    pytest.importorskip(NEEDS[notebook.stem])
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    nbclient.NotebookClient(nbformat.read(notebook, as_version=4), timeout=600, kernel_name="python3").execute()
