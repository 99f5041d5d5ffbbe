"""Solutions, certificates, checks and sweeps."""

from __future__ import annotations

import html
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _nndd
from ._case import CaseLike, Progress, native, threads_of
from ._data import Floats, fixed, floats
from ._errors import CaseWarning, of_caller, of_python, refuse, refusing
from ._mesh import Mesh
from ._plot import Picture, draw, to_meshio
from ._pyvista import blocks_of, view
from ._results import BodyResult, ContactResult

Path = Union[str, os.PathLike[str]]


class Status(str):
    """How a run ended: a word such as ``converged``, ``target_missed`` or ``interrupted``.

    Attributes
    ----------
    code : int
        The exit status of the command: 0 if all went well.
    reason : str
        Why, in a few words.
    """

    code: int
    reason: str

    def __new__(cls, word: str, code: int, reason: str) -> Status:
        made = super().__new__(cls, word)
        made.code, made.reason = code, reason
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.code, self.reason)


def _table(rows: Sequence[Mapping[str, Any]]) -> npt.NDArray[Any]:
    """Make a structured array of rows; what is unknown is NaN, and a pair has two columns."""
    columns: dict[str, list[Any]] = {}
    for name in rows[0] if rows else []:
        values = [row.get(name) for row in rows]
        if any(isinstance(value, list) for value in values):
            for k in range(2):
                columns[f"{name}_{k + 1}"] = [None if value is None else value[k] for value in values]
        else:
            columns[name] = values
    arrays = {name: _column(values) for name, values in columns.items()}
    made = np.zeros(len(rows), dtype=[(name, array.dtype) for name, array in arrays.items()])
    for name, array in arrays.items():
        made[name] = array
    return fixed(made)


def _column(values: Sequence[Any]) -> npt.NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else value for value in values])
    if all(isinstance(value, int) for value in values):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


