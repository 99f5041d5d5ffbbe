//! Volumes of every shape, alone and in random meshes, split into tetrahedra.

use super::*;
use crate::mesh_file::solid::faces_of;
use crate::{Region, RegionOptions, parse};
use fem_core::space::{Solid, Space};
use std::fmt::Write as _;

/// Corners of the unit cube, in the order of hexahedra.
const CUBE: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Kinds with Gmsh's numbers, corners among those of the cube, and volumes.
const KINDS: [(ElementKind, u32, &[usize], f64); 11] = [
    (ElementKind::Tetra4, 4, &[0, 1, 2, 6], 1.0 / 6.0),
    (ElementKind::Tetra10, 11, &[0, 1, 2, 6], 1.0 / 6.0),
    (ElementKind::Pyramid5, 7, &[0, 1, 2, 3, 6], 1.0 / 3.0),
    (ElementKind::Pyramid13, 19, &[0, 1, 2, 3, 6], 1.0 / 3.0),
    (ElementKind::Pyramid14, 14, &[0, 1, 2, 3, 6], 1.0 / 3.0),
    (ElementKind::Prism6, 6, &[0, 1, 2, 4, 5, 6], 0.5),
    (ElementKind::Prism15, 18, &[0, 1, 2, 4, 5, 6], 0.5),
    (ElementKind::Prism18, 13, &[0, 1, 2, 4, 5, 6], 0.5),
    (ElementKind::Hexa8, 5, &[0, 1, 2, 3, 4, 5, 6, 7], 1.0),
    (ElementKind::Hexa20, 17, &[0, 1, 2, 3, 4, 5, 6, 7], 1.0),
    (ElementKind::Hexa27, 12, &[0, 1, 2, 3, 4, 5, 6, 7], 1.0),
];

/// Small random numbers, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % limit as u64) as usize
    }

    fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut numbers: Vec<usize> = (1..=count).collect();
        for k in (1..count).rev() {
            numbers.swap(k, self.below(k + 1));
        }
        numbers
    }
}

/// Cells by Gmsh's number of their type and their nodes, from 0; the first of the physical groups is the volume.
struct Sample {
    points: Vec<[f64; 3]>,
    cells: Vec<(u32, Vec<usize>)>,
    /// A surface by its faces.
    surface: Vec<Vec<usize>>,
}

impl Sample {
    /// Writes MSH 2.2; node `k` gets the number `numbers[k]`.
    fn msh2(&self, numbers: &[usize]) -> String {
        let mut text = String::from(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"block\"\n2 2 \"skin\"\n",
        );
        let _ = writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", self.points.len());
        for (point, number) in self.points.iter().zip(numbers) {
            let _ = writeln!(text, "{number} {} {} {}", point[0], point[1], point[2]);
        }
        let faces = self.surface.iter().map(|face| (face.len() as u32 - 1, 2, face));
        let all = self.cells.iter().map(|(code, nodes)| (*code, 1, nodes)).chain(faces);
        let _ = writeln!(text, "$EndNodes\n$Elements\n{}", all.clone().count());
        for (k, (code, group, nodes)) in all.enumerate() {
            let nodes: Vec<String> = nodes.iter().map(|n| numbers[*n].to_string()).collect();
            let _ = writeln!(text, "{} {code} 2 {group} 1 {}", k + 1, nodes.join(" "));
        }
        text + "$EndElements\n"
    }

    /// Writes MSH 4.1, a block for each cell.
    fn msh4(&self) -> String {
        let count = self.points.len();
        let mut text = format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"block\"\n$EndPhysicalNames\n$Entities\n0 0 0 1\n\
             1 0 0 0 1 1 1 1 1 0\n$EndEntities\n$Nodes\n1 {count} 1 {count}\n3 1 0 {count}\n"
        );
        (1..=count).for_each(|k| text += &format!("{k}\n"));
        self.points.iter().for_each(|p| text += &format!("{} {} {}\n", p[0], p[1], p[2]));
        let cells = self.cells.len();
        let _ = writeln!(text, "$EndNodes\n$Elements\n{cells} {cells} 1 {cells}");
        for (k, (code, nodes)) in self.cells.iter().enumerate() {
            let nodes: Vec<String> = nodes.iter().map(|n| (n + 1).to_string()).collect();
            let _ = writeln!(text, "3 1 {code} 1\n{} {}", k + 1, nodes.join(" "));
        }
        text + "$EndElements\n"
    }

    fn region(&self, numbers: &[usize]) -> Region<Solid> {
        let file = parse(self.msh2(numbers).as_bytes(), "sample.msh").unwrap();
        file.solid_regions(&["block"], RegionOptions::default()).unwrap()
    }
}

