//! Regions of volumes, as tetrahedra.

use super::region::{Kind, RegionOptions};
use super::shape::{counted_shape, triangles_of};
use super::sides::{Facets, free_facets};
use super::{ElementKind, MeshCell, MeshFault, MeshFile, MeshFileError, Region};
use crate::words::counted;
use fem_core::space::{Solid, Space};
use std::collections::BTreeMap;

/// Tetrahedra with a smaller angle between two faces, in degrees, are worth a warning.
const SLIVER: f64 = 0.5;

const SOLID: Kind = Kind { dimension: 3, cells: "volumes", facets: "faces, edges", gmsh: "Physical Volume" };

impl MeshFile {
    /// Takes a region of volumes: those of some groups together, or all if there are no names and at most one group of them.
    ///
    /// Quadratic cells are reduced to their corners. Pyramids, prisms and hexahedra are split into tetrahedra without new nodes: each
    /// quadrilateral, of a cell or of a surface, is cut by the diagonal through its node of smallest number. Either order of the corners is
    /// accepted. Every group of surfaces that has a face of the region becomes one of its sides, and so do groups of nodes.
    ///
    /// # Errors
    /// A file without volumes; a group that is not there or is empty; a cell that is flat, turned over in part or twisted.
    pub fn solid_regions(
        &self,
        names: &[&str],
        options: RegionOptions,
    ) -> Result<Region<Solid>, MeshFileError> {
        if !self.has_volumes() {
            let found = format!("{} and no volumes", counted(self.cells.len(), "2D element"));
            return Err(self.fault(MeshFault::Region, found).expected("a mesh of volumes").help(
                "add a Physical Volume, or set Mesh.SaveAll: Gmsh saves only what lies in a group; or make all bodies plane",
            ));
        }
        let (cells, title) = self.named_cells(&SOLID, names)?;
        let cells = cells.iter().map(|cell| &self.volumes[*cell as usize]);
        let mut used = self.nodes_of(cells.clone());
        let (mut notes, mut warnings) = (self.notes.clone(), Vec::new());
        self.note_loose_nodes(&mut notes);
        let place = |n: &u32| self.xyz(*n);
        let points: Vec<_> = used.iter().map(place).collect();
        let target = self.join(&mut used, &points, options, &title, (&mut notes, &mut warnings));
        let local = self.local_numbers(&used, &target);
        let points: Vec<_> = used.iter().map(place).collect();
        let made = Tetrahedra::of(cells.clone(), &|n| local[n as usize], &|n| points[n as usize]);
        if let Some(cell) = &made.first_degenerate {
            return Err(self.degenerate(
                cell,
                made.degenerate,
                "is flat, turned over in part or twisted",
                &title,
            ));
        }
        notes.extend(made.describe(&title));
        let faces: Vec<[u32; 3]> = made.corners.iter().flat_map(faces_of).collect();
        let halves = if self.group_names(0).next().is_none() { Vec::new() } else { halves(cells, &local) };
        let facets = Facets { all: &faces, nodes: used.len(), word: "face", dimension: 2, halves: &halves };
        let facets_of = |face: u32| {
            let corners = self.cells[face as usize].first_four().map(|n| local[n as usize]);
            triangles_of(corners).map(ascending).collect()
        };
        let groups = self.sides(&local, &facets, &facets_of, &title, &mut warnings);
        let mut region = Region {
            file: self.name.clone(),
            title,
            points,
            cells: made.corners,
            groups,
            node_numbers: used.iter().map(|n| self.node_numbers[*n as usize]).collect(),
            cell_numbers: made.cells,
            cell_groups: self.group_names(3).map(str::to_owned).collect(),
            notes,
            warnings,
        };
        region.warn_of_flat_cells();
        Ok(region)
    }
}

