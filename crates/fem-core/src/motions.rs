//! The rigid motions that the supports of the bodies leave free.

use crate::assembly::external_forces;
use crate::body::{Body, FacetCondition, Piece, RigidMotion, arms};
use crate::geometry::{Coordinates, Vector, perpendicular};
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
    /// |e·a + ∫ b·R a + ∫ t·R a| ≤ |∑_i P_i (n_i − (x_i − c)/R)·R a|
    /// ```
    /// with the means `n_i` of the polygon's normals, body force and tractions on what is between the chords and the declared arcs, and so on the left
    /// the load of the declared shape. `None` if one is not.
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
        let mut of_polygon = 0.0;
        for (pair, rows) in self.contacts.iter().zip(self.normal_rows()) {
            let Some(side) = pair.side_of(Partner::Body(body)) else { continue };
            if pair.is_within_a_body() {
                return false;
            }
            let Some(own) = pair.interface.centre() else { return false };
            // The largest displacement is 1 m, at the radius 1/|spin|.
            if !((own - centre).norm() * motion.spin.abs() <= SAME_CENTRE) {
                return false;
            }
            let polygon = pair.interface.polygon_normals(of, side);
            for ((node, polygon), force) in pair.interface.pairs().iter().zip(&polygon).zip(&forces[rows]) {
                of_polygon += force * (polygon - node.normal).dot(&moved[node.nodes[side]]);
            }
        }
        let terms = || external_forces(of).into_iter().zip(&moved).map(|(f, u)| f.dot(u));
        let load = terms().sum::<f64>() + load_beyond_chords(of, motion);
        load.abs() <= of_polygon.abs() + ROUNDING * terms().map(f64::abs).sum::<f64>()
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

/// Computes what the loads on the arcs of a body do along a motion beyond those on its chords, N/m times the unit of the motion.
fn load_beyond_chords(body: &Body, motion: RigidMotion) -> f64 {
    let of_facet = |(condition, facet): (&FacetCondition, &FacetId)| {
        let Some(&Piece::Arc { centre, radius }) = body.curve(*facet) else { return 0.0 };
        let Some(segment) = Segment::new(body, *facet, centre, radius) else { return 0.0 };
        let (cell, middle) =
            (body.mesh().topology().facet_cells()[*facet][0] as usize, segment.centre_of_area());
        let corners = body.mesh().corners(cell);
        let force = body.force(cell).at(middle - corners[0] + arms::<Plane>(&corners)[0]);
        segment.area * force.dot(&motion.at(middle))
            + segment.traction_beyond_chord(&condition.traction, motion)
    };
    let facets = body.mesh().topology().boundary_facets();
    body.facet_conditions().iter().zip(facets).map(of_facet).sum()
}

/// The segment of a circle between a chord and its arc.
struct Segment {
    centre: Vector,
    radius: f64,
    /// Half the angle of the arc.
    angle: f64,
    /// Unit vectors from the centre to the middle of the chord, and along the chord.
    axes: [Vector; 2],
    /// It is negative where the arc takes something away, such as at a hole.
    area: f64,
}

impl Segment {
    /// Returns `None` if the arc is straight to rounding, or half a circle.
    fn new(body: &Body, facet: FacetId, centre: Vector, radius: f64) -> Option<Self> {
        let [from, to] = body.mesh().facet_corners(facet);
        let [arm, along] = [0.5 * (from + to) - centre, 0.5 * (to - from)];
        let angle = (along.norm() / radius).asin();
        let part = 2.0 * angle - (2.0 * angle).sin();
        let axes = [1.0 / arm.norm() * arm, 1.0 / along.norm() * along];
        let side = body.mesh().facet_normal(facet).dot(&axes[0]).signum();
        let area = 0.5 * radius * radius * part * side;
        (part > 0.0 && arm.norm() > 0.0).then_some(Self { centre, radius, angle, axes, area })
    }

    fn centre_of_area(&self) -> Vector {
        let distance = 2.0 * (self.radius * self.angle.sin()).powi(3) / (3.0 * self.area.abs());
        self.centre + distance * self.axes[0]
    }

    /// Computes `∫ t·R` over the arc less that over the chord.
    ///
    /// * `traction`: at both ends; it is linear in the angle and along the chord.
    fn traction_beyond_chord(&self, traction: &[Vector; 2], motion: RigidMotion) -> f64 {
        let Self { centre, radius, angle, axes: [out, along], .. } = *self;
        let [mean, half] = [0.5 * (traction[0] + traction[1]), 0.5 * (traction[1] - traction[0])];
        let (sine, cosine) = angle.sin_cos();
        let turned = |v: Vector| motion.spin * radius * radius * perpendicular(v);
        // The integrals of 1, of the cosine and of the angle times the sine over the arc, less those over the chord.
        mean.dot(&motion.at(centre)) * 2.0 * radius * (angle - sine)
            + mean.dot(&turned(out)) * 2.0 * sine * (1.0 - cosine)
            + half.dot(&turned(along)) * (2.0 / angle * (sine - angle * cosine) - 2.0 / 3.0 * sine * sine)
    }
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
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::TriMesh;

