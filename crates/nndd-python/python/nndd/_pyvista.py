"""Meshes from PyVista, solutions to it, and its views of solids. PyVista is imported when it is asked for."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Optional

import numpy as np

from ._errors import needs, refuse
from ._plot import magnified
from ._results import BodyResult, ContactResult


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError as error:
        raise needs("pyvista", error) from error
    return pyvista


@contextmanager
def saved(grid: Any) -> Iterator[Path]:
    """Write a grid to a file that is there for a while."""
    pyvista = _pyvista()
    if not isinstance(grid, (pyvista.DataSet, pyvista.MultiBlock)):
        refuse("grid", f"an object of type {type(grid).__name__}", "a grid of PyVista", "read one with pyvista.read")
    whole = grid.combine() if isinstance(grid, pyvista.MultiBlock) else grid.cast_to_unstructured_grid()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "grid.vtu"
        whole.save(file)
        yield file


def blocks_of(bodies: Sequence[BodyResult], contacts: Sequence[ContactResult]) -> Any:
    """Make a block of each body, and of each pair its edges or faces on the first body."""
    pyvista = _pyvista()
    kinds = {2: pyvista.CellType.LINE, 3: pyvista.CellType.TRIANGLE, 4: pyvista.CellType.TETRA}
    made = pyvista.MultiBlock()
    for body in bodies:
        grid = {"points": body.mesh.points, "cells": body.mesh._cells}
        _append(made, body.name, {**grid, "point_data": body.point_data, "cell_data": body.cell_data}, kinds)
    for pair in contacts:
        if pair._grid is not None:
            _append(made, pair.name, pair._grid, kinds)
    return made


def _append(blocks: Any, name: str, grid: dict[str, Any], kinds: dict[int, Any]) -> None:
    points, cells = grid["points"], grid["cells"]
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    made = _pyvista().UnstructuredGrid({kinds[cells.shape[1]]: cells}, points)
    made.point_data.update(grid["point_data"])
    made.cell_data.update(grid["cell_data"])
    blocks.append(made, name)


def view(bodies: Sequence[BodyResult], scale: Optional[float]) -> Any:
    """Show deformed solids by their von Mises stress; `None` without PyVista, or without a display."""
    try:
        import pyvista
    except ImportError:
        return None
    if not (pyvista.OFF_SCREEN or pyvista.system_supports_plotting()):
        return None
    scale = magnified(bodies, scale)
    plotter = pyvista.Plotter()
    for block in blocks_of(bodies, ()):
        moved = block.warp_by_vector("displacement", factor=scale)
        plotter.add_mesh(moved, scalars="von_mises", show_edges=moved.n_cells < _LINES)
    plotter.add_text(f"displacements × {scale:.3g}", font_size=10)
    plotter.add_axes()
    if plotter.notebook:
        return plotter.show(return_viewer=True)
    # Without a window the caller may want to take a picture.
    plotter.show(auto_close=not plotter.off_screen)
    return plotter


#: Meshes with more cells are drawn without their edges.
_LINES = 50_000
