"""Pictures, and solutions in matplotlib and meshio, which are imported when they are asked for."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import needs
from ._results import BodyResult, ContactResult

#: The largest displacement is drawn as this part of the bodies' size.
_DRAWN = 0.1


@dataclass(frozen=True)
class Picture:
    """A figure of report.html, which a notebook shows.

    Examples
    --------
    >>> import nndd
    >>> solution = nndd.solve("tests/cases/paper.toml")
    >>> list(solution.figures)
    ['problem', 'von_mises', 'displacement', 'contact', 'deformed', 'convergence']
    """

    #: Its name.
    name: str
    #: The drawing, as SVG.
    svg: str = field(repr=False)
    #: The text that belongs to it.
    caption: str = field(repr=False)

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Write the SVG file.

        Parameters
        ----------
        path : path
            Where.
        """
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.svg)

    def _repr_svg_(self) -> str:
        return self.svg


def magnified(bodies: Sequence[BodyResult], scale: Optional[float]) -> float:
    """Return what displacements are multiplied by: the largest is drawn as a part of the bodies' size."""
    if scale is not None:
        return scale
    points = np.concatenate([body.mesh.points for body in bodies])
    largest = max(float(np.abs(body.displacement).max()) for body in bodies)
    return _DRAWN * float(np.ptp(points, axis=0).max()) / largest if largest > 0.0 else 1.0


def draw(bodies: Sequence[BodyResult], contacts: Sequence[ContactResult], scale: Optional[float]) -> Any:
    """Draw deformed bodies of the plane and pressures."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure as Plain
    except ImportError as error:
        raise needs("matplotlib", error) from error

    class Figure(Plain):
        """A figure that a notebook shows, whatever backend is chosen there."""

        def _repr_png_(self) -> bytes:
            out = io.BytesIO()
            FigureCanvasAgg(self).print_png(out)
            return out.getvalue()

    meshes = [(body, body.mesh.points[:, :2], body.displacement) for body in bodies]
    scale = magnified(bodies, scale)
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
        raise needs("meshio", error) from error
    points, cells, point_data, cell_data = _merged(bodies)
    of_cells = {name: [values] for name, values in cell_data.items()}
    kind = "tetra" if cells.shape[1] == 4 else "triangle"
    return meshio.Mesh(points, [(kind, cells)], point_data=point_data, cell_data=of_cells)
