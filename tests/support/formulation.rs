//! The figures that the formulation prints for solids, and the same figures by this program.
//!
//! An independent code (Python, with another solver) computed them, and a second one reproduced them. If the two differ, the corrected figure is
//! listed.

mod printed;

use crate::model::Made;
use crate::solids::{
    Hertz, OnSphere, circle_of, cube, derivative, half_open, of_case, of_case_with, on_each_other, on_sphere,
};
use certified_contact::estimate;
use cre_estimator::{Estimate, Relaxation};
use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::field::stresses;
use fem_core::interface::{ContactInterface, ContactProblem};
use fem_core::norm::{energy_distance_squared, energy_norm_squared, sum_over_cells};
use fem_core::prepared::PreparedProblem;
use fem_core::quadrature::GAUSS5;
use fem_core::space::Solid;
use fem_core::tensor::SymTensor3;
use nalgebra::Vector3;
use nndd::stopping::EtaNndd;
use nndd::{Iterate, NewtonSettings, NnddSettings, solve};
use printed::Row;
use std::sync::OnceLock;

pub use printed::PRINTED;

/// A printed figure beside the one of this program.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// The section of the formulation.
    pub section: &'static str,
    /// The problem.
    pub problem: &'static str,
    /// Its cells per unit of length.
    pub n: usize,
    /// What is printed.
    pub name: &'static str,
    /// Its value as printed.
    pub printed: &'static str,
    /// The value of this program.
    pub found: f64,
}

impl Compared {
    fn value(&self) -> f64 {
        self.printed.parse().unwrap_or(f64::NAN)
    }

    /// Digits after the decimal point, and the power of ten that they are multiplied by.
    fn digits(&self) -> (usize, i32) {
        let (digits, power) = self.printed.split_once('e').unwrap_or((self.printed, "0"));
        (digits.split_once('.').map_or(0, |(_, after)| after.len()), power.parse().unwrap_or(0))
    }

    /// Computes the difference relative to the printed value, or the difference if that is 0.
    pub fn difference(&self) -> f64 {
        let by = self.value().abs();
        (self.found - self.value()) / if by > 0.0 { by } else { 1.0 }
    }

    /// Tells whether the figure rounds to the printed digits or is within 1e-9, relative.
    pub fn agrees(&self) -> bool {
        let (digits, power) = self.digits();
        let half = 0.5 * 10f64.powi(power - digits as i32);
        (self.found - self.value()).abs() <= half || self.difference().abs() <= 1e-9
    }

    /// Says why the figure differs from the printed one and by how much at most, relative; `None` if it should agree.
    pub fn reason(&self) -> Option<(&'static str, f64)> {
        let exact = ["cube", "circle", "circle, two materials"].contains(&self.problem);
        match self.name {
            // Smaller bodies are one cluster.
            name if name.starts_with("e_CRE/error") && self.n >= 12 => {
                Some(("edges are swept cluster by cluster, not in ascending order", 5e-3))
            }
            "error" if self.problem == "circle" => {
                Some(("the quadrature of the printed error is good to 1e-5", 3e-6))
            }
            _ if exact && self.n <= 6 => Some((
                "likely the loads, which are integrated by another rule: no problem with linear loads differs",
                3e-6,
            )),
            _ => None,
        }
    }

    /// Formats the figure with two digits more than the printed one.
    pub fn shown(&self) -> String {
        let (digits, found) = (self.digits().0, self.found);
        match () {
            () if self.printed.contains('e') => format!("{found:.*e}", digits + 2),
            () if digits == 0 && (found - found.round()).abs() < 1e-9 => format!("{:.0}", found.abs()),
            () => format!("{found:.*}", digits + 2),
        }
    }
}

fn figures(row: &Row) -> impl Iterator<Item = (&'static str, &'static str)> {
    row.3.split("; ").filter_map(|figure| figure.split_once(": "))
}

/// Returns a printed value; NaN if nothing is printed.
pub fn printed(problem: &str, n: usize, name: &str) -> f64 {
    let rows = PRINTED.iter().filter(|row| (row.1, row.2) == (problem, n));
    let found = rows.flat_map(figures).find(|figure| figure.0 == name);
    found.and_then(|(_, value)| value.parse().ok()).unwrap_or(f64::NAN)
}

