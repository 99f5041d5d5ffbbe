"""The two blocks of the paper's problem, assembled by scikit-fem.

The upper block (0,2)x(1,2) (E = 2000) rolls on x = 0, is pressed down by 0.02 along its top and carries the traction
(0, 30) on x = 2; the lower block (0,2)x(0,1) (E = 1000) is clamped along its base. Plane strain, nu = 0.3, P1 triangles,
each rectangle cut from its lower left to its upper right corner.
"""

import numpy as np
from skfem import Basis, ElementTriP1, ElementVector, FacetBasis, LinearForm, MeshTri, asm
from skfem.models.elasticity import lame_parameters, linear_elasticity

YOUNG = (2000.0, 1000.0)
POISSON = 0.3
PRESSED = -0.02
TRACTION = 30.0


class Block:
    """One block: mesh, stiffness `k`, load `f`, imposed unknowns with their values, and the unknowns on y = 1."""

    def __init__(self, nx, ny, upper):
        bottom = 1.0 if upper else 0.0
        x, y = np.meshgrid(np.linspace(0.0, 2.0, nx + 1), bottom + np.linspace(0.0, 1.0, ny + 1))
        i, j = np.meshgrid(np.arange(nx), np.arange(ny))
        a = (j * (nx + 1) + i).ravel()
        b, c, d = a + 1, a + nx + 2, a + nx + 1
        triangles = np.hstack([[a, b, c], [a, c, d]])
        self.mesh = MeshTri(np.vstack([x.ravel(), y.ravel()]), triangles)
        element = ElementVector(ElementTriP1())
        # Strains are constant, so one point integrates the stiffness.
        basis = Basis(self.mesh, element, intorder=0)
        young = YOUNG[0] if upper else YOUNG[1]
        self.k = asm(linear_elasticity(*lame_parameters(young, POISSON)), basis)
        self.f = np.zeros(basis.N)
        nodes = self.mesh.p
        unknowns = basis.nodal_dofs
        if upper:
            side = FacetBasis(self.mesh, element, facets=self.mesh.facets_satisfying(lambda p: p[0] == 2.0), intorder=1)
            self.f = asm(LinearForm(lambda v, w: TRACTION * v[1]), side)
            left, top = unknowns[0, nodes[0] == 0.0], unknowns[1, nodes[1] == 2.0]
            self.imposed = np.concatenate([left, top])
            self.values = np.concatenate([np.zeros(len(left)), np.full(len(top), PRESSED)])
        else:
            self.imposed = unknowns[:, nodes[1] == 0.0].ravel()
            self.values = np.zeros(len(self.imposed))
        on_contact = np.flatnonzero(nodes[1] == 1.0)
        on_contact = on_contact[np.argsort(nodes[0, on_contact])]
        self.contact = unknowns[1, on_contact]
        self.vertical = unknowns[1]
        self.horizontal = unknowns[0]

    def energy(self, u):
        """a(u, u), without a factor one half."""
        return float(u @ (self.k @ u))

    def contact_force(self, u):
        """The vertical nodal forces that the other block exerts on y = 1."""
        return (self.k @ u - self.f)[self.contact]


def blocks(nx, ny):
    """The upper and the lower block."""
    return Block(nx, ny, True), Block(nx, ny, False)
