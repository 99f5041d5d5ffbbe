"""Bounds of fields from elsewhere, held against their true errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import nndd
import numpy as np
import pytest
from conftest import CASES, arrays_of, blocks

YOUNG, POISSON = 1000.0, 0.3


def pulled(basis: Any, held: np.ndarray, c: float) -> tuple[np.ndarray, Any]:
    """Solve in scikit-fem for a body pulled in x on its right side, by c times the last coordinate; also return the stiffness."""
    import skfem
    from skfem.helpers import ddot, eye, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    lame, mu = lame_parameters(YOUNG, POISSON)

    @skfem.BilinearForm
    def form(u, v, w):  # type: ignore[no-untyped-def]
        stress = 2 * mu * sym_grad(u) + lame * eye(trace(sym_grad(u)), basis.mesh.dim())
        return ddot(stress, sym_grad(v))

    @skfem.LinearForm
    def load(v, w):  # type: ignore[no-untyped-def]
        return c * w.x[-1] * v[0]

    matrix = form.assemble(basis)
    loads = load.assemble(skfem.FacetBasis(basis.mesh, basis.elem, facets="right"))
    return skfem.solve(*skfem.condense(matrix, loads, D=held)), matrix


def bent(cells: tuple[int, int]) -> tuple[nndd.Problem, np.ndarray, float]:
    """Bend a plate in scikit-fem: a problem with an exact solution, its finite element displacements, and their true error.

    The stress is c y in x and nothing else, so the loads are linear, and what linear triangles miss is known: the squared energy
    norm of the error is that of the exact solution less that of the approximate one.
    """
    import skfem

    length, half, c = 2.0, 0.5, 10.0
    grid = np.linspace(0, length, cells[0] + 1), np.linspace(-half, half, cells[1] + 1)
    mesh = skfem.MeshTri.init_tensor(*grid).with_defaults()
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()))

    middle = np.flatnonzero((mesh.p[0] == 0) & (mesh.p[1] == 0))
    held = np.concatenate([basis.get_dofs("left").nodal["u^1"], basis.nodal_dofs[1, middle]])
    u, matrix = pulled(basis, held, c)
    energy = c**2 * (1 - POISSON**2) / YOUNG * length * 2 * half**3 / 3
    error = float(np.sqrt(energy - u @ matrix @ u))

    sides = {name: mesh.facets[:, facets].T for name, facets in mesh.boundaries.items()}
    plate = nndd.Body(nndd.Mesh(mesh.p.T, mesh.t.T, sides), nndd.Material(YOUNG, POISSON), "plate")
    plate.displace("left", ux=0.0).side("middle", point=(0, 0)).displace("middle", uy=0.0)
    plate.load("right", (lambda x, y: c * y, 0.0))
    return nndd.Problem([plate]), u[basis.nodal_dofs].T, error


@pytest.mark.parametrize("cells", [(8, 4), (16, 8), (32, 16)])
def test_a_field_of_scikit_fem_is_bounded(cells: tuple[int, int]) -> None:
    problem, found, error = bent(cells)
    certificate = nndd.certify(problem, [found])
    assert certificate.valid
    assert certificate.bound is not None
    assert 0.0 < error <= certificate.bound <= 1.5 * error
    # It is the field that this package finds on the same mesh.
    assert problem.solve().bodies[0].displacement == pytest.approx(found, abs=1e-12)
    # A worse field of the same mesh: the bound holds, whatever its source.
    wrong = found + 1e-4 * problem.bodies[0].mesh.points[:, :1] * [[1.0, 0.0]]
    poor = nndd.certify(problem, [wrong])
    assert poor.bound is None or poor.bound > certificate.bound


def test_a_certificate_of_the_solvers_own_field() -> None:
    problem = blocks((12, 6))
    solution = problem.solve()
    fields = [body.displacement for body in solution.bodies]
    certificate = nndd.certify(problem, fields)
    assert certificate.valid
    assert certificate.bound is not None
    assert solution.certified_error is not None
    assert certificate.bound == pytest.approx(solution.certified_error, rel=0.05)
    [density, _] = certificate.error_density
    assert density.shape == (len(problem.bodies[0].mesh.triangles),)
    pressure = np.zeros(len(fields[0]))
    [pair] = solution.contacts
    nodes = {tuple(point): k for k, point in enumerate(problem.bodies[0].mesh.points.tolist())}
    for point, value in zip(pair.points.tolist(), pair.pressure):
        pressure[nodes[tuple(point)]] = value
    by_pressure = nndd.certify(problem, fields, [pressure])
    assert by_pressure.bound == pytest.approx(certificate.bound, rel=1e-3)


def test_the_order_and_unused_nodes_of_a_mesh_do_not_matter() -> None:
    problem = blocks((12, 6))
    fields = [body.displacement for body in problem.solve().bodies]
    plain = nndd.certify(problem, fields)
    order = np.random.default_rng(1).permutation(len(fields[0]) + 1)
    place = np.argsort(order)
    given = problem.bodies[0].mesh
    # One more node that no triangle has, and all of them shuffled.
    points = np.vstack([given.points, [9.0, 9.0]])[order]
    sides = {name: place[edges] for name, edges in given.sides.items()}
    problem.bodies[0].mesh = nndd.Mesh(points, place[given.triangles], sides)
    shuffled = np.vstack([fields[0], [0.0, 0.0]])[order]
    found = nndd.certify(problem, [shuffled, fields[1]])
    assert found.valid
    assert found.bound == pytest.approx(plain.bound, rel=0.01)


def test_a_wrong_field_gets_a_large_bound_and_no_false_one() -> None:
    problem = blocks((12, 6))
    fields = [1.1 * body.displacement for body in problem.solve().bodies]
    poor = nndd.certify(problem, fields)
    assert poor.bound is None or poor.bound > 0.05 * poor.energy_norm
    assert poor.failed_checks or poor.valid
    nothing = nndd.certify(problem, [np.zeros_like(u) for u in fields])
    assert (nothing.valid, nothing.bound, nothing.relative) == (False, None, None)
    assert "imposed_displacement" in nothing.failed_checks
    assert nothing.missed_support is not None
    assert nothing.missed_support["body"] == "upper"


def test_meshes_that_do_not_match() -> None:
    problem = blocks((12, 6))
    problem.bodies[1].mesh = arrays_of(nndd.Mesh.block((0, 0), (2, 1), (9, 5)))
    fields = [np.zeros((len(body.mesh.points), 2)) for body in problem.bodies]
    for body, field in zip(problem.bodies, fields):
        field[:, 1] = -0.005 * body.mesh.points[:, 1]
    found = nndd.certify(problem, fields)
    assert [len(mesh.points) >= len(field) for mesh, field in zip(found.meshes, fields)] == [True, True]
    assert len(found.meshes[1].points) > len(fields[1])


def test_fields_on_meshes_that_do_not_match_are_bounded_as_they_were_given() -> None:
    """Hold random fields and pressures against the exact, linear solution; nodes are moved so that the surfaces match."""
    steel = nndd.Material(YOUNG, POISSON)
    upper = nndd.Body(arrays_of(nndd.Mesh.block((0, 1), (2, 1), (8, 4))), steel, "upper")
    lower = nndd.Body(arrays_of(nndd.Mesh.block((0, 0), (2, 1), (9, 4))), steel, "lower")
    upper.load("top", pressure=10.0).displace("left", ux=0.0)
    lower.displace("bottom", uy=0.0).displace("left", ux=0.0)
    problem = nndd.Problem([upper, lower], [nndd.Contact(upper, lower, ("bottom", "top"))])

    def error(fields: list[np.ndarray]) -> float:
        squared = 0.0
        for body, u in zip((upper, lower), fields):
            x, cells = np.asarray(body.mesh.points), np.asarray(body.mesh.triangles)
            edges = x[cells][:, 1:] - x[cells][:, :1]
            area = 0.5 * np.abs(np.linalg.det(edges))
            gradient = np.linalg.solve(edges, u[cells][:, 1:] - u[cells][:, :1])
            strain = 0.5 * (gradient + gradient.transpose(0, 2, 1)) - np.diag([0.0039, -0.0091])
            mu = YOUNG / (2 * (1 + POISSON))
            lame = 2 * mu * POISSON / (1 - 2 * POISSON)
            trace = np.trace(strain, axis1=1, axis2=2)
            squared += float(area @ (2 * mu * (strain**2).sum(axis=(1, 2)) + lame * trace**2))
        return float(np.sqrt(squared))

    random = np.random.default_rng(5)
    valid = 0
    for amplitude in (0.0, 1e-6, 1e-3, 0.03):
        for size in (None, 0.0, 10.0, 1e4):
            fields = [body.mesh.points * [0.0039, -0.0091] for body in (upper, lower)]
            for body, u in zip((upper, lower), fields):
                inside = (body.mesh.points[:, 0] > 0) & (body.mesh.points[:, 1] > 0)
                u += amplitude * inside[:, None] * random.uniform(-1, 1, u.shape)
            pressures = None if size is None else [size * random.uniform(-0.5, 1, len(fields[0]))]
            found = nndd.certify(problem, fields, pressures)
            valid += found.valid
            assert found.bound is None or found.bound >= error(fields)
    assert valid >= 8


def test_arrays_that_are_no_fields_are_refused() -> None:
    problem = blocks((12, 6))
    fields = [body.displacement for body in problem.solve().bodies]
    nodes = len(fields[0])
    bad_fields: list[Any] = [
        [fields[0][:-1], fields[1]],
        [fields[0].T, fields[1]],
        [fields[0].astype(complex) + 1j, fields[1]],
        [np.full_like(fields[0], np.nan), fields[1]],
        [fields[0]],
    ]
    for bad in bad_fields:
        with pytest.raises((nndd.Error, TypeError, ValueError)):
            nndd.certify(problem, bad)
    for pressure in (np.zeros(nodes - 1), np.zeros((nodes, 2)), np.full(nodes, np.nan), ["a"] * nodes):
        with pytest.raises((nndd.Error, TypeError, ValueError)):
            nndd.certify(problem, fields, [pressure])


def test_fields_of_solids_have_three_components() -> None:
    case = CASES / "solid" / "stack.toml"
    solution = nndd.solve(case, solver__method="exact")
    fields = [body.displacement for body in solution.bodies]
    own = nndd.certify(case, fields, threads=1)
    assert own.valid
    assert own.bound == pytest.approx(solution.certified_error, rel=1e-9)
    assert own.bound is not None
    assert own.meshes[0].tetrahedra is not None
    assert [len(density) for density in own.error_density] == [96, 96, 96]
    # A field of the half size misses no zero support; its bound holds against the first one.
    poor = nndd.certify(case, [0.5 * field for field in fields])
    assert poor.bound is None or poor.bound > own.bound
    for bad in ([field[:, :2] for field in fields], fields[:1], [fields[0][:-1], *fields[1:]]):
        with pytest.raises(nndd.Error):
            nndd.certify(case, bad)


def test_plane_fields_have_no_third_component() -> None:
    problem = blocks()
    with pytest.raises(nndd.Error, match="rows of 3 numbers"):
        nndd.certify(problem, [np.zeros((len(body.mesh.points), 3)) for body in problem.bodies])


def bent_bar(cells: int) -> tuple[nndd.Problem, np.ndarray, float]:
    """Bend a bar in scikit-fem, half of it by symmetry: σ_xx = c z and nothing else, so the error is known as in `bent`."""
    skfem = pytest.importorskip("skfem")

    length, width, half, c = 2.0, 0.5, 0.5, 10.0
    sizes = ((0.0, length, 4), (0.0, width, 1), (-half, half, 2))
    axes = [np.linspace(low, high, n * cells + 1) for low, high, n in sizes]
    mesh = skfem.MeshTet.init_tensor(*axes).with_boundaries(
        {"left": lambda x: x[0] == 0, "right": lambda x: x[0] == length, "front": lambda x: x[1] == 0}
    )
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()))

    middle = np.flatnonzero((np.abs(mesh.p) < 1e-12).all(axis=0))
    held = [basis.get_dofs("left").nodal["u^1"], basis.get_dofs("front").nodal["u^2"], basis.nodal_dofs[2, middle]]
    u, matrix = pulled(basis, np.concatenate(held), c)
    energy = c**2 / YOUNG * length * width * 2 * half**3 / 3
    sides = {name: mesh.facets[:, facets].T for name, facets in mesh.boundaries.items()}
    bar = nndd.Body(nndd.Mesh(mesh.p.T, sides=sides, tetrahedra=mesh.t.T), nndd.Material(YOUNG, POISSON), "bar")
    bar.displace("left", ux=0).displace("front", uy=0).side("middle", point=(0, 0, 0)).displace("middle", uz=0)
    bar.load("right", (f"{c}*z", 0, 0))
    return nndd.Problem([bar]), u[basis.nodal_dofs].T, float(np.sqrt(energy - u @ matrix @ u))


@pytest.mark.parametrize("cells", [1, 2, 4])
def test_a_solid_field_of_scikit_fem_is_bounded(cells: int) -> None:
    problem, found, error = bent_bar(cells)
    certificate = nndd.certify(problem, [found])
    assert certificate.valid
    assert certificate.bound is not None
    assert 0.0 < error <= certificate.bound <= 2.0 * error
    assert problem.solve().bodies[0].displacement == pytest.approx(found, abs=1e-11)


def pressed_cube(cells: int) -> nndd.Problem:
    """A cube on a rigid plane, pushed down on one half and pulled up on the other."""
    mesh = nndd.Mesh.box((0, 0, 0), (1, 1, 1), (cells, cells, cells))
    cube = nndd.Body(arrays_of(mesh), nndd.Material(YOUNG, POISSON), "cube").displace("left", ux=0).displace("front", uy=0)
    cube.load("top", (0, 0, "-20*(1-1.8*x)"))
    return nndd.Problem([cube], [nndd.Contact(cube, nndd.Obstacle.plane((0, 0, 0), (0, 0, 1)), "bottom")])


def pressed_pair(cells: int) -> nndd.Problem:
    """The same on another cube, which is held at its bottom."""
    meshes = [arrays_of(nndd.Mesh.box((0, 0, z), (1, 1, 1), (cells, cells, cells))) for z in (1, 0)]
    upper, lower = (nndd.Body(mesh, nndd.Material(YOUNG, POISSON), name) for mesh, name in zip(meshes, ("upper", "lower")))
    upper.displace("left", ux=0).displace("front", uy=0).load("top", (0, 0, "-20*(1-1.8*x)"))
    return nndd.Problem([upper, lower.fix("bottom")], [nndd.Contact(upper, lower, ("bottom", "top"))])


def energy_norm(mesh: nndd.Mesh, u: np.ndarray) -> float:
    """Integrate the energy of a solid displacement."""
    corners, moved = mesh.points[mesh._cells], u[mesh._cells]
    edges = corners[:, 1:] - corners[:, :1]
    gradient = np.linalg.solve(edges, moved[:, 1:] - moved[:, :1])
    strain = 0.5 * (gradient + gradient.transpose(0, 2, 1))
    mu = YOUNG / (2 * (1 + POISSON))
    lame = 2 * mu * POISSON / (1 - 2 * POISSON)
    density = 2 * mu * (strain**2).sum(axis=(1, 2)) + lame * np.trace(strain, axis1=1, axis2=2) ** 2
    return float(np.sqrt(np.abs(np.linalg.det(edges)) @ density / 6))


def onto(own: nndd.Mesh, mesh: nndd.Mesh) -> Callable[[np.ndarray], np.ndarray]:
    """Make the interpolation of fields on a mesh to a finer one whose cells lie in its cells: it is exact."""
    cells = own.points[own._cells]
    places = mesh.points - cells[:, :1]
    local = np.linalg.solve((cells[:, 1:] - cells[:, :1]).transpose(0, 2, 1)[:, None], places[..., None])
    weights = np.concatenate([1 - local.sum(axis=2), local[..., 0]], axis=2)
    inside, nodes = weights.min(axis=2).argmax(axis=0), np.arange(len(mesh.points))
    assert weights[inside, nodes].min() > -1e-12
    return lambda field: np.asarray(np.einsum("nc,ncd->nd", weights[inside, nodes], field[own._cells[inside]]))


@pytest.mark.parametrize("problem", [pressed_cube, pressed_pair])
def test_wrong_fields_of_solids_are_bounded(problem: Callable[[int], nndd.Problem]) -> None:
    """Hold random fields against the solution on a nested mesh.

    It has the smallest energy of the fields there, which is not below the exact one: it is no farther away than the bound.
    """
    coarse = problem(2)
    fine = problem(8).solve(solver__method="exact").bodies
    maps = [onto(body.mesh, of.mesh) for body, of in zip(coarse.bodies, fine)]
    linear = coarse.bodies[0].mesh.points @ np.array([[0.01, 0, 0], [0.02, 0.03, 0], [0, 0.01, -0.02]])
    assert energy_norm(fine[0].mesh, maps[0](linear)) == pytest.approx(energy_norm(coarse.bodies[0].mesh, linear))
    random = np.random.default_rng(11)
    start = [body.displacement for body in coarse.solve(solver__method="exact").bodies]
    valid, close = 0, 0
    for amplitude in (0.0, 1e-6, 1e-4, 1e-3, 1e-2, 0.1):
        for lift in (0.0, 0.0, -0.3, 0.3):
            fields = []
            for body, found in zip(coarse.bodies, start):
                # Supports are kept, and the first body as a whole is lifted or pressed in.
                held = body.mesh.points[:, 2:] == (0 if body.name == "lower" else -1)
                free = (body.mesh.points > 0) * [1, 1, 0] + [0, 0, 1]
                rise = [0, 0, 0 if body.name == "lower" else lift]
                fields.append(found + amplitude * (free * random.uniform(-1, 1, found.shape) + rise) * ~held)
            certificate = nndd.certify(coarse, fields)
            distances = [energy_norm(of.mesh, by(u) - of.displacement) for of, by, u in zip(fine, maps, fields)]
            distance = float(np.linalg.norm(distances))
            valid += certificate.valid
            close += certificate.bound is not None and certificate.bound <= 2 * distance
            assert certificate.bound is None or certificate.bound >= distance
    assert valid >= 20
    assert close >= 15
