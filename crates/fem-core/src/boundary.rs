//! Conditions on a body: displacements, tractions, pressures and a body force, by named sides.
//!
//! A condition names an edge group and holds numbers or functions of the position. [`crate::body::Body`]
//! evaluates it on the mesh.

use crate::geometry::Vector;
use std::fmt;
use std::sync::Arc;

/// A scalar datum: one number, or a function of the position.
#[derive(Clone)]
pub enum ScalarData {
    /// The same value everywhere.
    Constant(f64),
    /// A function of the position `[x, y]`.
    Function(Arc<dyn Fn(Vector) -> f64 + Send + Sync>),
}

impl ScalarData {
    /// Wraps a function of the position.
    pub fn function(f: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function(Arc::new(f))
    }

    /// Evaluates the datum at a point.
    pub fn at(&self, x: impl Into<Vector>) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Function(f) => f(x.into()),
        }
    }

    /// Returns the datum times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
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

impl From<f64> for ScalarData {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl fmt::Debug for ScalarData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Function(_) => write!(f, "f(x, y)"),
        }
    }
}

/// The edges a condition applies to: a named group or a part of it; or a single node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FacetSelection {
    /// Name of the edge group.
    pub on: String,
    /// If given, only edges with both ends in the closed box `[[x0, x1], [y0, y1]]` (with a
    /// tolerance of 1e-9 body diagonals); infinite limits do not restrict a direction.
    pub part: Option<[[f64; 2]; 2]>,
    /// If given, the boundary node at this place, to 1e-6 of the body's diagonal, and no edge; see [`FacetSelection::node`].
    pub node: Option<Vector>,
}

impl FacetSelection {
    /// Selects a single boundary node, for Cartesian components of a displacement.
    ///
    /// In the plane a point holds no elastic body: forces on it do infinite work. Such a support may remove rigid motions that no
    /// load drives. If it carries a force, no bound of the error is valid (`boundary_traction` of the checks).
    ///
    /// * `name`: of the support.
    pub fn node(name: impl Into<String>, at: impl Into<Vector>) -> Self {
        Self { on: name.into(), part: None, node: Some(at.into()) }
    }

    /// Selects a whole group.
    pub fn group(name: impl Into<String>) -> Self {
        Self { on: name.into(), part: None, node: None }
    }

    /// Restricts the selection to the edges within `[[x0, x1], [y0, y1]]`.
    pub fn within(mut self, part: [[f64; 2]; 2]) -> Self {
        self.part = Some(part);
        self
    }
}

impl From<&str> for FacetSelection {
    fn from(name: &str) -> Self {
        Self::group(name)
    }
}

/// The components of the displacement that are imposed, with their values in the length unit.
#[derive(Clone, Debug)]
pub enum Support {
    /// Cartesian components; `None` leaves one free.
    Components([Option<ScalarData>; 2]),
    /// The component along the outward normal of the side (0 is a roller); the tangential one is free.
    Normal(ScalarData),
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
    /// The curved sides of a body.
    Curve,
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
            ConditionList::Curve => "curved side",
        };
        write!(f, "{list} {}", self.index + 1)
    }
}

/// A displacement imposed on a part of the boundary.
#[derive(Clone, Debug)]
pub struct DisplacementCondition {
    /// The edges that it holds.
    pub edges: FacetSelection,
    /// The directions that are held, and the values imposed there.
    pub support: Support,
}

/// A load on a part of the boundary, per unit length and thickness (Pa).
#[derive(Clone, Debug)]
pub enum Load {
    /// A traction vector by Cartesian components.
    Vector([ScalarData; 2]),
    /// A pressure `q` that pushes onto the body: the traction `−q n`.
    Pressure(ScalarData),
}

/// A load applied to a part of the boundary.
#[derive(Clone, Debug)]
pub struct TractionCondition {
    /// The edges that it loads.
    pub edges: FacetSelection,
    /// The load on them.
    pub load: Load,
}

