//! The contact problem of a drawn assembly, on its own mesh or on halved cells.

use super::grid::{Cells, Grid, Patch, SIDES, prolonged};
use crate::model::Made;
use crate::random::Random;
use contact_geometry::{Contact, ContactNormal, Sides, paired_solids};
use fem_core::body::{Body, DeclaredSurface, SurfaceKind};
use fem_core::boundary::{
    BoundaryConditions, CutLoad, RigidCondition, ScalarData, SpringDirection, SpringRest,
};
use fem_core::interface::{
    ClampedCorner, ClampedPair, ContactFacet, ContactInterface, ContactProblem, Friction, Gap, NodePair,
    Obstacle, RigidLine, SAME_NORMAL,
};
use fem_core::material::{LinearElastic, Materials};
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Solid;
use nalgebra::{Rotation3, Vector3};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A linear function: finer meshes have the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    pub(super) middle: f64,
    pub(super) slope: Vector3<f64>,
    /// The point with the value `middle`, m.
    pub(super) about: Vector3<f64>,
}

impl Linear {
    pub(super) fn constant(value: f64) -> Self {
        Self { middle: value, slope: Vector3::zeros(), about: Vector3::zeros() }
    }

    fn at(&self, x: Vector3<f64>) -> f64 {
        self.middle + self.slope.dot(&(x - self.about))
    }
}

/// A rigid sphere or cylinder, in axes of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    pub(super) centre: Vector3<f64>,
    /// Of a cylinder.
    pub(super) axis: Option<Vector3<f64>>,
    pub(super) radius: f64,
    pub(super) inside: bool,
    /// The given gap; `None`: the distance.
    pub(super) gap: Option<Linear>,
}

/// How a plane moves.
#[derive(Clone, Copy, Debug)]
pub(super) enum Drive {
    /// Into the body, m; 0 for a fixed plane.
    Moved(f64),
    /// By a force into the body at a point of the side, N: it moves and tilts.
    Force(f64, Vector3<f64>),
}

/// What is imposed on the free part of a side.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition {
    Free,
    Fixed,
    Roller(Linear),
    Imposed([Linear; 3]),
    Pressure(Linear),
    Traction([Linear; 3]),
    /// Imposed motions, and the force and the moment along the others, in axes of the grid; with a turn all are imposed or all are free.
    Rigid([Option<f64>; 6], Vector3<f64>, Vector3<f64>),
    /// Springs: stiffness, Pa/m, directions in axes of the grid, and the displacement at which they are relaxed.
    Springs(f64, SpringDirection<Solid>, [Linear; 3]),
    /// A rigid plane along the side, with a gap.
    Plane(Linear, Drive),
    /// A rigid sphere or cylinder.
    Round(Round, Drive),
}

/// A body.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) cells: Cells,
    pub(super) materials: Vec<LinearElastic<Solid>>,
    /// An axis and a plane of the grid: cells behind it are of the second material.
    pub(super) divided: Option<(usize, usize)>,
    /// By side, in the order of [`SIDES`].
    pub(super) sides: [Condition; 6],
    /// Body force, N/m³.
    pub(super) weight: Vector3<f64>,
    /// A change of temperature, K, and a body force, N/m³, in axes of the grid.
    pub(super) inside: Option<(Linear, [Linear; 3])>,
    /// A cut: its axis, its plane of the grid, and what tightens it.
    pub(super) cut: Option<(usize, usize, CutLoad)>,
}

/// Two bodies in contact: the side of larger coordinates of the first, with the other's opposite side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) bodies: [usize; 2],
    pub(super) axis: usize,
    pub(super) faces: Cells,
    pub(super) gap: Linear,
    /// The surface on which the nodes lie, if it is declared. Finer meshes have its normals, and nodes beside it.
    pub(super) declared: Option<SurfaceKind>,
    /// The limit of friction, Pa.
    pub(super) friction: Option<Linear>,
    /// If it is bonded, by how much the second body is moved against the first, in axes of the space, m.
    pub(super) bond: Option<Vector3<f64>>,
    /// The displacements along the side that are imposed on each body, by component.
    pub(super) held: [[Option<Linear>; 3]; 2],
}

