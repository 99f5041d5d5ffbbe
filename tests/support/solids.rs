//! Problems of solid bodies whose solutions another code has printed.

use case_io::case::AnyCase;
use contact_geometry::{Contact, ContactNormal, Sides};
use fem_core::body::{Body, DeclaredSurface, SurfaceKind};
use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
use fem_core::interface::{ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::space::Solid;
use fem_core::tensor::SymTensor3;
use nalgebra::{Complex, Vector3};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

type Conditions = BoundaryConditions<Solid>;

const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Builds a case of `cases/solid` with `n` cells per unit of length, `across` of them along x.
///
/// # Errors
/// None, for the cases of this folder.
pub fn of_case(name: &str, n: usize, across: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    of_case_with(name, n, across, &[])
}

/// [`of_case`] with other values of some keys.
///
/// # Errors
/// As [`of_case`].
pub fn of_case_with(
    name: &str,
    n: usize,
    across: usize,
    others: &[(&str, &str)],
) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/solid").join(name);
    let bytes = std::fs::read(path)?;
    let solid = |overrides: &[(String, String)]| match AnyCase::parse_bytes(&bytes, name, overrides)? {
        AnyCase::Solid(case) => Ok::<_, Box<dyn Error>>(case),
        AnyCase::Plane(_) => Err(format!("{name} is a case of the plane").into()),
    };
    let cells = |body| (format!("body.{body}.generator.cells"), format!("[{across}, {n}, {n}]"));
    let mut overrides: Vec<_> = (0..solid(&[])?.bodies.len()).map(cells).collect();
    overrides.extend(others.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())));
    let (problem, notes) = solid(&overrides)?.build()?;
    assert_eq!(notes, Vec::<String>::new());
    Ok(problem)
}

/// Two blocks of which the upper one is pressed down on its left half and pulled up on its right half, with `n` cells per unit of length.
pub fn half_open(n: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let material = LinearElastic::isotropic_solid(1000.0, 0.3)?;
    let body = |z: f64, conditions: Conditions| -> Result<Body<Solid>, Box<dyn Error>> {
        let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [2 * n, n, n])?;
        Ok(Body::new(mesh, material.clone(), &conditions.roller("front", 0.0))?)
    };
    let half = |x: [f64; 2]| FacetSelection::from("top").within([x, ALL, ALL]);
    let pressed = Conditions::default()
        .roller("left", 0.0)
        .components(half([0.0, 1.0]), [None, None, Some((-0.02).into())])
        .traction(half([1.0, 2.0]), [0.0.into(), 0.0.into(), 5.0.into()]);
    let (upper, lower) = (body(1.0, pressed)?, body(0.0, Conditions::default().fix("bottom"))?);
    let interface = contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// Radius of the contact zone of [`Hertz`], m.
const RADIUS: f64 = 0.6;
/// Its largest pressure, Pa.
const PEAK: f64 = 0.1;

/// Hertz' field under a circle in the half-space `z > 0`, with a bending that leaves the circle flat.
#[derive(Clone, Copy, Debug)]
pub struct Hertz {
    /// E, Pa.
    pub modulus: f64,
    /// ν.
    pub nu: f64,
}

/// The derivatives of the potential `φ` at a point: along the plane they are the coordinate times a factor.
struct Potential {
    z: f64,
    zz: f64,
    zzz: f64,
    /// `φ_,α / x_α` and `φ_,zα / x_α`.
    across: f64,
    z_across: f64,
}

impl Hertz {
    fn potential(x: Vector3<f64>) -> Potential {
        let (a, z, squared) = (RADIUS, x[2], x[0] * x[0] + x[1] * x[1]);
        let w = Complex::new(z, a);
        let root = (w * w + squared).sqrt();
        let log = (root + w).ln();
        let kappa = PEAK / (4.0 * a);
        let front = a * a + z * z - 0.5 * squared;
        let ia = Complex::new(0.0, a);
        let zz = -4.0 * kappa * (root - log * z).im;
        let zzz = -4.0 * kappa * (ia / root - log).im;
        let inner = w * (a * a) + (w - z).powu(3) / 3.0 - root * (a * a + z * z)
            + (w * root - log * squared) * z
            - root.powu(3) / 3.0
            + root * squared;
        Potential {
            z: 2.0 * kappa * (log * front - root * (2.0 * z) + w * root * 0.5).im,
            zz,
            zzz,
            across: if squared > 0.0 { 2.0 * kappa / squared * inner.im } else { -0.5 * zz },
            z_across: 2.0
                * kappa
                * (Complex::from(front) / (root * (root + w)) - log - Complex::from(2.0 * z) / root
                    + w / (root * 2.0))
                    .im,
        }
    }

