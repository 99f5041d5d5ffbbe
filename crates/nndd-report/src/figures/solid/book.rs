//! The contact pressure of a pair on both sides, opened like a book.

use super::{DIGITS, Model, shown};
use crate::figures::{MOST_PAIRS, NamedRows, Picture, drawn_pairs};
use crate::plot::{self, Entry, Panel, Quantity, Scale, Views};
use crate::render::{Face, Line, Paint, Scene, Vector, View};
use crate::words::{contact_parts, one_line, with_digits};
use case_io::report::Report;
use case_io::table::ContactRow;
use fem_core::interface::{ContactFacet, ContactPair};
use fem_core::parallel::each_task;
use fem_core::space::Solid;
use std::collections::BTreeMap;

/// Thickness of the borders of the area in contact, in pixels.
const BORDER: f64 = 2.5;

/// An edge of contact faces.
struct Edge {
    /// Of each face at it: whether it is closed at every node, and at one node at least.
    closed: Vec<[bool; 2]>,
    ends: [Vector; 2],
}

impl Model<'_> {
    /// Draws the pairs under pressure; of many those with the largest forces.
    pub(super) fn books(&self, contact: &NamedRows<'_>, report: &Report) -> Vec<Picture> {
        if self.estimate.is_none() {
            return Vec::new();
        }
        let (chosen, count) = drawn_pairs(contact, report);
        let names = contact_parts(self.case);
        each_task(chosen.len(), |place| {
            let k = chosen[place];
            let (pair, rows) = &contact[k];
            let title = match contact.len() {
                1 => "Contact pressure".to_owned(),
                _ => format!("Contact pressure of {}", one_line(pair)),
            };
            let mut caption = "Both sides beside each other like the pages of an open book, each seen from outside along the contact's normal. \
                               The cross is the centre of pressure."
                .to_owned();
            if place == 0 && count > MOST_PAIRS {
                caption +=
                    &format!(" {MOST_PAIRS} of {count} pairs are drawn, those with the largest forces.");
            }
            let svg = self.book(title, k, rows);
            Picture { name: names[k].clone(), svg, caption, numbers: Some("contact.csv".into()), view: None }
        })
    }

    fn book(&self, title: String, k: usize, rows: &[ContactRow]) -> String {
        let pair = &self.solution.problem.contacts[k];
        let samples: Vec<[f64; 2]> =
            rows.iter().zip(pair.interface.pairs()).map(|(row, of)| [row.pressure, of.weight]).collect();
        let largest = rows.iter().map(|row| row.pressure).filter(|p| p.is_finite()).fold(0.0, f64::max);
        let scale = Scale::new(Quantity::Pressure, &[samples], Some((largest, None)), false);
        let [first, second] = self.pages(pair, rows);
        let scenes = [0, 1].map(|side| self.page(pair, rows, &scale, side, [first, second][side]));
        let results = self.solution.results.and_then(|results| results.contacts.get(k));
        let centre = results.and_then(|found| found.centre);
        let partners = pair.partners().map(|of| of.body().map_or("the obstacle", |body| self.names[body]));
        let focus: Vec<Vector> =
            pair.interface.facets().iter().flat_map(|facet| self.corners(pair, facet, 0)).collect();
        let panel = |side: usize| Panel {
            heading: format!("side of {}", partners[side]),
            scene: &scenes[side],
            view: [first, second][side],
            focus: &focus,
            marks: centre.into_iter().collect(),
        };
        let panels = [panel(0), panel(1)];
        let mut legend = vec![Entry::Certain, Entry::Possible];
        if scenes.iter().flat_map(|scene| &scene.faces).any(|face| matches!(face.paint, Paint::Plain(_))) {
            legend.push(Entry::Open);
        }
        let figure = Views {
            title,
            description: self.words_of_page(k, largest),
            legend: &legend,
            panels: &panels,
            scale: Some((&scale, Quantity::Pressure)),
            names: &[],
        };
        plot::views(&figure, &self.labels)
    }

    /// Chooses the views of both sides: along the resultant of the pressure, or along the mean normal without it, and upright along the longer
    /// extent.
    fn pages(&self, pair: &ContactPair<Solid>, rows: &[ContactRow]) -> [View; 2] {
        let nodes = || pair.interface.pairs().iter().zip(rows);
        let force: Vector = nodes().map(|(of, row)| of.weight * row.pressure.max(0.0) * of.normal).sum();
        let mean: Vector = nodes().map(|(of, _)| of.weight * of.normal).sum();
        let out = if force.norm() > 0.0 && force.norm().is_finite() { force } else { mean };
        let points = || pair.interface.pairs().iter().map(|of| self.rest(pair.body, of.nodes[0]));
        let extent = |axis: &Vector| {
            let view = View::new(out, *axis);
            view.extents(points()).map_or(0.0, |[_, [low, high]]| high - low)
        };
        let mut axes = [Vector::z(), Vector::y(), Vector::x()];
        // Not the axis along which one looks.
        axes.sort_by(|a, b| out.dot(a).abs().total_cmp(&out.dot(b).abs()));
        let up = if extent(&axes[1]) > extent(&axes[0]) { axes[1] } else { axes[0] };
        [View::new(out, up), View::new(-out, up)]
    }

    /// Returns the corners of a facet on a side.
    fn corners(&self, pair: &ContactPair<Solid>, facet: &ContactFacet<Solid>, side: usize) -> [Vector; 3] {
        let (body, side) = match pair.partners()[side].body() {
            Some(body) => (body, side),
            // The obstacle has no mesh: its side is where the body's is.
            None => (pair.body, 0),
        };
        [0, 1, 2].map(|k: usize| self.rest(body, pair.interface.corner_pair(facet, k).nodes[side]))
    }

    fn page(
        &self,
        pair: &ContactPair<Solid>,
        rows: &[ContactRow],
        scale: &Scale,
        side: usize,
        view: View,
    ) -> Scene {
        let mut scene = Scene::default();
        let outwards = [1.0, -1.0][side];
        let mut edges: BTreeMap<[usize; 2], Edge> = BTreeMap::new();
        for facet in pair.interface.facets() {
            let pairs = [0, 1, 2].map(|k: usize| facet.pairs[k] as usize);
            let corners = self.corners(pair, facet, side);
            let normal: Vector = (0..3).map(|k| pair.interface.corner_pair(facet, k).normal).sum();
            // Of a closed surface the far half is turned away.
            if outwards * normal.dot(&view.towards) <= 0.0 {
                continue;
            }
            let closed = |k: &usize| rows[pairs[*k]].active > 0;
            let (all, any) =
                (facet.free_corners().all(|k| closed(&k)), facet.free_corners().any(|k| closed(&k)));
            let paint = match any {
                true => Paint::Heights(pairs.map(|k| scale.position(rows[k].pressure))),
                false => Paint::Plain(Entry::Open.colour()),
            };
            scene.faces.push(Face { corners, paint, body: 0 });
            for [a, b] in [[0, 1], [1, 2], [2, 0]] {
                let number = |k: usize| match facet.clamped[k] {
                    None => pairs[k],
                    Some(clamped) => rows.len() + clamped.number as usize,
                };
                let (p, q) = (number(a), number(b));
                let edge = Edge { closed: vec![], ends: [corners[a], corners[b]] };
                edges.entry([p.min(q), p.max(q)]).or_insert(edge).closed.push([all, any]);
            }
        }
        let borders = [(1, Entry::Possible), (0, Entry::Certain)];
        for (which, entry) in borders {
            let is_border = |sides: &[[bool; 2]]| {
                let inside = sides.iter().filter(|side| side[which]).count();
                inside == 1 || (inside > 0 && inside < sides.len())
            };
            let lines = edges.values().filter(|edge| is_border(&edge.closed));
            scene.lines.extend(lines.map(|edge| Line {
                ends: edge.ends,
                colour: entry.colour(),
                width: BORDER,
            }));
        }
        scene
    }

    /// Describes the pressure of a pair.
    fn words_of_page(&self, k: usize, largest: f64) -> String {
        let pair = &self.solution.problem.contacts[k];
        let mut text = format!("The largest contact pressure is {}", with_digits(largest, DIGITS));
        let Some(found) = self.solution.results.and_then(|results| results.contacts.get(k)) else {
            return text + ".";
        };
        if let Some(at) = found.max_pressure_at {
            text += &format!(" at {}", shown(at));
        }
        let [certain, possible, total] = [found.area.inner, found.area.outer, pair.interface.measure()]
            .map(|area| with_digits(area, DIGITS));
        text += &format!(". The area in contact is {certain} to {possible} of {total}.");
        if let Some(centre) = found.centre {
            text += &format!(" The centre of pressure is {}.", shown(centre));
        }
        text
    }
}
