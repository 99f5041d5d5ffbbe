//! Stresses of single tetrahedra with given facet moments, for a judge in another language: FIAT's Johnson-Mercier element.

use crate::page::write;
use cre_estimator::EquilibratedStress;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::material::LinearElastic;
use fem_core::mesh::TetMesh;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::{Matrix6, SMatrix, SVector, Vector3};
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;
use tests::random::Random;

/// Tetrahedra of the whole study, and of a quick one.
const CELLS: [u64; 2] = [12, 4];
/// Moments in equilibrium without a body force have this dimension: a cell gets this many of them, and as many with a force.
const FIELDS: usize = 30;
/// Moments of a cell.
const MOMENTS: usize = 36;

/// Writes `cells.json`: tetrahedra, materials, moments in equilibrium, and the stresses and energies of this program.
pub(crate) fn cells(folder: &Path, quick: bool) -> Result<(), Box<dyn Error>> {
    let cells = (0..CELLS[usize::from(quick)]).map(cell).collect::<Result<Vec<Value>, _>>()?;
    write(folder, "cells.json", &serde_json::to_string(&cells)?)
}

/// Draws a tetrahedron, of which every fourth is flat.
fn corners(random: &mut Random, number: u64) -> [[f64; 3]; 4] {
    let height = if number % 4 == 3 { 0.05 } else { 1.0 };
    let reference = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 1.0]];
    let size = 10f64.powf(2.0 * random.signed());
    let mut moved = || 0.2 * random.signed();
    let mut corners = reference
        .map(|[x, y, z]| [size * (x + moved()), size * (y + moved()), size * height * (z + moved())]);
    // A turned cell has corners that do not ascend.
    corners.rotate_left(number as usize / 4 % 4);
    corners
}

/// Draws a stiffness: isotropic, or of 21 constants for every second cell.
fn stiffness(random: &mut Random, number: u64) -> Result<[[f64; 6]; 6], Box<dyn Error>> {
    let young = 10f64.powf(3.0 * random.signed());
    let isotropic = LinearElastic::<Solid>::isotropic_solid(young, 0.49 * random.unit())?;
    let mut entries = *isotropic.stiffness();
    if number % 2 == 1 {
        let change = Matrix6::from_fn(|_, _| 0.3 * random.signed());
        entries += change * change.transpose() * young;
    }
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (entries[(i, j)] + entries[(j, i)]))))
}

/// Draws moments on the faces of the only cell of a body that are in equilibrium with its body force, in the order of the mesh.
fn balanced(random: &mut Random, body: &Body<Solid>) -> Vec<[Vector3<f64>; 3]> {
    let mesh = body.mesh();
    let faces = mesh.topology().facets();
    let middle = mesh.corners(0).iter().sum::<Vector3<f64>>() / 4.0;
    let places = faces.iter().flatten().map(|node| (mesh.points()[*node] - middle) / mesh.diagonal());
    // Force and torque about the barycentre.
    let mut resultant = SMatrix::<f64, 6, MOMENTS>::zeros();
    for (k, lever) in places.enumerate() {
        for (axis, unit) in Solid::AXES.iter().enumerate() {
            let torque = lever.cross(unit);
            resultant.fixed_view_mut::<3, 1>(0, 3 * k + axis).copy_from(unit);
            resultant.fixed_view_mut::<3, 1>(3, 3 * k + axis).copy_from(&torque);
        }
    }
    let mut moments = SVector::<f64, MOMENTS>::from_fn(|_, _| random.signed());
    let mut missing = resultant * moments;
    for axis in 0..3 {
        missing[axis] += body.force(0).mean[axis] * mesh.measure(0);
    }
    let inverse = (resultant * resultant.transpose()).try_inverse().unwrap_or_default();
    moments -= resultant.transpose() * (inverse * missing);
    (0..4)
        .map(|face| [0, 1, 2].map(|j| Vector3::from_fn(|axis, _| moments[9 * face + 3 * j + axis])))
        .collect()
}

/// Makes one cell with its fields.
fn cell(number: u64) -> Result<Value, Box<dyn Error>> {
    let mut random = Random::new(number);
    let corners = corners(&mut random, number);
    let stiffness = stiffness(&mut random, number)?;
    let material = LinearElastic::from_solid_stiffness(stiffness)?;
    let volume = TetMesh::new(corners.to_vec(), vec![[0u32, 1, 2, 3]], vec![])?.measure(0);
    let mut fields = Vec::new();
    let mut nodes = ([[0; 3]; 4], Vec::new());
    for k in 0..2 * FIELDS {
        // Of the size of the resultants of the moments.
        let force = if k < FIELDS { [0.0; 3] } else { [0; 3].map(|_| random.signed() / volume) };
        let conditions = BoundaryConditions::<Solid>::default().body_force(force);
        let mesh = TetMesh::new(corners.to_vec(), vec![[0u32, 1, 2, 3]], vec![])?;
        let body = Body::new(mesh, material.clone(), &conditions)?;
        let stress = EquilibratedStress::<Solid> {
            facet_moments: balanced(&mut random, &body),
            conditions: body.facet_conditions().to_vec(),
            finite_element: vec![SymTensor3::default()],
        };
        let cell = body.mesh().cells()[0];
        nodes.0 = std::array::from_fn(|part| Solid::facet(part).map(|corner| cell[corner].index()));
        nodes.1 = body.mesh().topology().facets().iter().map(|face| face.map(|n| n.index())).collect();
        let moments: Vec<[[f64; 3]; 3]> =
            stress.facet_moments.iter().map(|face| face.map(Into::into)).collect();
        let parts = stress.cell(&body, 0).map(|part| part.map(<[f64; 6]>::from));
        let energy = stress.distance_squared(&body);
        fields.push(json!({ "force": force, "moments": moments, "stress": parts, "energy": energy }));
    }
    Ok(
        json!({ "corners": corners, "stiffness": stiffness, "parts": nodes.0, "faces": nodes.1, "fields": fields }),
    )
}
