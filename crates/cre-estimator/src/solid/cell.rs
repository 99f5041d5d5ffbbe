//! Johnson-Mercier stresses: a tetrahedron in four parts around its barycentre.
//!
//! In each part the stress is linear, in the whole tetrahedron it is free of sources, and tractions are continuous across the inner faces.
//! It is determined by the moments `m_{Γ,j} = ∫_Γ (τ n) φ_j` on the four faces, if forces and moments are in equilibrium. On the
//! reference tetrahedron that is one matrix for all; with `x = F x̂ + x₀` it is mapped by
//! ```math
//! m̂ = F⁻¹ m,   τ = F τ̂ Fᵀ/|det F|
//! ```
//! Source: Gopalakrishnan, Guzman and Lee 2024, after Johnson and Mercier 1978.

use fem_core::body::Body;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};
use std::sync::OnceLock;

/// Moments of the tractions on the faces of a cell about the corners of each, N: faces and corners in the order of [`Space::facet`].
pub(crate) type CellMoments = [[Vector3<f64>; 3]; 4];

/// The stress at the three corners of the face of each part and at the barycentre, Pa.
pub(crate) type CellStress = [[SymTensor3; 4]; 4];

/// Moments of a cell, as numbers.
pub(crate) const MOMENTS: usize = 36;

/// Stresses of a cell, as numbers.
const STRESSES: usize = 96;

/// Numbers of a face.
pub(crate) const FACE: usize = 9;

/// Entries of the block of two faces in a matrix for the moments.
pub(crate) const BLOCK: usize = FACE * FACE;

/// Pairs of components of a stress.
pub(crate) const PAIRS: usize = 21;

/// The fixed matrices of the reference tetrahedron.
pub(crate) struct Reference {
    /// The stress for each moment, column by column.
    stress: Vec<[f64; STRESSES]>,
    /// The same, row by row.
    transposed: Vec<[f64; MOMENTS]>,
    /// The energy of two moments for each pair of components, `∫ τ̂_a τ̂_b` and its mirror image, over the volume: a block by rows for each face
    /// and every one up to it.
    pub(crate) energy: Vec<[[f64; PAIRS]; BLOCK]>,
}

/// `∫ λ_v λ_w` of two corners of a part, over the volume of the whole cell.
fn weight(v: usize, w: usize) -> f64 {
    if v == w { 0.025 } else { 0.0125 }
}

/// Lists the pairs of components in order.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|a| (a..6).map(move |b| (a, b)))
}

/// The equations of the reference tetrahedron for its 96 stresses: 36 moments, then 66 conditions.
struct Equations {
    rows: Vec<[f64; STRESSES]>,
}

impl Equations {
    /// Adds the three components of `factor τ n`, for the stress at a corner of a part, to the last three rows.
    fn add(&mut self, (part, corner): (usize, usize), n: Vector3<f64>, factor: f64) {
        let first = self.rows.len() - 3;
        for (i, row) in self.rows[first..].iter_mut().enumerate() {
            for j in 0..3 {
                row[6 * (4 * part + corner) + Solid::component(i, j)] += factor * n[j];
            }
        }
    }

    fn new() -> Self {
        let corner = |k: usize| k.checked_sub(1).map_or(Vector3::zeros(), |axis| Solid::AXES[axis]);
        let middle = Vector3::from_element(0.25);
        let points = |part: usize| {
            let [a, b, c] = Solid::facet(part).map(corner);
            [a, b, c, middle]
        };
        let mut equations = Self { rows: Vec::new() };
        let next = |equations: &mut Self| equations.rows.extend([[0.0; STRESSES]; 3]);
        for part in 0..4 {
            let [a, b, c, _] = points(part);
            let normal = (b - a).cross(&(c - a)) / 2.0;
            for j in 0..3 {
                next(&mut equations);
                (0..3).for_each(|k| equations.add((part, k), normal, if j == k { 2.0 } else { 1.0 } / 12.0));
            }
        }
        for (first, second) in (0..4).flat_map(|s| (s + 1..4).map(move |t| (s, t))) {
            let (corners, others) = (Solid::facet(first), Solid::facet(second));
            let shared: Vec<(usize, usize)> = (0..3)
                .filter_map(|i| Some((i, others.iter().position(|other| *other == corners[i])?)))
                .chain([(3, 3)])
                .collect();
            let [a, b] = [0, 1].map(|k: usize| points(first)[shared[k].0] - middle);
            for (i, j) in shared {
                next(&mut equations);
                equations.add((first, i), a.cross(&b), 1.0);
                equations.add((second, j), a.cross(&b), -1.0);
            }
        }
        for part in 0..4 {
            let corners = points(part);
            let gradients = Solid::gradients(&corners, Solid::measure(&corners));
            next(&mut equations);
            (0..4).for_each(|v| equations.add((part, v), gradients[v], 1.0));
        }
        equations
    }
}

