//! Regions of tetrahedra.

use super::region::{Kind, RegionOptions};
use super::sides::{Facets, free_facets};
use super::{MeshCell, MeshFault, MeshFile, MeshFileError, Region};
use crate::words::counted;
use fem_core::space::{Solid, Space};

/// Tetrahedra with a smaller angle between two faces, in degrees, are worth a warning.
const SLIVER: f64 = 0.5;

const SOLID: Kind =
    Kind { dimension: 3, cells: "tetrahedra", facets: "faces, edges", gmsh: "Physical Volume" };

impl MeshFile {
    /// Takes a region of tetrahedra: those of some groups together, or all if there are no names and at most one group of them.
    ///
    /// Quadratic tetrahedra are reduced to their corners, and either order of the corners is accepted. Every group of surfaces that has a
    /// face of the region becomes one of its sides, and so do groups of nodes.
    ///
    /// # Errors
    /// A file without tetrahedra; a group that is not there or is empty.
    pub fn solid_regions(
        &self,
        names: &[&str],
        options: RegionOptions,
    ) -> Result<Region<Solid>, MeshFileError> {
        if !self.has_volumes() {
            let found = format!("{} and no tetrahedra", counted(self.cells.len(), "2D element"));
            return Err(self.fault(MeshFault::Region, found).expected("a mesh of volumes").help(
                "add a Physical Volume, or set Mesh.SaveAll: Gmsh saves only what lies in a group; or make all bodies plane",
            ));
        }
        let (cells, title) = self.named_cells(&SOLID, names)?;
        let cells: Vec<&MeshCell> = cells.iter().map(|cell| &self.volumes[*cell as usize]).collect();
        let mut used = self.nodes_of(cells.iter().copied());
        let (mut notes, mut warnings) = (self.notes.clone(), Vec::new());
        self.note_loose_nodes(&mut notes);
        let place = |n: &u32| <Solid as Space>::Vector::from(self.points[*n as usize]);
        let points: Vec<_> = used.iter().map(place).collect();
        let target = self.join(&mut used, &points, options, &title, (&mut notes, &mut warnings));
        let reduced = cells.iter().filter(|cell| cell.kind.is_quadratic()).count();
        if reduced > 0 {
            let (count, was) =
                (counted(reduced, "quadratic cell"), if reduced == 1 { "was" } else { "were" });
            notes.push(format!(
                "{count} of {title} {was} reduced to the corners: curved sides become flat faces"
            ));
        }
        let local = self.local_numbers(&used, &target);
        let corners: Vec<[u32; 4]> =
            cells.iter().map(|cell| cell.corners.map(|n| local[n as usize])).collect();
        let faces: Vec<[u32; 3]> = corners.iter().flat_map(faces_of).collect();
        let facets = Facets { all: &faces, nodes: used.len(), word: "face", dimension: 2 };
        let nodes_of = |face: u32| {
            let [a, b, c, _] = self.cells[face as usize].corners;
            [a, b, c]
        };
        let groups = self.sides(&local, &facets, &nodes_of, &title, &mut warnings);
        let mut region = Region {
            file: self.name.clone(),
            title,
            points: used.iter().map(place).collect(),
            cells: corners,
            groups,
            node_numbers: used.iter().map(|n| self.node_numbers[*n as usize]).collect(),
            cell_numbers: cells.iter().map(|cell| cell.number).collect(),
            cell_groups: self.group_names(3).map(str::to_owned).collect(),
            notes,
            warnings,
        };
        region.warn_of_flat_cells();
        Ok(region)
    }

    /// Counts the volumes in words.
    pub(super) fn volume_words(&self) -> String {
        match self.volumes.len() {
            1 => "1 tetrahedron".to_owned(),
            count => format!("{count} tetrahedra"),
        }
    }
}

impl Region<Solid> {
    fn warn_of_flat_cells(&mut self) {
        // A cell without a volume is refused later.
        let is_thin = |corners: &[_; 4]| {
            Solid::sure_measure(corners).is_some() && Solid::smallest_angle(corners) < SLIVER
        };
        self.warn_of_thin_cells(&format!("an angle between faces below {SLIVER} degrees"), is_thin);
    }

    /// Says that no side has a name, and what the free boundary is.
    pub fn without_sides(&self) -> Option<MeshFileError> {
        self.nameless(
            || free_facets(self.cells.iter().flat_map(faces_of).collect()).len(),
            "in Gmsh give names to the sides: Physical Surface(\"bottom\") = {…}; in a deck use *SURFACE; or select them \
             in the case file by [[body.side]]",
        )
    }
}

/// The faces of a tetrahedron, each by its nodes in ascending order.
pub(super) fn faces_of(corners: &[u32; 4]) -> [[u32; 3]; 4] {
    std::array::from_fn(|k| {
        let mut face = Solid::facet(k).map(|corner| corners[corner]);
        face.sort_unstable();
        face
    })
}

#[cfg(test)]
mod tests;
