//! Rings and their sectors.

use super::too_many;
use crate::geometry::Vector;
use crate::mesh::{MeshError, TriMesh};

/// Meshes the part of a ring between two radii and two angles with `cells[0] × cells[1]` cells, around and across.
///
/// ```text
///   centre + r (cos a, sin a),   radii[0] ≤ r ≤ radii[1],   angles[0] ≤ a ≤ angles[1] degrees
/// ```
/// The sides are named `inner` and `outer` (the radii), `start` and `end` (the angles); a whole ring, 360 degrees, has no
/// `start` and `end`. Nodes lie at equal steps of the radius and the angle; those at multiples of 90 degrees lie
/// exactly on the axes through the centre. All cells along an arc have the same angle, so rings with equal angles and
/// cell numbers match.
///
/// # Errors
/// Radii that are not positive and increasing, angles that are not increasing or more than 360 degrees apart, cells
/// that turn by more than 60 degrees, too many cells.
pub fn ring(
    centre: impl Into<Vector>,
    radii: [f64; 2],
    angles: [f64; 2],
    cells: [usize; 2],
) -> Result<TriMesh, MeshError> {
    let fault = |reason| Err(MeshError::Generator { kind: "ring", reason });
    let centre = centre.into();
    if !centre.iter().chain(&radii).chain(&angles).all(|x| x.is_finite()) {
        return fault("centre, radii and angles must be finite numbers");
    }
    if !(radii[0] > 0.0 && radii[1] > radii[0]) {
        return fault("the radii must be [inner, outer] with 0 < inner < outer");
    }
    let sweep = angles[1] - angles[0];
    if !(sweep > 0.0 && sweep <= 360.0) {
        return fault("the angles must be [start, end] in degrees, start below end, at most 360 apart");
    }
    let [around, across] = cells;
    if around == 0 || across == 0 || too_many(&cells) {
        return fault("at least one cell is needed in each direction, and at most 2^28 - 1 of them");
    }
    if sweep / around as f64 > 60.0 {
        return fault(
            "a cell would turn by more than 60 degrees: more cells are needed in the circumferential direction",
        );
    }
    let closed = sweep == 360.0;
    let columns = if closed { around } else { around + 1 };
    let mut points = Vec::with_capacity(columns * (across + 1));
    for j in 0..=across {
        let radius =
            if j == across { radii[1] } else { radii[0] + (radii[1] - radii[0]) * j as f64 / across as f64 };
        for i in 0..columns {
            let angle = if i == around { angles[1] } else { angles[0] + sweep * i as f64 / around as f64 };
            points.push(centre + radius * direction(angle));
        }
    }
    let node = |i: usize, j: usize| (j * columns + i % columns) as u32;
    let mut triangles = Vec::with_capacity(2 * around * across);
    for j in 0..across {
        for i in 0..around {
            // The circumferential direction is counter-clockwise, so the radial one comes first.
            let [a, b, c, d] = [node(i, j), node(i, j + 1), node(i + 1, j + 1), node(i + 1, j)];
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    let arc = |j: usize| (0..around).map(|i| [node(i, j), node(i + 1, j)]).collect();
    let ray = |i: usize| (0..across).map(|j| [node(i, j), node(i, j + 1)]).collect();
    let mut groups = vec![("inner".to_string(), arc(0)), ("outer".to_string(), arc(across))];
    if !closed {
        groups.push(("start".to_string(), ray(0)));
        groups.push(("end".to_string(), ray(around)));
    }
    TriMesh::new(points, triangles, groups)
}

/// Computes `[cos a, sin a]` of degrees, exact at multiples of 90.
pub(super) fn direction(degrees: f64) -> Vector {
    let quarter = (degrees / 90.0).round();
    let (s, c) = (degrees - 90.0 * quarter).to_radians().sin_cos();
    match (quarter as i64).rem_euclid(4) {
        0 => Vector::new(c, s),
        1 => Vector::new(-s, c),
        2 => Vector::new(-c, -s),
        _ => Vector::new(s, -c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_has_its_ends_on_the_axes() {
        let m = ring([0.5, -1.0], [1.0, 2.0], [0.0, 90.0], [8, 4]).unwrap();
        assert_eq!(m.points().len(), 45);
        for &e in m.group("end").unwrap() {
            assert_eq!(m.facet_normal(e).map(f64::abs), Vector::new(1.0, 0.0));
        }
        for &e in m.group("start").unwrap() {
            assert_eq!(m.facet_normal(e), Vector::new(0.0, -1.0));
        }
        assert_eq!(m.group("inner").unwrap().len(), 8);
        // The polygons' areas.
        let sine = (90.0f64 / 8.0).to_radians().sin();
        let area: f64 = (0..m.cells().len()).map(|t| m.measure(t)).sum();
        assert!((area - 8.0 * 0.5 * sine * (4.0 - 1.0)).abs() < 1e-13);
    }

    #[test]
    fn a_whole_ring_closes() {
        let m = ring([0.0, 0.0], [1.0, 2.0], [0.0, 360.0], [12, 3]).unwrap();
        assert_eq!(m.points().len(), 48);
        // Euler: V − E + T = 0 for a ring.
        assert_eq!(48 + m.cells().len(), m.topology().facets().len());
        assert!(m.group("start").is_none());
        assert!(m.topology().boundary_facets().len() == 24);
    }

    #[test]
    fn impossible_rings_are_refused() {
        let ring = |radii, angles, cells| ring([0.0, 0.0], radii, angles, cells);
        assert!(ring([0.0, 1.0], [0.0, 90.0], [8, 1]).is_err());
        assert!(ring([2.0, 1.0], [0.0, 90.0], [8, 1]).is_err());
        assert!(ring([1.0, 2.0], [0.0, 400.0], [8, 1]).is_err());
        assert!(ring([1.0, 2.0], [90.0, 0.0], [8, 1]).is_err());
        assert!(ring([1.0, 2.0], [0.0, 360.0], [5, 1]).is_err());
        assert!(ring([1.0, f64::NAN], [0.0, 90.0], [8, 1]).is_err());
        assert!(ring([1.0, 2.0], [0.0, 90.0], [usize::MAX, 2]).is_err());
    }
}
