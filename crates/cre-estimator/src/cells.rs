//! The Johnson-Mercier stresses of several triangles side by side, and what the bound and its checks need of them.

use crate::equilibrated::{EquilibratedStress, subtract};
use crate::johnson_mercier::{recovery, without_body_force};
use crate::lanes::{LaneRow, Lanes, Pair, Tensor, apply, contract, cross, dot, less, load_pair, turned};
use fem_core::body::Body;
use fem_core::parallel::each_task;
use fem_core::tensor::SymTensor2;
use pulp::Simd;
use std::ops::Range;

/// Nodes of the stress of a triangle: corner `m` of part `k` is node `3k + m`, as in [`crate::johnson_mercier::CellStress`].
const NODES: usize = 9;

/// The edges of some triangles and their materials, gathered from the mesh.
#[derive(Default)]
pub(crate) struct Geometry {
    /// From corner 0 to corners 1 and 2, m.
    edges: [[LaneRow; 2]; 2],
    /// `E⁻¹` in Voigt form, the upper half by rows, 1/Pa.
    compliance: [LaneRow; 6],
}

impl Geometry {
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, body: &Body, t: usize) {
        let corners = body.mesh().corners(t);
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        for (rows, edge) in self.edges.iter_mut().zip(edges) {
            (rows[0][lane], rows[1][lane]) = (edge[0], edge[1]);
        }
        for (row, c) in self.compliance.iter_mut().zip(body.material(t).compliance_entries()) {
            row[lane] = c;
        }
    }

    #[inline(always)]
    pub(crate) fn edges<S: Simd>(&self, simd: S) -> [Pair<S>; 2] {
        [load_pair(simd, &self.edges[0]), load_pair(simd, &self.edges[1])]
    }

    #[inline(always)]
    pub(crate) fn compliance<S: Simd>(&self, simd: S) -> Compliance<S> {
        let mut entries = [Lanes::splat(simd, 0.0); 6];
        for (entry, row) in entries.iter_mut().zip(&self.compliance) {
            *entry = Lanes::load(simd, row);
        }
        Compliance(entries)
    }
}

/// Some triangles and the loads on their edges.
#[derive(Default)]
pub(crate) struct Gathered {
    pub(crate) geometry: Geometry,
    /// Loads on the edges without what carries the body force, N/m: edge, end, component.
    loads: [LaneRow; 12],
    /// The mean body force, N/m³; not set without one.
    force: Option<[LaneRow; 2]>,
    fixed: Option<FixedRows>,
}

/// What is fixed in the stresses of some triangles, see [`crate::fixed`].
#[derive(Default)]
struct FixedRows {
    /// Tractions times length of the quadratic part, N/m: edge, end, component.
    loads: [LaneRow; 12],
    /// Added to `τ − σ̂` at the nodes, Pa.
    offset: [[LaneRow; 3]; NODES],
    /// Added to the energy, J/m.
    energy: LaneRow,
}

impl Gathered {
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, body: &Body, stress: &EquilibratedStress, t: usize) {
        self.geometry.set(lane, body, t);
        let mut loads = stress.cell_loads(body, t);
        if body.has_force() {
            let force = body.force(t).mean;
            loads = without_body_force(body.mesh().corners(t), &loads, force);
            let rows = self.force.get_or_insert_default();
            (rows[0][lane], rows[1][lane]) = (force[0], force[1]);
        }
        if body.has_heat() || body.has_varying_force() {
            let fixed = stress.fixed(body, t).unwrap_or_default();
            subtract(&mut loads, &fixed.loads);
            let rows = self.fixed.get_or_insert_default();
            for (rows, load) in rows.loads.chunks_exact_mut(2).zip(fixed.loads.as_flattened()) {
                (rows[0][lane], rows[1][lane]) = (load[0], load[1]);
            }
            for (rows, offset) in rows.offset.iter_mut().zip(fixed.offset.as_flattened()) {
                set_tensor(rows, lane, *offset);
            }
            rows.energy[lane] = fixed.energy;
        }
        for (rows, load) in self.loads.chunks_exact_mut(2).zip(loads.as_flattened()) {
            (rows[0][lane], rows[1][lane]) = (load[0], load[1]);
        }
    }
}

