"""Times linear solvers on the stiffness of the two blocks of the paper's problem, as one block-diagonal matrix.

Usage: linear.py CELLS_X CELLS_Y SOLVER RUNS      SOLVER: pardiso, cholmod, superlu
Prints one JSON object per run: seconds of analysis, factorisation and one solve, and a checksum.
"""

import json
import resource
import sys
import time

import numpy as np
import scipy.sparse as sp


def block_stiffness(nx, ny, young, fixed):
    """Assembles one block (0,2)x(0,1) of P1 triangles in plane strain; `fixed(x, y)` marks imposed components."""
    nu = 0.3
    x, y = np.meshgrid(np.linspace(0.0, 2.0, nx + 1), np.linspace(0.0, 1.0, ny + 1))
    points = np.column_stack([x.ravel(), y.ravel()])
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    a = (j * (nx + 1) + i).ravel()
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    cells = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    p = points[cells]
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    area2 = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    g = np.empty_like(p)
    for k in range(3):
        q, r = p[:, (k + 1) % 3], p[:, (k + 2) % 3]
        g[:, k, 0] = (q[:, 1] - r[:, 1]) / area2
        g[:, k, 1] = (r[:, 0] - q[:, 0]) / area2
    lam, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    # K_ab = A (lam ga gb^T + mu gb ga^T + mu (ga.gb) I)
    dots = np.einsum("ekc,elc->ekl", g, g)
    k = lam * np.einsum("ekc,eld->eklcd", g, g) + mu * np.einsum("eld,ekc->eklcd", g[:, :, ::1], g)
    k = lam * np.einsum("ekc,eld->eklcd", g, g) + mu * np.einsum("ekd,elc->eklcd", g, g)
    k[..., 0, 0] += mu * dots
    k[..., 1, 1] += mu * dots
    k *= (0.5 * area2)[:, None, None, None, None]
    dofs = 2 * cells[:, :, None] + np.arange(2)
    rows = np.broadcast_to(dofs[:, :, None, :, None], k.shape)
    cols = np.broadcast_to(dofs[:, None, :, None, :], k.shape)
    n = 2 * len(points)
    matrix = sp.coo_matrix((k.ravel(), (rows.ravel(), cols.ravel())), shape=(n, n)).tocsr()
    free = ~fixed(points).ravel()
    return matrix[free][:, free]


def blocks(nx, ny):
    upper = lambda p: np.column_stack([p[:, 0] == 0.0, p[:, 1] == 1.0])
    lower = lambda p: np.column_stack([p[:, 1] == 0.0, p[:, 1] == 0.0])
    return sp.block_diag(
        [block_stiffness(nx, ny, 2000.0, upper), block_stiffness(nx, ny, 1000.0, lower)], format="csr"
    )


def pardiso(matrix, rhs):
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=2)
    upper = sp.triu(matrix, format="csr")
    t0 = time.perf_counter()
    solver._check_A(upper)
    solver.set_phase(11)
    solver._call_pardiso(upper, rhs)
    t1 = time.perf_counter()
    solver.set_phase(22)
    solver._call_pardiso(upper, rhs)
    t2 = time.perf_counter()
    solver.set_phase(33)
    x = solver._call_pardiso(upper, rhs)
    t3 = time.perf_counter()
    return x, t1 - t0, t2 - t1, t3 - t2


def cholmod(matrix, rhs):
    from sksparse.cholmod import analyze

    lower = matrix.tocsc()
    t0 = time.perf_counter()
    factor = analyze(lower, ordering_method="metis")
    t1 = time.perf_counter()
    factor.cholesky_inplace(lower)
    t2 = time.perf_counter()
    x = factor(rhs)
    t3 = time.perf_counter()
    return x, t1 - t0, t2 - t1, t3 - t2


def superlu(matrix, rhs):
    from scipy.sparse.linalg import splu

    csc = matrix.tocsc()
    t0 = time.perf_counter()
    factor = splu(csc, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    t1 = time.perf_counter()
    x = factor.solve(rhs)
    t2 = time.perf_counter()
    return x, 0.0, t1 - t0, t2 - t1


def main():
    nx, ny, solver, runs = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], int(sys.argv[4])
    matrix = blocks(nx, ny)
    rhs = np.ones(matrix.shape[0])
    for _ in range(runs):
        x, analysis, factor, solve = {"pardiso": pardiso, "cholmod": cholmod, "superlu": superlu}[solver](matrix, rhs)
        residual = float(np.linalg.norm(matrix @ x - rhs) / np.linalg.norm(rhs))
        print(
            json.dumps(
                {
                    "solver": solver,
                    "unknowns": matrix.shape[0],
                    "analysis": analysis,
                    "factorisation": factor,
                    "solve": solve,
                    "total": analysis + factor + solve,
                    "residual": residual,
                    "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
                }
            ),
            flush=True,
        )


if __name__ == "__main__":
    main()
