//! A summary of a mesh file, for people who want to look before they use it.

use super::connected::joined;
use super::flat::coincident;
use super::region::{WHOLE, title_of};
use super::sides::{Key, free_facets, key, keys_of};
use super::solid::Tetrahedra;
use super::{ElementKind, MeshCell, MeshFile, Problem, Remedy};
use crate::words::{counted, listed};
use fem_core::geometry::{self, Coordinates};
use fem_core::space::{Plane, Solid, Space};
use std::collections::{BTreeMap, BTreeSet};

/// The most problems of one kind that are listed one by one.
const MOST: usize = 20;

/// One group of a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GroupSummary {
    /// 0 for nodes, 1 for edges, 2 for cells, 3 for volumes.
    pub dimension: u8,
    /// Its name.
    pub name: String,
    /// Number of nodes, edges, cells or volumes.
    pub members: usize,
    /// Length of the edges, area of the cells or volume, in the file's units; nothing for nodes.
    pub measure: Option<f64>,
}

/// The worst of all cells, as the triangles they become, or of all tetrahedra.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Quality {
    /// The smallest angle of any triangle, of tetrahedra between two faces, degrees.
    pub smallest_angle: f64,
    /// The file's number of the cell with that angle.
    pub cell: u64,
    /// The centre of the triangle or tetrahedron: two coordinates or three.
    pub at: Vec<f64>,
    /// The smallest ratio of a height to the longest edge of its triangle or tetrahedron.
    pub height_ratio: f64,
}

/// Keeps the cell with the smallest angle, and the smallest ratio of a height to the longest edge.
fn keep_worst<S: Space>(worst: &mut Option<Quality>, corners: &S::Corners<S::Vector>, cell: u64) {
    let angle = S::smallest_angle(corners);
    let points = corners.as_ref();
    let longest = points.iter().flat_map(|a| points.iter().map(|b| (*a - *b).length())).fold(0.0, f64::max);
    let facet = |k: usize| S::facet_measure(&S::axes(|j| corners[S::facet(k)[j]]));
    let largest = (0..=S::DIM).map(facet).fold(0.0, f64::max);
    let ratio = S::DIM as f64 * S::measure(corners).abs() / (largest * longest);
    let at = || points.iter().fold(S::Vector::ZERO, |sum, p| sum + *p * (1.0 / points.len() as f64));
    let worst = worst.get_or_insert_with(|| Quality {
        smallest_angle: f64::INFINITY,
        cell,
        at: Vec::new(),
        height_ratio: ratio,
    });
    worst.height_ratio = worst.height_ratio.min(ratio);
    if angle < worst.smallest_angle {
        (worst.smallest_angle, worst.cell, worst.at) = (angle, cell, at().entries().to_vec());
    }
}

/// The content of a mesh file in numbers, with its problems.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Format and version.
    pub format: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of edges that the file gives separately or as sides of surfaces.
    pub edges: usize,
    /// Number of cells by kind.
    pub cells: Vec<(ElementKind, usize)>,
    /// All groups, regions first.
    pub groups: Vec<GroupSummary>,
    /// The two corners of the box around all nodes that something uses.
    pub bounding_box: [[f64; 3]; 2],
    /// The worst cell, if there is a sound one.
    pub quality: Option<Quality>,
    /// Notes on how the file was read.
    pub notes: Vec<String>,
    /// Problems that may prevent the use of the file.
    pub problems: Vec<Problem>,
}

impl MeshFile {
    /// Looks at everything the file holds.
    pub fn summary(&self) -> Summary {
        let mut kinds = BTreeMap::new();
        for cell in self.cells.iter().chain(&self.volumes) {
            *kinds.entry(cell.kind).or_insert(0) += 1;
        }
        let mut groups: Vec<GroupSummary> = self.groups.iter().map(|g| self.measure(g)).collect();
        groups.sort_by_key(|g| std::cmp::Reverse(g.dimension));
        let mut notes = self.notes.clone();
        self.note_loose_nodes(&mut notes);
        let used = self.used_nodes();
        let mut problems = self.problems(&used);
        let quality = match self.has_volumes() {
            true => self.solid_quality(&mut notes, &mut problems),
            false => self.quality(&mut notes, &mut problems),
        };
        Summary {
            format: self.format.clone(),
            nodes: self.node_numbers.len(),
            edges: self.edges.len(),
            cells: kinds.into_iter().collect(),
            groups,
            bounding_box: if used.is_empty() { [[0.0; 3]; 2] } else { self.extent(&used) },
            quality,
            notes,
            problems,
        }
    }

    /// Lists the nodes that elements use.
    fn used_nodes(&self) -> Vec<u32> {
        (0..self.points.len() as u32).filter(|n| self.used[*n as usize]).collect()
    }

