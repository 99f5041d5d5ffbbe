use super::*;
use crate::geometry::Vector;
use crate::mesh::generate::block;

/// Reproducible pseudo-random numbers.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A block with its inner nodes moved by up to a fifth of a cell.
fn rough(cells: [usize; 2], random: &mut Random) -> TriMesh {
    let regular = block([0.0, 0.0], [2.0, 1.0], cells).unwrap();
    let step = [2.0 / cells[0] as f64, 1.0 / cells[1] as f64];
    let inner = |p: &Vector| p[0] > 1e-9 && p[0] < 2.0 - 1e-9 && p[1] > 1e-9 && p[1] < 1.0 - 1e-9;
    let mut moved = |p: &Vector| {
        if inner(p) { Vector::from_fn(|c, _| p[c] + 0.4 * (random.next() - 0.5) * step[c]) } else { *p }
    };
    let points = regular.points().iter().map(&mut moved).collect();
    let edges = regular.topology().facets();
    let groups = regular.groups().iter().map(|(n, g)| (n.clone(), g.iter().map(|&e| edges[e]).collect()));
    TriMesh::new(points, regular.cells().to_vec(), groups.collect()).unwrap()
}

fn area(mesh: &TriMesh) -> f64 {
    (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum()
}

fn length(mesh: &TriMesh, group: &str) -> f64 {
    mesh.group(group).unwrap().iter().map(|&e| mesh.facet_measure(e)).sum()
}

/// All relations between a mesh and its refinement.
fn check(old: &TriMesh, new: &Refinement) {
    let mesh = &new.mesh;
    // TriMesh::new has checked orientation and that no edge has three triangles. Conforming: a hanging node would be
    // a boundary node inside, and lengthen the boundary.
    let boundary =
        |m: &TriMesh| m.topology().boundary_facets().iter().map(|&e| m.facet_measure(e)).sum::<f64>();
    assert!((boundary(mesh) - boundary(old)).abs() < 1e-12 * boundary(old));
    assert!((area(mesh) - area(old)).abs() < 1e-12 * area(old));
    assert_eq!(mesh.points()[..old.points().len()], *old.points());
    for (k, [a, b]) in new.parent_nodes.iter().enumerate() {
        let ends = [a, b].map(|n| old.points()[*n]);
        assert_eq!(mesh.points()[old.points().len() + k], 0.5 * (ends[0] + ends[1]));
    }
    let mut part = vec![0.0; old.cells().len()];
    for (t, parent) in new.parent_cell.iter().enumerate() {
        part[*parent as usize] += mesh.measure(t);
    }
    for (t, part) in part.iter().enumerate() {
        // Coordinates of size 2 are rounded.
        assert!((part - old.measure(t)).abs() < 1e-15 * old.measure(t).sqrt(), "triangle {t}");
    }
    for side in ["bottom", "right", "top", "left"] {
        assert!((length(mesh, side) - length(old, side)).abs() < 1e-13);
    }
}

#[test]
fn one_to_three_marked_edges_make_two_to_four_triangles() {
    let mesh = block([0.0, 0.0], [1.0, 1.0], [1, 1]).unwrap();
    let labels = RefinementEdges::longest(&mesh);
    // Both triangles are cut in the middle of the diagonal first.
    let diagonal = mesh.topology().find_edge(0, 3).unwrap();
    assert_eq!([labels.of(&mesh, 0), labels.of(&mesh, 1)], [diagonal; 2]);
    let count = |edges: &[[u32; 2]]| {
        let mut marked = vec![false; 5];
        for [a, b] in edges {
            marked[mesh.topology().find_edge(*a, *b).unwrap()] = true;
        }
        let new = refine(&mesh, &labels, &marked).unwrap();
        check(&mesh, &new);
        new.mesh.cells().len()
    };
    assert_eq!(count(&[]), 2);
    assert_eq!(count(&[[0, 3]]), 4);
    assert_eq!(count(&[[0, 1]]), 5);
    assert_eq!(count(&[[0, 1], [1, 3]]), 6);
    assert_eq!(count(&[[0, 1], [1, 3], [0, 2], [2, 3]]), 8);
}

#[test]
fn random_refinements_keep_shapes_area_and_groups() {
    for seed in 0..6 {
        let mut random = Random(seed);
        let first = rough([5, 3], &mut random);
        let mut labels = RefinementEdges::longest(&first);
        let mut mesh = first.clone();
        for _ in 0..12 {
            // Few edges, near one point, so that the mesh is strongly graded.
            let marked: Vec<bool> = mesh
                .topology()
                .facets()
                .iter()
                .map(|e| {
                    let [x, y] = (mesh.points()[e[0]]).into();
                    random.next() < 0.005 + 0.25 * (-8.0 * ((x - 1.3).powi(2) + (y - 0.2).powi(2))).exp()
                })
                .collect();
            let new = refine(&mesh, &labels, &marked).unwrap();
            check(&mesh, &new);
            let again = refine(&mesh, &labels, &marked).unwrap();
            assert_eq!(new.mesh.cells(), again.mesh.cells());
            assert_eq!(new.refinement_edges, again.refinement_edges);
            (mesh, labels) = (new.mesh, new.refinement_edges);
        }
        assert!(mesh.cells().len() > 1000, "{}", mesh.cells().len());
        let (found, start) = (mesh.smallest_angle(), first.smallest_angle());
        assert!(found >= 0.5 * start, "seed {seed}: {found} from {start}");
    }
}

#[test]
fn right_isosceles_triangles_stay_what_they_are() {
    let mut mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
    let mut labels = RefinementEdges::longest(&mesh);
    for _ in 0..6 {
        let marked: Vec<bool> =
            mesh.topology().facets().iter().map(|e| mesh.points()[e[0]][0] < 0.2).collect();
        let new = refine(&mesh, &labels, &marked).unwrap();
        check(&mesh, &new);
        (mesh, labels) = (new.mesh, new.refinement_edges);
    }
    assert!((mesh.smallest_angle() - 45.0).abs() < 1e-9);
}

#[test]
fn linear_fields_are_carried_over_exactly() {
    let mesh = rough([4, 4], &mut Random(3));
    let linear = |p: &Vector| Vector::new(2.0 * p[0] - 0.5 * p[1] + 1.0, p[1] - 3.0 * p[0]);
    let field: Vec<Vector> = mesh.points().iter().map(linear).collect();
    let marked = vec![true; mesh.topology().facets().len()];
    let new = refine(&mesh, &RefinementEdges::longest(&mesh), &marked).unwrap();
    assert_eq!(new.mesh.cells().len(), 4 * mesh.cells().len());
    for (p, u) in new.mesh.points().iter().zip(new.prolong(&field)) {
        let exact = linear(p);
        assert!((0..2).all(|c| (u[c] - exact[c]).abs() < 1e-14), "{u:?} against {exact:?}");
    }
}

#[test]
fn an_edge_has_itself_or_its_halves_as_parts() {
    let mesh = block([0.0, 0.0], [1.0, 1.0], [1, 1]).unwrap();
    let bottom = mesh.group("bottom").unwrap()[0];
    let mut marked = vec![false; 5];
    marked[bottom] = true;
    let new = refine(&mesh, &RefinementEdges::longest(&mesh), &marked).unwrap();
    assert_eq!(new.parts(&mesh, bottom), new.mesh.group("bottom").unwrap());
    assert_eq!(new.parts(&mesh, mesh.group("top").unwrap()[0]), new.mesh.group("top").unwrap());
}