/// `E⁻¹` of a material per lane.
#[derive(Clone, Copy)]
pub(crate) struct Compliance<S: Simd>([Lanes<S>; 6]);

impl<S: Simd> Compliance<S> {
    /// Computes the strain of a stress.
    #[inline(always)]
    pub(crate) fn strain(&self, s: Tensor<S>) -> Tensor<S> {
        let [c11, c12, c13, c22, c23, c33] = self.0;
        [
            (c11 * s[0]).plus(c12, s[1]).plus(c13, s[2]),
            (c12 * s[0]).plus(c22, s[1]).plus(c23, s[2]),
            0.5 * (c13 * s[0]).plus(c23, s[1]).plus(c33, s[2]),
        ]
    }

    /// Computes `σ : E⁻¹ σ`.
    #[inline(always)]
    fn energy(&self, s: Tensor<S>) -> Lanes<S> {
        contract(s, self.strain(s))
    }
}

/// The stresses of some triangles.
pub(crate) struct Cells<S: Simd> {
    simd: S,
    /// From corner 0 to corners 1 and 2, m.
    pub(crate) edges: [Pair<S>; 2],
    /// Twice the area, m².
    pub(crate) jacobian: Lanes<S>,
    pub(crate) compliance: Compliance<S>,
    /// At the [`NODES`], Pa; if the body force varies in a triangle, without the quadratic part.
    pub(crate) stress: [Tensor<S>; NODES],
    /// N/m³.
    force: Option<Pair<S>>,
    fixed: Option<Fixed<S>>,
}

/// What is fixed in the stresses of some triangles.
#[derive(Clone, Copy)]
struct Fixed<S: Simd> {
    loads: [[Pair<S>; 2]; 3],
    offset: [Tensor<S>; NODES],
    energy: Lanes<S>,
}

impl<S: Simd> Fixed<S> {
    #[inline(always)]
    fn load(simd: S, rows: &FixedRows) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let mut fixed = Self {
            loads: [[[zero; 2]; 2]; 3],
            offset: [[zero; 3]; NODES],
            energy: Lanes::load(simd, &rows.energy),
        };
        for (pair, rows) in fixed.loads.as_flattened_mut().iter_mut().zip(rows.loads.as_chunks().0) {
            *pair = load_pair(simd, rows);
        }
        for (tensor, rows) in fixed.offset.iter_mut().zip(&rows.offset) {
            *tensor = load_tensor(simd, rows);
        }
        fixed
    }
}

/// The residuals of some triangles and the forces on their edges.
pub(crate) struct Residuals<S: Simd> {
    /// The largest square of a force without balance inside the triangle, N²/m²; NaN if one of them is.
    pub(crate) equilibrium: Lanes<S>,
    /// Tractions times length at the two ends of each edge, N/m.
    pub(crate) forces: [[Pair<S>; 2]; 3],
}

