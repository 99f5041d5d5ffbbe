//! A region of a mesh file: the cells, points and named sides of one body.

use super::flat::{coincident, is_wide, smallest_angle};
use super::sides::{Facets, free_facets, key, keys_of};
use super::{MeshCell, MeshFault, MeshFile, MeshFileError, Problem, Remedy};
use crate::words::{counted, listed};
use fem_core::geometry::{Coordinates, Vector, shown};
use fem_core::space::{Plane, Space};
use std::collections::HashSet;

/// Triangles with a smaller angle, in degrees, are worth a warning.
const SLIVER: f64 = 0.1;

/// Elements with such cells that are listed.
const MOST_SLIVERS: usize = 5;

/// Regions whose names are compared with a misspelt one.
const MOST_COMPARED: usize = 10_000;

/// Means 'not in the region'.
const OUTSIDE: u32 = u32::MAX;

/// The name of the whole file in messages.
pub(super) const WHOLE: &str = "the mesh";

/// Returns the name of a region in messages.
pub(super) fn title_of(name: &str) -> String {
    format!("region \"{name}\"")
}

/// The words and the dimension of the groups of cells that a region is made of.
pub(super) struct Kind {
    pub(super) dimension: u8,
    pub(super) cells: &'static str,
    pub(super) facets: &'static str,
    pub(super) gmsh: &'static str,
}

const PLANE: Kind =
    Kind { dimension: 2, cells: "triangles or quadrilaterals", facets: "edges", gmsh: "Physical Surface" };

/// How a region is taken from a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RegionOptions {
    /// True if nodes at one place become one node.
    pub merge: bool,
}

impl RegionOptions {
    /// Says whether nodes at one place become one node.
    pub fn with_merge(merge: bool) -> Self {
        Self { merge }
    }
}

/// One body's part of a mesh file, numbered for fem-core in the order of the file's numbers.
#[derive(Clone, Debug)]
pub struct Region<S: Space = Plane> {
    pub(super) file: String,
    pub(super) title: String,
    pub(super) points: Vec<S::Vector>,
    pub(super) cells: Vec<S::Corners<u32>>,
    pub(super) groups: Vec<(String, Vec<S::Axes<u32>>)>,
    pub(super) node_numbers: Vec<u64>,
    pub(super) cell_numbers: Vec<u64>,
    pub(super) cell_groups: Vec<String>,
    pub(super) notes: Vec<String>,
    pub(super) warnings: Vec<Problem>,
}

impl<S: Space> Region<S> {
    /// Returns what messages call it: `region "upper"`, or `the mesh` if it is the whole file.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Returns what was done to the cells, in words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns what is allowed but probably not meant.
    pub fn warnings(&self) -> &[Problem] {
        &self.warnings
    }

    /// Returns the file's number of each node.
    pub fn node_numbers(&self) -> &[u64] {
        &self.node_numbers
    }

    /// Returns the places of its nodes.
    pub fn points(&self) -> &[S::Vector] {
        &self.points
    }

    /// Returns the corners of its cells, by places in the list of nodes.
    pub fn cells(&self) -> &[S::Corners<u32>] {
        &self.cells
    }

    /// Lists its named sides: the facets by their nodes.
    pub fn sides(&self) -> impl Iterator<Item = (&str, &[S::Axes<u32>])> {
        self.groups.iter().map(|(name, facets)| (name.as_str(), &facets[..]))
    }

    /// Returns the file's number of the cell that each cell was made of.
    pub fn cell_numbers(&self) -> &[u64] {
        &self.cell_numbers
    }

    /// Lists the groups of cells of the file.
    pub fn cell_group_names(&self) -> impl Iterator<Item = &str> {
        self.cell_groups.iter().map(String::as_str)
    }

    /// Says whether the file has a group of cells of this name.
    pub fn is_cell_group(&self, name: &str) -> bool {
        self.cell_groups.iter().any(|g| g == name)
    }

    /// Warns of cells with a small angle.
    ///
    /// * `angle`: what they have, in words.
    pub(super) fn warn_of_thin_cells(
        &mut self,
        angle: &str,
        is_thin: impl Fn(&S::Corners<S::Vector>) -> bool,
    ) {
        let corners = |cell: &S::Corners<u32>| S::corners(|k| self.points[cell[k] as usize]);
        let all = self.cells.iter().zip(&self.cell_numbers);
        let thin: Vec<u64> =
            all.filter(|(cell, _)| is_thin(&corners(cell))).map(|(_, number)| *number).collect();
        if thin.is_empty() {
            return;
        }
        let listed: Vec<String> = thin.iter().take(MOST_SLIVERS).map(u64::to_string).collect();
        let what = format!(
            "{} {} of {} with {angle} (elements {}{}): the bound holds, and is large there",
            thin.len(),
            if thin.len() == 1 { S::WORDS.cell } else { S::WORDS.cells },
            self.title,
            listed.join(", "),
            if thin.len() > listed.len() { ", …" } else { "" }
        );
        self.warnings.push(what.into());
    }

