//! Pictures at known pixels.

use super::canvas::Canvas;
use super::*;

const RED: Colour = [200, 0, 0];
const BLUE: Colour = [0, 0, 200];
const SCALE: [Colour; 2] = [[0, 100, 0], [100, 0, 0]];

/// A window of 20 × 20 pixels of the page on the square from 0 to 20, seen from above.
fn window() -> Window {
    Window { view: View::new(Vector::z(), Vector::y()), middle: [10.0, 10.0], pixel: 1.0, size: [20, 20] }
}

fn face(corners: [[f64; 3]; 3], paint: Paint) -> Face {
    Face { corners: corners.map(Vector::from), paint, body: 0 }
}

/// The colour and opacity at a place of the page.
fn at(canvas: &Canvas, [x, y]: [f64; 2]) -> [u8; 4] {
    let (size, pixels) = canvas.pixels();
    let scale = size[0] as f64 / 20.0;
    pixels[((20.0 - y) * scale) as usize * size[0] + (x * scale) as usize]
}

/// A colour in the light that falls on faces to the viewer.
fn lit(colour: Colour) -> [u8; 4] {
    let [r, g, b] = colour.map(|part| (f64::from(part) * (0.7 + 0.3 * 0.81)).round() as u8);
    [r, g, b, 255]
}

#[test]
fn nearer_faces_hide_others_whatever_their_order() {
    let far = face([[0.0, 0.0, 1.0], [20.0, 0.0, 1.0], [0.0, 20.0, 1.0]], Paint::Plain(RED));
    // It passes through the far one in the line x = 5.
    let tilted = face([[0.0, 0.0, 0.0], [20.0, 0.0, 4.0], [0.0, 20.0, 0.0]], Paint::Plain(BLUE));
    for faces in [[far, tilted], [tilted, far]] {
        let mut canvas = Canvas::new(window());
        faces.iter().for_each(|face| canvas.face(face, &[]));
        assert_eq!(at(&canvas, [3.2, 3.2]), lit(RED));
        let [r, _, b, opacity] = at(&canvas, [7.2, 3.2]);
        assert!(r == 0 && b > 140 && opacity == 255, "{r} {b} {opacity}");
        assert_eq!(at(&canvas, [15.0, 15.0]), [0; 4], "nothing is drawn there");
    }
}

#[test]
fn colours_follow_the_heights_and_lines_stay_behind_faces() {
    let mut canvas = Canvas::new(window());
    let corners = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]];
    canvas.face(&face(corners, Paint::Heights([0.0, 1.0, 0.0])), &SCALE);
    // The height is x/20, so the scale changes in the middle.
    assert_eq!([[9.0, 1.2], [11.0, 1.2]].map(|p| at(&canvas, p)), SCALE.map(lit));
    let line =
        |z: f64| Line { ends: [[0.0, 5.0, z], [20.0, 5.0, z]].map(Vector::from), colour: BLUE, width: 1.0 };
    canvas.line(&line(-10.0));
    assert_eq!((at(&canvas, [5.0, 5.1]), at(&canvas, [18.0, 5.1])), (lit(SCALE[0]), [0, 0, 200, 255]));
    canvas.line(&line(0.0));
    assert_eq!(at(&canvas, [5.0, 5.1]), [0, 0, 200, 255]);
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let mut canvas = Canvas::new(window());
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        canvas.face(&face([[bad, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]], Paint::Plain(RED)), &[]);
        let ends = [Vector::new(bad, 0.0, 0.0), Vector::zeros()];
        canvas.line(&Line { ends, colour: BLUE, width: 1.0 });
    }
    assert!(canvas.pixels().1.iter().all(|pixel| *pixel == [0; 4]));
    // A height that is not known has its own colour.
    let corners = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]];
    canvas.face(&face(corners, Paint::Heights([f64::NAN, 0.0, 0.0])), &SCALE);
    assert_eq!(at(&canvas, [5.0, 5.0]), lit([160; 3]));
}

