//! The labels of axes and colour bars, with the units that the case names.

use case_io::case::Units;
use fem_core::space::{Plane, Solid};

/// Names the quantities of a figure.
#[derive(Clone, Debug, Default)]
pub(crate) struct Labels {
    pub(crate) units: Option<Units>,
    /// True if the figures show solids, whose forces are not per unit thickness.
    pub(crate) of_solids: bool,
}

impl Labels {
    /// Labels a length: `x [mm]`, or `x (length units)` if the case has no units.
    pub(super) fn length(&self, what: &str) -> String {
        labelled(what, self.units.as_ref().map(|u| u.length.clone()), "length units")
    }

    /// Labels a force, in the plane per unit thickness.
    pub(super) fn force(&self, what: &str) -> String {
        match self.of_solids {
            true => labelled(what, self.units.as_ref().map(|u| u.force.clone()), "force"),
            false => labelled(what, self.units.as_ref().map(Units::line_force), "force / thickness"),
        }
    }

    /// Labels an energy norm.
    pub(super) fn energy_norm(&self, what: &str) -> String {
        let unit = if self.of_solids { Units::energy_norm::<Solid> } else { Units::energy_norm::<Plane> };
        labelled(what, self.units.as_ref().map(unit), "energy^1/2")
    }

    /// Labels an energy over the measure of its cell, in the plane per unit thickness.
    pub(super) fn density(&self, what: &str) -> String {
        self.stress(what, if self.of_solids { "energy / volume" } else { "energy / area" })
    }

    /// Labels a stress.
    pub(super) fn stress(&self, what: &str, otherwise: &str) -> String {
        labelled(what, self.units.as_ref().map(Units::stress), otherwise)
    }
}

fn labelled(what: &str, unit: Option<String>, otherwise: &str) -> String {
    unit.map_or_else(|| format!("{what} ({otherwise})"), |unit| format!("{what} [{unit}]"))
}
