//! Data that a program gives at the nodes of a side instead of an expression.

use fem_core::geometry::Vector;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Line};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

type Function = dyn Fn(&[Vector]) -> Option<Vec<f64>> + Send + Sync;

/// A function of a program: the values at some points, m; `None` if it has none to give.
#[derive(Clone)]
pub struct NodalFunction(Arc<Function>);

impl NodalFunction {
    /// Takes a function, which is called once for each side on which it gives data.
    pub fn new(function: impl Fn(&[Vector]) -> Option<Vec<f64>> + Send + Sync + 'static) -> Self {
        Self(Arc::new(function))
    }

    /// Evaluates it; `None` also if it gives another number of values than of points.
    pub(crate) fn at(&self, points: &[Vector]) -> Option<Vec<f64>> {
        self.0(points).filter(|values| values.len() == points.len())
    }
}

impl PartialEq for NodalFunction {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for NodalFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("NodalFunction")
    }
}

/// An edge with the values at its two ends.
type Edge = GeomWithData<Line<[f64; 2]>, [f64; 2]>;

/// Values at the nodes of a side, linear along its edges.
#[derive(Clone)]
pub struct NodalData {
    at_nodes: Arc<HashMap<[u64; 2], f64>>,
    edges: Arc<RTree<Edge>>,
    digest: String,
}

/// A point as a key; zero has one sign.
fn key(point: Vector) -> [u64; 2] {
    point.map(|x| (x + 0.0).to_bits()).into()
}

impl NodalData {
    /// Makes the data of a side.
    ///
    /// * `ends`: the ends of its edges, m; `values`: at these ends.
    pub(crate) fn new(ends: &[[Vector; 2]], values: &[[f64; 2]]) -> Self {
        let nodes = || ends.as_flattened().iter().zip(values.as_flattened());
        let edge = |([a, b], values): (&[Vector; 2], &[f64; 2])| {
            GeomWithData::new(Line::new((*a).into(), (*b).into()), *values)
        };
        let mut hasher = Sha256::new();
        for (point, value) in nodes() {
            [point[0], point[1], *value]
                .iter()
                .for_each(|number| hasher.update(number.to_bits().to_le_bytes()));
        }
        Self {
            at_nodes: Arc::new(nodes().map(|(point, value)| (key(*point), *value)).collect()),
            edges: Arc::new(RTree::bulk_load(ends.iter().zip(values).map(edge).collect())),
            digest: hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }

    /// Evaluates the data: at a node its value, elsewhere on the nearest edge. NaN without edges.
    pub fn at(&self, point: impl Into<Vector>) -> f64 {
        let point = point.into();
        if let Some(value) = self.at_nodes.get(&key(point)) {
            return *value;
        }
        let Some(edge) = self.edges.nearest_neighbor(&point.into()) else { return f64::NAN };
        let [from, to] = [edge.geom().from, edge.geom().to].map(Vector::from);
        let part = ((point - from).dot(&(to - from)) / (to - from).norm_squared()).clamp(0.0, 1.0);
        let [a, b] = edge.data;
        a + part * (b - a)
    }

    /// Returns the SHA-256 of points and values, in hexadecimal.
    pub(crate) fn digest(&self) -> &str {
        &self.digest
    }
}

impl PartialEq for NodalData {
    fn eq(&self, other: &Self) -> bool {
        self.digest == other.digest
    }
}

impl fmt::Debug for NodalData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NodalData({} nodes)", self.at_nodes.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_have_their_values_and_edges_are_linear() {
        let points = [[0.0, 0.0], [0.1, 0.3], [2.0, 0.3]].map(Vector::from);
        let data =
            NodalData::new(&[[points[0], points[1]], [points[1], points[2]]], &[[1.0, 0.7], [0.7, -3.0]]);
        assert_eq!(points.map(|p| data.at(p)), [1.0, 0.7, -3.0]);
        assert_eq!(data.at([-0.0, 0.0]), 1.0);
        let middles = [data.at(0.5 * (points[0] + points[1])), data.at(0.5 * (points[1] + points[2]))];
        assert!((middles[0] - 0.85).abs() < 1e-15 && (middles[1] + 1.15).abs() < 1e-15, "{middles:?}");
        // Off the side the nearest place counts: a node that moved onto a curve, or lies beyond the end.
        assert!((data.at([1.05, 0.31]) + 1.15).abs() < 1e-15);
        assert_eq!(data.at([9.0, 0.3]), -3.0);
        assert!(NodalData::new(&[], &[]).at(points[0]).is_nan());
    }

    #[test]
    fn the_digest_tells_values_apart() {
        let ends = [[Vector::new(0.0, 0.0), Vector::new(1.0, 0.0)]];
        let [a, b] = [[1.0, 2.0], [1.0, 3.0]].map(|values| NodalData::new(&ends, &[values]));
        assert!(a != b && a == NodalData::new(&ends, &[[1.0, 2.0]]));
        assert_eq!(a.digest().len(), 64);
    }
}
