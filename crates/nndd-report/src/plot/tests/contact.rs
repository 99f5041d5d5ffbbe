//! Pressure, opening and friction along a contact line.

use super::*;
use case_io::table::{ContactRow, FrictionRow};

fn profile<const N: usize>(s: [f64; N], opening: [f64; N], pressure: [f64; N]) -> String {
    let row =
        |k| ContactRow { s: Some(s[k]), opening: opening[k], pressure: pressure[k], ..ContactRow::default() };
    contact("Contact", &(0..N).map(row).collect::<Vec<_>>(), None, 2, &Labels::default()).0
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
    // The axis ends a little above the other values, and nothing is drawn above it.
    assert!(cut.contains(">1.0</text>") && !cut.contains(">40</text>"), "{cut}");
    // Its words keep off the line that comes down from it.
    let number = |text: &str, key: &str| -> f64 {
        text.split_once(key).unwrap().1.split_once('"').unwrap().0.parse().unwrap()
    };
    let words = cut.lines().find(|line| line.contains(">peak")).unwrap();
    let [x, y] = [" x=\"", " y=\""].map(|key| number(words, key));
    let marks = cut.lines().filter(|line| line.contains("<circle cx"));
    let mut beside = marks.map(|line| [number(line, " cx=\""), number(line, " cy=\"")]);
    assert!(beside.any(|[cx, cy]| cx < x && (cy - y).abs() < 40.0) && x > 420.0, "{words}");
    assert!(beside.all(|[cx, cy]| cx < x || (cy - y).abs() > 40.0), "{words}");
    // A smooth maximum is no peak, however narrow its contact is.
    let hertz: [f64; 30] = std::array::from_fn(|k| (1.0 - ((k as f64 - 14.5) / 15.0).powi(2)).sqrt());
    assert!(!profile(s, [0.0; 30], hertz).contains(">peak"));
}

#[test]
fn labels_have_the_units_of_the_case() {
    let units = [("units.length", "mm"), ("units.force", "N")].map(|(key, name)| (key.into(), name.into()));
    let labels = Labels {
        of_solids: false,
        units: case_io::Case::parse(case_io::template::PAPER, "c.toml", &units).unwrap().units,
    };
    let row =
        |k: usize| ContactRow { s: Some(k as f64), pressure: 1.0, opening: 0.1, ..ContactRow::default() };
    let (svg, caption) = contact("Contact", &[row(0), row(1)], None, 2, &labels);
    assert!(caption.contains("opening") && !caption.contains("riction"), "{caption}");
    assert_whole(&svg);
    assert!(svg.contains("pressure [MPa]") && svg.contains("opening [mm]") && !svg.contains("units)"));
    assert!(convergence("Convergence", &[], &labels).contains("indicators [√N], precision"));
}

#[test]
fn friction_has_a_panel_with_its_limit() {
    let row = |k: usize, friction: Option<FrictionRow>| ContactRow {
        s: Some(k as f64),
        pressure: 1.0,
        friction,
        ..ContactRow::default()
    };
    let rubs = |tangential: f64| {
        Some(FrictionRow { tangential, limit: 4.0, state: "stick".into(), ..FrictionRow::default() })
    };
    let drawn = |rows: &[ContactRow]| contact("Contact", rows, None, 2, &Labels::default()).0;
    let svg = drawn(&[row(0, rubs(-1.0)), row(1, rubs(4.0)), row(2, rubs(f64::NAN))]);
    assert_whole(&svg);
    assert!(svg.contains("friction limit") && svg.contains("friction (stress units)"), "{svg}");
    assert!(!drawn(&[row(0, None), row(1, None)]).contains("friction"));
    // Sticking and slipping stretches have two shades; without friction there is one.
    let slips = rubs(4.0).map(|of| FrictionRow { slip: 0.1, state: "slip".into(), ..of });
    let svg = drawn(&[row(0, rubs(1.0)), row(1, rubs(2.0)), row(2, slips.clone()), row(3, slips)]);
    assert!(svg.contains("It sticks: 0 to 1.5. It slips: 1.5 to 3."), "{svg}");
    assert!(svg.contains(">sticks<") && svg.contains(">slips<") && !svg.contains(">contact zone<"), "{svg}");
    assert!(drawn(&[row(0, None), row(1, None)]).contains(">contact zone<"));
}

#[test]
fn a_small_contact_zone_is_drawn_large() {
    let s: [f64; 60] = std::array::from_fn(|k| k as f64);
    let row = |k: usize| {
        let pressure = if (30..34).contains(&k) { 2.0 } else { 0.0 };
        ContactRow { s: Some(s[k]), pressure, opening: 0.1, ..ContactRow::default() }
    };
    let rows: Vec<ContactRow> = (0..60).map(row).collect();
    let (svg, caption) = contact("Contact", &rows, None, 2, &Labels::default());
    assert_whole(&svg);
    assert!(caption.contains("around the contact zone") && svg.contains("at 12 nodes"), "{svg}");
    let (_, whole) = contact("Contact", &rows[28..37], None, 2, &Labels::default());
    assert!(!whole.contains("around the contact zone"), "{whole}");
}

#[test]
fn the_figure_says_which_pressure_it_draws() {
    let row = |k: usize| ContactRow {
        s: Some(k as f64),
        pressure: [4.0, 1.0][k % 2],
        pressure_recovered: Some(2.5),
        ..ContactRow::default()
    };
    let rows: Vec<ContactRow> = (0..6).map(row).collect();
    let (svg, caption) = contact("Contact", &rows, None, 3, &Labels::default());
    assert_whole(&svg);
    assert!(svg.contains(">pressure, recovered over the cells of the coarser side</text>"), "{svg}");
    assert!(svg.contains("at most 2.50 (largest nodal pressure 4.00)"), "{svg}");
    assert!(
        caption.contains(
            "coarser side, at most 2.50. The largest nodal pressure, which the tables have, is 4.00."
        )
    );
    // Its peak differs from the peak of the tables, too.
    let mut peak: Vec<ContactRow> = (0..60).map(row).collect();
    peak[0].pressure_recovered = Some(40.0);
    assert!(contact("Contact", &peak, None, 3, &Labels::default()).0.contains(">recovered peak 40.0</text>"));
    // Nodes that match have one pressure.
    let matching: Vec<ContactRow> =
        rows.into_iter().map(|row| ContactRow { pressure_recovered: None, ..row }).collect();
    let (svg, caption) = contact("Contact", &matching, None, 3, &Labels::default());
    assert!(svg.contains(">pressure</text>") && svg.contains("contact pressure, at most 4.00;"), "{svg}");
    assert!(!svg.contains("recovered") && !caption.contains("recovered"), "{caption}");
}