    fn bending(&self) -> f64 {
        -(1.0 + self.nu) * std::f64::consts::PI * PEAK / (2.0 * RADIUS)
    }

    /// Computes the displacement at a point, m.
    pub fn displacement(&self, x: Vector3<f64>) -> Vector3<f64> {
        let (nu, e, k, p) = (self.nu, self.modulus, self.bending(), Self::potential(x));
        let twice = e / (1.0 + nu);
        let across = (-(1.0 - 2.0 * nu) * p.across - x[2] * p.z_across) / twice + (1.0 - nu) * k * x[2] / e;
        let squared = x[0] * x[0] + x[1] * x[1];
        let constant = 2.0 * (1.0 - nu) / twice * std::f64::consts::PI * PEAK * RADIUS / 4.0;
        let up = (2.0 * (1.0 - nu) * p.z - x[2] * p.zz) / twice
            - (1.0 - nu) * k * squared / (2.0 * e)
            - nu * k * x[2] * x[2] / e
            - constant;
        Vector3::new(x[0] * across, x[1] * across, up)
    }

    /// Computes the stress at a point off the axis, Pa.
    pub fn stress(&self, x: Vector3<f64>) -> SymTensor3 {
        let (nu, p) = (self.nu, Self::potential(x));
        let squared = x[0] * x[0] + x[1] * x[1];
        // The Laplacians of φ and φ_,z vanish.
        let second = |i: usize, j: usize, factor: f64, along: f64| {
            let diagonal = if i == j { factor } else { 0.0 };
            diagonal + x[i] * x[j] * (-along - 2.0 * factor) / squared
        };
        let stress = |i: usize, j: usize| {
            let common = if i == j { 2.0 * nu * p.zz + self.bending() * x[2] } else { 0.0 };
            common - (1.0 - 2.0 * nu) * second(i, j, p.across, p.zz) - x[2] * second(i, j, p.z_across, p.zzz)
        };
        let shear = |i: usize| -x[2] * x[i] * Self::zz_across(x);
        SymTensor3 {
            xx: stress(0, 0),
            yy: stress(1, 1),
            zz: p.zz - x[2] * p.zzz,
            yz: shear(1),
            xz: shear(0),
            xy: stress(0, 1),
        }
    }

    /// Computes the traction on the side `x = 1`, or on `y = 1`, Pa.
    pub fn traction(&self, side: usize, x: Vector3<f64>) -> Vector3<f64> {
        let s = self.stress(x);
        if side == 0 { Vector3::new(s.xx, s.xy, s.xz) } else { Vector3::new(s.xy, s.yy, s.yz) }
    }

    /// `φ_,zzα / x_α`.
    fn zz_across(x: Vector3<f64>) -> f64 {
        let w = Complex::new(x[2], RADIUS);
        let root = (w * w + x[0] * x[0] + x[1] * x[1]).sqrt();
        let numerator = root + Complex::new(0.0, RADIUS);
        -PEAK / RADIUS * (numerator / (root * (root + w))).im
    }
}

/// [`circle_of`] two equal materials.
pub fn circle(n: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    circle_of(n, [Hertz { modulus: 1.0, nu: 0.3 }; 2])
}

