//! Data that a program gives a case in memory: meshes instead of files, and data at nodes instead of numbers.

use super::build::generator_fault;
use super::dimension::Keys;
use super::{Case, Dimension, Friction, Rest, Value, read_body};
use crate::case_file::{At, Findings, NodeValue, Reader, Table};
use crate::diagnostic::{CaseError, code};
use crate::expression::{AtNodes, Given, NodalData};
use fem_core::geometry::Vector;
use fem_core::mesh::id::NodeId;
use fem_core::mesh::{Mesh, TetMesh, TriMesh};
use fem_core::space::{Plane, Solid};
use mesh_io::MeshFile;
use std::collections::BTreeMap;

/// Makes the plane mesh of a generator alone.
///
/// * `keys`: those of `generator = { … }` of a body.
///
/// # Errors
/// Everything that is wrong with the keys, and a mesh that cannot be made.
pub fn mesh_of_generator(keys: &Table) -> Result<TriMesh, CaseError> {
    generated::<Plane>(keys)
}

/// Makes the mesh of tetrahedra of a generator alone, see [`mesh_of_generator`].
///
/// # Errors
/// Everything that is wrong with the keys, and a mesh that cannot be made.
pub fn solid_mesh_of_generator(keys: &Table) -> Result<TetMesh, CaseError> {
    generated::<Solid>(keys)
}

/// Tells whether a generator makes a mesh of tetrahedra.
pub fn is_solid_generator(keys: &Table) -> bool {
    let kind = keys.get("kind").map(|entry| &entry.node.value);
    Solid::GENERATORS.iter().any(|(word, _)| matches!(kind, Some(NodeValue::String(kind)) if kind == word))
}

fn generated<S: Keys>(keys: &Table) -> Result<Mesh<S>, CaseError> {
    let (findings, at) = (Findings::new(S::COORDINATES), At::of_key("generator", ""));
    let source = read_body::generator::<S>(Reader::new(&findings, keys, "generator".to_owned(), &at));
    let (faults, omitted, _) = findings.into_parts();
    match source.as_ref().filter(|_| faults.is_empty()).map(S::generated) {
        Some(made) => {
            made.map_err(|error| generator_fault(Some(at.place()), error.to_string(), &error).into())
        }
        None => Err(CaseError::new(faults).and_more(omitted)),
    }
}

impl<S: Dimension> Case<S> {
    /// Gives a mesh to the bodies whose `mesh.file` is `name`. [`Case::read_mesh_files`] then reads no file for them.
    pub(crate) fn give_mesh(&mut self, name: &str, mesh: MeshFile) {
        self.meshes.give(name, mesh);
    }

    /// Lists the data that a program may give, each with its body and its side.
    fn data_mut(&mut self) -> impl Iterator<Item = (usize, String, &mut Value)> {
        let of_bodies = self.bodies.iter_mut().enumerate().flat_map(|(b, body)| {
            let imposed =
                body.displacements.iter_mut().map(|given| (&given.on, given.imposition.values_mut()));
            let loads = body.tractions.iter_mut().map(|given| (&given.on, given.load.values_mut()));
            let springs = body.springs.iter_mut();
            let springs = springs.map(|given| {
                let values = [&mut given.stiffness]
                    .into_iter()
                    .chain(given.rest.iter_mut().flat_map(Rest::values_mut));
                (&given.on, values.collect())
            });
            let of_side = move |(on, values): (&String, Vec<_>)| {
                let on = on.clone();
                values.into_iter().map(move |value| (b, on.clone(), value))
            };
            imposed.chain(loads).chain(springs).flat_map(of_side)
        });
        let of_contacts = self.contacts.iter_mut().flat_map(|contact| {
            let first = contact.bodies.first().copied().zip(contact.surfaces.first().cloned());
            let limit = match &mut contact.friction {
                Some(Friction::Tresca { limit }) => Some(limit),
                _ => None,
            };
            let both = [Some(&mut contact.gap), limit].into_iter().flatten();
            both.filter_map(move |value| first.clone().map(|(body, side)| (body, side, value)))
        });
        of_bodies.chain(of_contacts)
    }

    /// Refuses values at nodes, which are read in the plane only.
    ///
    /// # Errors
    /// The first of them.
    pub(super) fn refuse_given(&mut self) -> Result<(), CaseError> {
        let given = self.data_mut().find_map(|(_, _, value)| match value {
            Value::Given(given) => Some(given.key.clone()),
            _ => None,
        });
        let Some(key) = given else { return Ok(()) };
        let fault = self.diagnostic(
            code::VALUE,
            &key,
            format!("`{key}`: values at the nodes of solids are not read"),
        );
        let fault = fault.expected("a number, or an expression in x, y and z");
        Err(fault.fix("write it as a text, such as \"1.0 - x*z\"").into())
    }

    /// Returns the numbers that the mesh file of a body gives to its nodes, in the order of its mesh; `None` for a generated mesh.
    pub fn node_numbers(&self, body: usize) -> Option<&[u64]> {
        self.mesh_region(body).map(|region| region.node_numbers())
    }

