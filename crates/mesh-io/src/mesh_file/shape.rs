//! Shapes of volumes: their faces, and how they become tetrahedra.
//!
//! Every quadrilateral is cut by the diagonal through its smallest node, so cells that share one cut it alike, and no node is added. A cell
//! is then cut into the tetrahedra between its smallest node and the triangles that do not touch it (Dompierre et al., 'How to subdivide
//! pyramids, prisms and hexahedra into tetrahedra', have the same diagonals).

use super::{ElementKind, MeshCell};

/// A face by the places of its corners, a triangle's last one twice.
type Face = [usize; 4];

// The faces, in the order and in the sense of Abaqus: their normals point into the cell.
const TETRAHEDRON: &[Face] = &[[0, 1, 2, 2], [0, 3, 1, 1], [1, 3, 2, 2], [2, 3, 0, 0]];
const PYRAMID: &[Face] = &[[0, 1, 2, 3], [0, 4, 1, 1], [1, 4, 2, 2], [2, 4, 3, 3], [3, 4, 0, 0]];
const PRISM: &[Face] = &[[0, 1, 2, 2], [3, 5, 4, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]];
const HEXAHEDRON: &[Face] =
    &[[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];

impl MeshCell {
    /// Returns the corners of a face, a triangle's last one twice; `None` if a volume has no face of this number, or for a surface.
    pub(super) fn face(&self, side: usize) -> Option<[u32; 4]> {
        Some(self.faces().get(side)?.map(|corner| self.corners[corner]))
    }

    /// Returns the corners of a face that is counted from 1 as Exodus counts: its caps, of which a hexahedron and a prism have two, are last.
    pub(super) fn exodus_face(&self, side: u64) -> Option<[u32; 4]> {
        let faces = self.faces().len();
        let caps = if self.kind.corners() < 6 { 1 } else { 2 };
        let side = usize::try_from(side).ok().filter(|side| (1..=faces).contains(side))?;
        self.face((side - 1 + caps) % faces)
    }

    fn faces(&self) -> &'static [Face] {
        match (self.kind.dimension(), self.kind.corners()) {
            (3, 4) => TETRAHEDRON,
            (3, 5) => PYRAMID,
            (3, 6) => PRISM,
            (3, _) => HEXAHEDRON,
            _ => &[],
        }
    }

    /// Cuts a volume into tetrahedra of positive volume, if its corners are in the order of the format. A tetrahedron stays as it is.
    ///
    /// * `map`: the number of each node that decides the cuts.
    pub(super) fn tetrahedra(&self, map: &dyn Fn(u32) -> u32) -> Vec<[u32; 4]> {
        let corners = self.corners.map(map);
        if let ([a, b, c, d, ..], 4) = (corners, self.kind.corners()) {
            return vec![[a, b, c, d]];
        }
        let apex = corners.into_iter().fold(u32::MAX, u32::min);
        let faces = self.faces().iter().map(|face| face.map(|corner| corners[corner]));
        let opposite = faces.filter(|face| !face.contains(&apex));
        opposite.flat_map(triangles_of).map(|[a, b, c]| [a, b, c, apex]).collect()
    }
}

/// Cuts a face into one triangle or two, by the diagonal through its smallest node. Triangles with a node twice are left out.
pub(super) fn triangles_of(face: [u32; 4]) -> impl Iterator<Item = [u32; 3]> {
    let first = (0..4).min_by_key(|k| face[*k]).unwrap_or(0);
    let at = move |k: usize| face[(first + k) % 4];
    let different = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    [[at(0), at(1), at(2)], [at(0), at(2), at(3)]].into_iter().filter(different)
}

/// Counts volumes of one kind of shape in words.
pub(super) fn counted_shape(count: usize, kind: ElementKind) -> String {
    let [one, many] = match kind.corners() {
        4 => ["tetrahedron", "tetrahedra"],
        5 => ["pyramid", "pyramids"],
        6 => ["prism", "prisms"],
        _ => ["hexahedron", "hexahedra"],
    };
    format!("{count} {}", if count == 1 { one } else { many })
}

#[cfg(test)]
mod tests;
