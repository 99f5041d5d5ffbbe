//! Operations and bytes of the phases, from the sizes alone. The page of `cargo xtask bench --limits` states the formulas.

use crate::record::Count;
use contact_qp::QpPath;
use cre_estimator::StarRelaxation;
use fem_core::assembly::System;
use fem_core::cholesky::SymbolicCholesky;
use fem_core::dof::DofMap;
use fem_core::mesh::TriMesh;
use fem_core::ordering::{ROOT, dissect};
use nndd::IterationRow;

const REAL: f64 = 8.0;
/// A number of a node, a triangle or an edge.
const INDEX: f64 = 4.0;

/// Sizes of a mesh.
struct Sizes {
    nodes: f64,
    triangles: f64,
    edges: f64,
}

impl Sizes {
    fn of(mesh: &TriMesh) -> Self {
        let [nodes, triangles, edges] =
            [mesh.points().len(), mesh.cells().len(), mesh.topology().facets().len()].map(|n| n as f64);
        Self { nodes, triangles, edges }
    }

    /// Points, and corners of triangles.
    fn mesh(&self) -> f64 {
        2.0 * REAL * self.nodes + 3.0 * INDEX * self.triangles
    }

    /// The neighbours of all nodes: ends of edges are read, the list is written and read.
    fn neighbours(&self) -> f64 {
        3.0 * 2.0 * INDEX * self.edges
    }

    /// The mesh, edges of triangles, ends and triangles of edges, moments of edges, and one stress per triangle.
    fn stress(&self) -> f64 {
        let edges = (2.0 + 2.0) * INDEX + 4.0 * REAL;
        self.mesh() + (3.0 * INDEX + 3.0 * REAL) * self.triangles + edges * self.edges
    }
}

/// Every cut reads number and point of the nodes of its part, and writes their numbers; the list of neighbours is made from the edges, and
/// read near the cuts.
pub(crate) fn dissection(mesh: &TriMesh) -> Count {
    let parts = dissect(mesh).parts;
    let mut depth = vec![1.0; parts.len()];
    let mut visits = 0.0;
    // Parents come after their children.
    for (k, part) in parts.iter().enumerate().rev() {
        if part.parent != ROOT {
            depth[k] += depth[part.parent as usize];
        }
        visits += depth[k] * part.nodes.len() as f64;
    }
    let visit = 2.0 * INDEX + 2.0 * REAL;
    Count { flops: 0.0, bytes: visit * visits + Sizes::of(mesh).neighbours() }
}

/// Three columns `A Bᵀ D B` of 56 operations in each triangle; mesh, triangles around nodes and neighbours are read, the matrix is written.
pub(crate) fn assembly(mesh: &TriMesh, system: &System) -> Count {
    let sizes = Sizes::of(mesh);
    let (n, entries) = (system.load.len() as f64, system.stiffness.values.len() as f64);
    let lists = 3.0 * INDEX * sizes.triangles + sizes.neighbours();
    let read = sizes.mesh() + lists + 2.0 * INDEX * sizes.nodes;
    let written = (INDEX + REAL) * entries + (INDEX + REAL) * n;
    Count { flops: 3.0 * 56.0 * sizes.triangles, bytes: read + written }
}

/// Rows of the matrix are read; rows of the fronts are written once and read twice.
pub(crate) fn analysis(system: &System, symbolic: &SymbolicCholesky) -> Count {
    let rows: f64 = symbolic.front_sizes().map(|[_, below]| below as f64).sum();
    Count { flops: 0.0, bytes: INDEX * (system.stiffness.values.len() as f64 + 3.0 * rows) }
}

/// Partial factors of the fronts; the matrix is read, the factor written, every update written and read.
pub(crate) fn factorisation(system: &System, symbolic: &SymbolicCholesky) -> Count {
    let updates: f64 = symbolic.front_sizes().map(|[_, b]| 0.5 * (b * (b + 1)) as f64).sum();
    let matrix = (INDEX + REAL) * system.stiffness.values.len() as f64;
    let bytes = matrix + REAL * (symbolic.stored_values() as f64 + 2.0 * updates);
    Count { flops: symbolic.operations(), bytes }
}

/// `S = L_CC L_CCᵀ` and one forward substitution.
pub(crate) fn condensation(symbolic: &SymbolicCholesky, dofs: &DofMap) -> Count {
    let (stored, n, n_c) = (symbolic.stored_values() as f64, dofs.len() as f64, dofs.interface_len() as f64);
    Count { flops: n_c.powi(3) / 3.0 + 2.0 * stored, bytes: REAL * (stored + 3.0 * n + 3.0 * n_c * n_c) }
}

/// Products and substitutions with matrices of the interface, and the factors of the contact problem's free unknowns.
pub(crate) fn iteration(n_c: usize, lanczos: usize, rows: &[IterationRow]) -> Count {
    let square = (n_c * n_c) as f64;
    let mut count = Count::default();
    let mut products = 4.0 * lanczos as f64;
    for row in rows {
        products += 4.0;
        let sets = match row.qp_path {
            QpPath::WarmStart | QpPath::ActiveSet => row.qp_iterations,
            // The last set; the interior-point steps are not counted.
            _ => 1,
        };
        let free = (n_c - row.contact_nodes.min(n_c)) as f64;
        let sets = sets as f64;
        products += 2.0 * sets + 1.0;
        count.flops += sets * (free.powi(3) / 3.0 + 2.0 * free * free);
        count.bytes += sets * REAL * 2.0 * free * free;
    }
    count.flops += 2.0 * products * square;
    count.bytes += REAL * products * square;
    count
}

