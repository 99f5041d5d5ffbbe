//! Lines and arcs of circles on which results are written: `[[output.path]]`.

use super::body::file_stem;
use super::dimension::Keys;
use super::names::Names;
use super::{Dimension, inside};
use crate::case_file::Reader;
use fem_core::geometry::{Coordinates, shown};
use fem_core::space::{Plane, Space};
use serde_json::{Value as Json, json};

/// The number of points by default, and the largest one.
const POINTS: usize = 200;
const MOST_POINTS: usize = 100_000;
/// The longest length, m: its square is finite.
const LONGEST: f64 = 1e100;

/// `[[output.path]]`: points at equal distances, at which displacement and stress are written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OutputPath<S: Dimension = Plane> {
    /// Its name, which also names its files.
    pub name: String,
    /// The line or arc.
    pub course: Course<S>,
    /// The number of points, both ends included.
    pub points: usize,
}

/// The course of a path.
#[derive(Clone, Debug, PartialEq)]
pub enum Course<S: Dimension = Plane> {
    /// A straight line.
    Line {
        /// The first point, m.
        from: S::Axes<f64>,
        /// The last point, m.
        to: S::Axes<f64>,
    },
    /// An arc of a circle.
    Circle {
        /// The centre, m.
        centre: S::Axes<f64>,
        /// The radius, m.
        radius: f64,
        /// The angles of both ends, degrees. In the plane they begin at the x axis; in space at the direction across the axis that is nearest
        /// to x, or to y if the axis is x.
        angles: [f64; 2],
        /// The direction around which the arc turns, in space; not of unit length.
        axis: Option<S::Axes<f64>>,
    },
}

impl<S: Dimension> OutputPath<S> {
    /// Returns its name as the stem of a file name, see [`super::BodyCase::file_stem`].
    pub fn file_stem(&self) -> String {
        file_stem(&self.name)
    }

    /// Lists its points, each with the length along the path, m.
    pub fn places(&self) -> Vec<(f64, S::Vector)> {
        let part = |k: usize| k as f64 / (self.points - 1) as f64;
        let place = |t: f64| match &self.course {
            Course::Line { from, to } => {
                let (from, to) = (S::vector(from), S::vector(to));
                (t * (to - from).length(), from * (1.0 - t) + to * t)
            }
            Course::Circle { centre, radius, angles: [start, end], axis } => {
                let turn = t * (end - start).to_radians();
                let (sine, cosine) = (start.to_radians() + turn).sin_cos();
                let [first, second] = across::<S>(axis.as_ref().map(S::vector));
                (radius * turn.abs(), S::vector(centre) + (first * cosine + second * sine) * *radius)
            }
        };
        (0..self.points).map(|k| place(part(k))).collect()
    }

    /// Returns the table as the case file has it.
    pub(super) fn json(&self) -> Json {
        match &self.course {
            Course::Line { from, to } => {
                json!({ "name": self.name, "from": from.as_ref(), "to": to.as_ref(), "points": self.points })
            }
            Course::Circle { centre, radius, angles, axis } => {
                let mut circle = json!({ "centre": centre.as_ref(), "radius": radius, "angles": angles });
                if let Some(axis) = axis {
                    circle["axis"] = json!(axis.as_ref());
                }
                json!({ "name": self.name, "circle": circle, "points": self.points })
            }
        }
    }
}

/// Returns two unit vectors across an axis, from the first to the second of which a positive turn goes by 90 degrees; the axes of the plane if there
/// is no axis.
fn across<S: Space>(axis: Option<S::Vector>) -> [S::Vector; 2] {
    let Some(axis) = axis else { return [S::AXES[0], S::AXES[1]] };
    let axis = axis / axis.length();
    let reject = |v: S::Vector| v - axis * axis.times(&v);
    // The x axis, or y beside it, is far from the axis.
    let near = if axis[0].abs() < 0.9 { 0 } else { 1 };
    let first = reject(S::AXES[near]);
    let first = first / first.length();
    let second = S::Vector::of(|k| {
        let [i, j] = [(k + 1) % S::DIM, (k + 2) % S::DIM];
        axis[i] * first[j] - axis[j] * first[i]
    });
    [first, second]
}

