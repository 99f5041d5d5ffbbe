//! `cargo xtask docs`: the documentation of every crate, its formulae typeset.

use crate::workspace::{Outcome, Workspace, stream};

/// Header of every page; docs.rs finds it through each crate's manifest.
const HEADER: &str = "crates/fem-core/katex.html";

/// Builds the documentation with warnings denied; returns whether there were none.
pub(crate) fn run(workspace: &Workspace) -> Outcome<bool> {
    // rustdoc links to another crate only where the folder of its pages is there when it begins; crates are documented at
    // the same time.
    let pages = workspace.target.join("doc");
    for package in workspace.packages.iter().filter(|p| p.is_crate()) {
        let folder = pages.join(package.name.replace('-', "_"));
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", workspace.shown(&folder)))?;
    }
    let header = workspace.root.join(HEADER);
    let flags = ["-D", "warnings", "--html-in-header", &header.to_string_lossy()].join("\u{1f}");
    // In the profile of the other tasks, so that nothing is compiled once more.
    let mut command = workspace.cargo(&["doc", "--workspace", "--no-deps", "--release"]);
    let built = stream(command.env("CARGO_ENCODED_RUSTDOCFLAGS", flags))? == Some(0);
    if built {
        println!("start at {}", workspace.shown(&pages.join("certified_contact").join("index.html")));
    }
    Ok(built)
}
