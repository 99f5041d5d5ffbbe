"""One linear solve with the stiffness of both blocks of the paper's problem, as one block-diagonal matrix.

linear.py matrix CELLS_X CELLS_Y FILE [COPIES]    assembles the matrix, or several copies of it, and writes it
linear.py SOLVER FILE                             analysis, factorisation, one solve
                                                  SOLVER: pardiso, pardiso-minimum-degree, cholmod, superlu
linear.py orders FILE                             values and operations of PARDISO's factor in both of its orders

The matrix is made by a process of its own, so that the peak memory of a solver holds nothing of its assembly.
Prints one JSON object: seconds, relative residual, and memory in bytes.
"""

import json
import sys
import time

import numpy as np
import scipy.sparse as sp

import process


def write_matrix(nx, ny, file, copies=1):
    """Writes the upper triangle of the stiffness of the free unknowns."""
    import paper

    free = []
    for block in paper.blocks(nx, ny):
        kept = np.setdiff1d(np.arange(len(block.f)), block.imposed)
        free.append(sp.csr_matrix(block.k)[kept][:, kept])
    write_upper(sp.triu(sp.block_diag(free * copies), format="csr"), file)


def write_upper(upper, file):
    """Writes an upper triangle, rows sorted, as three plain arrays."""
    upper.sort_indices()
    np.savez(file, data=upper.data, indices=upper.indices.astype(np.int32), indptr=upper.indptr.astype(np.int32))


def read_matrix(file):
    """Reads the upper triangle."""
    with np.load(file) as stored:
        parts = (stored["data"], stored["indices"], stored["indptr"])
    n = len(parts[2]) - 1
    return sp.csr_matrix(parts, shape=(n, n))


def pardiso(upper, rhs, minimum_degree=False):
    """MKL PARDISO: symmetric positive definite, upper triangle; ordered by METIS, its default, or minimum degree."""
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=2)
    if minimum_degree:
        # The first parameter says that the others are not to be filled with defaults; zeros suit this kind of matrix.
        solver.set_iparm(1, 1)
        solver.set_iparm(2, 0)
    times = []
    for phase in (11, 22, 33):
        solver.set_phase(phase)
        start = time.perf_counter()
        x = solver._call_pardiso(upper, rhs)
        times.append(time.perf_counter() - start)
    analysis, kept, numeric = (int(solver.get_iparm(i)) * 1024 for i in (15, 16, 17))
    return x, times, {"own_bytes": max(analysis, kept + numeric)}


def orders(upper, rhs):
    """Values and operations of the factor by METIS and by minimum degree; counting them takes time of its own."""
    from pypardiso import PyPardisoSolver

    counts = {}
    for name, order in (("metis", 2), ("minimum degree", 0)):
        solver = PyPardisoSolver(mtype=2)
        # -1 asks for the count.
        for place, value in ((1, 1), (2, order), (18, -1), (19, -1)):
            solver.set_iparm(place, value)
        for phase in (11, 22):
            solver.set_phase(phase)
            solver._call_pardiso(upper, rhs)
        counts[name] = {"values": int(solver.get_iparm(18)), "gflop": int(solver.get_iparm(19)) / 1000}
    return counts


def pardiso_minimum_degree(upper, rhs):
    return pardiso(upper, rhs, minimum_degree=True)


def cholmod(upper, rhs):
    """CHOLMOD in the order it chooses; it reads the lower triangle, which is the upper one by columns."""
    from sksparse.cholmod import analyze

    lower = sp.csc_matrix((upper.data, upper.indices, upper.indptr), shape=upper.shape)
    start = time.perf_counter()
    factor = analyze(lower)
    analysed = time.perf_counter()
    factor.cholesky_inplace(lower)
    factorised = time.perf_counter()
    x = factor(rhs)
    solved = time.perf_counter()
    return x, [analysed - start, factorised - analysed, solved - factorised], {"blas": process.blas()}


def superlu(upper, rhs):
    """SuperLU in its mode for symmetric patterns, ordered by minimum degree; it orders and factorises in one call."""
    from scipy.sparse.linalg import splu

    whole = (upper + sp.triu(upper, 1).T).tocsc()
    start = time.perf_counter()
    factor = splu(whole, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    factorised = time.perf_counter()
    x = factor.solve(rhs)
    solved = time.perf_counter()
    return x, [0.0, factorised - start, solved - factorised], {}


SOLVERS = {
    "pardiso": pardiso,
    "pardiso-minimum-degree": pardiso_minimum_degree,
    "cholmod": cholmod,
    "superlu": superlu,
}


def main():
    if sys.argv[1] == "matrix":
        return write_matrix(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4], *map(int, sys.argv[5:]))
    if sys.argv[1] == "orders":
        upper = read_matrix(sys.argv[2])
        return print(json.dumps(orders(upper, np.ones(upper.shape[0]))))
    solver, file = SOLVERS[sys.argv[1]], sys.argv[2]
    # A small system first: loading libraries and starting threads is no part of what is measured.
    small = sp.diags([2.0, -1.0], [0, 1], shape=(1000, 1000), format="csr")
    solver(small, np.ones(1000))
    before = process.resident()
    upper = read_matrix(file)
    rhs = np.ones(upper.shape[0])
    x, (analysis, factorisation, solve), more = solver(upper, rhs)
    peak = process.peak()
    product = upper @ x + sp.triu(upper, 1).T @ x
    print(
        json.dumps(
            {
                "unknowns": upper.shape[0],
                "analysis": analysis,
                "factorisation": factorisation,
                "solve": solve,
                "seconds": analysis + factorisation + solve,
                "residual": float(np.linalg.norm(product - rhs) / np.linalg.norm(rhs)),
                "memory_bytes": None if before is None or peak is None else peak - before,
                **more,
            }
        )
    )


if __name__ == "__main__":
    main()
