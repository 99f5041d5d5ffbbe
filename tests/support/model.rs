//! Parts that the files of the reference problems share: the names they need of fem-core, and the few steps in
//! which their problems are made.

pub(crate) use fem_core::body::Body;
pub(crate) use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
pub(crate) use fem_core::geometry::Vector;
pub(crate) use fem_core::interface::{ContactInterface, ContactProblem, Gap, Obstacle, RigidLine};
pub(crate) use fem_core::material::{Hypothesis, LinearElastic};
pub(crate) use fem_core::mesh::TriMesh;
pub(crate) use fem_core::mesh::generate::{block, ring};
pub(crate) use fem_core::mesh::id::NodeId;
pub(crate) use fem_core::tensor::SymTensor2;
use std::error::Error;

/// The result of a step that builds a part of a problem.
pub type Made<T> = Result<T, Box<dyn Error>>;

/// Makes an isotropic material in plane strain.
pub(crate) fn isotropic(young: f64, poisson: f64) -> Made<LinearElastic> {
    Ok(LinearElastic::isotropic(young, poisson, Hypothesis::PlaneStrain)?)
}

/// Returns the components of a vector field as data of a condition.
pub(crate) fn components(
    field: impl Fn(Vector) -> Vector + Clone + Send + Sync + 'static,
) -> [ScalarData; 2] {
    [0, 1].map(|c| {
        let field = field.clone();
        ScalarData::function(move |x| field(x)[c])
    })
}

/// Returns the sides of a mesh, each with the edges by their two nodes.
pub(crate) fn sides(mesh: &TriMesh) -> Vec<(String, Vec<[NodeId; 2]>)> {
    let edges = mesh.topology().facets();
    let side = |(name, ids): (&String, &Vec<_>)| (name.clone(), ids.iter().map(|id| edges[*id]).collect());
    mesh.groups().iter().map(side).collect()
}

/// Makes the problem of two bodies, the first above the second, of which these sides may touch.
pub(crate) fn pair(bodies: [Body; 2], surfaces: [&str; 2], gap: &Gap) -> Made<ContactProblem> {
    let interface = contact_geometry::pair(&bodies[0], &bodies[1], surfaces, gap)?;
    Ok(ContactProblem::between(bodies, interface))
}

/// [`pair`] of bodies that touch, along the `bottom` of the first and the `top` of the second.
pub(crate) fn stacked(bodies: [Body; 2]) -> Made<ContactProblem> {
    pair(bodies, ["bottom", "top"], &Gap::Given(0.0.into()))
}

/// Makes a body that is cut out of an exact solution: its displacement is imposed on the side `far`, its traction on
/// `left` and `right`.
pub(crate) fn cut_out(
    mesh: TriMesh,
    material: LinearElastic,
    far: &str,
    displacement: impl Fn(Vector) -> Vector + Clone + Send + Sync + 'static,
    stress: impl Fn(Vector) -> SymTensor2 + Clone + Send + Sync + 'static,
) -> Made<Body> {
    let [x, y] = components(displacement).map(Some);
    let [left, right] = [-1.0, 1.0].map(|n| {
        let stress = stress.clone();
        components(move |x| stress(x).apply(Vector::new(n, 0.0)))
    });
    let conditions =
        BoundaryConditions::new().displace(far, x, y).traction("left", left).traction("right", right);
    Ok(Body::new(mesh, material, &conditions)?)
}
