//! The difference between data given as functions and their linear interpolants on facets.
//!
//! Displacements are interpolated at the nodes, tractions become linear by their moments. The difference changes
//! the problem, and a bound of the discretisation error does not include it.

use super::facet_functions::linear_by_moments;
use super::{Body, ConditionList, ConditionPlace};
use crate::boundary::{Load, ScalarData, SpringCondition, SpringRest, Support};
use crate::parallel::each_task;
use crate::quadrature::GAUSS5;
use crate::space::{SAMPLED_PARTS as PARTS, Space};

/// Below this part of the largest value a difference is round-off: the data are linear along the edges.
const ROUND_OFF: f64 = 1e-12;

/// Edges that one thread sums at a time; the result does not depend on the number of threads.
const CHUNK: usize = 16;

/// Points at which a datum of the plane is compared with its linear interpolant on every edge, besides the two ends.
pub const SAMPLES: usize = PARTS * GAUSS5.len();

/// How far one datum is from its linear interpolant, over its largest value, both found by sampling every facet at
/// [`Space::facet_samples`]; differences between these points are not detected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Largest difference at the points; infinite if the datum has no finite value at one of them.
    pub largest: f64,
    /// Root of the mean squared difference.
    pub mean: f64,
}

/// The difference of one datum of a condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataDifference {
    /// The condition.
    pub place: ConditionPlace,
    /// The Cartesian component; `None` for one along the normal and for a pressure.
    pub component: Option<usize>,
    /// The difference.
    pub difference: Difference,
}

/// Adds up the difference of one datum, edge by edge.
#[derive(Default)]
pub(crate) struct Sum {
    scale: f64,
    largest: f64,
    squared: f64,
    length: f64,
}

impl Sum {
    /// Adds up many edges, in parallel.
    ///
    /// * `add`: adds one of them.
    pub(crate) fn of<T: Sync>(edges: &[T], add: impl Fn(&mut Self, &T) + Sync) -> Self {
        let parts: Vec<Self> = each_task(edges.len().div_ceil(CHUNK), |k| {
            let mut sum = Self::default();
            edges[k * CHUNK..edges.len().min((k + 1) * CHUNK)].iter().for_each(|edge| add(&mut sum, edge));
            sum
        });
        parts.into_iter().fold(Self::default(), |a, b| Self {
            scale: a.scale.max(b.scale),
            largest: a.largest.max(b.largest),
            squared: a.squared + b.squared,
            length: a.length + b.length,
        })
    }

    /// Adds a facet: a function against the linear one with the given values at the corners.
    ///
    /// * `samples`: [`Space::facet_samples`].
    pub(crate) fn facet<S: Space>(
        &mut self,
        samples: &[(S::Axes<f64>, f64)],
        (corners, values): (&S::Axes<S::Vector>, &S::Axes<f64>),
        function: impl Fn(S::Vector) -> f64,
    ) {
        let linear =
            |at: &S::Axes<f64>| (1..S::DIM).fold(at[0] * values[0], |sum, k| sum + at[k] * values[k]);
        self.facet_with::<S>(samples, corners, linear, function);
    }

    /// Adds a facet: a function against another one.
    ///
    /// * `made`: by the barycentric coordinates of a point.
    pub(crate) fn facet_with<S: Space>(
        &mut self,
        samples: &[(S::Axes<f64>, f64)],
        corners: &S::Axes<S::Vector>,
        made: impl Fn(&S::Axes<f64>) -> f64,
        function: impl Fn(S::Vector) -> f64,
    ) {
        let measure = S::facet_measure(corners);
        self.length += measure;
        // The largest value may be at a corner, and no sample is there.
        for corner in *corners {
            self.scale = self.scale.max(function(corner).abs());
        }
        for (at, weight) in samples {
            let exact = function(between::<S>(corners, at));
            self.add(exact, made(at), weight * measure);
        }
    }

    /// Adds an edge: the exact value at a fraction of it, and its interpolant on the mesh.
    pub(crate) fn compare(&mut self, length: f64, meant: impl Fn(f64) -> f64, made: impl Fn(f64) -> f64) {
        self.length += length;
        // The rule has no point at the ends, where the largest value may be.
        for end in [0.0, 1.0] {
            self.scale = self.scale.max(meant(end).abs());
        }
        let parts = PARTS as f64;
        for (part, (point, weight)) in (0..PARTS).flat_map(|k| GAUSS5.map(|rule| (k as f64, rule))) {
            let s = (part + point) / parts;
            self.add(meant(s), made(s), weight / parts * length);
        }
    }

