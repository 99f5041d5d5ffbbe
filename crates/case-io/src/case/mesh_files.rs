//! The mesh files of a case: read once, kept as regions, named by their contents.

use super::{Case, CellSelection, Dimension, MeshSource};
use crate::diagnostic::{CaseError, Diagnostic, code};
use fem_core::geometry::Point;
use fem_core::mesh::Mesh;
use mesh_io::{MeshFault, MeshFile, MeshFileError, Region, RegionOptions};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The mesh files of a case: the regions read from them for its bodies.
#[derive(Clone, Debug)]
pub(super) struct MeshFiles<S: Dimension> {
    /// Meshes that were given under names, until they are read.
    given: Vec<(String, MeshFile)>,
    /// Files that have been read already, by their names in the case.
    kept: Vec<(String, MeshFile)>,
    regions: Vec<Option<Arc<Region<S>>>>,
    /// By body: the nodes of its mesh in memory, those without cells included.
    node_counts: Vec<Option<u64>>,
    digests: Vec<Option<String>>,
    /// By body: the groups of cells that its material regions name, with the file's numbers of their cells.
    groups: Vec<Vec<(String, Vec<u64>)>>,
    notes: Vec<String>,
}

impl<S: Dimension> Default for MeshFiles<S> {
    fn default() -> Self {
        Self::for_bodies(0)
    }
}

impl<S: Dimension> MeshFiles<S> {
    /// Has room for a number of bodies.
    fn for_bodies(count: usize) -> Self {
        Self {
            given: Vec::new(),
            kept: Vec::new(),
            regions: vec![None; count],
            node_counts: vec![None; count],
            digests: vec![None; count],
            groups: vec![Vec::new(); count],
            notes: Vec::new(),
        }
    }

    /// Keeps a mesh for the bodies whose file has this name; the last of a name counts.
    pub(super) fn give(&mut self, name: &str, mesh: MeshFile) {
        self.given.retain(|(other, _)| other != name);
        self.given.push((name.to_owned(), mesh));
    }

    /// Keeps a file that has been read, so that it is not read again.
    pub(super) fn keep(&mut self, name: &str, mesh: MeshFile) {
        self.kept.push((name.to_owned(), mesh));
    }

    pub(super) fn given_nodes(&self, body: usize) -> Option<u64> {
        *self.node_counts.get(body)?
    }

    pub(super) fn region(&self, body: usize) -> Option<&Region<S>> {
        self.regions.get(body)?.as_deref()
    }

    /// Returns the hash of the contents of each body's file, if it has one.
    pub(super) fn digests(&self) -> &[Option<String>] {
        &self.digests
    }
}

impl<S: Dimension> Case<S> {
    /// Reads the mesh files that the bodies name; a mesh that a program gives takes the place of the file with its name. Bodies with a
    /// generator are skipped. Then data that a program gives at nodes become data along the sides.
    ///
    /// * `folder`: what the names of mesh files are relative to: the folder of the case file.
    ///
    /// # Errors
    /// Files that cannot be read (with [`code::UNREADABLE`]), that hold no mesh or not the region asked for, and two
    /// bodies that share nodes or cells; arrays with another number of values than a mesh has nodes.
    pub fn read_mesh_files(&mut self, folder: &Path) -> Result<(), CaseError> {
        let given = std::mem::take(&mut self.meshes.given);
        let names: BTreeSet<String> = given.iter().map(|(name, _)| name.clone()).collect();
        let mut files: Vec<(PathBuf, Result<MeshFile, MeshFileError>)> =
            given.into_iter().map(|(name, mesh)| (name.into(), Ok(mesh))).collect();
        let kept = std::mem::take(&mut self.meshes.kept);
        files.extend(kept.into_iter().map(|(name, mesh)| (folder.join(name), Ok(mesh))));
        let mut faults = Vec::new();
        let count = self.bodies.len();
        let mut loaded = MeshFiles::for_bodies(count);
        // The place of each body's file among them.
        let mut places = vec![None; count];
        for (body, place) in places.iter_mut().enumerate() {
            let MeshSource::File { file, .. } = &self.bodies[body].mesh else { continue };
            let path = if names.contains(file) { PathBuf::from(file) } else { folder.join(file) };
            let known = files.iter().position(|(other, _)| *other == path);
            *place = Some(known.unwrap_or_else(|| {
                let read = mesh_io::read(&path);
                files.push((path, read));
                files.len() - 1
            }));
        }
        let file_of = |body: usize| places[body].map(|place: usize| &files[place].1);
        let regions = fem_core::each_body(count, |body| {
            let read = file_of(body)?;
            Some(read.as_ref().map_err(Clone::clone).and_then(|mesh| self.region_of(body, mesh)))
        });
        for (body, region) in regions.into_iter().enumerate() {
            if let Some(Ok(mesh)) = file_of(body) {
                let in_memory = places[body].is_some_and(|place| place < names.len());
                loaded.node_counts[body] = in_memory.then(|| mesh.node_count());
                loaded.digests[body] = Some(mesh.digest().to_owned());
                for region in &self.bodies[body].regions {
                    let CellSelection::Group(name) = &region.cells else { continue };
                    let numbers = mesh.cells_of_group(S::DIM as u8, name);
                    loaded.groups[body].extend(numbers.map(|numbers| (name.clone(), numbers)));
                }
            }
            match region {
                Some(Ok(region)) => loaded.regions[body] = Some(Arc::new(region)),
                Some(Err(error)) => faults.push(self.mesh_file_diagnostic(body, error)),
                None => {}
            }
        }
        for region in loaded.regions.iter().flatten() {
            for note in region.notes() {
                // A note about the whole file comes with each of its regions: list it once.
                if !loaded.notes.contains(note) {
                    loaded.notes.push(note.clone());
                }
            }
        }
        match self.glued(&mut loaded) {
            Err(fault) if faults.is_empty() => faults.push(*fault),
            _ => {}
        }
        if !faults.is_empty() {
            return Err(CaseError::new(faults));
        }
        self.meshes = loaded;
        S::evaluate_given(self)
    }