/// The tetrahedra of volumes, and what was done to get them.
#[derive(Default)]
pub(super) struct Tetrahedra {
    pub(super) corners: Vec<[u32; 4]>,
    /// The file's number of the cell each was made of.
    pub(super) cells: Vec<u64>,
    /// Pyramids, prisms and hexahedra: how many were split, and into how many tetrahedra.
    split: BTreeMap<usize, (ElementKind, [usize; 2])>,
    reduced: usize,
    /// Cells that are flat, turned over in part or twisted: how many, and the first.
    pub(super) degenerate: usize,
    pub(super) first_degenerate: Option<MeshCell>,
}

impl Tetrahedra {
    /// Splits volumes.
    ///
    /// * `map`: the number of each node in the tetrahedra; `place`: the place of a node, by this number.
    pub(super) fn of<'a>(
        cells: impl Iterator<Item = &'a MeshCell>,
        map: &dyn Fn(u32) -> u32,
        place: &dyn Fn(u32) -> <Solid as Space>::Vector,
    ) -> Self {
        let mut made = Self::default();
        for cell in cells {
            let tetrahedra = cell.tetrahedra(map);
            let volume = |t: &[u32; 4]| Solid::sure_measure(&t.map(place)).unwrap_or(0.0);
            let above = tetrahedra.iter().filter(|t| volume(t) > 0.0).count();
            let below = tetrahedra.iter().filter(|t| volume(t) < 0.0).count();
            if above.max(below) < tetrahedra.len().max(1) {
                made.degenerate += 1;
                made.first_degenerate.get_or_insert(*cell);
                continue;
            }
            made.reduced += usize::from(cell.kind.is_quadratic());
            if cell.kind.corners() > 4 {
                let of_shape = made.split.entry(cell.kind.corners()).or_insert((cell.kind, [0; 2]));
                of_shape.1[0] += 1;
                of_shape.1[1] += tetrahedra.len();
            }
            made.cells.extend(tetrahedra.iter().map(|_| cell.number));
            made.corners.extend(tetrahedra);
        }
        made
    }

    /// Says what was done to the cells.
    ///
    /// * `title`: what the cells belong to.
    pub(super) fn describe(&self, title: &str) -> Vec<String> {
        let was = |count: usize| if count == 1 { "was" } else { "were" };
        let mut notes: Vec<String> = Vec::new();
        for (kind, [count, parts]) in self.split.values() {
            notes.push(format!(
                "{} of {title} {} split into {parts} tetrahedra: each quadrilateral is cut through its node of smallest number",
                counted_shape(*count, *kind),
                was(*count)
            ));
        }
        if self.reduced > 0 {
            notes.push(format!(
                "{} of {title} {} reduced to the corners: curved sides become flat faces",
                counted(self.reduced, "quadratic cell"),
                was(self.reduced)
            ));
        }
        notes
    }
}

impl MeshFile {
    /// Counts the volumes in words.
    pub(super) fn volume_words(&self) -> String {
        let count = self.volumes.len();
        let first = self
            .volumes
            .first()
            .filter(|first| self.volumes.iter().all(|other| other.kind.corners() == first.kind.corners()));
        first.map_or_else(|| counted(count, "volume"), |first| counted_shape(count, first.kind))
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

/// Lists the triangles into which the quadrilaterals of volumes are cut, each with the corner that it lacks; ascending.
fn halves<'a>(cells: impl Iterator<Item = &'a MeshCell>, local: &[u32]) -> Vec<([u32; 3], u32)> {
    let mut halves = Vec::new();
    for face in cells.flat_map(|cell| (0..).map_while(|side| cell.face(side))) {
        let corners = face.map(|n| local[n as usize]);
        for half in triangles_of(corners) {
            halves.extend(corners.into_iter().find(|n| !half.contains(n)).map(|n| (ascending(half), n)));
        }
    }
    halves.sort_unstable();
    halves.dedup();
    halves
}

fn ascending(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// The faces of a tetrahedron, each by its nodes in ascending order.
pub(super) fn faces_of(corners: &[u32; 4]) -> [[u32; 3]; 4] {
    std::array::from_fn(|k| ascending(Solid::facet(k).map(|corner| corners[corner])))
}

#[cfg(test)]
mod tests;
