//! Boxes that do not end at nodes or cell borders: what the mesh makes of them is not what was written.

use super::regions::cells_in;
use super::{Case, CellSelection, Part};
use crate::diagnostic::significant;
use fem_core::body::Body;
use fem_core::geometry::{Vector, clipped, cross, norm};
use fem_core::mesh::TriMesh;
use mesh_io::words::counted;

/// An edge or cell of which less than this share lies on one side of a limit is not cut.
const SHARE: f64 = 1e-6;

/// The extent of a `part` or a box as written and as taken on the mesh, m or m², and the number of edges or cells that it cuts.
#[derive(Default)]
struct Cover {
    written: f64,
    taken: f64,
    cut: usize,
}

impl Cover {
    /// Says what is taken instead of what was written.
    ///
    /// * `alike`: how to put it if the two are the same to three digits.
    fn words(&self, alike: &str) -> String {
        let [taken, written] = [self.taken, self.written].map(significant);
        if taken == written { format!("{taken}, {alike}") } else { format!("{taken} instead of {written}") }
    }
}

impl Case {
    /// Names every `part` and every `box` that ends inside edges or cells of the first meshes.
    ///
    /// * `bodies`: in the file's order.
    pub(super) fn cut_notes(&self, bodies: &[Body]) -> Vec<String> {
        let mut notes = Vec::new();
        for (given, body) in self.bodies.iter().zip(bodies) {
            let name = &given.name;
            let supports = given.displacements.iter().map(|d| ("displacement", &d.on, d.part));
            let loads = given.tractions.iter().map(|t| ("traction", &t.on, t.part));
            let rigid = given.rigid.iter().map(|s| ("rigid side", &s.on, s.part));
            for (what, on, part) in supports.chain(loads).chain(rigid) {
                let found = on_side(body.mesh(), on, part);
                if found.cut > 0 {
                    notes.push(format!(
                        "body \"{name}\": the part of a {what} on \"{on}\" ends inside {} of the mesh, left out: it acts on a \
                         length of {}; put nodes at its ends, or use finer edges",
                        counted(found.cut, "edge"),
                        found.words("shorter by less than 1 %")
                    ));
                }
            }
            for region in &given.regions {
                let CellSelection::Box(part) = region.cells else { continue };
                let found = in_body(body.mesh(), part);
                if found.cut > 0 {
                    notes.push(format!(
                        "body \"{name}\": the box of \"{}\" cuts {}, each of which belongs to it if its centroid does: its \
                         area is {}; end it at cell borders, or use finer cells",
                        region.material,
                        counted(found.cut, "cell"),
                        found.words("nearly as written, its shape is another")
                    ));
                }
            }
        }
        notes
    }
}

/// The half planes of a box, widened by a tolerance: each a signed distance to a limit, positive inside.
fn limits(part: Part, tolerance: f64) -> impl Iterator<Item = impl Fn(Vector) -> f64> {
    part.limits.into_iter().enumerate().flat_map(move |(c, limits)| {
        let both = limits.map(|[low, high]| [(low, 1.0), (high, -1.0)]);
        both.into_iter()
            .flatten()
            .map(move |(limit, sign)| move |p: Vector| sign * (p[c] - limit) + tolerance)
    })
}

/// Measures what a `part` takes of a side: the edges whose both ends lie in it.
fn on_side(mesh: &TriMesh, group: &str, part: Part) -> Cover {
    let tolerance = Part::tolerance(mesh);
    let mut cover = Cover::default();
    for &edge in mesh.group(group).unwrap_or(&[]) {
        let [a, b] = mesh.facet_corners(edge);
        let (mut from, mut to) = (0.0f64, 1.0f64);
        let mut is_inside = true;
        for inside in limits(part, tolerance) {
            let (p, q) = (inside(a), inside(b));
            is_inside &= p >= 0.0 && q >= 0.0;
            match (p >= 0.0, q >= 0.0) {
                (true, true) => {}
                (false, false) => to = -1.0,
                (true, false) => to = to.min(p / (p - q)),
                (false, true) => from = from.max(p / (p - q)),
            }
        }
        let (share, length) = ((to - from).max(0.0), norm(b - a));
        cover.written += share * length;
        if is_inside {
            cover.taken += length;
        }
        cover.cut += usize::from(!is_inside && share > SHARE);
    }
    cover
}

/// Measures what a `box` takes of a body, [`cells_in`].
fn in_body(mesh: &TriMesh, part: Part) -> Cover {
    let tolerance = Part::tolerance(mesh);
    let taken = cells_in(mesh, part).into_iter().fold(0.0, |sum, t| sum + mesh.measure(t));
    let mut cover = Cover { taken, ..Cover::default() };
    for t in 0..mesh.cells().len() {
        let mut polygon = mesh.corners(t).to_vec();
        for inside in limits(part, tolerance) {
            polygon = clipped(&polygon, inside);
        }
        let covered = area(&polygon);
        cover.written += covered;
        cover.cut += usize::from((SHARE..1.0 - SHARE).contains(&(covered / mesh.measure(t))));
    }
    cover
}

fn area(polygon: &[Vector]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    polygon.windows(2).map(|w| 0.5 * cross(w[0] - first, w[1] - first)).sum()
}

#[cfg(test)]
mod tests {
    use crate::Case;

    #[test]
    fn a_part_or_a_box_that_ends_inside_a_cell_has_a_note() {
        let notes = |limit: &str| {
            let part = format!("uy = -0.01\npart = {{ x = [0.0, {limit}] }}");
            let region =
                format!("[[body.region]]\nmaterial = \"upper\"\nbox = {{ x = [0.0, {limit}] }}\n\n[contact]");
            let text =
                crate::template::PATCH.replacen("uy = -0.01", &part, 1).replacen("[contact]", &region, 1);
            Case::parse(&text, "patch.toml", &[]).unwrap().build().unwrap().1.join("\n")
        };
        // Cells of 0.25.
        assert_eq!(notes("1.25"), "");
        assert_eq!(
            notes("0.6"),
            "body \"upper\": the part of a displacement on \"top\" ends inside 1 edge of the mesh, left out: it acts on a \
             length of 0.500 instead of 0.600; put nodes at its ends, or use finer edges\n\
             body \"lower\": the box of \"upper\" cuts 8 cells, each of which belongs to it if its centroid does: its area is \
             0.625 instead of 0.600; end it at cell borders, or use finer cells"
        );
        // Numbers that are small, or the same to all digits shown.
        let cover = |taken, written| super::Cover { taken, written, cut: 1 };
        assert_eq!(cover(5e-7, 6e-7).words("alike"), "5.00e-7 instead of 6.00e-7");
        assert_eq!(cover(0.999_9, 1.0).words("its shape is another"), "1.00, its shape is another");
    }
}