/// An assembly.
#[derive(Clone, Debug)]
pub(super) struct Assembly {
    pub(super) grid: Grid,
    pub(super) parts: Vec<Part>,
    pub(super) touches: Vec<Touch>,
    pub(super) turn: Rotation3<f64>,
    /// The limit of friction on obstacles, Pa.
    pub(super) friction_on_obstacles: Option<Linear>,
}

impl Assembly {
    fn linear(&self, of: Linear) -> ScalarData<Solid> {
        if of.slope == Vector3::zeros() {
            return of.middle.into();
        }
        let back = self.turn.inverse();
        ScalarData::Function(Arc::new(move |x: Vector3<f64>| of.at(back * x)))
    }

    /// Returns the components of a vector along the axes of the space.
    fn vector(&self, of: [Linear; 3]) -> [ScalarData<Solid>; 3] {
        let (turn, back) = (self.turn, self.turn.inverse());
        [0, 1, 2].map(|c| {
            ScalarData::Function(Arc::new(move |x: Vector3<f64>| {
                let x = back * x;
                (turn * Vector3::from_fn(|k, _| of[k].at(x)))[c]
            }))
        })
    }

    fn patches(&self, b: usize) -> Vec<Patch> {
        let of = |(k, touch): (usize, &Touch)| {
            let role = touch.bodies.iter().position(|body| *body == b)?;
            let side = touch.axis + [3, 0][role];
            Some(Patch { name: format!("touch {k}"), side, faces: touch.faces })
        };
        self.touches.iter().enumerate().filter_map(of).collect()
    }

    /// Tells if a part of a side is not in contact with another body.
    pub(super) fn is_free(&self, b: usize, side: usize) -> bool {
        let patches = self.patches(b);
        let taken: usize = patches.iter().filter(|p| p.side == side).map(|p| p.faces.faces(side % 3)).sum();
        self.parts[b].cells.side(side).faces(side % 3) > taken
    }

    fn body(&self, b: usize, halved: u32) -> Made<Body<Solid>> {
        let mesh = self.grid.mesh(&self.parts[b].cells, halved, &self.patches(b), &self.turn)?;
        self.body_of((b, halved), mesh)
    }

    fn body_of(&self, (b, halved): (usize, u32), mesh: TetMesh) -> Made<Body<Solid>> {
        let part = &self.parts[b];
        let mut conditions = BoundaryConditions::<Solid>::default().body_force(self.turn * part.weight);
        if let Some((temperature, force)) = part.inside {
            conditions.temperatures.push(self.linear(temperature));
            conditions.force_field = Some(self.vector(force));
        }
        if let Some((axis, plane, load)) = part.cut {
            let (mut low, mut high) = (part.cells.low, part.cells.high);
            (low[axis], high[axis]) = (plane, plane);
            let point = self.turn * self.grid.middle(&Cells { low, high });
            conditions = conditions.cut("bolt", point, self.turn * Vector3::ith(axis, 2.0), load);
        }
        for (k, touch) in self.touches.iter().enumerate() {
            let role = touch.bodies.iter().position(|body| *body == b);
            let held = role.map_or([None; 3], |role| touch.held[role]);
            if held.iter().any(Option::is_some) {
                let values = held.map(|value| value.map(|value| self.linear(value)));
                conditions = conditions.components(format!("touch {k}").as_str(), values);
            }
        }
        for (side, name) in SIDES.into_iter().enumerate().filter(|(side, _)| self.is_free(b, *side)) {
            conditions = match part.sides[side] {
                Condition::Free | Condition::Plane(..) | Condition::Round(..) => conditions,
                Condition::Fixed => conditions.fix(name),
                Condition::Roller(value) => conditions.roller(name, self.linear(value)),
                Condition::Imposed(values) => conditions.components(name, self.vector(values).map(Some)),
                Condition::Pressure(value) => conditions.pressure(name, self.linear(value)),
                Condition::Traction(values) => conditions.traction(name, self.vector(values)),
                Condition::Springs(stiffness, along, rest) => {
                    let along = match along {
                        SpringDirection::Vector(vector) => SpringDirection::Vector(self.turn * vector),
                        other => other,
                    };
                    let mut conditions = conditions.spring(name, stiffness, along);
                    if let Some(springs) = conditions.springs.last_mut() {
                        springs.rest = SpringRest::Vector(self.vector(rest));
                    }
                    conditions
                }
                Condition::Rigid(motion, force, moment) => conditions.rigid(RigidCondition {
                    edges: name.into(),
                    motion,
                    force: self.turn * force,
                    moment: self.turn * moment,
                    about: Some(self.turn * self.grid.middle(&part.cells.side(side))),
                }),
            };
        }
        let materials = match part.divided {
            None => part.materials[0].clone().into(),
            Some((axis, plane)) => {
                let counts = part.cells.counts().map(|n| n << halved);
                // Six tetrahedra for each cell of the grid.
                let of_cell = (0..mesh.cells().len()).map(|t| {
                    let place =
                        [t / 6 % counts[0], t / 6 / counts[0] % counts[1], t / 6 / counts[0] / counts[1]];
                    u32::from(part.cells.low[axis] + (place[axis] >> halved) >= plane)
                });
                Materials::by_cell(part.materials.clone(), of_cell.collect())
            }
        };
        let body = Body::new(mesh, materials, &conditions)?;
        let touches = self.touches.iter().enumerate().filter(|(_, touch)| touch.bodies.contains(&b));
        let of = |(k, touch): (usize, &Touch)| {
            touch.declared.map(|kind| DeclaredSurface { on: format!("touch {k}"), kind })
        };
        let declared: Vec<DeclaredSurface> = touches.filter_map(of).collect();
        Ok(if halved == 0 { body.with_surfaces(&declared)? } else { body })
    }

