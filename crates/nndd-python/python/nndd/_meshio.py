"""Meshes from meshio and to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._data import Floats, Integers
from ._errors import refuse

#: Corners of the kinds of cells that are taken.
_CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4, "line": 2, "line3": 2}
_PHYSICAL = "gmsh:physical"


def arrays(mesh: Any) -> tuple[Floats, Integers, dict[str, Integers], dict[str, Integers]]:
    """Return points, triangles, sides and regions of a mesh of meshio."""
    points = np.asarray(mesh.points, dtype=np.float64)
    triangles: list[Integers] = []
    edges: list[Integers] = []
    # For each block: its dimension and the numbers of the triangles or edges of each of its cells.
    places: list[tuple[int, list[Integers]]] = []
    count = {1: 0, 2: 0}
    for block in mesh.cells:
        corners = _CORNERS.get(block.type)
        if corners is None:
            places.append((0, []))
            continue
        cells = np.asarray(block.data, dtype=np.int64)[:, :corners]
        parts = [cells] if corners < 4 else _halves(points, cells)
        dimension = 1 if corners == 2 else 2
        first = count[dimension] + np.arange(len(cells), dtype=np.int64)
        places.append((dimension, [first + k * len(cells) for k in range(len(parts))]))
        count[dimension] += len(cells) * len(parts)
        (edges if dimension == 1 else triangles).extend(parts)
    if not triangles:
        refuse("mesh", "no triangles and no quadrilaterals", "a mesh of the plane", "look at mesh.cells")
    named = _groups(mesh, places)
    every_edge = np.concatenate(edges) if edges else np.zeros((0, 2), dtype=np.int64)
    sides = {name: every_edge[cells] for name, cells in named[1].items()}
    return (*_used(points, np.concatenate(triangles), sides), named[2])


def _halves(points: Floats, quads: Integers) -> list[Integers]:
    """Split quadrilaterals along their shorter diagonals."""
    lengths = [np.linalg.norm(points[quads[:, a]] - points[quads[:, b]], axis=1) for a, b in ((0, 2), (1, 3))]
    along = (lengths[0] <= lengths[1])[:, None]
    first = np.where(along, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    second = np.where(along, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return [first, second]


def _groups(mesh: Any, places: list[tuple[int, list[Integers]]]) -> dict[int, dict[str, Integers]]:
    """Collect the named groups of edges (1) and triangles (2)."""
    found: dict[int, dict[str, list[Integers]]] = {1: {}, 2: {}}

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


def _used(points: Floats, triangles: Integers, sides: dict[str, Integers]) -> tuple[Floats, Integers, dict[str, Integers]]:
    """Leave out the nodes that no triangle has, such as those in the middle of quadratic cells."""
    nodes = np.unique(triangles)
    number = np.full(len(points), -1, dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    kept = {name: number[edges] for name, edges in sides.items()}
    return points[nodes], number[triangles], {name: edges[(edges >= 0).all(axis=1)] for name, edges in kept.items()}
