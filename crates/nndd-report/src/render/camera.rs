//! The view of a picture, and the part of it that the picture shows.

use super::Vector;

/// An orthographic view: three perpendicular unit vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) right: Vector,
    pub(crate) up: Vector,
    /// From the scene to the viewer.
    pub(crate) towards: Vector,
}

impl View {
    /// Makes a view from a direction to the viewer, and one that shall be as upright as possible; each may have any length.
    pub(crate) fn new(towards: Vector, up: Vector) -> View {
        let unit = |v: Vector, otherwise: Vector| {
            let length = v.norm();
            if length > 0.0 && length.is_finite() { v / length } else { otherwise }
        };
        let towards = unit(towards, Vector::z());
        let axes = [up, Vector::y(), Vector::x()];
        // An upright direction along the view says nothing.
        let across = axes.map(|up| up.cross(&towards));
        let right = across.into_iter().find(|right| right.norm() > 1e-6 * up.norm()).unwrap_or(Vector::x());
        let right = unit(right, Vector::x());
        View { right, up: towards.cross(&right), towards }
    }

    /// Returns the coordinates of a point to the right, upwards and towards the viewer.
    pub(crate) fn seen(&self, point: Vector) -> [f64; 3] {
        [self.right, self.up, self.towards].map(|axis| axis.dot(&point))
    }

    /// Finds the smallest and largest coordinates of some points to the right and upwards; `None` without points.
    pub(crate) fn extents(&self, points: impl Iterator<Item = Vector>) -> Option<[[f64; 2]; 2]> {
        points.map(|point| self.seen(point)).filter(|seen| seen.iter().all(|x| x.is_finite())).fold(
            None,
            |extents: Option<[[f64; 2]; 2]>, seen| {
                let old = extents.unwrap_or([[seen[0]; 2], [seen[1]; 2]]);
                Some([0, 1].map(|c| [old[c][0].min(seen[c]), old[c][1].max(seen[c])]))
            },
        )
    }
}

/// The part of a view that a picture shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) view: View,
    /// The coordinates of its middle to the right and upwards.
    pub(crate) middle: [f64; 2],
    /// The length of a pixel of the page.
    pub(crate) pixel: f64,
    /// Its width and height in pixels of the page.
    pub(crate) size: [usize; 2],
}

impl Window {
    /// Returns the place of a point, in pixels from the left and from the top, and its height above the middle of the picture in pixels.
    pub(crate) fn place(&self, point: Vector) -> [f64; 3] {
        let [x, y, depth] = self.view.seen(point);
        let [width, height] = self.size.map(|n| n as f64);
        [
            0.5 * width + (x - self.middle[0]) / self.pixel,
            0.5 * height - (y - self.middle[1]) / self.pixel,
            depth / self.pixel,
        ]
    }
}