fn volume(region: &Region<Solid>) -> f64 {
    let of_cell = |cell: &[u32; 4]| Solid::measure(&cell.map(|n| region.points()[n as usize])).abs();
    region.cells().iter().map(of_cell).sum()
}

/// One cell; nodes besides the corners lie inside.
fn single((kind, code, corners, _): (ElementKind, u32, &[usize], f64)) -> Sample {
    let inside = corners.len()..kind.nodes();
    let points =
        corners.iter().map(|k| CUBE[*k]).chain(inside.map(|k| [0.5, 0.5, 0.01 * k as f64])).collect();
    Sample { points, cells: vec![(code, (0..kind.nodes()).collect())], surface: Vec::new() }
}

#[test]
fn every_shape_of_gmsh_is_split_and_keeps_its_volume() {
    for kind in KINDS {
        let sample = single(kind);
        let natural: Vec<usize> = (1..=sample.points.len()).collect();
        for text in [sample.msh2(&natural), sample.msh4()] {
            let file = parse(text.as_bytes(), "one.msh").unwrap();
            let region = file.solid_regions(&["block"], RegionOptions::default()).unwrap();
            assert!((volume(&region) - kind.3).abs() < 1e-14, "{:?}", kind.0);
            let corners = kind.2.len();
            assert_eq!(
                (region.points().len(), region.cells().len()),
                (corners, [1, 2, 3, 0, 6][corners - 4])
            );
            let said = |words: &str| region.notes().iter().filter(|note| note.contains(words)).count();
            assert_eq!(said("reduced to the corners"), usize::from(kind.0.is_quadratic()));
            assert_eq!(said("cut through its node of smallest number"), usize::from(corners > 4));
            assert_eq!(
                file.summary().groups[0].measure.map(|m| (m * 1e12).round()),
                Some((kind.3 * 1e12).round())
            );
        }
    }
}

#[test]
fn every_order_of_numbers_gives_faces_that_point_inwards() {
    let mut random = Random(3);
    for (kind, _, corners, expected) in KINDS {
        for _ in 0..100 {
            let numbers = random.shuffled(8);
            let given: Vec<u32> = corners.iter().map(|k| *k as u32).collect();
            let cell = MeshCell::new(1, kind, &given);
            let tetrahedra = cell.tetrahedra(&|n| numbers[n as usize] as u32);
            let place = |number: u32| {
                let node = numbers.iter().position(|n| *n as u32 == number).unwrap();
                CUBE[node].into()
            };
            let volumes: Vec<f64> = tetrahedra.iter().map(|t| Solid::measure(&t.map(place))).collect();
            assert!(volumes.iter().all(|v| *v > 0.1), "{kind:?} {numbers:?}: {volumes:?}");
            assert!((volumes.iter().sum::<f64>() - expected).abs() < 1e-14, "{kind:?} {numbers:?}");
        }
    }
}

/// A box of cells, each a hexahedron, two prisms, or six pyramids around its centre; inner nodes are moved.
fn mixed(cells: [usize; 3], random: &mut Random) -> Sample {
    let [nx, ny, nz] = cells;
    let node = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
    let mut sample = Sample { points: Vec::new(), cells: Vec::new(), surface: Vec::new() };
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let inner = (1..nx).contains(&i) && (1..ny).contains(&j) && (1..nz).contains(&k);
                let mut moved =
                    |x: usize| x as f64 + if inner { 0.002 * random.below(100) as f64 } else { 0.0 };
                sample.points.push([moved(i), moved(j), moved(k)]);
            }
        }
    }
    // A face between cells that are cut into prisms has the same diagonal from both sides.
    let column: Vec<usize> = (0..nx * ny).map(|_| random.below(2)).collect();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let c: Vec<usize> = CUBE
                    .iter()
                    .map(|p| node(i + p[0] as usize, j + p[1] as usize, k + p[2] as usize))
                    .collect();
                let of = |places: &[usize]| places.iter().map(|p| c[*p]).collect::<Vec<usize>>();
                for (face, out) in
                    HEXAHEDRON.iter().zip([k == 0, k + 1 == nz, j == 0, i + 1 == nx, j + 1 == ny, i == 0])
                {
                    if out && column[j * nx + i] == 1 {
                        sample.surface.push(of(face));
                    }
                }
                if column[j * nx + i] == 0 {
                    sample.cells.push((6, of(&[0, 1, 2, 4, 5, 6])));
                    sample.cells.push((6, of(&[0, 2, 3, 4, 6, 7])));
                } else if random.below(2) == 0 {
                    sample.cells.push((5, c));
                } else {
                    let centre = c
                        .iter()
                        .map(|n| sample.points[*n])
                        .fold([0.0; 3], |sum, p| [0, 1, 2].map(|a| sum[a] + p[a] / 8.0));
                    sample.points.push(centre);
                    let apex = sample.points.len() - 1;
                    sample.cells.extend(HEXAHEDRON.iter().map(|face| (7, [of(face), vec![apex]].concat())));
                }
            }
        }
    }
    sample
}

