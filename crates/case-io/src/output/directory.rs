//! The directory of results that one run writes to.

use super::inspect::{BELOW, Before, inspect, is_result};
use super::lock::{LOCK_FILE, Lock, is_at};
use super::{CHECKPOINT, CHECKPOINT_BEFORE, OutputError, ResultKind, STAGING, TEMPORARY, failed, write_file};
use mesh_io::BrokenLink;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// A directory of results that this run alone writes to.
///
/// Files are collected in a hidden directory below it. [`OutputDirectory::finish`] puts them in their places and removes
/// what an earlier result had and this one has not. If the value is dropped without that, the directory is as it was before.
#[derive(Debug)]
pub struct OutputDirectory {
    path: PathBuf,
    presence: Presence,
    before: Before,
    written: BTreeSet<PathBuf>,
    /// Directories that this run created, the innermost first.
    created: Vec<PathBuf>,
    /// True if the collected files stay when the value is dropped, for a run that is resumed.
    keeps_collected: bool,
    /// Dropping it releases the lock.
    lock: Option<Lock>,
}

/// Tells whether a directory is still the one that a run opened.
#[derive(Clone, Debug)]
pub struct Presence {
    path: PathBuf,
    /// Open, so that no other directory gets its number. `None` if the system does not open directories.
    opened: Option<Arc<File>>,
}

impl Presence {
    fn of(path: &Path) -> Self {
        Self { path: path.to_owned(), opened: File::open(path).ok().map(Arc::new) }
    }

    /// Returns the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Says whether the directory is still there, and is not another one of that name.
    pub fn lasts(&self) -> bool {
        match &self.opened {
            Some(opened) => is_at(opened, &self.path),
            None => self.path.is_dir(),
        }
    }
}