/// Computes all figures of a row.
///
/// * `case`: the file in `cases/solid` that states the problem; without one, a function of [`crate::solids`] does.
///
/// # Errors
/// A problem that cannot be solved.
pub fn compared(row: &Row, case: Option<&'static str>) -> Made<Vec<Compared>> {
    let &(section, problem, n, _) = row;
    let run = if section == "4" { None } else { Run::new(case.unwrap_or(problem), n)? };
    let others = match (&run, section) {
        (Some(_), _) => Vec::new(),
        (None, "4") => iteration(n)?,
        (None, _) => pushed(problem, n)?,
    };
    let mut found = Vec::new();
    for (name, printed) in figures(row) {
        let value = match &run {
            Some(run) => run.figure(name)?,
            None => others.iter().find(|(n, _)| n == name).map(|(_, value)| *value),
        };
        let value = value.ok_or_else(|| format!("{problem} {n}: no figure is named {name:?}"))?;
        found.push(Compared { section, problem, n, name, printed, found: value });
    }
    Ok(found)
}

fn problem(name: &str, n: usize) -> Made<Option<ContactProblem<Solid>>> {
    let unit = Hertz { modulus: 1.0, nu: 0.3 };
    Ok(Some(match name {
        "cube" => cube(n)?,
        "gradient.toml" | "hertz.toml" => of_case(name, n, n)?,
        "half_open.toml" => of_case(name, n, 2 * n)?,
        "weight" => of_case("weight.toml", n, n)?,
        "circle" => circle_of(n, [unit; 2])?,
        "circle, two materials" => circle_of(n, CONTRAST)?,
        "half-open" => half_open(n)?,
        "stack" => of_case("stack.toml", n, 2 * n)?,
        "friction, s = 1" => rubbing(n, "1.0")?,
        "friction, s = 4" => rubbing(n, "4.0")?,
        "friction, s = 8" => rubbing(n, "8.0")?,
        "stack with friction" => {
            let law = r#"{ law = "tresca", limit = 4.0 }"#;
            let both = [("contact.0.friction", law), ("contact.1.friction", law)];
            let others = [both[0], both[1], ("body.1.traction.0.vector", "[0.0, 3.0, 10.0]")];
            of_case_with("stack.toml", n, 2 * n, &others)?
        }
        "corner" => of_case("corner.toml", n, n)?,
        "sphere" => on_sphere(n)?,
        "tilted on a sphere" => on_each_other(n, OnSphere::Tilted)?,
        "side moved on a sphere" => on_each_other(n, OnSphere::SideMoved)?,
        "both sides moved on a sphere" => on_each_other(n, OnSphere::BothMoved)?,
        "pressed on a sphere" => on_each_other(n, OnSphere::Pressed)?,
        "socket" => on_each_other(n, OnSphere::Socket)?,
        _ => return Ok(None),
    }))
}

/// Two blocks with friction up to a limit.
fn rubbing(n: usize, limit: &str) -> Made<ContactProblem<Solid>> {
    of_case_with("tresca.toml", n, 2 * n, &[("contact.0.friction.limit", limit)])
}

const CONTRAST: [Hertz; 2] = [Hertz { modulus: 1.0, nu: 0.2 }, Hertz { modulus: 20.0, nu: 0.4 }];

/// The motion that nothing resists if a load pushes a body along its contact.
fn pushed(name: &str, n: usize) -> Made<Vec<(String, f64)>> {
    let (case, across, key, traction) = match name {
        "corner pulled" => ("corner.toml", n, "body.0.traction", "[10, 0.0, 0.0]"),
        _ => ("stack.toml", 2 * n, "body.1.traction", "[0.0, 3.0, 10.0]"),
    };
    let problem = crate::solids::of_case_with(case, n, across, &[(&format!("{key}.0.vector"), traction)])?;
    let motion = certified_contact::support(&problem)?.unresisted.ok_or("the problem is held")?;
    let centre = Vector3::new(0.5, 0.5, 0.5);
    let moved = motion.bodies[0].1.at(centre);
    let mut found = vec![("unresisted load".to_owned(), motion.load)];
    let names = ["its motion along x", "along y", "along z"];
    found.extend(names.iter().zip(moved.iter()).map(|(name, u)| ((*name).to_owned(), *u)));
    Ok(found)
}