    fn gap_of(&self, touch: &Touch) -> Gap<Solid> {
        touch.bond.map_or_else(|| Gap::Given(self.linear(touch.gap)), |offset| Gap::Bonded { offset })
    }

    /// Makes the problem.
    ///
    /// * `halved`: how often the cells are halved.
    pub(super) fn problem(&self, halved: u32) -> Made<ContactProblem<Solid>> {
        let bodies = (0..self.parts.len()).map(|b| self.body(b, halved)).collect::<Made<Vec<_>>>()?;
        let mut problem = ContactProblem::new(bodies.clone());
        for (k, touch) in self.touches.iter().enumerate() {
            let ([a, b], name) = (touch.bodies, format!("touch {k}"));
            let gap = self.gap_of(touch);
            let pair = |bodies: [&Body<Solid>; 2]| {
                contact_geometry::pair_solids(bodies[0], bodies[1], [&name, &name], &gap)
            };
            let mut interface = pair([&bodies[a], &bodies[b]])?;
            if halved > 0 {
                let coarse = pair([&self.body(a, 0)?, &self.body(b, 0)?])?;
                // A part of a declared sphere may be flat to rounding, and has its normals.
                if coarse.has_bent_facets() {
                    interface = self.inherited(a, &coarse, &interface, halved);
                }
            }
            problem = problem.contact([a, b], interface);
            if let Some(limit) = touch.friction {
                problem = problem.with_friction(k, Friction::tresca(self.linear(limit)))?;
            }
        }
        self.with_obstacles(problem, &bodies, halved)
    }

    /// Makes a problem whose surfaces do not match: every other body has halved cells, and nodes inside of flat sides are moved along them.
    pub(super) fn overlaid(&self, random: &mut Random) -> Made<ContactProblem<Solid>> {
        let body = |b: usize| {
            let halved = (b % 2) as u32;
            let mesh = self.grid.mesh(&self.parts[b].cells, halved, &self.patches(b), &self.turn)?;
            let mesh = if self.grid.is_bent() { mesh } else { self.moved(b, mesh, random)? };
            self.body_of((b, halved), mesh)
        };
        let bodies = (0..self.parts.len()).map(body).collect::<Made<Vec<_>>>()?;
        let contact = |(k, touch): (usize, &Touch)| {
            let (name, gap) = (format!("touch {k}"), self.gap_of(touch));
            let surfaces = [name.clone(), name.clone()];
            let normal = ContactNormal::Averaged;
            let sides = Sides::Bodies { bodies: touch.bodies, surfaces, gap, normal };
            let friction = touch.friction.map(|limit| Friction::tresca(self.linear(limit)));
            Contact { name, sides, friction }
        };
        let contacts: Vec<Contact<Solid>> = self.touches.iter().enumerate().map(contact).collect();
        let problem = paired_solids(bodies, &contacts)?.problem;
        let bodies = problem.bodies.clone();
        self.with_obstacles(problem, &bodies, 0)
    }

