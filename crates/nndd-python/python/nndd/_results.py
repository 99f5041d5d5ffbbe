"""What a solution has for each body and each pair."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _nndd
from ._data import Floats, fixed
from ._errors import refuse
from ._mesh import Mesh


class BodyResult:
    """A body on the last mesh, with n nodes and m triangles or tetrahedra. Its fields have the units of the case.

    Attributes
    ----------
    name : str
        Its name.
    """

    def __init__(self, solution: _nndd.Solution, number: int, name: str) -> None:
        self._solution = solution
        self._number = number
        self._made: dict[str, Optional[npt.NDArray[Any]]] = {}
        self.name = name

    @cached_property
    def mesh(self) -> Mesh:
        """The last mesh; refined if the run was adaptive."""
        return Mesh._of(self._solution.mesh(self._number))

    def _field(self, name: str) -> Optional[npt.NDArray[Any]]:
        if name not in self._made:
            found = self._solution.field(self._number, name)
            self._made[name] = None if found is None else fixed(found)
        return self._made[name]

    def _known(self, name: str) -> npt.NDArray[Any]:
        found = self._field(name)
        if found is None:
            refuse(self.name, f"no {name}: the numbers are not finite", "a run with an estimate", "look at solution.status")
        return found

    def _all(self, names: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
        fields = {name: self._field(name) for name in names}
        return {name: field for name, field in fields.items() if field is not None}

    @property
    def point_data(self) -> dict[str, npt.NDArray[Any]]:
        """All fields at the nodes, as the ParaView files have them: vectors (n, 3), tensors (n, 6) as XX, YY, ZZ, XY, YZ, XZ."""
        return self._all(_nndd.POINT_FIELDS)

    @property
    def cell_data(self) -> dict[str, npt.NDArray[Any]]:
        """All fields in the cells, as the ParaView files have them."""
        return self._all(_nndd.CELL_FIELDS)

    @cached_property
    def _is_solid(self) -> bool:
        return self.mesh.tetrahedra is not None

    @property
    def _axes(self) -> int:
        return 3 if self._is_solid else 2

    @property
    def _components(self) -> list[int]:
        """The places of the components of a stress in VTK's order."""
        return [0, 1, 2, 4, 5, 3] if self._is_solid else [0, 1, 3]

    @property
    def displacement(self) -> Floats:
        """Displacements of the nodes, m: (n, 2), of solids (n, 3)."""
        return self._known("displacement")[:, : self._axes]

    @property
    def reaction(self) -> Floats:
        """Forces of supports and contact on the nodes, N/m: (n, 2), of solids N: (n, 3)."""
        return self._known("reaction")[:, : self._axes]

    @property
    def stress(self) -> Floats:
        """Stresses of the displacements in the cells, Pa: (m, 3) as xx, yy, xy, of solids (m, 6) as xx, yy, zz, yz, xz, xy."""
        return fixed(self._known("stress")[:, self._components])

    @property
    def stress_recovered(self) -> Optional[Floats]:
        """A continuous stress at the nodes, Pa: (n, 3) or (n, 6), with components as `stress`. It bounds nothing."""
        found = self._field("stress_recovered")
        return None if found is None else fixed(found[:, self._components])

    @property
    def von_mises(self) -> Optional[Floats]:
        """Von Mises stress in the cells, Pa: (m,); `None` if the stress out of the plane is unknown."""
        return self._field("von_mises")

    @property
    def von_mises_recovered(self) -> Optional[Floats]:
        """Von Mises stress of the recovered stress at the nodes, Pa: (n,); `None` if it is unknown."""
        return self._field("von_mises_recovered")

    @property
    def error_density(self) -> Floats:
        """Each cell's part of the squared bound over its measure, Pa: (m,). With Coulomb friction, of the squared residual."""
        return self._known("error_density")

    def __repr__(self) -> str:
        return f"<BodyResult {self.name}: {len(self.mesh.points)} nodes>"


class ContactResult:
    """A pair on the last mesh, with k pairs of nodes on its contact line or surface.

    Attributes
    ----------
    name : str
        Its name.
    summary : dict
        Its entry of report.json: ``contact_force``, ``max_pressure``, ``contact_intervals``, ``friction`` and more.
    """

    def __init__(self, solution: _nndd.Solution, number: int, summary: dict[str, Any]) -> None:
        self._solution = solution
        self._number = number
        self.name: str = summary["name"]
        self.summary = summary

    @cached_property
    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """The columns of contact.csv, (k,) each; with friction ``tangential``, ``slip``, ``limit`` and ``state`` among them."""
        return {name: fixed(np.asarray(values)) for name, values in self._solution.contact(self._number).items()}

    @cached_property
    def _grid(self) -> Optional[dict[str, Any]]:
        """Points, cells and fields of the edges or faces, as the ParaView file has them; `None` without an estimate."""
        return self._solution.contact_grid(self._number)

    @property
    def s(self) -> Floats:
        """Arc length, m: (k,); solids have none."""
        if "s" not in self.columns:
            refuse(self.name, "a contact surface has no arc length", "a contact line of the plane", "use points")
        return self.columns["s"]

    @property
    def points(self) -> Floats:
        """The nodes of the first body, m: (k, 2), of solids (k, 3)."""
        return fixed(np.column_stack([self.columns[axis] for axis in "xyz" if axis in self.columns]))

    @property
    def gap(self) -> Floats:
        """Initial gap, m: (k,)."""
        return self.columns["gap"]

    @property
    def opening(self) -> Floats:
        """Current opening, m, ≥ 0: (k,)."""
        return self.columns["opening"]

    @property
    def pressure(self) -> Floats:
        """Pressure, Pa, ≥ 0: (k,)."""
        return self.columns["pressure"]

    @property
    def active(self) -> npt.NDArray[np.bool_]:
        """Whether there is a force: (k,)."""
        return self.columns["active"]

    @property
    def resultant(self) -> Optional[Floats]:
        """The force of the contact on the first body, N/m: (2,), of solids N: (3,)."""
        found = self.summary["resultant"]
        return None if found is None else fixed(np.array(found))

    def __repr__(self) -> str:
        return f"<ContactResult {self.name}: {len(self.pressure)} pairs of nodes>"
