use super::*;
use crate::mesh::generate::cuboid;
use std::collections::BTreeSet;

/// Numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A box whose nodes inside, and inside its sides, are moved, and whose nodes are numbered in another order.
fn shaken(origin: [f64; 3], size: [f64; 3], cells: [usize; 3], by: f64, seed: u64) -> TetMesh {
    let mesh = cuboid(origin, size, cells).unwrap();
    let steps = [0, 1, 2].map(|c| size[c] / cells[c] as f64);
    let moved = |x: &Vector| {
        // The same motion at the same place, so that sides of two boxes still match.
        let bits = x
            .iter()
            .fold(seed, |sum, c| sum.wrapping_mul(31).wrapping_add(((c + 10.0) * 1e6).round() as u64));
        let mut random = Random(bits);
        for _ in 0..3 {
            random.next();
        }
        Vector::from_fn(|c, _| {
            let inside = x[c] > origin[c] + 1e-9 && x[c] < origin[c] + size[c] - 1e-9;
            x[c] + if inside { by * steps[c] * (random.next() - 0.5) } else { 0.0 }
        })
    };
    let points: Vec<Vector> = mesh.points().iter().map(moved).collect();
    let groups = mesh.groups().iter().map(|(name, faces)| {
        (name.clone(), faces.iter().map(|face| mesh.topology().facets()[*face]).collect())
    });
    TetMesh::oriented(points, mesh.cells().to_vec(), groups.collect()).unwrap()
}

/// Pairs the nodes of two sides that are a distance apart.
fn partners(meshes: &[TetMesh], bodies: [usize; 2], sides: [&str; 2], apart: Vector) -> Vec<[BodyNode; 2]> {
    let nodes = |k: usize| -> BTreeSet<NodeId> {
        let mesh = &meshes[bodies[k]];
        mesh.group(sides[k]).unwrap().iter().flat_map(|face| mesh.topology().facets()[*face]).collect()
    };
    let facing = |node: &NodeId| {
        let to = meshes[bodies[0]].points()[*node] + apart;
        let found =
            nodes(1).into_iter().find(|other| (meshes[bodies[1]].points()[*other] - to).norm() < 1e-9);
        Some([(bodies[0], *node), (bodies[1], found?)])
    };
    nodes(0).iter().filter_map(facing).collect()
}

/// Refines in rounds, and checks after each that meshes are conforming, that named sides and volumes are the same, and that paired sides match.
fn check(
    meshes: Vec<TetMesh>,
    pairs: &[([usize; 2], [&str; 2], Vector)],
    rounds: usize,
    mut marks: impl FnMut(usize, &TetMesh) -> Vec<u32>,
) -> (Vec<TetMesh>, f64) {
    let nodes: Vec<[BodyNode; 2]> =
        pairs.iter().flat_map(|(bodies, sides, apart)| partners(&meshes, *bodies, *sides, *apart)).collect();
    let mut order = EdgeOrder::new(&meshes.iter().collect::<Vec<_>>(), &nodes).unwrap();
    let volume = |mesh: &TetMesh| -> f64 { (0..mesh.cells().len()).map(|cell| mesh.measure(cell)).sum() };
    let area = |mesh: &TetMesh, name: &str| -> f64 {
        mesh.group(name).unwrap().iter().map(|face| mesh.facet_measure(*face)).sum()
    };
    let mut now = meshes.clone();
    for round in 0..rounds {
        let marked: Vec<Vec<u32>> = now.iter().enumerate().map(|(b, mesh)| marks(b, mesh)).collect();
        let all = now.iter().collect::<Vec<_>>();
        let halved = Tets::of(&all, &order).halved(&marked);
        let Tets { bodies, order: finer } = halved;
        order = finer;
        let refine = |(old, tets): (&TetMesh, BodyTets)| {
            let points = tets.points(old);
            let new = TetRefinement::new(old, tets, points).unwrap();
            for (face, parent) in new.parent_facet.iter().enumerate() {
                let outside = *parent != FacetId::NONE && old.topology().is_boundary(*parent);
                assert_eq!(new.mesh.topology().is_boundary(FacetId::new(face)), outside, "round {round}");
            }
            new.mesh
        };
        now = now.iter().zip(bodies).map(refine).collect();
        for (body, (first, mesh)) in meshes.iter().zip(&now).enumerate() {
            assert!((volume(mesh) / volume(first) - 1.0).abs() < 1e-10);
            for name in first.groups().keys() {
                assert!((area(mesh, name) / area(first, name) - 1.0).abs() < 1e-10, "{name}");
            }
            assert_eq!(order.representatives(body).len(), mesh.points().len());
        }
        for (bodies, sides, apart) in pairs {
            // Of faces between nodes that have partners.
            let faces = |k: usize| -> BTreeSet<[u32; 3]> {
                let (mesh, of) = (&now[bodies[k]], order.representatives(bodies[k]));
                let faces = mesh.group(sides[k]).unwrap().iter();
                let sorted = faces.map(|face| {
                    let mut of = mesh.topology().facets()[*face].map(|node| of[node.index()]);
                    of.sort_unstable();
                    of
                });
                sorted.collect()
            };
            let (first, second) = (faces(0), faces(1));
            assert_eq!(first, second, "round {round}");
            let joined = partners(&now, *bodies, *sides, *apart);
            let side: BTreeSet<u32> = first.iter().flatten().copied().collect();
            assert_eq!(joined.len(), side.len(), "round {round}");
        }
    }
    let least = now.iter().flat_map(|mesh| (0..mesh.cells().len()).map(|cell| quality(&mesh.corners(cell))));
    let least = least.fold(1.0, f64::min);
    (now, least)
}

