//! From one body to a certified contact problem, step by step. Every step is a program that the tests run.
//!
//! # 1. One body
//! A mesh has points, triangles and named sides. A material belongs to the plane hypothesis it is used with. Conditions are
//! given on sides; what is not named is free.
//! ```
//! use certified_contact::fem_core::{assembly::System, body::Body, boundary::BoundaryConditions,
//!     condensation::CondensedBody, interface::InterfaceSide, material::{Hypothesis, LinearElastic},
//!     mesh::generate::block, norm::energy_norm_squared};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain)?;
//! // 16 × 8 cells on (0, 2) × (1, 2); the sides are "left", "right", "bottom", "top".
//! let mesh = block([0.0, 1.0], [2.0, 1.0], [16, 8])?;
//! let conditions = BoundaryConditions::new()
//!     .displace("left", Some(0.0.into()), None)
//!     .displace("top", None, Some((-0.02).into()));
//! let upper = Body::new(mesh, steel, &conditions)?;
//! // Alone, without interface, it is an ordinary problem of elasticity: moved down, without strain.
//! let solver = CondensedBody::factorise(System::assemble(&upper, &InterfaceSide::default())?, upper.mesh().points())?;
//! let u = solver.displacement_from_force(&[]);
//! assert!(energy_norm_squared(&upper, &u) < 1e-20);
//! # Ok(()) }
//! ```
//!
//! # 2. Two bodies in contact
//! A pair of surfaces becomes an interface: nodes that face each other, a normal out of the first body, and a gap. With
//! [`Gap::Touching`](fem_core::interface::Gap::Touching) surfaces that do not touch are an error;
//! [`Gap::Geometric`](fem_core::interface::Gap::Geometric) measures the gap between them. Surfaces whose nodes do not match
//! go through [`common_refinement`](contact_geometry::common_refinement) first.
//!
//! # 3. Solve and certify
//! [`solve`](crate::solve()) factorises both bodies, iterates until the error of the iteration is small against the error of
//! the mesh, and bounds the error of the result.
//! ```
//! use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions,
//!     interface::{ContactProblem, Gap}, material::{Hypothesis, LinearElastic}, mesh::generate::block};
//! use certified_contact::{Settings, Silent, solve};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let steel = || LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain);
//! # let pressed = BoundaryConditions::new().displace("left", Some(0.0.into()), None)
//! #     .displace("top", None, Some((-0.02).into()));
//! # let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [16, 8])?, steel()?, &pressed)?;
//! let clamped = BoundaryConditions::new().fix("bottom");
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [16, 8])?, steel()?, &clamped)?;
//! let interface = certified_contact::contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
//! let problem = ContactProblem::between([upper, lower], interface);
//! let answer = solve(problem, &Settings::default(), &mut Silent)?;
//!
//! // The bound is there only if all its checks hold.
//! let estimate = answer.estimate.as_ref().ok_or("no estimate")?;
//! let bound = estimate.certificate().ok_or("a check failed")?;
//! assert!(bound.eta_nndd < 0.02 * bound.e_cre);
//! // The parts of the bound: here nearly all of it is the mesh.
//! assert!(bound.parts.mesh > 0.9 * bound.e_cre);
//! // Displacements and stresses of each body, in the order they were given.
//! let deepest = estimate.pair.bodies[1].displacement.iter().map(|u| u[1]).fold(0.0, f64::min);
//! assert!(deepest < 0.0);
//! // Quantities of the exact solution, from both sides.
//! let [low, high] = answer.bounds.and_then(|b| b.contact_force.ok()).ok_or("no interval")?;
//! let force = answer.results.as_ref().ok_or("no results")?.contact_force;
//! assert!(low < force && force < high);
//! # Ok(()) }
//! ```
//!
//! # 4. Ask for an accuracy
//! [`solve_adaptively`](crate::solve_adaptively) refines both meshes where the certified error is, until the bound is a given part of the
//! energy norm. [`Observer`](crate::Observer) follows the run, and can end it: the answer is then the best mesh so far.
//! ```
//! use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions,
//!     interface::{ContactProblem, Gap}, material::{Hypothesis, LinearElastic}, mesh::generate::block};
//! use certified_contact::{AdaptSettings, AdaptiveEnd, Observer, Settings, CertifiedSolution, Step, solve_adaptively};
//!
//! /// Counts the meshes.
//! struct Meshes(usize);
//! impl Observer for Meshes {
//!     fn step(&mut self, _step: &Step, _solution: &CertifiedSolution) {
//!         self.0 += 1;
//!     }
//! }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let steel = || LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain);
//! # let pressed = BoundaryConditions::new().displace("left", Some(0.0.into()), None)
//! #     .displace("top", None, Some((-0.02).into()));
//! # let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2])?, steel()?, &pressed)?;
//! # let clamped = BoundaryConditions::new().fix("bottom");
//! # let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2])?, steel()?, &clamped)?;
//! # let interface = certified_contact::contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
//! # let problem = ContactProblem::between([upper, lower], interface);
//! let mut meshes = Meshes(0);
//! let found = solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(0.05), &mut meshes)?;
//! assert!(matches!(found.end, AdaptiveEnd::TargetMet));
//! assert!(found.solution.relative() <= Some(0.05));
//! assert_eq!(meshes.0, found.history.len());
//! # Ok(()) }
//! ```
//!
//! # 5. More bodies, and obstacles
//! [`ContactProblem::new`](fem_core::interface::ContactProblem::new) takes any number of bodies; then come the pairs, by the numbers of
//! the bodies, and rigid lines. A body may be held by contact alone: [`solve`](crate::solve()) refuses loads that nothing resists.
//! An assembly is solved exactly, by an active set, unless [`with_method`](crate::Settings::with_method) asks for the iteration.
//! ```
//! use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions, geometry::Vector,
//!     interface::{ContactProblem, Gap, Obstacle, RigidLine}, material::{Hypothesis, LinearElastic},
//!     mesh::generate::block};
//! use certified_contact::{Settings, Silent, solve};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let steel = || LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain);
//! // One block on the other, the lower one on a rigid floor; supports hold them sideways only.
//! let sideways = BoundaryConditions::new().displace("left", Some(0.0.into()), None);
//! let pressed = sideways.clone().pressure("top", 10.0);
//! let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [16, 8])?, steel()?, &sideways)?;
//! let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [16, 8])?, steel()?, &pressed)?;
//! let between = certified_contact::contact_geometry::pair(&lower, &upper, ["top", "bottom"], &Gap::Touching)?;
//! let floor = RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() };
//! let on_floor = certified_contact::contact_geometry::against(&lower, "bottom", &Obstacle::fixed(floor), None)?;
//! let problem = ContactProblem::new(vec![lower, upper])
//!     .contact([0, 1], between)
//!     .obstacle(0, on_floor, Obstacle::fixed(floor));
//! let answer = solve(problem, &Settings::default(), &mut Silent)?;
//! assert!(answer.is_certified());
//! // Both contacts carry the force of the pressure, in the order in which they were added.
//! for pair in &answer.results.as_ref().ok_or("no results")?.contacts {
//!     assert!((pair.contact_force - 20.0).abs() < 1e-8);
//! }
//! # Ok(()) }
//! ```
//! [`Obstacle::moved`](fem_core::interface::Obstacle::moved) moves the line, [`Obstacle::stamp`](fem_core::interface::Obstacle::stamp)
//! lets it move under a force. `examples/assembly.rs` has three blocks, on refined meshes.
//!
//! # 6. Solids
//! The same types with [`Solid`](fem_core::space::Solid) in place of the plane serve tetrahedra. Surfaces whose nodes match, flat or curved, are paired by
//! [`pair_solids`](contact_geometry::pair_solids); rigid planes, spheres and cylinders by [`solid_against`](contact_geometry::solid_against). Forces are in N.
//! ```
//! use certified_contact::fem_core::{body::Body, boundary::BoundaryConditions, interface::{ContactProblem, Gap},
//!     material::LinearElastic, mesh::generate::cuboid, space::Solid};
//! use certified_contact::{Settings, Silent, contact_geometry::pair_solids, solve};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let steel = || LinearElastic::isotropic_solid(2000.0, 0.3);
//! // One cube on the other, pressed down by 10 Pa; rollers hold the lower one at its bottom, and both at two sides.
//! let sides = BoundaryConditions::<Solid>::default().roller("left", 0.0).roller("front", 0.0);
//! let [pressed, on_floor] = [sides.clone().pressure("top", 10.0), sides.roller("bottom", 0.0)];
//! let upper = Body::new(cuboid([0.0, 0.0, 1.0], [1.0; 3], [4; 3])?, steel()?, &pressed)?;
//! let lower = Body::new(cuboid([0.0; 3], [1.0; 3], [4; 3])?, steel()?, &on_floor)?;
//! let between = pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
//! let problem = ContactProblem::between([upper, lower], between);
//! let answer = solve(problem, &Settings::<Solid>::default(), &mut Silent)?;
//! // Tetrahedra represent a uniform stress exactly, so the bound is round-off.
//! assert!(answer.is_certified() && answer.relative() < Some(1e-10));
//! let results = answer.results.as_ref().ok_or("no results")?;
//! assert!((results.contact_force - 10.0).abs() < 1e-9);
//! // The area in contact: of faces closed at every node, and at one node at least.
//! let area = &results.contacts[0].area;
//! assert!((area.inner - 1.0).abs() < 1e-12 && (area.outer - 1.0).abs() < 1e-12);
//! # Ok(()) }
//! ```
//! `examples/solids.rs` certifies two blocks of which only a part touches, on three meshes.
//!
//! # 7. The meaning of the number
//! The bound is of the energy norm of the error, and holds for data that are linear along the edges, on the given polygons. If a
//! check fails by more than round-off, [`certificate`](cre_estimator::Estimate::certificate) is `None`; then there is no bound, and
//! [`unchecked`](cre_estimator::Estimate::unchecked) has the numbers for a report. [`theory`](crate::theory) has every formula.
