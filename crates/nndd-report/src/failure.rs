//! Why a run ended without a result: an exit status and messages.

use crate::compare::CompareError;
use crate::motion;
use case_io::case::Dimension;
use case_io::checkpoint::CheckpointError;
use case_io::diagnostic::{Diagnostic, code, significant};
use case_io::output::OutputError;
use case_io::report::ReportError;
use case_io::table::TableError;
use case_io::{BrokenLink, Case, CaseError, SourcePosition};
use certified_contact::SolveError;
use contact_qp::QpError;
use cre_estimator::EstimatorError;
use fem_core::assembly::AssemblyError;
use fem_core::cholesky::CholeskyError;
use fem_core::condensation::CondensationError;
use fem_core::geometry::shown;
use fem_core::interface::LoadFactorError;
use fem_core::prepared::{AssemblyMotion, PrepareError};
use mesh_io::{MeshFault, MeshFileError};
use nndd::NnddError;
use std::io;
use std::path::Path;

/// Why a run ended without a result.
#[derive(Debug)]
#[non_exhaustive]
pub struct Failure {
    /// Exit status.
    pub code: u8,
    /// The messages, each with its place if there is one.
    pub diagnostics: Vec<Diagnostic>,
    /// The message that has no place.
    pub message: Option<String>,
}

/// One thing that is wrong, in its parts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Finding {
    /// The place of the error, if it is in a case.
    pub place: Option<SourcePosition>,
    /// The value or fact that is wrong.
    pub found: String,
    /// The value or fact expected there.
    pub expected: Option<String>,
    /// One fix.
    pub fix: Option<String>,
}

/// Exit status: a defect of this program.
pub const DEFECT: u8 = 1;
/// Exit status: a wrong command line, or wrong arguments of a call.
pub const COMMAND_LINE: u8 = 2;
/// Exit status: invalid input.
pub const INVALID_INPUT: u8 = 3;
/// Exit status: no unique solution.
pub const NO_UNIQUE_SOLUTION: u8 = 4;
/// Exit status: a target that was missed, or a certificate that is not valid.
pub const NOT_CERTIFIED: u8 = 6;
/// Exit status: something cannot be read or written.
pub const FILES: u8 = 7;
/// Exit status: too little memory or time.
pub const LIMIT: u8 = 8;
/// Exit status: ended from outside, it is not known how.
pub(crate) const INTERRUPTED: u8 = 130;

impl Failure {
    /// Makes one without a place.
    pub fn plain(code: u8, message: impl Into<String>) -> Self {
        Self { code, diagnostics: Vec::new(), message: Some(message.into()) }
    }

    /// Lists what is wrong, each in its parts.
    pub fn findings(&self) -> Vec<Finding> {
        let of_case = self.diagnostics.iter().map(|diagnostic| Finding {
            place: diagnostic.place.clone(),
            found: diagnostic.message.clone(),
            expected: diagnostic.expected.clone(),
            fix: diagnostic.help.clone(),
        });
        let of_text = self.message.iter().map(|text| {
            let (rest, fix) = parted(text, "\n  fix: ");
            let (found, expected) = parted(rest, "\n  expected: ");
            Finding { place: None, found: found.to_owned(), expected, fix }
        });
        of_case.chain(of_text).collect()
    }

    /// Makes it one of the command line, wherever it was found.
    pub(crate) fn on_command_line(self) -> Self {
        Self { code: COMMAND_LINE, ..self }
    }

    /// Makes one of a wrong command line, or of wrong arguments of a call.
    pub fn command_line(message: impl Into<String>) -> Self {
        Self::plain(COMMAND_LINE, message)
    }

    /// Says that an option of the command line gave a setting.
    pub(crate) fn given_by(mut self, option: &str, key: &str, value: &str) -> Self {
        self.diagnostics.iter_mut().for_each(|diagnostic| diagnostic.given_by(option, key, value));
        self
    }

    pub(crate) fn defect(message: impl Into<String>) -> Self {
        Self::plain(DEFECT, message)
    }

    /// Makes the failure for a problem whose numbers overflow.
    pub(crate) fn overflow(error: &dyn std::error::Error) -> Self {
        Self::invalid(format!(
            "{error}\n  expected: coordinates, moduli and loads of which sums of squares are finite\n  fix: check their units"
        ))
    }

    /// Makes the failure of a run that would take more than it may.
    pub fn limit(message: impl Into<String>) -> Self {
        Self::plain(LIMIT, message)
    }

