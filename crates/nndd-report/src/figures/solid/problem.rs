//! The problem: bodies, sides in contact, supports and loads.

use super::{DIGITS, Model};
use crate::figures::{NamedRows, Picture};
use crate::plot::{self, Entry, Panel, Views, of_body};
use crate::render::{Line, Paint, Scene, SkinFace, Vector, View};
use crate::words::with_digits;
use fem_core::mesh::id::{FacetId, NodeId};
use std::collections::BTreeSet;

/// At most this many arrows on the sides of a body that have loads, and as many for its imposed displacements.
const MOST: usize = 12;
/// The length of the longest arrow, the least of any, and the least distance of two, as parts of the size of the bodies.
const LONGEST: f64 = 0.16;
const SHORTEST: f64 = 0.06;
const APART: f64 = 0.14;
/// Thickness of the border of a side in contact, in pixels.
const BORDER: f64 = 2.5;

/// Vectors at places, each with the normal of its side.
type Arrows = Vec<(Vector, Vector, Vector)>;

impl Model<'_> {
    /// Draws the problem at rest, from in front and above, and from behind and below.
    pub(super) fn problem(&self, contact: &NamedRows<'_>) -> Picture {
        let touching: Vec<BTreeSet<FacetId>> = self.touching();
        let mark = |b: usize, face: &SkinFace| self.mark(&touching, b, face);
        let paint = |b: usize, face: &SkinFace| match mark(b, face) {
            None => Paint::Plain(of_body(b)),
            Some(Entry::Contact) => Paint::Plain(Entry::Contact.colour()),
            Some(entry) => Paint::Striped(entry.stripes()),
        };
        let key = |b: usize, face: &SkinFace| mark(b, face).map_or(0, |entry| 1 + entry as usize);
        let rest = Self {
            factor: 0.0,
            skins: self.skins.clone(),
            names: self.names.clone(),
            labels: self.labels.clone(),
            ..*self
        };
        let mut scene = rest.scene(&paint, &key, None);
        // A side that another body covers can be told by its border.
        for (b, skin) in self.skins.iter().enumerate() {
            let borders = skin.borders(|k| usize::from(touching[b].contains(&skin.faces[k].facet)));
            scene.lines.extend(borders.into_iter().map(|ends| Line {
                ends: ends.map(|node| self.rest(b, node)),
                colour: Entry::Contact.colour(),
                width: BORDER,
            }));
        }
        let obstacles = rest.obstacles();
        let faces =
            || self.skins.iter().enumerate().flat_map(|(b, skin)| skin.faces.iter().map(move |f| (b, f)));
        let mut legend: Vec<Entry> =
            [Entry::Contact, Entry::Fixed, Entry::Held, Entry::Rigid, Entry::Springs].into();
        legend.retain(|entry| faces().any(|(b, face)| mark(b, face) == Some(*entry)));
        if !obstacles.is_empty() {
            legend.push(Entry::Obstacle);
        }
        scene.lines.extend(obstacles);
        for (entry, arrows) in [(Entry::Load, self.loads()), (Entry::Imposed, self.imposed())] {
            if !arrows.is_empty() {
                self.draw(&mut scene, &arrows, entry);
                legend.push(entry);
            }
        }
        let below = View::new(-self.view.towards, self.upright());
        let panel = |heading: &str, view| Panel {
            heading: heading.into(),
            scene: &scene,
            view,
            focus: &[],
            marks: vec![],
        };
        let panels = [panel("from the front", self.view), panel("from behind and below", below)];
        let figure = Views {
            title: "The problem".into(),
            description: self.said(contact),
            legend: &legend,
            panels: &panels,
            scale: None,
            names: &self.names,
        };
        Picture {
            name: "problem".into(),
            svg: plot::views(&figure, &self.labels),
            caption: "Supports, loads and imposed displacements as the program read them.".into(),
            numbers: None,
            view: None,
        }
    }

    /// Lists the faces of each body that are in a pair.
    pub(super) fn touching(&self) -> Vec<BTreeSet<FacetId>> {
        let problem = self.solution.problem;
        let mut touching = vec![BTreeSet::new(); problem.bodies.len()];
        for pair in &problem.contacts {
            for (side, partner) in pair.partners().into_iter().enumerate() {
                if let Some(body) = partner.body() {
                    touching[body].extend(pair.interface.facets().iter().map(|facet| facet.facets[side]));
                }
            }
        }
        touching
    }

    /// Says what a face is marked as.
    fn mark(&self, touching: &[BTreeSet<FacetId>], b: usize, face: &SkinFace) -> Option<Entry> {
        let body = &self.solution.problem.bodies[b];
        if touching[b].contains(&face.facet) {
            return Some(Entry::Contact);
        }
        if body.rigid_sides().iter().any(|side| side.edges.binary_search(&face.facet).is_ok()) {
            return Some(Entry::Rigid);
        }
        let condition = body.facet_condition(face.facet)?;
        let (held, on_springs) = (condition.reaction, !condition.springs.directions.is_none());
        match (held.is_none(), held.is_all()) {
            (true, _) => on_springs.then_some(Entry::Springs),
            (_, true) => Some(Entry::Fixed),
            _ => Some(Entry::Held),
        }
    }

    /// Lists arrows of the loads of all bodies.
    fn loads(&self) -> Arrows {
        let mut arrows = Arrows::new();
        for (b, body) in self.solution.problem.bodies.iter().enumerate() {
            let traction = |face: &SkinFace| {
                let condition = body.facet_condition(face.facet);
                condition.map_or(Vector::zeros(), |of| of.traction.iter().sum::<Vector>() / 3.0)
            };
            arrows.extend(self.spread(b, &traction));
        }
        // Forces and body forces have other units: each has the length of the longest arrow.
        let longest = arrows.iter().map(|(_, vector, _)| vector.norm()).fold(0.0, f64::max);
        let unit = |v: Vector| v * (if longest > 0.0 { longest } else { 1.0 } / v.norm());
        for body in &self.solution.problem.bodies {
            let sides = body.rigid_sides().iter().filter(|side| side.force.norm() > 0.0);
            arrows.extend(sides.map(|side| {
                let out = side.edges.first().map_or(Vector::zeros(), |face| body.mesh().facet_normal(*face));
                (side.about, unit(side.force), out)
            }));
            let force = body.resultant_inside();
            if force.norm() > 0.0 {
                let [low, high] = body.mesh().bounding_box();
                // Above the body: it would hide the arrow.
                let upright = self.upright();
                let at =
                    0.5 * (low + high) + (0.5 * (high - low).dot(&upright) + LONGEST * self.size) * upright;
                arrows.push((at, unit(force), -force));
            }
        }
        arrows
    }

    /// Lists arrows of the displacements that supports impose.
    fn imposed(&self) -> Arrows {
        let bodies = self.solution.problem.bodies.iter().enumerate();
        let of_body = |(b, body): (usize, &fem_core::body::Body<fem_core::space::Solid>)| {
            let imposed = |node: NodeId| body.node_constraints()[node].displacement();
            let vector = |face: &SkinFace| {
                let mean = face.nodes.map(imposed).iter().sum::<Vector>() / 3.0;
                body.facet_condition(face.facet).map_or(Vector::zeros(), |of| of.reaction.project(mean))
            };
            self.spread(b, &vector)
        };
        bodies.flat_map(of_body).collect()
    }

    /// Chooses some faces of a body with a vector, far from each other.
    fn spread(&self, b: usize, vector: &dyn Fn(&SkinFace) -> Vector) -> Arrows {
        let mesh = self.solution.problem.bodies[b].mesh();
        let all =
            self.skins[b].faces.iter().map(|face| (mesh.facet_middle(face.facet), vector(face), face.normal));
        let all: Arrows =
            all.filter(|(_, vector, _)| vector.norm() > 0.0 && vector.norm().is_finite()).collect();
        let mut distances = vec![f64::INFINITY; all.len()];
        let mut chosen = Arrows::new();
        while chosen.len() < MOST {
            let farthest =
                (0..all.len()).max_by(|a, b| distances[*a].total_cmp(&distances[*b]).then(b.cmp(a)));
            let Some(next) = farthest.filter(|k| distances[*k] > APART * self.size) else { break };
            chosen.push(all[next]);
            for (distance, (at, ..)) in distances.iter_mut().zip(&all) {
                *distance = distance.min((at - all[next].0).norm());
            }
        }
        chosen
    }

    /// Draws arrows, the longest of the same length whatever its size.
    fn draw(&self, scene: &mut Scene, arrows: &Arrows, entry: Entry) {
        let longest = arrows.iter().map(|(_, vector, _)| vector.norm()).fold(0.0, f64::max);
        for (at, vector, normal) in arrows {
            let part = vector.norm() / longest;
            let arrow = vector / vector.norm() * (self.size * LONGEST * part.max(SHORTEST / LONGEST));
            // An arrow is outside its body: one that presses ends at it.
            let at = at + 0.01 * self.size * normal.normalize();
            let ends = if vector.dot(normal) < 0.0 { [at - arrow, at] } else { [at, at + arrow] };
            scene.arrow(ends, self.view.towards, entry.colour());
        }
    }

    /// Describes the problem in words.
    fn said(&self, contact: &NamedRows<'_>) -> String {
        let problem = self.solution.problem;
        let mut text = String::new();
        for (name, body) in self.names.iter().zip(&problem.bodies) {
            text += &format!("{name}: {} nodes", body.mesh().points().len());
            let mut groups: Vec<&str> = body.supports().iter().map(|set| set.group.as_str()).collect();
            groups.extend(body.rigid_sides().iter().map(|side| side.group.as_str()));
            groups.dedup();
            match groups.is_empty() {
                true => text += ", no support. ",
                false => text += &format!(", supports on {}. ", groups.join(", ")),
            }
        }
        for ((name, _), pair) in contact.iter().zip(&problem.contacts) {
            let area = with_digits(pair.interface.measure(), DIGITS);
            text +=
                &format!("Contact {name}: {} pairs of nodes, area {area}. ", pair.interface.pairs().len());
        }
        text.trim_end().to_owned()
    }
}
