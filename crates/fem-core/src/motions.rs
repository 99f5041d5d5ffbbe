//! The rigid motions that the supports of the bodies leave free.

use crate::assembly::external_forces;
use crate::body::{Body, Piece, RigidMotion};
use crate::geometry::{Coordinates, perpendicular};
use crate::interface::{ContactProblem, LeftOut, Partner};
use crate::mesh::id::FacetId;
use crate::space::{Plane, Space};

/// The load of a motion below this fraction of its terms is the rounding of their sum.
const ROUNDING: f64 = 1e-13;

/// Centres closer than this fraction of the radius of a line are the same.
const SAME_CENTRE: f64 = 1e-6;

/// A rigid motion that the supports of a body leave free, with the load along it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyMotion<S: Space = Plane> {
    /// The body or the obstacle.
    pub partner: Partner,
    /// The motion `R`.
    pub motion: RigidMotion<S>,
    /// `e = f·R`, the work of tractions and body force along the motion, N/m times the motion's unit.
    pub load: f64,
}

impl<S: Space> BodyMotion<S> {
    /// Takes a motion without a load.
    pub fn new(partner: Partner, motion: RigidMotion<S>) -> Self {
        Self { partner, motion, load: 0.0 }
    }
}

/// A rigid motion of an assembly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AssemblyMotion<S: Space = Plane> {
    /// The bodies and obstacles that move, each with its motion; the largest displacement of all is 1 m.
    pub bodies: Vec<(Partner, RigidMotion<S>)>,
    /// The largest displacement of each of them, m.
    pub largest: Vec<f64>,
    /// The load along the motion: its work over its largest displacement, N/m.
    pub load: f64,
}

impl<S: Space> ContactProblem<S> {
    /// Sums up rigid motions to one of the assembly.
    ///
    /// * `motions`: see [`Self::rigid_motions`]; `amounts`: number and amount, by number; `work`: of the loads along their sum, J/m; `least`: bodies
    ///   that move by at most this fraction of the one that moves most do not count.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn assembly_motion(
        &self,
        motions: &[BodyMotion<S>],
        amounts: &[(usize, f64)],
        work: f64,
        least: f64,
    ) -> AssemblyMotion<S> {
        let mut bodies: Vec<BodyMotion<S>> = Vec::new();
        for (number, amount) in amounts {
            let of = &motions[*number];
            let scaled = BodyMotion { motion: of.motion.scaled(*amount), ..*of };
            let mut of_body = bodies.iter_mut().rev().take_while(|known| known.partner == of.partner);
            match of_body.find(|known| known.motion.piece == of.motion.piece) {
                Some(sum) => {
                    sum.motion.translation += scaled.motion.translation;
                    sum.motion.spin += scaled.motion.spin;
                }
                None => bodies.push(scaled),
            }
        }
        let sizes: Vec<f64> = bodies.iter().map(|of| largest(&self.moved_by(of))).collect();
        let most = sizes.iter().copied().fold(0.0, f64::max);
        let moved = bodies.iter().zip(&sizes).filter(|(_, size)| **size > least * most);
        let (bodies, largest) =
            moved.map(|(of, size)| ((of.partner, of.motion.scaled(1.0 / most)), size / most)).unzip();
        AssemblyMotion { bodies, largest, load: work / most }
    }

    /// Lists the rigid motions of all floating bodies and of the obstacles that are free to move, in their order: for each
    /// of them a basis.
    pub fn rigid_motions(&self) -> Vec<BodyMotion<S>> {
        self.rigid_motions_under(&self.bodies.iter().map(external_forces).collect::<Vec<_>>())
    }

    /// * `external_forces`: of each body, N/m.
    pub(crate) fn rigid_motions_under(&self, external_forces: &[Vec<S::Vector>]) -> Vec<BodyMotion<S>> {
        let mut found = Vec::new();
        for (b, body) in self.bodies.iter().enumerate() {
            for motion in body.rigid_motions() {
                let moved = motion.displacements(body);
                let terms = || external_forces[b].iter().zip(&moved).map(|(f, u)| f.times(u));
                let (load, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
                let load = if load.abs() > ROUNDING * size { load } else { 0.0 };
                found.push(BodyMotion { partner: Partner::Body(b), motion, load });
            }
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            let of = |(motion, load)| BodyMotion { partner: Partner::Obstacle(k), motion, load };
            found.extend(obstacle.free_motions().into_iter().map(of));
        }
        found
    }

    /// Computes the displacement of each node in a rigid motion of its body, or of each point of its obstacle, m.
    pub fn moved_by(&self, of: &BodyMotion<S>) -> Vec<S::Vector> {
        match of.partner {
            Partner::Body(body) => of.motion.displacements(&self.bodies[body]),
            Partner::Obstacle(obstacle) => self.obstacles[obstacle].moved_by(&of.motion),
        }
    }
}

impl ContactProblem {
    /// Leaves the loads along some motions out, if each of them is a rotation about the centre of all contact lines of a body that only they hold,
    /// with a load that the error of the polygon explains:
    /// ```math
    /// |e·a| ≤ ∑_i P_i |(n_i − (x_i − c)/R)·R a| + |∫ b·R a|
    /// ```
    /// with the means `n_i` of the polygon's normals, and the integral over what is between the chords and the declared arcs: the load of the body
    /// force that the polygon lacks. `None` if one is not.
    ///
    /// * `motion`: of the assembly; `forces`: `P`, which balance all other loads, by row, N/m.
    pub fn without_spins(&self, motion: &AssemblyMotion, forces: &[f64]) -> Option<Self> {
        let mut without = self.clone();
        for (&(partner, motion), size) in motion.bodies.iter().zip(&motion.largest) {
            let unit = motion.scaled(1.0 / size);
            let body = partner.body()?;
            if !self.is_explained(body, unit, forces) {
                return None;
            }
            without.leave_out(body, unit);
        }
        Some(without)
    }

