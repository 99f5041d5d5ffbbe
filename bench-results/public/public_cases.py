#!/usr/bin/env python3
"""Solves contact problems of other projects' tests and compares values that these projects publish.

    python3 public_cases.py --nndd target/release/nndd --files FILES --work runs/public --out bench-results/public [CASE ...]

FILES is a folder with the meshes that `MESHES` names, taken from the repositories there; none is in this one. Those of ESPRESO come from its
generator: `write_grid` makes them again. Needs Python 3 and nothing else. Writes public.csv to --out and a table to the console.
"""

import argparse
import csv
import json
import math
import re
import shutil
import struct
import subprocess
import time
from pathlib import Path

HERE = Path(__file__).parent
PATCH = "modules/contact/test/tests/verification/patch_tests"
# The mesh of each case: repository, path.
MESHES = {
    **{f"brick{k}_mesh.e": ("aeslaughter/moose", f"{PATCH}/brick_{k}/brick{k}_mesh.e") for k in (1, 2, 3, 4)},
    "hertz_contact.e": ("aeslaughter/moose", "modules/contact/test/tests/hertz_spherical/hertz_contact.e"),
    "cubes.msh": ("ElmerCSC/elmerfem", "fem/tests/ContactPatch3D/cubes.msh"),
    "cube-1.g": ("sandialabs/Norma.jl", "examples/contact/static/cubes/cube-1.g"),
    "cube-2.g": ("sandialabs/Norma.jl", "examples/contact/static/cubes/cube-2.g"),
    "punch1.inp": ("Dhondtguido/CalculiX", "test/punch1.inp"),
}


def write_grid(path, low, size, cells, place):
    """Writes a box of cells, six tetrahedra each around the diagonal from (1, 1, 0) to (0, 0, 1), with sides x0 to z1.

    `place` moves each node of the box."""
    counts = [n + 1 for n in cells]
    number = lambda i, j, k: 1 + i + counts[0] * (j + counts[1] * k)
    every = [(i, j, k) for k in range(counts[2]) for j in range(counts[1]) for i in range(counts[0])]
    lines = ["*NODE"]
    for at in every:
        x = place(*(low[a] + size[a] * at[a] / cells[a] for a in range(3)))
        lines.append(", ".join([str(number(*at)), *map(repr, x)]))
    lines.append("*ELEMENT, TYPE=C3D4, ELSET=body")
    count = 0
    for i, j, k in every:
        if i == cells[0] or j == cells[1] or k == cells[2]:
            continue
        for order in ("xyz", "xzy", "yxz", "yzx", "zxy", "zyx"):
            corner = [i, j, k + 1]
            corners = [number(*corner)]
            for axis in order:
                a = "xyz".index(axis)
                corner[a] += -1 if axis == "z" else 1
                corners.append(number(*corner))
            count += 1
            lines.append(", ".join(map(str, [count, *corners])))
    for a, axis in enumerate("xyz"):
        for end, where in ((0, 0), (1, cells[a])):
            lines += [f"*NSET, NSET={axis}{end}", *(f"{number(*at)}," for at in every if at[a] == where)]
    path.write_text("\n".join(lines) + "\n")


def write_espreso(folder):
    """Writes the grids of both cases, with the numbers of cells of their tests."""
    same = lambda x, y, z: (x, y, z)
    bowl = lambda x, y, z: (x + 0.2, y + 0.2, z + (x * x + y * y) * (2 - z) * 0.2)
    write_grid(folder / "espreso_hertz_bottom.inp", (0, 0, 0), (1, 1, 1), (10, 10, 10), same)
    write_grid(folder / "espreso_hertz_up.inp", (0, 0, 1), (1, 1, 1), (18, 18, 18), bowl)
    write_grid(folder / "espreso_beams_bottom.inp", (-0.5, -2.1, 0), (1, 5, 1), (4, 16, 4), same)
    write_grid(folder / "espreso_beams_up.inp", (-0.5, 0, 1), (1, 5, 1), (3, 16, 3), lambda x, y, z: (x, y, z + 0.1))


def field(path, name):
    """Reads the vectors of an array of points, `Points` for their places, from a .vtu file that nndd wrote."""
    data = path.read_bytes()
    start = data.index(b'<AppendedData encoding="raw">')
    start = data.index(b"_", start) + 1
    header = data[:start].decode("ascii", "replace")
    entry = re.search(rf'<DataArray [^>]*Name="{name}"[^>]*>', header)[0]
    at = start + int(re.search(r'offset="(\d+)"', entry)[1])
    (length,) = struct.unpack_from("<Q", data, at)
    values = struct.unpack_from(f"<{length // 8}d", data, at + 8)
    return [values[k : k + 3] for k in range(0, len(values), 3)]


