//! The data of the view that turns: the surface of all bodies, with displacements and fields, in few bytes.

use super::Model;
use super::fields::Field;
use crate::figures::NamedRows;
use crate::plot::{self, Quantity, Scale};
use crate::render::Vector;
use crate::words::with_digits;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use case_io::table::ContactRow;
use fem_core::mesh::id::NodeId;
use serde_json::{Value, json};
use std::collections::{BTreeSet, HashMap};

/// At most this many points, times the number of load steps, are in the page; of more those in a cell of a grid are joined.
const MOST_POINTS: usize = 16_000;
/// Cells of the first grid along the largest extent of the bodies, and the factor by which they grow until there are few enough points.
const CELLS: f64 = 200.0;
const COARSER: f64 = 1.2;
/// The largest value of a height; the next one is an unknown value.
const HIGHEST: f64 = 65534.0;
/// How far bodies are moved apart along the normal of a pair, as a part of their size.
const APART: f64 = 0.35;

/// A corner of the surface. Nodes on the border between materials, or of a contact side, have several.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    body: usize,
    node: NodeId,
    material: usize,
    touches: bool,
}

/// The surface of all bodies, joined to few points.
struct Surface {
    corners: Vec<Corner>,
    /// The corners of each face, its body and its place in the skin of it.
    faces: Vec<([usize; 3], usize, usize)>,
    /// The point of each corner.
    point_of: Vec<usize>,
    /// The corner at each point.
    points: Vec<usize>,
}

