//! Makes the surfaces of two solids match whose nodes do not: lays one over the other along one direction, and cuts both.
//!
//! 1. **Project.** Both surfaces are seen along one direction `d`, by default the mean normal of the first one. No face may be steeper than 60
//!    degrees to it. Parallel projection is affine between two faces, so each stays a triangle.
//! 2. **Snap.** A node inside of a flat part of a surface slides along it onto a node or an edge of the other one that is close, see [`snapping`].
//! 3. **Overlay.** The nodes and edges of both, and the crossings of these, make one triangulation, Delaunay's as far as the edges let it. Where only
//!    one surface is, its faces stay free.
//! 4. **Insert.** Each new node is put on the face or edge of its own body, and the cells there are cut, see
//!    [`fem_core::mesh::insertion`]. No face changes its place, and its parts inherit its conditions ([`Body::refined`]): the problem is
//!    the same.
//!
//! Now nodes face each other along `d`. On flat surfaces the rest is as if the meshes matched. On curved ones the normals are those at the nodes
//! that the first body had, linear on its faces, and the distance of the two polyhedra is left out: it is of the square of the size of the faces.
//!
//! Sources: the common refinement of Jiao and Heath 2004; the constrained triangulation is spade's.

mod arrangement;
mod sliding;
mod snapping;

use crate::solid_pairs::{Known, averaged_normals, is_curved, plane};
use arrangement::{Arrangement, Fault, Flat, Patch, arrange, barycentric, by_face};
use fem_core::body::{Body, BodyError};
use fem_core::geometry::{Point, norm, shown};
use fem_core::interface::InterfaceError;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::insertion::{SurfaceCut, with_cut_surface};
use fem_core::mesh::{MeshError, TetMesh};
use fem_core::space::{Solid, Space};
use sliding::Sliding;
use snapping::snap;
use std::collections::{BTreeMap, HashMap};
use thiserror::Error;

type Vector = <Solid as Space>::Vector;

/// Cosine of the largest angle between a face and the direction along which it is seen: 60 degrees.
const STEEP: f64 = 0.5;
/// A free area up to this part of a surface is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Why two surfaces of solids have no overlay.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum OverlayError {
    /// The surfaces cannot be in contact at all.
    #[error("{0}")]
    Interface(#[from] InterfaceError),
    /// A face is too steep.
    #[error(
        "the surfaces do not match and face more than one way: the face of body {body} at {point} is {degrees:.0} degrees from the \
         direction {direction} along which they would be laid over each other; at most 60 are possible"
    )]
    Steep {
        /// 0 or 1.
        body: usize,
        /// Middle of the face.
        point: Point,
        /// Angle between its normal and the direction.
        degrees: f64,
        /// The direction.
        direction: Point,
    },
    /// The surfaces lie side by side.
    #[error(
        "the two contact surfaces do not overlap: seen along {direction}, no face of the one, around {}, is over a face of the other, around {}",
        points[0], points[1]
    )]
    NoOverlap {
        /// The mean of each surface's nodes.
        points: [Point; 2],
        /// The direction.
        direction: Point,
    },
    /// A surface covers itself.
    #[error("the surface of a body covers itself at {point}, seen along {direction}")]
    Folded {
        /// A point of the fold.
        point: Point,
        /// The direction.
        direction: Point,
    },
    /// Nodes or edges of the two surfaces are too close.
    #[error(
        "the surfaces do not match, and nodes or edges of the two are so close at {point} that the overlay has a triangle of {} of the height \
         of the faces there; at least 0.001 is needed",
        shown(*height)
    )]
    Thin {
        /// Where it is.
        point: Point,
        /// Its height over the size of the faces.
        height: f64,
    },
    /// A gap was to be measured between curved surfaces.
    #[error(
        "the gap between curved surfaces that do not match is not measured: their faces are apart by more than the bodies deform"
    )]
    MeasuredGap,
    /// The cut mesh is too large, or its cells are too small.
    #[error("the mesh of body {body}, cut at the other side's nodes and edges: {source}")]
    Mesh {
        /// 0 or 1.
        body: usize,
        /// The error of its mesh.
        source: MeshError,
    },
    /// A condition cannot be evaluated on the cut mesh.
    #[error("body {body}, cut at the other side's nodes and edges: {source}")]
    Body {
        /// 0 or 1.
        body: usize,
        /// The error of its conditions.
        source: BodyError,
    },
}