/// Marks the cells near a circle.
fn near_circle(centre: Vector, radius: f64, band: f64) -> impl Fn(usize, &TetMesh) -> Vec<u32> {
    move |_, mesh| {
        let near = |cell: &u32| {
            let off = mesh.corners(*cell as usize).iter().sum::<Vector>() / 4.0 - centre;
            let across = off.xy().norm() - radius;
            let size = mesh.measure(*cell as usize).cbrt();
            across.hypot(off.z) < band.min(0.8 * size)
        };
        (0..mesh.cells().len() as u32).filter(near).collect()
    }
}

fn at_random(share: f64, seed: u64) -> impl FnMut(usize, &TetMesh) -> Vec<u32> {
    let mut random = Random(seed);
    move |_, mesh| {
        let share = share.min(60.0 / mesh.cells().len() as f64);
        (0..mesh.cells().len() as u32).filter(|_| random.next() < share).collect()
    }
}

fn two(cells: [usize; 3], size: [f64; 3], by: f64, seed: u64, apart: Vector) -> Vec<TetMesh> {
    let below = shaken([0.0, 0.0, -size[2]], size, cells, by, seed);
    let above = shaken([0.0; 3], size, cells, by, seed);
    let moved = above.points().iter().map(|x| x + apart).collect();
    let groups = above.groups().iter().map(|(name, faces)| {
        (name.clone(), faces.iter().map(|face| above.topology().facets()[*face]).collect())
    });
    vec![below, TetMesh::oriented(moved, above.cells().to_vec(), groups.collect()).unwrap()]
}

#[test]
fn cubes_cut_alike_keep_the_quality_of_maubachs_bisection() {
    for cells in [[2, 2, 2], [1, 2, 3]] {
        let size = cells.map(|n| n as f64 * 0.5);
        let mesh = cuboid([0.0; 3], size, cells).unwrap();
        let all = |_: usize, mesh: &TetMesh| (0..mesh.cells().len() as u32).collect::<Vec<_>>();
        // Three halvings of everything give the mesh of half the size.
        let (finer, least) = check(vec![mesh.clone()], &[], 3, all);
        let expected = cuboid([0.0; 3], size, cells.map(|n| 2 * n)).unwrap();
        assert_eq!(
            (finer[0].cells().len(), finer[0].points().len()),
            (expected.cells().len(), expected.points().len())
        );
        assert!((least - 0.7559).abs() < 1e-3, "{least}");
        let (_, least) =
            check(vec![mesh.clone()], &[], 9, near_circle(Vector::new(0.3, 0.4, 0.0), 0.35, 0.1));
        assert!((least - 0.7559).abs() < 1e-3, "{least}");
        let (_, least) = check(vec![mesh], &[], 9, at_random(0.2, 5));
        assert!((least - 0.7559).abs() < 1e-3, "{least}");
    }
}

#[test]
fn many_meshes_stay_conforming_and_matched_through_nine_rounds() {
    let shapes = [([1.0, 1.0, 1.0], [3, 3, 2]), ([2.0, 1.0, 0.1], [3, 2, 2]), ([1.0, 0.04, 0.5], [4, 2, 2])];
    let mut worst = [1.0f64; 3];
    for (k, (size, cells)) in shapes.into_iter().enumerate() {
        for (seed, by) in [(1, 0.0), (2, 0.2), (3, 0.4), (4, 0.55)] {
            for apart in [Vector::zeros(), Vector::new(0.0, 0.0, 0.4), Vector::new(0.21, -0.1, 0.05)] {
                let pair = [([0, 1], ["top", "bottom"], apart)];
                let circle = near_circle(Vector::new(0.4 * size[0], 0.5 * size[1], 0.0), 0.3 * size[0], 0.2);
                let (_, least) = check(two(cells, size, by, seed, apart), &pair, 9, circle);
                worst[k] = worst[k].min(least);
                // One body alone is marked.
                let mut random = at_random(0.1, seed);
                let first = |b: usize, mesh: &TetMesh| if b == 0 { random(b, mesh) } else { Vec::new() };
                let (_, least) = check(two(cells, size, by, seed, apart), &pair, 9, first);
                worst[k] = worst[k].min(least);
            }
        }
    }
    println!("{worst:?}");
    assert!(worst[0] > 0.05 && worst[1] > 1e-3 && worst[2] > 1e-3, "{worst:?}");
}

#[test]
fn three_bodies_and_a_surface_of_three_stay_matched() {
    let below = cuboid([0.0, 0.0, -1.0], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
    let [left, right] = [0.0, 1.0].map(|x| cuboid([x, 0.0, 0.0], [1.0; 3], [2, 2, 2]).unwrap());
    let mut meshes = vec![left, below, right];
    // The parts of the top under each of the upper bodies.
    let top = meshes[1].group("top").unwrap().to_vec();
    for (name, on_right) in [("under left", false), ("under right", true)] {
        let is_here = |face: &FacetId| (meshes[1].facet_middle(*face).x > 1.0) == on_right;
        let part = top.iter().copied().filter(is_here).collect();
        meshes[1].add_group(name, part);
    }
    let zero = Vector::zeros();
    let pairs = [
        ([1, 0], ["under left", "bottom"], zero),
        ([1, 2], ["under right", "bottom"], zero),
        ([0, 2], ["right", "left"], zero),
    ];
    check(meshes.clone(), &pairs, 9, near_circle(Vector::new(1.0, 0.5, 0.0), 0.4, 0.2));
    check(meshes, &pairs, 9, at_random(0.1, 3));
}

#[test]
fn joined_nodes_of_one_cell_are_refused() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
    let [a, b] = [mesh.cells()[0][0], mesh.cells()[0][1]];
    assert!(matches!(EdgeOrder::new(&[&mesh], &[[(0, a), (0, b)]]), Err(JoinedNodes { body: 0, .. })));
}
