//! Iterations to reduce η_NNDD by 1e-10, over the family of stacked blocks.

use certified_contact::{Criterion, Imposed, Settings, Silent, solve};
use nndd::{NnddSettings, NnddStatus};
use std::error::Error;
use tests::blocks::Blocks;

/// Counts the iterations, or says how the run ended.
fn count(blocks: &Blocks, imposed: Imposed, swap: bool) -> Result<String, Box<dyn Error>> {
    let mut settings = Settings::default();
    settings.imposed = imposed;
    settings.criterion = Criterion::EtaNndd { tolerance: 1e-10 };
    let mut nndd = NnddSettings::default();
    nndd.max_iterations = 100;
    settings.method = nndd.into();
    let problem = blocks.problem()?;
    let problem = if swap { tests::run::exchanged(problem) } else { problem };
    let solution = solve(problem, &settings, &mut Silent)?;
    let iterations = solution.rows.len();
    Ok(match solution.nndd.status {
        NnddStatus::StoppedByCriterion => iterations.to_string(),
        NnddStatus::MaxIterations => "> 100".into(),
        NnddStatus::Diverged { .. } => format!("div {iterations}"),
        NnddStatus::Stalled { at_round_off: true, .. } => format!("floor {iterations}"),
        NnddStatus::Stalled { .. } => format!("stall {iterations}"),
        other => format!("{other:?}"),
    })
}

pub(crate) fn table(quick: bool) -> Result<(), Box<dyn Error>> {
    println!("| case | cells | E1/E2 | auto | auto, other file order | first | second |");
    println!("|---|---|---|---|---|---|---|");
    let thin = |height: [f64; 2]| move |c: f64| Blocks { height, ..Blocks::contrast(c) };
    let nearly = |c: f64| Blocks { poisson: [0.49, 0.49], ..Blocks::contrast(c) };
    let mixed = |c: f64| Blocks { poisson: [0.0, 0.49], ..Blocks::contrast(c) };
    let (flat, tall) = (thin([0.25, 1.0]), thin([1.0, 0.25]));
    let families: [(&str, &dyn Fn(f64) -> Blocks); 6] = [
        ("paper", &Blocks::contrast),
        ("half open", &Blocks::half_open),
        ("heights 0.25:1", &flat),
        ("heights 1:0.25", &tall),
        ("nu 0.49, 0.49", &nearly),
        ("nu 0, 0.49", &mixed),
    ];
    let meshes: &[usize] = if quick { &[20, 80] } else { &[20, 80, 160] };
    for (name, family) in families {
        for &cells in meshes {
            for c in [1e-3, 1e-2, 0.05, 0.5, 1.0, 2.0, 20.0, 100.0, 1e3] {
                let blocks = family(c).cells(cells);
                println!(
                    "| {name} | {cells} | {c} | {} | {} | {} | {} |",
                    count(&blocks, Imposed::Auto, false)?,
                    count(&blocks, Imposed::Auto, true)?,
                    count(&blocks, Imposed::First, false)?,
                    count(&blocks, Imposed::Second, false)?
                );
            }
        }
    }
    Ok(())
}
