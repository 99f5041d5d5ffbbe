"""The stiffness of two stacked boxes of tetrahedra, each held on one side, as one block-diagonal matrix.

boxes.py CELLS FILE     CELLS: cubes along each edge of a box; FILE: for linear.py

The lower box is clamped at its bottom, the upper one at its top. Each cube has six tetrahedra around its diagonal, as in the program.
"""

import itertools
import sys

import numpy as np
import scipy.sparse as sp

import linear

# Young's moduli of the lower and the upper box, and Poisson's number of both.
YOUNG, POISSON = (1000.0, 2000.0), 0.3


def element(path, size, young):
    """The stiffness of the tetrahedron of a cube that leads from one end of its diagonal to the other along its edges."""
    gradients = np.linalg.inv(np.hstack([np.ones((4, 1)), size * path]))[1:]
    shear = young / (2 + 2 * POISSON)
    lame = young * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    products = gradients.T @ gradients
    matrix = lame * np.einsum("ia,jb->aibj", gradients, gradients)
    matrix += shear * np.einsum("ib,ja->aibj", gradients, gradients)
    matrix += shear * np.einsum("ab,ij->aibj", products, np.eye(3))
    return matrix.reshape(12, 12) * size**3 / 6


def upper_triangle(cells, young, held):
    """The upper triangle of the stiffness of a box, without the nodes of the layer held."""
    layer = (cells + 1) ** 2
    count = layer * (cells + 1)
    strides = np.array([1, cells + 1, layer])
    axes = np.arange(cells)
    first = (axes[:, None, None] * layer + axes[:, None] * (cells + 1) + axes).ravel()
    number = np.arange(count)
    kept = np.where(held == "bottom", number >= layer, number < count - layer)
    new = np.cumsum(kept) - 1
    total = None
    for order in itertools.permutations(range(3)):
        path = np.zeros((4, 3))
        for step, axis in enumerate(order):
            path[step + 1 :, axis] = 1
        nodes = first[:, None] + (path @ strides).astype(int)
        unknowns = (3 * new[nodes][..., None] + np.arange(3)).reshape(-1, 12)
        free = np.repeat(kept[nodes], 3, axis=1)
        local = element(path, 1 / cells, young)
        rows, columns = np.repeat(unknowns, 12, axis=1), np.tile(unknowns, 12)
        wanted = np.repeat(free, 12, axis=1) & np.tile(free, 12) & (rows <= columns)
        values = np.broadcast_to(local.ravel(), rows.shape)[wanted]
        size = 3 * int(kept.sum())
        part = sp.coo_matrix((values, (rows[wanted], columns[wanted])), shape=(size, size)).tocsr()
        total = part if total is None else total + part
    return total


def main():
    cells = int(sys.argv[1])
    halves = [upper_triangle(cells, young, held) for young, held in zip(YOUNG, ("bottom", "top"))]
    linear.write_upper(sp.block_diag(halves, format="csr"), sys.argv[2])


if __name__ == "__main__":
    main()