#[test]
fn names_are_on_their_body() {
    let second = face([[12.0, 0.0, 5.0], [20.0, 0.0, 5.0], [20.0, 20.0, 5.0]], Paint::Plain(BLUE));
    let first = face([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]], Paint::Plain(RED));
    let scene = Scene { faces: vec![first, Face { body: 1, ..second }], lines: vec![] };
    let places = draw(&scene, &window(), &[], 3).places;
    let [Some([x, y]), Some([u, v]), None] = places[..] else { panic!("{places:?}") };
    assert!(x + (20.0 - y) < 20.0 && x < 12.0, "{x} {y}");
    assert!(u > 12.0 && 20.0 - v < 2.5 * (u - 12.0), "{u} {v}");
}

#[test]
fn a_plane_cuts_a_cell_in_a_triangle_or_a_square() {
    let corner = |x: [f64; 3], height: f64| (Vector::from(x), Vector::from(x), height);
    let corners = [
        corner([0.0, 0.0, 0.0], 0.0),
        corner([1.0, 0.0, 0.0], 1.0),
        corner([0.0, 1.0, 0.0], 0.0),
        corner([0.0, 0.0, 1.0], 0.0),
    ];
    let area = |parts: &[[(Vector, f64); 3]]| -> f64 {
        parts.iter().map(|[a, b, c]| 0.5 * (b.0 - a.0).cross(&(c.0 - a.0)).norm()).sum()
    };
    let cut = Cut { point: Vector::new(0.5, 0.0, 0.0), normal: Vector::x() };
    let section = cut.cell(corners);
    assert!(section.len() == 1 && (area(&section) - 0.125).abs() < 1e-15);
    // The height is x.
    assert!(section.iter().flatten().all(|(at, height)| at[0] == 0.5 && *height == 0.5));
    let cut = Cut { point: Vector::new(0.25, 0.25, 0.0), normal: Vector::new(1.0, 1.0, 0.0) };
    let section = cut.cell(corners);
    // The square between (½, 0, 0), (0, ½, 0) and their like half-way up.
    assert!(section.len() == 2 && (area(&section) - 0.5 * 0.5f64.sqrt()).abs() < 1e-15, "{}", area(&section));
    assert!(Cut { point: Vector::new(2.0, 0.0, 0.0), normal: Vector::x() }.cell(corners).is_empty());
    let [a, b, c, _] = corners;
    let kept = Cut { point: Vector::new(0.5, 0.0, 0.0), normal: Vector::x() };
    assert!((area(&kept.face([a, b, c])) - 0.375).abs() < 1e-15);
    assert_eq!(kept.rim([a, b, c]).map(|[p, q]| (p - q).norm()), Some(0.5));
    assert_eq!(kept.line(a, b), Some([a.0, Vector::new(0.5, 0.0, 0.0)]));
}

#[test]
fn a_png_file_has_the_pixels() {
    let scene = Scene {
        faces: vec![face([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]], Paint::Plain(RED))],
        lines: vec![],
    };
    let png = draw(&scene, &window(), &[], 1).png;
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x28\0\0\0\x28\x08\x06\0\0\0"), "{png:?}");
    let length = u32::from_be_bytes(png[33..37].try_into().unwrap()) as usize;
    assert_eq!(&png[37..41], b"IDAT");
    let rows = miniz_oxide::inflate::decompress_to_vec_zlib(&png[41..41 + length]).unwrap();
    let mut above = [0u8; 160];
    let mut pixels = Vec::new();
    for row in rows.chunks(161) {
        let (2, difference) = (row[0], &row[1..]) else { panic!("filter {}", row[0]) };
        above
            .iter_mut()
            .zip(difference)
            .for_each(|(above, difference)| *above = above.wrapping_add(*difference));
        pixels.extend(above.chunks(4).map(<[u8]>::to_vec));
    }
    let mut canvas = Canvas::new(window());
    canvas.face(&scene.faces[0], &[]);
    assert_eq!(pixels, canvas.pixels().1);
}
