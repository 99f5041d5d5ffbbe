"""Meshes from meshio and to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._data import Floats, Integers
from ._errors import refuse

#: Dimension and corners of the kinds of cells that are taken.
_KINDS = {
    **dict.fromkeys(("line", "line3"), (1, 2)),
    **dict.fromkeys(("triangle", "triangle6", "triangle7"), (2, 3)),
    **dict.fromkeys(("quad", "quad8", "quad9"), (2, 4)),
    **dict.fromkeys(("tetra", "tetra10"), (3, 4)),
}
_PHYSICAL = "gmsh:physical"


def arrays(mesh: Any) -> dict[str, Any]:
    """Return points, triangles or tetrahedra, sides and regions of a mesh of meshio."""
    points = np.asarray(mesh.points, dtype=np.float64)
    # By dimension the edges, triangles and tetrahedra.
    every: dict[int, list[Integers]] = {1: [], 2: [], 3: []}
    # For each block: its dimension and the numbers of the edges, triangles or tetrahedra of each of its cells.
    places: list[tuple[int, list[Integers]]] = []
    for block in mesh.cells:
        dimension, corners = _KINDS.get(block.type, (0, 0))
        if dimension == 0:
            places.append((0, []))
            continue
        cells = np.asarray(block.data, dtype=np.int64)[:, :corners]
        parts = _halves(points, cells) if (dimension, corners) == (2, 4) else [cells]
        first = sum(map(len, every[dimension])) + np.arange(len(cells), dtype=np.int64)
        places.append((dimension, [first + k * len(cells) for k in range(len(parts))]))
        every[dimension].extend(parts)
    if not every[2] and not every[3]:
        refuse("mesh", "no triangles, quadrilaterals or tetrahedra", "a mesh of cells that are read", "look at mesh.cells")
    dimension, what = (3, "tetrahedra") if every[3] else (2, "triangles")
    named = _groups(mesh, places)
    facets = np.concatenate(every[dimension - 1] or [np.zeros((0, dimension), dtype=np.int64)])
    sides = {name: facets[numbers] for name, numbers in named[dimension - 1].items()}
    points, cells, sides = _used(points, np.concatenate(every[dimension]), sides)
    return {"points": points, what: cells, "sides": sides, "regions": named[dimension]}


def _halves(points: Floats, quads: Integers) -> list[Integers]:
    """Split quadrilaterals along their shorter diagonals."""
    lengths = [np.linalg.norm(points[quads[:, a]] - points[quads[:, b]], axis=1) for a, b in ((0, 2), (1, 3))]
    along = (lengths[0] <= lengths[1])[:, None]
    first = np.where(along, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    second = np.where(along, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return [first, second]


def _groups(mesh: Any, places: list[tuple[int, list[Integers]]]) -> dict[int, dict[str, Integers]]:
    """Collect the named groups of edges (1), triangles (2) and tetrahedra (3)."""
    found: dict[int, dict[str, list[Integers]]] = {1: {}, 2: {}, 3: {}}

    def add(name: str, block: int, cells: Any) -> None:
        dimension, parts = places[block]
        if dimension:
            found[dimension].setdefault(name, []).extend(numbers[cells] for numbers in parts)

    for name, blocks in (mesh.cell_sets or {}).items():
        for k, cells in enumerate(blocks):
            if not name.startswith("gmsh:") and cells is not None and len(cells) > 0:
                add(name, k, np.asarray(cells, dtype=np.int64))
    names = {(int(tag), int(dimension)): name for name, (tag, dimension) in (mesh.field_data or {}).items()}
    for k, tags in enumerate((mesh.cell_data or {}).get(_PHYSICAL, [])):
        for tag in np.unique(tags):
            dimension = places[k][0]
            name = names.get((int(tag), dimension), str(int(tag)))
            if dimension and name not in (mesh.cell_sets or {}):
                add(name, k, np.flatnonzero(np.asarray(tags) == tag))
    return {d: {name: np.unique(np.concatenate(all_)) for name, all_ in of.items() if all_} for d, of in found.items()}


def _used(points: Floats, cells: Integers, sides: dict[str, Integers]) -> tuple[Floats, Integers, dict[str, Integers]]:
    """Leave out the nodes that no cell has, such as those in the middle of quadratic cells."""
    nodes = np.unique(cells)
    number = np.full(len(points), -1, dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    kept = {name: number[facets] for name, facets in sides.items()}
    return points[nodes], number[cells], {name: facets[(facets >= 0).all(axis=1)] for name, facets in kept.items()}
