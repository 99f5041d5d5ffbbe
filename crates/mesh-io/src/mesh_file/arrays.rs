//! Meshes that a program keeps in memory: arrays instead of a file.

use super::sides::{facets_among, key, keys_of};
use super::{Edge, ElementKind, Group, MeshCell, MeshFault, MeshFile, MeshFileError};
use crate::words::counted;
use fem_core::geometry::shown;
use sha2::{Digest, Sha256};

/// Largest number of points or cells in fem-core, see `TriMesh`.
const MOST: usize = (u32::MAX / 16) as usize;

/// Points or cells that are hashed at once.
const BLOCK: usize = 1 << 12;

/// Points, triangles and named parts of them. Everything is counted from 0, and so are the nodes and cells of messages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshArrays {
    /// Coordinates of the nodes, z last.
    pub points: Vec<[f64; 3]>,
    /// The corners of each cell, in either direction.
    pub triangles: Vec<[u64; 3]>,
    /// Names of sides and their edges, each by its two nodes.
    pub sides: Vec<(String, Vec<[u64; 2]>)>,
    /// Names of regions and their triangles.
    pub regions: Vec<(String, Vec<u64>)>,
}

impl MeshFile {
    /// Takes arrays instead of the contents of a file.
    ///
    /// ```
    /// use mesh_io::{MeshArrays, MeshFile, RegionOptions};
    /// let arrays = MeshArrays {
    ///     points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ///     triangles: vec![[0, 1, 2]],
    ///     sides: vec![("base".into(), vec![[1, 0]])],
    ///     regions: vec![("plate".into(), vec![0])],
    /// };
    /// let mesh = MeshFile::of_arrays("plate", &arrays)?.region(Some("plate"), RegionOptions::default())?.mesh()?;
    /// assert_eq!(mesh.group("base").map(<[_]>::len), Some(1));
    /// # Ok::<(), mesh_io::MeshFileError>(())
    /// ```
    ///
    /// * `name`: what messages call the mesh.
    ///
    /// # Errors
    /// Coordinates that are not finite; nodes and triangles that are not there; edges that no triangle has; two sides, or two
    /// regions, of one name.
    pub fn of_arrays(name: &str, arrays: &MeshArrays) -> Result<Self, MeshFileError> {
        let mut mesh = Self {
            name: name.to_owned(),
            format: "arrays".to_owned(),
            node_numbers: (0..arrays.points.len() as u64).collect(),
            points: arrays.points.clone(),
            used: vec![false; arrays.points.len()],
            cells: Vec::with_capacity(arrays.triangles.len()),
            ..Self::default()
        };
        let edges = arrays.sides.iter().map(|(_, edges)| edges.len()).sum();
        let counts = [(arrays.points.len(), "node"), (arrays.triangles.len(), "triangle"), (edges, "edge")];
        if let Some((count, what)) = counts.into_iter().find(|(count, _)| *count > MOST) {
            let found = format!("there are {}", counted(count, what));
            return Err(mesh.fault(MeshFault::Content, found).expected(format!("at most {MOST}")));
        }
        if let Some((node, point)) =
            arrays.points.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.is_finite()))
        {
            let [x, y, z] = point.map(shown);
            let found = format!("node {node} has the coordinates ({x}, {y}, {z})");
            return Err(mesh.fault(MeshFault::Content, found).expected("finite numbers"));
        }
        for (number, corners) in (0..).zip(&arrays.triangles) {
            let [a, b, c] = mesh.nodes(corners, || format!("triangle {number}"))?;
            mesh.cells.push(MeshCell { number, kind: ElementKind::Triangle3, corners: [a, b, c, c] });
        }
        // Edges are numbered behind the triangles.
        let edges = arrays.sides.iter().flat_map(|(side, edges)| edges.iter().map(move |ends| (side, ends)));
        for (number, (side, ends)) in (arrays.triangles.len() as u64..).zip(edges) {
            let nodes = mesh.nodes(ends, || format!("side \"{side}\""))?;
            mesh.edges.push(Edge { number, nodes });
        }
        let mut first = 0;
        for (side, edges) in &arrays.sides {
            let next = first + edges.len() as u32;
            mesh.take_group(1, side, (first..next).collect())?;
            first = next;
        }
        for (region, cells) in &arrays.regions {
            if let Some(cell) = cells.iter().find(|cell| **cell >= arrays.triangles.len() as u64) {
                let found = format!("region \"{region}\" has the triangle {cell}");
                let expected = format!("numbers below {}", arrays.triangles.len());
                return Err(mesh.fault(MeshFault::Content, found).expected(expected));
            }
            mesh.take_group(2, region, cells.iter().map(|cell| *cell as u32).collect())?;
        }
        mesh.check_edges_of_sides()?;
        mesh.digest = mesh.digest_of_contents();
        Ok(mesh)
    }

    /// Takes the nodes of a triangle or an edge, which are used then.
    fn nodes<const N: usize>(
        &mut self,
        nodes: &[u64; N],
        of: impl Fn() -> String,
    ) -> Result<[u32; N], MeshFileError> {
        for (k, node) in nodes.iter().enumerate() {
            let used = usize::try_from(*node).ok().and_then(|node| self.used.get_mut(node));
            let Some(used) = used else {
                let found = format!("{} has the node {node}", of());
                return Err(self
                    .fault(MeshFault::Content, found)
                    .expected(format!("numbers below {}", self.used.len())));
            };
            *used = true;
            if nodes[..k].contains(node) {
                let found = format!("{} has the node {node} twice", of());
                return Err(self.fault(MeshFault::Content, found).expected("different nodes"));
            }
        }
        Ok(nodes.map(|node| node as u32))
    }

    /// Adds a group under a name that no other of its dimension has.
    fn take_group(&mut self, dimension: u8, name: &str, members: Vec<u32>) -> Result<(), MeshFileError> {
        if self.group_names(dimension).any(|other| other == name) {
            let what = if dimension == 1 { "sides" } else { "regions" };
            let found = format!("two {what} are called \"{name}\"");
            return Err(self.fault(MeshFault::Content, found).expected("names that differ"));
        }
        self.push_group(Group { dimension, name: name.to_owned(), members });
        Ok(())
    }

    /// Computes the SHA-256 of points, triangles and groups, in hexadecimal.
    fn digest_of_contents(&self) -> String {
        let mut hasher = Sha256::new();
        // Lengths keep two meshes from being taken for one.
        let mut take = |bytes: &[u8]| {
            hasher.update((bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        let of_points = |points: &[[f64; 3]]| -> Vec<[u8; 8]> {
            points.as_flattened().iter().map(|x| x.to_bits().to_le_bytes()).collect()
        };
        let of_cells = |cells: &[MeshCell]| -> Vec<[[u8; 4]; 3]> {
            cells.iter().map(|cell| [0, 1, 2].map(|k| cell.corners[k].to_le_bytes())).collect()
        };
        self.points.chunks(BLOCK).for_each(|block| take(of_points(block).as_flattened()));
        self.cells.chunks(BLOCK).for_each(|block| take(of_cells(block).as_flattened().as_flattened()));
        for group in &self.groups {
            let edge = |member: &u32| self.edges[*member as usize].nodes;
            let members: Vec<u32> = match group.dimension {
                1 => group.members.iter().flat_map(edge).collect(),
                _ => group.members.clone(),
            };
            take(&[group.dimension]);
            take(group.name.as_bytes());
            take(members.iter().map(|member| member.to_le_bytes()).collect::<Vec<_>>().as_flattened());
        }
        hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Refuses an edge of a side that no triangle has. A file may have such edges, a program that gives them has counted wrong.
    fn check_edges_of_sides(&self) -> Result<(), MeshFileError> {
        let triangles: Vec<[u32; 3]> =
            self.cells.iter().map(|cell| [cell.corners[0], cell.corners[1], cell.corners[2]]).collect();
        let wanted = self.edges.iter().map(|edge| key(edge.nodes[0], edge.nodes[1])).collect();
        let edges: Vec<[u32; 2]> = triangles.iter().flat_map(keys_of).collect();
        let there = facets_among(&edges, self.points.len(), wanted);
        let stray = |edge: &Edge| there.binary_search(&key(edge.nodes[0], edge.nodes[1])).is_err();
        let Some(number) = self.edges.iter().position(stray) else { return Ok(()) };
        let owns = |group: &&Group| group.dimension == 1 && group.members.contains(&(number as u32));
        let side = self.groups.iter().find(owns).map_or("", |group| &group.name);
        let [a, b] = self.edges[number].nodes;
        let found = format!("side \"{side}\" has the edge between nodes {a} and {b}, which no triangle has");
        Err(self.fault(MeshFault::Content, found).expected("edges of the triangles, each by its two nodes"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Change<'a> = &'a dyn Fn(&mut MeshArrays);

    fn square() -> MeshArrays {
        MeshArrays {
            points: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| [x, y, 0.0]).to_vec(),
            triangles: vec![[0, 1, 2], [3, 2, 0]],
            sides: vec![("bottom".into(), vec![[1, 0]]), ("all".into(), vec![[0, 1], [1, 2]])],
            regions: vec![("a".into(), vec![0]), ("b".into(), vec![1])],
        }
    }

    #[test]
    fn arrays_become_sides_and_regions_of_a_mesh() {
        let file = MeshFile::of_arrays("square", &square()).unwrap();
        let whole = file.regions(&["a", "b"], Default::default()).unwrap();
        assert_eq!((whole.cells().len(), whole.node_numbers()), (2, &[0, 1, 2, 3][..]));
        let mesh = whole.mesh().unwrap();
        assert_eq!(["bottom", "all"].map(|name| mesh.group(name).unwrap().len()), [1, 2]);
        assert_eq!(file.region(Some("b"), Default::default()).unwrap().node_numbers(), [0, 2, 3]);
    }

    #[test]
    fn the_digest_is_that_of_the_contents() {
        let digest = |change: Change<'_>| {
            let mut arrays = square();
            change(&mut arrays);
            MeshFile::of_arrays("square", &arrays).unwrap().digest().to_owned()
        };
        let plain = digest(&|_| {});
        assert_eq!((plain.len(), &plain), (64, &digest(&|_| {})));
        let changes: [&dyn Fn(&mut MeshArrays); 4] =
            [&|a| a.points[1][0] = 1.5, &|a| a.triangles.swap(0, 1), &|a| a.sides[0].0.push('s'), &|a| {
                a.regions[1].1 = vec![0]
            }];
        assert!(changes.iter().all(|change| digest(change) != plain));
    }

    #[test]
    fn wrong_arrays_are_refused_with_their_numbers() {
        let said = |change: Change<'_>| {
            let mut arrays = square();
            change(&mut arrays);
            MeshFile::of_arrays("square", &arrays).unwrap_err().to_string()
        };
        let faults: [(Change<'_>, &str); 7] = [
            (&|a| a.points[2][1] = f64::NAN, "square: node 2 has the coordinates (1, NaN, 0)"),
            (&|a| a.triangles[1][0] = 9, "triangle 1 has the node 9; expected numbers below 4"),
            (&|a| a.triangles[1][0] = 2, "triangle 1 has the node 2 twice"),
            (
                &|a| a.sides[1].1[1] = [1, 3],
                "side \"all\" has the edge between nodes 1 and 3, which no triangle has",
            ),
            (&|a| a.sides[1].0 = "bottom".into(), "two sides are called \"bottom\""),
            (&|a| a.regions[1].0 = "a".into(), "two regions are called \"a\""),
            (&|a| a.regions[1].1[0] = 2, "region \"b\" has the triangle 2"),
        ];
        for (change, expected) in faults {
            assert!(said(change).contains(expected), "{}", said(change));
        }
    }
}
