//! Quadratic triangles: a reference that shares neither its element nor its solver with the program.
//!
//! It solves problems whose two bodies touch along the whole of a line `y = const`, where the vertical displacements of
//! both are then the same unknowns, and says whether they are pressed together everywhere. Rollers and single imposed
//! components must be along an axis.
//!
//! The potential energy `J(u) = ½ a(u, u) − ℓ(u)` of its solutions on finer and finer meshes is extrapolated. Of a field `v`
//! that touches along the whole line as well, `‖u − v‖² = 2 (J(v) − J(u))`: nothing else of the reference is needed.

use crate::finer::halve;
use crate::model::{Body, ContactProblem, Made, SymTensor2, Vector};
use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use fem_core::element::Triangle;
use std::collections::HashMap;

/// The condition on one displacement component at a node.
#[derive(Clone, Copy, Debug, Default)]
enum Component {
    #[default]
    Free,
    Imposed(f64),
    /// The same unknown as another node's.
    Shared(usize),
}

/// A body with nodes in the middle of its edges: node `n`, then `points + edge`.
struct Quadratic<'a> {
    body: &'a Body,
    components: Vec<[Component; 2]>,
    load: Vec<Vector>,
}

impl<'a> Quadratic<'a> {
    fn new(body: &'a Body) -> Made<Self> {
        let mesh = body.mesh();
        let (points, edges) = (mesh.points().len(), mesh.topology().facets());
        let mut components = vec![[Component::Free; 2]; points + edges.len()];
        let mut load = vec![Vector::zeros(); points + edges.len()];
        let mut known = vec![Vector::zeros(); points];
        for (n, constraint) in body.node_constraints().iter().enumerate() {
            if constraint.rigid_side.is_some() {
                return Err("rigid sides are not supported here".into());
            }
            for (direction, value) in constraint.components() {
                let c = axis(direction)?;
                known[n][c] = value * direction[c];
                components[n][c] = Component::Imposed(known[n][c]);
            }
        }
        for (&edge, condition) in mesh.topology().boundary_facets().iter().zip(body.facet_conditions()) {
            let ends = edges[edge].map(|n| n.index());
            let middle = points + edge.index();
            let held = |c: usize| Component::Imposed(0.5 * (known[ends[0]][c] + known[ends[1]][c]));
            for direction in condition.reaction.basis() {
                let c = axis(*direction)?;
                components[middle][c] = held(c);
            }
            // ∫ F φ of a traction linear along the edge, by Simpson's rule: exact for cubics.
            let length = mesh.facet_measure(edge);
            let [a, b] = condition.traction;
            load[ends[0]] += length / 6.0 * a;
            load[ends[1]] += length / 6.0 * b;
            load[middle] += length / 3.0 * (a + b);
        }
        // ∫ φ is zero at the corners and a third of the area at the middles.
        for (t, triangle) in mesh.topology().cell_facets().iter().enumerate() {
            for &edge in triangle {
                let share = mesh.measure(t) / 3.0 * body.force(t).mean;
                load[points + edge.index()] += share;
            }
        }
        Ok(Self { body, components, load })
    }

    /// Nodes of a triangle: its corners, then the middles of its edges.
    fn nodes(&self, t: usize) -> [usize; 6] {
        let mesh = self.body.mesh();
        let (corners, edges) = (mesh.cells()[t], mesh.topology().cell_facets()[t]);
        std::array::from_fn(|k| match k {
            0..3 => corners[k].index(),
            _ => mesh.points().len() + edges[k - 3].index(),
        })
    }

    /// Gradients of the six shape functions at the middle of each edge, where the quadrature of a triangle is exact for quadratics.
    fn gradients(&self, t: usize) -> [[Vector; 6]; 3] {
        let linear = Triangle::new(self.body.mesh().corners(t)).gradients;
        std::array::from_fn(|q| {
            let mut l = [0.5; 3];
            l[(q + 2) % 3] = 0.0;
            std::array::from_fn(|k| match k {
                0..3 => (4.0 * l[k] - 1.0) * linear[k],
                _ => {
                    let [a, b] = [k - 3, (k - 2) % 3];
                    4.0 * (l[a] * linear[b] + l[b] * linear[a])
                }
            })
        })
    }
}

fn axis(direction: Vector) -> Made<usize> {
    let found = (0..2).find(|&c| direction[1 - c].abs() < 1e-12);
    found.ok_or_else(|| format!("a support along {direction:?} is along no axis").into())
}

/// Strain of a unit displacement along `c` of a shape function.
fn strain(gradient: Vector, c: usize) -> SymTensor2 {
    let mut e = SymTensor2::default();
    let [x, y] = gradient.into();
    match c {
        0 => (e.xx, e.xy) = (x, 0.5 * y),
        _ => (e.yy, e.xy) = (y, 0.5 * x),
    }
    e
}

