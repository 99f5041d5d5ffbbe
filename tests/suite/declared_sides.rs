//! Gaps and normals between declared arcs and straight stretches: a rope on a pulley, a ring on a liner, random arcs.

use contact_geometry::ContactNormal;
use fem_core::body::{Body, CurveKind, CurvedSide};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, cross, norm, perpendicular};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::{block, ring};
use fem_core::mesh::id::FacetId;
use fem_core::mesh::refine::RefinementEdges;
use tests::run::paired_in_common;
use tests::shapes::moved;

/// Makes a body, some of whose edges of a side are declared as an arc.
///
/// * `fixed`: a group that is held, if any.
fn body(mesh: TriMesh, side: &str, is_round: impl Fn(Vector) -> bool, fixed: Option<&str>) -> Body {
    let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let conditions = match fixed {
        Some(group) => BoundaryConditions::new().fix(group),
        None => BoundaryConditions::new(),
    };
    let mut body = Body::new(mesh, steel, &conditions).unwrap();
    let edges = body.mesh().group(side).unwrap().iter().copied();
    let round: Vec<FacetId> = edges.filter(|edge| is_round(body.mesh().facet_middle(*edge))).collect();
    body.add_group("round", round);
    body.with_curves(&[CurvedSide { on: "round".to_owned(), kind: CurveKind::Arc }]).unwrap()
}

/// A line through a point, or a circle.
#[derive(Clone, Copy)]
enum Exact {
    Line(Vector, Vector),
    Circle(Vector, f64),
}

impl Exact {
    /// The way from a point to the piece along a unit direction: the shorter one.
    fn way(&self, point: Vector, along: Vector) -> f64 {
        match *self {
            Self::Line(on, direction) => cross(on - point, direction) / cross(along, direction),
            Self::Circle(centre, radius) => {
                let (arm, root) = (point - centre, |x: f64| x.sqrt());
                let b = arm.dot(&along);
                // Without a difference of nearly equal numbers.
                let off = (norm(arm) - radius) * (norm(arm) + radius);
                -off / (b + b.signum() * root(b * b - off))
            }
        }
    }

    /// The sine of the angle between a direction and the normal at a point.
    fn off_normal(&self, point: Vector, direction: Vector) -> f64 {
        match *self {
            Self::Line(_, along) => direction.dot(&along).abs(),
            Self::Circle(centre, _) => cross(point - centre, direction).abs() / norm(point - centre),
        }
    }
}

/// Checks gaps and normals at all pairs on a first mesh and on two finer ones: gaps to 1e-9 of a radius, and normals of one of the sides.
///
/// * `exact`: the piece of each body at a point of it.
fn check(name: &str, problem: ContactProblem, radius: f64, exact: [&dyn Fn(Vector) -> Exact; 2]) {
    let mut problem = problem;
    let mut edges: Vec<RefinementEdges> =
        problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    for finer in 0..3 {
        let (mut gaps, mut turned) = ([0.0f64; 2], [0.0f64; 2]);
        for pair in problem.contacts[0].interface.pairs() {
            let points = [0, 1].map(|b| problem.bodies[b].mesh().points()[pair.nodes[b]]);
            let unit = 1.0 / norm(pair.normal) * pair.normal;
            let pieces = [0, 1].map(|b| exact[b](points[b]));
            for r in 0..2 {
                // On the normal through the node of one side; the node of the other may lie beside it, or on a chord.
                let near = |b: usize| (points[b] - points[r]).dot(&unit);
                let way = |b: usize| near(b) + pieces[b].way(points[r] + near(b) * unit, unit);
                let distance = pair.gap / norm(pair.normal) - (way(1) - way(0)).max(0.0);
                gaps[r] = gaps[r].max(distance.abs() / radius);
                turned[r] = turned[r].max(pieces[r].off_normal(points[r], unit));
            }
        }
        let pairs = problem.contacts[0].interface.pairs().len();
        // The normals are of one side, and the gaps are measured from the nodes of one side, along these normals.
        let least = |of: [f64; 2]| of[0].min(of[1]);
        assert!(pairs > 4 && least(gaps) < 1e-9, "{name}, {finer}: {gaps:?}");
        assert!(least(turned) < 1e-9, "{name}, {finer}: {turned:?}");
        let marked: Vec<Vec<bool>> =
            problem.bodies.iter().map(|body| vec![true; body.mesh().topology().facets().len()]).collect();
        let found = contact_geometry::refined(&problem, &edges, &marked).unwrap();
        edges = found.refinements.into_iter().map(|found| found.refinement_edges).collect();
        problem = found.problem;
    }
}

fn paired(bodies: [Body; 2], sides: [&str; 2]) -> ContactProblem {
    paired_in_common(bodies, sides, &Gap::Geometric, ContactNormal::Averaged).unwrap().0
}