    fn measure(&self, group: &super::Group) -> GroupSummary {
        let length = |edge: &u32| {
            let [a, b] = self.edges[*edge as usize].nodes.map(|n| self.xyz(n));
            geometry::norm(b - a)
        };
        let area = |cell: &u32| {
            let [a, b, c, d] = self.cells[*cell as usize].first_four().map(|n| self.xyz(n));
            0.5 * geometry::norm((c - a).cross(&(d - b)))
        };
        let volume = |cell: &u32| {
            let parts = self.volumes[*cell as usize].tetrahedra(&|n| n);
            parts.iter().map(|t| Solid::measure(&t.map(|n| self.xyz(n)))).sum::<f64>().abs()
        };
        let measure = match group.dimension {
            1 => Some(group.members.iter().map(length).sum::<f64>()),
            2 => Some(group.members.iter().map(area).sum::<f64>()),
            3 => Some(group.members.iter().map(volume).sum::<f64>()),
            _ => None,
        };
        GroupSummary {
            dimension: group.dimension,
            name: group.name.clone(),
            members: group.members.len(),
            measure: measure.filter(|m| m.is_finite()),
        }
    }

    /// Finds the worst triangle; says how many cells are turned, flat, split or reduced.
    fn quality(&self, notes: &mut Vec<String>, problems: &mut Vec<Problem>) -> Option<Quality> {
        let made = self.triangulate(0..self.cells.len() as u32, &|n| n);
        notes.extend(made.describe(WHOLE));
        if let Some(cell) = made.first_degenerate {
            let what = counted(made.degenerate, "cell");
            problems.push(format!("{what} without an area, the first is element {}", cell.number).into());
        }
        let mut worst: Option<Quality> = None;
        for (t, cell) in made.corners.iter().zip(&made.cells) {
            let p = t.map(|n| self.xy(n));
            if geometry::sure_area(p).is_some() {
                keep_worst::<Plane>(&mut worst, &p, *cell);
            }
        }
        self.edge_problems(&made.corners, notes, problems);
        worst
    }

    /// Looks for edges with more than two cells, named edges without a cell, and sides without a name.
    fn edge_problems(&self, triangles: &[[u32; 3]], notes: &mut Vec<String>, problems: &mut Vec<Problem>) {
        let mut keys: Vec<Key> = triangles.iter().flat_map(keys_of).collect();
        keys.sort_unstable();
        let crowded = keys.chunk_by(|a, b| a == b).filter(|same| same.len() > 2).count();
        if crowded > 0 {
            let edges = counted(crowded, "edge");
            problems.push(
                format!("{edges} shared by more than two cells: cells overlap or appear once per group")
                    .into(),
            );
        }
        keys.dedup();
        let named: BTreeSet<Key> = self
            .groups
            .iter()
            .filter(|g| g.dimension == 1)
            .flat_map(|g| &g.members)
            .map(|e| self.edges[*e as usize].nodes)
            .map(|[a, b]| key(a, b))
            .collect();
        let loose = named.iter().filter(|e| keys.binary_search(e).is_err()).count();
        if loose > 0 {
            problems.push(format!("{} in groups, but sides of no cell", counted(loose, "edge")).into());
        }
        let nameless = free_facets(triangles.iter().flat_map(keys_of).collect())
            .iter()
            .filter(|e| !named.contains(*e))
            .count();
        let node_sets = self.groups.iter().any(|g| g.dimension == 0);
        if nameless > 0 && !node_sets {
            notes.push(format!(
                "{} of the free boundary in no group: free of loads and supports",
                counted(nameless, "edge")
            ));
        }
    }

    fn problems(&self, all: &[u32]) -> Vec<Problem> {
        let mut problems = Vec::new();
        let (facets, word) = if self.has_volumes() {
            (2, "surfaces (Gmsh: Physical Surface)")
        } else {
            if let Err(error) = self.check_cells() {
                return vec![error.into()];
            }
            match self.check_plane(all, WHOLE) {
                Err(error) => problems.push(error.into()),
                Ok(left_out) => problems.extend(left_out.map(Problem::from)),
            }
            (1, "edges (Gmsh: Physical Curve)")
        };
        if self.group_names(facets).next().is_none() && !self.groups.iter().any(|g| g.dimension == 0) {
            let what = format!(
                "no group of {word}: name the sides in the case file by their places, with [[body.side]]"
            );
            problems.push(what.into());
        }
        let mut parent = vec![u32::MAX; self.points.len()];
        for (name, members) in self.region_members() {
            if members.is_empty() {
                problems.push(format!("{name} is empty").into());
            }
            let parts = self.parts(&members, &mut parent);
            if parts > 1 {
                let found = format!("{name} consists of {parts} parts that are not connected");
                problems.push(Problem::new(found, Remedy::Part));
            }
            if problems.len() > MOST {
                problems.push("and more".to_owned().into());
                break;
            }
        }
        let before = problems.len();
        let owners = self.shared_nodes(&mut problems);
        if self.elementary {
            // The parts of one drawing share nodes.
            problems.truncate(before);
        }
        let mut twins = match self.has_volumes() {
            true => coincident(&all.iter().map(|n| self.xyz(*n)).collect::<Vec<_>>()),
            false => coincident(&all.iter().map(|n| self.xy(*n)).collect::<Vec<_>>()),
        };
        // Between two regions that is as it should be.
        twins.retain(|pair| {
            let [a, b] = pair.map(|k| owners[all[k as usize] as usize]);
            a == b && (a != u32::MAX || self.group_names(self.body_cells().0).next().is_none())
        });
        if !twins.is_empty() {
            let found = self.twins(&twins, all, "the same region") + ": a crack, or an error";
            problems.push(Problem::new(found, Remedy::Merge));
        }
        problems
    }

