//! The least value of the opening on a face along which the normal changes.

use crate::lift::depth_of_edge;
use crate::size::larger;

/// Coefficients below this part of the largest one are zero: those of active rows are rounding.
const ZERO: f64 = 1e-14;

/// Computes by how much a quadratic opening `λᵀ Q λ` on a face penetrates, m: not positive if it is nowhere negative at barycentric coordinates `λ ≥ 0`
/// (`Q` is copositive; Hadeler 1983 has the same conditions without a length).
///
/// On the edges see [`depth_of_edge`]. Inside, the least value is at a critical point, `Q λ = q 1`, if it is not on an edge:
/// ```math
/// λ = adj(Q) 1 / s,   q = det Q / s,   s = 1ᵀ adj(Q) 1
/// ```
///
/// * `corners`: `Q_11`, `Q_22`, `Q_33`; negative ones count as zero. `edges`: `Q_12`, `Q_13`, `Q_23`, m.
pub(super) fn depth(corners: [f64; 3], edges: [f64; 3]) -> f64 {
    let largest = corners.iter().chain(&edges).fold(0.0, |most, q| larger(most, q.abs()));
    let zeroed = |q: f64| if q.abs() <= ZERO * largest { 0.0 } else { q };
    let [a, b, c] = corners.map(|q| zeroed(larger(q, 0.0)));
    let [ab, ac, bc] = edges.map(zeroed);
    let of_edges = [depth_of_edge(ab, [a, b]), depth_of_edge(ac, [a, c]), depth_of_edge(bc, [b, c])];
    let along = larger(larger(of_edges[0], of_edges[1]), of_edges[2]);
    let adjugate = [
        [b * c - bc * bc, ac * bc - ab * c, ab * bc - ac * b],
        [ac * bc - ab * c, a * c - ac * ac, ab * ac - a * bc],
        [ab * bc - ac * b, ab * ac - a * bc, a * b - ab * ab],
    ];
    let sums = adjugate.map(|row| row[0] + row[1] + row[2]);
    let all = sums[0] + sums[1] + sums[2];
    // The critical point is in the face.
    if all == 0.0 || sums.iter().any(|sum| sum / all < 0.0) {
        return along;
    }
    let determinant = a * adjugate[0][0] + ab * adjugate[0][1] + ac * adjugate[0][2];
    let inside = -determinant / all;
    // Of the size of the rounding of the determinant.
    if inside <= ZERO * largest { along } else { larger(along, inside) }
}

#[cfg(test)]
mod tests {
    use super::depth;

    /// The least value on a grid, the three conditions of Hadeler, and the depth agree.
    #[test]
    fn the_depth_is_positive_if_and_only_if_the_opening_is_negative_somewhere() {
        let mut random = crate::random::random(3);
        let (mut inside, mut open) = (0, 0);
        for _ in 0..20_000 {
            let corners = [0; 3].map(|_| if random() < 0.2 { 0.0 } else { random() });
            let edges = [0; 3].map(|_| random() * 1.5 - 1.0);
            let value = |x: f64, y: f64| {
                let l = [x, y, 1.0 - x - y];
                let squares: f64 = corners.iter().zip(l).map(|(q, l)| q * l * l).sum();
                squares + 2.0 * (edges[0] * l[0] * l[1] + edges[1] * l[0] * l[2] + edges[2] * l[1] * l[2])
            };
            let n = 60;
            let points = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [i, j].map(|k| k as f64 / n as f64)));
            let least = points.map(|[x, y]| value(x, y)).fold(f64::INFINITY, f64::min);
            let [a, b, c] = corners.map(f64::sqrt);
            let alpha = [edges[0] + a * b, edges[1] + a * c, edges[2] + b * c];
            let third = a * b * c + edges[0] * c + edges[1] * b + edges[2] * a;
            let hadeler = alpha.iter().all(|x| *x >= 0.0)
                && third + (2.0 * alpha[0] * alpha[1] * alpha[2]).sqrt() >= 0.0;
            let found = depth(corners, edges);
            assert_eq!(found <= 0.0, hadeler, "{corners:?} {edges:?} {found:e}");
            assert!(least >= -found.max(0.0) - 1e-12, "{corners:?} {edges:?} {least:e} {found:e}");
            inside += usize::from(found > 0.0 && alpha.iter().all(|x| *x >= 0.0));
            open += usize::from(hadeler);
        }
        assert!(inside > 100 && open > 1000, "{inside} {open}");
        // Rounding of active rows is no penetration.
        assert!(depth([-1e-18, 0.0, 1.0], [0.0, 0.2, 1e-17]) <= 0.0);
    }
}
