//! Legends: a sample and a name per series, in as many rows as it takes.

use super::PlotError;
use super::look::{Look, mark, stroke};
use super::sheet::{Area, LEFT, SMALL, UNITS, WIDTH, Words, width_of};

/// Height of one row.
const ROW: i32 = 22;
/// Length of a legend's sample and the room behind an entry.
const SAMPLE: i32 = 28;
const SPACE: i32 = 14;

/// The rows of a legend: as many entries in each as there is room for.
fn rows(entries: &[Look]) -> Vec<Vec<Look>> {
    let mut rows: Vec<Vec<Look>> = vec![];
    let mut used = 0;
    for entry in entries {
        let needed = entry_width(entry);
        match rows.last_mut() {
            Some(row) if used + needed <= WIDTH - 20 => row.push(*entry),
            _ => {
                rows.push(vec![*entry]);
                used = 0;
            }
        }
        used += needed;
    }
    rows
}

fn entry_width(entry: &Look) -> i32 {
    width_of(entry.name, SMALL).ceil() as i32 + SAMPLE + 6 + SPACE
}

/// The height of a legend.
pub(super) fn height(entries: &[Look]) -> i32 {
    ROW * rows(entries).len() as i32
}

/// Draws a legend from a little left of the panels, in as many rows as it takes.
pub(super) fn draw(area: &Area<'_>, top: i32, entries: &[Look]) -> Result<(), PlotError> {
    for (k, row) in rows(entries).iter().enumerate() {
        let width: i32 = row.iter().map(entry_width).sum();
        // Beside the axis labels if there is room, otherwise further left.
        let mut x = LEFT.min(WIDTH - 10 - width).max(10);
        let y = top + ROW / 2 + ROW * k as i32;
        for entry in row {
            stroke(area, entry, &[(x * UNITS, y * UNITS), ((x + SAMPLE) * UNITS, y * UNITS)])?;
            mark(area, entry, ((x + SAMPLE / 2) * UNITS, y * UNITS))?;
            Words::new(SMALL).flush_left().write(area, entry.name, (x + SAMPLE + 6, y))?;
            x += entry_width(entry);
        }
    }
    Ok(())
}
