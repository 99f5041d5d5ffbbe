use super::*;
use crate::body::{DeclaredSurface, SurfaceKind};
use crate::boundary::BoundaryConditions;
use crate::material::LinearElastic;
use crate::mesh::TetMesh;
use crate::mesh::bisect::{TetRefinement, Tets, quality};
use crate::mesh::generate::{cuboid, tube};

fn body(mesh: TetMesh, on: &str, kind: SurfaceKind) -> Body<Solid> {
    let material = LinearElastic::isotropic_solid(1.0, 0.3).unwrap();
    let body = Body::new(mesh, material, &BoundaryConditions::default()).unwrap();
    body.with_surfaces(&[DeclaredSurface { on: on.into(), kind }]).unwrap()
}

/// A box of cells `n × n × n` as a ball.
fn ball(n: usize) -> Body<Solid> {
    let mesh = cuboid([-1.0; 3], [2.0; 3], [n; 3]).unwrap();
    let round = |x: &Vector| if x.norm() > 0.0 { x * (x.amax() / x.norm()) } else { *x };
    let boundary = mesh.topology().boundary_facets().iter().map(|face| mesh.topology().facets()[*face]);
    let groups = vec![("round".to_owned(), boundary.collect())];
    let points = mesh.points().iter().map(round).collect();
    body(TetMesh::oriented(points, mesh.cells().to_vec(), groups).unwrap(), "round", SurfaceKind::Sphere)
}

/// Refines in rounds; returns the body, its worst quality, and of the new nodes on the surface how many there are, and are not there.
fn refined(
    mut body: Body<Solid>,
    rounds: usize,
    marks: impl Fn(&TetMesh) -> Vec<u32>,
) -> (Body<Solid>, f64, [usize; 2]) {
    let mut order = EdgeOrder::new(&[body.mesh()], &[]).unwrap();
    let mut held = [0; 2];
    for _ in 0..rounds {
        let halved = Tets::of(&[body.mesh()], &order).halved(&[marks(body.mesh())]);
        order = halved.order;
        let tets = &halved.bodies[0];
        let mut moving = [FinerBody::new(&body, tets, body.surfaces())];
        move_onto_surfaces(&mut moving, &order);
        let [moved] = moving;
        let new = |node: &&NodeId| !order.is_first((0, **node));
        held = [moved.on.keys().filter(new).count(), moved.off().iter().filter(new).count()];
        let points = moved.points;
        // None is turned over: the mesh refuses that.
        let finer = TetRefinement::new(body.mesh(), tets.clone(), points).unwrap();
        body = body.refined(&finer).unwrap();
    }
    let mesh = body.mesh();
    let least = (0..mesh.cells().len()).map(|cell| quality(&mesh.corners(cell))).fold(1.0, f64::min);
    (body, least, held)
}

/// Marks the cells at a circle on the unit sphere.
fn at_circle(mesh: &TetMesh) -> Vec<u32> {
    let near = |cell: &u32| {
        let middle = mesh.corners(*cell as usize).iter().sum::<Vector>() / 4.0;
        let size = mesh.measure(*cell as usize).cbrt();
        (middle.xy().norm() - 0.8).hypot(middle.z - 0.6) < size
    };
    (0..mesh.cells().len() as u32).filter(near).collect()
}

#[test]
fn new_nodes_of_coarse_balls_arrive_on_the_sphere() {
    for n in [2, 3] {
        let (_, least, [nodes, off]) = refined(ball(n), 9, at_circle);
        println!("{n}: {nodes} nodes, {off} off, quality {least}");
        assert!(nodes > 100 && 100 * off <= nodes, "{off} of {nodes}");
        assert!(least > 0.02, "{least}");
        let all = |mesh: &TetMesh| (0..mesh.cells().len() as u32).collect();
        let (whole, least, [nodes, off]) = refined(ball(n), 6, all);
        println!("{n}: {nodes} nodes, {off} off, quality {least}");
        assert!(nodes > 100 && 100 * off <= nodes, "{off} of {nodes}");
        let volume: f64 = (0..whole.mesh().cells().len()).map(|cell| whole.mesh().measure(cell)).sum();
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        assert!(volume < exact && volume > 0.97 * exact, "{volume}");
    }
}

#[test]
fn nodes_on_the_edge_of_a_cylinder_stay_in_its_ends() {
    let mesh = tube([0.0; 3], [0.5, 1.0], 0.7, [0.0, 90.0], [3, 2, 2]).unwrap();
    let all = |mesh: &TetMesh| (0..mesh.cells().len() as u32).collect();
    let (body, _, [nodes, off]) = refined(body(mesh, "outer", SurfaceKind::Cylinder), 6, all);
    assert!(nodes > 100 && off == 0, "{off} of {nodes}");
    let mesh = body.mesh();
    for (name, [axis, place]) in
        [("bottom", [2.0, 0.0]), ("top", [2.0, 0.7]), ("start", [1.0, 0.0]), ("end", [0.0, 0.0])]
    {
        for node in mesh.group(name).unwrap().iter().flat_map(|face| mesh.topology().facets()[*face]) {
            let off = mesh.points()[node][axis as usize] - place;
            assert!(off.abs() < 1e-12, "{name}: {off:e}");
        }
    }
}