/// The history of the paper's iteration for half-open blocks, and the ends of the spectrum.
fn iteration(n: usize) -> Made<Vec<(String, f64)>> {
    let prepared = PreparedProblem::new(half_open(n)?)?;
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 100;
    let run = |settings: NnddSettings, tolerance: f64| {
        solve(&prepared.system(), vec![0.0; prepared.rows()], settings, &mut EtaNndd::new(tolerance))
    };
    let history = run(settings.clone(), 1e-10)?.history;
    let eta =
        history.iter().enumerate().map(|(k, row)| (format!("η_NNDD, iteration {}", k + 1), row.eta_nndd));
    let mut found: Vec<(String, f64)> = eta.collect();
    found.push(("iterations to 1e-10".to_owned(), history.len() as f64));
    settings.theta = None;
    let spectrum = run(settings, 0.5)?.spectrum.ok_or("no spectrum")?;
    found.push(("smallest μ".to_owned(), spectrum.smallest));
    found.push(("largest μ".to_owned(), spectrum.largest));
    Ok(found)
}

/// The displacements of the nodes of a body.
type Field = Vec<Vector3<f64>>;

/// A solved problem.
struct Run {
    name: &'static str,
    n: usize,
    prepared: PreparedProblem<Solid>,
    last: Iterate,
    fields: Vec<Field>,
    /// By EET.
    first: Estimate<Solid>,
    /// After as many steps as change it.
    best: OnceLock<Estimate<Solid>>,
    error: OnceLock<f64>,
}

fn certified(prepared: &PreparedProblem<Solid>, last: &Iterate, steps: usize) -> Made<Estimate<Solid>> {
    let found = estimate(prepared, last, Relaxation::Steps(steps))?;
    let rounded = found.round_off > 1e-9 * found.unchecked().e_cre;
    if found.certificate().is_none() || found.cre.split_defect() > 1e-12 || rounded {
        let (split, rounding) = (found.cre.split_defect(), found.round_off);
        return Err(format!("split {split}, round-off {rounding}, {:?}", found.admissibility).into());
    }
    Ok(found)
}

impl Run {
    fn new(name: &'static str, n: usize) -> Made<Option<Self>> {
        let Some(problem) = problem(name, n)? else { return Ok(None) };
        let prepared = PreparedProblem::new(problem)?;
        let start = vec![0.0; prepared.rows()];
        let mut stop = EtaNndd::new(1e-12);
        let last = solve(&prepared.system(), start, NewtonSettings::default(), &mut stop)?.last;
        let fields = prepared.displacements(&last.fields(&prepared.system()));
        let first = certified(&prepared, &last, 0)?;
        Ok(Some(Self {
            name,
            n,
            prepared,
            last,
            fields,
            first,
            best: OnceLock::new(),
            error: OnceLock::new(),
        }))
    }

    fn relaxed(&self, steps: usize) -> Made<Estimate<Solid>> {
        certified(&self.prepared, &self.last, steps)
    }

    fn best(&self) -> Made<&Estimate<Solid>> {
        if self.best.get().is_none() {
            let _ = self.best.set(self.relaxed(400)?);
        }
        self.best.get().ok_or_else(|| "no estimate".into())
    }

    fn bodies(&self) -> impl Iterator<Item = (&Body<Solid>, &Field)> {
        self.prepared.problem().bodies.iter().zip(&self.fields)
    }

    /// Computes the exact stress in a body.
    fn exact(&self, body: usize, x: Vector3<f64>) -> Made<SymTensor3> {
        let field = match self.name {
            "circle" | "hertz.toml" => Hertz { modulus: 1.0, nu: 0.3 },
            "circle, two materials" => CONTRAST[body],
            "cube" | "gradient.toml" => {
                let s = |i, j| derivative(x, &[i, j]) / 1.3;
                let [xx, yy, zz] = [0, 1, 2].map(|i| s(i, i));
                return Ok(SymTensor3 { xx, yy, zz, yz: s(1, 2), xz: s(0, 2), xy: s(0, 1) });
            }
            _ => return Err("no exact field is known".into()),
        };
        let mirror = if body == 1 { -1.0 } else { 1.0 };
        let s = field.stress(Vector3::new(x[0], x[1], mirror * x[2]));
        Ok(SymTensor3 { yz: mirror * s.yz, xz: mirror * s.xz, ..s })
    }

