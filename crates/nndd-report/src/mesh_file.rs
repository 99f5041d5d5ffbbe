//! The bodies that the regions of a mesh file make: their sides, and the sides that face each other.

use case_io::case::Dimension;
use certified_contact::contact_geometry::{FacingSides, facing_sides};
use fem_core::geometry::Coordinates;
use fem_core::mesh::Mesh;
use fem_core::space::{Plane, Solid, Space};
use mesh_io::{MeshFile, RegionOptions};
use std::collections::HashSet;

/// Sides that face each other within this part of a facet's radius are listed.
const REACH: f64 = 0.1;
/// Sides farther apart than this part of the body's size do not touch, see `gap` in the table of keys.
const APART: f64 = 1e-6;

/// A side of a region.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshSide {
    /// The region, empty if the file has none.
    pub region: String,
    /// The name of the side.
    pub side: String,
    /// Number of edges or faces.
    pub facets: usize,
    /// Length, or area in solids, in the unit of the file.
    pub measure: f64,
    /// The mean of the outward normals, weighted by the measure: of length 1 on a flat side, 0 on a closed one.
    pub normal: Vec<f64>,
}

/// Two sides of different regions that face each other.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshContact {
    /// The regions.
    pub regions: [String; 2],
    /// A side of each.
    pub sides: [String; 2],
    /// The largest distance between facets that face each other, in the unit of the file; `None` if the sides touch.
    pub apart: Option<f64>,
}

/// Lists the sides of the regions of a file, and those that face each other within a tenth of a facet.
///
/// Regions that make no mesh are left out, and so is one that has cells of an earlier one.
pub fn sides(file: &MeshFile) -> (Vec<MeshSide>, Vec<MeshContact>) {
    if file.has_volumes() { sides_in::<Solid>(file) } else { sides_in::<Plane>(file) }
}

fn sides_in<S: Dimension>(file: &MeshFile) -> (Vec<MeshSide>, Vec<MeshContact>) {
    let meshes = meshes::<S>(file);
    let side = |(region, mesh): &(String, Mesh<S>)| -> Vec<MeshSide> {
        mesh.groups().keys().filter_map(|name| side_of(mesh, region, name)).collect()
    };
    let contact = |FacingSides { bodies, sides, distance, .. }: FacingSides| {
        let size = bodies
            .map(|k| fem_core::geometry::diagonal(meshes[k].1.points()))
            .into_iter()
            .fold(0.0, f64::max);
        let apart = (distance > APART * size).then_some(distance);
        MeshContact { regions: bodies.map(|k| meshes[k].0.clone()), sides, apart }
    };
    let all: Vec<&Mesh<S>> = meshes.iter().map(|(_, mesh)| mesh).collect();
    (meshes.iter().flat_map(side).collect(), facing_sides(&all, REACH).into_iter().map(contact).collect())
}

/// Makes the meshes of the regions that have no cells in common.
fn meshes<S: Dimension>(file: &MeshFile) -> Vec<(String, Mesh<S>)> {
    let names: Vec<&str> = file.group_names(S::DIM as u8).collect();
    let regions: Vec<Vec<&str>> =
        if names.is_empty() { vec![Vec::new()] } else { names.iter().map(|name| vec![*name]).collect() };
    let mut taken: HashSet<u64> = HashSet::new();
    let mut meshes = Vec::new();
    for names in regions {
        let Ok(region) = S::region(file, &names, RegionOptions::default()) else { continue };
        let Ok(mesh) = region.mesh() else { continue };
        if region.cell_numbers().iter().any(|number| taken.contains(number)) {
            continue;
        }
        taken.extend(region.cell_numbers());
        meshes.push((names.concat(), mesh));
    }
    meshes
}

fn side_of<S: Space>(mesh: &Mesh<S>, region: &str, name: &str) -> Option<MeshSide> {
    let facets = mesh.group(name).filter(|facets| !facets.is_empty())?;
    let measure: f64 = facets.iter().map(|facet| mesh.facet_measure(*facet)).sum();
    let weighted: S::Vector =
        facets.iter().map(|facet| mesh.facet_normal(*facet) * mesh.facet_measure(*facet)).sum();
    let normal = (weighted * (1.0 / measure)).entries().to_vec();
    let all =
        MeshSide { region: region.to_owned(), side: name.to_owned(), facets: facets.len(), measure, normal };
    (measure > 0.0 && all.normal.iter().all(|x| x.is_finite()) && measure.is_finite()).then_some(all)
}
