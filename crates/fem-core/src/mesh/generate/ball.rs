//! Balls of tetrahedra, and halves, quarters and eighths of them.

use super::{Facing, cuboid, too_many};
use crate::mesh::{Mesh, MeshError, TetMesh};
use nalgebra::Vector3;
use std::collections::HashMap;

/// The part of a ball that is meshed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BallPart {
    /// All of it.
    Whole,
    /// The half on one side of the centre along z.
    Half,
    /// The part of that half at larger x than the centre.
    Quarter,
    /// The part of that half at larger x and y than the centre.
    Eighth,
}

/// The largest ratio of lengths of cells.
const LARGEST_GROWTH: f64 = 5.0;

/// The half length of the middle cube over the radius, before it is bent: its angles are larger than those of a sphere.
const CUBE: f64 = 0.75;

/// Meshes a ball, or a part of one for problems with planes of symmetry, with small cells near the poles: the points of the surface above and below the
/// centre.
///
/// Each eighth is a cube of `cells`³ boxes, cut as [`cuboid`] does, whose three outer sides are moved onto the sphere:
/// ```math
/// x ← R x (¾ (1 − s) + s²/|x|),   s = max(x_1, x_2, x_3)
/// ```
/// and the other eighths are its mirror images. The sides are named `surface` (the sphere), `flat` (through the centre, across z), and, at the planes of
/// symmetry of a quarter and an eighth, `left` (across x) and `front` (across y). Nodes of `surface` have the radius to rounding, and nodes of the planes lie on
/// them exactly.
///
/// * `facing`: the side of the pole of a half, a quarter or an eighth; a whole ball has both.
/// * `growth`: the length of the longest cells over the one at the pole, from 1 to 5. Up to 20 cells the smallest angle between faces is at least 28 degrees
///   with 1, 15 with 2, 10 with 3 and 5 with 5.
/// * `cells`: from the centre to the surface.
///
/// # Errors
/// A radius that is not positive, a growth beyond its limits, numbers that are not finite, no or too many cells.
pub fn ball(
    centre: impl Into<Vector3<f64>>,
    radius: f64,
    (part, facing): (BallPart, Facing),
    growth: f64,
    cells: usize,
) -> Result<TetMesh, MeshError> {
    let fault = |reason| Err(MeshError::Generator { kind: "ball", reason });
    let centre = centre.into();
    if !centre.iter().all(|x| x.is_finite()) {
        return fault("the centre must be finite");
    }
    if !(radius > 0.0 && radius.is_finite()) {
        return fault("the radius must be positive and finite");
    }
    if !(1.0..=LARGEST_GROWTH).contains(&growth) {
        return fault("the growth of the cells must be from 1 to 5");
    }
    if cells == 0 || too_many(&[cells.saturating_mul(2); 3]) {
        return fault("at least one cell is needed, and at most 2^28 - 1 in total");
    }
    let octant = cuboid([0.0; 3], [1.0; 3], [cells; 3])?;
    let step = |k: usize| {
        let part = k as f64 / cells as f64;
        if growth == 1.0 { part } else { (growth.powf(part) - 1.0) / (growth - 1.0) }
    };
    let steps: Vec<f64> = (0..=cells).map(step).collect();
    let place = |node: usize| {
        [node % (cells + 1), node / (cells + 1) % (cells + 1), node / (cells + 1) / (cells + 1)]
    };
    let bent = |[i, j, k]: [usize; 3]| {
        let at = Vector3::new(steps[i], steps[j], 1.0 - steps[cells - k]);
        let (s, length) = (at.max(), at.norm());
        match [i, j, k].contains(&cells) {
            true => at * (radius / length),
            false if length > 0.0 => at * (radius * (CUBE * (1.0 - s) + s * s / length)),
            false => at,
        }
    };
    let places: Vec<[usize; 3]> = (0..octant.points().len()).map(place).collect();
    let bent: Vec<Vector3<f64>> = places.iter().map(|place| bent(*place)).collect();
    let (mut points, mut all, mut number) = (Vec::new(), Vec::new(), HashMap::new());
    let sides = [
        ("surface", &["right", "back", "top"][..]),
        ("flat", &["bottom"]),
        ("left", &["left"]),
        ("front", &["front"]),
    ];
    let mut groups = sides.map(|(name, _)| (name.to_owned(), Vec::new()));
    for signs in octants(part, facing) {
        let of_node = |(place, at): (&[usize; 3], &Vector3<f64>)| {
            let lattice = [0, 1, 2].map(|c: usize| signs[c] * place[c] as i64);
            *number.entry(lattice).or_insert_with(|| {
                points.push(centre + Vector3::from_fn(|c, _| signs[c] as f64 * at[c]));
                points.len() as u32 - 1
            })
        };
        let nodes: Vec<u32> = places.iter().zip(&bent).map(of_node).collect();
        let mirrored = signs.iter().product::<i64>() < 0;
        all.extend(octant.cells().iter().map(|cell| {
            let mut cell = cell.map(|node| nodes[node.index()]);
            if mirrored {
                cell.swap(2, 3);
            }
            cell
        }));
        for ((_, group), (_, names)) in groups.iter_mut().zip(&sides) {
            let faces = names.iter().flat_map(|name| octant.group(name).unwrap_or_default());
            group.extend(faces.map(|face| octant.topology().facets()[*face].map(|node| nodes[node.index()])));
        }
    }
    // Planes between two eighths are no sides.
    let outer = match part {
        BallPart::Whole => 1,
        BallPart::Half => 2,
        BallPart::Quarter => 3,
        BallPart::Eighth => 4,
    };
    Mesh::new(points, all, groups.into_iter().take(outer).collect())
}

