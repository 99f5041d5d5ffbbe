//! The colour scale of a field on some bodies: its ends by quantiles, what lies beyond them, and its bar.

use super::axis::{Axis, Kind, drawable, drawable_log, short};
use super::bands;
use super::colour::INK;
use super::labels::Labels;
use super::sheet::{self, FINE, Frame, PIXEL, SMALL, Sheet, Words, rectangle};
use crate::nodal::NodalPatch;
use fem_core::geometry::{Vector, cross};
use fem_core::mesh::TriMesh;
use fem_core::parallel::each_task;

/// One body of a picture.
pub(crate) struct BodyPicture<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Its mesh.
    pub(crate) mesh: &'a TriMesh,
    /// The displacement of each point.
    pub(crate) displacement: &'a [Vector],
    /// The field that its colours show.
    pub(crate) field: Field<'a>,
}

/// A field of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Field<'a> {
    /// One value for each triangle.
    Cells(&'a [f64]),
    /// Linear in the triangles of each patch; the patches make the whole body.
    Nodes(&'a [NodalPatch]),
}

/// The quantity that the colours of a picture show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// The certified squared error over the area, on a logarithmic scale.
    ErrorDensity,
    /// Von Mises' stress.
    VonMises,
    /// The size of the displacement.
    Displacement,
    /// The contact pressure.
    Pressure,
}

impl Quantity {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::ErrorDensity => "error density",
            Self::VonMises => "von Mises stress",
            Self::Displacement => "displacement",
            Self::Pressure => "contact pressure",
        }
    }

    pub(crate) fn label(self, labels: &Labels) -> String {
        match self {
            Self::ErrorDensity => labels.density(self.name()),
            Self::VonMises | Self::Pressure => labels.stress(self.name(), "stress units"),
            Self::Displacement => labels.length(self.name()),
        }
    }
}

/// Height of the colour bar.
pub(super) const BAR: f64 = 14.0 * PIXEL;
/// The part of the area that may lie beyond the upper end of the scale, and beyond the lower end of a logarithmic one.
const BEYOND: f64 = 0.005;
const BELOW: f64 = 0.05;
/// The scale ends at the largest value unless that is this many times larger than nearly all others.
const PEAK: [f64; 2] = [1.4, 4.0];
/// The stress is on a scale of square roots if half of the area is below this part of its largest value.
const SMALL_PART: f64 = 0.1;
/// The longest and the shortest logarithmic scale, as a ratio of its ends.
const LOGARITHMIC: [f64; 2] = [1e6, 10.0];
/// Ticks of the colour bar.
const TICKS: usize = 6;
/// The colour scale, and what is special about it.
pub(crate) struct Scale {
    pub(super) axis: Axis,
    /// Some values are below the lower end.
    pub(super) cut: bool,
    /// The largest value, if it is above the upper end.
    pub(super) largest: Option<f64>,
    /// The body and the node of that value.
    pub(super) peak: Option<(usize, usize)>,
    /// There is no value to show, or no positive one on a logarithmic scale.
    pub(super) empty: bool,
}

