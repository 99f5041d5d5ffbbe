//! A grid of planes that boxes share: their meshes match on every common face, and nodes inside boxes and faces may be moved.

use crate::model::Made;
use crate::random::Random;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use nalgebra::{Rotation3, Vector3};

/// The names of the sides of a box, those at its smaller coordinate first.
pub(super) const SIDES: [&str; 6] = ["left", "front", "bottom", "right", "back", "top"];

/// A box of cells, or a patch of faces if it is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cells {
    /// Its first planes.
    pub(super) low: [usize; 3],
    /// Its last planes.
    pub(super) high: [usize; 3],
}

impl Cells {
    /// Counts the cells along each axis.
    pub(super) fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| self.high[a] - self.low[a])
    }

    /// Counts the nodes.
    pub(super) fn nodes(&self) -> usize {
        self.counts().iter().map(|n| n + 1).product()
    }

    /// Returns a side as a flat box.
    pub(super) fn side(&self, side: usize) -> Self {
        let (axis, mut flat) = (side % 3, *self);
        let plane = if side < 3 { self.low[axis] } else { self.high[axis] };
        (flat.low[axis], flat.high[axis]) = (plane, plane);
        flat
    }

    /// Returns the common part of two flat boxes across the same axis; `None` without a face.
    pub(super) fn common(&self, other: &Self, axis: usize) -> Option<Self> {
        let low = [0, 1, 2].map(|a| self.low[a].max(other.low[a]));
        let high = [0, 1, 2].map(|a| self.high[a].min(other.high[a]));
        let has_face = (0..3).all(|a| if a == axis { low[a] == high[a] } else { low[a] < high[a] });
        has_face.then_some(Self { low, high })
    }

    /// Counts the faces of cells of a flat box.
    pub(super) fn faces(&self, axis: usize) -> usize {
        (0..3).filter(|a| *a != axis).map(|a| self.high[a] - self.low[a]).product()
    }

    /// Tells if a flat box has a face of a cell.
    fn has_face(&self, face: [usize; 3], axis: usize) -> bool {
        (0..3).all(|a| a == axis || (self.low[a]..self.high[a]).contains(&face[a]))
    }
}

/// A part of a side that has a name of its own.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Its name.
    pub(super) name: String,
    /// The number of the side in [`SIDES`].
    pub(super) side: usize,
    /// Its faces.
    pub(super) faces: Cells,
}

/// Planes along each axis, and moved nodes.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Coordinates of the planes, m.
    pub(super) planes: [Vec<f64>; 3],
    /// The directions in which nodes are moved, as parts of the next cell; x first.
    moved: Vec<Vector3<f64>>,
    /// The size of the moves.
    pub(super) part: f64,
    /// Further moves, m; none if it is empty.
    bent: Vec<Vector3<f64>>,
}

impl Grid {
    /// Draws the moves of all nodes. A node keeps to the sides of all boxes that it lies on.
    pub(super) fn new(planes: [Vec<f64>; 3], boxes: &[Cells], random: &mut Random) -> Self {
        let counts = [0, 1, 2].map(|a: usize| planes[a].len());
        let mut moved = Vec::new();
        for (k, j) in (0..counts[2]).flat_map(|k| (0..counts[1]).map(move |j| (k, j))) {
            for i in 0..counts[0] {
                let at = [i, j, k];
                let mut direction = Vector3::from_fn(|_, _| random.signed());
                for of in boxes.iter().filter(|b| (0..3).all(|a| b.low[a] <= at[a] && at[a] <= b.high[a])) {
                    for a in 0..3 {
                        if at[a] == of.low[a] || at[a] == of.high[a] {
                            direction[a] = 0.0;
                        }
                    }
                }
                moved.push(direction);
            }
        }
        Self { planes, moved, part: 0.0, bent: Vec::new() }
    }

    /// Returns the grid with moves of a size, as a part of the cells.
    pub(super) fn with_moves(&self, part: f64) -> Self {
        Self { part, ..self.clone() }
    }

