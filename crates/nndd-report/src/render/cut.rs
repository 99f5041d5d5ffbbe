//! A plane that cuts bodies open: of faces and cells the parts behind it, and its sections of cells.

use super::Vector;

/// A corner of something that is cut: its place at rest, which decides where it is cut, its place as it is drawn, and its height.
pub(super) type Corner = (Vector, Vector, f64);

/// A plane in the bodies at rest. The side of its normal is cut away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) point: Vector,
    pub(crate) normal: Vector,
}

impl Cut {
    fn distance(&self, corner: &Corner) -> f64 {
        (corner.0 - self.point).dot(&self.normal)
    }

    /// Finds the point of the plane between two corners on its two sides.
    fn between(&self, a: &Corner, b: &Corner) -> (Vector, f64) {
        let [from, to] = [self.distance(a), self.distance(b)];
        let part = from / (from - to);
        (a.1 + part * (b.1 - a.1), a.2 + part * (b.2 - a.2))
    }

    /// Returns the part of a face that remains, as triangles with a height at each corner.
    pub(crate) fn face(&self, corners: [Corner; 3]) -> Vec<[(Vector, f64); 3]> {
        let mut polygon = Vec::with_capacity(4);
        for (k, a) in corners.iter().enumerate() {
            let b = &corners[(k + 1) % 3];
            let [here, next] = [a, b].map(|corner| self.distance(corner) <= 0.0);
            if here {
                polygon.push((a.1, a.2));
            }
            if here != next {
                polygon.push(self.between(a, b));
            }
        }
        fan(&polygon)
    }

    /// Returns the part of a line that remains; `None` if nothing does.
    pub(crate) fn line(&self, a: Corner, b: Corner) -> Option<[Vector; 2]> {
        match [a, b].map(|corner| self.distance(&corner) <= 0.0) {
            [true, true] => Some([a.1, b.1]),
            [true, false] => Some([a.1, self.between(&a, &b).0]),
            [false, true] => Some([self.between(&a, &b).0, b.1]),
            [false, false] => None,
        }
    }

    /// Returns the line in which the plane meets a face, if it does.
    pub(crate) fn rim(&self, corners: [Corner; 3]) -> Option<[Vector; 2]> {
        let kept = corners.map(|corner| self.distance(&corner) <= 0.0);
        let crossed = [[0, 1], [1, 2], [2, 0]].into_iter().filter(|[a, b]| kept[*a] != kept[*b]);
        let mut points = crossed.map(|[a, b]| self.between(&corners[a], &corners[b]).0);
        Some([points.next()?, points.next()?])
    }

    /// Returns the section of a tetrahedron, as triangles with a height at each corner.
    pub(crate) fn cell(&self, corners: [Corner; 4]) -> Vec<[(Vector, f64); 3]> {
        let is_kept = |corner: &&Corner| self.distance(corner) <= 0.0;
        let kept: Vec<&Corner> = corners.iter().filter(is_kept).collect();
        let others: Vec<&Corner> = corners.iter().filter(|corner| !is_kept(corner)).collect();
        let section: Vec<(Vector, f64)> = match (&kept[..], &others[..]) {
            ([a, b], [c, d]) => [(a, c), (a, d), (b, d), (b, c)].map(|(a, b)| self.between(a, b)).into(),
            ([a], all @ [_, _, _]) | (all @ [_, _, _], [a]) => {
                all.iter().map(|b| self.between(a, b)).collect()
            }
            _ => Vec::new(),
        };
        fan(&section)
    }
}

/// Cuts a convex polygon into triangles around its first corner.
fn fan(polygon: &[(Vector, f64)]) -> Vec<[(Vector, f64); 3]> {
    match polygon {
        [first, rest @ ..] => rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect(),
        [] => Vec::new(),
    }
}
