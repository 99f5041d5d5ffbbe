//! The results along a contact line of the plane: intervals of arc length, and connected parts.

use crate::pair_forces::{PairForces, mean};
use fem_core::geometry::{Vector, cross};
use fem_core::interface::ContactInterface;

/// One connected part of a contact line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Stretch {
    /// Arc lengths of its first and last pair, m; a closed one ends at the place where it begins.
    pub s: [f64; 2],
    /// Number of pairs.
    pub pairs: usize,
    /// Length, m; for a closed part it includes the last edge.
    pub length: f64,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// The force of the contact on the first body, friction included, N/m.
    pub resultant: Vector,
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    pub moment: f64,
    /// Largest nodal pressure, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of an edge, Pa: at most `max_pressure`.
    pub max_edge_pressure: f64,
    /// Smallest opening, m.
    pub min_opening: f64,
}

/// Adds up the forces of each connected part: consecutive pairs that are joined by edges.
pub(crate) fn stretches(line: &PairForces<'_>) -> Vec<Stretch> {
    let joined = joined(line.interface);
    let pressures: Vec<f64> = line.pressures().collect();
    let mut number = Vec::with_capacity(joined.len());
    let mut found: Vec<Stretch> = Vec::new();
    let arc_lengths = line.interface.arc_lengths();
    for (k, p) in line.interface.pairs().iter().enumerate() {
        if !joined[k] {
            found.push(Stretch {
                s: [arc_lengths[k]; 2],
                pairs: 0,
                length: 0.0,
                contact_force: 0.0,
                resultant: Vector::zeros(),
                moment: 0.0,
                max_pressure: 0.0,
                max_edge_pressure: 0.0,
                min_opening: f64::INFINITY,
            });
        }
        number.push(found.len() - 1);
        if let Some(last) = found.last_mut() {
            last.s[1] = arc_lengths[k];
            last.pairs += 1;
            last.contact_force += pressures[k] * p.weight;
            let force = line.on_first(k);
            last.resultant += force;
            last.moment += cross(line.points[p.nodes[0]], force);
            last.max_pressure = last.max_pressure.max(pressures[k]);
            last.min_opening = last.min_opening.min(line.opening[k] / p.normal_length());
        }
    }
    for edge in line.interface.facets() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let stretch = &mut found[number[i]];
        stretch.length += edge.measure;
        if edge.clamped == [None; 2] && j <= i {
            stretch.s[1] = arc_lengths[i] + edge.measure;
        }
        stretch.max_edge_pressure = stretch.max_edge_pressure.max(mean(line.interface, &pressures, edge));
    }
    found
}

/// Finds the intervals of arc length whose nodes have a property; they may cross the edge that closes a line.
pub(crate) fn intervals(interface: &ContactInterface, carries: &dyn Fn(usize) -> bool) -> Vec<[f64; 2]> {
    let pairs = interface.pairs();
    let joined = joined(interface);
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut open = false;
    let arc_lengths = interface.arc_lengths();
    for k in 0..pairs.len() {
        match found.last_mut() {
            Some(last) if carries(k) && open && joined[k] => last[1] = arc_lengths[k],
            _ if carries(k) => found.push([arc_lengths[k]; 2]),
            _ => {}
        }
        open = carries(k);
    }
    for edge in interface.facets() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let end = arc_lengths[i];
        // The pressure reaches a clamped end.
        if let Some(clamped) = edge.clamped.iter().position(Option::is_some).filter(|_| carries(i)) {
            let own = found.iter_mut().find(|interval| (interval[0]..=interval[1]).contains(&end));
            if let Some(interval) = own {
                interval[clamped] = end + [-1.0, 1.0][clamped] * edge.measure;
            }
            continue;
        }
        if edge.clamped == [None; 2]
            && j <= i
            && carries(i)
            && carries(j)
            && let Some(last) = found.iter_mut().find(|interval| interval[1] == end)
        {
            last[1] = end + edge.measure;
        }
    }
    found
}

/// Tells for each pair whether an edge joins it to the previous one.
fn joined(interface: &ContactInterface) -> Vec<bool> {
    let mut joined = vec![false; interface.pairs().len()];
    for edge in interface.facets() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        if j == i + 1 {
            joined[j] = true;
        }
    }
    joined
}
