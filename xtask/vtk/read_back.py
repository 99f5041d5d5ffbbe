"""Reads the ParaView files of a run back by VTK and by meshio, and compares them with report.json.

    read_back.py OUTPUT_DIRECTORY [PICTURE]

Prints one line per file and ends with status 1 where anything differs by more than round-off.
"""

import itertools
import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

POINT = {"displacement": 3, "reaction": 3, "stress_recovered": 6}
WHOLE = {"material_id", "element_id", "body_id", "active"}
CELL = {
    "stress": 6, "stress_equilibrated": 6, "strain": 6, "error_density": 1, "error_density_mesh": 1,
    "error_density_iteration": 1, "material_id": 1, "element_id": 1, "body_id": 1,
}
CONTACT = {
    "gap", "opening", "contact_pressure", "contact_pressure_recovered", "active", "lambda", "traction_1", "traction_2", "traction_imbalance",
}
ROUND_OFF = 1e-9


class Grid:
    """One file as both readers see it; they must agree exactly."""

    def __init__(self, path, corners):
        self.path = path
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
        self.points = vtk_to_numpy(grid.GetPoints().GetData())
        self.cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
        self.point, self.cell, self.field = (
            {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
            for data in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData())
        )
        other = meshio.read(path)
        self.expect(np.array_equal(other.points, self.points), "points differ between the readers")
        self.expect(np.array_equal(other.cells[0].data, self.cells), "cells differ between the readers")
        for name, values in self.point.items():
            self.expect(np.array_equal(other.point_data[name], values), f"{name} differs between the readers")
        for name, values in self.cell.items():
            self.expect(np.array_equal(other.cell_data[name][0], values), f"{name} differs between the readers")

    def expect(self, true, what):
        if not true:
            raise SystemExit(f"{self.path}: {what}")

    def equal(self, found, expected, what, noise=0.0):
        """Compares to round-off, and no closer than `noise`, the round-off of what they are differences of."""
        same = abs(found - expected) <= ROUND_OFF * max(abs(expected), abs(found)) + noise
        self.expect(same, f"{what}: found {found!r}, report.json says {expected!r}")

    def shaped(self, arrays, names, rows):
        for name, components in names.items():
            self.expect(name in arrays, f"no field {name}")
            size = arrays[name].shape
            self.expect(size == ((rows,) if components == 1 else (rows, components)), f"{name} has shape {size}")
            self.expect(np.isfinite(arrays[name]).all(), f"{name} is not finite everywhere")
            whole = np.issubdtype(arrays[name].dtype, np.integer)
            self.expect(whole == (name in WHOLE), f"{name} is of type {arrays[name].dtype}")


def body(path, nodes, triangles):
    grid = Grid(path, 3)
    grid.expect(grid.points.shape == (nodes, 3) and not grid.points[:, 2].any(), "wrong points")
    grid.expect(grid.cells.shape == (triangles, 3), "wrong cells")
    grid.shaped(grid.point, POINT, nodes)
    grid.shaped(grid.cell, CELL, triangles)
    return grid


def contact_files(folder, report):
    """The file of each pair: that of the only one has no name."""
    pairs = report["contact"]
    if len(pairs) == 1:
        return [folder / "contact.vtu"]
    return [folder / f"contact-{pair['name'].replace(' ', '_')}.vtu" for pair in pairs]


def files_of_bodies(folder, report):
    """The files of the bodies by number: a body's name may hold what a file's cannot."""
    lines = set(contact_files(folder, report))
    paths = [path for path in sorted(folder.glob("*.vtu")) if path not in lines]
    return {int(Grid(path, 3).cell["body_id"][0]): path for path in paths}


def gradients(grid):
    """Areas, and the gradients of the three hat functions on each triangle."""
    p = grid.points[grid.cells][:, :, :2]
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    opposite = np.stack([p[:, 2] - p[:, 1], p[:, 0] - p[:, 2], p[:, 1] - p[:, 0]], axis=1)
    turned = np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1)
    return 0.5 * np.abs(twice), turned / twice[:, None, None]


