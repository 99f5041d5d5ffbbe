//! Conditions on a body: displacements, tractions, pressures and a body force, by named sides.
//!
//! A condition names a group of facets and holds numbers or functions of the position. [`crate::body::Body`]
//! evaluates it on the mesh.

use crate::geometry::Vector;
use crate::linear_field::LinearField;
use crate::space::{Plane, Space};
use std::fmt;
use std::sync::Arc;

/// A scalar datum: one number, or a function of the position.
#[derive(Clone)]
pub enum ScalarData<S: Space = Plane> {
    /// The same value everywhere.
    Constant(f64),
    /// A function of the position.
    Function(Arc<dyn Fn(S::Vector) -> f64 + Send + Sync>),
}

impl ScalarData {
    /// Wraps a function of the position in the plane.
    pub fn function(f: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function(Arc::new(f))
    }
}

impl<S: Space> ScalarData<S> {
    /// Evaluates the datum at a point.
    pub fn at(&self, x: impl Into<S::Vector>) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Function(f) => f(x.into()),
        }
    }

    /// Returns the datum times a factor.
    #[must_use]
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        match self {
            _ if factor == 1.0 => self.clone(),
            Self::Constant(value) => Self::Constant(factor * value),
            Self::Function(f) => {
                let f = f.clone();
                Self::Function(Arc::new(move |x| factor * f(x)))
            }
        }
    }

    /// Returns the value if it is the same everywhere.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Function(_) => None,
        }
    }
}

impl<S: Space> From<f64> for ScalarData<S> {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl<S: Space> fmt::Debug for ScalarData<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Function(_) => write!(f, "f(x)"),
        }
    }
}

/// The facets a condition applies to: a named group or a part of it; or a single node.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetSelection<S: Space = Plane> {
    /// Name of the group.
    pub on: String,
    /// If given, only facets with all corners in the closed box `[[x0, x1], [y0, y1]]` (with a
    /// tolerance of 1e-9 body diagonals); infinite limits do not restrict a direction.
    pub part: Option<S::Axes<[f64; 2]>>,
    /// If given, the boundary node at this place, to 1e-6 of the body's diagonal, and no facet; see [`FacetSelection::node`].
    pub node: Option<S::Vector>,
}

impl<S: Space> Default for FacetSelection<S> {
    fn default() -> Self {
        Self { on: String::new(), part: None, node: None }
    }
}

impl<S: Space> FacetSelection<S> {
    /// Selects a single boundary node, for Cartesian components of a displacement.
    ///
    /// A point holds no elastic body: forces on it do infinite work. Such a support may remove rigid motions that no
    /// load drives. If it carries a force, no bound of the error is valid (`boundary_traction` of the checks).
    ///
    /// * `name`: of the support.
    pub fn node(name: impl Into<String>, at: impl Into<S::Vector>) -> Self {
        Self { on: name.into(), part: None, node: Some(at.into()) }
    }

    /// Selects a whole group.
    pub fn group(name: impl Into<String>) -> Self {
        Self { on: name.into(), part: None, node: None }
    }

    /// Restricts the selection to the facets within `[[x0, x1], [y0, y1]]`.
    pub fn within(mut self, part: S::Axes<[f64; 2]>) -> Self {
        self.part = Some(part);
        self
    }
}

impl<S: Space> From<&str> for FacetSelection<S> {
    fn from(name: &str) -> Self {
        Self::group(name)
    }
}

/// The components of the displacement that are imposed, with their values in the length unit.
#[derive(Clone, Debug)]
pub enum Support<S: Space = Plane> {
    /// Cartesian components; `None` leaves one free.
    Components(S::Data<Option<ScalarData<S>>>),
    /// The component along the outward normal of the side (0 is a roller); the tangential ones are free.
    Normal(ScalarData<S>),
}

/// The directions in which springs act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringDirection<S: Space = Plane> {
    /// Along the outward normal of the side.
    Normal,
    /// In all directions.
    All,
    /// Along a vector, whose length does not count.
    Vector(S::Vector),
}

/// The displacement at which springs are relaxed.
#[derive(Clone, Debug)]
pub enum SpringRest<S: Space = Plane> {
    /// The component along the direction of the springs, m; none of springs in all directions.
    Component(ScalarData<S>),
    /// A vector by Cartesian components, m.
    Vector(S::Data<ScalarData<S>>),
}

