//! Meshes that a program keeps in memory: arrays instead of a file.

use super::sides::{facets_among, keys_of};
use super::solid::faces_of;
use super::{Edge, ElementKind, Group, MeshCell, MeshFault, MeshFile, MeshFileError};
use crate::words::counted;
use fem_core::geometry::shown;
use sha2::{Digest, Sha256};

/// Largest number of points or cells in fem-core, see `TriMesh`.
const MOST: usize = (u32::MAX / 16) as usize;

/// Points or cells that are hashed at once.
const BLOCK: usize = 1 << 12;

/// Points, triangles or tetrahedra, and named parts of them. Everything is counted from 0, and so are the nodes and cells of messages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshArrays {
    /// Coordinates of the nodes, z last.
    pub points: Vec<[f64; 3]>,
    /// The corners of each triangle, in either direction.
    pub triangles: Vec<[u64; 3]>,
    /// The corners of each tetrahedron, in any order; none in the plane.
    pub tetrahedra: Vec<[u64; 4]>,
    /// Names of sides of triangles and their edges, each by its two nodes.
    pub sides: Vec<(String, Vec<[u64; 2]>)>,
    /// Names of sides of tetrahedra and their faces, each by its three nodes.
    pub faces: Vec<(String, Vec<[u64; 3]>)>,
    /// Names of regions and their tetrahedra, or their triangles if there are no tetrahedra.
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
    ///     ..MeshArrays::default()
    /// };
    /// let mesh = MeshFile::of_arrays("plate", &arrays)?.region(Some("plate"), RegionOptions::default())?.mesh()?;
    /// assert_eq!(mesh.group("base").map(<[_]>::len), Some(1));
    /// # Ok::<(), mesh_io::MeshFileError>(())
    /// ```
    ///
    /// * `name`: what messages call the mesh.
    ///
    /// # Errors
    /// Coordinates that are not finite; nodes and cells that are not there; edges or faces that no cell has; two sides, or two
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
        let faces = arrays.faces.iter().map(|(_, faces)| faces.len()).sum::<usize>() + arrays.triangles.len();
        let volumes = arrays.tetrahedra.len();
        let counts = [(arrays.points.len(), "node"), (faces, "triangle"), (volumes, "cell"), (edges, "edge")];
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
            mesh.cells.push(MeshCell::new(number, ElementKind::Triangle3, &[a, b, c]));
        }
        for (number, corners) in (0..).zip(&arrays.tetrahedra) {
            let corners = mesh.nodes(corners, || format!("tetrahedron {number}"))?;
            mesh.volumes.push(MeshCell::new(number, ElementKind::Tetra4, &corners));
        }
        for (side, faces) in &arrays.faces {
            let first = mesh.cells.len() as u32;
            for (number, corners) in (u64::from(first)..).zip(faces) {
                let [a, b, c] = mesh.nodes(corners, || format!("side \"{side}\""))?;
                mesh.cells.push(MeshCell::new(number, ElementKind::Triangle3, &[a, b, c]));
            }
            mesh.take_group(2, side, (first..mesh.cells.len() as u32).collect(), "sides")?;
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
            mesh.take_group(1, side, (first..next).collect(), "sides")?;
            first = next;
        }
        let (dimension, word, count) = match volumes {
            0 => (2, "triangle", arrays.triangles.len()),
            count => (3, "tetrahedron", count),
        };
        for (region, cells) in &arrays.regions {
            if let Some(cell) = cells.iter().find(|cell| **cell >= count as u64) {
                let found = format!("region \"{region}\" has the {word} {cell}");
                return Err(mesh.fault(MeshFault::Content, found).expected(format!("numbers below {count}")));
            }
            mesh.take_group(dimension, region, cells.iter().map(|cell| *cell as u32).collect(), "regions")?;
        }
        mesh.check_facets_of_sides(arrays.triangles.len())?;
        mesh.digest = mesh.digest_of_contents();
        Ok(mesh)
    }

    /// Takes the nodes of a cell, a face or an edge, which are used then.
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
    fn take_group(
        &mut self,
        dimension: u8,
        name: &str,
        members: Vec<u32>,
        what: &str,
    ) -> Result<(), MeshFileError> {
        if self.group_names(dimension).any(|other| other == name) {
            let found = format!("two {what} are called \"{name}\"");
            return Err(self.fault(MeshFault::Content, found).expected("names that differ"));
        }
        self.push_group(Group { dimension, name: name.to_owned(), members });
        Ok(())
    }

    /// Computes the SHA-256 of points, cells and groups, in hexadecimal.
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
        for block in self.volumes.chunks(BLOCK) {
            let corners: Vec<u8> =
                block.iter().flat_map(MeshCell::first_four).flat_map(u32::to_le_bytes).collect();
            take(&corners);
        }
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

    /// Refuses an edge or a face of a side that no cell has. A file may have some, a program that gives them has counted wrong.
    ///
    /// * `triangles`: how many of the cells are no faces of sides.
    fn check_facets_of_sides(&self, triangles: usize) -> Result<(), MeshFileError> {
        let three = |cell: &MeshCell| [cell.corners[0], cell.corners[1], cell.corners[2]];
        let edges: Vec<[u32; 2]> =
            self.cells[..triangles].iter().map(three).flat_map(|t| keys_of(&t)).collect();
        let faces: Vec<[u32; 3]> =
            self.volumes.iter().flat_map(|cell| faces_of(&cell.first_four())).collect();
        let of_sides = self.cells[triangles..].iter().map(three);
        self.check_facets(&edges, self.edges.iter().map(|edge| edge.nodes), (1, 0))?;
        self.check_facets(&faces, of_sides, (2, triangles))
    }

    /// Refuses facets of sides that no cell has.
    ///
    /// * `there`: the facets of the cells, each by its nodes in ascending order.
    /// * `dimension`, `first`: of the groups, and the number of the first facet in them.
    fn check_facets<const N: usize>(
        &self,
        there: &[[u32; N]],
        given: impl Iterator<Item = [u32; N]>,
        (dimension, first): (u8, usize),
    ) -> Result<(), MeshFileError> {
        let given: Vec<[u32; N]> = given.collect();
        let sorted = |mut nodes: [u32; N]| {
            nodes.sort_unstable();
            nodes
        };
        let found = facets_among(there, self.points.len(), given.iter().copied().map(sorted).collect());
        let stray = |nodes: &[u32; N]| found.binary_search(&sorted(*nodes)).is_err();
        let Some(number) = given.iter().position(stray) else { return Ok(()) };
        let member = (first + number) as u32;
        let owns = |group: &&Group| group.dimension == dimension && group.members.contains(&member);
        let side = self.groups.iter().find(owns).map_or("", |group| &group.name);
        let (facet, between, cell) =
            if N == 2 { ("edge", " and ", "triangle") } else { ("face", ", ", "tetrahedron") };
        let nodes = given[number].map(|node| node.to_string()).join(between);
        let found = format!("side \"{side}\" has the {facet} between nodes {nodes}, which no {cell} has");
        let expected = format!("{facet}s of the cells, each by its nodes");
        Err(self.fault(MeshFault::Content, found).expected(expected))
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
            ..MeshArrays::default()
        }
    }

    fn two_tetrahedra() -> MeshArrays {
        MeshArrays {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]],
            tetrahedra: vec![[0, 1, 2, 3], [2, 1, 0, 4]],
            faces: vec![("left".into(), vec![[2, 0, 3], [4, 0, 2]]), ("front".into(), vec![[0, 1, 3]])],
            regions: vec![("upper".into(), vec![0]), ("lower".into(), vec![1])],
            ..MeshArrays::default()
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
    fn arrays_of_tetrahedra_become_faces_and_regions() {
        let file = MeshFile::of_arrays("solid", &two_tetrahedra()).unwrap();
        let whole = file.solid_regions(&["upper", "lower"], Default::default()).unwrap();
        assert_eq!((whole.cells().len(), whole.node_numbers()), (2, &[0, 1, 2, 3, 4][..]));
        let mesh = whole.mesh().unwrap();
        assert_eq!(["left", "front"].map(|name| mesh.group(name).unwrap().len()), [2, 1]);
        let lower = file.solid_regions(&["lower"], Default::default()).unwrap();
        assert_eq!(lower.node_numbers(), [0, 1, 2, 4]);
        assert!(file.region(None, Default::default()).unwrap_err().to_string().contains("a plane mesh"));
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
        let solids = [
            two_tetrahedra(),
            MeshArrays { tetrahedra: vec![[2, 1, 0, 4], [0, 1, 2, 3]], ..two_tetrahedra() },
        ];
        let [first, second] =
            solids.map(|arrays| MeshFile::of_arrays("solid", &arrays).unwrap().digest().to_owned());
        assert_ne!(first, second);
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
        let said = |change: Change<'_>| {
            let mut arrays = two_tetrahedra();
            change(&mut arrays);
            MeshFile::of_arrays("solid", &arrays).unwrap_err().to_string()
        };
        let faults: [(Change<'_>, &str); 5] = [
            (&|a| a.tetrahedra[1][0] = 9, "tetrahedron 1 has the node 9; expected numbers below 5"),
            (&|a| a.tetrahedra[1][0] = 1, "tetrahedron 1 has the node 1 twice"),
            (
                &|a| a.faces[0].1[1] = [0, 3, 4],
                "side \"left\" has the face between nodes 0, 3, 4, which no tetrahedron has",
            ),
            (&|a| a.faces[1].0 = "left".into(), "two sides are called \"left\""),
            (&|a| a.regions[1].1[0] = 2, "region \"lower\" has the tetrahedron 2; expected numbers below 2"),
        ];
        for (change, expected) in faults {
            assert!(said(change).contains(expected), "{}", said(change));
        }
    }
}
