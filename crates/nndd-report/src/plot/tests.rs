use super::axis::{Axis, short};
use super::outline::outline;
use super::*;
use crate::nodal::NodalPatch;
use case_io::report::{IterationRow, SweepPanel, SweepRow};
use case_io::table::{ContactRow, FrictionRow};
use fem_core::geometry::Vector;
use fem_core::interface::RigidLine;
use fem_core::mesh::TriMesh;

const BAD: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 5e-324];

/// Fails unless the text is one SVG document whose tags close in order and whose numbers are numbers.
#[track_caller]
fn assert_whole(svg: &str) {
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "not one svg element");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "NaN or infinity in the drawing");
    let mut open: Vec<&str> = vec![];
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "stray > in text");
        let end = start + rest[start..].find('>').expect("tag without an end");
        let tag = &rest[start + 1..end];
        assert!(!tag.contains('<'), "tag within a tag: {tag}");
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of {tag}");
        let name = tag.split([' ', '/']).find(|s| !s.is_empty()).unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "left open: {open:?}");
    assert_eq!(svg.matches("<title>").count(), 1);
    assert_eq!(svg.matches("<desc>").count(), 1);
    assert!(svg.len() < 1_500_000, "{} bytes", svg.len());
}

fn rows(n: usize) -> Vec<IterationRow> {
    (1..=n)
        .map(|k| IterationRow {
            iteration: k,
            eta_nndd: Some(0.5f64.powi(k as i32)),
            precision: Some(0.1 * 0.3f64.powi(k as i32)),
            eta_dis: (k % 2 == 0).then_some(0.9),
            ..IterationRow::default()
        })
        .collect()
}

/// A block of `2n × n` squares cut into triangles.
fn block(n: usize, y: f64) -> TriMesh {
    let id = |i: usize, j: usize| (j * (2 * n + 1) + i) as u32;
    let points = (0..=n)
        .flat_map(|j| (0..=2 * n).map(move |i| [i as f64 / n as f64, y + j as f64 / n as f64]))
        .collect();
    let triangles = (0..n)
        .flat_map(|j| (0..2 * n).map(move |i| (i, j)))
        .flat_map(|(i, j)| {
            [[id(i, j), id(i + 1, j), id(i + 1, j + 1)], [id(i, j), id(i + 1, j + 1), id(i, j + 1)]]
        })
        .collect();
    TriMesh::new(points, triangles, vec![]).unwrap()
}

fn picture(n: usize, u: impl Fn([f64; 2]) -> [f64; 2], density: impl Fn(usize) -> f64) -> String {
    let meshes = [block(n, 1.0), block(n, 0.0)];
    let fields = meshes.each_ref().map(|m| -> (Vec<Vector>, Vec<_>) {
        (
            m.points().iter().map(|p| u((*p).into()).into()).collect(),
            (0..m.triangles().len()).map(&density).collect(),
        )
    });
    let bodies = [0, 1].map(|k| BodyPicture {
        name: ["upper", "lower"][k],
        mesh: &meshes[k],
        displacement: &fields[k].0,
        field: Field::Cells(&fields[k].1),
    });
    deformed("Two blocks", Quantity::ErrorDensity, &bodies, &[], &[], &Labels::default())
}

