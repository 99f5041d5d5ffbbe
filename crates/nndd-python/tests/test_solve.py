"""The same numbers as the command, from a file, a dict and objects."""

from __future__ import annotations

import filecmp
import json
import subprocess
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest
from conftest import CASES, PAPER, arrays_of, blocks, paper, same


def numbers(report: dict[str, Any]) -> dict[str, Any]:
    """A report without its times and what it ran on."""
    return {key: value for key, value in report.items() if key not in ("timings", "run")}


def written_by_command(command: str, case: str, out: Path, *options: str) -> dict[str, Any]:
    subprocess.run([command, "solve", str(CASES / case), "--out", str(out), "--quiet", *options], check=False)
    report: dict[str, Any] = json.loads((out / "report.json").read_text())
    return report


# A given mesh, an adaptive run, load steps, and Coulomb friction: each writes other files.
@pytest.mark.parametrize(
    "case", ["paper.toml", "adaptive.toml", "shear.toml", "coulomb.toml", "gmsh.toml", "roller.toml", "solid/stack.toml"]
)
def test_a_case_is_that_of_the_command_bit_for_bit(case: str, command: str, tmp_path: Path) -> None:
    out = tmp_path / "command"
    report = written_by_command(command, case, out)
    solution = nndd.solve(CASES / case)
    assert numbers(solution.report()) == numbers(report)
    assert (solution.status, solution.status.code) == (report["status"]["word"], report["status"]["code"])
    files = solution.save(tmp_path / "python")
    assert sorted(files) == sorted(str(p.relative_to(out)) for p in out.rglob("*") if p.is_file())
    others = [name for name in files if name != "report.json"]
    match, mismatch, errors = filecmp.cmpfiles(out, tmp_path / "python", others, shallow=False)
    assert (sorted(match), mismatch, errors) == (sorted(others), [], [])
    # A second time it replaces the result.
    assert solution.save(tmp_path / "python") == files


def test_the_arrays_are_those_of_the_files(command: str, tmp_path: Path) -> None:
    import meshio

    written_by_command(command, "paper.toml", tmp_path)
    solution = nndd.solve(CASES / "paper.toml")
    for body in solution.bodies:
        file = meshio.read(tmp_path / f"{body.name}.vtu")
        assert np.array_equal(file.points[:, :2], body.mesh.points)
        assert np.array_equal(file.point_data["displacement"][:, :2], body.displacement)
        assert np.array_equal(file.cell_data["stress"][0][:, [0, 1, 3]], body.stress)
        assert np.array_equal(file.cell_data["error_density"][0], body.error_density)
        von_mises = body.von_mises
        assert von_mises is not None
        assert np.array_equal(file.cell_data["von_mises"][0], von_mises)
    table = np.genfromtxt(tmp_path / "contact.csv", delimiter=",", names=True)
    [pair] = solution.contacts
    assert np.array_equal(table["pressure"], pair.pressure)
    assert np.array_equal(table["opening"], pair.opening)


def test_objects_dicts_and_arrays_have_the_numbers_of_the_file() -> None:
    by_file = nndd.solve(CASES / "paper.toml")
    problem = paper()
    by_objects = problem.solve(**PAPER)
    assert same(by_file, by_objects)
    assert same(by_file, nndd.solve(problem.to_dict(), **PAPER))
    for body in problem.bodies:
        body.mesh = arrays_of(body.mesh)
    assert same(by_file, problem.solve(**PAPER))


def test_overrides_are_those_of_the_command(command: str, tmp_path: Path) -> None:
    options = ["--set", "solver.theta=0.6", "--set", "body.0.generator.cells=[12, 6]", "--set", "body.1.generator.cells=[12, 6]"]
    report = written_by_command(command, "paper.toml", tmp_path, *options)
    overrides: dict[str, Any] = {
        "solver__theta": 0.6,
        "body__0__generator__cells": (12, 6),
        "body__1__generator__cells": np.array([12, 6]),
    }
    assert numbers(nndd.solve(str(CASES / "paper.toml"), **overrides).report()) == numbers(report)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_the_number_of_threads_changes_no_bit(threads: int) -> None:
    assert same(blocks((24, 12)).solve(0.05, threads=threads), blocks((24, 12)).solve(0.05))


def test_an_uncertified_result_has_no_bound() -> None:
    coulomb = nndd.solve(CASES / "coulomb.toml")
    assert coulomb.status == "converged" or coulomb.status == "residual_reached"
    assert (coulomb.valid, coulomb.relative, coulomb.certified_error, coulomb.bounds) == (False, None, None, {})
    assert coulomb.coulomb is not None
    assert coulomb.coulomb["e_b"] > 0.0
    assert "not certified" in repr(coulomb)
    # A point that carries a force: there is an estimate, but no bound.
    points = nndd.Body(nndd.Mesh.block((0, 0), (1, 1), (4, 4)), nndd.Material(1000.0, 0.3), "plate")
    points.side("a", point=(0, 0)).side("b", point=(1, 0)).fix("a").displace("b", uy=0.0).load("top", (0, -1))
    loose = nndd.Problem([points]).solve()
    assert (loose.status, loose.status.code, loose.valid, loose.relative) == ("not_certified", 6, False, None)


