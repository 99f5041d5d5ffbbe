//! The named sides of a region: groups of edges, restricted to the edges of its triangles.

use super::{MeshFile, Problem};
use crate::words::{counted, listed};

/// An edge by its two nodes, the smaller first.
pub(super) type Key = [u32; 2];

pub(super) fn key(a: u32, b: u32) -> Key {
    [a.min(b), a.max(b)]
}

pub(super) fn keys_of(t: &[u32; 3]) -> [Key; 3] {
    [key(t[0], t[1]), key(t[1], t[2]), key(t[2], t[0])]
}

impl MeshFile {
    /// Collects the sides of a region, by name.
    ///
    /// * `local`: the region's number of each node of the file, or one that is too large.
    /// * `warnings`: grows by what lies in the region without being an edge of it.
    pub(super) fn sides(
        &self,
        local: &[u32],
        triangles: &[[u32; 3]],
        nodes: usize,
        title: &str,
        warnings: &mut Vec<Problem>,
    ) -> Vec<(String, Vec<Key>)> {
        let mut candidates: Vec<(u32, Key)> = Vec::new();
        for (number, group) in self.groups.iter().enumerate().filter(|(_, g)| g.dimension == 1) {
            for member in &group.members {
                let [a, b] = self.edges[*member as usize].nodes.map(|n| local[n as usize]);
                if (a as usize) < nodes && (b as usize) < nodes {
                    candidates.push((number as u32, key(a, b)));
                }
            }
        }
        let there = edges_among(triangles, nodes, candidates.iter().map(|(_, k)| *k).collect());
        let total = candidates.len();
        let mut sides: Vec<(String, Vec<Key>)> = Vec::new();
        let mut previous = None;
        let mut strays: Vec<&str> = Vec::new();
        let mut stray_edges = total;
        for (number, edge) in candidates {
            let name = &self.groups[number as usize].name;
            if there.binary_search(&edge).is_err() {
                if strays.last() != Some(&name.as_str()) {
                    strays.push(name);
                }
                continue;
            }
            stray_edges -= 1;
            if previous != Some(number) {
                sides.push((name.clone(), Vec::new()));
                previous = Some(number);
            }
            if let Some((_, edges)) = sides.last_mut() {
                edges.push(edge);
            }
        }
        if stray_edges > 0 {
            let edges = counted(stray_edges, "edge");
            let what = format!(
                "{edges} of {} join nodes of {title} that no cell joins; they are left out",
                listed(&strays)
            );
            warnings.push(what.into());
        }
        sides.extend(self.node_sides(local, triangles, nodes));
        sides
    }

    /// Makes sides of the sets of nodes: the free edges whose both ends are in a set.
    fn node_sides(&self, local: &[u32], triangles: &[[u32; 3]], nodes: usize) -> Vec<(String, Vec<Key>)> {
        let sets: Vec<_> = self.groups.iter().filter(|g| g.dimension == 0).collect();
        if sets.is_empty() {
            return Vec::new();
        }
        let mut neighbours = vec![[u32::MAX; 2]; nodes];
        for [a, b] in free_edges(triangles) {
            for (from, to) in [(a, b), (b, a)] {
                // A sound boundary has two edges at a node; fem-core refuses any other.
                if let Some(slot) = neighbours[from as usize].iter_mut().find(|n| **n == u32::MAX) {
                    *slot = to;
                }
            }
        }
        let mut mark = vec![u32::MAX; nodes];
        let mut sides = Vec::new();
        for (number, set) in (0u32..).zip(sets) {
            let members: Vec<u32> =
                set.members.iter().map(|n| local[*n as usize]).filter(|n| (*n as usize) < nodes).collect();
            for node in &members {
                mark[*node as usize] = number;
            }
            let marked = |n: u32| mark.get(n as usize) == Some(&number);
            let mut edges: Vec<Key> = members
                .iter()
                .flat_map(|a| neighbours[*a as usize].map(|b| (*a, b)))
                .filter(|(a, b)| a < b && marked(*b))
                .map(|(a, b)| [a, b])
                .collect();
            edges.sort_unstable();
            if !edges.is_empty() {
                sides.push((set.name.clone(), edges));
            }
        }
        sides
    }
}

/// Finds which of some edges the triangles have: ascending.
pub(super) fn edges_among(triangles: &[[u32; 3]], nodes: usize, mut wanted: Vec<Key>) -> Vec<Key> {
    wanted.sort_unstable();
    wanted.dedup();
    let mut touched = vec![false; nodes];
    for node in wanted.iter().flatten() {
        touched[*node as usize] = true;
    }
    let mut found = vec![false; wanted.len()];
    for edge in triangles.iter().flat_map(keys_of) {
        if touched[edge[0] as usize]
            && touched[edge[1] as usize]
            && let Ok(place) = wanted.binary_search(&edge)
        {
            found[place] = true;
        }
    }
    wanted.into_iter().zip(found).filter(|(_, found)| *found).map(|(edge, _)| edge).collect()
}

/// Finds the edges that one triangle alone has: ascending.
pub(super) fn free_edges(triangles: &[[u32; 3]]) -> Vec<Key> {
    let mut keys: Vec<Key> = triangles.iter().flat_map(keys_of).collect();
    keys.sort_unstable();
    keys.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}
