//! How much memory a solve needs, before it starts, whether there is enough, and which way of solving fits.

use crate::convert;
use crate::failure::Failure;
use crate::host::{Host, MemoryLimit};
use crate::space::{Pieces, ReportSpace};
use case_io::Case;
use case_io::case::Subdomains;
use certified_contact::{Settings, prefers_exact, subdomains};
use fem_core::interface::{Bonds, ContactProblem};
use fem_core::mesh::Mesh;
use fem_core::subdomains::may_be_cut;
use nndd::{Method, flexibility_entries};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Memory that must be available, over the estimate, which is right within 8 % in the plane, and within 10 % for large solids.
const MARGIN: f64 = 1.1;

/// Memory of a solved mesh with its fields and stresses, kept while the next one is solved, bytes per node.
const KEPT_PER_NODE: f64 = 950.0;

/// Bytes of the program itself.
const PROGRAM: f64 = 20e6;
/// Bytes of three dense matrices per square of the pairs.
pub(crate) const INTERFACE: f64 = 3.0 * 8.0;

/// Bytes of a body whatever its size, measured on walls of 500 and 2,000 blocks.
pub(crate) const BODY: f64 = 6e4;

/// A contact line is named if it makes the need this many times as large.
const LONG_LINE: f64 = 2.0;

/// Nodes of a subdomain if memory is short: fewer need less memory for their factors, and more for the coarse space.
const SUBDOMAIN_NODES: usize = 350;

/// How bodies are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// See [`Settings::subdomains`].
    subdomains: usize,
    /// See [`Settings::subdomain_nodes`].
    subdomain_nodes: usize,
    /// See [`Settings::recomputes`].
    recomputes: bool,
}

impl Plan {
    /// Returns the way that the case asks for.
    fn asked<S: ReportSpace>(case: &Case<S>) -> Self {
        let subdomains = convert::settings(case).subdomains;
        Self { subdomains, subdomain_nodes: usize::MAX, recomputes: false }
    }

    /// Lists the ways to solve a case: the one that it asks for, then those that are tried if memory is short. The last one is for bodies that cannot be cut, and
    /// for small ones.
    fn all<S: ReportSpace>(case: &Case<S>) -> Vec<Self> {
        let asked = Self::asked(case);
        // The meshes to come of an adaptive run are not known.
        if case.adapt.is_some() || case.coulomb_pair().is_some() || convert::relaxation(case).max_steps() == 0
        {
            return vec![asked];
        }
        let lean = |plan: Self| Self { recomputes: true, ..plan };
        let cut = Self { subdomain_nodes: SUBDOMAIN_NODES, ..asked };
        match case.solver.subdomains {
            Subdomains::Auto => vec![asked, cut, lean(cut), lean(asked)],
            Subdomains::Count(_) => vec![asked, lean(asked)],
        }
    }

