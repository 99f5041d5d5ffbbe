"""Judges stresses of single tetrahedra by FIAT's Johnson-Mercier element on the same cells.

fiat_element.py FILE     FILE: cells, materials, facet moments and stresses, as `reproduce fiat` writes them

A stress is given by its values at the corners of the four parts of a cell, as is each function of FIAT's element, which is linear in each
part. Prints a JSON list with an object for each cell.
"""

import json
import sys

import numpy as np
from FIAT import JohnsonMercier
from FIAT.reference_element import TETRAHEDRON, UFCSimplex, UFCTetrahedron

# Components xx, yy, zz, yz, xz, xy.
ROWS, COLUMNS = [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]
# Points inside a part by its corners.
INSIDE = 0.4 * np.eye(4) + 0.15
# Singular values below this fraction of the largest one are round-off.
DEPENDENT = 1e-9


class Cell:
    """A tetrahedron, with the functions of FIAT's element as rows of values at the corners of its parts."""

    def __init__(self, given):
        self.points = np.array(given["corners"])
        self.middle = self.points.mean(axis=0)
        self.parts = [np.vstack([self.points[part], self.middle]) for part in given["parts"]]
        self.part_nodes = given["parts"]
        self.faces = given["faces"]
        self.compliance = np.linalg.inv(np.array(given["stiffness"]))
        self.volume = abs(np.linalg.det(self.points[1:] - self.points[0])) / 6
        corners = tuple(map(tuple, self.points))
        element = JohnsonMercier(UFCSimplex(TETRAHEDRON, corners, UFCTetrahedron().get_topology()))
        self.dimension = element.space_dimension()
        inside = np.vstack([INSIDE @ part for part in self.parts] + [[part.mean(axis=0) for part in self.parts]])
        values = element.tabulate(0, inside)[(0, 0, 0)]
        size = np.abs(values).max()
        self.asymmetry = np.abs(values - values.transpose(0, 2, 1, 3)).max() / size
        values = values[:, ROWS, COLUMNS]
        at_points = values[:, :, :16].reshape(-1, 6, 4, 4)
        at_corners = np.einsum("vq,icpq->ipvc", np.linalg.inv(INSIDE), at_points)
        # That each function is linear in each part is seen at one more point.
        self.bend = np.abs(at_corners.mean(axis=2).transpose(0, 2, 1) - values[:, :, 16:]).max() / size
        self.functions = at_corners.reshape(len(values), 96)
        self.functions /= np.linalg.norm(self.functions, axis=1)[:, None]

    def moments(self, fields):
        """The moments of the tractions about the corners of each face, for each stress."""
        found = []
        for face in self.faces:
            part = next(k for k, nodes in enumerate(self.part_nodes) if set(nodes) == set(face))
            a, b, c = self.points[face]
            normal = np.cross(b - a, c - a) / 2
            normal *= np.sign(normal @ (a - self.middle))
            places = [self.part_nodes[part].index(node) for node in face]
            tractions = np.einsum("nvij,j->nvi", tensor(fields.reshape(-1, 4, 4, 6)[:, part, places]), normal)
            found.append((tractions.sum(axis=1)[:, None] + tractions) / 12)
        return np.stack(found, axis=1).reshape(len(fields), 36)

    def divergence(self, fields):
        """The divergence in the four parts, for each stress."""
        found = []
        for k, part in enumerate(self.parts):
            gradients = np.linalg.inv(np.hstack([np.ones((4, 1)), part]))[1:].T
            found.append(np.einsum("nvij,vj->ni", tensor(fields.reshape(-1, 4, 4, 6)[:, k]), gradients))
        return np.hstack(found)

    def energy(self):
        """The matrix of the complementary energy of values at the corners of the parts."""
        # The compliance gives doubled shears, so that each of them counts twice in the product.
        weights = (np.eye(4) + 1) / 20
        return np.kron(np.eye(4), np.kron(weights, self.compliance)) * self.volume / 4


def tensor(components):
    """Symmetric tensors from six components in the last axis."""
    full = np.zeros(components.shape[:-1] + (3, 3))
    full[..., ROWS, COLUMNS] = components
    full[..., COLUMNS, ROWS] = components
    return full


def kernel(matrix):
    """A basis of the kernel, as columns."""
    _, values, right = np.linalg.svd(matrix)
    rank = int((values > DEPENDENT * values[0]).sum())
    return right[rank:].T


def least(functions, energy, constraints, wanted):
    """The least energy of combinations of some functions under constraints, and how many of them these leave free."""
    start = np.linalg.lstsq(constraints, wanted, rcond=DEPENDENT)[0]
    missed = np.abs(constraints @ start - wanted).max() / np.abs(wanted).max()
    free = kernel(constraints)
    values, base = functions.T @ free, functions.T @ start
    if free.shape[1]:
        base = base - values @ np.linalg.solve(values.T @ energy @ values, values.T @ energy @ base)
    return base @ energy @ base, free.shape[1], missed


def judge(given):
    """The figures of one cell."""
    cell = Cell(given)
    stresses = np.array([np.ravel(field["stress"]) for field in given["fields"]])
    forces = np.array([field["force"] for field in given["fields"]])
    wanted = np.array([np.ravel(field["moments"]) for field in given["fields"]])
    functions, energy = cell.functions, cell.energy()
    inside = np.linalg.lstsq(functions.T, stresses.T, rcond=None)[0]
    residuals = np.linalg.norm(functions.T @ inside - stresses.T, axis=0) / np.linalg.norm(stresses, axis=1)

    # Of both spaces without divergence: orthonormal bases, and how far each is from the other.
    still = functions.T @ kernel(cell.divergence(functions).T * cell.volume ** (1 / 3))
    theirs, _ = np.linalg.qr(still)
    left, values, _ = np.linalg.svd(stresses[~forces.any(axis=1)].T, full_matrices=False)
    ours = left[:, values > DEPENDENT * values[0]]
    apart = max(np.linalg.norm(a - b @ (b.T @ a), 2) for a, b in ((ours, theirs), (theirs, ours)))

    length = cell.volume ** (1 / 3)
    of_moments = cell.moments(functions) / length**2
    of_balance = cell.divergence(functions) * length
    differences, free, below, missed, sums = [], set(), [], [], []
    for stress, force, moments, field in zip(stresses, forces, wanted, given["fields"]):
        constraints = np.hstack([of_moments, of_balance]).T
        target = np.hstack([moments / length**2, np.tile(-force, 4) * length])
        smallest, left_free, off = least(functions, energy, constraints, target)
        differences.append(abs(field["energy"] / smallest - 1))
        free.add(left_free)
        missed.append(off)
        below.append(least(functions, energy, of_moments.T, moments / length**2)[0] / field["energy"])
        sums.append(abs(stress @ energy @ stress / field["energy"] - 1))
    return {
        "dimension": cell.dimension,
        "rank": int(np.linalg.matrix_rank(functions, tol=DEPENDENT)),
        "asymmetry": cell.asymmetry,
        "bend": cell.bend,
        "residual": residuals.max(),
        "dimensions": [theirs.shape[1], ours.shape[1]],
        "apart": apart,
        "moments": np.abs(cell.moments(stresses) - wanted).max() / np.abs(wanted).max(),
        "missed": max(missed),
        "free": max(free),
        "sum": max(sums),
        "energy": max(differences),
        "below": [min(below), max(below)],
    }


def main():
    with open(sys.argv[1]) as file:
        cells = json.load(file)
    print(json.dumps([judge(cell) for cell in cells]))


if __name__ == "__main__":
    main()
