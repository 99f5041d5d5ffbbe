"""Meshes of Gmsh and meshio, and results for meshio, PyVista and matplotlib."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest
from conftest import CASES, blocks, same


@pytest.fixture
def gmsh() -> Iterator[Any]:
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


def punch(gmsh: Any, path: Path, order: int = 1) -> None:
    """A punch on a base, as one mesh file."""
    gmsh.clear()
    occ = gmsh.model.occ
    base = occ.addRectangle(-2, -1, 0, 4, 1)
    upper = occ.addRectangle(-0.5, 0, 0, 1, 0.5)
    occ.synchronize()
    for name, surface in (("base", base), ("punch", upper)):
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
        for _, curve in gmsh.model.getBoundary([(2, surface)], oriented=False):
            x0, y0, _, x1, _, _ = gmsh.model.getBoundingBox(1, curve)
            side = "left" if x1 < 0.1 and x1 - x0 < 0.1 else "right" if x1 - x0 < 0.1 else None
            side = side or ("top" if y0 > -0.1 and (name == "base" or y0 > 0.1) else "bottom")
            gmsh.model.addPhysicalGroup(1, [curve], name=f"{name} {side}")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
    gmsh.option.setNumber("Mesh.ElementOrder", order)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))


def pressed(mesh: nndd.Mesh) -> nndd.Problem:
    steel = nndd.Material(1000.0, 0.3)
    base = nndd.Body(mesh, steel, "base", region="base").fix("base bottom")
    upper = nndd.Body(mesh, steel, "punch", region="punch").displace("punch top", ux=0.0, uy=-0.01)
    return nndd.Problem([upper, base], [nndd.Contact(upper, base, ("punch bottom", "base top"))])


def test_two_percent_from_gmsh(gmsh: Any, tmp_path: Path) -> None:
    """A mesh made in this script, solved until 2 % are certified."""
    file = tmp_path / "punch.msh"
    punch(gmsh, file)
    solution = pressed(nndd.Mesh.read(file)).solve(target=0.02)
    assert solution.status == "converged"
    assert solution.relative is not None
    assert solution.relative <= 0.02
    assert len(solution.adaptive) > 1
    assert solution.contacts[0].pressure.min() >= 0.0


@pytest.mark.parametrize("order", [1, 2])
def test_gmsh_by_file_by_read_and_by_meshio(gmsh: Any, tmp_path: Path, order: int) -> None:
    import meshio

    file = tmp_path / "punch.msh"
    punch(gmsh, file, order)
    by_read = pressed(nndd.Mesh.read(file)).solve()
    by_meshio = pressed(nndd.Mesh.from_meshio(meshio.read(file))).solve()
    case = pressed(nndd.Mesh.read(file)).to_dict()
    for body in case["body"]:
        body["mesh"]["file"] = file
    by_file = nndd.solve(case)
    assert by_read.valid
    assert same(by_file, by_read)
    # Nodes may be numbered in another order.
    assert by_meshio.relative == pytest.approx(by_read.relative, rel=1e-9)
    assert sorted(by_meshio.bodies[0].mesh.sides) == sorted(by_read.bodies[0].mesh.sides)


def test_files_of_the_example_cases() -> None:
    for name in ("blocks.msh", "blocks_mixed.msh", "blocks.inp"):
        file = CASES / "meshes" / name
        if not file.exists():
            continue
        mesh = nndd.Mesh.read(file)
        assert mesh.regions
        assert mesh.sides
        assert mesh.triangles.max() == len(mesh.points) - 1
        assert all(cells.max() < len(mesh.triangles) for cells in mesh.regions.values())


def test_cells_of_meshio() -> None:
    import meshio

    points = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 2], [9, 9]], dtype=float)
    cells = [("quad", [[0, 1, 4, 3]]), ("triangle", [[1, 2, 5], [1, 5, 4]]), ("line", [[0, 1], [1, 2]]), ("vertex", [[6]])]
    sets = {"bottom": [[], [], [0, 1], []], "hard": [[], [0, 1], [], []], "all": [[0], [0, 1], [], []]}
    mesh = nndd.Mesh.from_meshio(meshio.Mesh(points, cells, cell_sets=sets))
    assert (len(mesh.points), len(mesh.triangles)) == (6, 4)
    assert mesh.sides["bottom"].tolist() == [[0, 1], [1, 2]]
    assert mesh.regions["hard"].tolist() == [2, 3]
    assert mesh.regions["all"].tolist() == [0, 1, 2, 3]
    with pytest.raises(nndd.InvalidInput, match="no triangles"):
        nndd.Mesh.from_meshio(meshio.Mesh(points, [("line", [[0, 1]])]))


def test_results_for_meshio(tmp_path: Path) -> None:
    import meshio

    solution = blocks().solve()
    merged = solution.to_meshio()
    assert len(merged.points) == sum(len(body.mesh.points) for body in solution.bodies)
    assert merged.cell_data["body_id"][0].sum() == len(solution.bodies[1].mesh.triangles)
    merged.write(tmp_path / "all.vtu")
    again = meshio.read(tmp_path / "all.vtu")
    both = np.concatenate([body.displacement for body in solution.bodies])
    assert np.array_equal(again.point_data["displacement"][:, :2], both)


@pytest.mark.filterwarnings("ignore")
def test_results_for_pyvista() -> None:
    solution = blocks().solve()
    grid = solution.to_pyvista()
    assert grid.n_cells == sum(len(body.mesh.triangles) for body in solution.bodies)
    first = solution.bodies[0]
    assert np.array_equal(grid.cell_data["error_density"][: len(first.mesh.triangles)], first.error_density)
    assert grid.area == pytest.approx(4.0)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_plot_shows_bodies_and_pressure() -> None:
    figure = blocks().solve().plot(scale=10.0)
    bodies, pressure, _colours = figure.axes
    assert [len(drawn.get_paths()) for drawn in bodies.collections] == [36, 36]
    assert bodies.get_title() == "displacements × 10"
    assert len(pressure.lines) == 1
    figure.canvas.draw()
    # A notebook shows it, without a backend for notebooks.
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    solution = blocks().solve()
    for package, ask in (("matplotlib", solution.plot), ("meshio", solution.to_meshio), ("pyvista", solution.to_pyvista)):
        for name in [name for name in sys.modules if name.split(".")[0] == package]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=f"pip install {package}"):
            ask()


def test_a_notebook_shows_the_summary() -> None:
    shown = blocks().solve()._repr_html_()
    assert "certified error &lt;=" in shown
    assert shown.count("<tr>") == 5
