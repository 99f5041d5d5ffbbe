"""Primal-dual active set for the paper's problem, from assembly to converged displacements, by scikit-fem.

active_set.py SOLVER CELLS_X CELLS_Y     SOLVER: cholmod, superlu

The vertical unknowns of pairs in contact are tied, the contact forces are the residual there, and the tied matrix is
factorised anew in every step. Prints one JSON object.
"""

import json
import sys
import time

import numpy as np
import scipy.sparse as sp

import paper
import process


def cholmod(matrix, rhs):
    """One analysis, factorisation and solve by CHOLMOD, in the order it chooses."""
    from sksparse.cholmod import cholesky

    return cholesky(matrix)(rhs)


def superlu(matrix, rhs):
    """The same by SuperLU in its mode for symmetric patterns."""
    from scipy.sparse.linalg import splu

    return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0).solve(rhs)


SOLVERS = {"cholmod": cholmod, "superlu": superlu}


def tie(n, slaves, masters, free):
    """The matrix that gives all unknowns from the free ones: each slave follows its master."""
    follows = np.arange(n)
    follows[slaves] = masters
    columns = np.full(n, -1)
    kept = np.setdiff1d(free, slaves)
    columns[kept] = np.arange(len(kept))
    rows = np.flatnonzero(columns[follows] >= 0)
    return sp.csr_matrix((np.ones(len(rows)), (rows, columns[follows[rows]])), shape=(n, len(kept)))


def solve(nx, ny, solver, max_steps=100):
    """Returns both blocks, their displacements, the forces of contact, and the number of steps."""
    upper, lower = paper.blocks(nx, ny)
    m = len(upper.f)
    k = sp.block_diag([upper.k, lower.k], format="csr")
    f = np.concatenate([upper.f, lower.f])
    n = len(f)
    imposed = np.concatenate([upper.imposed, m + lower.imposed])
    u = np.zeros(n)
    u[imposed] = np.concatenate([upper.values, lower.values])
    load = f - k @ u
    free = np.setdiff1d(np.arange(n), imposed)
    above, below = upper.contact, m + lower.contact

    active = np.ones(len(above), dtype=bool)
    for step in range(1, max_steps + 1):
        t = tie(n, below[active], above[active], free)
        correction = t @ solver((t.T @ k @ t).tocsc(), t.T @ load)
        now = u + correction
        force = upper.contact_force(now[:m])
        opening = now[above] - now[below]
        following = np.where(active, force > 0.0, opening < 0.0)
        if np.array_equal(following, active):
            force[~active] = 0.0
            return (upper, lower), (now[:m], now[m:]), force, step
        active = following
    raise RuntimeError(f"the active set still changes after {max_steps} steps")


def main():
    solver, nx, ny = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    start = time.perf_counter()
    bodies, u, force, steps = solve(nx, ny, SOLVERS[solver])
    seconds = time.perf_counter() - start
    print(
        json.dumps(
            {
                "seconds": seconds,
                "steps": steps,
                "energies": [body.energy(v) for body, v in zip(bodies, u)],
                "contact_force": float(force.sum()),
                "memory_bytes": process.peak(),
                "blas": process.blas(),
            }
        )
    )


if __name__ == "__main__":
    main()
