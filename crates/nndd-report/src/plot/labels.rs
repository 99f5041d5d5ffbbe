//! The labels of axes and colour bars, with the units that the case names.

use case_io::case::Units;
use fem_core::space::Plane;

/// Names the quantities of a figure.
#[derive(Clone, Debug, Default)]
pub(crate) struct Labels {
    pub(crate) units: Option<Units>,
}

impl Labels {
    /// Labels a length: `x [mm]`, or `x (length units)` if the case has no units.
    pub(super) fn length(&self, what: &str) -> String {
        labelled(what, self.units.as_ref().map(|u| u.length.clone()), "length units")
    }

    /// Labels a force per unit thickness.
    pub(super) fn line_force(&self, what: &str) -> String {
        labelled(what, self.units.as_ref().map(Units::line_force), "force / thickness")
    }

    /// Labels an energy norm.
    pub(super) fn energy_norm(&self, what: &str) -> String {
        labelled(what, self.units.as_ref().map(Units::energy_norm::<Plane>), "energy^1/2")
    }

    /// Labels a stress, or an energy per area and thickness, which has the same unit.
    pub(super) fn stress(&self, what: &str, otherwise: &str) -> String {
        labelled(what, self.units.as_ref().map(Units::stress), otherwise)
    }
}

fn labelled(what: &str, unit: Option<String>, otherwise: &str) -> String {
    unit.map_or_else(|| format!("{what} ({otherwise})"), |unit| format!("{what} [{unit}]"))
}