def energy(grid):
    """a(u, u) from the file alone: stress times the strain of the displacement."""
    areas, hats = gradients(grid)
    u = grid.point["displacement"][grid.cells][:, :, :2]
    g = np.einsum("tkc,tkd->tcd", u, hats)
    s = grid.cell["stress"]
    return float(np.sum(areas * (s[:, 0] * g[:, 0, 0] + s[:, 1] * g[:, 1, 1] + s[:, 3] * (g[:, 0, 1] + g[:, 1, 0]))))


def check(folder, report):
    certificate, results = report["certificate"], report["results"]
    # With Coulomb friction there is a residual in place of the bound.
    name, size = ("e_cre", certificate["e_cre"]) if certificate else ("e_b", report["coulomb"]["e_b"])
    grids = []
    files = files_of_bodies(folder, report)
    # A body without load has the energy of round-off.
    noise = ROUND_OFF * max(results["energy_norm_squared"])
    for k, summary in enumerate(report["bodies"]):
        if k not in files:
            raise SystemExit(f"{folder}: no file has the body {k}, {summary['name']!r}")
        grid = body(files[k], summary["nodes"], summary["triangles"])
        grid.equal(float(grid.field[name][0]), size, name)
        grid.equal(float(grid.field["iteration"][0]), report["iterations"][-1]["iteration"], "iteration")
        grid.equal(energy(grid), results["energy_norm_squared"][k], "energy norm squared", noise)
        grids.append(grid)
        print(f"{grid.path.name}: {len(grid.points)} points, {len(grid.cells)} triangles, energy as in report.json")
    largest = max(np.linalg.norm(g.point["displacement"], axis=1).max() for g in grids)
    grids[0].equal(float(largest), results["max_displacement"], "largest displacement")
    if results["max_von_mises"] is not None:
        largest = max(g.cell["von_mises"].max() for g in grids)
        grids[0].equal(float(largest), results["max_von_mises"], "largest von Mises stress")
    if results["peak_stress"] is not None:
        largest = max(g.point["von_mises_recovered"].max() for g in grids)
        grids[0].equal(float(largest), results["peak_stress"]["von_mises"], "largest recovered von Mises stress")
    for grid in grids:
        stress, strain = grid.cell["stress"], grid.cell["strain"]
        pairs = stress * strain * np.array([1, 1, 1, 2, 2, 2])
        k = int(grid.cell["body_id"][0])
        grid.equal(float(np.sum(gradients(grid)[0] * pairs.sum(axis=1))), results["energy_norm_squared"][k], "strain", noise)

    lines = [check_line(path, pair) for path, pair in zip(contact_files(folder, report), report["contact"])]
    if lines:
        force = sum(force for force, _ in lines)
        grids[0].equal(force, results["contact_force"], "contact force of all pairs")
    # The squared bound, or residual, less the allowance for round-off: the cells' part, and 2 integral p o along the contact lines.
    line = sum(line for _, line in lines)
    first = grids[0]
    round_off = float(first.field["round_off"][0])
    squared = (size - round_off) ** 2
    for names in (["error_density"], ["error_density_mesh", "error_density_iteration"]):
        inside = sum(float(np.sum(gradients(g)[0] * g.cell[name])) for g in grids for name in names)
        first.equal(inside + line, squared, f"squared {name} from {' and '.join(names)}", round_off**2)
    first.expect(float(first.field["certified"][0]) == float(bool(certificate) and certificate["valid"]), "certified")
    return grids