    /// Chooses the first way to solve a problem that fits in memory, or the one that needs least if none does.
    ///
    /// * `joined`: after bonds have joined bodies; `sizes`: of these.
    fn new<S: ReportSpace>(
        case: &Case<S>,
        (joined, sizes): (&ContactProblem<S>, &[Size<'_, S>]),
        host: &dyn Host,
    ) -> Self {
        let asked = Self::asked(case);
        // An exact solution has no subdomains.
        let newton_nn = matches!(asked.settings(case).method_for(joined), Method::NewtonNn(_));
        let counts = |plan: &Self| plan.settings(case).subdomains_of(joined).ok();
        let differs = |plan: &Self| {
            let cuts = plan.subdomain_nodes != asked.subdomain_nodes;
            !cuts || newton_nn && counts(plan).is_some_and(|counts| counts.iter().any(|count| *count > 1))
        };
        let need = |plan: &Self| plan.of_sizes(sizes);
        let most = need(&asked);
        // The others cost a partition of every body.
        if shortage(case, most, host).is_none() {
            return asked;
        }
        let mut all = vec![(asked, most)];
        let others = Self::all(case).into_iter().skip(1).filter(differs);
        all.extend(others.map(|plan| (plan, need(&plan))).filter(|(_, need)| *need < most));
        Self::choose(case, &all, host)
    }

    /// * `all`: with what they need, bytes.
    fn choose<S: ReportSpace>(case: &Case<S>, all: &[(Self, f64)], host: &dyn Host) -> Self {
        let fits = |(_, need): &&(Self, f64)| shortage(case, *need, host).is_none();
        let least = || all.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        all.iter().find(fits).or_else(least).map_or(Self::asked(case), |(plan, _)| *plan)
    }

    /// Makes the settings of a solve.
    pub fn settings<S: ReportSpace>(&self, case: &Case<S>) -> Settings<S> {
        let mut settings = convert::settings(case);
        settings.subdomains = self.subdomains;
        (settings.subdomain_nodes, settings.recomputes) = (self.subdomain_nodes, self.recomputes);
        settings
    }

    /// Estimates the memory of a solve from the number of nodes, bytes.
    ///
    /// See [`ReportSpace::memory`] of each body; and the program itself.
    pub fn estimate<S: ReportSpace>(&self, problem: &ContactProblem<S>) -> f64 {
        let bonds = Bonds::new(problem).ok().flatten();
        self.of_sizes(&sizes(bonds.as_ref().map_or(problem, |bonds| &bonds.joined)))
    }

    fn of_sizes<S: ReportSpace>(&self, bodies: &[Size<'_, S>]) -> f64 {
        let of_body = |body: &Size<'_, S>| {
            let count = match body.may_be_cut {
                true => subdomains(body.nodes as usize, self.subdomains, self.subdomain_nodes),
                false => 1,
            };
            S::memory((body.nodes, body.pairs), &body.subdomains(count), self.recomputes)
        };
        bodies.iter().map(of_body).sum::<f64>() + PROGRAM
    }

    /// Says what the run does because memory is short; `None` if it does nothing.
    pub fn note<S: ReportSpace>(&self, case: &Case<S>) -> Option<String> {
        let asked = Self::asked(case);
        let mut what = Vec::new();
        if self.subdomain_nodes != asked.subdomain_nodes {
            what.push(format!("bodies are cut into subdomains of about {SUBDOMAIN_NODES} nodes or fewer"));
        }
        if self.recomputes {
            what.push("the estimator computes its coefficients again in each sweep".to_owned());
        }
        if what.is_empty() {
            return None;
        }
        let what = what.join(", and ");
        Some(format!("since memory is short, {what}: the bounds are as strict, and the run takes longer"))
    }
}

/// Estimates the memory of a solve on a finer mesh, while the solution on the mesh before is kept, bytes.
///
/// * `before`: nodes of that mesh.
pub(crate) fn estimate_finer<S: ReportSpace>(
    (case, plan): (&Case<S>, &Plan),
    problem: &ContactProblem<S>,
    before: usize,
) -> f64 {
    let steps = case.increments().len().max(1);
    // Of each mesh the solutions of all load steps are kept.
    let kept = steps * before + (steps - 1) * problem.nodes();
    plan.estimate(problem) + KEPT_PER_NODE * kept as f64
}

/// The sizes of a body that determine its memory.
#[derive(Clone)]
struct Size<'p, S: ReportSpace> {
    nodes: u64,
    /// Contact nodes.
    pairs: usize,
    may_be_cut: bool,
    /// Its mesh, if there is one already.
    mesh: Option<&'p Mesh<S>>,
    /// What [`Self::subdomains`] found for some counts.
    known: RefCell<BTreeMap<usize, Rc<[Pieces]>>>,
}

impl<'p, S: ReportSpace> Size<'p, S> {
    fn new(nodes: u64, pairs: usize, may_be_cut: bool, mesh: Option<&'p Mesh<S>>) -> Self {
        Self { nodes, pairs, may_be_cut, mesh, known: RefCell::default() }
    }

    /// Returns the sizes of its subdomains, without a mesh at least; none if the body is in one piece.
    fn subdomains(&self, count: usize) -> Rc<[Pieces]> {
        if count == 1 {
            return Rc::new([]);
        }
        let find = || -> Rc<[Pieces]> {
            match self.mesh {
                Some(mesh) => {
                    let of =
                        |(nodes, shared)| Pieces { count: 1.0, nodes: nodes as f64, shared: shared as f64 };
                    mesh.shared_nodes(count).into_iter().map(of).collect()
                }
                None => {
                    let (count, nodes) = (count as f64, self.nodes as f64 / count as f64);
                    // Four of the six sides of a cube.
                    let shared = nodes.min(4.0 * nodes.powf(2.0 / 3.0));
                    Rc::new([Pieces { count, nodes, shared }])
                }
            }
        };
        self.known.borrow_mut().entry(count).or_insert_with(find).clone()
    }
}

fn sizes<S: ReportSpace>(problem: &ContactProblem<S>) -> Vec<Size<'_, S>> {
    let bodies = problem.bodies.iter().zip(problem.sides());
    let mut sizes: Vec<Size<'_, S>> = bodies
        .map(|(body, sides)| {
            let pairs = sides.into_iter().map(|(k, _)| problem.contacts[k].interface.pairs().len()).sum();
            Size::new(body.mesh().points().len() as u64, pairs, may_be_cut(body), Some(body.mesh()))
        })
        .collect();
    if prefers_exact(problem) {
        // The flexibility of all pairs together, with its factor.
        let pairs = flexibility_entries(&problem.contact_rows()).isqrt();
        sizes.push(Size::new(0, pairs, false, None));
    }
    sizes
}