/// Springs between a part of the boundary and the ground: the traction `−k (u − u₀)` along their directions.
#[derive(Clone, Debug)]
pub struct SpringCondition<S: Space = Plane> {
    /// The facets on which they act.
    pub edges: FacetSelection<S>,
    /// `k ≥ 0`, traction per displacement, Pa/m: constant on each facet, its value in the middle.
    pub stiffness: ScalarData<S>,
    /// The directions of the springs.
    pub along: SpringDirection<S>,
    /// `u₀`, linear on each facet between its values at the corners.
    pub rest: SpringRest<S>,
}

/// The list that contains a condition, for error messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConditionList {
    /// `BoundaryConditions::displacements`.
    Displacement,
    /// `BoundaryConditions::tractions`.
    Traction,
    /// `BoundaryConditions::rigid`.
    Rigid,
    /// `BoundaryConditions::springs`.
    Spring,
    /// The curved sides of a body.
    Curve,
    /// The declared surfaces of a body.
    Surface,
    /// `BoundaryConditions::temperatures`.
    Temperature,
    /// `BoundaryConditions::force_field`.
    BodyForce,
    /// `BoundaryConditions::cuts`.
    Cut,
}

/// One condition by its list and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConditionPlace {
    /// The list.
    pub list: ConditionList,
    /// Place in the list, from 0.
    pub index: usize,
}

impl fmt::Display for ConditionPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = match self.list {
            ConditionList::Displacement => "displacement condition",
            ConditionList::Traction => "traction condition",
            ConditionList::Rigid => "rigid side condition",
            ConditionList::Spring => "spring condition",
            ConditionList::Curve => "curved side",
            ConditionList::Surface => "declared surface",
            ConditionList::Temperature => "temperature",
            ConditionList::BodyForce => "body force",
            ConditionList::Cut => "cut",
        };
        write!(f, "{list} {}", self.index + 1)
    }
}

/// A displacement imposed on a part of the boundary.
#[derive(Clone, Debug)]
pub struct DisplacementCondition<S: Space = Plane> {
    /// The facets that it holds.
    pub edges: FacetSelection<S>,
    /// The directions that are held, and the values imposed there.
    pub support: Support<S>,
}

/// A load on a part of the boundary, in the plane per unit length and thickness (Pa).
#[derive(Clone, Debug)]
pub enum Load<S: Space = Plane> {
    /// A traction vector by Cartesian components.
    Vector(S::Data<ScalarData<S>>),
    /// A pressure `q` that pushes onto the body: the traction `−q n`.
    Pressure(ScalarData<S>),
}

/// A load applied to a part of the boundary.
#[derive(Clone, Debug)]
pub struct TractionCondition<S: Space = Plane> {
    /// The facets that it loads.
    pub edges: FacetSelection<S>,
    /// The load on them.
    pub load: Load<S>,
}

/// A side that stays rigid: a loading plate, the bore of a pin on its bolt. Each component of its motion is imposed, or free
/// under its load.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidCondition<S: Space = Plane> {
    /// The facets that stay rigid.
    pub edges: FacetSelection<S>,
    /// Imposed displacements of the point `about`, m, and then rotations, radians, counter-clockwise; `None`: free.
    pub motion: S::Components<Option<f64>>,
    /// Resultant of its load, N/m in the plane, N in space; it acts along free components only.
    pub force: S::Vector,
    /// Moment of its load about the point `about`, N in the plane, N m in space.
    pub moment: S::Spin,
    /// The point about which it rotates, m; `None`: the centroid of the side.
    pub about: Option<S::Vector>,
}

impl<S: Space> Default for RigidCondition<S> {
    fn default() -> Self {
        Self {
            edges: FacetSelection::default(),
            motion: S::components(|_| None),
            force: S::Vector::default(),
            moment: S::Spin::default(),
            about: None,
        }
    }
}

/// What tightens a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutLoad {
    /// The shortening `δ`, m.
    Shortening(f64),
    /// The force, N/m in the plane, N in space; it pulls if it is positive.
    Force(f64),
}