    /// Bends a common side of two boxes along its axis at those of its nodes at which no other box has a side and that are not at the end of a larger
    /// side. `None` if cells get slivers or turn over.
    ///
    /// * `height`: how far a node moves, m.
    ///
    /// # Errors
    /// None, for the boxes of this grid.
    pub(super) fn bent(
        &self,
        (axis, faces): (usize, &Cells),
        boxes: &[Cells],
        mut height: impl FnMut([usize; 3]) -> f64,
    ) -> Made<Option<Self>> {
        let is_whole = self.is_whole((axis, faces), boxes);
        let has = |of: &Cells, at: [usize; 3]| (0..3).all(|a| of.low[a] <= at[a] && at[a] <= of.high[a]);
        let mut found = self.clone();
        found.bent.resize(found.moved.len(), Vector3::zeros());
        for n in 0..found.moved.len() {
            let counts = [0, 1].map(|a: usize| self.planes[a].len());
            let at = [n % counts[0], n / counts[0] % counts[1], n / counts[0] / counts[1]];
            let within = (0..3).all(|a| a == axis || faces.low[a] < at[a] && at[a] < faces.high[a]);
            let sides = boxes.iter().flat_map(|of| [of.side(axis), of.side(axis + 3)]);
            if has(faces, at) && (within || is_whole) && sides.filter(|side| has(side, at)).count() == 2 {
                found.bent[n][axis] = height(at);
            }
        }
        Ok((found.smallest_angle(boxes)? > 3.0).then_some(found))
    }

    /// Tells if a common side is the whole side of both boxes, and all its nodes can be bent.
    pub(super) fn is_whole(&self, (axis, faces): (usize, &Cells), boxes: &[Cells]) -> bool {
        let sides = || boxes.iter().flat_map(|of| [of.side(axis), of.side(axis + 3)]);
        let meets =
            |side: &Cells| (0..3).all(|a| side.low[a] <= faces.high[a] && faces.low[a] <= side.high[a]);
        sides().filter(|side| side == faces).count() == 2 && sides().filter(meets).count() == 2
    }

    /// Tells if any side is bent.
    pub(super) fn is_bent(&self) -> bool {
        self.bent.iter().any(|by| *by != Vector3::zeros())
    }

    /// Returns the distance to the next plane, m.
    pub(super) fn spacing(&self, at: [usize; 3], axis: usize) -> f64 {
        let (planes, at) = (&self.planes[axis], at[axis]);
        let next = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|n| planes.get(n));
        next.map(|next| (next - planes[at]).abs()).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn point(&self, at: [usize; 3]) -> Vector3<f64> {
        let counts = [0, 1, 2].map(|a: usize| self.planes[a].len());
        let n = at[0] + counts[0] * (at[1] + counts[1] * at[2]);
        let direction = self.moved[n];
        let flat =
            Vector3::from_fn(|a, _| self.planes[a][at[a]] + self.part * direction[a] * self.spacing(at, a));
        self.bent.get(n).map_or(flat, |bent| flat + bent)
    }

    fn points(&self, of: &Cells) -> Vec<Vector3<f64>> {
        let [nx, ny, nz] = of.counts();
        let mut points = Vec::new();
        for (k, j) in (0..=nz).flat_map(|k| (0..=ny).map(move |j| (k, j))) {
            points.extend((0..=nx).map(|i| self.point([of.low[0] + i, of.low[1] + j, of.low[2] + k])));
        }
        points
    }

    /// Returns the middle of a box or a side, m.
    pub(super) fn middle(&self, of: &Cells) -> Vector3<f64> {
        Vector3::from_fn(|a, _| 0.5 * (self.planes[a][of.low[a]] + self.planes[a][of.high[a]]))
    }

    /// Returns the sizes of a box or a side, m.
    pub(super) fn sizes(&self, of: &Cells) -> Vector3<f64> {
        Vector3::from_fn(|a, _| self.planes[a][of.high[a]] - self.planes[a][of.low[a]])
    }

