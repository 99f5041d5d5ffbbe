//! The matrix of promises: random case files that switch every feature on and off, and a judge for every guarantee that the program prints.
//!
//! ```text
//! number ─ draw ─► case file ─ run (two settings) ─► report.json ─ judge ─► one verdict for each promise
//!                                   └─ cells halved ─► finer field, its intervals
//! ```
//! Rows are [`FEATURES`], columns [`Promise::ALL`]: a problem counts in the cell of each feature it has and each promise that was judged.
//! There are no reference values: what is true of one problem must agree. All intervals of one quantity of the exact solution have a point in
//! common, by whatever settings and on whatever nested meshes; two fields are not farther apart than both their bounds together; a finer
//! admissible field has not less energy than the bound allows. Some problems have linear solutions or forces that equilibrium gives.

mod bonded;
mod cuts;
mod draw;
mod held;
mod inside;
mod judge;
mod layouts;
mod runs;
mod settings;
mod springs;

use crate::model::Made;
use draw::Draw;
use layouts::Known;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use judge::{Promise, Verdict};

/// The features, in the order of the table.
pub const FEATURES: [&str; 89] = [
    "no contact",
    "one body",
    "two bodies",
    "three or more bodies",
    "floating body",
    "obstacle: fixed plane",
    "obstacle: circle",
    "obstacle: hollow circle",
    "obstacle: moved",
    "obstacle: driven by a force",
    "rigid side",
    "springs",
    "heat",
    "linear body force",
    "rotation or acceleration",
    "no friction",
    "friction: Tresca",
    "friction: Coulomb",
    "clamped end of a contact line",
    "held node of a contact line",
    "contact side held along itself",
    "corner of two pairs",
    "partial overlap",
    "meshes that match",
    "meshes that do not match",
    "bent contact line",
    "closed contact line",
    "declared arc",
    "declared smooth curve",
    "corner of one side",
    "torque on a pin",
    "given normal",
    "gap: none",
    "gap: number",
    "gap: expression",
    "gap: geometric",
    "interference: given",
    "interference: drawn",
    "interference: load steps",
    "load steps",
    "adaptive",
    "adaptive load steps",
    "subdomains",
    "subdomains: few iterations",
    "isotropic material",
    "orthotropic material",
    "given stiffness",
    "region of another material",
    "nearly incompressible",
    "contrast of moduli",
    "plane stress",
    "other units",
    "far from the origin",
    "body force",
    "roller along a normal",
    "part of a side",
    "side by its place",
    "mesh file",
    "slivers",
    "exact solution is linear",
    "method: auto",
    "method: nndd",
    "method: newton",
    "method: exact",
    "method: newton-nn",
    "programme",
    "imposed",
    "imposed of a pair",
    "theta",
    "weights: half",
    "acceleration",
    "initial λ",
    "no coarse space",
    "criterion: estimator",
    "criterion: precision",
    "criterion: eta_nndd",
    "force balance",
    "early stop",
    "fixed relaxation",
    "relaxation by tolerance",
    "estimate every iteration",
    "Coulomb steps",
    "labels of units",
    "limits",
    "bonded pair",
    "offset of a bond",
    "contact beside a bond",
    "cut: shortening",
    "cut: force",
];

/// One of this many problems has a corner of one side, one has a pin that may spin, and one has bonded bodies. They are not among the layouts, so that the other
/// problems keep their numbers.
const SELDOM: u64 = 30;
/// One of this many problems is a press fit, so that the other problems keep their numbers.
const PRESSED: u64 = 10;

/// The table of the keys and values of a case file, with the features that switch them on.
pub const KEYS: &str = include_str!("matrix/keys.toml");

/// A random problem, with two settings to solve it by.
pub struct Problem {
    /// Its number.
    pub number: u64,
    /// The features that are switched on.
    pub features: BTreeSet<&'static str>,
    /// The case file.
    pub text: String,
    /// The same with other settings; without load steps, if the last factors are 1.
    pub other: String,
    /// Mesh files with their names.
    pub files: Vec<(String, Vec<u8>)>,
    /// True if the exact problem is the same on halved cells.
    nested: bool,
    /// True if the second text states the same problem.
    comparable: bool,
    /// A typical force.
    load: f64,
    known: Known,
}