/// What an overlay changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OverlayChanges {
    /// Nodes added to each body.
    pub added: [usize; 2],
    /// Nodes of each body that slid along its surface, onto a node or an edge of the other one.
    pub snapped: [usize; 2],
    /// The largest distance by which one slid, m.
    pub largest_move: f64,
    /// The smallest height of a triangle of the overlay over the size of the smaller face it lies in.
    pub lowest: f64,
    /// Area of each surface that does not face the other one and is free, m².
    pub free: [f64; 2],
}

impl OverlayChanges {
    /// Adds what an earlier overlay of the same surfaces changed.
    pub(crate) fn after(self, before: Option<Self>) -> Self {
        let Some(before) = before else { return self };
        Self {
            added: [0, 1].map(|b: usize| before.added[b] + self.added[b]),
            snapped: [0, 1].map(|b: usize| before.snapped[b] + self.snapped[b]),
            largest_move: before.largest_move.max(self.largest_move),
            lowest: before.lowest.min(self.lowest),
            free: [0, 1].map(|b: usize| before.free[b] + self.free[b]),
        }
    }
}

/// Two bodies whose surfaces match.
#[derive(Clone, Debug)]
pub(crate) struct Overlay {
    /// The bodies, in the order given. Each has a group of the faces in contact.
    pub(crate) bodies: [Body<Solid>; 2],
    pub(crate) known: Known,
    pub(crate) changes: OverlayChanges,
}