/// Refuses, before any mesh is made, a case whose nodes alone need more memory than there may be.
///
/// * `planned`: whether it is solved in whatever way fits, or in the one that it asks for.
pub(crate) fn check_counts<S: ReportSpace>(
    case: &Case<S>,
    planned: bool,
    host: &dyn Host,
) -> Result<(), Failure> {
    let size = |nodes: u64| Size::new(nodes, 0, true, None);
    let sizes: Vec<Size<'_, S>> = case.node_counts().into_iter().map(size).collect();
    let all = if planned { Plan::all(case) } else { vec![Plan::asked(case)] };
    let all: Vec<(Plan, f64)> = all.into_iter().map(|plan| (plan, plan.of_sizes(&sizes))).collect();
    check((case, &Plan::choose(case, &all, host)), host, &sizes, None)
}

/// Decides how a problem is solved, and estimates the memory of that, bytes; refuses one that needs more than there may be.
pub(crate) fn plan<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    planned: bool,
    host: &dyn Host,
) -> Result<(Plan, f64), Failure> {
    let bonds = Bonds::new(problem).ok().flatten();
    let joined = bonds.as_ref().map_or(problem, |bonds| &bonds.joined);
    let sizes = sizes(joined);
    let plan = if planned { Plan::new(case, (joined, &sizes), host) } else { Plan::asked(case) };
    check((case, &plan), host, &sizes, Some(problem.node_pairs()))?;
    Ok((plan, plan.of_sizes(&sizes)))
}