    /// Says that no side has a name, and what the free boundary is.
    ///
    /// * `free`: counts the free facets; `help`: what gives names to sides.
    pub(super) fn nameless(&self, free: impl FnOnce() -> usize, help: &str) -> Option<MeshFileError> {
        if !self.groups.is_empty() {
            return None;
        }
        let [low, high] = fem_core::geometry::bounding_box(&self.points);
        let sides: Vec<String> =
            (0..S::DIM).map(|c| format!("[{}, {}]", shown(low[c]), shown(high[c]))).collect();
        let found = format!(
            "{} has no named side: its free boundary has {} within {}",
            self.title,
            counted(free(), S::WORDS.facet),
            sides.join(" x ")
        );
        let error = MeshFileError::new(MeshFault::Region, &self.file, super::MeshPlace::File, found);
        Some(
            error
                .expected(format!("groups of {} to support, load and bring into contact", S::WORDS.facets))
                .help(help),
        )
    }
}

impl MeshFile {
    /// Takes a region: the cells of one group, or all cells if the file has at most one group of them, or elementary groups only.
    ///
    /// Quadrilaterals are split along their shorter diagonal, quadratic cells reduced to their corners, clockwise
    /// cells turned; [`Region::notes`] says how many. Every group of edges that has an edge of the region becomes one
    /// of its sides.
    ///
    /// # Errors
    /// A group that is not there or is empty, cells without an area, a mesh that is not plane.
    pub fn region(&self, name: Option<&str>, options: RegionOptions) -> Result<Region, MeshFileError> {
        self.regions(name.as_slice(), options)
    }

    /// [`Self::region`] of several groups of cells together; of all cells if there are no names.
    ///
    /// # Errors
    /// See [`Self::region`].
    pub fn regions(&self, names: &[&str], options: RegionOptions) -> Result<Region, MeshFileError> {
        self.check_cells()?;
        let (cells, title) = self.named_cells(&PLANE, names)?;
        let mut used = self.nodes_of(cells.iter().map(|cell| &self.cells[*cell as usize]));
        let left_out = self.check_plane(&used, &title)?;
        let mut notes = self.notes.clone();
        let mut warnings = Vec::new();
        self.note_loose_nodes(&mut notes);
        notes.extend(left_out);
        let points: Vec<Vector> = used.iter().map(|n| self.xy(*n)).collect();
        let target = self.join(&mut used, &points, options, &title, (&mut notes, &mut warnings));
        let made = self.triangulate(cells.iter().copied(), &|n| target[n as usize]);
        if let Some(cell) = &made.first_degenerate {
            return Err(self.degenerate(cell, made.degenerate, "has no area or crosses itself", &title));
        }
        notes.extend(made.describe(&title));
        let local = self.local_numbers(&used, &target);
        let cells: Vec<[u32; 3]> = made.corners.iter().map(|t| t.map(|n| local[n as usize])).collect();
        let points: Vec<Vector> = used.iter().map(|n| self.xy(*n)).collect();
        let edges: Vec<[u32; 2]> = cells.iter().flat_map(keys_of).collect();
        let facets = Facets { all: &edges, nodes: points.len(), word: "edge", dimension: 1, halves: &[] };
        let facets_of = |edge: u32| {
            let [a, b] = self.edges[edge as usize].nodes.map(|n| local[n as usize]);
            vec![key(a, b)]
        };
        let groups = self.sides(&local, &facets, &facets_of, &title, &mut warnings);
        let mut region = Region {
            file: self.name.clone(),
            title,
            points,
            cells,
            groups,
            node_numbers: used.iter().map(|n| self.node_numbers[*n as usize]).collect(),
            cell_numbers: made.cells,
            cell_groups: self.group_names(2).map(str::to_owned).collect(),
            notes,
            warnings,
        };
        region.warn_of_slivers();
        Ok(region)
    }

    /// Takes the cells of some groups together, all cells if there are no names; and what messages call them.
    pub(super) fn named_cells(
        &self,
        kind: &Kind,
        names: &[&str],
    ) -> Result<(Vec<u32>, String), MeshFileError> {
        Ok(match names {
            [] => (self.cells_of(kind, None)?, WHOLE.to_owned()),
            [name] => (self.cells_of(kind, Some(name))?, title_of(name)),
            names => {
                let of: Vec<Vec<u32>> =
                    names.iter().map(|name| self.cells_of(kind, Some(name))).collect::<Result<_, _>>()?;
                let mut cells = of.concat();
                cells.sort_unstable();
                cells.dedup();
                (cells, format!("the regions {}", listed(names)))
            }
        })
    }

