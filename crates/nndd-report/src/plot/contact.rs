//! Pressure and opening along the contact.

use super::axis::{Axis, drawable, extent, short};
use super::colour::{BLUE, GREEN, GREY, PALE_BLUE, PALE_ORANGE, VERMILLION};
use super::labels::Labels;
use super::lines::{self, Band, LinePanel, Series, THICK, THIN};
use super::look::{Look, Marker};
use super::sheet::PIXEL;
use crate::words::with_digits;
use case_io::table::ContactRow;
use fem_core::geometry::Vector;

const PRESSURE: Look = Look::new("pressure", BLUE, THICK, Marker::Disc);
const RECOVERED: Look = Look { name: "pressure, recovered over the cells of the coarser side", ..PRESSURE };
const OPENING: Look = Look::new("opening", VERMILLION, THICK, Marker::Square);
const FRICTION: Look = Look::new("friction", GREEN, THICK, Marker::Disc);
const LIMIT: Look = Look::new("friction limit", GREY, THIN, Marker::None);
const HEIGHT: f64 = 170.0 * PIXEL;
const TICKS: usize = 5;
/// Pressures below this part of the largest count as zero.
const NONE: f64 = 1e-9;
/// Zones that the description lists.
const MOST_LISTED: usize = 6;

/// The pressure axis ends at the largest pressure unless that is this many times larger than on nearly all of the contact.
const PEAK: f64 = 1.8;
/// The part of the contact's length on which the pressure may be beyond the axis.
const BEYOND: f64 = 0.04;
/// How far the axis goes beyond the pressures that it shows, if it does not show all.
const ABOVE: f64 = 1.2;

/// Only the part of the line around the contact zone is drawn if it is less than this part of the line; half of it is this many times
/// the zone, and it has at least this many nodes.
const SMALL_PART: f64 = 0.6;
const WIDE: f64 = 1.5;
const FEWEST: usize = 8;