    /// Counts the nodes for which a program gives data: those of a mesh in memory, nodes without cells included, or of a
    /// generated mesh; `None` for a mesh that was read from a file.
    pub fn given_node_count(&self, body: usize) -> Option<u64> {
        match self.mesh_region(body) {
            Some(_) => self.meshes.given_nodes(body),
            None => self.node_counts().get(body).copied(),
        }
    }

    /// Makes the mesh of a body as the case describes it.
    ///
    /// # Errors
    /// A mesh that cannot be generated, or a file that was not read or holds no sound mesh.
    pub fn mesh_of(&self, body: usize) -> Result<Mesh<S>, CaseError> {
        self.build_mesh(body)
    }
}

impl Case {
    /// Puts data along sides where a program gave data at nodes, which are linear along the edges.
    pub(super) fn evaluate_plane_given(&mut self) -> Result<(), CaseError> {
        let given = |(body, side, value): (usize, String, &mut Value)| match value {
            Value::Given(given) => Some((body, side, given.clone())),
            _ => None,
        };
        let given: Vec<(usize, String, Given)> = self.data_mut().filter_map(given).collect();
        let made = given.iter().map(|(body, side, given)| self.evaluated(*body, side, given));
        let made = made.collect::<Result<Vec<_>, _>>()?;
        let values = self.data_mut().map(|(_, _, value)| value);
        let values = values.filter(|value| matches!(value, Value::Given(_)));
        values.zip(made).for_each(|(value, data)| *value = Value::Nodal(data));
        Ok(())
    }

    /// Evaluates data at the nodes of a side. A side that does not exist has none: building the body says so.
    fn evaluated(&self, body: usize, side: &str, given: &Given) -> Result<NodalData, CaseError> {
        let fault = |message: String| self.diagnostic(code::VALUE, &given.key, message);
        if self.bodies[body].sides.iter().any(|other| other.name == side && other.point.is_some()) {
            let fault = fault(format!("`{}` takes no values at nodes", given.key));
            return Err(fault.expected("a number for a single node").fix("write a number there").into());
        }
        let edges = self.edges_of_side(body, side)?;
        let nodes: BTreeMap<usize, Vector> = edges.as_flattened().iter().copied().collect();
        let values = match &given.data {
            _ if nodes.is_empty() => Vec::new(),
            AtNodes::Values(values) => {
                self.check_count(body, values.len(), given)?;
                let number = |node: &usize| self.node_numbers(body).map_or(*node, |n| n[*node] as usize);
                nodes.keys().filter_map(|node| values.get(number(node)).copied()).collect()
            }
            AtNodes::Function(function) => {
                let points: Vec<Vector> = nodes.values().copied().collect();
                let fault = || fault(format!("`{}`: the function gives no values", given.key));
                let expected = "one number for each node of the side";
                let values = function.at(&points);
                values.ok_or_else(|| fault().expected(expected).fix("change the function"))?
            }
        };
        let values: BTreeMap<usize, f64> = nodes.into_keys().zip(values).collect();
        let ends: Vec<[Vector; 2]> = edges.iter().map(|ends| ends.map(|(_, point)| point)).collect();
        let of_ends: Vec<[f64; 2]> = edges
            .iter()
            .map(|ends| ends.map(|(node, _)| values.get(&node).copied().unwrap_or(f64::NAN)))
            .collect();
        Ok(NodalData::new(&ends, &of_ends))
    }

    /// Refuses an array that has not one value for each node of a mesh in memory.
    fn check_count(&self, body: usize, values: usize, given: &Given) -> Result<(), CaseError> {
        let count = self.given_node_count(body);
        if count == Some(values as u64) {
            return Ok(());
        }
        let name = &self.bodies[body].name;
        let (mesh, expected, fix) = match count {
            Some(count) => (
                format!("has {count} nodes"),
                "one value for each node of the body's mesh",
                "give as many values as the mesh has points, or a function f(x, y)",
            ),
            None => (
                "is a file".to_owned(),
                "a mesh in memory",
                "read it with Mesh.read, or give a function f(x, y)",
            ),
        };
        let message = format!("an array of {values} values, and the mesh of body \"{name}\" {mesh}");
        Err(self.diagnostic(code::VALUE, &given.key, message).expected(expected).fix(fix).into())
    }

    /// Returns the edges of a side, each by its two nodes and their points, m.
    fn edges_of_side(&self, body: usize, side: &str) -> Result<Vec<[(usize, Vector); 2]>, CaseError> {
        let selected = self.bodies[body].sides.iter().any(|other| other.name == side);
        if let Some(region) = self.mesh_region(body).filter(|_| !selected) {
            // To make the mesh takes longer, and is done later.
            let edges = region.sides().find(|(name, _)| *name == side).map_or(&[][..], |(_, edges)| edges);
            let end = |node: u32| (node as usize, region.points()[node as usize]);
            return Ok(edges.iter().map(|ends| ends.map(end)).collect());
        }
        let mesh = self.build_mesh(body)?;
        let end = |node: NodeId| (node.index(), mesh.points()[node]);
        let edges = mesh.group(side).unwrap_or_default().iter();
        Ok(edges.map(|edge| mesh.topology().facets()[*edge].map(end)).collect())
    }
}
