//! Pressure and opening along the contact.

use super::axis::{Axis, drawable, extent, short};
use super::colour::{BLUE, VERMILLION};
use super::lines::{self, LinePanel, Series, THICK};
use super::look::{Look, Marker};
use super::sheet::PIXEL;
use case_io::table::ContactRow;
use fem_core::geometry::Vector;

const PRESSURE: Look = Look::new("pressure", BLUE, THICK, Marker::Disc);
const OPENING: Look = Look::new("opening", VERMILLION, THICK, Marker::Square);
const HEIGHT: f64 = 170.0 * PIXEL;
const TICKS: usize = 5;
/// Pressures below this part of the largest count as zero.
const NONE: f64 = 1e-9;
/// Zones that the description lists.
const MOST_LISTED: usize = 6;

/// Draws the pressure above and the opening below, over a common axis, with the contact zone shaded.
///
/// A node with pressure shades half of the way to its neighbours. Nodes with a value that is not finite are
/// left out; nodes need not come in order.
pub(crate) fn contact(title: &str, rows: &[ContactRow]) -> String {
    let mut nodes: Vec<[f64; 3]> = rows
        .iter()
        .map(|r| [r.s, r.pressure, r.opening])
        .filter(|n| n.iter().all(|v| drawable(*v)))
        .collect();
    nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let zones = zones(&nodes);
    let x_axis = lines::linear_axis(extent(nodes.iter().map(|n| n[0])));
    let ends = [1, 2].map(|c| extent(nodes.iter().map(|n| n[c]).chain([0.0])).unwrap_or_default());
    let description = format!(
        "Above the contact pressure, at most {}; below the opening, at most {}, along the contact at {} nodes. \
         Contact zone: {}.",
        short(ends[0].1),
        short(ends[1].1),
        nodes.len(),
        written(&zones)
    );
    let axes = ends.map(upwards);
    let series = [(PRESSURE, 1), (OPENING, 2)].map(|(look, c)| {
        [Series { look, points: nodes.iter().map(|n| Some(Vector::new(n[0], n[c]))).collect() }]
    });
    let labels = [
        ["", "pressure (stress units)"],
        ["s along the first body's surface (length units)", "opening (length units)"],
    ];
    let panels = [0, 1].map(|k| LinePanel {
        bands: &zones,
        remark: (ends[k] == (0.0, 0.0)).then(|| format!("{} is zero everywhere", series[k][0].look.name)),
        ..LinePanel::new(labels[k], [&x_axis, &axes[k]], &series[k])
    });
    lines::figure(title, &description, HEIGHT, &panels)
}

/// An axis from 0 (or the least value, if that is negative) to a little above the largest.
fn upwards((lo, hi): (f64, f64)) -> Axis {
    if hi - lo <= 0.0 {
        return Axis::linear(0.0, 1.0, TICKS);
    }
    let margin = 0.06 * (hi - lo);
    Axis::linear(lo - 0.4 * margin, hi + margin, TICKS)
}

/// The intervals of contact: around each node with pressure, half of the way to its neighbours.
fn zones(nodes: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let least = NONE * nodes.iter().map(|n| n[1]).fold(0.0, f64::max);
    let middle = |i: usize, j: usize| 0.5 * nodes[i][0] + 0.5 * nodes[j][0];
    let mut zones: Vec<[f64; 2]> = vec![];
    for i in (0..nodes.len()).filter(|i| nodes[*i][1] > least) {
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