    /// Makes the failure of an invalid input: what was found, what was expected, and one fix, a line each.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::plain(INVALID_INPUT, message)
    }

    fn no_unique_solution(why: String) -> Self {
        Self::plain(NO_UNIQUE_SOLUTION, format!("no unique solution: {why}"))
    }

    pub(crate) fn unreadable(path: &Path, error: &io::Error) -> Self {
        if let Some(link) = BrokenLink::find(path) {
            let (name, fix) = (path.display(), BrokenLink::FIX);
            let found = format!("cannot read {name}: {} {link}", link.link.display());
            return Self::plain(FILES, format!("{found}\n  expected: a case file\n  fix: {fix}"));
        }
        let (path, folder) = (path.display(), path.is_dir());
        let fix = match error.kind() {
            _ if folder => format!("name the file in it, such as {path}/case.toml"),
            io::ErrorKind::NotFound => format!("check the path, or begin one with `nndd new paper > {path}`"),
            io::ErrorKind::PermissionDenied => "allow this user to read it".to_owned(),
            _ => "name a case file; `nndd new paper` prints one".to_owned(),
        };
        Self::plain(FILES, format!("cannot read {path}: {error}\n  expected: a case file\n  fix: {fix}"))
    }

    /// Says which bodies nothing holds, how they move, and the load.
    fn not_held<S: Dimension>(case: &Case<S>, motion: &AssemblyMotion<S>) -> Self {
        let moves = motion.bodies.iter().map(|(b, moved)| {
            format!("{} is not held: it {}", motion::member(case, *b), motion::moves(moved))
        });
        let moves = moves.collect::<Vec<_>>().join("; ");
        if !motion.load.is_finite() {
            return Self::invalid(
                "the loads are so large that the work of their sum overflows\n  expected: loads whose squares are finite numbers\n  \
                 fix: check the units of the loads",
            );
        }
        Self::no_unique_solution(format!(
            "{moves} (load {} in that direction, nothing resists)\n  expected: supports or contacts that \
                 resist every motion that a load causes\n  fix: add a [[body.displacement]] or a [[contact]] that prevents this \
                 motion, or change the load",
            significant(motion.load)
        ))
    }

    /// Says why a body has no solution, with its name.
    fn prepare<S: Dimension>(case: &Case<S>, error: &PrepareError) -> Self {
        let name = |body: usize| &case.bodies[body].name;
        match error {
            PrepareError::Assembly { body, source: AssemblyError::Floating { motion } } => {
                Self::no_unique_solution(format!(
                    "body \"{}\" {motion} (piece at ({}, {})).\n  expected: supports that hold \
                     every rigid motion of each body on its own, without the contact\n  fix: add a [[body.displacement]] \
                     to \"{}\" that prevents this motion",
                    name(*body),
                    shown(motion.near()[0]),
                    shown(motion.near()[1]),
                    name(*body)
                ))
            }
            PrepareError::Assembly { body, source } => {
                use AssemblyError::{NothingUnknown, OutOfMemory, TooLarge};
                let fault = format!("body \"{}\": {source}", name(*body));
                match source {
                    TooLarge { .. } | OutOfMemory { .. } => Self::limit(fault),
                    NothingUnknown => Self::invalid(format!(
                        "{fault}\n  expected: nodes that can move\n  fix: hold fewer sides, or make the mesh finer"
                    )),
                    _ => Self::invalid(format!(
                        "{fault}\n  expected: coordinates, moduli and loads of which sums of squares are finite\n  fix: check their \
                             units, and the points about which rigid sides rotate"
                    )),
                }
            }
            PrepareError::Factor { body, source: CondensationError::Cholesky { source, .. } }
                if matches!(source, CholeskyError::OutOfMemory { .. }) =>
            {
                Self::limit(format!("body \"{}\": {source}", name(*body)))
            }
            PrepareError::Factor { body, source: source @ CondensationError::OutOfMemory { .. } } => {
                Self::limit(format!("body \"{}\": {source}", name(*body)))
            }
            PrepareError::Factor { body, source } => Self::no_unique_solution(format!(
                "body \"{}\": {source}.\n  expected: supports and materials that leave no motion \
                     nearly free\n  fix: support the body at points farther apart, or lower Poisson's ratio to 0.49",
                name(*body)
            )),
            PrepareError::ContactAcrossCut { .. } => Self::invalid(error.to_string()),
            other => Self::defect(other.to_string()),
        }
    }

    /// Says why a solve made no sense, with the body's name.
    pub(crate) fn solve<S: Dimension>(case: &Case<S>, error: &SolveError<S>) -> Self {
        match error {
            SolveError::Prepare(error) => Self::prepare(case, error),
            SolveError::LoadStep { step, error } => {
                let mut failure = Self::solve(case, error);
                failure.message = failure.message.map(|message| format!("load step {step}: {message}"));
                failure
            }
            SolveError::Estimator(source @ EstimatorError::OutOfMemory { .. }) => {
                Self::limit(source.to_string())
            }
            SolveError::CutForce { name, force, found, shortening } => Self::no_unique_solution(format!(
                "no shortening up to the size of the body gives the force {} in the cut \"{name}\"; at {} it is {}, off by {}\n  expected: a \
                 bolt both of whose ends are held against the force, for example by a contact that it closes, and no other cut or load that \
                 determines its force\n  fix: check the sign of the force, which pulls if it is positive, its unit, and the contact of the \
                 head; or give a `shortening`",
                significant(*force),
                significant(*shortening),
                significant(*found),
                significant(found - force)
            )),
            SolveError::CutMethod { name } => Self::invalid(format!(
                "the force in the cut \"{name}\" is given, which needs the exact solution without Coulomb friction\n  expected: \
                 method = \"auto\" or \"exact\" without settings of the iteration, and no pair with Coulomb friction\n  fix: leave \
                 solver.method, theta, weights and acceleration out, or give a `shortening`"
            )),
            SolveError::Subdomains { with } => Self::invalid(format!(
                "bodies in subdomains do not go with {with}\n  expected: method = \"newton-nn\" or \"auto\" without settings of the iteration, and \
                 contact without friction\n  fix: take solver.subdomains out, or write 1"
            )),
            SolveError::NotHeld { motion } => Self::not_held(case, motion),
            SolveError::OutsideCones { motion } => Self::no_unique_solution(format!(
                "the load is not balanced within the friction cones: {} (load {} in that direction, which no contact forces with \
                 |q| <= mu p resist)\n  expected: loads that contact forces with |q| <= mu p balance\n  fix: raise mu, add a \
                 [[body.displacement]] that holds the body, or change the load",
                motion::all_move(case, motion),
                significant(motion.load)
            )),
            SolveError::Estimator(
                source @ (EstimatorError::NotFinite { .. }
                | EstimatorError::TooSmall { .. }
                | EstimatorError::Balance(QpError::NotFinite { .. })),
            ) => Self::overflow(source),
            SolveError::Nndd(source @ NnddError::Qp(QpError::NotFinite { .. })) => Self::overflow(source),
            SolveError::Bonds(e) => Self::invalid(e.to_string()),
            SolveError::Nndd(e @ (NnddError::DependentRows { .. } | NnddError::WithinABody { .. })) => {
                Self::invalid(format!(
                    "{e}\n  expected: a problem that the iteration can solve\n  fix: leave solver.method out, or use \
                     method = \"exact\""
                ))
            }
            SolveError::Nndd(e @ (NnddError::Theta { .. } | NnddError::Lambda { .. })) => {
                Self::invalid(e.to_string())
            }
            SolveError::Factors(e) => {
                let fault = match e {
                    LoadFactorError::Body { body, source } => {
                        format!("body \"{}\": {source}", case.bodies[*body].name)
                    }
                    other => other.to_string(),
                };
                Self::invalid(format!(
                    "{fault}, with the factors of a load step\n  expected: conditions that agree where they meet, whatever the \
                         factors are\n  fix: give conditions that meet the same name, or impose them on one list of sides"
                ))
            }
            SolveError::Checkpoint { .. } => Self::invalid(error.to_string()),
            other => Self::defect(other.to_string()),
        }
    }
}