def check_line(path, pair):
    """The contact line of one pair; returns its force, and its part of the squared bound."""
    contact = Grid(path, 2)
    contact.expect(CONTACT <= contact.point.keys(), f"fields {sorted(contact.point)}")
    # The end of a line whose node is held on both sides is drawn, and is no pair.
    contact.expect(pair["pairs"] <= len(contact.points) <= pair["pairs"] + 2, "wrong number of pairs")
    length = np.linalg.norm(np.diff(contact.points[contact.cells], axis=1)[:, 0], axis=1)
    contact.equal(float(length.sum()), pair["length"], "length of the contact line")
    contact.expect(bool((contact.point["gap"] >= 0.0).all()), "a negative initial gap")
    contact.equal(float(contact.point["opening"].min()), pair["min_opening"], "smallest opening")
    contact.equal(float(contact.point["contact_pressure"].max()), pair["max_pressure"], "largest pressure")
    tributary = np.zeros(len(contact.points))
    np.add.at(tributary, contact.cells, 0.5 * length[:, None])
    forces = tributary * contact.point["contact_pressure"]
    ends = np.flatnonzero(np.bincount(contact.cells.ravel()) == 1)
    # The support takes the force at a held end.
    held = itertools.combinations(ends, len(contact.points) - pair["pairs"])
    sums = [float(np.sum(np.delete(forces, list(nodes)))) for nodes in held]
    force = min(sums, key=lambda found: abs(found - pair["contact_force"]))
    contact.equal(force, pair["contact_force"], "contact force")
    print(f"{path.name}: {len(contact.points)} points, contact force {force:.6g} as in report.json")
    return force, float(np.sum(length * contact.cell["error_density"]))


def check_series(folder, report):
    """The collections of an adaptive run: every mesh of every body, with the nodes that the history counts, and the
    contact line of each with its pairs."""
    nodes, pairs = {}, {}
    files = set()
    for entry in ElementTree.parse(folder / "adaptive.pvd").getroot().iter("DataSet"):
        line = entry.get("name").startswith("contact")
        grid = Grid(folder / entry.get("file"), 2 if line else 3)
        if not line:
            grid.shaped(grid.point, POINT, len(grid.points))
        step = int(float(entry.get("timestep")))
        grid.expect(float(grid.field["TimeValue"][0]) == step, "wrong TimeValue")
        counted = pairs if line else nodes
        counted[step] = counted.get(step, 0) + len(grid.points)
        files.add((entry.get("file"), float(step)))
    expected = {row["step"]: row["nodes"] for row in report["adaptive"]}
    if nodes != expected:
        raise SystemExit(f"{folder}/adaptive.pvd: found nodes {nodes}, report.json says {expected}")
    if pairs != {row["step"]: row["pairs"] for row in report["adaptive"] if row["pairs"]}:
        raise SystemExit(f"{folder}/adaptive.pvd: found pairs {pairs}")
    series = [json.loads(path.read_text()) for path in sorted(folder.glob("*.vtu.series"))]
    if len(series) != len(report["bodies"]) + len(report["contact"]) or files != {(file["name"], file["time"]) for part in series for file in part["files"]}:
        raise SystemExit(f"{folder}: the .vtu.series files do not name the files of adaptive.pvd")
    print(f"adaptive.pvd: {len(expected)} meshes, nodes and pairs as in report.json")


def draw(grids, picture):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    size = max(np.ptp(np.concatenate([g.points for g in grids]), axis=0))
    largest = max(np.linalg.norm(g.point["displacement"], axis=1).max() for g in grids)
    factor = 10.0 ** np.floor(np.log10(0.1 * size / largest))
    figure, axes = plt.subplots(figsize=(7.2, 4.6), constrained_layout=True)
    top = max(g.cell["von_mises"].max() for g in grids)
    for grid in grids:
        moved = grid.points[:, :2] + factor * grid.point["displacement"][:, :2]
        drawn = axes.tripcolor(
            *moved.T, grid.cells, facecolors=grid.cell["von_mises"], cmap="viridis", vmin=0.0, vmax=top,
            edgecolors="#ffffff59", linewidth=0.2,
        )
    figure.colorbar(drawn, label="von Mises stress", shrink=0.85)
    axes.set(aspect="equal", xlabel="x", ylabel="y")
    axes.set_title(f"Read from upper.vtu and lower.vtu by VTK, displacements × {factor:g}", fontsize=10)
    figure.savefig(picture, dpi=110)
    print(f"wrote {picture}")


if __name__ == "__main__":
    directory = Path(sys.argv[1])
    said = json.loads((directory / "report.json").read_text())
    read = check(directory, said)
    if said["adaptive"]:
        check_series(directory, said)
    if len(sys.argv) > 2:
        draw(read, sys.argv[2])
