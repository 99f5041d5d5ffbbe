//! Connected parts of a region: bodies that a file does not name.

use super::{MeshFault, MeshFileError, MeshPlace, Region};
use fem_core::space::Space;

/// Finds the representative of a node among those it is joined with.
pub(super) fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

/// Joins the parts of two nodes; returns false if they are one part already.
pub(super) fn joined(parent: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
    a != b
}

impl<S: Space> Region<S> {
    /// Keeps the connected parts that have a facet of a side. Cells are connected if they share a node.
    ///
    /// # Errors
    /// A side that the region does not have.
    pub fn connected_to(mut self, side: &str) -> Result<Self, MeshFileError> {
        let mut parent: Vec<u32> = (0..self.points.len() as u32).collect();
        for cell in &self.cells {
            for node in cell.as_ref() {
                joined(&mut parent, cell.as_ref()[0], *node);
            }
        }
        let Some((_, facets)) = self.groups.iter().find(|(name, _)| name == side) else {
            let found = format!("{} has no side \"{side}\"", self.title);
            let names = self.groups.iter().map(|(name, _)| name.as_str());
            return Err(MeshFileError::new(MeshFault::Region, &self.file, MeshPlace::File, found)
                .expected("a side of the body, for `connected_to`")
                .or_similar(side, names));
        };
        let mut kept = vec![false; self.points.len()];
        for facet in facets {
            kept[root(&mut parent, facet.as_ref()[0]) as usize] = true;
        }
        for node in 0..parent.len() {
            kept[node] = kept[root(&mut parent, node as u32) as usize];
        }
        let mut number = vec![0; kept.len()];
        let of_kept = number.iter_mut().zip(&kept).filter(|(_, kept)| **kept);
        for (place, (new, _)) in (0..).zip(of_kept) {
            *new = place;
        }
        self.retain(&kept, &number);
        self.title = format!("the part of {} at \"{side}\"", self.title);
        Ok(self)
    }

    /// Keeps some nodes and what is made of them.
    ///
    /// * `number`: the new number of each node that is kept.
    fn retain(&mut self, kept: &[bool], number: &[u32]) {
        let is_kept = |nodes: &[u32]| kept[nodes[0] as usize];
        let numbered = |nodes: &[u32], k: usize| number[nodes[k] as usize];
        let cells = self.cells.iter().zip(&self.cell_numbers).filter(|(cell, _)| is_kept(cell.as_ref()));
        (self.cells, self.cell_numbers) =
            cells.map(|(cell, file)| (S::corners(|k| numbered(cell.as_ref(), k)), *file)).unzip();
        for (_, facets) in &mut self.groups {
            facets.retain(|facet| is_kept(facet.as_ref()));
            for facet in facets {
                *facet = S::axes(|k| numbered(facet.as_ref(), k));
            }
        }
        self.groups.retain(|(_, facets)| !facets.is_empty());
        let nodes = self.points.iter().zip(&self.node_numbers).zip(kept).filter(|(_, kept)| **kept);
        (self.points, self.node_numbers) = nodes.map(|((point, file), _)| (*point, *file)).unzip();
    }
}

#[cfg(test)]
mod tests {
    use crate::{RegionOptions, parse};

    /// Two squares and a third one that are not connected, all of them in one set.
    const DECK: &str = "*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n5, 5, 0\n6, 6, 0\n7, 6, 1\n8, 5, 1\n9, 2, 0\n10, 2, 1\n\
        *ELEMENT, TYPE=CPS4, ELSET=all\n1, 1, 2, 3, 4\n2, 5, 6, 7, 8\n3, 2, 9, 10, 3\n\
        *SURFACE, NAME=left\n1, S4\n*SURFACE, NAME=top\n1, S3\n2, S3\n*SURFACE, NAME=far\n2, S2\n";

    #[test]
    fn the_part_at_a_side_is_kept_with_its_numbers_and_sides() {
        let file = parse(DECK.as_bytes(), "d.inp").unwrap();
        let whole = file.region(Some("all"), RegionOptions::default()).unwrap();
        let near = whole.clone().connected_to("left").unwrap();
        assert_eq!(near.node_numbers(), [1, 2, 3, 4, 9, 10]);
        assert_eq!(near.cell_numbers(), [1, 1, 3, 3]);
        assert_eq!(near.mesh().unwrap().group("top").unwrap().len(), 1);
        assert_eq!(near.sides().map(|(name, _)| name).collect::<Vec<_>>(), ["left", "top"]);
        let far = whole.clone().connected_to("far").unwrap();
        assert_eq!(far.node_numbers(), [5, 6, 7, 8]);
        assert_eq!(far.cells(), [[0, 1, 2], [0, 2, 3]]);
        assert!(crate::glued_nodes(&near, &far).is_none());
        // A side of both parts keeps both.
        assert_eq!(whole.clone().connected_to("top").unwrap().points(), whole.points());
        let told = whole.connected_to("botom").unwrap_err().to_string();
        assert!(told.contains("region \"all\" has no side \"botom\""), "{told}");
    }
}
