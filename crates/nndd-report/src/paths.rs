//! Displacement and stress along the paths of `[[output.path]]`.

use crate::figures::Picture;
use crate::plot::{self, Labels};
use crate::solved::Fields;
use crate::space::ReportSpace;
use case_io::Case;
use case_io::case::OutputPath;
use case_io::table::{PathRow, PathValues};
use cre_estimator::RecoveredStress;
use fem_core::body::Body;
use fem_core::geometry::Coordinates;
use fem_core::mesh::cell_tree::{CellAt, CellTree};

/// A point belongs to a body if it is at most this far outside of a cell, as a part of the body's size.
const INSIDE: f64 = 1e-9;
/// A point outside of all bodies has the values of the nearest cell if it is less than this part of the cell's height away: meshes have chords
/// for arcs.
const BESIDE: f64 = 0.1;

/// A body with what is known of it.
struct Known<'a, S: ReportSpace> {
    name: &'a str,
    body: &'a Body<S>,
    cells: CellTree<'a, S>,
    displacement: &'a [S::Vector],
    stress: &'a RecoveredStress<S>,
    /// How far outside of a cell a point may be, m.
    width: f64,
}

impl<S: ReportSpace> Known<'_, S> {
    /// Finds the cell with a point, the one with the smallest number.
    fn cell(&self, point: S::Vector) -> Option<CellAt<S>> {
        self.cells.around(point, self.width).into_iter().next()
    }

    /// Interpolates at a point of a cell.
    fn values(&self, at: &CellAt<S>) -> Option<PathValues> {
        let material = self.body.materials().index(at.cell);
        let law = &self.body.materials().list()[material];
        let temperatures = self.body.temperature();
        let (mut displacement, mut temperature) = (S::Vector::ZERO, 0.0);
        let mut stress = S::components(|_| 0.0);
        let beyond_cuts = self.body.cut_displacement(at.cell);
        let corners = self.body.mesh().cells()[at.cell].into_iter().zip(beyond_cuts);
        for ((node, beyond), weight) in corners.zip(at.weights) {
            displacement += (self.displacement[node.index()] + beyond) * weight;
            temperature += weight * temperatures.get(node.index()).copied().unwrap_or_default();
            let of_node: S::Components<f64> = self.stress.at(node, material)?.into();
            for k in 0..S::COMPONENTS {
                stress[k] += weight * of_node[k];
            }
        }
        let stress = S::Tensor::from(stress);
        let principal = S::principal(stress);
        Some(PathValues {
            body: self.name.to_owned(),
            displacement: displacement.entries().to_vec(),
            stress: S::six_stresses(law, stress, temperature)[..2 * S::DIM].to_vec(),
            von_mises: S::von_mises(law, stress, temperature),
            principal: [principal[0], principal[S::DIM - 1]],
        })
    }
}

/// Makes the rows of a path: one for each of its points, or one for each body where several meet.
fn rows<S: ReportSpace>(path: &OutputPath<S>, bodies: &[Known<'_, S>]) -> Vec<PathRow> {
    let of_point = |(s, point): (f64, S::Vector)| {
        let mut found: Vec<PathValues> =
            bodies.iter().filter_map(|known| known.values(&known.cell(point)?)).collect();
        if found.is_empty() {
            let least = |at: &CellAt<S>| at.weights.into_iter().fold(f64::INFINITY, f64::min);
            let near = bodies.iter().filter_map(|known| Some((known, known.cells.nearest(point)?)));
            let nearest = near.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)));
            found.extend(
                nearest.filter(|(_, at)| least(at) > -BESIDE).and_then(|(known, at)| known.values(&at)),
            );
        }
        let row = move |found| PathRow { s, place: point.entries().to_vec(), found };
        let outside = found.is_empty().then_some(None);
        found.into_iter().map(Some).chain(outside).map(row).collect::<Vec<_>>()
    };
    path.places().into_iter().flat_map(of_point).collect()
}

/// Makes the rows of path-NAME.csv of every path; none without an estimate.
pub(crate) fn all<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>) -> Vec<Vec<PathRow>> {
    let (Some(estimate), Some(results)) = (solution.estimate, solution.results) else { return Vec::new() };
    if case.paths.is_empty() {
        return Vec::new();
    }
    let bodies = case.bodies.iter().zip(&solution.problem.bodies).zip(&results.recovered).enumerate();
    let known: Vec<Known<'_, S>> = bodies
        .map(|(k, ((given, body), stress))| Known {
            name: &given.name,
            body,
            cells: CellTree::new(body.mesh()),
            displacement: &estimate.pair.bodies[k].displacement,
            stress,
            width: INSIDE * body.mesh().diagonal(),
        })
        .collect();
    case.paths.iter().map(|path| rows(path, &known)).collect()
}

/// Draws every path.
pub(crate) fn pictures<S: ReportSpace>(case: &Case<S>, all: &[Vec<PathRow>]) -> Vec<Picture> {
    // Lengths and stresses have the same labels in the plane and of solids.
    let labels = Labels { units: case.units.clone(), ..Labels::default() };
    let picture = |(path, rows): (&OutputPath<S>, &Vec<PathRow>)| {
        let outside = rows.iter().filter(|row| row.found.is_none()).count();
        let mut caption = "The recovered stress: a smooth picture of the stress in equilibrium. It is no bound of the stress at a point.".to_owned();
        if outside > 0 {
            caption += &format!(" {outside} of {} points are outside of all bodies.", path.points);
        }
        Picture {
            name: stem(path),
            svg: plot::path(&path.name, rows, path.points, &labels),
            caption,
            numbers: Some(file(path)),
            view: None,
        }
    };
    case.paths.iter().zip(all).map(picture).collect()
}

/// Names the file of a path.
pub(crate) fn file<S: ReportSpace>(path: &OutputPath<S>) -> String {
    format!("{}.csv", stem(path))
}

/// Names the figure of a path.
fn stem<S: ReportSpace>(path: &OutputPath<S>) -> String {
    format!("path-{}", path.file_stem())
}