impl Reference {
    fn new() -> Self {
        let equations = Equations::new();
        let rows = equations.rows.len();
        // The columns are independent; moments in equilibrium satisfy all rows, others in the least squares.
        let qr = DMatrix::from_fn(rows, STRESSES, |i, j| equations.rows[i][j]).qr();
        let q = qr.q();
        let mut stress = DMatrix::from_fn(STRESSES, MOMENTS, |i, j| q[(j, i)]);
        qr.r().solve_upper_triangular_mut(&mut stress);
        let stress: Vec<[f64; STRESSES]> =
            stress.column_iter().map(|column| std::array::from_fn(|i| column[i])).collect();
        let pairs = (0..4).flat_map(|k| (0..=k).map(move |l| (FACE * k, FACE * l)));
        let block = |(i, j)| std::array::from_fn(|k| Self::energy(&stress, i + k / FACE, j + k % FACE));
        let energy = pairs.map(block).collect();
        let transposed = (0..STRESSES).map(|i| std::array::from_fn(|k| stress[k][i])).collect();
        Self { stress, transposed, energy }
    }

    /// Computes the entries of two moments.
    fn energy(stress: &[[f64; STRESSES]], i: usize, j: usize) -> [f64; PAIRS] {
        let mut sums = [0.0; PAIRS];
        for (sum, (a, b)) in sums.iter_mut().zip(pairs()) {
            for part in 0..4 {
                for (v, w) in (0..4).flat_map(|v| (0..4).map(move |w| (v, w))) {
                    let at =
                        |moment: usize, corner: usize, c: usize| stress[moment][6 * (4 * part + corner) + c];
                    let both = at(i, v, a) * at(j, w, b) + at(i, v, b) * at(j, w, a);
                    *sum += weight(v, w) * if a == b { 0.5 * both } else { both };
                }
            }
        }
        sums
    }

    pub(crate) fn get() -> &'static Self {
        static REFERENCE: OnceLock<Reference> = OnceLock::new();
        REFERENCE.get_or_init(Self::new)
    }
}

/// The sum of some rows times factors.
struct Sum<'a, const N: usize> {
    rows: &'a [[f64; N]],
    factors: &'a [f64],
}

impl<const N: usize> pulp::NullaryFnOnce for Sum<'_, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn call(self) -> [f64; N] {
        let mut sums = [0.0; N];
        for (row, factor) in self.rows.iter().zip(self.factors) {
            for (sum, x) in sums.iter_mut().zip(row) {
                *sum += factor * x;
            }
        }
        sums
    }
}

/// The map from the reference tetrahedron to a cell.
pub(crate) struct CellMap {
    /// `F⁻¹`.
    inverse: Matrix3<f64>,
    /// The components of `F T Fᵀ/|det F|` for each component of T, as columns.
    tensor: Matrix6<f64>,
    /// V, m³.
    volume: f64,
}