    const CENTRE: Vector = Vector::new(0.3, -0.2);
    const RADIUS: f64 = 2.0;
    const FORCE: Vector = Vector::new(-1.0, 0.5);
    const SPIN: RigidMotion =
        RigidMotion { piece: 0, translation: Vector::ZERO, spin: 1.0 / RADIUS, centre: CENTRE };

    /// A polygon of 20 edges of 6 to 30 degrees whose rim is declared as a circle.
    fn disc(loads: &BoundaryConditions) -> Body {
        let angles: Vec<f64> = (0..20).map(|k| f64::from(k) * 18.0 + 6.0 * f64::from(k * k % 3)).collect();
        let on_rim =
            |angle: &f64| CENTRE + RADIUS * Vector::new(angle.to_radians().cos(), angle.to_radians().sin());
        let points: Vec<Vector> = std::iter::once(CENTRE).chain(angles.iter().map(on_rim)).collect();
        let edges: Vec<[u32; 2]> = (1..=20).map(|k| [k, k % 20 + 1]).collect();
        let cells: Vec<[u32; 3]> = edges.iter().map(|[a, b]| [0, *a, *b]).collect();
        let mesh = TriMesh::new(points, cells, vec![("rim".to_owned(), edges)]).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = Body::new(mesh, steel, loads).unwrap();
        body.with_curves(&[CurvedSide { on: "rim".into(), kind: CurveKind::Arc }]).unwrap()
    }

    /// Returns the load of the polygon along a motion, and what the disc adds.
    fn load(body: &Body, motion: RigidMotion) -> [f64; 2] {
        let moved = motion.displacements(body);
        let load = external_forces(body).iter().zip(&moved).map(|(f, u)| f.dot(u)).sum();
        [load, load_beyond_chords(body, motion)]
    }

    #[test]
    fn loads_on_a_disc_have_no_moment_about_its_centre_though_those_on_its_polygon_have() {
        let [x, y] = [FORCE[0], FORCE[1]];
        let weight = disc(&BoundaryConditions::new().body_force(FORCE));
        let wind = disc(&BoundaryConditions::new().traction("rim", [x.into(), y.into()]));
        // Both loads of the whole disc along the force.
        let along = RigidMotion { translation: FORCE, spin: 0.0, ..SPIN };
        let pi = std::f64::consts::PI;
        for (body, size) in [(weight, pi * RADIUS * RADIUS), (wind, 2.0 * pi * RADIUS)] {
            let [polygon, beyond] = load(&body, SPIN);
            assert!(polygon.abs() > 1e-3 && (polygon + beyond).abs() < 1e-13, "{polygon} {beyond}");
            let [polygon, beyond] = load(&body, along);
            assert!((polygon + beyond - size * FORCE.dot(&FORCE)).abs() < 1e-12, "{polygon} {beyond}");
        }
    }

    #[test]
    fn a_traction_that_changes_along_an_arc_is_integrated_there() {
        let body = disc(&BoundaryConditions::new());
        let facet = body.mesh().topology().boundary_facets()[3];
        let segment = Segment::new(&body, facet, CENTRE, RADIUS).unwrap();
        let traction = [Vector::new(1.0, -2.0), Vector::new(0.5, 3.0)];
        let motion = RigidMotion { translation: Vector::new(0.4, 0.1), centre: Vector::ZERO, ..SPIN };
        let [from, to] = body.mesh().facet_corners(facet);
        let mut expected = 0.0;
        const PARTS: usize = 10_000;
        for k in 0..PARTS {
            let part = (k as f64 + 0.5) / PARTS as f64;
            let pulled = (1.0 - part) * traction[0] + part * traction[1];
            let (sine, cosine) = (segment.angle * (2.0 * part - 1.0)).sin_cos();
            let on_arc = CENTRE + RADIUS * (cosine * segment.axes[0] + sine * segment.axes[1]);
            let on_chord = (1.0 - part) * from + part * to;
            expected += pulled.dot(&motion.at(on_arc)) * 2.0 * RADIUS * segment.angle
                - pulled.dot(&motion.at(on_chord)) * (to - from).norm();
        }
        let found = segment.traction_beyond_chord(&traction, motion);
        assert!((found - expected / PARTS as f64).abs() < 1e-8 && found.abs() > 1e-4, "{found} {expected}");
    }
}
