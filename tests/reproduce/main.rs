//! Studies whose pages are in bench-results; run by `cargo xtask reproduce`.
//!
//! `reproduce STUDY FOLDER [--quick] [--solids] [--problems N] [--only N]` prints the page of a study and writes its tables and figures to a folder.
//! Of the study adversarial, `--problems N` judges this number of problems, `--solids` those of solid bodies alone, `--family NAME` those of one family of solids, and
//! `--only N` repeats one.
#![allow(clippy::print_stdout)] // It writes pages.

mod adaptivity;
mod adversarial;
mod counts;
mod effectivity;
mod exact;
mod fiat;
mod figure;
mod formulation;
mod friction;
mod iterations;
mod page;
mod relaxation;
mod sharpness;
mod solids;

use std::path::PathBuf;
use tests::random_solids::FAMILIES;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let quick = arguments.iter().any(|a| a == "--quick");
    let solids = arguments.iter().any(|a| a == "--solids");
    let number = |name: &str| arguments.iter().skip_while(|a| *a != name).nth(1).map(|n| n.parse::<u64>());
    let only = number("--only").transpose()?;
    let problems = number("--problems").transpose()?;
    let named = arguments.iter().skip_while(|a| *a != "--family").nth(1);
    let family = FAMILIES.into_iter().find(|family| named.is_some_and(|named| named == family));
    let [study, folder, ..] = arguments.as_slice() else {
        return Err(
            "expected: reproduce iterations|effectivity|adaptivity|adversarial|friction|solids|fiat FOLDER [--quick] [--solids] [--family NAME] [--problems N] [--only N]"
                .into(),
        );
    };
    let folder = PathBuf::from(folder);
    match study.as_str() {
        "iterations" => iterations::table(quick),
        "effectivity" => effectivity::page(&folder, quick),
        "adaptivity" => adaptivity::page(&folder, quick),
        "adversarial" => match (only, solids) {
            (Some(number), true) => solids::one(number, family),
            (Some(number), false) => adversarial::one(number, &folder),
            (None, true) => adversarial::solids(&folder, quick, problems, family),
            (None, false) => adversarial::page(&folder, quick, problems),
        },
        "friction" => friction::page(&folder, quick),
        "solids" => formulation::page(quick),
        "fiat" => fiat::cells(&folder, quick),
        other => Err(format!(
            "no study is named {other:?}: iterations, effectivity, adaptivity, adversarial, friction, solids or fiat"
        )
        .into()),
    }
}