    /// Takes the region that a body is from its file.
    fn region_of(&self, body: usize, mesh: &MeshFile) -> Result<Region<S>, MeshFileError> {
        let MeshSource::File { region, merge, connected_to, .. } = &self.bodies[body].mesh else {
            return S::region(mesh, &[], RegionOptions::default());
        };
        let names: Vec<&str> = region.iter().map(String::as_str).collect();
        let mut region = S::region(mesh, &names, RegionOptions::with_merge(*merge))?;
        if let Some(side) = connected_to {
            region = region.connected_to(side)?;
        }
        let selected = !self.bodies[body].sides.is_empty();
        S::without_sides(&region).filter(|_| !selected).map_or(Ok(region), Err)
    }

    /// Returns the mesh file's number of each cell, if a mesh of a body has the cells of the
    /// file; `None` for a generated mesh and for one that was refined.
    pub fn element_numbers(&self, body: usize, mesh: &Mesh<S>) -> Option<&[u64]> {
        let region = self.meshes.region(body)?;
        let of_file = region.cells().len() == mesh.cells().len()
            && region.mesh().is_ok_and(|own| own.cells() == mesh.cells());
        of_file.then(|| region.cell_numbers())
    }

    /// Makes the mesh of a body whose file has been read.
    pub(super) fn mesh_of_file(&self, body: usize) -> Result<Mesh<S>, CaseError> {
        let Some(region) = self.meshes.region(body) else { return Err(self.unread_mesh(body)) };
        let mesh = region.mesh().and_then(|mesh| region.without_overlaps(mesh));
        mesh.map_err(|error| self.mesh_file_diagnostic(body, error).into())
    }

    /// Attributes an error of a mesh file to the key that names the file or the region.
    fn mesh_file_diagnostic(&self, body: usize, error: MeshFileError) -> Diagnostic {
        let of_region = format!("body.{body}.mesh.region");
        let path = if error.fault == MeshFault::Region && self.is_given(&of_region) {
            of_region
        } else {
            format!("body.{body}.mesh.file")
        };
        Diagnostic::of_mesh_file(error, self.place(&path))
    }

    /// Refuses bodies that are one mesh, or notes that they were parted if that was asked for.
    fn glued(&self, loaded: &mut MeshFiles<S>) -> Result<(), Box<Diagnostic>> {
        for second in 1..self.bodies.len() {
            for first in 0..second {
                self.glued_pair([first, second], loaded)?;
            }
        }
        Ok(())
    }