/// Splits a text at a mark.
fn parted<'a>(text: &'a str, mark: &str) -> (&'a str, Option<String>) {
    text.split_once(mark).map_or((text, None), |(before, after)| (before, Some(after.to_owned())))
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        let (expected, fix) = match &error {
            OutputError::NotADirectory { .. } => ("a directory", "choose another with --out"),
            OutputError::BrokenLink { .. } => {
                ("a directory", "create what the link points to, or choose another with --out")
            }
            OutputError::Link { .. } => {
                ("a directory of results without links", "remove the link, or choose another with --out")
            }
            OutputError::Locked { .. } => {
                ("a directory that no other run uses", "wait for it, or choose another with --out")
            }
            OutputError::Unfinished { .. } => {
                ("an empty directory or a result", "continue it with --resume, or start again with --force")
            }
            OutputError::NotOurs { .. } => (
                "an empty directory or a result of this case",
                "choose another with --out, or write anyway with --force",
            ),
            OutputError::OtherCase { .. } => (
                "an empty directory or a result of this case",
                "choose another with --out, or replace it with --force",
            ),
            OutputError::Io { source, .. } if source.kind() == io::ErrorKind::PermissionDenied => {
                ("a directory that this user may write to", "allow it, or choose another with --out")
            }
            OutputError::Vanished { .. } => {
                ("the directory to stay until the run has ended", "run the case again")
            }
            OutputError::Io { what: "create" | "write" | "lock", source, .. }
                if source.kind() == io::ErrorKind::FileTooLarge =>
            {
                ("files of any size", "raise the limit of the file size (ulimit -f)")
            }
            OutputError::Io { what: "create" | "write" | "lock", .. } => {
                ("a directory that can be written to", "choose another with --out, or free space")
            }
            _ => return Self::plain(FILES, error.to_string()),
        };
        Self::plain(FILES, format!("{error}\n  expected: {expected}\n  fix: {fix}"))
    }
}