impl<S: Simd> Cells<S> {
    /// Computes the stresses, see [`crate::johnson_mercier::cell_stress`].
    #[inline(always)]
    pub(crate) fn new(simd: S, gathered: &Gathered) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let [a, b] = gathered.geometry.edges(simd);
        let jacobian = cross(a, b);
        let inverse = Lanes::splat(simd, 1.0).over(jacobian);
        // The loads on the reference triangle.
        let mut reference = [zero; 12];
        for i in 0..6 {
            let g =
                [Lanes::load(simd, &gathered.loads[2 * i]), Lanes::load(simd, &gathered.loads[2 * i + 1])];
            reference[2 * i] = inverse * (b[1] * g[0] - b[0] * g[1]);
            reference[2 * i + 1] = inverse * (a[0] * g[1] - a[1] * g[0]);
        }
        let recovery = recovery();
        let mut stress = [[zero; 3]; NODES];
        for (component, row) in stress.as_flattened_mut().iter_mut().zip(recovery) {
            let mut sum = row[0] * reference[0];
            for l in 1..12 {
                sum = sum.plus_times(row[l], reference[l]);
            }
            *component = sum;
        }
        // F τ̂ Fᵀ with F = [a b].
        for s in &mut stress {
            let [xx, yy, xy] = *s;
            let fa = [a[0] * xx + b[0] * xy, a[1] * xx + b[1] * xy];
            let fb = [a[0] * xy + b[0] * yy, a[1] * xy + b[1] * yy];
            *s = [
                inverse * (fa[0] * a[0] + fb[0] * b[0]),
                inverse * (fa[1] * a[1] + fb[1] * b[1]),
                inverse * (fa[0] * a[1] + fb[0] * b[1]),
            ];
        }
        let compliance = gathered.geometry.compliance(simd);
        let mut cells = Self { simd, edges: [a, b], jacobian, compliance, stress, force: None, fixed: None };
        if let Some(rows) = &gathered.force {
            cells.carry(load_pair(simd, rows));
        }
        if let Some(rows) = &gathered.fixed {
            cells.fixed = Some(Fixed::load(simd, rows));
        }
        cells
    }

    /// Adds the stress that carries the mean body force; it vanishes at the barycentre.
    #[inline(always)]
    fn carry(&mut self, force: Pair<S>) {
        self.force = Some(force);
        let (corners, centre) = (self.corners(), self.centre());
        for k in 0..3 {
            for m in 0..2 {
                let d = less(corners[(k + m) % 3], centre);
                for c in 0..2 {
                    self.stress[3 * k + m][c] = self.stress[3 * k + m][c] - force[c] * d[c];
                }
            }
        }
    }

    /// The corners relative to the first one: far from the origin their differences would be round-off.
    #[inline(always)]
    fn corners(&self) -> [Pair<S>; 3] {
        [[Lanes::splat(self.simd, 0.0); 2], self.edges[0], self.edges[1]]
    }

    #[inline(always)]
    fn centre(&self) -> Pair<S> {
        let [a, b] = self.edges;
        [1.0 / 3.0 * (a[0] + b[0]), 1.0 / 3.0 * (a[1] + b[1])]
    }

    /// Checks the equilibrium inside the triangles.
    #[inline(always)]
    pub(crate) fn residuals(&self) -> Residuals<S> {
        let zero = Lanes::splat(self.simd, 0.0);
        let (corners, centre) = (self.corners(), self.centre());
        // The sum of the squares tells whether one of them is NaN.
        let (mut largest, mut sum) = (zero, zero);
        let mut take = |force: Pair<S>| {
            let square = dot(force, force);
            largest = largest.max(square);
            sum += square;
        };
        let third = 1.0 / 6.0 * self.jacobian;
        let load = self.force.map_or([zero; 2], |force| [force[0] * third, force[1] * third]);
        let mut forces = [[[zero; 2]; 2]; 3];
        for k in 0..3 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let own = [self.stress[3 * k], self.stress[3 * k + 1], self.stress[3 * k + 2]];
            // The divergence times the area of the part: half the stress at each corner on the side opposite to it.
            let mut balance = load;
            for (s, side) in own.into_iter().zip([less(centre, q), less(p, centre), less(q, p)]) {
                let force = apply(s, turned(self.simd, side));
                balance = [balance[0] - 0.5 * force[0], balance[1] - 0.5 * force[1]];
            }
            take(balance);
            // The inner edge at corner k, between part k and the part before it.
            let inner = turned(self.simd, less(centre, p));
            for (m, other) in [(0, 1), (2, 2)] {
                let before = self.stress[3 * ((k + 2) % 3) + other];
                let jump = [own[m][0] - before[0], own[m][1] - before[1], own[m][2] - before[2]];
                take(apply(jump, inner));
            }
            let normal = turned(self.simd, less(q, p));
            forces[k] = [apply(own[0], normal), apply(own[1], normal)];
        }
        if let Some(fixed) = &self.fixed {
            for (force, load) in forces.as_flattened_mut().iter_mut().zip(fixed.loads.as_flattened()) {
                *force = [force[0] + load[0], force[1] + load[1]];
            }
        }
        Residuals { equilibrium: largest + 0.0 * sum, forces }
    }

    /// Computes `∫ (τ − σ) : E⁻¹ (τ − σ)` for a σ by its mean, J/m.
    #[inline(always)]
    pub(crate) fn distance_squared(&self, constant: Tensor<S>) -> Lanes<S> {
        self.energy(&self.less(constant)) + self.rest()
    }

    /// Computes `τ − σ` at the nodes for a σ by its mean.
    #[inline(always)]
    pub(crate) fn less(&self, constant: Tensor<S>) -> [Tensor<S>; NODES] {
        let mut d = self.stress;
        for s in &mut d {
            for c in 0..3 {
                s[c] = s[c] - constant[c];
            }
        }
        if let Some(fixed) = &self.fixed {
            for (s, offset) in d.iter_mut().zip(&fixed.offset) {
                for c in 0..3 {
                    s[c] += offset[c];
                }
            }
        }
        d
    }

    /// The energy that is fixed, J/m.
    #[inline(always)]
    fn rest(&self) -> Lanes<S> {
        match &self.fixed {
            Some(fixed) => fixed.energy,
            None => Lanes::splat(self.simd, 0.0),
        }
    }

    /// Computes `∫ d : E⁻¹ d` of a stress by its values at the nodes, J/m: see [`crate::johnson_mercier::distance_squared`].
    #[inline(always)]
    fn energy(&self, d: &[Tensor<S>; NODES]) -> Lanes<S> {
        let mut sum = Lanes::splat(self.simd, 0.0);
        for k in 0..3 {
            for m in 0..3 {
                sum += self.compliance.energy(d[3 * k + m]);
            }
            sum += self.compliance.energy(total(d, k));
        }
        0.5 / 36.0 * (self.jacobian * sum)
    }

    /// Computes `∫ σ : E⁻¹ σ` of a constant stress, J/m.
    #[inline(always)]
    pub(crate) fn energy_of(&self, constant: Tensor<S>) -> Lanes<S> {
        0.5 * (self.jacobian * self.compliance.energy(constant))
    }

    /// Computes `∫ d : E⁻¹ d`, J/m, and its derivative by the loads on the reference triangle, halved.
    #[inline(always)]
    pub(crate) fn gradient(&self, d: &[Tensor<S>; NODES]) -> (Lanes<S>, [Lanes<S>; 12]) {
        let zero = Lanes::splat(self.simd, 0.0);
        let dyads = dyads(self.edges);
        let scale = Lanes::splat(self.simd, 0.5 / 36.0);
        let recovery = recovery();
        let (mut energy, mut loads) = (zero, [zero; 12]);
        for k in 0..3 {
            let total = total(d, k);
            energy += self.compliance.energy(total);
            for node in 3 * k..3 * k + 3 {
                let own = d[node];
                energy += self.compliance.energy(own);
                let strain =
                    self.compliance.strain([own[0] + total[0], own[1] + total[1], own[2] + total[2]]);
                for (c, dyad) in dyads.into_iter().enumerate() {
                    let weight = contract(strain, dyad);
                    for (load, factor) in loads.iter_mut().zip(&recovery[3 * node + c]) {
                        *load = load.plus_times(*factor, weight);
                    }
                }
            }
        }
        // τ = F τ̂ Fᵀ/J, and the integral has the factor J/72.
        for load in &mut loads {
            *load = scale * *load;
        }
        (scale * self.jacobian * energy + self.rest(), loads)
    }

    /// Adds up the nine stresses of the three parts in double-double numbers, Pa: high parts, then low ones. What varies with the temperature in `σ`
    /// has no mean.
    #[inline(always)]
    pub(crate) fn sum(&self) -> [Tensor<S>; 2] {
        let mut high = self.stress[0];
        let mut low = [Lanes::splat(self.simd, 0.0); 3];
        let fixed: &[Tensor<S>] = self.fixed.as_ref().map_or(&[], |fixed| &fixed.offset);
        for term in self.stress[1..].iter().chain(fixed) {
            for c in 0..3 {
                let (a, b) = (high[c], term[c]);
                let sum = a + b;
                let share = sum - a;
                let rest = low[c] + ((a - (sum - share)) + (b - share));
                high[c] = sum + rest;
                low[c] = rest - (high[c] - sum);
            }
        }
        [high, low]
    }
}

