//! Collects nodes and elements while a file is read, and checks them against each other at its end.

use super::{Edge, ElementKind, MeshCell, MeshFault, MeshFile, MeshFileError, MeshPlace, NumberIndex};
use crate::words::counted;
use fem_core::geometry::shown;

/// A line of one of the files that make up a mesh; line 0 if lines mean nothing.
#[derive(Clone, Copy, Default)]
pub(crate) struct Spot {
    pub(crate) file: u16,
    pub(crate) line: u32,
}

struct Node {
    number: u64,
    spot: Spot,
    point: [f64; 3],
}

struct Element {
    number: u64,
    spot: Spot,
    kind: ElementKind,
    set: u32,
    /// The index of its first node in `connectivity`.
    start: usize,
}

/// The nodes and elements read so far, with their spots.
#[derive(Default)]
pub(crate) struct Collector {
    /// The names that spots refer to; the first is the file's own.
    pub(crate) files: Vec<String>,
    nodes: Vec<Node>,
    elements: Vec<Element>,
    connectivity: Vec<u64>,
}

/// A mesh whose nodes and elements agree, with the set each of its edges and cells was given.
pub(crate) struct Collected {
    pub(crate) mesh: MeshFile,
    pub(crate) edge_sets: Vec<u32>,
    pub(crate) cell_sets: Vec<u32>,
    pub(crate) volume_sets: Vec<u32>,
}

impl Collected {
    /// Makes an error about the file as a whole.
    pub(crate) fn fault(&self, found: impl Into<String>) -> MeshFileError {
        self.mesh.fault(MeshFault::Content, found)
    }
}

impl Collector {
    pub(crate) fn new(file: &str) -> Self {
        Self { files: vec![file.to_owned()], ..Self::default() }
    }

    /// Makes room for nodes that are known to be there.
    pub(crate) fn reserve_nodes(&mut self, count: usize) {
        self.nodes.reserve(count);
    }

    /// Makes room for elements that are known to be there.
    pub(crate) fn reserve_elements(&mut self, count: usize) {
        self.elements.reserve(count);
        self.connectivity.reserve(3 * count);
    }

    /// Adds a node; its coordinates must be finite.
    pub(crate) fn node(&mut self, number: u64, point: [f64; 3], spot: Spot) -> Result<(), MeshFileError> {
        if point.iter().any(|x| !x.is_finite()) {
            let [x, y, z] = point.map(shown);
            let found = format!("node {number} has the coordinates ({x}, {y}, {z})");
            return Err(self.fault(spot, found).expected("finite numbers"));
        }
        self.nodes.push(Node { number, spot, point });
        Ok(())
    }

    /// Adds an element; `nodes` are the file's numbers, as many as its kind has.
    pub(crate) fn element(&mut self, number: u64, kind: ElementKind, nodes: &[u64], set: u32, spot: Spot) {
        self.elements.push(Element { number, spot, kind, set, start: self.connectivity.len() });
        self.connectivity.extend_from_slice(nodes);
    }

    /// Counts the elements so far.
    pub(crate) fn element_count(&self) -> usize {
        self.elements.len()
    }

    /// Makes an error at a spot.
    pub(crate) fn fault(&self, spot: Spot, found: impl Into<String>) -> MeshFileError {
        let file = self.files.get(usize::from(spot.file)).map_or("", String::as_str);
        let place = if spot.line == 0 { MeshPlace::File } else { MeshPlace::Line(u64::from(spot.line)) };
        MeshFileError::new(MeshFault::Content, file, place, found)
    }

