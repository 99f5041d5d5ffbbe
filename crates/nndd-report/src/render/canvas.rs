//! The depth buffer: faces and lines become samples, and the means of samples become pixels.

use super::png;
use super::{Colour, Face, Line, Paint, Scene, Vector, Window};

/// Pixels of the picture in one of the page, in each direction: words beside the picture are sharper than it otherwise.
const RESOLUTION: usize = 2;
/// Samples of a pixel of the picture, in each direction.
const SAMPLES: usize = 2;
/// Samples of a pixel of the page, in each direction.
const FINE: usize = RESOLUTION * SAMPLES;
/// The light that falls on a face from the side; all of it falls on one that faces the light.
const AMBIENT: f64 = 0.7;
/// The direction to the light: to the right, upwards, towards the viewer.
const LIGHT: [f64; 3] = [0.3, 0.5, 0.81];
/// A line is drawn in front of faces that hide it by less than this many pixels of the page: it lies in them.
const IN_FACE: f64 = 2.0;
/// Width of a stripe, in samples.
const STRIPE: usize = 3 * FINE;
/// The colour of unknown values.
const UNKNOWN: Colour = [160, 160, 160];
/// No body.
const NOBODY: u16 = u16::MAX;
/// Samples between two that are tried as the place of a name.
const STEP: usize = 2 * FINE;

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing {
    /// The file.
    pub(crate) png: Vec<u8>,
    /// For each body of the scene a place on it that can be seen, near the middle of all such places, in pixels of the page.
    pub(crate) places: Vec<Option<[f64; 2]>>,
}

/// Draws a scene.
///
/// * `colours`: of the scale, at equal steps.
/// * `bodies`: their number.
pub(crate) fn draw(scene: &Scene, window: &Window, colours: &[Colour], bodies: usize) -> Drawing {
    let mut canvas = Canvas::new(*window);
    for face in &scene.faces {
        canvas.face(face, colours);
    }
    let places = canvas.places(bodies);
    for line in &scene.lines {
        canvas.line(line);
    }
    Drawing { png: canvas.png(), places }
}

#[derive(Clone, Copy)]
struct Sample {
    colour: Colour,
    is_drawn: bool,
    body: u16,
    depth: f32,
}

/// The samples of a picture.
pub(super) struct Canvas {
    window: Window,
    size: [usize; 2],
    samples: Vec<Sample>,
}

impl Canvas {
    pub(super) fn new(window: Window) -> Canvas {
        let size = window.size.map(|n| n * FINE);
        let empty = Sample { colour: [0; 3], is_drawn: false, body: NOBODY, depth: f32::NEG_INFINITY };
        Canvas { window, size, samples: vec![empty; size[0] * size[1]] }
    }

    /// Returns the place of a point in samples, and its depth in pixels of the page; `None` if it cannot be drawn.
    fn place(&self, point: Vector) -> Option<[f64; 3]> {
        let [x, y, depth] = self.window.place(point);
        let place = [x * FINE as f64, y * FINE as f64, depth];
        place.iter().all(|x| x.abs() < 1e9).then_some(place)
    }

