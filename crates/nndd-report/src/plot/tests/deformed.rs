//! The deformed bodies with a field.

use super::*;
use crate::nodal::NodalPatch;
use crate::plot::outline::outline;

fn picture(n: usize, u: impl Fn([f64; 2]) -> [f64; 2], density: impl Fn(usize) -> f64) -> String {
    let meshes = [block(n, 1.0), block(n, 0.0)];
    let fields = meshes.each_ref().map(|m| -> (Vec<Vector>, Vec<_>) {
        (
            m.points().iter().map(|p| u((*p).into()).into()).collect(),
            (0..m.cells().len()).map(&density).collect(),
        )
    });
    let bodies = [0, 1].map(|k| BodyPicture {
        name: ["upper", "lower"][k],
        mesh: &meshes[k],
        displacement: &fields[k].0,
        field: Field::Cells(&fields[k].1),
    });
    deformed("Two blocks", Quantity::ErrorDensity, &bodies, &[], &[], false, &Labels::default())
}

#[test]
fn a_singular_peak_does_not_take_the_scale() {
    let mesh = block(20, 0.0);
    let still = vec![Vector::zeros(); mesh.points().len()];
    let with = |peak: f64, infinite: bool| {
        let mut values: Vec<f64> = mesh.points().iter().map(|p| 1.0 + p[0]).collect();
        values[0] = peak;
        let patch = [NodalPatch { triangles: mesh.cells().to_vec(), values }];
        let body = BodyPicture { name: "b", mesh: &mesh, displacement: &still, field: Field::Nodes(&patch) };
        deformed("d", Quantity::VonMises, &[body], &[], &[], infinite, &Labels::default())
    };
    let [smooth, peaked, finite] = [with(1.0, true), with(1000.0, true), with(1000.0, false)];
    assert_whole(&peaked);
    assert!(smooth.contains("linear scale from 0 to 3.") && !smooth.contains("or more"), "{smooth}");
    assert!(peaked.contains("right end: or more, largest 1000"), "{peaked}");
    assert!(peaked.contains("scale from 0 to 2.") || peaked.contains("scale from 0 to 3"), "{peaked}");
    // A finite one does, and small values are still told apart.
    assert!(finite.contains("square-root scale from 0 to 1000") && !finite.contains("<circle"), "{finite}");
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
            field: Field::Cells(&vec![1.0; mesh.cells().len()]),
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
fn the_title_of_the_displacement_says_the_word_once() {
    let mesh = block(2, 0.0);
    let moved = vec![Vector::new(0.0, -0.02); mesh.points().len()];
    let values = vec![0.02; mesh.points().len()];
    let patch = [NodalPatch { triangles: mesh.cells().to_vec(), values }];
    let body = BodyPicture { name: "b", mesh: &mesh, displacement: &moved, field: Field::Nodes(&patch) };
    let svg = deformed("Displacement", Quantity::Displacement, &[body], &[], &[], false, &Labels::default());
    assert!(svg.contains("<title>Displacement (drawn × 5)</title>"), "{svg}");
}
