//! The packages of the peers in Python, and programs of the system.

use crate::python::{Environment, Group};
use crate::workspace::Workspace;
use std::path::{Path, PathBuf};

/// The group that every peer in Python needs.
pub(super) const BASE: &str = "scikit-fem";
/// The group of PARDISO.
pub(super) const PARDISO: &str = "pypardiso";
/// The group of CHOLMOD.
pub(super) const CHOLMOD: &str = "scikit-sparse";

const GROUPS: [Group; 3] = [
    Group {
        name: BASE,
        tools: &[],
        packages: &[["numpy", "2.4.6"], ["scipy", "1.17.1"], ["scikit-fem", "12.0.2"]],
        hint: "it needs Python 3.11 or newer and the package index",
    },
    Group {
        name: PARDISO,
        tools: &[],
        packages: &[["pypardiso", "0.4.7"]],
        hint: "MKL is there for Intel and AMD processors only",
    },
    Group {
        name: CHOLMOD,
        tools: &["wheel", "setuptools<81", "cython"],
        packages: &[["scikit-sparse", "0.4.15"]],
        hint: "`apt install libsuitesparse-dev` and a C compiler may be missing",
    },
];

/// Makes the environment of the peers, or completes the one of an earlier run.
pub(super) fn make(workspace: &Workspace) -> Environment {
    Environment::make(workspace.target.join("peers-venv"), &GROUPS)
}

/// MKL as a shared library, which also holds a BLAS.
pub(super) fn mkl(environment: &Environment) -> Option<PathBuf> {
    let entries = std::fs::read_dir(environment.folder.join("lib")).ok()?;
    let is_mkl = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libmkl_rt.so"));
    entries.filter_map(Result::ok).map(|e| e.path()).find(is_mkl)
}

/// A program in the folders where the system looks for programs.
pub(super) fn program(name: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| Path::is_file(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let folder = PathBuf::from("nowhere");
        let environment = Environment { folder, missing: vec![(CHOLMOD, "no compiler".into())] };
        assert!(environment.has(BASE) && environment.has(PARDISO) && !environment.has(CHOLMOD));
        assert_eq!(mkl(&environment), None);
        assert_eq!(program("a program of this name is not installed"), None);
    }
}
