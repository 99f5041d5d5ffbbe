mod closed_forms;
mod random;

use super::*;
use fem_core::body::tractions;
use fem_core::boundary::{BoundaryConditions, SpringDirection};
use fem_core::geometry::Vector;
use fem_core::linear_field::LinearField;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, cuboid};
use fem_core::mesh::{Mesh, TriMesh};
use fem_core::space::{Plane, Solid};
use nalgebra::Vector3;

/// A quadratic tensor at a point of its part, by barycentric coordinates.
fn at<S: Space>(of: &Quadratic<S>, point: &[f64]) -> S::Tensor {
    let linear = (0..=S::DIM).fold(S::Tensor::default(), |t, v| sum::<S>(t, point[v], of.at[v]));
    let bows = pairs(S::DIM + 1).zip(of.bow);
    bows.fold(linear, |t, ((i, j), bow)| sum::<S>(t, 4.0 * point[i] * point[j], bow))
}

/// The stress of the bubble of one edge of the regular cell.
fn of_bubble<S: Space>(bubble: usize, axis: usize) -> S::Corners<Quadratic<S>> {
    let none =
        Quadratic { at: S::corners(|_| S::Tensor::default()), bow: S::components(|_| S::Tensor::default()) };
    let mut bubbles = vec![S::Vector::ZERO; (S::DIM + 1) * pairs(S::DIM).count()];
    bubbles[bubble] = S::AXES[axis];
    let mut parts = S::corners(|_| none);
    Bubbles::get::<S>().add::<S>(&regular::<S>(), &bubbles, &mut parts);
    parts
}

#[test]
fn the_stress_of_a_bubble_has_the_published_energy() {
    // On the edge from (0, 0) to (1, 0) the traction (1, 0) or (0, −1) times 6 s² − 6 s + 1, which is −3/2 of the function here.
    for (axis, factor, energy, middle) in [
        (0, -1.5, 0.12830005982, [0.0, 0.0, -1.0 / 9.0]),
        (1, 1.5, 0.177481749418, [5.0 / 18.0, -7.0 / 18.0, 0.0]),
    ] {
        let parts = of_bubble::<Plane>(0, axis);
        let mass = mass::<Plane>();
        let values =
            parts.iter().flat_map(|part| part.at.iter().chain(&part.bow).map(|t| <[f64; 3]>::from(*t)));
        let values = nalgebra::DVector::from_vec(values.flatten().collect());
        let third = 3f64.sqrt() / 12.0;
        let found = factor * factor * third * values.dot(&(&mass * &values));
        assert!((found / energy - 1.0).abs() < 1e-10, "{found}");
        let centre: [f64; 3] = parts[0].at[2].into();
        for (found, expected) in centre.into_iter().zip(middle) {
            assert!((factor * found - expected).abs() < 1e-12, "{centre:?}");
        }
    }
}