class Run:
    """The results of a case."""

    def __init__(self, folder, seconds):
        self.folder, self.seconds = folder, seconds
        self.report = json.loads((folder / "report.json").read_text())
        self.results = self.report["results"]

    def displacements(self, body):
        path = self.folder / f"{body}.vtu"
        return zip(field(path, "Points"), field(path, "displacement"))

    def at(self, body, place):
        """Returns the displacement of the node nearest to a place."""
        return min(self.displacements(body), key=lambda node: math.dist(node[0], place))[1]

    def largest(self, body, axis):
        return max(u[axis] for _, u in self.displacements(body))

    def nodes(self):
        return sum(body["nodes"] for body in self.report["bodies"])


def elmer_norm(run):
    """Returns Elmer's norm, the root of the mean square over all components, of the linear field at the nodes of its refined mesh."""
    strain = [u / x for u, x in zip(run.at("upper", (0.0, 0.0, 2.0)), (-1.0, -1.0, 2.0))]
    total = count = 0
    for cells, low in ((8, 0.0), (6, 1.0)):
        steps = [k / cells for k in range(cells + 1)]
        squares = [sum(((s - 1) * strain[a]) ** 2 for s in steps) for a in (0, 1)]
        squares.append(sum(((low + s) * strain[2]) ** 2 for s in steps))
        total += sum(squares) * len(steps) ** 2
        count += 3 * len(steps) ** 3
    return math.sqrt(total / count)


def force(run):
    return run.results["contact_force"]


# Title, case, what --set gives, what is compared, the published value, and how ours is read.
ROWS = [
    *((f"MOOSE brick_{k}", "moose_brick", [f'body.{b}.mesh.file="brick{k}_mesh.e"' for b in (0, 1)], what, value, ours)
      for k in (1, 2, 3, 4)
      for what, value, ours in (
          ("pressure", 109.89724572635, lambda r: r.results["max_pressure"]),
          ("u_y of the top", -1.0988396e-4, lambda r: r.at("top", (1, 1, 1))[1]))),
    ("MOOSE hertz_spherical", "moose_hertz", [], "force of the ball (4 quarters), u_y = -0.005", 10000.0, lambda r: 4 * force(r)),
    ("ESPRESO hertz", "espreso_hertz", [], "largest displacement", 4.748130e-2, lambda r: r.results["max_displacement"]),
    ("ESPRESO beams", "espreso_beams", [], "largest displacement", 0.1233770, lambda r: r.results["max_displacement"]),
    ("code_aster ssnv104i", "aster_ssnv104i", [], "largest pressure, Hertz", 2798.3, lambda r: r.results["max_pressure"]),
    ("code_aster ssnv104i", "aster_ssnv104i", [], "its own stress at the pole", 3127.4064765192, lambda r: r.results["max_pressure"]),
    ("code_aster ssnv167a", "aster_ssnv167a", [], "u_z of the upper face in contact", -0.1, lambda r: r.at("upper", (2, 0, 2))[2]),
    ("code_aster ssnv167a", "aster_ssnv167a", [], "force of four nodes", 40000.0, force),
    ("Elmer ContactPatch3D", "elmer_patch3d", [], "norm of the displacements", 6.693448e-3, elmer_norm),
    ("Norma.jl cubes", "norma_cubes", [], "sigma_xx", -1e8, lambda r: -force(r)),
    ("Norma.jl cubes", "norma_cubes", [], "largest u_y", 0.025, lambda r: r.largest("fine", 1)),
    ("CalculiX punch1", "calculix_punch1", [], "u_z at node 209, after the fall", -6.527236e-4,
     lambda r: r.at("punch", (0.69134, 0.0, 1.38268))[2] + 0.004277933466),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nndd", required=True)
    parser.add_argument("--files", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("cases", nargs="*", help="names of cases; all if none is given")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    for name, (repository, path) in MESHES.items():
        if not (given.files / name).exists():
            parser.error(f"there is no {given.files / name}: it is {path} in the repository {repository}")
        shutil.copy(given.files / name, given.work / name)
    write_espreso(given.work)
    runs, table = {}, []
    for title, case, settings, what, published, ours in ROWS:
        if given.cases and case not in given.cases:
            continue
        if (title, case) not in runs:
            shutil.copy(HERE / f"{case}.toml", given.work)
            folder = given.work / title.replace(" ", "-")
            words = [word for setting in settings for word in ("--set", setting)]
            start = time.monotonic()
            done = subprocess.run([given.nndd, "solve", given.work / f"{case}.toml", "--out", folder, "--force", "--quiet", *words])
            if done.returncode not in (0, 6):
                parser.error(f"{case} ended with {done.returncode}")
            runs[title, case] = Run(folder, time.monotonic() - start)
        run = runs[title, case]
        value = ours(run)
        bound = run.report["certificate"]
        table.append([title, what, f"{published:.7g}", f"{value:.7g}", f"{100 * (value / published - 1):+.2g} %",
                      f"{100 * bound['relative']:.2g} %" if bound["valid"] else "not valid", run.nodes(), f"{run.seconds:.1f}"])
    head = ["problem", "value", "published", "ours", "difference", "certified error", "nodes", "seconds"]
    with (given.out / "public.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *table])
    for row in [head, ["---"] * len(head), *table]:
        print("| " + " | ".join(map(str, row)) + " |")


if __name__ == "__main__":
    main()
