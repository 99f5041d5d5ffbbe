//! Evaluates boundary conditions on a mesh: nodal constraints and edge tractions.

use super::interpolation::{gauss_points, linear_by_moments};
use super::{
    Body, BodyError, ConditionList, ConditionPlace, EdgeCondition, EdgeReaction, NodeConstraint, SupportSet,
};
use crate::boundary::{BoundaryConditions, EdgeSelection, Load, ScalarData, Support};
use crate::geometry::{self, Vector, cross, dot, scale};
use crate::material::Materials;
use crate::mesh::TriMesh;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Two directions closer than this (sine of the angle) are the same one.
const SAME_DIRECTION: f64 = 1e-9;

/// Values that differ by less, relative to the largest that their conditions impose, are the same one.
const SAME_VALUE: f64 = 1e-12;

/// Rollers on neighbouring edges whose normals differ by no more hold a node along their mean; by more, they fix it.
const SMOOTH: f64 = 30.0;

/// The edges that each condition applies to, in the order of the conditions.
#[derive(Clone, Debug, Default)]
pub(super) struct Selected {
    pub(super) displacements: Vec<Vec<u32>>,
    pub(super) tractions: Vec<Vec<u32>>,
}

/// Evaluates conditions on a mesh, on the edges they select or on those `inherited` from a coarser mesh.
pub(super) fn evaluate(
    mesh: TriMesh,
    materials: Materials,
    conditions: &BoundaryConditions,
    inherited: Option<Selected>,
) -> Result<Body, BodyError> {
    let triangles = mesh.triangles().len();
    if !materials.fit(triangles) {
        return Err(BodyError::Materials { cells: materials.len(), triangles });
    }
    let force = conditions.body_force;
    if !(force[0].is_finite() && force[1].is_finite()) {
        return Err(BodyError::BodyForce { force });
    }
    let mut work = Evaluation {
        constraints: vec![NodeConstraint::Free; mesh.points().len()],
        magnitudes: vec![0.0; mesh.points().len()],
        turned: Vec::new(),
        edges: vec![
            EdgeCondition { reaction: EdgeReaction::None, traction: [[0.0; 2]; 2] };
            mesh.topology().boundary_edges().len()
        ],
        mesh: &mesh,
    };
    let inherited = inherited.as_ref();
    let (displacements, supports) = work.impose_all(conditions, inherited)?;
    let tractions = work.load_all(conditions, inherited)?;
    let selected = Selected { displacements, tractions };
    let roller_turn = work.roller_turn();
    let (node_constraints, edge_conditions) = (work.constraints, work.edges);
    let conditions = conditions.clone();
    let free_motion = OnceLock::new();
    Ok(Body {
        mesh,
        materials,
        node_constraints,
        edge_conditions,
        supports,
        roller_turn,
        conditions,
        selected,
        free_motion,
    })
}

struct Evaluation<'a> {
    mesh: &'a TriMesh,
    constraints: Vec<NodeConstraint>,
    /// How large the data are that hold each node, m: what their round-off is measured by.
    magnitudes: Vec<f64>,
    edges: Vec<EdgeCondition>,
    turned: Vec<Turned>,
}

/// A node on a bent roller, held in another direction than the normal of one of its edges.
struct Turned {
    node: u32,
    /// The edge's normal, and what is imposed along it.
    normal: Vector,
    value: f64,
    /// Sine of the angle between the two.
    sine: f64,
}

/// A datum and the direction in which it holds the nodes of an edge.
struct Imposed<'a> {
    direction: Vector,
    data: &'a ScalarData,
    /// Largest absolute value at the nodes of the condition's edges, m.
    magnitude: f64,
}

