//! Sets and surfaces: collected while the deck is read, resolved when nodes and elements are known.

use super::keyword::upper;
use crate::mesh_file::{Group, MeshFault, MeshFile, MeshFileError, MeshPlace, NumberIndex, Spot};
use std::collections::{HashMap, HashSet};
use std::fmt::{self, Display, Formatter};

/// Members that all sets together may have: for each byte of the deck, and in addition.
const MEMBERS_PER_BYTE: usize = 4;
const MEMBERS: usize = 10_000;
/// Sets whose names are compared with a misspelt one.
const MOST_COMPARED: usize = 1000;

/// One entry of a set.
pub(super) enum Entry {
    Range { from: u64, to: u64, step: u64 },
    Name(String),
}

/// A set: its name as written first, and its entries with their places.
struct Set {
    name: String,
    entries: Vec<(Entry, Spot)>,
}

/// Sets of nodes, or sets of elements, by name without regard to case.
#[derive(Default)]
pub(super) struct Registry {
    sets: Vec<Set>,
    index: HashMap<String, usize>,
}

impl Registry {
    /// Finds a set or makes it; sets with one name grow.
    pub(super) fn define(&mut self, name: &str) -> usize {
        *self.index.entry(upper(name)).or_insert_with(|| {
            self.sets.push(Set { name: name.to_owned(), entries: Vec::new() });
            self.sets.len() - 1
        })
    }

    pub(super) fn add(&mut self, set: usize, entries: Vec<Entry>, spot: Spot) {
        self.sets[set].entries.extend(entries.into_iter().map(|e| (e, spot)));
    }

    /// Adds one number; runs of numbers become one entry.
    pub(super) fn add_number(&mut self, set: usize, number: u64, spot: Spot) {
        let entries = &mut self.sets[set].entries;
        match entries.last_mut() {
            Some((Entry::Range { to, step: 1, .. }, _)) if to.checked_add(1) == Some(number) => *to = number,
            _ => entries.push((Entry::Range { from: number, to: number, step: 1 }, spot)),
        }
    }
}

/// The elements or nodes of a line of a surface: one by its number, or a set by its name.
pub(super) enum Target {
    Number(u64),
    Name(String),
}

/// The face of an element in a surface.
#[derive(Clone, Copy)]
pub(super) enum Face {
    /// `S1` to `S6`: the sides of a plane element; of a shell its two faces, then its edges, as CalculiX counts.
    Side(usize),
    /// `E1` to `E4`: the edges of a shell, as Abaqus counts.
    Edge(usize),
    /// `SPOS`, `SNEG`: a face of a shell, no side.
    Whole,
}

impl Face {
    /// Reads a face in upper case.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let number =
            |digits: &str, most: usize| digits.parse::<usize>().ok().filter(|n| (1..=most).contains(n));
        match text {
            "SPOS" | "SNEG" => Some(Self::Whole),
            _ => match text.split_at_checked(1)? {
                ("S", digits) => number(digits, 6).map(Self::Side),
                ("E", digits) => number(digits, 4).map(Self::Edge),
                _ => None,
            },
        }
    }

    /// Returns the place of the side among the sides of its element; `None` for the face of a shell.
    fn side(self, shell: bool) -> Option<usize> {
        match self {
            Self::Side(n) if shell => n.checked_sub(3),
            Self::Side(n) | Self::Edge(n) => Some(n - 1),
            Self::Whole => None,
        }
    }
}

impl Display for Face {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Side(n) => write!(f, "S{n}"),
            Self::Edge(n) => write!(f, "E{n}"),
            Self::Whole => f.write_str("SPOS"),
        }
    }
}

/// A surface: sides of elements, or nodes.
pub(super) struct Surface {
    name: String,
    pub(super) of_nodes: bool,
    entries: Vec<(Target, Face, Spot)>,
}

impl Surface {
    pub(super) fn add(&mut self, (target, face): (Target, Face), spot: Spot) {
        self.entries.push((target, face, spot));
    }
}

/// All sets and surfaces of a deck.
#[derive(Default)]
pub(super) struct Sets {
    pub(super) nodes: Registry,
    pub(super) elements: Registry,
    pub(super) surfaces: Vec<Surface>,
    /// Numbers of shells, whose faces are counted differently.
    pub(super) shells: Vec<u64>,
    /// Numbers of springs, masses and the like.
    pub(super) no_cells: Vec<u64>,
    surface_index: HashMap<(String, bool), usize>,
}

impl Sets {
    /// Returns the sets of nodes, or the sets of elements.
    pub(super) fn registry(&mut self, of_nodes: bool) -> &mut Registry {
        if of_nodes { &mut self.nodes } else { &mut self.elements }
    }

    /// Tells whether a set or a surface has a name.
    pub(super) fn has(&self, name: &str) -> bool {
        let name = upper(name);
        let surface =
            [true, false].map(|of_nodes| self.surface_index.contains_key(&(name.clone(), of_nodes)));
        [&self.nodes, &self.elements].iter().any(|sets| sets.index.contains_key(&name))
            || surface.contains(&true)
    }

