"""Certificates for fields of CalculiX and scikit-fem on the paper's problem, beside their true errors.

certify_other_codes.py NNDD WORK [NXxNY ...]     NNDD: the program; WORK: a directory for files; default 18x9 36x18 80x36

Needs numpy, scipy, scikit-fem, meshio, and `ccx` on the path. The true error is the energy norm of the difference to a
solution by NNDD on a finer mesh, in which the given one is nested. Prints the tables as Markdown and writes WORK/certify.csv.
"""

import csv
import json
import math
import os
import pathlib
import subprocess
import sys

import meshio
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import active_set
import calculix
import paper

HERE = pathlib.Path(__file__).resolve().parent
CASE = pathlib.Path(os.environ.get("NNDD_CASE", HERE / "../../tests/cases/paper.toml"))
# Slope of the penalty, over the stiffer modulus.
PENALTIES = (10, 100, 500, 5000)
# How many times finer the reference is, per direction.
FINER = {(18, 9): 32}
FINER_ELSE = 16
BODIES = ("upper", "lower")


def cells(nx, ny):
    """Options that give both bodies so many cells."""
    return [x for b in (0, 1) for x in ("--set", f"body.{b}.generator.cells=[{nx},{ny}]")]


def on_grid(nx, ny, upper, points, values):
    """Values at the nodes of a block, in its order, from points in any order."""
    i, j = np.rint(points[:, 0] * nx / 2.0), np.rint((points[:, 1] - (1.0 if upper else 0.0)) * ny)
    found = np.full(((nx + 1) * (ny + 1), 2), np.nan)
    found[(j * (nx + 1) + i).astype(int)] = values
    if np.isnan(found).any():
        raise RuntimeError("a node has no value")
    return found.ravel()


def reference(nndd, work, nx, ny):
    """Displacements by nndd on a fine mesh, and its own bound."""
    out = work / f"reference-{nx}x{ny}"
    if not (out / "report.json").exists():
        options = ["--set", 'solver.method="newton"', "--set", "estimator.relaxation=8", "--set", "solver.stop.ratio=1e-6"]
        subprocess.run([nndd, "solve", CASE, "--out", out, "--force", *cells(nx, ny), *options], check=True, capture_output=True)
    fields = []
    for name in BODIES:
        file = meshio.read(out / f"{name}.vtu")
        fields.append(on_grid(nx, ny, name == "upper", file.points, file.point_data["displacement"][:, :2]))
    return fields, json.loads((out / "report.json").read_text())["certificate"]["e_cre"]