/// Two surfaces, seen along a direction.
struct Seen<'a> {
    bodies: [&'a Body<Solid>; 2],
    faces: [&'a [FacetId]; 2],
    /// The direction, then two axes across it.
    axes: [Vector; 3],
    /// The nodes of each patch.
    nodes: [Vec<NodeId>; 2],
    sliding: [Sliding<'a>; 2],
    patches: [Patch; 2],
}

/// Makes the surfaces of two bodies match.
///
/// * `faces`: of each surface; `groups`: the names of the groups of faces in contact that the bodies get; `direction`: along which they are seen, of
///   any length, or the mean normal of the first.
///
/// # Errors
/// Surfaces that do not overlap, are too steep, or have nodes too close to each other's, see [`OverlayError`].
pub(crate) fn overlay(
    bodies: [&Body<Solid>; 2],
    faces: [&[FacetId]; 2],
    groups: [&str; 2],
    direction: Option<Vector>,
) -> Result<Overlay, OverlayError> {
    let mut seen = Seen::new(bodies, faces, direction)?;
    seen.snap();
    let found = arrange(&seen.patches).map_err(|fault| seen.fault(fault))?;
    let both = |triangle: &arrangement::Triangle| triangle.faces.iter().all(Option::is_some);
    if !found.triangles.iter().any(both) {
        let points = [0, 1].map(|b: usize| Point::from(seen.mean(b)));
        return Err(OverlayError::NoOverlap { points, direction: seen.axes[0].into() });
    }
    let cuts = [0, 1].map(|b| seen.cut(b, &found));
    let changed = |b: usize| -> Result<Body<Solid>, OverlayError> {
        let (old, (cut, node_of)) = (bodies[b], &cuts[b]);
        let finer =
            with_cut_surface(old.mesh(), cut).map_err(|source| OverlayError::Mesh { body: b, source })?;
        let mut body = old.refined(&finer).map_err(|source| OverlayError::Body { body: b, source })?;
        body.note_inserted(old.mesh().points().len());
        let topology = body.mesh().topology();
        let of = |triangle: &arrangement::Triangle| {
            topology.find_facet(triangle.corners.map(|vertex| node_of[&vertex]))
        };
        let own = found.triangles.iter().filter(|t| both(t)).filter_map(of).collect();
        body.add_group(groups[b], own);
        Ok(body)
    };
    let changed = [changed(0)?, changed(1)?];
    let free = [0, 1].map(|b: usize| {
        let whole = area(bodies[b].mesh(), faces[b]);
        let left = whole - area(changed[b].mesh(), changed[b].mesh().group(groups[b]).unwrap_or(&[]));
        if left > ROUND_OFF * whole { left } else { 0.0 }
    });
    let added = [0, 1].map(|b: usize| changed[b].mesh().points().len() - bodies[b].mesh().points().len());
    let normals = seen.normals(&found, &cuts[0].1)?;
    let in_contact = found.triangles.iter().filter(|t| both(t)).flat_map(|t| t.corners);
    let partner = in_contact.map(|vertex| (cuts[0].1[&vertex], cuts[1].1[&vertex])).collect();
    let measures =
        (0..2).flat_map(|b| faces[b].iter().map(move |face| bodies[b].mesh().facet_measure(*face)));
    let size = (2.0 * measures.fold(0.0, f64::max)).sqrt();
    let snapped = [0, 1].map(|b: usize| seen.sliding[b].moved.len());
    let largest_move = seen.sliding.iter().map(Sliding::farthest).fold(0.0, f64::max);
    let changes = OverlayChanges { added, snapped, largest_move, lowest: found.lowest, free };
    Ok(Overlay { bodies: changed, known: Known { partner, normals, size }, changes })
}

/// Adds up the areas of faces, m².
fn area(mesh: &TetMesh, faces: &[FacetId]) -> f64 {
    faces.iter().map(|face| mesh.facet_measure(*face)).sum()
}

/// The nodes that are inserted into a body, and its node at each vertex of the overlay.
type Cut = (SurfaceCut, HashMap<usize, NodeId>);

impl<'a> Seen<'a> {
    /// Sees two surfaces along a direction.
    fn new(
        bodies: [&'a Body<Solid>; 2],
        faces: [&'a [FacetId]; 2],
        direction: Option<Vector>,
    ) -> Result<Self, OverlayError> {
        let outward = |b: usize| bodies[b].outward_faces(faces[b]);
        let mean = || {
            let flat = plane(bodies[0], faces[0]).or(plane(bodies[1], faces[1]).map(|normal| -normal));
            let across = |[p, q, r]: [Vector; 3]| (q - p).cross(&(r - p));
            flat.unwrap_or_else(|| outward(0).into_iter().map(across).sum())
        };
        let along = direction.unwrap_or_else(mean);
        let along = along / norm(along);
        let least = along.iamin();
        let helper = Vector::from_fn(|k, _| if k == least { 1.0 } else { 0.0 });
        let side = along.cross(&helper);
        let side = side / norm(side);
        let axes = [along, side, along.cross(&side)];
        for b in 0..2 {
            let sign = if b == 0 { 1.0 } else { -1.0 };
            for (face, corners) in faces[b].iter().zip(outward(b)) {
                let cosine = sign * along.dot(&Solid::facet_normal(&corners));
                if !(cosine >= STEEP) {
                    let degrees = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                    let point = bodies[b].mesh().facet_middle(*face).into();
                    return Err(OverlayError::Steep { body: b, point, degrees, direction: along.into() });
                }
            }
        }
        let flat = |point: &Vector| -> Flat { [axes[1].dot(point), axes[2].dot(point)] };
        let nodes = [0, 1].map(|b: usize| {
            let topology = bodies[b].mesh().topology();
            let mut nodes: Vec<NodeId> = faces[b].iter().flat_map(|face| topology.facets()[*face]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        });
        let patches = [0, 1].map(|b: usize| {
            let place: HashMap<NodeId, usize> = nodes[b].iter().copied().zip(0..).collect();
            let mesh = bodies[b].mesh();
            let points = nodes[b].iter().map(|node| flat(&mesh.points()[*node])).collect();
            let corners = |face: &FacetId| mesh.topology().facets()[*face].map(|node| place[&node]);
            Patch { points, faces: faces[b].iter().map(corners).collect() }
        });
        let sliding = [0, 1].map(|b: usize| Sliding::new(bodies[b], faces[b], &nodes[b]));
        Ok(Self { bodies, faces, axes, nodes, sliding, patches })
    }

    /// Slides nodes onto close nodes and edges of the other surface.
    fn snap(&mut self) {
        let Self { axes, nodes, sliding, patches, .. } = self;
        snap(patches, |[b, node], to| sliding[b].slide(nodes[b][node], to, axes));
    }

    /// Returns the mean of the nodes of a surface.
    fn mean(&self, b: usize) -> Vector {
        let points = self.bodies[b].mesh().points();
        self.nodes[b].iter().map(|node| points[*node]).sum::<Vector>() / self.nodes[b].len() as f64
    }

    /// Puts a fault at a point of space: over the mean of the first surface.
    fn fault(&self, fault: Fault) -> OverlayError {
        let [along, side, up] = self.axes;
        let place = |at: Flat| Point::from(at[0] * side + at[1] * up + along.dot(&self.mean(0)) * along);
        match fault {
            Fault::Thin(at, height) => OverlayError::Thin { point: place(at), height },
            Fault::Folded(at) => OverlayError::Folded { point: place(at), direction: along.into() },
        }
    }

    /// Finds the nodes that are inserted into a body, and how they cut its faces.
    fn cut(&self, b: usize, found: &Arrangement) -> Cut {
        let (sliding, nodes) = (&self.sliding[b], &self.nodes[b]);
        let own = |(vertex, of): (usize, &arrangement::Vertex)| of.nodes[b].map(|node| (vertex, nodes[node]));
        let mut node_of: HashMap<usize, NodeId> = found.vertices.iter().enumerate().filter_map(own).collect();
        let (mut points, old) = (Vec::new(), sliding.mesh().points().len());
        let mut node_at = |vertex: usize, at: Vector| {
            *node_of.entry(vertex).or_insert_with(|| {
                points.push(at);
                NodeId::new(old + points.len() - 1)
            })
        };
        let mut edges = BTreeMap::new();
        for chain in found.chains[b].iter().filter(|chain| !chain.on.is_empty()) {
            let ends = chain.ends.map(|node| nodes[node]);
            let [p, q] = ends.map(|node| sliding.place(node));
            let on = chain.on.iter().map(|(t, vertex)| node_at(*vertex, p + *t * (q - p)));
            edges.insert(ends, on.collect());
        }
        let mut faces = BTreeMap::new();
        for (face, parts) in by_face(&found.triangles, b).into_iter().filter(|(_, parts)| parts.len() > 1) {
            let corners = self.patches[b].faces[face];
            let flat = corners.map(|node| self.patches[b].points[node]);
            let corners = corners.map(|node| sliding.place(nodes[node]));
            let mut inside = |vertex: usize| {
                let weights = barycentric(flat, found.vertices[vertex].at);
                node_at(vertex, corners.iter().zip(weights).map(|(corner, weight)| weight * corner).sum())
            };
            let triangles = parts.iter().map(|corners| corners.map(&mut inside)).collect();
            faces.insert(self.faces[b][face], triangles);
        }
        (SurfaceCut { points, moved: sliding.moved.clone(), edges, faces }, node_of)
    }

    /// Computes the normals at the first body's nodes, old and new: those at its old nodes, linear on its faces. None if a surface is flat.
    ///
    /// * `node_of`: its node at each vertex.
    fn normals(
        &self,
        found: &Arrangement,
        node_of: &HashMap<usize, NodeId>,
    ) -> Result<HashMap<NodeId, Vector>, InterfaceError> {
        if !is_curved(self.bodies, self.faces) {
            return Ok(HashMap::new());
        }
        let mut normals = averaged_normals(self.bodies[0], self.faces[0])?;
        let at = |normals: &HashMap<NodeId, Vector>, node: usize| normals[&self.nodes[0][node]];
        for chain in &found.chains[0] {
            for (t, vertex) in &chain.on {
                let [a, b] = chain.ends.map(|node| at(&normals, node));
                normals.insert(node_of[vertex], a + *t * (b - a));
            }
        }
        for (face, parts) in by_face(&found.triangles, 0) {
            let corners = self.patches[0].faces[face];
            let flat = corners.map(|node| self.patches[0].points[node]);
            let at = corners.map(|node| at(&normals, node));
            for vertex in parts.iter().flatten() {
                let weights = barycentric(flat, found.vertices[*vertex].at);
                let mean: Vector = at.iter().zip(weights).map(|(normal, weight)| weight * normal).sum();
                normals.entry(node_of[vertex]).or_insert(mean);
            }
        }
        Ok(normals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::material::LinearElastic;
    use fem_core::mesh::generate::cuboid;

    fn body(z: f64, n: usize, jitter: f64) -> Body<Solid> {
        let mesh = cuboid([0.0, 0.0, z], [1.0; 3], [n; 3]).unwrap();
        let inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
        let face = |x: &Vector| (x[2] - 1.0).abs() < 1e-9 && inside(x[0]) && inside(x[1]);
        let h = jitter / n as f64;
        let move_ = |x: &Vector| {
            let by = Vector::new(
                (13.0 * x[0] + 57.0 * x[1] + z).sin(),
                (41.0 * x[0] - 23.0 * x[1] + z).cos(),
                0.0,
            );
            if face(x) { x + by * h } else { *x }
        };
        let points = mesh.points().iter().map(move_).collect();
        let of = |ids: &[FacetId]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
        let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), of(ids))).collect();
        let mesh = TetMesh::new(points, mesh.cells().to_vec(), groups).unwrap();
        Body::new(
            mesh,
            LinearElastic::isotropic_solid(1.0, 0.3).unwrap(),
            &BoundaryConditions::<Solid>::default(),
        )
        .unwrap()
    }

    /// The heights are those of the meshes here; shifted ones would not be laid over each other without it.
    #[test]
    fn close_nodes_slide_and_bodies_stay_the_same() {
        let all = [([6, 7], 0.0), ([6, 7], 0.2), ([5, 9], 0.2), ([6, 6], 0.1), ([10, 10], 0.05)];
        for (cells, jitter) in all {
            let bodies = [body(1.0, cells[0], jitter), body(0.0, cells[1], jitter)];
            let both = [&bodies[0], &bodies[1]];
            let faces = [both[0].mesh().group("bottom").unwrap(), both[1].mesh().group("top").unwrap()];
            let seen = Seen::new(both, faces, None).unwrap();
            let before = arrange(&seen.patches).map_or(0.0, |found| found.lowest);
            let found = overlay(both, faces, ["contact"; 2], None).unwrap();
            let changes = found.changes;
            assert!(changes.snapped.iter().sum::<usize>() > 0 || jitter == 0.0, "{changes:?}");
            assert!(
                changes.lowest >= 2.0 * before || jitter == 0.0 && changes.lowest == before,
                "{changes:?}"
            );
            assert!(changes.lowest > 5e-3 && changes.largest_move < 0.2 / cells[0] as f64, "{changes:?}");
            for (body, z) in found.bodies.iter().zip([1.0, 0.0]) {
                let mesh = body.mesh();
                let volume: f64 = (0..mesh.cells().len()).map(|cell| mesh.measure(cell)).sum();
                assert!((volume - 1.0).abs() < 1e-12, "{volume}");
                let points = mesh.points();
                assert!(points.iter().all(|x| x[2] >= z - 1e-15 && x[2] <= z + 1.0 + 1e-15), "{cells:?}");
                assert!((area(mesh, mesh.group("contact").unwrap()) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn nodes_between_groups_or_on_supports_stay() {
        let lower = body(0.0, 6, 0.1);
        let top = lower.mesh().group("top").unwrap().to_vec();
        let count = |body: &Body<Solid>| {
            let topology = body.mesh().topology();
            let all: std::collections::BTreeSet<NodeId> =
                top.iter().flat_map(|face| topology.facets()[*face]).collect();
            Sliding::new(body, &top, &all.into_iter().collect::<Vec<_>>()).count()
        };
        assert_eq!(count(&lower), 25);
        let mut halves = lower.clone();
        let half = top.iter().copied().filter(|face| lower.mesh().facet_middle(*face)[0] < 0.5);
        halves.add_group("half", half.collect());
        assert_eq!(count(&halves), 20);
        let conditions = BoundaryConditions::<Solid>::default().roller("half", 0.0);
        let held = Body::new(halves.mesh().clone(), lower.material(0).clone(), &conditions).unwrap();
        assert_eq!(count(&held), 10);
    }
}