/// A rope of three stretches around a pulley of radius 1 at the origin: straight, half wound, straight.
fn rope(clearance: f64, cells: [usize; 3], fixed: Option<&str>) -> Body {
    let radius = 1.0 + clearance;
    let columns = cells.iter().sum::<usize>();
    let wound = 2.0;
    let place = |p: Vector| {
        let [before, around, after] = cells.map(|count| count as f64);
        let k = (p[0] * columns as f64).round();
        let angle = wound * ((k - before) / around).clamp(0.0, 1.0) - 0.5 * wound;
        let out = Vector::new(angle.sin(), angle.cos());
        let straight = 0.6 * (((k - before) / before).min(0.0) + ((k - before - around) / after).max(0.0));
        // The body is on the left of its lower side.
        (radius + p[1]) * out + straight * Vector::new(out[1], -out[0])
    };
    let mesh = moved(&block([0.0, 0.0], [1.0, 0.2], [columns, 3]).unwrap(), place).unwrap();
    body(mesh, "bottom", |x| rope_is_round(x, wound), fixed)
}

fn rope_is_round(x: Vector, wound: f64) -> bool {
    x[0].atan2(x[1]).abs() < 0.5 * wound
}

#[test]
fn a_rope_lies_on_its_pulley() {
    let round = |radius: f64| Exact::Circle(Vector::zeros(), radius);
    for (clearance, cells, turns) in [
        (0.0, [4, 17, 5], false),
        (0.01, [3, 20, 3], true),
        (0.003, [7, 23, 6], false),
        (0.0, [5, 12, 5], true),
    ] {
        let rope = rope(clearance, cells, if turns { Some("left") } else { None });
        let pulley = ring([0.0, 0.0], [0.5, 1.0], [0.0, 360.0], [40, 4]).unwrap();
        let pulley = body(pulley, "outer", |_| true, if turns { None } else { Some("inner") });
        let along = move |x: Vector| {
            let side = x[0].signum();
            let out = Vector::new(side * 1.0f64.sin(), 1.0f64.cos());
            let line = Exact::Line((1.0 + clearance) * out, perpendicular(out));
            if rope_is_round(x, 2.0) { round(1.0 + clearance) } else { line }
        };
        let name = format!("clearance {clearance}, {cells:?} cells");
        check(
            &name,
            paired([rope.clone(), pulley.clone()], ["bottom", "outer"]),
            1.0,
            [&along, &|_| round(1.0)],
        );
        check(&name, paired([pulley, rope], ["outer", "bottom"]), 1.0, [&|_| round(1.0), &along]);
    }
}

#[test]
fn a_full_ring_meets_a_straight_liner() {
    let line = |_: Vector| Exact::Line(Vector::new(0.0, -1.02), Vector::x());
    let circle = |_: Vector| Exact::Circle(Vector::zeros(), 1.0);
    for (cells, held) in [(24, true), (37, true), (24, false), (40, false)] {
        let wheel = ring([0.0, 0.0], [0.6, 1.0], [0.0, 360.0], [cells, 4]).unwrap();
        let wheel = body(wheel, "outer", |_| true, if held { Some("inner") } else { None });
        let mesh = block([-1.5, -1.52], [3.0, 0.5], [31, 5]).unwrap();
        let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let liner = Body::new(mesh, steel, &BoundaryConditions::new().fix("bottom")).unwrap();
        let name = format!("{cells} cells, held {held}");
        check(&name, paired([wheel.clone(), liner.clone()], ["outer", "top"]), 1.0, [&circle, &line]);
        check(&name, paired([liner, wheel], ["top", "outer"]), 1.0, [&line, &circle]);
    }
}

#[test]
fn gaps_between_random_arcs_are_their_own() {
    let mut state = 11u64;
    let mut random = |from: f64, to: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for k in 0..12 {
        let centre = Vector::new(random(-5.0, 5.0), random(-5.0, 5.0));
        let radius = 10f64.powf(random(-2.0, 2.0));
        // Eccentric by a part of the clearance.
        let clearance = radius * random(1e-4, 0.02);
        let shift = 0.9 * clearance * Vector::new(random(-0.7, 0.7), random(-0.7, 0.7));
        let start = random(0.0, 300.0);
        let angles = [start, start + random(40.0, 160.0)];
        let cells = [random(8.0, 30.0) as usize, 3];
        let inner = ring(centre, [0.5 * radius, radius], angles, cells).unwrap();
        let outer_radius = radius + clearance;
        let around = [random(8.0, 30.0) as usize, 3];
        let outer = ring(centre + shift, [outer_radius, 1.5 * radius], angles, around).unwrap();
        let inner = body(inner, "outer", |_| true, if k % 2 == 0 { Some("inner") } else { None });
        let outer = body(outer, "inner", |_| true, if k % 3 == 0 { Some("outer") } else { None });
        let circles = [Exact::Circle(centre, radius), Exact::Circle(centre + shift, outer_radius)];
        let problem = paired([inner, outer], ["outer", "inner"]);
        check(&format!("arcs {k}"), problem, radius, [&|_| circles[0], &|_| circles[1]]);
    }
}
