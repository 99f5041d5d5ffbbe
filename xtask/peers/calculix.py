"""The paper's problem for CalculiX, on the same triangles (CPE3).

calculix.py deck CELLS_X CELLS_Y JOB    writes JOB.inp
calculix.py read CELLS_X CELLS_Y JOB    reads JOB.dat and prints one JSON object: energies and contact force

Contact is surface to surface with a linear pressure-overclosure of slope PENALTY: the mortar method with hard contact
refuses plane elements, whose nodes CalculiX ties to those of a solid one layer thick. Energies and forces are computed
here from the printed displacements, which have seven digits.
"""

import json
import sys

import numpy as np

import paper

# 500 E: agrees to about a thousandth; the slopes of 5 to 50 E that its manual advises agree to a hundredth.
PENALTY = 1e6


def lines(rows, form):
    """One line per row; CalculiX reads at most twenty characters of a number."""
    return "".join(form.format(*row) + "\n" for row in rows)


def counterclockwise(mesh):
    """The triangles of a mesh, one per row; scikit-fem sorts their vertices by number."""
    (ax, bx, cx), (ay, by, cy) = mesh.p[0, mesh.t], mesh.p[1, mesh.t]
    turned = (bx - ax) * (cy - ay) < (cx - ax) * (by - ay)
    triangles = mesh.t.T.copy()
    triangles[turned, 1:] = triangles[turned, :0:-1]
    return triangles


def deck(nx, ny):
    """The input deck. Nodes and elements are numbered from one, the upper block first."""
    blocks = paper.blocks(nx, ny)
    text, nodes, elements = [], 0, 0
    sets = {}
    for name, young, block in zip(("UPPER", "LOWER"), paper.YOUNG, blocks):
        points, triangles = block.mesh.p.T, counterclockwise(block.mesh) + 1 + nodes
        numbered = ((nodes + i + 1, float(x), float(y)) for i, (x, y) in enumerate(points))
        text.append(f"*NODE,NSET=N{name}\n" + lines(numbered, "{},{:.12e},{:.12e},0."))
        numbered = ((elements + i + 1, *t) for i, t in enumerate(triangles))
        text.append(f"*ELEMENT,TYPE=CPE3,ELSET={name}\n" + lines(numbered, "{},{},{},{}"))
        text.append(f"*MATERIAL,NAME=M{name}\n*ELASTIC\n{young},{paper.POISSON}\n")
        text.append(f"*SOLID SECTION,ELSET={name},MATERIAL=M{name}\n1.\n")
        # Triangles come as the lower halves of all cells, then the upper halves: the side S1 of the first row of the
        # one is the bottom, S2 of the last row of the other (b-c of a, c, d) the top.
        upper = name == "UPPER"
        first = elements + 1 + (0 if upper else nx * ny + nx * (ny - 1))
        sides = ((first + i, "S1" if upper else "S2") for i in range(nx))
        text.append(f"*SURFACE,NAME=S{name}\n" + lines(sides, "{},{}"))
        x, y = points.T
        if upper:
            sets["TOP"] = nodes + 1 + np.flatnonzero(y == 2.0)
            sets["LEFT"] = nodes + 1 + np.flatnonzero(x == 0.0)
        else:
            sets["BASE"] = nodes + 1 + np.flatnonzero(y == 0.0)
        nodes, elements = nodes + len(points), elements + len(triangles)
    for name, members in sets.items():
        text.append(f"*NSET,NSET={name}\n" + lines(((i,) for i in members), "{},"))
    upper = blocks[0]
    loaded = [(int(i) + 1, float(upper.f[d])) for i, d in enumerate(upper.vertical) if upper.f[d] > 1e-12]
    text.append(
        "*SURFACE INTERACTION,NAME=CONTACT\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR\n"
        f"{PENALTY}\n*CONTACT PAIR,INTERACTION=CONTACT,TYPE=SURFACE TO SURFACE\nSLOWER,SUPPER\n"
        "*BOUNDARY\nBASE,1,2,0.\nLEFT,1,1,0.\n*STEP,INC=200\n*STATIC\n1.,1.\n"
        f"*BOUNDARY\nTOP,2,2,{paper.PRESSED}\n*CLOAD\n" + lines(loaded, "{},2,{:.12e}")
    )
    for name in ("UPPER", "LOWER"):
        text.append(f"*NODE PRINT,NSET=N{name},FREQUENCY=1000\nU\n")
    return "".join(text) + "*END STEP\n"


def displacements(text, counts):
    """The last displacements printed for each block, as vectors of unknowns."""
    rows = np.array([line.split() for line in text.splitlines() if len(line.split()) == 4], dtype=float)
    rows = rows[-sum(counts) :]
    if len(rows) != sum(counts):
        raise RuntimeError(f"found {len(rows)} displacements, expected {sum(counts)}")
    split = np.split(rows[:, 1:3], np.cumsum(counts)[:-1])
    return [part.ravel() for part in split]


def main():
    task, nx, ny, job = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    if task == "deck":
        with open(job + ".inp", "w") as file:
            file.write(deck(nx, ny))
        return
    blocks = paper.blocks(nx, ny)
    with open(job + ".dat") as file:
        u = displacements(file.read(), [len(block.f) // 2 for block in blocks])
    opening = u[0][blocks[0].contact] - u[1][blocks[1].contact]
    print(
        json.dumps(
            {
                "energies": [block.energy(v) for block, v in zip(blocks, u)],
                "contact_force": float(blocks[0].contact_force(u[0]).sum()),
                "largest_penetration": float(max(0.0, -opening.min())),
                "penalty": PENALTY,
            }
        )
    )


if __name__ == "__main__":
    main()
