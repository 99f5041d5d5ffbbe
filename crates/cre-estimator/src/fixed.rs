//! The part of a cell's stress that no traction changes: quadratic stresses under a linear body force, and the linear part of `σ̂` under heat.
//!
//! A body force `b(x) = b̄ + B ξ`, `ξ = x − c` about the centroid of the cell, is carried by a polynomial, as `b̄` is by a linear one:
//! ```math
//! Q = −diag_i(½ B_ii ξ_i² + ∑_{j≠i} B_ij ξ_i ξ_j),   div Q = −B ξ
//! ```
//! Its tractions are quadratic along facets. The Johnson-Mercier stress takes the linear functions with the same moments; what is left of a traction, its
//! bubble, is the same on both sides of a facet between cells of one `B`. Where a traction is given, and between cells of different `B`, a stress `κ`
//! removes it: quadratic in the parts of the cell, symmetric, without divergence, continuous across the inner facets. There are several; the one of least
//! `∫ κ : κ` on the regular cell is taken, and mapped as the Johnson-Mercier stress is: so it does not depend on the order of the corners.
//!
//! In the distance `‖τ − σ̂‖²` all other fields are linear in the parts, and the compliance is constant in the cell: of `Q + κ` only the projection on
//! linear fields meets them, and the rest adds a constant.

use fem_core::body::{Body, FacetCondition, arms};
use fem_core::dense::pseudo_inverse;
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::space::Space;
use nalgebra::{Cholesky, DMatrix};
use std::sync::OnceLock;

/// Singular values up to this fraction of the largest are zero: 51 of 54 rows are independent in the plane, 222 of 228 in space.
const RANK: f64 = 1e-9;

/// What is fixed in the stress of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FixedPart<S: Space> {
    /// The tractions of `Q` at the corners of each facet, times its measure: of the linear functions with the same moments, N/m in the plane, N in
    /// space.
    pub(crate) loads: S::Corners<S::Axes<S::Vector>>,
    /// What is added to the linear stress in `τ − σ̂`, with the mean of `σ̂`: at the corners of the facet of each part and at the centroid, Pa.
    pub(crate) offset: S::Corners<S::Corners<S::Tensor>>,
    /// The square that the quadratic rest adds, J/m in the plane, J in space.
    pub(crate) energy: f64,
}

impl<S: Space> Default for FixedPart<S> {
    fn default() -> Self {
        Self {
            loads: S::corners(|_| S::ZEROS),
            offset: S::corners(|_| S::corners(|_| S::Tensor::default())),
            energy: 0.0,
        }
    }
}

/// A quadratic tensor on a part of a cell, `Σ λ_v at_v + Σ 4 λ_i λ_j bow_ij`: corners of the part's facet, then the centroid; pairs of them in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quadratic<S: Space> {
    pub(crate) at: S::Corners<S::Tensor>,
    pub(crate) bow: S::Components<S::Tensor>,
}

/// Lists the pairs of some numbers in order.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

/// Computes the value at corner `v` of the linear function with the moments of `4 λ_i λ_j`, on a simplex of a dimension.
fn share(dimension: usize, v: usize, (i, j): (usize, usize)) -> f64 {
    let n = dimension as f64;
    (if v == i || v == j { 8.0 } else { 4.0 }) / (n + 3.0) - 4.0 / (n + 2.0)
}

/// Computes the mean of `Π λ_v` over a simplex of a dimension.
fn mean_product(dimension: usize, corners: &[usize]) -> f64 {
    let times = |v: usize| corners.iter().filter(|c| **c == v).count();
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let powers: f64 = (0..=dimension).map(|v| factorial(times(v))).product();
    factorial(dimension) * powers / factorial(dimension + corners.len())
}

/// Adds multiples of tensors.
fn sum<S: Space>(tensor: S::Tensor, factor: f64, other: S::Tensor) -> S::Tensor {
    let [a, b]: [S::Components<f64>; 2] = [tensor.into(), other.into()];
    S::components(|k| a[k] + factor * b[k]).into()
}