/// Draws the pressure above and the opening below, over a common axis, with the contact zone shaded, with friction in two shades for what
/// sticks and what slips; the pressure alone if the opening is zero everywhere.
///
/// A node with pressure shades half of the way to its neighbours. Nodes with a value that is not finite are
/// left out; nodes need not come in order. A peak on a small part of the contact is cut, and its value written.
///
/// * `start`: the arc length at which a closed line was opened, if it is not its first node.
/// * `digits`: of the largest pressures, as in the tables.
///
/// Returns the figure, and what there is to see on it.
pub(crate) fn contact(
    title: &str,
    rows: &[ContactRow],
    start: Option<f64>,
    digits: usize,
    labels: &Labels,
) -> (String, String) {
    let recovered = |r: &ContactRow| r.pressure_recovered.unwrap_or(r.pressure);
    let numbers = |r: &&ContactRow| [r.arc_length(), r.pressure, recovered(r), r.opening];
    let mut all: Vec<&ContactRow> = rows.iter().filter(|r| numbers(r).iter().all(|v| drawable(*v))).collect();
    all.sort_by(|a, b| a.arc_length().total_cmp(&b.arc_length()));
    let near = around(&all.iter().map(|r| [r.arc_length(), r.pressure]).collect::<Vec<_>>());
    all.retain(|r| near.is_none_or(|[from, to]| r.arc_length() >= from && r.arc_length() <= to));
    let slips: Vec<Option<bool>> =
        all.iter().map(|r| r.friction.as_ref().map(|f| f.state == "slip")).collect();
    // Nodes are in contact if their forces are positive; the pressure drawn is the recovered one.
    let forces: Vec<[f64; 2]> = all.iter().map(|r| [r.arc_length(), r.pressure]).collect();
    let nodes: Vec<[f64; 3]> = all.iter().map(|r| [r.arc_length(), recovered(r), r.opening]).collect();
    let touching = zones(&forces, |_| true);
    let [stick, slip] = [false, true].map(|state| zones(&forces, |i| slips[i] == Some(state)));
    let friction_zones = match slips.iter().any(Option::is_some) {
        true => format!(" It sticks: {}. It slips: {}.", written(&stick), written(&slip)),
        false => String::new(),
    };
    let x_axis = lines::linear_axis(extent(nodes.iter().map(|n| n[0])));
    let ends = [1, 2].map(|c| extent(nodes.iter().map(|n| n[c]).chain([0.0])).unwrap_or_default());
    // The tables have the largest nodal pressure, the axis the largest drawn one. They differ if the pressure is recovered.
    let nodal = with_digits(forces.iter().map(|n| n[1]).fold(0.0, f64::max), digits);
    let drawn = with_digits(ends[0].1, digits);
    let is_recovered = all.iter().any(|row| row.pressure_recovered.is_some());
    let (above, most) = match is_recovered {
        true => (RECOVERED.name, format!("{drawn} (largest nodal pressure {nodal})")),
        false => ("contact pressure", drawn.clone()),
    };
    let description = format!(
        "Above the {above}, at most {most}; below the opening, at most {}, along the contact at {} nodes. \
         Contact zone: {}.{friction_zones}",
        short(ends[1].1),
        nodes.len(),
        written(&touching)
    );
    let bands = match friction_zones.is_empty() {
        true => vec![Band::new("contact zone", PALE_ORANGE, touching)],
        false => vec![Band::new("sticks", PALE_BLUE, stick), Band::new("slips", PALE_ORANGE, slip)],
    };
    let cap = cap(&nodes);
    let axes = [(ends[0].0, cap.unwrap_or(ends[0].1)), ends[1]].map(upwards);
    let points = |c: usize| nodes.iter().map(|n| Vector::new(n[0], n[c])).collect::<Vec<_>>();
    let look = if is_recovered && ends[0] != (0.0, 0.0) { RECOVERED } else { PRESSURE };
    let series = [
        [Series { look, points: below(&points(1), axes[0].ends().1) }],
        [Series { look: OPENING, points: points(2).into_iter().map(Some).collect() }],
    ];
    let places = match start {
        Some(s) => format!("s along the first body's surface, from {}", short(s)),
        None => "s along the first body's surface".to_owned(),
    };
    let [s, pressure] = [labels.length(&places), labels.stress("pressure", "stress units")];
    let opening = labels.length("opening");
    // If the bodies touch everywhere, or nothing is known, there is no opening to see.
    let open = ends[1] != (0.0, 0.0);
    let count = if open { 2 } else { 1 };
    let rubs = friction(&all);
    let reach = extent(rubs.iter().flatten().flat_map(|series| series.points.iter().flatten().map(|p| p[1])));
    let friction_axis = both_ways(reach.unwrap_or_default());
    let friction_label = labels.stress("friction", "stress units");
    // The arc length is written below the last panel.
    let last = if rubs.is_some() { 2 } else { count - 1 };
    let below_panel = |k: usize| if k == last { s.as_str() } else { "" };
    let label = [[below_panel(0), pressure.as_str()], [below_panel(1), &opening]];
    let peak = nodes.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])).filter(|_| cap.is_some());
    let peak_name = if is_recovered { "recovered peak" } else { "peak" };
    let friction = rubs.as_ref().map(|series| LinePanel {
        bands: &bands,
        ..LinePanel::new([below_panel(2), &friction_label], [&x_axis, &friction_axis], series)
    });
    let panels = (0..count).map(|k| LinePanel {
        bands: &bands,
        remark: (ends[k] == (0.0, 0.0)).then(|| format!("{} is zero everywhere", series[k][0].look.name)),
        peak: peak.filter(|_| k == 0).map(|n| (n[0], format!("{peak_name} {}", with_digits(n[1], digits)))),
        ..LinePanel::new(label[k], [&x_axis, &axes[k]], &series[k])
    });
    let of_recovered = format!(
        "The pressure drawn is recovered over the cells of the coarser side, at most {drawn}. The largest nodal pressure, \
         which the tables have, is {nodal}."
    );
    let caption = [
        ("The pressure is zero where the bodies are apart.", true),
        ("The opening is zero where there is pressure.", open),
        ("Only the part around the contact zone is drawn.", near.is_some()),
        (of_recovered.as_str(), is_recovered),
        ("A peak grows with every refinement: its value is written.", cap.is_some()),
        ("Friction is that on the second body, between the two limits.", rubs.is_some()),
        (
            "Its limit is given, so that it acts where the bodies are apart, too.",
            all.iter().any(|row| rubs_apart(row)),
        ),
    ];
    let caption: Vec<&str> = caption.into_iter().filter(|(_, said)| *said).map(|(words, _)| words).collect();
    let svg = lines::figure(title, &description, HEIGHT, &panels.chain(friction).collect::<Vec<_>>());
    (svg, caption.join(" "))
}

/// Tells if there is friction without pressure.
fn rubs_apart(row: &ContactRow) -> bool {
    row.pressure <= 0.0 && row.friction.as_ref().is_some_and(|friction| friction.tangential != 0.0)
}

/// The part of the line that is drawn if the contact zone is a small part of it; `None`: all of it.
fn around(forces: &[[f64; 2]]) -> Option<[f64; 2]> {
    let [first, last] = [forces.first()?[0], forces.last()?[0]];
    let zones = zones(forces, |_| true);
    let [from, to] = [zones.first()?[0], zones.last()?[1]];
    let mut half = WIDE * (to - from);
    let part = |half: f64| [0.5 * (from + to) - half, 0.5 * (from + to) + half];
    let count = |[a, b]: [f64; 2]| forces.iter().filter(|[s, _]| *s >= a && *s <= b).count();
    while half > 0.0 && half < last - first && count(part(half)) < FEWEST {
        half *= WIDE;
    }
    (half > 0.0 && 2.0 * half < SMALL_PART * (last - first)).then(|| part(half))
}