    /// Moves the nodes that are on one contact side alone, along it.
    fn moved(&self, b: usize, mesh: TetMesh, random: &mut Random) -> Made<TetMesh> {
        let (topology, mut points) = (mesh.topology(), mesh.points().to_vec());
        let mut sides: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); points.len()];
        let patches = self.patches(b);
        let of_patch = |facet: &FacetId| {
            patches.iter().position(|patch| mesh.group(&patch.name).is_some_and(|of| of.contains(facet)))
        };
        for facet in topology.boundary_facets() {
            let side = of_patch(facet).unwrap_or(usize::MAX);
            for node in topology.facets()[*facet] {
                sides[node.index()].insert(side);
            }
        }
        for (node, sides) in sides.iter().enumerate() {
            let (1, Some(patch)) = (sides.len(), sides.first().and_then(|side| patches.get(*side))) else {
                continue;
            };
            let own = points[node];
            let near = topology.cells_around(NodeId::new(node)).iter();
            let corners =
                near.flat_map(|cell| mesh.cells()[*cell as usize]).map(|other| mesh.points()[other]);
            let apart = corners.map(|x| (x - mesh.points()[node]).norm()).filter(|d| *d > 0.0);
            let step = 0.15 * apart.fold(f64::INFINITY, f64::min);
            let along =
                Vector3::from_fn(|k, _| if k == patch.side % 3 { 0.0 } else { step * random.signed() });
            points[node] = own + self.turn * along;
        }
        let groups = mesh.groups().iter().map(|(name, facets)| {
            (name.clone(), facets.iter().map(|facet| topology.facets()[*facet]).collect())
        });
        Ok(TetMesh::oriented(points, mesh.cells().to_vec(), groups.collect())?)
    }

    /// Adds the obstacles.
    fn with_obstacles(
        &self,
        mut problem: ContactProblem<Solid>,
        bodies: &[Body<Solid>],
        halved: u32,
    ) -> Made<ContactProblem<Solid>> {
        for (b, side) in (0..self.parts.len()).flat_map(|b| (0..6).map(move |side| (b, side))) {
            let (round, drive) = match self.parts[b].sides[side] {
                Condition::Plane(_, drive) => (None, drive),
                Condition::Round(round, drive) => (Some(round), drive),
                _ => continue,
            };
            if !self.is_free(b, side) {
                continue;
            }
            let into = Vector3::ith(side % 3, if side < 3 { 1.0 } else { -1.0 });
            let middle = self.grid.middle(&self.parts[b].cells.side(side));
            let normal = self.turn * into;
            let line = match round {
                None => RigidLine::Plane { point: self.turn * middle, normal },
                Some(Round { centre, axis, radius, inside, .. }) => match axis {
                    None => RigidLine::Circle { centre: self.turn * centre, radius, inside },
                    Some(axis) => {
                        let (point, axis) = (self.turn * centre, self.turn * axis);
                        RigidLine::Cylinder { point, axis, radius, inside }
                    }
                },
            };
            let obstacle = match drive {
                Drive::Moved(by) => Obstacle::fixed(line).moved(normal * by),
                Drive::Force(force, at) => {
                    // It moves along its normal and tilts; its motion is given along the axes of the space.
                    let free = |k: usize| k == side % 3 || k >= 3 && k != 3 + side % 3;
                    let motion = [0, 1, 2, 3, 4, 5].map(|k| if free(k) { None } else { Some(0.0) });
                    Obstacle::fixed(line).stamp(motion, (into * force, Vector3::zeros()), at)
                }
            };
            let interface = match self.parts[b].sides[side] {
                Condition::Plane(gap, _) => {
                    let gap = Gap::Given(self.linear(gap));
                    contact_geometry::solid_against(&bodies[b], SIDES[side], &obstacle, Some(&gap))?
                }
                _ => self.against_round((b, side), round.and_then(|round| round.gap), &obstacle, halved)?,
            };
            problem = problem.obstacle(b, interface, obstacle);
            if let Some(limit) = self.friction_on_obstacles {
                let pair = problem.contacts.len() - 1;
                problem = problem.with_friction(pair, Friction::tresca(self.linear(limit)))?;
            }
        }
        Ok(problem)
    }

    /// Pairs a side with a round obstacle. The gap of the coarse mesh is a linear vector on its faces: finer meshes have the same.
    fn against_round(
        &self,
        (b, side): (usize, usize),
        given: Option<Linear>,
        obstacle: &Obstacle<Solid>,
        halved: u32,
    ) -> Made<ContactInterface<Solid>> {
        let gap = given.map(|gap| Gap::Given(self.linear(gap)));
        let coarse = self.body(b, 0)?;
        let found = contact_geometry::solid_against(&coarse, SIDES[side], obstacle, gap.as_ref())?;
        if halved == 0 {
            return Ok(found);
        }
        // Distances are not refused as given gaps may be.
        let fine = contact_geometry::solid_against(&self.body(b, halved)?, SIDES[side], obstacle, None)?;
        Ok(self.inherited(b, &found, &fine, halved))
    }

    /// Gives the pairs of a finer mesh the normals and gaps of the coarse one: vectors that are linear on its faces.
    ///
    /// * `body`: the first one of the pair.
    fn inherited(
        &self,
        body: usize,
        coarse: &ContactInterface<Solid>,
        fine: &ContactInterface<Solid>,
        halved: u32,
    ) -> ContactInterface<Solid> {
        let counts = self.parts[body].cells.counts();
        let field = |of: fn(&NodePair<Solid>) -> Vector3<f64>| {
            let mut field = vec![Vector3::zeros(); self.parts[body].cells.nodes()];
            let removed = coarse.clamped().iter().map(|clamped| &clamped.pair);
            coarse.pairs().iter().chain(removed).for_each(|pair| field[pair.nodes[0].index()] = of(pair));
            (0..halved).fold(field, |field, k| prolonged(counts.map(|n| n << k), &field))
        };
        let normals = field(|pair| pair.normal);
        let gaps = field(|pair| pair.normal * (pair.gap / pair.normal.norm_squared()));
        let of_pair = |pair: &NodePair<Solid>| {
            let node = pair.nodes[0].index();
            NodePair { normal: normals[node], gap: gaps[node].dot(&normals[node]), ..*pair }
        };
        let pairs: Vec<NodePair<Solid>> = fine.pairs().iter().map(of_pair).collect();
        let removed: Vec<ClampedPair<Solid>> = fine
            .clamped()
            .iter()
            .map(|clamped| ClampedPair { pair: of_pair(&clamped.pair), ..clamped.clone() })
            .collect();
        let of_face = |face: &ContactFacet<Solid>| {
            let own = |corner: usize| match face.clamped[corner] {
                None => pairs[face.pairs[corner] as usize],
                Some(clamped) => removed[clamped.number as usize].pair,
            };
            let [a, b, c] = [0, 1, 2].map(|corner| own(corner).normal);
            let bent = [a - b, b - c, c - a].iter().any(|turn| turn.norm() > SAME_NORMAL);
            let clamped = [0, 1, 2].map(|corner: usize| {
                let pair = own(corner);
                let of = face.clamped[corner]?;
                Some(ClampedCorner { opening: (pair.gap - of.jump.dot(&pair.normal)).max(0.0), ..of })
            });
            ContactFacet { bent, clamped, ..*face }
        };
        let facets = fine.facets().iter().map(of_face).collect();
        ContactInterface::new(pairs, facets, fine.gap().clone()).with_clamped(removed)
    }
}