/// Computes what is fixed in the stress of a cell; `None` if there is nothing.
///
/// * `conditions`: of the boundary facets.
pub(crate) fn fixed<S: Space>(
    body: &Body<S>,
    cell: usize,
    conditions: &[FacetCondition<S>],
) -> Option<FixedPart<S>> {
    let mut found = FixedPart::<S>::default();
    if body.has_heat() {
        let heat = body.heat_beyond_mean(cell);
        for part in 0..=S::DIM {
            let corners = S::facet(part);
            (0..S::DIM).for_each(|v| found.offset[part][v] = heat[corners[v]]);
        }
    }
    let Some(parts) = quadratic(body, cell, conditions) else { return body.has_heat().then_some(found) };
    for (part, normal) in (0..=S::DIM).map(|part| (part, normal(body, cell, part))) {
        let own = particular(body, cell, part);
        found.loads[part] = S::axes(|v| {
            let bows = pairs(S::DIM).zip(facet_bows(&own));
            let linear = bows.fold(own.at[v], |t, (pair, bow)| sum::<S>(t, share(S::DIM - 1, v, pair), bow));
            S::applied(linear, normal)
        });
        let Quadratic { at, bow } = parts[part];
        let linear = S::corners(|v| {
            let bows = pairs(S::DIM + 1).zip(bow);
            bows.fold(at[v], |t, (pair, bow)| sum::<S>(t, share(S::DIM, v, pair), bow))
        });
        (0..=S::DIM).for_each(|v| {
            let before = found.offset[part][v];
            found.offset[part][v] = sum::<S>(before, 1.0, linear[v]);
        });
        found.energy += rest(body, cell, &bow);
    }
    Some(found)
}

/// Lists the bows between the corners of the facet of a part.
fn facet_bows<S: Space>(of: &Quadratic<S>) -> impl Iterator<Item = S::Tensor> {
    let bows = pairs(S::DIM + 1).zip(of.bow);
    bows.filter(|((_, j), _)| *j < S::DIM).map(|(_, bow)| bow)
}

/// Integrates the square of what quadratic fields have beyond their linear projection, over a part.
fn rest<S: Space>(body: &Body<S>, cell: usize, bow: &S::Components<S::Tensor>) -> f64 {
    let entries = (0..S::COMPONENTS).flat_map(|p| (0..S::COMPONENTS).map(move |q| (p, q)));
    let terms = entries.zip(&Bubbles::get::<S>().rest);
    let sum: f64 = terms.map(|((p, q), rest)| rest * body.material(cell).complementary(bow[p], bow[q])).sum();
    sum * body.mesh().measure(cell) / (S::DIM + 1) as f64
}

/// Computes the normal of a facet of a cell, times its measure.
fn normal<S: Space>(body: &Body<S>, cell: usize, facet: usize) -> S::Vector {
    let all = body.mesh().corners(cell);
    let own = S::facet(facet);
    let corners = S::axes(|k| all[own[k]]);
    S::facet_normal(&corners) * S::facet_measure(&corners)
}

/// Computes `Q` on a part.
fn particular<S: Space>(body: &Body<S>, cell: usize, part: usize) -> Quadratic<S> {
    let slope = body.force(cell).gradient;
    let (arms, corners) = (arms::<S>(&body.mesh().corners(cell)), S::facet(part));
    // The bilinear form of −Q.
    let form = |a: S::Vector, b: S::Vector| -> S::Tensor {
        S::components(|i| {
            let of_axis = |j: usize| {
                let factor = if i == j { 0.5 * a[i] * b[i] } else { 0.5 * (a[i] * b[j] + a[j] * b[i]) };
                -slope[j][i] * factor
            };
            if i < S::DIM { (0..S::DIM).map(of_axis).sum() } else { 0.0 }
        })
        .into()
    };
    let place = |v: usize| if v < S::DIM { arms[corners[v]] } else { S::Vector::ZERO };
    let mut list = pairs(S::DIM + 1);
    Quadratic {
        at: S::corners(|v| form(place(v), place(v))),
        // −⅛ of the second derivative along the edge.
        bow: S::components(|_| {
            let (i, j) = list.next().unwrap_or_default();
            let along = place(j) - place(i);
            sum::<S>(S::Tensor::default(), -0.25, form(along, along))
        }),
    }
}

