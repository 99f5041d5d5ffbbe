"""Objects, data at nodes, functions: each is the same problem written in another way."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest
import tomllib
from conftest import CASES, ROOT, arrays_of, blocks, same

STEEL = nndd.Material(1000.0, 0.3, name="steel")


@pytest.mark.parametrize("file", sorted(CASES.glob("*.toml")), ids=lambda file: file.stem)
def test_a_dict_of_the_same_keys_is_the_same_case(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        expected = nndd.check(file)
    except nndd.Error as error:
        # A limit of memory that is too small.
        if error.code == 8:
            return
        raise
    # Mesh files of a dict are relative to the working directory.
    monkeypatch.chdir(CASES)
    found = nndd.check(tomllib.loads(file.read_text()))
    assert (found.bodies, found.contacts, found.warnings) == (expected.bodies, expected.contacts, expected.warnings)


def keys_of_the_page() -> set[str]:
    """The keys of tests/cases/README.md by section, as `contact.friction`; those of settings are overrides."""
    found, section = set(), ""
    for line in (ROOT / "tests" / "cases" / "README.md").read_text().splitlines():
        if heading := re.match(r"\| \*\*`(\[+)([^\]]+)\]+`\*\*", line):
            section = heading[2]
        elif row := re.match(r"\| ((`[a-z_0-9]+`(, )?)+) ", line):
            found |= {f"{section}.{key}" for key in re.findall(r"`([a-z_0-9]+)`", row[1])}
        elif line.startswith("| `generator` | keys"):
            break
    settings = ("solver", "estimator", "adapt", "output", "limits")
    return {key.removeprefix(".") for key in found if not key.startswith(settings)}


# Tables whose own keys are not collected.
WITHOUT_KEYS = ("generator", "obstacle", "friction", "factors", "box", "part", "circle", "plane")


def keys_of(table: dict[str, Any], section: str = "") -> set[str]:
    """The keys of a dict by section, numbers and the users' own names left out."""
    found = set()
    for key, value in table.items():
        found.add(f"{section}.{key}".removeprefix("."))
        inner = f"{section}.{key}".removeprefix(".")
        if section == "materials":
            found -= {inner}
            inner = "materials.NAME"
        for entry in value if isinstance(value, list) else [value]:
            if isinstance(entry, dict) and key not in WITHOUT_KEYS:
                found |= keys_of(entry, inner)
    return found


def every_key() -> nndd.Problem:
    """A problem, of no other sense, that uses every method."""
    mesh = arrays_of(nndd.Mesh.block((0, 0), (1, 1), (2, 2)))
    ply = nndd.Material.orthotropic(3.0, 1.0, 0.2, 0.5, angle=30, young_3=1.0, poisson_13=0.2, poisson_23=0.2)
    sheet = nndd.Material.of_stiffness(np.eye(3), name="sheet")
    steel = STEEL.having(expansion=1e-5, density=1.0, limit=5.0)
    body = nndd.Body(mesh, steel, "a", region="r", body_force=(0, -1), merge=True, duplicate_interface=True)
    body.side("s", box={"x": (0, 1)}, facing=(0, 1), within=10, circle=((0, 0), 1)).side("p", point=(0, 0))
    body.fix("p").displace("left", ux=0.0, uy=0.0, normal=0.0, part={"x": (0, 1)}, name="push")
    body.load("right", (0, 1)).load("right", pressure=1.0, part={"y": (0, 1)}, name="pull")
    body.rigid("top", ux=0, uy=0, rotation=0, force=(0, 1), moment=1, about=(0, 0), part={"x": (0, 1)}, name="plate")
    body.spring("left", 1.0, along=(1, 0), rest=0.1, part={"x": (0, 1)}, name="bed").warm("x", name="warm")
    body.cut("bolt", (0, 0.5), (0, 1), shortening=0.1, force=1.0, box={"x": (0, 1)})
    body.curve("top", "arc").region(ply, group="g").region(sheet, box={"x": (0, 1)})
    other = nndd.Body(nndd.Mesh.block((0, 0), (1, 1), (2, 2)), STEEL, "b")
    wall = nndd.Obstacle.plane((0, 0), (0, 1), ux=0, uy=0, rotation=0, force=(0, 1), moment=1, about=(0, 0))
    contacts = [
        nndd.Contact(body, other, ("top", "bottom"), gap=0, friction=nndd.Friction.coulomb(0.3), normal=(0, 1), imposed="first"),
        nndd.Contact(body, other, ("top", "bottom"), gap="geometric", interference=True),
        nndd.Contact(body, other, ("top", "bottom"), law="bonded", offset=(0, 1)),
        nndd.Contact(body, wall, "bottom", motion=(0, 1), friction=nndd.Friction.tresca(1.0), name="wall"),
        nndd.Contact(body, nndd.Obstacle.circle((0, 0), 1, side="inside", ux=0), "right"),
    ]
    steps = [nndd.Step({"push": 1.0}, count=2)]
    spin = {"speed": 1.0, "point": (0, 0)}
    problem = nndd.Problem([body, other], contacts, steps=steps, thickness=2.0, title="all", units=("mm", "N"))
    problem.rotation, problem.acceleration = spin, (0, -1)
    return problem