/// A quarter of two blocks with a field of [`Hertz`] in the upper one and the image of another in the lower one.
pub fn circle_of(n: usize, fields: [Hertz; 2]) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let body = |field: Hertz, sign: f64, far: &str| -> Result<Body<Solid>, Box<dyn Error>> {
        let image = move |x: Vector3<f64>| Vector3::new(x[0], x[1], sign * x[2]);
        let component = |value: fn(&Hertz, usize, Vector3<f64>) -> Vector3<f64>, side: usize| {
            [0, 1, 2].map(|c: usize| {
                ScalarData::<Solid>::Function(Arc::new(move |x| image(value(&field, side, image(x)))[c]))
            })
        };
        let conditions = Conditions::default()
            .roller("left", 0.0)
            .roller("front", 0.0)
            .components(far, component(|field, _, x| field.displacement(x), 0).map(Some))
            .traction("right", component(Hertz::traction, 0))
            .traction("back", component(Hertz::traction, 1));
        let mesh = cuboid([0.0, 0.0, 0.5 * (sign - 1.0)], [1.0; 3], [n; 3])?;
        Ok(Body::new(mesh, LinearElastic::isotropic_solid(field.modulus, field.nu)?, &conditions)?)
    };
    let (upper, lower) = (body(fields[0], 1.0, "top")?, body(fields[1], -1.0, "bottom")?);
    let interface = contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// The exact displacement of [`cube`] is the gradient of `φ = e^{ax} cos(y/2 + 0.3) cos(1.2z + 0.2)`, `a² = 0.25 + 1.44`: this is its
/// derivative along the given axes.
pub fn derivative(x: Vector3<f64>, axes: &[usize]) -> f64 {
    let order = |axis: usize| axes.iter().filter(|k| **k == axis).count() as i32;
    let wave = |argument: f64, factor: f64, order: i32| {
        factor.powi(order) * (argument + f64::from(order) * std::f64::consts::FRAC_PI_2).cos()
    };
    let a = 1.69f64.sqrt();
    a.powi(order(0))
        * (a * x[0]).exp()
        * wave(0.5 * x[1] + 0.3, 0.5, order(1))
        * wave(1.2 * x[2] + 0.2, 1.2, order(2))
}

/// The unit cube with the displacement of [`derivative`], imposed at the bottom, and its tractions on the other sides.
pub fn cube(n: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let function =
        |f: Box<dyn Fn(Vector3<f64>) -> f64 + Send + Sync>| ScalarData::<Solid>::Function(f.into());
    let twice_mu = 1.0 / 1.3;
    let imposed = [0, 1, 2].map(|i| Some(function(Box::new(move |x| derivative(x, &[i])))));
    let mut conditions = Conditions::default().components("bottom", imposed);
    let sides = [("left", 0, -1.0), ("right", 0, 1.0), ("front", 1, -1.0), ("back", 1, 1.0), ("top", 2, 1.0)];
    for (side, axis, sign) in sides {
        let load =
            [0, 1, 2].map(|i| function(Box::new(move |x| sign * twice_mu * derivative(x, &[i, axis]))));
        conditions = conditions.traction(side, load);
    }
    let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3])?;
    let body = Body::new(mesh, LinearElastic::isotropic_solid(1.0, 0.3)?, &conditions)?;
    Ok(ContactProblem::new(vec![body]))
}

/// A cube with two planes of symmetry is pressed onto a rigid sphere of radius 2 that touches it at a corner.
pub fn on_sphere(n: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3])?;
    let conditions = Conditions::default()
        .roller("left", 0.0)
        .roller("front", 0.0)
        .traction("top", [0.0.into(), 0.0.into(), (-20.0).into()]);
    let body = Body::new(mesh, LinearElastic::isotropic_solid(1000.0, 0.3)?, &conditions)?;
    let sphere = RigidLine::Circle { centre: Vector3::new(0.0, 0.0, -2.0), radius: 2.0, inside: false };
    let sphere = Obstacle::fixed(sphere);
    let interface = contact_geometry::solid_against(&body, "bottom", &sphere, None)?;
    Ok(ContactProblem::new(vec![body]).obstacle(0, interface, sphere))
}

/// The loads on two bodies with a spherical interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnSphere {
    /// The lower body is clamped, and the top side of the upper one moves down and tilts.
    Tilted,
    /// The lower body is clamped, and a side of the upper one moves, contact nodes among it.
    SideMoved,
    /// The same side of both bodies moves, contact nodes among it, and a traction presses the upper one.
    BothMoved,
    /// The lower body is clamped, and a traction presses the upper one, which only contact holds along z.
    Pressed,
    /// The lower body is clamped, and a traction along the radii presses the upper one, which may spin about the centre: there are no planes of symmetry,
    /// and the surface is declared.
    Socket,
    /// As [`Self::Socket`], with a traction that turns the upper body.
    Turned,
}

