"""Solutions in other packages: matplotlib, meshio, PyVista. They are imported when they are asked for."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from ._errors import refuse
from ._results import BodyResult, ContactResult

#: The largest displacement is drawn as this part of the bodies' size.
_DRAWN = 0.1


def _needs(package: str, error: ImportError) -> ImportError:
    return ImportError(f"this needs the package {package}: pip install {package}", name=error.name)


def draw(bodies: Sequence[BodyResult], contacts: Sequence[ContactResult], scale: Optional[float]) -> Any:
    """Draw deformed bodies and pressures."""
    for body in bodies:
        if body.mesh.tetrahedra is not None:
            refuse(body.name, "solids are not drawn here", "bodies of the plane", "use to_pyvista, or ParaView")
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure as Plain
    except ImportError as error:
        raise _needs("matplotlib", error) from error

    class Figure(Plain):
        """A figure that a notebook shows, whatever backend is chosen there."""

        def _repr_png_(self) -> bytes:
            out = io.BytesIO()
            FigureCanvasAgg(self).print_png(out)
            return out.getvalue()

    meshes = [(body, body.mesh.points[:, :2], body.displacement) for body in bodies]
    every = np.concatenate([points for _, points, _ in meshes])
    largest = max(float(np.abs(u).max()) for _, _, u in meshes)
    if scale is None:
        size = float(np.ptp(every, axis=0).max())
        scale = _DRAWN * size / largest if largest > 0.0 else 1.0
    pairs = [pair for pair in contacts if len(pair.s) > 0]
    figure = Figure(figsize=(10.0, 4.5) if pairs else (6.0, 4.5), layout="constrained")
    axes = figure.subplots(1, 2 if pairs else 1, squeeze=False)[0]
    stresses = [body.von_mises for body, _, _ in meshes]
    known = [stress for stress in stresses if stress is not None]
    limits = (min(float(s.min()) for s in known), max(float(s.max()) for s in known)) if known else (0.0, 1.0)
    drawn = None
    for (body, points, u), stress in zip(meshes, stresses):
        corners = (points + scale * u)[body.mesh.triangles]
        drawn = PolyCollection(list(corners), array=stress, cmap="viridis", edgecolors="face", linewidths=0.1)
        drawn.set_clim(*limits)
        axes[0].add_collection(drawn)
    axes[0].autoscale()
    axes[0].set_aspect("equal")
    axes[0].set_title(f"displacements × {scale:.3g}")
    if drawn is not None and known:
        figure.colorbar(drawn, ax=axes[0], label="von Mises stress")
    for pair in pairs:
        axes[1].plot(pair.s, pair.pressure, marker=".", label=pair.name)
    if pairs:
        axes[1].set_xlabel("arc length")
        axes[1].set_ylabel("contact pressure")
        axes[1].legend()
    return figure


def _merged(bodies: Sequence[BodyResult]) -> tuple[npt.NDArray[Any], npt.NDArray[Any], dict[str, Any], dict[str, Any]]:
    """Join all bodies: points (n, 3), triangles or tetrahedra, and the fields that every body has."""
    points, cells, first = [], [], 0
    for body in bodies:
        own = body.mesh.points
        points.append(np.column_stack([own, np.zeros((len(own), 3 - own.shape[1]))]))
        cells.append(body.mesh._cells + first)
        first += len(own)

    def joined(fields: list[dict[str, Any]]) -> dict[str, Any]:
        names = [name for name in fields[0] if all(name in of for of in fields)]
        return {name: np.concatenate([of[name] for of in fields]) for name in names}

    point_data = joined([body.point_data for body in bodies])
    cell_data = joined([body.cell_data for body in bodies])
    return np.concatenate(points), np.concatenate(cells), point_data, cell_data


def to_meshio(bodies: Sequence[BodyResult]) -> Any:
    """Make a mesh of meshio."""
    try:
        import meshio
    except ImportError as error:
        raise _needs("meshio", error) from error
    points, cells, point_data, cell_data = _merged(bodies)
    of_cells = {name: [values] for name, values in cell_data.items()}
    kind = "tetra" if cells.shape[1] == 4 else "triangle"
    return meshio.Mesh(points, [(kind, cells)], point_data=point_data, cell_data=of_cells)


def to_pyvista(bodies: Sequence[BodyResult]) -> Any:
    """Make a grid of PyVista."""
    try:
        import pyvista
    except ImportError as error:
        raise _needs("pyvista", error) from error
    points, cells, point_data, cell_data = _merged(bodies)
    kind = pyvista.CellType.TETRA if cells.shape[1] == 4 else pyvista.CellType.TRIANGLE
    grid = pyvista.UnstructuredGrid({kind: cells}, points)
    for name, values in point_data.items():
        grid.point_data[name] = values
    for name, values in cell_data.items():
        grid.cell_data[name] = values
    return grid