    /// * `motion`: whose largest displacement is 1 m.
    fn is_explained(&self, body: usize, motion: RigidMotion, forces: &[f64]) -> bool {
        let of = &self.bodies[body];
        if !of.has_no_support() || motion.spin == 0.0 {
            return false;
        }
        let centre = motion.centre + 1.0 / motion.spin * perpendicular(motion.translation);
        let moved = motion.displacements(of);
        let mut allowed = 0.0;
        for (pair, rows) in self.contacts.iter().zip(self.normal_rows()) {
            let Some(side) = pair.side_of(Partner::Body(body)) else { continue };
            let Some(own) = pair.interface.centre() else { return false };
            // The largest displacement is 1 m, at the radius 1/|spin|.
            if !((own - centre).norm() * motion.spin.abs() <= SAME_CENTRE) {
                return false;
            }
            let polygon = pair.interface.polygon_normals(of, side);
            for ((node, polygon), force) in pair.interface.pairs().iter().zip(&polygon).zip(&forces[rows]) {
                allowed += force * (polygon - node.normal).dot(&moved[node.nodes[side]]).abs();
            }
        }
        let load: f64 = external_forces(of).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        load.abs() <= allowed + load_beyond_chords(of, motion).abs()
    }

    /// Leaves the load along a rotation of a body out: a constant traction along its whole boundary, without resultant, balances it.
    fn leave_out(&mut self, body: usize, motion: RigidMotion) {
        let of = &self.bodies[body];
        let (forces, moved) = (external_forces(of), motion.displacements(of));
        let load: f64 = forces.iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        let size: f64 = forces.iter().zip(&moved).map(|(f, u)| f.norm() * u.norm()).sum();
        let area: f64 = (0..of.mesh().cells().len()).map(|t| of.mesh().measure(t)).sum();
        self.bodies[body].turn(-load / (2.0 * area * motion.spin));
        self.left_out.push(LeftOut { body, motion, load, share: load.abs() / size });
    }
}

/// Computes the load along a motion of the body force between the chords of a mesh and the arcs that are declared there, N/m times the unit of the
/// motion. It is negative where an arc takes something away, such as at a hole.
fn load_beyond_chords(body: &Body, motion: RigidMotion) -> f64 {
    let mesh = body.mesh();
    let of_facet = |facet: FacetId| {
        let Some(&Piece::Arc { centre, radius }) = body.curve(facet) else { return 0.0 };
        let [from, to] = mesh.facet_corners(facet);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from).norm());
        let arm = (middle - centre).norm();
        // A segment of a circle: its area, and the distance of its centre of area from the centre of the circle.
        let (angle, sine) = (2.0 * (half / radius).asin(), half / radius);
        let part = angle - angle.sin();
        if !(part > 0.0 && arm > 0.0) {
            return 0.0;
        }
        let distance = 4.0 * radius * sine.powi(3) / (3.0 * part);
        let out = 1.0 / arm * (middle - centre);
        let at = middle + (distance - radius * (0.5 * angle).cos()) * out;
        let area = 0.5 * radius * radius * part * mesh.facet_normal(facet).dot(&out).signum();
        area * body.body_force().dot(&motion.at(at))
    };
    mesh.topology().boundary_facets().iter().map(|facet| of_facet(*facet)).sum()
}

/// Returns the largest displacement, m.
pub(crate) fn largest<V: Coordinates>(moved: &[V]) -> f64 {
    moved.iter().map(|u| u.times(u).sqrt()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{CurveKind, CurvedSide};
    use crate::boundary::BoundaryConditions;
    use crate::geometry::Vector;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::TriMesh;

    #[test]
    fn the_body_force_on_a_disc_has_no_moment_about_its_centre_though_that_on_its_polygon_has() {
        let (centre, radius, force) = (Vector::new(0.3, -0.2), 2.0, Vector::new(-1.0, 0.5));
        // Edges of 6 to 30 degrees.
        let angles: Vec<f64> = (0..20).map(|k| f64::from(k) * 18.0 + 6.0 * f64::from(k * k % 3)).collect();
        let on_rim =
            |angle: &f64| centre + radius * Vector::new(angle.to_radians().cos(), angle.to_radians().sin());
        let points: Vec<Vector> = std::iter::once(centre).chain(angles.iter().map(on_rim)).collect();
        let edges: Vec<[u32; 2]> = (1..=20).map(|k| [k, k % 20 + 1]).collect();
        let cells: Vec<[u32; 3]> = edges.iter().map(|[a, b]| [0, *a, *b]).collect();
        let mesh = TriMesh::new(points, cells, vec![("rim".to_owned(), edges)]).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = Body::new(mesh, steel, &BoundaryConditions::new().body_force(force)).unwrap();
        let body = body.with_curves(&[CurvedSide { on: "rim".into(), kind: CurveKind::Arc }]).unwrap();
        let motion = RigidMotion { piece: 0, translation: Vector::ZERO, spin: 1.0 / radius, centre };
        let moved = motion.displacements(&body);
        let load: f64 = external_forces(&body).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        let beyond = load_beyond_chords(&body, motion);
        assert!(load.abs() > 1e-3 && (load + beyond).abs() < 1e-13, "{load} {beyond}");
        // The whole disc is pushed along.
        let along = RigidMotion { translation: force, spin: 0.0, ..motion };
        let area: f64 = (0..20).map(|t| body.mesh().measure(t)).sum();
        let lacks = std::f64::consts::PI * radius * radius - area;
        assert!((load_beyond_chords(&body, along) - 1.25 * lacks).abs() < 1e-12);
    }
}