    /// Adds a cell: the values of a function at its corners, and at some points the exact value, the linear one and the weight.
    pub(super) fn cell(&mut self, measure: f64, corners: &[f64], samples: &[[f64; 3]]) {
        self.length += measure;
        self.scale = corners.iter().fold(self.scale, |most, value| most.max(value.abs()));
        samples.iter().for_each(|[exact, made, weight]| self.add(*exact, *made, weight * measure));
    }

    /// Adds one sample.
    fn add(&mut self, exact: f64, made: f64, weight: f64) {
        if !exact.is_finite() {
            self.largest = f64::INFINITY;
            return;
        }
        let difference = exact - made;
        self.scale = self.scale.max(exact.abs());
        self.largest = self.largest.max(difference.abs());
        self.squared += weight * difference * difference;
    }

    /// Returns the difference, unless it is round-off.
    pub(crate) fn difference(&self) -> Option<Difference> {
        if self.largest == f64::INFINITY {
            return Some(Difference { largest: f64::INFINITY, mean: f64::INFINITY });
        }
        if !(self.largest > ROUND_OFF * self.scale) {
            return None;
        }
        let mean = (self.squared / self.length).sqrt();
        Some(Difference { largest: self.largest / self.scale, mean: mean / self.scale })
    }
}

impl<S: Space> Body<S> {
    /// Measures how far the imposed displacements and loads are from the linear ones that the body carries.
    ///
    /// This is a check by sampling, see [`Space::facet_samples`]. Returns the data that differ by more than round-off,
    /// relative to their largest values, in the order of the conditions: numbers, and functions that are
    /// linear on each facet, are not included.
    pub fn interpolated_data(&self) -> Vec<DataDifference> {
        let samples = S::facet_samples();
        let mut found = Vec::new();
        let mut push = |list, index, component, sum: &Sum| {
            let place = ConditionPlace { list, index };
            found.extend(sum.difference().map(|difference| DataDifference { place, component, difference }));
        };
        let displacements = self.conditions.displacements.iter().zip(&self.selected.displacements);
        for (index, (condition, edges)) in displacements.enumerate() {
            let data: Vec<(Option<usize>, &ScalarData<S>)> = match &condition.support {
                Support::Normal(value) => vec![(None, value)],
                Support::Components(components) => {
                    let given = components.as_ref().iter().enumerate();
                    given.filter_map(|(c, value)| Some((Some(c), value.as_ref()?))).collect()
                }
            };
            for (component, datum) in data.into_iter().filter(|(_, d)| d.constant().is_none()) {
                let sum = Sum::of(edges, |sum, &edge| {
                    let corners = self.mesh.facet_corners(edge);
                    let values = S::axes(|k| datum.at(corners[k]));
                    sum.facet::<S>(&samples, (&corners, &values), |x| datum.at(x));
                });
                push(ConditionList::Displacement, index, component, &sum);
            }
        }
        for (index, (condition, edges)) in
            self.conditions.tractions.iter().zip(&self.selected.tractions).enumerate()
        {
            let data: Vec<(Option<usize>, &ScalarData<S>)> = match &condition.load {
                Load::Pressure(value) => vec![(None, value)],
                Load::Vector(all) => {
                    all.as_ref().iter().enumerate().map(|(c, value)| (Some(c), value)).collect()
                }
            };
            for (component, datum) in data.into_iter().filter(|(_, d)| d.constant().is_none()) {
                let sum = Sum::of(edges, |sum, &edge| {
                    let corners = self.mesh.facet_corners(edge);
                    let mut moments = S::axes(|_| 0.0);
                    for (at, share) in S::facet_rule() {
                        let value = datum.at(between::<S>(&corners, at));
                        for k in 0..S::DIM {
                            moments[k] += share * at[k] * value;
                        }
                    }
                    let values = linear_by_moments::<S, f64>(&moments);
                    sum.facet::<S>(&samples, (&corners, &values), |x| datum.at(x));
                });
                push(ConditionList::Traction, index, component, &sum);
            }
        }
        for (index, (condition, facets)) in
            self.conditions.springs.iter().zip(&self.selected.springs).enumerate()
        {
            for (component, datum) in
                spring_data(condition).into_iter().filter(|(_, d)| d.constant().is_none())
            {
                let sum = Sum::of(facets, |sum, &facet| {
                    let corners = self.mesh.facet_corners(facet);
                    let middle = datum.at(self.mesh.facet_middle(facet));
                    let values = S::axes(|k| component.map_or(middle, |_| datum.at(corners[k])));
                    sum.facet::<S>(&samples, (&corners, &values), |x| datum.at(x));
                });
                push(ConditionList::Spring, index, component, &sum);
            }
        }
        found
    }
}