/// A cut through a bolt, along facets of the mesh: the displacement jumps by `u^a − u^b = δ e`, with the unit normal `e` out of a.
#[derive(Clone, Debug, PartialEq)]
pub struct CutCondition<S: Space = Plane> {
    /// Its name.
    pub name: String,
    /// A point of its plane, m.
    pub point: S::Vector,
    /// The normal of its plane, out of a; its length does not count.
    pub normal: S::Vector,
    /// If given, only facets with all corners in this box.
    pub part: Option<S::Axes<[f64; 2]>>,
    /// The shortening or the force.
    pub load: CutLoad,
}

/// All conditions and loads of one body. Sides that are not named are free of traction.
///
/// ```
/// use fem_core::boundary::BoundaryConditions;
/// let conditions = BoundaryConditions::new()
///     .fix("bottom")
///     .displace("left", Some(0.0.into()), None)
///     .traction("right", [0.0.into(), 30.0.into()])
///     .pressure("top", 5.0);
/// assert_eq!(conditions.displacements.len(), 2);
/// ```
#[derive(Clone, Debug)]
pub struct BoundaryConditions<S: Space = Plane> {
    /// Imposed displacements.
    pub displacements: Vec<DisplacementCondition<S>>,
    /// Imposed tractions; several on one facet add up.
    pub tractions: Vec<TractionCondition<S>>,
    /// Sides that stay rigid.
    pub rigid: Vec<RigidCondition<S>>,
    /// Springs to the ground; several on one facet add up.
    pub springs: Vec<SpringCondition<S>>,
    /// Constant body force per unit volume, N/m³.
    pub body_force: S::Vector,
    /// A body force by functions of the position, N/m³, in addition to the constant one: exact if it is linear at the nodes of the mesh, otherwise
    /// interpolated in each cell.
    pub force_field: Option<S::Data<ScalarData<S>>>,
    /// A body force per unit mass, m/s²: of a rotation or an acceleration. It is multiplied by the density of the material.
    pub per_mass: Option<LinearField<S>>,
    /// Changes of temperature, which add up; linear in each cell between their values at the nodes.
    pub temperatures: Vec<ScalarData<S>>,
    /// Cuts through bolts that are tightened.
    pub cuts: Vec<CutCondition<S>>,
}

impl<S: Space> Default for BoundaryConditions<S> {
    fn default() -> Self {
        Self {
            displacements: Vec::new(),
            tractions: Vec::new(),
            rigid: Vec::new(),
            springs: Vec::new(),
            body_force: S::Vector::default(),
            force_field: None,
            per_mass: None,
            temperatures: Vec::new(),
            cuts: Vec::new(),
        }
    }
}

impl BoundaryConditions {
    /// Creates empty conditions of the plane.
    pub fn new() -> Self {
        Self::default()
    }

    /// Imposes the given Cartesian components on a side.
    pub fn displace(
        self,
        edges: impl Into<FacetSelection>,
        ux: Option<ScalarData>,
        uy: Option<ScalarData>,
    ) -> Self {
        self.components(edges, [ux, uy])
    }
}

impl<S: Space> BoundaryConditions<S> {
    /// Imposes zero displacement in all components on a side.
    pub fn fix(self, edges: impl Into<FacetSelection<S>>) -> Self {
        self.components(edges, S::data(|_| Some(0.0.into())))
    }

    /// Imposes the given Cartesian components on a side.
    pub fn components(
        mut self,
        edges: impl Into<FacetSelection<S>>,
        components: S::Data<Option<ScalarData<S>>>,
    ) -> Self {
        let support = Support::Components(components);
        self.displacements.push(DisplacementCondition { edges: edges.into(), support });
        self
    }

    /// Imposes the normal component on a side and leaves the tangential ones free: a roller.
    pub fn roller(mut self, edges: impl Into<FacetSelection<S>>, value: impl Into<ScalarData<S>>) -> Self {
        let support = Support::Normal(value.into());
        self.displacements.push(DisplacementCondition { edges: edges.into(), support });
        self
    }

    /// Applies a traction vector to a side.
    pub fn traction(mut self, edges: impl Into<FacetSelection<S>>, vector: S::Data<ScalarData<S>>) -> Self {
        self.tractions.push(TractionCondition { edges: edges.into(), load: Load::Vector(vector) });
        self
    }