def test_tables_are_structured_arrays() -> None:
    import pandas

    solution = nndd.solve(CASES / "adaptive.toml")
    assert solution.adaptive["nodes"][0] == 380
    assert list(solution.adaptive["relative"]) == sorted(solution.adaptive["relative"], reverse=True)
    frame = pandas.DataFrame(solution.adaptive)
    assert (len(frame), frame["step"].tolist()) == (len(solution.adaptive), list(range(1, len(frame) + 1)))
    rows = solution.report()["iterations"]
    assert pandas.DataFrame(solution.iterations)["eta_nndd"].tolist() == [row["eta_nndd"] for row in rows]
    assert solution.iterations["contact_forces_2"].tolist() == [row["contact_forces"][1] for row in rows]
    assert np.isnan(solution.iterations["e_cre"]).any()


def test_a_sweep_is_that_of_the_command(command: str, tmp_path: Path) -> None:
    over = "solver.theta=0.3:0.5:0.1"
    panel = "body.0.generator.cells=[12,6]; body.1.generator.cells=[12,6]"
    args = [command, "sweep", str(CASES / "paper.toml"), "--over", over, "--panel", panel, "--out", str(tmp_path), "--quiet"]
    subprocess.run(args, check=True)
    record = json.loads((tmp_path / "sweep.json").read_text())
    found = nndd.sweep(CASES / "paper.toml", over, panels=[panel])
    assert found.report()["panels"] == record["panels"]
    assert list(found.panels) == ["380 nodes", "182 nodes"]
    assert found.panels["380 nodes"]["value"].tolist() == ["0.3", "0.4", "0.5"]
    # Of objects the numbers are the same, and a directory gets the files.
    out = tmp_path / "objects"
    again = paper().sweep(over, out=out, **PAPER)
    assert np.array_equal(again.panels["380 nodes"]["eta_nndd"], found.panels["380 nodes"]["eta_nndd"])
    assert (out / "sweep.csv").is_file()


def test_a_check_says_what_the_command_says(command: str) -> None:
    args = [command, "check", str(CASES / "assembly.toml"), "--format", "json"]
    said = json.loads(subprocess.run(args, check=True, capture_output=True, text=True).stdout)
    found = nndd.check(CASES / "assembly.toml")
    assert (found.bodies, found.contacts) == (said["bodies"], said["contact"])
    assert (found.memory, found.notes, found.warnings) == (said["memory_bytes"], said["notes"], said["warnings"])


def test_a_warning_of_a_case_is_a_warning() -> None:
    thin = nndd.Mesh(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1e-4], [0.0, 1e-4]], [[0, 1, 2], [0, 2, 3]], {"bottom": [[0, 1]], "top": [[2, 3]]}
    )
    body = nndd.Body(thin, nndd.Material(1.0, 0.3)).fix("bottom").load("top", (0, -1e-6))
    with pytest.warns(nndd.CaseWarning, match=r"angle below 0\.1 degrees"):
        nndd.Problem([body]).solve()


def test_bounds_enclose_those_of_a_finer_mesh() -> None:
    coarse, fine = blocks((6, 3)).solve(), blocks((48, 24)).solve()
    assert coarse.bounds.keys() >= {"energy_norm", "potential_energy"}
    for name, (low, high) in coarse.bounds.items():
        assert low <= fine.bounds[name][0] <= fine.bounds[name][1] <= high, name


def test_solids_have_three_components() -> None:
    solution = nndd.solve(CASES / "solid" / "stack.toml")
    body, pair = solution.bodies[1], solution.contacts[0]
    mesh = body.mesh
    assert mesh.tetrahedra is not None
    assert mesh.tetrahedra.shape == (96, 4)
    assert mesh.points.shape == (45, 3)
    assert body.displacement.shape == (45, 3)
    assert body.stress.shape == (96, 6)
    assert body.stress_recovered is not None
    assert body.stress_recovered.shape == (45, 6)
    assert pair.points.shape == (15, 3)
    assert pair.resultant is not None
    assert pair.resultant.shape == (3,)
    assert pair.summary["area"]["certain"] <= pair.summary["area"]["possible"] <= pair.summary["area"]["total"]
    with pytest.raises(nndd.InvalidInput, match="no arc length"):
        _ = pair.s
    # The tensor is in equilibrium with the cells of the mesh: xx, yy, zz, yz, xz, xy.
    assert np.allclose(body.stress[:, 2], body.cell_data["stress"][:, 2])
    assert np.array_equal(body.stress[:, 3], body.cell_data["stress"][:, 4])


def test_boxes_are_generated_for_solids() -> None:
    mesh = nndd.Mesh.box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0), (2, 1, 1))
    assert mesh.tetrahedra is not None
    assert len(mesh.tetrahedra) == 12
    assert mesh.points.shape == (12, 3)
    assert {name: faces.shape for name, faces in mesh.sides.items()}["bottom"] == (4, 3)
    with pytest.raises(nndd.InvalidInput):
        nndd.Mesh.box((0.0, 0.0, 0.0), (2.0, 1.0, -1.0), (2, 1, 1))