impl From<CheckpointError> for Failure {
    fn from(error: CheckpointError) -> Self {
        let fix = match &error {
            CheckpointError::NeverStarted { .. } | CheckpointError::Finished { .. } => {
                "run the case without --resume"
            }
            CheckpointError::Damaged { .. } => "run the case without --resume, with --force",
            _ => return Self::plain(FILES, error.to_string()),
        };
        Self::plain(FILES, format!("{error}\n  expected: a checkpoint of an unfinished run\n  fix: {fix}"))
    }
}

impl From<CaseError> for Failure {
    fn from(error: CaseError) -> Self {
        let message = (error.omitted > 0).then(|| format!("and {} more", error.omitted));
        let unreadable = error.diagnostics.iter().any(|d| d.code == code::UNREADABLE);
        let code = if unreadable { FILES } else { INVALID_INPUT };
        Self { code, diagnostics: error.diagnostics, message }
    }
}

impl From<MeshFileError> for Failure {
    fn from(error: MeshFileError) -> Self {
        let code = if error.fault == MeshFault::Unreadable { FILES } else { INVALID_INPUT };
        Self { code, diagnostics: vec![Diagnostic::of_mesh_file(error, None)], message: None }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::plain(FILES, error.to_string())
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            // Products of extreme data overflow in the results at the latest.
            ReportError::NotFinite { .. } => Self::overflow(&error),
            other => Self::defect(other.to_string()),
        }
    }
}

impl From<CompareError> for Failure {
    fn from(error: CompareError) -> Self {
        let (code, expected, fix) = match &error {
            CompareError::Unreadable { .. } => (
                FILES,
                "the folder of a run that has ended",
                "name the folder that `nndd solve` wrote, such as runs/paper",
            ),
            CompareError::NotAReport { .. } | CompareError::OtherSchema { .. } => {
                (FILES, "a report of this program", "solve the case again with this version of nndd")
            }
            CompareError::OtherBodies { .. } => (
                INVALID_INPUT,
                "the same bodies in the same order",
                "compare two runs of one case, with other settings",
            ),
        };
        Self::plain(code, format!("{error}\n  expected: {expected}\n  fix: {fix}"))
    }
}

impl From<TableError> for Failure {
    fn from(error: TableError) -> Self {
        match error {
            TableError::NotFinite { .. } => Self::overflow(&error),
            other => Self::defect(other.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_listed_in_its_parts() {
        let failure = Failure::plain(LIMIT, "too large\n  expected: less\n  fix: take fewer cells");
        let [finding] = &failure.findings()[..] else { panic!("one finding") };
        assert_eq!((finding.found.as_str(), finding.expected.as_deref()), ("too large", Some("less")));
        assert_eq!(finding.fix.as_deref(), Some("take fewer cells"));
        assert!(Failure::plain(DEFECT, "alone").findings()[0].fix.is_none());
        let case = Case::parse("schema = 1\ntitle = 3\n", "a.toml", &[]).unwrap_err();
        let listed = Failure::from(case).findings();
        assert!(listed.len() > 1 && listed[0].place.as_ref().is_some_and(|place| place.file() == "a.toml"));
    }
}
