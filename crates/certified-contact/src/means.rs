//! Means over pairs of nodes that are near each other, which keep the sum of the forces.

pub(crate) mod line;
pub(crate) mod surface;

/// Nodes with at most this part of the largest force are open.
pub(crate) const OPEN: f64 = 1e-9;

/// Weights are found to this precision.
const PRECISION: f64 = 1e-14;

/// Iterations for the weights; 40 are enough for meshes of constant size.
const MAX_ITERATIONS: usize = 200;

/// Two pairs of nodes that are near each other, and their factor `K`, between 0 and 1.
pub(crate) struct Near {
    pub(crate) places: [u32; 2],
    pub(crate) factor: f64,
}

/// Computes the pressures `p` at the nodes, Pa.
///
/// * `lengths`, `forces`: of each node.
pub(crate) fn recover(near: &[Near], lengths: &[f64], forces: &[f64]) -> Vec<f64> {
    let weights = weights(near, lengths);
    let mean = means(near, &weights, forces);
    let returned = returned(near, &weights, lengths, forces, &mean);
    // An open node that gives back all that it has keeps round-off.
    mean.iter().zip(returned).map(|(mean, returned)| (mean + returned).max(0.0)).collect()
}

/// Computes the means `m`, Pa.
pub(crate) fn means(near: &[Near], weights: &[f64], forces: &[f64]) -> Vec<f64> {
    let weighted: Vec<f64> = weights.iter().zip(forces).map(|(w, force)| w * force).collect();
    weights.iter().zip(sums(near, &weighted)).map(|(w, sum)| w * sum).collect()
}

/// Computes the force that flows back from open nodes to nodes in contact, by length, Pa.
fn returned(near: &[Near], weights: &[f64], lengths: &[f64], forces: &[f64], mean: &[f64]) -> Vec<f64> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let open: Vec<bool> = forces.iter().map(|force| *force <= OPEN * largest).collect();
    // Node in contact, open node, and the force between them.
    let flows: Vec<(usize, usize, f64)> = near
        .iter()
        .filter_map(|Near { places, factor }| {
            let [i, j] = places.map(|place| place as usize);
            let (k, i) = if open[j] { (i, j) } else { (j, i) };
            let force = lengths[k] * weights[k] * factor * weights[i] * lengths[i] * (mean[k] - mean[i]);
            (open[i] && !open[k] && force > 0.0).then_some((k, i, force))
        })
        .collect();
    let mut leaving = vec![0.0; mean.len()];
    for (_, i, force) in &flows {
        leaving[*i] += force;
    }
    let mut returned = vec![0.0; mean.len()];
    for (k, i, force) in flows {
        let has = mean[i] * lengths[i];
        let force = if leaving[i] > has { force * (has / leaving[i]) } else { force };
        returned[k] += force / lengths[k];
        returned[i] -= force / lengths[i];
    }
    returned
}

/// Computes `Σ_i K_ki x_i`.
fn sums(near: &[Near], x: &[f64]) -> Vec<f64> {
    let mut sums = x.to_vec();
    for Near { places, factor } in near {
        let [i, j] = places.map(|place| place as usize);
        sums[i] += factor * x[j];
        sums[j] += factor * x[i];
    }
    sums
}

/// Finds the weights with `w_k Σ_i K_ki w_i ℓ_i = 1`, by the iteration of Sinkhorn and Knopp in its symmetric form (Knight, Ruiz and Ucar 2014).
pub(crate) fn weights(near: &[Near], lengths: &[f64]) -> Vec<f64> {
    let mut weights = vec![1.0; lengths.len()];
    for _ in 0..MAX_ITERATIONS {
        let weighted: Vec<f64> = weights.iter().zip(lengths).map(|(w, l)| w * l).collect();
        let mut largest = 0.0_f64;
        for (w, sum) in weights.iter_mut().zip(sums(near, &weighted)) {
            largest = largest.max((*w * sum - 1.0).abs());
            *w = (*w / sum).sqrt();
        }
        if largest <= PRECISION {
            break;
        }
    }
    weights
}
