"""Write the decks of `tests/cases/solid/meshes`: `python crates/nndd-python/tests/decks.py`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[3] / "tests" / "cases" / "solid" / "meshes"
Cell = tuple[int, int, int]


def bricks(cells: Iterable[Cell], size: tuple[float, float, float], elset: str, kind: str = "C3D8") -> str:
    """Number the corners of bricks on a grid, and write nodes and elements."""
    at = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    corners = [[(i + a, j + b, k + c) for a, b, c in at] for i, j, k in cells]
    numbers = {place: n for n, place in enumerate(sorted({place for of in corners for place in of}), 1)}
    lines = ["*NODE"]
    for place, n in numbers.items():
        lines.append(", ".join([str(n), *(f"{index * length:g}" for index, length in zip(place, size))]))
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET={elset}")
    lines += [", ".join(map(str, [n, *(numbers[place] for place in of)])) for n, of in enumerate(corners, 1)]
    return "\n".join(lines) + "\n"


def grid(across: int, deep: int, high: int) -> list[Cell]:
    """List the bricks of a block."""
    return [(i, j, k) for k in range(high) for j in range(deep) for i in range(across)]


def bracket() -> str:
    """Half of a bracket: a foot 3 long, 1 deep and 0.5 high, and a wall 0.5 thick and 2.5 high at its left end."""
    cells = grid(6, 2, 1) + [(0, j, k) for k in range(1, 5) for j in range(2)]
    return "** Half of a bracket, in bricks of the length 0.5.\n" + bricks(cells, (0.5, 0.5, 0.5), "bracket")


def tilted() -> str:
    """Two blocks of other divisions on top of each other, turned by 30 degrees about the y axis."""
    text = "** Two blocks, the upper one in other divisions, turned by 30 degrees about the y axis.\n"
    for part, cells, size in (("lower", grid(2, 2, 1), (1.0, 0.5, 1.0)), ("upper", grid(5, 1, 1), (0.4, 1.0, 1.0))):
        text += f"*PART, NAME={part}\n{bricks(cells, size, part)}*END PART\n"
    text += "*ASSEMBLY, NAME=pair\n*INSTANCE, NAME=below, PART=lower\n0, 0, 0\n0, 0, 0, 0, 1, 0, 30\n*END INSTANCE\n"
    # A point at height 1 is turned to (sin 30°, cos 30°), where the upper block begins.
    x, z = "0.5", "0.86602540378443865"
    text += f"*INSTANCE, NAME=above, PART=upper\n{x}, 0, {z}\n{x}, 0, {z}, {x}, 1, {z}, 30\n"
    return text + "*END INSTANCE\n*END ASSEMBLY\n"


#: The contents of each file.
DECKS = {"bracket.inp": bracket, "tilted.inp": tilted}

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, write in DECKS.items():
        (FOLDER / name).write_text(write(), encoding="utf-8")