/// Computes `Q + κ` on the parts of a cell; `None` if the body force is constant there.
pub(crate) fn quadratic<S: Space>(
    body: &Body<S>,
    cell: usize,
    conditions: &[FacetCondition<S>],
) -> Option<S::Corners<Quadratic<S>>> {
    if !body.has_varying_force() || body.force(cell).is_constant() {
        return None;
    }
    let mut parts = S::corners(|part| particular(body, cell, part));
    let bubbles: Vec<S::Vector> = (0..=S::DIM)
        .flat_map(|part| {
            let normal = normal(body, cell, part);
            let bows: Vec<S::Tensor> = facet_bows(&parts[part]).collect();
            bows.into_iter().map(move |bow| -removed(body, (cell, part), conditions, S::applied(bow, normal)))
        })
        .collect();
    if bubbles.iter().any(|bubble| *bubble != S::Vector::ZERO) {
        Bubbles::get::<S>().add::<S>(&body.mesh().corners(cell), &bubbles, &mut parts);
    }
    Some(parts)
}

/// Returns the part of a traction's bubble that must vanish: on the boundary where the traction is given or springs carry it, and all of it between different forces.
fn removed<S: Space>(
    body: &Body<S>,
    (cell, part): (usize, usize),
    conditions: &[FacetCondition<S>],
    bubble: S::Vector,
) -> S::Vector {
    let topology = body.mesh().topology();
    let facet = topology.cell_facets()[cell][part];
    if topology.is_boundary(facet) {
        // The tractions of springs are linear in the bound.
        return conditions[topology.boundary_place(facet)].given_or_on_springs().project(bubble);
    }
    let [a, b] = topology.facet_cells()[facet].map(|cell| body.force(cell as usize).gradient);
    if a == b { S::Vector::ZERO } else { bubble }
}

/// The stresses `κ` of the regular cell for each bubble on its facets.
#[derive(Debug)]
struct Bubbles {
    /// For each facet, pair of its corners and axis: parts, then corners and pairs of corners, then components.
    columns: Vec<Vec<f64>>,
    /// The means of the products of two functions `4 λ_i λ_j` less their linear projections, by rows.
    rest: Vec<f64>,
}

/// The numbers of a part: corners and pairs of them.
fn functions<S: Space>() -> usize {
    S::DIM + 1 + S::COMPONENTS
}

/// Places the corners of the regular cell with edges of length 1: each new one above the centroid of those before.
fn regular<S: Space>() -> S::Corners<S::Vector> {
    let mut corners = S::corners(|_| S::Vector::ZERO);
    for k in 1..=S::DIM {
        let centre = corners.as_ref()[..k].iter().copied().sum::<S::Vector>() / k as f64;
        let height = (1.0 - (corners[0] - centre).length().powi(2)).sqrt();
        corners[k] = centre + S::AXES[k - 1] * height;
    }
    corners
}

/// Linear equations for the unknowns of a cell.
struct Equations<S: Space> {
    corners: S::Corners<S::Vector>,
    rows: Vec<Vec<f64>>,
    right: Vec<Vec<f64>>,
}

impl<S: Space> Equations<S> {
    /// The first unknown of a function on a part.
    fn unknown(part: usize, function: usize) -> usize {
        (part * functions::<S>() + function) * S::COMPONENTS
    }

    /// The place of a pair of corners among the functions.
    fn pair(i: usize, j: usize) -> usize {
        let sought = (i.min(j), i.max(j));
        S::DIM + 1 + pairs(S::DIM + 1).take_while(|pair| *pair != sought).count()
    }

    /// Adds a row for each axis: `Σ factor τ n`, each term by part and function.
    fn add(&mut self, terms: &[((usize, usize), S::Vector)], right: &[(usize, f64)]) {
        let columns = (S::DIM + 1) * S::DIM * (S::DIM - 1) / 2;
        for axis in 0..S::DIM {
            let mut row = vec![0.0; (S::DIM + 1) * functions::<S>() * S::COMPONENTS];
            for ((part, function), n) in terms {
                let first = Self::unknown(*part, *function);
                (0..S::DIM).for_each(|j| row[first + S::component(axis, j)] += n[j]);
            }
            let mut sums = vec![0.0; columns * S::DIM];
            right.iter().for_each(|(column, factor)| sums[column * S::DIM + axis] += factor);
            self.rows.push(row);
            self.right.push(sums);
        }
    }

