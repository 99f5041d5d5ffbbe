//! Tests of the figures by subject, and what they share.

use super::*;
use fem_core::geometry::Vector;
use fem_core::interface::RigidLine;
use fem_core::mesh::TriMesh;

mod axis;
mod contact;
mod curves;
mod deformed;
mod sketch;

const BAD: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 5e-324];

/// Fails unless the text is one SVG document whose tags close in order and whose numbers are numbers.
#[track_caller]
fn assert_whole(svg: &str) {
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "not one svg element");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "NaN or infinity in the drawing");
    let mut open: Vec<&str> = vec![];
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "stray > in text");
        let end = start + rest[start..].find('>').expect("tag without an end");
        let tag = &rest[start + 1..end];
        assert!(!tag.contains('<'), "tag within a tag: {tag}");
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of {tag}");
        let name = tag.split([' ', '/']).find(|s| !s.is_empty()).unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "left open: {open:?}");
    assert_eq!(svg.matches("<title>").count(), 1);
    assert_eq!(svg.matches("<desc>").count(), 1);
    assert!(svg.len() < 1_500_000, "{} bytes", svg.len());
}

/// A block of `2n × n` squares cut into triangles.
fn block(n: usize, y: f64) -> TriMesh {
    let id = |i: usize, j: usize| (j * (2 * n + 1) + i) as u32;
    let points = (0..=n)
        .flat_map(|j| (0..=2 * n).map(move |i| [i as f64 / n as f64, y + j as f64 / n as f64]))
        .collect();
    let triangles = (0..n)
        .flat_map(|j| (0..2 * n).map(move |i| (i, j)))
        .flat_map(|(i, j)| {
            [[id(i, j), id(i + 1, j), id(i + 1, j + 1)], [id(i, j), id(i + 1, j + 1), id(i, j + 1)]]
        })
        .collect();
    TriMesh::new(points, triangles, vec![]).unwrap()
}

fn density(
    title: &str,
    bodies: &[BodyPicture<'_>],
    obstacles: &[ObstaclePicture<'_>],
    closing: &[Closing],
) -> String {
    deformed(title, Quantity::ErrorDensity, bodies, obstacles, closing, false, &Labels::default())
}

const CIRCLE: RigidLine = RigidLine::Circle { centre: Vector::new(1.0, 3.0), radius: 2.0, inside: false };

fn rest() -> Motion {
    Motion { translation: Vector::zeros(), spin: 0.0, centre: Vector::zeros() }
}

fn obstacle(line: RigidLine, points: &[Vector], load: (Vector, f64)) -> ObstaclePicture<'_> {
    ObstaclePicture { line, points, motion: rest(), imposed: Vector::zeros(), load }
}
