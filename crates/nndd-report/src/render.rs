//! Pictures of solids: faces and lines in an orthographic view, drawn with a depth buffer and encoded as PNG.
//!
//! ```text
//! Scene (faces, lines) ─ Window (view, place, size) ─► canvas (colour and depth of each sample) ─► Drawing ─► PNG
//! ```
//! All of it is sums and comparisons in a fixed order, so the bytes of a picture are the same for every number of threads.

mod camera;
mod canvas;
mod cut;
mod png;
mod skin;
#[cfg(test)]
mod tests;

pub(crate) use camera::{View, Window};
pub(crate) use canvas::{Drawing, draw};
pub(crate) use cut::Cut;
pub(crate) use skin::{Skin, SkinFace};

use fem_core::space::{Solid, Space};

/// A point or a direction in space.
pub(crate) type Vector = <Solid as Space>::Vector;

/// Red, green, blue.
pub(crate) type Colour = [u8; 3];

/// How a face is coloured.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Paint {
    /// One colour.
    Plain(Colour),
    /// Stripes of two colours.
    Striped([Colour; 2]),
    /// By the colour scale: a height between 0 and 1 at each corner; NaN has no colour of the scale.
    Heights([f64; 3]),
}

/// A triangle of a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) corners: [Vector; 3],
    pub(crate) paint: Paint,
    /// The number of its body.
    pub(crate) body: u16,
}

/// A line of a scene. Faces nearer to the viewer hide it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) ends: [Vector; 2],
    pub(crate) colour: Colour,
    /// In pixels of the page.
    pub(crate) width: f64,
}

/// The things that a picture shows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scene {
    pub(crate) faces: Vec<Face>,
    pub(crate) lines: Vec<Line>,
}

impl Scene {
    /// Lists all corners and ends.
    pub(crate) fn points(&self) -> impl Iterator<Item = Vector> + '_ {
        let corners = self.faces.iter().flat_map(|face| face.corners);
        corners.chain(self.lines.iter().flat_map(|line| line.ends))
    }

    /// Adds an arrow with its tip at `to`.
    ///
    /// * `across`: a direction in which its head is wide.
    pub(crate) fn arrow(&mut self, [from, to]: [Vector; 2], across: Vector, colour: Colour) {
        const HEAD: f64 = 0.3;
        let shaft = to - from;
        let side = shaft.cross(&across);
        let side = if side.norm() > 0.0 { side * (0.5 * HEAD * shaft.norm() / side.norm()) } else { side };
        let neck = to - HEAD * shaft;
        let ends = [[from, to], [neck + side, to], [neck - side, to]];
        self.lines.extend(ends.map(|ends| Line { ends, colour, width: 1.75 }));
    }
}