    /// Integrates the energy of the exact stress in a body less `given` ones of the cells.
    fn energy(&self, b: usize, given: Option<&[SymTensor3]>) -> Made<f64> {
        let body = &self.prepared.problem().bodies[b];
        self.exact(b, Vector3::new(0.3, 0.3, 0.3))?;
        let mesh = body.mesh();
        Ok(sum_over_cells(mesh.cells().len(), |t| {
            let [o, p, q, r] = mesh.corners(t);
            let mut mean = 0.0;
            // A cube that is folded to the tetrahedron.
            for ((u, a), (v, b_), (w, c)) in points() {
                let x = o + (p - o) * u + ((q - o) * v + (r - o) * ((1.0 - v) * w)) * (1.0 - u);
                let exact = self.exact(b, x).unwrap_or_default();
                let d = given.map_or(exact, |given| exact.minus(given[t]));
                mean +=
                    6.0 * a * b_ * c * (1.0 - u).powi(2) * (1.0 - v) * body.material(t).complementary(d, d);
            }
            mean * mesh.measure(t)
        }))
    }

    fn error(&self) -> Made<f64> {
        if let Some(error) = self.error.get() {
            return Ok(*error);
        }
        let of_body =
            |(b, (body, u)): (usize, (&Body<Solid>, &Field))| self.energy(b, Some(&stresses(body, u)));
        let error = self.bodies().enumerate().map(of_body).sum::<Made<f64>>()?.sqrt();
        Ok(*self.error.get_or_init(|| error))
    }

    /// Computes the distance to the solution with `times` as many cells along each axis.
    fn distance(&self, times: usize) -> Made<f64> {
        let finer = Self::new(self.name, self.n * times)?.ok_or("no problem")?;
        let long = self.name.starts_with("stack") || self.name.starts_with("friction");
        let across = if long { 2 } else { 1 } * self.n;
        let of_body = |((body, fine), coarse): ((&Body<Solid>, &Field), &Field)| {
            energy_distance_squared(body, fine, &interpolated([across, self.n, self.n], coarse, times))
        };
        Ok(finer.bodies().zip(&self.fields).map(of_body).sum::<f64>().sqrt())
    }

    /// Adds up the friction of a pair on its second body.
    fn friction(&self, pair: usize) -> Vector3<f64> {
        let problem = self.prepared.problem();
        let of = &problem.contacts[pair];
        let Some(rows) = problem.tangential_blocks().nth(pair) else { return Vector3::zeros() };
        let force = &self.last.tangential.force[rows];
        (0..of.interface.pairs().len()).map(|k| of.along_tangents(k, force)).sum()
    }

    /// Counts the closed nodes of a pair that stick, or that slip.
    fn closed(&self, pair: usize, sticks: bool) -> f64 {
        let problem = self.prepared.problem();
        let both = problem.blocks().zip(problem.tangential_blocks()).nth(pair);
        let Some((rows, tangents)) = both else { return 0.0 };
        let (forces, slip) = (&self.last.contact.normal_reaction[rows], &self.last.tangential.slip[tangents]);
        let nodes = forces.len();
        let found = (0..nodes).filter(|k| forces[*k] > 0.0);
        found.filter(|k| (slip[*k] == 0.0 && slip[nodes + k] == 0.0) == sticks).count() as f64
    }

    /// Computes the term of friction with each face in 16 parts.
    fn parted_friction(&self, found: &Estimate<Solid>) -> f64 {
        let pairs = self.prepared.problem().contacts.iter().zip(&found.pair.contacts);
        let mut sum = 0.0;
        for (of, contact) in pairs {
            let friction = &contact.facet_friction;
            for (k, face) in of.interface.facets().iter().enumerate() {
                let normal = of.interface.corner_pair(face, 0).normal;
                let slip = friction.jump[k].map(|jump| jump - normal * normal.dot(&jump));
                let (traction, limit) = (&friction.traction[k], &friction.limit[k]);
                for part in parts_of_face() {
                    let at = |of: &[Vector3<f64>; 3], x: [f64; 3]| of[0] * x[0] + of[1] * x[1] + of[2] * x[2];
                    let (q, w) = (part.map(|x| at(traction, x)), part.map(|x| at(&slip, x)));
                    let s = part.map(|x| x[0] * limit[0] + x[1] * limit[1] + x[2] * limit[2]);
                    let term = |i: usize, j: usize| {
                        f64::from(u8::from(i == j) + 1) * (s[i] * w[j].norm() - q[i].dot(&w[j]))
                    };
                    let terms: f64 = (0..9).map(|k| term(k / 3, k % 3)).sum();
                    sum += 2.0 * face.measure / 16.0 * terms / 12.0;
                }
            }
        }
        sum
    }