/// A side that stays rigid: a loading plate, the bore of a pin on its bolt. Each component of its motion is imposed, or free
/// under its load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigidCondition {
    /// The edges that stay rigid.
    pub edges: FacetSelection,
    /// Imposed displacements in x and y of the point `about`, m; `None`: free.
    pub translation: [Option<f64>; 2],
    /// Imposed rotation, radians, counter-clockwise; `None`: free.
    pub rotation: Option<f64>,
    /// Resultant of its load, N/m; it acts along free components only.
    pub force: Vector,
    /// Moment of its load about the point `about`, N.
    pub moment: f64,
    /// The point about which it rotates, m; `None`: the centroid of the side.
    pub about: Option<Vector>,
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
#[derive(Clone, Debug, Default)]
pub struct BoundaryConditions {
    /// Imposed displacements.
    pub displacements: Vec<DisplacementCondition>,
    /// Imposed tractions; several on one edge add up.
    pub tractions: Vec<TractionCondition>,
    /// Sides that stay rigid.
    pub rigid: Vec<RigidCondition>,
    /// Constant body force per unit area and thickness, N/m³.
    pub body_force: Vector,
}

impl BoundaryConditions {
    /// Creates empty conditions.
    pub fn new() -> Self {
        Self::default()
    }

    /// Imposes zero displacement in both components on a side.
    pub fn fix(self, edges: impl Into<FacetSelection>) -> Self {
        self.displace(edges, Some(0.0.into()), Some(0.0.into()))
    }

    /// Imposes the given Cartesian components on a side.
    pub fn displace(
        mut self,
        edges: impl Into<FacetSelection>,
        ux: Option<ScalarData>,
        uy: Option<ScalarData>,
    ) -> Self {
        let support = Support::Components([ux, uy]);
        self.displacements.push(DisplacementCondition { edges: edges.into(), support });
        self
    }

    /// Imposes the normal component on a side and leaves the tangential one free: a roller.
    pub fn roller(mut self, edges: impl Into<FacetSelection>, value: impl Into<ScalarData>) -> Self {
        let support = Support::Normal(value.into());
        self.displacements.push(DisplacementCondition { edges: edges.into(), support });
        self
    }

    /// Applies a traction vector to a side.
    pub fn traction(mut self, edges: impl Into<FacetSelection>, vector: [ScalarData; 2]) -> Self {
        self.tractions.push(TractionCondition { edges: edges.into(), load: Load::Vector(vector) });
        self
    }

    /// Applies a pressure that pushes onto the body.
    pub fn pressure(mut self, edges: impl Into<FacetSelection>, value: impl Into<ScalarData>) -> Self {
        self.tractions.push(TractionCondition { edges: edges.into(), load: Load::Pressure(value.into()) });
        self
    }

    /// Keeps a side rigid.
    pub fn rigid(mut self, condition: RigidCondition) -> Self {
        self.rigid.push(condition);
        self
    }

    /// Returns the conditions with other amounts of what they impose.
    ///
    /// * `factor`: of each condition; the body force has none.
    #[must_use]
    pub fn scaled(&self, factor: &dyn Fn(ConditionPlace) -> f64) -> Self {
        let mut scaled = self.clone();
        let of = |list, index| factor(ConditionPlace { list, index });
        for (k, condition) in scaled.displacements.iter_mut().enumerate() {
            let s = of(ConditionList::Displacement, k);
            condition.support = match &condition.support {
                Support::Components(all) => {
                    Support::Components(all.each_ref().map(|data| data.as_ref().map(|data| data.scaled(s))))
                }
                Support::Normal(data) => Support::Normal(data.scaled(s)),
            };
        }
        for (k, condition) in scaled.tractions.iter_mut().enumerate() {
            let s = of(ConditionList::Traction, k);
            condition.load = match &condition.load {
                Load::Vector(all) => Load::Vector(all.each_ref().map(|data| data.scaled(s))),
                Load::Pressure(data) => Load::Pressure(data.scaled(s)),
            };
        }
        for (k, condition) in scaled.rigid.iter_mut().enumerate() {
            let s = of(ConditionList::Rigid, k);
            condition.translation = condition.translation.map(|u| u.map(|u| s * u));
            condition.rotation = condition.rotation.map(|angle| s * angle);
            condition.force *= s;
            condition.moment *= s;
        }
        scaled
    }

    /// Sets the constant body force per unit area and thickness.
    pub fn body_force(mut self, force: impl Into<Vector>) -> Self {
        self.body_force = force.into();
        self
    }
}
