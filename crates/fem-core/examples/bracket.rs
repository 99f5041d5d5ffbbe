//! An L-shaped bracket on its own mesh, held at the wall and loaded at its end: displacement, stress, energy.
//!
//! ```text
//!   ▒▒▒▒ y = 100, fixed
//!   │  │
//!   │  │           Steel, E = 210 000, ν = 0.3, plane stress, legs 20 wide. Units: mm, N, MPa, per mm of thickness.
//!   │  └───────┐
//!   └──────────┘ ↓ 50 N over x = 100, 0 ≤ y ≤ 20
//! ```
//! The stress in the inner corner is singular: its largest value grows with the mesh, the energy converges.
#![allow(clippy::print_stdout)]

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::condensation::CondensedBody;
use fem_core::geometry::Vector;
use fem_core::interface::InterfaceSide;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::{MeshError, TriMesh};
use fem_core::{assembly::System, field, norm};
use std::collections::BTreeMap;
use std::error::Error;

const WIDTH: f64 = 20.0;
const LENGTH: f64 = 100.0;
const FORCE: f64 = 50.0;

/// The response of the bracket to its load.
struct Answer {
    /// Vertical displacement of the loaded corner (100, 0), mm.
    tip: f64,
    /// Largest von Mises stress of the triangles, MPa.
    von_mises: f64,
    /// `a(u, u)`, N mm per mm.
    energy: f64,
    /// Work of the load, `f·u`, N mm per mm.
    work: f64,
    /// Force on the wall, N per mm.
    reaction: Vector,
}

/// Meshes the bracket with squares of `WIDTH / n`, each cut into two triangles.
fn mesh(n: usize) -> Result<TriMesh, MeshError> {
    let (long, h) = ((LENGTH / WIDTH) as usize * n, WIDTH / n as f64);
    let mut numbers = BTreeMap::new();
    let mut points = vec![];
    let mut node = |i: usize, j: usize| {
        *numbers.entry((i, j)).or_insert_with(|| {
            points.push([i as f64 * h, j as f64 * h]);
            points.len() as u32 - 1
        })
    };
    let (mut triangles, mut wall, mut end) = (vec![], vec![], vec![]);
    for (i, j) in (0..long).flat_map(|i| (0..long).map(move |j| (i, j))).filter(|(i, j)| *i < n || *j < n) {
        let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
        if j + 1 == long {
            wall.push([c, d]);
        }
        if i + 1 == long {
            end.push([b, c]);
        }
    }
    TriMesh::new(points, triangles, vec![("wall".to_owned(), wall), ("end".to_owned(), end)])
}

fn solve(n: usize) -> Result<Answer, Box<dyn Error>> {
    let steel = LinearElastic::isotropic(210_000.0, 0.3, Hypothesis::PlaneStress)?;
    let conditions =
        BoundaryConditions::new().fix("wall").traction("end", [0.0.into(), (-FORCE / WIDTH).into()]);
    let body = Body::new(mesh(n)?, steel, &conditions)?;
    // One body alone: no interface.
    let system = System::assemble(&body, &InterfaceSide::default())?;
    let solver = CondensedBody::factorise(system, body.mesh().points())?;
    let u = solver.displacement_from_force(&[]);

    let stresses = field::stresses(&body, &u);
    let von_mises = stresses.iter().enumerate().filter_map(|(t, s)| body.material(t).von_mises(*s, 0.0));
    let points = body.mesh().points();
    let corner = points.iter().position(|p| p[0] == LENGTH && p[1] == 0.0).ok_or("no loaded corner")?;
    let sum = |forces: &[Vector], at: &dyn Fn(&Vector) -> bool| {
        let chosen = forces.iter().zip(points).filter(|(_, p)| at(p));
        chosen.map(|(f, _)| f).sum::<Vector>()
    };
    let load = fem_core::assembly::external_forces(&body);
    Ok(Answer {
        tip: u[corner][1],
        von_mises: von_mises.fold(0.0, f64::max),
        energy: norm::energy_norm_squared(&body, &u),
        work: load.iter().zip(&u).map(|(f, u)| f.dot(u)).sum(),
        reaction: sum(&field::nodal_residual(&body, &u), &|p| p[1] == LENGTH),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cells   tip uy [mm]  von Mises [MPa]  energy a(u,u)    work f·u   wall force [N/mm]");
    for n in [2, 4, 8, 16] {
        let a = solve(n)?;
        let (tip, stress, wall) = (a.tip, a.von_mises, a.reaction[1]);
        println!("{n:5}  {tip:12.6}  {stress:15.1}  {:13.6}  {:10.6}   {wall:.6}", a.energy, a.work);
    }
    Ok(())
}

#[test]
fn forces_balance_and_energies_rise_to_their_limit() {
    let answers: Vec<Answer> = [2, 4, 8, 16].map(|n| solve(n).unwrap()).into();
    for a in &answers {
        assert!(a.reaction[0].abs() < 1e-6 && (a.reaction[1] - FORCE).abs() < 1e-6, "{:?}", a.reaction);
        // Clapeyron: the supports do no work.
        assert!((a.energy / a.work - 1.0).abs() < 1e-8);
    }
    let steps: Vec<f64> = answers.windows(2).map(|a| a[1].energy - a[0].energy).collect();
    assert!(steps.windows(2).all(|s| s[1] > 0.0 && s[1] < 0.5 * s[0]), "energies {steps:?}");
    // Beams: the horizontal leg bends as a cantilever on the rotating end of the vertical one.
    let (arm, ei) = (LENGTH - 0.5 * WIDTH, 210_000.0 * WIDTH.powi(3) / 12.0);
    let beams = FORCE * arm * arm * (arm / 3.0 + arm) / ei;
    let tip = answers[3].tip;
    assert!((-tip / beams - 1.0).abs() < 0.1, "tip {tip}, beams {beams}");
    // The corner's stress grows with the mesh.
    assert!(answers.windows(2).all(|a| a[1].von_mises > a[0].von_mises));
}