#[test]
fn all_equations_of_the_regular_cells_hold() {
    fn check<S: Space>(rank: usize, rows: usize) {
        let mut equations = Equations::<S> { corners: regular::<S>(), rows: Vec::new(), right: Vec::new() };
        equations.outer();
        equations.inner();
        equations.divergence();
        assert_eq!(equations.rows.len(), rows);
        let a = DMatrix::from_fn(rows, equations.rows[0].len(), |i, j| equations.rows[i][j]);
        let columns = &Bubbles::get::<S>().columns;
        for (k, column) in columns.iter().enumerate() {
            let found = &a * nalgebra::DVector::from_column_slice(column);
            let off = found.iter().zip(&equations.right).map(|(found, right)| (found - right[k]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12);
        }
        let singular = a.singular_values();
        assert_eq!(singular.iter().filter(|s| **s > RANK * singular.max()).count(), rank);
    }
    check::<Plane>(51, 54);
    check::<Solid>(222, 228);
}

/// Checks `τ` under a linear body force point by point: equilibrium in the parts, tractions in the middle of edges of facets from both sides, and given
/// ones.
///
/// * `cell`: the linear part of the stress of a cell; `force`: b.
fn check<S: crate::recovery::Recovery>(
    body: &Body<S>,
    cell: impl Fn(&crate::EquilibratedStress<S>, usize) -> S::Corners<S::Corners<S::Tensor>>,
    force: impl Fn(S::Vector) -> S::Vector,
) {
    let mesh = body.mesh();
    let cells = mesh.cells().len();
    let conditions = body.facet_conditions().to_vec();
    // In FE equilibrium with the forces.
    let dofs = fem_core::dof::DofMap::new(body, &fem_core::interface::InterfaceSide::default());
    let system = fem_core::assembly::System::with_dofs(body, dofs).unwrap();
    let condensed = fem_core::condensation::CondensedBody::factorise(system, mesh.points()).unwrap();
    let u = condensed.displacement_from_force(&[]);
    let conditions = crate::springs::released(body, conditions, &[&u]);
    let stress =
        crate::EquilibratedStress::<S>::recover(body, fem_core::field::stresses(body, &u), conditions);
    assert!(
        crate::check::check_stress(body, &stress).is_valid(),
        "{:?}",
        crate::check::check_stress(body, &stress)
    );
    let loads = |t: usize| {
        let found = cell(&stress, t);
        let quadratic = quadratic(body, t, &stress.conditions);
        (found, quadratic)
    };
    let mut largest: f64 = 0.0;
    let mut worst: f64 = 0.0;
    for t in 0..cells {
        let (linear, quadratic) = loads(t);
        let arms = arms::<S>(&mesh.corners(t));
        let centre = mesh.corners(t)[0] - arms[0];
        let tau = |part: usize, point: &[f64]| -> S::Tensor {
            let of_linear =
                (0..=S::DIM).fold(S::Tensor::default(), |t, v| sum::<S>(t, point[v], linear[part][v]));
            quadratic
                .as_ref()
                .map_or(of_linear, |parts| sum::<S>(of_linear, 1.0, at::<S>(&parts[part], point)))
        };
        for part in 0..=S::DIM {
            let corners = S::facet(part);
            let places = S::corners(|v| if v < S::DIM { arms[corners[v]] } else { S::Vector::ZERO });
            let gradients = Element::<S>::new(places).gradients;
            // The divergence by differences of a quadratic function, exact.
            let (point, step) = (vec![1.0 / (S::DIM + 1) as f64; S::DIM + 1], 1e-3);
            let mut total =
                force(centre + places.into_iter().zip(&point).map(|(x, w)| x * *w).sum::<S::Vector>());
            for w in 1..=S::DIM {
                let moved = |by: f64| {
                    let mut point = point.clone();
                    (point[0], point[w]) = (point[0] - by, point[w] + by);
                    tau(part, &point)
                };
                total += S::applied(sum::<S>(moved(step), -1.0, moved(-step)), gradients[w]) * (0.5 / step);
            }
            worst = worst.max(total.length() * mesh.measure(t).powf(1.0 / S::DIM as f64));
            let topology = mesh.topology();
            let facet = topology.cell_facets()[t][part];
            let normal = normal(body, t, part);
            let normal = normal / normal.length();
            for (i, j) in pairs(S::DIM) {
                let mut point = vec![0.0; S::DIM + 1];
                (point[i], point[j]) = (0.5, 0.5);
                let traction = S::applied(tau(part, &point), normal);
                largest = largest.max(traction.length());
                if topology.is_boundary(facet) {
                    let condition = stress.conditions[topology.boundary_place(facet)];
                    let nodes = topology.facets()[facet];
                    let node = |corner: usize| {
                        let node = mesh.cells()[t][corners[corner]];
                        nodes.as_ref().iter().position(|n| *n == node).unwrap()
                    };
                    let given = (condition.traction[node(i)] + condition.traction[node(j)]) * 0.5;
                    worst = worst.max(condition.reaction.complement().components(traction - given).length());
                    // That of springs is linear, whatever it is.
                    let own = tractions::<S>(&stress.facet_moments[facet.index()], mesh.facet_measure(facet));
                    let between = (own[node(i)] + own[node(j)]) * 0.5;
                    worst =
                        worst.max(condition.given_or_on_springs().components(traction - between).length());
                    continue;
                }
                let other =
                    topology.facet_cells()[facet].into_iter().find(|other| *other as usize != t).unwrap()
                        as usize;
                let (linear, quadratic) = loads(other);
                let part = topology.facet_in(other, facet);
                let own = S::facet(part);
                let mut point = vec![0.0; S::DIM + 1];
                for corner in [i, j] {
                    let node = mesh.cells()[t][corners[corner]];
                    let place = own.as_ref().iter().position(|k| mesh.cells()[other][*k] == node).unwrap();
                    point[place] = 0.5;
                }
                let of_linear =
                    (0..=S::DIM).fold(S::Tensor::default(), |t, v| sum::<S>(t, point[v], linear[part][v]));
                let beyond =
                    quadratic.as_ref().map_or(S::Tensor::default(), |parts| at::<S>(&parts[part], &point));
                worst = worst.max((S::applied(sum::<S>(of_linear, 1.0, beyond), normal) - traction).length());
            }
        }
    }
    assert!(worst < 1e-9 * largest, "{worst:e} {largest:e}");
    // Without the stress that removes bubbles the given tractions are missed.
    assert!(largest > 0.0);
}

/// A block whose sides are turned, so that no edge is along an axis.
fn turned() -> TriMesh {
    let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 3]).unwrap();
    let (sin, cos) = 0.35f64.sin_cos();
    let turn = |x: &Vector| Vector::new(cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]);
    let groups = mesh.groups().iter().map(|(name, edges)| {
        (name.clone(), edges.iter().map(|e| mesh.topology().facets()[*e]).collect::<Vec<_>>())
    });
    let groups: Vec<_> = groups.collect();
    Mesh::new(mesh.points().iter().map(turn).collect(), mesh.cells().to_vec(), groups).unwrap()
}

