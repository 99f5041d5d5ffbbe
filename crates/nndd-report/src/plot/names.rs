//! The names of bodies, written within them.

use super::axis::drawable;
use super::outline::outline;
use super::sheet::{self, MARGIN, PIXEL, Sheet, WIDTH, Words};
use fem_core::geometry::{Vector, norm};
use fem_core::mesh::TriMesh;

/// Size of the names.
pub(super) const NAME: f64 = 15.0 * PIXEL;
/// Triangles and points of the boundary tried in search of a place for a name.
const MOST_TRIED: usize = 300;

/// Writes the name of a body within it, as far from its boundary as it gets and near its middle, and returns the place.
///
/// * `places`: of the mesh's points on the sheet.
pub(super) fn write(
    sheet: &mut Sheet,
    name: &str,
    mesh: &TriMesh,
    places: &[Option<Vector>],
) -> Option<Vector> {
    // Of some triangles the one farthest from the boundary, and of those alike the one nearest to the middle.
    let step = |n: usize| (n / MOST_TRIED).max(1);
    let edge = outline(mesh).concat();
    let edge: Vec<Vector> = edge.iter().step_by(step(edge.len())).filter_map(|v| places[v.index()]).collect();
    let middle = |t: &[_; 3]| -> Option<Vector> {
        let [a, b, c] = t.map(|v: fem_core::mesh::id::NodeId| places[v.index()]);
        Some((a? + b? + c?) / 3.0)
    };
    let triangles = mesh.cells();
    let tried: Vec<Vector> = triangles.iter().step_by(step(triangles.len())).filter_map(middle).collect();
    let centre = tried.iter().sum::<Vector>() / tried.len().max(1) as f64;
    // Words are wider than high: what is beside them is nearer than it looks.
    let aspect = (sheet::width_of(name, NAME) / NAME).max(1.0);
    let squared = |a: Vector, b: Vector| ((a[0] - b[0]) / aspect).powi(2) + (a[1] - b[1]).powi(2);
    let near = |m: Vector| edge.iter().map(|p| squared(*p, m)).fold(f64::INFINITY, f64::min).sqrt();
    let worth = |m: &Vector| near(*m) - 0.2 * norm(centre - *m);
    let best = tried.iter().max_by(|a, b| worth(a).total_cmp(&worth(b)));
    let at = *best.filter(|m| m.iter().all(|v| drawable(*v)))?;
    // As large as fits into the body, if that can be read; a name of several words on two lines if it must.
    let inside = 1.8 * aspect * near(at);
    let lines = match name.rsplit_once(' ') {
        Some((first, second)) if sheet::width_of(name, NAME) > inside => vec![first, second],
        _ => vec![name],
    };
    let widest = lines.iter().copied().max_by_key(|line| line.chars().count()).unwrap_or(name);
    let inside = inside.max(sheet::width_of(widest, 0.7 * NAME));
    let room = (2.0 * at[0].min(WIDTH - at[0]) - MARGIN).min(inside);
    let size = sheet::fitting(widest, NAME, room);
    for (k, line) in lines.iter().enumerate() {
        let down = 1.1 * size * (k as f64 - 0.5 * (lines.len() - 1) as f64);
        Words::new(size).bold().with_halo().write(sheet, line, at + down * Vector::y());
    }
    Some(at)
}