    /// Joins the nodes at one place, if that is asked for; returns for each node of the file the one that takes its place.
    ///
    /// * `used`: the nodes of the region, less those that were joined with another; `points`: their places.
    pub(super) fn join<V: Coordinates>(
        &self,
        used: &mut Vec<u32>,
        points: &[V],
        options: RegionOptions,
        title: &str,
        (notes, warnings): (&mut Vec<String>, &mut Vec<Problem>),
    ) -> Vec<u32> {
        let mut target: Vec<u32> = (0..self.points.len() as u32).collect();
        let twins = coincident(points);
        if !twins.is_empty() && !options.merge {
            let found = self.twins(&twins, used, title) + ": the body is open there";
            warnings.push(Problem::new(found, Remedy::Merge));
        } else if !twins.is_empty() {
            notes.push(format!(
                "{} of {title} joined with the node at the same place",
                counted(twins.len(), "node")
            ));
            for [kept, other] in &twins {
                target[used[*other as usize] as usize] = used[*kept as usize];
            }
            used.retain(|n| target[*n as usize] == *n);
        }
        target
    }

    /// Returns for each node of the file its number in a region, or a number that is too large. Joined nodes are known by the one that was
    /// kept.
    pub(super) fn local_numbers(&self, used: &[u32], target: &[u32]) -> Vec<u32> {
        let mut local = vec![OUTSIDE; self.points.len()];
        for (k, node) in used.iter().enumerate() {
            local[*node as usize] = k as u32;
        }
        target.iter().map(|n| local[*n as usize]).collect()
    }

    /// Returns the file's numbers of the cells of a group, ascending; `None` if there is no such group.
    ///
    /// * `dimension`: 2 for cells, 3 for volumes.
    pub fn cells_of_group(&self, dimension: u8, name: &str) -> Option<Vec<u64>> {
        let group = self.groups.iter().find(|g| g.dimension == dimension && g.name == name)?;
        let cells = if dimension == 3 { &self.volumes } else { &self.cells };
        let numbers = group.members.iter().filter_map(|m| cells.get(*m as usize));
        let mut numbers: Vec<u64> = numbers.map(|cell| cell.number).collect();
        numbers.sort_unstable();
        Some(numbers)
    }

    /// Checks that there is something a body can be made of.
    pub(super) fn check_cells(&self) -> Result<(), MeshFileError> {
        if self.has_volumes() {
            let found = format!("the mesh has {}", self.volume_words());
            let error = self.fault(MeshFault::Region, found).expected("a plane mesh");
            return Err(error.help(
                "make all bodies of the case of volumes, or give the physical groups to surfaces only",
            ));
        }
        if !self.cells.is_empty() {
            return Ok(());
        }
        let found = format!("{} and no 2D elements", counted(self.edges.len(), "edge"));
        Err(self
            .fault(MeshFault::Region, found)
            .expected("triangles or quadrilaterals")
            .help("add a Physical Surface, or set Mesh.SaveAll: Gmsh saves only what lies in a group"))
    }

    /// Finds the cells of a group by name, with helpful words if there is no such group.
    fn cells_of(&self, kind: &Kind, name: Option<&str>) -> Result<Vec<u32>, MeshFileError> {
        let names: Vec<&str> = self.group_names(kind.dimension).collect();
        let Some(name) = name else {
            if names.len() < 2 || self.elementary {
                let count = if kind.dimension == 3 { self.volumes.len() } else { self.cells.len() };
                return Ok((0..count as u32).collect());
            }
            let found = format!("the file has {} regions", names.len());
            return Err(self
                .fault(MeshFault::Region, found)
                .expected(format!("the name of one of them: {}", listed(&names))));
        };
        if let Some(group) = self.groups.iter().find(|g| g.dimension == kind.dimension && g.name == name) {
            if group.members.is_empty() {
                let found = format!("region \"{name}\" is empty: no cell belongs to it");
                return Err(self
                    .fault(MeshFault::Region, found)
                    .expected(format!("a group with {}", kind.cells)));
            }
            let mut cells = group.members.clone();
            cells.sort_unstable();
            cells.dedup();
            return Ok(cells);
        }
        let of_sides = self.groups.iter().any(|g| g.dimension < kind.dimension && g.name == name);
        let found = if of_sides {
            format!("\"{name}\" is a group of {} or nodes, not a region", kind.facets)
        } else {
            format!("there is no region \"{name}\"")
        };
        let error = self.fault(MeshFault::Region, found);
        let error = if names.is_empty() {
            error.expected(format!(
                "a file with groups of cells (Gmsh: {}), or no name, which takes the whole mesh",
                kind.gmsh
            ))
        } else {
            error.expected(listed(&names))
        };
        Err(error.or_similar(name, names.iter().copied().take(MOST_COMPARED)))
    }