def test_every_key_of_the_page_has_its_object() -> None:
    page = keys_of_the_page()
    assert len(page) >= 50
    assert {"contact.friction", "materials.NAME.young_1", "body.rigid.about", "step.factors", "units.length"} <= page
    # What the page says in its headings and texts.
    page |= {f"body.region.{key}" for key in ("material", "group", "box")}
    page |= {f"body.mesh.{key}" for key in ("file", "region", "merge", "duplicate_interface")}
    page |= {"body.displacement.part", "body.traction.name", "body.rigid.name", "body.curve.on"}
    assert page - keys_of(every_key().to_dict()) == set()


def test_meshes_of_generators_and_of_arrays_are_the_same() -> None:
    for mesh in (
        nndd.Mesh.ring((0, 0), (1, 2), (12, 3), angles=(0, 90)),
        nndd.Mesh.disc((0, 0), 1.0, 3, start=10.0),
        nndd.Mesh.half_disc((0, 0), 1.0, "down", 0.2, 4),
    ):
        body = nndd.Body(mesh, STEEL, body_force=(1.0, 2.0)).fix(next(iter(mesh.sides)))
        first = nndd.Problem([body]).solve()
        body.mesh = arrays_of(mesh)
        assert same(first, nndd.Problem([body]).solve())
        assert np.array_equal(first.bodies[0].mesh.points, mesh.points)


def test_numbers_expressions_arrays_and_functions_agree() -> None:
    """A linear load: all four are exact."""

    def solved(uy: Any, vector: Any) -> nndd.Solution:
        mesh = arrays_of(nndd.Mesh.block((0, 0), (2, 1), (8, 4)))
        body = nndd.Body(mesh, STEEL).displace("bottom", ux=0.0, uy=uy).load("right", vector)
        return nndd.Problem([body]).solve()

    x, y = nndd.Mesh.block((0, 0), (2, 1), (8, 4)).points.T
    by_text = solved("0.01 * x", (0.0, "3 * y"))
    away = np.where(y == 0.0, 0.01 * x, np.nan)
    for uy, vector in (
        (lambda x, y: 0.01 * x, (0.0, lambda x, y: 3 * y)),
        (0.01 * x, (0.0, 3 * y)),
        # Values away from the side do not count.
        (away, np.column_stack([0 * y, 3 * y])),
    ):
        assert same(by_text, solved(uy, vector))
    assert not any("linear" in note for note in by_text.notes)


def test_a_function_is_called_once_with_the_nodes_of_its_side() -> None:
    calls = []

    def sink(x: Any, y: Any) -> Any:
        calls.append((x, y))
        return -0.01 * (1 + x)

    problem = blocks()
    problem.bodies[0]._lists["displacement"][0]["uy"] = sink
    solution = problem.solve(0.1)
    [(x, y)] = calls
    assert np.sort(x) == pytest.approx(np.linspace(0, 2, 7))
    assert (y == 2.0).all()
    # On the refined meshes the data are linear between these nodes.
    [upper, _] = solution.bodies
    top = upper.mesh.points[:, 1] == 2.0
    assert top.sum() > 7
    assert upper.displacement[top, 1] == pytest.approx(-0.01 * (1 + upper.mesh.points[top, 0]), abs=1e-16)


def test_gaps_and_limits_take_data_too() -> None:
    gap = lambda x, y: 1e-3 * (x - 1) ** 2  # noqa: E731
    by_function, by_text = blocks(gap=gap).solve(), blocks(gap="1e-3 * (x - 1)^2").solve()
    assert same(by_function, by_text)
    x = nndd.Mesh.block((0, 1), (2, 1), (6, 3)).points[:, 0]
    assert same(by_text, blocks(gap=1e-3 * (x - 1) ** 2).solve())
    tresca = [blocks(friction=nndd.Friction.tresca(limit)).solve() for limit in ("1 + x", lambda x, y: 1 + x, 1 + x)]
    assert same(tresca[0], tresca[1])
    assert same(tresca[0], tresca[2])
    assert tresca[0].valid


def test_data_at_nodes_on_meshes_that_do_not_match() -> None:
    def solved(gap: Any) -> nndd.Solution:
        lower = nndd.Body(nndd.Mesh.block((0, 0), (2, 1), (7, 3)), STEEL, "lower").fix("bottom")
        upper = nndd.Body(nndd.Mesh.block((0, 1), (2, 1), (6, 3)), STEEL, "upper").displace("top", ux=0.0, uy=-0.01)
        return nndd.Problem([upper, lower], [nndd.Contact(upper, lower, ("bottom", "top"), gap=gap)]).solve()

    by_text, by_function = solved("1e-3 * x"), solved(lambda x, y: 1e-3 * x)
    assert by_text.valid
    assert by_function.valid
    for first, second in zip(by_text.bodies, by_function.bodies):
        assert second.displacement == pytest.approx(first.displacement, abs=1e-12)