#[test]
fn tractions_agree_in_the_middle_of_edges() {
    let material =
        LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap().with_density(2.0).unwrap();
    let field = LinearField {
        point: Vector::new(0.3, -0.2),
        value: Vector::new(1.0, -10.0),
        gradient: [Vector::new(20.0, -8.0), Vector::new(5.0, 12.0)],
    };
    let mut conditions = BoundaryConditions::new().fix("left").roller("bottom", 0.0).pressure("top", 3.0);
    conditions = conditions.spring("right", 500.0, SpringDirection::All);
    conditions.per_mass = Some(field);
    let body = Body::new(turned(), material.clone(), &conditions).unwrap();
    check::<Plane>(&body, |stress, t| stress.cell(&body, t), |x| field.at(x) * 2.0);
    // Interpolated in each triangle: bubbles are removed everywhere.
    let mut conditions = BoundaryConditions::new().fix("left");
    let data = |c: usize| {
        fem_core::boundary::ScalarData::function(move |x| if c == 0 { x[0] * x[1] } else { x[1] * x[1] })
    };
    conditions.force_field = Some([data(0), data(1)]);
    let body = Body::new(turned(), material, &conditions).unwrap();
    assert_ne!(body.force(0).gradient, body.force(5).gradient);
    let tree = fem_core::mesh::cell_tree::CellTree::new(body.mesh());
    check::<Plane>(
        &body,
        |stress, t| stress.cell(&body, t),
        |x| {
            let cell = tree.nearest(x).unwrap().cell;
            let corners = body.mesh().corners(cell);
            body.force(cell).at(x - corners[0] + arms::<Plane>(&corners)[0])
        },
    );
}

#[test]
fn tractions_of_solids_agree_in_the_middle_of_edges() {
    let material = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap().with_density(2.0).unwrap();
    let field = LinearField {
        point: Vector3::new(0.3, -0.2, 0.1),
        value: Vector3::new(1.0, -10.0, 2.0),
        gradient: [Vector3::new(20.0, -8.0, 3.0), Vector3::new(5.0, 12.0, -7.0), Vector3::new(1.0, 4.0, 9.0)],
    };
    let mut conditions = BoundaryConditions::<Solid>::default().fix("bottom").pressure("top", 3.0);
    conditions = conditions.spring("right", 500.0, SpringDirection::Normal);
    conditions.per_mass = Some(field);
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [3, 2, 2]).unwrap();
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    let groups = mesh.groups().iter().map(|(name, faces)| {
        (name.clone(), faces.iter().map(|f| mesh.topology().facets()[*f]).collect::<Vec<_>>())
    });
    let groups: Vec<_> = groups.collect();
    let mesh =
        Mesh::new(mesh.points().iter().map(|x| turn * x).collect(), mesh.cells().to_vec(), groups).unwrap();
    let body = Body::new(mesh, material, &conditions).unwrap();
    check::<Solid>(&body, |stress, t| stress.cell(&body, t), |x| field.at(x) * 2.0);
}
