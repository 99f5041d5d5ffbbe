use super::super::energy::Batch;
use super::*;
use fem_core::material::LinearElastic;

const CORNERS: [[f64; 3]; 4] = [[0.1, 0.2, -0.3], [1.3, 0.1, 0.2], [0.4, 0.9, 0.1], [0.2, 0.3, 1.1]];

fn corners() -> [Vector3<f64>; 4] {
    CORNERS.map(Vector3::from)
}

/// Moments in equilibrium: of bars along the edges of every face, and of a constant stress.
fn balanced() -> CellMoments {
    let corners = corners();
    let constant = SymTensor3 { xx: 0.3, yy: -0.2, zz: 0.7, yz: 0.4, xz: -0.1, xy: 0.5 };
    let mut moments = moments_of(&corners, &[constant; 4]);
    for (face, moments) in moments.iter_mut().enumerate() {
        let nodes = Solid::facet(face);
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let bar = (corners[nodes[b]] - corners[nodes[a]]) * (0.3 + 0.2 * (face + k) as f64);
            moments[a] += bar;
            moments[b] -= bar;
        }
    }
    moments
}

#[test]
fn the_equations_determine_the_stress() {
    let equations = Equations::new();
    assert_eq!(equations.rows.len(), MOMENTS + 66);
    let matrix = DMatrix::from_fn(equations.rows.len(), STRESSES, |i, j| equations.rows[i][j]);
    assert_eq!(matrix.rank(1e-10), STRESSES);
}

#[test]
fn a_stress_has_its_moments_and_is_free_of_sources() {
    let (corners, moments) = (corners(), balanced());
    let stress = CellMap::new(corners).stress(&moments);
    let middle = corners.iter().sum::<Vector3<f64>>() / 4.0;
    for part in 0..4 {
        let nodes = Solid::facet(part);
        let [a, b, c] = nodes.map(|k| corners[k]);
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let tractions: [Vector3<f64>; 3] = std::array::from_fn(|v| Solid::applied(stress[part][v], normal));
        let sum: Vector3<f64> = tractions.iter().sum();
        for (j, t) in tractions.iter().enumerate() {
            assert!(((sum + t) / 12.0 - moments[part][j]).norm() < 1e-13);
        }
        let gradients = Solid::gradients(&[a, b, c, middle], Solid::measure(&[a, b, c, middle]).abs());
        let divergence: Vector3<f64> = (0..4).map(|v| Solid::applied(stress[part][v], gradients[v])).sum();
        assert!(divergence.norm() < 1e-11, "{divergence}");
        // Across the face to another part, from both sides.
        for other in 0..4 {
            for (i, node) in nodes.iter().enumerate() {
                let Some(j) = Solid::facet(other).iter().position(|n| n == node) else { continue };
                let edge: Vec<usize> =
                    nodes.into_iter().filter(|n| Solid::facet(other).contains(n)).collect();
                if let [p, q] = edge[..] {
                    let across = (corners[p] - middle).cross(&(corners[q] - middle));
                    for (own, theirs) in [(i, j), (3, 3)] {
                        let jump = Solid::applied(stress[part][own], across)
                            - Solid::applied(stress[other][theirs], across);
                        assert!(jump.norm() < 1e-12);
                    }
                }
            }
        }
    }
}

#[test]
fn a_constant_stress_is_reproduced() {
    let constant = SymTensor3 { xx: 0.3, yy: -0.2, zz: 0.7, yz: 0.4, xz: -0.1, xy: 0.5 };
    let moments = moments_of(&corners(), &[constant; 4]);
    for at in CellMap::new(corners()).stress(&moments).iter().flatten() {
        let [found, expected]: [[f64; 6]; 2] = [(*at).into(), constant.into()];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-13), "{found:?}");
    }
}

#[test]
fn the_energy_matrix_and_the_work_agree_with_sums_over_the_parts() {
    let entry = |i: usize, j: usize| if i == j { 3.0 } else { 0.1 * ((i + 1) * (j + 1)) as f64 / 10.0 };
    let entries = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
    let material = LinearElastic::from_solid_stiffness(entries).unwrap();
    let (map, moments) = (CellMap::new(corners()), balanced());
    let stress = map.stress(&moments);
    let direct = distance_squared(&stress, SymTensor3::default(), map.volume, |s| material.strain(s));
    // The moments themselves as coordinates.
    let unit = |k: usize| [0, 1, 2].map(|j| if k / 3 == j { Solid::AXES[k % 3] } else { Vector3::zeros() });
    let mut batch = Batch::default();
    let factors = map.factors(|s| material.strain(s), 1.0);
    batch.enter(&map, factors, [std::array::from_fn(unit); 4]);
    let mut h = [[[0.0; 40]; MOMENTS]];
    batch.take(&mut h);
    let m: Vec<f64> = moments.iter().flatten().flat_map(|m| [m[0], m[1], m[2]]).collect();
    let product: f64 = (0..MOMENTS)
        .flat_map(|i| (0..MOMENTS).map(move |j| (i, j)))
        .map(|(i, j)| m[i] * f64::from(h[0][i][j]) * m[j])
        .sum();
    assert!((product - direct).abs() < 1e-5 * direct, "{product} {direct}");
    // The work on the strain of a linear displacement is that of the moments.
    let u = |x: Vector3<f64>| Vector3::new(0.1 * x[0] + 0.4 * x[1], -0.3 * x[2], 0.2 * x[0] + 0.7 * x[2]);
    let strain = SymTensor3 { xx: 0.1, zz: 0.7, yz: -0.15, xz: 0.1, xy: 0.2, yy: 0.0 };
    let work = map.work(&[[strain; 4]; 4]);
    let of_strain: f64 = work.iter().flatten().zip(moments.iter().flatten()).map(|(w, m)| w.dot(m)).sum();
    let places = (0..4).flat_map(Solid::facet).map(|k| corners()[k]);
    let of_moments: f64 = places.zip(moments.iter().flatten()).map(|(x, m)| u(x).dot(m)).sum();
    assert!((of_strain - of_moments).abs() < 1e-13, "{of_strain} {of_moments}");
}

#[test]
fn the_particular_stress_balances_the_force() {
    let force = Vector3::new(0.3, -0.2, -1.0);
    let stress = particular(&corners(), force);
    let gradients = Solid::gradients(&corners(), Solid::measure(&corners()));
    let divergence: Vector3<f64> = (0..4).map(|v| Solid::applied(stress[v], gradients[v])).sum();
    assert!((divergence + force).norm() < 1e-14);
    let sum: Vector3<f64> = moments_of(&corners(), &stress).iter().flatten().sum();
    assert!((sum + force * Solid::measure(&corners())).norm() < 1e-14);
}