/// One substitution, of which the interface's part is known if `trace`.
pub(crate) fn substitution(stored: usize, dofs: &DofMap, trace: bool) -> Count {
    let n_c = if trace { dofs.interface_len() } else { 0 };
    let values = stored as f64 - 0.5 * (n_c * (n_c + 1)) as f64;
    Count { flops: 2.0 * values, bytes: REAL * (values + 4.0 * dofs.len() as f64) }
}

/// The stress of a displacement: that and the mesh are read, three numbers per triangle are written.
pub(crate) fn stress(mesh: &TriMesh) -> Count {
    let sizes = Sizes::of(mesh);
    Count { flops: 0.0, bytes: sizes.mesh() + 2.0 * REAL * sizes.nodes + 3.0 * REAL * sizes.triangles }
}

/// Mesh, stress and triangles around nodes are read, moments are written.
pub(crate) fn eet(mesh: &TriMesh) -> Count {
    let sizes = Sizes::of(mesh);
    Count { flops: 0.0, bytes: sizes.stress() + 3.0 * INDEX * sizes.triangles }
}

/// Operations for the Johnson-Mercier stress of a triangle: a 27×12 product, and the maps of loads and stresses.
const CELL: f64 = 2.0 * 27.0 * 12.0 + 312.0;

/// Counts the work for the stress of each triangle and its distance to the element's stress: four strains in each of three parts.
pub(crate) fn johnson_mercier(mesh: &TriMesh) -> Count {
    let sizes = Sizes::of(mesh);
    Count { flops: (CELL + 318.0) * sizes.triangles, bytes: sizes.stress() }
}

/// The stress of each triangle; what is done with it is not counted.
pub(crate) fn checks(mesh: &TriMesh) -> Count {
    let sizes = Sizes::of(mesh);
    Count { flops: CELL * sizes.triangles, bytes: sizes.stress() }
}

/// The unknowns of the stars of a mesh, and what they store.
pub(crate) struct Stars {
    /// Spokes and colour of every vertex.
    stars: Vec<(f64, u32)>,
    /// The share of coefficients that are stored, lanes of batches that are not full included.
    own: f64,
    sizes: Sizes,
}

impl Stars {
    pub(crate) fn new(mesh: &TriMesh, prepared: &StarRelaxation<'_>) -> Self {
        let mut spokes = vec![0.0; mesh.points().len()];
        for node in mesh.topology().facets().as_flattened() {
            spokes[*node] += 1.0;
        }
        let own = (prepared.stored_couplings() as f64 / spokes.iter().sum::<f64>()).min(1.0);
        Self {
            own,
            stars: spokes.into_iter().zip(prepared.colours().iter().copied()).collect(),
            sizes: Sizes::of(mesh),
        }
    }

    fn unknowns(&self) -> f64 {
        3.0 * self.sizes.nodes + self.sizes.edges
    }

    /// One visit of a star: its share of a batch and three numbers per spoke; if they are its own, 23 couplings per spoke and a packed block in
    /// single precision.
    fn visit(&self, spokes: f64) -> Count {
        let size = spokes + 3.0;
        let coefficients = 23.0 * spokes + 0.5 * size * (size + 1.0);
        let bytes = 6.0 + 3.0 * INDEX * spokes + self.own * 4.0 * coefficients;
        Count { flops: 45.0 * spokes + 2.0 * size * size, bytes }
    }

    /// 1866 operations for the form of a triangle, `s³` for the inverse of a star of `s` unknowns, if they are their own; blocks are written.
    pub(crate) fn set_up(&self) -> Count {
        let mut count = Count { flops: self.own * 1866.0 * self.sizes.triangles, bytes: self.sizes.mesh() };
        for &(spokes, _) in &self.stars {
            let size = spokes + 3.0;
            count.flops += self.own * size.powi(3);
            count.bytes += self.visit(spokes).bytes + self.own * 0.5 * size * (size + 1.0) * 4.0;
        }
        count
    }

    /// The stress of each triangle with seven strains in each of three parts, and a 27×12 product of their sums. The moments
    /// are read; the residual is written and divided by the unit of the stars, and three vectors are made.
    pub(crate) fn start(&self) -> Count {
        Count {
            flops: (CELL + 480.0 + 810.0) * self.sizes.triangles,
            bytes: self.sizes.stress() + 6.0 * REAL * self.unknowns(),
        }
    }

    /// Counts the work of some steps. Each visits every star twice in its two sweeps, the stars of the last colour once, and all stars
    /// once more for `A p`; the first visit of the first colour needs its blocks alone. It passes over the vectors 22 times.
    pub(crate) fn sweeps(&self, steps: usize) -> Count {
        let last = self.stars.iter().map(|(_, colour)| *colour).max().unwrap_or(0);
        let visits = |colour: u32| if colour == last { 2.0 } else { 3.0 };
        let all = Count::sum(self.stars.iter().map(|&(spokes, colour)| {
            let Count { flops, bytes } = self.visit(spokes);
            Count { flops: visits(colour) * flops, bytes: visits(colour) * bytes }
        }));
        let (unknowns, steps) = (self.unknowns(), steps as f64);
        Count {
            flops: steps * (all.flops + 10.0 * unknowns),
            bytes: steps * (all.bytes + 22.0 * REAL * unknowns),
        }
    }
}
