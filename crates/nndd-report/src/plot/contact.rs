//! Pressure and opening along the contact.

use super::PlotError;
use super::axis::{Axis, drawable, short};
use super::colour::{BLUE, ORANGE, PALE_ORANGE, VERMILLION};
use super::legend;
use super::look::{Look, Marker};
use super::series::{self, Series};
use super::sheet::{self, Area, Chart, Frame, Labels, TITLE, Words};
use plotters::element::Rectangle;
use plotters::style::Color;

/// Pressure and opening at the nodes of the contact, for [`contact`].
pub(crate) struct ContactProfile<'a> {
    /// Arc length along the first body's surface, one entry per node.
    pub(crate) s: &'a [f64],
    /// Current opening, ≥ 0.
    pub(crate) opening: &'a [f64],
    /// Contact pressure, ≥ 0.
    pub(crate) pressure: &'a [f64],
}

const PRESSURE: Look =
    Look { name: "pressure", colour: BLUE, dash: None, marker: Marker::Disc, thickness: 8 };
const OPENING: Look =
    Look { name: "opening", colour: VERMILLION, dash: None, marker: Marker::Square, thickness: 8 };
const ZONE: Look =
    Look { name: "contact zone", colour: PALE_ORANGE, dash: None, marker: Marker::None, thickness: 48 };
const PANEL: i32 = 170;
/// Pressures below this part of the largest count as zero.
const NONE: f64 = 1e-9;

/// Draws the pressure above and the opening below, over a common axis, with the contact zone shaded.
///
/// A node with pressure shades half of the way to its neighbours. Nodes with a value that is not finite are
/// left out; nodes need not come in order.
///
/// # Errors
/// [`PlotError::Length`] if the three arrays differ in length.
pub(crate) fn contact(title: &str, profile: &ContactProfile<'_>) -> Result<String, PlotError> {
    super::same_length("opening along the contact", profile.s.len(), profile.opening.len())?;
    super::same_length("pressure along the contact", profile.s.len(), profile.pressure.len())?;
    let mut nodes: Vec<[f64; 3]> = (0..profile.s.len())
        .map(|i| [profile.s[i], profile.pressure[i], profile.opening[i]])
        .filter(|n| n.iter().all(|v| drawable(*v)))
        .collect();
    nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let zones = zones(&nodes);
    let largest = |k: usize| nodes.iter().map(|n| n[k]).fold(0.0, f64::max);
    let x_axis = match (nodes.first(), nodes.last()) {
        (Some(a), Some(b)) => Axis::padded(a[0], b[0], 8),
        _ => Axis::linear(0.0, 1.0, 8),
    };
    let panels = [(PRESSURE, 1, "pressure (stress units)"), (OPENING, 2, "opening (length units)")];
    let description = format!(
        "Above the contact pressure, at most {}; below the opening, at most {}, along the contact at {} nodes. \
         Contact zone: {}.",
        short(largest(1)),
        short(largest(2)),
        nodes.len(),
        if zones.is_empty() { "none".to_owned() } else { written(&zones) }
    );

    let each = 14 + PANEL + sheet::BELOW;
    let entries: &[Look] = if zones.is_empty() { &[PRESSURE, OPENING] } else { &[PRESSURE, OPENING, ZONE] };
    let head = TITLE + legend::height(entries);
    sheet::figure(head + 2 * each + 8, title, &description, |area| {
        legend::draw(area, TITLE, entries)?;
        for (k, (look, column, label)) in panels.into_iter().enumerate() {
            let top = head + 14 + k as i32 * each;
            let frame = Frame::wide(top, PANEL);
            let x = if k == 1 { "s along the first body's surface (length units)" } else { "" };
            let labels = Labels { x, y: label, grid: true };
            let values = nodes.iter().map(|n| n[column]);
            let (lo, hi) = (values.clone().fold(0.0, f64::min), values.fold(0.0, f64::max));
            let chart = sheet::panel(area, frame, (x_axis.clone(), upwards(lo, hi)), &labels)?;
            shade(area, &chart, &zones, frame)?;
            let points = nodes.iter().map(|n| Some((n[0], n[column]))).collect();
            series::draw(area, &chart, &Series { look, points })?;
            if nodes.is_empty() {
                sheet::no_data(area, frame)?;
            } else if lo == 0.0 && hi == 0.0 {
                let text = format!("{} is zero everywhere", look.name);
                Words::new(14.0).grey().write(
                    area,
                    &text,
                    (frame.left + frame.width / 2, top + PANEL / 2),
                )?;
            }
        }
        Ok(String::new())
    })
}

/// An axis from 0 (or the least value, if that is negative) to a little above the largest.
fn upwards(lo: f64, hi: f64) -> Axis {
    if hi - lo <= 0.0 {
        return Axis::linear(0.0, 1.0, 5);
    }
    let margin = 0.06 * (hi - lo);
    Axis::linear(lo - 0.4 * margin, hi + margin, 5)
}

/// The intervals of contact: around each node with pressure, half of the way to its neighbours.
fn zones(nodes: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let least = NONE * nodes.iter().map(|n| n[1]).fold(0.0, f64::max);
    let s = |i: usize| nodes[i][0];
    let mut zones: Vec<[f64; 2]> = vec![];
    for i in (0..nodes.len()).filter(|i| nodes[*i][1] > least) {
        let from = if i == 0 { s(0) } else { 0.5 * s(i - 1) + 0.5 * s(i) };
        let to = if i + 1 == nodes.len() { s(i) } else { 0.5 * s(i) + 0.5 * s(i + 1) };
        match zones.last_mut() {
            Some(zone) if zone[1] >= from => zone[1] = to,
            _ => zones.push([from, to]),
        }
    }
    zones
}

fn written(zones: &[[f64; 2]]) -> String {
    let mut parts: Vec<String> =
        zones.iter().take(6).map(|z| format!("{} to {}", short(z[0]), short(z[1]))).collect();
    if zones.len() > 6 {
        parts.push(format!("and {} more", zones.len() - 6));
    }
    parts.join(", ")
}

fn shade(area: &Area<'_>, chart: &Chart<'_, '_>, zones: &[[f64; 2]], frame: Frame) -> Result<(), PlotError> {
    let units = sheet::UNITS;
    let (top, bottom) = (frame.top * units, (frame.top + frame.height) * units);
    let mut drawn: Option<i32> = None;
    for [from, to] in zones {
        let (a, b) = (chart.backend_coord(&(*from, 0.0)).0, chart.backend_coord(&(*to, 0.0)).0);
        // A great many zones narrower than a unit are drawn once.
        if drawn.is_some_and(|end| b <= end) {
            continue;
        }
        area.draw(&Rectangle::new([(a, top), (b.max(a + units), bottom)], ORANGE.mix(0.22).filled()))?;
        drawn = Some(b.max(a + units));
    }
    Ok(())
}