/// Computes `a⊗a`, `b⊗b` and `a⊗b + b⊗a`.
#[inline(always)]
pub(crate) fn dyads<S: Simd>([a, b]: [Pair<S>; 2]) -> [Tensor<S>; 3] {
    [
        [a[0] * a[0], a[1] * a[1], a[0] * a[1]],
        [b[0] * b[0], b[1] * b[1], b[0] * b[1]],
        [2.0 * (a[0] * b[0]), 2.0 * (a[1] * b[1]), a[0] * b[1] + a[1] * b[0]],
    ]
}

/// Adds up a stress at the corners of part `k`.
#[inline(always)]
fn total<S: Simd>(d: &[Tensor<S>; NODES], k: usize) -> Tensor<S> {
    let [a, b, c] = [d[3 * k], d[3 * k + 1], d[3 * k + 2]];
    // Not by a closure: it would be compiled for the oldest processor.
    [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]]
}

/// A constant stress per triangle, gathered from the mesh.
#[inline(always)]
pub(crate) fn load_tensor<S: Simd>(simd: S, rows: &[LaneRow; 3]) -> Tensor<S> {
    [Lanes::load(simd, &rows[0]), Lanes::load(simd, &rows[1]), Lanes::load(simd, &rows[2])]
}

#[inline(always)]
pub(crate) fn set_tensor(rows: &mut [LaneRow; 3], lane: usize, s: SymTensor2) {
    (rows[0][lane], rows[1][lane], rows[2][lane]) = (s.xx, s.yy, s.xy);
}

