//! Data that a program gives a case in memory: meshes instead of files, and data at nodes instead of numbers.

use super::{Case, Friction, Imposition, Load, Value};
use crate::diagnostic::{CaseError, code};
use crate::expression::NodalData;
use fem_core::geometry::Vector;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use mesh_io::MeshFile;
use std::collections::BTreeSet;

/// The nodes at which the values of a key apply: the nodes of the side of its condition.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DataNodes {
    /// The body, in the file's order.
    pub body: usize,
    /// The number of each node in the body's mesh file, or its place in a generated mesh.
    pub numbers: Vec<u64>,
    /// Their places, m.
    pub points: Vec<Vector>,
    /// The edges of the side, by places in these lists.
    edges: Vec<[usize; 2]>,
}

impl Case {
    /// Gives a mesh to the bodies whose `mesh.file` is `name`. [`Case::read_mesh_files`] then reads no file for them.
    pub fn give_mesh(&mut self, name: &str, mesh: MeshFile) {
        self.meshes.give(name, mesh);
    }

    /// Returns the numbers that the mesh file of a body gives to its nodes, in the order of its mesh; `None` for a generated mesh.
    pub fn node_numbers(&self, body: usize) -> Option<&[u64]> {
        self.mesh_region(body).map(|region| region.node_numbers())
    }

    /// Makes the mesh of a body as the case describes it.
    ///
    /// # Errors
    /// A mesh that cannot be generated, or a file that was not read or holds no sound mesh.
    pub fn mesh_of(&self, body: usize) -> Result<TriMesh, CaseError> {
        self.build_mesh(body)
    }

    /// Finds the nodes at which the data of a key count. There are no nodes if the side does not exist: building the body says so.
    ///
    /// * `key`: a dotted path, such as `body.0.displacement.1.uy`, `body.0.traction.0.vector.1`, `contact.gap` or
    ///   `contact.0.friction.limit`.
    ///
    /// # Errors
    /// A key without data at nodes, and a mesh that cannot be made.
    pub fn data_nodes(&self, key: &str) -> Result<DataNodes, CaseError> {
        let Some((body, side)) = self.side_of_datum(key) else { return Err(self.no_datum(key)) };
        let selected = self.bodies[body].sides.iter().any(|other| other.name == side);
        match self.mesh_region(body).filter(|_| !selected) {
            // To make the mesh takes longer, and is done later.
            Some(region) => {
                let edges =
                    region.sides().find(|(name, _)| *name == side).map_or(&[][..], |(_, edges)| edges);
                let edges = edges.iter().map(|ends| ends.map(|node| node as usize));
                Ok(self.nodes_of(body, &edges.collect::<Vec<_>>(), region.points()))
            }
            None => {
                let mesh = self.build_mesh(body)?;
                let edges = mesh.group(side).unwrap_or_default().iter();
                let ends = edges.map(|edge| mesh.topology().edges()[*edge].map(NodeId::index));
                Ok(self.nodes_of(body, &ends.collect::<Vec<_>>(), mesh.points()))
            }
        }
    }

    fn nodes_of(&self, body: usize, ends: &[[usize; 2]], points: &[Vector]) -> DataNodes {
        let nodes: BTreeSet<usize> = ends.as_flattened().iter().copied().collect();
        let nodes: Vec<usize> = nodes.into_iter().collect();
        let place = |node: usize| nodes.binary_search(&node).unwrap_or_default();
        let number = |node: &usize| self.node_numbers(body).map_or(*node as u64, |numbers| numbers[*node]);
        DataNodes {
            body,
            numbers: nodes.iter().map(number).collect(),
            points: nodes.iter().map(|node| points[*node]).collect(),
            edges: ends.iter().map(|ends| ends.map(place)).collect(),
        }
    }

