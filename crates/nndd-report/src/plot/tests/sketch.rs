//! The problem: supports, loads, obstacles.

use super::*;

fn drawn(
    title: &str,
    bodies: &[SketchBody<'_>],
    obstacles: &[ObstaclePicture<'_>],
    contact: &[[Vector; 2]],
) -> String {
    sketch(title, bodies, obstacles, contact, &Labels::default())
}

#[test]
fn sketch_says_what_is_imposed() {
    let mesh = block(3, 0.0);
    let edge = |x: f64, held: Held, displacement: [f64; 2], traction: [f64; 2]| SketchEdge {
        ends: [[x, 1.0], [x + 0.5, 1.0]].map(Vector::from),
        normal: Vector::y(),
        held,
        displacement: displacement.into(),
        traction: traction.into(),
    };
    let edges = vec![
        edge(0.0, Held::Fixed, [0.0, -0.1], [0.0; 2]),
        edge(0.5, Held::Roller, [0.0; 2], [0.0; 2]),
        edge(1.0, Held::Free, [0.0; 2], [0.0, -3.0]),
    ];
    let body = |edges| SketchBody {
        name: "block <1>",
        mesh: &mesh,
        materials: vec![],
        cuts: vec![],
        edges,
        body_force: Vector::zeros(),
        rigid: vec![],
    };
    let svg = drawn("Sketch", &[body(edges)], &[], &[[Vector::zeros(), 2.0 * Vector::x()]]);
    assert_whole(&svg);
    let words =
        ["block &lt;1&gt;", "held in one direction", "imposed displacement", "load", "possible contact"];
    for text in words {
        assert!(svg.contains(text), "{text}");
    }
    let bare = drawn("Bare", &[body(vec![])], &[], &[]);
    assert_whole(&bare);
    assert!(bare.contains("nothing imposed") && !bare.contains("possible contact"));
}

#[test]
fn sketch_shows_obstacles_and_what_moves_them() {
    let mesh = block(3, 0.0);
    let body = || SketchBody {
        name: "b",
        mesh: &mesh,
        materials: vec![],
        cuts: vec![],
        edges: vec![],
        body_force: Vector::zeros(),
        rigid: vec![],
    };
    let below = [Vector::zeros(), 2.0 * Vector::x()];
    let plane = RigidLine::Plane { point: -3.0 * Vector::x(), normal: 5.0 * Vector::y() };
    let still = (Vector::zeros(), 0.0);
    let svg = drawn("Plane", &[body()], &[obstacle(plane, &below, still)], &[]);
    assert_whole(&svg);
    assert!(svg.contains("rigid obstacle</text>") && svg.contains("A rigid obstacle (hatched line)."));
    assert!(!svg.contains(">load</text>"), "{svg}");
    // From the force an arrow, from the moment a second one.
    let heads = |load| {
        let svg = drawn("Circle", &[body()], &[obstacle(CIRCLE, &[Vector::new(1.0, 1.0)], load)], &[]);
        assert_whole(&svg);
        svg.matches("fill=\"#0072B2\"").count()
    };
    let legend = 1;
    assert_eq!(heads(still), 0);
    assert_eq!(heads((-Vector::y(), 0.0)), legend + 1);
    assert_eq!(heads((-Vector::y(), 2.0)), legend + 2);
}

#[test]
fn lines_of_obstacles_go_a_little_beyond_their_contact() {
    let still = (Vector::zeros(), 0.0);
    let ends = [Vector::new(1.0, 1.0), Vector::new(3.0, 1.5)];
    let plane = RigidLine::Plane { point: Vector::new(0.0, -1.0), normal: -Vector::y() };
    let line = obstacle(plane, &ends, still).near(2.0);
    let x: Vec<f64> = line.iter().map(|[p, _]| p[0]).collect();
    assert!((x[0].min(x[1]) - 0.7).abs() < 1e-12 && (x[0].max(x[1]) - 3.3).abs() < 1e-12, "{x:?}");
    assert!(line.iter().all(|[p, n]| (p[1] + 1.0).abs() < 1e-12 && *n == Vector::y()));
    // An arc over the angles of the points, also where they pass ±π; and the whole circle for points all around.
    let circle = RigidLine::Circle { centre: Vector::zeros(), radius: 1.0, inside: true };
    let at = |degrees: f64| Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    let arc = |points: &[Vector]| {
        let line = obstacle(circle, points, still).near(0.1);
        let places = line.iter().map(|[p, n]| {
            assert!((*p - *n).norm() < 1e-12, "the normal into a hole's wall");
            *p
        });
        let places: Vec<Vector> = places.collect();
        places.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>().to_degrees()
    };
    let some = [at(170.0), at(-170.0), at(180.0)];
    assert!((arc(&some) - 26.0).abs() < 0.1, "{}", arc(&some));
    let all: Vec<Vector> = (0..12).map(|k| at(30.0 * f64::from(k))).collect();
    assert!((arc(&all) - 360.0).abs() < 0.1, "{}", arc(&all));
    assert!(obstacle(circle, &[], still).near(1.0).is_empty());
}

#[test]
fn rigid_sides_are_bars_with_their_loads() {
    let mesh = block(3, 0.0);
    let edge = |held| SketchEdge {
        ends: [[0.0, 1.0], [2.0, 1.0]].map(Vector::from),
        normal: Vector::y(),
        held,
        displacement: Vector::zeros(),
        traction: Vector::zeros(),
    };
    let load =
        SketchLoad { at: Vector::new(1.0, 1.0), normal: Vector::y(), force: -Vector::y(), moment: 0.0 };
    let body = |held, rigid| SketchBody {
        name: "b",
        mesh: &mesh,
        materials: vec![],
        cuts: vec![],
        edges: vec![edge(held)],
        body_force: Vector::zeros(),
        rigid,
    };
    let bar = drawn("Bar", &[body(Held::Rigid, vec![load])], &[], &[]);
    assert_whole(&bar);
    assert!(bar.contains("rigid side</text>") && bar.contains("load</text>") && !bar.contains("held</text>"));
    assert!(bar.contains("1 boundary edges of rigid sides that are free to move"));
    let clamped = drawn("Clamped", &[body(Held::Fixed, vec![])], &[], &[]);
    assert!(clamped.contains("held</text>") && !clamped.contains("rigid side"));
}

#[test]
fn a_load_keeps_off_the_rollers_below_it() {
    let mesh = block(3, 0.0);
    let of = |held| {
        let edges = vec![SketchEdge {
            ends: [[0.5, 1.0], [1.0, 1.0]].map(Vector::from),
            normal: Vector::y(),
            held,
            displacement: Vector::zeros(),
            traction: -Vector::y(),
        }];
        let body = SketchBody {
            name: "b",
            mesh: &mesh,
            materials: vec![],
            cuts: vec![],
            edges,
            body_force: Vector::zeros(),
            rigid: vec![],
        };
        let svg = drawn("Load", &[body], &[], &[]);
        let head = svg.lines().rfind(|line| line.contains("fill=\"#0072B2\" fill-rule")).unwrap();
        // The tip is the second point of the head; y grows downwards.
        let tip = head.split_once('L').unwrap().1.split(' ').nth(1).unwrap();
        tip.parse::<f64>().unwrap()
    };
    assert!(of(Held::Roller) + 40.0 <= of(Held::Free), "{} {}", of(Held::Roller), of(Held::Free));
}

#[test]
fn a_triangle_is_a_single_node_and_not_a_short_edge() {
    let mesh = block(3, 0.0);
    let edge = |length: f64| SketchEdge {
        ends: [[1.0, 1.0], [1.0 + length, 1.0]].map(Vector::from),
        normal: Vector::y(),
        held: Held::Fixed,
        displacement: Vector::zeros(),
        traction: Vector::zeros(),
    };
    let of = |length: f64| {
        let body = SketchBody {
            name: "b",
            mesh: &mesh,
            materials: vec![],
            cuts: vec![],
            edges: vec![edge(length)],
            body_force: Vector::zeros(),
            rigid: vec![],
        };
        let svg = drawn("Held", &[body], &[], &[]);
        svg.matches("fill=\"#191919\" fill-rule").count()
    };
    assert_eq!([of(0.0), of(1e-6), of(0.5)], [1, 0, 0]);
}

#[test]
fn sketch_of_odd_bodies() {
    assert!(drawn("Nothing", &[], &[], &[]).contains("no data"));
    for bad in BAD {
        let mesh = block(2, 0.0);
        let edges = vec![SketchEdge {
            ends: [[0.0, bad], [1.0, 1.0]].map(Vector::from),
            normal: Vector::new(bad, 1.0),
            held: Held::Fixed,
            displacement: Vector::repeat(bad),
            traction: Vector::new(bad, 1.0),
        }];
        let (force, moment) = (Vector::new(bad, 0.0), bad);
        let load = SketchLoad { at: Vector::y(), normal: Vector::new(0.0, bad), force, moment };
        let points = [Vector::new(bad, 0.0), Vector::x()];
        let circle = RigidLine::Circle { centre: Vector::new(0.0, bad), radius: bad, inside: false };
        let plane = RigidLine::Plane { point: Vector::new(bad, bad), normal: Vector::new(bad, 1.0) };
        let obstacles = [CIRCLE, circle, plane].map(|line| ObstaclePicture {
            imposed: force,
            motion: Motion { spin: bad, ..rest() },
            ..obstacle(line, &points, (force, moment))
        });
        assert_whole(&density("Odd", &[], &obstacles, &[]));
        let body = SketchBody {
            name: "odd",
            mesh: &mesh,
            materials: vec![],
            cuts: vec![],
            edges,
            body_force: Vector::repeat(bad),
            rigid: vec![load],
        };
        assert_whole(&drawn("Odd", &[body], &obstacles, &[]));
    }
}