    /// Lists the samples with their middle between two coordinates.
    fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let end = self.size[axis] as f64;
        (low - 0.5).ceil().clamp(0.0, end) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, end) as usize
    }

    pub(super) fn face(&mut self, face: &Face, colours: &[Colour]) {
        let [Some(a), Some(b), Some(c)] = face.corners.map(|corner| self.place(corner)) else { return };
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice == 0.0 {
            return;
        }
        let shade = self.shade(&face.corners);
        // Barycentric coordinates are linear: each has a value at the corner of the picture and two slopes.
        let linear = |p: [f64; 3], q: [f64; 3]| {
            let slope = [(p[1] - q[1]) / twice, (q[0] - p[0]) / twice];
            [-(slope[0] * p[0] + slope[1] * p[1]), slope[0], slope[1]]
        };
        let parts = [linear(b, c), linear(c, a), linear(a, b)];
        let ends = |axis: usize| [a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis])];
        let [[left, right], [top, bottom]] = [ends(0), ends(1)];
        for row in self.range(1, top, bottom) {
            let y = row as f64 + 0.5;
            // The samples of the row that are inside.
            let (mut low, mut high) = (left, right);
            for [start, slope, down] in parts {
                let start = start + down * y;
                match slope {
                    0.0 if start < 0.0 => high = f64::NEG_INFINITY,
                    0.0 => {}
                    _ if slope > 0.0 => low = low.max(-start / slope),
                    _ => high = high.min(-start / slope),
                }
            }
            for column in self.range(0, low, high) {
                let x = column as f64 + 0.5;
                let weights = parts.map(|[start, slope, down]| start + slope * x + down * y);
                let depth = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) as f32;
                let sample = &mut self.samples[row * self.size[0] + column];
                if depth > sample.depth {
                    let colour = match face.paint {
                        Paint::Plain(colour) => colour,
                        Paint::Striped(both) => both[(row + column) / STRIPE % 2],
                        Paint::Heights(heights) => scaled(colours, heights, weights),
                    };
                    let colour = colour.map(|part| (f64::from(part) * shade).round() as u8);
                    *sample = Sample { colour, is_drawn: true, body: face.body, depth };
                }
            }
        }
    }

    /// Computes the part of its colour that a face has in the light.
    fn shade(&self, [a, b, c]: &[Vector; 3]) -> f64 {
        let normal = (b - a).cross(&(c - a));
        let length = normal.norm();
        if !(length > 0.0) {
            return AMBIENT;
        }
        let [x, y, z] = self.window.view.seen(normal / length);
        // Whichever way its corners run, the face looks to the viewer.
        let lit = z.signum() * (LIGHT[0] * x + LIGHT[1] * y + LIGHT[2] * z);
        AMBIENT + (1.0 - AMBIENT) * lit.clamp(0.0, 1.0)
    }

    pub(super) fn line(&mut self, line: &Line) {
        let [Some(from), Some(to)] = line.ends.map(|end| self.place(end)) else { return };
        let length = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
        // A line of many times the picture's size is mostly outside of it; its steps are bounded.
        let steps = length.ceil().clamp(1.0, 1e5) as usize;
        let half = 0.5 * line.width * FINE as f64;
        for step in 0..=steps {
            let part = step as f64 / steps as f64;
            let [x, y, depth] = [0, 1, 2].map(|c: usize| from[c] + part * (to[c] - from[c]));
            for row in self.range(1, y - half, y + half) {
                for column in self.range(0, x - half, x + half) {
                    let sample = &mut self.samples[row * self.size[0] + column];
                    if depth + IN_FACE >= f64::from(sample.depth) {
                        (sample.colour, sample.is_drawn) = (line.colour, true);
                    }
                }
            }
        }
    }

    /// Finds a place for the name of each body.
    fn places(&self, bodies: usize) -> Vec<Option<[f64; 2]>> {
        let mut sums = vec![[0.0; 3]; bodies];
        let tried = || {
            let rows = (0..self.size[1]).step_by(STEP);
            let places =
                rows.flat_map(|row| (0..self.size[0]).step_by(STEP).map(move |column| (row, column)));
            let body =
                |row: usize, column: usize| usize::from(self.samples[row * self.size[0] + column].body);
            places.map(move |(row, column)| (body(row, column), [column as f64, row as f64]))
        };
        for (body, [x, y]) in tried().filter(|(body, _)| *body < bodies) {
            let sum = &mut sums[body];
            *sum = [sum[0] + x, sum[1] + y, sum[2] + 1.0];
        }
        let mut nearest = vec![None; bodies];
        for (body, at) in tried().filter(|(body, _)| *body < bodies) {
            let [x, y, count] = sums[body];
            let distance = (at[0] - x / count).powi(2) + (at[1] - y / count).powi(2);
            if nearest[body].is_none_or(|(least, _)| distance < least) {
                nearest[body] = Some((distance, at));
            }
        }
        nearest.into_iter().map(|found| found.map(|(_, at)| at.map(|x| x / FINE as f64))).collect()
    }

    /// Returns the pixels of the picture row by row: red, green, blue and opacity, each the mean of its samples.
    pub(super) fn pixels(&self) -> ([usize; 2], Vec<[u8; 4]>) {
        let size = self.size.map(|n| n / SAMPLES);
        let pixel = |row: usize, column: usize| {
            let (mut sum, mut count) = ([0u32; 3], 0u32);
            for k in 0..SAMPLES * SAMPLES {
                let place = (row * SAMPLES + k / SAMPLES) * self.size[0] + column * SAMPLES + k % SAMPLES;
                let Sample { colour, is_drawn, .. } = self.samples[place];
                if is_drawn {
                    (0..3).for_each(|c| sum[c] += u32::from(colour[c]));
                    count += 1;
                }
            }
            let [r, g, b] = sum.map(|part| (part / count.max(1)) as u8);
            [r, g, b, (255 * count / (SAMPLES * SAMPLES) as u32) as u8]
        };
        let rows = 0..size[1];
        (size, rows.flat_map(|row| (0..size[0]).map(move |column| pixel(row, column))).collect())
    }

    fn png(&self) -> Vec<u8> {
        let (size, pixels) = self.pixels();
        png::encode(size, &pixels)
    }
}

/// Returns the colour at a place in a face.
fn scaled(colours: &[Colour], heights: [f64; 3], weights: [f64; 3]) -> Colour {
    let height: f64 = heights.iter().zip(weights).map(|(height, weight)| height * weight).sum();
    if !height.is_finite() || colours.is_empty() {
        return UNKNOWN;
    }
    colours[((height * colours.len() as f64).max(0.0) as usize).min(colours.len() - 1)]
}
