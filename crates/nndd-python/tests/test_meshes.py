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


def test_a_file_of_exodus(tmp_path: Path) -> None:
    """Two hexahedra in two blocks with a side set, written as classic netCDF."""
    netcdf = pytest.importorskip("scipy.io").netcdf_file
    file = tmp_path / "bar.e"
    grid = [[x, y, z] for x in (0.0, 1.0, 2.0) for z in (0.0, 1.0) for y in (0.0, 1.0)]
    with netcdf(file, "w") as out:
        sizes = {"num_dim": 3, "num_nodes": 12, "num_elem": 2, "num_el_blk": 2, "num_side_sets": 1, "len_string": 33}
        sizes.update({f"num_el_in_blk{k}": 1 for k in (1, 2)}, num_side_ss1=1)
        sizes.update({f"num_nod_per_el{k}": 8 for k in (1, 2)})
        for name, size in sizes.items():
            out.createDimension(name, size)
        for axis, name in enumerate(("coordx", "coordy", "coordz")):
            out.createVariable(name, "d", ("num_nodes",))[:] = np.array(grid)[:, axis]
        for k in (1, 2):
            cell = out.createVariable(f"connect{k}", "i", (f"num_el_in_blk{k}", f"num_nod_per_el{k}"))
            cell[:] = 4 * (k - 1) + np.array([[1, 5, 6, 2, 3, 7, 8, 4]])
            cell.elem_type = "HEX8"
        for name, words in (("eb_names", ["steel", "rubber"]), ("ss_names", ["low"])):
            of = "num_el_blk" if name == "eb_names" else "num_side_sets"
            letters = [list(word.ljust(33, "\0")) for word in words]
            out.createVariable(name, "c", (of, "len_string"))[:] = np.array(letters, dtype="S1")
        out.createVariable("eb_prop1", "i", ("num_el_blk",))[:] = [1, 2]
        out.createVariable("ss_prop1", "i", ("num_side_sets",))[:] = 1
        # The last face of a hexahedron but one is its bottom.
        out.createVariable("elem_ss1", "i", ("num_side_ss1",))[:] = 1
        out.createVariable("side_ss1", "i", ("num_side_ss1",))[:] = 5
    mesh = nndd.Mesh.read(file)
    assert {name: len(cells) for name, cells in mesh.regions.items()} == {"steel": 6, "rubber": 6}
    assert mesh.points[mesh.sides["low"]][..., 2].max() == 0.0
    assert volume(mesh) == pytest.approx(2.0)


def volume(mesh: nndd.Mesh) -> float:
    corners = mesh.points[mesh._cells]
    return float(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6)


