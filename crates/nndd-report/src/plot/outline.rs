//! The boundary of a triangulation, as closed lines.

use std::collections::HashMap;

/// Returns the boundary of a triangulation as lines through point numbers, each ending where it began if
/// it closes.
///
/// `area` gives twice the signed area of a triangle; those without area are left out. An edge belongs to the
/// boundary when the triangles, all turned the same way, do not pass it in the opposite direction too. Only
/// nodes whose edges in and out do not balance can lie on it, so that the search touches few triangles.
pub(super) fn outline(
    points: usize,
    triangles: &[[u32; 3]],
    area: impl Fn(&[u32; 3]) -> f64,
) -> Vec<Vec<u32>> {
    let turned = |t: &[u32; 3]| {
        let a = area(t);
        if a > 0.0 {
            Some(*t)
        } else if a < 0.0 {
            Some([t[0], t[2], t[1]])
        } else {
            None
        }
    };
    let mut balance = vec![0i64; points];
    for t in triangles.iter().filter_map(turned) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            balance[a as usize] += i64::from(b) + 1;
            balance[b as usize] -= i64::from(a) + 1;
        }
    }
    let near = |v: u32| balance[v as usize] != 0;
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in triangles.iter().filter_map(turned) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if near(a) && near(b) {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    for ((a, b), count) in edges {
        if count > 0 {
            next.entry(a).or_default().push(b);
        } else if count < 0 {
            next.entry(b).or_default().push(a);
        }
    }
    chained(next)
}

/// Joins directed edges end to end, always starting from the smallest point left.
fn chained(mut next: HashMap<u32, Vec<u32>>) -> Vec<Vec<u32>> {
    next.values_mut().for_each(|v| v.sort_unstable_by(|a, b| b.cmp(a)));
    let mut starts: Vec<u32> = next.keys().copied().collect();
    starts.sort_unstable();
    let mut lines = vec![];
    for start in starts {
        while let Some(second) = next.get_mut(&start).and_then(Vec::pop) {
            let mut line = vec![start, second];
            let mut at = second;
            while at != start {
                let Some(to) = next.get_mut(&at).and_then(Vec::pop) else { break };
                line.push(to);
                at = to;
            }
            lines.push(line);
        }
    }
    lines
}