def interpolate(u, nx, ny, factor):
    """A P1 field on the nested mesh that is finer by a factor, cut along the same diagonals."""
    v = u.reshape(ny + 1, nx + 1, 2)
    i, j = np.meshgrid(np.arange(factor * nx + 1), np.arange(factor * ny + 1))
    a, b = np.minimum(i // factor, nx - 1), np.minimum(j // factor, ny - 1)
    s, t = ((i / factor) - a)[..., None], ((j / factor) - b)[..., None]
    low, right, top, far = v[b, a], v[b, a + 1], v[b + 1, a], v[b + 1, a + 1]
    below = low + s * (right - low) + t * (far - right)
    above = low + t * (top - low) + s * (far - top)
    return np.where(s >= t, below, above).ravel()


def distance(blocks, u, v):
    """Energy norm of the difference of two pairs of fields."""
    return math.sqrt(sum(block.energy(a - b) for block, a, b in zip(blocks, u, v)))


def write(work, name, blocks, u):
    """One table per body, as `nndd certify` reads them."""
    files = []
    for body, block, field in zip(BODIES, blocks, u):
        files.append(work / f"{name}-{body}.csv")
        rows = np.column_stack([block.mesh.p.T, field.reshape(-1, 2)])
        np.savetxt(files[-1], rows, "%.15g", ",", header="x,y,ux,uy", comments="")
    return files


def certify(nndd, files, nx, ny):
    """Exit status, the numbers, and what is printed for people."""
    command = [nndd, "certify", CASE, *cells(nx, ny), "--displacement", *files]
    for_people = subprocess.run(command, capture_output=True, text=True)
    found = subprocess.run([*command, "--format", "json"], capture_output=True, text=True)
    numbers = json.loads(found.stdout) if found.stdout.strip() else {}
    return found.returncode, numbers, (for_people.stdout + for_people.stderr).strip()


def by_calculix(work, nx, ny, factor):
    """Displacements by CalculiX with a penalty of `factor` times the stiffer modulus."""
    job = f"ccx-{nx}x{ny}-{factor}"
    if not (work / f"{job}.dat").exists():
        calculix.PENALTY = factor * max(paper.YOUNG)
        (work / f"{job}.inp").write_text(calculix.deck(nx, ny))
        env = {**os.environ, "OMP_NUM_THREADS": "1"}
        subprocess.run(["ccx", job], cwd=work, env=env, check=True, capture_output=True)
    counts = [(nx + 1) * (ny + 1)] * 2
    return calculix.displacements((work / f"{job}.dat").read_text(), counts)


def pushing_while_open(blocks, u):
    """The largest opening of a pair whose nodal force is at least a hundredth of the largest."""
    force = blocks[0].contact_force(u[0])
    opening = u[0][blocks[0].contact] - u[1][blocks[1].contact]
    return float(max(0.0, opening[force > 0.01 * force.max()].max()))


class Model:
    """Both blocks as one system, for solutions by penalty."""

    def __init__(self, blocks):
        upper, lower = self.blocks = blocks
        self.m = m = len(upper.f)
        self.k = sp.block_diag([upper.k, lower.k], format="csr")
        self.f = np.concatenate([upper.f, lower.f])
        self.imposed = np.concatenate([upper.imposed, m + lower.imposed])
        self.u = np.zeros(len(self.f))
        self.u[self.imposed] = np.concatenate([upper.values, lower.values])
        self.free = np.setdiff1d(np.arange(len(self.f)), self.imposed)
        self.above, self.below = upper.contact, m + lower.contact
        count = len(self.above)
        self.length = np.full(count, 2.0 / (count - 1))
        self.length[[0, -1]] *= 0.5

    def penalty(self, slope, follow=True, max_steps=100):
        """Node to node: the force on a pair is slope x its length x its overlap; `follow` false: springs that also pull."""
        n = len(self.f)
        active = np.ones(len(self.above), dtype=bool)
        for _ in range(max_steps):
            a, b = self.above[active], self.below[active]
            rows = np.arange(len(a))
            gap = sp.csr_matrix((np.ones(len(a)), (rows, a)), (len(a), n)) - sp.csr_matrix((np.ones(len(a)), (rows, b)), (len(a), n))
            k = (self.k + gap.T @ sp.diags(slope * self.length[active]) @ gap).tocsr()
            u = self.u.copy()
            free = k[self.free]
            u[self.free] += splu(free[:, self.free].tocsc()).solve(self.f[self.free] - free @ self.u)
            following = u[self.above] < u[self.below]
            if not follow or np.array_equal(following, active):
                return [u[: self.m], u[self.m :]]
            active = following
        raise RuntimeError("the active set still changes")

    def apart(self):
        """Each body on its own, without contact: the lower one stays at rest."""
        u = self.u.copy()
        free = self.k[self.free]
        u[self.free] += splu(free[:, self.free].tocsc()).solve(self.f[self.free] - free @ self.u)
        return [u[: self.m], u[self.m :]]


def fields(work, nx, ny, blocks):
    """Names of codes, of ways, and the fields."""
    for factor in PENALTIES:
        yield "CalculiX", f"penalty {factor} E", by_calculix(work, nx, ny, factor)
    _, u, _, _ = active_set.solve(nx, ny, active_set.superlu)
    yield "scikit-fem", "active set", list(u)
    model = Model(blocks)
    for factor in PENALTIES:
        yield "scikit-fem", f"penalty {factor} E", model.penalty(factor * max(paper.YOUNG))


def wrong_fields(nx, ny):
    """Fields that are no solutions."""
    blocks = paper.blocks(nx, ny)
    _, u, _, _ = active_set.solve(nx, ny, active_set.superlu)
    model = Model(blocks)
    yield "tied: contact may pull", model.penalty(1e9, follow=False)
    yield "no contact at all", model.apart()
    yield "active set, three digits", [np.array([float(f"{x:.3g}") for x in v]) for v in u]
    yield "active set, six decimals", [np.round(v, 6) for v in u]
    yield "all halved: supports missed", [0.5 * v for v in u]
    turned = [v.copy() for v in u]
    turned[0][1::2] += 0.01
    yield "upper body too high: supports missed", turned
    yield "lower body at rest, upper body right", [u[0], 0.0 * u[1]]


def wrong_files(nndd, work, nx, ny):
    """Files that do not belong to the mesh: what is said."""
    blocks, finer = paper.blocks(nx, ny), paper.blocks(2 * nx, 2 * ny)
    _, u, _, _ = active_set.solve(nx, ny, active_set.superlu)
    _, v, _, _ = active_set.solve(2 * nx, 2 * ny, active_set.superlu)
    v = [w.copy() for w in v]
    between = np.rint(finer[0].mesh.p[0] * nx).astype(int) % 2 == 1
    v[0][1::2][between] += 0.005
    added = math.sqrt(finer[0].energy(0.005 * np.kron(between, [0.0, 1.0])))
    status, found, said = certify(nndd, write(work, "finer", finer, v), nx, ny)
    yield f"field of a mesh twice as fine, spoilt by {added:.3g} at the nodes between", status, found.get("bound"), said
    rows = [np.column_stack([block.mesh.p.T, w.reshape(-1, 2)]) for block, w in zip(blocks, u)]
    for name, order in (("upper first", rows), ("lower first", rows[::-1])):
        file = work / f"both-{name[:5]}.csv"
        np.savetxt(file, np.vstack(order), "%.15g", ",", header="x,y,ux,uy", comments="")
        status, found, said = certify(nndd, [file, file], nx, ny)
        yield f"both bodies in one file, {name}, given for each", status, found.get("bound"), said


def number(x, digits=4):
    return "" if x is None else f"{x:.{digits}g}"


HEAD = ("mesh", "code", "contact", "pushes open by", "overlap", "change", "e_cre", "bound", "relative", "valid", "exit", "true error", "bound / error", "said")


def row(nndd, work, mesh, names, blocks, u, fine, fine_u, factor):
    nx, ny = mesh
    label = "-".join([*names, f"{nx}x{ny}"]).replace(" ", "_").replace(":", "").replace(",", "")
    files = write(work, label, blocks, u)
    status, found, said = certify(nndd, files, nx, ny)
    error = distance(fine, [interpolate(v, nx, ny, factor) for v in u], fine_u)
    bound = found.get("bound")
    return dict(zip(HEAD, (f"{nx}x{ny}", *names, pushing_while_open(blocks, u), found.get("penetration"), found.get("change"), found.get("e_cre"), bound,
        found.get("relative"), found.get("valid"), status, error, bound / error if bound else None, said)))


def show(rows):
    names = [name for name in HEAD if name != "said"]
    print("| " + " | ".join(names) + " |\n|" + "---|" * len(names))
    for r in rows:
        print("| " + " | ".join(number(r[n]) if isinstance(r[n], float) else str(r[n] if r[n] is not None else "") for n in names) + " |", flush=True)


def main():
    nndd, work = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    work.mkdir(parents=True, exist_ok=True)
    meshes = [tuple(int(n) for n in text.split("x")) for text in sys.argv[3:]] or [(18, 9), (36, 18), (80, 36)]
    rows, wrong = [], []
    for mesh in meshes:
        nx, ny = mesh
        factor = FINER.get(mesh, FINER_ELSE)
        fine = paper.blocks(factor * nx, factor * ny)
        fine_u, own = reference(nndd, work, factor * nx, factor * ny)
        blocks = paper.blocks(nx, ny)
        print(f"reference of {nx}x{ny}: {factor * nx}x{factor * ny}, its own error at most {own:.3g}", file=sys.stderr, flush=True)
        for code, way, u in fields(work, nx, ny, blocks):
            rows.append(row(nndd, work, mesh, (code, way), blocks, u, fine, fine_u, factor))
            print({k: v for k, v in rows[-1].items()}, file=sys.stderr, flush=True)
        if mesh == meshes[0]:
            files = list(wrong_files(nndd, work, nx, ny))
            for name, u in wrong_fields(nx, ny):
                wrong.append(row(nndd, work, mesh, ("wrong", name), blocks, u, fine, fine_u, factor))
    show(rows)
    print()
    show(wrong)
    print()
    for name, status, bound, said in files:
        print(f"{name}: exit {status}, bound {number(bound)}: {said}\n")
    for r in [*rows, *wrong]:
        if r["exit"] != 0 or r["bound / error"] is None or r["bound / error"] < 1.0:
            print(f"{r['code']}, {r['contact']}, {r['mesh']}: exit {r['exit']}: {r['said']}\n")
    with open(work / "certify.csv", "w", newline="") as file:
        table = csv.DictWriter(file, HEAD)
        table.writeheader()
        table.writerows([*rows, *wrong])


if __name__ == "__main__":
    main()