def shapes() -> Any:
    """A cube of eight hexahedra, one of them two prisms and one six pyramids, with the numbers of their nodes shuffled."""
    import meshio

    grid = np.array([[x, y, z] for z in range(3) for y in range(3) for x in range(3)], dtype=float)
    corner = np.array([0, 1, 4, 3, 9, 10, 13, 12])
    cubes = [corner + x + 3 * y + 9 * z for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    last, centre = cubes[7], len(grid)
    faces = [[0, 1, 2, 3], [7, 6, 5, 4], [4, 5, 1, 0], [5, 6, 2, 1], [6, 7, 3, 2], [7, 4, 0, 3]]
    pyramids = [[*last[face], centre] for face in faces]
    points = np.vstack([grid, grid[last].mean(axis=0)])
    order = np.random.default_rng(3).permutation(len(points))
    place = np.argsort(order)
    # The cube below is cut through the smallest node of its top: so are the prisms.
    turn = int(place[cubes[6][:4]].argmin())
    split = cubes[6].reshape(2, 4)[:, np.roll(range(4), -turn)]
    prisms = [split[:, triangle].ravel() for triangle in ([0, 1, 2], [0, 2, 3])]
    bottom = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    kinds = (("hexahedron", cubes[:6]), ("wedge", prisms), ("pyramid", pyramids), ("quad", bottom))
    blocks = [(kind, place[np.array(cells)]) for kind, cells in kinds]
    sets = {"bottom": [[], [], [], [0, 1, 2, 3]], "odd": [[], [0, 1], range(6), []], "cubes": [range(6), [], [], []]}
    return meshio.Mesh(points[order], blocks, cell_sets=sets)


def test_volumes_of_meshio_are_split_as_those_of_files(tmp_path: Path) -> None:
    given = shapes()
    mesh = nndd.Mesh.from_meshio(given)
    assert volume(mesh) == pytest.approx(8.0)
    assert len(mesh.sides["bottom"]) == 8
    # Files of VTK have numbers of parts in place of names.
    given.cell_sets = {}
    given.cell_data["part"] = [np.full(len(block.data), k) for k, block in enumerate(given.cells)]
    given.write(tmp_path / "shapes.vtu")
    read = nndd.Mesh.read(tmp_path / "shapes.vtu")
    assert read.sides.keys() == {"part_3"}

    def sets(cells: Any) -> list[list[int]]:
        return sorted(np.sort(cells, axis=1).tolist())

    assert np.array_equal(mesh.points, read.points)
    assert sets(mesh._cells) == sets(read._cells)
    assert sets(mesh.sides["bottom"]) == sets(read.sides["part_3"])
    assert volume(nndd.Mesh(mesh.points, tetrahedra=mesh._cells[mesh.regions["odd"]])) == pytest.approx(2.0)
    # Cells that do not fit to each other would not pass on a uniform stress.
    body = nndd.Body(mesh, nndd.Material(1000.0, 0.3), region=["cubes", "odd"]).displace("bottom", uz=0.0)
    body.side("left", facing=(-1, 0, 0)).displace("left", ux=0.0).side("front", facing=(0, -1, 0)).displace("front", uy=0.0)
    body.side("top", facing=(0, 0, 1))
    [solved] = nndd.Problem([body.load("top", (0, 0, 5.0))]).solve().bodies
    assert solved.stress == pytest.approx(np.tile([0, 0, 5, 0, 0, 0], (len(mesh._cells), 1)), abs=1e-9)


@pytest.mark.parametrize("mesh", [nndd.Mesh.block((0, 0), (2, 1), (4, 2)), nndd.Mesh.ball(1.0, 3, part="quarter")])
def test_a_mesh_goes_to_meshio_and_back(mesh: nndd.Mesh) -> None:
    regions = {"all": np.arange(len(mesh._cells)), "some": np.array([0, 3])}
    kind = "triangles" if mesh.tetrahedra is None else "tetrahedra"
    given = nndd.Mesh(mesh.points, sides=mesh.sides, regions=regions, **{kind: mesh._cells})
    again = nndd.Mesh.from_meshio(given.to_meshio())
    assert np.array_equal(again.points[:, : mesh.points.shape[1]], mesh.points)
    assert np.array_equal(again._cells, mesh._cells)
    for these, those in ((again.sides, given.sides), (again.regions, given.regions)):
        assert these.keys() == those.keys()
        assert all(np.array_equal(these[name], those[name]) for name in those)


def test_grids_of_pyvista(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()
    grid.cell_data["part"] = np.arange(8) // 4
    mesh = nndd.Mesh.from_pyvista(grid)
    assert volume(mesh) == pytest.approx(8.0)
    assert sorted(mesh.regions) == ["part_0", "part_1"]
    plane = nndd.Mesh.from_pyvista(pyvista.Plane(i_resolution=2, j_resolution=3))
    assert (len(plane.points), len(plane.triangles)) == (12, 12)
    # Two results become two regions, by the number of the body.
    solved = nndd.Mesh.from_pyvista(blocks().solve().to_pyvista()[:2])
    assert {name for name in solved.regions if name.startswith("body_id")} == {"body_id_0", "body_id_1"}
    with pytest.raises(nndd.InvalidInput, match=r"an object of type list"):
        nndd.Mesh.from_pyvista([grid])
    with pytest.raises(nndd.InvalidInput, match="VTK type"):
        nndd.Mesh.from_pyvista(pyvista.UnstructuredGrid([1, 0], [pyvista.CellType.POLY_VERTEX], [[0.0, 0.0, 0.0]]))


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


def test_results_for_pyvista() -> None:
    pytest.importorskip("pyvista")
    solution = blocks().solve()
    found = solution.to_pyvista()
    assert found.keys() == ["upper", "lower", "upper-lower"]
    for body in solution.bodies:
        grid = found[body.name]
        assert np.array_equal(grid.cell_data["error_density"], body.error_density)
        assert np.array_equal(grid.point_data["displacement"][:, :2], body.displacement)
        assert grid.area == pytest.approx(2.0)
    line = found["upper-lower"]
    assert np.array_equal(line.point_data["contact_pressure"], solution.contacts[0].pressure)
    assert line.length == pytest.approx(2.0)


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
    for package, ask in (
        ("matplotlib", solution.plot),
        ("meshio", solution.to_meshio),
        ("meshio", solution.bodies[0].mesh.to_meshio),
        ("pyvista", solution.to_pyvista),
        ("pyvista", lambda: nndd.Mesh.from_pyvista(None)),
    ):
        for name in [name for name in sys.modules if name.split(".")[0] == package]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=f"pip install {package}"):
            ask()


def test_figures_are_those_of_the_page(tmp_path: Path) -> None:
    solution = blocks().solve()
    files = [Path(file) for file in solution.save(tmp_path) if file.startswith("figures")]
    assert sorted(solution.figures) == sorted(file.stem for file in files)
    for file in files:
        assert solution.figures[file.stem]._repr_svg_() == (tmp_path / file).read_text(encoding="utf-8")
    solution.figures["contact"].save(tmp_path / "own.svg")
    assert (tmp_path / "own.svg").read_bytes() == (tmp_path / "figures" / "contact.svg").read_bytes()


def test_a_notebook_shows_the_summary() -> None:
    shown = blocks().solve()._repr_html_()
    assert "certified error &lt;=" in shown
    assert shown.count("<tr>") == 5