    /// Computes the bound with that term.
    fn parted_bound(&self, found: &Estimate<Solid>) -> f64 {
        let squared = found.cre.e_cre_squared - found.cre.friction_squared() + self.parted_friction(found);
        squared.sqrt()
    }

    /// Computes a figure; `None` if it has no such name.
    fn figure(&self, name: &str) -> Made<Option<f64>> {
        let problem = self.prepared.problem();
        if let Some(steps) = name.strip_prefix("e_CRE/error, step ") {
            return Ok(Some(self.relaxed(steps.parse()?)?.cre.e_cre() / self.error()?));
        }
        if let Some(times) =
            name.strip_prefix("e_CRE of 4 steps/distance to ").and_then(|rest| rest.strip_suffix(" n"))
        {
            return Ok(Some(self.relaxed(4)?.cre.e_cre() / self.distance(times.parse()?)?));
        }
        let norm = || self.bodies().map(|(body, u)| energy_norm_squared(body, u)).sum::<f64>();
        // A number of a body or of a pair, from 1.
        let (what, k) = match name.rsplit_once([' ']) {
            Some((what, k)) => (what, k.parse::<usize>().unwrap_or(1).saturating_sub(1)),
            None => (name, 0),
        };
        let pair = |value: fn(&ContactInterface<Solid>, &[f64], &[f64]) -> f64| -> Option<f64> {
            let (of, rows) = problem.contacts.iter().zip(problem.blocks()).nth(k)?;
            let nodes = of.interface.pairs();
            let forces = nodes.iter().zip(&self.last.contact.normal_reaction[rows]);
            let along: Vec<f64> = forces.map(|(node, r)| r * node.normal_length()).collect();
            let density: Vec<f64> = nodes.iter().zip(&along).map(|(node, r)| r / node.weight).collect();
            Some(value(&of.interface, &along, &density))
        };
        let mesh = |found: &Estimate<Solid>| {
            found.cre.discretisation_by_cell.get(k).map(|cells| cells.iter().sum::<f64>().sqrt())
        };
        Ok(match (name, what) {
            ("nodes", _) => {
                Some(self.bodies().map(|(body, _)| body.mesh().points().len()).sum::<usize>() as f64)
            }
            ("√a(u,u)", _) => Some(norm().sqrt()),
            ("J", _) => {
                let nodes = self.bodies().flat_map(|(body, u)| external_forces(body).into_iter().zip(u));
                Some(0.5 * norm() - nodes.map(|(f, u)| f.dot(u)).sum::<f64>())
            }
            ("error", _) => Some(self.error()?),
            ("relative error", _) => Some(self.error()? / norm().sqrt()),
            ("e_CRE by EET", _) => Some(self.first.cre.e_cre()),
            ("e_CRE at best", _) => Some(self.best()?.cre.e_cre()),
            ("2∫po", _) => Some(self.first.cre.contact_squared() - self.first.cre.friction_squared()),
            ("friction term", _) => Some(self.first.cre.friction_squared()),
            ("friction term, 16 parts a face", _) => Some(self.parted_friction(&self.first)),
            ("e_CRE by EET, 16 parts a face", _) => Some(self.parted_bound(&self.first)),
            ("e_CRE at best, 16 parts a face", _) => Some(self.parted_bound(self.best()?)),
            ("sticking, pairs", _) => Some((0..problem.contacts.len()).map(|k| self.closed(k, true)).sum()),
            ("slipping, pairs", _) => Some((0..problem.contacts.len()).map(|k| self.closed(k, false)).sum()),
            (_, "sticking, pair") => Some(self.closed(k, true)),
            (_, "slipping, pair") => Some(self.closed(k, false)),
            (_, "friction x, pair") => Some(self.friction(k)[0]),
            (_, "friction y, pair") => Some(self.friction(k)[1]),
            (_, "‖û−u‖², body") => self.first.pair.bodies.get(k).map(|of| {
                let body = &problem.bodies[k];
                let cell = |t: usize| {
                    let difference = of.equilibrated.finite_element[t].minus(of.stress[t]);
                    body.mesh().measure(t) * body.material(t).complementary(difference, difference)
                };
                sum_over_cells(of.stress.len(), cell)
            }),
            ("2∫po with the lift", _) => {
                Some(self.first.cre.contact_squared() - self.first.pair.lift_energy)
            }
            ("‖û−u‖²", _) => {
                Some(self.first.cre.algebraic_squared - self.first.cre.contact_squared())
            }
            (_, "a(u,u) of the exact field, body") => Some(self.energy(k, None)?),
            (_, "a(u,u), body") => self.bodies().nth(k).map(|(body, u)| energy_norm_squared(body, u)),
            (_, "‖τ−σ̂‖ by EET, body") => mesh(&self.first),
            (_, "‖τ−σ̂‖ at best, body") => mesh(self.best()?),
            (_, "nodes of pair") => pair(|_, along, _| along.len() as f64),
            (_, "force, pair") => pair(|_, along, _| along.iter().sum()),
            (_, "closed, pair") => pair(|_, along, _| along.iter().filter(|r| **r > 0.0).count() as f64),
            (_, "largest P/ℓ, pair") => pair(|_, _, density| density.iter().copied().fold(0.0, f64::max)),
            // Of the corners of a face.
            (_, "largest mean P/ℓ, pair") => pair(|interface, _, density| {
                let faces = interface.facets().iter().map(|face| interface.pressure(face, density)[0]);
                faces.fold(0.0, f64::max)
            }),
            (_, "largest face p, pair") => {
                let faces = self.first.pair.contacts.get(k).map(|of| of.edge_pressure.as_flattened());
                faces.map(|faces| faces.iter().copied().fold(0.0, f64::max))
            }
            (_, "largest p, pair") => {
                self.first.pair.contacts.get(k).map(|of| of.pressure.iter().copied().fold(0.0, f64::max))
            }
            _ => None,
        })
    }
}