    pub(super) fn define_surface(&mut self, name: &str, of_nodes: bool) -> usize {
        *self.surface_index.entry((upper(name), of_nodes)).or_insert_with(|| {
            self.surfaces.push(Surface { name: name.to_owned(), of_nodes, entries: Vec::new() });
            self.surfaces.len() - 1
        })
    }

    /// Makes the groups of the mesh.
    ///
    /// * `bytes`: the size of the deck, which bounds how many members all sets together may have.
    pub(super) fn apply(
        mut self,
        mesh: &mut MeshFile,
        files: &[String],
        bytes: usize,
    ) -> Result<(), MeshFileError> {
        let mut work = Work { files, left: bytes.saturating_mul(MEMBERS_PER_BYTE).saturating_add(MEMBERS) };
        let node_numbers = mesh.node_numbers().to_vec();
        let (edge_numbers, cell_numbers) = (mesh.edge_numbers(), mesh.cell_numbers());
        let volume_numbers = mesh.volume_numbers();
        let mut element_numbers =
            [edge_numbers.as_slice(), &cell_numbers, &volume_numbers, &self.no_cells].concat();
        self.shells.sort_unstable();
        element_numbers.sort_unstable();
        element_numbers.dedup();
        let node_sets = work.resolve(&self.nodes, &node_numbers, "node")?;
        let element_sets = work.resolve(&self.elements, &element_numbers, "element")?;
        let cells = NumberIndex::new(&cell_numbers);
        let volumes = NumberIndex::new(&volume_numbers);
        let mut taken = HashSet::new();
        for surface in self.surfaces.iter().filter(|s| !s.of_nodes) {
            let sides = self.sides(surface, &element_sets, [&cells, &volumes], mesh, &mut work)?;
            taken.insert(upper(&surface.name));
            let [edges, faces] = sides;
            if !faces.is_empty() {
                mesh.push_group(Group { dimension: 2, name: surface.name.clone(), members: faces });
            }
            if !edges.is_empty() || !mesh.has_volumes() {
                mesh.push_group(Group { dimension: 1, name: surface.name.clone(), members: edges });
            }
        }
        let edges = NumberIndex::new(&edge_numbers);
        for (set, numbers) in self.elements.sets.iter().zip(&element_sets) {
            let (of_edges, of_cells) = (places(numbers, &edges), places(numbers, &cells));
            let of_volumes = places(numbers, &volumes);
            if !of_volumes.is_empty() {
                mesh.push_group(Group { dimension: 3, name: set.name.clone(), members: of_volumes });
            }
            // A surface is the more deliberate of two groups of edges with one name.
            if !of_edges.is_empty() && !taken.contains(&upper(&set.name)) {
                mesh.push_group(Group { dimension: 1, name: set.name.clone(), members: of_edges });
            }
            let is_surface = mesh.has_volumes() && taken.contains(&upper(&set.name));
            if (!of_cells.is_empty() || numbers.is_empty()) && !is_surface {
                mesh.push_group(Group { dimension: 2, name: set.name.clone(), members: of_cells });
            }
        }
        taken.extend(self.elements.sets.iter().map(|s| upper(&s.name)));
        self.node_groups(&node_sets, &node_numbers, taken, mesh, &mut work)
    }

    /// Finds the sides of a surface: edges of cells and faces of volumes.
    ///
    /// * `elements`: cells, then volumes.
    fn sides(
        &self,
        surface: &Surface,
        element_sets: &[Vec<u64>],
        [cells, volumes]: [&NumberIndex; 2],
        mesh: &mut MeshFile,
        work: &mut Work<'_>,
    ) -> Result<[Vec<u32>; 2], MeshFileError> {
        let mut members = [Vec::new(), Vec::new()];
        for (target, face, spot) in &surface.entries {
            let numbers = match target {
                Target::Number(number) => std::slice::from_ref(number),
                Target::Name(name) => &element_sets[work.find(&self.elements, name, *spot, "element")?],
            };
            work.spend(numbers.len(), *spot)?;
            for number in numbers {
                let Some(place) = face.side(self.shells.binary_search(number).is_ok()) else { continue };
                let edge = cells.find(*number).and_then(|cell| mesh.push_edge(cell, place));
                let of_volume =
                    || volumes.find(*number).and_then(|volume| mesh.push_face(volume, place)).map(|k| (1, k));
                let Some((list, side)) = edge.map(|edge| (0, edge)).or_else(of_volume) else {
                    let found =
                        format!("surface \"{}\" takes the face {face} of element {number}", surface.name);
                    return Err(work.fault(*spot, found).expected("an element that has this face"));
                };
                members[list].push(side);
            }
        }
        Ok(members)
    }

