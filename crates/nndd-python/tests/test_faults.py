"""Wrong input is an exception with its place, never a crash."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import nndd
import numpy as np
import pytest
from conftest import CASES, blocks

POINTS = [[0, 0], [1, 0], [1, 1], [0, 1]]
TRIANGLES = [[0, 1, 2], [0, 2, 3]]
NAN = float("nan")


def refused(problem: nndd.Problem | dict[str, Any] | Path, **options: Any) -> nndd.Error:
    with pytest.raises(nndd.Error) as caught:
        nndd.solve(problem, **options)
    return caught.value


def square(**changes: Any) -> nndd.Mesh:
    given: dict[str, Any] = {"points": POINTS, "triangles": TRIANGLES, "sides": {"bottom": [[0, 1]], "top": [[2, 3]]}, **changes}
    return nndd.Mesh(**given)


def body(mesh: nndd.Mesh) -> nndd.Problem:
    return nndd.Problem([nndd.Body(mesh, nndd.Material(1.0, 0.3), "square").fix("bottom").load("top", (0, 1))])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"points": [0, 1, 2]}, "points: the shape is (3,)"),
        ({"points": [[0, 0, 0, 0]]}, "points: the shape is (1, 4)"),
        ({"points": [[0, 0], [1, NAN], [1, 1], [0, 1]]}, "points: the value at (1, 1) is nan"),
        ({"points": np.array(POINTS, dtype=complex)}, "points: an array of type complex128"),
        ({"points": [["a", "b"]]}, "points: an array of type <U1"),
        ({"points": [[0, 0], [1]]}, "points: it cannot be made an array"),
        ({"triangles": [[0, 1]]}, "triangles: the shape is (1, 2)"),
        ({"triangles": [[0.0, 1.0, 2.0]]}, "triangles: an array of type float64"),
        ({"triangles": [[0, 1, -1]]}, "triangles: the number -1"),
        ({"sides": {"bottom": [0, 1]}}, "sides['bottom']: the shape is (2,)"),
        ({"regions": {"all": [[0, 1]]}}, "regions['all']: the shape is (1, 2)"),
        ({"regions": {"all": [True, False]}}, "regions['all']: an array of type bool"),
    ],
)
def test_arrays_of_a_mesh(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(nndd.InvalidInput) as caught:
        square(**changes)
    assert words in str(caught.value)
    assert caught.value.expected
    assert caught.value.fix
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"triangles": [[0, 1, 9]]}, "triangle 0 has the node 9"),
        ({"triangles": [[0, 1, 1]]}, "triangle 0 has the node 1 twice"),
        ({"triangles": [[0, 1, 2], [0, 1, 2]]}, "edge"),
        ({"points": [[0, 0], [1, 0], [2, 0], [0, 1]]}, "has no area"),
        ({"points": [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]}, "not plane"),
        ({"sides": {"bottom": [[0, 1]], "top": [[1, 3]]}}, 'side "top" has the edge between nodes 1 and 3'),
        ({"sides": {"bottom": [[0, 1]]}}, 'there is no edge group "top"'),
        ({"sides": {}}, "has no named side"),
        ({"regions": {"a": [5]}}, 'region "a" has the triangle 5'),
        ({"triangles": np.zeros((0, 3), dtype=int), "sides": {}}, "no 2D elements"),
        ({"triangles": [[0, 1, 2**40]]}, "has the node 1099511627776"),
    ],
)
def test_meshes_that_make_no_sense(changes: dict[str, Any], words: str) -> None:
    error = refused(body(square(**changes)))
    assert isinstance(error, nndd.InvalidInput)
    assert words in str(error)


@pytest.mark.parametrize(
    ("uy", "words"),
    [
        (np.zeros(3), "an array of 3 values"),
        (np.zeros((28, 1)), "an array of 28 entries, and entry 0 is an array"),
        (np.full(28, NAN), "NaN"),
        (np.full(28, "a"), 'entry 0 is the string "a"'),
        (lambda x, y: x[:-1], "the function returns the shape (6,)"),
        (lambda x, y: np.log(x - 1e3), "is nan at"),
        (lambda x, y: None, "an array of type object"),
        (lambda x, y: x + 0j, "an array of type complex128"),
        ("0.1 * z", "z"),
        (object(), "a value of type object"),
        (NAN, "NaN"),
        (b"0.1", "a value of type bytes"),
    ],
)
def test_data(uy: Any, words: str) -> None:
    problem = blocks()
    problem.bodies[0]._lists["displacement"][0]["uy"] = uy
    with np.errstate(invalid="ignore"):
        error = refused(problem)
    assert words in str(error)
    assert isinstance(error, nndd.InvalidInput)
    assert error.place is not None
    assert error.place.startswith("body.0.displacement.0")


def test_functions_have_their_places() -> None:
    case = blocks().to_dict()
    case["body"][0]["body_force"] = [lambda x, y: x, 0.0]
    error = refused(case)
    assert (error.place, error.expected) == ("body.0.body_force", "a number, or an expression in x and y")
    # A function becomes values at the nodes of a side, and this acts inside.
    assert "takes no values at nodes" in error.found
    both = blocks()
    both.bodies[0].load("left", vector=lambda x, y: x)  # type: ignore[arg-type]
    error = refused(both)
    assert (error.place, error.expected) == ("body.0.traction.0.vector", "an array of two numbers")


def test_what_a_function_raises_passes_through() -> None:
    class Own(Exception):
        pass

    def raising(x: Any, y: Any) -> Any:
        raise Own("my fault")

    with pytest.raises(Own, match="my fault"):
        blocks(gap=raising).solve()
    # The next solve is a new one.
    assert blocks(gap=lambda x, y: 0.0 * x).solve().valid


def test_data_for_a_mesh_file_need_a_mesh() -> None:
    case = {
        "schema": 1,
        "materials": {"m": {"young": 1.0, "poisson": 0.3}},
        "body": [
            {
                "name": "a",
                "material": "m",
                "mesh": {"file": "tests/cases/meshes/blocks.msh", "region": "upper"},
                "displacement": [{"on": "upper.top", "fixed": True}],
                "traction": [{"on": "upper.left", "pressure": np.zeros(5)}],
            }
        ],
        "contact": [],
    }
    error = refused(case)
    assert "Mesh.read" in str(error.fix)
    case["body"][0]["traction"][0]["pressure"] = lambda x, y: 1.0 + 0 * x  # type: ignore[index]
    assert nndd.solve(case).valid


def test_places_are_keys() -> None:
    problem = blocks().to_dict()
    problem["body"][1]["displacement"][0]["on"] = "botom"
    error = refused(problem)
    assert (error.place, error.code) == ("body.1.displacement.0.on", 3)
    assert "botom" in error.found
    assert error.fix == 'did you mean "bottom"?'
    problem = blocks().to_dict()
    problem["body"][0]["colour"] = "red"
    problem["materials"]["material1"]["young"] = -1
    error = refused(problem)
    assert {finding["place"] for finding in error.findings} == {"body.0.colour", "materials.material1.young"}
    assert refused(blocks(), solver__theta=-1).place == "solver.theta=-1"
    assert refused(blocks(), solver__theat=1).place == "solver.theat=1"
    place = refused(CASES / "bad" / "adapt_fraction.toml").place
    assert place is not None
    assert "adapt_fraction.toml:" in place


@pytest.mark.filterwarnings("ignore::nndd.CaseWarning")
@pytest.mark.parametrize("file", sorted((CASES / "bad").glob("*.toml")), ids=lambda file: file.stem)
def test_bad_cases_end_as_the_command_ends(file: Path) -> None:
    """The first line of each names the exit status; the second the words, of the failure or of the status."""
    first = file.read_text().splitlines()[0]
    expected = int(next(word for word in first.replace(":", " ").split() if word.isdigit()))
    try:
        found = nndd.solve(file).status.code
    except nndd.Error as error:
        found = error.code if error.found else -1
    assert found == expected


def test_the_time_limit_ends_work_that_has_no_result() -> None:
    def block(name: str, x: int, y: int, size: list[int], cells: list[int], held: dict[str, Any]) -> dict[str, Any]:
        made = {"kind": "block", "origin": [x, y], "size": size, "cells": cells}
        return {"name": name, "material": "a", "generator": made, "displacement": [held]}

    # Too many to be read and built within a second.
    count = 20_000
    names = [f"b{k}" for k in range(count)]
    small = [block(name, 2 * k, 1, [1, 1], [2, 1], {"on": "left", "ux": 0.0}) for k, name in enumerate(names)]
    base = block("base", 0, 0, [2 * count, 1], [2 * count, 1], {"on": "bottom", "fixed": True})
    case = {
        "schema": 1,
        "materials": {"a": {"young": 1000.0, "poisson": 0.2}},
        "body": [base, *small],
        "contact": [{"bodies": [name, "base"], "surfaces": ["bottom", "top"]} for name in names],
        "limits": {"time": "0.001s"},
    }
    with pytest.raises(nndd.LimitReached, match="in making the bodies"):
        nndd.check(case)


def test_failures_have_their_classes() -> None:
    problem = blocks()
    problem.bodies[1]._lists.clear()
    problem.bodies[1].load("right", (1, 0))
    assert isinstance(refused(problem), nndd.NotSolvable)
    error = refused(Path("no/such.toml"))
    assert isinstance(error, nndd.FileError)
    assert isinstance(error, OSError)
    assert (error.code, error.place) == (7, None)
    assert isinstance(refused(blocks(), limits__memory="1MiB"), nndd.LimitReached)
    with pytest.raises(nndd.FileError):
        nndd.Mesh.read("no/such.msh")
    with pytest.raises(nndd.InvalidInput, match="MSH 1, 2 or 4"):
        nndd.Mesh.read(CASES / "paper.toml")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.found, again.code) == (type(error), error.found, error.code)


def test_arguments() -> None:
    with pytest.raises(nndd.InvalidInput, match="a path, a dict or a Problem"):
        nndd.solve(3)  # type: ignore[arg-type]
    for threads in (0, -1, 1.5, True, 5000):
        assert "threads" in str(refused(blocks(), threads=threads))
    steel = nndd.Material(1.0, 0.3)
    with pytest.raises(nndd.InvalidInput, match="a Mesh"):
        nndd.Body("a.msh", steel)  # type: ignore[arg-type]
    with pytest.raises(nndd.InvalidInput, match="a Material"):
        nndd.Body(square(), "steel")  # type: ignore[arg-type]
    with pytest.raises(nndd.InvalidInput, match=r"Friction\.coulomb"):
        blocks(friction=0.3)
    stranger = nndd.Body(square(), steel, "stranger")
    problem = blocks()
    problem.contacts.append(nndd.Contact(problem.bodies[0], stranger, ("left", "top")))
    assert "is not a body of the problem" in str(refused(problem))
    with pytest.raises(ValueError, match="read-only"):
        square().points[0, 0] = 3.0


def test_a_directory_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    solution = blocks().solve()
    with pytest.raises(nndd.FileError, match=r"mine\.txt") as caught:
        solution.save(tmp_path)
    # Arguments of the package, not options of the command.
    assert "force=True" in str(caught.value)
    assert "--" not in str(caught.value)
    solution.save(tmp_path, force=True)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_fields_to_certify() -> None:
    problem = blocks()
    zeros = [np.zeros((28, 2)), np.zeros((28, 2))]
    for wrong, words in (
        ([zeros[0]], "found 1, and the case has 2"),
        ([zeros[0], np.zeros((27, 2))], "found 27, and the case has 28"),
        ([zeros[0], np.zeros((28, 3))], "rows of 3 numbers"),
        ([zeros[0], np.full((28, 2), NAN)], "nan"),
        ([zeros[0], np.zeros((28, 2), dtype=complex)], "complex128"),
    ):
        with pytest.raises(nndd.InvalidInput) as caught:
            nndd.certify(problem, wrong)
        assert words in str(caught.value)
    with pytest.raises(nndd.InvalidInput, match="found 2, and the case has 1"):
        nndd.certify(problem, zeros, [np.zeros(28), np.zeros(28)])
    with pytest.raises(nndd.InvalidInput, match="friction"):
        nndd.certify(blocks(friction=nndd.Friction.tresca(1.0)), zeros)


def test_masks_are_refused() -> None:
    masked = np.ma.masked_array(POINTS, mask=[[False, False], [True, False], [False, False], [False, False]], dtype=float)
    with pytest.raises(nndd.InvalidInput, match="a masked array"):
        square(points=masked)
    with pytest.raises(nndd.InvalidInput, match="a masked array"):
        square(triangles=np.ma.masked_array(TRIANGLES, mask=False))
    problem = blocks()
    for hidden in (np.ma.masked_array(np.zeros(28), mask=True), np.ma.masked_array(np.zeros(28))):
        problem.bodies[0]._lists["displacement"][0]["uy"] = hidden
        assert "a masked array" in str(refused(problem))
    with pytest.raises(nndd.InvalidInput, match="a masked array"):
        nndd.solve(CASES / "paper.toml", body__0__generator__cells=np.ma.masked_array([36, 18], mask=[True, False]))
    solution = blocks().solve()
    fields = [np.ma.masked_array(body.displacement) for body in solution.bodies]
    with pytest.raises(nndd.InvalidInput, match="a masked array"):
        nndd.certify(blocks(), fields)
    with pytest.raises(nndd.InvalidInput, match="a masked array"):
        blocks(gap=lambda x, y: np.ma.masked_array(0.0 * x, mask=x > 0.5)).solve()


def test_every_wrong_argument_is_an_error_of_the_package(tmp_path: Path) -> None:
    case = CASES / "paper.toml"
    circle: dict[str, Any] = {"schema": 1}
    circle["body"] = [circle]
    rings: list[Any] = []
    rings += [rings, rings]
    solution = blocks().solve()
    wrong: list[Any] = [
        lambda: nndd.solve(case, on_iteration=5),  # type: ignore[arg-type]
        lambda: nndd.solve({"schema": 1, "title": "\ud800"}),
        lambda: nndd.solve(circle),
        lambda: nndd.solve({"schema": 1, "body": rings}),
        lambda: nndd.solve(case, title=rings),
        lambda: nndd.solve({"schema": np.longdouble(2.0)}),
        lambda: nndd.solve(case, title=len),
        lambda: nndd.solve({"schema": np.ma.masked}),
        lambda: nndd.solve(case, threads=10**30),
        lambda: nndd.solve(case, solver__theta=10**400),
        lambda: nndd.solve(case, title="\ud800"),
        lambda: nndd.solve(5),  # type: ignore[arg-type]
        lambda: nndd.solve("a\0b"),
        lambda: nndd.check(None),  # type: ignore[arg-type]
        lambda: nndd.sweep(case, 5),  # type: ignore[arg-type]
        lambda: nndd.sweep(case, "solver.theta=[0.4]", iterations="3"),  # type: ignore[arg-type]
        lambda: nndd.sweep(case, "solver.theta=[0.4]", iterations=-1),
        lambda: nndd.sweep(case, "solver.theta=[0.4]", panels=5),  # type: ignore[arg-type]
        lambda: nndd.sweep(case, "solver.theta=[0.4]", panels=[5]),  # type: ignore[list-item]
        lambda: nndd.certify(blocks(), 5),  # type: ignore[arg-type]
        lambda: nndd.certify(blocks(), None),  # type: ignore[arg-type]
        lambda: nndd.certify(blocks(), [np.zeros((28, 2))] * 2, 7),  # type: ignore[arg-type]
        lambda: nndd.Mesh.read(5),  # type: ignore[arg-type]
        lambda: solution.save(5),  # type: ignore[arg-type]
        lambda: solution.save(tmp_path, force="yes"),  # type: ignore[arg-type]
    ]
    for number, ask in enumerate(wrong):
        with pytest.raises(nndd.Error) as caught:
            ask()
        assert caught.value.expected, number


def test_what_a_callback_raises_passes_through() -> None:
    def raising(event: dict[str, Any]) -> None:
        raise ValueError("mine")

    with pytest.raises(ValueError, match=r"^mine$") as caught:
        blocks().solve(on_iteration=raising)
    assert not isinstance(caught.value, nndd.Error)