/// Reads `[[output.path]]`.
pub(super) fn paths<S: Keys>(r: &mut Reader<'_>) -> Vec<OutputPath<S>> {
    let mut names = Names::default();
    let mut found = Vec::new();
    for mut table in r.tables("path").unwrap_or_default() {
        table.require(&["name"]);
        let name = table.string("name").unwrap_or_default();
        if table.has("name") {
            names.check(&table, &name, "path", "choose another name");
        }
        names.take(&name);
        let points = table.count("points", 2).unwrap_or(POINTS);
        if points > MOST_POINTS {
            let message = format!("`{}` is {points}", table.path_of("points"));
            table.refuse(
                "points",
                message,
                &format!("at most {MOST_POINTS}"),
                "take fewer points, or several paths",
            );
        }
        let course = course::<S>(&mut table);
        table.finish();
        found.extend(course.map(|course| OutputPath { name, course, points }));
    }
    found
}

/// Reads the line or the circle of a path.
fn course<S: Keys>(r: &mut Reader<'_>) -> Option<Course<S>> {
    if !r.has("circle") {
        r.require(&["from", "to"]);
        let (from, to) = (r.axes::<S>("from")?, r.axes::<S>("to")?);
        let length = (S::vector(&to) - S::vector(&from)).length();
        if !(length > 0.0 && length < LONGEST) {
            let message = format!("the line from `from` to `to` has the length {}", shown(length));
            r.refuse("to", message, "two points", "write the other end of the line there");
        }
        return Some(Course::Line { from, to });
    }
    if r.has("from") || r.has("to") {
        let message = format!("`{}` has both a circle and the ends of a line", r.path_of("circle"));
        r.refuse("circle", message, "`circle`, or `from` and `to`", "take one of them out");
        r.node("from");
        r.node("to");
    }
    circle(r.table("circle")?)
}

fn circle<S: Keys>(mut r: Reader<'_>) -> Option<Course<S>> {
    let in_space = S::COORDINATES.len() == 3;
    r.require(if in_space { &["centre", "radius", "axis"] } else { &["centre", "radius"] });
    let centre = r.axes::<S>("centre");
    let radius = r.number_where("radius", |radius| radius > 0.0 && radius < LONGEST, "a number > 0");
    let angles = r.pair("angles").unwrap_or([0.0, 360.0]);
    let turn = (angles[1] - angles[0]).abs();
    if !(turn > 0.0 && turn <= 360.0) {
        let message = format!("`{}` is an arc of {} degrees", r.path_of("angles"), shown(turn));
        r.refuse(
            "angles",
            message,
            "two angles, at most 360 degrees apart",
            "leave it out for the whole circle",
        );
    }
    let mut axis = None;
    if in_space {
        axis = inside::direction::<S>(&mut r, "axis");
    }
    r.finish();
    Some(Course::Circle { centre: centre?, radius: radius?, angles, axis })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::norm;
    use fem_core::space::Solid;

    #[test]
    fn arcs_turn_around_their_axis() {
        for axis in [[0.0, 0.0, 2.0], [1.0, 0.0, 0.0], [1.0, -2.0, 0.5]] {
            let course = Course::Circle {
                centre: [1.0, 2.0, 3.0],
                radius: 2.0,
                angles: [0.0, 90.0],
                axis: Some(axis),
            };
            let path: OutputPath<Solid> = OutputPath { name: "arc".into(), course, points: 3 };
            let places = path.places();
            let arms: Vec<_> = places.iter().map(|(_, p)| *p - Solid::vector(&[1.0, 2.0, 3.0])).collect();
            let axis = Solid::vector(&axis);
            assert!(arms.iter().all(|arm| (norm(*arm) - 2.0).abs() < 1e-14 && arm.dot(&axis).abs() < 1e-14));
            assert!((arms[0].cross(&arms[2]).dot(&axis) - 4.0 * norm(axis)).abs() < 1e-13);
            assert!((places[2].0 - std::f64::consts::PI).abs() < 1e-14);
        }
    }
}
