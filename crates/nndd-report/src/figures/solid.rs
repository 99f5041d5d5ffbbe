//! The figures of solids: shaded views of the bodies, sections, and contact pressures on both sides.

mod book;
mod fields;
mod obstacles;
mod problem;
mod viewer;

use super::{NamedRows, Picture, adaptive, closing, convergence, steps};
use crate::plot::{self, Labels, OUTLINE, Panel, Quantity, Views, of_edges};
use crate::render::{Cut, Face, Line, Paint, Scene, Skin, SkinFace, Vector, View};
use crate::solved::Fields;
use crate::words::{self, short, with_digits};
use case_io::Case;
use case_io::report::Report;
use case_io::table::ContactRow;
use cre_estimator::Estimate;
use fem_core::geometry::norm;
use fem_core::mesh::id::NodeId;
use fem_core::parallel::each_task;
use fem_core::space::Solid;
use fields::{Coloured, Field};
use serde_json::Value;

/// A cut that takes less away than this part of the size is not drawn: what it would show is on the surface.
const LEAST: f64 = 0.01;
/// Digits of numbers in titles and alternative texts.
const DIGITS: usize = 3;

/// Draws the figures of a solve.
///
/// * `steps_seen`: [`of_step`] of each load step.
pub(crate) fn of_solve(
    case: &Case<Solid>,
    solution: &Fields<'_, Solid>,
    (contact, steps_seen): (&NamedRows<'_>, &[Value]),
    report: &Report,
) -> Vec<Picture> {
    let model = &Model::new(case, solution);
    let labels = &model.labels;
    let drawn: [&(dyn Fn() -> Vec<Picture> + Sync); 8] = [
        &|| model.turning(contact, steps_seen).into_iter().collect(),
        &|| vec![model.problem(contact)],
        &|| model.picture_of(Quantity::VonMises).into_iter().collect(),
        &|| model.books(contact, report),
        &|| model.picture_of(Quantity::ErrorDensity).into_iter().collect(),
        &|| convergence(case, report, labels).into_iter().collect(),
        &|| steps(contact, report, labels),
        &|| adaptive(case, report, labels).into_iter().collect(),
    ];
    each_task(drawn.len(), |k| drawn[k]()).into_iter().flatten().collect()
}

/// Makes the data of a load step for the view that turns.
///
/// * `rows`: of contact.csv, of each pair; `step`: its number and the number of all.
pub(crate) fn of_step(
    case: &Case<Solid>,
    solution: &Fields<'_, Solid>,
    rows: &[&[ContactRow]],
    step: (usize, usize),
) -> Option<Value> {
    Model::new(case, solution).view_of_step(rows, step)
}

/// The heights on the scale at the corners of a cell, by the numbers of its body and its own.
type Heights<'a> = dyn Fn(usize, usize) -> [f64; 4] + 'a;

/// The bodies as they are drawn.
struct Model<'a> {
    case: &'a Case<Solid>,
    solution: &'a Fields<'a, Solid>,
    estimate: Option<&'a Estimate<Solid>>,
    names: Vec<&'a str>,
    labels: Labels,
    skins: Vec<Skin>,
    /// The largest extent of all bodies, m.
    size: f64,
    /// By which displacements are multiplied.
    factor: f64,
    /// From in front, above and to the right.
    view: View,
}