    /// Returns what bodies are made of, with its dimension: the volumes if there are any, or the cells.
    fn body_cells(&self) -> (u8, &[MeshCell]) {
        if self.has_volumes() { (3, &self.volumes) } else { (2, &self.cells) }
    }

    /// Returns the place of a node.
    pub(super) fn xyz(&self, node: u32) -> <Solid as Space>::Vector {
        self.points[node as usize].into()
    }

    /// Finds the worst tetrahedron; says how many cells are split or reduced, and how many make no tetrahedra.
    fn solid_quality(&self, notes: &mut Vec<String>, problems: &mut Vec<Problem>) -> Option<Quality> {
        let made = Tetrahedra::of(self.volumes.iter(), &|n| n, &|n| self.xyz(n));
        notes.extend(made.describe(WHOLE));
        if let Some(cell) = made.first_degenerate {
            let what = counted(made.degenerate, "cell");
            let found =
                format!("{what} flat, turned over in part or twisted, the first is element {}", cell.number);
            problems.push(found.into());
        }
        let mut worst: Option<Quality> = None;
        for (cell, number) in made.corners.iter().zip(&made.cells) {
            keep_worst::<Solid>(&mut worst, &cell.map(|n| self.xyz(n)), *number);
        }
        worst
    }

    /// Lists what can be a region: its title and cells.
    fn region_members(&self) -> Vec<(String, Vec<u32>)> {
        let (dimension, cells) = self.body_cells();
        let groups = self.groups.iter().filter(|g| g.dimension == dimension);
        let named: Vec<_> = groups.map(|g| (title_of(&g.name), g.members.clone())).collect();
        if named.is_empty() {
            return vec![(WHOLE.to_owned(), (0..cells.len() as u32).collect())];
        }
        named
    }

    /// Counts the parts of a set of cells that are joined by nodes.
    ///
    /// * `parent`: room for one number per node, kept between calls; only the nodes of the cells are touched.
    fn parts(&self, cells: &[u32], parent: &mut [u32]) -> usize {
        let (_, all) = self.body_cells();
        let corners = || cells.iter().map(|c| all[*c as usize].corners);
        for node in corners().flatten() {
            parent[node as usize] = u32::MAX;
        }
        let mut parts = 0;
        for node in corners().flatten() {
            if std::mem::replace(&mut parent[node as usize], node) == u32::MAX {
                parts += 1;
            }
        }
        for [first, others @ ..] in corners() {
            for other in others {
                parts -= usize::from(joined(parent, first, other));
            }
        }
        parts
    }

    /// Finds pairs of regions that share nodes but no cell: one mesh if two bodies are wanted.
    ///
    /// Returns the first region of each node.
    fn shared_nodes(&self, problems: &mut Vec<Problem>) -> Vec<u32> {
        let mut of_node = vec![u32::MAX; self.points.len()];
        let (dimension, cells) = self.body_cells();
        let mut of_cell = vec![u32::MAX; cells.len()];
        let mut seen = vec![u32::MAX; self.points.len()];
        let mut pairs: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        let mut overlapping = BTreeSet::new();
        let regions: Vec<_> = self.groups.iter().filter(|g| g.dimension == dimension).collect();
        for (number, region) in (0u32..).zip(&regions) {
            for cell in &region.members {
                let owner = std::mem::replace(&mut of_cell[*cell as usize], number);
                if owner != u32::MAX && owner != number {
                    overlapping.insert((owner, number));
                }
                for node in cells[*cell as usize].corners {
                    let owner = &mut of_node[node as usize];
                    if *owner == u32::MAX {
                        *owner = number;
                    } else if *owner != number
                        && std::mem::replace(&mut seen[node as usize], number) != number
                    {
                        *pairs.entry((*owner, number)).or_insert(0) += 1;
                    }
                }
            }
        }
        for ((a, b), count) in pairs.iter().filter(|(pair, _)| !overlapping.contains(pair)).take(MOST) {
            let names = [a, b].map(|k| regions[*k as usize].name.as_str());
            let found = format!("{} are regions with {} in common", listed(&names), counted(*count, "node"));
            problems.push(Problem::new(found, Remedy::OwnNodes));
        }
        of_node
    }
}
