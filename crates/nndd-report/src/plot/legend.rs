//! Legends: a sample and a name per series, in as many rows as it takes.

use super::look::Look;
use super::sheet::{LEFT, MARGIN, PIXEL, SMALL, Sheet, TITLE, WIDTH, Words, width_of};
use fem_core::geometry::Vector;

/// Height of one row.
const ROW: f64 = 22.0 * PIXEL;
/// Length of a legend's sample, and the room behind it.
const SAMPLE: f64 = 28.0 * PIXEL;
const BEHIND_SAMPLE: f64 = 6.0 * PIXEL;
/// Room behind an entry.
const BEHIND_ENTRY: f64 = 14.0 * PIXEL;

/// The rows of a legend: as many entries in each as there is room for.
fn rows(entries: &[Look]) -> Vec<&[Look]> {
    let (mut rows, mut start, mut used) = (vec![], 0, 0.0);
    for (k, entry) in entries.iter().enumerate() {
        let needed = entry_width(entry);
        if used + needed > WIDTH - 2.0 * MARGIN && k > start {
            rows.push(&entries[start..k]);
            (start, used) = (k, 0.0);
        }
        used += needed;
    }
    rows.push(&entries[start..]);
    rows
}

fn entry_width(entry: &Look) -> f64 {
    SAMPLE + BEHIND_SAMPLE + width_of(entry.name, SMALL) + BEHIND_ENTRY
}

/// Returns the height at which a legend below the title ends.
pub(super) fn end(entries: &[Look]) -> f64 {
    TITLE + ROW * rows(entries).len() as f64
}

/// Draws a legend below the title, from the left of the panels, in as many rows as it takes.
pub(super) fn draw(sheet: &mut Sheet, entries: &[Look]) {
    let rows = rows(entries);
    let width = |row: &&[Look]| row.iter().map(entry_width).sum::<f64>();
    // Beside the axis labels if there is room for the widest row, otherwise further left.
    let left = LEFT.min(WIDTH - MARGIN - rows.iter().map(width).fold(0.0, f64::max)).max(MARGIN);
    for (k, row) in rows.into_iter().enumerate() {
        let mut x = left;
        let y = TITLE + ROW * (k as f64 + 0.5);
        for entry in row {
            sheet.line(entry, &[Vector::new(x, y), Vector::new(x + SAMPLE, y)]);
            sheet.mark(entry, [x + 0.5 * SAMPLE, y]);
            Words::new(SMALL).flush_left().write(sheet, entry.name, [x + SAMPLE + BEHIND_SAMPLE, y]);
            x += entry_width(entry);
        }
    }
}