impl<'a> Model<'a> {
    fn new(case: &'a Case<Solid>, solution: &'a Fields<'a, Solid>) -> Self {
        let bodies = &solution.problem.bodies;
        let boxes = bodies.iter().map(|body| body.mesh().bounding_box());
        let all = boxes.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).unwrap_or_default();
        let size = (all[1] - all[0]).max();
        let displacements = solution.estimate.iter().flat_map(|estimate| &estimate.pair.bodies);
        let largest = displacements.flat_map(|body| &body.displacement).map(|u| norm(*u)).fold(0.0, f64::max);
        // The y axis is upright if bodies are pressed along it, otherwise the z axis.
        let pairs = solution.problem.contacts.iter().flat_map(|pair| pair.interface.pairs());
        let sums = pairs.fold(Vector::zeros(), |sum, pair| sum + pair.weight * pair.normal.abs());
        let view = match sums.imax() {
            1 if sums[1] > 0.0 => View::new(Vector::new(0.6, 0.5, 1.0), Vector::y()),
            _ => View::new(Vector::new(0.6, -1.0, 0.5), Vector::z()),
        };
        Self {
            case,
            solution,
            estimate: solution.estimate,
            names: case.bodies.iter().map(|body| body.name.as_str()).collect(),
            labels: Labels { units: case.units.clone(), of_solids: true },
            skins: each_task(bodies.len(), |b| Skin::of(&bodies[b])),
            size,
            factor: plot::magnified(size, largest, &closing(solution)),
            view,
        }
    }

    /// Draws the displacement, with the view that turns in front of the picture.
    fn turning(&self, contact: &NamedRows<'_>, steps: &[Value]) -> Option<Picture> {
        let view = self.view(contact, steps);
        self.picture_of(Quantity::Displacement).map(|picture| Picture { view, ..picture })
    }

    /// Returns the place of a node at rest, m.
    fn rest(&self, body: usize, node: NodeId) -> Vector {
        self.solution.problem.bodies[body].mesh().points()[node]
    }

    /// Returns the place of a node in a picture: displaced by the factor.
    fn place(&self, body: usize, node: NodeId) -> Vector {
        let moved = self.estimate.map(|estimate| estimate.pair.bodies[body].displacement[node.index()]);
        self.rest(body, node) + moved.map_or(Vector::zeros(), |u| self.factor * u)
    }

    /// Returns the values of a field at some nodes of a cell.
    fn values<const N: usize>(
        &self,
        field: &Field,
        body: usize,
        cell: usize,
        nodes: [NodeId; N],
    ) -> [f64; N] {
        match field {
            Field::Cells(values) => [values[body][cell]; N],
            Field::Nodes(values) => {
                let material = self.solution.problem.bodies[body].materials().index(cell);
                nodes.map(|node| values[body][material][node.index()])
            }
        }
    }

    /// Makes the scene of the displaced bodies, or of the parts of them behind a plane.
    ///
    /// * `paint`: of the faces of each body; `heights`: on the scale, of the corners of the cells of each body.
    fn scene(
        &self,
        paint: &dyn Fn(usize, &SkinFace) -> Paint,
        key: &dyn Fn(usize, &SkinFace) -> usize,
        cut: Option<(&Cut, &Heights<'_>)>,
    ) -> Scene {
        let mut scene = Scene::default();
        for (b, skin) in self.skins.iter().enumerate() {
            let body = b as u16;
            let corner = |node: NodeId, height: f64| (self.rest(b, node), self.place(b, node), height);
            let edge = |ends: [Vector; 2]| Line { ends, colour: of_edges(), width: OUTLINE };
            for face in &skin.faces {
                let paint = paint(b, face);
                let Some((cut, _)) = cut else {
                    scene.faces.push(Face {
                        corners: face.nodes.map(|node| self.place(b, node)),
                        paint,
                        body,
                    });
                    continue;
                };
                let heights = if let Paint::Heights(heights) = paint { heights } else { [0.0; 3] };
                let corners = [0, 1, 2].map(|k: usize| corner(face.nodes[k], heights[k]));
                for part in cut.face(corners) {
                    let paint = match paint {
                        Paint::Heights(_) => Paint::Heights(part.map(|(_, height)| height)),
                        other => other,
                    };
                    scene.faces.push(Face { corners: part.map(|(at, _)| at), paint, body });
                }
                scene.lines.extend(cut.rim(corners).map(edge));
            }
            let lines = skin.edges(|k| key(b, &skin.faces[k])).into_iter().filter_map(|ends| {
                let [from, to] = ends.map(|node| corner(node, 0.0));
                cut.map_or(Some([from.1, to.1]), |(cut, _)| cut.line(from, to))
            });
            scene.lines.extend(lines.map(edge));
            if let Some((cut, heights)) = cut {
                let cells = self.solution.problem.bodies[b].mesh().cells().iter().enumerate();
                for (cell, nodes) in cells {
                    let heights = heights(b, cell);
                    let corners = [0, 1, 2, 3].map(|k: usize| corner(nodes[k], heights[k]));
                    for part in cut.cell(corners) {
                        let paint = Paint::Heights(part.map(|(_, height)| height));
                        scene.faces.push(Face { corners: part.map(|(at, _)| at), paint, body });
                    }
                }
            }
        }
        scene
    }

    /// Draws the bodies coloured by a field, and their section through its largest value.
    fn coloured(&self, of: &Coloured, caption: &str) -> Picture {
        let Coloured { field, scale, .. } = of;
        let heights = |b: usize, face: &SkinFace| {
            self.values(field, b, face.cell, face.nodes).map(|value| scale.position(value))
        };
        let material =
            |b: usize, face: &SkinFace| self.solution.problem.bodies[b].materials().index(face.cell);
        let paint = |b: usize, face: &SkinFace| Paint::Heights(heights(b, face));
        let mut skin = self.scene(&paint, &material, None);
        // On the other figures their nets would hide colours.
        if of.quantity == Quantity::Displacement {
            skin.lines.extend(self.obstacles());
        }
        let cut = of.through.map(|point| Cut { point, normal: self.to_cut() }).filter(|cut| self.opens(cut));
        let section = cut.map(|cut| {
            let cells = |b: usize, cell: usize| {
                let nodes = self.solution.problem.bodies[b].mesh().cells()[cell];
                self.values(field, b, cell, nodes).map(|value| scale.position(value))
            };
            self.scene(&paint, &material, Some((&cut, &cells)))
        });
        let panel =
            |heading: String, scene| Panel { heading, scene, view: self.view, focus: &[], marks: vec![] };
        let mut panels = vec![panel(if cut.is_some() { "surface".into() } else { String::new() }, &skin)];
        if let (Some(cut), Some(section)) = (&cut, &section) {
            let axis = cut.normal.abs().imax();
            let place = with_digits(cut.point[axis], DIGITS);
            panels.push(panel(format!("cut at {} = {place}", ["x", "y", "z"][axis]), section));
        }
        let drawn = if of.quantity == Quantity::Displacement { "drawn" } else { "displacements" };
        let figure = Views {
            title: format!("{} ({drawn} × {})", of.title, short(self.factor)),
            description: format!(
                "{} Displacements are drawn {} times as large.",
                of.said,
                short(self.factor)
            ),
            legend: &[],
            panels: &panels,
            scale: Some((scale, of.quantity)),
            names: &self.names,
        };
        let cut = if cut.is_some() { " The cut goes through the largest value." } else { "" };
        Picture {
            name: of.name.into(),
            svg: plot::views(&figure, &self.labels),
            caption: format!("{caption}{cut}"),
            numbers: None,
            view: None,
        }
    }

    /// Tells whether a cut takes something away that can be seen.
    fn opens(&self, cut: &Cut) -> bool {
        let boxes = self.solution.problem.bodies.iter().flat_map(|body| body.mesh().bounding_box());
        let farthest = boxes.map(|corner| (corner - cut.point).dot(&cut.normal)).fold(0.0, f64::max);
        farthest > LEAST * self.size
    }

    /// Returns the axis along which bodies are cut open, towards the viewer.
    fn to_cut(&self) -> Vector {
        let level = self.view.towards - self.view.towards.component_mul(&self.upright().abs());
        let axis = level.abs().imax();
        let mut normal = Vector::zeros();
        normal[axis] = level[axis].signum();
        normal
    }

    /// Returns the axis that is upright in the pictures.
    fn upright(&self) -> Vector {
        let mut upright = Vector::zeros();
        upright[self.view.up.abs().imax()] = 1.0;
        upright
    }
}

/// Writes a place.
fn shown(point: Vector) -> String {
    words::place(point.as_slice(), point.amax())
}
