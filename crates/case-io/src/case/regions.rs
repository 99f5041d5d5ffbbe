//! `[[body.region]]`: parts of a body that are of another material.

use super::{BodyCase, Case, Dimension, Material, Part};
use crate::case_file::Reader;
use crate::diagnostic::{CaseError, Diagnostic, code, did_you_mean, excerpt};
use fem_core::material::Materials;
use fem_core::mesh::Mesh;
use fem_core::space::Plane;
use mesh_io::words::listed;
use serde::Serialize;
use std::collections::{HashMap, HashSet};

/// `[[body.region]]`: cells with a material of their own. If regions overlap, the later one counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(bound = "")]
#[non_exhaustive]
pub struct MaterialRegion<S: Dimension = Plane> {
    /// The name of the material.
    pub material: String,
    /// Which cells.
    #[serde(flatten)]
    pub cells: CellSelection<S>,
}

/// Which cells a `[[body.region]]` takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", bound = "")]
#[non_exhaustive]
pub enum CellSelection<S: Dimension = Plane> {
    /// `box`: the cells whose centroid lies in the closed box (with a tolerance of 1e-9 body diagonals).
    Box(Part<S>),
    /// `group`: the cells of a group of the body's mesh file.
    Group(String),
}

/// Reads `[[body.region]]`.
pub(super) fn regions<S: Dimension>(r: &mut Reader<'_>) -> Vec<MaterialRegion<S>> {
    r.tables("region").unwrap_or_default().into_iter().map(|r| region(r)).collect()
}

fn region<S: Dimension>(mut r: Reader<'_>) -> MaterialRegion<S> {
    r.require(&["material"]);
    let material = r.string("material").unwrap_or_default();
    let limits = Part::<S>::written(", ");
    let expected = format!("`box = {{ {limits} }}`, or `group = \"name\"` for a mesh file");
    let expected = expected.as_str();
    match (r.has("box"), r.has("group")) {
        (true, true) => {
            r.refuse("group", "`box` and `group` exclude each other", expected, "take one of them out")
        }
        (false, false) => {
            r.refuse("", "this region takes no cells", expected, "write `box = { x = [0.0, 1.0] }`")
        }
        _ => {}
    }
    let group = r.string("group");
    let part = Part::read(&mut r, "box");
    if r.has("box") && part.is_all() {
        let expected = format!("`{}`", Part::<S>::written("` and/or `"));
        r.refuse("box", "the box has no limits", &expected, "write `box = { x = [0.0, 1.0] }`");
    }
    r.finish();
    let cells = group.map_or(CellSelection::Box(part), CellSelection::Group);
    MaterialRegion { material, cells }
}

/// Checks that every material that bodies and regions name exists, and names the nearest if it does not.
pub(super) fn check_references<S: Dimension>(
    root: &Reader<'_>,
    materials: &[Material<S>],
    bodies: &[BodyCase<S>],
) {
    if materials.is_empty() && !root.has("materials") {
        return;
    }
    let names = || materials.iter().map(|m| m.name.as_str());
    let used = bodies.iter().enumerate().flat_map(|(k, body)| {
        let of_regions =
            body.regions.iter().enumerate().map(move |(j, r)| (format!("body.{k}.region.{j}"), &r.material));
        std::iter::once((format!("body.{k}"), &body.material)).chain(of_regions)
    });
    let all: HashSet<&str> = names().collect();
    for (path, material) in used {
        // An empty name means that it is missing or not a string, which has been reported.
        if material.is_empty() || all.contains(material.as_str()) {
            continue;
        }
        let message = format!("there is no material {}", excerpt(material));
        if root.findings().are_many() {
            let place = root.findings().place(&format!("{path}.material"));
            root.findings().push(Diagnostic::new(code::REFERENCE, place, message));
            continue;
        }
        let known: Vec<String> = names().map(|n| format!("\"{n}\"")).collect();
        let diagnostic =
            Diagnostic::new(code::REFERENCE, root.findings().place(&format!("{path}.material")), message);
        let expected =
            if known.is_empty() { "a table [materials.NAME]".to_owned() } else { known.join(" or ") };
        let fix = format!("write a table [materials.{}]", excerpt(material));
        let diagnostic = diagnostic.expected(expected).help(did_you_mean(material, names(), '"'));
        root.findings().push(diagnostic.fix(fix));
    }
}

impl<S: Dimension> Case<S> {
    /// Lists the materials of a body: its own first, then the materials of its regions, each once.
    pub fn materials_of(&self, body: usize) -> Vec<&Material<S>> {
        let names = self.bodies[body].material_names();
        let by_name: HashMap<&str, &Material<S>> =
            self.materials.iter().map(|m| (m.name.as_str(), m)).collect();
        let mut seen = HashSet::new();
        names
            .filter(|name| seen.insert(*name))
            .filter_map(|name| by_name.get(name.as_str()).copied())
            .collect()
    }

