"""What a type checker should know of the package; mypy reads this file, and Python runs it."""

from __future__ import annotations

from typing import Any, Optional

import nndd
import numpy as np
import numpy.typing as npt
from conftest import blocks


def test_types_of_results() -> None:
    solution: nndd.Solution = blocks().solve(target=0.5, threads=1, solver__max_iterations=20)
    relative: Optional[float] = solution.relative
    reason: str = solution.status.reason
    body: nndd.BodyResult = solution.bodies[0]
    displacement: npt.NDArray[np.float64] = body.displacement
    stress: Optional[npt.NDArray[np.float64]] = body.von_mises
    bounds: dict[str, tuple[float, float]] = solution.bounds
    report: dict[str, Any] = solution.report()
    assert relative is not None
    assert stress is not None
    assert reason
    assert bounds
    assert report["schema"] == 1
    assert displacement.shape == (28, 2)


def test_types_of_arguments() -> None:
    mesh = nndd.Mesh(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), [[0, 1, 2]], {"bottom": [(0, 1)], "side": [[1, 2]]})
    body = nndd.Body(mesh, nndd.Material(1.0, 0.3)).fix("bottom").load("side", (0.0, lambda x, y: x))
    certificate: nndd.Certificate = nndd.certify(nndd.Problem([body]), [np.zeros((3, 2))])
    bound: Optional[float] = certificate.bound
    assert bound is None or bound > 0.0
    error = nndd.InvalidInput(3, [{"place": "a", "found": "b", "expected": None, "fix": None}])
    place: Optional[str] = error.place
    assert place == "a"
