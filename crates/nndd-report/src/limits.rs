//! The recovered stress beside the limits of the materials.

use crate::nodal::von_mises_by_material;
use crate::solved::Fields;
use crate::space::ReportSpace;
use case_io::Case;
use case_io::diagnostic::significant;
use case_io::report::StressLimit;
use fem_core::geometry::{Coordinates, shown};
use fem_core::mesh::id::NodeId;

/// Compares the recovered stress with the limits of the materials; `None` without limits, or if the equivalent stress of a body is unknown.
pub(crate) fn found<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>) -> Option<Vec<StressLimit>> {
    if case.materials.iter().all(|material| material.limit.is_none()) {
        return None;
    }
    let mut found: Vec<Option<StressLimit>> = vec![None; case.materials.len()];
    for (b, (body, stress)) in solution.problem.bodies.iter().zip(&solution.results?.recovered).enumerate() {
        for (values, place) in von_mises_by_material(body, stress)?.into_iter().zip(case.material_places(b)) {
            let Some(limit) = case.materials[place].limit else { continue };
            let known = values.into_iter().enumerate().filter(|(_, value)| !value.is_nan());
            let Some((node, von_mises)) = known.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            if found[place].as_ref().is_none_or(|most| von_mises > most.von_mises) {
                let point = body.mesh().points()[NodeId::new(node)];
                found[place] = Some(StressLimit {
                    material: case.materials[place].name.clone(),
                    limit,
                    von_mises,
                    share: von_mises / limit,
                    body: case.bodies[b].name.clone(),
                    x: point[0],
                    y: point[1],
                    z: point.entries().get(2).copied(),
                });
            }
        }
    }
    Some(found.into_iter().flatten().collect())
}

/// Says how much of its limit the largest stress of each material is.
pub(crate) fn notes<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>) -> Vec<String> {
    let note = |of: StressLimit| {
        let place: Vec<String> = [Some(of.x), Some(of.y), of.z].into_iter().flatten().map(shown).collect();
        format!(
            "material \"{}\": the largest recovered von Mises stress is {} of its limit {}{}, in body \"{}\" at ({}); this is no bound",
            of.material,
            significant(of.share),
            shown(of.limit),
            if of.share > 1.0 { ", above it" } else { "" },
            of.body,
            place.join(", ")
        )
    };
    found(case, solution).into_iter().flatten().map(note).collect()
}