/// * `pairs`: of all contact lines, if they are known.
fn check<S: ReportSpace>(
    (case, plan): (&Case<S>, &Plan),
    host: &dyn Host,
    sizes: &[Size<'_, S>],
    pairs: Option<usize>,
) -> Result<(), Failure> {
    let needed = plan.of_sizes(sizes);
    let without: Vec<Size<'_, S>> = sizes.iter().map(|size| Size { pairs: 0, ..size.clone() }).collect();
    let line = pairs.filter(|_| needed > LONG_LINE * plan.of_sizes(&without));
    let Some((needed, MemoryLimit { bytes: limit, words, fix: other })) = shortage(case, needed, host) else {
        return Ok(());
    };
    let nodes = sizes.iter().fold(0u64, |sum, size| sum.saturating_add(size.nodes));
    let least = if pairs.is_none() { "at least " } else { "" };
    // The need grows a little faster than the number of nodes, and as the square of the pairs.
    let (what, fits, fix) = match line {
        None => (
            format!("{nodes} nodes"),
            format!("{} nodes", two_digits(nodes as f64 * (limit / needed).powf(1.0 / S::MEMORY_POWER))),
            S::FEWER_NODES,
        ),
        Some(pairs) => (
            format!("{pairs} pairs of contact nodes, and {nodes} nodes"),
            format!("{} pairs", two_digits(pairs as f64 * (limit / needed).sqrt())),
            S::FEWER_PAIRS,
        ),
    };
    Err(Failure::limit(format!(
        "{least}about {} are needed for {what}; {words}, enough for about {fits}.\n  expected: a problem that fits \
         into memory\n  fix: {}",
        mebibytes(needed),
        other.map_or(fix.to_owned(), |other| format!("{other}; or {fix}"))
    )))
}

/// Rounds down to two digits.
fn two_digits(count: f64) -> u64 {
    let unit = 10f64.powf((count.max(10.0).log10() - 1.0).floor());
    ((count / unit).floor() * unit) as u64
}

/// Says why there is not enough memory; `None` if there is.
pub(crate) fn no_room<S: ReportSpace>(case: &Case<S>, needed: f64, host: &dyn Host) -> Option<String> {
    shortage(case, needed, host)
        .map(|(needed, room)| format!("about {} and {}", mebibytes(needed), room.words))
}

/// Returns the room that is too small, the case's limit first, and what there must be room for.
fn shortage<S: ReportSpace>(case: &Case<S>, needed: f64, host: &dyn Host) -> Option<(f64, MemoryLimit)> {
    let allowed = case.limits.memory.as_ref().map(|limit| MemoryLimit {
        bytes: limit.value as f64,
        words: format!("limits.memory is {}", limit.written),
        fix: None,
    });
    let system = || host.memory_limit().map(|room| (MARGIN * needed, room));
    let is_short = |(needed, room): &(f64, MemoryLimit)| *needed > room.bytes;
    allowed.map(|room| (needed, room)).filter(is_short).or_else(|| system().filter(is_short))
}

/// Writes a size in MiB, GiB or TiB.
pub fn mebibytes(bytes: f64) -> String {
    let mib = bytes / f64::from(1 << 20);
    let (gib, tib) = (mib / 1024.0, mib / f64::from(1 << 20));
    match mib {
        _ if mib < 1024.0 => format!("{mib:.1} MiB"),
        _ if gib < 1024.0 => format!("{gib:.2} GiB"),
        _ if tib < 1e4 => format!("{tib:.2} TiB"),
        _ => format!("{tib:.1e} TiB"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use case_io::case::AnyCase;
    use fem_core::space::{Plane, Solid};

    struct Nowhere;

    impl Host for Nowhere {
        fn elapsed(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn a_long_contact_line_is_named_where_it_takes_the_memory() {
        let limit = [("limits.memory".to_owned(), "1MiB".to_owned())];
        let case = Case::parse(case_io::template::PAPER, "paper.toml", &limit).unwrap();
        let said = |nodes: [u64; 2], pairs: Option<usize>| {
            let sizes = nodes.map(|nodes| Size::<Plane>::new(nodes, pairs.unwrap_or(0), true, None));
            check((&case, &Plan::all(&case)[0]), &Nowhere, &sizes, pairs).unwrap_err().message.unwrap()
        };
        let of_nodes = said([1000, 1000], Some(40));
        assert!(of_nodes.contains("for 2000 nodes; limits.memory is 1MiB, enough for about"), "{of_nodes}");
        let of_line = said([20_000, 20_000], Some(20_000));
        assert!(
            of_line.contains("for 20000 pairs of contact nodes") && of_line.contains("fewer edges"),
            "{of_line}"
        );
        // Before there is a mesh the contact line is not known.
        assert!(said([1000, 1000], None).starts_with("at least about"));
    }

    #[test]
    fn each_way_to_solve_large_solids_in_subdomains_needs_less_memory_than_the_one_before() {
        let text = case_io::template::SOLID.split("[adapt]").next().unwrap();
        let AnyCase::Solid(case) = AnyCase::parse(text, "solid.toml", &[]).unwrap() else {
            panic!("a plane case")
        };
        let need = |nodes: u64| {
            let sizes = [nodes; 2].map(|nodes| Size::<Solid>::new(nodes, 2000, true, None));
            let of = |plan: Plan| plan.of_sizes(&sizes);
            Plan::all(&case).into_iter().map(of).collect::<Vec<f64>>()
        };
        let of_mesh = need(100_000);
        assert!(of_mesh[..3].is_sorted_by(|a, b| a > b) && of_mesh[3] < of_mesh[0], "{of_mesh:?}");
        // A factor grows as n^(4/3), subdomains as n.
        let [ten, one] = [need(1_000_000), of_mesh];
        assert!(ten[0] > 14.0 * one[0] && ten[2] < 12.0 * one[2], "{one:?} {ten:?}");
        let notes: Vec<Option<String>> = Plan::all(&case).iter().map(|plan| plan.note(&case)).collect();
        assert!(notes[0].is_none() && notes[1..].iter().all(Option::is_some));
    }

    #[test]
    fn sizes_stay_short() {
        let sizes = [4.5e6, 8.0 * f64::from(1 << 30), 7.5e12, 1e40].map(mebibytes);
        assert_eq!(sizes, ["4.3 MiB", "8.00 GiB", "6.82 TiB", "9.1e27 TiB"]);
    }
}
