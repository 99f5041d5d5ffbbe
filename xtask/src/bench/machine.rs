//! The part of a page about the machine, the commit and the compiler.

use crate::workspace::{Outcome, Workspace, output, read};
use std::fmt::Write as _;
use std::process::Command;

/// The packages whose versions decide the numbers.
const NUMERIC: [&str; 4] = ["faer", "clarabel", "nalgebra", "rayon"];

/// The machine, without its name.
pub(super) struct Machine {
    pub(super) model: String,
    pub(super) cores: usize,
}

impl Machine {
    /// Looks at this machine.
    pub(super) fn look() -> Machine {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Machine { model: cpu_model(&info).unwrap_or("unknown processor").to_owned(), cores }
    }

    /// A short name for a folder, such as `xeon-2c`.
    pub(super) fn slug(&self) -> String {
        let plain = self.model.to_lowercase().replace("(r)", " ").replace("(tm)", " ");
        let dull = |w: &str| {
            ["intel", "amd", "cpu", "processor", "with", "graphics", "core", "unknown"].contains(&w)
                || w.ends_with("ghz")
                || w.ends_with("-core")
        };
        let words = plain.split(|c: char| !c.is_ascii_alphanumeric() && c != '-' && c != '.');
        let kept: Vec<String> =
            words.filter(|w| !w.is_empty() && !dull(w)).take(4).map(|w| w.replace('.', "-")).collect();
        let name = if kept.is_empty() { "cpu".to_owned() } else { kept.join("-") };
        format!("{name}-{}c", self.cores)
    }
}

/// The processor's name in the text of `/proc/cpuinfo`.
fn cpu_model(info: &str) -> Option<&str> {
    let line = info.lines().find(|l| l.starts_with("model name"))?;
    line.split_once(':').map(|(_, name)| name.trim()).filter(|name| !name.is_empty())
}

/// Versions of some packages in the text of `Cargo.lock`, in the order asked for.
fn locked_versions(lock: &str, names: &[&str]) -> Outcome<Vec<(String, String)>> {
    let lock: toml::Table = lock.parse().map_err(|e| format!("Cargo.lock: {e}"))?;
    let packages = lock.get("package").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let text = |p: &toml::Value, key: &str| p.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let versions_of = |name: &str| -> String {
        let found: Vec<String> = packages
            .iter()
            .filter(|p| text(p, "name").as_deref() == Some(name))
            .filter_map(|p| text(p, "version"))
            .collect();
        if found.is_empty() { "none".to_owned() } else { found.join(" and ") }
    };
    Ok(names.iter().map(|n| ((*n).to_owned(), versions_of(n))).collect())
}

/// The table a page begins with: how it was made, from what, and where.
///
/// * `command`: what was run.
/// * `more`: further rows.
pub(super) fn provenance(
    workspace: &Workspace,
    machine: &Machine,
    command: &str,
    more: &[(&str, String)],
) -> Outcome<String> {
    let commit =
        output(&mut workspace.git(&["rev-parse", "HEAD"])).map_or("none".to_owned(), |h| h.trim().to_owned());
    let tree = match output(&mut workspace.git(&["status", "--porcelain"])) {
        Ok(changes) if changes.trim().is_empty() => "clean",
        Ok(_) => "with uncommitted changes",
        Err(_) => "unknown",
    };
    let rustc = output(Command::new("rustc").arg("--version"))?;
    let cargo = output(&mut workspace.cargo(&["--version"]))?;
    let versions = locked_versions(&read(&workspace.root.join("Cargo.lock"))?, &NUMERIC)?;
    let versions: Vec<String> = versions.into_iter().map(|(n, v)| format!("{n} {v}")).collect();
    let rows = [
        ("command", format!("`{command}`")),
        ("commit", format!("{commit}, tree {tree}")),
        ("compiler", format!("{}, {}", rustc.trim(), cargo.trim())),
        ("packages", versions.join(", ")),
        ("processor", format!("{}, {} cores available", machine.model, machine.cores)),
    ];
    let mut text = String::from("| what | value |\n|---|---|\n");
    for (what, value) in rows.iter().chain(more) {
        let _ = writeln!(text, "| {what} | {value} |");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machines_have_short_names() {
        let slug = |model: &str, cores| Machine { model: model.into(), cores }.slug();
        assert_eq!(slug("Intel(R) Xeon(R) Processor", 2), "xeon-2c");
        assert_eq!(slug("Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz", 8), "xeon-platinum-8375c-8c");
        assert_eq!(slug("AMD EPYC 7B13", 4), "epyc-7b13-4c");
        assert_eq!(slug("unknown processor", 1), "cpu-1c");
        assert_eq!(cpu_model("processor : 0\nmodel name\t: A B\n"), Some("A B"));
        assert_eq!(cpu_model("processor : 0\n"), None);
    }

    #[test]
    fn versions_are_read_from_the_lock_file() {
        let lock = "[[package]]\nname = \"nalgebra\"\nversion = \"0.35.0\"\n[[package]]\nname = \"rayon\"\nversion = \"1.12.0\"\n";
        let found = locked_versions(lock, &["nalgebra", "clarabel"]).unwrap();
        assert_eq!(found, [("nalgebra".into(), "0.35.0".into()), ("clarabel".into(), "none".into())]);
    }
}