impl Model<'_> {
    /// Makes the data of the view that turns; `None` without a solution.
    ///
    /// * `steps`: what [`Self::view_of_step`] made of each load step; empty without load steps.
    pub(super) fn view(&self, contact: &NamedRows<'_>, steps: &[Value]) -> Option<Value> {
        self.estimate?;
        let surface = self.surface(steps.len());
        let steps = match steps {
            [] => vec![self.state(&surface, &self.rows(contact), String::new())?],
            steps => steps.to_vec(),
        };
        let corners = |k: usize| surface.corners[surface.points[k]];
        let places: Vec<Vector> = (0..surface.points.len()).map(|k| self.at(corners(k))).collect();
        let low = places.iter().fold(Vector::repeat(f64::INFINITY), |low, p| low.inf(p));
        let high = places.iter().fold(Vector::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
        let extent = (high - low).map(|x| x.max(1e-9 * self.size));
        let shorts = |p: &Vector| (p - low).component_div(&extent).map(|x| (65535.0 * x) as u16);
        let faces = surface.faces.iter().map(|(face, ..)| face.map(|corner| surface.point_of[corner]));
        let faces: Vec<[usize; 3]> = faces.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let (all, drawn) = (surface.faces.len(), faces.len());
        let axes = [self.view.right, self.view.up, self.view.towards];
        Some(json!({
            "low": low.as_slice(), "extent": extent.as_slice(), "factor": self.factor,
            "view": axes.iter().map(|axis| axis.as_slice()).collect::<Vec<_>>(),
            "colours": plot::scale_colours(),
            "apart": self.apart().iter().map(|way| way.as_slice()).collect::<Vec<_>>(),
            "bodies": encoded((0..surface.points.len()).map(|k| (corners(k).body as u16).to_le_bytes())),
            "places": encoded(places.iter().flat_map(|p| <[u16; 3]>::from(shorts(p))).map(u16::to_le_bytes)),
            "faces": encoded(faces.iter().flatten().map(|k| (*k as u32).to_le_bytes())),
            "edges": encoded(self.lines(&surface).iter().flatten().map(|k| (*k as u32).to_le_bytes())),
            "steps": steps,
            "note": if drawn < all { format!("The view has {drawn} of {all} faces of the surface. ") } else { String::new() },
        }))
    }

    /// Makes the data of a load step.
    ///
    /// * `rows`: of contact.csv, of each pair; `count`: the number of all load steps.
    pub(super) fn view_of_step(
        &self,
        rows: &[&[ContactRow]],
        (step, count): (usize, usize),
    ) -> Option<Value> {
        self.state(&self.surface(count), rows, format!("step {step}"))
    }

    fn rows<'b>(&self, contact: &'b NamedRows<'_>) -> Vec<&'b [ContactRow]> {
        contact.iter().map(|(_, rows)| rows.as_slice()).collect()
    }

    fn at(&self, corner: Corner) -> Vector {
        self.rest(corner.body, corner.node)
    }

    /// Finds the surface, with few enough points.
    fn surface(&self, steps: usize) -> Surface {
        let touching = self.touching();
        let (mut corners, mut numbers, mut faces) = (Vec::new(), HashMap::new(), Vec::new());
        for (body, skin) in self.skins.iter().enumerate() {
            for (place, face) in skin.faces.iter().enumerate() {
                let material = self.solution.problem.bodies[body].materials().index(face.cell);
                let touches = touching[body].contains(&face.facet);
                let number = face.nodes.map(|node| {
                    let corner = Corner { body, node, material, touches };
                    *numbers.entry(corner).or_insert_with(|| {
                        corners.push(corner);
                        corners.len() - 1
                    })
                });
                faces.push((number, body, place));
            }
        }
        let most = (MOST_POINTS / steps.max(1)).max(1);
        let mut surface = Surface {
            point_of: (0..corners.len()).collect(),
            points: (0..corners.len()).collect(),
            corners,
            faces,
        };
        let mut cell = self.size / CELLS;
        while surface.points.len() > most && cell < self.size {
            self.join(&mut surface, cell);
            cell *= COARSER;
        }
        surface
    }

    /// Joins the corners in each cell of a grid that have the same body, material and kind of face.
    fn join(&self, surface: &mut Surface, cell: f64) {
        let mut numbers = HashMap::new();
        surface.points.clear();
        for (k, corner) in surface.corners.iter().enumerate() {
            let place = self.at(*corner).map(|x| (x / cell).floor() as i64);
            let key = (corner.body, corner.material, corner.touches, <[i64; 3]>::from(place));
            surface.point_of[k] = *numbers.entry(key).or_insert_with(|| {
                surface.points.push(k);
                surface.points.len() - 1
            });
        }
    }

    /// Lists the edges that are drawn, by their points.
    fn lines(&self, surface: &Surface) -> Vec<[usize; 2]> {
        let mut points = HashMap::new();
        for (k, corner) in surface.corners.iter().enumerate() {
            points.entry((corner.body, corner.node)).or_insert(surface.point_of[k]);
        }
        let touching = self.touching();
        let mut lines = BTreeSet::new();
        for (body, skin) in self.skins.iter().enumerate() {
            let edges = skin.edges(|k| usize::from(touching[body].contains(&skin.faces[k].facet)));
            for ends in edges {
                let [from, to] = ends.map(|node| points.get(&(body, node)).copied());
                if let (Some(from), Some(to)) = (from, to)
                    && from != to
                {
                    lines.insert([from.min(to), from.max(to)]);
                }
            }
        }
        lines.into_iter().collect()
    }

    /// Finds for each body how far it is moved if the contact is opened.
    fn apart(&self) -> Vec<Vector> {
        let mut apart: Vec<Option<Vector>> = vec![None; self.skins.len()];
        for start in 0..apart.len() {
            if apart[start].is_some() {
                continue;
            }
            apart[start] = Some(Vector::zeros());
            // Each pass reaches the neighbours of the bodies that are known.
            for _ in 0..self.skins.len() {
                for pair in &self.solution.problem.contacts {
                    let Some([first, second]) = pair.bodies() else { continue };
                    let normal: Vector = pair.interface.pairs().iter().map(|of| of.weight * of.normal).sum();
                    let way = APART * self.size * normal / normal.norm().max(f64::MIN_POSITIVE);
                    match (apart[first], apart[second]) {
                        (Some(known), None) => apart[second] = Some(known + way),
                        (None, Some(known)) => apart[first] = Some(known - way),
                        _ => {}
                    }
                }
            }
        }
        apart.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Makes displacements and fields at the points.
    fn state(&self, surface: &Surface, rows: &[&[ContactRow]], name: String) -> Option<Value> {
        let estimate = self.estimate?;
        let moved = |k: &usize| {
            let corner = surface.corners[*k];
            estimate.pair.bodies[corner.body].displacement[corner.node.index()]
        };
        let moved: Vec<Vector> = surface.points.iter().map(moved).collect();
        let largest =
            moved.iter().map(|u| u.amax()).filter(|u| u.is_finite()).fold(f64::MIN_POSITIVE, f64::max);
        let shorts = moved.iter().flat_map(|u| <[i16; 3]>::from(u.map(|x| (32767.0 * x / largest) as i16)));
        let coloured = [self.displacement(), self.von_mises(), self.density()];
        let mut fields: Vec<Value> = Vec::new();
        for of in coloured.into_iter().flatten() {
            let values = self.at_corners(surface, &of.field);
            fields.push(self.field(surface, (of.title, &of.said, of.quantity), &of.scale, &values));
        }
        fields.extend(self.pressure(surface, rows));
        Some(
            json!({ "name": name, "largest": largest, "moved": encoded(shorts.map(i16::to_le_bytes)), "fields": fields }),
        )
    }

    /// Returns the values of a field at the corners: of cells the mean over the faces around, by their area.
    fn at_corners(&self, surface: &Surface, field: &Field) -> Vec<f64> {
        match field {
            Field::Nodes(values) => {
                let of = |corner: &Corner| values[corner.body][corner.material][corner.node.index()];
                surface.corners.iter().map(of).collect()
            }
            Field::Cells(values) => {
                let mut sums = vec![[0.0; 2]; surface.corners.len()];
                for (corners, body, place) in &surface.faces {
                    let face = &self.skins[*body].faces[*place];
                    let area = self.solution.problem.bodies[*body].mesh().facet_measure(face.facet);
                    for corner in corners {
                        let [sum, weight] = sums[*corner];
                        sums[*corner] = [sum + area * values[*body][face.cell], weight + area];
                    }
                }
                sums.into_iter().map(|[sum, weight]| sum / weight).collect()
            }
        }
    }

    /// Makes the contact pressure of all pairs; `None` without a pair.
    fn pressure(&self, surface: &Surface, rows: &[&[ContactRow]]) -> Option<Value> {
        let mut pressures: HashMap<(usize, NodeId), f64> = HashMap::new();
        let mut samples = Vec::new();
        for (pair, rows) in self.solution.problem.contacts.iter().zip(rows) {
            for (side, partner) in pair.partners().into_iter().enumerate() {
                let Some(body) = partner.body() else { continue };
                for (of, row) in pair.interface.pairs().iter().zip(*rows) {
                    let pressure = pressures.entry((body, of.nodes[side])).or_insert(0.0);
                    *pressure = pressure.max(row.pressure);
                    samples.push([row.pressure, of.weight]);
                }
            }
        }
        let largest = samples.iter().map(|[p, _]| *p).filter(|p| p.is_finite()).fold(0.0, f64::max);
        let of = |corner: &Corner| {
            let known = pressures.get(&(corner.body, corner.node)).filter(|_| corner.touches);
            known.copied().unwrap_or(f64::NAN)
        };
        let values: Vec<f64> = surface.corners.iter().map(of).collect();
        let scale = Scale::new(Quantity::Pressure, &[samples], Some((largest, None)), false);
        let said =
            format!("Contact sides coloured by the pressure. The largest is {}.", with_digits(largest, 3));
        (!rows.is_empty())
            .then(|| self.field(surface, ("Contact pressure", &said, Quantity::Pressure), &scale, &values))
    }

    /// Writes a field; of joined corners the largest value.
    fn field(
        &self,
        surface: &Surface,
        (name, said, quantity): (&str, &str, Quantity),
        scale: &Scale,
        values: &[f64],
    ) -> Value {
        let mut heights = vec![f64::NAN; surface.points.len()];
        for (value, point) in values.iter().zip(&surface.point_of) {
            heights[*point] = heights[*point].max(scale.position(*value));
        }
        let short = |height: &f64| match height.is_finite() {
            true => (height.clamp(0.0, 1.0) * HIGHEST) as u16,
            false => u16::MAX,
        };
        json!({
            "name": name, "said": said, "label": quantity.label(&self.labels), "ticks": scale.ticks(),
            "values": encoded(heights.iter().map(|height| short(height).to_le_bytes())),
        })
    }
}

/// Writes numbers as text.
fn encoded<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> String {
    STANDARD.encode(numbers.flatten().collect::<Vec<u8>>())
}