def test_regions_have_materials_of_their_own() -> None:
    mesh = nndd.Mesh.block((0, 0), (2, 1), (4, 2))
    centroids = mesh.points[mesh.triangles].mean(axis=1)
    left = np.flatnonzero(centroids[:, 0] < 1)
    named = nndd.Mesh(mesh.points, mesh.triangles, mesh.sides, {"left": left, "all": np.arange(len(mesh.triangles))})
    hard = nndd.Material(5000.0, 0.3, name="hard")

    def solved(mesh: nndd.Mesh, region: str | None, **part: Any) -> nndd.Solution:
        body = nndd.Body(mesh, STEEL, region=region).fix("bottom").load("top", (0, 1)).region(hard, **part)
        return nndd.Problem([body]).solve()

    by_group, by_box = solved(named, "all", group="left"), solved(mesh, None, box={"x": (0, 1)})
    assert same(by_group, by_box)
    assert by_group.bodies[0].cell_data["material_id"].tolist() == (centroids[:, 0] < 1).astype(int).tolist()


def test_two_bodies_of_one_mesh_may_share_nodes() -> None:
    mesh = nndd.Mesh.block((0, 0), (1, 2), (3, 6))
    upper = mesh.points[mesh.triangles].mean(axis=1)[:, 1] > 1
    middle = np.flatnonzero(mesh.points[:, 1] == 1.0)
    sides = {**mesh.sides, "middle": np.column_stack([middle[:-1], middle[1:]])}
    regions = {"upper": np.flatnonzero(upper), "lower": np.flatnonzero(~upper)}
    whole = nndd.Mesh(mesh.points, mesh.triangles, sides, regions)
    first = nndd.Body(whole, STEEL, region="upper", duplicate_interface=True).displace("top", ux=0, uy=-0.01)
    second = nndd.Body(whole, STEEL, region="lower").fix("bottom")
    problem = nndd.Problem([first, second], [nndd.Contact(first, second, ("middle", "middle"))])
    solution = problem.solve()
    assert solution.valid
    assert [len(body.mesh.points) for body in solution.bodies] == [16, 16]
    assert solution.contacts[0].pressure.min() > 0.0


def test_obstacles_rigid_sides_and_steps() -> None:
    body = nndd.Body(nndd.Mesh.block((0, 0), (1, 1), (6, 6)), STEEL, "block")
    body.rigid("top", force=(0, -10), ux=0, rotation=0, name="push")
    table = nndd.Obstacle.plane((0, 0), (0, 1))
    contact = nndd.Contact(body, table, "bottom", friction=nndd.Friction.tresca(2.0))
    solution = nndd.Problem([body], [contact], steps=[nndd.Step({"push": 1.0}, count=2)]).solve()
    assert [step["factors"]["push"] for step in solution.steps] == [0.5, 1.0]
    resultant = solution.contacts[0].resultant
    assert resultant is not None
    assert resultant[1] == pytest.approx(10.0)
    assert set(solution.contacts[0].columns) >= {"tangential", "slip", "limit", "state"}
    stamp = nndd.Obstacle.circle((0.5, 1.5), 0.5, ux=0, rotation=0, force=(0, -5))
    held = nndd.Body(nndd.Mesh.block((0, 0), (1, 1), (8, 8)), STEEL, "held").fix("bottom")
    pressed = nndd.Problem([held], [nndd.Contact(held, stamp, "top", gap="geometric")]).solve()
    assert pressed.valid
    resultant = pressed.contacts[0].resultant
    assert resultant is not None
    assert resultant[1] == pytest.approx(-5.0)


def test_a_target_is_a_bound_or_with_coulomb_friction_a_residual() -> None:
    certified = blocks().solve(0.2)
    assert certified.relative is not None
    assert certified.relative <= 0.2
    coulomb = blocks(friction=nndd.Friction.coulomb(0.3)).solve(0.3)
    assert (coulomb.status, coulomb.valid) == ("residual_reached", False)
    assert coulomb.coulomb is not None
    assert coulomb.coulomb["relative"] <= 0.3
    assert coulomb.adaptive["relative_residual"][-1] == coulomb.coulomb["relative"]


def test_results_cannot_be_written_to() -> None:
    solution = blocks().solve()
    [body, _] = solution.bodies
    [pair] = solution.contacts
    arrays: list[Any] = [solution.iterations, pair.points, pair.resultant, *pair.columns.values()]
    arrays += [*body.point_data.values(), *body.cell_data.values(), body.displacement, body.reaction, body.stress]
    arrays += [body.stress_recovered, body.von_mises, body.von_mises_recovered, body.error_density, body.mesh.points]
    certificate = nndd.certify(blocks(), [body.displacement for body in solution.bodies])
    for array in arrays + certificate.error_density:
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array.flat[0] = array.flat[0]