/// Counts the nodes of a [`ball`] without creating it.
pub fn ball_nodes(part: BallPart, cells: usize) -> u64 {
    let (one, two) = (cells as u64 + 1, (cells as u64).saturating_mul(2) + 1);
    let along = match part {
        BallPart::Whole => [two; 3],
        BallPart::Half => [two, two, one],
        BallPart::Quarter => [two, one, one],
        BallPart::Eighth => [one; 3],
    };
    along.into_iter().fold(1, u64::saturating_mul)
}

/// Lists the signs of the coordinates in each eighth of a part.
fn octants(part: BallPart, facing: Facing) -> impl Iterator<Item = [i64; 3]> {
    const BOTH: &[i64] = &[1, -1];
    const LARGER: &[i64] = &[1];
    let pole: &[i64] = if facing == Facing::Down { &[-1] } else { LARGER };
    let [x, y, z] = match part {
        BallPart::Whole => [BOTH; 3],
        BallPart::Half => [BOTH, BOTH, pole],
        BallPart::Quarter => [LARGER, BOTH, pole],
        BallPart::Eighth => [LARGER, LARGER, pole],
    };
    z.iter().flat_map(move |z| y.iter().flat_map(move |y| x.iter().map(move |x| [*x, *y, *z])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const PARTS: [(BallPart, f64); 4] =
        [(BallPart::Whole, 1.0), (BallPart::Half, 0.5), (BallPart::Quarter, 0.25), (BallPart::Eighth, 0.125)];

    fn volume(mesh: &TetMesh) -> f64 {
        (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum()
    }

    #[test]
    fn parts_of_balls_have_their_volume_and_every_face_of_their_boundary_has_one_name() {
        let centre = Vector3::new(0.3, -1.0, 2.0);
        for (part, share) in PARTS {
            for facing in [Facing::Down, Facing::Up] {
                let mut missing = Vec::new();
                for cells in [2, 4, 8] {
                    let mesh = ball(centre, 1.5, (part, facing), 2.0, cells).unwrap();
                    assert_eq!(mesh.turned(), 0);
                    assert_eq!(mesh.points().len() as u64, ball_nodes(part, cells));
                    missing.push(4.0 / 3.0 * PI * 1.5f64.powi(3) * share - volume(&mesh));
                    let named: usize = mesh.groups().values().map(|faces| faces.len()).sum();
                    assert_eq!(named, mesh.topology().boundary_facets().len());
                    for (name, faces) in mesh.groups() {
                        for x in faces.iter().flat_map(|face| mesh.facet_corners(*face)).map(|x| x - centre) {
                            match &**name {
                                "surface" => assert!((x.norm() - 1.5).abs() < 1e-15),
                                "flat" => assert_eq!(x[2], 0.0),
                                "left" => assert_eq!(x[0], 0.0),
                                _ => assert_eq!(x[1], 0.0),
                            }
                        }
                    }
                    let sign = if facing == Facing::Down { -1.0 } else { 1.0 };
                    let pole = centre + Vector3::z() * (sign * 1.5);
                    assert!(mesh.points().iter().any(|x| (x - pole).norm() < 1e-15));
                }
                // The facets of the surface are flat: what is missing falls with the square of their size.
                assert!(missing[2] > 0.0 && missing[1] < 0.4 * missing[0] && missing[2] < 0.4 * missing[1]);
            }
        }
    }

    #[test]
    fn cells_of_balls_have_good_angles_at_any_number_and_are_small_at_the_pole() {
        for (growth, least) in [(1.0, 28.0), (2.0, 15.0), (3.0, 10.0), (5.0, 5.0)] {
            for cells in [1, 2, 3, 6, 12] {
                let mesh = ball([0.0; 3], 1.0, (BallPart::Eighth, Facing::Down), growth, cells).unwrap();
                assert!(mesh.smallest_angle() > least, "{growth} {cells}: {}", mesh.smallest_angle());
            }
        }
        let sizes = |growth: f64| {
            let mesh = ball([0.0; 3], 1.0, (BallPart::Half, Facing::Up), growth, 8).unwrap();
            let at = |x: Vector3<f64>| {
                let near =
                    |t: &usize| mesh.cells()[*t].iter().any(|n| (mesh.points()[*n] - x).norm() < 1e-12);
                (0..mesh.cells().len()).filter(near).map(|t| mesh.measure(t)).fold(0.0, f64::max)
            };
            at(Vector3::x()) / at(Vector3::z())
        };
        assert!((sizes(1.0) - 1.0).abs() < 1e-9 && sizes(2.0) > 3.0, "{} {}", sizes(1.0), sizes(2.0));
    }

    #[test]
    fn balls_that_cannot_be_are_refused() {
        let refused = |centre: f64, radius, growth, cells| {
            let part = (BallPart::Half, Facing::Down);
            ball([centre; 3], radius, part, growth, cells).unwrap_err().to_string()
        };
        assert!(refused(f64::NAN, 1.0, 1.0, 2).contains("centre"));
        assert!(refused(0.0, 0.0, 1.0, 2).contains("radius"));
        assert!(refused(0.0, 1.0, 0.5, 2).contains("from 1 to 5"));
        assert!(refused(0.0, 1.0, f64::NAN, 2).contains("from 1 to 5"));
        assert!(refused(0.0, 1.0, 1.0, 0).contains("one cell"));
        assert!(refused(0.0, 1.0, 1.0, usize::MAX).contains("2^28"));
    }
}
