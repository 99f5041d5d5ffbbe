"""Meshes of triangles, and of tetrahedra."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _nndd
from ._data import Floats, Integers, Pair, Vector, floats, integers
from ._errors import refuse, refusing


class Mesh:
    """A mesh of triangles or tetrahedra with named sides and regions. Its arrays cannot be written to.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array_like of float
        Coordinates of the nodes, m. The third column of a mesh of triangles must be the same everywhere.
    triangles : (m, 3) array_like of int
        The nodes of each triangle, from 0, in either direction.
    sides : mapping of str to (k, 2) or (k, 3) array_like of int, optional
        Edges of triangles by their two nodes, faces of tetrahedra by their three nodes, for supports, loads and contact.
    regions : mapping of str to (k,) array_like of int, optional
        Numbers of cells, for `Body` and `Body.region`.
    tetrahedra : (m, 4) array_like of int
        Instead of triangles, the nodes of each tetrahedron, from 0, in any order.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], {"bottom": [[0, 1]]})
    >>> mesh
    <Mesh: 4 nodes, 2 triangles, sides: bottom>
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        triangles: Optional[npt.ArrayLike] = None,
        sides: Optional[Mapping[str, npt.ArrayLike]] = None,
        regions: Optional[Mapping[str, npt.ArrayLike]] = None,
        *,
        tetrahedra: Optional[npt.ArrayLike] = None,
    ) -> None:
        if (triangles is None) == (tetrahedra is None):
            given = "neither triangles nor" if triangles is None else "triangles and"
            refuse("mesh", f"{given} tetrahedra", "one of the two", "write Mesh(points, triangles) or tetrahedra=…")
        axes = 2 if tetrahedra is None else 3
        what, cells = ("triangles", triangles) if tetrahedra is None else ("tetrahedra", tetrahedra)
        self._points = _fixed(floats(points, "points", *[(None, columns) for columns in range(axes, 4)]))
        self._cells: Integers = _fixed(integers(cells, what, (None, axes + 1)))
        self._sides = {name: _fixed(integers(nodes, f"sides[{name!r}]", (None, axes))) for name, nodes in (sides or {}).items()}
        self._regions = {name: _fixed(integers(cells, f"regions[{name!r}]", (None,))) for name, cells in (regions or {}).items()}
        self._generator: Optional[dict[str, Any]] = None

    @classmethod
    @refusing
    def read(cls, path: Union[str, os.PathLike[str]]) -> Mesh:
        """Read a mesh file: Gmsh (.msh), Abaqus-style (.inp), Exodus II (.e, .exo, .g) or VTK (.vtu).

        Nodes and cells are counted from 0, in the order of the file's numbers. Quadrilaterals, hexahedra, prisms and pyramids are
        split, quadratic cells reduced to their corners, and nodes without a cell left out. A file with volumes is a mesh of
        tetrahedra.

        Parameters
        ----------
        path : path
            The file. If it has groups of cells, the cells without a group are left out.

        Returns
        -------
        Mesh
            Its sides are physical curves, sets of nodes, surfaces and side sets, its regions physical surfaces, sets of elements
            and blocks. Of volumes, physical surfaces are sides, and physical volumes regions. In a .vtu file the value 3 of a
            whole-number array ``part`` at cells is the region, of surfaces the side, ``part_3``.
        """
        arrays, _notes = _nndd.read_mesh(path)
        return cls._of(arrays)

    @classmethod
    def from_meshio(cls, mesh: Any) -> Mesh:
        """Take a mesh of meshio.

        Parameters
        ----------
        mesh : meshio.Mesh
            With triangles or quadrilaterals, or with volumes, which are split into tetrahedra; linear or quadratic. Its cell
            sets, or Gmsh's physical groups, become sides (of lines, in a mesh of volumes of surfaces) and regions (of cells).
        """
        from ._meshio import arrays

        return cls(**arrays(mesh))

    def to_meshio(self) -> Any:
        """Return a meshio.Mesh, whose cell sets are the sides and regions."""
        from ._meshio import meshio_of

        return meshio_of(self)

    @classmethod
    @refusing
    def from_pyvista(cls, grid: Any) -> Mesh:
        """Take a grid of PyVista, as `read` takes a .vtu file.

        Parameters
        ----------
        grid : pyvista.DataSet or pyvista.MultiBlock
            With triangles or quadrilaterals, or with volumes; linear or quadratic. The value 3 of a whole-number array ``part``
            at cells is the region, of surfaces in a grid of volumes the side, ``part_3``.
        """
        from ._pyvista import saved

        with saved(grid) as file:
            return cls.read(file)

    @classmethod
    def block(cls, origin: Pair, size: Pair, cells: Sequence[int]) -> Mesh:
        """Generate a rectangle with the sides bottom, right, top, left.

        Parameters
        ----------
        origin : (2,) array_like
            Lower left corner, m.
        size : (2,) array_like
            Width and height, m.
        cells : (2,) sequence of int
            Rectangles in each direction; each is cut in two triangles.

        Examples
        --------
        >>> Mesh.block((0, 0), (2, 1), (18, 9))
        <Mesh: 190 nodes, 324 triangles, sides: bottom, left, right, top>
        """
        return cls._generated(kind="block", origin=origin, size=size, cells=cells)

    @classmethod
    def ring(cls, centre: Pair, radii: Pair, cells: Sequence[int], *, angles: Pair = (0.0, 360.0)) -> Mesh:
        """Generate a ring, or a sector of one, with the sides inner, outer, start, end.

        Parameters
        ----------
        centre, radii : (2,) array_like
            m.
        cells : (2,) sequence of int
            Around and across.
        angles : (2,) array_like
            Start and end, degrees.
        """
        return cls._generated(kind="ring", centre=centre, radii=radii, angles=angles, cells=cells)

    @classmethod
    def disc(cls, centre: Pair, radius: float, cells: int, *, start: float = 0.0) -> Mesh:
        """Generate a full disc with the side rim.

        Parameters
        ----------
        centre : (2,) array_like
            m.
        radius : float
            m.
        cells : int
            From the centre to the rim, which has six times as many edges.
        start : float
            Direction of the first node of the rim, degrees.
        """
        return cls._generated(kind="disc", centre=centre, radius=radius, cells=cells, start=start)

    @classmethod
    def half_disc(cls, pole: Pair, radius: float, facing: str, half_width: float, cells: int) -> Mesh:
        """Generate half a disc, fine near its pole, with the sides contact, arc, flat.

        Parameters
        ----------
        pole : (2,) array_like
            The middle of the arc, m.
        radius, half_width : float
            Of the disc, and of the side contact, m.
        facing : {"down", "up"}
            Direction of the pole.
        cells : int
            From the pole to the end of contact.
        """
        return cls._generated(kind="half_disc", pole=pole, radius=radius, facing=facing, half_width=half_width, cells=cells)

    @classmethod
    def box(cls, origin: Vector, size: Vector, cells: Sequence[int]) -> Mesh:
        """Generate a box of tetrahedra with the sides left, right, front, back, bottom, top.

        Parameters
        ----------
        origin : (3,) array_like
            The corner with the smallest coordinates, m.
        size : (3,) array_like
            Lengths along the axes, m.
        cells : (3,) sequence of int
            Boxes in each direction; each is cut in six tetrahedra.

        Examples
        --------
        >>> Mesh.box((0, 0, 0), (2, 1, 1), (4, 2, 2))
        <Mesh: 45 nodes, 96 tetrahedra, sides: back, bottom, front, left, right, top>
        """
        return cls._generated(kind="box", origin=origin, size=size, cells=cells)

    @classmethod
    def tube(
        cls, radii: Pair, length: float, cells: Sequence[int], *, origin: Vector = (0, 0, 0), angles: Pair = (0.0, 360.0)
    ) -> Mesh:
        """Generate a tube around an axis along z with the sides inner, outer, bottom, top, and of a sector start and end.

        Parameters
        ----------
        radii : (2,) array_like
            Of bore and outside, m.
        length : float
            Along the axis, m.
        cells : (3,) sequence of int
            Around, across the wall, and along the axis.
        origin : (3,) array_like
            The middle of the bottom, m.
        angles : (2,) array_like
            Start and end, degrees.
        """
        return cls._generated(kind="tube", origin=origin, radii=radii, length=length, angles=angles, cells=cells)

    @classmethod
    def cylinder(
        cls, radius: float, length: float, cells: Sequence[int], *, origin: Vector = (0, 0, 0), angles: Pair = (0.0, 360.0)
    ) -> Mesh:
        """Generate a cylinder around an axis along z with the sides outer, bottom, top, and of a sector start and end.

        Parameters
        ----------
        radius, length : float
            m.
        cells : (3,) sequence of int
            Around, from the axis outwards, and along the axis.
        origin, angles
            See `tube`.
        """
        return cls._generated(kind="cylinder", origin=origin, radius=radius, length=length, angles=angles, cells=cells)

    @classmethod
    def ball(
        cls,
        radius: float,
        cells: int,
        *,
        centre: Vector = (0, 0, 0),
        part: str = "whole",
        facing: str = "down",
        growth: float = 2.0,
    ) -> Mesh:
        """Generate a ball, or a part of one, fine at its poles, with the side surface.

        Parameters
        ----------
        radius : float
            m.
        cells : int
            From the centre to the surface.
        centre : (3,) array_like
            m.
        part : {"whole", "half", "quarter", "eighth"}
            A part also has the sides flat (through the centre, across z), left (across x) and front (across y).
        facing : {"down", "up"}
            Direction of the pole of a part.
        growth : float
            How many times as long as those at the poles the longest cells are, 1 to 5.

        Examples
        --------
        >>> Mesh.ball(1.0, 3, part="eighth")
        <Mesh: 64 nodes, 162 tetrahedra, sides: flat, front, left, surface>
        """
        keys = {"centre": centre, "radius": radius, "part": part, "facing": facing, "growth": growth, "cells": cells}
        return cls._generated(kind="ball", **keys)

    @classmethod
    def _generated(cls, **generator: Any) -> Mesh:
        mesh = cls._of(_nndd.generate(generator))
        mesh._generator = generator
        return mesh

    @property
    def points(self) -> Floats:
        """Coordinates of the nodes, m: (n, 2), or (n, 3) if they were given so."""
        return self._points

    @property
    def triangles(self) -> Integers:
        """The nodes of each triangle: (m, 3); none in a mesh of tetrahedra."""
        return self._cells if self.tetrahedra is None else np.zeros((0, 3), dtype=np.int64)

    @property
    def tetrahedra(self) -> Optional[Integers]:
        """The nodes of each tetrahedron: (m, 4); `None` in a mesh of triangles."""
        return self._cells if self._cells.shape[1] == 4 else None

    @property
    def sides(self) -> dict[str, Integers]:
        """The edges of each side by their two nodes: (k, 2); of tetrahedra its faces: (k, 3)."""
        return dict(self._sides)

    @property
    def regions(self) -> dict[str, Integers]:
        """The numbers of the cells of each region: (k,)."""
        return dict(self._regions)

    @classmethod
    def _of(cls, arrays: Mapping[str, Any]) -> Mesh:
        """Take arrays of the library, which nobody else has: they are not copied."""
        for array in arrays.values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False
        return cls(**arrays)

    def __repr__(self) -> str:
        cells = "triangles" if self.tetrahedra is None else "tetrahedra"
        text = f"<Mesh: {len(self._points)} nodes, {len(self._cells)} {cells}"
        for what, names in (("sides", self._sides), ("regions", self._regions)):
            text += f", {what}: {', '.join(names)}" if names else ""
        return text + ">"


def _fixed(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array that cannot be written to: a copy, unless nobody can write to it."""
    made = array.copy() if array.flags.writeable else array
    made.flags.writeable = False
    return made
