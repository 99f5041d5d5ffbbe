//! The figures that the formulation prints for solids, beside those of this program.

use crate::page::head;
use std::error::Error;
use std::fmt::Write as _;
use tests::formulation::{Compared, PRINTED, compared};

/// The largest `n` of a quick study.
const QUICK: usize = 6;

fn line(of: &Compared, text: &mut String) {
    let agrees = if of.agrees() { "" } else { "**differs**" };
    let (printed, shown, difference) = (of.printed, of.shown(), of.difference());
    let _ = writeln!(
        text,
        "| {} | {} | {} | {} | {printed} | {shown} | {difference:.1e} | {agrees} |",
        of.section, of.problem, of.n, of.name
    );
}

/// Makes the tables.
pub(crate) fn page(quick: bool) -> Result<(), Box<dyn Error>> {
    let mut all = Vec::new();
    for row in PRINTED.iter().filter(|row| !quick || row.2 <= QUICK) {
        all.extend(compared(row, None)?);
    }
    let differ: Vec<&Compared> = all.iter().filter(|of| !of.agrees()).collect();
    let agree = all.len() - differ.len();
    println!("Of {} figures {agree} agree and {} do not.\n", all.len(), differ.len());
    println!("## Figures that differ\n");
    println!("{}", head(&["section", "problem", "n", "figure", "difference, relative", "reason"]));
    for of in differ {
        println!(
            "| {} | {} | {} | {} | {:.1e} | {} |",
            of.section,
            of.problem,
            of.n,
            of.name,
            of.difference(),
            of.reason().map_or("not known", |(reason, _)| reason)
        );
    }
    let mut text =
        head(&["section", "problem", "n", "figure", "printed", "ours", "difference, relative", ""]) + "\n";
    all.iter().for_each(|of| line(of, &mut text));
    println!("\n## All figures\n\n{text}");
    Ok(())
}