    /// Meshes a box, with half the cells a number of times: each mesh contains the one before. The rest of each side, without the patches, has
    /// the name of the side.
    ///
    /// # Errors
    /// Cells that the moves of nodes turn over.
    pub(super) fn mesh(
        &self,
        of: &Cells,
        halved: u32,
        patches: &[Patch],
        turn: &Rotation3<f64>,
    ) -> Made<TetMesh> {
        let (mut counts, mut points) = (of.counts(), self.points(of));
        for _ in 0..halved {
            points = prolonged(counts, &points);
            counts = counts.map(|n| 2 * n);
        }
        let mesh = cuboid([0.0; 3], [1.0; 3], counts)?;
        let place = |node: usize| {
            let row = counts[0] + 1;
            [node % row, node / row % (counts[1] + 1), node / row / (counts[1] + 1)]
        };
        let mut groups: Vec<(String, Vec<_>)> =
            patches.iter().map(|p| (p.name.clone(), Vec::new())).collect();
        for (side, name) in SIDES.into_iter().enumerate() {
            let mut rest = Vec::new();
            for facet in mesh.group(name).unwrap_or_default() {
                let nodes = mesh.topology().facets()[*facet];
                let corners = nodes.map(|n| place(n.index()));
                // The corner with the smallest coordinates is one of each triangle.
                let face = [0, 1, 2]
                    .map(|a| of.low[a] + (corners.iter().map(|c| c[a]).min().unwrap_or(0) >> halved));
                let inside = |p: &Patch| p.side == side && p.faces.has_face(face, side % 3);
                match patches.iter().position(inside) {
                    Some(k) => groups[k].1.push(nodes),
                    None => rest.push(nodes),
                }
            }
            if !rest.is_empty() {
                groups.push((name.to_owned(), rest));
            }
        }
        let points = points.into_iter().map(|x| turn * x).collect();
        let made = Mesh::new(points, mesh.cells().to_vec(), groups)?;
        if made.turned() > 0 {
            return Err("cells are turned over".into());
        }
        Ok(made)
    }

    /// Computes the smallest angle between two faces of a tetrahedron of some boxes, degrees; 0 if one is turned over.
    pub(super) fn smallest_angle(&self, boxes: &[Cells]) -> Made<f64> {
        let mut smallest = 180.0f64;
        for of in boxes {
            let points = self.points(of);
            let mesh = cuboid([0.0; 3], [1.0; 3], of.counts())?;
            for cell in mesh.cells() {
                smallest = smallest.min(angle(cell.map(|n| points[n.index()])));
            }
        }
        Ok(smallest)
    }
}

/// Computes the smallest angle between two faces, degrees; 0 for a negative volume.
fn angle(corners: [Vector3<f64>; 4]) -> f64 {
    let edge = |i: usize, j: usize| corners[j] - corners[i];
    let volume = edge(0, 1).cross(&edge(0, 2)).dot(&edge(0, 3));
    if !(volume > 0.0) {
        return 0.0;
    }
    let mut smallest = 180.0f64;
    for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let along = edge(i, j).normalize();
        // The parts of the other two corners across the edge.
        let across: Vec<_> = (0..4)
            .filter(|k| *k != i && *k != j)
            .map(|k| edge(i, k) - edge(i, k).dot(&along) * along)
            .collect();
        smallest = smallest.min(across[0].angle(&across[1]).to_degrees());
    }
    smallest
}

/// Interpolates a field on a mesh of a box with half the cells.
///
/// * `counts`: cells along each axis of the coarser mesh.
pub(super) fn prolonged([nx, ny, nz]: [usize; 3], coarse: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let at = |[i, j, k]: [usize; 3]| coarse[i + (nx + 1) * (j + (ny + 1) * k)];
    let mut fine = Vec::new();
    for (k, j) in (0..=2 * nz).flat_map(|k| (0..=2 * ny).map(move |j| (k, j))) {
        for i in 0..=2 * nx {
            // Half way along an edge of the coarse mesh, or of its diagonals.
            fine.push((at([i / 2, j / 2, k / 2]) + at([i, j, k].map(|c| c.div_ceil(2)))) / 2.0);
        }
    }
    fine
}