    /// Lists the nodes that are corners of cells, in the order of their numbers.
    pub(super) fn nodes_of<'a>(&self, cells: impl Iterator<Item = &'a MeshCell>) -> Vec<u32> {
        let mut there = vec![false; self.points.len()];
        for cell in cells {
            for node in cell.corners {
                there[node as usize] = true;
            }
        }
        (0..there.len() as u32).filter(|n| there[*n as usize]).collect()
    }

    pub(super) fn note_loose_nodes(&self, notes: &mut Vec<String>) {
        let loose = self.used.iter().filter(|used| !**used).count();
        if let Some(first) = self.used.iter().position(|used| !used) {
            notes.push(format!(
                "{} that no element uses: left out (the first is node {})",
                counted(loose, "node"),
                self.node_numbers[first]
            ));
        }
    }

    /// Makes the error of a cell whose corners make no cell.
    ///
    /// * `count`: how many there are; `fault`: what they have or are.
    pub(super) fn degenerate(
        &self,
        cell: &MeshCell,
        count: usize,
        fault: &str,
        title: &str,
    ) -> MeshFileError {
        let corners = &cell.corners[..cell.kind.corners()];
        let numbers: Vec<String> =
            corners.iter().map(|n| self.node_numbers[*n as usize].to_string()).collect();
        let axes = usize::from(cell.kind.dimension());
        let place = |n: &u32| format!("({})", self.points[*n as usize].map(shown)[..axes].join(", "));
        let places: Vec<String> = corners.iter().map(place).collect();
        let others = match count {
            1 => String::new(),
            n => format!("; so have {} of {title}", counted(n - 1, "other cell")),
        };
        let found = format!(
            "element {} ({}, nodes {} at {}) {fault}{others}",
            cell.number,
            cell.kind.name(),
            numbers.join(", "),
            places.join(", ")
        );
        let expected = if axes == 3 {
            "corners in the order of the format"
        } else {
            "corners that do not lie on one line"
        };
        self.fault(MeshFault::Content, found).expected(expected)
    }
}

impl Region {
    fn warn_of_slivers(&mut self) {
        let sine = SLIVER.to_radians().sin();
        let is_thin = |corners: &[Vector; 3]| !is_wide(*corners, sine) && smallest_angle(*corners) < SLIVER;
        self.warn_of_thin_cells(&format!("an angle below {SLIVER} degrees"), is_thin);
    }

    /// Says that no side has a name, and what the free boundary is.
    pub fn without_sides(&self) -> Option<MeshFileError> {
        self.nameless(
            || free_facets(self.cells.iter().flat_map(keys_of).collect()).len(),
            "in Gmsh give names to the sides: Physical Curve(\"bottom\") = {…}; in a deck use *SURFACE; or select them \
             in the case file by [[body.side]]",
        )
    }
}

/// Counts the nodes and finds a cell that two regions of one file share: such bodies cannot part.
///
/// Returns the number of shared nodes, one of them with its place, and the number of a shared cell.
pub fn glued_nodes<S: Space>(a: &Region<S>, b: &Region<S>) -> Option<(usize, u64, S::Vector, Option<u64>)> {
    let (mut i, mut j) = (0, 0);
    let mut shared = HashSet::new();
    let mut first = None;
    while let (Some(x), Some(y)) = (a.node_numbers.get(i), b.node_numbers.get(j)) {
        if x == y {
            first.get_or_insert((*x, a.points[i]));
            shared.insert(*x);
        }
        let (forward, back) = (x <= y, y <= x);
        i += usize::from(forward);
        j += usize::from(back);
    }
    let (number, point) = first?;
    let of_shared = |region: &Region<S>| -> HashSet<(u64, Vec<u64>)> {
        let is_shared = |n: &u32| shared.contains(&region.node_numbers[*n as usize]);
        let all = region.cells.iter().zip(&region.cell_numbers);
        let numbered = |(corners, cell): (&S::Corners<u32>, &u64)| {
            let mut numbers: Vec<u64> =
                corners.as_ref().iter().map(|n| region.node_numbers[*n as usize]).collect();
            numbers.sort_unstable();
            (*cell, numbers)
        };
        all.filter(|(corners, _)| corners.as_ref().iter().all(is_shared)).map(numbered).collect()
    };
    let corners: HashSet<Vec<u64>> = of_shared(a).into_iter().map(|(_, t)| t).collect();
    let cell = of_shared(b).into_iter().filter(|(_, t)| corners.contains(t)).map(|(cell, _)| cell).min();
    Some((shared.len(), number, point, cell))
}