/// Triangles of one task.
const CHUNK: usize = 4096;

/// Computes `‖τ − σ̂‖²` over a body, J/m, in tasks of fixed size.
pub(crate) fn distance_squared(body: &Body, stress: &EquilibratedStress) -> f64 {
    let triangles = stress.finite_element.len();
    let sums = each_task(triangles.div_ceil(CHUNK), |k| {
        let triangles = k * CHUNK..triangles.min((k + 1) * CHUNK);
        pulp::Arch::new().dispatch(Distance { body, stress, triangles })
    });
    sums.iter().sum()
}

/// `‖τ − σ̂‖²` of some triangles.
struct Distance<'a> {
    body: &'a Body,
    stress: &'a EquilibratedStress,
    triangles: Range<usize>,
}

impl pulp::WithSimd for Distance<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { body, stress, triangles } = self;
        let (mut gathered, mut finite_element) = (Gathered::default(), [LaneRow::default(); 3]);
        let mut sum = 0.0;
        for first in triangles.clone().step_by(S::F64_LANES) {
            let group = first..triangles.end.min(first + S::F64_LANES);
            for (lane, t) in group.clone().enumerate() {
                gathered.set(lane, body, stress, t);
                set_tensor(&mut finite_element, lane, stress.finite_element[t]);
            }
            let cells = Cells::new(simd, &gathered);
            let mut distances = LaneRow::default();
            cells.distance_squared(load_tensor(simd, &finite_element)).store(&mut distances);
            // One by one: the sum does not depend on the number of lanes.
            distances[..group.len()].iter().for_each(|distance| sum += distance);
        }
        sum
    }
}