fn density(
    title: &str,
    bodies: &[BodyPicture<'_>],
    obstacles: &[ObstaclePicture<'_>],
    closing: &[Closing],
) -> String {
    deformed(title, Quantity::ErrorDensity, bodies, obstacles, closing, &Labels::default())
}

fn drawn(
    title: &str,
    bodies: &[SketchBody<'_>],
    obstacles: &[ObstaclePicture<'_>],
    contact: &[[Vector; 2]],
) -> String {
    sketch(title, bodies, obstacles, contact, &Labels::default())
}

const VALUES: [f64; 3] = [0.2, 0.4, 0.6];

fn constant(name: &str, value: Option<f64>) -> SweepPanel {
    let iteration = IterationRow { eta_nndd: value, eta_dis: value, e_cre: value, ..IterationRow::default() };
    let row = SweepRow { iteration, ..SweepRow::default() };
    SweepPanel { name: name.into(), rows: vec![row; 3], ..SweepPanel::default() }
}

fn profile<const N: usize>(s: [f64; N], opening: [f64; N], pressure: [f64; N]) -> String {
    let row = |k| ContactRow { s: s[k], opening: opening[k], pressure: pressure[k], ..ContactRow::default() };
    contact("Contact", &(0..N).map(row).collect::<Vec<_>>(), None, &Labels::default())
}

#[test]
fn sweep_names_its_panels_series_and_losses() {
    let mut fine = constant("fine <5994> & more", Some(0.2));
    for (row, eta) in fine.rows.iter_mut().zip([Some(0.5), Some(0.01), None]) {
        row.iteration.eta_nndd = eta;
    }
    let svg = sweep("Sweep", "solver.theta", &VALUES, &[constant("coarse", Some(1.0)), fine]);
    assert_whole(&svg);
    for text in ["coarse", "fine &lt;5994&gt; &amp; more", "eta_nndd", "eta_dis", "e_cre", "energy^1/2"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.contains("smallest eta_nndd at solver.theta = 0.4") && svg.contains("1 of 3 diverged"));
}

#[test]
fn sweep_of_nothing_says_so() {
    let empty = SweepPanel { name: "e".into(), ..SweepPanel::default() };
    for panels in [vec![], vec![empty], vec![constant("lost", None)], vec![constant("zero", Some(0.0))]] {
        let svg = sweep("Sweep", "theta", &VALUES, &panels);
        assert_whole(&svg);
        assert!(svg.contains("no data"));
    }
    for bad in BAD {
        let panels = [constant("bad", Some(bad)), constant("good", Some(1.0))];
        assert_whole(&sweep("Sweep", "theta", &[0.2, bad, 0.6], &panels));
    }
}

#[test]
fn convergence_shows_only_what_was_computed() {
    let svg = convergence("Convergence", &rows(12));
    assert_whole(&svg);
    assert!(svg.contains("eta_nndd") && svg.contains("precision") && svg.contains("eta_dis"));
    assert!(!svg.contains("e_cre (total"), "a legend entry without data");
    assert!(svg.contains("1e-3"), "logarithmic ticks");
}

#[test]
fn convergence_of_odd_rows() {
    assert!(convergence("None", &[]).contains("no data"));
    assert_whole(&convergence("One", &rows(1)));
    for bad in BAD.into_iter().chain([0.0, -1.0]) {
        let mut odd = rows(5);
        odd[2].eta_nndd = Some(bad);
        odd[3].precision = Some(bad);
        odd[1].eta_dis = Some(bad);
        odd[4].e_cre = Some(bad);
        assert_whole(&convergence("Odd", &odd));
    }
    let mut many = rows(20_000);
    for (k, row) in many.iter_mut().enumerate() {
        row.eta_nndd = Some(if k % 2 == 0 { 1e-9 } else { 1.0 });
        row.precision = row.eta_nndd;
        row.e_cre = row.eta_nndd;
    }
    assert_whole(&convergence("Many", &many));
}

#[test]
fn contact_shades_where_there_is_pressure() {
    let svg = profile([0.0, 0.5, 1.0, 1.5, 2.0], [0.0, 0.0, 0.0, 0.1, 0.3], [3.0, 2.0, 1.0, 0.0, 0.0]);
    assert_whole(&svg);
    assert!(svg.contains("Contact zone: 0 to 1.25."), "{svg}");
    for text in ["pressure", "opening", "contact zone", "length units"] {
        assert!(svg.contains(text), "{text}");
    }
}

#[test]
fn contact_of_odd_profiles() {
    let empty = profile([], [], []);
    assert_whole(&empty);
    assert!(empty.contains("no data"));
    assert_whole(&profile([1.0], [0.0], [2.0]));
    assert!(profile([0.0, 1.0], [1.0; 2], [0.0; 2]).contains("pressure is zero everywhere"));
    for bad in BAD {
        let values = [1.0, bad, 2.0];
        for (s, opening, pressure) in [
            ([0.0, bad, 1.0], [0.0; 3], [1.0; 3]),
            ([0.0, 0.5, 1.0], values, [1.0; 3]),
            ([0.0; 3], [0.0; 3], values),
        ] {
            assert_whole(&profile(s, opening, pressure));
        }
    }
}

#[test]
fn a_peak_of_the_pressure_is_cut_and_its_value_written() {
    let s: [f64; 30] = std::array::from_fn(|k| k as f64);
    let mut pressure = [1.0; 30];
    let smooth = profile(s, [0.0; 30], pressure);
    assert!(!smooth.contains(">peak"), "{smooth}");
    pressure[0] = 40.0;
    let cut = profile(s, [0.0; 30], pressure);
    assert_whole(&cut);
    assert!(cut.contains(">peak 40</text>"), "{cut}");
    // What the axis shows ends a little above the others, and nothing is drawn above it.
    assert!(cut.contains(">1.0</text>") && !cut.contains(">40</text>"), "{cut}");
    // A smooth maximum is no peak, however narrow its contact is.
    let hertz: [f64; 30] = std::array::from_fn(|k| (1.0 - ((k as f64 - 14.5) / 15.0).powi(2)).sqrt());
    assert!(!profile(s, [0.0; 30], hertz).contains(">peak"));
}

#[test]
fn labels_have_the_units_of_the_case() {
    let units = [("units.length", "mm"), ("units.force", "N")].map(|(key, name)| (key.into(), name.into()));
    let labels =
        Labels { units: case_io::Case::parse(case_io::template::PAPER, "c.toml", &units).unwrap().units };
    let row = |k: usize| ContactRow { s: k as f64, pressure: 1.0, opening: 0.1, ..ContactRow::default() };
    let svg = contact("Contact", &[row(0), row(1)], None, &labels);
    assert_whole(&svg);
    assert!(svg.contains("pressure [MPa]") && svg.contains("opening [mm]") && !svg.contains("units)"));
}

#[test]
fn friction_has_a_panel_with_its_limit() {
    let row = |k: usize, friction: Option<FrictionRow>| ContactRow {
        s: k as f64,
        pressure: 1.0,
        friction,
        ..ContactRow::default()
    };
    let rubs =
        |tangential: f64| Some(FrictionRow { tangential, slip: 0.0, limit: 4.0, state: "stick".into() });
    let drawn = |rows: &[ContactRow]| contact("Contact", rows, None, &Labels::default());
    let svg = drawn(&[row(0, rubs(-1.0)), row(1, rubs(4.0)), row(2, rubs(f64::NAN))]);
    assert_whole(&svg);
    assert!(svg.contains("its limit") && svg.contains("friction (stress units)"), "{svg}");
    assert!(!drawn(&[row(0, None), row(1, None)]).contains("friction"));
}

#[test]
fn a_singular_peak_does_not_take_the_scale() {
    let mesh = block(20, 0.0);
    let still = vec![Vector::zeros(); mesh.points().len()];
    let with = |peak: f64| {
        let mut values: Vec<f64> = mesh.points().iter().map(|p| 1.0 + p[0]).collect();
        values[0] = peak;
        let patch = [NodalPatch { triangles: mesh.triangles().to_vec(), values }];
        let body = BodyPicture { name: "b", mesh: &mesh, displacement: &still, field: Field::Nodes(&patch) };
        deformed("d", Quantity::VonMises, &[body], &[], &[], &Labels::default())
    };
    let [smooth, peaked] = [with(1.0), with(1000.0)];
    assert_whole(&peaked);
    assert!(smooth.contains("linear scale from 0 to 3.") && !smooth.contains("or more"), "{smooth}");
    assert!(peaked.contains("right end: or more, largest 1000"), "{peaked}");
    assert!(peaked.contains("scale from 0 to 2.") || peaked.contains("scale from 0 to 3"), "{peaked}");
    // A ring shows where it is.
    assert!(peaked.contains("fill=\"none\" stroke=\"#191919\"") && peaked.matches("<circle").count() == 1);
}

#[test]
fn deformed_says_its_factor_and_names() {
    let svg = picture(3, |p| [0.0, -0.02 * p[1]], |k| 1e-3 * (k + 1) as f64);
    assert_whole(&svg);
    // The largest displacement is 0.04 and the size 2: 0.16 / 0.04 = 4, rounded down.
    assert!(svg.contains("displacements × 2"), "factor");
    assert!(svg.contains("upper") && svg.contains("lower") && svg.contains("error density"));
}

#[test]
fn deformed_never_draws_bodies_into_each_other() {
    // Two blocks of size 2: the upper one comes down by 0.02 and closes a gap of as much.
    let factor = |gap: f64, approach: f64| {
        let mesh = block(2, 0.0);
        let body = BodyPicture {
            name: "b",
            mesh: &mesh,
            displacement: &vec![Vector::new(0.0, -0.02); mesh.points().len()],
            field: Field::Cells(&vec![1.0; mesh.triangles().len()]),
        };
        let svg = density("d", &[body], &[], &[Closing { gap, approach }]);
        svg.split("multiplied by ").nth(1).unwrap().split(". ").next().unwrap().parse::<f64>().unwrap()
    };
    assert_eq!(factor(0.02, 0.02), 1.0);
    assert_eq!(factor(0.0, 0.0), 5.0);
    assert_eq!(factor(0.02, -0.02), 5.0);
    // A gap that is given in the case file only: bodies that touch come together, so hardly any motion can be drawn.
    assert_eq!(factor(0.0, 0.02), 0.1);
    assert_eq!(factor(f64::NAN, f64::NAN), 5.0);
}

#[test]
fn deformed_of_odd_bodies() {
    let still = picture(2, |_| [0.0; 2], |_| 0.0);
    assert_whole(&still);
    assert!(still.contains("no displacement") && still.contains("zero everywhere"));
    assert!(density("Nothing", &[], &[], &[]).contains("no data"));
    assert_whole(&picture(2, |_| [0.1; 2], |_| 3.0));
    for bad in BAD {
        assert_whole(&picture(2, |p| [if p[0] == 1.0 { bad } else { 0.1 }, 0.0], |_| 1.0));
        assert_whole(&picture(2, |_| [0.1; 2], |k| if k == 1 { bad } else { 1.0 }));
        assert_whole(&picture(2, |_| [bad; 2], |_| bad));
    }
}

#[test]
fn many_cells_stay_a_small_file() {
    // As unlike from cell to cell as can be: no two neighbours share a shade.
    let noise = |k: usize| 10f64.powf(-4.0 * ((k * 2_654_435_761) % 1000) as f64 / 1000.0);
    for n in [50, 150] {
        assert_whole(&picture(n, |p| [0.0, -0.02 * p[1]], noise));
    }
}

#[test]
fn outline_of_a_block_goes_once_around() {
    let lines = outline(&block(4, 0.0));
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0].len(), 2 * (8 + 4) + 1);
    assert_eq!(lines[0].first(), lines[0].last());
}

#[test]
fn ticks_are_readable() {
    let written = |axis: Axis| -> Vec<String> { axis.major().iter().map(|m| m.1.clone()).collect() };
    assert_eq!(written(Axis::linear(0.0, 1.0, 5)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    assert_eq!(written(Axis::linear(0.0, 3e-7, 3)), ["0", "1e-7", "2e-7", "3e-7"]);
    assert_eq!(written(Axis::log(1e-4, 1.0, 8)), ["1e-4", "1e-3", "1e-2", "1e-1", "1e0"]);
    assert_eq!(written(Axis::log(0.09, 1.1, 8)), ["1e-1", "2e-1", "5e-1", "1e0"]);
    assert_eq!(written(Axis::whole(1, 4, 12)), ["1", "2", "3", "4"]);
    for (lo, hi) in [(1.0, 1.0), (0.0, 0.0), (-1e100, 1e100), (1e9, 1e9 + 1e-7), (0.0, 1e-160)] {
        let ticks = written(Axis::padded(lo, hi, 8)).len();
        assert!((2..=20).contains(&ticks), "{ticks} ticks between {lo} and {hi}");
    }
    for (lo, hi) in [(1.0, 1.0), (1e-100, 1e100), (0.95, 1.0), (2.0, 2.0000001), (3.0, 30.0)] {
        let ticks = written(Axis::log_padded(lo, hi, 8)).len();
        assert!((2..=20).contains(&ticks), "{ticks} ticks between {lo} and {hi}");
    }
}

#[test]
fn short_numbers() {
    for (value, text) in
        [(0.0, "0"), (0.45, "0.45"), (5.0, "5"), (1e5, "1e5"), (2.5e-7, "2.5e-7"), (-12.345, "-12.35")]
    {
        assert_eq!(short(value), text);
    }
}

#[test]
fn adaptive_shows_the_rate_and_the_target() {
    let steps = [(380, Some(0.19)), (1000, Some(0.06)), (4000, Some(0.029))];
    let svg = adaptive(Measure::CertifiedError, &steps, 0.03);
    assert_whole(&svg);
    for text in ["certified relative error", "N^(-1/2)", "target", "nodes of both bodies"] {
        assert!(svg.contains(text), "{text}");
    }
    let svg = adaptive(Measure::Residual, &steps, 0.03);
    assert!(
        svg.contains("relative residual, no bound") && !svg.to_lowercase().contains("certified"),
        "{svg}"
    );
}

#[test]
fn adaptive_of_odd_steps() {
    for steps in [vec![], vec![(10, None)], vec![(0, Some(0.1))]] {
        let svg = adaptive(Measure::CertifiedError, &steps, 0.03);
        assert_whole(&svg);
        assert!(svg.contains("no data"));
    }
    let one = adaptive(Measure::CertifiedError, &[(380, Some(0.2))], 0.1);
    assert_whole(&one);
    assert!(!one.contains("N^(-1/2)"), "a rate of one point");
    for bad in BAD.into_iter().chain([0.0, -1.0]) {
        assert_whole(&adaptive(Measure::Residual, &[(100, Some(0.1)), (200, Some(bad)), (400, None)], bad));
    }
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

const CIRCLE: RigidLine = RigidLine::Circle { centre: Vector::new(1.0, 3.0), radius: 2.0, inside: false };

fn rest() -> Motion {
    Motion { translation: Vector::zeros(), spin: 0.0, centre: Vector::zeros() }
}

fn obstacle(line: RigidLine, points: &[Vector], load: (Vector, f64)) -> ObstaclePicture<'_> {
    ObstaclePicture { line, points, motion: rest(), imposed: Vector::zeros(), load }
}

#[test]
fn sketch_shows_obstacles_and_what_moves_them() {
    let mesh = block(3, 0.0);
    let body =
        || SketchBody { name: "b", mesh: &mesh, edges: vec![], body_force: Vector::zeros(), rigid: vec![] };
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
fn deformed_moves_obstacles_as_much_as_bodies() {
    let mesh = block(2, 0.0);
    let down = vec![Vector::new(0.0, -0.02); mesh.points().len()];
    let body =
        || BodyPicture { name: "b", mesh: &mesh, displacement: &down, field: Field::Cells(&[1.0; 16]) };
    let points = [Vector::y(), Vector::new(2.0, 1.0)];
    let plane = RigidLine::Plane { point: Vector::y(), normal: -Vector::y() };
    let moving = ObstaclePicture {
        motion: Motion { translation: Vector::new(0.0, -0.02), ..rest() },
        ..obstacle(plane, &points, (Vector::zeros(), 0.0))
    };
    let still = obstacle(plane, &points, (Vector::zeros(), 0.0));
    let with = |o| density("d", &[body()], &[o], &[]);
    let [moving, still] = [with(moving), with(still)];
    assert_whole(&moving);
    assert!(moving.contains("rigid obstacle") && moving != still);
    assert!(!density("d", &[body()], &[], &[]).contains("rigid obstacle"));
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
            edges,
            body_force: Vector::repeat(bad),
            rigid: vec![load],
        };
        assert_whole(&drawn("Odd", &[body], &obstacles, &[]));
    }
}

#[test]
fn words_are_large_enough_for_a_telephone() {
    // At 390 pixels the page is 366 wide; 14 of 480 are then 10.7 pixels.
    let svg = convergence("Convergence", &rows(12));
    let sizes: Vec<f64> = svg
        .split("font-size=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().parse::<f64>().unwrap())
        .collect();
    let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(smallest * 366.0 / sheet::WIDTH >= 9.5, "{smallest}");
}