class Solution:
    """A solved problem, certified or not; however the run ended.

    Examples
    --------
    >>> import nndd
    >>> solution = nndd.solve("tests/cases/paper.toml")
    >>> solution
    <Solution: converged, certified error <= 18.84 % of the energy norm>
    >>> solution.bodies[0].displacement.shape, round(float(solution.contacts[0].pressure.max()), 1)
    ((190, 2), 16.8)
    """

    def __init__(self, solution: _nndd.Solution) -> None:
        self._native = solution
        self._report: dict[str, Any] = json.loads(solution.report())
        for warning in solution.warnings():
            warnings.warn(warning, CaseWarning, stacklevel=3)
        report = self._report
        bodies = enumerate(report["bodies"])
        self.bodies = tuple(BodyResult(solution, k, body["name"]) for k, body in bodies)
        self.contacts = tuple(ContactResult(solution, k, pair) for k, pair in enumerate(report["contact"]))

    @property
    def status(self) -> Status:
        """How the run ended."""
        status = self._report["status"]
        return Status(status["word"], status["code"], of_python(status["reason"]))

    @property
    def _certificate(self) -> dict[str, Any]:
        certificate = self._report["certificate"] or {}
        return certificate if certificate.get("valid") else {}

    @property
    def valid(self) -> bool:
        """Whether the error is certified: there is a bound, and its checks hold. Never with Coulomb friction."""
        return bool(self._certificate)

    @property
    def certified_error(self) -> Optional[float]:
        """The bound of the error in the energy norm, √(J/m), of solids √J; `None` unless `valid`."""
        return self._certificate.get("e_cre")

    @property
    def relative(self) -> Optional[float]:
        """The bound over the energy norm of the computed displacements; `None` unless `valid`, or without strain energy."""
        return self._certificate.get("relative")

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Lower and upper bounds of the exact energy_norm, potential_energy and contact_force; empty unless `valid`."""
        found = self._certificate.get("bounds", {})
        return {name: (pair[0], pair[1]) for name, pair in found.items() if pair is not None}

    @property
    def coulomb(self) -> Optional[dict[str, Any]]:
        """With Coulomb friction the residual ``e_b`` and what belongs to it; it bounds no error."""
        return self._report.get("coulomb")

    @cached_property
    def iterations(self) -> npt.NDArray[Any]:
        """A structured array with a row for each iteration on the last mesh; ``pandas.DataFrame`` reads it."""
        return _table(self._report["iterations"])

    @cached_property
    def adaptive(self) -> npt.NDArray[Any]:
        """A structured array with a row for each mesh of an adaptive run."""
        return _table(self._report["adaptive"])

    @property
    def steps(self) -> list[dict[str, Any]]:
        """The load steps, as report.json has them."""
        return list(self._report.get("steps", []))

    @property
    def notes(self) -> list[str]:
        """What is worth knowing about the case and its solution."""
        return list(self._report["notes"])

    def report(self) -> dict[str, Any]:
        """Return the contents of report.json."""
        report: dict[str, Any] = json.loads(self._native.report())
        return report

    @refusing
    def save(self, directory: Path, *, force: bool = False) -> list[str]:
        """Write what the command writes: report.json, report.html, tables, figures and ParaView files.

        Parameters
        ----------
        directory : path
            Where. It is made if it is not there; a result of the same case is replaced.
        force : bool
            Whether to write even if it contains something else.

        Returns
        -------
        list of str
            The files, below the directory.
        """
        return self._native.save(os.fspath(directory), force)

    @cached_property
    def figures(self) -> dict[str, Picture]:
        """The figures of report.html by their names, such as ``problem`` and ``von_mises``; a notebook shows them."""
        return {name: Picture(name, svg, caption) for name, svg, caption in self._native.figures()}

    @refusing
    def plot(self, *, scale: Optional[float] = None) -> Any:
        """Draw the deformed bodies by their von Mises stress; a notebook shows what is returned.

        In the plane the pressures are drawn beside them, with matplotlib. Solids turn in a window or a notebook by PyVista.
        Without PyVista or without a display they are drawn as on report.html, at the scale of that page.

        Parameters
        ----------
        scale : float, optional
            What displacements are multiplied by; by default the largest is drawn as a tenth of the bodies' size.

        Returns
        -------
        matplotlib.figure.Figure, Picture or viewer of PyVista
            What was drawn.
        """
        if self.bodies[0].mesh.tetrahedra is None:
            return draw(self.bodies, self.contacts, scale)
        shown = view(self.bodies, scale)
        return self.figures.get("von_mises", self.figures["problem"]) if shown is None else shown

    def to_meshio(self) -> Any:
        """Return one meshio.Mesh of all bodies, with all fields; ``body_id`` says which cell is whose."""
        return to_meshio(self.bodies)

    def to_pyvista(self) -> Any:
        """Return a pyvista.MultiBlock: a grid of each body, and of each contact its edges or faces, with all fields by name.

        Bodies have among others displacement, stress, von_mises and error_density, contacts contact_pressure and opening.
        """
        return blocks_of(self.bodies, self.contacts)

    def __repr__(self) -> str:
        if not self.valid:
            return f"<Solution: {self.status}, not certified>"
        if self.relative is None:
            return f"<Solution: {self.status}, certified error <= {self.certified_error:.3e}>"
        sentence = self._native.verdict().splitlines()[-1].split(" (")[0]
        return f"<Solution: {self.status}, {sentence}>"

    def _repr_html_(self) -> str:
        lines = [html.escape(line) for line in self._native.verdict().splitlines()]
        cells = "triangles" if "triangles" in self._report["bodies"][0] else "tetrahedra"
        rows = [("body", "nodes", cells, "")]
        rows += [(b["name"], b["nodes"], b[cells], "") for b in self._report["bodies"]]
        rows.append(("contact", "pairs", "largest pressure", "contact force"))
        for pair in self._report["contact"]:
            numbers = ["" if pair[key] is None else f"{pair[key]:.4g}" for key in ("max_pressure", "contact_force")]
            rows.append((pair["name"], pair["pairs"], numbers[0], numbers[1]))
        table = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
        return f"<p><b>{lines[0]}</b></p>" + "".join(f"<p>{line}</p>" for line in lines[1:]) + f"<table>{table}</table>"


@dataclass(frozen=True)
class Certificate:
    """The bound of the error of displacements that another code computed.

    The field is made admissible first: supported nodes that nearly have their displacements get them, and nodes that penetrate
    move back. The bound is that of the changed field, and the energy norm of the change is added. Norms of solids are in √J.
    """

    #: Whether the checks hold.
    valid: bool
    #: The bound in the energy norm, √(J/m); `None` unless `valid`.
    bound: Optional[float]
    #: The bound over the energy norm of the changed field; `None` unless `valid`.
    relative: Optional[float]
    #: Energy norm of the changed field, √(J/m).
    energy_norm: float
    #: What the bound would be without the change, √(J/m), whether it is valid or not.
    e_cre: float
    #: Energy norm of the change that made the field admissible, √(J/m).
    change: float
    #: The largest penetration that was removed, m.
    penetration: float
    #: The largest displacement of a supported node that was changed, m.
    support_change: float
    #: The part of `e_cre` that allows for round-off, √(J/m).
    round_off: float
    #: Loads that were left out, along motions that contact resists only by the error of the polygon: for each its `body`,
    #: `motion`, `load` and `share`.
    projected_load: list[dict[str, Any]]
    #: The checks that fail, with their residuals.
    failed_checks: dict[str, float]
    #: The supported node that misses its support by most: its body, point and distance in m, if that is too much to be mended.
    missed_support: Optional[dict[str, Any]]
    #: The mesh of each body; contact surfaces that do not match were refined in common.
    meshes: list[Mesh]
    #: Each cell's part of the squared error over its area or volume, Pa: (m,) by body.
    error_density: list[Floats]


@dataclass(frozen=True)
class Check:
    """What is known of a case before it is solved."""

    #: For each body its name, numbers of nodes and cells, sides with their numbers of edges or faces, supports, loads.
    bodies: list[dict[str, Any]]
    #: For each pair its name, bodies, surfaces, number of pairs of nodes and length, m, of solids area, m².
    contacts: list[dict[str, Any]]
    #: Estimate of the memory that solving it needs, bytes.
    memory: int
    #: What is worth knowing about how it was read.
    notes: list[str]
    #: What is allowed and probably not meant.
    warnings: list[str]


class Sweep:
    """Runs for several values of one setting."""

    def __init__(self, record: dict[str, Any]) -> None:
        self._record = record

    @property
    def key(self) -> str:
        """The setting."""
        return str(self._record["key"])

    @cached_property
    def panels(self) -> dict[str, npt.NDArray[Any]]:
        """For each panel by its name a structured array with a row for each value, as ``sweep.csv`` has it."""

        def flat(row: Mapping[str, Any]) -> dict[str, Any]:
            return {"value": row["value"], "status": row["status"], **row["iteration"]}

        return {panel["name"]: _table([flat(row) for row in panel["rows"]]) for panel in self._record["panels"]}

    def report(self) -> dict[str, Any]:
        """Return the contents of sweep.json."""
        return dict(self._record)

    def __repr__(self) -> str:
        return f"<Sweep of {self.key}: {', '.join(self.panels)}>"


def _told(on_iteration: Optional[Progress]) -> Optional[Progress]:
    if on_iteration is None:
        return None
    if not callable(on_iteration):
        refuse("on_iteration", f"a value of type {type(on_iteration).__name__}", "a function of one dict", "leave it out")
    return of_caller(on_iteration)


@refusing
def solve(
    case: CaseLike, *, on_iteration: Optional[Progress] = None, threads: Optional[int] = None, **overrides: Any
) -> Solution:
    """Solve a case and certify the answer.

    The lock on the interpreter is released. After Ctrl-C the run ends with what it has, and its status is ``interrupted``; before
    there is a result, and after a second Ctrl-C, `KeyboardInterrupt` is raised.

    Parameters
    ----------
    case : path, dict or Problem
        A case file, or a dict of the same keys. In a dict, ``mesh`` or ``mesh["file"]`` may be a `Mesh`, and data on sides in
        the plane may be arrays with a value at each node of the body's mesh, or functions of the arrays x and y, called once.
    on_iteration : callable, optional
        Is called with a dict after each iteration (``event = "iteration"``), mesh of an adaptive run (``"mesh"``) and load step
        (``"load_step"``). If it raises, the run ends and the exception passes through.
    threads : int, optional
        One per core by default. Results do not depend on it, bit for bit.
    **overrides
        Settings of the case file, with two underscores for a dot: ``solver__theta=0.4``, ``body__0__generator__cells=[36, 18]``.

    Returns
    -------
    Solution
        What was found, however the run ended: see its `status`.

    Raises
    ------
    Error
        There is no result; `InvalidInput`, `NotSolvable`, `FileError` and `LimitReached` say which kind of reason.

    Examples
    --------
    >>> solution = solve("tests/cases/paper.toml", solver__theta=0.5)
    >>> solution.status, len(solution.iterations)
    ('converged', 4)
    """
    made = native(case).solve(overrides, threads_of(threads), _told(on_iteration))
    return Solution(made)


@refusing
def check(case: CaseLike, *, threads: Optional[int] = None, **overrides: Any) -> Check:
    """Check everything of a case that needs no factorisation.

    Parameters
    ----------
    case : path, dict or Problem
        See `solve`.
    threads : int, optional
        One per core by default.
    **overrides
        See `solve`.

    Returns
    -------
    Check
        Its bodies, contacts, notes and warnings.

    Raises
    ------
    Error
        What is wrong.

    Examples
    --------
    >>> check("tests/cases/paper.toml").bodies[0]["nodes"]
    190
    """
    found = native(case).check(overrides, threads_of(threads))
    return Check(found["bodies"], found["contact"], found["memory_bytes"], found["notes"], found["warnings"])


@refusing
def sweep(
    case: CaseLike,
    over: str,
    *,
    iterations: int = 3,
    panels: Sequence[str] = (),
    out: Optional[Path] = None,
    force: bool = False,
    on_iteration: Optional[Progress] = None,
    threads: Optional[int] = None,
    **overrides: Any,
) -> Sweep:
    """Compare values of one setting, a few iterations each.

    Parameters
    ----------
    case : path, dict or Problem
        See `solve`.
    over : str
        The setting and its values, such as ``"solver.theta=0.1:0.9:0.1"`` or ``"solver.theta=[0.3, 0.5]"``.
    iterations : int
        Iterations of each run.
    panels : sequence of str
        Further panels with other settings, each ``"KEY=VALUE; KEY=VALUE"``.
    out : path, optional
        A directory for sweep.json, the tables and the figure; nothing is written by default.
    force : bool
        Whether to write even if it contains something else.
    on_iteration, threads, **overrides
        See `solve`; there is an event ``"value"`` after each run.

    Returns
    -------
    Sweep
        Its panels as structured arrays.

    Examples
    --------
    >>> found = sweep("tests/cases/paper.toml", "solver.theta=[0.4, 0.5]")
    >>> found.panels["380 nodes"]["value"].tolist()
    ['0.4', '0.5']
    """
    directory = None if out is None else os.fspath(out)
    text = native(case).sweep(
        over, overrides, iterations, list(panels), directory, force, threads_of(threads), _told(on_iteration)
    )
    return Sweep(json.loads(text))


@refusing
def certify(
    problem: CaseLike,
    displacements: Sequence[npt.ArrayLike],
    pressures: Optional[Sequence[npt.ArrayLike]] = None,
    *,
    threads: Optional[int] = None,
    **overrides: Any,
) -> Certificate:
    """Bound the error of displacements that another code computed.

    Parameters
    ----------
    problem : Problem, dict or path
        The problem that the field should solve. Friction is refused.
    displacements : sequence of (n, 2) array_like, of solids (n, 3)
        For each body the displacements of the nodes of its mesh, m, in the order of `Mesh.points`.
    pressures : sequence of (n,) array_like, optional
        For each contact the pressure at the nodes of the mesh of its first body, Pa; values away from the contact side do not
        count. By default they are the forces that the equilibrium of the field lacks.
    threads : int, optional
        One per core by default.
    **overrides
        See `solve`.

    Returns
    -------
    Certificate
        The bound, if it is valid.
    """
    if isinstance(displacements, np.ndarray) and displacements.ndim == 2:
        displacements = [displacements]
    fields = [floats(u, f"displacements[{k}]", (None, 2), (None, 3)) for k, u in enumerate(displacements)]
    given = None
    if pressures is not None:
        given = [floats(p, f"pressures[{k}]", (None,)) for k, p in enumerate(pressures)]
    numbers, bodies = native(problem).certify(overrides, fields, given, threads_of(threads))
    # JSON has no infinity.
    checks = {name: float("inf") if value is None else value for name, value in numbers.pop("failed_checks").items()}
    meshes = [Mesh._of(arrays) for arrays, _ in bodies]
    return Certificate(**numbers, failed_checks=checks, meshes=meshes, error_density=[fixed(density) for _, density in bodies])