impl Problem {
    /// Draws the problem with a number.
    ///
    /// # Errors
    /// None.
    pub fn new(number: u64) -> Made<Self> {
        let mut d = Draw::new(1_000_003 * number + 17);
        // 8 to 2,000 cells in all.
        d.triangles = 8.0 * 250f64.powf(d.random.unit());
        let stepped = d.on(0.1, "load steps");
        let mut last = 1.0;
        if stepped {
            last = settings::load_steps(&mut d);
        }
        type Layout = fn(&mut Draw) -> Made<Known>;
        const LAYOUTS: [Layout; 17] = [
            layouts::blocks,
            layouts::blocks,
            layouts::blocks,
            layouts::blocks,
            layouts::blocks,
            layouts::pile,
            layouts::pile,
            layouts::column,
            layouts::column,
            layouts::corner_of_blocks,
            layouts::room,
            layouts::beam,
            layouts::pin,
            layouts::arcs,
            layouts::arcs,
            layouts::half_disc,
            layouts::alone,
        ];
        let layout = d.random.integer(0, LAYOUTS.len() - 1);
        d.presses = number % PRESSED == 3;
        let presses: [Layout; 4] = [layouts::blocks, layouts::blocks, layouts::arcs, layouts::pin];
        let mut known = match number % SELDOM {
            _ if d.presses => presses[layout % presses.len()](&mut d)?,
            7 => layouts::spun(&mut d)?,
            15 => layouts::kinked(&mut d)?,
            27 => bonded::layout(&mut d)?,
            _ => LAYOUTS[layout](&mut d)?,
        };
        if last != 1.0 {
            known = Known::default();
        }
        let bonded = d.features.contains("bonded pair");
        if known.torque.is_none() && !bonded && (springs::put(&mut d, number) | inside::put(&mut d, number)) {
            known = Known::default();
        }
        if known.torque.is_none() && cuts::put(&mut d, number)? {
            known = Known::default();
        }
        let slips = ["friction: Coulomb", "friction: Tresca"].iter().any(|law| d.features.contains(law));
        if known.torque.is_none() && !bonded && !slips && held::put(&mut d, number) {
            known = Known::default();
        }
        let has = |d: &Draw, feature| d.features.contains(feature);
        let coulomb = has(&d, "friction: Coulomb");
        let friction = coulomb || has(&d, "friction: Tresca");
        if !friction {
            d.mark("no friction");
        }
        if d.matching {
            d.mark("meshes that match");
        }
        d.mark(match d.count() {
            1 => "one body",
            2 => "two bodies",
            _ => "three or more bodies",
        });
        let allowed = settings::Allowed {
            held: d.count() == 2 && !has(&d, "floating body") && !has(&d, "obstacle: fixed plane"),
            coulomb,
            adapt: if stepped { 0.4 } else { 0.12 },
            contact: !has(&d, "no contact"),
        };
        let mut first = settings::draw(&mut d, allowed);
        let mut second = settings::draw(&mut d, settings::Allowed { adapt: 0.0, ..allowed });
        if has(&d, cuts::TIGHTENED) {
            // The exact solution alone finds the shortening.
            for of in [&mut first, &mut second] {
                of.retain(|(key, _)| !key.starts_with("solver."));
            }
        }
        if !friction {
            [&mut first, &mut second].into_iter().for_each(|of| settings::cut(&mut d, of));
        }
        let text = d.text(&first);
        if last == 1.0 && !friction {
            d.steps.clear();
        }
        let other = d.text(&second);
        let other = if d.steps.is_empty() { other.replace("name = \"push\"\n", "") } else { other };
        Ok(Self {
            number,
            text,
            other,
            nested: d.nested && !(friction && has(&d, "bent contact line")),
            comparable: !(coulomb || stepped && friction),
            known,
            load: d.stress * d.strain * d.length,
            features: d.features,
            files: d.files,
        })
    }

    /// Writes the case and its mesh files into a folder.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn write(&self, folder: &std::path::Path) -> Made<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("case.toml"), &self.text)?;
        std::fs::write(folder.join("other.toml"), &self.other)?;
        for (name, bytes) in &self.files {
            std::fs::write(folder.join(name), bytes)?;
        }
        Ok(())
    }
}

impl Problem {
    /// Solves the case with a few more lines, and returns `e_CRE`; `None` if there is no valid certificate.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn bound_with(&self, more: &str) -> Made<Option<f64>> {
        let folder = tempfile::tempdir()?;
        self.write(folder.path())?;
        let text = format!("{}\n{more}", self.text);
        let source = runs::CaseText { text, folder: folder.path().to_owned() };
        let done = runs::run(&source, &folder.path().join("out"), &mut runs::Quiet::new());
        let certificate = done.ok().and_then(|done| done.report.certificate);
        Ok(certificate.filter(|c| c.valid).and_then(|c| c.e_cre))
    }
}

/// A bound beside the distance to the solution on halved cells.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// `e_CRE`.
    pub bound: f64,
    /// The distance in the energy norm.
    pub distance: f64,
    /// Tells if the distance is far above the rounding of both fields.
    pub above_rounding: bool,
    /// The largest part of the bound.
    pub largest: &'static str,
}

/// The outcome of a problem.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its number.
    pub number: u64,
    /// The features that are switched on.
    pub features: BTreeSet<&'static str>,
    /// Triangles of all bodies, and of the body that has fewest.
    pub cells: [usize; 2],
    /// The exit status of the first run, and why it ended.
    pub code: u8,
    /// Its reason.
    pub reason: String,
    /// How often a problem was solved or certified.
    pub runs: usize,
    /// The bound beside a finer field.
    pub measured: Option<Measured>,
    /// The verdicts.
    pub verdicts: Vec<Verdict>,
}

impl Trial {
    /// Draws, runs and judges the problem with a number, in a folder of its own.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn new(number: u64) -> Made<Self> {
        let problem = Problem::new(number)?;
        let folder = tempfile::tempdir()?;
        problem.write(folder.path())?;
        let mut trial = Self {
            number,
            features: problem.features.clone(),
            cells: [0; 2],
            code: 0,
            reason: String::new(),
            runs: 0,
            measured: None,
            verdicts: Vec::new(),
        };
        // A panic is a defect of the program, and one of the verdicts.
        let judged =
            catch_unwind(AssertUnwindSafe(|| judge::judge(&problem, folder.path(), &mut trial).is_ok()));
        if judged.is_err() {
            let said = "panicked".to_owned();
            trial.verdicts.push(Verdict { promise: Promise::Status, holds: false, said });
        }
        Ok(trial)
    }

    /// Lists what is violated.
    pub fn violations(&self) -> impl Iterator<Item = &Verdict> {
        self.verdicts.iter().filter(|verdict| !verdict.holds)
    }
}