    /// [`Self::glued`] of two bodies, the first with the smaller number.
    fn glued_pair(&self, pair: [usize; 2], loaded: &mut MeshFiles<S>) -> Result<(), Box<Diagnostic>> {
        let [
            MeshSource::File { duplicate_interface: part_a, .. },
            MeshSource::File { file: b, duplicate_interface: part_b, .. },
        ] = pair.map(|k| &self.bodies[k].mesh)
        else {
            return Ok(());
        };
        let [Some(first), Some(second)] = pair.map(|k| loaded.regions[k].as_ref()) else { return Ok(()) };
        // The same contents, under any names.
        if loaded.digests[pair[0]] != loaded.digests[pair[1]] {
            return Ok(());
        }
        let Some((count, node, point, cell)) = mesh_io::glued_nodes(first, second) else { return Ok(()) };
        let names = pair.map(|k| &self.bodies[k].name);
        let path = format!("body.{}.mesh.file", pair[1]);
        if let Some(cell) = cell {
            let found =
                format!("{b}: element {cell} belongs to both bodies, \"{}\" and \"{}\"", names[0], names[1]);
            let fault = self.diagnostic(MeshFault::Region.code(), &path, found);
            let fault = fault.expected("regions without a common element");
            return Err(Box::new(fault.fix("give the two bodies two different regions")));
        }
        if *part_a || *part_b {
            let title = if count == 1 { "1 node" } else { &format!("{count} nodes") };
            loaded.notes.push(format!(
                "{title} of {b} belonging to both bodies: each body has its own (duplicate_interface)"
            ));
            return Ok(());
        }
        let found = format!(
            "{b}: the bodies \"{}\" and \"{}\" share {count} nodes (node {node} at {}): as one mesh they \
             cannot part",
            names[0],
            names[1],
            Point::from(point)
        );
        let fault = self.diagnostic(MeshFault::Region.code(), &path, found);
        Err(Box::new(fault.expected("two regions that have their own nodes where they touch").help(Some(
            "write `duplicate_interface = true` into `mesh` to give each body its own nodes, or draw the interface \
             twice"
                .to_owned(),
        ))))
    }

    /// Returns the mesh file of a body, 0 or 1, with the SHA-256 of its contents; `None` for a generated mesh.
    pub fn mesh_file_of(&self, body: usize) -> Option<(&str, &str)> {
        let MeshSource::File { file, .. } = &self.bodies[body].mesh else { return None };
        Some((file, self.meshes.digests.get(body)?.as_deref()?))
    }

    /// Returns what is worth knowing about how the meshes were read: cells split, turned or reduced, nodes left out.
    pub(crate) fn mesh_notes(&self) -> &[String] {
        &self.meshes.notes
    }

    /// Returns the region of the mesh file that a body is.
    pub(super) fn mesh_region(&self, body: usize) -> Option<&Region<S>> {
        self.meshes.region(body)
    }

    /// Returns the file's numbers of the cells of a group that a material region names, ascending.
    pub(super) fn group_of_cells(&self, body: usize, group: &str) -> Option<&[u64]> {
        let groups = self.meshes.groups.get(body)?;
        groups.iter().find(|(name, _)| name == group).map(|(_, numbers)| &numbers[..])
    }

    /// Returns what is probably not meant in the meshes, with the body's place in the case file.
    pub(super) fn mesh_warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = Vec::new();
        for body in 0..self.bodies.len() {
            for warning in self.meshes.region(body).map(Region::warnings).unwrap_or_default() {
                let message = format!("body \"{}\": {}", self.bodies[body].name, Diagnostic::told(warning));
                warnings.push(self.diagnostic(code::MESH, &format!("body.{body}.mesh.file"), message));
            }
        }
        warnings
    }

    /// Helps when a region is named and a side is wanted.
    pub(super) fn region_not_side(&self, body: usize, name: &str) -> Option<String> {
        let region = self.meshes.region(body).filter(|r| r.is_cell_group(name))?;
        Some(format!(
            "\"{name}\" is a group of cells (dimension {}) of the file, {} wants {} (dimension {})",
            S::DIM,
            region.title(),
            S::WORDS.facets,
            S::DIM - 1
        ))
    }

    /// Says that a mesh file was not read.
    pub(super) fn unread_mesh(&self, body: usize) -> CaseError {
        let message = format!("the mesh file of body \"{}\" has not been read", self.bodies[body].name);
        let diagnostic = self.diagnostic(code::UNREADABLE, &format!("body.{body}.mesh.file"), message);
        let diagnostic = diagnostic.expected("the files to have been read");
        diagnostic.fix("call Case::read_mesh_files first").into()
    }
}