/// Potential energy of the solution by quadratic triangles on the problem's meshes, J/m.
///
/// # Errors
/// A problem that is not of the kind described above, or whose bodies pull at each other somewhere.
pub fn potential_energy(problem: &ContactProblem) -> Made<f64> {
    let mut bodies = [Quadratic::new(&problem.bodies[0])?, Quadratic::new(&problem.bodies[1])?];
    let contact = share(problem, &mut bodies)?;
    let offset = bodies[0].components.len();
    // Numbers of the unknowns.
    let mut number = vec![[None; 2]; offset + bodies[1].components.len()];
    let mut count = 0;
    for (n, components) in bodies[0].components.iter().chain(&bodies[1].components).enumerate() {
        for c in 0..2 {
            match components[c] {
                Component::Free => {
                    number[n][c] = Some(count);
                    count += 1;
                }
                Component::Shared(other) => number[n][c] = number[other][c],
                Component::Imposed(_) => {}
            }
        }
    }
    let mut u: Vec<Vector> = vec![Vector::zeros(); number.len()];
    for (n, components) in bodies[0].components.iter().chain(&bodies[1].components).enumerate() {
        for c in 0..2 {
            if let Component::Imposed(value) = components[c] {
                u[n][c] = value;
            }
        }
    }
    let (mut entries, mut right) = (Vec::new(), vec![0.0; count]);
    for (b, quadratic) in bodies.iter().enumerate() {
        for (n, f) in quadratic.load.iter().enumerate() {
            for c in 0..2 {
                if let Some(i) = number[b * offset + n][c] {
                    right[i] += f[c];
                }
            }
        }
        for_entries(quadratic, |t_nodes, [a, c], [d, e], k| {
            let [n, m] = [a, d].map(|x| b * offset + t_nodes[x]);
            let Some(i) = number[n][c] else { return };
            match number[m][e] {
                Some(j) => entries.push(Triplet::new(i, j, k)),
                None => right[i] -= k * u[m][e],
            }
        });
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(count, count, &entries)
        .map_err(|e| format!("the matrix of the reference: {e:?}"))?;
    let factor =
        matrix.sp_cholesky(Side::Lower).map_err(|e| format!("the factor of the reference: {e:?}"))?;
    let solution = factor.solve(faer::ColRef::from_slice(&right));
    for (u, number) in u.iter_mut().zip(&number) {
        for c in 0..2 {
            if let Some(i) = number[c] {
                u[c] = solution[i];
            }
        }
    }
    let (mut energy, mut work, mut force) = (0.0, 0.0, vec![0.0; offset]);
    for (b, quadratic) in bodies.iter().enumerate() {
        let own = &u[b * offset..];
        work += quadratic.load.iter().zip(own).map(|(f, u)| f[0] * u[0] + f[1] * u[1]).sum::<f64>();
        for_entries(quadratic, |nodes, [a, c], [d, e], k| {
            let part = k * own[nodes[d]][e];
            energy += own[nodes[a]][c] * part;
            if b == 0 && c == 1 {
                force[nodes[a]] += part;
            }
        });
    }
    // Forces in the middle of edges have the sign of the mean pressure there.
    let side = problem.contacts[0].interface.pairs()[0].normal[1];
    if contact.iter().any(|&n| force[n] * side > 0.0) {
        return Err("the bodies of the reference pull at each other".into());
    }
    Ok(0.5 * energy - work)
}

/// Calls `act` with the nodes of each triangle, two of its unknowns as corner and component, and their stiffness.
fn for_entries(quadratic: &Quadratic<'_>, mut act: impl FnMut(&[usize; 6], [usize; 2], [usize; 2], f64)) {
    let mesh = quadratic.body.mesh();
    for t in 0..mesh.cells().len() {
        let (nodes, gradients) = (quadratic.nodes(t), quadratic.gradients(t));
        let (weight, material) = (mesh.measure(t) / 3.0, quadratic.body.material(t));
        for column in 0..12 {
            let [d, e] = [column / 2, column % 2];
            let stresses = gradients.map(|g| material.stress(strain(g[d], e)));
            for row in 0..12 {
                let [a, c] = [row / 2, row % 2];
                let k: f64 =
                    (0..3).map(|q| stresses[q].contract(strain(gradients[q][a], c))).sum::<f64>() * weight;
                act(&nodes, [a, c], [d, e], k);
            }
        }
    }
}

/// Makes the vertical displacements of facing nodes the same unknowns; returns the middles of the first body's contact edges.
fn share(problem: &ContactProblem, bodies: &mut [Quadratic<'_>; 2]) -> Made<Vec<usize>> {
    let mut facing: HashMap<usize, usize> = HashMap::new();
    for pair in problem.contacts[0].interface.pairs() {
        if pair.normal[0].abs() > 1e-12 || pair.gap != 0.0 {
            return Err("the contact line of the reference is level and closed".into());
        }
        facing.insert(pair.nodes[1].index(), pair.nodes[0].index());
    }
    let points = [0, 1].map(|b| problem.bodies[b].mesh().points().len());
    let edges = problem.contacts[0].interface.facets().iter();
    let middles: Vec<[usize; 2]> = edges.map(|e| [0, 1].map(|b| points[b] + e.facets[b].index())).collect();
    facing.extend(middles.iter().map(|[first, second]| (*second, *first)));
    for (second, first) in facing {
        bodies[1].components[second][1] = Component::Shared(first);
    }
    Ok(middles.iter().map(|m| m[0]).collect())
}

/// Extrapolates the potential energy on four meshes, the given one and three times halved: `J₃ − d²/(1 − d)·…` by Aitken, from
/// the last three.
///
/// Returns the energies and the limit.
///
/// # Errors
/// See [`potential_energy`].
pub fn extrapolated(problem: &ContactProblem, halvings: usize) -> Made<(Vec<f64>, f64)> {
    let mut energies = vec![potential_energy(problem)?];
    let mut finer = problem.clone();
    for _ in 0..halvings {
        finer = halve(&finer)?.problem;
        energies.push(potential_energy(&finer)?);
    }
    let [.., a, b, c] = energies[..] else { return Err("an extrapolation needs three meshes".into()) };
    let limit = if (c - b).abs() < (b - a).abs() { c - (c - b).powi(2) / ((c - b) - (b - a)) } else { c };
    Ok((energies, limit))
}
