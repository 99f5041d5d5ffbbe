"""Solids by objects: the same problems as the case files, materials, meshes, results, and wrong input."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest
from conftest import CASES, blocks, same

STEEL = nndd.Material(1000.0, 0.3)


def cube(cells: int = 2) -> nndd.Body:
    """A cube on two planes of symmetry."""
    mesh = nndd.Mesh.box((0, 0, 0), (1, 1, 1), (cells, cells, cells))
    return nndd.Body(mesh, STEEL, "cube").displace("left", ux=0).displace("front", uy=0)


def on_sphere(centre: Any = (0, 0, -2), radius: Any = 2, **obstacle: Any) -> nndd.Problem:
    body = cube().load("top", (0, 0, -20))
    return nndd.Problem([body], [nndd.Contact(body, nndd.Obstacle.sphere(centre, radius, **obstacle), "bottom")])


def rollers() -> nndd.Problem:
    plate = nndd.Body(nndd.Mesh.box((-1, -1, 0), (2, 2, 0.5), (8, 8, 2)), STEEL, "plate")
    plate.displace("left", ux=0).displace("front", uy=0)
    below = nndd.Obstacle.cylinder((0, 0, -4), (0, 1, 0), 4)
    above = nndd.Obstacle.cylinder((0, 0, 3.5), (1, 0, 0), 3, force=(0, 0, -10), ux=0, uy=0, rotation=(0, 0, 0))
    contacts = [nndd.Contact(plate, below, "bottom", name="below"), nndd.Contact(plate, above, "top", name="above")]
    return nndd.Problem([plate], contacts)


def stack() -> nndd.Problem:
    def block(name: str, z: int, young: float) -> nndd.Body:
        return nndd.Body(nndd.Mesh.box((0, 0, z), (2, 1, 1), (4, 2, 2)), nndd.Material(young, 0.3, name=name), name)

    bottom, middle, top = block("bottom", 0, 1000.0).fix("bottom"), block("middle", 1, 1500.0), block("top", 2, 2000.0)
    middle.load("back", (0, 0, 10))
    top.displace("top", uz=-0.02).displace("left", ux=0).displace("front", uy=0).load("right", (0, 0, 30))
    pairs = [nndd.Contact(middle, bottom, ("bottom", "top")), nndd.Contact(top, middle, ("bottom", "top"))]
    return nndd.Problem([bottom, middle, top], pairs)


def corner() -> nndd.Problem:
    body = nndd.Body(nndd.Mesh.box((0, 0, 0), (1, 1, 1), (2, 2, 2)), STEEL, "cube")
    body.load("right", ("-10*(z+0.2)", 0, 0)).load("back", (0, "-10*(x+0.2)", 0)).load("top", (0, 0, "-20*(2*x+y-0.5)"))
    sides = [("left", (1, 0, 0)), ("front", (0, 1, 0)), ("bottom", (0, 0, 1))]
    return nndd.Problem([body], [nndd.Contact(body, nndd.Obstacle.plane((0, 0, 0), normal), side) for side, normal in sides])


@pytest.mark.parametrize(("case", "problem"), [("sphere", on_sphere), ("rollers", rollers), ("stack", stack), ("corner", corner)])
def test_objects_are_the_case_files(case: str, problem: Callable[[], nndd.Problem]) -> None:
    found, expected = problem().solve(), nndd.solve(CASES / "solid" / f"{case}.toml")
    assert found.valid
    assert same(found, expected)
    assert [pair.name for pair in found.contacts] == [pair.name for pair in expected.contacts]
    assert problem().check().contacts == nndd.check(CASES / "solid" / f"{case}.toml").contacts


def test_meshes_of_arrays_are_those_of_the_generator() -> None:
    problem = stack()
    expected = problem.solve()
    for body in problem.bodies:
        mesh = body.mesh
        assert mesh.tetrahedra is not None
        every = np.arange(len(mesh.tetrahedra))
        body.mesh = nndd.Mesh(mesh.points, sides=mesh.sides, regions={"all": every}, tetrahedra=mesh.tetrahedra)
        assert "96 tetrahedra, sides: back, bottom, front, left, right, top, regions: all" in repr(body.mesh)
    assert same(problem.solve(), expected)
    assert np.array_equal(problem.mesh(1).points, expected.bodies[1].mesh.points)
    upper = problem.bodies[2]
    assert len(nndd.Problem([nndd.Body(upper.mesh, STEEL, region="all").fix("top")]).mesh(0).points) == 45


def test_gmsh_by_file_by_read_and_by_meshio(tmp_path: Path) -> None:
    import gmsh
    import meshio

    file = tmp_path / "box.msh"
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    box = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [box], name="box")
    for _, face in gmsh.model.getBoundary([(3, box)], oriented=False):
        *_, low, _, _, high = gmsh.model.getBoundingBox(2, face)
        if high - low < 0.1:
            gmsh.model.addPhysicalGroup(2, [face], name="top" if low > 0.5 else "bottom")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(file))
    gmsh.finalize()

    def pulled(mesh: nndd.Mesh) -> nndd.Problem:
        return nndd.Problem([nndd.Body(mesh, STEEL, "box", region="box").fix("bottom").load("top", (0, 0, 1))])

    mesh = nndd.Mesh.read(file)
    assert list(mesh.sides) == ["bottom", "top"]
    by_read = pulled(mesh).solve()
    by_meshio = pulled(nndd.Mesh.from_meshio(meshio.read(file))).solve()
    case = pulled(mesh).to_dict()
    case["body"][0]["mesh"]["file"] = file
    assert by_read.valid
    assert same(nndd.solve(case), by_read)
    assert by_meshio.relative == pytest.approx(by_read.relative, rel=1e-9)
    swept = nndd.sweep(case, "estimator.relaxation=[0, 1]", iterations=1)
    assert swept.panels.keys()


def test_materials_of_solids() -> None:
    def solved(material: nndd.Material) -> nndd.Solution:
        body = nndd.Body(nndd.Mesh.box((0, 0, 0), (1, 1, 1), (2, 2, 2)), material, body_force=(1, 2, 3)).fix("bottom")
        return nndd.Problem([body]).solve()

    shear = 1000.0 / 2.6
    nine: dict[str, Any] = {"poisson_13": 0.3, "poisson_23": 0.3, "shear_12": shear, "shear_13": shear, "shear_23": shear}
    lame = 1000.0 * 0.3 / (1.3 * 0.4)
    stiffness = np.diag([2 * shear] * 3 + [shear] * 3)
    stiffness[:3, :3] += lame
    expected = solved(STEEL)
    for material in (
        nndd.Material.orthotropic(1000.0, 1000.0, 0.3, young_3=1000.0, axes=[(0, 1, 1), (1, 0, 0)], **nine),
        nndd.Material.of_stiffness(stiffness),
    ):
        found = solved(material)
        assert found.valid
        assert found.bodies[0].displacement == pytest.approx(expected.bodies[0].displacement, abs=1e-12)


def test_rigid_sides_parts_and_sides_by_their_place() -> None:
    mesh = nndd.Mesh.box((0, 0, 0), (1, 1, 1), (2, 2, 2))
    body = nndd.Body(mesh, STEEL, "cube").side("low", facing=(0, 0, -1), within=1, box={"z": (0, 0)})
    body.side("far", sphere=((1, 1, 1), 3**0.5)).side("node", point=(0, 0, 0)).fix("low", part={"x": (0, 0.5), "z": (0, 0)})
    body.rigid("top", uz=-0.01, rotation=(0, 0, 0), force=(1, 2, 0), about=(0, 0, 1))
    with pytest.raises(nndd.InvalidInput, match='no boundary face belongs to the side "far"'):
        nndd.Problem([body]).check()
    del body._lists["side"][1]
    solution = nndd.Problem([body]).solve()
    [side] = solution.report()["bodies"][0]["rigid_sides"]
    assert side["force"][:2] == pytest.approx([1, 2])
    assert solution.valid
    twisted = nndd.Body(mesh, STEEL, "cube").fix("bottom").rigid("top", moment=(0, 0, 1))
    [side] = nndd.Problem([twisted]).solve().report()["bodies"][0]["rigid_sides"]
    assert side["moment"] == pytest.approx([0, 0, 1])


def test_obstacles_may_move() -> None:
    fixed = on_sphere()
    moved = on_sphere((0, 0, -2.01), uz=0.01, ux=0, uy=0, rotation=(0, 0, 0))
    by_motion = on_sphere((0, 0, -2.01))
    by_motion.contacts[0]._keys["motion"] = (0, 0, 0.01)
    for problem in (moved, by_motion):
        problem.contacts[0]._keys["gap"] = "geometric"
        found = problem.solve()
        assert found.valid
        resultant = found.contacts[0].resultant
        assert resultant is not None
        assert resultant[2] == pytest.approx(20.0)
    assert fixed.solve().contacts[0].pressure.max() > 0.0


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_every_result_of_a_solid(tmp_path: Path) -> None:
    solution = rollers().solve()
    body, pair = solution.bodies[0], solution.contacts[1]
    nodes, cells = len(body.mesh.points), len(body.mesh._cells)
    assert body.mesh.triangles.shape == (0, 3)
    assert body.reaction.shape == (nodes, 3)
    for field, length in ((body.von_mises, cells), (body.von_mises_recovered, nodes), (body.error_density, cells)):
        assert field is not None
        assert field.shape == (length,)
    assert body.point_data["displacement"].shape == (nodes, 3)
    assert body.cell_data["stress"].shape == (cells, 6)
    assert pair.points.shape == (len(pair.pressure), 3)
    assert pair.active.any()
    assert (pair.gap >= 0.0).all()
    assert (pair.opening >= 0.0).all()
    assert pair.resultant == pytest.approx([0, 0, -10])
    assert solution.bounds.keys() >= {"energy_norm", "potential_energy"}
    assert len(solution.iterations) == 1
    assert len(solution.adaptive) == 0
    assert solution.steps == []
    assert solution.coulomb is None
    assert any("finer faces" in note for note in solution.notes)
    assert "certified error" in repr(solution)
    assert f"<td>tetrahedra</td><td></td></tr><tr><td>plate</td><td>{nodes}</td><td>{cells}</td>" in solution._repr_html_()
    assert "plate.vtu" in solution.save(tmp_path)
    assert len(solution.to_meshio().cells_dict["tetra"]) == cells


def test_solids_for_pyvista() -> None:
    pytest.importorskip("pyvista")
    solution = rollers().solve()
    found = solution.to_pyvista()
    assert found.keys() == ["plate", "below", "above"]
    assert found["plate"].volume == pytest.approx(2.0)
    assert np.array_equal(found["plate"].cell_data["von_mises"], solution.bodies[0].cell_data["von_mises"])
    for pair in solution.contacts:
        faces = found[pair.name]
        assert faces.area == pytest.approx(4.0)
        assert np.array_equal(faces.points[: len(pair.points)], pair.points.astype(faces.points.dtype))
        assert np.array_equal(faces.point_data["contact_pressure"][: len(pair.points)], pair.pressure)
        # The pressure is linear on each face, so the means of the faces have the force.
        sizes = faces.compute_cell_sizes()["Area"]
        assert pair.summary["contact_force"] == pytest.approx(sizes @ faces.cell_data["contact_pressure_mean"], rel=0.02)


def test_the_plot_of_a_solid_is_a_view_or_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    pyvista = pytest.importorskip("pyvista")
    solution = rollers().solve()
    monkeypatch.setattr(pyvista, "OFF_SCREEN", True)
    shown = solution.plot(scale=3.0)
    assert isinstance(shown, pyvista.Plotter)
    [drawn] = [mesh for mesh in shown.meshes if "von_mises" in mesh.array_names]
    body = solution.bodies[0]
    shown.close()
    assert np.asarray(drawn.points) == pytest.approx(body.mesh.points + 3.0 * body.displacement, abs=1e-6)
    monkeypatch.setattr(pyvista, "OFF_SCREEN", False)
    monkeypatch.setattr(pyvista, "system_supports_plotting", lambda: False)
    assert solution.plot() is solution.figures["von_mises"]
    for name in [name for name in sys.modules if name.split(".")[0] == "pyvista"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    assert solution.plot() is solution.figures["von_mises"]
    assert solution.figures.keys() >= {"problem", "displacement", "von_mises", "contact-below", "contact-above", "deformed"}


def test_a_notebook_shows_every_plot() -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    cells = [
        "import nndd",
        "solid = nndd.solve('tests/cases/solid/ball.toml')\nsolid.figures['contact']",
        "import sys\nsys.modules['pyvista'] = None\nsolid.plot()",
        "nndd.solve('tests/cases/paper.toml').plot()",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    shown = [{kind for output in cell.outputs for kind in output.get("data", {})} for cell in notebook.cells]
    assert ["image/svg+xml" in kinds for kinds in shown] == [False, True, True, False]
    assert "image/png" in shown[3]


def test_round_sides_are_declared_and_generated() -> None:
    """The pin in an eye of tests/cases/solid/pin.toml."""
    pin = nndd.Body(nndd.Mesh.cylinder(1.0, 2.0, (16, 3, 4)), nndd.Material(2000.0, 0.3), "pin", body_force=(0, -5, 0))
    eye = nndd.Body(nndd.Mesh.tube((1.0, 1.8), 2.0, (16, 2, 4)), STEEL, "eye").fix("outer").surface("inner", "cylinder")
    problem = nndd.Problem([pin.surface("outer", "cylinder"), eye], [nndd.Contact(pin, eye, ("outer", "inner"))])
    found = problem.solve()
    assert found.valid
    assert same(found, nndd.solve(CASES / "solid" / "pin.toml"))
    by_place = nndd.Body(eye.mesh, STEEL, "eye").side("rim", cylinder=((0, 0, 0), (0, 0, 1), 1.8)).fix("rim")
    [checked] = nndd.Problem([by_place]).check().bodies
    assert checked["sides"]["rim"] == len(eye.mesh.sides["outer"])
    ball = nndd.Body(nndd.Mesh.ball(1.0, 6, part="eighth", growth=3.0), STEEL, "ball").displace("flat", uz=-0.02)
    ball.displace("left", ux=0).displace("front", uy=0)
    touch = nndd.Contact(ball, nndd.Obstacle.plane((0, 0, -1), (0, 0, 1)), "surface")
    assert same(nndd.Problem([ball], [touch]).solve(), nndd.solve(CASES / "solid" / "ball.toml"))


def plane_with_sphere() -> nndd.Problem:
    problem = blocks()
    upper = problem.bodies[0]
    return nndd.Problem([upper], [nndd.Contact(upper, nndd.Obstacle.sphere((0, 0), 1), "bottom")])


def loaded(vector: Any) -> nndd.Problem:
    return nndd.Problem([cube().fix("bottom").load("top", vector)])


def on_cylinder(axis: Any) -> nndd.Problem:
    body = cube()
    return nndd.Problem([body], [nndd.Contact(body, nndd.Obstacle.cylinder((0, 0, -1), axis, 1), "bottom")])


@pytest.mark.parametrize(
    ("problem", "place", "words"),
    [
        (plane_with_sphere(), "contact.0.obstacle.kind", "spheres touch solid bodies"),
        (loaded((0, -1)), "body.0.traction.0.vector", "has 2 entries"),
        (loaded((0, 0, np.zeros(27))), "body.0.traction.0.vector", "values at the nodes of solids are not read"),
        (loaded((0, 0, lambda x, y: x)), "body.0.traction.0.vector", "values at the nodes of solids are not read"),
        (on_sphere(side="out"), "contact.0.obstacle.side", "out"),
        (on_sphere(radius=-1), "contact.0.obstacle.radius", "-1"),
        (on_sphere(radius=float("nan")), "contact.0.obstacle.radius", "NaN"),
        (on_sphere(centre=(0, 0)), "contact.0.obstacle.centre", "has 2 entries"),
        (on_sphere(rotation=0.0), "contact.0.obstacle.rotation", "number 0.0"),
        (on_sphere(rotatoin=(0, 0, 0)), "contact.0.obstacle.rotatoin", "unknown key"),
        (on_cylinder((0, 0, 0)), "contact.0.obstacle.axis", "has no direction"),
        (nndd.Problem([cube()], hypothesis="plane_strain"), "model.hypothesis", "belongs to the plane"),
        (nndd.Problem([cube()], thickness=2.0), "model.thickness", "belongs to the plane"),
        (nndd.Problem([cube().curve("top", "arc")]), "body.0.curve", "surfaces"),
        (nndd.Problem([cube(), blocks().bodies[0]]), "body.1.generator.kind", "a case has bodies of one kind"),
    ],
)
def test_wrong_input_names_its_place(problem: nndd.Problem, place: str, words: str) -> None:
    with pytest.raises(nndd.InvalidInput) as caught:
        problem.check()
    error = caught.value
    assert len(error.findings) == 1
    assert error.place == place
    assert words in error.found
    assert error.expected
    assert error.fix


def test_wrong_meshes_of_tetrahedra() -> None:
    points, cells = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]]
    for wrong, words in (
        ({}, "neither triangles nor tetrahedra"),
        ({"triangles": [[0, 1, 2]], "tetrahedra": cells}, "triangles and tetrahedra"),
        ({"tetrahedra": [[0, 1, 2]]}, "tetrahedra: the shape is (1, 3)"),
        ({"tetrahedra": cells, "sides": {"a": [[0, 1]]}}, "sides['a']: the shape is (1, 2)"),
    ):
        with pytest.raises(nndd.InvalidInput) as caught:
            nndd.Mesh(points, **wrong)
        assert words in str(caught.value)
    with pytest.raises(nndd.InvalidInput, match=r"points: the shape is \(3, 2\)"):
        nndd.Mesh([[0, 0], [1, 0], [0, 1]], tetrahedra=cells)
    for wrong, words in (
        ({"tetrahedra": [[0, 1, 2, 9]]}, "tetrahedron 0 has the node 9"),
        ({"tetrahedra": cells, "sides": {"a": [[0, 1, 1]]}}, 'side "a" has the node 1 twice'),
        ({"tetrahedra": cells, "sides": {"a": [[0, 1, 2]]}, "regions": {"b": [1]}}, 'region "b" has the tetrahedron 1'),
    ):
        body = nndd.Body(nndd.Mesh(points, **wrong), STEEL).fix("a")
        with pytest.raises(nndd.InvalidInput) as caught:
            nndd.Problem([body]).check()
        assert words in str(caught.value)
