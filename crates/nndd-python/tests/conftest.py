"""What the tests share: the folder of the example cases, the command, and a small problem."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
CASES = ROOT / "tests" / "cases"


@pytest.fixture(autouse=True)
def _at_the_top(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.fixture
def command() -> str:
    """The program nndd, which `cargo xtask python` names."""
    found = os.environ.get("NNDD_COMMAND") or shutil.which("nndd")
    if found is None:
        pytest.fail("no program nndd: set NNDD_COMMAND, as `cargo xtask python` does")
    return found


def blocks(cells: tuple[int, int] = (6, 3), **contact: Any) -> nndd.Problem:
    """Two blocks, the upper one pressed down by 0.01."""
    steel = nndd.Material(1000.0, 0.3)
    lower = nndd.Body(nndd.Mesh.block((0, 0), (2, 1), cells), steel, "lower").fix("bottom")
    upper = nndd.Body(nndd.Mesh.block((0, 1), (2, 1), cells), steel, "upper").displace("top", ux=0.0, uy=-0.01)
    return nndd.Problem([upper, lower], [nndd.Contact(upper, lower, ("bottom", "top"), **contact)])


def paper() -> nndd.Problem:
    """The paper's problem, as tests/cases/paper.toml has it."""
    stiff = nndd.Material(2000.0, 0.3, name="stiff")
    soft = nndd.Material(1000.0, 0.3, name="soft")
    upper = nndd.Body(nndd.Mesh.block((0, 1), (2, 1), (18, 9)), stiff, "upper")
    upper.displace("left", ux=0.0).displace("top", uy=-0.02).load("right", (0.0, 30.0))
    lower = nndd.Body(nndd.Mesh.block((0, 0), (2, 1), (18, 9)), soft, "lower").fix("bottom")
    return nndd.Problem([upper, lower], [nndd.Contact(upper, lower, ("bottom", "top"), gap=0.0)])


#: The settings of tests/cases/paper.toml.
PAPER: dict[str, Any] = {
    "solver.method": "nndd",
    "solver.imposed": "first",
    "solver.theta": 0.4,
    "solver.weights": "half",
    "solver.acceleration": "none",
    "solver.stop.ratio": 0.1,
    "estimator.relaxation": 2,
    "estimator.every": 1,
}


def arrays_of(mesh: nndd.Mesh) -> nndd.Mesh:
    """The same mesh of its arrays alone."""
    if mesh.tetrahedra is not None:
        return nndd.Mesh(mesh.points, sides=mesh.sides, tetrahedra=mesh.tetrahedra)
    return nndd.Mesh(mesh.points, mesh.triangles, mesh.sides)


def same(first: nndd.Solution, second: nndd.Solution) -> bool:
    """Whether the numbers of two solutions agree bit for bit."""
    pairs = zip(first.bodies, second.bodies)
    fields = all(np.array_equal(a.displacement, b.displacement) and np.array_equal(a.stress, b.stress) for a, b in pairs)
    return fields and first.report()["results"] == second.report()["results"] and first.relative == second.relative
