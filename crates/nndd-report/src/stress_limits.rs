//! The recovered stress beside the limits of the materials.

use crate::nodal::von_mises_by_material;
use crate::solved::Fields;
use crate::space::ReportSpace;
use case_io::Case;
use case_io::case::Dimension;
use case_io::diagnostic::significant;
use case_io::report::{Results, StressLimit};
use fem_core::geometry::{Coordinates, shown};
use fem_core::mesh::id::NodeId;

/// Compares the recovered stress with the limits of the materials; `None` without limits or results.
pub(crate) fn found<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>) -> Option<Vec<StressLimit>> {
    if case.materials.iter().all(|material| material.limit.is_none()) {
        return None;
    }
    let mut found: Vec<Option<StressLimit>> = vec![None; case.materials.len()];
    for (b, (body, stress)) in solution.problem.bodies.iter().zip(&solution.results?.recovered).enumerate() {
        let of_body = von_mises_by_material(body, stress).unwrap_or_default();
        for (values, place) in of_body.into_iter().zip(case.material_places(b)) {
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

/// Says how much of its limit the largest stress of each material is, or that it is not known.
pub(crate) fn notes<S: Dimension>(case: &Case<S>, results: &Results) -> Vec<String> {
    let Some(found) = &results.stress_limits else { return Vec::new() };
    let limits = case.materials.iter().filter_map(|material| Some((&material.name, material.limit?)));
    let note = |(name, limit): (&String, f64)| {
        let Some(of) = found.iter().find(|of| of.material == *name) else {
            return format!(
                "material \"{name}\": nothing is compared with its limit {}: no body has it, or a plane `stiffness` does not say the \
                 stress across the plane",
                shown(limit)
            );
        };
        let place: Vec<String> = [Some(of.x), Some(of.y), of.z].into_iter().flatten().map(shown).collect();
        format!(
            "material \"{name}\": the largest recovered von Mises stress is {} of its limit {}{}, in body \"{}\" at ({}); this is no bound",
            significant(of.share),
            shown(limit),
            if of.share > 1.0 { ", above it" } else { "" },
            of.body,
            place.join(", ")
        )
    };
    limits.map(note).collect()
}