impl CellMap {
    /// Computes the map of a cell of positive volume; NaN if the volume is zero, so that it stays visible.
    pub(crate) fn new([o, a, b, c]: [Vector3<f64>; 4]) -> Self {
        let f = Matrix3::from_columns(&[a - o, b - o, c - o]);
        let determinant = f.determinant();
        let mut tensor = Matrix6::zeros();
        for (k, l) in (0..3).flat_map(|k| (0..=k).map(move |l| (k, l))) {
            for (i, j) in (0..3).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let mirrored = if k == l { 0.0 } else { f[(i, l)] * f[(j, k)] };
                tensor[(Solid::component(i, j), Solid::component(k, l))] =
                    (f[(i, k)] * f[(j, l)] + mirrored) / determinant;
            }
        }
        let inverse = f.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
        Self { inverse, tensor, volume: determinant / 6.0 }
    }

    /// Computes the stress with given moments of its tractions, without a body force.
    pub(crate) fn stress(&self, moments: &CellMoments) -> CellStress {
        let mut mapped = [0.0; MOMENTS];
        for (mapped, moment) in mapped.chunks_exact_mut(3).zip(moments.iter().flatten()) {
            mapped.copy_from_slice((self.inverse * moment).as_slice());
        }
        let sums = pulp::Arch::new().dispatch(Sum { rows: &Reference::get().stress, factors: &mapped });
        std::array::from_fn(|part| {
            std::array::from_fn(|v| {
                let first = 6 * (4 * part + v);
                let mapped = self.tensor * Vector6::from_column_slice(&sums[first..first + 6]);
                SymTensor3::from(<[f64; 6]>::from(mapped))
            })
        })
    }

    /// Maps a moment to the reference tetrahedron, `F⁻¹ m`.
    pub(crate) fn pulled_back(&self, moment: Vector3<f64>) -> Vector3<f64> {
        self.inverse * moment
    }

    /// Computes the factors of the fixed matrices [`Reference::energy`] in the energy `∫ τ : C⁻¹ : τ` of moments on the reference tetrahedron.
    ///
    /// * `compliance`: the strain of a stress; `unit`: of the energy.
    pub(crate) fn factors(&self, compliance: impl Fn(SymTensor3) -> SymTensor3, unit: f64) -> [f64; PAIRS] {
        let mapped: [SymTensor3; 6] =
            std::array::from_fn(|k| <[f64; 6]>::from(self.tensor.column(k).into_owned()).into());
        let strains = mapped.map(compliance);
        let mut factors = [0.0; PAIRS];
        for (factor, (a, b)) in factors.iter_mut().zip(pairs()) {
            *factor = self.volume * Solid::contracted(mapped[a], strains[b]) / unit;
        }
        factors
    }

    /// Computes the derivatives of `∫ JM(m) : ε` by the moments, for strains that are linear in each part.
    pub(crate) fn work(&self, strains: &CellStress) -> CellMoments {
        let mut pulled = [0.0; STRESSES];
        for (part, strains) in strains.iter().enumerate() {
            let at = strains.map(|strain| Vector6::from(<[f64; 6]>::from(strain)));
            for v in 0..4 {
                let mean: Vector6<f64> = (0..4).map(|w| weight(v, w) * at[w]).sum();
                // Shears count twice.
                let doubled = Vector6::from_fn(|k, _| if k < 3 { mean[k] } else { 2.0 * mean[k] });
                let back = self.tensor.tr_mul(&doubled) * self.volume;
                pulled[6 * (4 * part + v)..][..6].copy_from_slice(back.as_slice());
            }
        }
        let products =
            pulp::Arch::new().dispatch(Sum { rows: &Reference::get().transposed, factors: &pulled });
        std::array::from_fn(|face| {
            std::array::from_fn(|j| {
                let first = 3 * (3 * face + j);
                self.inverse.tr_mul(&Vector3::from_column_slice(&products[first..first + 3]))
            })
        })
    }
}

/// Computes the stress that balances a constant body force and has no mean, at the corners of a cell: `−diag(b_i (x_i − c_i))`.
pub(crate) fn particular(corners: &[Vector3<f64>; 4], body_force: Vector3<f64>) -> [SymTensor3; 4] {
    let middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
    corners.map(|x| {
        let [xx, yy, zz] = [0, 1, 2].map(|i: usize| -body_force[i] * (x[i] - middle[i]));
        SymTensor3 { xx, yy, zz, ..SymTensor3::default() }
    })
}

/// Computes the moments of the tractions of a stress that is linear in a cell.
pub(crate) fn moments_of(corners: &[Vector3<f64>; 4], stress: &[SymTensor3; 4]) -> CellMoments {
    std::array::from_fn(|face| {
        let nodes = Solid::facet(face);
        let [a, b, c] = nodes.map(|k| corners[k]);
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let tractions = nodes.map(|k| Solid::applied(stress[k], normal));
        let sum = tractions[0] + tractions[1] + tractions[2];
        tractions.map(|t| (sum + t) / 12.0)
    })
}

/// Computes `∫ (τ − σ̂) : C⁻¹ : (τ − σ̂)` in a cell, J.
pub(crate) fn distance_squared(
    stress: &CellStress,
    constant: SymTensor3,
    volume: f64,
    compliance: impl Fn(SymTensor3) -> SymTensor3,
) -> f64 {
    let mut sum = 0.0;
    for part in stress {
        let differences = part.map(|at| at.minus(constant));
        let strains = differences.map(&compliance);
        for (v, w) in (0..4).flat_map(|v| (0..4).map(move |w| (v, w))) {
            sum += weight(v, w) * Solid::contracted(differences[v], strains[w]);
        }
    }
    volume * sum
}

/// The order of the face moments of a cell: for each corner of each face its place on the face, and the sign of the face.
pub(crate) fn order(body: &Body<Solid>, cell: usize) -> [([usize; 3], f64); 4] {
    let mesh = body.mesh();
    let (corners, topology) = (mesh.cells()[cell], mesh.topology());
    std::array::from_fn(|k| {
        let face = topology.cell_facets()[cell][k];
        let nodes = topology.facets()[face];
        let place = |corner: usize| nodes.iter().filter(|node| **node < corners[corner]).count();
        let sign = if topology.facet_cells()[face][0] as usize == cell { 1.0 } else { -1.0 };
        (Solid::facet(k).map(place), sign)
    })
}

#[cfg(test)]
mod tests;