impl Evaluation<'_> {
    /// Imposes all displacement conditions; returns the edges of each, and what it holds.
    fn impose_all(
        &mut self,
        conditions: &BoundaryConditions,
        inherited: Option<&Selected>,
    ) -> Result<(Vec<Vec<u32>>, Vec<SupportSet>), BodyError> {
        let (mut selected, mut supports) = (Vec::new(), Vec::new());
        for (index, condition) in conditions.displacements.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Displacement, index };
            let edges = match inherited {
                Some(known) => known.displacements[index].clone(),
                None => self.select(place, &condition.edges)?,
            };
            let nodes = self.impose(place, &edges, &condition.support)?;
            selected.push(edges);
            let components = match &condition.support {
                Support::Components(values) => [values[0].is_some(), values[1].is_some()],
                Support::Normal(_) => [true; 2],
            };
            supports.push(SupportSet { group: condition.edges.on.clone(), nodes, components });
        }
        Ok((selected, supports))
    }

    /// Applies all loads; returns the edges of each.
    fn load_all(
        &mut self,
        conditions: &BoundaryConditions,
        inherited: Option<&Selected>,
    ) -> Result<Vec<Vec<u32>>, BodyError> {
        let mut selected = Vec::new();
        for (index, condition) in conditions.tractions.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Traction, index };
            let edges = match inherited {
                Some(known) => known.tractions[index].clone(),
                None => self.select(place, &condition.edges)?,
            };
            self.load(place, &edges, &condition.load)?;
            selected.push(edges);
        }
        Ok(selected)
    }

    /// Selects boundary edges.
    fn select(&self, place: ConditionPlace, selection: &EdgeSelection) -> Result<Vec<u32>, BodyError> {
        let group = selection.on.clone();
        let Some(edges) = self.mesh.group(&group) else {
            let names: Vec<&str> = self.mesh.groups().keys().map(String::as_str).collect();
            return Err(BodyError::UnknownGroup { place, group, known: names.join(", ") });
        };
        let points = self.mesh.points();
        let tolerance = 1e-9 * geometry::diagonal(points);
        let inside = |p: Vector| {
            selection.part.is_none_or(|part| {
                (0..2).all(|c| p[c] >= part[c][0] - tolerance && p[c] <= part[c][1] + tolerance)
            })
        };
        let mut selected = Vec::new();
        for &edge in edges {
            let ends = self.mesh.topology().edges()[edge as usize].map(|n| points[n as usize]);
            if !ends.into_iter().all(inside) {
                continue;
            }
            if !self.mesh.topology().is_boundary(edge) {
                return Err(BodyError::InteriorEdge { place, group, ends });
            }
            selected.push(edge);
        }
        if selected.is_empty() { Err(BodyError::EmptySelection { place, group }) } else { Ok(selected) }
    }

    /// Pairs boundary edges with their places among the boundary edges.
    fn places<'s>(&'s self, edges: &'s [u32]) -> impl Iterator<Item = (u32, usize)> + use<'s> {
        let boundary = self.mesh.topology().boundary_edges();
        edges.iter().filter_map(|&edge| Some((edge, boundary.binary_search(&edge).ok()?)))
    }

    fn impose(
        &mut self,
        place: ConditionPlace,
        edges: &[u32],
        support: &Support,
    ) -> Result<Vec<u32>, BodyError> {
        let mut nodes = Vec::new();
        let rollers = match support {
            Support::Normal(_) => self.roller_normals(edges),
            Support::Components(_) => HashMap::new(),
        };
        let magnitude = |data: &ScalarData| {
            let all = edges.iter().flat_map(|&e| self.mesh.topology().edges()[e as usize]);
            all.fold(0.0f64, |largest, n| largest.max(data.at(self.mesh.points()[n as usize]).abs()))
        };
        let magnitudes = match support {
            Support::Normal(data) => [Some((data, magnitude(data))); 2],
            Support::Components(all) => all.each_ref().map(|d| d.as_ref().map(|d| (d, magnitude(d)))),
        };
        let axes = [[1.0, 0.0], [0.0, 1.0]];
        for (edge, position) in self.places(edges).collect::<Vec<_>>() {
            let normal = self.mesh.edge_normal(edge);
            let directions: &[Vector] = if matches!(support, Support::Normal(_)) { &[normal] } else { &axes };
            for (&direction, known) in directions.iter().zip(magnitudes) {
                let Some((data, magnitude)) = known else { continue };
                let reaction = &mut self.edges[position].reaction;
                *reaction = add_reaction(*reaction, direction);
                for node in self.mesh.topology().edges()[edge as usize] {
                    let held = rollers.get(&node).map_or(direction, |all| mean_normal(all, direction));
                    let value = self.constrain(place, node, &Imposed { direction: held, data, magnitude })?;
                    let sine = cross(held, direction).abs();
                    if sine > 0.0 {
                        self.turned.push(Turned { node, normal: direction, value, sine });
                    }
                    nodes.push(node);
                }
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Lists the normals of a roller's edges at each of their nodes, times the edges' lengths.
    fn roller_normals(&self, edges: &[u32]) -> HashMap<u32, Vec<Vector>> {
        let mut normals: HashMap<u32, Vec<Vector>> = HashMap::new();
        for &edge in edges {
            let weighted = scale(self.mesh.edge_length(edge), self.mesh.edge_normal(edge));
            for node in self.mesh.topology().edges()[edge as usize] {
                normals.entry(node).or_default().push(weighted);
            }
        }
        normals
    }

    /// Holds a node, and returns the value imposed.
    fn constrain(
        &mut self,
        place: ConditionPlace,
        node: u32,
        imposed: &Imposed<'_>,
    ) -> Result<f64, BodyError> {
        let (point, direction) = (self.mesh.points()[node as usize], imposed.direction);
        let value = finite(place, point, imposed.data.at(point))?;
        let magnitude = &mut self.magnitudes[node as usize];
        *magnitude = magnitude.max(imposed.magnitude);
        let agree = |known: f64, magnitude: f64| {
            let close = (known - value).abs() <= SAME_VALUE * magnitude;
            if close { Ok(value) } else { Err(BodyError::Conflict { place, point, values: [known, value] }) }
        };
        let constraint = &mut self.constraints[node as usize];
        match *constraint {
            NodeConstraint::Free => *constraint = NodeConstraint::Along { direction, value },
            NodeConstraint::Along { direction: d, value: v } => {
                let sine = cross(d, direction);
                if sine.abs() <= SAME_DIRECTION {
                    return agree(v * dot(d, direction).signum(), *magnitude);
                }
                // Solve d·u = v, direction·u = value: round-off grows as the directions come near each other.
                let u = [(v * direction[1] - value * d[1]) / sine, (d[0] * value - direction[0] * v) / sine];
                *constraint = NodeConstraint::Fixed { value: u };
                *magnitude /= sine.abs();
            }
            NodeConstraint::Fixed { value: u } => return agree(dot(u, direction), *magnitude),
        }
        Ok(value)
    }

    /// Computes [`Body::roller_turn`] when all conditions are imposed.
    fn roller_turn(&self) -> f64 {
        let violates = |t: &&Turned| match self.constraints[t.node as usize] {
            NodeConstraint::Fixed { value: u } => {
                (dot(u, t.normal) - t.value).abs() > SAME_VALUE * self.magnitudes[t.node as usize]
            }
            _ => true,
        };
        self.turned.iter().filter(violates).fold(0.0, |largest, t| largest.max(t.sine))
    }

    fn load(&mut self, place: ConditionPlace, edges: &[u32], load: &Load) -> Result<(), BodyError> {
        for (edge, position) in self.places(edges).collect::<Vec<_>>() {
            let traction = self.edge_traction(place, edge, load)?;
            let condition = &mut self.edges[position];
            let blocked = match condition.reaction {
                EdgeReaction::None => false,
                EdgeReaction::Along(d) => {
                    traction.iter().any(|&t| dot(t, d).abs() > SAME_DIRECTION * geometry::norm(t))
                }
                EdgeReaction::Both => traction.iter().any(|&t| t != [0.0; 2]),
            };
            if blocked {
                let ends =
                    self.mesh.topology().edges()[edge as usize].map(|n| self.mesh.points()[n as usize]);
                let point = scale(0.5, geometry::add(ends[0], ends[1]));
                return Err(BodyError::LoadOnSupport { place, point });
            }
            for (total, t) in condition.traction.iter_mut().zip(traction) {
                let along = match condition.reaction {
                    EdgeReaction::Along(d) => scale(dot(t, d), d),
                    _ => [0.0; 2],
                };
                *total = geometry::add(*total, geometry::sub(t, along));
            }
        }
        Ok(())
    }

    /// Computes the linear traction with the moments of the given one.
    fn edge_traction(&self, place: ConditionPlace, edge: u32, load: &Load) -> Result<[Vector; 2], BodyError> {
        let ends = self.mesh.topology().edges()[edge as usize].map(|n| self.mesh.points()[n as usize]);
        let normal = self.mesh.edge_normal(edge);
        let constant = match load {
            Load::Vector([x, y]) => x.constant().zip(y.constant()).map(|(x, y)| [x, y]),
            Load::Pressure(q) => q.constant().map(|q| scale(-q, normal)),
        };
        if let Some(t) = constant {
            finite(place, ends[0], t[0])?;
            finite(place, ends[0], t[1])?;
            return Ok([t, t]);
        }
        let at = |point: Vector| {
            let t = match load {
                Load::Vector([x, y]) => [x.at(point), y.at(point)],
                Load::Pressure(q) => scale(-q.at(point), normal),
            };
            finite(place, point, t[0])?;
            finite(place, point, t[1])?;
            Ok(t)
        };
        // The quadrature has no point at the nodes, where a singular load must not pass unseen.
        at(ends[0])?;
        at(ends[1])?;
        let mut values = [[0.0; 5]; 2];
        for (k, point) in gauss_points(ends).into_iter().enumerate() {
            let t = at(point)?;
            (values[0][k], values[1][k]) = (t[0], t[1]);
        }
        let [x, y] = values.map(linear_by_moments);
        Ok([[x[0], y[0]], [x[1], y[1]]])
    }
}

/// The mean of those weighted normals that are within [`SMOOTH`] of the edge's own; that one itself on a straight side.
fn mean_normal(all: &[Vector], own: Vector) -> Vector {
    let near = all.iter().filter(|n| dot(**n, own) >= SMOOTH.to_radians().cos() * geometry::norm(**n));
    let mean = near.fold([0.0; 2], |sum, n| geometry::add(sum, *n));
    let mean = scale(1.0 / geometry::norm(mean), mean);
    if cross(mean, own).abs() <= SAME_DIRECTION { own } else { mean }
}

fn finite(place: ConditionPlace, point: Vector, value: f64) -> Result<f64, BodyError> {
    if value.is_finite() { Ok(value) } else { Err(BodyError::NotFinite { place, point, value }) }
}

fn add_reaction(present: EdgeReaction, direction: Vector) -> EdgeReaction {
    match present {
        EdgeReaction::None => EdgeReaction::Along(direction),
        EdgeReaction::Along(d) if cross(d, direction).abs() <= SAME_DIRECTION => present,
        _ => EdgeReaction::Both,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    fn body(conditions: &BoundaryConditions) -> Result<Body, BodyError> {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        Body::new(mesh, LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap(), conditions)
    }

    #[test]
    fn two_imposed_components_fix_a_corner() {
        let b =
            body(&BoundaryConditions::new().displace("left", Some(0.5.into()), None).roller("bottom", -0.25))
                .unwrap();
        assert_eq!(b.node_constraints()[0], NodeConstraint::Fixed { value: [0.5, 0.25] });
        assert!(matches!(b.node_constraints()[1], NodeConstraint::Along { .. }));
        assert_eq!(b.node_constraints()[9], NodeConstraint::Free);
        assert_eq!(b.supports()[0].nodes.len(), 3);
    }

    #[test]
    fn data_that_meet_at_zero_to_round_off_agree() {
        let sine =
            |size: f64| ScalarData::function(move |x| size * (std::f64::consts::PI * x[0] / 2.0).sin());
        // sin π is 1e-16.
        let held = |top, right: f64| {
            let base = BoundaryConditions::new();
            body(&base.displace("top", None, Some(top)).displace("right", None, Some(right.into())))
        };
        assert!(held(sine(0.01), 0.0).is_ok());
        assert!(matches!(held(sine(0.01), 1e-13), Err(BodyError::Conflict { .. })));
        // A third direction at a corner that two conditions fix.
        let corner = BoundaryConditions::new().displace("left", Some(0.3.into()), Some(sine(1.0))).displace(
            "bottom",
            Some(0.3.into()),
            Some(0.0.into()),
        );
        assert!(body(&corner).is_ok());
    }

    #[test]
    fn linear_tractions_are_exact_and_pressure_pushes() {
        let linear = ScalarData::function(|x| 3.0 * x[0] - 1.0);
        let b =
            body(&BoundaryConditions::new().pressure("top", 2.0).traction("bottom", [linear, 0.0.into()]))
                .unwrap();
        for &e in b.mesh().group("top").unwrap() {
            assert_eq!(b.edge_condition(e).unwrap().traction, [[0.0, -2.0]; 2]);
        }
        for &e in b.mesh().group("bottom").unwrap() {
            let nodes = b.mesh().topology().edges()[e as usize];
            for (n, t) in nodes.iter().zip(b.edge_condition(e).unwrap().traction) {
                assert!((t[0] - (3.0 * b.mesh().points()[*n as usize][0] - 1.0)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn contradictions_are_refused() {
        let base = BoundaryConditions::new;
        let conflict =
            base().displace("left", Some(0.0.into()), None).displace("bottom", Some(0.1.into()), None);
        assert!(matches!(body(&conflict), Err(BodyError::Conflict { .. })));
        let loaded = base().displace("top", None, Some(0.0.into())).pressure("top", 1.0);
        assert!(matches!(body(&loaded), Err(BodyError::LoadOnSupport { .. })));
        let shear = base().displace("top", None, Some(0.0.into())).traction("top", [1.0.into(), 0.0.into()]);
        assert!(body(&shear).is_ok());
        assert!(matches!(body(&base().fix("botom")), Err(BodyError::UnknownGroup { .. })));
        assert!(matches!(body(&base().pressure("top", f64::NAN)), Err(BodyError::NotFinite { .. })));
        let part = EdgeSelection::group("top").within([[5.0, 6.0], [0.0, 2.0]]);
        assert!(matches!(body(&base().fix(part)), Err(BodyError::EmptySelection { .. })));
    }

    /// A fan of three edges that turn by 20 and 80 degrees, all on a roller.
    #[test]
    fn rollers_hold_the_mean_normal_where_a_side_is_smooth_and_fix_its_corners() {
        let angles = [0.0f64, 20.0, 100.0];
        let mut points = vec![[0.0, 0.0]];
        for a in angles {
            let (sine, cosine) = a.to_radians().sin_cos();
            let last: Vector = points[points.len() - 1];
            points.push([last[0] + cosine, last[1] + sine]);
        }
        let centre = points.len() as u32;
        points.push([0.5, 2.0]);
        let triangles = (0..3).map(|k| [k, k + 1, centre]).collect();
        let groups = vec![("side".to_string(), (0..3).map(|k| [k, k + 1]).collect())];
        let mesh = TriMesh::new(points, triangles, groups).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = Body::new(mesh, steel, &BoundaryConditions::new().roller("side", 0.5)).unwrap();
        let mean = 10.0f64.to_radians();
        match body.node_constraints()[1] {
            NodeConstraint::Along { direction, value } => {
                assert!(
                    (direction[0] - mean.sin()).abs() < 1e-15 && (direction[1] + mean.cos()).abs() < 1e-15
                );
                assert_eq!(value, 0.5);
            }
            other => panic!("{other:?}"),
        }
        assert!(matches!(body.node_constraints()[2], NodeConstraint::Fixed { .. }));
        assert!(matches!(body.node_constraints()[0], NodeConstraint::Along { direction: [_, -1.0], .. }));
        // The bound does not hold where the direction held is not the edge's own.
        assert!((body.roller_turn() - mean.sin()).abs() < 1e-15);
    }

    /// Two edges that turn by 20 degrees, on a roller; a wall of two edges at a right angle beside it.
    #[test]
    fn a_bent_roller_whose_nodes_are_fixed_besides_still_shows() {
        let (sine, cosine) = 20.0f64.to_radians().sin_cos();
        let points = vec![[0.0, 0.0], [1.0, 0.0], [1.0 + cosine, sine], [0.5, 2.0]];
        let groups = vec![
            ("side".to_string(), vec![[0, 1], [1, 2]]),
            ("first".to_string(), vec![[0, 1]]),
            ("second".to_string(), vec![[1, 2]]),
        ];
        let mesh = TriMesh::new(points, vec![[0, 1, 3], [1, 2, 3]], groups).unwrap();
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let turn = |conditions: BoundaryConditions| {
            Body::new(mesh.clone(), steel.clone(), &conditions).unwrap().roller_turn()
        };
        let roller = |value: f64| BoundaryConditions::new().roller("side", value);
        let half = 10.0f64.to_radians().sin();
        assert!((turn(roller(0.5).displace("first", Some(0.0.into()), None)) - half).abs() < 1e-15);
        // Held at rest, the middle node agrees with the normals of both edges.
        assert_eq!(turn(roller(0.0).displace("side", Some(0.0.into()), None)), 0.0);
        // Two rollers, each along a straight side: the corner between them agrees with both.
        assert_eq!(turn(BoundaryConditions::new().roller("first", 0.5).roller("second", 0.2)), 0.0);
    }

    #[test]
    fn a_part_selects_edges_by_both_ends() {
        let part = EdgeSelection::group("top").within([[0.0, 1.1], [f64::NEG_INFINITY, f64::INFINITY]]);
        let b = body(&BoundaryConditions::new().fix(part)).unwrap();
        assert_eq!(b.supports()[0].nodes.len(), 3);
    }
}