    /// Applies a pressure that pushes onto the body.
    pub fn pressure(mut self, edges: impl Into<FacetSelection<S>>, value: impl Into<ScalarData<S>>) -> Self {
        self.tractions.push(TractionCondition { edges: edges.into(), load: Load::Pressure(value.into()) });
        self
    }

    /// Keeps a side rigid.
    pub fn rigid(mut self, condition: RigidCondition<S>) -> Self {
        self.rigid.push(condition);
        self
    }

    /// Puts springs, relaxed at zero displacement, between a side and the ground.
    pub fn spring(
        mut self,
        edges: impl Into<FacetSelection<S>>,
        stiffness: impl Into<ScalarData<S>>,
        along: SpringDirection<S>,
    ) -> Self {
        let (stiffness, rest) = (stiffness.into(), SpringRest::Vector(S::data(|_| 0.0.into())));
        self.springs.push(SpringCondition { edges: edges.into(), stiffness, along, rest });
        self
    }

    /// Returns the conditions with other amounts of what they impose.
    ///
    /// * `factor`: of each condition, in springs of `u₀`; the body forces have none.
    #[must_use]
    pub(crate) fn scaled(&self, factor: &dyn Fn(ConditionPlace) -> f64) -> Self {
        let mut scaled = self.clone();
        let of = |list, index| factor(ConditionPlace { list, index });
        for (k, condition) in scaled.displacements.iter_mut().enumerate() {
            let s = of(ConditionList::Displacement, k);
            condition.support = match &condition.support {
                Support::Components(all) => {
                    Support::Components(S::data(|c| all[c].as_ref().map(|data| data.scaled(s))))
                }
                Support::Normal(data) => Support::Normal(data.scaled(s)),
            };
        }
        for (k, condition) in scaled.tractions.iter_mut().enumerate() {
            let s = of(ConditionList::Traction, k);
            condition.load = match &condition.load {
                Load::Vector(all) => Load::Vector(S::data(|c| all[c].scaled(s))),
                Load::Pressure(data) => Load::Pressure(data.scaled(s)),
            };
        }
        for (k, data) in scaled.temperatures.iter_mut().enumerate() {
            *data = data.scaled(of(ConditionList::Temperature, k));
        }
        for (k, condition) in scaled.rigid.iter_mut().enumerate() {
            let s = of(ConditionList::Rigid, k);
            condition.motion = S::components(|k| condition.motion[k].map(|u| s * u));
            condition.force *= s;
            condition.moment = condition.moment * s;
        }
        for (k, condition) in scaled.springs.iter_mut().enumerate() {
            let s = of(ConditionList::Spring, k);
            condition.rest = match &condition.rest {
                SpringRest::Component(data) => SpringRest::Component(data.scaled(s)),
                SpringRest::Vector(all) => SpringRest::Vector(S::data(|c| all[c].scaled(s))),
            };
        }
        for (k, condition) in scaled.cuts.iter_mut().enumerate() {
            let s = of(ConditionList::Cut, k);
            condition.load = match condition.load {
                CutLoad::Shortening(value) => CutLoad::Shortening(s * value),
                CutLoad::Force(value) => CutLoad::Force(s * value),
            };
        }
        scaled
    }

    /// Cuts the body along a plane, and tightens it.
    ///
    /// * `name`: of the cut; `point`, `normal`: of its plane.
    pub fn cut(
        mut self,
        name: impl Into<String>,
        point: impl Into<S::Vector>,
        normal: impl Into<S::Vector>,
        load: CutLoad,
    ) -> Self {
        let (name, point, normal) = (name.into(), point.into(), normal.into());
        self.cuts.push(CutCondition { name, point, normal, part: None, load });
        self
    }

    /// Adds a change of temperature.
    pub fn temperature(mut self, value: impl Into<ScalarData<S>>) -> Self {
        self.temperatures.push(value.into());
        self
    }

    /// Sets the constant body force per unit volume, in the plane per unit area and thickness.
    pub fn body_force(mut self, force: impl Into<S::Vector>) -> Self {
        self.body_force = force.into();
        self
    }
}