impl OutputDirectory {
    /// Opens a directory for the results of one case, and locks it.
    ///
    /// A missing or empty directory is fine. A result of the same case will be replaced, unless a checkpoint lies beside it,
    /// with which its run could be resumed. Anything else is refused, unless `force` is given.
    ///
    /// * `case_hash`: [`crate::Case::hash`] or what else names the case, compared with the one on record.
    ///
    /// # Errors
    /// See [`OutputError`]; nothing has been changed then.
    pub fn open(path: &Path, kind: ResultKind, case_hash: &str, force: bool) -> Result<Self, OutputError> {
        if let Some(link) = BrokenLink::find(path) {
            return Err(OutputError::BrokenLink { link });
        }
        if path.exists() && !path.is_dir() {
            return Err(OutputError::NotADirectory { path: path.to_owned() });
        }
        let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists());
        let mut directory = Self::new(path, missing.map(Path::to_owned).collect());
        fs::create_dir_all(path).map_err(failed("create", path))?;
        directory.presence = Presence::of(path);
        directory.lock = Some(Lock::take(path)?);
        if let Err(link) = directory.without_links() {
            directory.keeps_collected = true;
            return Err(link);
        }
        directory.before = match inspect(path, kind, case_hash)? {
            Ok(before) => before,
            Err(_) if force && ResultKind::ALL.iter().any(|k| path.join(k.record()).is_file()) => {
                Before::OtherCase
            }
            Err(_) if force => Before::Foreign,
            Err(refusal) => {
                directory.keeps_collected = true;
                return Err(refusal);
            }
        };
        directory.remove_temporaries()?;
        Ok(directory)
    }

    /// Opens a directory in which a run of the same case is resumed, and locks it.
    ///
    /// # Errors
    /// No directory, or another run in it.
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        if let Some(link) = BrokenLink::find(path) {
            return Err(OutputError::BrokenLink { link });
        }
        if !path.is_dir() {
            return Err(OutputError::NotADirectory { path: path.to_owned() });
        }
        let mut directory = Self::new(path, Vec::new());
        directory.keeps_collected = true;
        directory.lock = Some(Lock::take(path)?);
        directory.without_links()?;
        let staging = path.join(STAGING);
        if is_link(&staging) {
            return Err(OutputError::Link { path: staging });
        }
        directory.before = Before::SameCase;
        Ok(directory)
    }

    fn new(path: &Path, created: Vec<PathBuf>) -> Self {
        Self {
            path: path.to_owned(),
            presence: Presence::of(path),
            before: Before::Nothing,
            written: BTreeSet::new(),
            created,
            keeps_collected: false,
            lock: None,
        }
    }

    /// Returns the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the value that can tell whether the directory is still there.
    pub fn presence(&self) -> Presence {
        self.presence.clone()
    }

    /// Says whether an earlier result is being replaced.
    pub(crate) fn replaces_a_result(&self) -> bool {
        matches!(self.before, Before::SameCase | Before::OtherCase)
    }

    /// Returns what was written so far, relative to the directory, in alphabetical order.
    pub fn written(&self) -> impl Iterator<Item = &Path> {
        self.written.iter().map(PathBuf::as_path)
    }

    /// Writes one file; directories in its name are created.
    ///
    /// * `name`: relative to the directory, such as `figures/history.svg`.
    ///
    /// # Errors
    /// A name that leads elsewhere, and what the operating system reports.
    pub fn write(&mut self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        self.write_with(name, |out| out.write_all(content))
    }

    /// Writes one file piece by piece, see [`OutputDirectory::write`].
    ///
    /// # Errors
    /// See [`OutputDirectory::write`]; and what the closure reports.
    pub fn write_with(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let relative = Path::new(name);
        let plain = relative.components().all(|c| matches!(c, Component::Normal(_)));
        if name.is_empty() || !plain || relative.file_name() == Some(OsStr::new(LOCK_FILE)) {
            return Err(OutputError::Name { name: name.to_owned() });
        }
        self.check_presence()?;
        let path = self.collected(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed("write", parent))?;
        }
        write_file(&path, content).map_err(|error| match error {
            OutputError::Io { what, source, .. } => {
                OutputError::Io { what, path: self.path.join(relative), source }
            }
            other => other,
        })?;
        self.written.insert(relative.to_owned());
        Ok(())
    }

    /// Writes copies of the files that another run has written so far, its checkpoints among them.
    ///
    /// # Errors
    /// See [`OutputDirectory::write`].
    pub fn copy_from(&mut self, other: &OutputDirectory) -> Result<(), OutputError> {
        for name in &other.written {
            let places = [other.collected(name), other.path.join(name)];
            let Some(from) = places.iter().find(|path| path.is_file()) else { continue };
            self.write_with(&name.to_string_lossy(), |out| {
                io::copy(&mut File::open(from)?, out).map(|_| ())
            })?;
        }
        Ok(())
    }

    /// Renames a file to an older name, if it is there, and writes it at its place at once, not at the end of the run.
    ///
    /// * `pieces`: the content, one after the other.
    ///
    /// # Errors
    /// See [`OutputDirectory::write`].
    pub(crate) fn write_after_renaming(
        &mut self,
        name: &str,
        older: &str,
        pieces: &[&[u8]],
    ) -> Result<(), OutputError> {
        self.check_presence()?;
        let (path, to) = (self.path.join(name), self.path.join(older));
        match fs::rename(&path, &to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(failed("rename", &path)(error));
            }
            Err(_) => {}
            Ok(()) => {
                self.written.insert(PathBuf::from(older));
            }
        }
        write_file(&path, |out| pieces.iter().try_for_each(|piece| out.write_all(piece)))?;
        // An earlier one that was collected is out of date.
        remove(&self.collected(Path::new(name)))?;
        self.written.insert(PathBuf::from(name));
        Ok(())
    }

    /// Counts a file that an earlier part of this run wrote as one of this run.
    pub fn keep(&mut self, name: &str) {
        let relative = Path::new(name);
        if self.collected(relative).is_file() || self.path.join(relative).is_file() {
            self.written.insert(relative.to_owned());
        }
    }

    /// Removes a file that this run may have written, if it is there.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn remove(&mut self, name: &str) -> Result<(), OutputError> {
        let relative = Path::new(name);
        self.written.remove(relative);
        remove(&self.collected(relative))?;
        remove(&self.path.join(relative))
    }

    /// Puts the checkpoints of a run that failed among its collected files, and keeps these: the run can be resumed, and
    /// another one may begin here. Returns false if there is no checkpoint; then nothing is kept.
    pub fn set_checkpoints_aside(&mut self) -> bool {
        let there = [CHECKPOINT, CHECKPOINT_BEFORE].iter().any(|name| self.path.join(name).is_file());
        if there && self.presence.lasts() {
            let _ = fs::create_dir_all(self.collected(Path::new("")));
            self.move_checkpoints(Self::collected, |directory, name| directory.path.join(name));
            self.keeps_collected = true;
        }
        there
    }

    /// Puts checkpoints that were set aside back in their places.
    pub fn restore_checkpoints(&mut self) {
        self.move_checkpoints(|directory, name| directory.path.join(name), Self::collected);
    }

    /// Moves both checkpoints, as far as that is possible: one that stays where it is does no harm.
    fn move_checkpoints(&self, to: fn(&Self, &Path) -> PathBuf, from: fn(&Self, &Path) -> PathBuf) {
        for name in [CHECKPOINT_BEFORE, CHECKPOINT].map(Path::new) {
            let _ = fs::rename(from(self, name), to(self, name));
        }
    }

    /// Ends a run: puts its files in their places, the record last, and removes the files of the result that it replaces.
    /// Files that are not this program's stay.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.check_presence()?;
        let places: Vec<&PathBuf> =
            self.written.iter().filter(|name| self.collected(name).is_file()).collect();
        // Steps that may still fail come first, while the earlier result is complete.
        self.without_links()?;
        for parent in places.iter().filter_map(|name| name.parent()) {
            let parent = self.path.join(parent);
            fs::create_dir_all(&parent).map_err(failed("create", &parent))?;
        }
        if let Some(taken) = places.iter().map(|name| self.path.join(name)).find(|path| path.is_dir()) {
            let error = io::Error::from(io::ErrorKind::IsADirectory);
            return Err(failed("write", &taken)(error));
        }
        if self.before == Before::OtherCase {
            // Half of one case beside the record of another would be taken for a complete result.
            for kind in ResultKind::ALL {
                remove(&self.path.join(kind.record()))?;
            }
        }
        let is_record = |name: &Path| ResultKind::ALL.iter().any(|kind| Path::new(kind.record()) == name);
        let (records, others): (Vec<_>, Vec<_>) = places.into_iter().partition(|name| is_record(name));
        for name in others.into_iter().chain(records) {
            let path = self.path.join(name);
            fs::rename(self.collected(name), &path).map_err(failed("write", &path))?;
        }
        self.keeps_collected = false;
        if self.replaces_a_result() {
            for directory in [""].iter().chain(&BELOW) {
                self.remove_old(Path::new(directory))?;
            }
        }
        Ok(())
    }

    /// The place of a file until the end of the run.
    fn collected(&self, name: &Path) -> PathBuf {
        self.path.join(STAGING).join(name)
    }

    /// Refuses directories for results that are links: files would be written and removed in another directory.
    fn without_links(&self) -> Result<(), OutputError> {
        match BELOW.iter().map(|below| self.path.join(below)).find(|path| is_link(path)) {
            Some(path) => Err(OutputError::Link { path }),
            None => Ok(()),
        }
    }

    fn check_presence(&self) -> Result<(), OutputError> {
        if self.presence.lasts() { Ok(()) } else { Err(OutputError::Vanished { path: self.path.clone() }) }
    }

    /// Removes what killed runs left behind.
    fn remove_temporaries(&self) -> Result<(), OutputError> {
        for entry in fs::read_dir(&self.path).map_err(failed("read", &self.path))? {
            let path = entry.map_err(failed("read", &self.path))?.path();
            if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(TEMPORARY)) {
                let removed = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
                removed.map_err(failed("remove", &path))?;
            }
        }
        Ok(())
    }

    fn remove_old(&self, below: &Path) -> Result<(), OutputError> {
        let directory = self.path.join(below);
        if !directory.is_dir() {
            return Ok(());
        }
        for entry in fs::read_dir(&directory).map_err(failed("read", &directory))? {
            let entry = entry.map_err(failed("read", &directory))?;
            let relative = below.join(entry.file_name());
            let is_file = entry.file_type().is_ok_and(|t| t.is_file());
            if is_file && is_result(below, &entry.file_name()) && !self.written.contains(&relative) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }
}

impl Drop for OutputDirectory {
    fn drop(&mut self) {
        // Nothing can be done about a failure here; what is left does not count as content.
        let lasts = self.presence.lasts();
        if self.lock.is_some() && !self.keeps_collected && lasts {
            let _ = fs::remove_dir_all(self.path.join(STAGING));
        }
        self.lock = None;
        if !lasts {
            // Another one of the same name is not this run's.
            return;
        }
        // Only an empty directory can be removed like this.
        let _ = self.created.iter().try_for_each(fs::remove_dir);
    }
}

fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink())
}

fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed("remove", path)(error)),
        _ => Ok(()),
    }
}