/// Lists the data of springs: the stiffness, and the components of the displacement at rest.
fn spring_data<S: Space>(condition: &SpringCondition<S>) -> Vec<(Option<usize>, &ScalarData<S>)> {
    let mut data = vec![(None, &condition.stiffness)];
    match &condition.rest {
        SpringRest::Component(value) => data.push((Some(0), value)),
        SpringRest::Vector(all) => {
            data.extend(all.as_ref().iter().enumerate().map(|(c, value)| (Some(c), value)));
        }
    }
    data
}

/// Returns the point of a facet with the given barycentric coordinates.
fn between<S: Space>(corners: &S::Axes<S::Vector>, at: &S::Axes<f64>) -> S::Vector {
    (1..S::DIM).fold(corners[0] * at[0], |sum, k| sum + corners[k] * at[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryConditions;
    use crate::geometry::Vector;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    fn differences(cells: usize, conditions: &BoundaryConditions) -> Vec<DataDifference> {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [cells, 1]).unwrap();
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, material, conditions).unwrap().interpolated_data()
    }

    fn data(f: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> ScalarData {
        ScalarData::function(f)
    }

    #[test]
    fn numbers_and_affine_data_are_exact() {
        let conditions = BoundaryConditions::new()
            .fix("bottom")
            .displace("left", Some(data(|x| -2e-3 * x[1])), None)
            .roller("right", data(|x| 3.0 * (x[0] - 2.0) - x[1]))
            .traction("top", [data(|x| 1e6 - 7e5 * x[0] + x[1]), data(|_| 0.0)])
            .pressure("top", data(|x| x[0]));
        assert_eq!(differences(7, &conditions), []);
    }

    #[test]
    fn a_peak_at_a_node_is_the_largest_value() {
        let peak = || data(|x| if x[0] == 1.0 { 0.01 } else { 0.0 });
        let conditions = BoundaryConditions::new().displace("bottom", None, Some(peak()));
        let [d] = differences(4, &conditions)[..] else { unreachable!() };
        // The interpolant falls from the peak linearly; seen at the first point beside it.
        assert!((d.difference.largest - (1.0 - GAUSS5[0].0 / PARTS as f64)).abs() < 1e-14, "{d:?}");
        assert!(d.difference.mean > 0.0 && d.difference.mean < d.difference.largest);
    }

    #[test]
    fn a_spike_between_the_nodes_is_found() {
        // Narrower than a twentieth of an edge: it contains no node and no point of one five-point rule on the edge.
        for (centre, width) in [(0.513, 0.008), (1.371, 0.002), (0.02, 0.004)] {
            let spike = move || data(move |x| (1.0 - (x[0] - centre).abs() / width).max(0.0));
            let conditions =
                BoundaryConditions::new().displace("bottom", None, Some(spike())).pressure("top", spike());
            let found = differences(20, &conditions);
            assert_eq!(found.len(), 2, "{centre}: {found:?}");
            assert!(found.iter().all(|d| (0.8..1.1).contains(&d.difference.largest)), "{found:?}");
        }
    }

    #[test]
    fn data_without_a_value_between_the_nodes_are_found() {
        let root = data(|x| ((x[0] - 0.05).abs() - 0.01).sqrt());
        let conditions = BoundaryConditions::new().displace("bottom", None, Some(root));
        let found = differences(20, &conditions);
        assert_eq!(found[0].difference.largest, f64::INFINITY);
    }

    #[test]
    fn quadratic_data_differ_by_an_eighth_of_the_second_derivative() {
        // x² on edges of length h: the interpolant is above by h²/4 s(1−s)·4, in the mean square h²/√30; the linear
        // function of the same moments differs by h²/6 at the ends, in the mean square h²/(6√5).
        let square = || data(|x| x[0] * x[0]);
        let conditions =
            BoundaryConditions::new().displace("bottom", None, Some(square())).pressure("top", square());
        for cells in [4, 8] {
            let h = 2.0 / cells as f64;
            let [d, t] = differences(cells, &conditions)[..] else { unreachable!() };
            assert_eq!((d.place.list, d.place.index, d.component), (ConditionList::Displacement, 0, Some(1)));
            assert_eq!((t.place.list, t.place.index, t.component), (ConditionList::Traction, 0, None));
            // The largest value is at the right end.
            let scale = 4.0;
            assert!((d.difference.largest * scale - h * h / 4.0).abs() < 1e-14);
            assert!((d.difference.mean * scale - h * h / 30f64.sqrt()).abs() < 1e-14);
            assert!((t.difference.mean * scale - h * h / (6.0 * 5f64.sqrt())).abs() < 1e-14);
            assert!(t.difference.largest * scale < h * h / 6.0);
            assert!(t.difference.largest * scale > 0.7 * h * h / 6.0);
        }
    }
}