    /// The corners of a part: of its facet, then the centroid.
    fn part(&self, part: usize) -> S::Corners<S::Vector> {
        let (own, arms) = (S::facet(part), arms::<S>(&self.corners));
        S::corners(|v| if v < S::DIM { arms[own[v]] } else { S::Vector::ZERO })
    }

    /// The tractions on the outer facets are the bubbles.
    fn outer(&mut self) {
        for part in 0..=S::DIM {
            let of_part = self.part(part);
            let corners = S::axes(|k| of_part[k]);
            let normal = S::facet_normal(&corners) * S::facet_measure(&corners);
            let first = part * pairs(S::DIM).count();
            for v in 0..S::DIM {
                let linear =
                    pairs(S::DIM).enumerate().map(|(k, pair)| (first + k, -share(S::DIM - 1, v, pair)));
                self.add(&[((part, v), normal)], &linear.collect::<Vec<_>>());
            }
            for (k, (i, j)) in pairs(S::DIM).enumerate() {
                self.add(&[((part, Self::pair(i, j)), normal)], &[(first + k, 1.0)]);
            }
        }
    }

    /// The tractions on the inner facets are continuous.
    fn inner(&mut self) {
        for (first, second) in pairs(S::DIM + 1) {
            let (own, other) = (S::facet(first), S::facet(second));
            let shared = (0..S::DIM)
                .filter_map(|i| Some((i, other.as_ref().iter().position(|corner| *corner == own[i])?)));
            let shared: Vec<(usize, usize)> = shared.chain([(S::DIM, S::DIM)]).collect();
            let of_part = self.part(first);
            let corners = S::axes(|k| of_part[shared[k].0]);
            let normal = S::facet_normal(&corners);
            for (i, j) in &shared {
                self.add(&[((first, *i), normal), ((second, *j), -normal)], &[]);
            }
            for (k, l) in pairs(shared.len()) {
                let functions = [Self::pair(shared[k].0, shared[l].0), Self::pair(shared[k].1, shared[l].1)];
                self.add(&[((first, functions[0]), normal), ((second, functions[1]), -normal)], &[]);
            }
        }
    }

    /// The divergence, linear on each part, vanishes at its corners.
    fn divergence(&mut self) {
        for part in 0..=S::DIM {
            let gradients = Element::<S>::new(self.part(part)).gradients;
            for v in 0..=S::DIM {
                let linear = (0..=S::DIM).map(|w| ((part, w), gradients[w]));
                let others = (0..=S::DIM).filter(|w| *w != v);
                let bows = others.map(|w| ((part, Self::pair(v, w)), gradients[w] * 4.0));
                self.add(&linear.chain(bows).collect::<Vec<_>>(), &[]);
            }
        }
    }
}

/// Computes the means of the products of the functions of a part, for all unknowns of a cell: shears count twice.
fn mass<S: Space>() -> DMatrix<f64> {
    let corners = |function: usize| match function.checked_sub(S::DIM + 1) {
        None => (1.0, vec![function]),
        Some(k) => {
            let (i, j) = pairs(S::DIM + 1).nth(k).unwrap_or_default();
            (4.0, vec![i, j])
        }
    };
    let count = functions::<S>();
    let size = (S::DIM + 1) * count * S::COMPONENTS;
    DMatrix::from_fn(size, size, |row, column| {
        let of = |unknown: usize| {
            let (function, component) = (unknown / S::COMPONENTS, unknown % S::COMPONENTS);
            (function / count, function % count, component)
        };
        let ((part, f, component), (other, g, same)) = (of(row), of(column));
        if part != other || component != same {
            return 0.0;
        }
        let ((a, mut both), (b, more)) = (corners(f), corners(g));
        both.extend(more);
        let weight = if component < S::DIM { 1.0 } else { 2.0 };
        weight * a * b * mean_product(S::DIM, &both)
    })
}

