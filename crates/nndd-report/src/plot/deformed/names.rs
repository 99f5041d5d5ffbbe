//! The names of the deformed bodies, beside the panel or above it.

use super::{BESIDE, BodyPicture, moved};
use crate::plot::PlotError;
use crate::plot::axis::extent;
use crate::plot::colour::INK;
use crate::plot::sheet::{self, Area, Chart, Frame, UNITS, Words};
use plotters::element::{Circle, PathElement};
use plotters::style::Color;

/// Writes the bodies' names beside the panel at the height of each, or above it for bodies side by side.
pub(super) fn names(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    bodies: &[BodyPicture<'_>],
    factor: f64,
    frame: Frame,
) -> Result<(), PlotError> {
    let mut middles: Vec<(&str, [i32; 2], usize)> = vec![];
    for (number, body) in bodies.iter().enumerate() {
        let places = || (0..body.points.len()).filter_map(|i| moved(body, i, factor));
        if let (Some(x), Some(y)) = (extent(places().map(|p| p[0])), extent(places().map(|p| p[1]))) {
            let m = chart.backend_coord(&(0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)));
            middles.push((body.name, [m.0 / UNITS, m.1 / UNITS], number));
        }
    }
    let spread = |c: usize| extent(middles.iter().map(|m| f64::from(m.1[c]))).map_or(0.0, |e| e.1 - e.0);
    let beside = spread(1) >= spread(0);
    middles.sort_by_key(|m| if beside { m.1[1] } else { m.1[0] });
    let mut free = i32::MIN;
    let nested = nested(bodies, factor);
    for (name, [x, y], number) in middles {
        let room =
            if beside { f64::from(BESIDE - 12) } else { f64::from(frame.width) / bodies.len().max(1) as f64 };
        let letters = (room / (0.54 * 10.0)) as usize;
        let name: String = if name.chars().count() <= letters {
            name.to_owned()
        } else {
            name.chars().take(letters.saturating_sub(1)).chain(['…']).collect()
        };
        let size = sheet::fitting(&name, 14.0, room);
        if beside {
            let y = y.max(free);
            let at = (frame.left + frame.width + 8, y);
            Words::new(size).flush_left().write(area, &name, at)?;
            if nested {
                leader(area, chart, &bodies[number], factor, (at.0 * UNITS - 2 * UNITS, at.1 * UNITS))?;
            }
            free = y + 18;
        } else {
            let half = (0.5 * sheet::width_of(&name, size)) as i32;
            let x = x.max(free.saturating_add(half)).max(half + 4);
            Words::new(size).write(area, &name, (x, frame.top - 13))?;
            free = x + half + 10;
        }
    }
    Ok(())
}

/// Says whether bodies are at the same height, so that a name beside the panel may be that of either.
fn nested(bodies: &[BodyPicture<'_>], factor: f64) -> bool {
    let heights: Vec<(f64, f64)> = bodies
        .iter()
        .filter_map(|b| extent((0..b.points.len()).filter_map(|i| moved(b, i, factor)).map(|p| p[1])))
        .collect();
    heights.iter().enumerate().any(|(k, a)| {
        heights[..k].iter().any(|b| {
            let shared = a.1.min(b.1) - a.0.max(b.0);
            shared > 0.3 * (a.1 - a.0).min(b.1 - b.0)
        })
    })
}

/// Draws a line from a name to the nearest cell of its body, which gets a dot.
fn leader(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    body: &BodyPicture<'_>,
    factor: f64,
    from: (i32, i32),
) -> Result<(), PlotError> {
    let middle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| moved(body, v as usize, factor));
        let [a, b, c] = [a?, b?, c?];
        Some(chart.backend_coord(&((a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0)))
    };
    let far = |p: &(i32, i32)| i64::from(p.0 - from.0).pow(2) + i64::from(p.1 - from.1).pow(2);
    let Some(to) = body.triangles.iter().filter_map(middle).min_by_key(far) else { return Ok(()) };
    area.draw(&PathElement::new(vec![from, to], INK.stroke_width(3)))?;
    Ok(area.draw(&Circle::new(to, 2 * UNITS, INK.filled()))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::deformed;

    #[test]
    fn bodies_at_one_height_have_lines_from_their_names() {
        let dots = |offset: [f64; 2]| {
            let low = [[0.0, 0.0], [4.0, 0.0], [0.0, 2.0]];
            let high = low.map(|[x, y]| [x + offset[0], y + offset[1]]);
            let body = |name, points| BodyPicture {
                name,
                points,
                triangles: &[[0, 1, 2]],
                displacement: &[[0.0; 2]; 3],
                density: &[1.0],
            };
            let svg = deformed("Two", &[body("low", &low), body("high", &high)], &[]).unwrap();
            assert!(svg.contains("low") && svg.contains("high"));
            svg.matches("<circle").count()
        };
        assert_eq!(dots([0.0, 2.0]), 0);
        assert_eq!(dots([0.0, 0.5]), 2);
    }
}
