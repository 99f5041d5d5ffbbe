//! Studies whose pages are in bench-results; run by `cargo xtask reproduce`.
//!
//! `reproduce STUDY FOLDER [--quick] [--only N]` prints the page of a study and writes its tables and figures to a folder; `--only N` repeats
//! one problem of the study adversarial.
#![allow(clippy::print_stdout)] // It writes pages.

mod adaptivity;
mod adversarial;
mod effectivity;
mod exact;
mod figure;
mod friction;
mod iterations;
mod page;
mod relaxation;
mod sharpness;

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let quick = arguments.iter().any(|a| a == "--quick");
    let only = arguments.iter().skip_while(|a| *a != "--only").nth(1).map(|n| n.parse()).transpose()?;
    let [study, folder, ..] = arguments.as_slice() else {
        return Err(
            "expected: reproduce iterations|effectivity|adaptivity|adversarial|friction FOLDER [--quick] [--only N]"
                .into(),
        );
    };
    let folder = PathBuf::from(folder);
    match study.as_str() {
        "iterations" => iterations::table(quick),
        "effectivity" => effectivity::page(&folder, quick),
        "adaptivity" => adaptivity::page(&folder, quick),
        "adversarial" => match only {
            Some(number) => adversarial::one(number, &folder),
            None => adversarial::page(&folder, quick),
        },
        "friction" => friction::page(&folder, quick),
        other => Err(format!(
            "no study is named {other:?}: iterations, effectivity, adaptivity, adversarial or friction"
        )
        .into()),
    }
}
