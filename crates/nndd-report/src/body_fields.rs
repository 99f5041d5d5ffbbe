//! The fields of a body by name, as its ParaView file has them.

use crate::solved::Fields;
use crate::space::ReportSpace;
use case_io::Case;
use cre_estimator::Estimate;
use fem_core::body::Body;
use fem_core::directions::Directions;
use fem_core::field;
use fem_core::geometry::norm;
use fem_core::interface::Partner;
use fem_core::material::LinearElastic;
use fem_core::space::Space;
use mesh_io::vtu::VtuArray;
use rayon::prelude::*;

/// Smallest number of cells per parallel task.
const FEWEST_PER_TASK: usize = 4096;

/// Fields at the nodes, in the order of the files.
pub(crate) const AT_POINTS: [&str; 4] =
    ["displacement", "reaction", "stress_recovered", "von_mises_recovered"];

/// Fields in the cells, in the order of the files.
pub(crate) const IN_CELLS: [&str; 10] = [
    "stress",
    "stress_equilibrated",
    "strain",
    "error_density",
    "error_density_mesh",
    "error_density_iteration",
    "material_id",
    "element_id",
    "body_id",
    "von_mises",
];

/// The recovered stress of a node with its material and the change of temperature.
type AtNode<'a, S> = (&'a LinearElastic<S>, <S as Space>::Tensor, f64);

/// The data from which the fields of a body are computed.
pub(crate) struct BodyFields<'a, S: ReportSpace> {
    pub(crate) case: &'a Case<S>,
    pub(crate) solution: &'a Fields<'a, S>,
    pub(crate) estimate: &'a Estimate<S>,
    /// Its number in the case file.
    pub(crate) body: usize,
}

impl<S: ReportSpace> BodyFields<'_, S> {
    fn model(&self) -> &Body<S> {
        &self.solution.problem.bodies[self.body]
    }

    /// Makes several fields, in their order; unknown fields are left out.
    pub(crate) fn all(&self, names: &[&str]) -> Vec<VtuArray> {
        names.iter().filter_map(|name| self.field(name)).collect()
    }

    /// Makes a field; `None` without a field of that name, or if it is unknown.
    pub(crate) fn field(&self, name: &str) -> Option<VtuArray> {
        let model = self.model();
        let mesh = model.mesh();
        let fields = &self.estimate.pair.bodies[self.body];
        let cells = (0..mesh.cells().len()).into_par_iter().with_min_len(FEWEST_PER_TASK);
        let tensors = |of: &(dyn Fn(usize) -> [f64; 6] + Sync)| {
            VtuArray::tensors(name, cells.clone().map(of).collect())
        };
        let scalars =
            |of: &(dyn Fn(usize) -> f64 + Sync)| VtuArray::scalars(name, cells.clone().map(of).collect());
        let integers =
            |of: &(dyn Fn(usize) -> usize + Sync)| VtuArray::integers(name, cells.clone().map(of).collect());
        let (stress, means) = (&fields.stress, &self.estimate.mean_stress[self.body]);
        let place_of = |places: &[usize], t: usize| places[model.materials().index(t)];
        let heat = |t: usize| model.cell_temperature(t);
        Some(match name {
            "displacement" => VtuArray::vectors(name, &fields.displacement),
            "reaction" => VtuArray::vectors(name, &self.reactions()),
            "stress_recovered" => {
                let recovered = self.recovered()?.into_iter();
                VtuArray::tensors(name, recovered.map(|(law, s, t)| S::six_stresses(law, s, t)).collect())
            }
            "von_mises_recovered" => {
                let values: Option<Vec<f64>> =
                    self.recovered()?.into_iter().map(|(law, s, t)| S::von_mises(law, s, t)).collect();
                VtuArray::scalars(name, values?)
            }
            "stress" => tensors(&|t| S::six_stresses(model.material(t), stress[t], heat(t))),
            "stress_equilibrated" => tensors(&|t| S::six_stresses(model.material(t), means[t], heat(t))),
            "strain" => {
                let places = self.case.material_places(self.body);
                tensors(&|t| {
                    S::six_strains(self.case, place_of(&places, t), model.material(t), (stress[t], heat(t)))
                })
            }
            "error_density" => scalars(&|t| self.estimate.cre.by_cell[self.body][t] / mesh.measure(t)),
            "error_density_mesh" => {
                scalars(&|t| self.estimate.cre.discretisation_by_cell[self.body][t] / mesh.measure(t))
            }
            // Constant in the cell: its energy density.
            "error_density_iteration" => scalars(&|t| {
                let (made, of): (S::Components<f64>, S::Components<f64>) =
                    (fields.equilibrated.finite_element[t].into(), stress[t].into());
                let d = S::Tensor::from(S::components(|k| made[k] - of[k]));
                model.material(t).complementary(d, d)
            }),
            "material_id" => {
                let places = self.case.material_places(self.body);
                integers(&|t| place_of(&places, t))
            }
            "element_id" => {
                let numbers = self.case.element_numbers(self.body, mesh);
                integers(&|t| numbers.map_or(t, |numbers| numbers[t] as usize))
            }
            "body_id" => integers(&|_| self.body),
            "von_mises" => {
                let values: Option<Vec<f64>> =
                    cells.clone().map(|t| S::von_mises(model.material(t), stress[t], heat(t))).collect();
                VtuArray::scalars(name, values?)
            }
            _ => return None,
        })
    }

    /// Returns the recovered stress at each node, with its material and the change of temperature.
    fn recovered(&self) -> Option<Vec<AtNode<'_, S>>> {
        let model = self.model();
        let recovered = self.solution.results.as_ref()?.recovered.get(self.body)?;
        let temperature = |node: usize| model.temperature().get(node).copied().unwrap_or_default();
        let values = recovered.by_node(model).into_iter().enumerate();
        Some(values.map(|(n, (m, s))| (&model.materials().list()[m], s, temperature(n))).collect())
    }

    /// The forces of supports and contact on the nodes, N/m: what the loads leave of `K u − f`, in the directions that are
    /// held or in contact, so that nothing but round-off is left out.
    fn reactions(&self) -> Vec<S::Vector> {
        let (solution, model) = (self.solution, self.model());
        let residual = field::nodal_residual(model, &self.estimate.pair.bodies[self.body].displacement);
        let held = model.node_constraints().iter().zip(&residual);
        let mut forces: Vec<S::Vector> = held.map(|(node, force)| node.held.project(*force)).collect();
        for side in model.rigid_sides() {
            for (node, load) in side.nodes.iter().zip(&side.forces) {
                forces[*node] += *load;
            }
        }
        for (k, side) in solution.problem.sides_of(Partner::Body(self.body)) {
            for pair in solution.problem.contacts[k].interface.pairs() {
                let node = pair.nodes[side].index();
                let pair_of = &solution.problem.contacts[k];
                let slides = !pair_of.friction.acts() && !pair_of.is_bonded();
                let held: Directions<S> = match model.node_constraints()[node].held.is_none() && slides {
                    true => Directions::along(pair.normal / norm(pair.normal)),
                    false => Directions::ALL,
                };
                forces[node] = held.project(residual[node]);
            }
        }
        forces
    }
}