/// Two bodies on `(0,1)² × (0,2)`, with two planes of symmetry and `n` cells per unit of length, that touch on the sphere of radius 2
/// around `(0, 0, -1)`: the upper one with twice the stiffness.
pub fn on_each_other(n: usize, loads: OnSphere) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let [upper, lower] = both_on_sphere([n; 2], loads)?;
    let interface = contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Touching)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// The bodies of [`on_each_other`], with different numbers of cells, laid over each other along z.
pub fn over_each_other(n: [usize; 2], loads: OnSphere) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
    let bodies = both_on_sphere(n, loads)?;
    let normal = ContactNormal::Fixed(-Vector3::z());
    let surfaces = ["bottom", "top"].map(str::to_owned);
    let sides = Sides::Bodies { bodies: [0, 1], surfaces, gap: Gap::Touching, normal };
    let contact = Contact { name: "sphere".into(), sides, friction: None };
    Ok(contact_geometry::paired_solids(bodies.into(), &[contact])?.problem)
}

fn both_on_sphere(n: [usize; 2], loads: OnSphere) -> Result<[Body<Solid>; 2], Box<dyn Error>> {
    let floats = [OnSphere::Socket, OnSphere::Turned].contains(&loads);
    let body = |(n, z): (usize, f64),
                young: f64,
                side: &str,
                conditions: Conditions|
     -> Result<Body<Solid>, Box<dyn Error>> {
        let mesh: TetMesh = cuboid([0.0, 0.0, z], [1.0; 3], [n; 3])?;
        let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
        let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
        let sphere = |x: &Vector3<f64>| {
            let height = (4.0 - x[0] * x[0] - x[1] * x[1]).sqrt() - 2.0;
            x + Vector3::z() * ((1.0 - (x[2] - 1.0).abs()) * height)
        };
        let mesh = Mesh::new(mesh.points().iter().map(sphere).collect(), mesh.cells().to_vec(), groups)?;
        let material = LinearElastic::isotropic_solid(young, 0.3)?;
        if !floats {
            let conditions = conditions.roller("left", 0.0).roller("front", 0.0);
            return Ok(Body::new(mesh, material, &conditions)?);
        }
        let surface = DeclaredSurface { on: side.into(), kind: SurfaceKind::Sphere };
        Ok(Body::new(mesh, material, &conditions)?.with_surfaces(&[surface])?)
    };
    let along = |turn: f64| {
        let arm = Vector3::new(0.0, 0.0, -1.0);
        [0, 1, 2].map(|c: usize| {
            let moved = if c == 1 { turn } else { 0.0 };
            ScalarData::<Solid>::Function(Arc::new(move |x: Vector3<f64>| -8.0 * (x - arm)[c] + moved))
        })
    };
    let tilt = ScalarData::<Solid>::Function(Arc::new(|x: Vector3<f64>| -0.02 + 0.03 * x[0]));
    let moved = [0.01, 0.0, -0.02].map(|u| Some(u.into()));
    let pressed = [0.0, 0.0, -20.0].map(ScalarData::from);
    let upper = match loads {
        OnSphere::Tilted => Conditions::default().components("top", [None, None, Some(tilt)]),
        OnSphere::SideMoved => Conditions::default().components("right", moved.clone()),
        OnSphere::BothMoved => {
            Conditions::default().components("right", moved.clone()).traction("top", pressed.clone())
        }
        OnSphere::Pressed => Conditions::default().traction("top", pressed),
        OnSphere::Socket => Conditions::default().traction("top", along(0.0)),
        OnSphere::Turned => Conditions::default().traction("top", along(1.0)),
    };
    let upper = body((n[0], 1.0), 2000.0, "bottom", upper)?;
    let lower = match loads {
        OnSphere::BothMoved => Conditions::default().components("right", moved),
        _ => Conditions::default().fix("bottom"),
    };
    let lower = body((n[1], 0.0), 1000.0, "top", lower)?;
    Ok([upper, lower])
}
