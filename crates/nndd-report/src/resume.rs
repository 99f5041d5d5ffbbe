//! Checkpoints of adaptive runs: what is written during a run, and `--resume`.

use crate::failure::Failure;
use crate::words;
use case_io::case::Dimension;
use case_io::checkpoint::{self, Checkpoint, CheckpointError, FinerMesh, Progress};
use case_io::output::{OutputDirectory, Presence, ResultKind};
use case_io::{BrokenLink, Case};
use certified_contact::{RoleReason, Step};
use fem_core::interface::Roles;
use nndd::ActiveSet;
use nndd::Start;
use serde_json::{Value, json};
use std::path::Path;

/// The directory of a run, and the state from which it resumes.
pub struct RunDirectory {
    pub(crate) directory: OutputDirectory,
    /// How far it had come; `None` if no mesh had been solved.
    pub(crate) progress: Option<Progress>,
    resumed: bool,
    notes: Vec<String>,
}

impl RunDirectory {
    /// Opens the directory of a new run.
    ///
    /// * `force`: writes even if the directory contains something else.
    ///
    /// # Errors
    /// A directory that cannot be written to, or contains something else.
    pub fn open<S: Dimension>(case: &Case<S>, path: &Path, force: bool) -> Result<Self, Failure> {
        let directory = OutputDirectory::open(path, ResultKind::Solve, &case.hash(), force)?;
        Ok(Self { directory, progress: None, resumed: false, notes: Vec::new() })
    }

    /// Copies what a run has written in another place so far: the fields of its earlier meshes or load steps, and its checkpoints.
    ///
    /// # Errors
    /// Files that cannot be read or written.
    pub fn copy_from(&mut self, run: &RunDirectory) -> Result<(), Failure> {
        Ok(self.directory.copy_from(&run.directory)?)
    }

    /// Finds the interrupted adaptive run of a case in a directory.
    ///
    /// # Errors
    /// A case without an adaptive run, and a directory without a checkpoint of this case.
    pub fn resume<S: Dimension>(case: &Case<S>, path: &Path) -> Result<Self, Failure> {
        find(case, path)
    }

    /// Returns what is worth knowing about the state from which the run resumes.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the mesh on which a resumed run begins, from 1.
    pub(crate) fn resumed_on(&self) -> Option<usize> {
        self.resumed.then(|| self.progress.as_ref().map_or(1, |p| p.meshes.len() + 1))
    }

    pub(crate) fn presence(&self) -> Presence {
        self.directory.presence()
    }
}

/// Returns the settings that must be the same to resume a run: the case, the version of this program, which its numbers
/// depend on, and `output.vtu`, since ParaView files of earlier meshes cannot be written later.
fn identity<S: Dimension>(case: &Case<S>) -> Value {
    let mut identity = case.identity();
    identity["output"] = json!({ "vtu": case.output.vtu });
    identity["program"] = env!("CARGO_PKG_VERSION").into();
    identity
}

/// Finds the interrupted run of a case in a directory.
fn find<S: Dimension>(case: &Case<S>, path: &Path) -> Result<RunDirectory, Failure> {
    if case.adapt.is_none() {
        return Err(Failure::command_line(format!(
            "--resume continues adaptive runs only, and {} has no [adapt]: run it again without --resume",
            case.file_name()
        )));
    }
    // A broken link is reported below.
    if !path.is_dir() && BrokenLink::find(path).is_none() {
        return Err(CheckpointError::NeverStarted { directory: path.to_owned() }.into());
    }
    let mut directory = OutputDirectory::reopen(path)?;
    directory.restore_checkpoints();
    let (Checkpoint { case: old, progress }, damage) = checkpoint::read(path)?;
    let differences = checkpoint::differences(&old, &identity(case));
    if !differences.is_empty() {
        return Err(Failure::invalid(format!(
            "the checkpoint in {} is of another case: {}.\n  expected: the case as it was, but for the title, [limits] and \
             output.directory\n  fix: undo the change, or start again with --force instead of --resume",
            path.display(),
            differences.join("; ")
        )));
    }
    let mesh = progress.as_ref().map_or(1, |p| p.meshes.len() + 1);
    let mut notes = vec![format!("the run continues with mesh {mesh}")];
    if let Some(damage) = damage {
        // Otherwise it would replace the intact one.
        directory.remove(checkpoint::NEWEST)?;
        notes.insert(0, damage);
    }
    Ok(RunDirectory { directory, progress, resumed: true, notes })
}