#[test]
fn random_meshes_of_all_shapes_conform_and_keep_their_volume() {
    let mut random = Random(7);
    for round in 0..40 {
        // Triangles of prisms meet quadrilaterals along z if there are several layers of mixed cells: one kind a column keeps them apart.
        let cells = [1 + random.below(4), 1 + random.below(4), 1 + random.below(4)];
        let sample = mixed(cells, &mut random);
        let region = sample.region(&random.shuffled(sample.points.len()));
        let mut faces: Vec<[u32; 3]> = region.cells().iter().flat_map(faces_of).collect();
        faces.sort_unstable();
        let counts: Vec<usize> = faces.chunk_by(|a, b| a == b).map(<[_]>::len).collect();
        let [x, y, z] = cells;
        let outside = 4 * (x * y + y * z + z * x);
        assert!(counts.iter().all(|count| *count <= 2), "{round}");
        assert_eq!(counts.iter().filter(|count| **count == 1).count(), outside, "{round}");
        let exact = (x * y * z) as f64;
        assert!((volume(&region) - exact).abs() <= 1e-12 * exact, "{round}: {}", volume(&region));
        assert_eq!(region.warnings(), [], "{round}");
        let mesh = region.mesh().unwrap();
        // Quadrilaterals of the surface are cut as the cells are.
        let skin = mesh.group("skin").map_or(0, <[_]>::len);
        assert_eq!(skin, 2 * sample.surface.len(), "{round}");
    }
}

#[test]
fn joined_cells_are_cut_by_the_numbers_of_the_nodes_that_are_kept() {
    let mut random = Random(11);
    for _ in 0..20 {
        let whole = mixed([2, 2, 2], &mut random);
        let mut parted = Sample { points: Vec::new(), cells: Vec::new(), surface: Vec::new() };
        for (code, nodes) in &whole.cells {
            let first = parted.points.len();
            parted.points.extend(nodes.iter().map(|n| whole.points[*n]));
            parted.cells.push((*code, (first..parted.points.len()).collect()));
        }
        let text = parted.msh2(&random.shuffled(parted.points.len()));
        let file = parse(text.as_bytes(), "parted.msh").unwrap();
        let region = file.solid_regions(&[], RegionOptions::with_merge(true)).unwrap();
        assert_eq!(region.points().len(), whole.points.len());
        let mesh = region.mesh().unwrap();
        assert_eq!(mesh.topology().boundary_facets().len(), 48);
    }
}

#[test]
fn collapsed_and_mirrored_cells_are_read_and_twisted_ones_refused() {
    let read = |nodes: [usize; 8]| {
        let sample = Sample { points: CUBE.to_vec(), cells: vec![(5, nodes.to_vec())], surface: Vec::new() };
        let file = parse(sample.msh2(&[8, 7, 6, 5, 1, 2, 3, 4]).as_bytes(), "one.msh").unwrap();
        file.solid_regions(&["block"], RegionOptions::default())
    };
    let prism = read([0, 1, 2, 2, 4, 5, 6, 6]).unwrap();
    assert_eq!((prism.cells().len(), volume(&prism)), (3, 0.5));
    assert!((volume(&read([4, 5, 6, 7, 0, 1, 2, 3]).unwrap()) - 1.0).abs() < 1e-14);
    let twisted = read([0, 1, 2, 3, 4, 5, 7, 6]).unwrap_err().to_string();
    let place =
        "element 1 (8-node hexahedron, nodes 8, 7, 6, 5, 1, 2, 4, 3 at (0, 0, 0), (1, 0, 0), (1, 1, 0)";
    assert!(
        twisted.contains(place) && twisted.contains("is flat, turned over in part or twisted"),
        "{twisted}"
    );
    assert!(read([0, 1, 2, 3, 0, 1, 2, 3]).is_err());
}