    /// Lists, for each entry of the list of materials that fem-core has of a body, 0 or 1, its place in
    /// [`Case::materials`]: the body's own first, then one entry per region.
    pub fn material_places(&self, body: usize) -> Vec<usize> {
        let names = self.bodies[body].material_names();
        names.filter_map(|name| self.materials.iter().position(|m| m.name == *name)).collect()
    }

    /// Makes the materials of a body's cells.
    pub(super) fn build_materials(&self, body: usize, mesh: &Mesh<S>) -> Result<Materials<S>, CaseError> {
        let given = &self.bodies[body];
        let mut list = Vec::with_capacity(1 + given.regions.len());
        for name in given.material_names() {
            let Some(material) = self.materials.iter().find(|m| m.name == *name) else {
                let path = format!("body.{body}.material");
                let message = format!("there is no material \"{name}\"");
                let fault = self.diagnostic(code::REFERENCE, &path, message).expected("one of [materials]");
                return Err(fault.fix("write a table of this name under [materials]").into());
            };
            let elastic = material.elastic(&self.model);
            list.push(elastic.map_err(|error| CaseError::from(self.material_diagnostic(name, &error)))?);
        }
        if given.regions.is_empty() {
            return Ok(Materials::by_cell(list, Vec::new()));
        }
        let mut of_triangle = vec![0; mesh.cells().len()];
        let mut faults = Vec::new();
        for (k, region) in given.regions.iter().enumerate() {
            let cells = match &region.cells {
                CellSelection::Box(part) => Ok(cells_in(mesh, *part)),
                CellSelection::Group(group) => self.cells_of_group(body, k, group),
            };
            match cells {
                Ok(cells) if cells.is_empty() => {
                    let path = format!("body.{body}.region.{k}.box");
                    let message = format!("body \"{}\": no cell lies in this region", given.name);
                    let expected = "a box that holds the centroid of a cell";
                    let fault = self.diagnostic(code::MESH, &path, message).expected(expected);
                    faults.push(fault.fix("make the box larger or the mesh finer"));
                }
                Ok(cells) => cells.into_iter().for_each(|t| of_triangle[t] = k as u32 + 1),
                Err(fault) => faults.push(*fault),
            }
        }
        if faults.is_empty() {
            Ok(Materials::by_cell(list, of_triangle))
        } else {
            Err(CaseError::new(faults))
        }
    }

    /// Finds the cells of a body that belong to a group of its mesh file.
    fn cells_of_group(&self, body: usize, k: usize, group: &str) -> Result<Vec<usize>, Box<Diagnostic>> {
        let path = format!("body.{body}.region.{k}.group");
        let name = &self.bodies[body].name;
        let fault = |message: String| self.diagnostic(code::MESH, &path, message);
        let Some(region) = self.mesh_region(body) else {
            let message = format!("body \"{name}\" has no mesh file, and so no groups of cells");
            let fault = fault(message).expected(format!("`box = {{ {} }}`", Part::<S>::written(", ")));
            return Err(Box::new(fault.fix("write `box` instead of `group`")));
        };
        let Some(numbers) = self.group_of_cells(body, group) else {
            let message =
                format!("the mesh file of body \"{name}\" has no group of cells {}", excerpt(group));
            let known: Vec<&str> = region.cell_group_names().collect();
            let listed =
                if known.is_empty() { "a file with groups of cells".to_owned() } else { listed(&known) };
            let help = did_you_mean(group, known.into_iter().take(10_000), '"');
            let fault = fault(message).expected(listed).help(help);
            return Err(Box::new(fault.fix("look at the groups with `nndd mesh FILE`")));
        };
        let is_inside = |t: &usize| numbers.binary_search(&region.cell_numbers()[*t]).is_ok();
        let cells: Vec<usize> = (0..region.cells().len()).filter(is_inside).collect();
        if cells.is_empty() {
            let message = format!("no cell of body \"{name}\" belongs to the group {}", excerpt(group));
            let fault = fault(message).expected("a group that shares cells with the body's region");
            return Err(Box::new(fault.fix("take this [[body.region]] out, or name another group")));
        }
        Ok(cells)
    }
}

/// Finds the cells whose centroids lie in a box.
pub(super) fn cells_in<S: Dimension>(mesh: &Mesh<S>, part: Part<S>) -> Vec<usize> {
    let inside = part.contains(mesh);
    let corners = (S::DIM + 1) as f64;
    let centroid = |t: usize| mesh.corners(t).into_iter().sum::<S::Vector>() / corners;
    (0..mesh.cells().len()).filter(|t| inside(centroid(*t))).collect()
}