impl Bubbles {
    /// Returns the stresses of a space.
    fn get<S: Space>() -> &'static Self {
        /// Of the plane and of the space.
        static BUBBLES: [OnceLock<Bubbles>; 2] = [OnceLock::new(), OnceLock::new()];
        BUBBLES[S::DIM - 2].get_or_init(Self::new::<S>)
    }

    /// Solves the equations on the regular cell.
    fn new<S: Space>() -> Self {
        let mut equations = Equations::<S> { corners: regular::<S>(), rows: Vec::new(), right: Vec::new() };
        equations.outer();
        equations.inner();
        equations.divergence();
        let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        let (a, right) = (matrix(&equations.rows), matrix(&equations.right));
        // With M = L Lᵀ the least |y| gives x = L⁻ᵀ y.
        let Some(factor) = Cholesky::new(mass::<S>()) else { unreachable!("the mass is not positive") };
        let lower = factor.l();
        let solved = lower.solve_lower_triangular(&a.transpose()).map(|columns| columns.transpose());
        let Some(scaled) = solved else { unreachable!("the mass has a pivot that is zero") };
        let largest = scaled.clone().singular_values().max();
        let inverse = pseudo_inverse(scaled, RANK * largest);
        let found = inverse.and_then(|inverse| lower.tr_solve_lower_triangular(&(inverse * right)));
        // The matrices are constants.
        let Some(found) = found else { unreachable!("the regular cell has no stress for bubbles") };
        let rest = |(p, q): ((usize, usize), (usize, usize))| {
            let linear =
                (0..=S::DIM).map(|v| share(S::DIM, v, p) * 4.0 * mean_product(S::DIM, &[v, q.0, q.1]));
            16.0 * mean_product(S::DIM, &[p.0, p.1, q.0, q.1]) - linear.sum::<f64>()
        };
        let both = pairs(S::DIM + 1).flat_map(|p| pairs(S::DIM + 1).map(move |q| (p, q)));
        let rest = both.map(rest).collect();
        Self { rest, columns: found.column_iter().map(|column| column.iter().copied().collect()).collect() }
    }

    /// Adds the stresses of some bubbles to those of the parts of a cell.
    ///
    /// * `bubbles`: for each facet and pair of its corners the traction between these beyond the linear one, times the measure of the facet.
    fn add<S: Space>(
        &self,
        corners: &S::Corners<S::Vector>,
        bubbles: &[S::Vector],
        parts: &mut S::Corners<Quadratic<S>>,
    ) {
        let reference = regular::<S>();
        let (to, from) = (Element::<S>::new(reference), Element::<S>::new(*corners));
        let arms = arms::<S>(corners);
        let map = |points: &S::Corners<S::Vector>, element: &Element<S>, v: S::Vector| -> S::Vector {
            points.into_iter().zip(element.gradients).map(|(x, g)| x * g.times(&v)).sum()
        };
        let columns = S::axes(|a| map(&arms, &to, S::AXES[a]));
        let mut sums = vec![0.0; self.columns[0].len()];
        for (k, bubble) in bubbles.iter().enumerate() {
            let pulled_back = map(&reference, &from, *bubble);
            for axis in 0..S::DIM {
                let factor = pulled_back[axis];
                sums.iter_mut().zip(&self.columns[k * S::DIM + axis]).for_each(|(s, x)| *s += factor * x);
            }
        }
        let scale = to.measure / from.measure;
        // F τ̂ Fᵀ over the ratio of the measures.
        let pushed = |at: usize| -> S::Tensor {
            let mut tensor = S::components(|_| 0.0);
            for (i, j) in (0..S::DIM).flat_map(|i| (i..S::DIM).map(move |j| (i, j))) {
                let entries = (0..S::DIM).flat_map(|a| (0..S::DIM).map(move |b| (a, b)));
                let terms =
                    entries.map(|(a, b)| columns[a][i] * sums[at + S::component(a, b)] * columns[b][j]);
                tensor[S::component(i, j)] = scale * terms.sum::<f64>();
            }
            tensor.into()
        };
        for part in 0..=S::DIM {
            let first = |function: usize| Equations::<S>::unknown(part, function);
            for v in 0..=S::DIM {
                let before = parts[part].at[v];
                parts[part].at[v] = sum::<S>(before, 1.0, pushed(first(v)));
            }
            for k in 0..S::COMPONENTS {
                let before = parts[part].bow[k];
                parts[part].bow[k] = sum::<S>(before, 1.0, pushed(first(S::DIM + 1 + k)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