    /// Puts nodes and elements in the order of their numbers and resolves who belongs to whom.
    pub(crate) fn finish(mut self, format: String) -> Result<Collected, MeshFileError> {
        self.check_sizes()?;
        if !self.nodes.is_sorted_by_key(|n| n.number) {
            // A stable sort: if two nodes have one number, the later one is blamed.
            self.nodes.sort_by_key(|n| n.number);
        }
        if !self.elements.is_sorted_by_key(|e| e.number) {
            self.elements.sort_by_key(|e| e.number);
        }
        if let Some([a, b]) = equal_neighbours(&self.nodes, |n| n.number) {
            let found = format!("node {} is given twice{}", b.number, self.first_time(a.spot));
            return Err(self.fault(b.spot, found).expected("every node number once"));
        }
        if let Some([a, b]) = equal_neighbours(&self.elements, |e| e.number) {
            let found = format!("element {} is given twice{}", b.number, self.first_time(a.spot));
            return Err(self.fault(b.spot, found).expected("every element number once"));
        }
        let node_numbers: Vec<u64> = self.nodes.iter().map(|n| n.number).collect();
        let index = NumberIndex::new(&node_numbers);
        let mut used = vec![false; node_numbers.len()];
        let (mut edges, mut cells, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut edge_sets, mut cell_sets, mut volume_sets) = (Vec::new(), Vec::new(), Vec::new());
        let mut loops = 0;
        for element in &self.elements {
            let corners = self.resolve(element, &index, &mut used)?;
            match element.kind.dimension() {
                1 if corners[0] == corners[1] => loops += 1,
                1 => {
                    edges.push(Edge { number: element.number, nodes: [corners[0], corners[1]] });
                    edge_sets.push(element.set);
                }
                2 => {
                    cells.push(MeshCell { number: element.number, kind: element.kind, corners });
                    cell_sets.push(element.set);
                }
                3 => {
                    volumes.push(MeshCell { number: element.number, kind: element.kind, corners });
                    volume_sets.push(element.set);
                }
                _ => {}
            }
        }
        let points = self.nodes.iter().map(|n| n.point).collect();
        let mut mesh = MeshFile {
            name: self.files.swap_remove(0),
            format,
            node_numbers,
            points,
            used,
            edges,
            cells,
            volumes,
            ..MeshFile::default()
        };
        if loops > 0 {
            mesh.push_note(format!("{} from a node to itself: left out", counted(loops, "edge")));
        }
        Ok(Collected { mesh, edge_sets, cell_sets, volume_sets })
    }

    /// Finds the corners of an element (the last repeated if there are fewer than eight) and checks its nodes.
    fn resolve(
        &self,
        element: &Element,
        index: &NumberIndex,
        used: &mut [bool],
    ) -> Result<[u32; ElementKind::MOST_CORNERS], MeshFileError> {
        let kind = element.kind;
        let nodes = self.connectivity.get(element.start..element.start + kind.nodes()).unwrap_or_default();
        let mut corners = [0; ElementKind::MOST_CORNERS];
        for (k, &number) in nodes.iter().enumerate() {
            let Some(place) = index.find(number) else {
                let found = format!(
                    "element {} ({}) uses node {number}, which the file does not have",
                    element.number,
                    kind.name()
                );
                let expected = match (self.nodes.first(), self.nodes.last()) {
                    (Some(a), Some(b)) => {
                        format!(
                            "one of its {}, numbered from {} to {}",
                            counted(self.nodes.len(), "node"),
                            a.number,
                            b.number
                        )
                    }
                    _ => "nodes; it has none".to_owned(),
                };
                return Err(self.fault(element.spot, found).expected(expected));
            };
            if kind != ElementKind::Point {
                used[place as usize] = true;
            }
            if k < kind.corners() {
                corners[k..].fill(place);
            }
        }
        let different = |k: usize| (0..k).all(|j| corners[j] != corners[k]);
        // Other volumes may be collapsed, a hexahedron with one edge for a face is a prism; edges from a node to itself are left out.
        if matches!(kind.corners(), 3 | 4) && !(1..kind.corners()).all(different) {
            let listed: Vec<String> = nodes.iter().take(kind.corners()).map(u64::to_string).collect();
            let found = format!(
                "element {} ({}) has the corners {}: one node twice",
                element.number,
                kind.name(),
                listed.join(", ")
            );
            return Err(self.fault(element.spot, found).expected("different nodes"));
        }
        Ok(corners)
    }

    fn first_time(&self, spot: Spot) -> String {
        if spot.line == 0 { String::new() } else { format!(", first in line {}", spot.line) }
    }

    fn check_sizes(&self) -> Result<(), MeshFileError> {
        // The largest count in fem-core, see `TriMesh`; quadrilaterals count twice there.
        let limit = (u32::MAX / 16) as usize;
        for (count, what) in [(self.nodes.len(), "node"), (self.elements.len(), "element")] {
            if count > limit {
                let found = format!("the file has {}", counted(count, what));
                return Err(self.fault(Spot::default(), found).expected(format!("at most {limit}")));
            }
        }
        Ok(())
    }
}

/// Finds the first two neighbours with the same key.
fn equal_neighbours<T>(items: &[T], key: impl Fn(&T) -> u64) -> Option<[&T; 2]> {
    items.windows(2).find(|w| key(&w[0]) == key(&w[1])).map(|w| [&w[0], &w[1]])
}
