"""Meshes from meshio and to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._data import Floats, Integers
from ._errors import needs, refuse

if TYPE_CHECKING:
    from ._mesh import Mesh

#: Dimension and corners of the kinds of cells that are taken.
_KINDS = {
    **dict.fromkeys(("line", "line3"), (1, 2)),
    **dict.fromkeys(("triangle", "triangle6", "triangle7"), (2, 3)),
    **dict.fromkeys(("quad", "quad8", "quad9"), (2, 4)),
    **dict.fromkeys(("tetra", "tetra10"), (3, 4)),
    **dict.fromkeys(("pyramid", "pyramid13", "pyramid14"), (3, 5)),
    **dict.fromkeys(("wedge", "wedge15", "wedge18"), (3, 6)),
    **dict.fromkeys(("hexahedron", "hexahedron20", "hexahedron24", "hexahedron27"), (3, 8)),
}
#: The faces of volumes by their numbers of corners; a triangle's last corner is there twice.
_FACES = {
    5: [[0, 1, 2, 3], [0, 1, 4, 4], [1, 2, 4, 4], [2, 3, 4, 4], [3, 0, 4, 4]],
    6: [[0, 1, 2, 2], [3, 4, 5, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    8: [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}
_PHYSICAL = "gmsh:physical"


def arrays(mesh: Any) -> dict[str, Any]:
    """Return points, triangles or tetrahedra, sides and regions of a mesh of meshio."""
    points = np.asarray(mesh.points, dtype=np.float64)
    # By dimension the edges, triangles and tetrahedra.
    every: dict[int, list[Integers]] = {1: [], 2: [], 3: []}
    # For each block: its dimension, the number of its first edge, triangle or tetrahedron, and the cell that each of them is of.
    places: list[tuple[int, int, Integers]] = []
    solid = any(_KINDS.get(block.type, (0, 0))[0] == 3 for block in mesh.cells)
    for block in mesh.cells:
        dimension, corners = _KINDS.get(block.type, (0, 0))
        if dimension == 0:
            places.append((0, 0, np.zeros(0, dtype=np.int64)))
            continue
        made, owners = _split(points, np.asarray(block.data, dtype=np.int64)[:, :corners], dimension, solid)
        places.append((dimension, sum(map(len, every[dimension])), owners))
        every[dimension].append(made)
    if not every[2] and not every[3]:
        refuse("mesh", "no triangles, quadrilaterals or volumes", "a mesh of cells that are read", "look at mesh.cells")
    dimension, what = (3, "tetrahedra") if every[3] else (2, "triangles")
    named = _groups(mesh, places)
    facets = np.concatenate(every[dimension - 1] or [np.zeros((0, dimension), dtype=np.int64)])
    sides = {name: facets[numbers] for name, numbers in named[dimension - 1].items()}
    points, cells, sides = _used(points, np.concatenate(every[dimension]), sides)
    return {"points": points, what: cells, "sides": sides, "regions": named[dimension]}


def meshio_of(mesh: Mesh) -> Any:
    """Make a mesh of meshio: a block of cells and one of the edges or faces of sides, and cell sets."""
    try:
        import meshio
    except ImportError as error:
        raise needs("meshio", error) from error
    solid = mesh.tetrahedra is not None
    points = np.column_stack([mesh.points, np.zeros((len(mesh.points), 3 - mesh.points.shape[1]))])
    blocks = [("tetra" if solid else "triangle", mesh._cells)]
    none = np.zeros(0, dtype=np.int64)
    sets = {name: [cells, none] for name, cells in mesh.regions.items()}
    first = 0
    for name, facets in mesh.sides.items():
        sets.setdefault(name, [none, none])[1] = first + np.arange(len(facets))
        first += len(facets)
    if first > 0:
        blocks.append(("triangle" if solid else "line", np.concatenate(list(mesh.sides.values()))))
    return meshio.Mesh(points, blocks, cell_sets={name: of[: len(blocks)] for name, of in sets.items()})


def _split(points: Floats, cells: Integers, dimension: int, solid: bool) -> tuple[Integers, Integers]:
    """Split quadrilaterals and volumes into triangles and tetrahedra; also return the cell that each is of."""
    every = np.arange(len(cells), dtype=np.int64)
    corners = cells.shape[1]
    if corners == dimension + 1:
        return cells, every
    if dimension == 2:
        return np.concatenate(_halves(points, cells, solid)), np.tile(every, 2)
    # The tetrahedra between the smallest node of a cell and the triangles that it is not on.
    apex = cells.min(axis=1, keepdims=True)
    made, owners = [], []
    for face in _FACES[corners]:
        nodes = cells[:, face]
        triangles = [nodes[:, :3]] if face[2] == face[3] else _halves(points, nodes, solid)
        for triangle in triangles:
            apart = (triangle != apex).all(axis=1)
            made.append(np.column_stack([apex, triangle])[apart])
            owners.append(every[apart])
    return np.concatenate(made), np.concatenate(owners)


def _halves(points: Floats, quads: Integers, solid: bool) -> list[Integers]:
    """Split quadrilaterals along their shorter diagonals; in a mesh of volumes through their smallest nodes."""
    if solid:
        along = (quads.argmin(axis=1) % 2 == 0)[:, None]
    else:
        lengths = [np.linalg.norm(points[quads[:, a]] - points[quads[:, b]], axis=1) for a, b in ((0, 2), (1, 3))]
        along = (lengths[0] <= lengths[1])[:, None]
    first = np.where(along, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    second = np.where(along, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return [first, second]


def _groups(mesh: Any, places: list[tuple[int, int, Integers]]) -> dict[int, dict[str, Integers]]:
    """Collect the named groups of edges (1), triangles (2) and tetrahedra (3)."""
    found: dict[int, dict[str, list[Integers]]] = {1: {}, 2: {}, 3: {}}

    def add(name: str, block: int, cells: Any) -> None:
        dimension, first, owners = places[block]
        if dimension:
            found[dimension].setdefault(name, []).append(first + np.flatnonzero(np.isin(owners, cells)))

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
