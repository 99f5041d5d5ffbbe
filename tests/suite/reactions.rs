//! Reactions of supports that share nodes: each has its direction, and together they carry the loads.

use case_io::Case;
use certified_contact::{Results, Settings, Silent, solve};
use fem_core::geometry::{Vector, cross, norm};

/// Solves a case of one body and asserts that its forces are in balance; `loads` is their sum, N/m.
fn results(body: &str, loads: Vector) -> Results {
    let text = format!(
        "schema = 1\ncontact = []\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n[[body]]\nname = \"body\"\nmaterial = \"m\"\n{body}"
    );
    let problem = Case::parse(&text, "case.toml", &[]).unwrap().build().unwrap().0;
    let answer = solve(problem, &Settings::default(), &mut Silent).unwrap();
    assert!(answer.is_certified());
    let results = answer.results.unwrap();
    let scale = norm(loads);
    for balance in &results.balance {
        assert!(norm(balance.force).max(balance.moment.abs()) < 1e-11 * scale, "{balance:?}");
    }
    let held: Vector = results.reactions.iter().map(|reaction| reaction.force).sum();
    assert!(norm(held + loads) < 1e-11 * scale, "{held:?}");
    results
}

fn force(results: &Results, on: &str) -> Vector {
    results.reactions.iter().find(|reaction| reaction.on == on).unwrap().force
}

#[test]
fn an_inclined_roller_beside_another_support_keeps_its_direction() {
    let end = Vector::new(-(60.0f64.to_radians().sin()), 60.0f64.to_radians().cos());
    for inner in ["ux = 0.0", "uy = 0.0", "fixed = true"] {
        // The order of the supports changes the share of the common node, not the sum.
        let roller = "[[body.displacement]]\non = \"end\"\nnormal = 0.0\n";
        let other = format!("[[body.displacement]]\non = \"inner\"\n{inner}\n");
        for supports in [[roller, &other], [&other, roller]] {
            let text = format!(
                "generator = {{ kind = \"ring\", radii = [1.0, 2.0], angles = [0.0, 60.0], cells = [12, 6] }}\n{}\
                 [[body.displacement]]\non = \"start\"\nuy = 0.0\n[[body.traction]]\non = \"outer\"\nvector = [-1.0, -2.0]\n",
                supports.concat()
            );
            // The outer side is a polygon of 12 edges.
            let length = 24.0 * 2.0 * (2.5f64).to_radians().sin();
            let found = results(&text, length * Vector::new(-1.0, -2.0));
            let along = force(&found, "end");
            assert!(cross(along, end).abs() < 1e-11 * length, "{inner}: {along:?}");
            assert!(force(&found, "start")[0] == 0.0);
            let along = force(&found, "inner");
            match inner {
                "ux = 0.0" => assert!(along[1].abs() < 1e-11 * length, "{along:?}"),
                "uy = 0.0" => assert!(along[0].abs() < 1e-11 * length, "{along:?}"),
                _ => {}
            }
        }
    }
}

#[test]
fn a_roller_around_a_corner_holds_both_components_there() {
    let text = "generator = { kind = \"block\", size = [2.0, 1.0], cells = [8, 4] }
[[body.side]]
name = \"corner\"
box = { x = [0.0, 2.0], y = [0.0, 0.0] }
[[body.displacement]]
on = [\"left\", \"corner\"]
normal = 0.0
[[body.traction]]
on = \"top\"
vector = [-3.0, -5.0]
";
    results(text, Vector::new(-6.0, -10.0));
}

#[test]
fn supports_at_the_corners_of_a_rigid_side_take_its_force_and_moment() {
    // Its rotation is held by the two corners, and nothing else holds the block.
    let text = "generator = { kind = \"block\", size = [2.0, 1.0], cells = [8, 4] }
[[body.displacement]]
on = \"left\"
uy = 0.0
[[body.displacement]]
on = \"right\"
fixed = true
[[body.rigid]]
on = \"top\"
force = [0.0, -10.0]
moment = 3.0
";
    let found = results(text, Vector::new(0.0, -10.0));
    let side = &found.rigid_sides[0];
    assert!(norm(side.force - Vector::new(0.0, -10.0)) < 1e-9, "{side:?}");
    assert!((side.moment - 3.0).abs() < 1e-9, "{side:?}");
    assert!(force(&found, "left")[0] == 0.0);
}