/// Lists the corners of 16 equal parts of a triangle, by barycentric coordinates.
fn parts_of_face() -> impl Iterator<Item = [[f64; 3]; 3]> {
    let at = |i: i32, j: i32| [i, j, 4 - i - j].map(|k| 0.25 * f64::from(k));
    (0..4).flat_map(move |i| (0..4 - i).map(move |j| (i, j))).flat_map(move |(i, j)| {
        let upright = [at(i + 1, j), at(i, j + 1), at(i, j)];
        let turned = [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        [Some(upright), (i + j < 3).then_some(turned)].into_iter().flatten()
    })
}

type Point = (f64, f64);

fn points() -> impl Iterator<Item = (Point, Point, Point)> {
    let all = || GAUSS5.into_iter();
    all().flat_map(move |u| all().flat_map(move |v| all().map(move |w| (u, v, w))))
}

/// Interpolates a field on a mesh of a box with `times` as many cells along each axis.
///
/// * `cells`: along each axis of the coarser mesh.
fn interpolated([nx, ny, nz]: [usize; 3], coarse: &[Vector3<f64>], times: usize) -> Vec<Vector3<f64>> {
    let at = |[i, j, k]: [usize; 3]| coarse[i + (nx + 1) * (j + (ny + 1) * k)];
    let value = |place: [usize; 3]| {
        // From the first corner of the cell along the axes, the longest way first.
        let mut corner = place.map(|c| c / times);
        let mut axes = [0, 1, 2];
        axes.sort_by_key(|axis| std::cmp::Reverse(place[*axis] % times));
        let mut u = at(corner);
        for axis in axes.into_iter().filter(|axis| !place[*axis].is_multiple_of(times)) {
            let before = at(corner);
            corner[axis] += 1;
            u += (at(corner) - before) * ((place[axis] % times) as f64 / times as f64);
        }
        u
    };
    let counts = [nx, ny, nz].map(|n| n * times);
    let planes = (0..=counts[2]).flat_map(|k| (0..=counts[1]).map(move |j| (j, k)));
    planes.flat_map(|(j, k)| (0..=counts[0]).map(move |i| [i, j, k])).map(value).collect()
}