impl Scale {
    /// Chooses the scale for some bodies.
    ///
    /// * `infinite`: the largest value grows with every refinement, so that the scale may end below it. That of an error density always does.
    pub(super) fn of(quantity: Quantity, bodies: &[BodyPicture<'_>], infinite: bool) -> Scale {
        let of_bodies: Vec<Vec<[f64; 2]>> = each_task(bodies.len(), |b| samples(&bodies[b]));
        Scale::new(quantity, &of_bodies, largest_value(bodies), infinite)
    }

    /// Chooses the scale for some values.
    ///
    /// * `of_bodies`: of each body the values, each with the area or volume that has it.
    /// * `found`: the largest value that can be drawn, with its body and node.
    pub(crate) fn new(
        quantity: Quantity,
        of_bodies: &[Vec<[f64; 2]>],
        found: Option<(f64, Option<(usize, usize)>)>,
        infinite: bool,
    ) -> Scale {
        let logarithmic = quantity == Quantity::ErrorDensity;
        let usable = |v: f64| if logarithmic { drawable_log(v) } else { drawable(v) };
        let known = |[value, area]: &[f64; 2]| usable(*value) && drawable(*area);
        let by_body: Vec<Vec<[f64; 2]>> =
            of_bodies.iter().map(|body| body.iter().copied().filter(known).collect()).collect();
        let samples = by_body.concat();
        let found = found.filter(|(value, ..)| usable(*value));
        let Some((largest, place)) = found.filter(|(largest, _)| !samples.is_empty() && *largest > 0.0)
        else {
            let axis = if logarithmic { Axis::log(0.1, 10.0, TICKS) } else { Axis::linear(0.0, 1.0, TICKS) };
            return Scale { axis, cut: false, largest: None, peak: None, empty: true };
        };
        // A small body must not be beyond the scale as a whole.
        let nearly_all = match infinite || logarithmic {
            true => by_body.iter().map(|body| quantile(body, 1.0 - BEYOND)).fold(0.0, f64::max),
            false => largest,
        };
        let clipped = nearly_all > 0.0 && largest > PEAK[usize::from(logarithmic)] * nearly_all;
        let hi = if clipped { nearly_all } else { largest };
        let uneven = quantity == Quantity::VonMises
            && area(samples.iter().filter(|[value, _]| *value < SMALL_PART * hi)) > 0.5 * area(&samples);
        let axis = match logarithmic {
            true => {
                let lo = quantile(&samples, BELOW).max(hi / LOGARITHMIC[0]);
                Axis::log(lo.min(hi / LOGARITHMIC[1]), hi, TICKS)
            }
            false if uneven => Axis::root(hi, TICKS),
            false => Axis::linear(0.0, hi, TICKS),
        };
        let lower = axis.ends().0;
        let cut = of_bodies.iter().flatten().any(|[value, _]| *value < lower);
        let largest = clipped.then_some(largest);
        Scale { axis, cut, largest, peak: place.filter(|_| clipped), empty: false }
    }

    pub(crate) fn position(&self, value: f64) -> f64 {
        let logarithmic = self.axis.kind() == Kind::Log;
        match value {
            _ if self.empty => 0.0,
            // Zero is below every logarithmic scale.
            _ if logarithmic && value.is_finite() && value <= 0.0 => 0.0,
            _ if !drawable(value) || (logarithmic && !drawable_log(value)) => f64::NAN,
            _ => self.axis.position(value),
        }
    }

    /// Lists the ticks: their positions, with their labels.
    pub(crate) fn ticks(&self) -> Vec<(f64, &str)> {
        let labelled = self.axis.major().iter().filter(|_| !self.empty);
        labelled.map(|(value, label)| (self.axis.position(*value), label.as_str())).collect()
    }

    /// Draws the bar below a panel.
    pub(super) fn bar(&self, sheet: &mut Sheet, panel: Frame, quantity: Quantity, labels: &Labels) {
        let frame = Frame { top: panel.bottom() + sheet::BELOW + sheet::MARGIN, height: BAR, ..panel };
        if self.empty {
            return frame.remark(sheet, &format!("{} zero everywhere", quantity.name()));
        }
        let (left, right, bottom) = (frame.left, frame.right(), frame.bottom());
        for k in 0..bands::BANDS {
            // Each shade covers the bar from its left edge to the right; the next covers the rest: no seams.
            let x = left + k as f64 / bands::BANDS as f64 * frame.width;
            sheet.fill(&rectangle([x, right], [frame.top, bottom]), &bands::colour_of(k));
        }
        sheet.axis(&self.axis, [left, bottom], [right, bottom], &quantity.label(labels));
        if let Some(remark) = self.remark() {
            let below = bottom + sheet::BELOW + 4.0 * PIXEL;
            Words::new(SMALL).grey().write(sheet, &remark, [0.5 * (left + right), below]);
        }
        sheet.stroke(&rectangle([left, right], [frame.top, bottom]), INK, FINE);
    }

    /// Says what the ends of the scale leave out, if they do.
    pub(super) fn remark(&self) -> Option<String> {
        let more = self.largest.map(|largest| format!("right end: or more, largest {}", three(largest)));
        let less = self.cut.then(|| "left end: or less".to_owned());
        let root = (self.axis.kind() == Kind::Root).then(|| "scale of square roots".to_owned());
        let parts: Vec<String> = root.into_iter().chain(less).chain(more).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// A number with three significant digits.
pub(super) fn three(value: f64) -> String {
    short(format!("{value:.2e}").parse().unwrap_or(value))
}

/// The values of a body's triangles or nodes, each with its area; a node has a third of the triangles around it.
fn samples(body: &BodyPicture<'_>) -> Vec<[f64; 2]> {
    match body.field {
        Field::Cells(values) => values.iter().enumerate().map(|(t, v)| [*v, body.mesh.measure(t)]).collect(),
        Field::Nodes(patches) => {
            let of = |patch: &NodalPatch| -> Vec<[f64; 2]> {
                let mut samples: Vec<[f64; 2]> = patch.values.iter().map(|v| [*v, 0.0]).collect();
                for t in &patch.triangles {
                    let [a, b, c] = t.map(|v| body.mesh.points()[v]);
                    t.iter().for_each(|v| samples[v.index()][1] += cross(b - a, c - a).abs() / 6.0);
                }
                // The nodes of other patches have no area in this one.
                samples.retain(|[_, area]| *area != 0.0);
                samples
            };
            patches.iter().flat_map(of).collect()
        }
    }
}

fn area<'a>(samples: impl IntoIterator<Item = &'a [f64; 2]>) -> f64 {
    samples.into_iter().map(|[_, area]| area).sum()
}

/// The value that a part of the area lies below: in time proportional to the number of samples, because each step halves them.
fn quantile(samples: &[[f64; 2]], part: f64) -> f64 {
    let mut left = part * area(samples);
    let mut samples = samples.to_vec();
    let mut rest = &mut samples[..];
    while rest.len() > 1 {
        let middle = rest.len() / 2;
        rest.select_nth_unstable_by(middle, |a, b| a[0].total_cmp(&b[0]));
        let (lower, upper) = rest.split_at_mut(middle);
        let below = area(&*lower);
        rest = if left < below {
            lower
        } else {
            left -= below;
            upper
        };
    }
    rest.first().map_or(0.0, |s| s[0])
}

/// The largest value, with the body and the node that have it.
fn largest_value(bodies: &[BodyPicture<'_>]) -> Option<(f64, Option<(usize, usize)>)> {
    let of = |(k, body): (usize, &BodyPicture<'_>)| -> Vec<(f64, Option<(usize, usize)>)> {
        let node = |t: usize| body.mesh.cells()[t][0].index();
        match body.field {
            Field::Cells(values) => {
                values.iter().enumerate().map(|(t, v)| (*v, Some((k, node(t))))).collect()
            }
            Field::Nodes(patches) => {
                let values = patches.iter().flat_map(|patch| patch.values.iter().enumerate());
                values.map(|(node, v)| (*v, Some((k, node)))).collect()
            }
        }
    };
    let all = bodies.iter().enumerate().flat_map(of).filter(|(v, _)| drawable(*v));
    all.max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_the_first_sample_above_its_part_of_the_area() {
        // Values 0 to 99 in mixed order; equal values occur, and some samples have no area.
        let samples: Vec<[f64; 2]> = (0..300).map(|k| [f64::from(k * 37 % 100), f64::from(k % 3)]).collect();
        let mut sorted = samples.clone();
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
        for part in [0.0, 0.001, 0.3, 0.5, 0.98, 0.999] {
            let mut left = part * area(&samples);
            let expected = sorted.iter().find(|s| {
                left -= s[1];
                left < 0.0
            });
            assert_eq!(quantile(&samples, part), expected.unwrap()[0], "{part}");
        }
        assert_eq!(quantile(&samples, 1.0), 99.0);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
