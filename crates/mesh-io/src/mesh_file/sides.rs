//! The named sides of a region: groups of facets, restricted to the facets of its cells.

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

/// The facets of the cells of a region, with words for them.
pub(super) struct Facets<'a, const N: usize> {
    /// The facets of all cells, each by its nodes in ascending order.
    pub(super) all: &'a [[u32; N]],
    /// The number of nodes.
    pub(super) nodes: usize,
    /// The word for one.
    pub(super) word: &'static str,
    /// The dimension of a group of them.
    pub(super) dimension: u8,
    /// Halves of quadrilaterals, each with the corner that it lacks; ascending.
    pub(super) halves: &'a [([u32; N], u32)],
}

impl MeshFile {
    /// Collects the sides of a region, by name.
    ///
    /// * `local`: the region's number of each node of the file, or one that is too large.
    /// * `facets_of`: the facets of a member of a group, each by its nodes in ascending order, in the region's numbers.
    /// * `warnings`: grows by what lies in the region without being a facet of it.
    pub(super) fn sides<const N: usize>(
        &self,
        local: &[u32],
        facets: &Facets<'_, N>,
        facets_of: &dyn Fn(u32) -> Vec<[u32; N]>,
        title: &str,
        warnings: &mut Vec<Problem>,
    ) -> Vec<(String, Vec<[u32; N]>)> {
        let nodes = facets.nodes;
        let mut candidates: Vec<(u32, [u32; N])> = Vec::new();
        for (number, group) in self.groups.iter().enumerate().filter(|(_, g)| g.dimension == facets.dimension)
        {
            let inside = |facet: &[u32; N]| facet.iter().all(|n| (*n as usize) < nodes);
            let of_group = group.members.iter().flat_map(|member| facets_of(*member)).filter(inside);
            candidates.extend(of_group.map(|facet| (number as u32, facet)));
        }
        let there = facets_among(facets.all, nodes, candidates.iter().map(|(_, k)| *k).collect());
        let total = candidates.len();
        let mut sides: Vec<(String, Vec<[u32; N]>)> = Vec::new();
        let mut previous = None;
        let mut strays: Vec<&str> = Vec::new();
        let mut stray_facets = total;
        for (number, facet) in candidates {
            let name = &self.groups[number as usize].name;
            if there.binary_search(&facet).is_err() {
                if strays.last() != Some(&name.as_str()) {
                    strays.push(name);
                }
                continue;
            }
            stray_facets -= 1;
            if previous != Some(number) {
                sides.push((name.clone(), Vec::new()));
                previous = Some(number);
            }
            if let Some((_, of_side)) = sides.last_mut() {
                of_side.push(facet);
            }
        }
        if stray_facets > 0 {
            let found = counted(stray_facets, facets.word);
            let what = format!(
                "{found} of {} join nodes of {title} that no cell joins; they are left out",
                listed(&strays)
            );
            warnings.push(what.into());
        }
        sides.extend(self.node_sides(local, facets));
        sides
    }

    /// Makes sides of the sets of nodes: the free facets all of whose nodes are in a set, of a quadrilateral's halves those of all four.
    fn node_sides<const N: usize>(
        &self,
        local: &[u32],
        facets: &Facets<'_, N>,
    ) -> Vec<(String, Vec<[u32; N]>)> {
        let sets: Vec<_> = self.groups.iter().filter(|g| g.dimension == 0).collect();
        if sets.is_empty() {
            return Vec::new();
        }
        let free = free_facets(facets.all.to_vec());
        let mut mark = vec![u32::MAX; facets.nodes];
        let mut sides = Vec::new();
        for (number, set) in (0u32..).zip(sets) {
            let members = set.members.iter().map(|n| local[*n as usize]);
            let mut members: Vec<u32> = members.filter(|n| (*n as usize) < facets.nodes).collect();
            members.sort_unstable();
            members.dedup();
            for node in &members {
                mark[*node as usize] = number;
            }
            let is_marked = |n: &u32| mark[*n as usize] == number;
            let is_whole = |facet: &[u32; N]| {
                let half = facets.halves.binary_search_by(|(half, _)| half.cmp(facet));
                facet.iter().all(is_marked) && half.map_or(true, |k| is_marked(&facets.halves[k].1))
            };
            // The free facets whose first node is one of the set; they are in ascending order.
            let first = |node: u32| free.partition_point(|facet| facet[0] < node);
            let of_node = |node: &u32| free[first(*node)..first(*node + 1)].iter();
            let of_set: Vec<[u32; N]> =
                members.iter().flat_map(of_node).filter(|facet| is_whole(facet)).copied().collect();
            if !of_set.is_empty() {
                sides.push((set.name.clone(), of_set));
            }
        }
        sides
    }
}

/// Finds which of some facets the cells have: ascending.
pub(super) fn facets_among<const N: usize>(
    facets: &[[u32; N]],
    nodes: usize,
    mut wanted: Vec<[u32; N]>,
) -> Vec<[u32; N]> {
    wanted.sort_unstable();
    wanted.dedup();
    let mut touched = vec![false; nodes];
    for node in wanted.as_flattened() {
        touched[*node as usize] = true;
    }
    let mut found = vec![false; wanted.len()];
    for facet in facets.iter().filter(|facet| facet.iter().all(|n| touched[*n as usize])) {
        if let Ok(place) = wanted.binary_search(facet) {
            found[place] = true;
        }
    }
    wanted.into_iter().zip(found).filter(|(_, found)| *found).map(|(facet, _)| facet).collect()
}

/// Finds the facets that one cell alone has: ascending.
pub(super) fn free_facets<const N: usize>(mut keys: Vec<[u32; N]>) -> Vec<[u32; N]> {
    keys.sort_unstable();
    keys.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}
