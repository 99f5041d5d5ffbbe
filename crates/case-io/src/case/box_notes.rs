//! Boxes that do not end at nodes or cell borders: what the mesh makes of them is not what was written.

use super::regions::cells_in;
use super::{Case, CellSelection, Dimension, Part};
use crate::diagnostic::significant;
use fem_core::body::Body;
use fem_core::geometry::Coordinates;
use fem_core::mesh::Mesh;
use fem_core::space::Array;
use mesh_io::words::counted;

/// An edge or cell of which less than this share lies on one side of a limit is not cut.
const SHARE: f64 = 1e-6;

/// The extent of a `part` or a box as written and as taken on the mesh, m to m³, and the number of facets or cells that it cuts.
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

impl<S: Dimension> Case<S> {
    /// Names every `part` and every `box` that ends inside edges or cells of the first meshes.
    ///
    /// * `bodies`: in the file's order.
    pub(super) fn cut_notes(&self, bodies: &[Body<S>]) -> Vec<String> {
        let mut notes = Vec::new();
        for (given, body) in self.bodies.iter().zip(bodies) {
            let name = &given.name;
            let supports = given.displacements.iter().map(|d| ("displacement", &d.on, d.part));
            let loads = given.tractions.iter().map(|t| ("traction", &t.on, t.part));
            let rigid = given.rigid.iter().map(|s| ("rigid side", &s.on, s.part));
            let springs = given.springs.iter().map(|s| ("spring", &s.on, s.part));
            for (what, on, part) in supports.chain(loads).chain(rigid).chain(springs) {
                let found = on_side(body.mesh(), on, part);
                if found.cut > 0 {
                    notes.push(format!(
                        "body \"{name}\": the part of a {what} on \"{on}\" ends inside {} of the mesh, left out: the {} \
                         that it acts on is {}; put nodes at its ends, or use finer {}",
                        counted(found.cut, S::WORDS.facet),
                        S::EXTENT,
                        found.words("shorter by less than 1 %"),
                        S::WORDS.facets
                    ));
                }
            }
            for region in &given.regions {
                let CellSelection::Box(part) = region.cells else { continue };
                let found = in_body(body.mesh(), part);
                if found.cut > 0 {
                    notes.push(format!(
                        "body \"{name}\": the box of \"{}\" cuts {}, each of which belongs to it if its centroid does: its \
                         {} is {}; end it at cell borders, or use finer cells",
                        region.material,
                        counted(found.cut, "cell"),
                        S::WORDS.measure,
                        found.words("nearly as written, its shape is another")
                    ));
                }
            }
        }
        notes
    }
}

/// The half spaces of a box, widened by a tolerance: each a signed distance to a limit, positive inside.
fn limits<S: Dimension>(part: Part<S>, tolerance: f64) -> Vec<impl Fn(S::Vector) -> f64> {
    let of_axis = |c: usize| {
        let both = part.limits[c].map(|[low, high]| [(low, 1.0), (high, -1.0)]);
        both.into_iter().flatten().map(move |(limit, sign)| (c, limit, sign))
    };
    let distance =
        |(c, limit, sign): (usize, f64, f64)| move |p: S::Vector| sign * (p[c] - limit) + tolerance;
    (0..S::DIM).flat_map(of_axis).map(distance).collect()
}

/// Measures the part of a simplex in which all numbers are positive.
///
/// * `inside`: linear functions; `measure`: of a simplex.
fn covered<V: Coordinates, A: Array<V>>(
    corners: &A,
    inside: &[impl Fn(V) -> f64],
    measure: &dyn Fn(&A) -> f64,
) -> f64 {
    let Some((first, others)) = inside.split_first() else { return measure(corners).abs() };
    let values = corners.as_ref().iter().map(|p| first(*p)).collect();
    positive(corners, values, &|part| covered(part, others, measure))
}

/// Adds up a number over the simplices in which a linear function is positive: a simplex is halved at the zero on an edge, again and again.
fn positive<V: Coordinates, A: Array<V>>(corners: &A, values: Vec<f64>, number: &dyn Fn(&A) -> f64) -> f64 {
    let (Some(i), Some(j)) = (values.iter().position(|v| *v > 0.0), values.iter().position(|v| *v < 0.0))
    else {
        return if values.iter().any(|v| *v < 0.0) { 0.0 } else { number(corners) };
    };
    let zero = corners[i] + (corners[j] - corners[i]) * (values[i] / (values[i] - values[j]));
    let half = |k: usize| {
        let (mut corners, mut values) = (corners.clone(), values.clone());
        (corners[k], values[k]) = (zero, 0.0);
        positive(&corners, values, number)
    };
    half(i) + half(j)
}

/// Measures what a `part` takes of a side: the facets all of whose corners lie in it.
fn on_side<S: Dimension>(mesh: &Mesh<S>, group: &str, part: Part<S>) -> Cover {
    let inside = limits(part, Part::tolerance(mesh));
    let mut cover = Cover::default();
    for &facet in mesh.group(group).unwrap_or(&[]) {
        let corners = mesh.facet_corners(facet);
        let (whole, share) = (mesh.facet_measure(facet), covered(&corners, &inside, &S::facet_measure));
        let is_inside = corners.into_iter().all(|p| inside.iter().all(|of| of(p) >= 0.0));
        cover.written += share;
        if is_inside {
            cover.taken += whole;
        }
        cover.cut += usize::from(!is_inside && share > SHARE * whole);
    }
    cover
}

/// Measures what a `box` takes of a body, [`cells_in`].
fn in_body<S: Dimension>(mesh: &Mesh<S>, part: Part<S>) -> Cover {
    let inside = limits(part, Part::tolerance(mesh));
    let taken = cells_in(mesh, part).into_iter().fold(0.0, |sum, t| sum + mesh.measure(t));
    let mut cover = Cover { taken, ..Cover::default() };
    for t in 0..mesh.cells().len() {
        let share = covered(&mesh.corners(t), &inside, &S::measure);
        cover.written += share;
        cover.cut += usize::from((SHARE..1.0 - SHARE).contains(&(share / mesh.measure(t))));
    }
    cover
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
            "body \"upper\": the part of a displacement on \"top\" ends inside 1 edge of the mesh, left out: the length \
             that it acts on is 0.500 instead of 0.600; put nodes at its ends, or use finer edges\n\
             body \"lower\": the box of \"upper\" cuts 8 cells, each of which belongs to it if its centroid does: its area is \
             0.625 instead of 0.600; end it at cell borders, or use finer cells"
        );
        // Numbers that are small, or the same to all digits shown.
        let cover = |taken, written| super::Cover { taken, written, cut: 1 };
        assert_eq!(cover(5e-7, 6e-7).words("alike"), "5.00e-7 instead of 6.00e-7");
        assert_eq!(cover(0.999_9, 1.0).words("its shape is another"), "1.00, its shape is another");
    }
}