/// Prepares the directory: a new run writes its first checkpoint, a resumed one keeps what it has.
pub(crate) fn prepare<S: Dimension>(case: &Case<S>, place: &mut RunDirectory) -> Result<(), Failure> {
    let Some(progress) = &place.progress else {
        checkpoint::remove(&mut place.directory)?;
        let first = Checkpoint { case: identity(case), progress: None };
        return Ok(checkpoint::write(&mut place.directory, &first)?);
    };
    for name in [checkpoint::NEWEST, checkpoint::PREVIOUS] {
        place.directory.keep(name);
    }
    for step in 1..=progress.steps.len() {
        words::parts(case).iter().for_each(|part| place.directory.keep(&words::step_file(part, step)));
    }
    Ok(())
}

/// Says that a run which could not write can be resumed, if it has solved a mesh.
///
/// Its checkpoints are set aside, so that another run may begin there.
pub(crate) fn after_failure(mut failure: Failure, directory: &mut OutputDirectory) -> Failure {
    if directory.set_checkpoints_aside()
        && let Some(message) = &mut failure.message
    {
        message.push_str("; then --resume continues the run");
    }
    failure
}

/// Writes the checkpoint of a run.
///
/// * `seconds`: when each of its meshes had been solved.
pub(crate) fn write<S: Dimension>(
    case: &Case<S>,
    from: &certified_contact::Checkpoint,
    seconds: &[f64],
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    let compliance = match from.role_reason {
        RoleReason::Given => None,
        RoleReason::Stiffer { compliance } => Some(compliance),
    };
    let mesh = |mesh: &certified_contact::FinerMesh| FinerMesh {
        rounds: mesh.rounds.clone(),
        lambda: mesh.start.lambda.clone(),
        active: mesh.start.active.as_ref().map(|active| active.as_slice().to_vec()),
    };
    let step = |(step, &seconds): (&Step, &f64)| checkpoint::Step {
        nodes: step.nodes,
        pairs: step.pairs,
        load_step: step.load_step,
        e_cre: step.e_cre,
        relative: step.relative,
        certified: step.certified,
        e_b: step.e_b,
        relative_residual: step.relative_residual,
        iterations: step.iterations,
        energy_norm_squared: step.energy_norm_squared,
        peak_stress: step.peak_stress,
        seconds,
    };
    let progress = Progress {
        imposed: from.roles.iter().map(|roles| roles.imposed()).collect(),
        compliance,
        meshes: from.meshes.iter().map(mesh).collect(),
        steps: from.history.iter().zip(seconds).map(step).collect(),
    };
    let checkpoint = Checkpoint { case: identity(case), progress: Some(progress) };
    Ok(checkpoint::write(directory, &checkpoint)?)
}

/// Makes the library's values of a checkpoint.
pub(crate) fn read(progress: &Progress) -> certified_contact::Checkpoint {
    let mesh = |mesh: &FinerMesh| certified_contact::FinerMesh {
        rounds: mesh.rounds.clone(),
        start: Start { lambda: mesh.lambda.clone(), active: mesh.active.clone().map(ActiveSet::new) },
    };
    let step = |(k, step): (usize, &checkpoint::Step)| Step {
        step: k + 1,
        nodes: step.nodes,
        pairs: step.pairs,
        load_step: step.load_step,
        e_cre: step.e_cre,
        relative: step.relative,
        certified: step.certified,
        e_b: step.e_b,
        relative_residual: step.relative_residual,
        iterations: step.iterations,
        energy_norm_squared: step.energy_norm_squared,
        peak_stress: step.peak_stress,
    };
    certified_contact::Checkpoint {
        roles: progress
            .imposed
            .iter()
            .map(|side| if *side == 0 { Roles::FIRST } else { Roles::SECOND })
            .collect(),
        role_reason: progress
            .compliance
            .map_or(RoleReason::Given, |compliance| RoleReason::Stiffer { compliance }),
        meshes: progress.meshes.iter().map(mesh).collect(),
        history: progress.steps.iter().enumerate().map(step).collect(),
    }
}