/// The friction on the second body, and its limit in both directions; `None` without friction.
fn friction(rows: &[&ContactRow]) -> Option<[Series; 3]> {
    let mut nodes: Vec<[f64; 3]> = rows
        .iter()
        .filter_map(|r| r.friction.as_ref().map(|f| [r.arc_length(), f.tangential, f.limit]))
        .filter(|n| n.iter().all(|v| drawable(*v)))
        .collect();
    nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let line = |look: Look, value: fn(&[f64; 3]) -> f64| Series {
        look,
        points: nodes.iter().map(|n| Some(Vector::new(n[0], value(n)))).collect(),
    };
    let all = [line(FRICTION, |n| n[1]), line(LIMIT, |n| n[2]), line(LIMIT, |n| -n[2])];
    (!nodes.is_empty()).then_some(all)
}

/// An axis a little beyond the smallest and the largest value.
fn both_ways((lo, hi): (f64, f64)) -> Axis {
    if hi - lo <= 0.0 {
        return Axis::linear(-1.0, 1.0, TICKS);
    }
    let margin = 0.06 * (hi - lo);
    Axis::linear(lo - margin, hi + margin, TICKS)
}

/// Returns the end of the pressure axis if a peak on a small part of the contact must be cut.
fn cap(nodes: &[[f64; 3]]) -> Option<f64> {
    let last = nodes.len().checked_sub(1)?;
    let length = |i: usize| 0.5 * (nodes[(i + 1).min(last)][0] - nodes[i.saturating_sub(1)][0]);
    let pressed = (0..nodes.len()).filter(|i| nodes[*i][1] > 0.0);
    let mut all: Vec<[f64; 2]> = pressed.map(|i| [nodes[i][1], length(i)]).collect();
    all.sort_by(|a, b| b[0].total_cmp(&a[0]));
    let mut left = BEYOND * all.iter().map(|n| n[1]).sum::<f64>();
    let found = all.iter().find(|n| {
        left -= n[1];
        left < 0.0
    });
    let (nearly_all, largest) = (found?[0], all[0][0]);
    (largest > PEAK * nearly_all).then_some(ABOVE * nearly_all)
}

/// The part of a line that is not above a level, with the places where it passes the level.
fn below(points: &[Vector], level: f64) -> Vec<Option<Vector>> {
    let mut kept = vec![];
    for (k, p) in points.iter().enumerate() {
        if let Some(q) = k.checked_sub(1).map(|j| points[j])
            && (q[1] > level) != (p[1] > level)
        {
            kept.push(Some(q + (level - q[1]) / (p[1] - q[1]) * (p - q)));
        }
        kept.push(Some(*p).filter(|p| p[1] <= level));
    }
    kept
}

/// An axis from 0 (or the least value, if that is negative) to a little above the largest.
fn upwards((lo, hi): (f64, f64)) -> Axis {
    if hi - lo <= 0.0 {
        return Axis::linear(0.0, 1.0, TICKS);
    }
    let margin = 0.06 * (hi - lo);
    Axis::linear(lo - 0.4 * margin, hi + margin, TICKS)
}

/// The intervals of contact: around each node with pressure that is one of `which`, half of the way to its neighbours.
fn zones(nodes: &[[f64; 2]], which: impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
    let least = NONE * nodes.iter().map(|n| n[1]).fold(0.0, f64::max);
    let middle = |i: usize, j: usize| 0.5 * nodes[i][0] + 0.5 * nodes[j][0];
    let mut zones: Vec<[f64; 2]> = vec![];
    for i in (0..nodes.len()).filter(|i| nodes[*i][1] > least && which(*i)) {
        let (from, to) = (middle(i.saturating_sub(1), i), middle(i, (i + 1).min(nodes.len() - 1)));
        match zones.last_mut() {
            Some(zone) if zone[1] >= from => zone[1] = to,
            _ => zones.push([from, to]),
        }
    }
    zones
}

fn written(zones: &[[f64; 2]]) -> String {
    let mut parts: Vec<String> =
        zones.iter().take(MOST_LISTED).map(|z| format!("{} to {}", short(z[0]), short(z[1]))).collect();
    match zones.len() {
        0 => return "none".into(),
        n if n > MOST_LISTED => parts.push(format!("and {} more", n - MOST_LISTED)),
        _ => {}
    }
    parts.join(", ")
}