    /// Replaces the number of a key by values at nodes, which are linear along the edges of the side.
    ///
    /// * `nodes`: the result of [`Case::data_nodes`]; `values`: one for each node.
    ///
    /// # Errors
    /// A key without data at nodes, and another number of values than of nodes.
    pub fn set_data(&mut self, key: &str, nodes: &DataNodes, values: &[f64]) -> Result<(), CaseError> {
        if values.len() != nodes.points.len() {
            let message = format!("`{key}` has {} values for {} nodes", values.len(), nodes.points.len());
            let fault = self.diagnostic(code::VALUE, key, message).expected("one value for each node");
            return Err(fault.fix("give as many values as the side has nodes").into());
        }
        let ends: Vec<[Vector; 2]> = nodes.edges.iter().map(|ends| ends.map(|n| nodes.points[n])).collect();
        let of_ends: Vec<[f64; 2]> = nodes.edges.iter().map(|ends| ends.map(|n| values[n])).collect();
        match self.datum_mut(key) {
            Some(datum) => *datum = Value::Nodal(NodalData::new(&ends, &of_ends)),
            None => return Err(self.no_datum(key)),
        }
        Ok(())
    }

    fn no_datum(&self, key: &str) -> CaseError {
        let message = format!("`{key}` takes no values at nodes");
        let fault = self.diagnostic(code::VALUE, key, message);
        let fault = fault
            .expected("`ux`, `uy`, `normal`, `vector`, `pressure`, `gap` or `limit` on a side with edges");
        fault.fix("write a number there").into()
    }

    /// Finds body and side of a key.
    fn side_of_datum(&self, key: &str) -> Option<(usize, &str)> {
        if let Some((contact, _)) = self.contact_of_datum(key) {
            let contact = &self.contacts[contact];
            return Some((*contact.bodies.first()?, contact.surfaces.first()?));
        }
        let (body, list, index, _) = split(key)?;
        let given = self.bodies.get(body)?;
        let side = match list {
            "displacement" => &given.displacements.get(index)?.on,
            "traction" => &given.tractions.get(index)?.on,
            _ => return None,
        };
        let is_point = given.sides.iter().any(|other| other.name == *side && other.point.is_some());
        (!is_point).then_some((body, side))
    }

    fn datum_mut(&mut self, key: &str) -> Option<&mut Value> {
        if let Some((contact, rest)) = self.contact_of_datum(key) {
            let contact = &mut self.contacts[contact];
            return match (rest.as_str(), &mut contact.friction) {
                ("gap", _) if !contact.geometric => Some(&mut contact.gap),
                ("friction.limit", Some(Friction::Tresca { limit })) => Some(limit),
                _ => None,
            };
        }
        let (body, list, index, datum) = split(key)?;
        let given = self.bodies.get_mut(body)?;
        if list == "traction" {
            return match (&mut given.tractions.get_mut(index)?.load, datum) {
                (Load::Vector([x, _]), "vector.0") => Some(x),
                (Load::Vector([_, y]), "vector.1") => Some(y),
                (Load::Pressure(value), "pressure") => Some(value),
                _ => None,
            };
        }
        match (&mut given.displacements.get_mut(index)?.imposition, datum) {
            (Imposition::Components([x, _]), "ux") => x.as_mut(),
            (Imposition::Components([_, y]), "uy") => y.as_mut(),
            (Imposition::Normal(value), "normal") => Some(value),
            _ => None,
        }
    }

    /// Finds the pair that a key belongs to, and the rest of the key.
    fn contact_of_datum(&self, key: &str) -> Option<(usize, String)> {
        let rest = |path: &str| key.strip_prefix(path)?.strip_prefix('.').map(str::to_owned);
        self.contacts.iter().enumerate().find_map(|(k, contact)| Some((k, rest(&contact.path)?)))
    }
}

/// Splits `body.0.traction.1.vector.0` into its body, list, place in the list, and rest.
fn split(key: &str) -> Option<(usize, &str, usize, &str)> {
    let mut parts = key.strip_prefix("body.")?.splitn(4, '.');
    Some((parts.next()?.parse().ok()?, parts.next()?, parts.next()?.parse().ok()?, parts.next()?))
}