    /// Makes groups of the sets of nodes whose names are free.
    fn node_groups(
        &self,
        node_sets: &[Vec<u64>],
        node_numbers: &[u64],
        mut taken: HashSet<String>,
        mesh: &mut MeshFile,
        work: &mut Work<'_>,
    ) -> Result<(), MeshFileError> {
        let index = NumberIndex::new(node_numbers);
        for surface in self.surfaces.iter().filter(|s| s.of_nodes) {
            let mut members = Vec::new();
            for (target, _, spot) in &surface.entries {
                let numbers = match target {
                    Target::Number(number) => std::slice::from_ref(number),
                    Target::Name(name) => &node_sets[work.find(&self.nodes, name, *spot, "node")?],
                };
                work.spend(numbers.len(), *spot)?;
                members.extend(places(numbers, &index));
            }
            members.sort_unstable();
            members.dedup();
            if taken.insert(upper(&surface.name)) {
                mesh.push_group(Group { dimension: 0, name: surface.name.clone(), members });
            }
        }
        for (set, numbers) in self.nodes.sets.iter().zip(node_sets) {
            if taken.insert(upper(&set.name)) {
                let members = places(numbers, &index);
                mesh.push_group(Group { dimension: 0, name: set.name.clone(), members });
            }
        }
        Ok(())
    }
}

fn places(numbers: &[u64], index: &NumberIndex) -> Vec<u32> {
    numbers.iter().filter_map(|n| index.find(*n)).collect()
}

/// Resolves entries, within bounds.
struct Work<'a> {
    files: &'a [String],
    /// How many more members may be looked at.
    left: usize,
}

impl Work<'_> {
    fn fault(&self, spot: Spot, found: String) -> MeshFileError {
        let file = self.files.get(usize::from(spot.file)).map_or("", String::as_str);
        MeshFileError::new(MeshFault::Content, file, MeshPlace::Line(u64::from(spot.line)), found)
    }

    /// Takes members from what is left: without this bound a few bytes (`1, 1000000000`, again and again) would cost
    /// any amount of memory and time.
    fn spend(&mut self, members: usize, spot: Spot) -> Result<(), MeshFileError> {
        match self.left.checked_sub(members) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(self
                .fault(
                    spot,
                    "the sets expand to more members than this file can describe; it is probably damaged"
                        .to_owned(),
                )
                .expected("fewer or smaller sets")),
        }
    }

    fn find(&self, registry: &Registry, name: &str, spot: Spot, what: &str) -> Result<usize, MeshFileError> {
        registry.index.get(&upper(name)).copied().ok_or_else(|| {
            let error = self.fault(spot, format!("there is no {what} set \"{name}\""));
            let names = registry.sets.iter().take(MOST_COMPARED).map(|s| s.name.as_str());
            error.expected("the name of a set of the deck").or_similar(name, names)
        })
    }

    /// Resolves all sets of a registry to ascending numbers of what exists.
    fn resolve(
        &mut self,
        registry: &Registry,
        existing: &[u64],
        what: &str,
    ) -> Result<Vec<Vec<u64>>, MeshFileError> {
        let index = NumberIndex::new(existing);
        let mut resolved: Vec<Vec<u64>> = Vec::with_capacity(registry.sets.len());
        for (place, set) in registry.sets.iter().enumerate() {
            let mut members = Vec::new();
            for (entry, spot) in &set.entries {
                match entry {
                    Entry::Range { from, to, step } => {
                        self.range(*from, *to, *step, existing, &index, &mut members, *spot)?;
                        if from == to && members.last() != Some(from) {
                            let found = format!(
                                "{what} set \"{}\" names {what} {from}, which the deck does not have",
                                set.name
                            );
                            return Err(self.fault(*spot, found).expected("numbers of the deck"));
                        }
                    }
                    Entry::Name(name) => {
                        let other = self.find(registry, name, *spot, what)?;
                        if other >= place {
                            let found = format!("{what} set \"{}\" contains the set \"{name}\"", set.name);
                            return Err(self.fault(*spot, found).expected("sets that begin before it"));
                        }
                        self.spend(resolved[other].len(), *spot)?;
                        members.extend_from_slice(&resolved[other]);
                    }
                }
            }
            members.sort_unstable();
            members.dedup();
            resolved.push(members);
        }
        Ok(resolved)
    }

    /// Takes what exists of a range, looking at no more than the smaller of the two.
    #[allow(clippy::too_many_arguments)]
    fn range(
        &mut self,
        from: u64,
        to: u64,
        step: u64,
        existing: &[u64],
        index: &NumberIndex,
        members: &mut Vec<u64>,
        spot: Spot,
    ) -> Result<(), MeshFileError> {
        let terms = (to - from) / step;
        let (low, high) = (existing.partition_point(|n| *n < from), existing.partition_point(|n| *n <= to));
        if terms < (high - low) as u64 {
            self.spend(terms as usize + 1, spot)?;
            members.extend((0..=terms).map(|k| from + k * step).filter(|n| index.find(*n).is_some()));
        } else {
            self.spend(high - low, spot)?;
            members.extend(existing[low..high].iter().filter(|n| (*n - from).is_multiple_of(step)));
        }
        Ok(())
    }
}
